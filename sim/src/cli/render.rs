//! `slicecast render`.

use std::path::PathBuf;

use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::threads::on_threads;
use slicecast_engine::tiles::TILE_ROWS;

use super::Failure;
use super::inputs::{SceneArgs, ThreadArgs, VolumeArgs, size};
use super::output::{png, write_file};
use super::progress::with_bar;

/// Render a volume to a PNG picture.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast render -o head.png
  slicecast render scan.nrrd --scene bone.toml --precision wide --size 800x600 -o bone.png
  slicecast render voxels.raw --raw-dims 256x256x128 --raw-type uint8 --scene fog.toml -o fog.png")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Size of the picture; without it, the scene's, or large enough for every ray.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// The picture.
    #[arg(short, long, value_name = "FILE", default_value = "image.png")]
    output: PathBuf,
    /// Push the slices one by one through the stream layer, as firmware does.
    #[arg(long)]
    stream: bool,
    /// Replace the output if it exists.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// Does it.
    pub fn run(self) -> Result<(), Failure> {
        if !self.force && self.output.symlink_metadata().is_ok() {
            return Err(Failure::input(format!(
                "{} exists; --force replaces it",
                self.output.display()
            )));
        }
        let loaded = self.volume.load()?;
        let mut scene = self.scene.load_for(&self.volume, &loaded)?;
        if let Some(size) = self.size {
            scene.image.size = Some(size);
        }
        let prepared = Prepared::new(&scene, &loaded.volume)?.with_simd(self.threads.simd());
        let layer = if self.stream {
            Layer::Stream
        } else {
            Layer::Tiles(TILE_ROWS)
        };
        let frame = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || prepared.render(layer, progress))
        })??;
        write_file(&self.output, self.force, &png(&frame.picture)?)?;
        let [width, height] = frame.picture.size;
        println!("{}: {width} x {height} pixels", self.output.display());
        Ok(())
    }
}
