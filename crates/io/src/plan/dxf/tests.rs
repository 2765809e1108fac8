use super::*;
use proptest::prelude::*;

/// Pairs as a file has them: a code and a value each, separated by spaces; `~` stands for a space in values.
fn pairs(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.chunks(2).map(|pair| format!("{}\n{}\n", pair[0], pair.get(1).unwrap_or(&"").replace('~', " "))).collect()
}

fn file(header: &str, tables: &str, blocks: &str, entities: &str) -> String {
    pairs(&format!(
        "0 SECTION 2 HEADER {header} 0 ENDSEC 0 SECTION 2 TABLES {tables} 0 ENDSEC 0 SECTION 2 BLOCKS {blocks} 0 ENDSEC \
         0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF"
    ))
}

fn entities(entities: &str) -> Sketch {
    read(file("", "", "", entities).as_bytes()).unwrap()
}

/// The points of all paths, to the centimetre, without minus zeros.
fn points(sketch: &Sketch) -> Vec<Vec<Point>> {
    let round = |p: &Point| p.map(|v| (v * 100.0).round() / 100.0 + 0.0);
    sketch.paths.iter().map(|path| path.points.iter().map(round).collect()).collect()
}

fn noted(sketch: &Sketch, words: &str) -> bool {
    sketch.notes.iter().any(|note| note.contains(words))
}

const LINE: &str = "0 LINE 8 A-WALL 10 1 20 2 11 4 21 2";

#[test]
fn a_line_has_its_layer_its_colour_and_its_unit() {
    let header = "9 $ACADVER 1 AC1015 9 $TDCREATE 40 1.#INF 9 $INSUNITS 70 4";
    let tables = "0 TABLE 2 LTYPE 0 LTYPE 2 Zaun 49 0.5 49 -0.25 0 ENDTAB \
                  0 TABLE 2 LAYER 0 LAYER 2 A-WALL 70 0 62 3 6 CONTINUOUS 0 LAYER 2 HID 62 1 6 zaun 0 ENDTAB";
    let lines = format!("{LINE} {LINE} 8 HID {LINE} 62 5 6 HIDDEN2 {LINE} 62 5 420 {}", 0xFF_8000);
    let sketch =
        read(file(header, tables, "", &lines.replace("8 A-WALL 10 1 20 2 11 4 21 2 8 HID", "8 HID 10 1 20 2 11 4 21 2")).as_bytes())
            .unwrap();
    let looks: Vec<_> = sketch.paths.iter().map(|p| (p.layer.as_str(), p.stroke.unwrap(), p.dashed)).collect();
    let green = [0, 255, 0];
    assert_eq!(
        looks,
        [("A-WALL", green, false), ("HID", [255, 0, 0], true), ("A-WALL", [0, 0, 255], true), ("A-WALL", [255, 128, 0], false)]
    );
    assert_eq!((sketch.metres_per_unit, points(&sketch)[0].as_slice()), (Some(0.001), [[1.0, 2.0], [4.0, 2.0]].as_slice()));
    assert!(noted(&sketch, "millimetres"), "{:?}", sketch.notes);
}

#[test]
fn a_unit_that_is_not_stated_is_not_guessed() {
    let sketch = read(file("9 $MEASUREMENT 70 1", "", "", LINE).as_bytes()).unwrap();
    assert_eq!(sketch.metres_per_unit, None);
    assert!(noted(&sketch, "does not say how long its unit is") && noted(&sketch, "metric"), "{:?}", sketch.notes);
}

