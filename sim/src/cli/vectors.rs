//! `slicecast vectors`.

use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::{Value, json};
use slicecast_engine::frame::Prepared;
use slicecast_vectors::answer::{self, Divergence};
use slicecast_vectors::directed;
use slicecast_vectors::files::{self, Format, MANIFEST, bytes_of_vector};
use slicecast_vectors::frame::{self, Part};
use slicecast_vectors::set::{Field, Set};

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs};
use super::output::Folder;

/// Write what goes into and comes out of every stage, for a device or an RTL bench; or compare what one made of it.
///
/// --directed: the extremes, ties and halves of every stage, for all three precisions. Without it, a frame: its voxels in
/// the order of slices, its table, and every stage boundary as a tap sees it. Each set NAME has NAME.in.hex and NAME.out.hex
/// ($readmemh: a word a line), NAME.in.npy and NAME.out.npy, and a place in manifest.json, which has names, widths and
/// units. docs/hardware.md says how to use them.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast vectors --directed -o directed/
  slicecast vectors scan.nrrd --scene bone.toml --only-planes 20:24 -o frame/
  slicecast vectors --directed --compare answers/        exit code 1 at the first divergence, 2 for a bad file
  slicecast vectors scan.nrrd --scene bone.toml --only-planes 20:24 --stage normal,shading --compare answers/")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// Directed vectors instead of a frame: they need no volume and no scene.
    #[arg(long, conflicts_with_all = ["volume", "scene", "only_planes", "only_rows"])]
    directed: bool,
    /// Write the vectors into this folder.
    #[arg(
        short,
        long,
        value_name = "DIR",
        required_unless_present = "compare",
        conflicts_with = "compare"
    )]
    output: Option<PathBuf>,
    /// Make the vectors again and compare the outputs in this folder, NAME.out.hex or NAME.out.npy, with them.
    #[arg(long, value_name = "DIR")]
    compare: Option<PathBuf>,
    /// Only these stages, or sets such as compact/power.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    stage: Vec<String>,
    /// Only these planes of a frame, from A up to the one before B.
    #[arg(long, value_name = "A:B", value_parser = range)]
    only_planes: Option<Range<u32>>,
    /// Only these rows of a frame (of each phase), from A up to the one before B.
    #[arg(long, value_name = "A:B", value_parser = range)]
    only_rows: Option<Range<u32>>,
    /// Form of the files; without it, both.
    #[arg(long, value_enum)]
    format: Option<FormatArg>,
    /// Refuse to write more than this, MB.
    #[arg(long, value_name = "MB", default_value_t = 256)]
    limit: u64,
    /// Replace files that were not written by slicecast, or have been changed since.
    #[arg(long, conflicts_with = "compare")]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum FormatArg {
    Hex,
    Npy,
}

/// `A:B`.
fn range(text: &str) -> Result<Range<u32>, String> {
    let parts = text
        .split_once(':')
        .and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?));
    parts
        .filter(|range: &Range<u32>| !range.is_empty())
        .ok_or_else(|| "expected A:B with A below B, like 20:24".into())
}

/// What is written or compared.
struct Vectors {
    sets: Vec<Set>,
    constants: Vec<(Field, i64)>,
    /// Where they come from, for the manifest.
    from: Value,
}

impl Args {
    /// Writes or compares.
    pub fn run(self) -> Result<(), Failure> {
        let mut vectors = if self.directed { self.directed()? } else { self.frame()? };
        self.check_stages(&vectors.sets)?;
        match (&self.output, &self.compare) {
            (Some(path), _) => {
                vectors.sets.retain(|set| self.wants(set));
                self.write(path, &vectors)
            }
            (None, Some(path)) => self.compare(path, &vectors.sets),
            (None, None) => Err(Failure::input("neither -o nor --compare")),
        }
    }

    fn formats(&self) -> Vec<Format> {
        match self.format {
            None => Format::ALL.to_vec(),
            Some(FormatArg::Hex) => vec![Format::Hex],
            Some(FormatArg::Npy) => vec![Format::Npy],
        }
    }

    fn directed(&self) -> Result<Vectors, Failure> {
        let sets = directed::sets();
        let formats = self.formats();
        let bytes: u64 = sets
            .iter()
            .map(|set| set.len() as u64 * bytes_of_vector(set, &formats))
            .sum();
        let count: usize = sets.iter().map(Set::len).sum();
        self.announce(&format!("{} sets, {count} vectors", sets.len()), bytes)?;
        Ok(Vectors {
            sets,
            constants: Vec::new(),
            from: json!("directed"),
        })
    }

    fn frame(&self) -> Result<Vectors, Failure> {
        let loaded = self.volume.load()?;
        let scene = self.scene.load_for(&self.volume, &loaded)?;
        let prepared = Prepared::new(&scene, &loaded.volume)?;
        prepared.check_staged()?;
        let part = self.part(&Part::whole(&prepared.setup.plan))?;
        let [samples, bytes] = frame::at_most(&prepared, &part, &self.formats());
        self.announce(&format!("at most {samples} samples"), bytes)?;
        let frame = frame::sets(&prepared, &part)?;
        Ok(Vectors {
            sets: frame.sets,
            constants: frame.constants,
            from: json!({
                "volume": prepared.volume.name,
                "scene": self.scene.name(),
                "precision": scene.precision.name(),
                "planes": [part.planes.start, part.planes.end],
                "rows": [part.rows.start, part.rows.end],
            }),
        })
    }

