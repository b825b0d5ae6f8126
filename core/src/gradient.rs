//! Gradient: the direction in which the volume rises, at a sample.
//!
//! Source: the central difference of Squeeze, section 4.3, taken on the voxel grid and interpolated at the sample.
//! Along i and j that equals the difference of neighbouring samples of the same plane, because all samples of a plane
//! share their weights; along k the slices' derivatives `V[z+1] - V[z-1]` are interpolated in place of voxels. One
//! voxel beyond each face the volume is continued linearly (`interpolate`), which makes the one-sided difference
//! there count in full.
//!
//! | value | format | range | unit |
//! |---|---|---|---|
//! | sample | 12.F | -4095 to 8190 with ghosts | data code |
//! | G | s13.F | -8190 to 8190 | data code over two voxels |
//! | spacing factor f | 1.15 | 0 to 1 | smallest spacing / spacing |
//!
//! `Gx = S(i+1) - S(i-1)`, `Gy = S(j+1) - S(j-1)`, exact; `Gz` as a sample of derivatives. Then `G f`, to nearest.
//! Error: along i and j that of two samples (1.5 ulp of 12.15, 1.07 of 12.12), along k that of one, and 0.5 ulp more
//! where f is not 1; `Paper` cuts its weights, which costs more than any of this.
//! Overflow: none, |G| <= 8190 * 2^15 < 2^28.01. State: none.

use crate::format::Intensity;
use crate::lanes::{Lanes, places};

/// Difference of two rows of samples: `next - previous`. All rows equally long.
#[inline(always)]
pub fn difference_row<V: Lanes>(next: &[i32], previous: &[i32], out: &mut [i32]) {
    let len = out.len();
    let (Some(next), Some(previous)) = (next.get(..len), previous.get(..len)) else {
        return;
    };
    for at in places::<V>(len) {
        (V::load(next, at) - V::load(previous, at)).store(out, at);
    }
}

/// A gradient component times its spacing factor, to nearest, halves up. This function is the definition.
///
/// Range: |G| < 2^29, f <= 1.
#[inline(always)]
pub fn space<V: Lanes>(component: V, factor: Intensity) -> V {
    component.round15(V::splat(i32::from(factor.to_bits())))
}

/// Applies [`space`] along a row; a factor of 1 leaves it alone.
#[inline(always)]
pub fn space_row<V: Lanes>(row: &mut [i32], factor: Intensity) {
    if factor != Intensity::ONE {
        for at in places::<V>(row.len()) {
            space(V::load(row, at), factor).store(row, at);
        }
    }
}

/// A gradient of which the largest component keeps `bits` bits (1 to 15) and the others the same scale; to nearest on
/// magnitudes, saturated. 15 bits are all that normalisation reads. For studies ([`Formats::gradient_bits`]).
///
/// [`Formats::gradient_bits`]: crate::precision::Formats::gradient_bits
#[inline(always)]
pub fn coarsen<V: Lanes>(gradient: [V; 3], bits: u32) -> [V; 3] {
    let [x, y, z] = gradient;
    let zero = V::splat(0);
    let cut = (V::splat(32 - bits as i32) - (x.abs() | y.abs() | z.abs()).leading_zeros()).at_least(zero);
    [coarse(x, cut, bits), coarse(y, cut, bits), coarse(z, cut, bits)]
}

#[inline(always)]
fn coarse<V: Lanes>(c: V, cut: V, bits: u32) -> V {
    let half = V::splat(1).shl_each(cut).shr_unsigned(1);
    let kept = (c.abs() + half).shr_each(cut).at_most(V::splat((1 << bits) - 1));
    kept.shl_each(cut).with_sign_of(c)
}

/// Applies [`coarsen`] along rows, in place. All rows equally long.
#[inline(always)]
pub fn coarsen_row<V: Lanes>(g: [&mut [i32]; 3], bits: u32) {
    let [x, y, z] = g;
    for at in places::<V>(x.len()) {
        let [a, b, c] = coarsen([V::load(x, at), V::load(y, at), V::load(z, at)], bits);
        a.store(x, at);
        b.store(y, at);
        c.store(z, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spacing_is_the_nearest_product(g in -(1i32 << 29)..(1 << 29), f in 1u16..=32768) {
            let exact = (i64::from(g) * i64::from(f) + (1 << 14)) >> 15;
            prop_assert_eq!(i64::from(space(g, Intensity::from_bits(f))), exact);
        }
    }

    proptest! {
        #[test]
        fn coarse_gradients_keep_their_bits(g in prop::array::uniform3(-(1i32 << 28)..(1 << 28)), shift in 0u32..28, bits in 1u32..=15) {
            let g = g.map(|c| c >> shift);
            let out = coarsen(g, bits);
            let top = |v: [i32; 3]| 32 - v.iter().fold(0, |m, c| m | c.unsigned_abs()).leading_zeros();
            let cut = top(g).saturating_sub(bits);
            for (c, o) in g.iter().zip(out) {
                // Half a unit of what is kept, or a whole one where the largest component saturates.
                prop_assert_eq!(o & ((1 << cut) - 1), 0);
                let error = f64::from(o - c).abs() / f64::from(1 << cut);
                prop_assert!(error <= 0.5 || error <= 1.0 && o.unsigned_abs() >> cut == (1 << bits) - 1, "{g:?} {out:?}");
            }
            prop_assert_eq!(top(out), top(g));
            prop_assert_eq!(coarsen(g.map(|c| -c), bits), out.map(|c| -c));
            // What normalisation reads of 15 bits is what it reads of the whole gradient.
            if bits == 15 {
                prop_assert_eq!(crate::normalise::block(out), crate::normalise::block(g));
            }
        }
    }

    #[test]
    fn spacing_extremes() {
        for g in [-(8190 << 15), 8190 << 15, 0, 1, -1] {
            assert_eq!(space(g, Intensity::ONE), g);
            assert_eq!(
                space(g, Intensity::from_bits(1)),
                ((i64::from(g) + (1 << 14)) >> 15) as i32
            );
        }
    }
}
