//! `planwalk plan import|export|render`: what was made of a plan, kept, handed on, drawn.

use std::path::Path;

use planwalk::figure::{lettered, png_within};
use planwalk::types::{Building, ElementKind, Level};
use planwalk_io::plan::audit::{self, Audit};
use planwalk_io::plan::native::{self, PlanDocument};
use planwalk_io::plan::{self, export};

use super::{name_of, plan_audit};
use crate::args::{PlanExportArgs, PlanFileArgs};
use crate::failure::Failure;
use crate::inputs;
use crate::output::Output;
use crate::say::Voice;

/// Longer side of a drawn plan, pixels.
const PICTURE_PX: u32 = 2400;
/// Endings that `export` knows.
const ENDINGS: &str = ".svg, .geojson, .csv, .yaml or .plan.json";

/// Keeps a plan.
pub fn import(args: &PlanFileArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.quiet };
    if !name_of(&args.output).ends_with(".plan.json") {
        return Err(Failure::usage(format!(
            "the file is to end in .plan.json; plan export writes other formats\n  {}",
            args.output.display()
        )));
    }
    let target = Target::of(args)?;
    let mut document = open(args, voice)?;
    let audits = plan::complete(&mut document);
    tell(&document.building.levels, voice);
    let notes = plan_audit::notes(&document, &audits);
    for note in notes {
        voice.say(&note);
        // A plan that was kept before has them already.
        if !document.notes.contains(&note) {
            document.notes.push(note);
        }
    }
    target.write(native::write(&document))
}

/// Writes a plan in another format.
pub fn export(args: &PlanExportArgs) -> Result<(), Failure> {
    let (file, voice) = (&args.file, Voice { quiet: args.file.quiet });
    let name = name_of(&file.output).to_lowercase();
    let has = |ending: &str| name.ends_with(ending);
    let target = Target::of(file)?;
    if has(".yaml") || has(".yml") {
        return robots_map(file, voice, &target);
    }
    if ![".svg", ".geojson", ".csv", ".plan.json"].into_iter().any(has) {
        return Err(Failure::usage(format!("the file's ending says the format: {ENDINGS}\n  {}", file.output.display())));
    }
    let mut document = open(file, voice)?;
    if has(".plan.json") {
        plan::complete(&mut document);
        return target.write(native::write(&document));
    }
    let level = &audit::as_drawn(storey(&document.building, file, voice)?);
    match document.building.georeference.filter(|_| !args.metres) {
        _ if has(".svg") => target.write(export::svg(level)),
        _ if has(".csv") => target.write(export::csv(level)),
        Some(place) => {
            let text = export::geojson_on_globe(level, &place).map_err(|why| Failure::input("the plan", why, &file.plan))?;
            target.write(text)
        }
        None => target.write(export::geojson(level)),
    }
}

/// Draws what was taken for what.
pub fn render(args: &PlanFileArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.quiet };
    let name = name_of(&args.output).to_lowercase();
    if !name.ends_with(".png") && !name.ends_with(".svg") {
        return Err(Failure::usage(format!("a picture ends in .png or .svg\n  {}", args.output.display())));
    }
    let target = Target::of(args)?;
    let document = open(args, voice)?;
    let mut level = storey(&document.building, args, voice)?.clone();
    let audit = Audit::of(&level).unwrap_or_else(|why| {
        voice.say(&format!("note: rooms are not looked for, nor mistakes: {why}"));
        Audit::default()
    });
    audit.complete(&mut level);
    tell(std::slice::from_ref(&level), voice);
    plan_audit::findings(&audit).iter().for_each(|line| voice.say(line));
    // What was kept is still known by the file that it came from.
    let known_as = document.source.file.clone().unwrap_or_else(|| name_of(&args.plan));
    let title = format!("{known_as}, storey {}", level.name);
    let svg = export::picture(&level, &audit, &title);
    if name.ends_with(".svg") {
        return target.write(svg);
    }
    target.write(png_within(&lettered(&svg), PICTURE_PX).map_err(|why| Failure::output(why, &args.output))?)
}

/// A map.yaml, and its picture beside it.
fn robots_map(args: &PlanFileArgs, voice: Voice, target: &Target<'_>) -> Result<(), Failure> {
    let image = Path::new(target.name).with_extension("pgm");
    let image = image.to_str().unwrap_or("map.pgm");
    target.may_write(image)?;
    let read = inputs::plan_at(&args.plan, &args.reading)?;
    read.notes.iter().for_each(|note| voice.say(&format!("note: {note}")));
    target.write_as(image, export::ros_map_image(&read.value))?;
    target.write(export::ros_map_yaml(&read.value, image))
}

pub(super) fn open(args: &PlanFileArgs, voice: Voice) -> Result<PlanDocument, Failure> {
    let mut document = plan::import(&args.plan, &args.reading.options()).map_err(|why| Failure::input("the plan", why, &args.plan))?;
    document.notes.iter().for_each(|note| voice.say(&format!("note: {note}")));
    // A plan that was kept before goes on telling where it came from.
    if document.source.file.is_none() {
        document.source.file = Some(name_of(&args.plan));
        document.source.sha256 = Some(inputs::entry("plan", &args.plan)?.sha256);
    }
    Ok(document)
}

fn storey<'a>(building: &'a Building, args: &PlanFileArgs, voice: Voice) -> Result<&'a Level, Failure> {
    let mut notes = Vec::new();
    let level = plan::level(building, &args.reading.options(), &mut notes).map_err(|why| Failure::input("the plan", why, &args.plan))?;
    notes.iter().for_each(|note| voice.say(&format!("note: {note}")));
    Ok(level)
}

/// What there is, a line a storey.
fn tell(levels: &[Level], voice: Voice) {
    for level in levels {
        let count = |kind: ElementKind| level.elements.iter().filter(|element| element.kind == kind).count();
        let counts: Vec<String> = ElementKind::ALL
            .iter()
            .map(|kind| (count(*kind), kind.word()))
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}{}", if count == 1 || word.ends_with('s') { "" } else { "s" }))
            .collect();
        voice.say(&format!("storey {} ({}): {}", level.name, level.ordinal, counts.join(", ")));
    }
}

/// The file that is written.
pub(super) struct Target<'a> {
    folder: &'a Path,
    name: &'a str,
    force: bool,
}

impl<'a> Target<'a> {
    /// Refuses a file that is there, unless it may be overwritten.
    pub(super) fn of(args: &'a PlanFileArgs) -> Result<Self, Failure> {
        let path = &args.output;
        let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(|| Failure::usage("the output needs a file name"))?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let target = Self { folder, name, force: args.force };
        target.may_write(name)?;
        Ok(target)
    }

    fn may_write(&self, name: &str) -> Result<(), Failure> {
        let path = self.folder.join(name);
        if path.exists() && !self.force {
            let why = "the file is there already; give another, or --force to overwrite it";
            return Err(Failure::usage(format!("{why}\n  {}", path.display())));
        }
        Ok(())
    }

    pub(super) fn write(&self, content: impl AsRef<[u8]>) -> Result<(), Failure> {
        self.write_as(self.name, content)
    }

    /// Writes a file that goes with it. The folder is made only now, that a plan that cannot be read leaves none behind.
    fn write_as(&self, name: &str, content: impl AsRef<[u8]>) -> Result<(), Failure> {
        Output::beside(self.folder)?.write(name, content)
    }
}
