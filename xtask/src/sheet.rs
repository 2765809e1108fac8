//! What does the program make of every plan here? A contact sheet: each plan imported, drawn over the picture that it came from.
//!
//! folders ─▶ plan files ─▶ `planwalk plan import` and `plan render`, a process each ─▶ `index.html`, and pages of thumbnails as PNG
//!
//! Pictures say nothing of metres: a list of lines `part of a path <tab> options` says with which options a plan is read; the last
//! line that fits counts. Time and memory are those of the import's own process (memory where the system tells it in /proc).

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use image::imageops::FilterType;
use image::{Rgb, RgbImage};
use serde_json::Value;

/// Endings of files that may be plans; others are passed over.
const ENDINGS: [&str; 18] =
    ["png", "jpg", "jpeg", "tif", "tiff", "webp", "bmp", "pgm", "yaml", "yml", "svg", "pdf", "dxf", "dwg", "geojson", "osm", "zip", "csv"];
/// Sides of a thumbnail, pixels, and thumbnails of a page along and down.
const THUMB: (u32, u32) = (620, 460);
const PAGE: (u32, u32) = (3, 4);
/// An import that takes longer is ended.
const PATIENCE: Duration = Duration::from_secs(60);

/// What became of one plan.
struct Entry {
    name: String,
    options: String,
    seconds: f64,
    peak_mb: Option<u64>,
    /// What the import said: notes and storeys, or the error.
    said: String,
    /// Kinds with their number, and metres of wall outline.
    counts: Option<String>,
    thumb: Option<RgbImage>,
}

/// Draws the sheet of all plans under some folders into a folder.
pub fn draw(arguments: &[&str]) -> Result<String, Vec<String>> {
    let request = Request::of(arguments).map_err(|why| vec![why])?;
    let failed = |why: std::io::Error| vec![format!("{}: {why}", request.output.display())];
    std::fs::create_dir_all(&request.output).map_err(failed)?;
    let mut entries = Vec::new();
    for folder in &request.folders {
        let mut plans = Vec::new();
        gather(folder, &mut plans);
        entries.extend(plans.iter().map(|plan| request.entry(plan, folder)));
    }
    if entries.is_empty() {
        return Err(vec!["no file there has the ending of a plan".to_owned()]);
    }
    let pages = pages(&entries, &request.output).map_err(|why| vec![why])?;
    std::fs::write(request.output.join("index.html"), html(&entries)).map_err(failed)?;
    let refused = entries.iter().filter(|entry| entry.counts.is_none()).count();
    Ok(format!("{} plans, {refused} refused: {} and {pages} pages beside it", entries.len(), request.output.join("index.html").display()))
}

/// What is asked for.
struct Request {
    folders: Vec<PathBuf>,
    output: PathBuf,
    program: PathBuf,
    /// Parts of paths, and options for those plans.
    options: Vec<(String, Vec<String>)>,
}

impl Request {
    fn of(arguments: &[&str]) -> Result<Self, String> {
        let (mut folders, mut output, mut program, mut options) = (Vec::new(), None, PathBuf::from("target/release/planwalk"), Vec::new());
        let mut left = arguments.iter();
        while let Some(argument) = left.next() {
            let mut value = || left.next().ok_or(format!("{argument} needs a value"));
            match *argument {
                "-o" => output = Some(PathBuf::from(value()?)),
                "--program" => program = PathBuf::from(value()?),
                "--options" => options = option_list(Path::new(value()?))?,
                folder => folders.push(PathBuf::from(folder)),
            }
        }
        let output = output.ok_or("say with -o which folder the sheet goes to")?;
        if folders.is_empty() {
            return Err("say which folders of plans are to be drawn".to_owned());
        }
        if !program.is_file() {
            return Err(format!("{} is not there: cargo build --release, or say where planwalk is with --program FILE", program.display()));
        }
        Ok(Self { folders, output, program, options })
    }

