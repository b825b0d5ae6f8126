use super::*;
use crate::borders::WHOLE;
use crate::format::{Direction, Intensity};
use crate::lanes::Small;
use crate::plan::{Plan, Sampling, Spacing};
use crate::precision::{Compact, Wide};
use crate::slice::RowRange;
use crate::view::View;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::vec::Vec;

/// Nodes of bins of constant extinction and colours, and their exponent.
fn lists(grain: u32, tau: impl Fn(usize) -> f64, colour: impl Fn(usize) -> [f64; 3]) -> ([Vec<u32>; 4], u32) {
    let bins = ENTRIES >> grain;
    let mut sums = [0.0; 4];
    let mut all = Vec::from([[0.0; 4]]);
    for bin in 0..bins {
        let (t, c) = (tau(bin) * f64::from(1 << grain), colour(bin));
        for (sum, weight) in sums.iter_mut().zip([1.0, c[0], c[1], c[2]]) {
            *sum += t * weight;
        }
        all.push(sums);
    }
    let mut exponent = 28;
    while sums[0] * f64::from(exponent).exp2() > f64::from(NODE_MAX) {
        exponent -= 1;
    }
    let list = |channel: usize| {
        let node = |sums: &[f64; 4]| (sums[channel] * f64::from(exponent).exp2()).round() as u32;
        all.iter().map(node).collect()
    };
    ([list(0), list(1), list(2), list(3)], exponent)
}

fn length(l: f64) -> Length {
    let mut bits = 27;
    let scaled = |bits: u32| (l * std::f64::consts::LOG2_E * f64::from(bits).exp2()).round();
    while scaled(bits) >= 4_294_967_296.0 {
        bits -= 1;
    }
    Length {
        scaled: scaled(bits) as u32,
        bits,
    }
}

fn table(lists: &[Vec<u32>; 4], exponent: u32, grain: u32, l: f64) -> Integral<&[u32]> {
    let [t, r, g, b] = lists;
    Integral::new(&t[..], Colours::Each([r, g, b]), grain, exponent, length(l)).unwrap()
}

/// A code as a sample of `Wide`.
fn sample(code: f64) -> i32 {
    (code * 32768.0) as i32
}

fn opacity(table: &Integral<&[u32]>, front: f64, back: f64) -> f64 {
    let ends = [sample(front), sample(back)];
    let a = table.segment_opacity(Wide, ends).to_bits();
    let ends = [ends[1], ends[0]];
    assert_eq!(a, table.segment_opacity(Wide, ends).to_bits(), "the order counts");
    f64::from(a) / 2_147_483_648.0
}

#[test]
fn white_fog_is_the_same_at_every_segment() {
    let (lists, exponent) = lists(0, |_| 1.0 / 256.0, |_| [1.0; 3]);
    assert_eq!(exponent, 27);
    for (front, back, l) in [
        (0.0, 4095.0, 1.0),
        (100.0, 100.0, 1.0),
        (100.5, 101.25, 1.0),
        (3000.0, 7.0, 0.25),
        (4095.0, 4095.0, 16.0),
        (0.0, 0.0, 16.0),
        (4094.5, 4095.0, 40.0),
    ] {
        let table = table(&lists, exponent, 0, l);
        let exact = -(-l / 256.0f64).exp_m1();
        let found = opacity(&table, front, back);
        assert!(
            (found - exact).abs() < 60.0 / 2_147_483_648.0,
            "{front} {back}: {found} {exact}"
        );
        let colour = table.segment_colour(Wide, [front, back].map(sample));
        assert_eq!(colour, [1 << 31; 3], "white");
    }
}

