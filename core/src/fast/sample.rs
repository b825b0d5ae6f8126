//! Samples and gradients in 16 bits.
//!
//! `lerp(a, b, w) = a + MH(b - a, w)` with `MH(d, w) = (d w + 2^14) >> 15`, which lies between 0 and d: samples stay between
//! their voxels, and a weight of 0 gives a. Differences of derivatives may have 17 bits, so these are mixed by two products:
//! `mix(a, b, w) = MH(a, 2^15 - w) + MH(b, w)`, a where w is 0.

use crate::format::{Intensity, Weight};
use crate::lanes::{Halves, each};

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
pub(crate) struct Both<H> {
    near: H,
    far: H,
    /// Whether the weight is not 0.
    mixes: bool,
}

impl<H: Halves> Both<H> {
    #[inline(always)]
    pub(crate) fn of(w: u16) -> Self {
        Self {
            near: H::splat((1 << 15) - w),
            far: H::splat(w),
            mixes: w != 0,
        }
    }

    /// [`Both::mix`] where the weight is not 0.
    #[inline(always)]
    pub(crate) fn mix_both(self, a: H, b: H) -> H {
        a.product_round(self.near).plus(b.product_round(self.far))
    }

    /// From `a` to `b`, whose difference may have 17 bits.
    #[inline(always)]
    pub(crate) fn mix(self, a: H, b: H) -> H {
        if self.mixes { self.mix_both(a, b) } else { a }
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
        each!(H, len, |at, WHOLE| {
            H::load::<WHOLE>(near, at).shl(VOXEL_SHIFT).store::<WHOLE>(out, at);
        });
        return;
    }
    let w = H::splat(w);
    each!(H, len, |at, WHOLE| {
        let (a, b) = (H::load::<WHOLE>(near, at), H::load::<WHOLE>(far, at));
        lerp(a.shl(VOXEL_SHIFT), b.shl(VOXEL_SHIFT), w).store::<WHOLE>(out, at);
    });
}

/// y interpolation of two rows' elements `at ..`, shifted left first.
#[inline(always)]
fn along_y<H: Halves, const WHOLE: bool>([a, b]: [&[u16]; 2], at: usize, shift: u32, y: H) -> H {
    lerp(
        H::load::<WHOLE>(a, at).shl(shift),
        H::load::<WHOLE>(b, at).shl(shift),
        y,
    )
}

/// The first elements of two rows, and those behind each of them, all equally long: then one comparison finds that a vector lies inside
/// all of them.
#[inline(always)]
fn beside([a, b]: [&[u16]; 2], len: usize) -> Option<[[&[u16]; 2]; 2]> {
    Some([[a.get(..len)?, b.get(..len)?], [a.get(1..=len)?, b.get(1..=len)?]])
}

/// y, then x interpolation of two rows, which are shifted left first; sample i lies between elements i and i + 1. Where an x weight asks
/// for an element behind the rows, there is no sample.
#[inline(always)]
pub fn yx_row<H: Halves>(a: &[u16], b: &[u16], shift: u32, [wx, wy]: [u16; 2], out: &mut [u16]) {
    let (x, y) = (H::splat(wx), H::splat(wy));
    if wx == 0 {
        let len = out.len();
        let (Some(a), Some(b)) = (a.get(..len), b.get(..len)) else {
            return;
        };
        each!(H, len, |at, WHOLE| {
            along_y::<H, WHOLE>([a, b], at, shift, y).store::<WHOLE>(out, at);
        });
        return;
    }
    let len = out.len().min(a.len().saturating_sub(1));
    let (Some(out), Some([left, right])) = (out.get_mut(..len), beside([a, b], len)) else {
        return;
    };
    if H::COUNT == 1 {
        // One lane makes each column once: what lies to the right of a sample lies to the left of the next.
        let mut before = along_y::<H, true>(left, 0, shift, y);
        for at in 0..len {
            let behind = along_y::<H, true>(right, at, shift, y);
            lerp(before, behind, x).store::<true>(out, at);
            before = behind;
        }
        return;
    }
    each!(H, len, |at, WHOLE| {
        let sample = lerp(
            along_y::<H, WHOLE>(left, at, shift, y),
            along_y::<H, WHOLE>(right, at, shift, y),
            x,
        );
        sample.store::<WHOLE>(out, at);
    });
}

