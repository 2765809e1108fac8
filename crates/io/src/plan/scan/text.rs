//! What of the ink is writing? Small pieces that stand in a row, close to each other and equally high, as the letters of a word do.
//!
//! Letters that touch a wall are of one piece with it and stay. So does all that could be built: what is solid, what stands alone, and
//! what stands farther from its neighbours than letters do, as pillars and the dashes of a line.

use super::blobs::{Blob, Blobs, Run};
use super::strip::Strip;

/// Lower letters than this, in pixels, are too coarse to be told from the noise of a robot's map.
const LEAST_PX: u32 = 5;
/// No letter is larger than this share of the picture's longer side …
const LARGEST_SHARE: f64 = 0.05;
/// … or than this, metres, where pixels are so fine that letters are seen to be small.
const LARGEST_M: f64 = 0.8;
/// Letters smaller than this, in pixels, may be larger in metres: words on the plan of a whole site.
const SMALL_PX: f64 = 16.0;
/// Letters of a word are no farther apart than this share of their height, and words no farther than twice that.
const GAP: f64 = 0.7;
/// Letters of a word differ in height by no more than this factor: "a" and "l".
const HEIGHTS: f64 = 1.7;
/// A letter is no longer than this many times its height: "W", and two that touch.
const WIDEST: f64 = 1.8;
/// Fewest letters of a word.
const LEAST_LETTERS: usize = 3;
/// Two letters are a word if this many others are as high as one of them, to a seventh: figures of rooms.
const ALIKE: usize = 10;
/// A letter fills no more than this share of its box; what does is a pillar, unless it is as narrow as an "l".
const SOLID: f64 = 0.82;
/// A word that is read from below, whose letters run together, fills no more than this share of its box; a post that lacks a pixel does.
const RUN_TOGETHER: f64 = 0.7;
/// A word whose letters run together is at least this much longer than high, a row of its pixels crosses this many strokes, and it is
/// no higher than this, pixels: larger letters do not run together, stairs and cubicles do.
const MERGED: (f64, f64, f64) = (1.8, 2.6, 24.0);
/// More pieces of a letter's size are dots of a printer's grey, or a photograph's noise.
const GLYPH_LIMIT: usize = 50_000;

/// Which pieces are letters of words, written along rows or, turned by a quarter, along columns.
pub(super) fn letters(found: &Blobs, size_px: [usize; 2], metres_per_pixel: f64) -> Vec<bool> {
    let side = size_px[0].max(size_px[1]) as f64;
    let largest = (LARGEST_M / metres_per_pixel).max(SMALL_PX).min(LARGEST_SHARE * side).max(f64::from(LEAST_PX)) as u32;
    let mut is_letter = vec![false; found.blobs.len()];
    for axis in [0, 1] {
        let glyphs = glyphs(&found.blobs, axis, largest);
        if glyphs.len() > GLYPH_LIMIT {
            continue;
        }
        let mut words = words(&glyphs);
        let is_dash = dashes(found, words.iter().filter(|word| word.len() > 1).flatten().map(|i| glyphs[*i].blob));
        words.retain(|word| !word.iter().all(|i| is_dash[glyphs[*i].blob]));
        let (written, short): (Vec<_>, Vec<_>) = words.into_iter().partition(|word| is_written(word.iter().map(|i| &glyphs[*i])));
        written.iter().flatten().for_each(|i| is_letter[glyphs[*i].blob] = true);
        // What is as high as the letters of these words, or as other pairs, is a number of two figures or the end of a word.
        let strokes: Vec<Vec<usize>> =
            short.into_iter().filter(|word| word.len() == 2 && word.iter().all(|i| is_stroke(&glyphs[*i]))).collect();
        let mut heights: Vec<f64> = written.iter().chain(&strokes).flatten().map(|i| glyphs[*i].height()).collect();
        heights.sort_by(f64::total_cmp);
        let alike = |height: f64| heights.partition_point(|h| *h <= 1.15 * height) - heights.partition_point(|h| *h < height / 1.15);
        for word in strokes.iter().filter(|word| word.iter().any(|i| alike(glyphs[*i].height()) >= ALIKE)) {
            word.iter().for_each(|i| is_letter[glyphs[*i].blob] = true);
        }
    }
    take_dots(found, &mut is_letter);
    is_letter
}

/// Which of some pieces are straight strokes that lean: what an oblique line leaves above the threshold stands in a row, too.
fn dashes(found: &Blobs, pieces: impl Iterator<Item = usize>) -> Vec<bool> {
    let mut is_dash = vec![false; found.blobs.len()];
    pieces.for_each(|blob| is_dash[blob] = true);
    let mut runs: Vec<Run> = found.runs_of(|blob| is_dash[blob]).copied().collect();
    runs.sort_by_key(|run| run.blob);
    for piece in runs.chunk_by(|a, b| a.blob == b.blob) {
        let strip = Strip::of(piece.iter().copied());
        is_dash[piece[0].blob as usize] = strip.is_bar() && strip.is_oblique();
    }
    is_dash
}

