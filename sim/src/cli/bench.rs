//! `slicecast bench`.

use std::path::PathBuf;
use std::time::Instant;

use clap::builder::RangedU64ValueParser;
use serde::Serialize;
use slicecast_bench::scenes::{Fog, SIDES, cube, cube_bytes, everything, fog};
use slicecast_bench::ways::{FOV, WayRow, measure_ways};
use slicecast_bench::{Beside, Engine, Row, Subject, Threads, beside, measure};
use slicecast_engine::error::RenderError;
use slicecast_engine::simd::Simd;
use slicecast_scene::{Blend, Borders, PrecisionName, Scene};
use slicecast_volume::Volume;

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs};
use super::output::write_file;
use super::progress::with_bar;
use super::tables;

/// Measure frames: the pipeline at each precision, vector width and number of threads, the same pipeline in f32, and the
/// definitions ray by ray.
///
/// Synthetic fog, in which nothing can be skipped, and a volume: the built-in head as bone, or the one given under the scene
/// that is named or chosen for it. All subjects of a section take turns, and the shortest time of each counts; how far the
/// others scatter is shown beside it. A frame is all sample planes folded into the base plane: no reading, no preparation, no
/// final warp. Samples are all that lie in the volume, skipped or not. Borders are whole, the only ones that f32 has. Whole
/// pictures of one size, by rays and by splats, parallel and in perspective, are timed beside each other on one thread, at
/// two planes and rays per voxel at most; splats that take more than two seconds once.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast bench
  slicecast bench scan.nrrd --scene ct-bone --rays 2 --sides 256 --json bench.json
  slicecast bench --sides 64,512 --frames 50 --full")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames that each subject renders; the shortest counts.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = RangedU64ValueParser::<usize>::new().range(1..=10_000))]
    frames: usize,
    /// Sides of the cubes of fog, voxels; `0` for none.
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "64,128,256,512", value_parser = side)]
    sides: Vec<usize>,
    /// Threads that "all" stands for; without it, one a processor.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    threads: Option<usize>,
    /// Measure every subject in every section; takes long.
    #[arg(long)]
    full: bool,
    /// Write the figures to this file as well.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
}

fn side(text: &str) -> Result<usize, String> {
    let side = text.parse().map_err(|_| "expected a number of voxels".to_owned())?;
    if side == 0 || SIDES.contains(&side) {
        Ok(side)
    } else {
        Err(format!("accepted: {} to {}", SIDES.start(), SIDES.end()))
    }
}

/// Frames of each way to a picture, at most: splats take long.
const WAYS_FRAMES: usize = 5;
/// Planes and rays per voxel of them, at most.
const WAYS_RATE: u32 = 2;

/// Who is measured in a section.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Field {
    /// Every precision and f32, with every vector, on one thread and on all.
    Vectors,
    /// Everybody without vectors, and the rays, on one thread; `compact` with vectors as well.
    Scalars,
    /// `compact`, `wide` and f32 with the widest vectors, on one thread and on all.
    Widest,
    /// The same on all threads.
    Growth,
    /// All of these.
    Everybody,
}

impl Field {
    /// The subjects, where "all" are so many threads: of one thread, each only once.
    fn subjects(self, threads: usize) -> Vec<Subject> {
        let fixed = PrecisionName::ALL.into_iter().rev().map(Engine::Fixed);
        let rays = [PrecisionName::Compact, PrecisionName::Wide].map(Engine::Rays);
        let mut subjects = Vec::new();
        for simd in Simd::available() {
            for engine in fixed.clone().chain([Engine::Float]).chain(rays) {
                for all_threads in [false, true] {
                    let subject = Subject {
                        engine,
                        simd,
                        all_threads,
                    };
                    let measured = Subject {
                        all_threads: all_threads && threads > 1,
                        ..subject
                    };
                    if self.holds(subject) && !subjects.contains(&measured) {
                        subjects.push(measured);
                    }
                }
            }
        }
        subjects
    }

    fn holds(self, subject: Subject) -> bool {
        let compact = subject.engine == Engine::Fixed(PrecisionName::Compact);
        let paper = subject.engine == Engine::Fixed(PrecisionName::Paper);
        let rays = matches!(subject.engine, Engine::Rays(_));
        let scalar = subject.simd == Simd::Scalar;
        match self {
            Self::Vectors => !scalar && !rays,
            Self::Scalars => !subject.all_threads && (scalar || compact),
            Self::Widest => subject.simd == Simd::widest() && !paper && !rays,
            Self::Growth => subject.all_threads && Self::Widest.holds(subject),
            Self::Everybody => scalar || !rays,
        }
    }
}

/// A table of results.
#[derive(Serialize)]
struct Section {
    name: String,
    dims: [usize; 3],
    samples: u64,
    rows: Vec<Row>,
    #[serde(skip_serializing_if = "Option::is_none")]
    beside: Option<Beside>,
    /// Pictures by rays and by splats, parallel and in perspective.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    ways: Vec<WayRow>,
}

