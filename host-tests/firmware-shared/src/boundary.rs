//! A tap that sums up every stage boundary of every sample plane.

use slicecast::locate::Plane;
use slicecast::plan::Phase;
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits, Tap};

use crate::sum::Sum;

/// The sums of one sample plane of one phase, in the order of [`Stage::ALL`]. A stage that did nothing has 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneSums {
    /// The phase.
    pub phase: Phase,
    /// Number of the plane.
    pub index: u32,
    /// One sum a stage.
    pub sums: [u32; Stage::ALL.len()],
}

/// Sums up boundaries and hands over the sums of a plane when the next one begins.
#[derive(Debug)]
pub struct Boundaries<F: FnMut(PlaneSums)> {
    plane: Option<(Phase, u32)>,
    sums: [Sum; Stage::ALL.len()],
    done: F,
}

impl<F: FnMut(PlaneSums)> Boundaries<F> {
    /// A tap that calls `done` for every plane.
    pub const fn new(done: F) -> Self {
        Self {
            plane: None,
            sums: [Sum::new(); Stage::ALL.len()],
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
        self.sums = [Sum::new(); Stage::ALL.len()];
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

    fn row(&mut self, stage: Stage, at: Beam<'_>, rows: &[&dyn Bits]) {
        if let Some(sum) = self.sums.get_mut(stage as usize) {
            sum.word(at.row);
            sum.word(at.column);
            for row in rows {
                sum.row((0..row.len()).map(|index| row.bits(index)));
            }
        }
    }
}
