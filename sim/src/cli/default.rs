//! The main job: the built-in volume through the whole machine.

use std::path::PathBuf;

use slicecast_compare::image::{heat_map, model_picture};
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
use crate::raster::rgb_png;

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

/// A difference of this many steps of 1/255 is white in the heat map: from here on an 8-bit value may be another.
const HEAT_FULL: f64 = 0.5;

fn names() -> Vec<String> {
    let per_precision = |p: PrecisionName| {
        let name = p.name();
        [
            format!("head-{name}.png"),
            format!("head-{name}-difference.png"),
            format!("head-{name}.json"),
        ]
    };
    let mut names: Vec<String> = PrecisionName::ALL.into_iter().flat_map(per_precision).collect();
    names.push("head-model.png".into());
    names
}

impl Args {
    /// Does it.
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
        for precision in PrecisionName::ALL {
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
            let heat = heat_map(&comparison.frame.base, &comparison.model, HEAT_FULL);
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
        println!("Differences: base plane, black is none, white {HEAT_FULL} of a step of 1/255 or more.\n");
        for path in written {
            println!("wrote {}", path.display());
        }
        Ok(())
    }
}
