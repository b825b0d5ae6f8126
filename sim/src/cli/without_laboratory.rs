//! A program without the precision laboratory: its subcommands say in one line how to get it. A tenth of the time that a build takes
//! from nothing is the laboratory's.

use std::ffi::OsString;

use clap::Subcommand;
use clap::builder::ValueParser;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::Rgb;

use super::Failure;
use super::inputs::ThreadArgs;

/// What has to be built.
const HINT: &str = "the precision laboratory is not part of this program; `cargo build --release --features laboratory` makes one that has it";

/// Whatever is asked of a subcommand that is not there.
#[derive(clap::Args)]
pub struct Asked {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _words: Vec<OsString>,
}

/// Their names, each with the first line of its help.
#[derive(Subcommand)]
pub enum Command {
    /// The laboratory (not in this program): errors, speed and memory of every configuration
    #[command(disable_help_flag = true)]
    Sweep(Asked),
    /// The laboratory (not in this program): parts of a sweep as one
    #[command(disable_help_flag = true)]
    SweepMerge(Asked),
    /// The laboratory (not in this program): the hard cases
    #[command(disable_help_flag = true)]
    Hard(Asked),
    /// The laboratory (not in this program): classification of segments
    #[command(disable_help_flag = true)]
    Segments(Asked),
    /// The laboratory (not in this program): border sampling
    #[command(disable_help_flag = true)]
    Borders(Asked),
    /// The laboratory (not in this program): texture hardware of 8 bits
    #[command(disable_help_flag = true)]
    Texture(Asked),
    /// The laboratory (not in this program): reflectance maps by size
    #[command(disable_help_flag = true)]
    Reflectance(Asked),
    /// The laboratory (not in this program): splatting by the widths of its records
    #[command(disable_help_flag = true)]
    Splats(Asked),
    /// The laboratory (not in this program): all of it on one page
    #[command(disable_help_flag = true)]
    Report(Asked),
}

impl Command {
    pub fn run(self) -> Result<(), Failure> {
        let name = match self {
            Self::Sweep(_) => "sweep",
            Self::SweepMerge(_) => "sweep-merge",
            Self::Hard(_) => "hard",
            Self::Segments(_) => "segments",
            Self::Borders(_) => "borders",
            Self::Texture(_) => "texture",
            Self::Reflectance(_) => "reflectance",
            Self::Splats(_) => "splats",
            Self::Report(_) => "report",
        };
        Err(Failure::input(format!("{name}: {HINT}")))
    }
}

/// No pipeline of 8 bits can be named.
#[derive(Clone, Copy, Debug)]
pub enum Texture8Arg {}

/// What refuses the name of one.
pub fn texture8() -> ValueParser {
    ValueParser::new(|_: &str| Err::<Texture8Arg, _>(HINT))
}

pub fn texture_picture(_: &Prepared<'_>, pipeline: Texture8Arg, _: &ThreadArgs) -> Result<Rgb, Failure> {
    match pipeline {}
}

pub fn compare_textures(_: &Prepared<'_>, _: &[Texture8Arg], _: &ThreadArgs) -> Result<[String; 2], Failure> {
    Err(Failure::input(format!("--texture8: {HINT}")))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::{Command, Texture8Arg, texture8};

    #[derive(Parser)]
    struct Cli {
        #[arg(long, value_parser = texture8())]
        texture8: Vec<Texture8Arg>,
        #[command(subcommand)]
        command: Option<Command>,
    }

    #[test]
    fn whatever_is_asked_of_the_laboratory_says_how_to_get_it() {
        let names = [
            "sweep",
            "sweep-merge",
            "hard",
            "segments",
            "borders",
            "texture",
            "reflectance",
            "splats",
            "report",
        ];
        for name in names {
            for words in [&[][..], &["--help"], &["-h"], &["a.nrrd", "--rows", "a.jsonl"]] {
                let words = ["slicecast", name].into_iter().chain(words.iter().copied());
                let failure = Cli::parse_from(words).command.unwrap().run().unwrap_err();
                assert!(failure.message.starts_with(&format!("{name}: ")), "{}", failure.message);
                assert!(failure.message.contains("--features laboratory"), "{}", failure.message);
                assert_eq!(failure.code, 2);
            }
        }
    }

    #[test]
    fn what_is_there_keeps_its_help() {
        let error = Cli::try_parse_from(["slicecast", "--help"]).err().unwrap();
        assert_eq!(error.kind(), clap::error::ErrorKind::DisplayHelp);
        assert!(error.to_string().contains("sweep-merge"), "{error}");
    }

    #[test]
    fn no_pipeline_of_8_bits_can_be_named() {
        let error = Cli::try_parse_from(["slicecast", "--texture8", "post"]).err().unwrap();
        assert!(error.to_string().contains("--features laboratory"), "{error}");
        assert!(Cli::parse_from(["slicecast"]).texture8.is_empty());
    }
}
