//! What do the largest files that are still read cost? Seconds and memory of `planwalk plan info`, for a file at each limit of each reader.
//!
//! case ─▶ a file at the limit, written to a folder ─▶ `planwalk plan info`, a process each ─▶ a table in Markdown
//!
//! The files hold as much as the limit admits of what costs most; the names of the cases say which limit. Files are removed when they
//! have been read: together they are some gigabytes.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::sheet;

/// A reader that takes longer is ended.
const PATIENCE: Duration = Duration::from_secs(600);
/// Columns of everything that is drawn in rows: nothing lies on anything else.
const COLUMNS: usize = 2000;

type Written = std::io::Result<()>;

/// A file at a limit.
struct Case {
    name: &'static str,
    file: &'static str,
    options: &'static [&'static str],
    write: fn(&mut dyn Write) -> Written,
}

const CENTIMETRE: &[&str] = &["--metres-per-pixel", "0.01"];
const ON_PAPER: &[&str] = &["--drawing-scale", "100"];

/// All of them.
const CASES: &[Case] = &[
    Case {
        name: "PNG, grey, 500 megapixels",
        file: "grey.png",
        options: CENTIMETRE,
        write: |to| picture(to, 22_360, image::ColorType::L8),
    },
    Case {
        name: "PNG, RGBA, 500 megapixels",
        file: "rgba.png",
        options: CENTIMETRE,
        write: |to| picture(to, 22_360, image::ColorType::Rgba8),
    },
    Case {
        name: "PNG, RGBA of 16 bits, 500 megapixels",
        file: "deep.png",
        options: CENTIMETRE,
        write: |to| picture(to, 22_360, image::ColorType::Rgba16),
    },
    Case { name: "PGM of dots, 16 megapixels: too many corners", file: "dots.pgm", options: CENTIMETRE, write: dots },
    Case { name: "DXF, 990,000 lines", file: "fewer.dxf", options: &[], write: |to| dxf_lines(to, 990_000) },
    Case { name: "DXF, 3 million lines: refused", file: "lines.dxf", options: &[], write: |to| dxf_lines(to, 3_000_000) },
    Case { name: "DXF, blocks of blocks, 8 to the 32nd", file: "blocks.dxf", options: &[], write: dxf_blocks },
    Case { name: "SVG, 500,000 elements", file: "elements.svg", options: &["--metres-per-pixel", "0.1"], write: svg_elements },
    Case { name: "SVG, 1.9 million points", file: "points.svg", options: CENTIMETRE, write: |to| svg_points(to, 1_900_000) },
    Case { name: "SVG, 4.9 million points: refused", file: "more.svg", options: CENTIMETRE, write: |to| svg_points(to, 4_900_000) },
    Case { name: "SVG, 149 deep", file: "deep.svg", options: CENTIMETRE, write: |to| svg_nested(to, 147) },
    Case { name: "SVG, 1,000,000 deep: refused", file: "deeper.svg", options: CENTIMETRE, write: |to| svg_nested(to, 1_000_000) },
    Case { name: "PDF, 1.9 million points", file: "points.pdf", options: ON_PAPER, write: |to| pdf_points(to, 1_900_000) },
    Case { name: "PDF, 4.9 million points: refused", file: "more.pdf", options: ON_PAPER, write: |to| pdf_points(to, 4_900_000) },
    Case { name: "GeoJSON, 999,000 walls", file: "walls.geojson", options: &[], write: |to| geojson(to, 999_000) },
    Case { name: "GeoJSON, numbers without end: refused", file: "numbers.geojson", options: &[], write: json_numbers },
    Case { name: "GeoJSON, one wall of 5 million points", file: "points.geojson", options: &[], write: |to| geojson_line(to, 5_000_000) },
    Case { name: "IMDF, 999,000 units", file: "imdf.zip", options: &[], write: imdf },
    Case { name: "IMDF, 300 MB unpacked: refused", file: "bomb.zip", options: &[], write: imdf_bomb },
    Case { name: "OpenStreetMap, 3 million nodes, 750,000 ways", file: "town.osm", options: &[], write: osm },
    Case { name: "wall list, 1 million walls and one: refused", file: "more.csv", options: &[], write: |to| wall_list(to, 1_000_001) },
    Case { name: "wall list, 1 million walls", file: "walls.csv", options: &[], write: |to| wall_list(to, 1_000_000) },
    Case { name: "plan.json, 999,000 elements", file: "walls.plan.json", options: &[], write: plan_json },
    Case { name: "gzip of 1.1 GiB of text: refused", file: "bomb.csv.gz", options: &[], write: gzip_bomb },
];

