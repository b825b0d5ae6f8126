//! `slicecast merge`.

use std::fs;
use std::path::PathBuf;

use super::Failure;
use super::inputs::ThreadArgs;
use super::picture::{FinishArgs, Target};
use crate::raster::png;
use crate::shards::Merged;

/// Put the shards of a frame together, which several machines have rendered: the same picture as of one.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast render scan.nrrd --scene bone.toml --shard 1/2 -o part-1.shard     one machine
  slicecast render scan.nrrd --scene bone.toml --shard 2/2 -o part-2.shard     another
  slicecast merge part-*.shard -o bone.png")]
pub struct Args {
    /// All shards of the frame, in any order.
    #[arg(required = true, value_name = "SHARD")]
    shards: Vec<PathBuf>,
    #[command(flatten)]
    finish: FinishArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// The picture, a PNG; - is standard output.
    #[arg(short, long, value_name = "FILE", default_value = "image.png")]
    output: PathBuf,
    /// Replace the output if it exists.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// Writes the picture.
    pub fn run(self) -> Result<(), Failure> {
        let target = Target::checked(&self.output, vec![self.output.clone()], self.force)?;
        let mut merged = Merged::default();
        for path in &self.shards {
            let name = path.display().to_string();
            let file = fs::read(path).map_err(|error| Failure::input(format!("{name}: {error}")))?;
            let added = merged.add(&name, &file);
            added.map_err(|error| Failure::input(format!("{name}: {error}")))?;
        }
        let (frame, picture, background) = merged.frame(self.threads.simd()).map_err(Failure::input)?;
        if frame.base.planes[3].iter().all(|bits| *bits == frame.base.one) {
            eprintln!("warning: no ray of the frame meets anything; the picture shows its background");
        }
        let raster = self.finish.raster(frame, &picture, background);
        let [width, height] = raster.size();
        let png = png(&raster).map_err(Failure::machine)?;
        let said = format!("{width} x {height} pixels, of {} shards", self.shards.len());
        target.write(self.force, &[png], &said)
    }
}
