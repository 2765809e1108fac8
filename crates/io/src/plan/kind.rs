//! What does a word on a drawing mean? `Wall`, `B_Door`, `Stairscase`, `mur`: wall, door, floor, wall.
//!
//! People type these words, so case, plurals, joined words, abbreviations and one slip of the finger are put up with.

use planwalk_types::ElementKind;

/// What a word says of what it stands at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Meaning {
    /// Part of the building.
    Part(ElementKind),
    /// Neither in the way nor part of the building's shape: furniture that may be moved, labels, routes, outlines of plots.
    Passed,
}

const WALL: Meaning = Meaning::Part(ElementKind::Wall);
const WINDOW: Meaning = Meaning::Part(ElementKind::Window);
const DOOR: Meaning = Meaning::Part(ElementKind::Door);
const FLOOR: Meaning = Meaning::Part(ElementKind::Floor);
const ROOM: Meaning = Meaning::Part(ElementKind::Room);
const STAIRS: Meaning = Meaning::Part(ElementKind::Stairs);
const LIFT: Meaning = Meaning::Part(ElementKind::Lift);

/// Words in the order in which they decide: a glass door is a door, a glass wall is glass, furniture of a room is no floor.
const WORDS: [(Meaning, &[&str]); 8] = [
    (
        Meaning::Passed,
        &[
            "furnitur",
            "möbel",
            "mobel",
            "meuble",
            "table",
            "chair",
            "desk",
            "label",
            "annotation",
            "route",
            "footprint",
            "venue",
            "opentobelow",
        ],
    ),
    (DOOR, &["door", "opening", "gate", "tuer", "tür", "porte", "puerta", "deur"]),
    (WINDOW, &["window", "glass", "glazing", "fenster", "fenetre", "fenêtre", "ventana", "raam"]),
    (WALL, &["wall", "facade", "façade", "fassade", "column", "pillar", "partition", "wand", "mauer", "muur", "mur", "muro", "pared"]),
    (STAIRS, &["stair", "step", "escalator", "ramp", "treppe", "escalier", "escalera"]),
    (LIFT, &["elevator", "lift", "aufzug", "ascenseur", "ascensor"]),
    (
        ROOM,
        &[
            "room", "corridor", "hallway", "hall", "lobby", "foyer", "office", "kitchen", "toilet", "unit", "lounge", "storage", "lab",
            "zimmer", "raum", "flur", "gang", "couloir", "salle",
        ],
    ),
    (FLOOR, &["balcony", "gallery", "terrace", "walkway", "passage", "floor", "area", "space"]),
];

/// Whole words that are too short to be looked for inside others, and abbreviations.
const SHORT: [(Meaning, &[&str]); 4] = [
    (DOOR, &["d", "do", "doo", "dr", "entrance", "exit"]),
    (WINDOW, &["win", "wnd"]),
    (WALL, &["w", "wa", "wal"]),
    (ROOM, &["r", "rm", "wc", "cor", "corr"]),
];

/// A word shorter than this is not looked for with a slip: "hall" is one slip from "wall".
const SLIP_FROM: usize = 5;

/// What this word stands for, if that is known.
pub(super) fn of(word: &str) -> Option<Meaning> {
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

/// Whether a layer's name says that its lines are ways to walk.
pub(super) fn is_routes(name: &str) -> bool {
    let name = name.to_lowercase();
    ["route", "routing"].iter().any(|word| name.contains(word))
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
            ("Wall", WALL),
            ("Wa", WALL),
            ("WALLS", WALL),
            ("A-WALL-INTR", WALL),
            ("Fassade", WALL),
            ("Door", DOOR),
            ("D", DOOR),
            ("B_Door", DOOR),
            ("glass door", DOOR),
            ("glass wall", WINDOW),
            ("Stairscase", STAIRS),
            ("Rooms", ROOM),
            ("Coridor", ROOM),
            ("Elevatr", LIFT),
            ("hall", ROOM),
            ("Furnitures", Meaning::Passed),
            ("Outdoor area", FLOOR),
            ("entrance hall", ROOM),
            ("entrance", DOOR),
        ] {
            assert_eq!(of(word), Some(kind), "{word}");
        }
        for word in ["", "indoor", "NaNs", "yes", "Ω", "x"] {
            assert_eq!(of(word), None, "{word}");
        }
    }
}
