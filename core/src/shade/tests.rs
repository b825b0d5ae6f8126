//! Bounds of the three arithmetics against f64, rows against the definition, ends of ranges.

use super::*;
use crate::composite::Recurrence as _;
use crate::format::Cosine;
use crate::normalise::normalise;
use crate::precision::{Compact, Formats, NormalForm, Paper, Power, Wide};
use proptest::prelude::*;
use std::vec::Vec as StdVec;

fn unit(v: [f64; 3]) -> [Vector; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| Vector::from_num(c / length))
}

fn value(v: [Vector; 3]) -> [f64; 3] {
    v.map(Vector::to_num)
}

fn kept<P: Precision>(p: P, v: [i32; 3]) -> [f64; 3] {
    v.map(|c| f64::from(c) * 2f64.powi(-(p.formats().shading.vector_bits() as i32)))
}

fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Equation 10 in f64, on the pipeline's own inputs.
fn model<P: Precision>(phong: &Phong<P>, normal: Normal, colour: [u32; 3]) -> [f64; 3] {
    let p = phong.precision;
    let n = normal.g.map(|c| -f64::from(c) * f64::from(normal.r) / 2f64.powi(35));
    let viewer = kept(p, opposite(phong.away_from_viewer));
    let mut out = [0.0; 3];
    for (c, o) in out.iter_mut().enumerate() {
        let one = 2f64.powi(p.formats().shading.coefficient_bits() as i32);
        let k = |v: [u32; 3]| f64::from(v[c]) / one;
        let (mut diffuse, mut specular) = (k(phong.ambient), 0.0);
        for light in &phong.lights {
            let l = kept(p, opposite(light.away));
            let nl = dot64(n, l).clamp(0.0, 1.0);
            let base = match phong.highlight {
                Highlight::HalfVector => dot64(n, kept(p, opposite(light.away_from_half))),
                Highlight::Reflection => {
                    let nv = dot64(n, viewer).clamp(0.0, 1.0);
                    if nv > 0.0 {
                        2.0 * nv * nl - dot64(viewer, l)
                    } else {
                        0.0
                    }
                }
            };
            diffuse += k(light.diffuse) * nl;
            if nl > 0.0 {
                specular += k(light.specular) * base.clamp(0.0, 1.0).powi(1 << phong.exponent_log2);
            }
        }
        *o = (f64::from(colour[c]) / f64::from(p.pixel().colour_bits()).exp2() * diffuse.min(1.0) + specular).min(1.0);
    }
    out
}

/// Whole ones as well.
fn coefficient() -> impl Strategy<Value = u32> {
    prop_oneof![0u32..=1 << 31, Just(1 << 31)]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-1.0f64..1.0).prop_filter("a direction", |v| dot64(*v, *v) > 0.01)
}

/// The arguments of [`Phong::new`].
type Scene = ([Coefficient; 3], StdVec<Light>, [Vector; 3], Highlight, u32);

fn make<P: Precision>(p: P, (ambient, lights, viewer, highlight, exponent): &Scene) -> Phong<P> {
    Phong::new(p, *ambient, lights, *viewer, *highlight, *exponent).unwrap()
}

prop_compose! {
    fn scene(count: usize)(
        lights in prop::collection::vec((vector(), prop::array::uniform3(0.0f64..1.0)), 1..=count),
        viewer in vector(), exponent in 0u32..=8, reflection in any::<bool>(),
        shares in prop::array::uniform3(0.01f64..1.0),
    ) -> Scene {
        let sum: f64 = shares.iter().sum();
        let [ka, kd, ks] = shares.map(|s| s / sum);
        let each = 1.0 / lights.len() as f64;
        let scaled = |k: f64, i: [f64; 3]| i.map(|i| Coefficient::from_num(k * each * i));
        let viewer = unit(viewer);
        let lights: StdVec<Light> = lights.iter().map(|&(l, i)| {
            let (l, v) = (value(unit(l)), value(viewer));
            let half = [l[0] + v[0], l[1] + v[1], l[2] + v[2]];
            Light {
                direction: unit(l),
                half: if dot64(half, half) > 1e-6 { unit(half) } else { unit(l) },
                diffuse: scaled(kd, i),
                specular: scaled(ks, i),
            }
        }).collect();
        let highlight = if reflection { Highlight::Reflection } else { Highlight::HalfVector };
        ([Coefficient::from_num(ka); 3], lights, viewer, highlight, exponent)
    }
}

type Sample = (Normal, [u32; 3]);

