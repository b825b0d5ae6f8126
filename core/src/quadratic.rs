//! Triquadratic B-spline sampling: a smoother value between voxels, of three slices, rows and columns.
//!
//! Source: Kraus and Bürger, section 4.2, name it as a sampling filter of volumes of colours; the spline of second degree is
//! `(1/2 - u)^2 / 2, 3/4 - u^2, (1/2 + u)^2 / 2` at the nearest voxel and its neighbours, u from -1/2 to 1/2.
//! `docs/contract/quadratic.md`. In slice order all samples of a plane share their weights, as in `interpolate`.
//!
//! | value | format | range |
//! |---|---|---|
//! | voxel v | 15.0 | 0 to 32767 |
//! | weights w-, w+ | 0.16 | 0 to 32768, at most 32769 together |
//! | after z, after y | 15.16 | as the voxels |
//! | sample | 15.12 or 15.15 | between its 27 voxels |
//!
//! Each pass is `v0 + (w- (v- - v0) + w+ (v+ - v0)) / 2^16`: z exact, y to nearest, x with one rounding to the sample's format. All
//! three weights are positive, so each pass is monotone in every voxel. Overflow: none, each sum lies between its voxels. State: none.

use crate::format::Weight;
use crate::lanes::{Lanes, places};
use crate::precision::{Formats, Precision};

/// The weights of the voxels before and behind the nearest one, 0.16.
pub type Pair = [i32; 2];

/// Half a voxel, 0.16.
const HALF: u32 = 1 << 15;

/// Whether the nearest voxel is the one behind the position, whose fraction this is; halves are nearer to it.
#[inline]
pub const fn is_behind(fraction: Weight) -> bool {
    fraction.to_bits() >= HALF
}

/// The weights about the nearest voxel of a position with this fraction: with u its distance from that, 0.16, `((2^15 - u)^2 + 2^16)
/// >> 17` and `((2^15 + u)^2 + 2^16) >> 17`. The rest of 2^16 is the nearest voxel's.
#[inline]
pub const fn weights(fraction: Weight) -> Pair {
    // From half a voxel before the nearest one.
    let along = (fraction.to_bits() + HALF) & 0xffff;
    let (before, behind) = (65536 - along as u64, along as u64);
    [
        ((before * before + (1 << 16)) >> 17) as i32,
        ((behind * behind + (1 << 16)) >> 17) as i32,
    ]
}

/// `floor((d- w- + d+ w+ + bias) / 2^16)`: in 16-bit halves, whose low products add up to less than 2^32.
#[inline(always)]
fn scaled<V: Lanes>([before, behind]: [V; 2], [a, b]: [V; 2], bias: u32) -> V {
    let mask = V::splat(0xffff);
    let low = (before & mask)
        .wrapping_mul(a)
        .wrapping_add((behind & mask).wrapping_mul(b))
        .wrapping_add(V::splat(bias as i32));
    (before >> 16) * a + (behind >> 16) * b + low.shr_unsigned(16)
}

#[inline(always)]
fn along_z<V: Lanes>([before, at, behind]: [V; 3], [a, b]: [V; 2]) -> V {
    (at << 16) + (before - at) * a + (behind - at) * b
}

#[inline(always)]
fn along_y<V: Lanes>([before, at, behind]: [V; 3], w: [V; 2]) -> V {
    at + scaled([before - at, behind - at], w, HALF)
}

#[inline(always)]
fn along_x<P: Precision, V: Lanes>(p: P, [before, at, behind]: [V; 3], w: [V; 2]) -> V {
    let Formats { sample_bits, .. } = p.formats();
    let cut = 16 - sample_bits;
    (at + scaled([before - at, behind - at], w, 0) + V::splat(1 << cut >> 1)) >> cut
}

#[inline(always)]
fn splat<V: Lanes>([a, b]: Pair) -> [V; 2] {
    [V::splat(a), V::splat(b)]
}