#[test]
fn a_shell_one_code_wide() {
    let (lists, exponent) = lists(0, |code| if code == 1000 { 16.0 } else { 0.0 }, |_| [1.0; 3]);
    let near = |front, back, l, exact: f64| {
        let found = opacity(&table(&lists, exponent, 0, l), front, back);
        assert!((found - exact).abs() < 2e-7, "{front} {back}: {found} {exact}");
    };
    near(900.0, 1100.0, 1.0, -(-16.0f64 / 200.0).exp_m1());
    near(1000.0, 1000.0, 1.0, -(-16.0f64).exp_m1());
    near(999.0, 1000.0, 1.0, -(-8.0f64).exp_m1());
    near(0.0, 4095.0, 1.0, -(-16.0f64 / 4095.0).exp_m1());
    near(999.5, 1000.5, 1.0 / 16.0, -(-1.0f64).exp_m1());
    assert_eq!(opacity(&table(&lists, exponent, 0, 1.0), 998.0, 999.0), 0.0);
    assert_eq!(opacity(&table(&lists, exponent, 0, 1.0), 1001.0, 4095.0), 0.0);
}

#[test]
fn colours_are_means_weighted_by_extinction() {
    let tau = |code| if (10..30).contains(&code) { 1.0 } else { 0.0 };
    let colour = |code| if code < 20 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
    let (lists, exponent) = lists(0, tau, colour);
    let table = table(&lists, exponent, 0, 1.0);
    let ends = [9.5, 29.5].map(sample);
    assert!((opacity(&table, 9.5, 29.5) + (-1.0f64).exp_m1()).abs() < 3e-8);
    let [r, g, b] = table.segment_colour(Wide, ends);
    assert!(
        r.abs_diff(1 << 30) < 40 && b.abs_diff(1 << 30) < 40 && g == 0,
        "{r} {b}"
    );
    let [r, g, b] = table.segment_colour(Compact, ends.map(|end| end >> 3));
    assert_eq!([r, g, b], [1 << 14, 0, 1 << 14]);
}

#[test]
fn the_densest_table_is_opaque() {
    let (lists, exponent) = lists(0, |_| 16.0, |_| [1.0; 3]);
    assert_eq!(exponent, 15);
    assert_eq!(opacity(&table(&lists, exponent, 0, 22.0), 2000.0, 2000.0), 1.0);
    assert_eq!(opacity(&table(&lists, exponent, 0, 50_000.0), 0.0, 4095.0), 1.0);
    let found = opacity(&table(&lists, exponent, 0, 1.0 / 16.0), 2000.0, 2000.0);
    assert!((found + (-1.0f64).exp_m1()).abs() < 3e-8);
}

#[test]
fn an_empty_table_has_neither_opacity_nor_colour() {
    let (lists, exponent) = lists(0, |_| 0.0, |_| [1.0; 3]);
    let table = table(&lists, exponent, 0, 1.0);
    assert_eq!(exponent, 28);
    assert_eq!(Classifier::<Wide>::support(&table), Support::NONE);
    assert_eq!(opacity(&table, 0.0, 4095.0), 0.0);
    assert_eq!(table.segment_colour(Wide, [0, sample(4095.0)]), [0; 3]);
}

#[test]
fn what_is_no_table_is_refused() {
    let (lists, exponent) = lists(0, |_| 1.0, |_| [1.0; 3]);
    let [t, ..] = &lists;
    let one = Colours::One([0; 3]);
    let l = length(1.0);
    let refused = |t: &[u32], grain, exponent, length| Integral::new(t, one, grain, exponent, length).err();
    assert_eq!(refused(t, 5, exponent, l), Some(IntegralError::Grain { given: 5 }));
    assert_eq!(refused(t, 0, 29, l), Some(IntegralError::Exponent { given: 29 }));
    let (needed, given) = (1025, 4097);
    assert_eq!(refused(t, 2, exponent, l), Some(IntegralError::Nodes { needed, given }));
    let bits = 28;
    assert_eq!(
        refused(t, 0, exponent, Length { bits, ..l }),
        Some(IntegralError::Length { bits })
    );
    let mut falling = t.clone();
    falling[7] = falling[6] - 1;
    let (index, value) = (7, falling[7]);
    assert_eq!(
        refused(&falling, 0, exponent, l),
        Some(IntegralError::Node { list: 0, index, value })
    );
    let (list, each) = (2, Colours::Each([t, &falling, t]));
    assert_eq!(
        Integral::new(t, each, 0, exponent, l).err(),
        Some(IntegralError::Node { list, index, value })
    );
    let mut high = t.clone();
    high[4096] = NODE_MAX + 1;
    let (index, value) = (4096, high[4096]);
    assert_eq!(
        refused(&high, 0, exponent, l),
        Some(IntegralError::Node { list: 0, index, value })
    );
    let bits = (1 << 31) + 1;
    assert_eq!(
        Integral::new(t, Colours::One([0, bits, 0]), 0, exponent, l).err(),
        Some(IntegralError::Colour { bits })
    );
}