fn sample() -> impl Strategy<Value = Sample> {
    let gradient = prop::array::uniform3(-100_000i32..100_000);
    let colour = prop::array::uniform3(0u32..=32768);
    (gradient.prop_map(normalise), colour)
}

proptest! {
    #[test]
    fn shading_is_within_its_bound(scene in scene(8), (normal, colour) in sample()) {
        within(&make(Compact, &scene), normal, colour, 1.0)?;
        let exponent = f64::from(scene.4).exp2();
        within(&make(Wide, &scene), normal, colour.map(|c| c << 16), 2.0 + 2.0 * 8.0 + 4.25 * exponent)?;
    }

    /// Normals around the middle of a highlight of exponent 256, where errors of the cosine count most and random
    /// normals hardly ever lie.
    #[test]
    fn highlights_are_within_their_bound(g in prop::array::uniform2(-1500i32..1500), depth in 16_384i32..30_000) {
        let towards = unit([0.02, -0.01, -1.0]);
        let light = Light {
            direction: towards,
            half: towards,
            diffuse: [Coefficient::ZERO; 3],
            specular: [Coefficient::ONE; 3],
        };
        let scene = ([Coefficient::ZERO; 3], std::vec![light], towards, Highlight::HalfVector, 8);
        let normal = normalise([g[0], g[1], depth]);
        within(&make(Compact, &scene), normal, [0; 3], 1.0)?;
        within(&make(Wide, &scene), normal, [0; 3], 4.0 + 4.25 * 256.0)?;
    }

    #[test]
    fn powers_are_rounded_squares(x in prop_oneof![0u32..=1 << 31, (1 << 31) - 9..=1u32 << 31], n in 0u32..=8) {
        let squared = (0..n).fold(u64::from(x), |x, _| (x * x + (1 << 30)) >> 31);
        prop_assert_eq!(u64::from(power(Compact, Cosine::from_bits(x), n).to_bits()), squared);
    }

    /// Vectors of any length, too: a product beyond 1 is 1.
    #[test]
    fn dots_are_rounded_and_clamped(g in prop::array::uniform3(-32767i32..=32767), v in prop::array::uniform3(-32768i32..=32768)) {
        let normal = normalise(g);
        let sum: i64 = normal.g.iter().zip(v).map(|(g, l)| -i64::from(*g) * i64::from(l)).sum();
        prop_assume!(i32::try_from(sum).is_ok());
        let exact = (sum.max(0) * i64::from(normal.r) + (1 << 18)) >> 19;
        prop_assert_eq!(i64::from(dot(Compact, normal, v).to_bits()), exact.min(1 << 31));
        let fine: i64 = sum.max(0) << 15;
        let exact = (((fine + (1 << 8)) >> 9) * i64::from(normal.r) + (1 << 24)) >> 25;
        prop_assert_eq!(i64::from(dot(Wide, normal, v.map(|c| c << 15)).to_bits()), exact.min(1 << 31));
    }

    /// 2 (N.V)(N.L) - V.L, V.L with as many bits as there are of it.
    #[test]
    fn reflections_are_rounded_and_clamped(
        [nv, nl] in [0u32..=1 << 31, 0u32..=1 << 31], viewer in vector(), light in vector(),
    ) {
        let product = i128::from(nv) * i128::from(nl);
        let cosines = [nv, nl].map(Cosine::from_bits);
        let expected = |rounded: i128| if product == 0 { 0 } else { rounded.clamp(0, 1 << 31) };
        // Beyond 2 there are no unit vectors, and no bits.
        prop_assume!(product >> 30 < 1 << 32);
        let along = |v: [i32; 3], l: [i32; 3]| v.iter().zip(l).map(|(v, l)| i128::from(*v) * i128::from(l)).sum::<i128>();
        let [v, l] = [viewer, light].map(|v| keep_vector(Compact, unit(v)));
        let rounded = (product - (along(v, l) << 31) + (1 << 29)) >> 30;
        prop_assume!(rounded < 1 << 32);
        let [a, b] = cosines;
        prop_assert_eq!(i128::from(reflected(Compact, a, b, v, l).to_bits()), expected(rounded));
        let [v, l] = [viewer, light].map(|v| keep_vector(Wide, unit(v)));
        let rounded = (product - (along(v, l) >> 29 << 30) + (1 << 29)) >> 30;
        prop_assume!(rounded < 1 << 32);
        let [a, b] = cosines;
        prop_assert_eq!(i128::from(reflected(Wide, a, b, v, l).to_bits()), expected(rounded));
    }

    #[test]
    fn sums_of_lights_are_clamped(
        c in prop_oneof![0u32..=1 << 15, Just(1 << 15)], ambient in coefficient(), lights in prop_oneof![0usize..=8, Just(1)],
        k in [coefficient(), coefficient()], out in any::<bool>(),
    ) {
        // The light and the eye straight ahead of the surface, or behind it: x and y are 1 or 0.
        let ahead = unit([0.0, 0.0, -1.0]);
        let [kd, ks] = k.map(Coefficient::from_bits);
        let light = Light { direction: ahead, half: ahead, diffuse: [kd; 3], specular: [ks; 3] };
        let ambient = Coefficient::from_bits(ambient);
        let phong =
            Phong::new(Compact, [ambient; 3], &std::vec![light; lights], ahead, Highlight::HalfVector, 0).unwrap();
        let normal = Normal { g: [0, 0, if out { -1 } else { 1 } << 14], r: 1 << 21 };
        let x = if out { 0 } else { 1u64 << 16 };
        let [diffuse, specular] = [kd, ks].map(|k| lights as u64 * u64::from(keep(Compact, k)) * x);
        let m = (((u64::from(keep(Compact, ambient)) << 16) + diffuse + (1 << 14)) >> 15).min(1 << 16);
        let expected = ((u64::from(c) * m + specular + (1 << 15)) >> 16).min(1 << 15);
        prop_assert_eq!(phong.shade(normal, [c; 3]).map(u64::from), [expected; 3]);
    }

    #[test]
    fn rows_are_the_scalar(scene in scene(3), samples in prop::collection::vec(sample(), 0..34)) {
        let phong = make(Paper, &scene);
        let column = |f: &dyn Fn(&Sample) -> i32| samples.iter().map(f).collect::<StdVec<_>>();
        let g = [0, 1, 2].map(|a| column(&|s| s.0.g[a]));
        let r = column(&|s| s.0.r as i32);
        let mut c = [0, 1, 2].map(|a| column(&|s| s.1[a] as i32));
        let [cr, cg, cb] = &mut c;
        Shader::<Paper>::shade_row::<i32>(&phong, [&g[0], &g[1], &g[2]], &r, &mut Colours { one: None, rows: [cr, cg, cb] });
        for (i, (normal, colour)) in samples.iter().enumerate() {
            let out = phong.shade(*normal, *colour).map(|c| c as i32);
            prop_assert_eq!([c[0][i], c[1][i], c[2][i]], out);
        }
    }

    #[test]
    fn one_colour_needs_no_rows(scene in scene(2), samples in prop::collection::vec(sample(), 1..20)) {
        let phong = make(Compact, &scene);
        let g = [0, 1, 2].map(|a| samples.iter().map(|s| s.0.g[a]).collect::<StdVec<_>>());
        let r = samples.iter().map(|s| s.0.r as i32).collect::<StdVec<_>>();
        let one = samples[0].1;
        let mut found = [0; 3].map(|c| std::vec![c; r.len()]);
        let [red, green, blue] = &mut found;
        Shader::<Compact>::shade_row::<i32>(&phong, [&g[0], &g[1], &g[2]], &r, &mut Colours { one: Some(one), rows: [red, green, blue] });
        for (i, (normal, _)) in samples.iter().enumerate() {
            let expected = phong.shade(*normal, one).map(|c| c as i32);
            prop_assert_eq!([found[0][i], found[1][i], found[2][i]], expected);
        }
    }
}

