//! Checks and measurements that cargo itself does not make: `cargo xtask layers`, `cargo xtask two-view FILE.npz`; and
//! `cargo xtask plans`, to look at many plans; `cargo xtask limits`, what the largest of them cost.

mod layers;
mod limits;
mod sheet;
mod two_view;

use std::process::ExitCode;

const USAGE: &str = "usage:
  cargo xtask layers
      which crate may use which, and what the pure crates must not touch
  cargo xtask two-view FILE.npz [--solver five-point|eight-point|upright] [--up-noise DEGREES] [--json]
      how well and how fast the motion between two pictures is found, a scenario a row
  cargo xtask plans DIR... -o DIR [--options FILE] [--program target/release/planwalk]
      every plan under the folders, imported and drawn: index.html and pages of thumbnails;
      FILE has lines \"part of a path <tab> options of planwalk plan import\"
  cargo xtask limits -o DIR [--program target/release/planwalk] [--only PART-OF-A-NAME]
      seconds and memory of the largest files that each reader of plans admits; DIR needs 5 GB for a while";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["layers"] => layers::check(),
        ["plans", ref request @ ..] => sheet::draw(request),
        ["limits", ref request @ ..] => limits::measure(request),
        ["two-view", ref words @ ..] => two_view::Wish::of(words).and_then(|wish| two_view::run(&wish)).map_err(|why| vec![why]),
        _ => Err(vec![USAGE.to_owned()]),
    };
    match outcome {
        Ok(said) => {
            say(&said);
            ExitCode::SUCCESS
        }
        Err(faults) => {
            faults.iter().for_each(|fault| complain(fault));
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stdout, reason = "this is a command; its result goes to the terminal")]
fn say(text: &str) {
    println!("{text}");
}

#[expect(clippy::print_stderr, reason = "this is a command; its faults go to the terminal")]
fn complain(text: &str) {
    eprintln!("{text}");
}
