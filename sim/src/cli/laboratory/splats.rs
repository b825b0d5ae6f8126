//! `slicecast splats`.

use slicecast_engine::threads::on_threads;
use slicecast_laboratory::splats::{Line, Way, Widths, lines};

use crate::cli::Failure;
use crate::cli::inputs::{SceneArgs, ThreadArgs, VolumeArgs, whole_in};
use crate::cli::output::JsonArgs;
use crate::cli::picture::size;
use crate::cli::progress::with_bar;
use crate::cli::tables::{header, short};

/// Compare splatting with rays by the widths of its records: error against f64 and against the integral, and time.
///
/// Rays, records of 11, 8 and 12 bits (fine) and Squeeze's of 13, 8 and 8 (paper) come first; then each part of a record is varied
/// alone. `rounded` is the mean error of f64 with records so rounded against f64 of exact ones, then the largest; `equal %` and what
/// follows is the pipeline's image against the same; `integral` is the mean error of the 8-bit picture against the integral along rays
/// (in perspective, f64 of 8 planes per voxel), in steps of 1/255 all; `time`, from the voxels to the picture on one thread, is in that
/// of rays. Widths that no record of 64 bits has are tried in f64 alone. JSON has milliseconds and numbers of samples and records too.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast splats --planes 1 --rays 1
  slicecast splats ct.nrrd --scene ct-bone --fov 60 --size 256x256 --position 4,6,8,10,12,13 --json bits.json
  slicecast render ct.nrrd --scene ct-bone --splat=paper -o bone.png")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Pixels of the pictures; without it, the scene's or the natural size.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Fraction bits of x and y, 0 to 24 each; records have 6 to 13.
    #[arg(long, value_name = "BITS,...", value_delimiter = ',', default_value = "6,8,10,11,12,13", value_parser = whole_in(0..=24))]
    position: Vec<u32>,
    /// Bits of u, the depth between two sheets, 0 to 24 each; records have 1 to 10.
    #[arg(long, value_name = "BITS,...", value_delimiter = ',', default_value = "4,6,8,10", value_parser = whole_in(0..=24))]
    depth: Vec<u32>,
    /// Bits of v, the value, 1 to 12 each; records have 4 to 12.
    #[arg(long, value_name = "BITS,...", value_delimiter = ',', default_value = "6,8,10,12", value_parser = whole_in(1..=12))]
    value: Vec<u32>,
    /// Frames of each, of which the shortest counts.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    rounds: u32,
    #[command(flatten)]
    json: JsonArgs,
}

impl Args {
    /// Runs the comparison.
    pub fn run(self) -> Result<(), Failure> {
        self.json.check_free()?;
        let loaded = self.volume.load()?;
        let mut chosen = self.scene.choose(&self.volume, &loaded)?;
        chosen.scene.image.size = self.size.or(chosen.scene.image.size);
        let widths = Widths {
            position: self.position,
            depth: self.depth,
            value: self.value,
        };
        let lines = with_bar("records", |progress| {
            on_threads(self.threads.count(), || {
                lines(&chosen.scene, &loaded.volume, &widths, self.rounds, progress)
            })
        })??;
        print(&lines);
        self.json.write(&lines)
    }
}

fn named(way: Way) -> String {
    match way {
        Way::Rays => "rays".into(),
        Way::Fine => "fine".into(),
        Way::Paper => "paper".into(),
        Way::Position(bits) => format!("x, y: {bits}"),
        Way::Depth(bits) => format!("u: {bits}"),
        Way::Value(bits) => format!("v: {bits}"),
    }
}

fn print(lines: &[Line]) {
    let mut table = header(&[
        "picture", "record", "rounded", "max", "equal %", "mean", "max", "integral", "dB", "time",
    ]);
    let none = || "-".to_owned();
    for line in lines {
        let rounded = line
            .rounded
            .map(|found| (short(found.mean_lsb8), short(found.max_lsb8)));
        let (rounded_mean, rounded_max) = rounded.unwrap_or_else(|| (none(), none()));
        let made = line.made.as_ref();
        let record = made.and_then(|made| made.record);
        let image = made.and_then(|made| made.image);
        let of = |figure: Option<f64>, said: &dyn Fn(f64) -> String| figure.map_or_else(none, said);
        table.add_row([
            named(line.way),
            record.map_or_else(none, |[position, depth, value]| format!("{position}, {depth}, {value}")),
            rounded_mean,
            rounded_max,
            of(image.map(|image| image.equal_percent), &|equal| format!("{equal:.2}")),
            of(image.map(|image| image.mean_lsb8), &short),
            of(image.map(|image| image.max_lsb8), &short),
            of(made.map(|made| made.picture.mean_lsb8), &short),
            of(made.and_then(|made| made.picture.psnr_db), &|db| format!("{db:.1}")),
            of(made.map(|made| made.against_rays), &|ratio| format!("{ratio:.1}")),
        ]);
    }
    println!("{table}");
}