/// The value at a sample: `voxels[z][y][x]` are the nearest voxel and its neighbours, `fractions` those of x, y and z. This function is the
/// definition; the row kernels apply its three parts.
pub fn triquadratic<P: Precision>(p: P, voxels: [[[u16; 3]; 3]; 3], fractions: [Weight; 3]) -> i32 {
    let [x, y, z] = fractions.map(weights);
    let [before, at, behind] = voxels.map(|slice| slice.map(|row| row.map(i32::from)));
    let mut rows = [[0; 3]; 3];
    for (out, ((before, at), behind)) in rows.iter_mut().zip(before.into_iter().zip(at).zip(behind)) {
        for (out, ((before, at), behind)) in out.iter_mut().zip(before.into_iter().zip(at).zip(behind)) {
            *out = along_z([before, at, behind], z);
        }
    }
    let [before, at, behind] = rows;
    let mut columns = [0; 3];
    for (out, ((before, at), behind)) in columns.iter_mut().zip(before.into_iter().zip(at).zip(behind)) {
        *out = along_y([before, at, behind], y);
    }
    along_x(p, columns, x)
}

/// z interpolation of a row of three slices' voxels. `out`: 15.16, no longer than the rows.
#[inline(always)]
pub fn z_row<V: Lanes>([before, at, behind]: [&[u16]; 3], weights: Pair, out: &mut [i32]) {
    let len = out.len();
    let (Some(before), Some(at), Some(behind)) = (before.get(..len), at.get(..len), behind.get(..len)) else {
        return;
    };
    let w = splat::<V>(weights);
    for place in places::<V>(len) {
        let voxels = [
            V::load_voxels(before, place),
            V::load_voxels(at, place),
            V::load_voxels(behind, place),
        ];
        along_z(voxels, w).store(out, place);
    }
}

/// y interpolation of three rows. `out`: 15.16, no longer than the rows.
#[inline(always)]
pub fn y_row<V: Lanes>([before, at, behind]: [&[i32]; 3], weights: Pair, out: &mut [i32]) {
    let len = out.len();
    let (Some(before), Some(at), Some(behind)) = (before.get(..len), at.get(..len), behind.get(..len)) else {
        return;
    };
    let w = splat::<V>(weights);
    for place in places::<V>(len) {
        let rows = [V::load(before, place), V::load(at, place), V::load(behind, place)];
        along_y(rows, w).store(out, place);
    }
}

