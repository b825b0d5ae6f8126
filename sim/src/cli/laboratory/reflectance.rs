//! `slicecast reflectance`.

use slicecast_engine::threads::on_threads;
use slicecast_laboratory::reflectance::{Line, lines};

use crate::cli::Failure;
use crate::cli::inputs::{SceneArgs, ThreadArgs, VolumeArgs};
use crate::cli::output::JsonArgs;
use crate::cli::progress::with_bar;
use crate::cli::tables::{header, short};

/// Compare reflectance maps with Phong's light: error and speed by nodes along an edge of the cube.
///
/// The scene is rendered without a map and with maps of 8 to 128 nodes, nearest and bilinear, in turns. Errors are those of the base
/// plane against f64, which computes light at every sample. Frames are timed on one thread.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast reflectance
  slicecast reflectance ct.nrrd --scene ct-bone --rounds 5 --json maps.json
  slicecast render ct.nrrd --scene ct-bone --reflectance 32 -o bone.png")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Frames of each configuration, of which the quickest counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100))]
    rounds: u32,
    #[command(flatten)]
    json: JsonArgs,
}

impl Args {
    /// Runs the comparison.
    pub fn run(self) -> Result<(), Failure> {
        self.json.check_free()?;
        let loaded = self.volume.load()?;
        let chosen = self.scene.choose(&self.volume, &loaded)?;
        if chosen.scene.lighting.is_none() {
            return Err(Failure::input(
                "reflectance: the scene is not lit, expected [lighting]; --light 0,0,1 lights it from the viewer",
            ));
        }
        let lines = with_bar("maps", |progress| {
            on_threads(self.threads.count(), || {
                lines(&chosen.scene, &loaded.volume, self.rounds, progress)
            })
        })??;
        print(&lines);
        self.json.write(&lines)
    }
}

fn print(lines: &[Line]) {
    let mut table = header(&[
        "map",
        "filter",
        "bytes",
        "ms to make",
        "equal %",
        "max step",
        "mean step",
        "speed, vectors",
        "speed, one lane",
    ]);
    for line in lines {
        let (map, filter) = match line.side {
            None => ("none".to_owned(), "-"),
            Some(side) => (side.to_string(), if line.bilinear { "bilinear" } else { "nearest" }),
        };
        let [vectors, scalar] = line.speed;
        table.add_row([
            map,
            filter.to_owned(),
            line.bytes.to_string(),
            short(line.made),
            format!("{:.2}", line.image.equal_percent),
            short(line.image.max_lsb8),
            short(line.image.mean_lsb8),
            format!("{vectors:.2}"),
            format!("{scalar:.2}"),
        ]);
    }
    println!("{table}");
}