    /// Imports one plan and draws it.
    fn entry(&self, plan: &Path, folder: &Path) -> Entry {
        let name = plan.strip_prefix(folder.parent().unwrap_or(folder)).unwrap_or(plan).to_string_lossy().into_owned();
        let options = self.options.iter().rev().find(|(part, _)| plan.to_string_lossy().contains(part.as_str()));
        let options = options.map(|(_, options)| options.clone()).unwrap_or_default();
        let kept = self.output.join("sheet.plan.json");
        let run = run(Command::new(&self.program).args(["plan", "import", "--force", "-o"]).arg(&kept).args(&options).arg(plan), PATIENCE);
        let mut entry = Entry {
            name,
            options: options.join(" "),
            seconds: run.seconds,
            peak_mb: run.peak_mb,
            said: run.said,
            counts: None,
            thumb: None,
        };
        if run.succeeded {
            let drawing = self.output.join("sheet.png");
            let document = std::fs::read_to_string(&kept).ok().and_then(|text| serde_json::from_str::<Value>(&text).ok());
            let level = document.as_ref().and_then(storey);
            entry.counts = level.map(counts);
            let drawn = self.render(&kept, &drawing);
            let scale = document.as_ref().and_then(|d| d["source"]["metres_per_unit"].as_f64());
            let is_picture = document.as_ref().is_some_and(|d| d["source"]["format"] == "picture");
            let under = scale.filter(|_| is_picture).and_then(|metres| {
                let vector = self.output.join("sheet.svg");
                self.render(&kept, &vector);
                let sheet = std::fs::read_to_string(&vector).ok().as_deref().and_then(sheet_m);
                let _ = std::fs::remove_file(vector);
                Some(Under { picture: image::open(plan).ok()?.to_rgba8(), metres_per_pixel: metres, sheet_m: sheet? })
            });
            if drawn && let Ok(picture) = image::open(&drawing) {
                entry.thumb = Some(thumbnail(&on_paper(&picture), under.as_ref()));
            }
            let _ = std::fs::remove_file(drawing);
        }
        let _ = std::fs::remove_file(kept);
        entry
    }

    fn render(&self, kept: &Path, drawing: &Path) -> bool {
        run(Command::new(&self.program).args(["plan", "render", "--force", "-o"]).arg(drawing).arg(kept), PATIENCE).succeeded
    }
}

fn option_list(path: &Path) -> Result<Vec<(String, Vec<String>)>, String> {
    let text = std::fs::read_to_string(path).map_err(|why| format!("{}: {why}", path.display()))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let of = |(number, line): (usize, &str)| {
        let (part, options) = line.split_once('\t').ok_or(format!(
            "{}, line {}: a line is part of a path, a tab, and options",
            path.display(),
            number + 1
        ))?;
        Ok((part.to_owned(), options.split_whitespace().map(str::to_owned).collect()))
    };
    lines.map(of).collect()
}

/// Plan files below a folder, by name; a map's image goes with its map.yaml.
fn gather(folder: &Path, plans: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    paths.sort();
    for path in &paths {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let is_maps_image = ["pgm", "png"].contains(&ending.as_str()) && path.with_extension("yaml").is_file();
        if path.is_dir() {
            gather(path, plans);
        } else if ENDINGS.contains(&ending.as_str()) && !is_maps_image {
            plans.push(path.clone());
        }
    }
}

/// What a command did.
pub struct Run {
    /// Whether it said so by its exit code.
    pub succeeded: bool,
    /// What it wrote to its errors.
    pub said: String,
    /// From its start to its end.
    pub seconds: f64,
    /// Most memory it had, where the system tells it.
    pub peak_mb: Option<u64>,
}

/// Runs a command to its end, or to the end of patience.
pub fn run(command: &mut Command, patience: Duration) -> Run {
    let begin = Instant::now();
    let failed = |said: String| Run { succeeded: false, said, seconds: begin.elapsed().as_secs_f64(), peak_mb: None };
    let mut child = match command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn() {
        Ok(child) => child,
        Err(why) => return failed(format!("it does not start: {why}")),
    };
    let (id, errors) = (child.id(), child.stderr.take());
    // A pipe that nobody empties stops who fills it.
    let reader = std::thread::spawn(move || {
        let mut said = String::new();
        errors.map(|mut errors| errors.read_to_string(&mut said));
        said
    });
    let mut peak_mb = None;
    let status = loop {
        peak_mb = peak(id).max(peak_mb);
        match child.try_wait() {
            Ok(Some(status)) => break Some(status),
            Ok(None) if begin.elapsed() < patience => std::thread::sleep(Duration::from_millis(2)),
            Ok(None) | Err(_) => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
        }
    };
    let seconds = begin.elapsed().as_secs_f64();
    let said = reader.join().unwrap_or_default();
    match status {
        Some(status) => Run { succeeded: status.success(), said, seconds, peak_mb },
        None => Run { succeeded: false, said: format!("ended after {} s\n{said}", patience.as_secs()), seconds, peak_mb },
    }
}

/// Most memory that a process has had so far, megabytes.
fn peak(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kb| kb / 1024)
}

/// The storey that is drawn: the ground floor, or the lowest above it, or the highest.
fn storey(document: &Value) -> Option<&Value> {
    let levels = document["levels"].as_array()?;
    levels.iter().find(|level| level["ordinal"].as_i64() >= Some(0)).or(levels.last())
}

