//! `planwalk bench`: how good is a localiser over many walks, and did it get better?

use std::path::Path;
use std::sync::Mutex;

use planwalk::Method;
use planwalk::bench::table::Table;
use planwalk::bench::{self, Record, Target, Verdict};
use planwalk::figure::{BenchPicture, png_of};
use planwalk::types::Status;
use serde::Serialize;

use crate::args::BenchArgs;
use crate::bench::run::{ODOMETRY, Plan};
use crate::bench::suite::{Job, Suite};
use crate::failure::{self, Failure};
use crate::output::Output;
use crate::say::{self, Voice};

/// Every run, one a line.
const RESULTS: &str = "results.jsonl";

/// Runs a suite, or the rest of it, and says what came of it.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.common.quiet };
    let suite = Suite::open(&args.suite)?;
    let jobs = chosen(&suite, args)?;
    if args.list {
        jobs.iter().for_each(|job| say::stdout_text(&format!("{} (seed {})\n", job.name, job.seed)));
        return Ok(());
    }
    let before = args.compare.as_deref().map(read).transpose()?;
    let output = Output::open(&args.common.output, args.common.force || args.resume)?;
    let results = output.path(RESULTS);
    let known = if args.resume && results.is_file() { keep_whole_lines(&results)? } else { start_anew(&results)? };
    let threads = args.common.threads.map_or_else(cores, usize::from);
    let mut plan = Plan { suite: &suite, jobs, methods: methods(&suite, args), data: &args.data, threads };
    plan.without(&known);
    voice.say(&format!("{}: {}; {} walks to do, on {threads} threads", suite.name, suite.about, plan.jobs.len()));
    let bar = voice.bar("walks", Some(plan.jobs.len() as u64));
    let failed = Mutex::new(Vec::new());
    plan.run(&results, &|records| {
        bar.inc(1);
        if let (Ok(mut failed), Some(why)) = (failed.lock(), records.iter().find_map(|r| r.error.as_ref())) {
            failed.push(format!("{} (seed {}): {why}", records[0].case, records[0].seed));
        }
    })?;
    bar.finish_and_clear();
    let records = in_order(&suite, read(&results)?);
    for why in failed.into_inner().unwrap_or_default() {
        voice.say(&format!("note: no scores for {why}"));
    }
    finish(args, &suite, &output, voice, &records, before.as_deref())
}

/// Tables and pictures.
fn finish(
    args: &BenchArgs,
    suite: &Suite,
    output: &Output,
    voice: Voice,
    records: &[Record],
    before: Option<&[Record]>,
) -> Result<(), Failure> {
    let named: Vec<_> = suite.columns.iter().filter_map(|head| bench::metric::named(head)).collect();
    let table = if named.is_empty() { bench::table::summary(records) } else { bench::table::summary_of(records, &named) };
    let verdicts = verdicts(suite, records);
    let mut page = format!("# Bench {}\n\n{}.\n\n{}", suite.name, suite.about, table.markdown());
    page.push_str(
        "\nIn brackets: 95 % intervals over walks and seeds (bootstrap; Wilson for shares). Median over walks where no % is said.\n",
    );
    if let Some(megabytes) = peak_memory_mb() {
        page.push_str(&format!("Most memory of the whole bench at any time: {megabytes:.0} MB.\n"));
    }
    if !verdicts.is_empty() {
        page.push_str(&format!("\n## Targets\n\n{}", bench::target::table(&verdicts).markdown()));
    }
    page.push_str(&confidently_wrong(records, &args.suite));
    if let Some(before) = before {
        let changes = bench::compare(before, records);
        let compared = bench::compare::table(&changes);
        page.push_str(&format!("\n## Changes\n\n{}", compared.markdown()));
        page.push_str(&flips(before, records, &args.suite));
    }
    output.write("table.md", &page)?;
    let title = format!("planwalk bench {}: {}", suite.name, suite.about);
    let svg = BenchPicture { title: &title, records }.svg();
    let png = png_of(&svg).map_err(|why| Failure::output(why, &output.path("bench.png")))?;
    output.write("bench.svg", svg)?;
    output.write("bench.png", png)?;
    if args.common.json {
        say::stdout_text(&summary_json(suite, records, &table, &verdicts));
    } else if !args.common.quiet {
        say::stdout_text(&page);
    }
    voice.say(&format!("results: {}", output.path(RESULTS).display()));
    if records.iter().all(|r| r.error.is_some()) {
        let why = records.iter().find_map(|r| r.error.clone()).unwrap_or_default();
        return Err(Failure {
            message: format!("no walk could be scored: {why}; is --data the folder that the suite means?"),
            code: failure::INPUT,
        });
    }
    Ok(())
}

/// What runs one walk again.
fn again(record: &Record, suite: &str) -> String {
    let Record { case, seed, method, .. } = record;
    format!("{case}, seed {seed}, {method} (`planwalk bench {suite} --only \"{case}\" --seed {seed} --method {method} -o DIR`)\n")
}

/// Walks whose answer was wrong and claimed to be tracking: the worst that a localiser can do.
fn confidently_wrong(records: &[Record], suite: &str) -> String {
    let wrong = |r: &&Record| r.status == Some(Status::Tracking) && r.place.as_ref().is_some_and(|p| !p.track.end_right);
    let line = |r: &Record| format!("* {:.1} m off: {}", r.place.as_ref().map_or(0.0, |p| p.track.end_m), again(r, suite));
    let lines: String = records.iter().filter(wrong).map(line).collect();
    if lines.is_empty() { lines } else { format!("\n## Wrong at the end, and yet tracking\n\n{lines}") }
}

