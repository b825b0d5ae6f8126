//! `slicecast inspect`.

use std::time::Instant;

use crate::framing::{Framing, Stated};
use crate::slab::thicken;
use crate::{legend, presets, visibility};
use serde::Serialize;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::tile::TILE_ROWS;
use slicecast_volume::Volume;
use slicecast_volume::decoded::Decoded;
use slicecast_volume::meaning::Modality;
use slicecast_volume::open::Loaded;
use slicecast_volume::statistics::Statistics;

use super::Failure;
use super::chosen::Chosen;
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
    labels: Option<Vec<legend::Line>>,
    scene: &'static str,
    scene_reason: String,
    presets: Vec<&'static str>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

impl Args {
    /// Describes the volume.
    pub fn run(self) -> Result<(), Failure> {
        let started = Instant::now();
        let decoded = self.volume.decode()?;
        let read = started.elapsed().as_secs_f64();
        let mut loaded = self.volume.map(&decoded)?;
        let mut notes = decoded.notes().to_vec();
        let (fitting, scene_reason) = presets::suggest(&loaded);
        let statistics = loaded.statistics.clone();
        let chosen = Chosen {
            scene: presets::scene(fitting, &loaded, &statistics, &loaded.volume).map_err(Failure::input)?,
            stock: Some(fitting.into()),
            fitting,
            statistics,
        };
        let labels = chosen.labels(&loaded);
        notes.extend(thicken(&mut loaded.volume, chosen.scene.borders));
        let drawn = Drawn::of(&chosen, &loaded.volume);
        let warnings = match &drawn {
            Ok(drawn) => drawn.warning.iter().cloned().collect(),
            Err(error) => vec![format!("there is no picture: {error}")],
        };
        let facts = Facts {
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
            labels: labels.as_deref().map(legend::lines),
            scene: fitting,
            scene_reason,
            presets: presets::fitting(&loaded),
            notes,
            warnings,
        };
        if self.json {
            let text = serde_json::to_string_pretty(&facts).map_err(Failure::machine)?;
            println!("{text}");
            return Ok(());
        }
        facts.print(stored(&decoded), read);
        println!("\n{}", histogram(&loaded, &chosen.statistics));
        println!(
            "scenes       {} (the first by default: {})",
            facts.presets.join(", "),
            facts.scene_reason
        );
        if let Some(labels) = labels {
            println!("\n{}\n", legend::text(&labels));
        }
        if let Ok(drawn) = drawn {
            drawn.print(2 * loaded.volume.voxels.len());
        }
        Ok(())
    }
}

impl Facts<'_> {
    /// Prints them as text, with the size of the stored values in MiB and the time that reading took in seconds.
    fn print(&self, stored: f64, read: f64) {
        let [nx, ny, nz] = self.dims;
        let [sx, sy, sz] = self.spacing;
        let side = |n: usize, s: f64| n as f64 * s;
        println!("file         {}", self.name);
        println!(
            "voxels       {nx} x {ny} x {nz}, {} ({stored:.1} MiB stored, read in {read:.2} s)",
            self.value_type
        );
        println!("spacing      {sx} x {sy} x {sz}");
        println!(
            "size         {:.1} x {:.1} x {:.1}",
            side(nx, sx),
            side(ny, sy),
            side(nz, sz)
        );
        println!("orientation  {}", self.orientation);
        println!("modality     {}", self.modality);
        if (self.value_scale, self.value_offset) != (1.0, 0.0) {
            println!(
                "unit         stored value x {} + {}",
                self.value_scale, self.value_offset
            );
        }
        if let Some([low, high]) = self.stated_window {
            println!("file window  {low} to {high} (--window file)");
        }
        println!("checksum     {} (CRC-32 of the stored values)", self.crc32);
        println!("mapping      {}", self.mapping.replace('\n', "\n             "));
        for note in &self.notes {
            println!("note         {note}");
        }
        for warning in &self.warnings {
            println!("warning      {warning}");
        }
    }
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
        let value = loaded.value((first + i * step) as u16);
        let len = (WIDTH * (1.0 + count as f64).ln() / most).round() as usize;
        format!("{value:>12.6}  {:<48}  {count}", "#".repeat(len))
    };
    let lines: Vec<String> = bins.iter().enumerate().map(line).collect();
    format!("   value from  voxels (length: logarithm)\n{}", lines.join("\n"))
}

/// The picture that `render` makes of a volume by default: what it warns of, and what it takes.
struct Drawn {
    warning: Option<String>,
    needs: slicecast::stream::Needs,
    samples: u64,
    seconds: f64,
}

impl Drawn {
    fn of(chosen: &Chosen, volume: &Volume) -> Result<Self, RenderError> {
        let framing = Framing::of(std::slice::from_ref(&chosen.scene), volume, Stated::default())?;
        let scene = framing.scene(&chosen.scene, volume);
        let prepared = Prepared::new(&scene, volume)?;
        if let Some(note) = visibility::fineness(&prepared) {
            eprintln!("note: {note}");
        }
        let plan = &prepared.setup.plan;
        let [w, h] = plan.base();
        let started = Instant::now();
        let frame = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| {})?;
        Ok(Self {
            seconds: started.elapsed().as_secs_f64(),
            warning: visibility::warning(&prepared, &frame, &chosen.circumstances()),
            needs: prepared.rendering()?.needs(),
            samples: u64::from(w) * u64::from(h) * u64::from(plan.phases()) * plan.planes_met().len() as u64,
        })
    }

    /// Prints the memory, with the bytes of the voxels, and the time.
    fn print(&self, voxels: usize) {
        let mib = |bytes: usize| bytes as f64 / (1 << 20) as f64;
        println!(
            "memory       {:.1} MiB of 12-bit voxels, {:.1} MiB of base-plane image; streamed: {:.1} MiB of slices",
            mib(voxels),
            mib(self.needs.image * self.needs.element_bytes),
            mib(2 * self.needs.slices)
        );
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        println!(
            "time         {:.2} s for a frame on {cores} processors, measured now ({} samples)",
            self.seconds, self.samples
        );
    }
}
