//! `slicecast turntable`.

use std::path::{Path, PathBuf};

use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::shard::Shard;
use slicecast_engine::threads::on_threads;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_scene::Scene;

use super::Failure;
use super::inputs::{SceneArgs, ThreadArgs, VolumeArgs};
use super::picture::{self, PictureArgs, Target};
use super::progress::with_bar;
use crate::raster::{animated, png};
use crate::slab::thicken;
use crate::visibility;

/// Render a volume from all sides, at one scale: an animated PNG, or numbered pictures.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast turntable scan.nii.gz -o head.png
  slicecast turntable --frames 72 --numbered -o frames/head.png    writes frames/head-000.png …
  slicecast turntable --frames 72 --numbered --shard 3/8 -o frames/head.png    head-002.png, head-010.png …")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Pictures of a full turn.
    #[arg(long, value_name = "N", default_value_t = 36, value_parser = clap::value_parser!(u16).range(1..=3600))]
    frames: u16,
    /// Milliseconds a picture.
    #[arg(long, value_name = "MS", default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..=10000))]
    delay: u16,
    /// Write numbered pictures instead of an animation.
    #[arg(long)]
    numbered: bool,
    /// Render only every N-th picture, from the I-th on, as on a machine of an array job.
    #[arg(long, value_name = "I/N", value_parser = picture::shard, requires = "numbered")]
    shard: Option<Shard>,
    /// The animation, or the pattern of the pictures' names; - is standard output, for an animation.
    #[arg(short, long, value_name = "FILE", default_value = "turntable.png")]
    output: PathBuf,
    /// Replace outputs that exist.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// Renders the turn.
    pub fn run(self) -> Result<(), Failure> {
        if self.numbered && self.output == Path::new("-") {
            return Err(Failure::input(
                "-o -: one animation goes to standard output, --numbered makes several files",
            ));
        }
        let target = Target::checked(&self.output, self.names(), self.force)?;
        let mut loaded = self.volume.load()?;
        let mut chosen = self.scene.choose(&self.volume, &loaded)?;
        self.picture.apply(&mut chosen.scene);
        if let Some(note) = thicken(&mut loaded.volume, chosen.scene.borders) {
            eprintln!("note: {note}");
        }
        let turned: Vec<Scene> = (0..self.frames)
            .map(|frame| self.turned(&chosen.scene, frame))
            .collect();
        let framing = self.picture.frame(&turned, &loaded.volume, &self.scene)?;
        let scenes: Vec<Scene> = turned
            .iter()
            .map(|scene| framing.scene(scene, &loaded.volume))
            .collect();
        let scenes: Vec<Scene> = (scenes.into_iter().enumerate())
            .filter(|(frame, _)| self.is_own(*frame))
            .map(|(_, scene)| scene)
            .collect();
        let total = scenes.len();
        let known = chosen.circumstances();
        let (pictures, warnings) = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || {
                let prepared = scenes.iter().map(|scene| Prepared::new(scene, &loaded.volume));
                let prepared: Vec<_> = prepared.collect::<Result<_, _>>()?;
                let mut pictures = Vec::with_capacity(total);
                let mut warnings = Vec::new();
                let seen = |p: &Prepared<'_>| (p.setup.plan.view().major(), p.setup.plan.view().reversed());
                // Slices are made once for all frames in a row that look along the same axis.
                for run in prepared.chunk_by(|a, b| seen(a) == seen(b)) {
                    let mut turned = Turned::new(&loaded.volume, &run[0].setup.plan);
                    let slices = turned.slices().map_err(RenderError::from)?;
                    let volume = Oriented::of(&slices);
                    for frame in run {
                        let frame = frame.clone().with_simd(self.threads.simd());
                        let made = frame.render_oriented(&volume, Layer::Tiles(TILE_ROWS), &|_, _| {})?;
                        warnings.extend(visibility::warning(&frame, &made, &known));
                        pictures.push(self.picture.raster(frame.scene, &frame.setup.picture, made));
                        progress(pictures.len(), total);
                    }
                }
                Ok::<_, Failure>((pictures, warnings))
            })
        })??;
        if let Some(warning) = warnings.first() {
            eprintln!("warning: {} of {total} pictures: {warning}", warnings.len());
        }
        let files = if self.numbered {
            pictures.iter().map(png).collect()
        } else {
            animated(&pictures, self.delay).map(|file| vec![file])
        };
        let [width, height] = framing.size;
        let said = format!("{total} pictures of {width} x {height} pixels");
        target.write(self.force, &files.map_err(Failure::machine)?, &said)
    }

    /// The scene from another side.
    fn turned(&self, scene: &Scene, frame: u16) -> Scene {
        let mut scene = scene.clone();
        scene.view = scene.view.turned(360.0 * f64::from(frame) / f64::from(self.frames));
        scene
    }

    /// The files to be written.
    fn names(&self) -> Vec<PathBuf> {
        if !self.numbered {
            return vec![self.output.clone()];
        }
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy();
        let numbered = |frame| self.output.with_file_name(format!("{stem}-{frame:03}.png"));
        let own = |frame: &u16| self.is_own(usize::from(*frame));
        (0..self.frames).filter(own).map(numbered).collect()
    }

    /// Whether a picture belongs to the shard.
    fn is_own(&self, frame: usize) -> bool {
        let Some(shard) = self.shard else { return true };
        frame % shard.count() as usize == shard.number() as usize - 1
    }
}
