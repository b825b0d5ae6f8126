//! `slicecast sweep` and `slicecast sweep-merge`.

use std::path::{Path, PathBuf};

use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::key::key;
use slicecast_engine::shard::Shard;
use slicecast_engine::threads::on_threads;
use slicecast_laboratory::catalogue::{self, Configuration};
use slicecast_laboratory::choose;
use slicecast_laboratory::rows::{self, Row, RowsError, Writer};
use slicecast_laboratory::shards::{merge, shard};
use slicecast_laboratory::sweep::{self, Options, SweepError};

use super::sweep_table;
use crate::cli::Failure;
use crate::cli::inputs::{SceneArgs, ThreadArgs, VolumeArgs};
use crate::cli::output::{check_free, write_file};
use crate::cli::picture;
use crate::cli::progress::with_bar;

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Render(error) => error.into(),
            _ => Self::input(error),
        }
    }
}

impl From<RowsError> for Failure {
    fn from(error: RowsError) -> Self {
        match error {
            RowsError::File { .. } => Self::machine(error),
            _ => Self::input(error),
        }
    }
}

/// Where tables go.
#[derive(clap::Args)]
struct Tables {
    /// Write the table as CSV.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the table as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

impl Tables {
    /// Refuses now what [`Tables::write`] would refuse later.
    fn check(&self) -> Result<(), Failure> {
        check_free([&self.csv, &self.json].into_iter().flatten(), self.force)
    }

    /// Prints the table and writes the files.
    fn write(&self, rows: &[Row]) -> Result<(), Failure> {
        println!("{}", sweep_table::table(rows));
        println!("\n{}", sweep_table::legend(rows));
        if let Some(path) = &self.csv {
            write_file(path, self.force, &sweep_table::csv(rows)?)?;
        }
        if let Some(path) = &self.json {
            write_file(path, self.force, &sweep_table::json(rows)?)?;
        }
        Ok(())
    }
}

/// Run the precision laboratory: errors, speed and memory of every configuration, and which of them nothing beats.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast sweep                                              every configuration on the built-in head
  slicecast sweep --list                                       the configurations and what they are made of
  slicecast sweep scan.nrrd --scene ct-bone --vary weight.bits=6..16 --vary normal.bits=4..14
  slicecast sweep scan.nrrd --scene ct-fog --views 12          which of two is more exact, not in one picture alone
  slicecast sweep scan.nrrd --scene ct-fog --rows fog.jsonl    stops and goes on where it was
  slicecast sweep scan.nrrd --scene ct-fog --rows fog-3.jsonl --shard 3/16   one of an array job
  slicecast sweep-merge fog-*.jsonl --csv fog.csv")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Only configurations that differ from `compact` in this stage and have one of these values; may be repeated.
    #[arg(long, value_name = "STAGE.WIDTH=VALUES")]
    vary: Vec<String>,
    /// Only the configurations of these names, separated by commas.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "vary")]
    only: Vec<String>,
    /// Views in which errors are taken: the scene's own, and more around the vertical axis. Frames are timed in the
    /// first.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=360))]
    views: u32,
    /// Frames of each configuration that are timed; the fastest counts.
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Threads that render the frames that are timed.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    timing_threads: u16,
    /// Keep finished rows in this file, and go on where it ends.
    #[arg(long, value_name = "FILE")]
    rows: Option<PathBuf>,
    /// Run part I of N; `sweep-merge` puts the parts together.
    #[arg(long, value_name = "I/N", value_parser = picture::shard, requires = "rows")]
    shard: Option<Shard>,
    /// List the configurations instead of running them.
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    tables: Tables,
}

impl Args {
    /// Runs the sweep.
    pub fn run(self) -> Result<(), Failure> {
        let mut all = catalogue::all();
        let mut chosen = self.chosen(&mut all)?;
        if self.list {
            println!("{}", sweep_table::list(chosen.iter().map(|index| &all[*index])));
            return Ok(());
        }
        self.tables.check()?;
        let loaded = self.volume.load()?;
        let scene = self.scene.load_for(&self.volume, &loaded)?;
        let scenes = sweep::views(&scene, self.views);
        let views = scenes.iter().map(|scene| Prepared::new(scene, &loaded.volume));
        let views: Vec<_> = views
            .map(|view| {
                let view = view?;
                view.check_points()?;
                view.check_unmodulated()?;
                view.check_linear()?;
                Ok(view.with_simd(self.threads.simd()))
            })
            .collect::<Result<_, RenderError>>()?;
        let asked = chosen.len();
        chosen = choose::applicable(&all, &chosen, scene.lighting.is_some());
        if chosen.len() < asked {
            eprintln!(
                "note: the scene is unlit: {} configurations vary shading alone and are left out",
                asked - chosen.len()
            );
        }
        let asked = chosen.len();
        chosen = choose::knowing(&all, &chosen, &scene);
        if chosen.len() < asked {
            eprintln!("note: 16-bit lanes do not know the scene (docs/contract/fast.md): `fast` is left out");
        }
        if let Some(part) = self.shard {
            chosen = shard(&chosen, part.number() as usize, part.count() as usize);
        }
        let (mut writer, mut rows) = self.resume(&views[0])?;
        rows.retain(|row| chosen.iter().any(|index| all[*index].name == row.name));
        let left: Vec<usize> = chosen
            .iter()
            .copied()
            .filter(|index| !rows.iter().any(|row| row.name == all[*index].name))
            .collect();
        if !rows.is_empty() {
            eprintln!("{} of {} configurations are finished", rows.len(), chosen.len());
        }
        let options = Options {
            rounds: self.rounds,
            timing_threads: usize::from(self.timing_threads),
        };
        with_bar("sweeping", |progress| {
            on_threads(self.threads.count(), || {
                sweep::run::<Failure>(&views, &all, &left, options, progress, |batch| {
                    if let Some(writer) = &mut writer {
                        writer.add(batch)?;
                    }
                    rows.extend_from_slice(batch);
                    Ok(())
                })
            })
        })??;
        self.tables.write(&merge(rows)?)
    }