/// All that is written as JSON.
#[derive(Serialize)]
struct Report {
    machine: Machine,
    version: &'static str,
    frames: usize,
    seconds: f64,
    sections: Vec<Section>,
}

/// What was measured on.
#[derive(Serialize)]
struct Machine {
    processor: String,
    architecture: &'static str,
    threads: usize,
    widths: Vec<&'static str>,
}

impl Machine {
    fn this(threads: usize) -> Self {
        let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let field = |name: &str| {
            let mut lines = information.lines().filter(|line| line.starts_with(name));
            let value = lines.next().and_then(|line| line.split(':').nth(1));
            value.map_or_else(|| "unknown".to_owned(), |value| value.trim().to_owned())
        };
        let available = Simd::available();
        Self {
            processor: format!(
                "{}, family {} model {}",
                field("model name"),
                field("cpu family"),
                // "model" is the beginning of "model name" as well.
                field("model\t")
            ),
            architecture: std::env::consts::ARCH,
            threads,
            widths: available.map(Simd::name).collect(),
        }
    }
}

/// A run of the bench.
struct Bench {
    threads: Threads,
    frames: usize,
    full: bool,
    sections: Vec<Section>,
}

impl Bench {
    /// Measures a scene and shows the table.
    fn section(&mut self, name: &str, scene: &Scene, volume: &Volume, field: Field) -> Result<(), Failure> {
        let field = if self.full { Field::Everybody } else { field };
        let (samples, rows) = with_bar(name, |progress| {
            let subjects = field.subjects(self.threads.count());
            measure(scene, volume, &subjects, self.frames, &self.threads, progress)
        })?;
        let millions = samples as f64 / 1e6;
        println!(
            "== {name}: {millions:.1} M samples per frame ==\n\n{}\n",
            tables::speed(&rows)
        );
        self.sections.push(Section {
            name: name.to_owned(),
            dims: volume.dims,
            samples,
            rows,
            beside: None,
            ways: Vec::new(),
        });
        Ok(())
    }

