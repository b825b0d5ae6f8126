//! The sides of a plan's segments: which part of each lies in the box of the volume ([`borders`](crate::borders) has the formats).

use core::ops::Range;

use crate::borders::{Borders, Part, WHOLE};
use crate::crop::Faces;
use crate::format::{Position, Step};
use crate::plan::Plan;

/// The segments of a plane along one axis, in units of 2^-33 voxel: pixel (0, 0)'s, and the box, of the volume or cropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// The front end of pixel 0's segment, from the box's low face.
    pub begin: i64,
    /// From its front end to its back end.
    pub length: i64,
    /// The box, from face to face.
    pub side: i64,
    /// What the front end lies behind `begin`, 0 to 7, in 2^-36 voxel: not 0 of the rays of another plan alone
    /// ([`Plan::offset`](crate::plan::Plan::offset)).
    pub finer: i64,
}

impl Side {
    /// Along i (axis 0) or j (axis 1), for a phase that starts at `start` ([`Plan::start`]): the segments about the samples of the plane with
    /// this number.
    pub fn of(plan: &Plan, start: Step, axis: usize, index: u32) -> Self {
        let halves = match plan.borders() {
            // Cells begin half a voxel before the first slice.
            Borders::Cells => 2 * i64::from(index) - i64::from(plan.sampling().planes_per_voxel),
            Borders::Whole | Borders::Nodes => 2 * i64::from(index),
        };
        Self::from(plan, start, axis, halves)
    }

    /// The same, the segments behind the plane with this number at which segments end ([`end_plane`]).
    ///
    /// [`end_plane`]: crate::locate::end_plane
    pub fn behind(plan: &Plan, start: Step, axis: usize, index: u32) -> Self {
        let halves = 2 * (i64::from(index) - i64::from(plan.ends_before()));
        Self::from(plan, start, axis, halves)
    }

    /// Segments that begin so many half steps behind the first slice.
    fn from(plan: &Plan, start: Step, axis: usize, halves: i64) -> Self {
        let (steps, faces, offsets) = (plan.step(), plan.faces(), plan.offset());
        let (Some(step), Some(faces), Some(offset)) = (steps.get(axis), faces.get(axis), offsets.get(axis)) else {
            return Self {
                begin: 0,
                length: 0,
                side: 0,
                finer: 0,
            };
        };
        let Faces { low, high, open } = *faces;
        let [low, high] = [low, high].map(|face| i64::from(face.to_bits()) << 17);
        // A ray along an open face lies beside the box.
        let open = open && step.to_bits() == 0;
        Self {
            begin: 2 * start.to_bits() + halves * step.to_bits() - low + (offset >> 3),
            length: 2 * step.to_bits(),
            side: high - low - i64::from(open),
            finer: offset & 7,
        }
    }

    /// The part of a pixel's segment between the faces. A segment along the faces is whole between them, and on them. This
    /// function is the definition.
    pub fn part(self, pixel: u32) -> Part {
        let begin = ((self.begin + (i64::from(pixel) << 33)) << 3) + self.finer;
        let (length, side) = (self.length.unsigned_abs() << 3, self.side << 3);
        if length == 0 {
            return if 0 <= begin && begin <= side {
                Part::WHOLE
            } else {
                Part::NONE
            };
        }
        let (into, out) = if self.length > 0 {
            (-begin, side - begin)
        } else {
            (begin - side, begin)
        };
        Part {
            from: share(into, length),
            to: share(out, length),
        }
    }
}

/// The part of the segments about the samples of a plane that lies between the front and the back face of the box.
pub fn about_k(plan: &Plan, index: u32) -> Part {
    // Cells begin half a voxel before the first slice.
    let halves = match plan.borders() {
        Borders::Cells => plan.sampling().planes_per_voxel,
        Borders::Whole | Borders::Nodes => 0,
    };
    from_front(plan, index, halves)
}

/// The part of the segments behind an end plane that lies between the front and the back face of the box.
pub fn along_k(plan: &Plan, index: u32) -> Part {
    from_front(plan, index, 2 * plan.ends_before())
}

/// The part of the segments with this number, the first of which begins so many half segments before the first slice. Exact: a
/// face times the planes per voxel is a whole number of 2^-16 segment.
fn from_front(plan: &Plan, index: u32, halves: u32) -> Part {
    let [_, _, Faces { low, high, .. }] = plan.faces();
    let begin = (i64::from(index) << 16) - (i64::from(halves) << 15);
    let place = |face: Position| {
        let way = i64::from(face.to_bits()) * i64::from(plan.sampling().planes_per_voxel) - begin;
        way.max(0).min(i64::from(WHOLE)) as u32
    };
    Part {
        from: place(low),
        to: place(high),
    }
}

/// Which of a side's pixels have something of their segments between the faces, and which all of it.
impl Side {
    /// The lower end of pixel 0's segment, and its upper end, in 2^-36 voxel.
    fn ends(self) -> [i64; 2] {
        [self.length.min(0), self.length.max(0)].map(|way| ((self.begin + way) << 3) + self.finer)
    }

    /// The pixels whose segments have a part between the faces.
    pub(crate) fn touched(self, pixels: u32) -> Range<u32> {
        if self.length == 0 {
            return self.whole(pixels);
        }
        let [low, high] = self.ends();
        among(pixels, 1 + (-high >> 36), -((low - (self.side << 3)) >> 36))
    }

    /// The pixels whose segments lie between the faces.
    pub(crate) fn whole(self, pixels: u32) -> Range<u32> {
        let [low, high] = self.ends();
        among(pixels, -(low >> 36), 1 + (((self.side << 3) - high) >> 36))
    }
}

/// A range of pixels, as far as there are so many.
fn among(pixels: u32, first: i64, end: i64) -> Range<u32> {
    let held = |pixel: i64| pixel.max(0).min(i64::from(pixels)) as u32;
    held(first)..held(end).max(held(first))
}

/// A distance along a segment of this length, at most 2^36, held to the segment, as its share.
fn share(distance: i64, length: u64) -> u32 {
    let held = (distance.max(0) as u64).min(length);
    // Not 0: a segment has a length here.
    ((held << 17) + length).checked_div(2 * length).unwrap_or(0) as u32
}