/// Writes, reads and measures.
pub fn measure(arguments: &[&str]) -> Result<String, Vec<String>> {
    let (mut folder, mut program, mut only) = (None, PathBuf::from("target/release/planwalk"), None);
    let mut left = arguments.iter();
    while let Some(argument) = left.next() {
        let mut value = || left.next().ok_or_else(|| vec![format!("{argument} needs a value")]);
        match *argument {
            "-o" => folder = Some(PathBuf::from(value()?)),
            "--program" => program = PathBuf::from(value()?),
            "--only" => only = Some(*value()?),
            other => return Err(vec![format!("{other} is not known here: -o DIR, --program FILE, --only PART-OF-A-NAME")]),
        }
    }
    let folder = folder.ok_or_else(|| vec!["say with -o which folder the files may be written to".to_owned()])?;
    std::fs::create_dir_all(&folder).map_err(|why| vec![format!("{}: {why}", folder.display())])?;
    let mut table = "| file | bytes | seconds | peak MB | what was said |\n|---|---|---|---|---|\n".to_owned();
    for case in CASES.iter().filter(|case| only.is_none_or(|part: &str| case.name.contains(part))) {
        let row = case.measured(&folder, &program).map_err(|why| vec![format!("{}: {why}", case.name)])?;
        table.push_str(&row);
    }
    Ok(table)
}

impl Case {
    fn measured(&self, folder: &Path, program: &Path) -> std::io::Result<String> {
        let path = folder.join(self.file);
        let mut to = BufWriter::new(File::create(&path)?);
        (self.write)(&mut to)?;
        to.flush()?;
        drop(to);
        let bytes = std::fs::metadata(&path)?.len();
        let run = sheet::run(Command::new(program).args(["plan", "info"]).args(self.options).arg(&path), PATIENCE);
        std::fs::remove_file(&path)?;
        let said = if run.succeeded { "read".to_owned() } else { last_line(&run.said) };
        let peak = run.peak_mb.map_or("?".to_owned(), |mb| mb.to_string());
        let mut row = String::new();
        let _ = writeln!(row, "| {} | {} | {:.1} | {peak} | {said} |", self.name, in_thousands(bytes), run.seconds);
        Ok(row)
    }
}

fn last_line(said: &str) -> String {
    said.lines().rfind(|line| line.starts_with("error")).or(said.lines().last()).unwrap_or("").replace('|', "/").chars().take(160).collect()
}

fn in_thousands(number: u64) -> String {
    let digits = number.to_string();
    let is_break = |i: usize| i > 0 && (digits.len() - i).is_multiple_of(3);
    digits.chars().enumerate().flat_map(|(i, c)| is_break(i).then_some(',').into_iter().chain([c])).collect()
}

/// Rooms of 5 m, walls of 10 cm, doors of 90 cm.
fn is_wall(u: usize, v: usize) -> bool {
    let is_door = |at: usize| (200..290).contains(&(at % 500));
    (u % 500 < 10 && !is_door(v)) || (v % 500 < 10 && !is_door(u))
}

