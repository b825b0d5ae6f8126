//! `slicecast table`.

use std::path::PathBuf;

use crate::losses::{Losses, losses};
use clap::ValueEnum;
use slicecast_engine::frame::Prepared;
use slicecast_engine::table::Correction;
use slicecast_export::table::{self, Language};

use crate::visibility;

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs};
use super::output::write_file;

/// Show or export the table that a scene's transfer function compiles to.
///
/// Opacities are corrected for the length of a ray's step in the scene's view of the volume.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast table --scene ct-fog
  slicecast table scan.nrrd --scene bone.toml --format hex -o table.hex
  slicecast table scan.nii.gz --transfer CT-Bone.vp --format c --name bone -o bone.h")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// Language of the export.
    #[arg(long, value_enum, default_value = "rust")]
    format: Format,
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
        prepared.check_points()?;
        if let Some(note) = visibility::fineness(&prepared) {
            eprintln!("note: {note}");
        }
        let step = prepared.setup.step_length;
        let mapping = &loaded.volume.mapping;
        let losses = losses(
            &prepared.table,
            &scene.transfer,
            mapping,
            Correction::Step(step),
            self.share,
        );
        println!(
            "{} entries, {} visible, {} bytes; opacities over a step of {step:.6}",
            prepared.table.entries.len(),
            losses.visible,
            prepared.table.bytes()
        );
        if self.output.is_none() {
            chart(&prepared);
        }
        for warning in warnings(&losses, self.share) {
            eprintln!("warning: {warning}");
        }
        if let Some(path) = &self.output {
            let language = match self.format {
                Format::Rust => Language::Rust,
                Format::C => Language::C,
                Format::Hex => Language::Readmemh,
            };
            let text = table::table(&prepared.table, &self.name, language);
            write_file(path, self.force, text.as_bytes())?;
            println!("{}: {} bytes", path.display(), text.len());
        }
        Ok(())
    }
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

/// Runs of visible entries, at most 32 lines.
fn chart(prepared: &Prepared<'_>) {
    let table = &prepared.table;
    let value = |index: usize| prepared.volume.mapping.value(index as f64);
    println!("    code         value  colour   opacity a step");
    let visible: Vec<usize> = (0..table.entries.len())
        .filter(|&i| table.opacity(i).to_bits() > 0)
        .collect();
    let step = visible.len().div_ceil(32).max(1);
    for &index in visible.iter().step_by(step) {
        let opacity = f64::from(table.opacity(index).to_bits()) / f64::from(1_u32 << 31);
        let [red, green, blue] = table.colour_bytes(index);
        let bar = "#".repeat((32.0 * opacity.sqrt()).round() as usize);
        println!(
            "    {index:>4}  {:>12.4}  #{red:02x}{green:02x}{blue:02x}  {opacity:<10.6}  {bar}",
            value(index)
        );
    }
}
