//! Shading: the colour of a sample under the scene's lights.
//!
//! Source: Squeeze, equations 10 and 11; reflection-vector form as there, or the half-vector form. Lights are
//! directional and the projection is parallel, so every vector but the normal is constant over a frame.
//!
//! | value | format | range |
//! |---|---|---|
//! | g, r | `normalise` | normal N = -g r / 2^35 (towards lower values) |
//! | light L, half vector H, viewer V | s1.30; s1.15 where a precision keeps less ([`keep_vector`]) | -1 to 1 |
//! | dot x | 1.31, `min(2^31, (d * r + 2^18) >> 19)` with `d = max(0, -(g . L))`; with 30 bits of L `(max(0, -(g . L)) + 2^8) >> 9` and `(d * r + 2^24) >> 25` | 0 to 1 |
//! | power x^(2^n) | 1.31, n times `x = (x * x + 2^30) >> 31` | 0 to 1, 1 stays 1 |
//! | coefficients ka, kd_i, ks_i | 1.31, a channel each (material times light); 1.15 where a precision keeps less | 0 to 1 |
//! | classified colour O, shaded colour c | 1.15; 1.31 in `Wide` | 0 to 1 |
//!
//! `c = min(1, O min(1, ka + sum kd_i (N.L_i)+) + sum ks_i y_i)`, in the precision's arithmetic ([`Shading`](crate::precision::Shading)):
//!
//! - `Rounded31` (`Wide`): products truncated to 1.31. A highlight raises the cosine's last bit to its exponent: error
//!   below 2^-31 (2 + 2 lights + 4.25 ks 2^n), which is 2^-20.9 at exponent 256.
//! - `Rounded16` (`Compact`): x and y rounded to 1.16 (x16, y16), coefficients 1.15, so that every product is 1.31 in 32 bits;
//!   `m = min(2^16, (2^16 ka + sum kd_i x16_i + 2^14) >> 15)`, `c = min(2^15, (O * m + sum ks_i y16_i + 2^15) >> 16)`. Error at most 1.0 ulp while
//!   ka + kd + ks <= 1, whatever the exponent and the number of lights.
//! - `Truncated16` (`Paper`): N truncated to 1.12, every product and power to 16.16.
//!
//! The errors are against f64 on the same g, r, O, light vectors and coefficients. A highlight needs light on the
//! surface: y = 0 where N.L <= 0 (and, for the reflection, where N.V <= 0). Reflection: R.L = 2 (N.V)(N.L) - V.L.
//! Sums saturate (8 lights of 1.0 each are allowed) and are clamped to 1. State: none.

mod arithmetic;
mod gaze;
pub mod map;
#[cfg(test)]
mod tests;

use heapless::Vec;

use crate::composite::Colours;
use crate::format::{Coefficient, Vector};
use crate::lanes::{Lanes, Wide as _};
use crate::normalise::Normal;
use crate::precision::Precision;
use crate::rows::three;

use arithmetic::dot_with;
pub(crate) use arithmetic::weighed;
use arithmetic::{along, ambient, brighter, for_products, lit, lit_weighted, opposite, weighted};
pub use arithmetic::{dot, dot_lanes, formed, formed_nearest, power, power_lanes, reflected};
use gaze::{Gaze, Parallel, Spreading};

/// The largest number of lights.
pub const LIGHTS_MAX: usize = 8;
/// The largest log2 of a specular exponent (256).
pub const EXPONENT_LOG2_MAX: u32 = 8;

/// What a shader asks of the source of samples: pipelines that ask the same share their source.
pub trait Asked: Copy + core::fmt::Debug + Sync + 'static {
    /// Whether gradients are made.
    const GRADIENTS: bool;
}

/// Samples.
#[derive(Clone, Copy, Debug)]
pub struct SamplesAlone;

/// Samples and their gradients.
#[derive(Clone, Copy, Debug)]
pub struct SamplesAndGradients;

impl Asked for SamplesAlone {
    const GRADIENTS: bool = false;
}

impl Asked for SamplesAndGradients {
    const GRADIENTS: bool = true;
}

