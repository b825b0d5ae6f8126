//! 16-bit lanes on a device: the dense scene in `fast` beside `compact`.

use std::fmt::Write as _;
use std::path::Path;

use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::Turned;
use slicecast_engine::rendering::in_memory_order;
use slicecast_engine::simd::Simd;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::PrecisionName;

use crate::images::{Pair, execute, parse};
use crate::line;
use crate::machines::Machine;
use crate::reference::places;
use crate::scenes::{Kind, Named};
use crate::shell::{Failure, fail};

/// What the host knows.
#[derive(Debug)]
pub struct Fast {
    scene: &'static str,
    /// Places of samples.
    places: u64,
    /// Unlit and lit.
    images: Vec<(&'static str, u32)>,
}

/// The sum of the image of a scene in 16-bit lanes, and the places of its samples.
fn image(named: &Named, kind: Kind) -> Result<(u32, u64), Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("{}, fast: {error}", named.name));
    let mut scene = named.of_kind(kind);
    scene.precision = PrecisionName::Fast;
    scene.check().map_err(|e| words(&e))?;
    let prepared = Prepared::new(&scene, &named.volume).map_err(|e| words(&e))?;
    let plan = prepared.setup.plan;
    let mut turned = Turned::new(&named.volume, &plan);
    let slices = turned.slices().map_err(|e| words(&e))?;
    let mut rendering = prepared.begun().map_err(|e| words(&e))?;
    rendering.fold_rows(&slices, 32, Simd::widest(), &|_, _| ());
    let mut sum = Sum::new();
    let rays = named.scene.sampling.rays_per_voxel as usize;
    in_memory_order(&rendering.base(), rays).for_each(|bits| sum.word(bits));
    Ok((sum.get(), places(&plan)))
}

/// The sums of a scene's images for C.
///
/// # Errors
/// If the scene cannot be rendered.
pub fn c(named: &Named) -> Result<String, Failure> {
    let mut out = String::new();
    for kind in [Kind::COMPACT_UNLIT, Kind::COMPACT_LIT] {
        let (sum, _) = image(named, kind)?;
        let _ = writeln!(out, "#define FAST_{} {sum}u", kind.shading().to_uppercase());
    }
    Ok(out)
}

impl Fast {
    /// Renders what devices will render.
    ///
    /// # Errors
    /// If the scene cannot be rendered.
    pub fn new(scenes: &[Named]) -> Result<Self, Failure> {
        let Some(dense) = scenes.iter().find(|named| named.name == "dense") else {
            return fail("there is no dense scene");
        };
        let (mut images, mut places) = (Vec::new(), 0);
        for (name, lit) in [("unlit", false), ("lit", true)] {
            let is_wanted = |kind: &Kind| kind.lit == lit && kind.precision() == PrecisionName::Compact;
            if let Some(kind) = Kind::all().find(is_wanted) {
                let (sum, count) = image(dense, kind)?;
                images.push((name, sum));
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
        let images: Vec<u32> = self.images.iter().map(|(_, image)| *image).collect();
        let mut out = String::new();
        let _ = writeln!(
            out,
            "/// The sums of the images in 16-bit lanes, unlit and lit.\npub static FAST_EXPECTED: [u32; 2] = {images:?};"
        );
        out
    }

    /// Holds a machine to the host, and prints what it costs; returns the number of failures.
    ///
    /// # Errors
    /// If the program does not run.
    pub fn check(&self, programs: &Path, machine: &Machine) -> Result<u32, Failure> {
        let finished = execute(machine, &programs.join("fast"), true)?;
        let report = parse(&finished.out)?;
        let mut failed = 0;
        for (shading, host) in self.images.iter().copied() {
            let names = ["compact", "fast"].map(|precision| format!("{} {precision} {shading}", self.scene));
            let pair = Pair::of(&report, names, [self.places; 2])?;
            let image = pair.image();
            let verdict = (image != host).then(|| format!("found {image:08x}"));
            failed += line(
                machine,
                &format!("{} fast {shading}", self.scene),
                &format!("{host:08x}"),
                verdict,
            );
            println!("{}", pair.cost(["compact", "fast"]));
        }
        let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
        failed += line(machine, "fast exit", "", verdict);
        Ok(failed)
    }
}
