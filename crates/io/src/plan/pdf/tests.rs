use super::*;
use crate::raster::RasterError;
use std::fmt::Write as _;

/// A file of these objects, numbered from 1: the first is the catalogue, the second the pages.
fn pdf(objects: &[Vec<u8>]) -> Vec<u8> {
    let mut file = b"%PDF-1.7\n".to_vec();
    let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for (number, object) in (1..).zip(objects) {
        let _ = writeln!(table, "{:010} 00000 n ", file.len());
        file.extend(format!("{number} 0 obj\n").bytes());
        file.extend(object);
        file.extend(b"\nendobj\n");
    }
    let start = file.len();
    file.extend(table.bytes());
    file.extend(format!("trailer\n<</Size {}/Root 1 0 R>>\nstartxref\n{start}\n%%EOF\n", objects.len() + 1).bytes());
    file
}

fn stream(head: &str, data: &[u8]) -> Vec<u8> {
    [format!("<<{head}/Length {}>>\nstream\n", data.len()).as_bytes(), data, b"\nendstream"].concat()
}

/// Pages of 200 × 100 pt with these contents; `page` goes into their dictionaries, `more` are objects 10, 11 …
fn pages(contents: &[&str], page: &str, catalogue: &str, more: &[Vec<u8>]) -> Vec<u8> {
    let at = |i: usize| 10 + more.len() + 2 * i;
    let kids: String = (0..contents.len()).map(|i| format!("{} 0 R ", at(i))).collect();
    let mut objects = vec![
        format!("<</Type/Catalog/Pages 2 0 R{catalogue}>>").into_bytes(),
        format!("<</Type/Pages/Kids[{kids}]/Count {}>>", contents.len()).into_bytes(),
    ];
    objects.resize(9, b"null".to_vec());
    objects.extend(more.iter().cloned());
    for (i, content) in contents.iter().enumerate() {
        objects.push(format!("<</Type/Page/Parent 2 0 R/MediaBox[0 0 200 100]/Contents {} 0 R{page}>>", at(i) + 1).into_bytes());
        objects.push(stream("", content.as_bytes()));
    }
    pdf(&objects)
}

fn drawing(file: Vec<u8>) -> Sketch {
    match read(file, None).unwrap() {
        PdfPage::Drawing(sketch) => sketch,
        PdfPage::Scan { notes, .. } => panic!("{notes:?}"),
    }
}

fn drawn(content: &str) -> Sketch {
    drawing(pages(&[content], "", "", &[]))
}

fn error(file: Vec<u8>) -> String {
    read(file, None).unwrap_err().to_string()
}

fn near(points: &[SketchPoint], wanted: &[SketchPoint]) -> bool {
    points.len() == wanted.len() && points.iter().zip(wanted).all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9)
}

#[test]
fn lines_and_areas_keep_their_looks() {
    let sketch =
        drawn("1 0 0 RG 2 w [3] 0 d 10 10 m 90 10 l S q 0.5 0 0 0.5 0 0 cm [] 0 d 0 1 0 rg 20 20 40 60 re B Q 0 0 m 50 0 50 50 0 50 c h f");
    let [line, area, curve] = &sketch.paths[..] else { panic!("{:?}", sketch.paths) };
    assert_eq!(line.points, [[10.0, 10.0], [90.0, 10.0]]);
    assert_eq!((line.stroke, line.width, line.dashed, line.closed, line.fill), (Some([255, 0, 0]), 2.0, true, false, None));
    assert!(near(&area.points, &[[10.0, 10.0], [30.0, 10.0], [30.0, 40.0], [10.0, 40.0]]), "{:?}", area.points);
    assert_eq!((area.stroke, area.width, area.dashed, area.closed, area.fill), (Some([255, 0, 0]), 1.0, false, true, Some([0, 255, 0])));
    assert!(curve.curved && curve.closed && curve.fill == Some([0; 3]) && curve.stroke.is_none());
    assert_eq!([line.group, area.group, curve.group], [0, 1, 2]);
    assert_eq!((sketch.metres_per_unit, sketch.notes), (None, Vec::new()));
}