fn within<P: Precision>(phong: &Phong<P>, normal: Normal, colour: [u32; 3], bound: f64) -> Result<(), TestCaseError> {
    let p = phong.precision;
    // A dot product that rounds to 0 takes its highlight with it; the model's threshold is exact.
    let grazing = phong
        .lights
        .iter()
        .any(|l| dot(p, normal, opposite(l.away)).to_bits() < 4)
        || dot(p, normal, opposite(phong.away_from_viewer)).to_bits() < 4;
    if grazing && phong.exponent_log2 < 6 {
        return Ok(());
    }
    let exact = model(phong, normal, colour);
    for (got, exact) in phong.shade(normal, colour).iter().zip(exact) {
        let error = f64::from(*got) - exact * f64::from(p.pixel().colour_bits()).exp2();
        prop_assert!(error.abs() <= bound + 1e-3, "{error}");
    }
    Ok(())
}

#[test]
fn lattice_vectors_have_the_right_length() {
    let mut worst: f64 = 0.0;
    for n in 0..2000 {
        let (a, b) = (f64::from(n) * 0.7, f64::from(n) * 0.31);
        let v = [a.sin() * b.cos(), a.cos() * b.cos(), b.sin()];
        let u = kept(Compact, keep_vector(Compact, unit(v)));
        let length = dot64(u, u).sqrt();
        worst = worst.max((length - 1.0).abs());
        assert!(dot64(u, v) > 0.99999999 * length, "{v:?} {u:?}");
        let w = kept(Wide, keep_vector(Wide, unit(v)));
        assert!((dot64(w, w).sqrt() - 1.0).abs() < 2e-9);
    }
    assert!(worst < 1.5e-5, "{worst}");
    assert_eq!(keep_vector(Compact, unit([0.0, -3.0, 0.0])), [0, -32768, 0]);
}

