//! Every operation of every width against one lane, which is the definition.

mod halves;

use std::marker::PhantomData;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use slicecast::composite::Unorm16;
use slicecast::lanes::{Kernel, Lanes, Small, Wide};
use slicecast::table::{Coding, Neighboured};

use super::{OverLanes, Simd, with_lanes};

/// All operations on rows of numbers. The fields hold numbers of the ranges that the operations' documentation gives.
#[derive(Clone, Debug)]
struct Rows {
    any: Vec<i32>,
    other: Vec<i32>,
    voxels: Vec<u16>,
    /// 0 to 31.
    shifts: Vec<i32>,
    /// 0, or 2^28 to 3 * 32767^2.
    squares: Vec<i32>,
    /// 0 to 2^31.
    ones: Vec<i32>,
    /// 0 to 65535.
    weights: Vec<i32>,
    by: u32,
}

impl OverLanes for &Rows {
    type Output = Vec<Vec<i32>>;

    fn run<V: Lanes>(self) -> Vec<Vec<i32>> {
        V::enter(Results::<V>(self, PhantomData))
    }
}

struct Results<'a, V>(&'a Rows, PhantomData<V>);

impl<V: Lanes> Kernel for Results<'_, V> {
    type Output = Vec<Vec<i32>>;

    #[inline(always)]
    fn run(self) -> Vec<Vec<i32>> {
        self.0.results::<V>()
    }
}

impl Rows {
    #[inline(always)]
    fn results<V: Lanes>(&self) -> Vec<Vec<i32>> {
        const OPERATIONS: usize = 49;
        let n = self.any.len();
        let mut out = vec![vec![0; n]; OPERATIONS];
        let values: Neighboured = std::array::from_fn(|code| (code as u32).wrapping_mul(2_654_435_761));
        let by = self.by;
        let samples: Vec<i32> = self.any.iter().map(|bits| bits & 0x0fff_ffff).collect();
        let coding = Coding {
            offset: (by * 1057 % 0x8000) as i32,
            bits: by & 15,
        };
        // At most one apart, as the cells of rays that spread.
        let cells = self.other.iter().scan(0, |cell, bits| {
            *cell += bits & 1;
            Some(*cell)
        });
        let cells: Vec<i32> = cells.collect();
        // Rows of other types, of which the last elements are not to be touched.
        let behind = [1, 2, 3];
        let mut narrow: Vec<u16> = self.voxels.iter().copied().chain(behind).collect();
        let mut unorms: Vec<Unorm16> = narrow.iter().copied().map(Unorm16).collect();
        let mut words: Vec<u32> = narrow.iter().copied().map(u32::from).collect();
        let mut bytes: Vec<u8> = narrow.iter().map(|v| *v as u8).collect();
        for at in (0..n).step_by(V::COUNT) {
            let (a, b) = (V::load(&self.any, at), V::load(&self.other, at));
            let (shift, square, one) = (
                V::load(&self.shifts, at),
                V::load(&self.squares, at),
                V::load(&self.ones, at),
            );
            let voxel = V::load_voxels(&self.voxels, at);
            let weight = V::load(&self.weights, at);
            // Small enough for every product and sum.
            let (x, y) = (a >> 16, b >> 16);
            let (w, v) = (a.product(b), one.product(one));
            let [value, next] = V::look_up(&values, &samples, at, coding);
            // Whether any lane is that large says nothing of one lane, so all are alike.
            let alike = V::Wide::of(V::splat(self.ones.first().copied().unwrap_or(0)));
            let flag = |condition: bool| V::splat(i32::from(condition));
            let results: [V; OPERATIONS] = [
                x + y,
                x - y,
                (x >> 1) * (y >> 1),
                a & b,
                a | b,
                a ^ b,
                x << (by & 15),
                a >> (by & 31),
                voxel,
                V::load_as(&self.voxels, at, |v| u32::from(v) + 1),
                value,
                next,
                a.followed_by(V::load(&self.any, at + V::COUNT)),
                a.wrapping_add(b),
                a.wrapping_sub(b),
                a.wrapping_mul(b),
                a.saturating_add(b),
                a.shr_unsigned(by & 31),
                a.shl_each(shift),
                a.shr_each(shift),
                a.at_most(b),
                a.at_least(b),
                a.at_most_unsigned(b),
                a.abs(),
                a.leading_zeros(),
                shift.leading_zeros(),
                shift.nonzero_then(a),
                a.at_least_then(b, y),
                square.reciprocal_root(),
                x.with_sign_of(b),
                (a >> 2).scale16(weight, 0),
                (a >> 2).scale16(weight, 1 << 15),
                (a >> 3).round15(weight >> 1),
                (voxel >> 4).between16(weight >> 4, weight),
                (one >> 1).mix(one.shr_unsigned(2), weight >> 4, 12),
                w.narrow(),
                w.shr(by).narrow(),
                w.shr(32).narrow(),
                w.shr_narrow(by.max(1)),
                (a.product_signed(b).shr(20) + v.shr(3) - V::Wide::splat(12345)).narrow(),
                x.product_signed(y).at_least_zero().narrow(),
                x.product_signed(y).at_most(V::Wide::of(one)).narrow(),
                V::Wide::of(one).shl(by & 31).shr(by & 15).narrow(),
                V::Wide::of(one).times(shift).shr(4).narrow(),
                V::Wide::of(one).square31().narrow() ^ w.low_product(v).shr(31).narrow(),
                one.product(shift).shr_to_one(5).narrow()
                    ^ flag(V::splat(0).all_zero() != alike.any_at_least(by << 26)),
                v.shr_to_one(by.max(1)).nonzero_then(w).narrow() ^ w.nonzero_then(v).narrow(),
                weight.product16_31(one.at_most_unsigned(V::splat(2_147_418_113)), 0x7fff_8000),
                V::picked(
                    &self.any,
                    cells[at] as usize + (by & 3) as usize,
                    V::load(&cells, at).wrapping_sub(V::splat(cells[at])),
                ),
            ];
            for (row, lanes) in out.iter_mut().zip(results) {
                lanes.store(row, at);
            }
            (voxel + V::splat(1)).store_as(&mut narrow[..n], at, |bits| bits as u16);
            V::load_as(&unorms[..n], at, |u| u32::from(u.0) + 1)
                .store_as(&mut unorms[..n], at, |bits| Unorm16(bits as u16));
            V::load_as(&words[..n], at, |w| w ^ 5).store_as(&mut words[..n], at, |bits| bits + 1);
            V::load_as(&bytes[..n], at, u32::from).store_as(&mut bytes[..n], at, |bits| bits as u8 ^ 5);
        }
        // Two at a time.
        let mut two = unorms.clone();
        let mut sums: Vec<u16> = self.voxels.iter().copied().chain(behind).collect();
        let mut long: Vec<u32> = sums.iter().copied().map(u32::from).collect();
        for at in (0..n).step_by(2 * V::COUNT) {
            let pair = [V::load(&self.weights, at), V::load(&self.weights, at + V::COUNT)];
            V::store_two_as(pair, &mut two[..n], at, |bits| Unorm16(bits as u16));
            let pair = [V::load(&self.ones, at), V::load(&self.ones, at + V::COUNT)];
            V::add_upper_as(pair, &mut sums[..n], at, u32::from, |bits| bits as u16);
            V::add_upper_as(pair, &mut long[..n], at, |w| w, |bits| bits);
        }
        out.push(two.into_iter().map(|u| i32::from(u.0)).collect());
        out.push(sums.into_iter().map(i32::from).collect());
        out.push(long.into_iter().map(|w| w as i32).collect());
        out.push(narrow.into_iter().map(i32::from).collect());
        out.push(unorms.into_iter().map(|u| i32::from(u.0)).collect());
        out.push(words.into_iter().map(|w| w as i32).collect());
        out.push(bytes.into_iter().map(i32::from).collect());
        out
    }
}

