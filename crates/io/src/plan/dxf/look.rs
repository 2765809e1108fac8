//! How does a layer, a colour number, a line type look, and how long is a unit? What the file's tables and its header say.
//!
//! Names are told apart without regard to case, as CAD programmes do.

use std::collections::HashMap;

/// Characters kept of a name: CAD programmes allow 255.
const LONGEST_NAME: usize = 255;
/// The layer that stands in blocks for whichever one the block is inserted on.
const INHERITED: &str = "0";

/// A colour as an object has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Colour {
    ByLayer,
    ByBlock,
    Is([u8; 3]),
}

impl Colour {
    /// Of the number under code 62 and the true colour under code 420.
    pub(super) fn of(index: i32, true_colour: Option<i32>) -> Self {
        match (true_colour, index) {
            (Some(rgb), _) => Self::Is(rgb_of(rgb)),
            (None, 0) => Self::ByBlock,
            (None, 1..=255) => Self::Is(index_rgb(index as u8)),
            (None, _) => Self::ByLayer,
        }
    }
}

fn rgb_of(packed: i32) -> [u8; 3] {
    let [_, red, green, blue] = packed.to_be_bytes();
    [red, green, blue]
}

/// The standard colours of AutoCAD's index on white paper, within a few steps of brightness: 1 to 9 are named, 250 to 255 grey;
/// between, tens are 24 hues, and units five brightnesses, odd ones paler.
fn index_rgb(index: u8) -> [u8; 3] {
    const BRIGHTNESS: [f64; 5] = [255.0, 189.0, 129.0, 104.0, 79.0];
    match index {
        1 => [255, 0, 0],
        2 => [255, 255, 0],
        3 => [0, 255, 0],
        4 => [0, 255, 255],
        5 => [0, 0, 255],
        6 => [255, 0, 255],
        // White on black screens, black on paper.
        0 | 7 => [0, 0, 0],
        8 => [65, 65, 65],
        9 => [128, 128, 128],
        10..=249 => {
            let bright = BRIGHTNESS[usize::from(index % 10 / 2)];
            let floor = if index % 2 == 1 { bright * 2.0 / 3.0 } else { 0.0 };
            let hue = f64::from(index / 10 - 1) / 4.0;
            // Red is full within one sixth of the circle to either side of hue 0 and none beyond two; green and blue likewise at 2 and 4.
            [0.0, 2.0, 4.0].map(|centre| {
                let away: f64 = (hue - centre).abs();
                let share = (2.0 - away.min(6.0 - away)).clamp(0.0, 1.0);
                (floor + share * (bright - floor)).round() as u8
            })
        }
        250 => [51; 3],
        251 => [80; 3],
        252 => [105; 3],
        253 => [130; 3],
        254 => [190; 3],
        255 => [255; 3],
    }
}

/// A line as an object has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Line {
    ByLayer,
    ByBlock,
    Is { dashed: bool },
}

/// A layer.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub name: String,
    pub colour: [u8; 3],
    pub dashed: bool,
    /// Switched on. What is inserted on one that is off shows all the same, if its own layers are on.
    pub on: bool,
    /// Frozen ones hide what is inserted on them too.
    pub frozen: bool,
}

impl Layer {
    pub(super) fn is_inherited(&self) -> bool {
        self.name == INHERITED
    }

    pub(super) fn is_shown(&self) -> bool {
        self.on && !self.frozen
    }
}

/// All layers, those of the table and those that only objects name; and the line types.
#[derive(Debug, Default)]
pub(super) struct Looks {
    pub layers: Vec<Layer>,
    layer_of: HashMap<String, usize>,
    dashed: HashMap<String, bool>,
}

impl Looks {
    /// The number of the layer of this name.
    pub(super) fn layer(&mut self, name: &str) -> usize {
        let name = short(name);
        let name = if name.is_empty() { INHERITED } else { name };
        if let Some(number) = self.layer_of.get(name) {
            return *number;
        }
        // The key as it is typed saves making it lower case for every object.
        let key = name.to_lowercase();
        let number = self.layer_of.get(&key).copied().unwrap_or_else(|| {
            self.layers.push(Layer { name: name.to_owned(), colour: index_rgb(7), dashed: false, on: true, frozen: false });
            self.layers.len() - 1
        });
        self.layer_of.insert(key, number);
        self.layer_of.insert(name.to_owned(), number);
        number
    }

    /// A layer of the table. A negative colour says that it is off.
    pub(super) fn define_layer(&mut self, name: &str, flags: i32, index: i32, true_colour: Option<i32>, line_type: &str) {
        let dashed = matches!(self.line(line_type), Line::Is { dashed: true });
        let number = self.layer(name);
        let Some(layer) = self.layers.get_mut(number) else { return };
        layer.colour = match Colour::of(index.saturating_abs(), true_colour) {
            Colour::Is(rgb) => rgb,
            Colour::ByLayer | Colour::ByBlock => index_rgb(7),
        };
        layer.on = index >= 0;
        layer.frozen = flags & 1 != 0;
        layer.dashed = dashed;
    }