/// x interpolation along a row, which has two elements more than `out`: the sample at a place is about the element behind it.
#[inline(always)]
pub fn x_row<P: Precision, V: Lanes>(p: P, row: &[i32], weights: Pair, out: &mut [i32]) {
    let len = out.len();
    let Some(row) = row.get(..len + 2) else { return };
    let w = splat::<V>(weights);
    for place in places::<V>(len) {
        let columns = [V::load(row, place), V::load(row, place + 1), V::load(row, place + 2)];
        along_x(p, columns, w).store(out, place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Compact, Wide};
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Every fraction: within half a unit of the spline, and never below 0 together.
    #[test]
    fn weights_are_the_spline() {
        for bits in 0..65536u32 {
            let fraction = Weight::from_bits(bits);
            let u = f64::from(bits) / 65536.0 - f64::from(u8::from(is_behind(fraction)));
            let [before, behind] = weights(fraction);
            for (found, exact) in [(before, (0.5 - u).powi(2) / 2.0), (behind, (0.5 + u).powi(2) / 2.0)] {
                assert!((f64::from(found) - 65536.0 * exact).abs() <= 0.5, "{bits}");
                assert!((0..=32768).contains(&found));
            }
            assert!(before + behind <= 32769, "{bits}");
        }
        assert_eq!(weights(Weight::ZERO), [8192, 8192]);
        assert_eq!(weights(Weight::from_bits(HALF)), [32768, 0]);
    }

    /// The formula of the contract in 128 bits.
    fn exact(voxels: [[[u16; 3]; 3]; 3], fractions: [Weight; 3], sample_bits: u32) -> i128 {
        let [x, y, z] = fractions.map(|fraction| {
            let [a, b] = weights(fraction).map(i128::from);
            [a, 65536 - a - b, b]
        });
        let sum = |w: [i128; 3], values: [i128; 3]| (0..3).map(|i| w[i] * values[i]).sum::<i128>();
        let after_z = |j: usize, i: usize| sum(z, [0, 1, 2].map(|k: usize| i128::from(voxels[k][j][i])));
        let after_y = |i: usize| (sum(y, [0, 1, 2].map(|j| after_z(j, i))) + (1 << 15)) >> 16;
        let cut = 32 - sample_bits;
        (sum(x, [0, 1, 2].map(after_y)) + (1 << (cut - 1))) >> cut
    }

    fn voxel() -> impl Strategy<Value = u16> {
        prop_oneof![2 => Just(0u16), 2 => Just(32767), 3 => 0u16..=32767]
    }

    fn fraction() -> impl Strategy<Value = Weight> {
        prop_oneof![Just(0u32), Just(32767), Just(32768), Just(65535), 0u32..65536].prop_map(Weight::from_bits)
    }

    fn cube() -> impl Strategy<Value = [[[u16; 3]; 3]; 3]> {
        prop::array::uniform3(prop::array::uniform3(prop::array::uniform3(voxel())))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn samples_are_the_formula(voxels in cube(), fractions in prop::array::uniform3(fraction())) {
            prop_assert_eq!(i128::from(triquadratic(Compact, voxels, fractions)), exact(voxels, fractions, 12));
            prop_assert_eq!(i128::from(triquadratic(Wide, voxels, fractions)), exact(voxels, fractions, 15));
        }

        /// No colour exceeds its extinction, because no voxel's does.
        #[test]
        fn samples_keep_the_order_of_voxels(
            high in cube(), cut in cube(), fractions in prop::array::uniform3(fraction()),
        ) {
            let at = |z: usize, y: usize, x: usize| high[z][y][x].min(cut[z][y][x]);
            let low = [0, 1, 2].map(|z| [0, 1, 2].map(|y| [0, 1, 2].map(|x| at(z, y, x))));
            prop_assert!(triquadratic(Compact, low, fractions) <= triquadratic(Compact, high, fractions));
            prop_assert!(triquadratic(Wide, low, fractions) <= triquadratic(Wide, high, fractions));
        }

        /// Rows are the scalar; equal voxels are themselves.
        #[test]
        fn rows_are_the_scalar(voxels in prop::collection::vec(voxel(), 9 * 3..9 * 14), fractions in prop::array::uniform3(fraction())) {
            let width = voxels.len() / 9;
            let row = |z: usize, y: usize| &voxels[(3 * z + y) * width..][..width];
            let [x, y, z] = fractions.map(weights);
            let mut after_z = [(); 3].map(|()| std::vec![0; width]);
            for (j, out) in after_z.iter_mut().enumerate() {
                z_row::<i32>([row(0, j), row(1, j), row(2, j)], z, out);
            }
            let mut after_y = std::vec![0; width];
            y_row::<i32>([&after_z[0], &after_z[1], &after_z[2]], y, &mut after_y);
            let mut samples = std::vec![0; width - 2];
            x_row::<Wide, i32>(Wide, &after_y, x, &mut samples);
            let scalar: Vec<i32> = (0..width - 2).map(|i| {
                let about = [0, 1, 2].map(|k| [0, 1, 2].map(|j| [0, 1, 2].map(|n| row(k, j)[i + n])));
                triquadratic(Wide, about, fractions)
            }).collect();
            prop_assert_eq!(samples, scalar);
            let same = voxels[0];
            prop_assert_eq!(triquadratic(Wide, [[[same; 3]; 3]; 3], fractions), i32::from(same) << 15);
        }
    }
}
