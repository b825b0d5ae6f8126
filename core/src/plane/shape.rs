//! What is known of a pipeline by its type alone, as values: code that needs no more is compiled once for all pipelines.

use core::ops::Range;

use super::scratch::{self, Rows as ScratchRows};
use crate::locate::{self, Plane, cell};
use crate::plan::{Phase, Plan};

/// How a pipeline's images, planes and memory are laid out ([`Pipeline::SHAPE`](super::Pipeline::SHAPE)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Runs in a row of the image.
    pub channels: usize,
    /// Bytes of an element of the image.
    pub element_bytes: usize,
    /// Slices that must be at hand at a time.
    pub slices: usize,
    /// Words of 16 bits that a voxel has.
    pub words: usize,
    /// The rows of scratch memory.
    pub scratch: ScratchRows,
    /// Whether a plane is folded together with the one in front of it.
    pub slabs: bool,
    /// Whether rays spread from an eye.
    pub spreads: bool,
    /// Whether planes go from the last to the first.
    pub back_to_front: bool,
}

impl Shape {
    /// Numbers of the planes of a plan that are folded: those of samples, or those at which segments end, of which the first ends
    /// none.
    pub const fn planes(&self, plan: &Plan) -> Range<u32> {
        if self.slabs { plan.ends_met() } else { plan.planes_met() }
    }

    /// The one with this number.
    pub fn plane(&self, plan: &Plan, phase: Phase, index: u32) -> Plane {
        if self.slabs {
            locate::end_plane(plan, phase, index)
        } else {
            locate::plane(plan, phase, index)
        }
    }

    /// Number, among those held, of the slice that is nearest in the window of a plane: the one before the plane, or before the one
    /// in front of it where both are folded together.
    pub fn near_slice(&self, plan: &Plan, index: u32) -> i32 {
        let first = if self.slabs {
            index.saturating_sub(1).max(plan.ends_met().start)
        } else {
            index
        };
        cell(self.plane(plan, Phase::default(), first).z).index
    }

    /// Words of scratch memory for slices of this width; in perspective for rows of this length ([`Plan::longest_row`]).
    pub const fn scratch_len(&self, width: u32) -> usize {
        self.scratch.len(width)
    }

    /// Words of scratch memory for blocks of slices of this width.
    pub const fn blocks_scratch_len(&self, width: u32) -> usize {
        scratch::blocks_len(self.scratch, width)
    }

    /// Elements of a row of the image.
    pub const fn row_len(&self, plan: &Plan) -> usize {
        let [width, _] = plan.base();
        self.channels * width as usize
    }

    /// Elements of one phase of the image.
    pub const fn phase_len(&self, plan: &Plan) -> usize {
        let [_, height] = plan.base();
        self.rows_len(plan, height)
    }

    /// Elements of some rows of one phase.
    pub(crate) const fn rows_len(&self, plan: &Plan, rows: u32) -> usize {
        self.row_len(plan).saturating_mul(rows as usize)
    }

    /// Where pixel (u, v) of an image of all phases lies, of which these rows are held: the start of its row, and its column. `None`
    /// outside them.
    pub fn place(&self, plan: &Plan, rows: Range<u32>, [u, v]: [i64; 2]) -> Option<(usize, usize)> {
        let n = u64::from(plan.sampling().rays_per_voxel);
        let (u, v) = (u64::try_from(u).ok()?, u64::try_from(v).ok()?);
        let [width, _] = plan.base();
        let (column, row) = (u.checked_div(n)? as usize, u32::try_from(v.checked_div(n)?).ok()?);
        if column >= width as usize || !rows.contains(&row) {
            return None;
        }
        let phase = (u.checked_rem(n)? + n * v.checked_rem(n)?) as usize;
        let start =
            phase * self.rows_len(plan, rows.end - rows.start) + (row - rows.start) as usize * self.row_len(plan);
        Some((start, column))
    }
}