#[test]
fn polylines_old_and_new_have_bulges_widths_and_ends() {
    let new = "0 LWPOLYLINE 90 3 70 1 43 0.2 10 0 20 0 10 4 20 0 42 1 10 4 20 2";
    let old = "0 POLYLINE 66 1 70 1 40 0.2 41 0.2 0 VERTEX 10 0 20 0 0 VERTEX 10 4 20 0 42 1 0 VERTEX 10 4 20 2 0 SEQEND";
    let (new, old) = (entities(new), entities(old));
    assert_eq!(points(&new), points(&old));
    let path = &new.paths[0];
    assert_eq!((path.closed, path.curved, path.width), (true, true, 0.2));
    assert!(path.points.len() > 10 && path.points.iter().any(|p| (p[0] - 5.0).abs() < 0.01), "the half circle reaches x = 5");
    let open = entities("0 LWPOLYLINE 10 0 20 0 10 1 20 0 40 0.4 41 0.4 10 2 20 0 40 0.4 41 0.4 10 3 20 0");
    assert_eq!(points(&open), [vec![[0.0, 0.0], [1.0, 0.0]], vec![[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]]);
    assert_eq!((open.paths[1].width, open.paths[0].group == open.paths[1].group), (0.4, true));
}

#[test]
fn arcs_turn_counter_clockwise_and_mirrored_ones_the_other_way() {
    let arc = "0 ARC 10 5 20 0 40 1 50 0 51 90";
    let ends = |sketch: &Sketch| (points(sketch)[0][0], *points(sketch)[0].last().unwrap());
    assert_eq!(ends(&entities(arc)), ([6.0, 0.0], [5.0, 1.0]));
    assert_eq!(ends(&entities(&format!("{arc} 210 0 220 0 230 -1"))), ([-6.0, 0.0], [-5.0, 1.0]));
    assert_eq!(ends(&entities("0 ARC 10 0 20 0 40 1 50 270 51 90")), ([0.0, -1.0], [0.0, 1.0]));
    let circle = &entities("0 CIRCLE 10 0 20 0 40 3").paths[0];
    assert!(circle.closed && circle.curved && circle.points.len() > 50);
    let [first, last] = [circle.points[0], *circle.points.last().unwrap()];
    assert!((first[0] - last[0]).hypot(first[1] - last[1]) > 0.1, "{first:?} is not there twice");
    let ellipse = entities("0 ELLIPSE 10 0 20 0 11 2 21 0 40 0.5 41 0 42 1.570796326794");
    assert_eq!(ends(&ellipse), ([2.0, 0.0], [0.0, 1.0]));
    let spline = entities("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 30 0 10 1 20 2 30 0 10 2 20 0 30 0");
    assert!(ends(&spline) == ([0.0, 0.0], [2.0, 0.0]) && spline.paths[0].points.iter().any(|p| (p[1] - 1.0).abs() < 1e-9));
}

#[test]
fn areas_are_filled() {
    let solid = entities("0 SOLID 62 1 10 0 20 0 11 2 21 0 12 0 22 1 13 2 23 1");
    assert_eq!(points(&solid), [vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]]);
    assert_eq!((solid.paths[0].fill, solid.paths[0].stroke), (Some([255, 0, 0]), None));
    let outline = "92 2 72 0 73 1 93 3 10 0 20 0 10 4 20 0 10 4 20 4 97 0";
    let hole = "92 1 93 2 72 1 10 3 20 1 11 2 21 1 72 2 10 2.5 20 1 40 0.5 50 180 51 360 73 1 97 1 330 AF";
    let hatch = entities(&format!("0 HATCH 10 0 20 0 30 0 2 SOLID 70 1 71 0 91 2 {outline} {hole} 75 1 98 1 10 9 20 9"));
    let [ring, island] = &hatch.paths[..] else { panic!("{hatch:?}") };
    assert_eq!((ring.points.len(), ring.group == island.group, island.curved), (3, true, true));
    assert!(island.points.iter().all(|p| p[1] <= 1.0 + 1e-9) && island.points.iter().any(|p| p[1] < 0.51), "{:?}", island.points);
    let lines = entities(&format!("{LINE} 0 HATCH 2 ANSI31 70 0 91 1 {outline}"));
    assert!(lines.paths.len() == 1 && noted(&lines, "1 HATCH of lines"), "{:?}", lines.notes);
}