/// A table of random bins, thin and thick, with gaps.
fn random(grain: u32) -> impl Strategy<Value = ([Vec<u32>; 4], u32)> {
    let bin = (0u32..6, 0.0..1.0f64, prop::array::uniform3(0u8..=4));
    let few = prop::collection::vec((1usize..400, bin), 12..60);
    (few, -12.0..4.0f64).prop_map(move |(runs, thickest)| {
        let mut bins = Vec::new();
        for (len, bin) in runs {
            bins.resize(bins.len() + len, bin);
        }
        let bin = |n: usize| bins[n % bins.len()];
        let tau = |n: usize| {
            let (kind, t, _) = bin(n);
            if kind < 2 { 0.0 } else { t * thickest.exp2() }
        };
        lists(grain, tau, |n| bin(n).2.map(|c| f64::from(c) / 4.0))
    })
}

fn small_rows_are_the_definition<P: Precision>(
    p: P,
    table: &Integral<&[u32]>,
    front: &[i32],
    back: &[i32],
    fraction: u32,
) -> Result<(), TestCaseError> {
    let [mut a, mut r, mut g, mut b] = [(); 4].map(|()| std::vec![0; front.len()]);
    let slab = || Slab::between(front, back).of_fraction(fraction);
    table.opacity_row::<Small>(p, slab(), &mut a);
    table.colour_row::<Small>(p, slab(), [&mut r, &mut g, &mut b]);
    for n in 0..front.len() {
        let ends = [front[n], back[n]];
        let [red, green, blue] = table.segment_colour(p, ends).map(|c| c as i32);
        let opacity = table.part_opacity(p, ends, fraction, 0);
        if fraction == WHOLE {
            prop_assert_eq!(opacity, table.segment_opacity(p, ends));
        }
        let expected = [opacity.to_bits() as i32, red, green, blue];
        prop_assert_eq!([a[n], r[n], g[n], b[n]], expected, "{:?}", ends);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, rng_seed: RngSeed::Fixed(1025), failure_persistence: None, ..ProptestConfig::default() })]

    /// The formula in f64 on the same nodes: the stated errors. A small machine: the same bits. Out of the support: nothing.
    #[test]
    fn segments_are_as_near_as_stated(
        (lists, exponent) in prop_oneof![random(0), random(2)],
        l in prop_oneof![0.0625..2.0f64, 2.0..60.0],
        ends in prop::collection::vec((0.0..4095.0f64, -9.0..12.0f64, any::<bool>()), 200),
        fraction in prop_oneof![Just(WHOLE), 1..=WHOLE, (0u32..16).prop_map(|bits| 1 << bits)],
    ) {
        let grain = if lists[0].len() == 4097 { 0 } else { 2 };
        let table = table(&lists, exponent, grain, l);
        for (front, distance, up) in ends {
            let back = if up { front + distance.exp2() } else { front - distance.exp2() }.clamp(0.0, 4095.0);
            let ends = [front, back].map(sample);
            let a = f64::from(table.part_opacity(Wide, ends, fraction, 0).to_bits());
            let c = table.segment_colour(Wide, ends);
            let bin = f64::from(1u32 << grain);
            // The ends as real numbers; the middle of a short segment is that of the samples' bits.
            let raw = (1i32 << 15) << grain;
            let (mut low, mut high) = (ends[0].min(ends[1]) + 16384, ends[0].max(ends[1]) + 16384);
            if high - low < raw {
                low = (((low + high) >> 1) - raw / 2).clamp(0, (4096 << 15) - raw);
                high = low + raw;
            }
            let [low, high] = [low, high].map(|end| f64::from(end) / 32768.0);
            let over = |list: &[u32]| {
                let at = |u: f64| {
                    let n = ((u / bin) as usize).min(list.len() - 2);
                    let [a, b] = [list[n], list[n + 1]].map(f64::from);
                    a + (b - a) * (u / bin - n as f64)
                };
                at(high) - at(low)
            };
            let inside = l * f64::from(fraction) / 65536.0;
            let depth = over(&lists[0]) / f64::from(exponent).exp2() / (high - low) * inside;
            let exact = -(-depth).exp_m1() * 2_147_483_648.0;
            // A unit of the integral, for its two roundings, where the table is thin.
            let unit = inside / (high - low) * f64::from(31 - exponent as i32).exp2() * (-depth).exp();
            // Half a unit of y, and 2^-y itself; relative to y the reciprocal 2^-25, its product with the length a unit of at least
            // dl / 2, and dl half a unit: y 2^-y is at most 1 / (e ln 2). Of a fraction dl is rounded once more.
            let scaled = f64::from(table.scaled(fraction));
            let rate = (-25f64).exp2() + if fraction == WHOLE { 2.5 } else { 3.0 } / scaled;
            let arithmetic = 44.4 + 5.5 + 2_147_483_648.0 / std::f64::consts::E * rate;
            prop_assert!((a - exact).abs() <= arithmetic + 1.1 * unit, "{front} {back} {l}: {a} {exact} {arithmetic} {unit}");
            for channel in 0..3 {
                let mean = over(&lists[channel + 1]) / over(&lists[0]);
                if a > 0.0 && mean.is_finite() {
                    let light = a * (f64::from(c[channel]) / 2_147_483_648.0);
                    // The divisor is truncated to V of 27 bits and its reciprocal is up to 1 too large: V / 2^52 + 1 / V is 80 of
                    // 2^-31 at most; the product is truncated.
                    prop_assert!((light - a * mean).abs() <= 81.0 + 2.2 * a / over(&lists[0]), "{front} {back}: {light} {}", a * mean);
                }
            }
            let scaled = table.scaled(fraction);
            let small = [table.opacity_by::<_, Small>(Wide, ends[0], ends[1], scaled), table.opacity_by::<_, i32>(Wide, ends[0], ends[1], scaled)];
            prop_assert_eq!(small[0], small[1]);
            prop_assert_eq!(table.colour_by::<_, Small>(Wide, ends[0], ends[1]), c);
            let [low, high] = [front.min(back).floor() as u16, front.max(back).ceil() as u16];
            if !Classifier::<Wide>::support(&table).meets(RowRange { low, high }) {
                prop_assert_eq!(a, 0.0);
            }
        }
    }

    /// Rows of a small machine, which go another way: every segment as the definition has it, at both ends of the codes too.
    #[test]
    fn rows_of_a_small_machine_have_the_same_bits(
        (lists, exponent) in prop_oneof![random(0), random(2), random(4)],
        l in prop_oneof![0.0625..2.0f64, 2.0..3000.0],
        one in any::<bool>(),
        fraction in prop_oneof![Just(WHOLE), 1..=WHOLE],
        mut ends in prop::collection::vec((0i32..=4095 << 15, -18.0..27.0f64, any::<bool>()), 300),
    ) {
        let grain = (4096usize / (lists[0].len() - 1)).ilog2();
        let mut table = table(&lists, exponent, grain, l);
        if one {
            table.colours = Colours::One([1 << 31, 12_345_678, 0]);
        }
        let top = 4095 << 15;
        ends.extend([(top, -18.0, true), (top, 1.0, false), (top, 16.0, false), (0, -18.0, true), (0, 27.0, true)]);
        for n in 0..40 {
            ends.push((top - (n << 13), 14.0, n % 2 == 0));
        }
        let front: Vec<i32> = ends.iter().map(|end| end.0).collect();
        let back: Vec<i32> = (ends.iter())
            .map(|(front, away, up)| {
                let away = away.exp2() as i32;
                (if *up { front + away } else { front - away }).clamp(0, top)
            })
            .collect();
        small_rows_are_the_definition(Wide, &table, &front, &back, fraction)?;
        let [front, back] = [front, back].map(|row| row.iter().map(|s| s >> 3).collect::<Vec<_>>());
        small_rows_are_the_definition(Compact, &table, &front, &back, fraction)?;
    }

    /// Equal samples: 1 - e^-x of the linear look-up of the bins' means; and no jump where segments begin to be wider.
    #[test]
    fn equal_samples_are_points((lists, exponent) in random(0), s in 1.0..4094.0f64) {
        let table = table(&lists, exponent, 0, 1.0);
        let s = f64::from(sample(s)) / 32768.0;
        let bin = |n: usize| f64::from(lists[0][n + 1] - lists[0][n]) / f64::from(exponent).exp2();
        let n = s as usize;
        let tau = bin(n) + (bin(n + 1) - bin(n)) * (s - n as f64);
        let exact = -(-tau).exp_m1();
        let found = opacity(&table, s, s);
        let unit = f64::from(-(exponent as i32)).exp2();
        prop_assert!((found - exact).abs() < 310.0 / 2_147_483_648.0 + unit, "{found} {exact}");
        let [less, more] = [1.0 - 1.0 / 32768.0, 1.0].map(|d| opacity(&table, s - 0.5, s - 0.5 + d));
        prop_assert!((less - more).abs() < 2e-4, "{less} {more}");
    }
}