/// Walks that were right and are not, or the other way round, each with what repeats it.
fn flips(before: &[Record], after: &[Record], suite: &str) -> String {
    let line = |(record, now_right): &(&Record, bool)| {
        let way = if *now_right { "wrong → right" } else { "right → wrong" };
        format!("* {way}: {}", again(record, suite))
    };
    let lines: String = bench::compare::flips(before, after).iter().map(line).collect();
    if lines.is_empty() { lines } else { format!("\n## Flips\n\n{lines}") }
}

#[derive(Serialize)]
struct Summary<'a> {
    suite: &'a str,
    records: usize,
    failed: usize,
    head: &'a [String],
    rows: &'a [Vec<String>],
    targets: Vec<TargetEntry<'a>>,
}

#[derive(Serialize)]
struct TargetEntry<'a> {
    #[serde(flatten)]
    target: &'a Target,
    walks: usize,
    failed: usize,
    got: &'a str,
    met: bool,
}

/// The suite's targets, held against the first of its methods; where no localiser answers, against the odometry.
fn verdicts(suite: &Suite, records: &[Record]) -> Vec<Verdict> {
    let method = suite.methods.first().copied().unwrap_or_default().to_string();
    let judge = |target: &Target| match target.judge(records, &method) {
        Verdict { walks: 0, .. } => target.judge(records, ODOMETRY),
        localised => localised,
    };
    suite.targets.iter().map(judge).collect()
}

/// Most memory that this process ever held, where the system says so.
fn peak_memory_mb() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?;
    kilobytes.trim().parse::<f64>().ok().map(|kb| kb / 1024.0)
}

fn summary_json<'a>(suite: &'a Suite, records: &[Record], table: &'a Table, verdicts: &'a [Verdict]) -> String {
    let failed = records.iter().filter(|r| r.error.is_some()).count();
    let entry = |v: &'a Verdict| TargetEntry { target: &v.target, walks: v.walks, failed: v.failed, got: &v.text, met: v.met };
    let targets = verdicts.iter().map(entry);
    let summary =
        Summary { suite: &suite.name, records: records.len(), failed, head: &table.head, rows: &table.rows, targets: targets.collect() };
    // Text and numbers always become JSON.
    serde_json::to_string_pretty(&summary).unwrap_or_default() + "\n"
}

fn chosen<'a>(suite: &'a Suite, args: &BenchArgs) -> Result<Vec<Job<'a>>, Failure> {
    let mut jobs = suite.jobs(args.common.seed.map(|seed| seed.saturating_add(1)).or(args.seeds));
    jobs.retain(|job| args.common.seed.is_none_or(|seed| job.seed == seed));
    if let Some(text) = &args.only {
        jobs.retain(|job| job.name.contains(text.as_str()));
        if jobs.is_empty() {
            return Err(Failure::usage(format!("no walk of the suite {} has \"{text}\" in its name; --list names them", suite.name)));
        }
    }
    if let Some(shard) = args.shard {
        let mut index = 0;
        jobs.retain(|_| {
            index += 1;
            index % shard.of == shard.part % shard.of
        });
    }
    Ok(jobs)
}

fn methods(suite: &Suite, args: &BenchArgs) -> Vec<Method> {
    let mut methods: Vec<Method> = args.methods.iter().map(|name| Method::from(*name)).collect();
    if methods.is_empty() {
        methods.clone_from(&suite.methods);
    }
    if methods.is_empty() {
        methods = vec![Method::Planwalk, Method::Report];
    }
    methods.sort();
    methods.dedup();
    methods
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn read(path: &Path) -> Result<Vec<Record>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|why| Failure::input("the bench's results", why, path))?;
    bench::record::parse(&text).map_err(|why| Failure::input("the bench's results", why, path))
}

/// The records of an interrupted bench; a line that it did not finish is cut off, so that the next one does not join it.
fn keep_whole_lines(path: &Path) -> Result<Vec<Record>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|why| Failure::input("the bench's results", why, path))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    std::fs::write(path, whole).map_err(|why| Failure::output(why, path))?;
    bench::record::parse(whole).map_err(|why| Failure::input("the bench's results", why, path))
}

fn start_anew(path: &Path) -> Result<Vec<Record>, Failure> {
    std::fs::write(path, "").map_err(|why| Failure::output(why, path))?;
    Ok(Vec::new())
}

/// The newest record of each run, in the suite's order: workers end in any order, and what failed may have been tried again.
fn in_order(suite: &Suite, records: Vec<Record>) -> Vec<Record> {
    let mut newest: Vec<Record> = Vec::new();
    for record in records {
        match newest.iter_mut().find(|known| known.key() == record.key()) {
            Some(known) => *known = record,
            None => newest.push(record),
        }
    }
    let place = |record: &Record| {
        suite.cases.iter().position(|case| record.case == case.name || record.case.starts_with(&format!("{}/", case.name)))
    };
    newest.sort_by_cached_key(|record| (place(record), record.case.clone(), record.seed, record.method.clone()));
    newest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_of_walks_without_a_plan_are_held_against_the_odometry() {
        let suite = Suite::open("odometry").unwrap();
        let record = |group: &str, method: &str| {
            format!(
                r#"{{"schema":"planwalk-bench/1","suite":"odometry","group":"{group}","case":"{group}","method":"{method}","seed":0,"version":"",
                "given":"","walk_s":1,"error":"gone"}}"#
            )
            .replace('\n', "")
        };
        let lines = format!("{}\n{}\n", record("icsl", "odometry"), record("rendered, steady", "foreign"));
        let verdicts = verdicts(&suite, &bench::record::parse(&lines).unwrap());
        let walks = |group: &str| verdicts.iter().find(|v| v.target.group == group).unwrap().walks;
        assert_eq!((walks("icsl"), walks("rendered, steady")), (1, 0), "what others made is not ours");
    }
}
