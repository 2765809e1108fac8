//! What does a word on a drawing mean? `Wall`, `B_Door`, `Stairscase`, `mur`: wall, door, floor, wall.
//!
//! People type these words, so case, plurals, joined words, abbreviations and one slip of the finger are put up with.

/// What a shape of a drawing stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Stops people and light.
    Wall,
    /// A way through a wall.
    Door,
    /// Stops people only.
    Window,
    /// Somewhere to walk: rooms, corridors, stairs.
    Floor,
    /// Neither in the way nor part of the building's shape: furniture that may be moved, labels, routes, outlines of plots.
    Passed,
}

/// Words in the order in which they decide: a glass door is a door, a glass wall is glass, furniture of a room is no floor.
const WORDS: [(Kind, &[&str]); 5] = [
    (
        Kind::Passed,
        &["furnitur", "möbel", "mobel", "meuble", "table", "chair", "desk", "label", "annotation", "route", "footprint", "venue"],
    ),
    (Kind::Door, &["door", "opening", "gate", "tuer", "tür", "porte", "puerta", "deur"]),
    (Kind::Window, &["window", "glass", "glazing", "fenster", "fenetre", "fenêtre", "ventana", "raam"]),
    (
        Kind::Wall,
        &["wall", "facade", "façade", "fassade", "column", "pillar", "partition", "wand", "mauer", "muur", "mur", "muro", "pared"],
    ),
    (
        Kind::Floor,
        &[
            "room",
            "corridor",
            "hallway",
            "hall",
            "lobby",
            "foyer",
            "stair",
            "step",
            "elevator",
            "lift",
            "escalator",
            "ramp",
            "balcony",
            "gallery",
            "terrace",
            "office",
            "kitchen",
            "toilet",
            "walkway",
            "passage",
            "floor",
            "area",
            "space",
            "unit",
            "lounge",
            "storage",
            "lab",
            "zimmer",
            "raum",
            "flur",
            "gang",
            "treppe",
            "couloir",
            "salle",
            "escalier",
            "escalera",
        ],
    ),
];

/// Whole words that are too short to be looked for inside others, and abbreviations.
const SHORT: [(Kind, &[&str]); 4] = [
    (Kind::Door, &["d", "do", "doo", "dr", "entrance", "exit"]),
    (Kind::Window, &["win", "wnd"]),
    (Kind::Wall, &["w", "wa", "wal"]),
    (Kind::Floor, &["r", "rm", "wc", "cor", "corr"]),
];

/// A word shorter than this is not looked for with a slip: "hall" is one slip from "wall".
const SLIP_FROM: usize = 5;

/// What this word stands for, if that is known.
pub(super) fn of(word: &str) -> Option<Kind> {
    let word = word.trim().to_lowercase();
    let parts: Vec<&str> = word.split(|c: char| !c.is_alphanumeric()).filter(|p| !p.is_empty()).collect();
    // Neither is a door.
    let whole = parts.concat().replace("indoor", "").replace("outdoor", "");
    let contained = WORDS.iter().find(|(_, known)| known.iter().any(|k| whole.contains(k)));
    let short = || SHORT.iter().find(|(_, known)| parts.iter().any(|p| known.contains(p))).map(|(kind, _)| *kind);
    let slipped = |known: &str| known.chars().count() >= SLIP_FROM && parts.iter().any(|p| one_slip(p, known));
    let nearly = || WORDS.iter().find(|(_, known)| known.iter().any(|k| slipped(k))).map(|(kind, _)| *kind);
    contained.map(|(kind, _)| *kind).or_else(short).or_else(nearly)
}

/// Whether one letter more, one less or another one makes the words equal.
fn one_slip(a: &str, b: &str) -> bool {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len().abs_diff(b.len()) > 1 {
        return false;
    }
    let same = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let rest = |word: &[char], skip: usize| word.get(same + skip..).map(<[char]>::to_vec).unwrap_or_default();
    match a.len().cmp(&b.len()) {
        std::cmp::Ordering::Equal => rest(&a, 1) == rest(&b, 1),
        std::cmp::Ordering::Less => rest(&a, 0) == rest(&b, 1),
        std::cmp::Ordering::Greater => rest(&a, 1) == rest(&b, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_known_however_they_are_typed() {
        for (word, kind) in [
            ("Wall", Kind::Wall),
            ("Wa", Kind::Wall),
            ("WALLS", Kind::Wall),
            ("A-WALL-INTR", Kind::Wall),
            ("Fassade", Kind::Wall),
            ("Door", Kind::Door),
            ("D", Kind::Door),
            ("B_Door", Kind::Door),
            ("glass door", Kind::Door),
            ("glass wall", Kind::Window),
            ("Stairscase", Kind::Floor),
            ("Rooms", Kind::Floor),
            ("Coridor", Kind::Floor),
            ("Elevatr", Kind::Floor),
            ("hall", Kind::Floor),
            ("Furnitures", Kind::Passed),
            ("Outdoor area", Kind::Floor),
            ("entrance hall", Kind::Floor),
            ("entrance", Kind::Door),
        ] {
            assert_eq!(of(word), Some(kind), "{word}");
        }
        for word in ["", "indoor", "NaNs", "yes", "Ω", "x"] {
            assert_eq!(of(word), None, "{word}");
        }
    }
}
