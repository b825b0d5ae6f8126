//! Volumes of colour and extinction on a device: the dense scene's voxels as entries.

use std::fmt::Write as _;
use std::path::Path;

use slicecast_colours::Coloured;
use slicecast_engine::camera::set_up;
use slicecast_engine::frame::Layer;
use slicecast_engine::rendering::in_memory_order;
use slicecast_engine::simd::Simd;
use slicecast_firmware_shared::scene::{COLOUR_SCALE, colour_entry, colour_medium};
use slicecast_firmware_shared::sum::Sum;
use slicecast_pyramid::volume::{RgbaVolume, Voxels};
use slicecast_scene::{PrecisionName, Scene};
use slicecast_volume::decoded::Orientation;

use crate::images::{Pair, execute, parse};
use crate::line;
use crate::machines::Machine;
use crate::reference::places;
use crate::scenes::{Kind, Named};
use crate::shell::{Failure, fail};

/// How many times the instructions of a point, unlit, a sample of colours may take on a Cortex-M4.
const RATIO_MAX: f64 = 1.6;

/// What the host knows.
#[derive(Debug)]
pub struct Colours {
    scene: &'static str,
    places: u64,
    /// By precision and light.
    images: Vec<(PrecisionName, Kind, u32)>,
}

/// A scene's part of the C header: the scale of its extinctions, the voxels of a slice, and the sums of two images.
///
/// # Errors
/// If the scene cannot be rendered.
pub fn c(named: &Named) -> Result<String, Failure> {
    let sum = |precision, kind| image(named, precision, kind).map(|(sum, _)| sum);
    let (unlit, lit) = (
        sum(PrecisionName::Compact, Kind::COMPACT_UNLIT)?,
        sum(PrecisionName::Wide, Kind::COMPACT_LIT)?,
    );
    // No slice has more.
    let [x, y, z] = named.volume.dims;
    let most = (x * y).max(y * z).max(x * z);
    let [mantissa, exponent] = COLOUR_SCALE;
    Ok(format!(
        "#define COLOUR_MEDIUM {{{mantissa}u, {exponent}u}}\n#define COLOUR_SLICE_VOXELS {most}\n\
         #define COLOURS_COMPACT_UNLIT {unlit}u\n#define COLOURS_WIDE_LIT {lit}u\n"
    ))
}

/// The sum of the image of a scene's entries.
fn image(named: &Named, precision: PrecisionName, kind: Kind) -> Result<(u32, u64), Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("{}, colours: {error}", named.name));
    let scene = Scene {
        precision,
        ..named.of_kind(kind)
    };
    let entries = named.volume.voxels.iter().map(|code| colour_entry(*code).to_le_bytes());
    let volume = RgbaVolume {
        name: named.name.to_owned(),
        dims: named.volume.dims,
        spacing: named.volume.spacing,
        orientation: Orientation::Unknown,
        tau_max: 1.0,
        alpha_distance: None,
        voxels: Voxels::Entries(entries.collect()),
    };
    let prepared = Coloured {
        setup: set_up(&scene, &volume).map_err(|e| words(&e))?,
        medium: colour_medium().map_err(|e| words(&e))?,
        scene: &scene,
        volume: &volume,
        simd: Simd::widest(),
    };
    let frame = prepared.render(Layer::Tiles(32), &|_, _| ()).map_err(|e| words(&e))?;
    let plan = &prepared.setup.plan;
    let mut sum = Sum::new();
    in_memory_order(&frame.base, plan.sampling().rays_per_voxel as usize).for_each(|bits| sum.word(bits));
    Ok((sum.get(), places(plan)))
}

impl Colours {
    /// Renders what devices will render.
    ///
    /// # Errors
    /// If the scene cannot be rendered.
    pub fn new(scenes: &[Named]) -> Result<Self, Failure> {
        let Some(dense) = scenes.iter().find(|named| named.name == "dense") else {
            return fail("there is no dense scene");
        };
        let (mut images, mut places) = (Vec::new(), 0);
        for kind in [Kind::COMPACT_UNLIT, Kind::COMPACT_LIT] {
            for precision in [PrecisionName::Compact, PrecisionName::Wide] {
                let (sum, count) = image(dense, precision, kind)?;
                images.push((precision, kind, sum));
                places = count;
            }
        }
        Ok(Self {
            scene: dense.name,
            places,
            images,
        })
    }

    /// Rust source of the sums.
    pub fn source(&self) -> String {
        let images: Vec<u32> = self.images.iter().map(|(_, _, image)| *image).collect();
        let mut out = String::new();
        let _ = writeln!(
            out,
            "/// The sums of the images of colours, compact and wide, unlit and lit.\npub static COLOURS_EXPECTED: [u32; 4] = {images:?};"
        );
        out
    }

    /// Holds a machine to the host, and prints what it costs; returns the number of failures.
    ///
    /// # Errors
    /// If the program does not run.
    pub fn check(&self, programs: &Path, machine: &Machine) -> Result<u32, Failure> {
        let finished = execute(machine, &programs.join("colours"), true)?;
        let report = parse(&finished.out)?;
        let mut failed = 0;
        for (precision, kind, host) in self.images.iter().copied() {
            let names = ["points", "colours"]
                .map(|way| format!("{way} {} {} {}", self.scene, precision.name(), kind.shading()));
            let pair = Pair::of(&report, names, [self.places; 2])?;
            let [of_points, of_colours] = pair.each();
            let ratio = of_colours / of_points;
            let verdict = if pair.image() != host {
                Some(format!("found {:08x}", pair.image()))
            } else if machine.core == "Cortex-M4"
                && precision == PrecisionName::Compact
                && !kind.lit
                && ratio > RATIO_MAX
            {
                Some(format!(
                    "{ratio:.2} times the instructions of a point, more than {RATIO_MAX}"
                ))
            } else {
                None
            };
            failed += line(
                machine,
                &format!("colours {} {} {}", self.scene, precision.name(), kind.shading()),
                &format!("{host:08x}"),
                verdict,
            );
            let [points, colours] = pair.instructions();
            println!("{}; frames {points} and {colours}", pair.cost(["points", "colours"]));
        }
        let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
        failed += line(machine, "colours exit", "", verdict);
        Ok(failed)
    }
}