#[test]
fn one_stays_one_and_zero_stays_zero() {
    for n in 0..=8 {
        assert_eq!(power(Compact, Cosine::ONE, n), Cosine::ONE);
        assert_eq!(power(Paper, Cosine::ONE, n), Cosine::ONE);
        assert_eq!(power(Compact, Cosine::ZERO, n), Cosine::ZERO);
    }
}

/// A precision of a study: nearest normals of so many bits, and the parabola.
#[derive(Clone, Copy, Debug)]
struct Study(u32);

impl Precision for Study {
    type Pixel = crate::composite::Truncating15;
    const NAME: &'static str = "study";

    fn formats(self) -> Formats {
        Formats {
            normal: NormalForm::Nearest(self.0),
            power: Power::Parabola,
            ..Compact.formats()
        }
    }

    fn pixel(self) -> Self::Pixel {
        crate::composite::Truncating15
    }
}

/// The dot product's bound, in units of the normal's last place.
fn nearest_dot(bits: u32, normal: Normal, vector: [f64; 3]) -> f64 {
    let study = Study(bits);
    let kept_vector = keep_vector(study, unit(vector));
    let got = dot(study, normal, kept_vector).to_num::<f64>();
    let n = normal.g.map(|c| -f64::from(c) * f64::from(normal.r) / 2f64.powi(35));
    let exact = dot64(n, kept(study, kept_vector)).clamp(0.0, 1.0);
    (got - exact).abs() * f64::from(1 << bits)
}

proptest! {
    #[test]
    fn nearest_normals_are_within_half_a_unit((normal, _) in sample(), v in vector()) {
        // Three components of half a unit each, weighted by a unit vector: sqrt(3) / 2.
        for error in [nearest_dot(4, normal, v), nearest_dot(10, normal, v), nearest_dot(15, normal, v)] {
            prop_assert!(error <= 0.867, "{error}");
        }
        let mirrored = Normal { g: normal.g.map(|c| -c), ..normal };
        prop_assert_eq!(formed_nearest(mirrored.g, mirrored.r as i32, 9), formed_nearest(normal.g, normal.r as i32, 9).map(|c| -c));
    }

    #[test]
    fn rows_of_a_study_are_the_scalar(scene in scene(3), samples in prop::collection::vec(sample(), 0..34)) {
        let phong = make(Study(6), &scene);
        let column = |f: &dyn Fn(&Sample) -> i32| samples.iter().map(f).collect::<StdVec<_>>();
        let g = [0, 1, 2].map(|a| column(&|s| s.0.g[a]));
        let r = column(&|s| s.0.r as i32);
        let mut c = [0, 1, 2].map(|a| column(&|s| s.1[a] as i32));
        let [cr, cg, cb] = &mut c;
        Shader::<Study>::shade_row::<i32>(&phong, [&g[0], &g[1], &g[2]], &r, &mut Colours { one: None, rows: [cr, cg, cb] });
        for (i, (normal, colour)) in samples.iter().enumerate() {
            let out = phong.shade(*normal, *colour).map(|c| c as i32);
            prop_assert_eq!([c[0][i], c[1][i], c[2][i]], out);
        }
    }
}

#[test]
fn the_parabola_has_its_top_and_its_foot_where_it_should() {
    let at = |x: f64, n: u32| power(Study(15), Cosine::from_num(x), n).to_num::<f64>();
    for n in 0..=8 {
        let slope = (f64::from(n).exp2() + 1.0) / 2.0;
        assert_eq!(at(1.0, n), 1.0);
        for x in [0.0, 0.5, 1.0 - 0.5 / slope, 1.0 - 1.0 / slope, 0.99] {
            let exact = (1.0 - (1.0 - x) * slope).max(0.0);
            assert!((at(x, n) - exact).abs() < 1e-6, "{x} {n}");
        }
    }
}

