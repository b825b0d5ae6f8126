//! Samples and gradients in 16 bits.
//!
//! `lerp(a, b, w) = a + MH(b - a, w)` with `MH(d, w) = (d w + 2^14) >> 15`, which lies between 0 and d: samples stay between
//! their voxels, and a weight of 0 gives a. Differences of derivatives may have 17 bits, so these are mixed by two products:
//! `mix(a, b, w) = MH(a, 2^15 - w) + MH(b, w)`, a where w is 0.

use crate::format::{Intensity, Weight};
use crate::lanes::{Halves, places_of};

/// A weight's upper 15 bits.
#[inline(always)]
pub const fn short(weight: Weight) -> u16 {
    (weight.to_bits() >> 1) as u16
}

/// Voxels as samples: 12.3.
pub const VOXEL_SHIFT: u32 = 3;

/// From `a` to `b`.
#[inline(always)]
pub fn lerp<H: Halves>(a: H, b: H, w: H) -> H {
    a.plus(b.minus(a).product_round(w))
}

/// A weight, and 2^15 less it, of which 2^15 itself is not asked.
#[derive(Clone, Copy)]
struct Both<H> {
    near: H,
    far: H,
    /// Whether the weight is not 0.
    mixes: bool,
}

impl<H: Halves> Both<H> {
    #[inline(always)]
    fn of(w: u16) -> Self {
        Self {
            near: H::splat((1 << 15) - w),
            far: H::splat(w),
            mixes: w != 0,
        }
    }

    /// From `a` to `b`, whose difference may have 17 bits.
    #[inline(always)]
    fn mix(self, a: H, b: H) -> H {
        if self.mixes {
            a.product_round(self.near).plus(b.product_round(self.far))
        } else {
            a
        }
    }
}

/// z interpolation of a row of voxels.
#[inline(always)]
pub fn z_row<H: Halves>(near: &[u16], far: &[u16], w: u16, out: &mut [u16]) {
    let len = out.len();
    let (Some(near), Some(far)) = (near.get(..len), far.get(..len)) else {
        return;
    };
    if w == 0 {
        for at in places_of::<H>(len) {
            H::load(near, at).shl(VOXEL_SHIFT).store(out, at);
        }
        return;
    }
    let w = H::splat(w);
    for at in places_of::<H>(len) {
        let (a, b) = (H::load(near, at), H::load(far, at));
        lerp(a.shl(VOXEL_SHIFT), b.shl(VOXEL_SHIFT), w).store(out, at);
    }
}

/// Two rows that are shifted left, and mixed by a weight along y.
#[derive(Clone, Copy)]
struct Pair<'a> {
    rows: [&'a [u16]; 2],
    shift: u32,
}

impl Pair<'_> {
    #[inline(always)]
    fn along_y<H: Halves>(&self, at: usize, y: H) -> H {
        let [a, b] = self.rows;
        lerp(H::load(a, at).shl(self.shift), H::load(b, at).shl(self.shift), y)
    }
}

/// y, then x interpolation of two rows, which are shifted left first; sample i lies between elements i and i + 1.
#[inline(always)]
pub fn yx_row<H: Halves>(a: &[u16], b: &[u16], shift: u32, [wx, wy]: [u16; 2], out: &mut [u16]) {
    let (x, y, rows) = (H::splat(wx), H::splat(wy), Pair { rows: [a, b], shift });
    if wx == 0 {
        for at in places_of::<H>(out.len()) {
            rows.along_y(at, y).store(out, at);
        }
        return;
    }
    for at in places_of::<H>(out.len()) {
        lerp(rows.along_y(at, y), rows.along_y(at + 1, y), x).store(out, at);
    }
}

/// x interpolation of the difference of two rows.
#[inline(always)]
pub fn slope_row<H: Halves>(a: &[u16], b: &[u16], wx: u16, out: &mut [u16]) {
    let x = H::splat(wx);
    for at in places_of::<H>(out.len()) {
        let a = lerp(H::load(a, at), H::load(a, at + 1), x);
        let b = lerp(H::load(b, at), H::load(b, at + 1), x);
        b.minus(a).store(out, at);
    }
}

/// The derivative along z at a slice: `(minuend - subtrahend) << shift`; nothing of a volume of one slice.
#[derive(Clone, Copy, Debug)]
pub struct Slope<'a> {
    /// Voxels behind.
    pub minuend: &'a [u16],
    /// Voxels before.
    pub subtrahend: &'a [u16],
    /// At most 3.
    pub shift: u32,
}

impl Slope<'_> {
    #[inline(always)]
    fn at<H: Halves>(&self, at: usize) -> H {
        H::load(self.minuend, at).minus(H::load(self.subtrahend, at)).shl(self.shift)
    }
}

/// z interpolation of derivatives along z.
#[inline(always)]
pub fn slopes_row<H: Halves>(near: Slope<'_>, far: Slope<'_>, w: u16, out: &mut [u16]) {
    let w = Both::<H>::of(w);
    for at in places_of::<H>(out.len()) {
        w.mix(near.at(at), far.at(at)).store(out, at);
    }
}

/// y, then x interpolation of derivatives.
#[inline(always)]
pub fn mixed_row<H: Halves>(a: &[u16], b: &[u16], [wx, wy]: [u16; 2], out: &mut [u16]) {
    let (x, y) = (Both::<H>::of(wx), Both::<H>::of(wy));
    for at in places_of::<H>(out.len()) {
        let left = y.mix(H::load(a, at), H::load(b, at));
        let right = y.mix(H::load(a, at + 1), H::load(b, at + 1));
        x.mix(left, right).store(out, at);
    }
}

/// The difference of two rows of samples.
#[inline(always)]
pub fn difference_row<H: Halves>(next: &[u16], previous: &[u16], out: &mut [u16]) {
    for at in places_of::<H>(out.len()) {
        H::load(next, at).minus(H::load(previous, at)).store(out, at);
    }
}

/// Halves components, towards minus infinity.
#[inline(always)]
pub fn halve_row<H: Halves>(row: &mut [u16]) {
    for at in places_of::<H>(row.len()) {
        H::load(row, at).shr_signed(1).store(row, at);
    }
}

/// The half of a one-sided difference and of the slope beyond it: a component at a face.
#[inline(always)]
pub fn face_row<H: Halves>(slope: &[u16], row: &mut [u16]) {
    for at in places_of::<H>(row.len()) {
        let half = H::load(slope, at).shr_signed(1);
        H::load(row, at).shr_signed(1).plus(half).store(row, at);
    }
}

/// Components times their spacing factor; a factor of 1 leaves them alone.
#[inline(always)]
pub fn space_row<H: Halves>(row: &mut [u16], factor: Intensity) {
    if factor != Intensity::ONE {
        let factor = H::splat(factor.to_bits());
        for at in places_of::<H>(row.len()) {
            H::load(row, at).product_round(factor).store(row, at);
        }
    }
}
