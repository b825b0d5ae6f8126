//! One level of a pyramid from the one below it: extinctions, and colours times extinction, filtered in integers.
//!
//! Source: Kraus and Bürger, section 4.1. Along x, y and z the weights of [`Filter`] are summed without rounding; g is log2 of
//! the sum of all weights, at most 12, so that sums S have 27 bits. The one division carries its remainder along the row:
//!
//! `a = S + r; v = a >> g; r = a mod 2^g` for the extinction; `v_k = min((S_k + r_k) >> g, v); r_k = S_k + r_k - (v_k << g)` for
//! the colours; r begins every row with 2^(g-1), nothing where g is 0.
//!
//! - Sums are kept: over a row, the sum of v · 2^g differs from that of S by r's beginning less its end, -(2^(g-1) - 1) to 2^(g-1).
//! - Constants stay: S = c 2^g gives c and leaves r alone.
//! - v_k <= v by construction, and v_k = v where S_k = S: white stays white.
//! - r_k >= 0, and r_k <= 2 (2^g - 1): while v_k is not held to v it is below 2^g; where it is, it grows by no more than r does,
//!   since S_k <= S. So nothing passes 2^28.

use std::collections::BTreeMap;
use std::ops::AddAssign;

use crate::filter::{Axis, Filter};
use crate::voxel::Codes;

/// A number of four channels that weights can be put on.
pub trait Channels: Copy + Default + AddAssign {
    /// A voxel, once for every `weight`.
    #[must_use]
    fn times(self, weight: u32) -> Self;
}

/// Sums of codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sums(pub [u32; 4]);

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += more);
    }
}

impl Channels for Sums {
    fn times(self, weight: u32) -> Self {
        Self(self.0.map(|sum| weight * sum))
    }
}

/// The axes of a volume under a filter.
pub fn axes(filter: Filter, dims: [usize; 3]) -> [Axis; 3] {
    dims.map(|len| filter.axis(len))
}

/// Sums the voxels behind every coarse voxel, row by row: `slice` writes a slice of the fine volume, `row` takes each row.
pub fn sum_rows<T: Channels>(
    filter: Filter,
    dims: [usize; 3],
    slice: &dyn Fn(usize, &mut Vec<T>),
    row: &mut dyn FnMut(&[T]),
) {
    let [x, y, z] = axes(filter, dims);
    let taps = |axis: &Axis| -> Vec<Vec<(usize, u32)>> { (0..axis.coarse).map(|at| axis.taps(at).collect()).collect() };
    let [along_x, along_y, along_z] = [&x, &y, &z].map(taps);
    let mut fine = Vec::new();
    let mut narrow = Vec::new();
    // Slices that are summed along x and y and still needed.
    let mut kept: BTreeMap<usize, Vec<T>> = BTreeMap::new();
    let mut sums = vec![T::default(); x.coarse];
    for taps in &along_z {
        kept.retain(|index, _| taps.iter().any(|(needed, _)| needed == index));
        for &(index, _) in taps {
            kept.entry(index).or_insert_with(|| {
                fine.clear();
                slice(index, &mut fine);
                narrow.clear();
                for row in fine.chunks_exact(dims[0]) {
                    narrow.extend(along_x.iter().map(|taps| {
                        let mut sum = T::default();
                        taps.iter().for_each(|&(at, weight)| sum += row[at].times(weight));
                        sum
                    }));
                }
                let mut small = Vec::with_capacity(x.coarse * y.coarse);
                for taps in &along_y {
                    add_rows(
                        &mut sums,
                        taps.iter().map(|&(at, weight)| (&narrow[at * x.coarse..], weight)),
                    );
                    small.extend_from_slice(&sums);
                }
                small
            });
        }
        for at in 0..y.coarse {
            let rows = taps
                .iter()
                .filter_map(|(index, weight)| Some((kept.get(index)?, *weight)));
            add_rows(&mut sums, rows.map(|(plane, weight)| (&plane[at * x.coarse..], weight)));
            row(&sums);
        }
    }
}