#[test]
fn texts_are_where_their_base_line_begins() {
    let at = |text: &str| {
        let sketch = entities(text);
        let text = &sketch.texts[0];
        (text.text.clone(), text.at.map(|v| (v * 100.0).round() / 100.0 + 0.0), text.height)
    };
    let is = |text: &str, at: Point| (text.to_owned(), at, 2.0);
    assert_eq!(at("0 TEXT 10 1 20 2 40 2 1 %%u101%%u"), is("101", [1.0, 2.0]));
    assert_eq!(at("0 TEXT 10 7 20 2 40 2 1 101 72 1 11 9 21 2"), is("101", [7.0, 2.0]));
    assert_eq!(at("0 TEXT 10 0 20 0 40 2 1 1234 72 4 11 9 21 2"), is("1234", [6.0, 1.0]));
    assert_eq!(at(r"0 MTEXT 10 1 20 9 40 2 71 1 1 {\fArial|b1;OFFICE}\P101"), is("OFFICE\n101", [1.0, 7.0]));
    assert_eq!(at("0 MTEXT 10 1 20 9 40 2 71 5 11 0 21 1 1 1234"), is("1234", [2.0, 6.0]));
    let long = entities(r"0 MTEXT 10 1 20 9 40 2 3 a\P 3 b~ 1 c");
    assert_eq!(long.texts[0].text, "a\nb c");
}

#[test]
fn old_files_say_their_code_page() {
    let text = |header: &str, bytes: &[u8]| {
        let mut file = pairs(&format!("0 SECTION 2 HEADER {header} 0 ENDSEC 0 SECTION 2 ENTITIES 0 TEXT 10 0 20 0 40 1")).into_bytes();
        file.extend(b"1\n");
        file.extend(bytes);
        file.extend(b"\n0\nENDSEC\n0\nEOF\n");
        read(&file).unwrap().texts[0].text.clone()
    };
    assert_eq!(text("9 $ACADVER 1 AC1009 9 $DWGCODEPAGE 3 ANSI_1251", &[0xca, 0xeb]), "Кл");
    assert_eq!(text("9 $ACADVER 1 AC1021 9 $DWGCODEPAGE 3 ANSI_1251", "Büro".as_bytes()), "Büro");
    assert_eq!(text("", &[b'B', 0xfc, b'r', b'o']), "Büro");
}

const DOOR: &str = "0 BLOCK 2 Door 70 0 10 1 20 0 0 LINE 8 0 62 0 10 1 20 0 11 2 21 0 0 LINE 8 LEAF 10 1 20 0 11 1 21 1 0 ENDBLK";

#[test]
fn blocks_are_moved_turned_stretched_and_mirrored() {
    let inserted = |insert: &str| read(file("", "", DOOR, &format!("0 INSERT 8 A-DOOR 62 1 2 DOOR {insert}")).as_bytes()).unwrap();
    let sketch = inserted("10 10 20 20 50 90 41 3 42 -2");
    assert_eq!(points(&sketch), [vec![[10.0, 20.0], [10.0, 23.0]], vec![[10.0, 20.0], [12.0, 20.0]]]);
    let looks: Vec<_> = sketch.paths.iter().map(|p| (p.layer.as_str(), p.stroke.unwrap())).collect();
    assert_eq!(looks, [("A-DOOR/Door", [255, 0, 0]), ("LEAF/Door", [0, 0, 0])]);
    let rows = inserted("10 0 20 0 70 2 71 3 44 5 45 7");
    let first: Vec<Point> = points(&rows).iter().step_by(2).map(|p| p[0]).collect();
    assert_eq!(first, [[0.0, 0.0], [5.0, 0.0], [0.0, 7.0], [5.0, 7.0], [0.0, 14.0], [5.0, 14.0]]);
    assert_eq!(points(&inserted("10 10 20 0 230 -1"))[0], [[-10.0, 0.0], [-11.0, 0.0]]);
    let labelled =
        inserted("66 1 10 10 20 20 41 9 0 ATTRIB 8 0 10 3 20 4 40 2 1 D1 2 NUMBER 70 0 0 ATTRIB 8 0 10 3 20 4 40 2 1 X 2 Y 70 1 0 SEQEND");
    assert_eq!((labelled.texts.len(), labelled.texts[0].text.as_str(), labelled.texts[0].at), (1, "D1", [3.0, 4.0]));
    assert_eq!(labelled.texts[0].layer, "A-DOOR/DOOR");
}

