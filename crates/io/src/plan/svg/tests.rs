use super::super::drafter;
use super::super::sketch::SketchPoint;
use super::redraft::{DEEPEST, styles_of_groups};
use super::xml::has_far_number;
use super::*;

fn svg(head: &str, body: &str) -> String {
    format!("<svg xmlns=\"{SVG}\" xmlns:xlink=\"{XLINK}\" xmlns:inkscape=\"{INKSCAPE}\" xmlns:v=\"{VISIO}\" {head}>{body}</svg>")
}

/// A drawing of 200 × 100 units.
fn drawn(body: &str) -> Sketch {
    read(&svg("viewBox=\"0 0 200 100\"", body)).unwrap()
}

fn error(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

const LINE: &str = "<path d='M10 10H30' stroke='black'/>";

#[test]
fn y_is_turned_up_and_the_papers_size_is_none_of_the_plans() {
    for head in ["viewBox='0 0 200 100'", "viewBox='0 0 200 100' width='420mm' height='297mm'", "width='200' height='100px'"] {
        let sketch = read(&svg(head, LINE)).unwrap();
        assert_eq!(sketch.paths[0].points, [[10.0, 90.0], [30.0, 90.0]], "{head}");
        assert_eq!((sketch.metres_per_unit, sketch.notes.len()), (None, 0), "{head}");
    }
    let shifted = read(&svg("viewBox='-50 5 200 100'", LINE)).unwrap();
    assert_eq!(shifted.paths[0].points, [[60.0, 95.0], [80.0, 95.0]]);
}

#[test]
fn without_a_size_what_is_drawn_gives_the_origin() {
    for head in ["", "viewBox='0 0 0 0'", "viewBox='a b' width='100%'", "viewBox='0 0 nan 5'", "width='-3' height='0'"] {
        let sketch = read(&svg(head, "<path d='M10 10V30H50' stroke='black' fill='none'/>")).unwrap();
        assert_eq!(sketch.paths[0].points, [[0.0, 20.0], [0.0, 0.0], [40.0, 0.0]], "{head}");
        assert!(sketch.notes[0].contains("neither a valid viewBox nor a size"), "{head}");
    }
}

#[test]
fn transforms_copies_and_symbols_are_applied() {
    let sketch = drawn(
        "<defs><symbol id='door' viewBox='0 0 10 10'><line id='leaf' x2='10' stroke='#f00'/></symbol><g id='w'><path d='M0 0H5' stroke='#000'/></g></defs>
         <g id='A-DOOR' transform='translate(100 0) scale(2)'><use xlink:href='#door' x='5' y='5' width='20' height='20'/></g>
         <use href='#w' x='7' transform='rotate(90)'/>",
    );
    let [door, wall] = &sketch.paths[..] else { panic!("{:?}", sketch.paths) };
    assert_eq!(door.points, [[110.0, 90.0], [150.0, 90.0]]);
    assert_eq!((door.stroke, door.layer.as_str(), door.width), (Some([255, 0, 0]), "A-DOOR/door/leaf", 4.0));
    let near = |a: SketchPoint, b: SketchPoint| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-4;
    assert!(near(wall.points[0], [0.0, 93.0]) && near(wall.points[1], [0.0, 88.0]), "{:?}", wall.points);
    assert_eq!((wall.layer.as_str(), door.group, wall.group), ("w", 0, 1));
}

#[test]
fn layers_have_labels_classes_and_titles() {
    let sketch = drawn(
        "<style>.st1 { stroke: #00ff00; stroke-width: 3; stroke-dasharray: 4 } #odd { fill: #0000ff }</style>
         <g id='layer1' inkscape:label='Walls' inkscape:groupmode='layer'>
           <g class='a b'><title>Exterior wall.12</title><path id='p1' class='st1' fill='none' d='M0 0H9'/></g>
         </g><rect id='odd' width='9' height='9'/>",
    );
    let [wall, odd] = &sketch.paths[..] else { panic!("{:?}", sketch.paths) };
    assert_eq!(wall.layer, "Walls/a/b/Exterior wall.12/p1/st1");
    assert_eq!((wall.stroke, wall.width, wall.dashed, wall.fill), (Some([0, 255, 0]), 3.0, true, None));
    assert_eq!((odd.layer.as_str(), odd.fill, odd.closed, odd.points.len()), ("odd", Some([0, 0, 255]), true, 4));
}

#[test]
fn hidden_things_are_left_out_and_clips_cut() {
    let sketch = drawn(
        "<style>.off { display: none }</style><clipPath id='c'><rect x='10' width='20' height='100'/></clipPath>
         <g style='display:none'><path d='M0 0H9' stroke='red'/></g><path class='off' d='M0 0H9' stroke='red'/>
         <g visibility='hidden'><path d='M0 0H9' stroke='red'/></g><g opacity='0'><path d='M0 0H9' stroke='red'/></g>
         <path d='M0 0H9' stroke='red' stroke-opacity='0'/><path d='M0 0h9v9z' fill='none'/><text class='off'>no</text>
         <g clip-path='url(#c)'><path d='M0 50H100' stroke='black'/><path d='M50 50H100' stroke='red'/></g>",
    );
    assert_eq!((sketch.paths.len(), sketch.texts.len()), (1, 0));
    assert_eq!(sketch.paths[0].points, [[10.0, 50.0], [30.0, 50.0]]);
    assert!(sketch.notes[0].starts_with("1 shapes without fill and stroke"), "{:?}", sketch.notes);
}

#[test]
fn what_usvg_would_drop_or_cannot_show_is_drawn() {
    let sketch = drawn(
        "<defs><pattern id='hatch' width='1' height='1'><path d='M0 0H1' stroke='url(#hatch)'/></pattern>
           <linearGradient id='g'><stop stop-color='#102030'/><stop offset='1'/></linearGradient></defs>
         <rect width='9' height='9' fill='url(#hatch)'/><rect width='9' height='9' fill='url(#g)'/>
         <path d='M0 0H9' stroke='#000' style='filter:url(#gone);mask:url(#m);marker-end:url(#m)'/>
         <g clip-path='url(#t)'><clipPath id='t'><text>A</text></clipPath><path d='M0 0H9' stroke='#000'/></g>
         <image href='data:image/png;base64,AAAA' width='5' height='5'/>",
    );
    let fills: Vec<_> = sketch.paths.iter().map(|p| p.fill).collect();
    assert_eq!(fills, [Some([128; 3]), Some([16, 32, 48]), None, None]);
    assert_eq!(sketch.notes, ["1 bitmaps in the SVG are not read"]);
}

#[test]
fn arcs_are_curves_and_an_outline_with_its_hole_is_one_group() {
    let sketch = drawn("<path d='M0 0H90V90H0ZM10 10H20V20H10Z'/><path d='M0 0A50 50 0 0 1 50 50' fill='none' stroke='#000'/>");
    let looks: Vec<_> = sketch.paths.iter().map(|p| (p.group, p.closed, p.curved)).collect();
    assert_eq!(looks, [(0, true, false), (0, true, false), (1, false, true)]);
    for pair in sketch.paths[2].points.windows(2) {
        let middle = [0, 1].map(|k| (pair[0][k] + pair[1][k]) / 2.0);
        let off = 50.0 - middle[0].hypot(middle[1] - 50.0);
        // A curve's chords, and the curve that stands for the arc (0.03 % of its radius).
        assert!(off.abs() < 200.0 * drafter::CHORD_ERROR + 0.015, "{off}");
    }
}

#[test]
fn texts_are_where_their_groups_put_them() {
    let sketch = drawn(
        "<path d='M0 0H9' stroke='red'/><style>.small { font-size: 5px } text { font-size: 10px }</style>
         <g id='Rooms' transform='translate(20 0) scale(2)'><text id='t' x='10' y='20' class='small'>Room
           <tspan>12</tspan><tspan x='10' dy='1.2em'>Store</tspan></text></g>
         <text x='100' y='50' text-anchor='middle'>Lift</text><text x='1' y='2'> </text>",
    );
    let [room, store, lift] = &sketch.texts[..] else { panic!("{:?}", sketch.texts) };
    assert_eq!((room.text.as_str(), room.at, room.layer.as_str()), ("Room 12", [40.0, 60.0], "Rooms/t/small"));
    assert_eq!(room.height, 10.0 * 0.7);
    assert!(store.text == "Store" && store.at[0] == 40.0 && (store.at[1] - 48.0).abs() < 1e-4, "{store:?}");
    assert!(lift.text == "Lift" && (lift.at[0] - 92.0).abs() < 1.0, "{lift:?}");
}

#[test]
fn only_visios_drawing_scale_is_a_scale() {
    let page = |drawing: f64| {
        let page = format!("<g><v:pageProperties v:drawingScale='{drawing}' v:pageScale='0.0393701'/>{LINE}</g>");
        read(&svg("width='8.5in' height='11in' viewBox='0 0 612 792'", &page)).unwrap().metres_per_unit
    };
    // 1:50, with 72 units an inch.
    assert!((page(1.968_505).unwrap() - 50.0 * 0.0254 / 72.0).abs() < 1e-9);
    assert_eq!(page(0.0393701), None);
}

#[test]
fn what_is_no_svg_or_shows_nothing_is_refused_with_a_remedy() {
    assert!(error("").contains("cannot be read"));
    assert!(error("<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0").contains("save it as plain SVG"));
    assert!(error("<html><body/></html>").contains("<html>"));
    assert!(error(&svg("", "")).contains("is it empty"));
    assert!(error(&svg("", "<image href='plan.png'/>")).contains("1 bitmaps"));
    assert!(error(&svg("", "<path d='M0 0h9v9z' fill='none'/>")).contains("1 shapes have neither"));
}

#[test]
fn coordinates_that_are_no_numbers_are_left_out() {
    let sketch = drawn(
        "<path d='M0 0H9' stroke='#000'/><path d='M0 0L1e999 5L9 9' stroke='#000'/><path d='M0 0Lnan 5' stroke='#000'/>
         <rect width='nan' height='5'/><circle r='inf'/><g transform='scale(0)'><rect width='5' height='5'/></g>
         <g transform='scale(1e30)'><g transform='scale(1e30)'><rect width='5' height='5'/></g></g>",
    );
    assert!(sketch.paths.iter().flat_map(|p| &p.points).flatten().all(|v| v.is_finite()));
    assert_eq!(sketch.paths[0].points, [[0.0, 100.0], [9.0, 100.0]]);
}

#[test]
fn arcs_of_an_astronomical_size_are_left_out() {
    let sketch =
        drawn(&format!("{LINE}<path d='M0 0L11e38 1A1 1 0 0 1 5 5z'/><circle r='1e30'/><rect width='9' height='1E+12' rx='1e11'/>"));
    assert_eq!((sketch.paths.len(), sketch.notes.len()), (1, 1), "{:?}", sketch.notes);
    for far in ["1e9", "M0 0L-1234567890 5", "1.5E+12,3", "00001e38", ".5e10"] {
        assert!(has_far_number(far), "{far}");
    }
    for near in
        ["123456789", "0.12345678901234", "1e8", "1e-30-5", "2em", "M1.5.5-3.000000000001", "0000000000001", "1 2 3 4 5 6 7 8 9 10 11"]
    {
        assert!(!has_far_number(near), "{near}");
    }
}

#[test]
fn links_in_circles_end() {
    let sketch = drawn(&format!(
        "{LINE}<g id='a'><use href='#b'/></g><g id='b'><use href='#a'/></g><use id='c' href='#c'/><symbol id='s'><use href='#s'/>{LINE}</symbol><use href='#s'/>
         <linearGradient id='x' href='#y'/><linearGradient id='y' href='#x'/><rect width='5' height='5' fill='url(#x)'/>
         <clipPath id='k' clip-path='url(#k)'><rect clip-path='url(#k)' width='5' height='5'/></clipPath><rect clip-path='url(#k)' width='5' height='5'/>",
    ));
    assert!(sketch.notes.iter().any(|n| n.contains("hold themselves")), "{:?}", sketch.notes);
}

#[test]
fn bombs_are_refused_in_bounded_time() {
    let deep = format!("{}{LINE}{}", "<g>".repeat(50_000), "</g>".repeat(50_000));
    assert!(error(&svg("", &deep)).contains("nested deeper than 150"));
    // Depth that is allowed does not overflow the stack.
    let allowed = DEEPEST - 1;
    assert_eq!(drawn(&format!("{}{LINE}{}", "<g>".repeat(allowed), "</g>".repeat(allowed))).paths.len(), 1);
    let chain: String = (0..1000).map(|i| format!("<g id='u{i}'><use href='#u{}'/></g>", i + 1)).collect();
    assert!(error(&svg("", &chain)).contains("nested deeper"));

    let copies: String = (0..10).map(|i| format!("<g id='b{}'>{}</g>", i + 1, format!("<use href='#b{i}'/>").repeat(10))).collect();
    assert!(error(&svg("", &format!("<g id='b0'>{LINE}</g>{copies}"))).contains("more than"));

    let laughs: String = (1..10).map(|i| format!("<!ENTITY l{i} \"{}\">", format!("&l{};", i - 1).repeat(10))).collect();
    let bomb = format!("<!DOCTYPE svg [<!ENTITY l0 \"lol\">{laughs}]>{}", svg("", "<text>&l9;</text>"));
    assert!(error(&bomb).contains("cannot be read"));
    let long = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]>{}", "x".repeat(1_000_000), svg("", &"<text>&a;</text>".repeat(1000)));
    assert!(error(&long).contains("entities may grow to 953 MB"), "{}", error(&long));
}

