//! Who does the jobs, and what if somebody stops them? Workers with threads of their own; every record is on disk when it is made.
//!
//! Each worker has a thread pool of its own: on a shared one, a job that waits for its own pieces would begin another job
//! meanwhile, and times would mean nothing.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use planwalk::bench::{Key, Record};
use planwalk::types::Seed;
use planwalk::{LocalizeOptions, Method, evaluate};

use super::suite::{Job, Suite};
use super::walk::{self, Prepared};
use crate::failure::Failure;

/// What to run.
pub struct Plan<'a> {
    /// The suite.
    pub suite: &'a Suite,
    /// The jobs of this shard.
    pub jobs: Vec<Job<'a>>,
    /// Localisers to run on each walk.
    pub methods: Vec<Method>,
    /// Where data lies.
    pub data: &'a Path,
    /// Threads for all.
    pub threads: usize,
}

impl Plan<'_> {
    /// Takes out what records of an earlier run already say; what failed then is tried again.
    pub fn without(&mut self, known: &[Record]) {
        let suite = self.suite;
        let done: BTreeMap<Key, &str> = known.iter().filter(|r| r.error.is_none()).map(|r| (r.key(), r.given.as_str())).collect();
        let methods = &self.methods;
        self.jobs.retain(|job| {
            let given = given(suite, job);
            !answers(job, methods).iter().all(|method| done.get(&key(job, method)).is_some_and(|then| *then == given))
        });
    }

    /// Runs all jobs; `on_done` is told of each one's records, in the order in which they end.
    pub fn run(&self, results: &Path, on_done: &(dyn Fn(&[Record]) + Sync)) -> Result<(), Failure> {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(results).map_err(|why| Failure::output(why, results))?;
        let file = Mutex::new(file);
        let workers = if self.suite.parallel { self.threads.min(self.jobs.len()).max(1) } else { 1 };
        let next = AtomicUsize::new(0);
        let refused = Mutex::new(None);
        std::thread::scope(|scope| {
            for worker in 0..workers {
                let share = self.threads / workers + usize::from(worker < self.threads % workers);
                let (next, file, refused) = (&next, &file, &refused);
                scope.spawn(move || {
                    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(share.max(1)).build() else { return };
                    while let Some(job) = self.jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let records = pool.install(|| self.records(job));
                        let lines: String = records.iter().map(|r| r.to_line() + "\n").collect();
                        if let Ok(mut file) = file.lock()
                            && let Err(why) = file.write_all(lines.as_bytes()).and_then(|()| file.flush())
                        {
                            if let Ok(mut refused) = refused.lock() {
                                *refused = Some(Failure::output(why, results));
                            }
                            return;
                        }
                        on_done(&records);
                    }
                });
            }
        });
        refused.into_inner().ok().flatten().map_or(Ok(()), Err)
    }

    /// One walk, by every method.
    fn records(&self, job: &Job<'_>) -> Vec<Record> {
        let prepared = walk::prepare(job, self.data);
        let answers = answers(job, &self.methods);
        answers.iter().map(|answer| self.record(job, answer, prepared.as_ref().map_err(String::clone))).collect()
    }

    fn record(&self, job: &Job<'_>, answer: &Answer, prepared: Result<&Prepared, String>) -> Record {
        let mut record = Record {
            schema: planwalk::bench::record::SCHEMA.to_owned(),
            suite: self.suite.name.clone(),
            group: job.case.group().to_owned(),
            case: job.name.clone(),
            method: answer.name(),
            seed: job.seed,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            given: given(self.suite, job),
            walk_s: 0.0,
            odometry_s: None,
            locate_s: None,
            status: None,
            wall_crossings: None,
            place: None,
            odometry: None,
            error: None,
        };
        match prepared {
            Ok(prepared) => {
                record.walk_s = prepared.duration_s();
                record.odometry_s = prepared.odometry_s;
                record.odometry.clone_from(&prepared.odometry);
                record.error = score(answer, prepared, &mut record).err();
            }
            Err(why) => record.error = Some(why),
        }
        record
    }
}

/// Who answers where there is no plan, or where it is not asked: nobody but the odometry.
pub const ODOMETRY: &str = "odometry";

/// Who answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Answer {
    /// A localiser of ours.
    Localiser(Method),
    /// Nobody: there is no plan, only the odometry is scored.
    Odometry,
    /// A trajectory from elsewhere.
    Foreign,
}

impl Answer {
    fn name(self) -> String {
        match self {
            Self::Localiser(method) => method.to_string(),
            Self::Odometry => ODOMETRY.to_owned(),
            Self::Foreign => "foreign".to_owned(),
        }
    }
}

fn answers(job: &Job<'_>, methods: &[Method]) -> Vec<Answer> {
    let case = job.case;
    if case.track.is_some() {
        vec![Answer::Foreign]
    } else if case.tracking_only || case.plan.is_none() && case.simulate.is_none() {
        vec![Answer::Odometry]
    } else {
        methods.iter().map(|method| Answer::Localiser(*method)).collect()
    }
}

fn key(job: &Job<'_>, answer: &Answer) -> Key {
    Key { case: job.name.clone(), seed: job.seed, method: answer.name() }
}

/// Hash of all that the suite says of a walk.
fn given(suite: &Suite, job: &Job<'_>) -> String {
    let said = format!("{} {:?} {} {}", suite.name, job.case, job.seed, env!("CARGO_PKG_VERSION"));
    let mut hash = planwalk_io::inputs::sha256_of_bytes(said.as_bytes());
    hash.truncate(16);
    hash
}

/// Localises where there is something to localise, and scores the answer.
fn score(answer: &Answer, prepared: &Prepared, record: &mut Record) -> Result<(), String> {
    match (answer, &prepared.plan) {
        (Answer::Localiser(method), Some(plan)) => {
            let options = LocalizeOptions { seed: Seed(record.seed), start: prepared.start, method: *method };
            let began = Instant::now();
            let run = planwalk::localize(&prepared.walk, plan, &options, &mut |_| {}).map_err(|why| why.to_string())?;
            record.locate_s = Some(began.elapsed().as_secs_f64());
            let found = &run.localization;
            record.status = Some(found.status);
            record.wall_crossings = Some(found.quality.wall_crossings);
            let curves =
                evaluate::curves(&found.track, &found.filter, &prepared.truth, &prepared.options).map_err(|why| why.to_string())?;
            let mut scores = evaluate::place::scores_of(&curves, &prepared.options).ok_or("the track has no moments")?;
            scores.scale = evaluate::scale::score(&curves, &prepared.units);
            let places: Vec<_> = found.hypotheses.iter().map(|h| (h.probability, h.pose)).collect();
            let end = found.track.last().map(|e| e.stamp);
            scores.hypotheses = end.and_then(|end| evaluate::place::hypotheses(&places, end, &prepared.truth, &prepared.options));
            record.place = Some(scores);
            Ok(())
        }
        (Answer::Localiser(_), None) => Err("there is no plan to localise on".to_owned()),
        (Answer::Odometry | Answer::Foreign, _) => {
            record.place.clone_from(&prepared.place);
            Ok(())
        }
    }
}
