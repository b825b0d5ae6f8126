//! Interpolation: the value of the volume at a sample.
//!
//! Source: Squeeze, equation 15; order z, then y, then x. In slice order all samples of a plane share their weights,
//! so a row is three passes of multiply-adds over neighbouring voxels.
//!
//! | value | format | range |
//! |---|---|---|
//! | voxel v | 12.0 | 0 to 4095; -4095 to 8190 one voxel beyond a face |
//! | weight w | 0.16, cut to [`Formats::weight_bits`] | 0 to 65535 |
//! | after z, after y | s15.16 | as the voxels |
//! | sample | 12.12 or 12.15 | between its eight voxels |
//!
//! z: `(v0 << 16) + (v1 - v0) * wz`, exact. y: `((a1 - a0) * wy + 2^15) >> 16` beside a0, rounded to `lerp_bits`. x:
//! `b0 + ((b1 - b0) * wx >> 16)`, rounded to the sample's format. All forms: `docs/contract/interpolation.md`.
//! Error of a sample against the same weights: 0.75 ulp of 12.15, 0.54 of 12.12 (both nearest), below 2 truncated.
//! Overflow: none; |b1 - b0| <= 16380 * 2^16 < 2^30. State: none.

use core::ops::Range;

use crate::format::Weight;
use crate::lanes::{Lanes, places};
use crate::precision::{Formats, Precision};

/// Sixteen-bit weight with the bits that a precision does not have cut off.
#[inline(always)]
pub(crate) fn cut<P: Precision>(p: P, weight: Weight) -> i32 {
    (weight.to_bits() & (u32::MAX << (16 - p.formats().weight_bits))) as i32
}

/// A number with all 16 fraction bits, rounded to those that a precision keeps between its steps.
#[inline(always)]
pub(crate) fn kept<P: Precision, V: Lanes>(p: P, exact: V) -> V {
    let Formats {
        lerp_bits,
        lerp_rounding,
        ..
    } = p.formats();
    let cut = 16 - lerp_bits;
    if cut == 0 {
        exact
    } else {
        ((exact + V::splat(lerp_rounding.bias(cut) as i32)) >> cut) << cut
    }
}

/// `WHOLE`: `a` and `b` are whole numbers, and so their difference times the weight is exact.
#[inline(always)]
pub(crate) fn lerp_y<P: Precision, V: Lanes, const WHOLE: bool>(p: P, a: V, b: V, w: V) -> V {
    let Formats {
        lerp_bits,
        lerp_rounding,
        ..
    } = p.formats();
    let cut = 16 - lerp_bits;
    if WHOLE {
        kept(p, a + ((b - a) >> 16) * w)
    } else if cut == 0 {
        a + (b - a).scale16(w, lerp_rounding.bias(16))
    } else {
        kept(p, a + (b - a).scale16(w, 0))
    }
}

#[inline(always)]
pub(crate) fn lerp_x<P: Precision, V: Lanes>(p: P, a: V, b: V, w: V) -> V {
    let Formats {
        sample_bits,
        lerp_rounding,
        ..
    } = p.formats();
    let cut = 16 - sample_bits;
    (a + (b - a).scale16(w, 0) + V::splat(lerp_rounding.bias(cut) as i32)) >> cut
}

/// z interpolation between two voxels' words, s15.16 of voxels: exact, or to nearest where words have a fraction.
#[inline(always)]
fn between<P: Precision, V: Lanes>(a: V, b: V, w: V) -> V {
    let fraction = P::VOXEL_FRACTION;
    if fraction == 0 {
        return a.between16(b, w);
    }
    // In two parts, because the whole product has 33 bits.
    let (d, low) = (b - a, V::splat((1 << fraction) - 1));
    let rest = ((d & low) * w + V::splat(1 << fraction >> 1)) >> fraction;
    (a << (16 - fraction)) + (d >> fraction) * w + rest
}

/// The value at a sample: `voxels[z][y][x]` are the corners of its cell (each -4095 to 8190), `weights` those of x, y
/// and z. This function is the definition; the row kernels apply its three parts.
pub fn trilinear<P: Precision>(p: P, voxels: [[[i16; 2]; 2]; 2], weights: [Weight; 3]) -> i32 {
    trilinear_words(p, voxels.map(|slice| slice.map(|row| row.map(i32::from))), weights)
}

