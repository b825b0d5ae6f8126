//! Triquadratic B-spline sampling: a smoother value between voxels, of three slices, rows and columns, and its gradient.
//!
//! Source: Kraus and Bürger, section 4.2, name it as a sampling filter of volumes of colours; the spline of second degree is
//! `(1/2 - u)^2 / 2, 3/4 - u^2, (1/2 + u)^2 / 2` at the nearest voxel and its neighbours, u from -1/2 to 1/2.
//! `docs/contract/quadratic.md`. In slice order all samples of a plane share their weights, as in `interpolate`.
//!
//! | value | format | range |
//! |---|---|---|
//! | voxel v | 12.0, or 15.0 of colours | 0 to 32767 |
//! | weights w-, w+ | 0.16, cut to [`Formats::weight_bits`] | 0 to 32768, at most 32769 together |
//! | slopes' weights p-, p+ | 0.16, the same | 0 to 65536, together 65536 |
//! | after z, after y | 15.16 | as the voxels |
//! | sample | 12 or 15 bits before, 12 or 15 behind | between its 27 voxels |
//! | gradient, of 12 bits | s13.12 or s13.15 | -8190 to 8190, code over two voxels |
//!
//! Each pass is `v0 + (w- (v- - v0) + w+ (v+ - v0)) / 2^16`: z exact, y rounded to `lerp_bits`, x with one rounding to the sample's format.
//! All three weights are positive, so each pass is monotone in every voxel. A component of the gradient has `(p- (v0 - v-) + p+ (v+ - v0)) /
//! 2^15`, twice the spline's slope, in place of the pass along its axis. Overflow: none, each sum lies between its voxels. State: none.

use crate::format::Weight;
use crate::interpolate::{cut, kept};
use crate::lanes::{Lanes, places};
use crate::precision::{Formats, Precision};

/// The weights of the voxels before and behind the nearest one, or of the differences to them, 0.16.
pub type Pair = [i32; 2];

/// Half a voxel, 0.16.
const HALF: u32 = 1 << 15;

/// Whether the nearest voxel is the one behind the position, whose fraction this is; halves are nearer to it.
#[inline]
pub const fn is_behind(fraction: Weight) -> bool {
    fraction.to_bits() >= HALF
}

/// How far a position lies behind half a voxel before the nearest one, 0.16, with the bits that a precision has.
#[inline(always)]
fn along<P: Precision>(p: P, fraction: Weight) -> i32 {
    (cut(p, fraction) + HALF as i32) & 0xffff
}

/// The weights about the nearest voxel of a position with this fraction: with u its distance from that, 0.16, `((2^15 - u)^2 + 2^16)
/// >> 17` and `((2^15 + u)^2 + 2^16) >> 17`, with the bits that a precision has. The rest of 2^16 is the nearest voxel's.
#[inline]
pub fn weights<P: Precision>(p: P, fraction: Weight) -> Pair {
    let behind = along(p, fraction) as u64;
    let weight = |distance: u64| {
        let exact = (distance * distance + (1 << 16)) >> 17;
        cut(p, Weight::from_bits(exact as u32))
    };
    [weight(65536 - behind), weight(behind)]
}

/// The weights of the differences before and behind that voxel, whose sum is twice the slope of the spline: `2^15 - u`, `2^15 + u`.
#[inline]
pub fn slopes<P: Precision>(p: P, fraction: Weight) -> Pair {
    let behind = along(p, fraction);
    [65536 - behind, behind]
}

/// `d- w- + d+ w+ + bias` in two parts, of the upper and of the lower 16 bits: the second is below 2^32.
#[inline(always)]
fn products<V: Lanes>([before, behind]: [V; 2], [a, b]: [V; 2], bias: u32) -> [V; 2] {
    let mask = V::splat(0xffff);
    let low = (before & mask)
        .wrapping_mul(a)
        .wrapping_add((behind & mask).wrapping_mul(b))
        .wrapping_add(V::splat(bias as i32));
    [(before >> 16) * a + (behind >> 16) * b, low]
}

/// `floor((d- w- + d+ w+ + bias) / 2^16)`.
#[inline(always)]
fn scaled<V: Lanes>(differences: [V; 2], w: [V; 2], bias: u32) -> V {
    let [high, low] = products(differences, w, bias);
    high + low.shr_unsigned(16)
}

