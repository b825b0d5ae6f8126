//! What clip planes leave of the segments of an extent.

use core::ops::Range;

use super::At;
use super::extent::Extent;
use crate::clip::{Boxed, Clipping, Distances, Remainder};

/// An extent under clip planes.
pub(super) struct Clipped<'c> {
    clips: &'c dyn Clipping,
    distances: Distances,
    boxed: Boxed,
    /// Bits of a colour after 1.0.
    colour_bits: u32,
}

impl<'c> Clipped<'c> {
    /// Of the segments about the samples of a plane, or of those that end at it; `None` without clip planes.
    #[inline(always)]
    pub(super) fn of<X>(at: &At<'c, X>, extent: &Extent, slabs: bool, colour_bits: u32) -> Option<Self> {
        let clips = at.clips?.0;
        Some(Self {
            clips,
            distances: clips.distances(at.plan, at.plane.phase, at.plane.index, slabs),
            boxed: Boxed {
                columns: extent.columns.clone(),
                part: extent.part,
                ends: extent.ends,
            },
            colour_bits,
        })
    }

    /// Whether nothing is left of a row.
    pub(super) fn is_empty(&self, row: u32) -> bool {
        let [left, _] = self.reach(row);
        left.is_empty()
    }

    /// The columns of a row of which something may be left, and a range of those that may be cut.
    pub(super) fn reach(&self, row: u32) -> [Range<usize>; 2] {
        self.clips.reach(&self.distances, &self.boxed, row)
    }

    /// Goes through a span of a row, counted from the extent's first column.
    pub(super) fn each(&self, row: u32, span: Range<usize>, see: &mut dyn FnMut(Range<usize>, Remainder)) {
        self.clips.each(&self.distances, &self.boxed, (row, span), see);
    }

    /// Makes the opacities of a span of samples those of what is left.
    pub(super) fn weigh(&self, row: u32, span: Range<usize>, opacities: &mut [i32]) {
        self.clips.weigh(&self.distances, &self.boxed, (row, span), opacities);
    }

    /// Makes opacities those of a share of the step.
    pub(super) fn fade(&self, opacities: &mut [i32], share: u32) {
        self.clips.fade(opacities, share);
    }

    /// Whether colours turn with depth.
    pub(super) fn cues(&self) -> bool {
        self.clips.cues()
    }

    /// Turns the colours of a row of segments, from a column on, counted from the extent's first.
    pub(super) fn turn(&self, row: u32, first: usize, colours: [&mut [i32]; 3]) {
        let column = self.boxed.columns.start + first;
        self.clips
            .turn(&self.distances, (row, column), colours, self.colour_bits);
    }

    /// Turns colours times extinction alike.
    pub(super) fn turn_weighted(&self, row: u32, first: usize, extinction: &[i32], colours: [&mut [i32]; 3]) {
        let column = self.boxed.columns.start + first;
        self.clips
            .turn_weighted(&self.distances, (row, column), extinction, colours);
    }

    /// The share of a segment's step that lies in the box and is left, 0.16.
    pub(super) fn fraction(&self, left: Remainder) -> u32 {
        ((u64::from(self.boxed.part.length()) * u64::from(left.weight()) + (1 << 15)) >> 16) as u32
    }
}