fn picture(to: &mut dyn Write, side: usize, colour: image::ColorType) -> Written {
    let bytes = usize::from(colour.bytes_per_pixel());
    let mut pixels = vec![255u8; side * side * bytes];
    for (i, pixel) in pixels.chunks_mut(bytes).enumerate().filter(|(i, _)| is_wall(i % side, i / side)) {
        // Half of each sample, and some red: brightness and hue are both looked at.
        let shade = if colour.has_color() && i.is_multiple_of(7) { 200 } else { 20 };
        pixel[..bytes / usize::from(colour.channel_count())].fill(shade);
        let opaque = if colour.has_alpha() { bytes - bytes / 4 } else { bytes };
        pixel[bytes / usize::from(colour.channel_count())..opaque].fill(20);
    }
    use image::ImageEncoder as _;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let encoder = PngEncoder::new_with_quality(to, CompressionType::Fast, FilterType::NoFilter);
    encoder.write_image(&pixels, side as u32, side as u32, colour.into()).map_err(std::io::Error::other)
}

fn dots(to: &mut dyn Write) -> Written {
    write!(to, "P5\n4000 4000\n255\n")?;
    (0..4000).try_for_each(|v| to.write_all(&(0..4000).map(|u: i32| if (u + v) % 2 == 0 { 0 } else { 255 }).collect::<Vec<u8>>()))
}

/// Two ends of the i-th short wall, metres.
fn wall(i: usize) -> [f64; 4] {
    let (x, y) = ((i % COLUMNS) as f64 * 0.8, (i / COLUMNS) as f64 * 0.8);
    if i.is_multiple_of(2) { [x, y, x + 0.6, y] } else { [x, y, x, y + 0.6] }
}

fn dxf_lines(to: &mut dyn Write, count: usize) -> Written {
    write!(to, "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n")?;
    for i in 0..count {
        // Five centimetres apart, so that three million are one floor.
        let [x0, y0, x1, y1] = wall(i).map(|v| v / 0.8);
        write!(to, "0\nLINE\n8\nA\n10\n{x0:.2}\n20\n{y0:.2}\n11\n{x1:.2}\n21\n{y1:.2}\n")?;
    }
    write!(to, "0\nENDSEC\n0\nEOF\n")
}

fn dxf_blocks(to: &mut dyn Write) -> Written {
    write!(to, "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n")?;
    for depth in 0..31 {
        write!(to, "0\nBLOCK\n2\nB{depth}\n10\n0\n20\n0\n")?;
        for k in 0..8 {
            match depth {
                0 => write!(to, "0\nLINE\n8\nA\n10\n{k}\n20\n0\n11\n{k}\n21\n1\n")?,
                _ => write!(to, "0\nINSERT\n8\nA\n2\nB{}\n10\n{}\n20\n0\n", depth - 1, k)?,
            }
        }
        write!(to, "0\nENDBLK\n")?;
    }
    write!(to, "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n8\nA\n2\nB30\n10\n0\n20\n0\n0\nENDSEC\n0\nEOF\n")
}

fn svg(to: &mut dyn Write, drawn: impl FnOnce(&mut dyn Write) -> Written) -> Written {
    write!(to, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 20000 20000\"><g stroke=\"black\" fill=\"none\">")?;
    drawn(to)?;
    write!(to, "</g></svg>")
}

fn svg_elements(to: &mut dyn Write) -> Written {
    svg(to, |to| {
        (0..499_000).try_for_each(|i| {
            let [x0, y0, x1, y1] = wall(i).map(|v| 10.0 * v);
            writeln!(to, "<path d=\"M{x0:.0} {y0:.0}L{x1:.0} {y1:.0}\"/>")
        })
    })
}

fn svg_points(to: &mut dyn Write, count: usize) -> Written {
    svg(to, |to| {
        write!(to, "<path d=\"M0 0")?;
        (0..count).try_for_each(|i| write!(to, "L{} {}", i % 20_000, i / 20_000 * 80 + i % 2 * 40))?;
        write!(to, "\"/>")
    })
}

fn svg_nested(to: &mut dyn Write, depth: usize) -> Written {
    svg(to, |to| {
        (0..depth).try_for_each(|_| write!(to, "<g>"))?;
        write!(to, "<path d=\"M0 0L1000 0L1000 1000L0 1000Z\"/>")?;
        (0..depth).try_for_each(|_| write!(to, "</g>"))
    })
}