/// Chains of points of an element.
fn chains(element: &Value) -> Vec<Vec<[f64; 2]>> {
    let point = |v: &Value| Some([v.get(0)?.as_f64()?, v.get(1)?.as_f64()?]);
    let chain = |v: &Value| v.as_array().map(|points| points.iter().filter_map(point).collect::<Vec<_>>()).unwrap_or_default();
    let rings = element["area"].as_array().into_iter().flatten().map(chain);
    let spot = element.get("spot").and_then(point).map(|at| vec![at]);
    rings.chain(element.get("line").map(chain)).chain(spot).collect()
}

fn counts(level: &Value) -> String {
    let elements = || level["elements"].as_array().into_iter().flatten();
    let mut text = String::new();
    for kind in ["wall", "window", "door", "floor", "room", "stairs", "lift"] {
        let count = elements().filter(|element| element["kind"] == kind).count();
        if count > 0 {
            let _ = write!(text, "{count} {kind}, ");
        }
    }
    let length = |chain: &Vec<[f64; 2]>| chain.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum::<f64>();
    let metres: f64 = elements()
        .filter(|element| element["kind"] == "wall")
        .flat_map(chains)
        .map(|chain| length(&chain))
        .fold(0.0, |sum, metres| sum + metres);
    let size =
        extent(level).map_or(String::new(), |[left, lower, right, upper]| format!("{:.1} m × {:.1} m, ", right - left, upper - lower));
    format!("{size}{text}{metres:.0} m of wall lines")
}

/// Left, lower, right and upper edge of what is drawn, metres.
fn extent(level: &Value) -> Option<[f64; 4]> {
    let points = level["elements"].as_array()?.iter().flat_map(chains).flatten();
    let grown = |[l, b, r, t]: [f64; 4], [x, y]: [f64; 2]| [l.min(x), b.min(y), r.max(x), t.max(y)];
    let found = points.fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], grown);
    (found[0] <= found[2]).then_some(found)
}

/// A drawing on white: what `plan render` leaves empty is transparent.
fn on_paper(drawing: &image::DynamicImage) -> RgbImage {
    let drawing = drawing.to_rgba8();
    RgbImage::from_fn(drawing.width(), drawing.height(), |u, v| {
        let [r, g, b, a] = drawing.get_pixel(u, v).0.map(u32::from);
        Rgb([r, g, b].map(|c| ((c * a + 255 * (255 - a)) / 255) as u8))
    })
}

/// The picture that a drawing was made of; its lower left corner is the plan's origin.
struct Under {
    picture: image::RgbaImage,
    metres_per_pixel: f64,
    /// Left and upper edge, width and height of the drawing's sheet on the plan, metres.
    sheet_m: [f64; 4],
}

/// What part of the plan a drawing's sheet shows: its `viewBox` is in millimetres, downwards.
fn sheet_m(svg: &str) -> Option<[f64; 4]> {
    let (_, rest) = svg.split_once("viewBox=\"")?;
    let numbers: Vec<f64> = rest.split('"').next()?.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [x, y, width, height] = numbers[..] else { return None };
    Some([1e-3 * x, -1e-3 * y, 1e-3 * width, 1e-3 * height])
}

/// A drawing made small, its paper filled by the pale picture that lies under it.
fn thumbnail(drawing: &RgbImage, under: Option<&Under>) -> RgbImage {
    let scale = (f64::from(THUMB.0) / f64::from(drawing.width())).min(f64::from(THUMB.1) / f64::from(drawing.height()));
    let [width, height] = [drawing.width(), drawing.height()].map(|side| ((scale * f64::from(side)).round() as u32).max(1));
    let mut small = image::imageops::resize(drawing, width, height, FilterType::Triangle);
    let Some(Under { picture, metres_per_pixel: metres, sheet_m: [left, upper, wide, high] }) = under else { return small };
    for (u, v, pixel) in small.enumerate_pixels_mut() {
        let x = left + (f64::from(u) + 0.5) / f64::from(width) * wide;
        let y = upper - (f64::from(v) + 0.5) / f64::from(height) * high;
        let (column, row) = ((x / metres).floor(), f64::from(picture.height()) - (y / metres).floor() - 1.0);
        if column >= 0.0 && row >= 0.0 && column < f64::from(picture.width()) && row < f64::from(picture.height()) {
            let [r, g, b, a] = picture.get_pixel(column as u32, row as u32).0;
            let pale = |c: u8| 255.0 - 0.35 * (255.0 - f64::from(c)) * f64::from(a) / 255.0;
            *pixel = Rgb([0, 1, 2].map(|k| (f64::from(pixel.0[k]) * pale([r, g, b][k]) / 255.0) as u8));
        }
    }
    small
}