/// Turns a classified colour into the one that is composited.
pub trait Shader<P: Precision>: Sync {
    /// What it asks of the source of samples.
    type Asked: Asked;
    /// Whether normals are read. Without them the pipeline holds no gradient rows and two slices instead of four.
    const LIT: bool = Self::Asked::GRADIENTS;
    /// Whether magnitudes of gradients weigh light and opacities ([`modulate`](crate::modulate)). Without it the pipeline holds no row of
    /// them.
    const MODULATES: bool = false;

    /// Whether light falls on normals, and not only their lengths count.
    #[inline(always)]
    fn reads_normals(&self) -> bool {
        Self::LIT
    }

    /// Shades the colours of a row in place, so that its rows hold them. Rows of equal length: components of g, r, and
    /// colours (as the pixel takes them).
    fn shade_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], colours: &mut Colours<'_, i32>);

    /// The same of rays that spread: with the unit vectors towards the eye, s1.30.
    #[inline(always)]
    fn shade_towards_row<V: Lanes>(
        &self,
        g: [&[i32]; 3],
        r: &[i32],
        _towards: [&[i32]; 3],
        colours: &mut Colours<'_, i32>,
    ) {
        self.shade_row::<V>(g, r, colours);
    }

    /// The same with the places of the gradients' magnitudes ([`magnitude`](crate::modulate::magnitude)).
    #[inline(always)]
    fn shade_modulated_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], _: &[i32], colours: &mut Colours<'_, i32>) {
        self.shade_row::<V>(g, r, colours);
    }

    /// Puts the factors of opacities in the place of magnitudes, if there are any.
    #[inline(always)]
    fn factor_row<V: Lanes>(&self, _magnitudes: &mut [i32]) -> bool {
        false
    }

    /// Shades colours times extinction in place, 15.S, none above its extinction. Rows of equal length.
    fn shade_weighted_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], extinction: &[i32], colours: [&mut [i32]; 3]);
}

/// What weighs the light of each sample of a row.
pub(crate) trait Weights: Copy {
    /// The cosine of a light, with the bits that products take.
    fn diffuse<P: Precision, V: Lanes>(&self, p: P, at: usize, x: V) -> V;
    /// The power of a highlight, likewise.
    fn specular<P: Precision, V: Lanes>(&self, p: P, at: usize, y: V) -> V;
}

/// Nothing does.
#[derive(Clone, Copy)]
struct Unweighed;

impl Weights for Unweighed {
    #[inline(always)]
    fn diffuse<P: Precision, V: Lanes>(&self, _: P, _: usize, x: V) -> V {
        x
    }

    #[inline(always)]
    fn specular<P: Precision, V: Lanes>(&self, _: P, _: usize, y: V) -> V {
        y
    }
}

/// No lights: the classified colour is the colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unlit;

impl<P: Precision> Shader<P> for Unlit {
    type Asked = SamplesAlone;

    #[inline(always)]
    fn shade_row<V: Lanes>(&self, _: [&[i32]; 3], _: &[i32], _: &mut Colours<'_, i32>) {}

    #[inline(always)]
    fn shade_weighted_row<V: Lanes>(&self, _: [&[i32]; 3], _: &[i32], _: &[i32], _: [&mut [i32]; 3]) {}
}

/// Which dot product the highlight is a power of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Highlight {
    /// The reflected viewing vector and the light: R.L (Phong).
    Reflection,
    /// The normal and the half vector: N.H (Blinn).
    HalfVector,
}

/// A directional light, in the slice frame (i, j, k), in the world's proportions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Light {
    /// Unit vector towards the light.
    pub direction: [Vector; 3],
    /// Unit vector half way between the light and the viewer; read by [`Highlight::HalfVector`] only.
    pub half: [Vector; 3],
    /// Diffuse coefficient times the light's red, green, blue.
    pub diffuse: [Coefficient; 3],
    /// Specular coefficient times the light's red, green, blue.
    pub specular: [Coefficient; 3],
}

/// A [`Light`] with the bits that a precision keeps: the integers that shading multiplies by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeptLight {
    /// [`keep_vector`] of the direction.
    pub direction: [i32; 3],
    /// [`keep_vector`] of the half vector.
    pub half: [i32; 3],
    /// [`keep`] of the diffuse coefficients.
    pub diffuse: [u32; 3],
    /// [`keep`] of the specular coefficients.
    pub specular: [u32; 3],
}

