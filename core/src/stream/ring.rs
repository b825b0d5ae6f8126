//! The slices at hand and how far a frame has come: what of a stream does not ask for its pipeline's type.

use core::ops::Range;

use super::{Needs, Part, StreamError};
use crate::clip::Clipper;
use crate::plan::Plan;
use crate::plane::Shape;
use crate::rows::three;
use crate::slice::{Region, RowRange, Slice, Voxel, Window};

/// A ring of slices. The shape that each call is given is the pipeline's: a constant, and no field, so that firmware folds it.
#[derive(Debug)]
pub(super) struct Ring<'m, X> {
    pub(super) plan: Plan,
    slices: &'m mut [u16],
    ranges: &'m mut [RowRange],
    voxels: core::marker::PhantomData<X>,
    /// Rows of the image that the stream makes.
    pub(super) band: Range<u32>,
    pub(super) clips: Option<Clipper<'m>>,
    pub(super) pushed: u32,
    pub(super) folded: u32,
}

impl<'m, X: Voxel> Ring<'m, X> {
    /// A ring without slices, after the stream's memory has been checked; `others` is how much there is for rows under way and for the
    /// image.
    pub(super) fn new(
        shape: Shape,
        plan: Plan,
        (slices, ranges): (&'m mut [u16], &'m mut [RowRange]),
        others: [usize; 2],
        band: Range<u32>,
    ) -> Result<Self, StreamError> {
        let [_, base_height] = plan.base();
        if shape.spreads != plan.spreads() {
            return Err(StreamError::Rays);
        }
        let Range { start: first, end } = band;
        if first >= end || end > base_height {
            let rows = base_height;
            return Err(StreamError::Band { first, end, rows });
        }
        let needs = Needs::of_shape(shape, &plan, end - first);
        let [scratch, image] = others;
        for (part, needed, given) in [
            (Part::Slices, needs.slices, slices.len()),
            (Part::Ranges, needs.ranges, ranges.len()),
            (Part::Scratch, needs.scratch, scratch),
            (Part::Image, needs.image, image),
        ] {
            if given < needed {
                return Err(StreamError::Memory { part, needed, given });
            }
        }
        Ok(Self {
            plan,
            slices,
            ranges,
            voxels: core::marker::PhantomData,
            band,
            clips: None,
            pushed: 0,
            folded: 0,
        })
    }

    /// The number of the slice that is wanted next, counted from the first that is held.
    pub(super) fn wanted(&self, shape: Shape) -> Option<u32> {
        let [_, _, depth] = self.plan.dims();
        let left = depth.checked_sub(self.pushed + 1)?;
        Some(if shape.back_to_front { left } else { self.pushed })
    }

    /// Checks a slice and keeps it.
    pub(super) fn take(&mut self, shape: Shape, slice: X::Given<'_>) -> Result<(), StreamError> {
        let number = self.wanted(shape).ok_or(StreamError::Complete)?;
        let [width, height, _] = three(self.plan.dims(), |side| side as usize);
        let ([whole_width, whole_height, _], [column, row, _]) = (self.plan.volume(), self.plan.first());
        let region = Region {
            whole: [whole_width as usize, whole_height as usize],
            first: [column as usize, row as usize],
            size: [width, height],
        };
        let len = X::WORDS * width * height;
        let slot = (number as usize).checked_rem(shape.slices).unwrap_or(0);
        let ranges = self.ranges.get_mut(slot * height..(slot + 1) * height);
        let kept = self.slices.get_mut(slot * len..(slot + 1) * len);
        // Where a slice is refused its slot is left with wrong ranges, but the next good one overwrites them.
        X::keep(slice, region, kept.unwrap_or(&mut []), ranges.unwrap_or(&mut []))?;
        self.pushed += 1;
        Ok(())
    }

    /// The number of the plane that is folded next, if its slices are all there.
    pub(super) fn ready(&self, shape: Shape) -> Option<u32> {
        let [_, _, depth] = self.plan.dims();
        let Range { start, end } = shape.planes(&self.plan);
        let left = (end - start).checked_sub(self.folded + 1)?;
        // How far a plane looks beyond its two slices.
        let reach = i64::from(shape.slices > 2);
        let index = start + if shape.back_to_front { left } else { self.folded };
        let z = i64::from(shape.near_slice(&self.plan, index));
        let last = i64::from(depth) - 1;
        let farthest = if shape.back_to_front {
            last - (z - reach).max(0)
        } else {
            (z + 1 + reach).min(last)
        };
        (farthest < i64::from(self.pushed)).then_some(index)
    }

    /// The slices around a plane.
    pub(super) fn window(&self, shape: Shape, index: u32) -> Option<Window<'_, X>> {
        let [width, rows, depth] = three(self.plan.dims(), |side| side as usize);
        let slice_len = X::WORDS * width * rows;
        let slice = |z: i32| -> Option<Slice<'_, X>> {
            let z = usize::try_from(z).ok().filter(|z| *z < depth)?;
            let slot = z.checked_rem(shape.slices)?;
            Some(Slice::measured(
                self.slices.get(slot * slice_len..(slot + 1) * slice_len)?,
                self.ranges.get(slot * rows..(slot + 1) * rows)?,
                width,
            ))
        };
        let z = shape.near_slice(&self.plan, index);
        let outer = |z: i32| slice(z).filter(|_| shape.slices > 2);
        Some(Window {
            before: outer(z - 1),
            near: slice(z)?,
            far: slice(z + 1),
            after: outer(z + 2),
        })
    }
}