/// Dots and accents: what is smaller than a letter, within the box of one, or as near above or below it as an i's dot.
fn take_dots(found: &Blobs, is_letter: &mut [bool]) {
    let letters: Vec<Blob> = found.blobs.iter().zip(is_letter.iter()).filter(|(_, letter)| **letter).map(|(blob, _)| *blob).collect();
    // In the order of their tops, as all pieces are: only those above within a letter's reach are looked at.
    let tallest = letters.iter().map(Blob::reach).max().unwrap_or(0);
    for (blob, taken) in found.blobs.iter().zip(is_letter.iter_mut()).filter(|(blob, taken)| !**taken && blob.reach() < LEAST_PX) {
        let first = letters.partition_point(|letter| letter.low[1] + 2 * tallest < blob.low[1]);
        let last = letters.partition_point(|letter| letter.low[1] <= blob.high[1] + tallest);
        *taken = letters[first.min(last)..last].iter().any(|letter| {
            let reach = letter.reach() / 2;
            (0..2).all(|k| blob.low[k] + reach >= letter.low[k] && blob.high[k] <= letter.high[k] + reach)
        });
    }
}

/// Whether it is drawn by a pen, and neither solid nor a mere line.
fn is_stroke(glyph: &Glyph) -> bool {
    glyph.fill <= SOLID && glyph.length() >= 0.3 * glyph.height()
}

/// A piece that may be a letter, by the direction of reading.
#[derive(Debug, Clone, Copy)]
struct Glyph {
    blob: usize,
    /// Where it begins and ends along the line of writing.
    along: [f64; 2],
    /// … and across.
    across: [f64; 2],
    /// Share of its box that is ink.
    fill: f64,
    /// Strokes that a line along the writing crosses, about.
    strokes: f64,
}

impl Glyph {
    fn height(&self) -> f64 {
        self.across[1] - self.across[0]
    }

    fn length(&self) -> f64 {
        self.along[1] - self.along[0]
    }
}

/// What is small and high enough, sorted by where it begins.
fn glyphs(blobs: &[Blob], axis: usize, largest: u32) -> Vec<Glyph> {
    let of = |(blob, b): (usize, &Blob)| {
        let (size, span) = (b.size(), |k: usize| [f64::from(b.low[k]), f64::from(b.high[k])]);
        let (length, height) = (size[axis], size[1 - axis]);
        let fill = b.area as f64 / (f64::from(size[0]) * f64::from(size[1]));
        let strokes = match axis {
            0 => f64::from(b.runs) / f64::from(size[1]),
            // Along columns the runs of rows say little; the ink says as much: half of a word's box.
            _ if fill <= RUN_TOGETHER && b.is_closed() => f64::from(length) * fill / 3.0,
            _ => 1.0,
        };
        // Words that run together are longer than letters; other long pieces are walls between doors, which stand in rows too.
        let is_letters = f64::from(length) <= WIDEST * f64::from(height) || (strokes >= MERGED.1 && length <= 8 * height);
        let fits = (LEAST_PX..=largest).contains(&height) && is_letters;
        fits.then_some(Glyph { blob, along: span(axis), across: span(1 - axis), fill, strokes })
    };
    let mut glyphs: Vec<Glyph> = blobs.iter().enumerate().filter_map(of).collect();
    glyphs.sort_by(|a, b| a.along[0].total_cmp(&b.along[0]).then(a.blob.cmp(&b.blob)));
    glyphs
}