fn pdf_points(to: &mut dyn Write, count: usize) -> Written {
    let mut drawn = "1 w 0 0 m\n".to_owned();
    for i in 0..count {
        let _ = writeln!(drawn, "{} {} l", i % 20_000, i / 20_000 * 80 + i % 2 * 40);
    }
    drawn.push_str("S\n");
    let objects = [
        "<</Type/Catalog/Pages 2 0 R>>".to_owned(),
        "<</Type/Pages/Kids[3 0 R]/Count 1>>".to_owned(),
        "<</Type/Page/Parent 2 0 R/MediaBox[0 0 20000 20000]/Contents 4 0 R/Resources<<>>>>".to_owned(),
        format!("<</Length {}>>stream\n{drawn}endstream", drawn.len()),
    ];
    let mut at = write_counted(to, "%PDF-1.4\n")?;
    let mut offsets = Vec::new();
    for (i, object) in objects.iter().enumerate() {
        offsets.push(at);
        at += write_counted(to, &format!("{} 0 obj\n{object}\nendobj\n", i + 1))?;
    }
    write!(to, "xref\n0 5\n0000000000 65535 f \n")?;
    offsets.iter().try_for_each(|offset| writeln!(to, "{offset:010} 00000 n "))?;
    write!(to, "trailer\n<</Size 5/Root 1 0 R>>\nstartxref\n{at}\n%%EOF\n")
}

fn write_counted(to: &mut dyn Write, text: &str) -> std::io::Result<usize> {
    to.write_all(text.as_bytes())?;
    Ok(text.len())
}

fn geojson(to: &mut dyn Write, count: usize) -> Written {
    write!(to, "{{\"type\":\"FeatureCollection\",\"units\":\"m\",\"features\":[")?;
    for i in 0..count {
        let [x0, y0, x1, y1] = wall(i);
        let comma = if i == 0 { "" } else { ",\n" };
        write!(
            to,
            "{comma}{{\"type\":\"Feature\",\"properties\":{{\"type\":\"wall\"}},\
             \"geometry\":{{\"type\":\"LineString\",\"coordinates\":[[{x0:.2},{y0:.2}],[{x1:.2},{y1:.2}]]}}}}"
        )?;
    }
    write!(to, "]}}")
}

fn geojson_line(to: &mut dyn Write, count: usize) -> Written {
    write!(
        to,
        "{{\"type\":\"Feature\",\"units\":\"m\",\"properties\":{{\"type\":\"wall\"}},\"geometry\":{{\"type\":\"LineString\",\"coordinates\":[[0,0]"
    )?;
    (1..count).try_for_each(|i| write!(to, ",[{:.2},{:.2}]", (i % 40_000) as f64 * 0.03, (i / 40_000) as f64 * 2.0 + (i % 2) as f64))?;
    write!(to, "]}}}}")
}

fn json_numbers(to: &mut dyn Write) -> Written {
    write!(to, "{{\"type\":\"Feature\",\"bbox\":[0")?;
    (0..200).try_for_each(|_| to.write_all(&b",1".repeat(1 << 20)))?;
    write!(to, "]}}")
}

/// An archive of one file.
fn archive(to: &mut dyn Write, write: impl FnOnce(&mut dyn Write) -> Written) -> Written {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("unit.geojson", zip::write::SimpleFileOptions::default()).map_err(std::io::Error::other)?;
    write(&mut zip)?;
    to.write_all(zip.finish().map_err(std::io::Error::other)?.get_ref())
}