impl KeptLight {
    /// What a precision keeps of a light.
    pub fn of<P: Precision>(p: P, light: &Light) -> Self {
        Self {
            direction: keep_vector(p, light.direction),
            half: keep_vector(p, light.half),
            diffuse: light.diffuse.map(|c| keep(p, c)),
            specular: light.specular.map(|c| keep(p, c)),
        }
    }
}

/// Phong illumination by up to eight lights.
#[derive(Clone, Debug)]
pub struct Phong<P> {
    /// Vectors and coefficients hold as many fraction bits as the precision keeps.
    ambient: [u32; 3],
    lights: Vec<Source, LIGHTS_MAX>,
    /// -V.
    away_from_viewer: [i32; 3],
    highlight: Highlight,
    exponent_log2: u32,
    /// Whether no coefficient differs between the channels: then one sum serves all three.
    grey: bool,
    /// See [`least_bright`].
    least_bright: u32,
    precision: P,
}

/// A light with the bits that a precision keeps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    /// -L.
    away: [i32; 3],
    /// -H.
    away_from_half: [i32; 3],
    /// V.L.
    along: i64,
    diffuse: [u32; 3],
    specular: [u32; 3],
}

/// Why lights and material are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PhongError {
    /// More than [`LIGHTS_MAX`] lights.
    Lights {
        /// The number given.
        given: usize,
    },
    /// log2 of the exponent above [`EXPONENT_LOG2_MAX`].
    Exponent {
        /// The log2 given.
        given: u32,
    },
    /// A component of a vector is beyond -1 to 1.
    Vector {
        /// The component's bits, s1.30.
        bits: i32,
    },
    /// A coefficient is above 1.
    Coefficient {
        /// The coefficient's bits, 1.31.
        bits: u32,
    },
    /// A component of a kept vector is beyond -1 to 1.
    KeptVector {
        /// The component.
        given: i32,
        /// What 1 is in the precision.
        one: u32,
    },
    /// A kept coefficient is above 1.
    KeptCoefficient {
        /// The coefficient.
        given: u32,
        /// What 1 is in the precision.
        one: u32,
    },
}

impl core::fmt::Display for PhongError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Lights { given } => write!(f, "{given} lights; accepted: at most {LIGHTS_MAX}"),
            Self::Exponent { given } => {
                write!(f, "an exponent of 2^{given}; accepted: at most 2^{EXPONENT_LOG2_MAX}")
            }
            Self::Vector { bits } => write!(f, "a vector component of {bits}/2^30; accepted: -2^30 to 2^30"),
            Self::Coefficient { bits } => write!(f, "a coefficient of {bits}/2^31; accepted: at most 2^31"),
            Self::KeptVector { given, one } => {
                write!(f, "a kept vector component of {given}; accepted: -{one} to {one}")
            }
            Self::KeptCoefficient { given, one } => {
                write!(f, "a kept coefficient of {given}; accepted: at most {one}")
            }
        }
    }
}

impl core::error::Error for PhongError {}

/// A coefficient with the bits that a precision keeps, to nearest.
#[inline]
pub fn keep<P: Precision>(p: P, coefficient: Coefficient) -> u32 {
    let cut = 31 - p.formats().shading.coefficient_bits();
    (coefficient.to_bits() + ((1 << cut) >> 1)) >> cut
}

/// A unit vector with the bits that a precision keeps. At 15 bits it is the nearest lattice vector, or that one of its
/// 26 neighbours whose length is nearest to 1: a highlight raises the length to its exponent. Length error 1.5e-5
/// (plain rounding: 2.2e-5).
pub fn keep_vector<P: Precision>(p: P, vector: [Vector; 3]) -> [i32; 3] {
    let exact = vector.map(Vector::to_bits);
    let cut = 30 - p.formats().shading.vector_bits();
    if cut == 0 {
        return exact;
    }
    let one = 1i64 << p.formats().shading.vector_bits();
    let nearest = exact.map(|c| (i64::from(c) + ((1 << cut) >> 1)) >> cut);
    let (mut best, mut least) = (nearest, (u64::MAX, u64::MAX));
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                let [a, b, c] = nearest;
                let candidate = [a + x, b + y, c + z];
                let square: i64 = candidate.iter().map(|c| c * c).sum();
                let away: i64 = candidate
                    .iter()
                    .zip(exact)
                    .map(|(c, e)| ((c << cut) - i64::from(e)).pow(2))
                    .sum();
                let cost = ((square - one * one).unsigned_abs(), away.unsigned_abs());
                if cost < least && candidate.iter().all(|c| c.abs() <= one) {
                    (best, least) = (candidate, cost);
                }
            }
        }
    }
    best.map(|c| c as i32)
}

