//! Borders: how much of a ray's step lies in the volume.
//!
//! Source: LaMar, adaptive border sampling; `docs/contract/borders.md` has the ranges and the proof.
//!
//! A sample stands for a segment of its ray. With exact borders it lies in the middle of the segment, is held to the voxels,
//! and counts by the fraction of the segment that lies in the box of the volume. Where segments between samples are classified,
//! these lie at both ends of that part.
//!
//! | value | format | unit |
//! |---|---|---|
//! | front end of a segment, from the box's low face | s30.33, of the rays of another plan s27.36 | voxels |
//! | part of a segment, from .. to | 0.16, both ends included | segments |
//! | fraction f | 0.16, 65536 is 1 | segments |
//! | opacity, optical depth y | 1.31, u5.27 | light, powers of 2 |
//!
//! Rounding: nearest, parts halves up. The fractions of a ray add up to its length in segments within 1 ulp. Overflow: none
//! inside a `Plan`. State: none.

use core::ops::Range;

use crate::crop::Faces;
use crate::exp2::{LIMIT, absorbed};
use crate::format::{Opacity, Position, Step};
use crate::lanes::{Lanes, Small, Wide as _, places};
use crate::plan::Plan;

/// Where the volume ends, and what a sample at its borders counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Borders {
    /// Every sample between the first and the last voxel counts as a whole step, and none beyond: Squeeze.
    Whole,
    /// The box of the voxels' cells, from half a voxel before the first to half a voxel behind the last.
    #[default]
    Cells,
    /// The box between the first and the last voxel, along each axis.
    Nodes,
}

/// A whole segment, 0.16.
pub const WHOLE: u32 = 1 << 16;

/// The part of a segment that lies between two faces, 0.16; nothing if it ends before it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Where it begins.
    pub from: u32,
    /// Where it ends.
    pub to: u32,
}

impl Part {
    /// All of it.
    pub const WHOLE: Self = Self { from: 0, to: WHOLE };
    /// Nothing.
    pub const NONE: Self = Self { from: WHOLE, to: 0 };

    /// What lies in this part and in another: between the faces of both axes.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            from: if self.from > other.from { self.from } else { other.from },
            to: if self.to < other.to { self.to } else { other.to },
        }
    }

    /// How long it is.
    pub const fn length(self) -> u32 {
        self.to.saturating_sub(self.from)
    }

    /// The fraction that lies in this part and in another.
    pub const fn fraction(self, other: Self) -> u32 {
        self.and(other).length()
    }
}

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

/// The largest error of [`opacity_of_fraction`], ulp of 1.31.
pub const ERROR: f64 = 60.0;

/// Coefficients of `-log2(1 - w / 2) / (w / 2)`, s1.30, the highest power first: the polynomial that meets it at Chebyshev
/// nodes, within 2^-26.8.
const COEFFICIENTS: [i32; 10] = [
    0x0050_08cb,
    -0x00e3_0ac4,
    0x0169_eb60,
    -0x00d9_effb,
    0x00fb_b21c,
    0x0103_2e9f,
    0x02e8_7105,
    0x07b1_4c36,
    0x1715_4b06,
    0x5c55_1d90,
];

/// `-log2` of a transparency above 0, 1.31: u5.27.
#[inline(always)]
fn depth<V: Lanes>(transparency: V) -> V {
    let whole = transparency.leading_zeros().at_most(V::splat(31));
    // m = 1 - u of the transparency times 2^(whole - 1); w = 2 u, 1.31.
    let w = V::splat(0).wrapping_sub(transparency.shl_each(whole));
    let half = w.shr_unsigned(1);
    let [first, rest @ ..] = COEFFICIENTS;
    let mut sum = V::splat(first);
    for c in rest {
        sum = sum.product_signed(half).shr_narrow(30).wrapping_add(V::splat(c));
    }
    let part = (w.product(sum) + V::Wide::splat(1 << 34)).shr(35).narrow();
    ((whole - V::splat(1)) << 27).wrapping_add(part)
}

/// The opacity of a fraction of a segment, `1 - (1 - a)^f`, 1.31, at most a. What is opaque stays opaque. This function is
/// the definition.
///
/// Range: a at most 2^31, f 1 to [`WHOLE`] (which changes nothing).
#[inline(always)]
pub fn opacity_of_fraction<V: Lanes>(opacity: V, fraction: u32) -> V {
    if fraction >= WHOLE {
        return opacity;
    }
    opacity_of_part(opacity, V::splat(fraction as i32))
}

