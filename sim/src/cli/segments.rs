//! `slicecast segments`.

use std::path::PathBuf;

use slicecast_laboratory::segments::figures::{Error, Figures, run};

use super::Failure;
use super::output::{check_free, write_file};
use super::progress::with_bar;
use super::tables::header;

/// Compare ways of classifying segments: two-dimensional tables, integrals, and samples of many planes.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast segments
  slicecast segments --json segments.json")]
pub struct Args {
    /// Fewer rays, smaller fields and tables.
    #[arg(long)]
    reduced: bool,
    /// Write the figures as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// Runs the comparison.
    pub fn run(self) -> Result<(), Failure> {
        check_free(&self.json, self.force)?;
        let figures = with_bar("segments", |progress| run(self.reduced, progress));
        println!("Errors in steps of 1/255, mean / maximum. Times are of one thread.");
        figures.iter().for_each(print);
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(&figures).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        Ok(())
    }
}

fn print(figures: &Figures) {
    let pair = |[mean, most]: [f64; 2]| format!("{mean:.3} / {most:.2}");
    let mut errors = header(&["way", "planes", "piecewise-linear", "trilinear", "worth planes"]);
    let dash = || "-".to_owned();
    for Error {
        way,
        planes,
        linear,
        trilinear,
        worth,
    } in &figures.errors
    {
        errors.add_row([
            way.clone(),
            planes.to_string(),
            linear.map_or_else(dash, pair),
            pair(*trilinear),
            worth.map_or_else(dash, |planes| format!("{planes:.1}")),
        ]);
    }
    let mut times = header(&[
        "table",
        "ordered ms",
        "integrals ms",
        "unattenuated ms",
        "ordered : unattenuated",
        "local ms",
        "local share",
    ]);
    for time in &figures.times {
        times.add_row([
            format!("{0}²", time.side),
            format!("{:.1}", time.ordered),
            format!("{:.2}", time.integrals),
            format!("{:.2}", time.unattenuated),
            format!("{:.0}", time.ordered / time.unattenuated),
            format!("{:.1}", time.local),
            format!("{:.3}", time.share),
        ]);
    }
    println!("\n{}\n\n{errors}\n\n{times}", figures.case);
}
