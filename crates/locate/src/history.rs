//! Which guesses of the past do today's guesses descend from?
//!
//! Every update leaves a generation of particles; each knows its parent. Guesses of long ago without descendants are dropped,
//! so that memory grows with the walk by a few hundred nodes a generation (Jacob, Murray & Rubenthaler 2015), not by the cloud.

use crate::likelihood::Ray;
use crate::motion::Motion;
use crate::particles::{Particles, Roughening};

/// The parent of a particle that was put in anew.
pub(crate) const NO_PARENT: u32 = u32::MAX;
/// Generations that are kept whole: backward sampling wants more than the ancestors of the survivors.
const LAG: usize = 40;
/// Clouds above this size are not kept whole.
const WHOLE: usize = 50_000;

/// The cloud after one update, before resampling.
#[derive(Debug, Clone)]
pub(crate) struct Generation {
    /// From the generation before to this one.
    pub motion: Motion,
    /// Noise that was added after the generation before, if it was resampled; if not, each particle's parent has its own index.
    pub roughening: Option<Roughening>,
    /// What was seen, in this generation's body frame.
    pub rays: Vec<Ray>,
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub heading: Vec<f32>,
    pub log_scale: Vec<f32>,
    pub drift: Vec<i8>,
    pub weight: Vec<f32>,
    pub parent: Vec<u32>,
}

impl Generation {
    pub(crate) fn len(&self) -> usize {
        self.x.len()
    }
}

/// All generations, oldest first.
#[derive(Debug, Clone, Default)]
pub(crate) struct History {
    pub generations: Vec<Generation>,
}

impl History {
    /// Adds the cloud; `parents` are indices into the generation before.
    pub(crate) fn push(&mut self, cloud: &Particles, parents: Vec<u32>, motion: Motion, roughening: Option<Roughening>, rays: Vec<Ray>) {
        self.generations.push(Generation {
            motion,
            roughening,
            rays,
            x: cloud.x.clone(),
            y: cloud.y.clone(),
            heading: cloud.heading.clone(),
            log_scale: cloud.log_scale.clone(),
            drift: cloud.drift.clone(),
            weight: cloud.weight.clone(),
            parent: parents,
        });
        self.prune();
    }

    /// Drops the oldest generations, but never the newest.
    pub(crate) fn forget(&mut self, count: usize) {
        self.generations.drain(..count.min(self.generations.len().saturating_sub(1)));
        if let Some(oldest) = self.generations.first_mut() {
            oldest.parent.fill(NO_PARENT);
        }
    }

    /// Drops nodes without descendants in the oldest generation that is kept whole. Ends where nothing can be dropped: without
    /// resampling everybody has a descendant, and before a generation that lost nobody, nobody was lost.
    fn prune(&mut self) {
        let newest = self.generations.len().saturating_sub(1);
        let whole = self.generations.iter().rev().take(LAG).take_while(|g| g.len() <= WHOLE).count();
        let mut child = newest.saturating_sub(whole.saturating_sub(1));
        while child > 0 && self.generations[child].roughening.is_some() {
            let (before, after) = self.generations.split_at_mut(child);
            let (Some(parents), Some(children)) = (before.last_mut(), after.first_mut()) else { return };
            let mut alive = vec![false; parents.len()];
            for parent in children.parent.iter().filter(|p| **p != NO_PARENT) {
                alive[*parent as usize] = true;
            }
            if alive.iter().all(|a| *a) {
                return;
            }
            let mut renamed = vec![NO_PARENT; parents.len()];
            let mut next = 0;
            for (name, alive) in renamed.iter_mut().zip(&alive) {
                if *alive {
                    *name = next;
                    next += 1;
                }
            }
            for parent in children.parent.iter_mut().filter(|p| **p != NO_PARENT) {
                *parent = renamed[*parent as usize];
            }
            for values in [&mut parents.x, &mut parents.y, &mut parents.heading, &mut parents.log_scale, &mut parents.weight] {
                keep(values, &alive);
            }
            keep(&mut parents.drift, &alive);
            let mut alive = alive.iter();
            parents.parent.retain(|_| alive.next().copied().unwrap_or(false));
            child -= 1;
        }
    }
}

fn keep<T>(values: &mut Vec<T>, alive: &[bool]) {
    let mut alive = alive.iter();
    values.retain(|_| alive.next().copied().unwrap_or(false));
    values.shrink_to_fit();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(count: usize, x: f32) -> Particles {
        let mut cloud = Particles::default();
        for i in 0..count {
            cloud.push(x + i as f32, 0.0, 0.0, 0.0);
        }
        cloud.set_equal_weights();
        cloud
    }

    #[test]
    fn lines_of_descent_survive_pruning_and_dead_ends_do_not() {
        let mut history = History::default();
        let resampled = Some(Roughening { metres: 0.0, heading_rad: 0.0, log_scale: 0.0 });
        history.push(&cloud(100, 0.0), vec![NO_PARENT; 100], Motion::none(), None, Vec::new());
        // Every generation descends from the even half of the one before; the newest particle 10 always from 10's line.
        for g in 1..200 {
            let parents = (0..100).map(|i| i / 2 * 2).collect();
            history.push(&cloud(100, 1000.0 * g as f32), parents, Motion::none(), resampled, Vec::new());
        }
        let mut node = 10u32;
        for g in (1..200).rev() {
            let generation = &history.generations[g];
            assert_eq!(generation.x[node as usize], 1000.0 * g as f32 + 10.0, "generation {g}");
            node = generation.parent[node as usize];
        }
        assert_eq!(history.generations[0].x[node as usize], 10.0);
        assert!(history.generations[..150].iter().all(|g| g.len() == 50), "odd ones have no descendants");
        assert_eq!(history.generations[199].len(), 100);
    }

    #[test]
    fn large_clouds_keep_only_ancestors() {
        let mut history = History::default();
        history.push(&cloud(60_000, 0.0), vec![NO_PARENT; 60_000], Motion::none(), None, Vec::new());
        let resampled = Some(Roughening { metres: 0.0, heading_rad: 0.0, log_scale: 0.0 });
        history.push(&cloud(60_000, 0.0), vec![7; 60_000], Motion::none(), resampled, Vec::new());
        assert_eq!(history.generations[0].len(), 1);
        assert_eq!(history.generations[0].x[0], 7.0);
    }
}