/// The same of another fraction in each lane, each less than [`WHOLE`].
#[inline(always)]
fn opacity_of_part<V: Lanes>(opacity: V, fraction: V) -> V {
    let one = V::splat(i32::MIN);
    let transparency = one.wrapping_sub(opacity);
    let y = depth(transparency).product(fraction) + V::Wide::splat(1 << 18);
    let left = one.wrapping_sub(absorbed(y.shr_narrow(19)));
    // A depth is a whole number of 2^-24: the part of a very thin step would round to more than the step.
    one.wrapping_sub(transparency.nonzero_then(left))
        .at_most_unsigned(opacity)
}

/// The opacity of a step that is so many times as long, `1 - (1 - a)^l`, 1.31, at least a: l in 3.20, 1 to
/// [`LENGTH_MAX`](crate::perspective::LENGTH_MAX). What is transparent stays transparent, what is opaque opaque. This function is the
/// definition.
#[inline(always)]
pub fn opacity_of_length<V: Lanes>(opacity: V, length: V) -> V {
    let one = V::splat(i32::MIN);
    let transparency = one.wrapping_sub(opacity);
    let y = depth(transparency).product(length) + V::Wide::splat(1 << 22);
    let y = y.shr_narrow(23).at_most_unsigned(V::splat(LIMIT as i32));
    let left = transparency.nonzero_then(one.wrapping_sub(absorbed(y)));
    opacity.nonzero_then(one.wrapping_sub(left.at_most_unsigned(transparency)))
}

/// Applies [`opacity_of_length`] along a row, of another length in each column.
#[inline(always)]
pub fn lengths_row<V: Lanes>(opacities: &mut [i32], lengths: &[i32]) {
    let Some(lengths) = lengths.get(..opacities.len()) else {
        return;
    };
    for at in places::<V>(opacities.len()) {
        let opacity = V::load(opacities, at);
        if !opacity.all_zero() {
            opacity_of_length(opacity, V::load(lengths, at)).store(opacities, at);
        }
    }
}

/// [`opacity_of_fraction`] of one opacity.
pub fn fraction_of(opacity: Opacity, fraction: u32) -> Opacity {
    Opacity::from_bits(opacity_of_fraction(opacity.to_bits() as i32, fraction) as u32)
}

/// Applies [`opacity_of_fraction`] along a row.
#[inline(always)]
pub fn fraction_row<V: Lanes>(opacities: &mut [i32], fraction: u32) {
    if V::SMALL {
        return fraction_row_small(opacities, fraction);
    }
    for at in places::<V>(opacities.len()) {
        opacity_of_fraction(V::load(opacities, at), fraction).store(opacities, at);
    }
}

/// Applies [`opacity_of_fraction`] along a row, of another fraction in each column, 0 to [`WHOLE`]: of 0 nothing is left.
#[inline(always)]
pub fn fractions_row<V: Lanes>(opacities: &mut [i32], fractions: &[i32]) {
    if V::SMALL {
        for (opacity, fraction) in opacities.iter_mut().zip(fractions) {
            let mut own = [*opacity];
            if *fraction == 0 {
                own = [0];
            } else {
                fraction_row_small(&mut own, *fraction as u32);
            }
            [*opacity] = own;
        }
        return;
    }
    let whole = V::splat(WHOLE as i32);
    for at in places::<V>(opacities.len()) {
        let (opacity, fraction) = (V::load(opacities, at), V::load(fractions, at));
        let part = fraction.nonzero_then(opacity_of_part(opacity, fraction));
        let part = part ^ fraction.at_least_then(whole, part ^ opacity);
        part.store(opacities, at);
    }
}

/// On a small machine invisible samples, most of them, are left alone; a pipeline has the code once.
#[inline(never)]
fn fraction_row_small(opacities: &mut [i32], fraction: u32) {
    for opacity in opacities.iter_mut().filter(|opacity| **opacity != 0) {
        let mut out = [0];
        opacity_of_fraction(Small::splat(*opacity), fraction).store(&mut out, 0);
        [*opacity] = out;
    }
}

#[cfg(test)]
mod tests;