/// Checks lights and material.
///
/// # Errors
/// [`PhongError`], with the value that is out of range; not of the number of lights.
pub(crate) fn check(
    ambient: [Coefficient; 3],
    lights: &[Light],
    viewer: [Vector; 3],
    exponent_log2: u32,
) -> Result<(), PhongError> {
    if exponent_log2 > EXPONENT_LOG2_MAX {
        return Err(PhongError::Exponent { given: exponent_log2 });
    }
    let vectors = lights.iter().flat_map(|l| [l.direction, l.half]).chain([viewer]);
    for component in vectors.flatten() {
        if component.unsigned_abs() > Vector::ONE.unsigned_abs() {
            return Err(PhongError::Vector {
                bits: component.to_bits(),
            });
        }
    }
    let coefficients = lights.iter().flat_map(|l| [l.diffuse, l.specular]).chain([ambient]);
    for coefficient in coefficients.flatten() {
        if coefficient > Coefficient::ONE {
            return Err(PhongError::Coefficient {
                bits: coefficient.to_bits(),
            });
        }
    }
    Ok(())
}

impl<P: Precision> Phong<P> {
    /// Lights and material. All vectors are unit vectors: their length is not checked, and one of more than 1 makes
    /// highlights that are too bright, or wrap. `viewer` is the unit vector towards the eye, in the slice frame; the highlight's exponent
    /// is `2^exponent_log2`.
    ///
    /// # Errors
    /// [`PhongError`], with the value that is out of range.
    pub fn new(
        p: P,
        ambient: [Coefficient; 3],
        lights: &[Light],
        viewer: [Vector; 3],
        highlight: Highlight,
        exponent_log2: u32,
    ) -> Result<Self, PhongError> {
        check(ambient, lights, viewer, exponent_log2)?;
        let kept = lights.iter().map(|light| KeptLight::of(p, light));
        Self::build(
            p,
            ambient.map(|c| keep(p, c)),
            kept,
            keep_vector(p, viewer),
            highlight,
            exponent_log2,
        )
    }

    /// Lights and material as the precision keeps them, and as [`Phong::new`] finds them with [`keep`] and [`keep_vector`]
    /// (whose search, from a vector that it has found, may find another: it is for vectors of full width).
    ///
    /// # Errors
    /// [`PhongError`], with the value that is out of range.
    pub fn of_kept(
        p: P,
        ambient: [u32; 3],
        lights: &[KeptLight],
        viewer: [i32; 3],
        highlight: Highlight,
        exponent_log2: u32,
    ) -> Result<Self, PhongError> {
        if exponent_log2 > EXPONENT_LOG2_MAX {
            return Err(PhongError::Exponent { given: exponent_log2 });
        }
        let shading = p.formats().shading;
        let one = 1 << shading.vector_bits();
        let vectors = lights.iter().flat_map(|l| [l.direction, l.half]).chain([viewer]);
        if let Some(given) = vectors.flatten().find(|c| c.unsigned_abs() > one) {
            return Err(PhongError::KeptVector { given, one });
        }
        let one = 1 << shading.coefficient_bits();
        let coefficients = lights.iter().flat_map(|l| [l.diffuse, l.specular]).chain([ambient]);
        if let Some(given) = coefficients.flatten().find(|c| *c > one) {
            return Err(PhongError::KeptCoefficient { given, one });
        }
        Self::build(p, ambient, lights.iter().copied(), viewer, highlight, exponent_log2)
    }

