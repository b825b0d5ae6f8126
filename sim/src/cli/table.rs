//! `slicecast table`.

use std::path::PathBuf;

use crate::losses::{Losses, losses};
use clap::ValueEnum;
use slicecast::integral::{Colours, GRAINS};
use slicecast::table::ENTRIES;
use slicecast_engine::frame::Prepared;
use slicecast_engine::integrals::Cumulative;
use slicecast_engine::table::Correction;
use slicecast_export::integrals::{Source, integrals};
use slicecast_export::table::{self, Language};
use slicecast_scene::Classification;

use crate::visibility;

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs};
use super::output::write_file;

/// Show or export the table that a scene's transfer function compiles to.
///
/// A table of points holds opacities that are corrected for the length of a ray's step in the scene's view of the volume. A scene
/// that classifies segments has a table of integrals (--classification integral), which holds for every view, step and number
/// of planes per voxel.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast table --scene ct-fog
  slicecast table scan.nrrd --scene bone.toml --format hex -o table.hex
  slicecast table scan.nii.gz --transfer CT-Bone.vp --format c --name bone -o bone.h
  slicecast table scan.nrrd --scene bone.toml --classification integral --bins 512 --format c --name bone -o bone.h")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// Language of the export.
    #[arg(long, value_enum, default_value = "rust")]
    format: Format,
    /// Bins of a table of integrals: 4096, 2048, 1024, 512 or 256. Without it 1024 (4 KiB a list, 16 KiB in all where colours
    /// differ), which a device holds; `render` has 4096 (64 KiB), and only these give its bits.
    #[arg(long, value_name = "N", value_parser = grain)]
    bins: Option<u32>,
    /// Name of the array.
    #[arg(long, default_value = "table")]
    name: String,
    /// Export to this file; without it the table is shown as a chart.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Warn of entries whose opacity is off by more than this share.
    #[arg(long, value_name = "SHARE", default_value_t = 0.05)]
    share: f64,
    /// Replace the output if it exists.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Rust,
    C,
    Hex,
}

impl Args {
    /// Prints the table.
    pub fn run(self) -> Result<(), Failure> {
        let loaded = self.volume.load()?;
        let scene = self.scene.load_for(&self.volume, &loaded)?;
        let prepared = Prepared::new(&scene, &loaded.volume)?;
        if let Some(note) = visibility::fineness(&prepared) {
            eprintln!("note: {note}");
        }
        if scene.classification == Classification::None {
            return Err(Failure::input(
                "the scene draws surfaces alone, which have no table; --classification integral is that of its volume",
            ));
        }
        let text = match (&prepared.segments, self.bins) {
            (Some(_), grain) => self.integrals(&prepared, grain.unwrap_or(GRAIN)),
            (None, None) => self.points(&prepared),
            (None, Some(_)) => {
                return Err(Failure::input(
                    "--bins: the scene classifies samples, whose table has 4096 entries; --classification integral has bins",
                ));
            }
        };
        if let Some(path) = &self.output {
            write_file(path, self.force, text.as_bytes())?;
            println!("{}: {} bytes", path.display(), text.len());
        }
        Ok(())
    }

    fn language(&self) -> Language {
        match self.format {
            Format::Rust => Language::Rust,
            Format::C => Language::C,
            Format::Hex => Language::Readmemh,
        }
    }

    /// Says what a table of points holds and loses; its text.
    fn points(&self, prepared: &Prepared<'_>) -> String {
        let step = prepared.setup.step_length;
        let table = &prepared.table;
        let losses = losses(
            table,
            &prepared.scene.transfer,
            &prepared.volume.mapping,
            Correction::Step(step),
            self.share,
        );
        println!(
            "{} entries, {} visible, {} bytes; opacities over a step of {step:.6}",
            table.entries.len(),
            losses.visible,
            table.bytes()
        );
        if self.output.is_none() {
            let entry = |index: usize| Entry {
                code: index as f64,
                colour: table.colour_bytes(index),
                opacity: f64::from(table.opacity(index).to_bits()) / f64::from(1_u32 << 31),
            };
            let visible = (0..table.entries.len()).filter(|&i| table.opacity(i).to_bits() > 0);
            let visible: Vec<Entry> = visible.map(entry).collect();
            chart(prepared, "opacity a step", &visible);
        }
        for warning in warnings(&losses, self.share) {
            eprintln!("warning: {warning}");
        }
        table::table(table, &self.name, self.language())
    }