#[test]
fn the_page_is_as_it_is_shown() {
    let line = ["30 20 m 60 20 l S"];
    let points = |page: &str| drawing(pages(&line, page, "", &[])).paths[0].points.clone();
    assert!(near(&points("/CropBox[20 10 120 60]"), &[[10.0, 10.0], [40.0, 10.0]]));
    // Turned clockwise: what was left is on top.
    assert!(near(&points("/Rotate 90"), &[[20.0, 170.0], [20.0, 140.0]]), "{:?}", points("/Rotate 90"));
    assert!(near(&points("/Rotate 180"), &[[170.0, 80.0], [140.0, 80.0]]));
    assert!(near(&points("/Rotate -90"), &[[80.0, 30.0], [80.0, 60.0]]), "{:?}", points("/Rotate -90"));
    assert!(near(&points("/UserUnit 10"), &[[300.0, 200.0], [600.0, 200.0]]));
    // What leaves the crop box is not shown.
    assert!(near(&points("/CropBox[20 10 50 60]"), &[[10.0, 10.0], [30.0, 10.0]]));
}

#[test]
fn clips_cut_and_faint_things_are_hidden() {
    let state = "/Resources<</ExtGState<</G<</CA 0/ca 0>>>>>>";
    let content = "q 10 0 20 100 re W n 0 50 m 100 50 l S 50 50 m 100 50 l S Q /G gs 0 10 m 9 10 l S";
    let sketch = drawing(pages(&[content], state, "", &[]));
    assert_eq!(sketch.paths.len(), 1);
    assert!(near(&sketch.paths[0].points, &[[10.0, 50.0], [30.0, 50.0]]));
}

#[test]
fn content_groups_are_layers_and_those_switched_off_are_left_out() {
    let more =
        [b"<</Type/OCG/Name(A-WALL)>>".to_vec(), b"<</Type/OCG/Name<FEFF0054006f0072>>>".to_vec(), b"<</Type/OCG/Name(Off)>>".to_vec()];
    let page = "/Resources<</Properties<</W 10 0 R/T 11 0 R/O 12 0 R>>>>";
    let catalogue = "/OCProperties<</OCGs[10 0 R 11 0 R 12 0 R]/D<</OFF[12 0 R]>>>>";
    let content =
        "/OC /W BDC 0 0 m 9 0 l S /Span BMC /OC /T BDC 0 1 m 9 1 l S EMC EMC EMC /OC /O BDC 0 2 m 9 2 l S EMC 0 3 m 9 3 l S EMC EMC";
    let sketch = drawing(pages(&[content], page, catalogue, &more));
    let layers: Vec<&str> = sketch.paths.iter().map(|p| p.layer.as_str()).collect();
    assert_eq!(layers, ["A-WALL", "A-WALL/Tor", ""]);
}

#[test]
fn letters_are_texts() {
    let font = "/Resources<</Font<</F<</Type/Font/Subtype/Type1/BaseFont/Helvetica/Encoding/WinAnsiEncoding>>>>>>";
    let content =
        "0 0 m 9 0 l S BT /F 10 Tf 20 30 Td (Scale) Tj ( 1:100) Tj 0 20 Td [(K) -50 (\\374che)] TJ 0 1 -1 0 150 10 Tm (Lift) Tj ET";
    let sketch = drawing(pages(&[content], font, "", &[]));
    let texts: Vec<_> = sketch.texts.iter().map(|t| (t.text.as_str(), t.at)).collect();
    assert_eq!(texts, [("Scale 1:100", [20.0, 30.0]), ("K\u{fc}che", [20.0, 50.0]), ("Lift", [150.0, 10.0])]);
    assert!((sketch.texts[0].height - 7.0).abs() < 1e-6, "{}", sketch.texts[0].height);
}