/// `floor((d- p- + d+ p+ + bias) / 2^15)`.
#[inline(always)]
fn doubled<V: Lanes>(differences: [V; 2], w: [V; 2], bias: u32) -> V {
    let [high, low] = products(differences, w, bias);
    (high << 1) + low.shr_unsigned(15)
}

/// Differences to the nearest value.
#[inline(always)]
fn about<V: Lanes>([before, at, behind]: [V; 3]) -> [V; 2] {
    [before - at, behind - at]
}

/// Differences along the axis.
#[inline(always)]
fn steps<V: Lanes>([before, at, behind]: [V; 3]) -> [V; 2] {
    [at - before, behind - at]
}

#[inline(always)]
fn along_z<V: Lanes>(voxels: [V; 3], [a, b]: [V; 2]) -> V {
    let ([before, behind], [_, at, _]) = (about(voxels), voxels);
    (at << 16) + before * a + behind * b
}

#[inline(always)]
fn slope_z<V: Lanes>(voxels: [V; 3], [a, b]: [V; 2]) -> V {
    let [before, behind] = steps(voxels);
    (before * a + behind * b) << 1
}

/// What is added before a pass along y loses so many bits, if they are all that it loses.
#[inline(always)]
fn bias<P: Precision>(p: P, lost: u32) -> u32 {
    let Formats {
        lerp_bits,
        lerp_rounding,
        ..
    } = p.formats();
    if lerp_bits == 16 { lerp_rounding.bias(lost) } else { 0 }
}

#[inline(always)]
fn along_y<P: Precision, V: Lanes>(p: P, rows: [V; 3], w: [V; 2]) -> V {
    let [_, at, _] = rows;
    kept(p, at + scaled(about(rows), w, bias(p, 16)))
}

#[inline(always)]
fn slope_y<P: Precision, V: Lanes>(p: P, rows: [V; 3], w: [V; 2]) -> V {
    kept(p, doubled(steps(rows), w, bias(p, 15)))
}

/// Rounds a number with 16 fraction bits to a sample.
#[inline(always)]
fn settled<P: Precision, V: Lanes>(p: P, exact: V) -> V {
    let Formats {
        sample_bits,
        lerp_rounding,
        ..
    } = p.formats();
    let cut = 16 - sample_bits;
    (exact + V::splat(lerp_rounding.bias(cut) as i32)) >> cut
}

#[inline(always)]
fn along_x<P: Precision, V: Lanes>(p: P, columns: [V; 3], w: [V; 2]) -> V {
    let [_, at, _] = columns;
    settled(p, at + scaled(about(columns), w, 0))
}

#[inline(always)]
fn slope_x<P: Precision, V: Lanes>(p: P, columns: [V; 3], w: [V; 2]) -> V {
    settled(p, doubled(steps(columns), w, 0))
}

#[inline(always)]
fn splat<V: Lanes>([a, b]: Pair) -> [V; 2] {
    [V::splat(a), V::splat(b)]
}

/// What a pass makes of three slices, rows or columns.
type Pass<'a> = &'a dyn Fn([i32; 3]) -> i32;