/// [`trilinear`] of words with [`Precision::VOXEL_FRACTION`], as many times larger.
pub fn trilinear_words<P: Precision>(p: P, voxels: [[[i32; 2]; 2]; 2], weights: [Weight; 3]) -> i32 {
    let [wx, wy, wz] = weights.map(|weight| cut(p, weight));
    let [[[n00, n01], [n10, n11]], [[f00, f01], [f10, f11]]] = voxels;
    let z = |near: i32, far: i32| between::<P, i32>(near, far, wz);
    let left = lerp_y::<P, i32, false>(p, z(n00, f00), z(n10, f10), wy);
    let right = lerp_y::<P, i32, false>(p, z(n01, f01), z(n11, f11), wy);
    lerp_x(p, left, right, wx)
}

/// z interpolation of a row of voxels. `out`: s15.16, as long as the rows.
#[inline(always)]
pub fn z_row<P: Precision, V: Lanes>(p: P, near: &[u16], far: &[u16], weight: Weight, out: &mut [i32]) {
    let len = out.len();
    let (Some(near), Some(far)) = (near.get(..len), far.get(..len)) else {
        return;
    };
    if weight == Weight::ZERO {
        // A plane that lies in a slice: all of them at one plane per voxel.
        for at in places::<V>(len) {
            (V::load_voxels(near, at) << (16 - P::VOXEL_FRACTION)).store(out, at);
        }
        return;
    }
    let w = V::splat(cut(p, weight));
    for at in places::<V>(len) {
        between::<P, V>(V::load_voxels(near, at), V::load_voxels(far, at), w).store(out, at);
    }
}

/// Turns a row that holds the first (or last) voxel row of the volume into the row one voxel beyond it, continued
/// linearly: `2 * edge - inner`. Exact, because the z interpolation is.
#[inline]
pub(crate) fn extend_row(edge: &mut [i32], inner: &[i32]) {
    for (e, &i) in edge.iter_mut().zip(inner) {
        *e = 2 * *e - i;
    }
}

/// Fills the two places of a row (one before its first voxel, one after its last) with the volume continued
/// linearly by one voxel. A row of one voxel is continued with itself.
#[inline]
pub(crate) fn extend_ends(row: &mut [i32]) {
    let beyond = |edge: i32, inner: i32| 2 * edge - inner;
    match row {
        [before, a, b, .., y, z, after] => {
            *before = beyond(*a, *b);
            *after = beyond(*z, *y);
        }
        [before, a, b, c, after] => {
            *before = beyond(*a, *b);
            *after = beyond(*c, *b);
        }
        [before, a, b, after] => {
            *before = beyond(*a, *b);
            *after = beyond(*b, *a);
        }
        [before, a, after] => {
            *before = *a;
            *after = *a;
        }
        _ => {}
    }
}

/// The difference of two voxel rows, `scale * (minuend - subtrahend)`: the derivative along z at a slice, over two
/// voxels. At a face of the volume `scale` is 2 (one-sided, doubled), for a volume one slice thick it is 0.
#[derive(Clone, Copy, Debug)]
pub struct Difference<'a> {
    /// 0, 1 or 2.
    pub scale: i32,
    /// Voxels behind.
    pub minuend: &'a [u16],
    /// Voxels before.
    pub subtrahend: &'a [u16],
}

impl Difference<'_> {
    /// The first columns, if there are as many.
    #[inline(always)]
    fn first(self, len: usize) -> Option<Self> {
        Some(Self {
            scale: self.scale,
            minuend: self.minuend.get(..len)?,
            subtrahend: self.subtrahend.get(..len)?,
        })
    }

    /// Columns `at ..`, of which there are as many as lanes.
    #[inline(always)]
    pub(crate) fn inner<V: Lanes>(&self, at: usize) -> V {
        self.scaled(V::load_inner_voxels(self.minuend, at) - V::load_inner_voxels(self.subtrahend, at))
    }

    /// Columns `at ..`.
    #[inline(always)]
    pub(crate) fn outer<V: Lanes>(&self, at: usize) -> V {
        self.scaled(self.lanes(at))
    }

    #[inline(always)]
    fn scaled<V: Lanes>(&self, lanes: V) -> V {
        // At a face of the volume; everywhere else the scale is 1.
        if self.scale == 1 {
            lanes
        } else {
            lanes * V::splat(self.scale)
        }
    }

    /// Columns `at ..`, before scaling.
    #[inline(always)]
    fn lanes<V: Lanes>(&self, at: usize) -> V {
        V::load_voxels(self.minuend, at) - V::load_voxels(self.subtrahend, at)
    }

    /// Some of its columns.
    #[inline]
    pub fn columns(self, columns: Range<usize>) -> Self {
        Self {
            scale: self.scale,
            minuend: self.minuend.get(columns.clone()).unwrap_or(&[]),
            subtrahend: self.subtrahend.get(columns).unwrap_or(&[]),
        }
    }
}

