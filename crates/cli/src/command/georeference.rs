//! `planwalk plan georeference`: where on the globe does this plan lie?

use std::path::Path;

use planwalk::types::{Georeference, Pt2};
use planwalk_io::plan::georeference::{self, ControlPoint, Crs, GeoreferenceError, WorldFile};
use planwalk_io::plan::native::{self, Placed, PlanDocument};
use planwalk_io::raster;

use super::name_of;
use super::plan_file::{self, Target};
use crate::args::{Known, PlanFileArgs, PlanGeoreferenceArgs};
use crate::failure::Failure;
use crate::say::Voice;

/// Largest world file, bytes: six numbers.
const WORLD_FILE_MOST: u64 = 4096;

/// Places a plan, and keeps it.
pub fn run(args: &PlanGeoreferenceArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.file.quiet };
    if !name_of(&args.file.output).ends_with(".plan.json") {
        return Err(Failure::usage(format!("the file is to end in .plan.json\n  {}", args.file.output.display())));
    }
    let target = Target::of(&args.file)?;
    let mut document;
    let (place, placed) = match (&args.world_file, args.crs, args.anchor.zip(args.bearing)) {
        (Some(world), Some(crs), _) => {
            let points;
            (document, points) = by_world_file(&args.file, world, crs, voice)?;
            fitted(&points, format!("the world file {}, {crs}", name_of(world)), voice)?
        }
        (_, Some(crs), _) => {
            document = plan_file::open(&args.file, voice)?;
            by_grid(&document, crs, &args.file.plan)?
        }
        (_, _, Some(([latitude, longitude], bearing))) => {
            document = plan_file::open(&args.file, voice)?;
            let place = georeference::anchored(latitude, longitude, bearing).map_err(Failure::usage)?;
            (place, Placed { from: "an anchor and a bearing, given".to_owned(), points: Vec::new() })
        }
        _ => {
            document = plan_file::open(&args.file, voice)?;
            let points = control(args, &document)?;
            fitted(&points, format!("{} points, given", points.len()), voice)?
        }
    };
    if let Some(before) = &document.building.georeference {
        voice.say(&format!("note: the plan had a place, which is replaced: {}", georeference::words(before)));
    }
    voice.say(&georeference::words(&place));
    document.building.georeference = Some(place);
    document.placed = Some(placed);
    target.write(native::write(&document))
}

/// The place that fits points best; with what a person should know of it.
fn fitted(points: &[ControlPoint], from: String, voice: Voice) -> Result<(Georeference, Placed), Failure> {
    let fit = georeference::fit(points).map_err(Failure::usage)?;
    fit.words(points).iter().for_each(|word| voice.say(word));
    Ok((fit.place, fit.kept(from, points)))
}

/// The points that were given, in the plan's metres.
fn control(args: &PlanGeoreferenceArgs, document: &PlanDocument) -> Result<Vec<ControlPoint>, Failure> {
    let point = |known: &Known, plan| ControlPoint { plan, longitude_deg: known.longitude_deg, latitude_deg: known.latitude_deg };
    if args.pixel.is_empty() {
        return Ok(args.point.iter().map(|known| point(known, Pt2::new(known.at[0], known.at[1]))).collect());
    }
    let metres = document.source.metres_per_unit.filter(|_| document.source.format.as_deref() == Some("picture"));
    let is_kept = name_of(&args.file.plan).ends_with(".json");
    let Some(metres) = metres.filter(|_| !is_kept) else {
        return Err(Failure::usage(format!(
            "--pixel is for pictures: give this plan's points in its metres, with --point\n  {}",
            args.file.plan.display()
        )));
    };
    let [_, height] = picture_size(&args.file.plan)?;
    let on_plan = |known: &Known| point(known, Pt2::new(known.at[0] * metres, (height - known.at[1]) * metres));
    Ok(args.pixel.iter().map(on_plan).collect())
}

/// A picture whose corners are where a world file has them.
fn by_world_file(args: &PlanFileArgs, world: &Path, crs: Crs, voice: Voice) -> Result<(PlanDocument, Vec<ControlPoint>), Failure> {
    let refuse = |why: &dyn std::fmt::Display| Failure::input("the world file", why, world);
    let length = std::fs::metadata(world).map_err(|why| refuse(&why))?.len();
    if length > WORLD_FILE_MOST {
        return Err(refuse(&format!("it has {length} bytes, and six numbers need no more than {WORLD_FILE_MOST}")));
    }
    let text = std::fs::read_to_string(world).map_err(|why| refuse(&why))?;
    let file: WorldFile = text.parse().map_err(|why| refuse(&why))?;
    let size = picture_size(&args.plan)?;
    let by_world = file.metres_per_pixel(crs, size).map_err(|why| refuse(&why))?;
    let mut reading = args.reading.clone();
    if reading.metres_per_pixel.is_none() && reading.measure.is_empty() {
        reading.metres_per_pixel = Some(by_world);
    }
    let args = PlanFileArgs { plan: args.plan.clone(), output: args.output.clone(), reading, ..*args };
    let mut document = plan_file::open(&args, voice)?;
    let metres = document.source.metres_per_unit.unwrap_or(by_world);
    if metres == by_world {
        document.source.scale_from = Some(format!("the world file {}", name_of(world)));
    }
    let points = file.control(crs, size, metres).map_err(|why| refuse(&why))?;
    Ok((document, points))
}

/// A plan whose metres are a grid's.
fn by_grid(document: &PlanDocument, crs: Crs, plan: &Path) -> Result<(Georeference, Placed), Failure> {
    if crs == Crs::Degrees {
        return Err(Failure::usage(
            "--crs EPSG:4326 alone says nothing of a plan in metres: give a world file, or the grid of its metres (EPSG:326zz)",
        ));
    }
    let place = georeference::on_grid(&document.building, crs).map_err(|why: GeoreferenceError| Failure::input("the plan", why, plan))?;
    Ok((place, Placed { from: format!("the plan's metres are those of {crs}"), points: Vec::new() }))
}

/// Columns and rows of a picture.
fn picture_size(path: &Path) -> Result<[f64; 2], Failure> {
    let size = raster::size(path).map_err(|why| Failure::input("the plan's picture", why, path))?;
    Ok(size.map(f64::from))
}