/// Pages of thumbnails in the order of the list; a refused plan is a grey field.
fn pages(entries: &[Entry], folder: &Path) -> Result<usize, String> {
    let a_page = (PAGE.0 * PAGE.1) as usize;
    for (number, page) in entries.chunks(a_page).enumerate() {
        let mut sheet = RgbImage::from_pixel(PAGE.0 * (THUMB.0 + 10), PAGE.1 * (THUMB.1 + 10), Rgb([255, 255, 255]));
        for (i, entry) in page.iter().enumerate() {
            let (x, y) = (i as u32 % PAGE.0 * (THUMB.0 + 10), i as u32 / PAGE.0 * (THUMB.1 + 10));
            let refused = || RgbImage::from_pixel(THUMB.0, THUMB.1, Rgb([225, 225, 225]));
            let thumb = entry.thumb.clone().unwrap_or_else(refused);
            image::imageops::replace(&mut sheet, &thumb, i64::from(x), i64::from(y));
            let name = format!("plan-{:03}.png", number * a_page + i + 1);
            thumb.save(folder.join(&name)).map_err(|why| format!("{name}: {why}"))?;
        }
        let name = format!("page-{:02}.png", number + 1);
        sheet.save(folder.join(&name)).map_err(|why| format!("{name}: {why}"))?;
    }
    Ok(entries.len().div_ceil(a_page))
}

fn html(entries: &[Entry]) -> String {
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let mut out = String::from(
        "<!doctype html><meta charset=\"utf-8\"><title>Plans</title>\n<style>body{font:13px sans-serif;display:grid;\
         grid-template-columns:repeat(3,1fr);gap:16px}figure{margin:0;break-inside:avoid}img{max-width:100%;border:1px solid #ccc}\
         .refused{color:#b00}small{color:#555;white-space:pre-wrap}</style>\n",
    );
    for (i, entry) in entries.iter().enumerate() {
        let memory = entry.peak_mb.map_or(String::new(), |mb| format!(", {mb} MB"));
        let counts = entry.counts.as_deref().unwrap_or("refused");
        let class = if entry.counts.is_some() { "" } else { " class=\"refused\"" };
        let _ = writeln!(
            out,
            "<figure><img src=\"plan-{:03}.png\" alt=\"\"><figcaption><b>{}</b> {}<br><span{class}>{counts}</span>; {:.2} s{memory}<br>\
             <small>{}</small></figcaption></figure>",
            i + 1,
            escaped(&entry.name),
            escaped(&entry.options),
            entry.seconds,
            escaped(entry.said.trim()),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_are_measured_on_the_ground_floor() {
        let text = r#"{"levels":[{"ordinal":-1,"elements":[]},{"ordinal":0,"elements":[
            {"kind":"wall","line":[[0,0],[3,4]]},{"kind":"wall","area":[[[0,0],[2,0],[2,1]],[[1,0.2],[1.5,0.2]]]},
            {"kind":"door","spot":[7,1]}]}]}"#;
        let document: Value = serde_json::from_str(text).unwrap();
        let level = storey(&document).unwrap();
        assert_eq!(extent(level), Some([0.0, 0.0, 7.0, 4.0]));
        assert_eq!(counts(level), "7.0 m × 4.0 m, 2 wall, 1 door, 8 m of wall lines");
    }

    #[test]
    fn the_picture_lies_under_the_drawing_where_it_belongs() {
        // A picture of 4 × 4 m whose lower left metre is black; the drawing shows the metre around its walls too.
        let picture = RgbImage::from_fn(4, 4, |u, v| if (u, v) == (0, 3) { Rgb([0, 0, 0]) } else { Rgb([255, 255, 255]) });
        let drawing = RgbImage::from_pixel(60, 60, Rgb([255, 255, 255]));
        let sheet_m = sheet_m("<svg viewBox=\"-1000 -5000 6000 6000\">").unwrap();
        let picture = image::DynamicImage::from(picture).to_rgba8();
        let thumb = thumbnail(&drawing, Some(&Under { picture, metres_per_pixel: 1.0, sheet_m }));
        let at = |x: f64, y: f64| {
            let k = f64::from(thumb.width()) / 6.0;
            thumb.get_pixel(((x + 1.0) * k) as u32, ((5.0 - y) * k) as u32).0[0]
        };
        assert!(at(0.5, 0.5) < 200 && at(1.5, 0.5) == 255 && at(0.5, 1.5) == 255 && at(-0.5, 0.5) == 255);
    }
}
