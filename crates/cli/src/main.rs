//! The command `planwalk`: where on a floor plan was this video walked?
//!
//! Exit codes: 0 done, 2 usage, 4 input unusable, 5 no answer at all.

mod args;
mod bench;
mod command;
mod failure;
mod inputs;
mod output;
mod say;
mod simulate;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

fn main() -> ExitCode {
    let outcome = match &Cli::parse().command {
        Command::Demo(args) => command::demo::run(args),
        Command::Track(args) => command::track::run(args),
        Command::Locate(args) => command::locate::run(args),
        Command::Place(args) => command::place::run(args),
        Command::Plan(args) => command::plan::run(args),
        Command::Eval(args) => command::eval::run(args),
        Command::Sim(args) => command::sim::run(args),
        Command::Bench(args) => command::bench::run(args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say::stderr_line(&format!("error: {}", failure.message));
            ExitCode::from(failure.code)
        }
    }
}
