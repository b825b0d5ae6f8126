//! Overflow: the ends of every range, stage by stage and through the whole pipeline.
//!
//! Core adds, subtracts and multiplies with operators where a result fits, and those are checked in debug builds: the
//! reduced form of this file, run as a test, ends with a panic where one does not. What is counted here besides are
//! results outside the range that the contract states.

use slicecast::composite::{Channel as _, Dither, Pixel, Recurrence};
use slicecast::format::{Coefficient, Cosine, Intensity, Opacity, Vector, Weight};
use slicecast::gradient::{coarsen, space};
use slicecast::interpolate::trilinear;
use slicecast::normalise::{normalise, unit};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Highlight, Light, Phong, dot, keep_vector, power, reflected};

use super::scenes::{compared, scene, volume};
use super::{Case, Size};
use crate::channels::Scale::{Binary, Carrying, Full};
use crate::pixels::Arithmetic::{Product, Telescoping};
use crate::pixels::StudyPixel;
use slicecast_scene::{PrecisionName, View};

/// Values tried and values out of range.
#[derive(Clone, Copy, Default)]
struct Tally {
    tried: u64,
    wrong: u64,
}

impl Tally {
    fn check(&mut self, right: bool) {
        self.tried += 1;
        self.wrong += u64::from(!right);
    }
}

/// All 256 cells of corners 0 and 4095 (or, where gradients look beyond an edge, -4095 and 8190), at extreme weights.
fn interpolation<P: Precision>(p: P, tally: &mut Tally) {
    let weights = [0u32, 1, 32767, 32768, 65535].map(Weight::from_bits);
    for (low, high) in [(0i16, 4095i16), (-4095, 8190)] {
        for corners in 0u32..256 {
            let voxel = |z: u32, y: u32, x: u32| {
                if corners >> (4 * z + 2 * y + x) & 1 == 1 {
                    high
                } else {
                    low
                }
            };
            let voxels = [0, 1].map(|z| [0, 1].map(|y| [0, 1].map(|x| voxel(z, y, x))));
            for x in weights {
                for y in weights {
                    for z in weights {
                        let sample = trilinear(p, voxels, [x, y, z]);
                        let range =
                            i32::from(low) << p.formats().sample_bits..=i32::from(high) << p.formats().sample_bits;
                        tally.check(range.contains(&sample));
                    }
                }
            }
        }
    }
}

/// Gradients at the ends of their range, and of every length.
fn gradients() -> Vec<[i32; 3]> {
    let limit = 8190 << 15;
    let mut values = vec![0, 1, -1, limit, -limit, limit - 1, 32767, -32768, 32769];
    values.extend((0..29).map(|shift| 1 << shift));
    let mut all = Vec::new();
    for x in &values {
        for y in &values {
            all.extend([0, 1, limit, -limit, 12345].map(|z| [*x, *y, z]));
        }
    }
    all
}

fn normals(tally: &mut Tally) {
    for gradient in gradients() {
        for factor in [1u16, 16384, 32768] {
            let spaced = gradient.map(|g| space(g, Intensity::from_bits(factor)));
            for bits in [4, 15] {
                let normal = normalise(coarsen(spaced, bits));
                tally.check(normal.g.iter().all(|g| g.abs() <= 32767) && (normal.r == 0 || normal.r >= 605_414));
                tally.check(unit(normal).iter().all(|c| c.to_bits().abs() <= 32768));
            }
        }
    }
}

/// Eight lights of everything, from and towards everywhere.
fn shading<P: Precision>(p: P, tally: &mut Tally) {
    let one = Vector::ONE;
    let root = Vector::from_num(3f64.sqrt().recip());
    let zero = Vector::ZERO;
    let directions = [
        [zero, zero, -one],
        [one, zero, zero],
        [root; 3],
        [-root; 3],
        [zero, -one, zero],
    ];
    let top = 1u32 << p.pixel().colour_bits();
    for direction in directions {
        let light = Light {
            direction,
            half: direction,
            diffuse: [Coefficient::ONE; 3],
            specular: [Coefficient::ONE; 3],
        };
        let kept = keep_vector(p, direction);
        for highlight in [Highlight::Reflection, Highlight::HalfVector] {
            for exponent in [0, 8] {
                let phong = Phong::new(p, [Coefficient::ONE; 3], &[light; 8], direction, highlight, exponent);
                tally.check(phong.is_ok());
                let Ok(phong) = phong else { continue };
                for gradient in gradients().into_iter().step_by(7) {
                    let normal = normalise(gradient);
                    let cosine = dot(p, normal, kept);
                    let mirrored = reflected(p, cosine, cosine, kept, kept);
                    let powers = [cosine, mirrored, Cosine::ONE, Cosine::ZERO].map(|c| power(p, c, exponent));
                    tally.check(cosine <= Cosine::ONE && mirrored <= Cosine::ONE);
                    tally.check(powers.iter().all(|power| *power <= Cosine::ONE));
                    for colour in [0, 1, top - 1, top] {
                        tally.check(phong.shade(normal, [colour; 3]).iter().all(|c| *c <= top));
                    }
                }
            }
        }
    }
}

