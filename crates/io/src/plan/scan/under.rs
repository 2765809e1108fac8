//! How do lines go on under words? Outlines of shops on a mall's map, across which their names are written.
//!
//! line that ends at a word ─▶ straight on, as long as all is dark ─▶ kept as far as it meets another line that does so, or comes out
//!
//! Words hide a line only where their strokes are: between them it shows. So a line is never made up over paper or a pale fill.

use std::f64::consts::TAU;

/// Directions that lines go on in, over a turn: at the end of a word of 40 px one is off by less than a pixel.
const DIRECTIONS: usize = 144;
/// What ends at a word is a line if it was straight for this long before, pixels …
const LEAST_PX: usize = 4;
/// … and its direction is told from no more than this.
const MOST_PX: usize = 12;
/// … give or take this: a line of one pixel has steps.
const STEP_PX: usize = 3;
/// A line that is met a pixel aside is followed by this share of it: less loses flat lines, all of it runs into letters.
const SHIFT: f64 = 0.5;
/// Lines are told apart if they end at a word this far from each other, pixels: a line is half as thick.
const APART_PX: f64 = 4.0;
/// No word hides a line for longer, pixels.
const LONGEST_PX: usize = 200;
/// More ends of lines at words are dots of a printer's grey: the fullest of three real maps has 3,619.
const END_LIMIT: usize = 20_000;

/// A picture, in which lines end at words.
pub(super) struct Under<'a> {
    pub width: usize,
    /// Lines and walls, without words.
    pub is_line: &'a [bool],
    /// Words, with their edges.
    pub is_word: &'a [bool],
}

/// A line that goes on, from where it ends.
struct Ray {
    from: [f64; 2],
    /// Its places under the word, the nearest first.
    places: Vec<usize>,
    /// Whether it came out of the word at a line.
    is_through: bool,
}

