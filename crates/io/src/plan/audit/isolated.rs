//! Are there letters among the walls? Small things of one size in a row are; columns stand farther apart.

use planwalk_types::{Groups, Plan, Pt2};

use super::finding::Finding;
use super::ground::{Ground, Post};

/// Fewest letters of a word.
const FEWEST: usize = 3;
/// Letters of a word are at most this far from middle to middle, in sizes of the larger.
const APART: f64 = 2.0;
/// … and of like size: the smaller is at least this much of the larger (an "i" of an "m").
const ALIKE: f64 = 0.4;
/// … and none is farther from the line through the word than this, in sizes of the larger.
const ASIDE: f64 = 0.6;
/// Letters are at least so large, metres: smaller ones cannot be told from posts that a robot saw.
const SMALLEST_M: f64 = 0.12;
/// Most posts that are compared with all others.
const MOST: usize = 20_000;

/// Words among the posts.
pub(super) fn specks(ground: &Ground) -> Vec<Finding> {
    let mut posts: Vec<Post> = ground.posts.iter().copied().filter(|post| post.size_m >= SMALLEST_M).collect();
    if posts.len() > MOST {
        return Vec::new();
    }
    posts.sort_by(|a, b| a.at.x.total_cmp(&b.at.x));
    let mut words = Groups::new(posts.len());
    let reach_m = APART * posts.iter().map(|p| p.size_m).fold(0.0, f64::max);
    for (n, a) in posts.iter().enumerate() {
        for (m, b) in posts.iter().enumerate().skip(n + 1).take_while(|(_, b)| b.at.x - a.at.x <= reach_m) {
            let (small, large) = (a.size_m.min(b.size_m), a.size_m.max(b.size_m));
            if a.at.distance(b.at) <= APART * large && small >= ALIKE * large {
                words.join(n, m);
            }
        }
    }
    let mut members: Vec<Vec<Post>> = vec![Vec::new(); posts.len()];
    for (n, post) in posts.iter().enumerate() {
        members[words.first(n)].push(*post);
    }
    members.into_iter().filter(|word| word.len() >= FEWEST && is_row(word)).map(finding).collect()
}

/// Whether posts stand along a line.
fn is_row(word: &[Post]) -> bool {
    let Some(first) = word.first() else { return false };
    let farthest = |from: Pt2<Plan>| word.iter().map(|p| p.at).max_by(|a, b| a.distance(from).total_cmp(&b.distance(from))).unwrap_or(from);
    let end = farthest(first.at);
    let other = farthest(end);
    let length = end.distance(other).max(f64::MIN_POSITIVE);
    let largest = word.iter().map(|p| p.size_m).fold(0.0, f64::max);
    let aside = |at: Pt2<Plan>| ((other.x - end.x) * (at.y - end.y) - (other.y - end.y) * (at.x - end.x)).abs() / length;
    word.iter().all(|p| aside(p.at) <= ASIDE * largest)
}

fn finding(word: Vec<Post>) -> Finding {
    let count = word.len();
    let mut sizes: Vec<f64> = word.iter().map(|p| p.size_m).collect();
    sizes.sort_by(f64::total_cmp);
    let mean = |of: fn(&Post) -> f64| word.iter().map(of).sum::<f64>() / count as f64;
    let at: Pt2<Plan> = Pt2::new(mean(|p| p.at.x), mean(|p| p.at.y));
    Finding::Letters { at, count, size_m: sizes[count / 2] }
}
