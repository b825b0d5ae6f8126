use std::vec::Vec;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::fold::{Given, Offsets, fold_row, folded, taken};
use super::light::{one_lane, root};
use super::sample::lerp;
use super::table::{fill_colours, fill_roots, root_of};
use super::{FastPhong, RootTable};
use crate::classify::{Linear, PointTable, Sqrt16, entry, opacity_of_root};
use crate::composite::{BackToFront, Colours, FrontToBack, Order, Pixel, PixelRow};
use crate::format::{Coefficient, Vector};
use crate::lanes::Small;
use crate::lanes::two::Two;
use crate::shade::{Highlight, Light};
use crate::table::ENTRIES;

fn config(seed: u64) -> ProptestConfig {
    ProptestConfig {
        cases: 4000,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// All upper halves of squared lengths.
#[test]
fn reciprocal_roots_are_near() {
    let (mut largest, mut sum) = (0f64, 0f64);
    for h in 16384..=65535u16 {
        assert_eq!(one_lane::root(u32::from(h)), u32::from(root(h)));
        let error = f64::from(root(h)) - 8388608.0 / f64::from(h).sqrt();
        largest = largest.max(error.abs());
        sum += error;
    }
    let mean = sum / 49152.0;
    assert!(largest <= 2.1 && mean.abs() <= 0.04, "{largest} {mean}");
}

#[test]
fn roots_come_back() {
    for root in 0..=65535 {
        assert_eq!(root_of(opacity_of_root(root)), root);
    }
    assert_eq!(root_of(crate::format::Opacity::ONE), 65535);
}

proptest! {
    #![proptest_config(config(1))]

    #[test]
    fn samples_lie_between(a in 0u16..=32760, b in 0u16..=32760, w in 0u16..=32767) {
        let between = lerp(a, b, w);
        prop_assert!(a.min(b) <= between && between <= a.max(b));
        let exact = f64::from(a) + (f64::from(b) - f64::from(a)) * f64::from(w) / 32768.0;
        prop_assert!((f64::from(between) - exact).abs() <= 0.5);
    }

    #[test]
    fn light_is_neither_made_nor_lost(
        c in prop::array::uniform3(0u16..=65535), colour in prop::array::uniform3(0u16..=65535),
        t in 0u16..=65535, q in prop_oneof![any::<u16>(), 0u16..300, 65530u16..=65535], k in any::<u32>(),
    ) {
        let offsets = Offsets::of_plane(k);
        // A pixel that front to back may be: it has given what it has taken.
        let before = Pixel { colour: c.map(|c| c.min(65535 - t)), transparency: t };
        let after = folded::<FrontToBack>(before, colour, q, offsets, 1);
        prop_assert!(after.transparency <= t);
        for (channel, before) in after.colour.iter().zip(before.colour) {
            prop_assert!(*channel >= before && u32::from(*channel) + u32::from(after.transparency) <= 65535);
        }
        if q == 0 || t == 0 {
            prop_assert_eq!(after, before);
        }
        let exact = f64::from(t) * (1.0 - (f64::from(q) / 65536.0).powi(2));
        prop_assert!((f64::from(after.transparency) - exact).abs() <= 1.5);
        let after = folded::<BackToFront>(Pixel { colour: c, transparency: t }, colour, q, offsets, 1);
        for ((channel, before), colour) in after.colour.iter().zip(c).zip(colour) {
            prop_assert!(*channel >= before.min(colour) && *channel <= before.max(colour));
        }
        if q == 0 {
            prop_assert_eq!(after, Pixel { colour: c, transparency: t });
        }
    }

    #[test]
    fn samples_take_no_more_than_there_is(t in 0u16..=65535, q in 0u16..=65535, k in any::<u32>()) {
        prop_assert!(taken(t, q, Offsets::of_plane(k)) <= t);
    }

    /// Of any gradient, against f64: a weak one has as good a direction as its components.
    #[test]
    fn light_is_that_of_the_definition(
        g in prop::array::uniform3(-32767i16..=32767), shift in 0u32..12,
        l in prop::array::uniform3(-1f64..1.0), v in prop::array::uniform3(-1f64..1.0),
        half in any::<bool>(), n in 0u32..=8, colour in prop::array::uniform3(0u16..=65535),
    ) {
        let g = g.map(|c| c >> shift);
        let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let unit = |v: [f64; 3]| v.map(|c| c / length(v));
        prop_assume!(length(l) > 0.1 && length(v) > 0.1 && g != [0; 3]);
        let (l, v) = (unit(l), unit(v));
        let h = [0, 1, 2].map(|axis| l[axis] + v[axis]);
        prop_assume!(length(h) > 0.1);
        let h = unit(h);
        let bits = |v: [f64; 3]| v.map(|c| Vector::from_bits((c * 1073741824.0).round() as i32));
        let part = |c: f64| Coefficient::from_bits((c * 2147483648.0) as u32);
        let highlight = if half { Highlight::HalfVector } else { Highlight::Reflection };
        let light = Light { direction: bits(l), half: bits(h), diffuse: [part(0.5); 3], specular: [part(0.3), part(0.2), part(0.1)] };
        let phong = FastPhong::new([part(0.1); 3], &[light], bits(v), highlight, n).unwrap();
        let found = phong.shade(g, colour);

        let normal = unit(g.map(|c| -f64::from(c)));
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (nl, nv) = (dot(normal, l), dot(normal, v));
        let y = if half { dot(normal, h) } else { 2.0 * nl * nv - dot(v, l) };
        let lit = nl > 0.0 && (half || nv > 0.0);
        let y = if lit { y.clamp(0.0, 1.0).powi(1 << n) } else { 0.0 };
        for (channel, ks) in [0.3, 0.2, 0.1].into_iter().enumerate() {
            let exact = f64::from(colour[channel]) * (0.1 + 0.5 * nl.max(0.0)) + 65535.0 * ks * y;
            // A cosine errs by at most 8 of its last bits: 4 by the root, 1 by its product, 3 by the vector; a highlight by twice that
            // and 3, as many times as its exponent; products by 1 each.
            let allowed = 0.5 * 8.0 + 4.0 + ks * 19.0 * f64::from(1u32 << n);
            let near_edge = nl.abs().min(nv.abs()) < 1e-3;
            prop_assert!((f64::from(found[channel]) - exact.min(65535.0)).abs() <= allowed || near_edge, "{found:?} {exact} {channel}");
        }
    }
}

/// Folds samples as a row and one by one: pixels, colours and roots.
fn one_lane_folds<O: Order>(
    samples: &[([u16; 4], [u16; 3], u16)],
    one: Option<[u16; 3]>,
    k: u32,
    floor: u16,
) -> Result<(), TestCaseError> {
    let offsets = Offsets::of_plane(k);
    // Front to back a pixel has given what it has taken; back to front any may be.
    let pixel = |[r, g, b, t]: [u16; 4]| Pixel {
        colour: [r, g, b].map(|c| if O::BACK_TO_FRONT { c } else { c.min(65535 - t) }),
        transparency: t,
    };
    let pixels: Vec<Pixel<u16>> = samples.iter().map(|(of, ..)| pixel(*of)).collect();
    let channel = |c: usize| pixels.iter().map(|pixel| pixel.colour[c]).collect::<Vec<_>>();
    let [mut red, mut green, mut blue] = [0, 1, 2].map(channel);
    let mut transparency: Vec<u16> = pixels.iter().map(|pixel| pixel.transparency).collect();
    let roots: Vec<u16> = samples.iter().map(|(.., root)| *root).collect();
    let given = [0, 1, 2].map(|c| samples.iter().map(|(_, colour, _)| colour[c]).collect::<Vec<_>>());
    let mut row = PixelRow {
        colour: [&mut red, &mut green, &mut blue],
        transparency: &mut transparency,
    };
    let given = match one {
        Some(one) => Given::One(one),
        None => Given::Rows(given.each_ref().map(Vec::as_slice)),
    };
    fold_row::<O, u16>(&mut row, given, &roots, offsets, floor);
    for (at, (before, (_, colour, root))) in pixels.iter().zip(samples).enumerate() {
        let after = folded::<O>(*before, one.unwrap_or(*colour), *root, offsets, floor);
        let found = Pixel {
            colour: [red[at], green[at], blue[at]],
            transparency: transparency[at],
        };
        prop_assert_eq!(found, after, "sample {}", at);
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(2))]

    /// Code of its own for each kind of light, and lanes side by side, against the definition.
    #[test]
    fn rows_of_lanes_side_by_side_are_shaded_as_samples_are(
        g in prop::collection::vec(prop::array::uniform3(-32767i16..=32767), 0..8), away in prop::array::uniform3(-1f64..1.0),
        lights in 0usize..=3, grey in any::<bool>(), half in any::<bool>(), n in 0u32..=8,
        one in prop::option::of(prop::array::uniform3(0u32..=65535)), seed in any::<u16>(),
    ) {
        let length = away.iter().map(|c| c * c).sum::<f64>().sqrt();
        prop_assume!(length > 0.1);
        let unit = away.map(|c| Vector::from_bits((c / length * 1073741824.0).round() as i32));
        let viewer = [0, 0, -1].map(|c| Vector::from_bits(c << 30));
        let part = |c: u32| Coefficient::from_bits(c << 24);
        let specular = if grey { [part(30); 3] } else { [part(30), part(20), part(10)] };
        let light = Light { direction: unit, half: viewer, diffuse: [part(50); 3], specular };
        let highlight = if half { Highlight::HalfVector } else { Highlight::Reflection };
        let phong = FastPhong::new([part(12); 3], &std::vec![light; lights], viewer, highlight, n).unwrap();
        let component = |axis: usize| g.iter().map(|g| g[axis] as u16).collect::<Vec<_>>();
        let [x, y, z] = [0, 1, 2].map(component);
        let given = |channel: usize| (0..g.len()).map(|at| seed.wrapping_mul((7 * at + channel + 1) as u16)).collect::<Vec<_>>();
        let before = [0, 1, 2].map(given);
        for alone in [false, true] {
            let [mut red, mut green, mut blue] = before.clone();
            let mut colours = Colours { one, rows: [&mut red, &mut green, &mut blue] };
            if alone {
                phong.shade_row::<u16>([&x, &y, &z], &mut colours);
            } else {
                phong.shade_row::<Two<u16>>([&x, &y, &z], &mut colours);
            }
            for (at, g) in g.iter().enumerate() {
                let colour = [0, 1, 2].map(|channel| one.map_or(before[channel][at], |one| one[channel] as u16));
                prop_assert_eq!([red[at], green[at], blue[at]], phong.shade(*g, colour), "sample {}, alone {}", at, alone);
            }
        }
    }

    /// Rows of one lane against the definition, of one colour and of many, in both orders.
    #[test]
    fn rows_of_one_lane_are_folded_as_samples_are(
        samples in prop::collection::vec((any::<[u16; 4]>(), any::<[u16; 3]>(), prop_oneof![Just(0u16), any::<u16>()]), 0..6),
        one in prop::option::of(any::<[u16; 3]>()), k in any::<u32>(), floor in prop_oneof![Just(1u16), 1u16..9000],
    ) {
        one_lane_folds::<FrontToBack>(&samples, one, k, floor)?;
        one_lane_folds::<BackToFront>(&samples, one, k, floor)?;
    }
}

/// A table of ramps and steps in a caller's memory: linear between roots, as it was filled.
#[test]
fn tables_are_linear_between_codes() {
    let mut entries = [0; ENTRIES];
    let mut low = [0; ENTRIES];
    for (code, (entry_at, low)) in entries.iter_mut().zip(&mut low).enumerate() {
        let root = if code < 100 {
            0
        } else {
            ((code * 2_654_435_761) >> 7) as u16
        };
        let [high, rest] = root.to_be_bytes();
        *entry_at = entry([code as u8, (code >> 4) as u8, 200], high);
        *low = rest;
    }
    let points = PointTable::<Sqrt16, Linear>::new(&entries, &low);
    let (mut roots, mut colours) = ([0; ENTRIES], [[0; 4]; ENTRIES + 1]);
    fill_roots(&points, &mut roots);
    assert_eq!(fill_colours(&points, &mut colours), None);
    let table = RootTable::new(&roots, Err(&colours));
    for sample in 0..=32760u16 {
        let (code, f) = (usize::from(sample >> 3), f64::from(sample & 7) / 8.0);
        let next = (code + 1).min(ENTRIES - 1);
        let between = |a: u16, b: u16| f64::from(a) + (f64::from(b) - f64::from(a)) * f;
        let exact = between(points.code_root(code), points.code_root(next));
        assert!((f64::from(table.root(sample)) - exact).abs() < 1.0);
        let (a, b) = (points.code_colour(code), points.code_colour(next));
        for (channel, found) in table.colour(sample).into_iter().enumerate() {
            assert!((f64::from(found) - between(a[channel], b[channel])).abs() < 1.0);
        }
    }
    let samples: Vec<u16> = (0..700).map(|i| (i * 7919 % 32761) as u16).collect();
    let [mut red, mut green, mut blue] = [(); 3].map(|()| std::vec![0; samples.len()]);
    table.colour_row::<Small>(&samples, [&mut red, &mut green, &mut blue]);
    for (at, sample) in samples.iter().enumerate() {
        assert_eq!([red[at], green[at], blue[at]], table.colour(*sample));
    }
    let mut row = std::vec![0; samples.len()];
    table.root_row::<i32>(&samples, &mut row);
    for (sample, found) in samples.iter().zip(row) {
        assert_eq!(found, table.root(*sample));
    }
}