/// z interpolation of a row of derivatives along z. `out`: s15.16, as long as the rows.
#[inline(always)]
pub fn z_difference_row<P: Precision, V: Lanes>(
    p: P,
    near: Difference<'_>,
    far: Difference<'_>,
    weight: Weight,
    out: &mut [i32],
) {
    let len = out.len();
    let (Some(near), Some(far)) = (near.first(len), far.first(len)) else {
        return;
    };
    if weight == Weight::ZERO {
        let scale = V::splat(near.scale << (16 - P::VOXEL_FRACTION));
        for at in places::<V>(len) {
            (near.lanes::<V>(at) * scale).store(out, at);
        }
        return;
    }
    let w = V::splat(cut(p, weight));
    let scales = [near.scale, far.scale];
    for at in places::<V>(len) {
        let (mut a, mut b) = (near.lanes::<V>(at), far.lanes::<V>(at));
        // At a face of the volume; everywhere else the scales are 1.
        if scales != [1, 1] {
            a = a * V::splat(near.scale);
            b = b * V::splat(far.scale);
        }
        between::<P, V>(a, b, w).store(out, at);
    }
}

/// y interpolation between two rows, and x interpolation along the result. `a` and `b`: s15.16, as long as `out` or
/// longer; `whole` says that they hold whole numbers (the plane lies in a slice), of which fewer products are made.
/// `out`: samples. Behind the last element there are zeros: they are read with a weight of 0 only (a sample behind the
/// last voxel lies outside the volume).
#[inline(always)]
pub fn yx_row<P: Precision, V: Lanes>(p: P, a: &[i32], b: &[i32], whole: bool, weights: [Weight; 2], out: &mut [i32]) {
    // On small machines both take as many instructions; words with a fraction are no whole numbers.
    if whole && !V::SMALL && P::VOXEL_FRACTION == 0 {
        yx_row_of::<P, V, _, true>(p, TwoRows(a, b), weights, out);
    } else {
        yx_row_of::<P, V, _, false>(p, TwoRows(a, b), weights, out);
    }
}

/// [`yx_row`] of the voxels themselves: for a plane that lies in a slice, where there is nothing to interpolate along z.
#[inline(always)]
pub fn yx_row_in_slice<P: Precision, V: Lanes>(p: P, a: &[u16], b: &[u16], weights: [Weight; 2], out: &mut [i32]) {
    yx_row_of::<P, V, _, true>(p, TwoRows(a, b), weights, out);
}

/// Two rows, between which y interpolation takes place; `WHOLE`: of whole numbers.
#[derive(Clone, Copy)]
struct TwoRows<'a, T, const WHOLE: bool>(&'a [T], &'a [T]);

impl<T, const WHOLE: bool> TwoRows<'_, T, WHOLE> {
    /// How many elements both have.
    #[inline(always)]
    fn len(&self) -> usize {
        self.0.len().min(self.1.len())
    }

    /// The first elements of both, if there are as many.
    #[inline(always)]
    fn first(&self, len: usize) -> Option<Self> {
        Some(Self(self.0.get(..len)?, self.1.get(..len)?))
    }

    /// Those of both by whole vectors, whose lengths the compiler knows: nothing is compared at each load.
    #[inline(always)]
    fn vectors<V: Lanes>(&self) -> impl Iterator<Item = Self> {
        let (one, other) = (self.0.chunks_exact(V::COUNT), self.1.chunks_exact(V::COUNT));
        one.zip(other).map(|(one, other)| Self(one, other))
    }

    /// Their elements from the second vector on.
    #[inline(always)]
    fn behind<V: Lanes>(&self) -> Self {
        Self(
            self.0.get(V::COUNT..).unwrap_or(&[]),
            self.1.get(V::COUNT..).unwrap_or(&[]),
        )
    }
}