#[test]
fn only_a_measure_tells_metres() {
    let viewport = |unit: &str, per_point: f64| format!("<</Measure<</Subtype/RL/X[<</U({unit})/C {per_point}>>]>>>>");
    let scale = |viewports: String| drawing(pages(&["0 0 m 9 0 l S"], &format!("/VP[{viewports}]"), "", &[])).metres_per_unit;
    // 1:100: a point is 0.3528 mm of paper.
    assert!((scale(viewport("mm", 35.28)).unwrap() - 0.03528).abs() < 1e-12);
    assert!((scale(viewport("ft", 0.115_75)).unwrap() - 0.035_28).abs() < 1e-5);
    assert_eq!(scale(viewport("mm", 35.28) + &viewport("mm", 70.56)), None);
    assert_eq!(scale(viewport("cubits", 1.0) + &viewport("m", -1.0)), None);
}

#[test]
fn a_page_of_one_picture_is_a_scan() {
    // 4 × 2 pixels, the top left one black, over the left half of the page's middle.
    let picture = stream(
        "/Type/XObject/Subtype/Image/Width 4/Height 2/BitsPerComponent 8/ColorSpace/DeviceGray",
        &[0, 250, 250, 250, 250, 250, 250, 90],
    );
    let resources = "/Resources<</XObject<</P 10 0 R>>/Font<</F<</Type/Font/Subtype/Type1/BaseFont/Helvetica>>>>>>";
    let content = "q 100 0 0 50 0 50 cm /P Do Q 0 0 m 9 0 l S BT /F 8 Tf 50 20 Td (1:50) Tj ET";
    let found = read(pages(&[content], resources, "", std::slice::from_ref(&picture)), None).unwrap();
    // A quarter of the page is too little for a scan, where there is a line too.
    assert!(matches!(found, PdfPage::Drawing(sketch) if sketch.notes == ["1 bitmaps in the PDF are not read"]));
    let content = content.replace("50 cm", "0 cm").replace("100 0 0 50", "200 0 0 100");
    let found = read(pages(&[&content], resources, "", std::slice::from_ref(&picture)), None).unwrap();
    let PdfPage::Scan { luma, page_pt, texts, notes } = found else { panic!("{found:?}") };
    assert_eq!((luma.width(), luma.height(), luma.data(), page_pt), (4, 2, &[0, 250, 250, 250, 250, 250, 250, 90][..], [200.0, 100.0]));
    assert_eq!((texts[0].text.as_str(), notes.len()), ("1:50", 2));
    // Upright where the page is turned.
    let turned = read(pages(&[&content], &format!("{resources}/Rotate 90"), "", &[picture]), None).unwrap();
    let PdfPage::Scan { luma, page_pt, .. } = turned else { panic!("{turned:?}") };
    assert_eq!((luma.width(), luma.height(), luma.data(), page_pt), (2, 4, &[250, 0, 250, 250, 250, 250, 90, 250][..], [100.0, 200.0]));
}

#[test]
fn a_scan_in_strips_and_bits_is_put_together() {
    // One bit a pixel, painted in red where it is 0; two strips of 8 × 1.
    let strip = |bits: u8| stream("/Type/XObject/Subtype/Image/ImageMask true/Width 8/Height 1/BitsPerComponent 1", &[bits]);
    let content = "1 0 0 rg q 200 0 0 50 0 50 cm /A Do Q q 200 0 0 50 0 0 cm /B Do Q";
    let found =
        read(pages(&[content], "/Resources<</XObject<</A 10 0 R/B 11 0 R>>>>", "", &[strip(0b0111_1111), strip(0b1111_1110)]), None)
            .unwrap();
    let PdfPage::Scan { luma, .. } = found else { panic!("{found:?}") };
    assert_eq!((luma.width(), luma.height()), (8, 4));
    let dark: Vec<usize> = (0..32).filter(|i| luma.data()[*i] == 76).collect();
    assert_eq!(dark, [0, 8, 23, 31]);
    assert!(luma.data().iter().all(|v| matches!(v, 76 | 255)));
}

