use super::*;
use crate::format::{Coefficient, Vector};
use crate::normalise::Normal;
use crate::precision::{Compact, Paper, Wide};
use crate::shade::{Highlight, Light};
use proptest::prelude::*;
use std::vec::Vec;

fn vector(v: [f64; 3]) -> [Vector; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| Vector::from_bits((c / length * 1_073_741_824.0).round() as i32))
}

fn coefficient(k: f64) -> Coefficient {
    Coefficient::from_bits((k * 2_147_483_648.0).round() as u32)
}

/// Two lights, of one colour or of several, and an exponent of 2^n.
fn phong<P: Precision>(p: P, coloured: bool, n: u32) -> Phong<P> {
    let light = |direction: [f64; 3], colour: [f64; 3]| {
        let unit = vector(direction);
        let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [x, y, z] = direction.map(|c| c / length(direction));
        Light {
            direction: unit,
            half: vector([x, y, z - 1.0]),
            diffuse: colour.map(|c| coefficient(0.5 * c)),
            specular: colour.map(|c| coefficient(0.3 * c)),
        }
    };
    let colour = if coloured { [1.0, 0.6, 0.2] } else { [1.0; 3] };
    let lights = [light([0.3, -0.5, -0.8], colour), light([-0.7, 0.1, 0.2], [0.25; 3])];
    let viewer = vector([0.0, 0.0, -1.0]);
    let ambient = [coefficient(0.1); 3];
    Phong::new(p, ambient, &lights, viewer, Highlight::HalfVector, n).unwrap()
}

fn filled<P: Precision>(phong: &Phong<P>, side: u32, filter: Filter) -> Mapped<Vec<u32>, P> {
    let mut map = std::vec![0; entries(phong, side)];
    fill(phong, side, &mut map).unwrap();
    Mapped::new(phong, side, filter, map).unwrap()
}

/// White shaded by a map in full precision, and black: diffuse and specular light.
fn light<P: Precision>(mapped: &Mapped<Vec<u32>, P>, gradient: [i32; 3]) -> [f64; 2] {
    let deep = mapped.precision.formats().shading == Shading::Rounded31;
    let one = if deep { 1u32 << 31 } else { 1 << 15 };
    let of = |colour| f64::from(mapped.shade(gradient, [colour; 3])[0]) / f64::from(one);
    let specular = of(0);
    [of(one) - specular, specular]
}

#[test]
fn maps_of_other_sizes_are_refused() {
    let phong = phong(Compact, false, 5);
    assert_eq!(entries(&phong, 8), 1 + 6 * 64);
    assert_eq!(entries(&super::tests::phong(Compact, true, 5), 8), 3 * (1 + 6 * 64));
    let mut map = [7; 385];
    assert_eq!(fill(&phong, 1, &mut map), Err(MapError::Side { given: 1 }));
    assert_eq!(fill(&phong, 257, &mut map), Err(MapError::Side { given: 257 }));
    let wrong = MapError::Entries {
        needed: 1 + 6 * 49,
        given: 385,
    };
    assert_eq!(fill(&phong, 7, &mut map), Err(wrong));
    assert_eq!(map, [7; 385]);
    assert!(Mapped::new(&phong, 9, Filter::Nearest, map).is_err());
    assert_eq!(fill(&phong, 8, &mut map), Ok(()));
}

/// Where a gradient points at a node the map has Phong's own answer, to the entry's rounding.
fn held_at_nodes<P: Precision>(p: P, coloured: bool) {
    let (phong, side) = (phong(p, coloured, 4), 9);
    let one = 1u32 << p.pixel_colour_bits();
    for filter in [Filter::Nearest, Filter::Bilinear] {
        let mapped = filled(&phong, side, filter);
        for face in 0..6 {
            for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
                // 32764 is a multiple of 4: nodes are whole numbers, and so are their places.
                let major = if face & 1 == 1 { -32764 } else { 32764 };
                let (a, b) = (8191 * (a - 4), 8191 * (b - 4));
                let gradient = [[major, a, b], [a, major, b], [a, b, major]][face >> 1];
                let colour = [one, one >> 1, 0];
                let (found, exact) = (mapped.shade(gradient, colour), phong.shade(normalise(gradient), colour));
                for c in 0..3 {
                    let away = f64::from(found[c].abs_diff(exact[c])) / f64::from(one) * 32768.0;
                    assert!(away <= 5.0, "{} {filter:?} {gradient:?}: {found:?} {exact:?}", P::NAME);
                }
            }
        }
    }
}

trait ColourBits: Precision {
    fn pixel_colour_bits(self) -> u32 {
        if self.formats().shading == Shading::Rounded31 {
            31
        } else {
            15
        }
    }
}

impl<P: Precision> ColourBits for P {}

#[test]
fn nodes_are_phongs() {
    for coloured in [false, true] {
        held_at_nodes(Compact, coloured);
        held_at_nodes(Wide, coloured);
        held_at_nodes(Paper, coloured);
    }
}

#[test]
fn without_a_gradient_light_is_ambient() {
    for filter in [Filter::Nearest, Filter::Bilinear] {
        let phong = phong(Compact, true, 5);
        let mapped = filled(&phong, 16, filter);
        let colour = [32768, 20000, 1];
        assert_eq!(mapped.shade([0; 3], colour), phong.shade(Normal::default(), colour));
    }
}