/// Interpolation along y.
trait AlongY {
    /// Between the elements `at ..` of two rows, s15.16.
    fn between<P: Precision, V: Lanes>(&self, p: P, at: usize, w: V) -> V;
}

/// Of what z interpolation has made.
impl<const WHOLE: bool> AlongY for TwoRows<'_, i32, WHOLE> {
    #[inline(always)]
    fn between<P: Precision, V: Lanes>(&self, p: P, at: usize, w: V) -> V {
        lerp_y::<P, V, WHOLE>(p, V::load(self.0, at), V::load(self.1, at), w)
    }
}

/// Of voxels: what [`lerp_y`] makes of whole numbers.
impl AlongY for TwoRows<'_, u16, true> {
    #[inline(always)]
    fn between<P: Precision, V: Lanes>(&self, p: P, at: usize, w: V) -> V {
        kept(p, V::load_voxels(self.0, at).between16(V::load_voxels(self.1, at), w))
    }
}

#[inline(always)]
fn yx_row_of<P: Precision, V: Lanes, T, const WHOLE: bool>(
    p: P,
    rows: TwoRows<'_, T, WHOLE>,
    [wx, wy]: [Weight; 2],
    out: &mut [i32],
) where
    for<'a> TwoRows<'a, T, WHOLE>: AlongY,
{
    let (wx, wy) = (V::splat(cut(p, wx)), V::splat(cut(p, wy)));
    let mut here = rows.between::<P, V>(p, 0, wy);
    let behind = rows.behind::<V>();
    if const { V::COUNT == 1 } {
        // A single lane stops before an element that has no right neighbour.
        let len = out.len().min(behind.len());
        let (Some(behind), Some((inner, last))) = (behind.first(len), out.split_at_mut_checked(len)) else {
            return;
        };
        for at in places::<V>(len) {
            let next = behind.between::<P, V>(p, at, wy);
            lerp_x(p, here, here.followed_by(next), wx).store(inner, at);
            here = next;
        }
        lerp_x(p, here, V::splat(0), wx).store(last, 0);
        return;
    }
    let mut at = 0;
    for (next, out) in behind.vectors::<V>().zip(out.chunks_exact_mut(V::COUNT)) {
        let next = next.between::<P, V>(p, 0, wy);
        lerp_x(p, here, here.followed_by(next), wx).store(out, 0);
        here = next;
        at += V::COUNT;
    }
    while at < out.len() {
        let next = behind.between::<P, V>(p, at, wy);
        lerp_x(p, here, here.followed_by(next), wx).store(out, at);
        here = next;
        at += V::COUNT;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Compact, Paper, Wide};
    use proptest::prelude::*;
    use std::vec;

    fn exact(v: [[[i16; 2]; 2]; 2], [wx, wy, wz]: [u32; 3]) -> f64 {
        let mut sum = 0.0;
        for (z, y, x) in (0..8).map(|i| (i >> 2, i >> 1 & 1, i & 1)) {
            let weight = |side: usize, w: u32| {
                let f = f64::from(w) / 65536.0;
                if side == 1 { f } else { 1.0 - f }
            };
            sum += f64::from(v[z][y][x]) * weight(x, wx) * weight(y, wy) * weight(z, wz);
        }
        sum
    }

    fn corners() -> impl Strategy<Value = [[[i16; 2]; 2]; 2]> {
        prop_oneof![
            any::<[[[u16; 2]; 2]; 2]>().prop_map(|v| v.map(|s| s.map(|r| r.map(|c| (c & 4095) as i16)))),
            any::<[[[bool; 2]; 2]; 2]>().prop_map(|v| v.map(|s| s.map(|r| r.map(|c| if c { 4095 } else { 0 })))),
        ]
    }

    proptest! {
        #[test]
        fn samples_are_within_their_bound(v in corners(), w in any::<[u16; 3]>()) {
            let w = w.map(u32::from);
            let weights = w.map(Weight::from_bits);
            let e = exact(v, w);
            let wide = f64::from(trilinear(Wide, v, weights)) - e * 32768.0;
            prop_assert!(wide.abs() <= 0.75 + 1e-6, "wide {wide}");
            let compact = f64::from(trilinear(Compact, v, weights)) - e * 4096.0;
            prop_assert!(compact.abs() <= 0.5 + 1.0 / 32.0 + 1e-6, "compact {compact}");
            let cut = w.map(|w| w & !15);
            let paper = f64::from(trilinear(Paper, v, weights)) - exact(v, cut) * 4096.0;
            prop_assert!(paper > -2.0 && paper <= 1e-6, "paper {paper}");
            let (low, high) = v.iter().flatten().flatten().fold((4095, 0), |(l, h), &c| (c.min(l), c.max(h)));
            let bits = trilinear(Wide, v, weights);
            prop_assert!((i32::from(low) << 15..=i32::from(high) << 15).contains(&bits));
        }

        #[test]
        fn rows_are_the_scalar(length in 1usize..=33, seed in any::<u64>(), w in any::<[u16; 3]>(), in_slice in any::<bool>()) {
            let [x, y, z] = w;
            let w = [x, y, if in_slice { 0 } else { z }];
            rows(Paper, length, seed, w.map(|w| Weight::from_bits(u32::from(w))))?;
            rows(Compact, length, seed, w.map(|w| Weight::from_bits(u32::from(w))))?;
            rows(Wide, length, seed, w.map(|w| Weight::from_bits(u32::from(w))))?;
        }
    }

    fn rows<P: Precision>(p: P, length: usize, seed: u64, weights: [Weight; 3]) -> Result<(), TestCaseError> {
        let mut state = seed | 1;
        let mut voxel = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 52) as u16
        };
        let mut row = || (0..length).map(|_| voxel()).collect::<std::vec::Vec<u16>>();
        let [n0, n1, f0, f1] = [row(), row(), row(), row()];
        let [wx, wy, wz] = weights;
        let (mut z0, mut z1, mut s) = (vec![0; length], vec![0; length], vec![0; length]);
        z_row::<P, i32>(p, &n0, &f0, wz, &mut z0);
        z_row::<P, i32>(p, &n1, &f1, wz, &mut z1);
        yx_row::<P, i32>(p, &z0, &z1, wz == Weight::ZERO, [wx, wy], &mut s);
        if wz == Weight::ZERO {
            let mut of_voxels = vec![0; length];
            yx_row_in_slice::<P, i32>(p, &n0, &n1, [wx, wy], &mut of_voxels);
            prop_assert_eq!(&s, &of_voxels);
        }
        for i in 0..length {
            let pair = |r: &[u16]| [r[i] as i16, r.get(i + 1).copied().unwrap_or(0) as i16];
            let v = [[pair(&n0), pair(&n1)], [pair(&f0), pair(&f1)]];
            prop_assert_eq!(s[i], trilinear(p, v, weights));
        }
        Ok(())
    }

    #[test]
    fn derivative_extremes_do_not_overflow() {
        // W swings over its whole range between neighbouring voxels, with the heaviest weights.
        let (low, high) = ([0u16; 2], [4095u16; 2]);
        let up = Difference {
            scale: 2,
            minuend: &high,
            subtrahend: &low,
        };
        let down = Difference {
            scale: 2,
            minuend: &low,
            subtrahend: &high,
        };
        for bits in [0, 1, 32768, 65535] {
            let w = Weight::from_bits(bits);
            let (mut a, mut b, mut s) = ([0; 2], [0; 2], [0; 2]);
            z_difference_row::<_, i32>(Wide, up, down, w, &mut a);
            z_difference_row::<_, i32>(Wide, down, up, w, &mut b);
            yx_row::<_, i32>(Wide, &[a[0], -a[1]], &[b[0], -b[1]], bits == 0, [w, w], &mut s);
            let f = f64::from(bits) / 65536.0;
            let exact = 8190.0 * (1.0 - 2.0 * f) * (1.0 - 2.0 * f) * (1.0 - 2.0 * f);
            assert!((f64::from(s[0]) / 32768.0 - exact).abs() < 1e-4, "{bits}");
        }
    }

    #[test]
    fn ends_continue_linearly() {
        let extended = |inner: &[i32]| {
            let mut row = vec![0];
            row.extend_from_slice(inner);
            row.push(0);
            extend_ends(&mut row);
            (row[0], row[row.len() - 1])
        };
        assert_eq!(extended(&[5]), (5, 5));
        assert_eq!(extended(&[5, 7]), (3, 9));
        assert_eq!(extended(&[5, 7, 1]), (3, -5));
        assert_eq!(extended(&[5, 7, 1, 2]), (3, 3));
        assert_eq!(extended(&[5, 7, 1, 2, 8]), (3, 14));
    }
}