#[test]
fn blocks_in_blocks_are_named_from_outside_in() {
    let outer = "0 BLOCK 2 Wing 10 0 20 0 0 INSERT 8 0 2 Door 10 5 20 5 0 ENDBLK";
    let sketch = read(file("", "", &format!("{outer} {DOOR}"), "0 INSERT 8 EAST 2 Wing 10 100 20 0").as_bytes()).unwrap();
    assert_eq!((sketch.paths[0].layer.as_str(), points(&sketch)[0][0]), ("EAST/Wing/Door", [105.0, 5.0]));
}

#[test]
fn blocks_that_explode_or_contain_themselves_are_stopped() {
    let endless = "0 BLOCK 2 A 0 LINE 10 0 20 0 11 1 21 0 0 INSERT 2 B 0 ENDBLK 0 BLOCK 2 B 0 INSERT 2 A 0 ENDBLK";
    let sketch = read(file("", "", endless, "0 INSERT 2 A 0 INSERT 2 nowhere").as_bytes()).unwrap();
    assert_eq!(sketch.paths.len(), 1);
    assert!(noted(&sketch, "into themselves") && noted(&sketch, "not in the file"), "{:?}", sketch.notes);
    // Thirty times two of the one before: a thousand million.
    let bomb: String = (0..30).map(|k| format!("0 BLOCK 2 B{} 0 INSERT 2 B{k} 0 INSERT 2 B{k} 0 ENDBLK ", k + 1)).collect();
    let drawn = |blocks, entities| Drawing::read(file("", "", blocks, entities).as_bytes()).unwrap().sketch(1 << 20);
    let too_large = drawn(&bomb, "0 INSERT 2 B30");
    assert!(matches!(too_large, Err(PlanFileError::DrawingTooLarge { .. })), "{too_large:?}");
    let array = drawn(DOOR, "0 INSERT 2 Door 70 32767 71 32767");
    assert!(matches!(array, Err(PlanFileError::DrawingTooLarge { .. })), "{array:?}");
}

#[test]
fn what_is_not_shown_is_left_out() {
    let tables = "0 TABLE 2 LAYER 0 LAYER 2 OFF 62 -3 70 0 0 LAYER 2 ICE 62 3 70 1 0 ENDTAB";
    let hidden = format!("{LINE} 0 LINE 8 off 10 1 11 2 0 LINE 8 ICE 10 1 11 2 0 LINE 60 1 10 1 11 2 0 LINE 67 1 10 1 11 2");
    let inserts = "0 INSERT 8 OFF 2 Door 0 INSERT 8 ICE 2 Door";
    let sketch = read(file("", tables, DOOR, &format!("{hidden} {inserts}")).as_bytes()).unwrap();
    let layers: Vec<&str> = sketch.paths.iter().map(|p| p.layer.as_str()).collect();
    // Of what is inserted on a layer that is off, only what lies on that layer too is hidden.
    assert_eq!(layers, ["A-WALL", "LEAF/Door"]);
    for words in ["4 objects on layers that are off or frozen are left out: OFF, ICE", "1 objects are marked", "1 objects on sheets"] {
        assert!(noted(&sketch, words), "{:?}", sketch.notes);
    }
    let paper = entities("0 LINE 67 1 10 1 20 1 11 2 21 1");
    assert!(paper.paths.len() == 1 && noted(&paper, "the model is empty"), "{:?}", paper.notes);
}