    /// The file of rows, if there is one, and those of the same inputs that it holds. Rows that were measured in another
    /// way are refused: they could not stand in one table.
    fn resume(&self, first: &Prepared<'_>) -> Result<(Option<Writer>, Vec<Row>), Failure> {
        let Some(path) = &self.rows else {
            return Ok((None, Vec::new()));
        };
        let (writer, mut rows) = Writer::open(path)?;
        let key = key(first);
        rows.retain(|row| row.key == key);
        let how = |views, lanes: &str, threads| format!("{views} views and timed with {lanes} on {threads} threads");
        let own = how(self.views as usize, first.simd.name(), usize::from(self.timing_threads));
        for row in &rows {
            let found = how(row.views.len(), &row.lanes, row.threads);
            if found != own {
                return Err(Failure::input(format!(
                    "{}: `{}` was measured in {found}, expected {own}: give another file, or the same options",
                    path.display(),
                    row.name
                )));
            }
        }
        Ok((Some(writer), rows))
    }

    /// The configurations asked for; all without a wish.
    fn chosen(&self, all: &mut Vec<Configuration>) -> Result<Vec<usize>, Failure> {
        let mut chosen = Vec::new();
        for text in &self.vary {
            chosen.extend(choose::vary(all, text)?);
        }
        for name in &self.only {
            let index = all.iter().position(|c| c.name == *name);
            chosen.push(index.ok_or_else(|| {
                Failure::input(format!(
                    "--only: no configuration `{name}`; `slicecast sweep --list` names them"
                ))
            })?);
        }
        if self.vary.is_empty() && self.only.is_empty() {
            chosen.extend(0..all.len());
        }
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }
}

/// Put the rows of several sweeps of the same inputs together: the same table as one run would have made.
#[derive(clap::Args)]
#[command(after_help = "Example:
  slicecast sweep-merge fog-*.jsonl --csv fog.csv --json fog.json")]
pub struct MergeArgs {
    /// Files that `slicecast sweep --rows` has written.
    #[arg(required = true, value_name = "ROWS")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    tables: Tables,
}

impl MergeArgs {
    /// Merges the rows.
    pub fn run(self) -> Result<(), Failure> {
        self.tables.check()?;
        let rows = merge_all(read_all(&self.files)?)?;
        let all = catalogue::all();
        let missing = all.iter().filter(|c| !rows.iter().any(|row| row.name == c.name));
        let missing: Vec<&str> = missing.map(|c| c.name.as_str()).collect();
        if !missing.is_empty() {
            let first = missing[..missing.len().min(8)].join(", ");
            let more = if missing.len() > 8 { " ..." } else { "" };
            eprintln!(
                "note: {} of {} configurations are not in these rows: {first}{more}",
                missing.len(),
                all.len()
            );
        }
        self.tables.write(&rows)
    }
}

/// The rows of files, as they are.
pub fn read_all(files: &[PathBuf]) -> Result<Vec<(&Path, Vec<Row>)>, Failure> {
    files.iter().map(|path| Ok((path.as_path(), read_one(path)?))).collect()
}

/// Rows of files in one table.
pub fn merge_all<'a>(files: impl IntoIterator<Item = (&'a Path, Vec<Row>)>) -> Result<Vec<Row>, Failure> {
    let mut all = Vec::new();
    for (path, rows) in files {
        all.extend(rows);
        all = merge(all).map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    }
    Ok(all)
}

fn read_one(path: &Path) -> Result<Vec<Row>, Failure> {
    let found = rows::read(path)?.filter(|found| !found.rows.is_empty());
    let found = found.ok_or_else(|| {
        let path = path.display();
        Failure::input(format!(
            "{path}: has no rows, expected those that `slicecast sweep --rows {path}` writes"
        ))
    })?;
    if found.cut_off > 0 {
        eprintln!(
            "note: {}: the last row was cut off and is left out; running its sweep again completes it",
            path.display()
        );
    }
    Ok(found.rows)
}
