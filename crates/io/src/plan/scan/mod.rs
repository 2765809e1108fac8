//! What of a picture's ink was built? Words, signs and open doors are told from walls, and colours from ink.
//!
//! ink ─▶ [`blobs`] ─▶ without letters ([`text`]) and signs ([`tint`]) ─▶ with outlines of pale fills ([`fills`]), also under words
//! ([`under`]) ─▶ without curls and specks of a thin pen ([`strokes`]) ─▶ coloured doors ([`tint`]) and doors that stand open ([`swing`])
//! as ways through ─▶ [`Cell`]s
//!
//! Pitfall: a wall that is missing costs more than a chair that is left in. What touches a wall stays, unless it is a door's leaf and
//! circle; the notes say what was left out.

mod blobs;
mod fills;
pub(super) mod light;
mod strip;
mod strokes;
mod swing;
mod text;
pub(super) mod tilt;
mod tint;
mod under;

use planwalk_types::Cell;

use blobs::Blobs;
pub(super) use blobs::for_runs;
use fills::Fill;
pub(super) use tint::Planes;
use under::Under;

/// Edges of letters are blurred this far, pixels.
const BLUR_PX: usize = 2;

/// Cells of a picture's pixels, from what is ink in it; and what was done.
pub(super) fn cells(planes: &Planes, mut is_ink: Vec<bool>, metres_per_pixel: f64, notes: &mut Vec<String>) -> Vec<Cell> {
    let size = [planes.width, planes.height];
    let Some(found) = Blobs::of(is_ink.len(), planes.width, |i| is_ink[i]) else {
        notes.push("the picture has too many dots for a drawing: words and doors are not told from walls".to_owned());
        return plain(&is_ink);
    };
    let is_letter = text::letters(&found, size, metres_per_pixel);
    let is_sign = tint::signs(planes, &found);
    let is_note = |blob: usize| is_letter[blob] || is_sign[blob];
    found.runs_of(is_note).for_each(|run| is_ink[run.places(planes.width)].fill(false));
    tell(
        notes,
        is_letter.iter().filter(|l| **l).count(),
        "letter",
        "letters and figures",
        "left out: they stand in rows, apart from the walls",
    );
    tell(notes, is_sign.iter().filter(|s| **s).count(), "coloured sign", "coloured signs", "left out");
    if !planes.hue.is_empty() {
        outline_fills(planes, &mut is_ink, &found, is_note, notes);
    }
    let strokes = strokes::strokes(&is_ink, planes.width, metres_per_pixel);
    strokes.curls.iter().flatten().chain(&strokes.specks).for_each(|run| is_ink[run.places(planes.width)].fill(false));
    tell(notes, strokes.curls.len(), "curl", "curls", "of a pen much thinner than the walls left out: circles, arrows, writing");
    tell(notes, strokes.speck_count, "speck", "specks", "much smaller than the walls are thick left out");
    let coloured = if planes.hue.is_empty() { Vec::new() } else { tint::doors(planes, &is_ink, metres_per_pixel) };
    let swings = swing::swings(&is_ink, planes.width, metres_per_pixel);
    let mut is_way = Vec::new();
    for swing in &swings {
        swing.for_pixels(size, metres_per_pixel, |place, is_drawn| {
            is_ink[place] = false;
            if !is_drawn {
                is_way.push(place);
            }
        });
    }
    let mut cells = plain(&is_ink);
    is_way.into_iter().for_each(|place| cells[place] = Cell::Door);
    coloured.iter().flatten().for_each(|run| cells[run.places(planes.width)].fill(Cell::Door));
    tell(notes, coloured.len(), "coloured strip", "coloured strips", "across gaps of walls taken for doors");
    tell(notes, swings.len(), "door", "doors", "that stand open found by leaf and quarter circle, and opened");
    cells
}

fn plain(is_ink: &[bool]) -> Vec<Cell> {
    is_ink.iter().map(|ink| if *ink { Cell::Wall } else { Cell::Free }).collect()
}

/// "3 doors that stand open", if there are any.
fn tell(notes: &mut Vec<String>, count: usize, one: &str, many: &str, what: &str) {
    match count {
        0 => {}
        1 => notes.push(format!("1 {one} {what}")),
        _ => notes.push(format!("{count} {many} {what}")),
    }
}

/// Adds the outlines of fills to the ink.
fn outline_fills(planes: &Planes, is_ink: &mut [bool], found: &Blobs, is_note: impl Fn(usize) -> bool, notes: &mut Vec<String>) {
    let mut is_word = vec![false; is_ink.len()];
    for run in found.runs_of(is_note) {
        let rows = (run.row as usize).saturating_sub(BLUR_PX)..(run.row as usize + BLUR_PX + 1).min(planes.height);
        let columns = (run.start as usize).saturating_sub(BLUR_PX)..(run.end as usize + BLUR_PX).min(planes.width);
        rows.for_each(|row| is_word[row * planes.width + columns.start..row * planes.width + columns.end].fill(true));
    }
    let fills = fills::fills(planes);
    let Some(dark) = fills.iter().map(Fill::line).min() else { return };
    let lines = fills::outlines(&fills, planes, is_ink, |place| is_word[place]);
    if lines.is_empty() {
        return;
    }
    lines.iter().for_each(|place| is_ink[*place] = true);
    // Under a word is whatever is darker than all fills, by as much as lines are.
    let under = Under { width: planes.width, is_line: is_ink, is_word: &is_word }.lines(|place| planes.brightness[place] <= dark);
    under.iter().for_each(|place| is_ink[*place] = true);
    tell(notes, lines.len(), "pixel", "pixels", "of outlines around pale areas taken for walls");
    tell(notes, under.len(), "pixel", "pixels", "of such outlines followed under words");
}
