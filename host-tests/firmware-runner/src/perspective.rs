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

use crate::images::{Pair, execute, parse};
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
            let names = ["parallel", "perspective"].map(|way| format!("{way} {} {}", self.scene, kind.name()));
            let pair = Pair::of(&report, names, self.places)?;
            let image = pair.image();
            let verdict = (image != host).then(|| format!("found {image:08x}"));
            failed += line(
                machine,
                &format!("perspective {} {}", self.scene, kind.name()),
                &format!("{host:08x}"),
                verdict,
            );
            println!("{}", pair.cost(["parallel", "in perspective"]));
        }
        let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
        failed += line(machine, "perspective exit", "", verdict);
        Ok(failed)
    }
}