fn imdf(to: &mut dyn Write) -> Written {
    archive(to, |to| {
        write!(to, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
        for i in 0..999_000 {
            let [x, y] = [(i % COLUMNS) as f64 * 8e-6, (i / COLUMNS) as f64 * 8e-6];
            let feature = format!(
                "{}{{\"type\":\"Feature\",\"feature_type\":\"unit\",\"properties\":{{\"category\":\"room\"}},\"geometry\":{{\"type\":\"Polygon\",\
                 \"coordinates\":[[[{x:.7},{y:.7}],[{:.7},{y:.7}],[{:.7},{:.7}],[{x:.7},{y:.7}]]]}}}}",
                if i == 0 { "" } else { ",\n" },
                x + 6e-6,
                x + 6e-6,
                y + 6e-6
            );
            to.write_all(feature.as_bytes())?;
        }
        write!(to, "]}}")
    })
}

fn imdf_bomb(to: &mut dyn Write) -> Written {
    archive(to, |to| (0..300).try_for_each(|_| to.write_all(&vec![b' '; 1 << 20])))
}

/// Rooms of four nodes each, 750,000 of them.
fn osm(to: &mut dyn Write) -> Written {
    write!(to, "<?xml version=\"1.0\"?><osm version=\"0.6\">")?;
    let rooms = 749_000;
    for i in 0..rooms {
        let [x, y] = [(i % COLUMNS) as f64 * 8e-6, (i / COLUMNS) as f64 * 8e-6];
        for (k, (dx, dy)) in [(0.0, 0.0), (6e-6, 0.0), (6e-6, 6e-6), (0.0, 6e-6)].into_iter().enumerate() {
            writeln!(to, "<node id=\"{}\" lat=\"{:.7}\" lon=\"{:.7}\"/>", 4 * i + k + 1, y + dy, x + dx)?;
        }
    }
    for i in 0..rooms {
        let first = 4 * i + 1;
        write!(to, "<way id=\"{}\">", i + 1)?;
        [first, first + 1, first + 2, first + 3, first].iter().try_for_each(|node| write!(to, "<nd ref=\"{node}\"/>"))?;
        writeln!(to, "<tag k=\"indoor\" v=\"room\"/><tag k=\"level\" v=\"0\"/></way>")?;
    }
    write!(to, "</osm>")
}

fn wall_list(to: &mut dyn Write, count: usize) -> Written {
    writeln!(to, "x0,y0,x1,y1")?;
    (0..count).map(wall).try_for_each(|[x0, y0, x1, y1]| writeln!(to, "{x0:.2},{y0:.2},{x1:.2},{y1:.2}"))
}

fn plan_json(to: &mut dyn Write) -> Written {
    write!(to, "{{\"schema\":\"planwalk-plan/1\",\"levels\":[{{\"name\":\"0\",\"ordinal\":0,\"elements\":[")?;
    for i in 0..999_000 {
        let [x0, y0, x1, y1] = wall(i);
        let comma = if i == 0 { "" } else { ",\n" };
        write!(to, "{comma}{{\"kind\":\"wall\",\"line\":[[{x0:.2},{y0:.2}],[{x1:.2},{y1:.2}]]}}")?;
    }
    write!(to, "]}}]}}")
}

/// Stored zeros would be as large as what they unpack to; a run of one byte repeated by hand is a member of 1 MiB, told 1,100 times.
fn gzip_bomb(to: &mut dyn Write) -> Written {
    let member = gzip_member();
    (0..1100).try_for_each(|_| to.write_all(&member))
}

/// A gzip member of 1 MiB of spaces. The deflate stream is a zip entry's.
fn gzip_member() -> Vec<u8> {
    let spaces = vec![b' '; 1 << 20];
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let entry = zip.start_file("a", options).and_then(|()| Ok(zip.write_all(&spaces)?)).and_then(|()| zip.finish());
    let Ok(zipped) = entry.map(std::io::Cursor::into_inner) else { return Vec::new() };
    let field = |at: usize, length: usize| zipped[at..at + length].iter().rev().fold(0usize, |n, byte| n << 8 | usize::from(*byte));
    // Local header: crc at 14, packed size at 18, lengths of name and extra field at 26 and 28.
    let (crc, packed, begin) = (field(14, 4), field(18, 4), 30 + field(26, 2) + field(28, 2));
    let mut member = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255];
    member.extend(&zipped[begin..begin + packed]);
    member.extend((crc as u32).to_le_bytes());
    member.extend((spaces.len() as u32).to_le_bytes());
    member
}