#[test]
fn no_gradient_means_ambient_light_only() {
    let light = Light {
        direction: unit([0.0, 0.0, -1.0]),
        half: unit([0.0, 0.0, -1.0]),
        diffuse: [Coefficient::from_num(0.5); 3],
        specular: [Coefficient::from_num(0.25); 3],
    };
    let viewer = unit([0.0, 0.0, -1.0]);
    let ambient = [Coefficient::from_num(0.25); 3];
    let white = [1 << 15; 3];
    let compact = Phong::new(Compact, ambient, &[light], viewer, Highlight::Reflection, 5).unwrap();
    assert_eq!(compact.shade(Normal::default(), white), [1 << 13; 3]);
    // Facing the light: everything.
    assert_eq!(compact.shade(normalise([0, 0, 9]), white), white);
    let wide = Phong::new(Wide, ambient, &[light], viewer, Highlight::HalfVector, 8).unwrap();
    let white = [1 << 31; 3];
    assert_eq!(wide.shade(Normal::default(), white), [1 << 29; 3]);
    // The reciprocal length is a floor, within 2^-19; the exponent multiplies that.
    let [lit, ..] = wide.shade(normalise([0, 0, 9]), white);
    assert!(((1 << 31) - (1 << 18)..=1 << 31).contains(&lit), "{lit}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let light = Light {
        direction: unit([0.0, 0.0, 1.0]),
        half: unit([0.0, 0.0, 1.0]),
        diffuse: [Coefficient::ONE; 3],
        specular: [Coefficient::ZERO; 3],
    };
    let one = Coefficient::ONE.to_bits();
    let make = |lights: &[Light], ambient: u32, exponent| {
        let ambient = [Coefficient::from_bits(ambient); 3];
        Phong::new(
            Compact,
            ambient,
            lights,
            unit([0.0, 0.0, 1.0]),
            Highlight::HalfVector,
            exponent,
        )
        .err()
    };
    assert_eq!(make(&[light; 9], 0, 0), Some(PhongError::Lights { given: 9 }));
    assert_eq!(make(&[light], 0, 9), Some(PhongError::Exponent { given: 9 }));
    assert_eq!(
        make(&[light], one + 1, 0),
        Some(PhongError::Coefficient { bits: one + 1 })
    );
    let long = Light {
        half: [-Vector::ONE - Vector::DELTA, Vector::ZERO, Vector::ZERO],
        ..light
    };
    assert_eq!(make(&[long], 0, 0), Some(PhongError::Vector { bits: -(1 << 30) - 1 }));
    assert_eq!(make(&[light; 8], one, 8), None);
}

/// What a precision keeps, given back to it, makes the same shader, also where the search from a kept vector would go on to
/// another.
fn given_back<P: Precision>(p: P, scene: &Scene) {
    let (ambient, lights, viewer, highlight, exponent_log2) = scene;
    let lights: StdVec<_> = lights.iter().map(|light| KeptLight::of(p, light)).collect();
    let ambient = ambient.map(|c| keep(p, c));
    let back = Phong::of_kept(p, ambient, &lights, keep_vector(p, *viewer), *highlight, *exponent_log2);
    assert_eq!(
        std::format!("{:?}", back.unwrap()),
        std::format!("{:?}", make(p, scene))
    );
}

proptest! {
    #[test]
    fn kept_values_make_the_same_shader(scene in scene(3)) {
        given_back(Paper, &scene);
        given_back(Compact, &scene);
        given_back(Wide, &scene);
    }
}

#[test]
fn kept_values_out_of_range_are_named() {
    let light = KeptLight {
        direction: [-32768, 0, 32768],
        half: [0; 3],
        diffuse: [32768; 3],
        specular: [0; 3],
    };
    let made = |lights: &[KeptLight], ambient, viewer, exponent_log2| {
        Phong::of_kept(
            Compact,
            [ambient; 3],
            lights,
            [viewer, 0, 0],
            Highlight::Reflection,
            exponent_log2,
        )
        .err()
    };
    assert_eq!(made(&[light; 8], 32768, -32768, 8), None);
    assert_eq!(made(&[light; 9], 0, 0, 0), Some(PhongError::Lights { given: 9 }));
    assert_eq!(made(&[], 0, 0, 9), Some(PhongError::Exponent { given: 9 }));
    let vector = |given| Some(PhongError::KeptVector { given, one: 32768 });
    assert_eq!(made(&[], 0, i32::MIN, 0), vector(i32::MIN));
    let long = KeptLight {
        half: [0, 32769, 0],
        ..light
    };
    assert_eq!(made(&[light, long], 0, 0, 0), vector(32769));
    let coefficient = Some(PhongError::KeptCoefficient {
        given: 32769,
        one: 32768,
    });
    assert_eq!(made(&[], 32769, 0, 0), coefficient);
}
