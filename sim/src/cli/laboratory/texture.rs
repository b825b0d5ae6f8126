//! `slicecast texture`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use slicecast_engine::error::RenderError;
use slicecast_engine::image::Rgb;
use slicecast_engine::threads::on_threads;
use slicecast_laboratory::texture::figures::{Compared, OfBits, OfCode, Row, figure_1, sheet, tables, teaser};
use slicecast_volume::Volume;

use super::pipelines;
use super::sheets::{in_a_column, in_a_row};
use crate::cli::Failure;
use crate::cli::inputs::{ThreadArgs, VolumeArgs};
use crate::cli::output::{Folder, check_free, write_file};
use crate::cli::progress::with_bar;
use crate::cli::tables::{header, short};
use crate::lettering::captioned;
use crate::raster::rgb_png;

/// Compare texture hardware of 8 bits with this pipeline, on scenes of a CT: opaque surfaces, soft tissue, fog.
///
/// With --figures, Squeeze's figure 1 (thin soft tissue by codes of opacity) and its teaser (bone in the thinnest fog that frame
/// buffers of 8 to 16 bits take) are remade instead, and the scenes are drawn side by side.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast texture
  slicecast texture ct.nrrd --json texture.json
  slicecast texture ct.nrrd --figures figures
  slicecast compare ct.nrrd --scene ct-bone --specular 0 --texture8 post,pre
  slicecast render ct.nrrd --scene ct-fog --texture8 post-shift -o fog.png")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Write the sheets into this folder instead: squeeze-1.png, squeeze-teaser.png and texture8.png.
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write the numbers as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// Pixels of a picture of a sheet.
const SIZE: [u32; 2] = [240, 240];

/// Names of the sheets.
const SHEETS: [&str; 3] = ["squeeze-1.png", "squeeze-teaser.png", "texture8.png"];

/// What is written as JSON with pictures.
#[derive(Serialize)]
struct Figured<'a> {
    codes: &'a [OfCode],
    bits: &'a [OfBits],
}

impl Args {
    /// Runs the comparison.
    pub fn run(self) -> Result<(), Failure> {
        check_free(&self.json, self.force)?;
        let loaded = self.volume.load()?;
        let volume = &loaded.volume;
        if let Some(folder) = &self.figures {
            return self.sheets(folder, volume);
        }
        let compared = with_bar("texture", |progress| {
            on_threads(self.threads.count(), || tables(volume, progress))
        })??;
        for Compared { scene, lines } in &compared {
            println!("{scene}\n\n{}\n", pipelines::table(lines));
        }
        self.write_json(&compared)
    }

    /// The sheets, and the figures that belong to them.
    fn sheets(&self, folder: &Path, volume: &Volume) -> Result<(), Failure> {
        let mut folder = Folder::open(folder, self.force)?;
        folder.check(&SHEETS.map(str::to_owned))?;
        let made = on_threads(self.threads.count(), || {
            Ok::<_, RenderError>((figure_1(volume, SIZE)?, teaser(volume, SIZE)?, sheet(volume, SIZE)?))
        })?;
        let ((one, codes), (teaser, bits), texture) = made?;
        for (name, rows) in SHEETS.into_iter().zip([one, teaser, texture]) {
            let png = rgb_png(in_a_column(&rows.iter().map(lettered).collect::<Vec<_>>())).map_err(Failure::machine)?;
            println!("{}", folder.write(name, &png)?.display());
        }
        println!("\nFigure 1: opacities of a table by their code, against f64\n");
        let mut table = header(&["code", "equal %", "max step", "mean step"]);
        for OfCode { code, image } in &codes {
            table.add_row([
                (*code).to_owned(),
                format!("{:.2}", image.equal_percent),
                short(image.max_lsb8),
                short(image.mean_lsb8),
            ]);
        }
        println!("{table}\n\nTeaser: fog of 2^-b in a frame buffer 1.b whose products are truncated, against f64\n");
        let mut table = header(&[
            "b",
            "fog, f64 %",
            "fog, 1.b %",
            "1.b: max step",
            "mean",
            "compact: max step",
            "mean",
        ]);
        for of in &bits {
            let [exact, found] = of.fog;
            table.add_row([
                of.bits.to_string(),
                format!("{exact:.3}"),
                format!("{found:.3}"),
                short(of.truncated.max_lsb8),
                short(of.truncated.mean_lsb8),
                short(of.compact.max_lsb8),
                short(of.compact.mean_lsb8),
            ]);
        }
        println!("{table}");
        self.write_json(&Figured {
            codes: &codes,
            bits: &bits,
        })
    }

    fn write_json<T: Serialize + ?Sized>(&self, figures: &T) -> Result<(), Failure> {
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(figures).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        Ok(())
    }
}

/// A row of pictures with what they show.
fn lettered(row: &Row) -> Rgb {
    let parts: Vec<Rgb> = row
        .iter()
        .map(|(words, picture)| captioned(picture.clone(), words))
        .collect();
    in_a_row(&parts)
}
