//! `slicecast segments`.

use std::path::{Path, PathBuf};

use slicecast_engine::image::Rgb;
use slicecast_laboratory::segments::curves::{self, Curve, Frame, Worth};
use slicecast_laboratory::segments::figures::{Error, Figures, run};
use slicecast_laboratory::segments::pictures::{self, Figure};
use slicecast_laboratory::segments::plot;

use super::sheets::in_a_row;
use crate::cli::Failure;
use crate::cli::output::{Folder, check_free, write_file};
use crate::cli::progress::with_bar;
use crate::cli::tables::header;
use crate::lettering::captioned;
use crate::raster::rgb_png;

/// Pixels along an edge of a picture of a figure.
const SIDE: u32 = 240;

/// Compare ways of classifying segments: two-dimensional tables, integrals, and samples of many planes.
///
/// With --curves whole frames are rendered instead: errors and times of samples and of segments of several planes per voxel, and
/// how many planes of samples one of segments is worth.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast segments
  slicecast segments --json segments.json
  slicecast segments --curves --plot curves.svg
  slicecast segments --figures figures")]
pub struct Args {
    /// Fewer rays, smaller fields and tables.
    #[arg(long)]
    reduced: bool,
    /// Error against time of whole frames.
    #[arg(long)]
    curves: bool,
    /// Render the paper's figures 7 to 10 into this folder instead: figure-7.png and so on.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["curves", "json", "reduced"])]
    figures: Option<PathBuf>,
    /// Draw the curves as SVG.
    #[arg(long, value_name = "FILE", requires = "curves")]
    plot: Option<PathBuf>,
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
        check_free(&self.plot, self.force)?;
        if self.curves {
            return self.curves();
        }
        if let Some(folder) = &self.figures {
            return self.pictures(folder);
        }
        let figures = with_bar("segments", |progress| run(self.reduced, progress));
        println!("Errors in steps of 1/255, mean / maximum. Times are of one thread.");
        figures.iter().for_each(print);
        self.write_json(&figures)
    }

    /// The frames of every scene.
    fn curves(self) -> Result<(), Failure> {
        let curves = with_bar("segments", |progress| curves::run(self.reduced, progress))?;
        println!(
            "Errors of the base plane in steps of 1/255, mean / maximum, wide, against the converged integral; of whole rays, \
             which cross no side of the volume, the mean. Milliseconds of one processor, the base plane alone."
        );
        curves.iter().for_each(print_curve);
        if let Some(path) = &self.plot {
            let svg = plot::curves(&curves).map_err(Failure::machine)?;
            write_file(path, self.force, svg.as_bytes())?;
        }
        self.write_json(&curves)
    }

    /// The paper's figures, each as a row of pictures.
    fn pictures(&self, folder: &Path) -> Result<(), Failure> {
        let name = |number: u32| format!("figure-{number}.png");
        let mut folder = Folder::open(folder, self.force)?;
        folder.check(&pictures::NUMBERS.map(name))?;
        for Figure { number, parts } in pictures::figures(SIDE)? {
            let parts: Vec<Rgb> = (parts.into_iter())
                .map(|(words, picture)| captioned(picture, words))
                .collect();
            let png = rgb_png(in_a_row(&parts)).map_err(Failure::machine)?;
            println!("{}", folder.write(&name(number), &png)?.display());
        }
        Ok(())
    }

    fn write_json<T: serde::Serialize>(&self, figures: &T) -> Result<(), Failure> {
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(figures).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        Ok(())
    }
}

fn print_curve(curve: &Curve) {
    let mut table = header(&[
        "way",
        "planes",
        "error",
        "whole rays",
        "ms",
        "time",
        "worth planes",
        "gain in time",
        "whole: worth",
        "gain",
    ]);
    let unit = curve.samples[0].milliseconds;
    let mut row = |way: &str, frame: &Frame, worth: [String; 4]| {
        let mut cells = vec![
            way.to_owned(),
            frame.planes.to_string(),
            format!("{:.4} / {:.2}", frame.mean, frame.most),
            format!("{:.4}", frame.whole),
            format!("{:.2}", frame.milliseconds),
            format!("{:.2}", frame.milliseconds / unit),
        ];
        cells.extend(worth);
        table.add_row(cells);
    };
    for frame in &curve.samples {
        row("samples", frame, [(); 4].map(|()| "-".to_owned()));
    }
    for (frame, Worth { all, whole, .. }) in curve.segments.iter().zip(&curve.worth) {
        let worth = [all.samples, all.gain, whole.samples, whole.gain];
        row("segments", frame, worth.map(|number| number.to_string()));
    }
    println!("\n{}\n\n{table}", curve.case);
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
