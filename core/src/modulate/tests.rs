use super::*;
use crate::precision::{Compact, Paper, Wide};
use proptest::prelude::*;
use std::vec::Vec;

fn factors(at: impl Fn(usize) -> u16) -> Factors {
    Factors::new(&core::array::from_fn(|node| Intensity::from_bits(at(node)))).unwrap()
}

/// |G|^2 in codes at a node.
fn node(n: usize) -> f64 {
    let half = if n.is_multiple_of(2) { 1.0 } else { 1.5 };
    half * 2f64.powi((n / 2) as i32 + FIRST)
}

#[test]
fn factors_above_one_are_refused() {
    let mut bits = [Intensity::ONE; NODES];
    assert!(Factors::new(&bits).is_ok());
    bits[64] = Intensity::from_bits(32769);
    let refused = FactorError { node: 64, bits: 32769 };
    assert_eq!(Factors::new(&bits), Err(refused));
}

#[test]
fn the_longest_and_the_shortest_gradients_have_places() {
    for bits in [1, 12, 15] {
        let one = 1 << bits;
        assert_eq!(magnitude([0; 3], bits), 0);
        // A quarter of a code is node 0, a code node 8, the longest one below node 64.
        if bits > 2 {
            assert_eq!(magnitude([0, one / 4, 0], bits), 0);
            assert_eq!(magnitude([one / 8, 0, 0], bits), 0);
        }
        assert_eq!(magnitude([0, 0, -one], bits), 8 << FRACTION);
        let longest = magnitude([8190 * one, -8190 * one, 8190 * one], bits);
        assert!(longest < 64 << FRACTION, "{longest}");
        assert_eq!(longest >> FRACTION, 62);
    }
}

#[test]
fn a_factor_of_one_changes_nothing_and_none_leaves_nothing() {
    for a in [0u32, 1, 0x1234_5678, 1 << 31] {
        assert_eq!(modulated(a as i32, 1 << 15) as u32, a);
        assert_eq!(modulated(a as i32, 0), 0);
    }
    for x in [0, 1, 40_000, 1 << 16] {
        assert_eq!(weighed(Compact, x, 1 << 15), x);
        assert_eq!(weighed(Paper, x, 1 << 15), x);
    }
    assert_eq!(weighed(Wide, i32::MIN, 1 << 15), i32::MIN);
}

proptest! {
    /// The factor is the table's, linear in |G|^2 between its nodes: block normalisation keeps 15 bits of the largest component.
    #[test]
    fn factors_are_linear_in_the_square(
        g in prop::array::uniform3(-(8190i32 << 15)..=8190 << 15),
        shift in 0u32..28,
        seed in any::<[u16; 7]>(),
        bits in 12u32..=15,
    ) {
        let g = g.map(|c| c >> shift >> (15 - bits));
        let table = factors(|n| (u32::from(seed[n % 7]) * u32::from(seed[n / 7 % 7]) % 32769) as u16);
        let square: f64 = g.map(|c| (f64::from(c) / f64::from(1 << bits)).powi(2)).iter().sum();
        let n = (0..NODES - 1).rev().find(|n| node(*n) <= square);
        let exact = |n: usize, q: f64| {
            let [a, b] = [table.0[n], table.0[n + 1]].map(f64::from);
            a + (b - a) * (q - node(n)) / (node(n + 1) - node(n))
        };
        let place = [magnitude(g, bits)];
        let found = f64::from(table.at::<i32>(&place, 0));
        // Half a unit of each of three components, in the square; at a node it may be the line of either side.
        let slack = square * 3f64.sqrt() * 2f64.powi(-14) + 1e-9;
        let expected = n.map_or(f64::from(table.0[0]), |n| exact(n, square));
        let steep = n.map_or(0.0, |n| {
            let slope = |n: usize| f64::from(table.0[n + 1].abs_diff(table.0[n])) / (node(n + 1) - node(n));
            slope(n).max(slope(n.saturating_sub(1))).max(slope((n + 1).min(NODES - 2)))
        });
        let steep = if n.is_none() && square > node(0) - slack { f64::from(table.0[1].abs_diff(table.0[0])) / (node(1) - node(0)) } else { steep };
        prop_assert!((found - expected).abs() <= 1.5 + steep * slack, "{found} {expected} {n:?} {square}");
    }

    #[test]
    fn opacities_are_the_nearest(a in 0u32..=1 << 31, f in 0i32..=1 << 15) {
        let exact = (u64::from(a) * f as u64 + (1 << 14)) >> 15;
        prop_assert_eq!(modulated(a as i32, f) as u32 as u64, exact);
    }

    #[test]
    fn rows_are_the_scalar(rows in prop::collection::vec((any::<[i16; 3]>(), any::<[u8; 3]>()), 0..34), one in any::<bool>()) {
        let modulation = Modulation { opacity: Some(factors(|n| (500 * n) as u16)), ..Modulation::default() };
        let shader = Modulated::new(Compact, None, modulation);
        let gradients: Vec<[i32; 3]> = rows.iter().map(|(g, _)| g.map(|c| i32::from(c) << 10)).collect();
        let mut places: Vec<i32> = gradients.iter().map(|g| magnitude(*g, 12)).collect();
        let mut colours = [0, 1, 2].map(|c| rows.iter().map(|(_, rgb)| i32::from(rgb[c])).collect::<Vec<_>>());
        let before = colours.clone();
        let [red, green, blue] = &mut colours;
        let zero = std::vec![0; rows.len()];
        let mut row = Colours { one: one.then_some([1, 2, 3]), rows: [red, green, blue] };
        shader.shade_modulated_row::<i32>([&zero; 3].map(|row| &row[..]), &zero, &places, &mut row);
        let expected = if one { [1, 2, 3].map(|c| std::vec![c; rows.len()]) } else { before };
        prop_assert_eq!(&colours, &expected);
        prop_assert!(shader.factor_row::<i32>(&mut places));
        for (factor, gradient) in places.iter().zip(gradients) {
            let opacity = Opacity::from_bits(0x6543_2100);
            let expected = shader.opacity(gradient, opacity);
            prop_assert_eq!(modulated(0x6543_2100, *factor) as u32, expected.to_bits());
        }
    }
}
