//! `slicecast turntable`.

use std::path::PathBuf;

use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::Rgb;
use slicecast_engine::oriented::{Oriented, with_slices};
use slicecast_engine::threads::on_threads;
use slicecast_engine::tiles::TILE_ROWS;
use slicecast_scene::Scene;

use super::Failure;
use super::inputs::{SceneArgs, ThreadArgs, VolumeArgs, size};
use super::output::{png, write_file};
use super::progress::with_bar;

/// Render a volume from all sides: an animated PNG, or numbered pictures.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast turntable scan.nii.gz -o head.png
  slicecast turntable --frames 72 --numbered -o frames/head.png    writes frames/head-000.png …")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
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
    /// Size of the pictures; without it, the scene's, or large enough for every ray of every picture.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// The animation, or the pattern of the pictures' names.
    #[arg(short, long, value_name = "FILE", default_value = "turntable.png")]
    output: PathBuf,
    /// Replace outputs that exist.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// Does it.
    pub fn run(self) -> Result<(), Failure> {
        let names = self.names();
        if let Some(there) = names.iter().find(|name| !self.force && name.symlink_metadata().is_ok()) {
            return Err(Failure::input(format!(
                "{} exists; --force replaces it",
                there.display()
            )));
        }
        let loaded = self.volume.load()?;
        let mut scene = self.scene.load_for(&self.volume, &loaded)?;
        let scenes: Vec<Scene> = (0..self.frames).map(|frame| self.turned(&scene, frame)).collect();
        if let Some(size) = self.size.or(scene.image.size) {
            scene.image.size = Some(size);
        } else {
            // One size for all, that of the largest.
            let mut largest = [1; 2];
            for scene in &scenes {
                let Prepared { setup, .. } = Prepared::new(scene, &loaded.volume)?;
                largest = [0, 1].map(|side| largest[side].max(setup.picture.size[side]));
            }
            scene.image.size = Some(largest);
        }
        let total = usize::from(self.frames);
        let pictures = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || {
                let scenes: Vec<Scene> = (0..self.frames).map(|frame| self.turned(&scene, frame)).collect();
                let prepared = scenes.iter().map(|scene| Prepared::new(scene, &loaded.volume));
                let prepared: Vec<_> = prepared.collect::<Result<_, _>>()?;
                let mut pictures = Vec::with_capacity(total);
                let seen = |p: &Prepared<'_>| (p.setup.plan.view().major(), p.setup.plan.view().reversed());
                // Slices are made once for all frames in a row that look along the same axis.
                for run in prepared.chunk_by(|a, b| seen(a) == seen(b)) {
                    with_slices(&loaded.volume, run[0].setup.plan.view(), |slices| {
                        let volume = Oriented::of(slices);
                        for frame in run {
                            let frame = frame.clone().with_simd(self.threads.simd());
                            let made = frame.render_oriented(&volume, Layer::Tiles(TILE_ROWS), &|_, _| {})?;
                            pictures.push(made.picture);
                            progress(pictures.len(), total);
                        }
                        Ok::<_, RenderError>(())
                    })
                    .map_err(RenderError::from)??;
                }
                Ok::<_, Failure>(pictures)
            })
        })??;
        if self.numbered {
            for (name, picture) in names.iter().zip(&pictures) {
                write_file(name, self.force, &png(picture)?)?;
            }
        } else {
            write_file(&self.output, self.force, &animated(&pictures, self.delay)?)?;
        }
        let [width, height] = pictures.first().map_or([0; 2], |picture| picture.size);
        println!(
            "{}: {total} pictures of {width} x {height} pixels",
            self.output.display()
        );
        Ok(())
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
        (0..self.frames).map(numbered).collect()
    }
}

/// An endless animated PNG.
fn animated(pictures: &[Rgb], delay: u16) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let [width, height] = pictures.first().map_or([1; 2], |picture| picture.size);
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let encode = |mut encoder: png::Encoder<'_, &mut Vec<u8>>| {
        encoder.set_animated(pictures.len() as u32, 0)?;
        encoder.set_frame_delay(delay, 1000)?;
        let mut writer = encoder.write_header()?;
        for picture in pictures {
            writer.write_image_data(&picture.bytes)?;
        }
        writer.finish()
    };
    encode(encoder).map_err(Failure::machine)?;
    Ok(bytes)
}
