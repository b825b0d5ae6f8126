//! What the host renders: the same scenes through the program's own engine and the plane layer.

use std::collections::BTreeMap;
use std::sync::mpsc::channel;

use slicecast::slice::Slice;
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits, Tap};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::Turned;
use slicecast_engine::rendering::{in_memory_order, tapped};
use slicecast_firmware_shared::boundary::Boundaries;
use slicecast_firmware_shared::image::add_rgb;
use slicecast_firmware_shared::sum::Sum;

use crate::scenes::{Kind, Named};
use crate::shell::Failure;

/// A plane of a phase: number, u, v.
pub type PlaneKey = (u32, u32, u32);

/// The sums of one case.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sums {
    /// Every stage boundary of every plane.
    pub planes: BTreeMap<PlaneKey, [u32; Stage::ALL.len()]>,
    /// The base-plane image.
    pub image: u32,
    /// The viewer's picture.
    pub picture: u32,
}

/// How many samples a case has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sample places inside the volume, skipped or not.
    pub places: u64,
    /// Samples that were interpolated and classified.
    pub samples: u64,
    /// Samples that were visible: coloured, shaded, composited.
    pub visible: u64,
}

/// The host's sums and counts of a case.
///
/// # Errors
/// If the scene does not fit the pipeline.
pub fn reference(named: &Named, kind: Kind) -> Result<(Sums, Counts), Failure> {
    let scene = named.of_kind(kind);
    let words = |error: &dyn std::error::Error| Failure(format!("{}: {error}", named.name));
    let prepared = Prepared::new(&scene, &named.volume).map_err(|e| words(&e))?;
    sums(&prepared).map_err(|e| words(&e))
}

/// The host's sums and counts of a frame.
///
/// # Errors
/// If it cannot be rendered.
pub fn sums(prepared: &Prepared<'_>) -> Result<(Sums, Counts), RenderError> {
    let frame = prepared.render(Layer::Stream, &|_, _| ())?;
    let mut picture = Sum::new();
    for pixel in frame.picture.bytes.chunks_exact(3) {
        add_rgb(&mut picture, [pixel[0], pixel[1], pixel[2]]);
    }
    let mut turned = Turned::new(prepared.volume, &prepared.setup.plan);
    let slices = turned.slices()?;
    let (planes, image, counts) = folded(prepared, &slices)?;
    let sums = Sums {
        planes,
        image,
        picture: picture.get(),
    };
    Ok((sums, counts))
}

/// Sums of a frame's stage boundaries and of its image, and its counts.
#[expect(clippy::type_complexity, reason = "three things that are named where they are used")]
fn folded(
    prepared: &Prepared<'_>,
    slices: &[Slice<'_>],
) -> Result<(BTreeMap<PlaneKey, [u32; Stage::ALL.len()]>, u32, Counts), RenderError> {
    let plan = &prepared.setup.plan;
    let rows = plan.base()[1] as usize;
    let mut rendering = prepared.begun()?;
    let (sender, planes) = channel();
    let taps = tapped(&mut *rendering, slices, rows, &|_, _| (), |_| {
        let sender = sender.clone();
        Boundaries::new(move |plane| {
            // The receiver outlives the taps.
            let _ = sender.send(plane);
        })
    });
    for mut tap in taps {
        tap.finish();
    }
    drop(sender);
    let planes = planes
        .iter()
        .map(|p| ((p.index, p.phase.u, p.phase.v), p.sums))
        .collect();
    let mut sum = Sum::new();
    in_memory_order(&rendering.base(), plan.sampling().rays_per_voxel as usize).for_each(|bits| sum.word(bits));

    rendering.begin()?;
    let mut counts = Counts {
        places: places(plan),
        ..Counts::default()
    };
    for counter in tapped(&mut *rendering, slices, rows, &|_, _| (), |_| Counter::default()) {
        counts.samples += counter.0.samples;
        counts.visible += counter.0.visible;
    }
    Ok((planes, sum.get(), counts))
}

/// Sample places inside the volume.
pub fn places(plan: &slicecast::plan::Plan) -> u64 {
    use slicecast::locate::{cell, plane};
    let inside = |at: slicecast::locate::Cell, side: u32, pixels: u32| {
        let last = i64::from(side) - i64::from(at.weight.to_bits() != 0) - i64::from(at.index);
        let first = i64::from(-at.index).clamp(0, i64::from(pixels));
        (last.clamp(0, i64::from(pixels)) - first).max(0) as u64
    };
    let ([width, height, _], [base_width, base_height]) = (plan.dims(), plan.base());
    let mut places = 0;
    for phase in 0..plan.phases() {
        for index in 0..plan.planes() {
            let at = plane(plan, plan.phase(phase), index);
            places += inside(cell(at.x), width, base_width) * inside(cell(at.y), height, base_height);
        }
    }
    places
}

#[derive(Default)]
struct Counter(Counts);

impl Tap for Counter {
    fn row(&mut self, stage: Stage, _: Beam<'_>, rows: &[&dyn Bits]) {
        let len = rows.first().map_or(0, |row| row.len()) as u64;
        match stage {
            Stage::Interpolation => self.0.samples += len,
            Stage::Colour => self.0.visible += len,
            _ => {}
        }
    }
}
