//! The precision laboratory's subcommands, and the pipelines of 8 bits that `render` and `compare` show.

mod borders;
mod hard;
mod pipelines;
mod reflectance;
mod report;
mod segments;
mod sheets;
mod splats;
mod sweep;
mod sweep_table;
mod texture;

use clap::Subcommand;
use clap::builder::{EnumValueParser, ValueParser};
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::Rgb;
use slicecast_engine::threads::on_threads;
use slicecast_laboratory::texture::{self as textures, Texture8};

use super::Failure;
use super::inputs::ThreadArgs;
use super::progress::with_bar;
pub use pipelines::Texture8Arg;

#[derive(Subcommand)]
pub enum Command {
    Sweep(sweep::Args),
    SweepMerge(sweep::MergeArgs),
    Hard(hard::Args),
    Segments(segments::Args),
    Borders(borders::Args),
    Texture(Box<texture::Args>),
    Reflectance(Box<reflectance::Args>),
    Splats(Box<splats::Args>),
    Report(report::Args),
}

impl Command {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::Sweep(args) => args.run(),
            Self::SweepMerge(args) => args.run(),
            Self::Hard(args) => args.run(),
            Self::Segments(args) => args.run(),
            Self::Borders(args) => args.run(),
            Self::Texture(args) => args.run(),
            Self::Reflectance(args) => args.run(),
            Self::Splats(args) => args.run(),
            Self::Report(args) => args.run(),
        }
    }
}

/// What reads the name of a pipeline of 8 bits.
pub fn texture8() -> ValueParser {
    EnumValueParser::<Texture8Arg>::new().into()
}

/// What a pipeline of 8 bits makes of a scene.
pub fn texture_picture(prepared: &Prepared<'_>, pipeline: Texture8Arg, threads: &ThreadArgs) -> Result<Rgb, Failure> {
    let picture = on_threads(threads.count(), || {
        textures::figures::picture(prepared, pipeline.into())
    })?;
    Ok(picture?)
}

/// The table of pipelines of 8 bits, and the same as JSON.
pub fn compare_textures(
    prepared: &Prepared<'_>,
    pipelines: &[Texture8Arg],
    threads: &ThreadArgs,
) -> Result<[String; 2], Failure> {
    let pipelines: Vec<Texture8> = pipelines.iter().copied().map(Texture8::from).collect();
    let lines = with_bar("comparing", |progress| {
        on_threads(threads.count(), || textures::compare(prepared, &pipelines, progress))
    })??;
    let json = serde_json::to_string_pretty(&lines).map_err(Failure::machine)?;
    Ok([pipelines::table(&lines).to_string(), json])
}