    /// Says what a table of integrals holds; its text.
    fn integrals(&self, prepared: &Prepared<'_>, grain: u32) -> String {
        let table = Cumulative::of(&prepared.scene.transfer, prepared.volume, grain);
        let visible = bins(&table);
        println!(
            "{} bins of {} code(s), {} visible, {} bytes, exponent {}; for every view, step and number of planes per voxel",
            table.extinction.len() - 1,
            1 << grain,
            visible.len(),
            table.bytes(),
            table.exponent
        );
        if self.output.is_none() {
            chart(prepared, "opacity over the smallest spacing", &visible);
        }
        let source = Source {
            scene: &self.scene.name(),
            volume: prepared.volume,
        };
        integrals(&table, source, &self.name, self.language())
    }
}

/// Bins of 2^this many codes, unless others are asked for.
const GRAIN: u32 = 2;

/// log2 of the codes of a bin, from the number of bins.
fn grain(text: &str) -> Result<u32, String> {
    let found = GRAINS.rev().find(|grain| text == (ENTRIES >> grain).to_string());
    found.ok_or_else(|| "expected 4096, 2048, 1024, 512 or 256".into())
}

/// What should not pass unseen.
fn warnings(losses: &Losses, share: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if losses.underflows > 0 {
        warnings.push(format!(
            "{} of {} visible entries become invisible (opacity too small for the table; --table sqrt16 holds more)",
            losses.underflows, losses.visible
        ));
    }
    if losses.coarse > losses.underflows {
        warnings.push(format!(
            "{} of {} visible entries are off by more than {} %, at most {:.1} % at {}",
            losses.coarse,
            losses.visible,
            100.0 * share,
            100.0 * losses.worst,
            losses.worst_value
        ));
    }
    warnings
}

/// A line of a chart.
struct Entry {
    code: f64,
    colour: [u8; 3],
    opacity: f64,
}

/// The visible bins of a table of integrals: their middle, mean colour, and opacity over a reference length.
fn bins(table: &Cumulative) -> Vec<Entry> {
    let width = f64::from(1_u32 << table.grain);
    let of = |list: &[u32], bin: usize| f64::from(list[bin + 1] - list[bin]);
    let visible = (0..table.extinction.len() - 1).filter(|&bin| of(&table.extinction, bin) > 0.0);
    let entry = |bin: usize| {
        let extinction = of(&table.extinction, bin);
        let byte = |share: f64| (255.0 * share).round() as u8;
        Entry {
            code: bin as f64 * width + (width - 1.0) / 2.0,
            colour: match &table.colours {
                Colours::One(colour) => colour.map(|c| byte(f64::from(c) / f64::from(1_u32 << 31))),
                Colours::Each(lists) => lists.each_ref().map(|list| byte(of(list, bin) / extinction)),
            },
            opacity: -(-extinction / f64::from(table.exponent).exp2() / width).exp_m1(),
        }
    };
    visible.map(entry).collect()
}

/// Runs of visible entries, at most 32 lines.
fn chart(prepared: &Prepared<'_>, opacity: &str, visible: &[Entry]) {
    println!("    code         value  colour   {opacity}");
    let step = visible.len().div_ceil(32).max(1);
    for entry in visible.iter().step_by(step) {
        let Entry { code, colour, opacity } = *entry;
        let [red, green, blue] = colour;
        let value = prepared.volume.mapping.value(code);
        let bar = "#".repeat((32.0 * opacity.sqrt()).round() as usize);
        println!("    {code:>4}  {value:>12.4}  #{red:02x}{green:02x}{blue:02x}  {opacity:<10.6}  {bar}");
    }
}