#[test]
fn a_huge_picture_is_refused_before_memory_is_taken() {
    let jpeg = [0xff, 0xd8, 0xff, 0xe0, 0, 4, 0, 0, 0xff, 0xc0, 0, 17, 8, 0xff, 0xff, 0xff, 0xff];
    for (head, data) in [
        ("/Width 90000/Height 90000/BitsPerComponent 1", &b"x"[..]),
        ("/Width 8/Height 9999/BitsPerComponent 1/Filter/CCITTFaxDecode/DecodeParms<</K -1/Columns 99999999999>>", b"x"),
        ("/Width 8/Height 8/BitsPerComponent 8/SMask 11 0 R", b"x"),
        ("/Width 8/Height 8/BitsPerComponent 8/Filter/DCTDecode", &jpeg),
    ] {
        let picture = stream(&format!("/Type/XObject/Subtype/Image/ColorSpace/DeviceGray{head}"), data);
        let mask = stream("/Type/XObject/Subtype/Image/Width 90000/Height 90000", b"x");
        let file = pages(&["200 0 0 100 0 0 cm /P Do"], "/Resources<</XObject<</P 10 0 R>>>>", "", &[picture, mask]);
        assert!(matches!(read(file, None), Err(PlanFileError::Raster(RasterError::TooLarge { .. }))), "{head}");
    }
}

#[test]
fn pages_are_counted_from_one() {
    let file = || pages(&["", "0 0 m 9 0 l S", "0 0 m 9 9 l S"], "", "", &[]);
    let notes = |page| match read(file(), page).unwrap() {
        PdfPage::Drawing(sketch) => sketch.notes,
        PdfPage::Scan { .. } => panic!("a scan"),
    };
    assert_eq!(notes(None), ["page 2 of 3, the first with anything drawn on it"]);
    assert_eq!(notes(Some(3)), ["page 3 of 3"]);
    for page in [0, 4, usize::MAX] {
        assert!(matches!(read(file(), Some(page)), Err(PlanFileError::NoPage { pages: 3, .. })));
    }
    assert!(read(file(), Some(1)).unwrap_err().to_string().contains("page 1 of 3 does not have a line"));
}

#[test]
fn what_is_no_pdf_or_shows_nothing_is_refused_with_a_remedy() {
    for file in [&b""[..], b"%PDF-1.7\n", b"0,0,4,0\n", &[0xff; 5000]] {
        assert!(error(file.to_vec()).contains("print it into a new PDF"), "{}", error(file.to_vec()));
    }
    assert!(error(pages(&["", "BT ET"], "", "", &[])).contains("none of its 2 pages"));
    let whole = pages(&["0 0 m 9 0 l S"], "", "", &[]);
    // Cut off anywhere: an answer or an error, but an end.
    for end in 0..whole.len() {
        let _ = read(whole[..end].to_vec(), None);
    }
}

#[test]
fn locked_files_say_so() {
    let objects = pages(&["0 0 m 9 0 l S"], "", "", &[]);
    let text = String::from_utf8(objects).unwrap();
    let key = "00".repeat(32);
    let lock = format!("/Encrypt<</Filter/Standard/V 2/R 3/Length 128/P -44/O<{key}>/U<{key}>>>/ID[<00><00>]/Root 1 0 R");
    assert!(error(text.replace("/Root 1 0 R", &lock).into_bytes()).contains("locked by a password"));
}

#[test]
fn forms_that_draw_themselves_end() {
    let form = |n: usize, content: &str| {
        let resources = format!("/Resources<</XObject<</N {n} 0 R>>>>");
        stream(&format!("/Type/XObject/Subtype/Form/BBox[0 0 200 100]{resources}"), content.as_bytes())
    };
    let page = "/Resources<</XObject<</N 10 0 R>>>>";
    let own = drawing(pages(&["0 0 m 9 0 l S /N Do"], page, "", &[form(10, "0 1 m 9 1 l S /N Do")]));
    assert!((2..200).contains(&own.paths.len()), "{}", own.paths.len());
    // Ten of ten of ten …
    let bomb: Vec<_> = (0..12).map(|i| form(11 + i, &"/N Do ".repeat(10))).chain([form(9, "")]).collect();
    assert!(error(pages(&["/N Do"], page, "", &bomb)).contains("does one draw itself"));
}

