//! What clip planes leave of the segments of an extent.

use core::ops::Range;

use super::extent::Extent;
use super::parts::Samples;
use super::{At, parts};
use crate::clip::{Boxed, Clipper, Clipping, Distances, Left, Remainder};
use crate::plan::Plan;

/// What clip planes leave of rows of a plane.
pub(super) enum Rest<'c> {
    /// Nothing.
    Nothing,
    /// All of it, and no colour turns.
    All,
    /// Some, or colours turn.
    Some {
        clips: &'c dyn Clipping,
        distances: Distances,
    },
}

impl<'c> Rest<'c> {
    /// Of so many rows from the first on of a plane of samples, or of the segments that end at it. Colours may turn where there
    /// are any.
    #[inline(always)]
    pub(super) fn of<X>(at: &At<'c, X>, slabs: bool, (first, count): (u32, usize), colours: bool) -> Self {
        let Some(Clipper(clips)) = at.clips else {
            return Self::All;
        };
        let [width, _] = at.plan.base();
        let distances = clips.distances(at.plan, at.plane.phase, at.plane.index, slabs);
        let Left { columns, whole } = clips.left(&distances, &(0..width as usize), &(first..first + count as u32));
        if columns.is_empty() {
            Self::Nothing
        } else if whole && !(colours && clips.cues()) {
            Self::All
        } else {
            Self::Some { clips, distances }
        }
    }

    /// Whether something is cut that the blocks of a plane do not cut: segments and colours lie in rows.
    pub(super) fn cuts_rows(&self, slabs: bool) -> bool {
        matches!(self, Self::Some { clips, .. } if slabs || clips.cues())
    }

    /// Narrows samples of a plane, or both ends of segments, to the columns of which something may be left in one of some rows;
    /// whether it did. Both ends of narrowed segments are made anew, for which half of the columns must be cut away. Not for observers,
    /// to whom rows are the same in tiles of any size.
    #[inline(always)]
    pub(super) fn narrow(
        &self,
        plan: &Plan,
        samples: &mut [Samples<'_>],
        slabs: bool,
        (first, count): (u32, usize),
    ) -> bool {
        let (Self::Some { clips, distances }, [.., Samples { extent, .. }]) = (self, &*samples) else {
            return false;
        };
        let (all, rows) = (&extent.columns, extent.met(first, count));
        let Left { columns, .. } = clips.left(distances, all, &rows);
        if columns == *all || slabs && 2 * columns.len() > all.len() {
            return false;
        }
        for Samples { extent, .. } in &mut *samples {
            extent.keep(columns.clone());
        }
        if !columns.is_empty() {
            let [width, _, _] = plan.dims();
            parts::narrow(samples, width);
        }
        true
    }
}

/// An extent under clip planes.
pub(super) struct Clipped<'c> {
    clips: &'c dyn Clipping,
    distances: &'c Distances,
    boxed: Boxed,
    /// Bits of a colour after 1.0.
    colour_bits: u32,
}

impl<'c> Clipped<'c> {
    /// Of an extent of the plane; `None` where nothing is cut.
    #[inline(always)]
    pub(super) fn of(rest: &'c Rest<'_>, extent: &Extent, colour_bits: u32) -> Option<Self> {
        let Rest::Some { clips, distances } = rest else {
            return None;
        };
        Some(Self {
            clips: *clips,
            distances,
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
        self.clips.reach(self.distances, &self.boxed, row)
    }

    /// Goes through a span of a row, counted from the extent's first column.
    pub(super) fn each(&self, row: u32, span: Range<usize>, see: &mut dyn FnMut(Range<usize>, Remainder)) {
        self.clips.each(self.distances, &self.boxed, (row, span), see);
    }

    /// Makes the opacities of a span of samples those of what is left.
    pub(super) fn weigh(&self, row: u32, span: Range<usize>, opacities: &mut [i32]) {
        self.clips.weigh(self.distances, &self.boxed, (row, span), opacities);
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
            .turn(self.distances, (row, column), colours, self.colour_bits);
    }

    /// Turns colours times extinction alike.
    pub(super) fn turn_weighted(&self, row: u32, first: usize, extinction: &[i32], colours: [&mut [i32]; 3]) {
        let column = self.boxed.columns.start + first;
        self.clips
            .turn_weighted(self.distances, (row, column), extinction, colours);
    }

    /// The share of a segment's step that lies in the box and is left, 0.16.
    pub(super) fn fraction(&self, left: Remainder) -> u32 {
        ((u64::from(self.boxed.part.length()) * u64::from(left.weight()) + (1 << 15)) >> 16) as u32
    }
}
