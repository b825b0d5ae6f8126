//! `slicecast inspect`.

use std::time::Instant;

use crate::framing::{Framing, Stated};
use crate::labels::labels;
use crate::{legend, presets};
use serde::Serialize;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::tiles::TILE_ROWS;
use slicecast_volume::Volume;
use slicecast_volume::open::Loaded;
use slicecast_volume::statistics::Statistics;
use slicecast_volume::values::{Decoded, Modality};

use super::Failure;
use super::inputs::VolumeArgs;

/// Show what a volume file holds and how it would be rendered.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast inspect scan.nii.gz
  slicecast inspect dicom-folder --series 3
  slicecast inspect voxels.raw --raw 256x256x128,uint8 --json")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// The figures of a volume, as JSON shows them. `docs/formats.md` lists the keys, and a test holds the two together.
#[derive(Serialize)]
struct Facts<'a> {
    name: &'a str,
    dims: [usize; 3],
    spacing: [f64; 3],
    orientation: String,
    modality: &'static str,
    value_type: &'static str,
    value_scale: f64,
    value_offset: f64,
    range: [f64; 2],
    stated_window: Option<[f64; 2]>,
    crc32: String,
    mapping: String,
    mapped_window: [f64; 2],
    codes_per_unit: f64,
    lossless: bool,
    clipped: [u64; 2],
    scene: &'static str,
    scene_reason: String,
    presets: Vec<&'static str>,
    notes: &'a [String],
    warnings: Vec<String>,
}

impl Args {
    /// Describes the volume.
    pub fn run(self) -> Result<(), Failure> {
        let started = Instant::now();
        let decoded = self.volume.decode()?;
        let read = started.elapsed().as_secs_f64();
        let loaded = self.volume.map(&decoded)?;
        let statistics = Statistics::of(&loaded.volume);
        let facts = facts(&decoded, &loaded, &statistics)?;
        if self.json {
            let text = serde_json::to_string_pretty(&facts).map_err(Failure::machine)?;
            println!("{text}");
            return Ok(());
        }
        let [nx, ny, nz] = facts.dims;
        let [sx, sy, sz] = facts.spacing;
        let side = |n: usize, s: f64| n as f64 * s;
        println!("file         {}", facts.name);
        println!(
            "voxels       {nx} x {ny} x {nz}, {} ({:.1} MiB stored, read in {read:.2} s)",
            facts.value_type,
            stored(&decoded)
        );
        println!("spacing      {sx} x {sy} x {sz}");
        println!(
            "size         {:.1} x {:.1} x {:.1}",
            side(nx, sx),
            side(ny, sy),
            side(nz, sz)
        );
        println!("orientation  {}", facts.orientation);
        println!("modality     {}", facts.modality);
        if (facts.value_scale, facts.value_offset) != (1.0, 0.0) {
            println!(
                "unit         stored value x {} + {}",
                facts.value_scale, facts.value_offset
            );
        }
        if let Some([low, high]) = facts.stated_window {
            println!("file window  {low} to {high} (--window file)");
        }
        println!("checksum     {} (CRC-32 of the stored values)", facts.crc32);
        println!("mapping      {}", facts.mapping.replace('\n', "\n             "));
        for note in facts.notes {
            println!("note         {note}");
        }
        for warning in &facts.warnings {
            println!("warning      {warning}");
        }
        println!("\n{}", histogram(&loaded, &statistics));
        println!(
            "scenes       {} (the first by default: {})",
            facts.presets.join(", "),
            facts.scene_reason
        );
        if facts.scene == "labels" {
            println!(
                "
{}
",
                legend::text(&labels(&loaded.volume, &statistics))
            );
        }
        cost(facts.scene, &loaded, &statistics)
    }
}

fn facts<'a>(decoded: &'a Decoded, loaded: &Loaded, statistics: &Statistics) -> Result<Facts<'a>, Failure> {
    let (scene, scene_reason) = presets::suggest(loaded, statistics);
    Ok(Facts {
        name: decoded.name(),
        dims: decoded.dims(),
        spacing: decoded.spacing(),
        orientation: decoded.orientation().to_string(),
        modality: match decoded.modality() {
            Some(Modality::Ct) => "CT",
            Some(Modality::Mr) => "MR",
            Some(Modality::Other) => "other",
            None => "not stated",
        },
        value_type: decoded.values().value_type().name(),
        value_scale: decoded.value_scale(),
        value_offset: decoded.value_offset(),
        range: loaded.report.range,
        stated_window: decoded.stated_window(),
        crc32: format!("{:08x}", decoded.values().crc32()),
        mapping: loaded.report.to_string(),
        mapped_window: loaded.report.window,
        codes_per_unit: loaded.report.codes_per_unit,
        lossless: loaded.report.lossless,
        clipped: [loaded.report.clipped_low, loaded.report.clipped_high],
        scene,
        scene_reason,
        presets: presets::fitting(loaded, statistics),
        notes: decoded.notes(),
        warnings: warnings(scene, loaded, statistics)?,
    })
}