    /// Measures the scene's picture by rays and by splats, parallel and in perspective, on one thread, at two planes and rays
    /// per voxel at most. A scene that one of them does not know is told, and not measured.
    fn ways(&mut self, name: &str, scene: &Scene, volume: &Volume) -> Result<(), Failure> {
        let mut scene = scene.clone();
        for rate in [&mut scene.sampling.planes_per_voxel, &mut scene.sampling.rays_per_voxel] {
            *rate = (*rate).min(WAYS_RATE);
        }
        let found = with_bar(name, |progress| {
            measure_ways(
                &scene,
                volume,
                self.frames.min(WAYS_FRAMES),
                (&self.threads, false),
                progress,
            )
        });
        match found {
            Ok(rows) => {
                println!(
                    "pictures of one size, compact, samples, perspective of {FOV} degrees\n\n{}\n",
                    tables::ways(&rows)
                );
                if let Some(section) = self.sections.last_mut() {
                    section.ways = rows;
                }
                Ok(())
            }
            Err(error @ (RenderError::Unsplattable { .. } | RenderError::Splat(_) | RenderError::Camera(_))) => {
                eprintln!("note: {name}: no pictures by splats and in perspective: {error}");
                Ok(())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Measures what the section's frame costs beside its samples.
    fn beside(&mut self, scene: &Scene, volume: &Volume) -> Result<(), Failure> {
        let costs = beside(scene, volume, self.frames, &self.threads)?;
        println!(
            "compact, all threads: final warp {:.2} ms, {:.1} % of {:.2} ms; a new table {:.3} ms, decoded {:.3} ms\n\
             blocks: {:.1} % can be seen, found in {:.3} ms; measured once per volume in {:.2} ms, {:.1} MiB\n",
            costs.warp_milliseconds,
            100.0 * costs.warp_share,
            costs.fold_milliseconds + costs.warp_milliseconds,
            costs.table_milliseconds,
            costs.table_decoded_milliseconds,
            100.0 * costs.seen_share,
            costs.sight_milliseconds,
            costs.occupancy_milliseconds,
            costs.occupancy_bytes as f64 / f64::from(1 << 20)
        );
        if let Some(section) = self.sections.last_mut() {
            section.beside = Some(costs);
        }
        Ok(())
    }

    /// A cube of fog.
    fn fog(&mut self, side: usize, role: Role) -> Result<(), Failure> {
        eprintln!("fog {side}^3: {} MiB of voxels", cube_bytes(side).div_ceil(1 << 20));
        let volume = cube(side);
        let of = |lights, colourful| fog(&volume, Fog { lights, colourful });
        let field = if role.main { Field::Vectors } else { Field::Growth };
        self.section(&format!("fog {side}^3, 1 light"), &of(1, false), &volume, field)?;
        self.beside(&of(1, false), &volume)?;
        self.section(&format!("fog {side}^3, unlit"), &of(0, false), &volume, field)?;
        if role.slow {
            self.ways(&format!("fog {side}^3, unlit, ways"), &of(0, false), &volume)?;
        }
        if role.main {
            let name = format!("fog {side}^3, 8 lights");
            self.section(&name, &of(8, false), &volume, Field::Widest)?;
            let name = format!("fog {side}^3 of many colours, 1 light");
            self.section(&name, &of(1, true), &volume, Field::Widest)?;
        }
        if role.slow && !self.full {
            let name = format!("fog {side}^3, 1 light, without vectors");
            self.section(&name, &of(1, false), &volume, Field::Scalars)?;
            let name = format!("fog {side}^3, unlit, without vectors");
            self.section(&name, &of(0, false), &volume, Field::Scalars)?;
        }
        Ok(())
    }

    /// A real volume: its scene, lit as it is and unlit, and the same with nothing to skip.
    fn volume(&mut self, scene: &Scene, volume: &Volume) -> Result<(), Failure> {
        let name = &volume.name;
        let unlit = Scene {
            lighting: None,
            ..scene.clone()
        };
        let dense = Scene {
            transfer: everything(volume, false),
            ..scene.clone()
        };
        self.section(&format!("{name}, the scene"), scene, volume, Field::Widest)?;
        self.beside(scene, volume)?;
        self.ways(&format!("{name}, ways"), scene, volume)?;
        if scene.lighting.is_some() {
            self.section(&format!("{name}, the scene unlit"), &unlit, volume, Field::Widest)?;
        }
        self.section(&format!("{name}, nothing to skip"), &dense, volume, Field::Widest)?;
        self.ways(&format!("{name}, nothing to skip, ways"), &dense, volume)
    }
}

/// What else a cube of fog is used for.
#[derive(Clone, Copy)]
struct Role {
    /// Every precision, vector and number of threads; lights and colours.
    main: bool,
    /// What takes long.
    slow: bool,
}

impl Args {
    /// Times the frames.
    pub fn run(self) -> Result<(), Failure> {
        if let Some(path) = &self.json
            && !self.force
            && path.symlink_metadata().is_ok()
        {
            return Err(Failure::input(format!(
                "{} exists; --force replaces it",
                path.display()
            )));
        }
        let loaded = self.volume.load()?;
        let mut scene = self.scene.load_or("ct-bone", &self.volume, &loaded)?;
        // f32 knows no others.
        scene.borders = Borders::Whole;
        if scene.blend != Blend::FrontToBack {
            return Err(Failure::input(
                "the scene: bench measures front-to-back compositing only; --blend front-to-back",
            ));
        }
        let start = Instant::now();
        let threads = Threads::start(self.threads)?;
        let machine = Machine::this(threads.count());
        println!(
            "{}; {} threads; vectors: {}; shortest of {} frames each;\n\
             ±: half the distance between the quartiles of the frames' times, of the median\n",
            machine.processor,
            machine.threads,
            machine.widths.join(", "),
            self.frames
        );
        let mut bench = Bench {
            threads,
            frames: self.frames,
            full: self.full,
            sections: Vec::new(),
        };
        bench.volume(&scene, &loaded.volume)?;
        let sides: Vec<usize> = self.sides.iter().copied().filter(|side| *side > 0).collect();
        let nearest = |wanted: usize| sides.iter().copied().min_by_key(|side| side.abs_diff(wanted));
        for &side in &sides {
            let role = Role {
                main: nearest(256) == Some(side),
                slow: nearest(128) == Some(side),
            };
            bench.fog(side, role)?;
        }
        let report = Report {
            machine,
            version: env!("CARGO_PKG_VERSION"),
            frames: self.frames,
            seconds: start.elapsed().as_secs_f64(),
            sections: bench.sections,
        };
        println!("{:.0} s in all", report.seconds);
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(&report).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
            println!("wrote {}", path.display());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wherever "all threads" are one, nothing is measured, and shown, twice; and nothing is left out.
    #[test]
    fn one_thread_gives_each_row_once() {
        for field in [
            Field::Vectors,
            Field::Scalars,
            Field::Widest,
            Field::Growth,
            Field::Everybody,
        ] {
            let of = |threads| field.subjects(threads);
            let engines = |subjects: &[Subject]| {
                let mut names: Vec<_> = subjects.iter().map(|s| (s.engine.name(), s.simd.name())).collect();
                names.dedup();
                names
            };
            let one = of(1);
            assert!(one.iter().all(|subject| !subject.all_threads));
            assert_eq!(engines(&one).len(), one.len());
            assert_eq!(engines(&one), engines(&of(2)));
        }
        assert_eq!(Field::Widest.subjects(2).len(), 2 * Field::Widest.subjects(1).len());
    }
}