#[test]
fn broken_objects_are_counted_and_the_others_read() {
    let broken = "0 LINE 10 nan 20 0 11 1 21 1 0 LINE 10 1e999 20 0 11 1 21 1 0 LWPOLYLINE 20 3 10 1 0 CIRCLE 10 1e308 20 1e308 40 1e308";
    let sketch = entities(&format!("{LINE} {broken} 0 DIMENSION 2 *D1 0 3DSOLID 0 POLYLINE 70 64 {LINE}"));
    assert_eq!(sketch.paths.len(), 2);
    for words in ["3 objects are broken", "1 lines or texts are infinitely far", "1 3DSOLID, 1 DIMENSION, 1 POLYLINE mesh"] {
        assert!(noted(&sketch, words), "{:?}", sketch.notes);
    }
    let all = file("", "", "", &format!("{LINE} {LINE}"));
    let cut = read(&all.as_bytes()[..all.len() - 25]).unwrap();
    assert!(cut.paths.len() == 1 && noted(&cut, "cut off"), "{:?}", cut.notes);
}

#[test]
fn other_files_are_refused_with_what_to_do() {
    let why = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(why(b"AC1027\0\0\0\0").contains("ODA File Converter"));
    assert!(why(b"").contains("no section"));
    assert!(why(b"%PDF-1.7\nhello\n").contains("no section"));
    assert!(why(file("", "", "", "").as_bytes()).contains("none of its 0 objects"));
    assert!(is_one(LINE_FILE.as_bytes()) && is_one(pairs::SENTINEL) && is_one(b"\xef\xbb\xbf  0\nSECTION\n"));
    for other in ["", "0", "0\nLINE\n", "0,0,4,0\n4,0,4,3\n", "AC1027\0", "{}"] {
        assert!(!is_one(other.as_bytes()), "{other}");
    }
    assert!(is_dwg(b"AC1015\0\0") && is_dwg(b"AC2.10\0") && !is_dwg(b"AC1015 is a release") && !is_dwg(b"AC"));
}

const LINE_FILE: &str = "999\r\nmade by hand\r\n  0\r\nSECTION\r\n  2\r\nENTITIES\r\n  0\r\nEOF\r\n";

#[test]
fn binary_files_say_the_same() {
    let mut binary = pairs::SENTINEL.to_vec();
    let mut add = |code: u8, value: &[u8]| binary.extend([code, 0].iter().chain(value));
    add(0, b"SECTION\0");
    add(2, b"ENTITIES\0");
    add(0, b"LINE\0");
    add(8, b"A-WALL\0");
    for (code, value) in [(10, 1.0f64), (20, 2.0), (11, 4.0), (21, 2.0)] {
        add(code, &value.to_le_bytes());
    }
    add(0, b"ENDSEC\0");
    add(0, b"EOF\0");
    assert_eq!(read(&binary).unwrap(), entities(LINE));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn nothing_that_a_file_says_is_a_panic(
        words in prop::collection::vec(
            prop_oneof![
                prop::sample::select(vec![
                    "LINE", "ARC", "INSERT", "POLYLINE", "VERTEX", "ATTRIB", "SPLINE", "HATCH", "MTEXT", "TEXT", "ELLIPSE", "SOLID",
                    "LWPOLYLINE", "BLOCK", "ENDBLK", "ENDSEC", "SECTION", "SEQEND", "EOF",
                ]).prop_map(|kind| format!("0 {kind}")),
                (prop::sample::select(vec![1, 2, 8, 10, 11, 20, 40, 41, 42, 50, 62, 66, 70, 71, 72, 73, 91, 92, 93, 210, 230]), -3i32..9)
                    .prop_map(|(code, value)| format!("{code} {value}")),
            ],
            0..200,
        ),
    ) {
        let text = words.join(" ");
        if let Ok(sketch) = read(file("", "", &text, &text).as_bytes()) {
            prop_assert!(sketch.paths.iter().all(|path| path.points.len() >= 2));
            prop_assert!(sketch.paths.iter().flat_map(|path| &path.points).flatten().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn more_entities_than_any_floor_has_are_refused() {
    let crowd = file("", "", "", &"0 POINT ".repeat(OBJECTS_LIMIT + 1));
    let refused = read(crowd.as_bytes());
    assert!(matches!(refused, Err(PlanFileError::DrawingTooLarge { .. })), "{:?}", refused.map(|sketch| sketch.notes));
}