/// Every pair of extreme pixels and samples, both ways.
fn compositing<R: Recurrence>(r: R, shown: u32, tally: &mut Tally) {
    let (one, colour_bits) = (r.one().bits(), r.colour_bits());
    let opacities = [
        0u32,
        1,
        2,
        1 << 15,
        (1 << 15) - 1,
        1 << 30,
        2_147_418_113,
        (1 << 31) - 1,
        1 << 31,
    ];
    let colours = [0, 1, 1 << (colour_bits - 1), (1 << colour_bits) - 1, 1 << colour_bits];
    let transparencies = [0, 1, 2, one / 2, one / 2 + 1, one - 1, one];
    for k in (0..64).chain([20_250, 32_767, u32::MAX]) {
        let dither = Dither::of_plane(k);
        for t in transparencies {
            for c in [0, (one - t) / 2, one - t] {
                let pixel = Pixel {
                    colour: [R::Channel::from_bits(c); 3],
                    transparency: R::Channel::from_bits(t),
                };
                for opacity in opacities.map(Opacity::from_bits) {
                    for colour in colours {
                        let over = r.over(pixel, [colour; 3], opacity, dither);
                        let under = r.under(pixel, [colour; 3], opacity, dither);
                        let bounded = |p: Pixel<R::Channel>| {
                            let left = p.transparency.bits() & shown;
                            p.colour.iter().all(|c| c.bits() <= one) && left <= t & shown
                        };
                        tally.check(bounded(over) && bounded(under));
                    }
                }
            }
        }
    }
}

/// The whole pipeline on voxels of 0 and 4095 alone, lit, from many sides, in every named precision.
fn whole(tally: &mut Tally, views: u32) -> Result<(), slicecast_engine::error::RenderError> {
    let mut state = 4095u32;
    let noise: Vec<f64> = (0..10 * 9 * 8)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 31 == 1 { 4095.0 } else { 0.0 }
        })
        .collect();
    let board = volume([10, 9, 8], [1.0, 0.3, 4.8], |[x, y, z]| noise[x + 10 * (y + 9 * z)]);
    let mut scene = scene(&[(0.0, 0.001), (2000.0, 1.0), (4095.0, 0.5)]);
    scene.lighting = Some(slicecast_scene::Lighting {
        ambient: 1.0,
        diffuse: 1.0,
        specular: 1.0,
        exponent_log2: 8,
        highlight: slicecast_scene::Highlight::Reflection,
        lights: vec![slicecast_scene::Light::default(); 8],
    });
    for view in 0..views {
        scene.view = View {
            azimuth: 360.0 * f64::from(view) / f64::from(views),
            elevation: 80.0 * (f64::from(view) * 1.7).sin(),
            roll: 0.0,
        };
        scene.sampling.planes_per_voxel = 1 + view % 16;
        for precision in PrecisionName::STAGED {
            let base = compared(&scene, &board, precision)?.frame.base;
            for plane in &base.planes {
                plane.iter().for_each(|bits| tally.check(*bits <= base.one));
            }
        }
    }
    Ok(())
}

/// All of them.
///
/// # Errors
/// [`RenderError`](slicecast_engine::error::RenderError) if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, slicecast_engine::error::RenderError> {
    let mut named: Vec<(&str, Tally)> = Vec::new();
    let mut stage = |name, run: &dyn Fn(&mut Tally)| {
        let mut tally = Tally::default();
        run(&mut tally);
        named.push((name, tally));
    };
    stage("interpolation", &|t| {
        interpolation(Paper, t);
        interpolation(Compact, t);
        interpolation(Wide, t);
    });
    stage("spacing, normalisation", &normals);
    stage("dots, powers, shading", &|t| {
        shading(Paper, t);
        shading(Compact, t);
        shading(Wide, t);
    });
    stage("compositing", &|t| {
        compositing(Paper.pixel(), u32::MAX, t);
        compositing(Compact.pixel(), u32::MAX, t);
        compositing(Wide.pixel(), u32::MAX, t);
    });
    stage("compositing of studies", &|t| {
        let study = |arithmetic, scale| StudyPixel::new(arithmetic, scale).expect("a format that the arithmetic has");
        let deep = |arithmetic, scale| study(arithmetic, scale).deep().expect("room for 31-bit colours");
        let pixels = [
            study(Product { rounded: true }, Binary(8)),
            deep(Product { rounded: false }, Binary(31)),
            deep(Product { rounded: true }, Binary(31)),
            deep(Telescoping { rounded: true }, Binary(23)),
            study(Telescoping { rounded: false }, Carrying(15)),
            study(Product { rounded: true }, Full(8)),
        ];
        for pixel in pixels {
            compositing(pixel, pixel.scale().shown(), t);
        }
    });
    let views = if size == Size::Full { 64 } else { 8 };
    let mut tally = Tally::default();
    whole(&mut tally, views)?;
    named.push(("whole pipeline, voxels of 0 and 4095, eight lights of 1.0", tally));
    let case = |(name, tally): (&str, Tally)| {
        let mut case = Case::new(
            "overflow",
            name,
            "results outside their range",
            0.0,
            "the contract's proofs: nothing leaves its format",
        );
        case.outcome(format!("{} results", tally.tried), tally.wrong as f64, Some(0.0));
        case
    };
    Ok(named.into_iter().map(case).collect())
}
