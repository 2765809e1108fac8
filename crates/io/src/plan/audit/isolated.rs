//! Are there letters among the walls? Small things of one size in a row are; columns stand farther apart.

use planwalk_types::{Plan, Pt2};

use super::finding::Finding;
use super::ground::{Ground, Post};

/// Fewest letters of a word.
const FEWEST: usize = 3;
/// Letters of a word are at most this far from middle to middle, in sizes of the larger.
const APART: f64 = 2.0;
/// … and of like size: the smaller is at least this much of the larger (an "i" of an "m").
const ALIKE: f64 = 0.4;
/// Most posts that are compared with all others.
const MOST: usize = 20_000;

/// Words among the posts.
pub(super) fn specks(ground: &Ground) -> Vec<Finding> {
    let mut posts: Vec<Post> = ground.posts.clone();
    if posts.len() > MOST {
        return Vec::new();
    }
    posts.sort_by(|a, b| a.at.x.total_cmp(&b.at.x));
    let mut words: Vec<usize> = (0..posts.len()).collect();
    let reach_m = APART * posts.iter().map(|p| p.size_m).fold(0.0, f64::max);
    for (n, a) in posts.iter().enumerate() {
        for (m, b) in posts.iter().enumerate().skip(n + 1).take_while(|(_, b)| b.at.x - a.at.x <= reach_m) {
            let (small, large) = (a.size_m.min(b.size_m), a.size_m.max(b.size_m));
            if a.at.distance(b.at) <= APART * large && small >= ALIKE * large {
                let (a, b) = (root(&words, n), root(&words, m));
                words[a.max(b)] = a.min(b);
            }
        }
    }
    let mut members: Vec<Vec<Post>> = vec![Vec::new(); posts.len()];
    for (n, post) in posts.iter().enumerate() {
        members[root(&words, n)].push(*post);
    }
    members.into_iter().filter(|word| word.len() >= FEWEST).map(finding).collect()
}

fn root(words: &[usize], of: usize) -> usize {
    let mut root = of;
    while words[root] != root {
        root = words[root];
    }
    root
}

fn finding(word: Vec<Post>) -> Finding {
    let count = word.len();
    let mut sizes: Vec<f64> = word.iter().map(|p| p.size_m).collect();
    sizes.sort_by(f64::total_cmp);
    let mean = |of: fn(&Post) -> f64| word.iter().map(of).sum::<f64>() / count as f64;
    let at: Pt2<Plan> = Pt2::new(mean(|p| p.at.x), mean(|p| p.at.y));
    Finding::Letters { at, count, size_m: sizes[count / 2] }
}
