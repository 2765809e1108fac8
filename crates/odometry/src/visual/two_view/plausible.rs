//! Which matches can be of the scene at all? Those before both cameras, at depths that others have too.
//!
//! An essential matrix asks only that a match be *on* its epipolar line. A wrong match is as likely to be somewhere along it as
//! anywhere else, and then only its depth tells. Of wrong matches that go anywhere within 100 px, one in twenty is within 2.5 px of its
//! line; few of these have a parallax like that of the scene when it is small, as between neighbouring frames.

use super::RayPair;
use super::essential::{Twisted, is_ahead, residual};
use super::matches::{Match, Matches};
use super::transfer::transfer_squared;

/// For each match whether it can be of the scene, whatever its residual.
pub(super) struct Plausible(pub Vec<bool>);

impl Plausible {
    /// Parallax over so many times what three in four have at most is nobody's.
    const MOST: f64 = 3.0;

    pub fn of(pose: &Twisted, pairs: &[RayPair], matches: &Matches, limit: f64) -> Self {
        let essential = pose.essential();
        let parallax: Vec<f64> = matches.list.iter().map(|m| transfer_squared(&pose.rotation, m).sqrt()).collect();
        let ahead: Vec<bool> = matches.list.iter().map(|m| is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair])).collect();
        let agree = |i: &usize| ahead[*i] && residual(&essential, &matches.list[*i]).abs() < limit;
        let mut usual: Vec<f64> = (0..parallax.len()).filter(agree).map(|i| parallax[i]).collect();
        usual.sort_by(f64::total_cmp);
        let most = usual.get(usual.len() * 3 / 4).map_or(f64::INFINITY, |p| Self::MOST * p.max(limit));
        Self(parallax.into_iter().zip(ahead).map(|(p, ahead)| ahead && p < most).collect())
    }

    /// Those that can.
    pub fn list<'a>(&'a self, matches: &'a Matches) -> impl Iterator<Item = &'a Match> {
        matches.list.iter().zip(&self.0).filter(|(_, plausible)| **plausible).map(|(m, _)| m)
    }
}