    /// The shader of kept values in their ranges.
    fn build(
        p: P,
        ambient: [u32; 3],
        lights: impl ExactSizeIterator<Item = KeptLight>,
        viewer: [i32; 3],
        highlight: Highlight,
        exponent_log2: u32,
    ) -> Result<Self, PhongError> {
        let mut sources = Vec::new();
        let given = lights.len();
        for light in lights {
            let source = Source {
                away: opposite(light.direction),
                away_from_half: opposite(light.half),
                along: along(viewer, light.direction),
                diffuse: light.diffuse,
                specular: light.specular,
            };
            sources.push(source).map_err(|_| PhongError::Lights { given })?;
        }
        let equal = |[r, g, b]: [u32; 3]| r == g && g == b;
        let grey = equal(ambient) && sources.iter().all(|l| equal(l.diffuse) && equal(l.specular));
        Ok(Self {
            ambient,
            grey,
            least_bright: least_bright(p, exponent_log2),
            lights: sources,
            away_from_viewer: opposite(viewer),
            highlight,
            exponent_log2,
            precision: p,
        })
    }

    /// Colour of a sample with this normal and classified colour. This function is the definition: a row of one.
    #[inline]
    pub fn shade(&self, normal: Normal, colour: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = normal.g.map(|c| [c]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c as i32]);
        let mut colours = Colours {
            one: None,
            rows: [&mut red, &mut green, &mut blue],
        };
        Shader::<P>::shade_row::<i32>(self, [&x, &y, &z], &[normal.r as i32], &mut colours);
        [red, green, blue].map(|[c]| c as u32)
    }

    /// Red, green and blue times extinction of a sample with this normal. This function is the definition: a row of one.
    #[inline]
    pub fn shade_weighted(&self, normal: Normal, extinction: i32, colour: [i32; 3]) -> [i32; 3] {
        let [x, y, z] = normal.g.map(|c| [c]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c]);
        let (rows, r) = ([&mut red[..], &mut green, &mut blue], [normal.r as i32]);
        Shader::<P>::shade_weighted_row::<i32>(self, [&x, &y, &z], &r, &[extinction], rows);
        [red, green, blue].map(|[c]| c)
    }

    /// Colour of a sample with this normal and classified colour, whose ray comes from an eye in this direction (a unit vector, s1.30).
    /// This function is the definition: a row of one.
    #[inline]
    pub fn shade_towards(&self, normal: Normal, towards: [i32; 3], colour: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = normal.g.map(|c| [c]);
        let [i, j, k] = towards.map(|c| [c]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c as i32]);
        let mut colours = Colours {
            one: None,
            rows: [&mut red, &mut green, &mut blue],
        };
        let r = [normal.r as i32];
        Shader::<P>::shade_towards_row::<i32>(self, [&x, &y, &z], &r, [&i, &j, &k], &mut colours);
        [red, green, blue].map(|[c]| c as u32)
    }

    /// Shades a row whose colours lie in these rows, in place.
    #[inline(always)]
    fn shade_matter<V: Lanes, G: Gaze, W: Weights, M: Matter>(
        &self,
        gaze: G,
        weights: W,
        ([gx, gy, gz], r): ([&[i32]; 3], &[i32]),
        matter: M,
        [red, green, blue]: [&mut [i32]; 3],
    ) {
        let len = r.len();
        let (Some(gx), Some(gy), Some(gz)) = (gx.get(..len), gy.get(..len), gz.get(..len)) else {
            return;
        };
        let (Some(red), Some(green), Some(blue)) = (red.get_mut(..len), green.get_mut(..len), blue.get_mut(..len))
        else {
            return;
        };
        let (normals, colour) = (Normals { g: [gx, gy, gz], r }, [red, green, blue]);
        // A constant, so that nothing is compiled for the other.
        if const { V::COUNT > 1 } {
            if self.grey {
                self.shade_row_by::<V, G, W, M, 2, 1>(gaze, weights, normals, matter, colour);
            } else {
                self.shade_row_by::<V, G, W, M, 2, 3>(gaze, weights, normals, matter, colour);
            }
        } else if self.grey {
            self.shade_row_by::<V, G, W, M, 1, 1>(gaze, weights, normals, matter, colour);
        } else {
            self.shade_row_by::<V, G, W, M, 1, 3>(gaze, weights, normals, matter, colour);
        }
    }

    /// Shades a row, `B` vectors at a time and each step on all of them: one chain of dependent operations as long as
    /// all steps would leave a processor waiting. `N` channels differ in their coefficients: 1 (grey light) or 3.
    #[inline(always)]
    fn shade_row_by<V: Lanes, G: Gaze, W: Weights, M: Matter, const B: usize, const N: usize>(
        &self,
        gaze: G,
        weights: W,
        normals: Normals<'_>,
        matter: M,
        [red, green, blue]: [&mut [i32]; 3],
    ) {
        let (p, len) = (self.precision, normals.r.len());
        let (zero, dark) = (V::splat(0), V::Wide::splat(0));
        let reflection = self.highlight == Highlight::Reflection;
        for start in (0..len).step_by(B * V::COUNT) {
            let places = (start..len).step_by(V::COUNT);
            let mut sums = [[[zero; 2]; N]; B];
            let mut facing = [dark; B];
            for ((sums, facing), at) in sums.iter_mut().zip(&mut facing).zip(places.clone()) {
                for (sum, k) in sums.iter_mut().zip(self.ambient) {
                    *sum = [ambient::<P, V>(p, k), zero];
                }
                if reflection {
                    *facing = gaze.facing::<P, V>(p, normals, at);
                }
            }
            for light in &self.lights {
                let mut bases = [dark; B];
                for (((sums, base), nv), at) in sums.iter_mut().zip(&mut bases).zip(&facing).zip(places.clone()) {
                    let nl = normals.dot::<P, V>(p, at, light.away);
                    if !nl.any_at_least(1) {
                        continue;
                    }
                    *base = if reflection {
                        gaze.reflected::<P, V>(p, at, light, *nv, nl)
                    } else {
                        nl.nonzero_then(gaze.half_way::<P, V>(p, normals, at, light))
                    };
                    let x = weights.diffuse(p, at, for_products::<P, V>(p, nl.narrow()));
                    for ([d, _], k) in sums.iter_mut().zip(light.diffuse) {
                        *d = brighter::<P, V>(p, *d, weighted::<P, V>(p, k, x));
                    }
                }
                for (number, (sums, base)) in sums.iter_mut().zip(&bases).enumerate() {
                    // A power that products would not see is not formed.
                    if !base.any_at_least(self.least_bright) {
                        continue;
                    }
                    let y = for_products::<P, V>(p, power_lanes::<P, V>(p, *base, self.exponent_log2));
                    let y = weights.specular(p, start + number * V::COUNT, y);
                    for ([_, s], k) in sums.iter_mut().zip(light.specular) {
                        *s = brighter::<P, V>(p, *s, weighted::<P, V>(p, k, y));
                    }
                }
            }
            for (sums, at) in sums.iter().zip(places) {
                let [r, g, b] = matter.colour([red, green, blue], at);
                let unlit = &[zero; 2];
                let [first, middle, last] = three([0, N >> 1, N - 1], |n| sums.get(n).unwrap_or(unlit));
                matter.lit::<P, V>(p, at, r, *first).store(red, at);
                matter.lit::<P, V>(p, at, g, *middle).store(green, at);
                matter.lit::<P, V>(p, at, b, *last).store(blue, at);
            }
        }
    }
}