/// The length that a plan's own numbers have, in f64.
fn measured(plan: &Plan) -> f64 {
    let sides = plan.step().into_iter().zip(plan.spacing());
    let square = |side: f64| side * side;
    sides
        .map(|(step, factor)| square(step.to_bits() as f64 / 4_294_967_296.0 * 32_768.0 / f64::from(factor.to_bits())))
        .sum::<f64>()
        .sqrt()
}

fn value(length: Length) -> f64 {
    f64::from(length.scaled) / f64::from(length.bits).exp2() / std::f64::consts::LOG2_E
}

proptest! {
    #[test]
    fn a_plan_has_its_segments_length(
        direction in prop::array::uniform3(-(1i64 << 58)..=1 << 58),
        factors in prop::array::uniform3(1u16..=32_768),
        planes_per_voxel in 1u32..=16,
    ) {
        let Ok(view) = View::new(direction.map(Direction::from_bits)) else { return Ok(()) };
        let sampling = Sampling { planes_per_voxel, rays_per_voxel: 1 };
        let spacing = Spacing(factors.map(Intensity::from_bits));
        let plan = Plan::whole(view, [4, 5, 6], spacing, sampling).unwrap();
        let (length, exact) = (Length::of(&plan), measured(&plan));
        prop_assert!((value(length) / exact - 1.0).abs() < 1.5e-9 + 1.0 / f64::from(length.scaled), "{length:?} {exact}");
        prop_assert!(length.bits == 27 || length.scaled > 1 << 31);
    }
}

/// Straight on and along the diagonal of a cube.
#[test]
fn lengths_of_simple_views() {
    for (direction, exact) in [
        ([0, 0, 1], 1.0),
        ([0, -1, 0], 1.0),
        ([1, 1, 1], 3f64.sqrt()),
        ([1, 0, -1], 2f64.sqrt()),
    ] {
        let view = View::new(direction.map(|c: i64| Direction::from_bits(c << 58))).unwrap();
        let plan = Plan::whole(view, [9; 3], Spacing::CUBIC, Sampling::default()).unwrap();
        let length = Length::of(&plan);
        assert_eq!(length.bits, 27);
        assert!((value(length) - exact).abs() < 5e-9, "{} {exact}", value(length));
    }
}