#[test]
fn gigantic_and_broken_content_is_bounded() {
    let zigzag: String = (0..MOST_POINTS_AND_ONE).map(|i| if i == 0 { "0 0 m " } else { "9 9 l 0 0 l " }).collect();
    assert!(error(pages(&[&(zigzag + "S")], "", "", &[])).contains("more than 5000000 points"));
    let nested = format!("{}0 0 m 9 0 l S{}", "q ".repeat(200_000), " Q".repeat(200_000));
    assert_eq!(drawn(&nested).paths.len(), 1);
    let odd = "0 0 m 99999999999999999999999999999999999999999 0 l S 1e999 nan m 5 5 l S /None Do /None gs BT /No 1e38 Tf (x) Tj ET 9 l S Q Q Q EMC 0 0 0 0 0 0 cm 0 0 m 9 9 l S";
    assert!(drawn(&format!("0 0 m 9 0 l S {odd}")).paths.iter().flat_map(|p| &p.points).flatten().all(|v| v.is_finite()));
    let deep = format!("0 0 m 9 0 l S {} TJ", "[".repeat(100_000));
    assert_eq!(drawn(&deep).paths.len(), 1);
}

/// One over the drafter's limit, two a step.
const MOST_POINTS_AND_ONE: usize = 2_500_002;

#[test]
fn packed_bombs_are_found_before_they_are_unpacked() {
    use std::io::Write;
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let zeros = vec![b' '; 1 << 24];
    for _ in 0..(LONGEST_STREAM >> 24) + 1 {
        packer.write_all(&zeros).unwrap();
    }
    let packed = packer.finish().unwrap();
    let mut file = pages(&["0 0 m 9 0 l S"], "", "", &[stream("/Filter/FlateDecode", &packed)]);
    file.extend(vec![b' '; 2 << 20]);
    assert!(error(file).contains("over 1536 MB when unpacked"));
}

#[test]
fn a_picture_squeezed_flat_makes_no_paper_of_millions() {
    // 8 × 8 px on a thousandth of a point's height: paper of its shorter side would be 50 million times as fine.
    let picture = stream("/Type/XObject/Subtype/Image/Width 8/Height 8/BitsPerComponent 8/ColorSpace/DeviceGray", &[0; 64]);
    let file = pages(&["200 0 0 0.001 0 50 cm /I Do"], "/Resources<</XObject<</I 10 0 R>>>>", "", &[picture]);
    match read(file, None) {
        Ok(PdfPage::Scan { luma, .. }) => {
            assert!(luma.data().len() <= super::paint::FEWEST_PAPER as usize + 10_000, "{}", luma.data().len())
        }
        Ok(PdfPage::Drawing(sketch)) => panic!("{:?}", sketch.notes),
        Err(why) => assert!(matches!(why, PlanFileError::NothingDrawn { .. }), "{why}"),
    }
}

#[test]
fn pages_that_lead_in_circles_end() {
    let page = b"<</Type/Page/Parent 2 0 R/MediaBox[0 0 200 100]/Contents 4 0 R>>".to_vec();
    let content = stream("", b"0 0 m 9 0 l S");
    for kids in ["2 0 R", "3 0 R 2 0 R", "5 0 R 3 0 R"] {
        let tree = format!("<</Type/Pages/Parent 2 0 R/Kids[{kids}]/Count 3>>").into_bytes();
        let other = b"<</Type/Pages/Parent 2 0 R/Kids[2 0 R 5 0 R]/Count 2>>".to_vec();
        let read = read(pdf(&[b"<</Type/Catalog/Pages 2 0 R>>".to_vec(), tree, page.clone(), content.clone(), other]), None);
        assert!(read.is_ok() || read.is_err_and(|why| why.to_string().len() > 30), "{kids}");
    }
}
