//! The main job: the built-in volume through the whole machine.

use std::path::PathBuf;

use slicecast_compare::image::{ImageFigures, heat_map, model_picture};
use slicecast_compare::{Comparison, ModelPositions, compare};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::threads::on_threads;
use slicecast_scene::{PrecisionName, Scene};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use super::Failure;
use super::compare::figured;
use super::inputs::ThreadArgs;
use super::output::Folder;
use super::progress::with_bar;
use super::tables;
use crate::lettering::captioned;
use crate::raster::rgb_png;
use crate::visibility::rounded;

/// Options of the main job.
#[derive(clap::Args)]
pub struct Args {
    /// Where the pictures go.
    #[arg(long, value_name = "DIR", default_value = "slicecast-out")]
    out: PathBuf,
    /// Replace files in it that slicecast did not write.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    threads: ThreadArgs,
}

fn names() -> Vec<String> {
    let per_precision = |p: PrecisionName| {
        let name = p.name();
        [
            format!("head-{name}.png"),
            format!("head-{name}-difference.png"),
            format!("head-{name}.json"),
        ]
    };
    let mut names: Vec<String> = PrecisionName::STAGED.into_iter().flat_map(per_precision).collect();
    names.push("head-model.png".into());
    names
}

/// What white stands for in a picture of differences, steps of 1/255, and that in words. The scale follows the data: the
/// differences of two precisions are orders of magnitude apart, and a single pixel would leave all others dark.
fn difference_scale(figures: &ImageFigures) -> (f64, String) {
    let largest = figures.max_lsb8;
    let full = largest.min(6.0 * figures.mean_lsb8);
    if full > 0.0 {
        let [full, largest] = [full, largest].map(|value| rounded(value, 3));
        (full, format!("white: {full} of 1/255 or more; largest: {largest}"))
    } else {
        (1.0, "no difference".into())
    }
}

impl Args {
    /// Runs the main job.
    pub fn run(self) -> Result<(), Failure> {
        let mut folder = Folder::open(&self.out, self.force)?;
        folder.check(&names())?;
        let loaded = load(None, Window::Auto)?;
        let [nx, ny, nz] = loaded.volume.dims;
        println!("CT head, {nx} x {ny} x {nz} voxels; {}", loaded.report);
        println!("scene: sim/scene/scenes/headsq.toml\n");
        let base = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).map_err(Failure::input)?;
        let mut summary = Vec::new();
        let mut written = Vec::new();
        let mut captions = Vec::new();
        for precision in PrecisionName::STAGED {
            let name = precision.name();
            let scene = Scene {
                precision,
                ..base.clone()
            };
            let prepared = Prepared::new(&scene, &loaded.volume)?.with_simd(self.threads.simd());
            let streamed = with_bar(&format!("{name}: streaming"), |progress| {
                prepared.render(Layer::Stream, progress)
            })?;
            let comparison: Comparison = with_bar(&format!("{name}: comparing"), |progress| {
                on_threads(self.threads.count(), || {
                    compare(&prepared, ModelPositions::Pipeline, progress)
                })
            })??;
            if streamed != comparison.frame {
                return Err(Failure::machine(format!(
                    "{name}: the slices streamed one by one and the volume in memory gave different bits"
                )));
            }
            println!("== {name} ==\n");
            println!("{}\n", tables::local(&comparison.stages));
            println!("{}\n", tables::carried(&comparison.stages));
            summary.extend(tables::image_lines(name, &comparison));

            let mut write = |file: String, contents: Vec<u8>| -> Result<(), Failure> {
                written.push(folder.write(&file, &contents)?);
                Ok(())
            };
            write(
                format!("head-{name}.png"),
                rgb_png(streamed.picture).map_err(Failure::machine)?,
            )?;
            let (full, caption) = difference_scale(&comparison.image);
            let heat = captioned(heat_map(&comparison.frame.base, &comparison.model, full), &caption);
            captions.push(format!("{name}: {caption}"));
            write(
                format!("head-{name}-difference.png"),
                rgb_png(heat).map_err(Failure::machine)?,
            )?;
            let figures = figured(&prepared, &comparison, ModelPositions::Pipeline);
            let json = serde_json::to_vec_pretty(&figures).map_err(Failure::machine)?;
            write(format!("head-{name}.json"), json)?;
            if precision == PrecisionName::Wide {
                let model = model_picture(&comparison.model_picture, scene.image.background);
                write("head-model.png".into(), rgb_png(model).map_err(Failure::machine)?)?;
            }
        }
        println!("== pictures against the model ==\n");
        println!("{}\n", tables::images(&summary));
        println!("Streamed slice by slice and rendered in place: the same bits at every precision.");
        println!("Differences on the base plane, black is none:");
        for caption in captions {
            println!("  {caption}");
        }
        println!();
        for path in written {
            println!("wrote {}", path.display());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_scaled_to_what_they_are() {
        let scale = |max_lsb8, mean_lsb8| {
            difference_scale(&ImageFigures {
                values: 9,
                max_lsb8,
                mean_lsb8,
                equal_percent: 99.0,
                psnr_db: None,
            })
        };
        assert_eq!(
            scale(1.5, 0.125),
            (0.75, "white: 0.75 of 1/255 or more; largest: 1.5".into())
        );
        assert_eq!(
            scale(0.0625, 0.03),
            (0.0625, "white: 0.0625 of 1/255 or more; largest: 0.0625".into())
        );
        assert_eq!(scale(0.0, 0.0), (1.0, "no difference".into()));
    }
}