impl Under<'_> {
    /// Places of lines under words. `is_dark`: darker than any ground, be it line or letter.
    pub fn lines(&self, is_dark: impl Fn(usize) -> bool) -> Vec<usize> {
        let ends = self.ends();
        if ends.len() > END_LIMIT {
            return Vec::new();
        }
        let ways: Vec<[f64; 2]> =
            (0..DIRECTIONS).map(|i| TAU * i as f64 / DIRECTIONS as f64).map(|a| [libm::cos(a), libm::sin(a)]).collect();
        let rays: Vec<Ray> = ends.into_iter().filter_map(|end| self.ray(end, &ways, &is_dark)).collect();
        let mut lines: Vec<usize> = self.met(&rays).zip(&rays).flat_map(|(count, ray)| &ray.places[..count]).copied().collect();
        lines.sort_unstable();
        lines.dedup();
        lines
    }

    /// Places of lines beside words.
    fn ends(&self) -> Vec<usize> {
        let is_word = |place: Option<usize>| place.is_some_and(|place| self.is_word.get(place) == Some(&true));
        let is_beside = |place: usize| {
            let sides = [place.checked_sub(1), Some(place + 1), place.checked_sub(self.width), Some(place + self.width)];
            sides.into_iter().any(is_word)
        };
        (0..self.is_line.len()).filter(|place| self.is_line[*place] && !self.is_word[*place] && is_beside(*place)).collect()
    }

    /// The place of a point, if it is in the picture.
    fn place(&self, at: [f64; 2]) -> Option<usize> {
        let height = self.is_line.len() / self.width.max(1);
        let inside = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < self.width as f64 && at[1] < height as f64;
        inside.then_some(at[1] as usize * self.width + at[0] as usize)
    }

    /// How far aside of a point, across a line's way, the nearest pixel is at which it is so: none, or one to either side.
    fn aside(&self, at: [f64; 2], way: [f64; 2], is: impl Fn(usize) -> bool) -> Option<f64> {
        [0.0, 1.0, -1.0].into_iter().find(|aside| self.place([at[0] - aside * way[1], at[1] + aside * way[0]]).is_some_and(&is))
    }

    /// The line that ends there, straight on: of the directions that it had for about the longest, that in which it goes on for longest.
    fn ray(&self, end: usize, ways: &[[f64; 2]], is_dark: &impl Fn(usize) -> bool) -> Option<Ray> {
        let from = [(end % self.width) as f64 + 0.5, (end / self.width) as f64 + 0.5];
        let before = |way: &[f64; 2]| {
            let ahead = |steps: usize| [0, 1].map(|k| from[k] - steps as f64 * way[k]);
            let is_line = |place: usize| self.is_line[place] && !self.is_word[place];
            (1..=MOST_PX).take_while(|steps| self.aside(ahead(*steps), *way, is_line).is_some()).count()
        };
        let longest = ways.iter().map(before).max().filter(|longest| *longest >= LEAST_PX)?;
        let mut best: Option<Ray> = None;
        for way in ways.iter().filter(|way| before(way) >= LEAST_PX.max(longest - STEP_PX)) {
            let ray = self.followed(from, *way, is_dark);
            let rank = |ray: &Ray| (ray.is_through, ray.places.len());
            if best.as_ref().is_none_or(|best| rank(&ray) > rank(best)) {
                best = Some(ray);
            }
        }
        best
    }

    /// Straight on from an end, aside as the line does: a direction is never quite right.
    fn followed(&self, from: [f64; 2], way: [f64; 2], is_dark: &impl Fn(usize) -> bool) -> Ray {
        let mut ray = Ray { from, places: Vec::new(), is_through: false };
        let mut off = 0.0;
        for steps in 1..=LONGEST_PX {
            let along = steps as f64;
            let at = [from[0] + along * way[0] - off * way[1], from[1] + along * way[1] + off * way[0]];
            let Some(place) = self.place(at) else { break };
            // A line that a word meets at a flat angle runs beside it first.
            let is_beyond = !self.is_word[place] && !ray.places.is_empty();
            let is_line = |place: usize| self.is_line[place] || (self.is_word[place] && is_dark(place) && !is_beyond);
            let Some(aside) = self.aside(at, way, is_line) else { break };
            off += SHIFT * aside;
            ray.is_through = is_beyond;
            if is_beyond {
                break;
            }
            ray.places.extend(self.is_word[place].then_some(place));
        }
        ray
    }

    /// How many places of each ray are of a line: up to the last at which it meets another.
    fn met(&self, rays: &[Ray]) -> impl Iterator<Item = usize> {
        let mut places: Vec<(usize, usize)> =
            rays.iter().enumerate().flat_map(|(i, ray)| ray.places.iter().map(move |place| (*place, i))).collect();
        places.sort_unstable();
        let is_other = move |ray: &Ray, place: usize| {
            let first = places.partition_point(|(p, _)| *p < place);
            let here = places[first..].iter().take_while(|(p, _)| *p == place);
            here.map(|(_, i)| rays[*i].from).any(|from| libm::hypot(from[0] - ray.from[0], from[1] - ray.from[1]) > APART_PX)
        };
        let width = self.width;
        rays.iter().map(move |ray| {
            let meets = |place: &usize| {
                let around = [width + 1, width, width - 1, 1, 0];
                around.iter().any(|by| is_other(ray, place + by) || place.checked_sub(*by).is_some_and(|place| is_other(ray, place)))
            };
            if ray.is_through { ray.places.len() } else { ray.places.iter().rposition(meets).map_or(0, |last| last + 1) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 120;

    /// Lines that are drawn under a word of bars of 2 px every 6 px, from row 50 to 64; what goes on of them under it, and what is so
    /// though no line is there.
    fn found(is_drawn: impl Fn(f64, f64) -> bool) -> (f64, usize) {
        let at = |i: usize| [(i % W) as f64, (i / W) as f64];
        let is_word = |i: usize| (50..64).contains(&(i / W)) && (20..100).contains(&(i % W));
        let is_letter = |i: usize| is_word(i) && (i % W) % 6 < 2 && (52..62).contains(&(i / W));
        let is_drawn: Vec<bool> = (0..W * W).map(|i| is_drawn(at(i)[0], at(i)[1])).collect();
        let is_line: Vec<bool> = (0..W * W).map(|i| is_drawn[i] && !is_word(i)).collect();
        let words: Vec<bool> = (0..W * W).map(is_word).collect();
        let lines = Under { width: W, is_line: &is_line, is_word: &words }.lines(|i| is_drawn[i] || is_letter(i));
        let hidden: Vec<usize> = (0..W * W).filter(|i| is_drawn[*i] && is_word(*i)).collect();
        let near = |a: usize, b: usize| libm::hypot(at(a)[0] - at(b)[0], at(a)[1] - at(b)[1]) < 2.3;
        let met = hidden.iter().filter(|a| lines.iter().any(|b| near(**a, *b))).count();
        let astray = lines.iter().filter(|a| !hidden.iter().any(|b| near(**a, *b)) && is_word(**a)).count();
        (met as f64 / hidden.len().max(1) as f64, astray)
    }

    #[test]
    fn lines_go_on_under_words_whatever_their_direction() {
        for slope in [0.0, 0.3, -1.0, 3.0] {
            let (met, astray) = found(|x, y| (x - 60.0 - slope * (y - 57.0)).abs() <= 0.5 * libm::hypot(1.0, slope) && y > 5.0);
            assert!(met > 0.95 && astray == 0, "slope {slope}: {met}, {astray} astray");
        }
        // Along the word, and where two walls meet under it.
        let (met, astray) = found(|_, y| y == 57.0);
        assert!(met > 0.95 && astray == 0, "along: {met}, {astray} astray");
        let (met, astray) = found(|x, y| (y == 57.0 && x <= 62.0) || (x == 62.0 && y <= 57.0));
        assert!(met > 0.9 && astray == 0, "corner: {met}, {astray} astray");
    }

    #[test]
    fn no_line_is_made_up_between_lines_that_end_at_a_word() {
        // Ends across from each other, with paper between, and an end with nothing across.
        assert_eq!(found(|x, y| x == 62.0 && !(50.0..64.0).contains(&y)).1, 0);
        assert_eq!(found(|x, y| x == 62.0 && y < 50.0).1, 0);
        let gap = Under { width: W, is_line: &[false; W * W], is_word: &[true; W * W] };
        assert!(gap.lines(|_| true).is_empty());
        assert!(Under { width: 0, is_line: &[], is_word: &[] }.lines(|_| true).is_empty());
    }
}
