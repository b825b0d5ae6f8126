//! Every operation of 16-bit lanes of every width against one lane.

use std::marker::PhantomData;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use slicecast::lanes::{Halves, Kernel, Lanes};

use crate::simd::{OverLanes, Simd, with_lanes};

/// Rows of equal length, and a number.
#[derive(Clone, Debug)]
struct Rows {
    rows: [Vec<u16>; 3],
    vector: [i16; 3],
    by: u32,
    offset: u16,
}

const OPERATIONS: usize = 19;

impl OverLanes for &Rows {
    type Output = (Vec<Vec<u16>>, Vec<bool>);

    fn run<V: Lanes>(self) -> Self::Output {
        V::enter(Results::<V>(self, PhantomData))
    }
}

struct Results<'a, V>(&'a Rows, PhantomData<V>);

impl<V: Lanes> Kernel for Results<'_, V> {
    type Output = (Vec<Vec<u16>>, Vec<bool>);

    #[inline(always)]
    fn run(self) -> Self::Output {
        results::<V::Halves>(self.0)
    }
}

/// Not -32768: that is no component and no factor.
#[inline(always)]
fn above_least<H: Halves>(v: H) -> H {
    // -32768 is its own negative; the lower bit makes it -32767.
    let least = H::splat(0x8000);
    let difference = v.minus(least);
    v.plus(H::splat(1).minus(difference.nonzero_then(H::splat(1))))
}

#[inline(always)]
fn results<H: Halves>(given: &Rows) -> (Vec<Vec<u16>>, Vec<bool>) {
    let Rows {
        rows: [a, b, c],
        vector,
        by,
        offset,
    } = given;
    // Behind the row there is more, which is not to be touched.
    let (n, by) = (a.len(), *by);
    let mut out = vec![vec![7; n + 2]; OPERATIONS];
    // One flag a lane of the widest vectors' length, so that widths can be compared.
    let pairs: [u32; 128] = std::array::from_fn(|at| (at as u32).wrapping_mul(2_654_435_761) ^ by);
    let mut zeros = Vec::new();
    for at in (0..n).step_by(H::COUNT) {
        let (x, y, z) = (
            H::load::<false>(a, at),
            H::load::<false>(b, at),
            H::load::<false>(c, at),
        );
        let gradient = [above_least(x), above_least(y), above_least(z)];
        let (k, h) = H::normalised(gradient);
        zeros.push(x.nonzero_then(y).all_zero());
        let [low, high] = H::load_pairs(&pairs, at);
        let results: [H; OPERATIONS] = [
            x.plus(y),
            x.minus(y),
            x.plus_saturating(y),
            x.minus_saturating(y),
            x.shl(by),
            x.shr(by),
            x.shr_signed(by),
            x.product_high(y),
            x.product_low(y),
            x.product_round(above_least(y)),
            x.product_plus(y, *offset),
            x.top_then_else(y, z),
            x.nonzero_then(y),
            x.at_least_or_zero(y),
            h,
            H::facing(gradient, H::direction(*vector), k),
            H::splat(*offset),
            low,
            high,
        ];
        for (result, out) in results.into_iter().zip(&mut out) {
            result.store::<false>(&mut out[..n], at);
        }
    }
    (out, zeros)
}

/// Packed lanes of two rows, how many they are, and the lanes spread again; behind them nothing is compared.
struct Packing<'a, V>(&'a Rows, PhantomData<V>);

impl<V: Lanes> Kernel for Packing<'_, V> {
    type Output = [Vec<u16>; 2];

    #[inline(always)]
    fn run(self) -> Self::Output {
        packing::<V::Halves>(self.0)
    }
}

struct Packed<'a>(&'a Rows);

impl OverLanes for Packed<'_> {
    type Output = [Vec<u16>; 2];

    fn run<V: Lanes>(self) -> Self::Output {
        V::enter(Packing::<V>(self.0, PhantomData))
    }
}

#[inline(always)]
fn packing<H: Halves>(given: &Rows) -> [Vec<u16>; 2] {
    let [values, chosen, _] = &given.rows;
    let wanted = chosen.iter().filter(|lane| **lane != 0).count();
    // No longer than what is chosen, as rows of gradients are.
    let (mut packed, mut spread) = (vec![7; wanted], vec![7; values.len()]);
    let mut at = 0;
    for place in (0..values.len()).step_by(H::COUNT) {
        let chosen = H::load::<false>(chosen, place);
        let count = H::load::<false>(values, place).store_packed(chosen, &mut packed, at);
        assert_eq!(count, chosen.count());
        at += count;
    }
    assert_eq!(at, wanted);
    let mut at = 0;
    for place in (0..values.len()).step_by(H::COUNT) {
        let chosen = H::load::<false>(chosen, place);
        H::load_spread(&packed, at, chosen).store::<false>(&mut spread, place);
        at += chosen.count();
    }
    [packed, spread]
}

fn lane() -> impl Strategy<Value = u16> {
    prop_oneof![
        any::<u16>(),
        prop::sample::select(vec![0u16, 1, 2, 0x7ffe, 0x7fff, 0x8000, 0x8001, 0xfffe, 0xffff]),
        0u16..64,
    ]
}

fn rows() -> impl Strategy<Value = Rows> {
    let row = |n| prop::collection::vec(lane(), n);
    let component = -18918i16..=18918;
    (1usize..100).prop_flat_map(move |n| {
        let rows = (row(n), row(n), row(n)).prop_map(|(a, b, c)| [a, b, c]);
        // No longer than 32767.
        let vector = prop_oneof![
            prop::array::uniform3(component.clone()),
            Just([32767, 0, 0]),
            Just([0, -32767, 0]),
            Just([0, 0, 32767]),
        ];
        (rows, vector, 0u32..16, 1u16..).prop_map(|(rows, vector, by, offset)| Rows {
            rows,
            vector,
            by,
            offset,
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, rng_seed: RngSeed::Fixed(16), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn chosen_lanes_are_packed_and_spread_again(mut rows in rows()) {
        let [values, chosen, others] = &mut rows.rows;
        for (chosen, other) in chosen.iter_mut().zip(others) {
            if *other & 1 != 0 {
                *chosen = 0;
            }
        }
        let picked: Vec<u16> = values.iter().zip(&*chosen).filter(|(_, chosen)| **chosen != 0).map(|(v, _)| *v).collect();
        let back: Vec<u16> = values.iter().zip(&*chosen).map(|(v, chosen)| if *chosen != 0 { *v } else { 0 }).collect();
        for simd in Simd::available() {
            prop_assert_eq!(with_lanes(simd, Packed(&rows)), [picked.clone(), back.clone()], "{}", simd.name());
        }
    }

    #[test]
    fn every_width_does_what_one_lane_does(rows in rows()) {
        let (expected, flags) = with_lanes(Simd::Scalar, &rows);
        for simd in Simd::available() {
            let (found, of_vectors) = with_lanes(simd, &rows);
            for (operation, (expected, found)) in expected.iter().zip(&found).enumerate() {
                prop_assert_eq!(expected, found, "operation {} of {}", operation, simd.name());
            }
            let lanes = flags.len().div_ceil(of_vectors.len()).next_power_of_two();
            let together = flags.chunks(lanes).map(|flags| flags.iter().all(|zero| *zero));
            prop_assert_eq!(together.collect::<Vec<_>>(), of_vectors, "zeros of {}", simd.name());
        }
    }
}
