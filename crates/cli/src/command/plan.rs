//! `planwalk plan`: what is on a plan, and how far must one walk on it to know where one is?

use planwalk::figure::{AmbiguityPicture, png_of};
use planwalk::locate::{AmbiguityOptions, ambiguity};
use planwalk::plan_info::{AmbiguityEntry, PlanInfo, words};
use planwalk::types::FloorPlan;

use super::{georeference, name_of, plan_audit, plan_file};
use crate::args::{PlanCommand, PlanCommandArgs, PlanInfoArgs};
use crate::failure::Failure;
use crate::inputs;
use crate::output::Output;
use crate::say::{self, Voice};

/// Does what was asked of the plan.
pub fn run(args: &PlanCommandArgs) -> Result<(), Failure> {
    match &args.command {
        PlanCommand::Info(args) => info(args),
        PlanCommand::Import(args) => plan_file::import(args),
        PlanCommand::Export(args) => plan_file::export(args),
        PlanCommand::Render(args) => plan_file::render(args),
        PlanCommand::Georeference(args) => georeference::run(args),
    }
}

fn info(args: &PlanInfoArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.quiet };
    let output = args.output.as_ref().map(|folder| Output::open(folder, args.force)).transpose()?;
    if let Some(threads) = args.threads {
        // Built once a process; a second build can only fail in tests that call commands in one process.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
    }
    let refuse = |why| Failure::input("the plan", why, &args.plan);
    let (read, mut document) = planwalk_io::plan::survey(&args.plan, &args.reading.options()).map_err(refuse)?;
    read.notes.iter().for_each(|note| voice.say(&format!("note: {note}")));
    let audits = planwalk_io::plan::complete(&mut document);
    let storey = planwalk_io::plan::level(&document.building, &args.reading.options(), &mut Vec::new()).map_err(refuse)?.name.clone();
    let building = plan_audit::entry(&document, &audits, storey);
    let mut info = PlanInfo::new(&read.plan, building, args.seed(), vec![inputs::entry("plan", &args.plan)?], read.notes);
    voice.say(&basics(&info));
    plan_audit::describe(&info.building).iter().for_each(|line| voice.say(line));
    if args.ambiguity {
        find_ambiguity(args, &read.plan, voice, output.as_ref(), &mut info)?;
    }
    let json = info.to_json();
    if let Some(output) = &output {
        output.write("plan_info.json", &json)?;
    }
    if args.json {
        say::stdout_text(&json);
    }
    Ok(())
}

fn basics(info: &PlanInfo) -> String {
    let ([width, height], cell_cm) = (info.size_m, 100.0 * info.cell_m);
    let [x, y] = info.origin_m;
    let walls_m2 = info.cells.wall as f64 * info.cell_m * info.cell_m;
    let doors = match info.doors {
        0 => "doors are not told from openings".to_owned(),
        doors => format!("{doors} doors"),
    };
    format!(
        "{width:.1} m × {height:.1} m from ({x:.2}, {y:.2}) m, cells of {cell_cm:.1} cm; {:.0} m² of floor inside, {walls_m2:.1} m² of walls, {doors}",
        info.inside_m2
    )
}

fn find_ambiguity(
    args: &PlanInfoArgs,
    plan: &FloorPlan,
    voice: Voice,
    output: Option<&Output>,
    info: &mut PlanInfo,
) -> Result<(), Failure> {
    let bar = voice.bar("walking", Some(1000));
    let found = ambiguity(plan, &AmbiguityOptions::default(), args.seed(), &mut |share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let sentence = words(&found);
    voice.say(&sentence);
    for (i, pair) in found.pairs.iter().take(3).enumerate() {
        let longer = if pair.to_the_end { "at least " } else { "" };
        voice.say(&format!(
            "alike {}: ({:.1}, {:.1}) m facing {:.0}° and ({:.1}, {:.1}) m facing {:.0}°, for {longer}{:.0} m",
            i + 1,
            pair.a.x,
            pair.a.y,
            pair.a.heading_rad.to_degrees(),
            pair.b.x,
            pair.b.y,
            pair.b.heading_rad.to_degrees(),
            pair.alike_m
        ));
    }
    if let Some(output) = output {
        let title = format!("How far to walk on {} to know where one is", name_of(&args.plan));
        let svg = AmbiguityPicture { title: &title, plan, ambiguity: &found, words: &sentence }.svg();
        output.write("ambiguity.svg", &svg)?;
        output.write("ambiguity.png", png_of(&svg).map_err(|why| Failure::output(why, &output.path("ambiguity.png")))?)?;
        voice.say(&format!("picture: {}", output.path("ambiguity.png").display()));
    }
    info.ambiguity = Some(AmbiguityEntry::from(&found));
    Ok(())
}
