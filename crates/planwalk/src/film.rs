//! Which moments of a filter's belief are worth a picture?
//!
//! a cloud an update ──keep those that differ from their neighbours──▶ a bounded film ──the same, stricter──▶ a filmstrip
//!
//! Most is decided at the first corners, so even spacing in time would show little of it. What counts as news is how much
//! smaller the cloud became, whether places merged or the verdict changed, and a little how much time passed.

use crate::figure::ParticleCloud;

/// Most clouds that are kept of a run: frames of the animation.
const FRAMES: usize = 48;
/// Most panels of the filmstrip.
const PANELS: usize = 8;

/// The clouds of one run, thinned as they come.
#[derive(Debug, Clone, Default)]
pub(crate) struct Film {
    clouds: Vec<ParticleCloud>,
}

impl Film {
    /// Adds the cloud after an update. The newest is always kept, because nobody knows which is the last.
    pub(crate) fn push(&mut self, cloud: ParticleCloud) {
        self.clouds.push(cloud);
        // One more than wanted: the newest must stay, whatever the news.
        if self.clouds.len() > FRAMES {
            drop_dullest(&mut self.clouds);
        }
    }

    pub(crate) fn into_clouds(self) -> Vec<ParticleCloud> {
        self.clouds
    }
}

/// The most telling of the clouds, at most eight, the first and the last among them.
pub fn filmstrip(clouds: &[ParticleCloud]) -> Vec<ParticleCloud> {
    let mut strip = clouds.to_vec();
    while strip.len() > PANELS {
        drop_dullest(&mut strip);
    }
    strip
}

/// Drops the cloud in between that is most like a neighbour of its.
fn drop_dullest(clouds: &mut Vec<ParticleCloud>) {
    let span_s = clouds.first().zip(clouds.last()).map_or(0.0, |(a, b)| b.stamp.secs_since(a.stamp)).max(1e-9);
    let news = |a: &ParticleCloud, b: &ParticleCloud| {
        // Whatever is smaller is one dot in a panel.
        let size = |c: &ParticleCloud| (c.area_m2.max(4.0)).ln();
        let modes = (a.modes as f64 + 1.0).ln() - (b.modes as f64 + 1.0).ln();
        (size(a) - size(b)).abs() + modes.abs() + f64::from(u8::from(a.status != b.status)) + 3.0 * b.stamp.secs_since(a.stamp) / span_s
    };
    let told = |i: usize| news(&clouds[i - 1], &clouds[i]).min(news(&clouds[i], &clouds[i + 1]));
    if let Some(dullest) = (1..clouds.len().saturating_sub(1)).min_by(|a, b| told(*a).total_cmp(&told(*b))) {
        clouds.remove(dullest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Stamp, Status};

    fn cloud(second: i64, area_m2: f64, modes: usize, status: Status) -> ParticleCloud {
        let stamp = Stamp(second * 1_000_000_000);
        ParticleCloud { stamp, count: 10, places: Vec::new(), area_m2, modes, status, metres_per_unit: 1.0, relative_sigma: 0.1 }
    }

    #[test]
    fn what_happens_is_kept_and_what_lasts_is_not() {
        // 300 updates: the cloud shrinks from 4 to 8 s, the verdict changes at 10 s, and then nothing happens.
        let mut film = Film::default();
        for i in 0..300 {
            let area = if i < 4 { 500.0 } else { (500.0 / 4f64.powi(i as i32 - 3)).max(0.5) };
            film.push(cloud(i, area, if i < 6 { 5 } else { 1 }, if i < 10 { Status::Ambiguous } else { Status::Tracking }));
        }
        let clouds = film.into_clouds();
        assert!(clouds.len() <= FRAMES);
        let strip: Vec<i64> = filmstrip(&clouds).iter().map(|c| c.stamp.0 / 1_000_000_000).collect();
        assert_eq!((strip[0], strip[strip.len() - 1], strip.len()), (0, 299, PANELS));
        let early = strip.iter().filter(|s| (3..=10).contains(*s)).count();
        assert!(early >= 4, "{strip:?}");
    }

    #[test]
    fn a_short_run_is_kept_whole() {
        let mut film = Film::default();
        film.push(cloud(0, 1.0, 1, Status::Lost));
        assert_eq!(filmstrip(&film.into_clouds()).len(), 1);
        assert!(filmstrip(&[]).is_empty());
    }
}
