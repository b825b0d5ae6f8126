//! The command line: one file a subcommand.

mod bench;
mod chosen;
mod colours;
mod compare;
mod default;
mod explain;
mod export;
mod extinction;
mod inputs;
mod inspect;
#[cfg(feature = "laboratory")]
mod laboratory;
mod look;
mod materials;
mod memory;
mod merge;
mod named_scene;
mod output;
mod picture;
mod plan;
mod progress;
mod pyramid;
mod render;
mod sampled;
mod splatted;
mod table;
mod tables;
mod textured;
mod turntable;
mod vectors;
#[cfg(any(test, not(feature = "laboratory")))]
#[cfg_attr(feature = "laboratory", expect(dead_code, reason = "here for its tests"))]
mod without_laboratory;

use clap::error::{ContextKind, ContextValue};
use clap::{Parser, Subcommand};
use slicecast_engine::error::RenderError;
use slicecast_volume::open::LoadError;
#[cfg(not(feature = "laboratory"))]
use without_laboratory as laboratory;

/// Why the program stops, and with which code.
#[derive(Debug)]
pub struct Failure {
    /// One line for standard error.
    pub message: String,
    /// 1: the machine failed, or what was checked does not hold; 2: the request or its input is at fault.
    pub code: u8,
}

impl Failure {
    /// The request or its input is at fault.
    pub fn input(message: impl ToString) -> Self {
        Self {
            message: message.to_string(),
            code: 2,
        }
    }

    /// The machine failed.
    pub fn machine(message: impl ToString) -> Self {
        Self {
            message: message.to_string(),
            code: 1,
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        Self::input(error)
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Threads(_) => Self::machine(error),
            _ => Self::input(error),
        }
    }
}

/// A fixed-point volume renderer, and the f64 model that it is measured against.
///
/// Without a subcommand the built-in CT head is streamed, slice by slice, through the pipeline at its three
/// precisions, each stage is compared with the f64 model, the error tables are printed, and the pictures are written.
#[derive(Parser)]
#[command(
    name = "slicecast",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Examples:
  slicecast                                        the main job, pictures in ./slicecast-out/
  slicecast render scan.nrrd --scene bone.toml -o bone.png
  slicecast compare scan.nrrd --scene bone.toml --precision wide --json errors.json
  slicecast plan --dims 64x64x64 --scene bone.toml"
)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    main_job: default::Args,
}

#[derive(Subcommand)]
enum Command {
    Render(Box<render::Args>),
    Compare(Box<compare::Args>),
    Plan(plan::Args),
    Inspect(inspect::Args),
    Table(table::Args),
    Export(Box<export::Args>),
    Turntable(Box<turntable::Args>),
    Merge(merge::Args),
    Pyramid(Box<pyramid::Args>),
    Extinction(extinction::Args),
    Explain(explain::Args),
    Bench(Box<bench::Args>),
    Vectors(Box<vectors::Args>),
    #[command(flatten)]
    Laboratory(laboratory::Command),
}

impl Cli {
    /// The command line; if it cannot be understood, or asks for help, the program ends here.
    pub fn of_command_line() -> Self {
        Self::try_parse().unwrap_or_else(|mut error| {
            // clap takes any unknown flag for a value that was meant, which it never is here.
            if let Some(ContextValue::StyledStrs(mut tips)) = error.remove(ContextKind::Suggested) {
                tips.retain(|tip| !tip.to_string().contains("as a value, use"));
                if !tips.is_empty() {
                    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
                }
            }
            error.exit()
        })
    }

    /// Does what the command line asks.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            None => self.main_job.run(),
            Some(Command::Render(args)) => args.run(),
            Some(Command::Compare(args)) => args.run(),
            Some(Command::Plan(args)) => args.run(),
            Some(Command::Inspect(args)) => args.run(),
            Some(Command::Table(args)) => args.run(),
            Some(Command::Export(args)) => args.run(),
            Some(Command::Turntable(args)) => args.run(),
            Some(Command::Merge(args)) => args.run(),
            Some(Command::Pyramid(args)) => args.run(),
            Some(Command::Extinction(args)) => args.run(),
            Some(Command::Explain(args)) => args.run(),
            Some(Command::Bench(args)) => args.run(),
            Some(Command::Vectors(args)) => args.run(),
            Some(Command::Laboratory(command)) => command.run(),
        }
    }
}