/// x interpolation of the difference of two rows; as [`yx_row`].
#[inline(always)]
pub fn slope_row<H: Halves>(a: &[u16], b: &[u16], wx: u16, out: &mut [u16]) {
    if wx == 0 {
        difference_row::<H>(b, a, out);
        return;
    }
    let x = H::splat(wx);
    let len = out.len().min(a.len().saturating_sub(1));
    let (Some(out), Some([[a, b], [c, d]])) = (out.get_mut(..len), beside([a, b], len)) else {
        return;
    };
    each!(H, len, |at, WHOLE| {
        let before = lerp(H::load::<WHOLE>(a, at), H::load::<WHOLE>(c, at), x);
        let behind = lerp(H::load::<WHOLE>(b, at), H::load::<WHOLE>(d, at), x);
        behind.minus(before).store::<WHOLE>(out, at);
    });
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

impl<'a> Slope<'a> {
    #[inline(always)]
    pub(crate) fn at<H: Halves, const WHOLE: bool>(&self, at: usize) -> H {
        H::load::<WHOLE>(self.minuend, at)
            .minus(H::load::<WHOLE>(self.subtrahend, at))
            .shl(self.shift)
    }

    /// The first columns, if there are as many.
    #[inline(always)]
    fn first(self, len: usize) -> Option<Self> {
        Some(Self {
            minuend: self.minuend.get(..len)?,
            subtrahend: self.subtrahend.get(..len)?,
            ..self
        })
    }
}

/// z interpolation of derivatives along z.
#[inline(always)]
pub fn slopes_row<H: Halves>(near: Slope<'_>, far: Slope<'_>, w: u16, out: &mut [u16]) {
    let len = out.len();
    let (Some(near), Some(far)) = (near.first(len), far.first(len)) else {
        return;
    };
    if w == 0 {
        each!(H, len, |at, WHOLE| {
            near.at::<H, WHOLE>(at).store::<WHOLE>(out, at);
        });
        return;
    }
    let w = Both::<H>::of(w);
    each!(H, len, |at, WHOLE| {
        w.mix_both(near.at::<H, WHOLE>(at), far.at::<H, WHOLE>(at))
            .store::<WHOLE>(out, at);
    });
}

/// y, then x interpolation of derivatives; as [`yx_row`].
#[inline(always)]
pub fn mixed_row<H: Halves>(a: &[u16], b: &[u16], [wx, wy]: [u16; 2], out: &mut [u16]) {
    let (x, y) = (Both::<H>::of(wx), Both::<H>::of(wy));
    if wx == 0 {
        let len = out.len();
        let (Some(a), Some(b)) = (a.get(..len), b.get(..len)) else {
            return;
        };
        each!(H, len, |at, WHOLE| {
            y.mix(H::load::<WHOLE>(a, at), H::load::<WHOLE>(b, at))
                .store::<WHOLE>(out, at);
        });
        return;
    }
    let len = out.len().min(a.len().saturating_sub(1));
    let (Some(out), Some([[a, b], [c, d]])) = (out.get_mut(..len), beside([a, b], len)) else {
        return;
    };
    if wy == 0 {
        each!(H, len, |at, WHOLE| {
            x.mix(H::load::<WHOLE>(a, at), H::load::<WHOLE>(c, at))
                .store::<WHOLE>(out, at);
        });
        return;
    }
    if H::COUNT == 1 {
        let mut left = y.mix_both(H::load::<true>(a, 0), H::load::<true>(b, 0));
        for at in 0..len {
            let right = y.mix_both(H::load::<true>(c, at), H::load::<true>(d, at));
            x.mix_both(left, right).store::<true>(out, at);
            left = right;
        }
        return;
    }
    each!(H, len, |at, WHOLE| {
        let left = y.mix_both(H::load::<WHOLE>(a, at), H::load::<WHOLE>(b, at));
        let right = y.mix_both(H::load::<WHOLE>(c, at), H::load::<WHOLE>(d, at));
        x.mix_both(left, right).store::<WHOLE>(out, at);
    });
}

/// The difference of two rows of samples.
#[inline(always)]
pub fn difference_row<H: Halves>(next: &[u16], previous: &[u16], out: &mut [u16]) {
    let len = out.len().min(next.len()).min(previous.len());
    let (Some(next), Some(previous), Some(out)) = (next.get(..len), previous.get(..len), out.get_mut(..len)) else {
        return;
    };
    each!(H, len, |at, WHOLE| {
        H::load::<WHOLE>(next, at)
            .minus(H::load::<WHOLE>(previous, at))
            .store::<WHOLE>(out, at);
    });
}

/// Halves components, towards minus infinity.
#[inline(always)]
pub fn halve_row<H: Halves>(row: &mut [u16]) {
    each!(H, row.len(), |at, WHOLE| {
        H::load::<WHOLE>(row, at).shr_signed(1).store::<WHOLE>(row, at);
    });
}

/// The half of a one-sided difference and of the slope beyond it: a component at a face.
#[inline(always)]
pub fn face_row<H: Halves>(slope: &[u16], row: &mut [u16]) {
    let Some(slope) = slope.get(..row.len()) else {
        return;
    };
    each!(H, row.len(), |at, WHOLE| {
        let half = H::load::<WHOLE>(slope, at).shr_signed(1);
        H::load::<WHOLE>(row, at)
            .shr_signed(1)
            .plus(half)
            .store::<WHOLE>(row, at);
    });
}

/// Components times their spacing factor; a factor of 1 leaves them alone.
#[inline(always)]
pub fn space_row<H: Halves>(row: &mut [u16], factor: Intensity) {
    if factor != Intensity::ONE {
        let factor = H::splat(factor.to_bits());
        each!(H, row.len(), |at, WHOLE| {
            H::load::<WHOLE>(row, at).product_round(factor).store::<WHOLE>(row, at);
        });
    }
}
