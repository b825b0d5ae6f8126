//! `slicecast report`.

use std::io::{self, IsTerminal as _};
use std::path::PathBuf;

use slicecast_compare::{ModelPositions, compare, split};
use slicecast_engine::frame::Prepared;
use slicecast_engine::key::key;
use slicecast_engine::threads::on_threads;
use slicecast_laboratory::hard::{self, Size};
use slicecast_laboratory::report::{Contents, page::page};
use slicecast_laboratory::rows::Row;
use slicecast_laboratory::{catalogue, choose, shards, sweep};
use slicecast_scene::{Blend, Interpolation, PrecisionName, Scene};

use super::sweep::{merge_all, read_all};
use crate::cli::Failure;
use crate::cli::inputs::{SceneArgs, ThreadArgs, VolumeArgs};
use crate::cli::output::{check_free, write_file};
use crate::cli::progress::with_bar;

/// Write a report: one HTML page with pictures, errors, speed against error and the hard cases; it needs no network.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast report -o head.html
  slicecast sweep scan.nrrd --scene ct-bone --rows bone.jsonl
  slicecast report scan.nrrd --scene ct-bone --rows bone.jsonl -o bone.html")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// The page.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Rows of a finished sweep of the same inputs; without any, the sweep is run now.
    #[arg(long, value_name = "FILE")]
    rows: Vec<PathBuf>,
    #[command(flatten)]
    without: Without,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// What a report may leave out.
#[derive(clap::Args)]
struct Without {
    /// Leave out speed against error.
    #[arg(long, conflicts_with = "rows")]
    no_sweep: bool,
    /// Leave out the hard cases. Those of a report are the reduced form of what `slicecast hard` runs.
    #[arg(long)]
    no_hard: bool,
    /// Leave out the error of the algorithm, against the converged integral.
    #[arg(long)]
    no_converged: bool,
}

impl Args {
    /// Writes the report.
    pub fn run(self) -> Result<(), Failure> {
        check_free([&self.output], self.force)?;
        let loaded = self.volume.load()?;
        let scene = self.scene.load_for(&self.volume, &loaded)?;
        if scene.blend != Blend::FrontToBack {
            return Err(Failure::input(
                "a report is of a scene composited front to back; the scene's blend is another one",
            ));
        }
        let prepared = Prepared::new(&scene, &loaded.volume)?;
        let rows = self.sweep(&prepared)?;
        let mut comparisons = Vec::new();
        for precision in PrecisionName::STAGED {
            // The table of each precision is its own, unless the scene asks for one.
            let scene = Scene {
                precision,
                ..scene.clone()
            };
            let prepared = Prepared::new(&scene, &loaded.volume)?;
            let comparison = with_titled_bar(
                &format!("{}: comparing with the f64 model", precision.name()),
                |progress| {
                    on_threads(self.threads.count(), || {
                        compare(&prepared, ModelPositions::Pipeline, progress)
                    })
                },
            )??;
            comparisons.push((precision.name(), comparison));
        }
        let shown = PrecisionName::STAGED
            .iter()
            .position(|p| *p == scene.precision)
            .unwrap_or(0);
        // The integral is of values between voxels.
        let split = if self.without.no_converged || scene.interpolation == Interpolation::Nearest {
            None
        } else {
            let name = PrecisionName::STAGED[shown].name();
            Some(with_titled_bar(
                &format!("{name}: comparing with the converged integral"),
                |progress| {
                    on_threads(self.threads.count(), || {
                        split(&prepared, &comparisons[shown].1, progress)
                    })
                },
            )??)
        };
        let cases = if self.without.no_hard {
            Vec::new()
        } else {
            with_titled_bar("hard cases", |progress| hard::run(Size::Reduced, progress))?
        };
        let contents = Contents {
            prepared: &prepared,
            scene_name: &self.scene.name(),
            mapping: loaded.report.to_string(),
            comparisons,
            shown,
            split,
            rows,
            cases,
        };
        let page = page(&contents).map_err(Failure::machine)?;
        write_file(&self.output, self.force, page.as_bytes())?;
        println!("{}: {} bytes", self.output.display(), page.len());
        Ok(())
    }

    /// The rows of a sweep: those of files, or new ones.
    fn sweep(&self, prepared: &Prepared<'_>) -> Result<Vec<Row>, Failure> {
        if self.without.no_sweep {
            return Ok(Vec::new());
        }
        if !self.rows.is_empty() {
            let key = key(prepared);
            let mut files = read_all(&self.rows)?;
            // A file may hold rows of other inputs as well; one that holds no others was not meant.
            for (path, rows) in &mut files {
                let problem = rows.first().and_then(|row| shards::difference(&key, &row.key));
                rows.retain(|row| row.key == key);
                if let (true, Some(problem)) = (rows.is_empty(), problem) {
                    return Err(Failure::input(format!(
                        "{}: has rows of {problem} only, expected some of this volume and scene",
                        path.display()
                    )));
                }
            }
            return merge_all(files);
        }
        let all = catalogue::all();
        let chosen: Vec<usize> = (0..all.len()).collect();
        let chosen = choose::applicable(&all, &chosen, prepared.scene.lighting.is_some());
        let chosen = choose::knowing(&all, &chosen, prepared.scene);
        let options = sweep::Options {
            rounds: 5,
            timing_threads: 1,
        };
        let mut rows = Vec::new();
        with_titled_bar("sweeping", |progress| {
            on_threads(self.threads.count(), || {
                sweep::run::<Failure>(
                    std::slice::from_ref(prepared),
                    &all,
                    &chosen,
                    options,
                    progress,
                    |batch| {
                        rows.extend_from_slice(batch);
                        Ok(())
                    },
                )
            })
        })??;
        Ok(shards::merge(rows)?)
    }
}

/// As [`with_bar`], for a part of a longer job: where there is no bar, its title is told when it begins.
fn with_titled_bar<R>(title: &str, work: impl FnOnce(&(dyn Fn(usize, usize) + Sync)) -> R) -> R {
    if !io::stderr().is_terminal() {
        eprintln!("{title}");
    }
    with_bar(title, work)
}