fn bits() -> impl Strategy<Value = i32> {
    prop_oneof![
        4 => any::<i32>().prop_map(|b| if b == i32::MIN { 0 } else { b }),
        2 => (0u32..31, -3i32..=3).prop_map(|(n, d)| (1i32 << n) + d),
        1 => -4i32..=4,
        1 => Just(i32::MAX),
    ]
}

fn square() -> impl Strategy<Value = i32> {
    // Squares of powers of two have whole roots; the others lie next to a whole root (found by exhaustion).
    let hard = [
        1 << 28,
        (1 << 28) + 1,
        (1 << 28) + 7,
        1 << 30,
        (1 << 30) - 1,
        0,
        898_823_412,
        399_477_072,
        1_593_594_880,
        896_397_120,
        398_398_720,
        1_377_181_654,
        1_908_893_772,
        1_939_724_855,
        848_397_232,
        477_223_443,
        2_715_677_626,
        2_123_281_226,
        3_221_028_867,
    ];
    prop_oneof![
        3 => ((1u32 << 28)..=3_221_028_867).prop_map(|s| s as i32),
        1 => prop::sample::select(hard.to_vec()).prop_map(|s: u32| s as i32),
    ]
}

fn rows() -> impl Strategy<Value = Rows> {
    let row = |n| prop::collection::vec(bits(), n);
    (0usize..70).prop_flat_map(move |n| {
        (
            (row(n), row(n), prop::collection::vec(0u16..=4095, n)),
            (
                prop::collection::vec(0i32..32, n),
                prop::collection::vec(square(), n),
                prop::collection::vec(prop_oneof![0u32..=1 << 31, (1u32 << 31) - 3..=1 << 31], n),
                prop::collection::vec(0i32..65536, n),
            ),
            0u32..32,
        )
            .prop_map(|((any, other, voxels), (shifts, squares, ones, weights), by)| Rows {
                any,
                other,
                voxels,
                shifts,
                squares,
                ones: ones.into_iter().map(|one| one as i32).collect(),
                weights,
                by,
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(512), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_width_does_what_one_lane_does(rows in rows()) {
        let expected = with_lanes(Simd::Scalar, &rows);
        let vectors = Simd::available().map(|simd| (simd.name(), with_lanes(simd, &rows)));
        for (name, found) in vectors.chain([("small", (&rows).run::<Small>())]) {
            for (operation, (expected, found)) in expected.iter().zip(&found).enumerate() {
                prop_assert_eq!(expected, found, "operation {} of {}", operation, name);
            }
        }
    }
}

/// Every 977th square, and all within 2000 of the ends.
#[test]
fn reciprocal_roots_are_the_definition() {
    struct Roots(Vec<i32>);
    impl OverLanes for &Roots {
        type Output = Vec<i32>;
        fn run<V: Lanes>(self) -> Vec<i32> {
            let mut out = vec![0; self.0.len()];
            V::enter(Each::<V>(&self.0, &mut out, PhantomData));
            out
        }
    }
    struct Each<'a, V>(&'a [i32], &'a mut [i32], PhantomData<V>);
    impl<V: Lanes> Kernel for Each<'_, V> {
        type Output = ();
        #[inline(always)]
        fn run(self) {
            for at in (0..self.0.len()).step_by(V::COUNT) {
                V::load(self.0, at).reciprocal_root().store(self.1, at);
            }
        }
    }
    let (first, last) = (1u32 << 28, 3_221_028_867u32);
    let squares = (first..first + 2000)
        .chain((first..last).step_by(977))
        .chain(last - 2000..=last);
    let roots = Roots(squares.map(|s| s as i32).collect());
    let expected = with_lanes(Simd::Scalar, &roots);
    for simd in Simd::available() {
        assert!(with_lanes(simd, &roots) == expected, "{}", simd.name());
    }
    assert!((&roots).run::<Small>() == expected, "small");
}

/// A row packed by what is chosen, and spread again.
struct Packing<'a> {
    row: &'a [i32],
    chosen: &'a [i32],
}

impl OverLanes for Packing<'_> {
    type Output = [Vec<i32>; 2];

    fn run<V: Lanes>(self) -> [Vec<i32>; 2] {
        V::enter(PackedAndSpread::<V>(self, PhantomData))
    }
}

struct PackedAndSpread<'a, V>(Packing<'a>, PhantomData<V>);