/// What light falls on.
trait Matter: Copy {
    /// The colour at a place, given its rows.
    fn colour<V: Lanes>(self, rows: [&[i32]; 3], at: usize) -> [V; 3];
    /// A colour at a place under these sums of light.
    fn lit<P: Precision, V: Lanes>(self, p: P, at: usize, colour: V, sums: [V; 2]) -> V;
}

/// Classified samples, with the colour of all of them if they have one.
#[derive(Clone, Copy)]
struct Classified(Option<[u32; 3]>);

impl Matter for Classified {
    #[inline(always)]
    fn colour<V: Lanes>(self, [red, green, blue]: [&[i32]; 3], at: usize) -> [V; 3] {
        match self.0 {
            Some([r, g, b]) => [V::splat(r as i32), V::splat(g as i32), V::splat(b as i32)],
            None => [V::load(red, at), V::load(green, at), V::load(blue, at)],
        }
    }

    #[inline(always)]
    fn lit<P: Precision, V: Lanes>(self, p: P, _: usize, colour: V, sums: [V; 2]) -> V {
        lit::<P, V>(p, colour, sums)
    }
}

/// Colours times extinction, with their extinctions.
#[derive(Clone, Copy)]
struct Coloured<'a>(&'a [i32]);

impl Matter for Coloured<'_> {
    #[inline(always)]
    fn colour<V: Lanes>(self, rows: [&[i32]; 3], at: usize) -> [V; 3] {
        three(rows, |row| V::load(row, at))
    }

    #[inline(always)]
    fn lit<P: Precision, V: Lanes>(self, p: P, at: usize, colour: V, sums: [V; 2]) -> V {
        lit_weighted::<P, V>(p, V::load(self.0, at), colour, sums)
    }
}