    /// A line type of the table, and whether its pattern has gaps.
    pub(super) fn define_line(&mut self, name: &str, has_gaps: bool) {
        self.dashed.insert(short(name).to_lowercase(), has_gaps);
    }

    /// What this name of a line type means: what the table says of its pattern, or else what the name says.
    pub(super) fn line(&self, name: &str) -> Line {
        const GAPS: [&str; 12] =
            ["dash", "hidden", "center", "centre", "dot", "phantom", "border", "divide", "strich", "verdeckt", "mitte", "iso0"];
        let name = short(name).to_lowercase();
        match name.as_str() {
            "" | "bylayer" => Line::ByLayer,
            "byblock" => Line::ByBlock,
            "continuous" => Line::Is { dashed: false },
            _ => Line::Is { dashed: self.dashed.get(&name).copied() == Some(true) || GAPS.iter().any(|word| name.contains(word)) },
        }
    }
}

/// A name, cut to the length that names may have.
pub(super) fn short(name: &str) -> &str {
    let name = name.trim();
    name.char_indices().nth(LONGEST_NAME).map_or(name, |(end, _)| &name[..end])
}

/// Name and length in metres of the unit under `$INSUNITS`.
pub(super) fn unit(code: i32) -> Option<(&'static str, f64)> {
    const SURVEY_FOOT: f64 = 1200.0 / 3937.0;
    let unit = match code {
        1 => ("inches", 0.0254),
        2 => ("feet", 0.3048),
        3 => ("miles", 1609.344),
        4 => ("millimetres", 0.001),
        5 => ("centimetres", 0.01),
        6 => ("metres", 1.0),
        7 => ("kilometres", 1000.0),
        8 => ("microinches", 2.54e-8),
        9 => ("mils", 2.54e-5),
        10 => ("yards", 0.9144),
        11 => ("ångströms", 1e-10),
        12 => ("nanometres", 1e-9),
        13 => ("micrometres", 1e-6),
        14 => ("decimetres", 0.1),
        15 => ("decametres", 10.0),
        16 => ("hectometres", 100.0),
        17 => ("gigametres", 1e9),
        18 => ("astronomical units", 1.495_978_707e11),
        19 => ("light years", 9.460_730_472_580_8e15),
        20 => ("parsecs", 3.085_677_581_491_367e16),
        21 => ("US survey feet", SURVEY_FOOT),
        22 => ("US survey inches", SURVEY_FOOT / 12.0),
        23 => ("US survey yards", SURVEY_FOOT * 3.0),
        24 => ("US survey miles", SURVEY_FOOT * 5280.0),
        _ => return None,
    };
    Some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_numbers_are_hues_and_brightnesses() {
        for (index, rgb) in [
            (1, [255, 0, 0]),
            (10, [255, 0, 0]),
            (11, [255, 170, 170]),
            (30, [255, 128, 0]),
            (50, [255, 255, 0]),
            (90, [0, 255, 0]),
            (94, [0, 129, 0]),
            (130, [0, 255, 255]),
            (170, [0, 0, 255]),
            (210, [255, 0, 255]),
            (240, [255, 0, 64]),
            (253, [130, 130, 130]),
        ] {
            assert_eq!(Colour::of(index, None), Colour::Is(rgb), "{index}");
        }
        assert_eq!([0, 256, 257, -3].map(|i| Colour::of(i, None)), [Colour::ByBlock, Colour::ByLayer, Colour::ByLayer, Colour::ByLayer]);
        assert_eq!(Colour::of(256, Some(0x00FF_8001)), Colour::Is([255, 128, 1]));
    }

    #[test]
    fn layers_are_found_whatever_their_case() {
        let mut looks = Looks::default();
        looks.define_line("Unterzug", true);
        looks.define_layer("A-WALL", 1, -3, None, "UNTERZUG");
        let wall = looks.layer("a-wall");
        assert_eq!((wall, looks.layer("A-Wall"), looks.layers.len()), (0, 0, 1));
        let wall = &looks.layers[wall];
        assert_eq!((wall.on, wall.frozen, wall.colour, wall.dashed), (false, true, [0, 255, 0], true));
        assert_eq!((looks.layer(""), looks.layer("0")), (1, 1));
    }

    #[test]
    fn line_types_are_dashed_by_their_pattern_or_their_name() {
        let mut looks = Looks::default();
        looks.define_line("ZIGZAG", false);
        looks.define_line("x17", true);
        for (name, dashed) in [("HIDDEN2", true), ("ACAD_ISO03W100", true), ("X17", true), ("zigzag", false), ("Continuous", false)] {
            assert_eq!(looks.line(name), Line::Is { dashed }, "{name}");
        }
        assert_eq!((looks.line("ByLayer"), looks.line("BYBLOCK")), (Line::ByLayer, Line::ByBlock));
    }

    #[test]
    fn twelve_survey_inches_are_a_survey_foot() {
        let metres = |code| unit(code).unwrap().1;
        assert!((metres(22) * 12.0 - metres(21)).abs() < 1e-15);
        assert_eq!((unit(0), unit(25), unit(-1)), (None, None, None));
    }
}
