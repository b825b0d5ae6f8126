//! Perspective on a device: the dense scene from an eye in front of it.

use std::fmt::Write as _;
use std::path::Path;

use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::Turned;
use slicecast_engine::perspective::samples;
use slicecast_engine::rendering::in_memory_order;
use slicecast_engine::simd::Simd;
use slicecast_firmware_shared::scene::plan_in_perspective;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::PrecisionName;

use crate::images::{execute, parse};
use crate::line;
use crate::machines::Machine;
use crate::reference::places;
use crate::scenes::{Kind, Named};
use crate::shell::{Failure, fail};

/// What the host knows.
#[derive(Debug)]
pub struct Perspective {
    scene: &'static str,
    /// Of the parallel view, and in perspective.
    places: [u64; 2],
    /// By precision and light.
    images: Vec<(Kind, u32)>,
}

/// The sum of the image of a scene in perspective, and the places of samples in a parallel view and in perspective.
fn image(named: &Named, kind: Kind) -> Result<(u32, [u64; 2]), Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("{}, perspective: {error}", named.name));
    let scene = named.of_kind(kind);
    let mut prepared = Prepared::new(&scene, &named.volume).map_err(|e| words(&e))?;
    let parallel = places(&prepared.setup.plan);
    let (plan, spread) = plan_in_perspective(&prepared.setup.plan).map_err(|e| words(&e))?;
    (prepared.setup.plan, prepared.setup.spread) = (plan, Some(spread));
    let mut turned = Turned::new(&named.volume, &plan);
    let slices = turned.slices().map_err(|e| words(&e))?;
    let mut rendering = prepared.begun().map_err(|e| words(&e))?;
    rendering.fold_rows(&slices, 32, Simd::widest(), &|_, _| ());
    let mut sum = Sum::new();
    in_memory_order(&rendering.base(), 1).for_each(|bits| sum.word(bits));
    Ok((sum.get(), [parallel, samples(&plan, &spread)]))
}

impl Perspective {
    /// Renders what devices will render.
    ///
    /// # Errors
    /// If the scene cannot be rendered.
    pub fn new(scenes: &[Named]) -> Result<Self, Failure> {
        let Some(dense) = scenes.iter().find(|named| named.name == "dense") else {
            return fail("there is no dense scene");
        };
        let (mut images, mut places) = (Vec::new(), [0; 2]);
        for lit in [false, true] {
            for precision in [PrecisionName::Compact, PrecisionName::Wide] {
                let is_wanted = |kind: &Kind| kind.lit == lit && kind.precision() == precision;
                for kind in Kind::all().filter(is_wanted) {
                    let (sum, counts) = image(dense, kind)?;
                    images.push((kind, sum));
                    places = counts;
                }
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
            "/// The sums of the images in perspective, compact and wide, unlit and lit.\npub static PERSPECTIVE_EXPECTED: [u32; 4] = {images:?};"
        );
        out
    }

    /// Holds a machine to the host, and prints what it costs; returns the number of failures.
    ///
    /// # Errors
    /// If the program does not run.
    pub fn check(&self, programs: &Path, machine: &Machine) -> Result<u32, Failure> {
        let finished = execute(machine, &programs.join("perspective"), true)?;
        let report = parse(&finished.out)?;
        let mut failed = 0;
        for (kind, host) in self.images.iter().copied() {
            let case = |way: &str| {
                let name = format!("{way} {} {}", self.scene, kind.name());
                report.cases.iter().find(|case| case.name == name)
            };
            let (Some(parallel), Some(perspective)) = (case("parallel"), case("perspective")) else {
                return fail("the program did not report its cases");
            };
            let each =
                |case: &crate::images::Case, places: u64| case.instructions.unwrap_or(u64::MAX) as f64 / places as f64;
            let [places, spread] = self.places;
            let [of_parallel, of_perspective] = [each(parallel, places), each(perspective, spread)];
            let image = perspective.sums.image;
            let verdict = (image != host).then(|| format!("found {image:08x}"));
            failed += line(
                machine,
                &format!("perspective {} {}", self.scene, kind.name()),
                &format!("{host:08x}"),
                verdict,
            );
            let memory = |case: &crate::images::Case| case.memory.map_or(0, |parts| parts.iter().sum::<u64>());
            println!(
                "    instructions a sample: parallel {of_parallel:.1}, in perspective {of_perspective:.1}, {:.2} times; memory {} and {}",
                of_perspective / of_parallel,
                memory(parallel),
                memory(perspective)
            );
        }
        let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
        failed += line(machine, "perspective exit", "", verdict);
        Ok(failed)
    }
}