    /// The part that is asked for.
    fn part(&self, whole: &Part) -> Result<Part, Failure> {
        let within = |flag: &str, asked: &Option<Range<u32>>, all: &Range<u32>| match asked {
            None => Ok(all.clone()),
            Some(asked) if asked.end <= all.end => Ok(asked.clone()),
            Some(asked) => Err(Failure::input(format!(
                "{flag} {}:{}: the frame ends at {}",
                asked.start, asked.end, all.end
            ))),
        };
        Ok(Part {
            planes: within("--only-planes", &self.only_planes, &whole.planes)?,
            rows: within("--only-rows", &self.only_rows, &whole.rows)?,
        })
    }

    /// Says what the files take, and refuses too much before it is made.
    fn announce(&self, what: &str, bytes: u64) -> Result<(), Failure> {
        let megabytes = bytes.div_ceil(1_000_000);
        if self.output.is_some() {
            eprintln!("{what}, {megabytes} MB of files");
        }
        if megabytes > self.limit {
            return Err(Failure::input(format!(
                "{what} would take {megabytes} MB, more than --limit {}; --only-planes A:B and --only-rows A:B take a part, \
                 --format hex or npy one form",
                self.limit
            )));
        }
        Ok(())
    }

    /// Whether a set is of a stage that is asked for.
    fn wants(&self, set: &Set) -> bool {
        self.stage.is_empty() || self.stage.iter().any(|name| set.stage == name || set.name == *name)
    }

    /// Refuses names of no stage.
    fn check_stages(&self, sets: &[Set]) -> Result<(), Failure> {
        let known = |name: &String| sets.iter().any(|set| set.stage == name || set.name == *name);
        let Some(unknown) = self.stage.iter().find(|name| !known(name)) else {
            return Ok(());
        };
        let mut stages: Vec<&str> = Vec::new();
        for set in sets {
            if !stages.contains(&set.stage) {
                stages.push(set.stage);
            }
        }
        Err(Failure::input(format!(
            "--stage {unknown}: no such stage here; there are: {}",
            stages.join(", ")
        )))
    }

    fn write(&self, path: &Path, vectors: &Vectors) -> Result<(), Failure> {
        let formats = self.formats();
        let mut folder = Folder::open(path, self.force)?;
        let mut names = vec![MANIFEST.to_owned()];
        for set in &vectors.sets {
            for (side, _) in files::sides(set) {
                names.extend(formats.iter().map(|format| files::name(set, side, *format)));
            }
        }
        folder.check(&names)?;
        for set in &vectors.sets {
            for (side, values) in files::sides(set) {
                for format in &formats {
                    let contents = files::contents(values, *format).map_err(Failure::machine)?;
                    folder.write(&files::name(set, side, *format), &contents)?;
                }
            }
        }
        let manifest = files::manifest(&vectors.sets, &formats, &vectors.from, &vectors.constants);
        folder.write(MANIFEST, &manifest.map_err(Failure::machine)?)?;
        let count: usize = vectors.sets.iter().map(Set::len).sum();
        println!(
            "{}: {} sets, {count} vectors, {} files",
            path.display(),
            vectors.sets.len(),
            names.len()
        );
        Ok(())
    }

    /// Compares what is in a folder with the outputs of the sets.
    fn compare(&self, path: &Path, sets: &[Set]) -> Result<(), Failure> {
        let (mut departures, mut vectors, mut compared) = (Vec::new(), 0, 0);
        let answered = |set: &Set| !set.outputs.fields.is_empty() && self.wants(set);
        for (number, set) in sets.iter().enumerate().filter(|(_, set)| answered(set)) {
            for divergence in departures_of(path, set)? {
                departures.push((number, divergence));
            }
            vectors += set.len();
            compared += 1;
        }
        if compared == 0 {
            return Err(Failure::input(
                "--stage: only memories are named, which have no outputs to compare",
            ));
        }
        for (_, Divergence { set, departing, of, .. }) in &departures {
            println!("{set}: {departing} of {of} vectors depart");
        }
        match answer::earliest(sets, &departures) {
            Some(first) => Err(Failure::machine(first)),
            None => {
                let shown = path.display();
                println!("{shown}: {compared} sets, {vectors} vectors, all as the pipeline has them");
                Ok(())
            }
        }
    }
}

/// The first departure in each file that there is of a set.
fn departures_of(path: &Path, set: &Set) -> Result<Vec<Divergence>, Failure> {
    let (mut departures, mut there) = (Vec::new(), false);
    for format in Format::ALL {
        let file = path.join(files::name(set, "out", format));
        let bytes = match fs::read(&file) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(Failure::input(format!("{}: {error}", file.display()))),
        };
        there = true;
        let values = answer::read(&set.outputs, format, &bytes);
        let values = values.map_err(|error| Failure::input(format!("{}: {error}", file.display())))?;
        departures.extend(answer::first(set, &values));
    }
    if there {
        Ok(departures)
    } else {
        let [hex, npy] = Format::ALL.map(|format| path.join(files::name(set, "out", format)));
        Err(Failure::input(format!(
            "{}: missing, and so is {}; --stage compares only the stages that are named",
            hex.display(),
            npy.display()
        )))
    }
}