/// Rows of normals.
#[derive(Clone, Copy)]
pub(crate) struct Normals<'a> {
    g: [&'a [i32]; 3],
    r: &'a [i32],
}

impl Normals<'_> {
    /// [`dot_lanes`] of the normals at a place.
    #[inline(always)]
    fn dot<P: Precision, V: Lanes>(&self, p: P, at: usize, away: [i32; 3]) -> V::Wide {
        let [ax, ay, az] = away;
        self.dot_with::<P, V>(p, at, [V::splat(ax), V::splat(ay), V::splat(az)])
    }

    /// The same with another vector in each lane.
    #[inline(always)]
    fn dot_with<P: Precision, V: Lanes>(&self, p: P, at: usize, away: [V; 3]) -> V::Wide {
        let [x, y, z] = self.g;
        let g = [V::load(x, at), V::load(y, at), V::load(z, at)];
        dot_with::<P, V>(p, g, V::load(self.r, at), away)
    }
}

/// The least base of a highlight of which products see anything: its power rises with it.
fn least_bright<P: Precision>(p: P, exponent_log2: u32) -> u32 {
    let seen = |x: u32| for_products::<P, i32>(p, power_lanes::<P, i32>(p, i64::from(x), exponent_log2)) != 0;
    let (mut dark, mut bright) = (0u32, 1u32 << 31);
    while bright - dark > 1 {
        let middle = dark + ((bright - dark) >> 1);
        if seen(middle) {
            bright = middle;
        } else {
            dark = middle;
        }
    }
    bright
}

impl<P: Precision> Shader<P> for Phong<P> {
    type Asked = SamplesAndGradients;

    #[inline(always)]
    fn shade_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], colours: &mut Colours<'_, i32>) {
        self.shade_weighed_row::<V, _>(g, r, colours, Unweighed);
    }

    #[inline(always)]
    fn shade_towards_row<V: Lanes>(
        &self,
        g: [&[i32]; 3],
        r: &[i32],
        towards: [&[i32]; 3],
        colours: &mut Colours<'_, i32>,
    ) {
        let classified = Classified(colours.one.take());
        let [red, green, blue] = &mut colours.rows;
        self.shade_matter::<V, _, _, _>(Spreading { towards }, Unweighed, (g, r), classified, [red, green, blue]);
    }

    #[inline(always)]
    fn shade_weighted_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], extinction: &[i32], colours: [&mut [i32]; 3]) {
        if let Some(extinction) = extinction.get(..r.len()) {
            self.shade_matter::<V, _, _, _>(self.parallel(), Unweighed, (g, r), Coloured(extinction), colours);
        }
    }
}

impl<P: Precision> Phong<P> {
    /// [`Shader::shade_row`] with weights.
    #[inline(always)]
    pub(crate) fn shade_weighed_row<V: Lanes, W: Weights>(
        &self,
        g: [&[i32]; 3],
        r: &[i32],
        colours: &mut Colours<'_, i32>,
        weights: W,
    ) {
        let classified = Classified(colours.one.take());
        let [red, green, blue] = &mut colours.rows;
        self.shade_matter::<V, _, _, _>(self.parallel(), weights, (g, r), classified, [red, green, blue]);
    }

    /// The viewer of parallel rays.
    #[inline(always)]
    const fn parallel(&self) -> Parallel {
        Parallel {
            away: self.away_from_viewer,
        }
    }
}