/// Places are in the map for the ends of every length, and rise with the component.
#[test]
fn places_lie_in_the_map() {
    for m in (1 << 14)..(1 << 15) {
        let reciprocal = crate::reciprocal::reciprocal(m << 12);
        let q = |c: i32| (((c + m as i32) as u64 * u64::from(reciprocal)) >> 25) as u32;
        let m = m as i32;
        assert!(q(-m) == 0 && q(m) <= 1 << 16 && q(m) >= (1 << 16) - 1, "{m}");
        assert!((q(0) as i32 - (1 << 15)).abs() <= 1, "{m}");
        for c in [1 - m, -1, 1, m - 1, m / 3] {
            let exact = f64::from(c + m) / f64::from(m) * 32768.0;
            assert!((f64::from(q(c)) - exact).abs() <= 1.01, "{m} {c}");
            assert!(q(c) >= q(c - 1));
        }
    }
}

/// The answer in f64 between four nodes, of the map's own entries.
fn between(map: &[u32], side: u32, gradient: [i32; 3]) -> [f64; 2] {
    let [x, y, z] = block(gradient).map(f64::from);
    let (axis, [major, a, b]) = if x.abs() >= y.abs().max(z.abs()) {
        (0, [x, y, z])
    } else if y.abs() >= z.abs() {
        (1, [y, x, z])
    } else {
        (2, [z, x, y])
    };
    let face = 2 * axis + usize::from(major < 0.0);
    let last = f64::from(side - 1);
    let [u, v] = [a, b].map(|c| (c / major.abs() + 1.0) / 2.0 * last);
    let [i, j] = [u, v].map(|p| p.floor().min(last - 1.0));
    let at = |du: usize, dv: usize| {
        let side = side as usize;
        let entry = map[1 + (face * side + j as usize + dv) * side + i as usize + du];
        [entry & 0xffff, entry >> 16].map(|half| f64::from(half) / 32768.0)
    };
    let (wu, wv) = (u - i, v - j);
    [0, 1].map(|half| {
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)].map(|pair| pair[half]);
        (a + (b - a) * wu) * (1.0 - wv) + (c + (d - c) * wu) * wv
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, rng_seed: prop::test_runner::RngSeed::Fixed(21), failure_persistence: None, ..ProptestConfig::default() })]

    /// The arithmetic between nodes, and of the division, is right: half a unit of each of three mixtures, and a unit of the place
    /// times the slope, which is at most 1 a node.
    #[test]
    fn between_nodes_it_is_bilinear(g in prop::array::uniform3(-(1i32 << 27)..(1 << 27)), shift in 0u32..27, side in 2u32..65) {
        let gradient = g.map(|c| c >> shift);
        prop_assume!(gradient != [0; 3]);
        let phong = phong(Wide, false, 3);
        let mapped = filled(&phong, side, Filter::Bilinear);
        let (found, exact) = (light(&mapped, gradient), between(&mapped.map, side, gradient));
        let bound = (2.0 + 1.0 + f64::from(side)) / 32768.0;
        let [d, s] = exact;
        // White is held to 1.
        prop_assert!((found[0] - d.min(1.0 - s)).abs() <= bound, "{gradient:?} {found:?} {exact:?}");
        prop_assert!((found[1] - s).abs() <= bound, "{gradient:?} {found:?} {exact:?}");
    }

    /// Faces share their edges: the answer does not jump where the largest component changes.
    #[test]
    fn faces_meet(a in 1i32 << 20..1 << 24, b in -(1i32 << 24)..1 << 24, side in 2u32..33) {
        let b = b % a;
        let phong = phong(Wide, false, 3);
        let mapped = filled(&phong, side, Filter::Bilinear);
        let [here, there] = [[a, a - 64, b], [a - 64, a, b]].map(|gradient| light(&mapped, gradient));
        for half in 0..2 {
            prop_assert!((here[half] - there[half]).abs() < 0.004, "{here:?} {there:?}");
        }
    }

    #[test]
    fn rows_are_the_scalar(rows in prop::collection::vec(any::<[i16; 3]>(), 0..34), nearest in any::<bool>(), coloured in any::<bool>()) {
        let filter = if nearest { Filter::Nearest } else { Filter::Bilinear };
        let phong = phong(Compact, coloured, 5);
        let mapped = filled(&phong, 12, filter);
        let g = [0, 1, 2].map(|a| rows.iter().map(|v| i32::from(v[a])).collect::<Vec<_>>());
        let r = std::vec![0; rows.len()];
        let mut colours = [9000, 32768, 0].map(|c| std::vec![c; rows.len()]);
        let [x, y, z] = &g;
        let [red, green, blue] = &mut colours;
        let mut lent = Colours { one: None, rows: [red, green, blue] };
        mapped.shade_row::<i32>([x, y, z], &r, &mut lent);
        for (i, v) in rows.iter().enumerate() {
            let expected = mapped.shade(v.map(i32::from), [9000, 32768, 0]);
            prop_assert_eq!([0, 1, 2].map(|c| colours[c][i] as u32), expected);
        }
        // Block-normalised gradients have the same place: what an observer of normals leaves is shaded alike.
        for v in &rows {
            let gradient = v.map(i32::from);
            prop_assert_eq!(mapped.shade(gradient, [77; 3]), mapped.shade(block(gradient), [77; 3]));
        }
    }
}
