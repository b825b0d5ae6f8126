//! `slicecast borders`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use slicecast_engine::image::Rgb;
use slicecast_laboratory::borders::cost::{self, Line};
use slicecast_laboratory::borders::figures::{self, Errors, Profile};
use slicecast_laboratory::borders::plot;
use slicecast_laboratory::borders::seams::{self, Seam};

use super::sheets::in_a_row;
use crate::cli::Failure;
use crate::cli::output::{Folder, check_free, write_file};
use crate::cli::progress::with_bar;
use crate::cli::tables::header;
use crate::lettering::captioned;
use crate::raster::rgb_png;

/// Compare borders: rays of whole steps with rays of their exact length in the volume (LaMar's figures and table).
///
/// Figures 1 and 11: errors of a checkerboard of 4 voxels a side against the integral over the box. Figures 2 and 3: thickness
/// and opacity of a cube of 4 voxels a side, turned by 30 degrees. Figure 12: a cylinder, half of it in voxels twice as long. Table 1, with --cost: time of exact borders, of volumes of 32
/// to 256 voxels a side.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast borders
  slicecast borders --figures figures
  slicecast borders --cost --json cost.json")]
pub struct Args {
    /// Write the pictures into this folder: borders-1.png, borders-3.svg and borders-12.png.
    #[arg(long, value_name = "DIR", conflicts_with = "cost")]
    figures: Option<PathBuf>,
    /// Measure what exact borders cost instead; about a minute.
    #[arg(long)]
    cost: bool,
    /// Write the numbers as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// What is written as JSON.
#[derive(Serialize)]
struct Numbers<'a> {
    checkerboard: &'a [Errors],
    cube: &'a [Profile],
    cylinder: &'a [Seam],
}

/// Names of the pictures.
const FIGURES: [&str; 3] = ["borders-1.png", "borders-3.svg", "borders-12.png"];

impl Args {
    /// Runs the comparison.
    pub fn run(self) -> Result<(), Failure> {
        check_free(&self.json, self.force)?;
        if self.cost {
            let lines = with_bar("borders", |progress| cost::lines(false, progress))?;
            print_cost(&lines);
            return self.write_json(&lines);
        }
        let (errors, profiles, cylinder) = (figures::errors()?, figures::profiles()?, seams::errors()?);
        print_errors(&errors);
        print_profiles(&profiles);
        print_seams(&cylinder);
        if let Some(folder) = &self.figures {
            self.pictures(folder, &profiles)?;
        }
        self.write_json(&Numbers {
            checkerboard: &errors,
            cube: &profiles,
            cylinder: &cylinder,
        })
    }

    fn pictures(&self, folder: &Path, profiles: &[Profile]) -> Result<(), Failure> {
        let mut folder = Folder::open(folder, self.force)?;
        folder.check(&FIGURES.map(str::to_owned))?;
        let [board, turned, cylinder] = FIGURES;
        for (name, pictures) in [(board, figures::pictures()?), (cylinder, seams::pictures()?)] {
            let parts: Vec<Rgb> = (pictures.into_iter())
                .map(|(words, picture)| captioned(picture, &words))
                .collect();
            let png = rgb_png(in_a_row(&parts)).map_err(Failure::machine)?;
            println!("{}", folder.write(name, &png)?.display());
        }
        let svg = plot::profiles(profiles).map_err(Failure::machine)?;
        println!("{}", folder.write(turned, svg.as_bytes())?.display());
        Ok(())
    }

    fn write_json<T: Serialize + ?Sized>(&self, numbers: &T) -> Result<(), Failure> {
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(numbers).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        Ok(())
    }
}

fn print_errors(errors: &[Errors]) {
    let mut table = header(&["borders", "planes", "mean", "largest"]);
    for line in errors {
        table.add_row([
            line.borders.to_owned(),
            line.planes.to_string(),
            format!("{:.3}", line.mean),
            format!("{:.2}", line.most),
        ]);
    }
    println!(
        "Checkerboard of 4 voxels a side, opacity 0.5 a voxel, wide: error of the base plane in steps of 1/255, against the \
         integral over the box\n\n{table}"
    );
}

fn print_profiles(profiles: &[Profile]) {
    let mut table = header(&["borders", "thickness, steps", "opacity, steps of 1/255"]);
    for profile in profiles {
        table.add_row([
            profile.borders.to_owned(),
            format!("{:.4}", profile.thickness()),
            format!("{:.3}", profile.opacity()),
        ]);
    }
    println!(
        "\nCube of 4 voxels a side, turned by 30 degrees, opacity 0.5 a voxel: largest error along a row\n\n{table}\n"
    );
}

fn print_seams(seams: &[Seam]) {
    let mut table = header(&[
        "halves",
        "planes",
        "whole steps: largest",
        "mean",
        "at the seam",
        "levels: largest",
        "mean",
        "at the seam",
    ]);
    for seam in seams {
        let mut cells = vec![seam.name.to_owned(), seam.planes.to_string()];
        cells.extend(seam.whole.iter().chain(&seam.levels).map(|error| format!("{error:.3}")));
        table.add_row(cells);
    }
    println!(
        "Cylinder of 64 voxels a side, opacity 0.1 a voxel at its axis, half of it in voxels twice as long: error of the base plane in steps of \
         1/255, against the integral over both halves; bricks of whole steps in f64, boxes of levels in wide\n\n{table}\n"
    );
}

fn print_cost(lines: &[Line]) {
    let mut table = header(&[
        "side",
        "base plane",
        "whole, ms",
        "cells, ms",
        "nodes, ms",
        "drop, cells",
        "drop, nodes",
    ]);
    for line in lines {
        let [columns, rows] = line.pixels;
        let mut cells = vec![line.side.to_string(), format!("{columns} x {rows}")];
        cells.extend(line.milliseconds.map(|time| format!("{time:.2}")));
        cells.extend(line.drops().map(|drop| format!("{:.1} %", 100.0 * drop)));
        table.add_row(cells);
    }
    println!(
        "Dense unlit fog, compact, two planes per voxel, one thread, shortest of 15 frames in turns; drop: frames per second \
         lost against whole borders\n\n{table}"
    );
}