/// Three passes, one after the other.
fn passes(voxels: [[[u16; 3]; 3]; 3], [x, y, z]: [Pass<'_>; 3]) -> i32 {
    let [before, at, behind] = voxels.map(|slice| slice.map(|row| row.map(i32::from)));
    let mut rows = [[0; 3]; 3];
    for (out, ((before, at), behind)) in rows.iter_mut().zip(before.into_iter().zip(at).zip(behind)) {
        for (out, ((before, at), behind)) in out.iter_mut().zip(before.into_iter().zip(at).zip(behind)) {
            *out = z([before, at, behind]);
        }
    }
    let [before, at, behind] = rows;
    let mut columns = [0; 3];
    for (out, ((before, at), behind)) in columns.iter_mut().zip(before.into_iter().zip(at).zip(behind)) {
        *out = y([before, at, behind]);
    }
    x(columns)
}

/// The value at a sample: `voxels[z][y][x]` are the nearest voxel and its neighbours, `fractions` those of x, y and z. This function is the
/// definition; the row kernels apply its three parts.
pub fn triquadratic<P: Precision>(p: P, voxels: [[[u16; 3]; 3]; 3], fractions: [Weight; 3]) -> i32 {
    let [x, y, z] = fractions.map(|fraction| weights(p, fraction));
    let made: [Pass<'_>; 3] = [
        &|columns| along_x(p, columns, x),
        &|rows| along_y(p, rows, y),
        &|voxels| along_z(voxels, z),
    ];
    passes(voxels, made)
}

/// The gradient of that value, of voxels of 12 bits, before the spacing factors: its definition.
pub fn gradient<P: Precision>(p: P, voxels: [[[u16; 3]; 3]; 3], fractions: [Weight; 3]) -> [i32; 3] {
    let [x, y, z] = fractions.map(|fraction| weights(p, fraction));
    let [i, j, k] = fractions.map(|fraction| slopes(p, fraction));
    let (along_x, slope_x) = (|v| along_x(p, v, x), |v| slope_x(p, v, i));
    let (along_y, slope_y) = (|v| along_y(p, v, y), |v| slope_y(p, v, j));
    let (along_z, slope_z) = (|v| along_z(v, z), |v| slope_z(v, k));
    [
        passes(voxels, [&slope_x, &along_y, &along_z]),
        passes(voxels, [&along_x, &slope_y, &along_z]),
        passes(voxels, [&along_x, &along_y, &slope_z]),
    ]
}

/// The same elements of three rows, as many as there are of a row to be written.
#[inline(always)]
fn first<T>([before, at, behind]: [&[T]; 3], len: usize) -> Option<[&[T]; 3]> {
    Some([before.get(..len)?, at.get(..len)?, behind.get(..len)?])
}

/// Vectors of three rows of voxels.
#[inline(always)]
fn voxels<V: Lanes>([before, at, behind]: [&[u16]; 3], place: usize) -> [V; 3] {
    [
        V::load_voxels(before, place),
        V::load_voxels(at, place),
        V::load_voxels(behind, place),
    ]
}

/// Vectors of three rows.
#[inline(always)]
fn lanes<V: Lanes>([before, at, behind]: [&[i32]; 3], place: usize) -> [V; 3] {
    [V::load(before, place), V::load(at, place), V::load(behind, place)]
}

/// z interpolation of a row of three slices' voxels. `out`: 15.16, no longer than the rows.
#[inline(always)]
pub fn z_row<V: Lanes>(rows: [&[u16]; 3], weights: Pair, out: &mut [i32]) {
    let Some(rows) = first(rows, out.len()) else { return };
    let w = splat::<V>(weights);
    for place in places::<V>(out.len()) {
        along_z(voxels::<V>(rows, place), w).store(out, place);
    }
}

/// Slopes along z of a row of three slices' voxels of 12 bits. `out`: s13.16, no longer than the rows.
#[inline(always)]
pub fn z_slope_row<V: Lanes>(rows: [&[u16]; 3], slopes: Pair, out: &mut [i32]) {
    let Some(rows) = first(rows, out.len()) else { return };
    let w = splat::<V>(slopes);
    for place in places::<V>(out.len()) {
        slope_z(voxels::<V>(rows, place), w).store(out, place);
    }
}

/// y interpolation of three rows. `out`: 16 fraction bits, no longer than the rows.
#[inline(always)]
pub fn y_row<P: Precision, V: Lanes>(p: P, rows: [&[i32]; 3], weights: Pair, out: &mut [i32]) {
    let Some(rows) = first(rows, out.len()) else { return };
    let w = splat::<V>(weights);
    for place in places::<V>(out.len()) {
        along_y(p, lanes::<V>(rows, place), w).store(out, place);
    }
}

/// Slopes along y of three rows of what is made of voxels of 12 bits. `out`: s13.16, no longer than the rows.
#[inline(always)]
pub fn y_slope_row<P: Precision, V: Lanes>(p: P, rows: [&[i32]; 3], slopes: Pair, out: &mut [i32]) {
    let Some(rows) = first(rows, out.len()) else { return };
    let w = splat::<V>(slopes);
    for place in places::<V>(out.len()) {
        slope_y(p, lanes::<V>(rows, place), w).store(out, place);
    }
}

/// Vectors of an element and its neighbours.
#[inline(always)]
fn columns<V: Lanes>(row: &[i32], place: usize) -> [V; 3] {
    [V::load(row, place), V::load(row, place + 1), V::load(row, place + 2)]
}

/// x interpolation along a row, which has two elements more than `out`: the sample at a place is about the element behind it.
#[inline(always)]
pub fn x_row<P: Precision, V: Lanes>(p: P, row: &[i32], weights: Pair, out: &mut [i32]) {
    let Some(row) = row.get(..out.len() + 2) else { return };
    let w = splat::<V>(weights);
    for place in places::<V>(out.len()) {
        along_x(p, columns::<V>(row, place), w).store(out, place);
    }
}

/// Slopes along such a row of what is made of voxels of 12 bits. `out`: s13.12 or s13.15.
#[inline(always)]
pub fn x_slope_row<P: Precision, V: Lanes>(p: P, row: &[i32], slopes: Pair, out: &mut [i32]) {
    let Some(row) = row.get(..out.len() + 2) else { return };
    let w = splat::<V>(slopes);
    for place in places::<V>(out.len()) {
        slope_x(p, columns::<V>(row, place), w).store(out, place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Compact, Paper, Wide};
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Every fraction: within half a unit of the spline, and never below 0 together; the slopes' weights are the spline's derivative.
    #[test]
    fn weights_are_the_spline() {
        for bits in 0..65536u32 {
            let fraction = Weight::from_bits(bits);
            let u = f64::from(bits) / 65536.0 - f64::from(u8::from(is_behind(fraction)));
            let [before, behind] = weights(Wide, fraction);
            for (found, exact) in [(before, (0.5 - u).powi(2) / 2.0), (behind, (0.5 + u).powi(2) / 2.0)] {
                assert!((f64::from(found) - 65536.0 * exact).abs() <= 0.5, "{bits}");
                assert!((0..=32768).contains(&found));
            }
            assert!(before + behind <= 32769, "{bits}");
            assert_eq!(
                slopes(Wide, fraction).map(f64::from),
                [0.5 - u, 0.5 + u].map(|w| 65536.0 * w)
            );
            // Twelve bits of the position, and of the weights.
            let coarse = Weight::from_bits(bits & !15);
            assert_eq!(weights(Paper, fraction), weights(Wide, coarse).map(|w| w & !15));
            assert_eq!(slopes(Paper, fraction), slopes(Wide, coarse));
        }
        assert_eq!(weights(Compact, Weight::ZERO), [8192, 8192]);
        assert_eq!(weights(Compact, Weight::from_bits(HALF)), [32768, 0]);
    }

    /// A pass of the contract in 128 bits: the weights of three values, of which one loses 15 bits more or less.
    #[derive(Clone, Copy)]
    enum Along {
        Value([i128; 3]),
        Slope([i128; 3]),
    }

    impl Along {
        fn of<P: Precision>(p: P, fraction: Weight, slope: bool) -> Self {
            if slope {
                let [a, b] = slopes(p, fraction).map(i128::from);
                Self::Slope([-a, a - b, b])
            } else {
                let [a, b] = weights(p, fraction).map(i128::from);
                Self::Value([a, 65536 - a - b, b])
            }
        }

        /// The sum, whose unit is 2^-16 of the values'.
        fn sum(self, values: [i128; 3]) -> i128 {
            let ([a, b, c], scale) = match self {
                Self::Value(w) => (w, 1),
                Self::Slope(w) => (w, 2),
            };
            scale * (a * values[0] + b * values[1] + c * values[2])
        }
    }

    /// The formulas of the contract in 128 bits: the value, or its slope along one axis.
    fn exact<P: Precision>(p: P, voxels: [[[u16; 3]; 3]; 3], fractions: [Weight; 3], slope: Option<usize>) -> i32 {
        let Formats {
            lerp_bits,
            lerp_rounding,
            sample_bits,
            ..
        } = p.formats();
        let round = |value: i128, bits: u32| (value + i128::from(lerp_rounding.bias(bits))) >> bits;
        let [x, y, z] = [0, 1, 2].map(|axis: usize| Along::of(p, fractions[axis], slope == Some(axis)));
        let after_z = |j: usize, i: usize| z.sum([0, 1, 2].map(|k: usize| i128::from(voxels[k][j][i])));
        let after_y = |i: usize| {
            let sum = y.sum([0, 1, 2].map(|j| after_z(j, i)));
            round(sum, 32 - lerp_bits) << (16 - lerp_bits)
        };
        round(x.sum([0, 1, 2].map(after_y)), 32 - sample_bits) as i32
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
            prop_assert_eq!(triquadratic(Compact, voxels, fractions), exact(Compact, voxels, fractions, None));
            prop_assert_eq!(triquadratic(Wide, voxels, fractions), exact(Wide, voxels, fractions, None));
            let codes = voxels.map(|slice| slice.map(|row| row.map(|code| code >> 3)));
            prop_assert_eq!(triquadratic(Paper, codes, fractions), exact(Paper, codes, fractions, None));
            for axis in 0..3 {
                let slope = Some(axis);
                prop_assert_eq!(gradient(Paper, codes, fractions)[axis], exact(Paper, codes, fractions, slope));
                prop_assert_eq!(gradient(Compact, codes, fractions)[axis], exact(Compact, codes, fractions, slope));
                prop_assert_eq!(gradient(Wide, codes, fractions)[axis], exact(Wide, codes, fractions, slope));
            }
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

        /// Rows are the scalar; equal voxels are themselves, and have no slope.
        #[test]
        fn rows_are_the_scalar(voxels in prop::collection::vec(voxel(), 9 * 3..9 * 14), fractions in prop::array::uniform3(fraction())) {
            rows(Wide, &voxels, fractions)?;
            rows(Paper, &voxels, fractions)?;
            let same = voxels[0] >> 3;
            prop_assert_eq!(triquadratic(Wide, [[[same; 3]; 3]; 3], fractions), i32::from(same) << 15);
            prop_assert_eq!(gradient(Wide, [[[same; 3]; 3]; 3], fractions), [0; 3]);
        }
    }

    fn rows<P: Precision>(p: P, voxels: &[u16], fractions: [Weight; 3]) -> Result<(), TestCaseError> {
        let (width, voxels) = (
            voxels.len() / 9,
            voxels.iter().map(|code| code >> 3).collect::<Vec<_>>(),
        );
        let row = |z: usize, y: usize| &voxels[(3 * z + y) * width..][..width];
        let [x, y, z] = fractions.map(|fraction| weights(p, fraction));
        let [i, j, k] = fractions.map(|fraction| slopes(p, fraction));
        let (mut after_z, mut sloped) = (
            [(); 3].map(|()| std::vec![0; width]),
            [(); 3].map(|()| std::vec![0; width]),
        );
        for n in 0..3 {
            z_row::<i32>([row(0, n), row(1, n), row(2, n)], z, &mut after_z[n]);
            z_slope_row::<i32>([row(0, n), row(1, n), row(2, n)], k, &mut sloped[n]);
        }
        let [after_z, sloped] = [&after_z, &sloped].map(|rows| [&rows[0][..], &rows[1][..], &rows[2][..]]);
        let (mut after_y, mut out) = (std::vec![0; width], std::vec![0; width - 2]);
        let mut found = Vec::new();
        y_row::<P, i32>(p, after_z, y, &mut after_y);
        x_row::<P, i32>(p, &after_y, x, &mut out);
        found.push(out.clone());
        x_slope_row::<P, i32>(p, &after_y, i, &mut out);
        found.push(out.clone());
        y_slope_row::<P, i32>(p, after_z, j, &mut after_y);
        x_row::<P, i32>(p, &after_y, x, &mut out);
        found.push(out.clone());
        y_row::<P, i32>(p, sloped, y, &mut after_y);
        x_row::<P, i32>(p, &after_y, x, &mut out);
        found.push(out);
        let scalar = |first: usize| {
            let about = [0, 1, 2].map(|k| [0, 1, 2].map(|j| [0, 1, 2].map(|n| row(k, j)[first + n])));
            let [gx, gy, gz] = gradient(p, about, fractions);
            [triquadratic(p, about, fractions), gx, gy, gz]
        };
        let made = |first: usize| [0, 1, 2, 3].map(|row: usize| found[row][first]);
        let (made, scalar): (Vec<_>, Vec<_>) = (0..width - 2).map(|first| (made(first), scalar(first))).unzip();
        prop_assert_eq!(made, scalar);
        Ok(())
    }
}