/// Glyphs that follow one another, gathered.
fn words(glyphs: &[Glyph]) -> Vec<Vec<usize>> {
    let mut word_of: Vec<usize> = (0..glyphs.len()).collect();
    let mut words: Vec<Vec<usize>> = (0..glyphs.len()).map(|i| vec![i]).collect();
    for (i, glyph) in glyphs.iter().enumerate() {
        let reach = glyph.along[1] + GAP * HEIGHTS * glyph.height();
        for (j, other) in glyphs.iter().enumerate().skip(i + 1).take_while(|(_, other)| other.along[0] <= reach) {
            let (a, b) = (word_of[i].min(word_of[j]), word_of[i].max(word_of[j]));
            if a != b && follows(glyph, other) {
                let moved = std::mem::take(&mut words[b]);
                moved.iter().for_each(|k| word_of[*k] = a);
                words[a].extend(moved);
            }
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

fn follows(one: &Glyph, other: &Glyph) -> bool {
    let (low, high) = (one.height().min(other.height()), one.height().max(other.height()));
    let shared = one.across[1].min(other.across[1]) - one.across[0].max(other.across[0]);
    high <= HEIGHTS * low && shared >= 0.6 * low && other.along[0] - one.along[1] <= GAP * high
}

/// Whether a chain is a word.
fn is_written<'a>(word: impl Iterator<Item = &'a Glyph> + Clone) -> bool {
    let count = word.clone().count();
    let merged = |g: &Glyph| g.length() >= MERGED.0 * g.height() && g.strokes >= MERGED.1 && g.height() <= MERGED.2;
    let strokes = word.clone().filter(|g| is_stroke(g)).count();
    (count >= LEAST_LETTERS && 3 * strokes >= count) || word.clone().any(merged) && 2 * strokes >= count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strokes of letters, 5 × 7: M, A, L.
    const LETTERS: [&str; 3] =
        ["#...###.###.#.##...##...##...#", "..#...#.#.#...##...#######...##...##...#", "#....#....#....#....#....#....#####"];

    struct Sheet {
        width: usize,
        ink: Vec<bool>,
    }

    impl Sheet {
        fn new(width: usize, height: usize) -> Self {
            Self { width, ink: vec![false; width * height] }
        }

        fn rect(&mut self, [u0, v0, u1, v1]: [usize; 4]) {
            for v in v0..v1 {
                self.ink[v * self.width + u0..v * self.width + u1].fill(true);
            }
        }

        /// A word, each letter's dots `dot` px wide; turned by a quarter if it is to be read from below.
        fn word(&mut self, at: [usize; 2], dot: usize, turned: bool) {
            for (k, letter) in LETTERS.iter().enumerate() {
                for (i, _) in letter.chars().enumerate().filter(|(_, c)| *c == '#') {
                    let (x, y) = ((6 * k + i % 5) * dot, i / 5 * dot);
                    let (u, v) = if turned { (at[0] + y, at[1] - x) } else { (at[0] + x, at[1] + y) };
                    self.rect([u, v, u + dot, v + dot]);
                }
            }
        }

        fn letters(&self) -> (usize, usize) {
            let found = Blobs::of(self.ink.len(), self.width, |i| self.ink[i]).unwrap();
            let is_letter = letters(&found, [self.width, self.ink.len() / self.width], 0.02);
            (is_letter.iter().filter(|l| **l).count(), is_letter.len())
        }
    }

    #[test]
    fn words_are_told_from_walls_whichever_way_they_are_read() {
        let mut sheet = Sheet::new(400, 300);
        sheet.rect([20, 20, 380, 26]);
        sheet.rect([20, 20, 26, 280]);
        sheet.word([100, 100], 2, false);
        sheet.word([200, 200], 2, true);
        assert_eq!(sheet.letters(), (6, 7));
    }

    #[test]
    fn pillars_dashes_and_single_signs_stay() {
        let mut sheet = Sheet::new(600, 400);
        for i in 0..8 {
            // Pillars close to each other, hollow ones farther off, and a dashed line.
            sheet.rect([40 + 16 * i, 40, 52 + 16 * i, 52]);
            sheet.rect([40 + 60 * i, 100, 52 + 60 * i, 112]);
            sheet.rect([40 + 24 * i, 200, 58 + 24 * i, 203]);
        }
        sheet.rect([300, 300, 312, 302]);
        sheet.rect([300, 300, 302, 312]);
        // A post that lacks some pixels at its foot.
        sheet.rect([500, 300, 507, 309]);
        sheet.rect([503, 309, 505, 313]);
        assert_eq!(sheet.letters().0, 0);
    }

    #[test]
    fn walls_between_the_doors_of_a_corridor_stay_though_they_stand_in_a_row() {
        // Pieces of 20 px × 8 px, and T-shaped ones of 60 px × 42 px, with doors of 20 px between, as walls of 40 cm and rooms' walls.
        let mut sheet = Sheet::new(900, 400);
        for i in 0..8 {
            sheet.rect([40 + 40 * i, 40, 60 + 40 * i, 48]);
            sheet.rect([40 + 80 * i, 200, 100 + 80 * i, 210]);
            sheet.rect([66 + 80 * i, 210, 74 + 80 * i, 242]);
        }
        assert_eq!(sheet.letters().0, 0);
    }

    #[test]
    fn dashes_of_an_oblique_line_are_no_letters() {
        // What a thin grey line leaves above the threshold: four pixels of each five, a step aside now and then; steep, slanted, flat.
        for (run, rise) in [(1, 6), (1, 2), (1, 1), (3, 1)] {
            let mut sheet = Sheet::new(400, 300);
            for i in 0..80 {
                // Dashes of 8 px with gaps of 2 px, two pixels thick.
                let (u, v) = (40 + i * run, 20 + i * rise);
                if i % 10 < 8 && u < 398 && v + rise < 298 {
                    sheet.rect([u, v, u + run + 1, v + rise]);
                }
            }
            assert_eq!(sheet.letters().0, 0, "{run}:{rise}");
        }
    }

    #[test]
    fn a_letter_on_a_wall_is_wall() {
        let mut sheet = Sheet::new(400, 300);
        sheet.rect([20, 98, 380, 104]);
        sheet.word([100, 100], 2, false);
        assert_eq!(sheet.letters().0, 0);
    }
}