impl<V: Lanes> Kernel for PackedAndSpread<'_, V> {
    type Output = [Vec<i32>; 2];

    #[inline(always)]
    fn run(self) -> [Vec<i32>; 2] {
        self.0.packed_and_spread::<V>()
    }
}

impl Packing<'_> {
    #[inline(always)]
    fn packed_and_spread<V: Lanes>(self) -> [Vec<i32>; 2] {
        let n = self.row.len();
        let (mut packed, mut spread) = (vec![0; n + V::COUNT], vec![0; n]);
        let (mut end, mut from) = (0, 0);
        for at in (0..n).step_by(V::COUNT) {
            let chosen = V::load(self.chosen, at);
            V::load(self.row, at).packed(chosen).store(&mut packed, end);
            end += chosen.count();
        }
        packed.truncate(end);
        for at in (0..n).step_by(V::COUNT) {
            let chosen = V::load(self.chosen, at);
            let lanes = V::load(&packed, from).spread(chosen);
            chosen.nonzero_then(lanes).store(&mut spread, at);
            from += chosen.count();
        }
        [packed, spread]
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(8), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn packed_rows_are_what_is_chosen(
        rows in prop::collection::vec((bits(), prop_oneof![Just(0), bits()]), 0..70),
    ) {
        let (row, chosen): (Vec<i32>, Vec<i32>) = rows.iter().copied().unzip();
        let kept: Vec<i32> = rows.iter().filter(|(_, chosen)| *chosen != 0).map(|(c, _)| *c).collect();
        let back: Vec<i32> = rows.iter().map(|(c, chosen)| if *chosen != 0 { *c } else { 0 }).collect();
        for simd in Simd::available() {
            let [packed, spread] = with_lanes(simd, Packing { row: &row, chosen: &chosen });
            prop_assert_eq!(&packed, &kept, "packed by {}", simd.name());
            prop_assert_eq!(&spread, &back, "spread by {}", simd.name());
        }
    }
}

/// Every set of eight lanes, and every one of sixteen.
#[test]
fn every_choice_of_lanes_is_packed() {
    let row: Vec<i32> = (1..=16).collect();
    for set in 0..1 << 16 {
        let chosen: Vec<i32> = (0..16).map(|lane| set >> lane & 1).collect();
        let kept: Vec<i32> = row
            .iter()
            .zip(&chosen)
            .filter(|(_, c)| **c != 0)
            .map(|(v, _)| *v)
            .collect();
        for simd in Simd::available() {
            let [packed, spread] = with_lanes(
                simd,
                Packing {
                    row: &row,
                    chosen: &chosen,
                },
            );
            assert_eq!(packed, kept, "{set:x} by {}", simd.name());
            assert!(
                spread.iter().zip(&row).zip(&chosen).all(|((s, v), c)| *s == v * c),
                "{set:x} by {}",
                simd.name()
            );
        }
    }
}
