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
use crate::lanes::Lanes;

/// Difference of two rows of samples: `next - previous`. All rows equally long.
#[inline(always)]
pub fn difference_row<V: Lanes>(next: &[i32], previous: &[i32], out: &mut [i32]) {
    for at in (0..out.len()).step_by(V::COUNT) {
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
        for at in (0..row.len()).step_by(V::COUNT) {
            space(V::load(row, at), factor).store(row, at);
        }
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
