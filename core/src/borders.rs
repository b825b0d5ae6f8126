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

use crate::exp2::{LIMIT, absorbed};
use crate::format::Opacity;
use crate::lanes::{Lanes, Small, Wide as _, places};

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
