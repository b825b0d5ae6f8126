//! 16-bit lanes on a device: the dense scene and the head in `fast` beside `compact`.

use std::fmt::Write as _;
use std::path::Path;

use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::Turned;
use slicecast_engine::rendering::in_memory_order;
use slicecast_engine::simd::Simd;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::PrecisionName;

use crate::images::{Pair, Report, Workshop, execute, parse};
use crate::line;
use crate::machines::Machine;
use crate::proofs::link;
use crate::reference::places;
use crate::scenes::{COSTED, Kind, Named};
use crate::shell::{Failure, fail};

/// What the host knows of a scene.
#[derive(Debug)]
struct Rendered {
    scene: &'static str,
    /// Places of samples.
    places: u64,
    /// Sums of its images, unlit and lit.
    images: [u32; 2],
}

/// The scenes whose cost is measured.
#[derive(Debug)]
pub struct Fast([Rendered; 2]);

const SHADINGS: [&str; 2] = ["unlit", "lit"];

/// The heading of the rows of [`Fast::rows`].
pub const HEADING: &str = "## Sixteen-bit lanes\n\nThe same two scenes in `compact` and in `fast` ([contract/fast.md](contract/fast.md)), counted in one program \
     (`host-tests/firmware/src/bin/fast.rs`; `host-tests/run-firmware MACHINE` prints the counts, too). A table of `fast` has 16 KiB, \
     or 48 KiB where values differ in colour. `library` and `memory` (of the dense scene) are as above.\n\n\
     | core | pipeline | library: compact | fast | memory: compact | fast | dense, instr. a sample: compact | fast | ratio | head: compact \
     | fast | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";

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
    /// If a scene cannot be rendered, or there is none of the name.
    pub fn new(scenes: &[Named]) -> Result<Self, Failure> {
        let of = |name: &str| {
            let Some(named) = scenes.iter().find(|named| named.name == name) else {
                return fail(format!("there is no scene {name}"));
            };
            let (unlit, places) = image(named, Kind::COMPACT_UNLIT)?;
            let (lit, _) = image(named, Kind::COMPACT_LIT)?;
            Ok(Rendered {
                scene: named.name,
                places,
                images: [unlit, lit],
            })
        };
        let [dense, head] = COSTED;
        Ok(Self([of(dense)?, of(head)?]))
    }

    /// Rust source of the sums.
    pub fn source(&self) -> String {
        let images = self.0.each_ref().map(|rendered| rendered.images);
        let mut out = String::new();
        let _ = writeln!(
            out,
            "/// The sums of the images in 16-bit lanes, unlit and lit.\npub static FAST_EXPECTED: [[u32; 2]; 2] = {images:?};"
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
        for rendered in &self.0 {
            for (shading, host) in SHADINGS.into_iter().zip(rendered.images) {
                let pair = rendered.pair(&report, shading)?;
                let image = pair.image();
                let verdict = (image != host).then(|| format!("found {image:08x}"));
                failed += line(
                    machine,
                    &format!("{} fast {shading}", rendered.scene),
                    &format!("{host:08x}"),
                    verdict,
                );
                println!("{}", pair.cost(["compact", "fast"]));
            }
        }
        let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
        failed += line(machine, "fast exit", "", verdict);
        Ok(failed)
    }

    /// Rows of the cost table of a machine.
    ///
    /// # Errors
    /// If the program does not run, or an image is not the host's.
    pub fn rows(
        &self,
        workshop: &Workshop,
        machine: &Machine,
        programs: &Path,
        library: &Path,
    ) -> Result<String, Failure> {
        let finished = execute(machine, &programs.join("fast"), true)?;
        let report = parse(&finished.out)?;
        if !finished.passed || !report.verdict {
            return fail(format!("{}: fast renders another picture", machine.name));
        }
        let mut out = String::new();
        for shading in SHADINGS {
            let [dense, head] = [&self.0[0], &self.0[1]].map(|rendered| rendered.pair(&report, shading));
            let (dense, head) = (dense?, head?);
            let flash = |precision: &str| -> Result<u64, Failure> {
                Ok(link(workshop, machine, library, &format!("slicecast_{precision}_{shading}"))?.flash)
            };
            let [compact_bytes, fast_bytes] = dense.memory();
            let _ = write!(
                out,
                "| {} | {shading} | {} | {} | {compact_bytes} | {fast_bytes} |",
                machine.core,
                flash("compact")?,
                flash("fast")?
            );
            for pair in [dense, head] {
                let [compact, fast] = pair.each();
                let _ = write!(out, " {compact:.1} | {fast:.1} | {:.2} |", fast / compact);
            }
            out.push('\n');
        }
        Ok(out)
    }
}

impl Rendered {
    /// The frames of a shading in `compact` and in `fast`.
    fn pair<'r>(&self, report: &'r Report, shading: &str) -> Result<Pair<'r>, Failure> {
        let names = ["compact", "fast"].map(|precision| format!("{} {precision} {shading}", self.scene));
        Pair::of(report, names, [self.places; 2])
    }
}