#[test]
fn style_sheets_that_would_take_hours_are_refused() {
    let nested = format!("{}{LINE}{}", "<g>".repeat(100), "</g>".repeat(100));
    assert!(error(&svg("", &format!("<style>g g g g g g rect {{ fill: red }}</style>{nested}"))).contains("too intricate"));
    let rules = ".a{}".repeat(200_000);
    assert!(error(&svg("", &format!("<style>{rules}</style>{}", LINE.repeat(20_000)))).contains("too intricate"));
    let chain: String =
        (0..5000).map(|i| format!("<linearGradient id='g{i}' href='#g{}'/><path d='M{i} 0V9' stroke='url(#g{i})'/>", i + 1)).collect();
    assert_eq!(drawn(&chain).paths.len(), 5000);
}

#[test]
fn entities_of_illustrator_are_fine() {
    let body = svg("viewBox='0 0 200 100'", "<path style=\"&st0;\" d='M10 10H30'/>");
    let text = format!("<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\" \"svg11.dtd\" [<!ENTITY st0 \"stroke:#0f0;\">]>{body}");
    assert_eq!(read(&text).unwrap().paths[0].stroke, Some([0, 255, 0]));
}

#[test]
fn a_million_paths_are_refused() {
    assert!(error(&svg("", &"<path d='M0 0H9'/>".repeat(1_000_000))).contains("more than 500001 elements"));
}

#[test]
fn style_sheets_name_the_groups_that_texts_become() {
    let styles = "text, .text > tspan{text-anchor:middle}#text{}[a=text]{}";
    assert_eq!(styles_of_groups(styles), "a, .text > .was-tspan{text-anchor:middle}#text{}[a=text]{}");
}