/// The sum of weighted rows, each as long as `sums`.
fn add_rows<'a, T: Channels + 'a>(sums: &mut [T], rows: impl Iterator<Item = (&'a [T], u32)>) {
    sums.fill(T::default());
    for (row, weight) in rows {
        sums.iter_mut()
            .zip(row)
            .for_each(|(sum, voxel)| *sum += voxel.times(weight));
    }
}

/// log2 of the sum of all weights.
pub fn gain(filter: Filter, dims: [usize; 3]) -> u32 {
    axes(filter, dims).iter().map(Axis::bits).sum()
}

/// The codes of the coarse volume. `codes` writes those of a slice of the fine one.
pub fn reduce(filter: Filter, dims: [usize; 3], codes: &dyn Fn(usize, &mut Vec<Sums>)) -> Vec<Codes> {
    let bits = gain(filter, dims);
    let mut coarse = Vec::with_capacity(axes(filter, dims).iter().map(|axis| axis.coarse).product());
    sum_rows(filter, dims, codes, &mut |sums| divide_row(bits, sums, &mut coarse));
    coarse
}

/// Divides a row of sums by 2^bits, and carries what is left over from voxel to voxel.
fn divide_row(bits: u32, sums: &[Sums], coarse: &mut Vec<Codes>) {
    let mut rests = [(1 << bits) >> 1; 4];
    coarse.extend(sums.iter().map(|sums| {
        let held = [0, 1, 2, 3].map(|k| sums.0[k] + rests[k]);
        let tau = held[3] >> bits;
        let codes = held.map(|held| (held >> bits).min(tau));
        rests = [0, 1, 2, 3].map(|k| held[k] - (codes[k] << bits));
        // At most 15 bits: the extinction's mean, rounded up at most.
        codes.map(|code| code as u16)
    }));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::voxel::MAX_CODE;

    fn reduced(filter: Filter, dims: [usize; 3], fine: &[Codes]) -> Vec<Codes> {
        let area = dims[0] * dims[1];
        reduce(filter, dims, &|z, out| {
            out.extend(
                fine[z * area..(z + 1) * area]
                    .iter()
                    .map(|codes| Sums(codes.map(u32::from))),
            );
        })
    }

    /// Sums by their definition: every coarse voxel by itself.
    fn sums(filter: Filter, dims: [usize; 3], fine: &[Codes]) -> Vec<[i64; 4]> {
        let [x, y, z] = axes(filter, dims);
        let mut all = Vec::new();
        for k in 0..z.coarse {
            for j in 0..y.coarse {
                for i in 0..x.coarse {
                    let mut sum = [0; 4];
                    for (c, wz) in z.taps(k) {
                        for (b, wy) in y.taps(j) {
                            for (a, wx) in x.taps(i) {
                                let voxel = fine[a + dims[0] * (b + dims[1] * c)];
                                (0..4).for_each(|n| sum[n] += i64::from(voxel[n]) * i64::from(wx * wy * wz));
                            }
                        }
                    }
                    all.push(sum);
                }
            }
        }
        all
    }

    /// Voxels of every kind: none, faint, any, the largest; black, white, and between.
    fn voxel() -> impl Strategy<Value = Codes> {
        let tau = prop_oneof![Just(0), 0..6_u16, 0..=MAX_CODE, Just(MAX_CODE)];
        tau.prop_flat_map(|tau| {
            let colour = move || prop_oneof![Just(0), 0..=tau, Just(tau)];
            (colour(), colour(), colour(), Just(tau)).prop_map(|(r, g, b, t)| [r, g, b, t])
        })
    }

    fn volume() -> impl Strategy<Value = (Filter, [usize; 3], Vec<Codes>)> {
        let side = || {
            prop_oneof![
                Just(1),
                Just(2),
                Just(3),
                Just(4),
                Just(5),
                Just(8),
                Just(9),
                1..14_usize
            ]
        };
        let filter = (0..4_usize).prop_map(|index| Filter::ALL[index]);
        (filter, side(), side(), side()).prop_flat_map(|(filter, x, y, z)| {
            let voxels = proptest::collection::vec(voxel(), x * y * z);
            (Just(filter), Just([x, y, z]), voxels)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: proptest::test_runner::RngSeed::Fixed(17),
            failure_persistence: None,
            ..ProptestConfig::with_cases(400)
        })]

        /// Every row keeps its sum to less than a coarse ulp, every colour stays below its extinction, extinctions below the
        /// largest; every value is within one and, of colours, two ulp of its own mean.
        #[test]
        fn rows_keep_their_sums((filter, dims, fine) in volume()) {
            let (coarse, sums) = (reduced(filter, dims, &fine), sums(filter, dims, &fine));
            prop_assert_eq!(coarse.len(), sums.len());
            let bits = gain(filter, dims);
            let one = 1_i64 << bits;
            for (row, sums) in coarse.chunks(filter.axis(dims[0]).coarse).zip(sums.chunks(filter.axis(dims[0]).coarse)) {
                for k in 0..4 {
                    let difference: i64 = row.iter().zip(sums).map(|(c, s)| i64::from(c[k]) * one - s[k]).sum();
                    let low = if k == 3 { -(one / 2 - 1).max(0) } else { -(2 * one - 2 - one / 2).max(0) };
                    prop_assert!((low..=one / 2).contains(&difference), "{difference} of 2^{bits}, channel {k}");
                }
                for (codes, sums) in row.iter().zip(sums) {
                    prop_assert!(codes.iter().all(|code| *code <= codes[3]) && codes[3] <= MAX_CODE);
                    for k in 0..4 {
                        let away = (i64::from(codes[k]) * one - sums[k]).abs();
                        prop_assert!(away <= if k == 3 { one - 1 } else { 2 * one }, "{away} of 2^{bits}");
                    }
                }
            }
        }

        /// White voxels stay white.
        #[test]
        fn white_stays((filter, dims, fine) in volume()) {
            let white: Vec<Codes> = fine.iter().map(|codes| [codes[3]; 4]).collect();
            prop_assert!(reduced(filter, dims, &white).iter().all(|codes| *codes == [codes[3]; 4]));
        }
    }

    #[test]
    fn constants_stay() {
        for filter in Filter::ALL {
            for dims in [[1, 1, 1], [2, 3, 1], [8, 8, 8], [9, 17, 5], [16, 1, 2]] {
                for code in [[0, 0, 0, 0], [0, 1, 1, 1], [7, 32766, 0, MAX_CODE], [3, 5, 8, 13]] {
                    let coarse = reduced(filter, dims, &vec![code; dims.iter().product()]);
                    assert!(
                        coarse.iter().all(|found| *found == code),
                        "{filter:?} {dims:?} {code:?}"
                    );
                }
            }
        }
    }

    /// A row of halves: rounding each would add half a code to every voxel.
    #[test]
    fn rests_are_carried() {
        let fine: Vec<Codes> = (0..64).map(|i| [0, 0, i % 2, i % 2]).collect();
        let coarse = reduced(Filter::Two, [64, 1, 1], &fine);
        let tau: Vec<u16> = coarse.iter().map(|codes| codes[3]).collect();
        assert_eq!(tau, [1, 0].repeat(16));
        assert!(coarse.iter().all(|codes| codes[2] == codes[3]));
    }
}