/// What may surprise in a picture of the volume by its default scene.
fn warnings(scene: &str, loaded: &Loaded, statistics: &Statistics) -> Result<Vec<String>, Failure> {
    let mut warnings = Vec::new();
    let Volume { dims, mapping, .. } = &loaded.volume;
    if let Some(axis) = (0..3).find(|axis| dims[*axis] == 1) {
        let axis = ["x", "y", "z"][axis];
        warnings.push(format!(
            "one voxel along {axis}: the volume has no thickness there, and is seen from {axis} alone"
        ));
    }
    for (count, side, window) in [
        (loaded.report.clipped_low, "below", loaded.report.window[0]),
        (loaded.report.clipped_high, "above", loaded.report.window[1]),
    ] {
        if count > 0 {
            warnings.push(format!(
                "{count} voxels {side} {window} are clipped (--window maps others)"
            ));
        }
    }
    let transfer = presets::scene(scene, &loaded.volume, statistics)
        .map_err(Failure::input)?
        .transfer;
    let seen = |(code, count): (usize, &u64)| *count > 0 && transfer.evaluate(mapping.value(code as f64)).1 > 0.0;
    if !statistics.counts().iter().enumerate().any(seen) {
        let [low, high] = loaded.report.range;
        warnings.push(format!(
            "no value from {low} to {high} is visible in the scene `{scene}`"
        ));
    }
    Ok(warnings)
}

/// MiB of the stored values.
fn stored(decoded: &Decoded) -> f64 {
    let values = decoded.values();
    (values.len() as u64 * values.value_type().byte_len()) as f64 / (1 << 20) as f64
}

/// The histogram as bars, sixteen lines over the values that occur; the bars' length is the logarithm of the count.
fn histogram(loaded: &Loaded, statistics: &Statistics) -> String {
    const LINES: usize = 16;
    const WIDTH: f64 = 48.0;
    let [first, last] = statistics.range();
    let step = (last - first + 1).div_ceil(LINES);
    let counts = statistics.counts().get(first..=last).unwrap_or(&[]);
    let bins: Vec<u64> = counts.chunks(step).map(|part| part.iter().sum()).collect();
    let most = bins.iter().max().map_or(1.0, |&count| (1.0 + count as f64).ln());
    let line = |(i, &count): (usize, &u64)| {
        let value = loaded.volume.mapping.value((first + i * step) as f64);
        let len = (WIDTH * (1.0 + count as f64).ln() / most).round() as usize;
        format!("{value:>12.6}  {:<48}  {count}", "#".repeat(len))
    };
    let lines: Vec<String> = bins.iter().enumerate().map(line).collect();
    format!("   value from  voxels (length: logarithm)\n{}", lines.join("\n"))
}

/// Samples of a frame that is rendered to see how long it takes.
const MEASURED_MAX: u64 = 1 << 31;

/// Memory and time of the default scene.
fn cost(name: &str, loaded: &Loaded, statistics: &Statistics) -> Result<(), Failure> {
    let scene = presets::scene(name, &loaded.volume, statistics).map_err(Failure::input)?;
    // As `render` would draw it.
    let framing = Framing::of(std::slice::from_ref(&scene), &loaded.volume, Stated::default())?;
    let scene = framing.scene(&scene, &loaded.volume);
    let prepared = Prepared::new(&scene, &loaded.volume)?;
    let plan = &prepared.setup.plan;
    let needs = prepared.rendering()?.needs();
    let mib = |bytes: usize| bytes as f64 / (1 << 20) as f64;
    let voxels = 2 * loaded.volume.voxels.len();
    let [w, h] = plan.base();
    let samples = u64::from(w) * u64::from(h) * u64::from(plan.phases()) * u64::from(plan.planes());
    println!(
        "memory       {:.1} MiB of 12-bit voxels, {:.1} MiB of base-plane image; streamed: {:.1} MiB of slices",
        mib(voxels),
        mib(needs.image * needs.element_bytes),
        mib(2 * needs.slices)
    );
    if samples > MEASURED_MAX {
        println!("time         not measured: {samples} samples");
        return Ok(());
    }
    let started = Instant::now();
    prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| {})?;
    let seconds = started.elapsed().as_secs_f64();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("time         {seconds:.2} s for a frame on {cores} processors, measured now ({samples} samples)");
    Ok(())
}
