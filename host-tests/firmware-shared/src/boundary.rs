//! A tap that sums up every stage boundary of every sample plane.

use slicecast::composite::{Channel, PixelRow};
use slicecast::locate::Plane;
use slicecast::plan::Phase;
use slicecast::tap::{Beam, Tap};

use crate::sum::Sum;

/// The stage boundaries, in the order of the pipeline.
pub const STAGES: [&str; 9] = [
    "locate",
    "interpolate",
    "classify: opacity",
    "classify: colour",
    "gradient",
    "normalise",
    "shade",
    "composite: before",
    "composite: after",
];

/// The sums of one sample plane of one phase, in the order of [`STAGES`]. A stage that did nothing has 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneSums {
    /// The phase.
    pub phase: Phase,
    /// Number of the plane.
    pub index: u32,
    /// One sum a stage.
    pub sums: [u32; STAGES.len()],
}

/// Sums up boundaries and hands over the sums of a plane when the next one begins.
#[derive(Debug)]
pub struct Boundaries<F: FnMut(PlaneSums)> {
    plane: Option<(Phase, u32)>,
    sums: [Sum; STAGES.len()],
    done: F,
}

impl<F: FnMut(PlaneSums)> Boundaries<F> {
    /// A tap that calls `done` for every plane.
    pub const fn new(done: F) -> Self {
        Self {
            plane: None,
            sums: [Sum::new(); STAGES.len()],
            done,
        }
    }

    /// Hands over the last plane.
    pub fn finish(&mut self) {
        if let Some((phase, index)) = self.plane.take() {
            (self.done)(PlaneSums {
                phase,
                index,
                sums: self.sums.map(Sum::get),
            });
        }
        self.sums = [Sum::new(); STAGES.len()];
    }

    fn rows<const N: usize>(&mut self, stage: usize, at: Beam<'_>, rows: [&[i32]; N]) {
        if let Some(sum) = self.sums.get_mut(stage) {
            sum.word(at.row);
            sum.word(at.column);
            for row in rows {
                sum.row(row.iter().map(|v| *v as u32));
            }
        }
    }

    fn pixels<C: Channel>(&mut self, stage: usize, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        if let Some(sum) = self.sums.get_mut(stage) {
            sum.word(at.row);
            sum.word(at.column);
            for run in &pixels.colour {
                sum.row(run.iter().map(|c| c.bits()));
            }
            sum.row(pixels.transparency.iter().map(|t| t.bits()));
        }
    }
}

impl<F: FnMut(PlaneSums)> Tap for Boundaries<F> {
    fn plane(&mut self, plane: &Plane) {
        self.finish();
        self.plane = Some((plane.phase, plane.index));
        let words = [plane.index, plane.phase.u, plane.phase.v];
        let positions = [plane.x, plane.y, plane.z].map(|p| p.to_bits() as u32);
        let [sum, ..] = &mut self.sums;
        sum.row(words.into_iter());
        sum.row(positions.into_iter());
    }

    fn samples(&mut self, at: Beam<'_>, samples: &[i32]) {
        self.rows(1, at, [samples]);
    }

    fn opacities(&mut self, at: Beam<'_>, opacities: &[i32]) {
        self.rows(2, at, [opacities]);
    }

    fn colours(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        self.rows(3, at, colours);
    }

    fn gradients(&mut self, at: Beam<'_>, gradients: [&[i32]; 3]) {
        self.rows(4, at, gradients);
    }

    fn normals(&mut self, at: Beam<'_>, [x, y, z]: [&[i32]; 3], r: &[i32]) {
        self.rows(5, at, [x, y, z, r]);
    }

    fn shaded(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        self.rows(6, at, colours);
    }

    fn before<C: Channel>(&mut self, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        self.pixels(7, at, pixels);
    }

    fn after<C: Channel>(&mut self, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        self.pixels(8, at, pixels);
    }
}
