//! Shading: the colour of a sample under the scene's lights.
//!
//! Source: Squeeze, equations 10 and 11; reflection-vector form as there, or the half-vector form. Lights are
//! directional and the projection is parallel, so every vector but the normal is constant over a frame.
//!
//! | value | format | range |
//! |---|---|---|
//! | g, r | `normalise` | normal N = -g r / 2^35 (towards lower values) |
//! | light L, half vector H, viewer V | s1.30; s1.15 where a precision keeps less ([`keep_vector`]) | -1 to 1 |
//! | dot x | 1.31, `min(1, (d r + 2^18) >> 19)` with d = max(0, -(g . L)); with 30 bits of L `(d + 2^8) >> 9` and `(d r + 2^24) >> 25` | 0 to 1 |
//! | power x^(2^n) | 1.31, n times `x = (x x + 2^30) >> 31` | 0 to 1, 1 stays 1 |
//! | coefficients ka, kd_i, ks_i | 1.31, a channel each (material times light); 1.15 where a precision keeps less | 0 to 1 |
//! | classified colour O, shaded colour c | 1.15; 1.31 in `Wide` | 0 to 1 |
//!
//! `c = min(1, O min(1, ka + sum kd_i x_i) + sum ks_i y_i)`, in the precision's arithmetic ([`Shading`]):
//!
//! - `Rounded31` (`Wide`): products truncated to 1.31. A highlight raises the cosine's last bit to its exponent: error
//!   below 2^-31 (2 + 2 lights + 4.25 ks 2^n), which is 2^-20.9 at exponent 256.
//! - `Rounded16` (`Compact`): x and y rounded to 1.16, coefficients 1.15, so that every product is 1.31 in 32 bits;
//!   `m = (2^16 ka + sum kd_i x_i + 2^14) >> 15`, `c = (O m + sum ks_i y_i + 2^15) >> 16`. Error at most 1.0 ulp while
//!   ka + kd + ks <= 1, whatever the exponent and the number of lights.
//! - `Truncated16` (`Paper`): N truncated to 1.12, every product and power to 16.16.
//!
//! The errors are against f64 on the same g, r, O, light vectors and coefficients. A highlight needs light on the
//! surface: y = 0 where N.L <= 0 (and, for the reflection, where N.V <= 0). Reflection: R.L = 2 (N.V)(N.L) - V.L.
//! Sums saturate (8 lights of 1.0 each are allowed) and are clamped to 1. State: none.

use core::marker::PhantomData;

use heapless::Vec;

use crate::format::{Coefficient, Cosine, Vector};
use crate::lanes::{Lanes, Wide as _, places};
use crate::normalise::Normal;
use crate::precision::{NormalForm, Power, Precision, Shading};
use crate::rows::{part, part_mut};

/// The largest number of lights.
pub const LIGHTS_MAX: usize = 8;
/// The largest log2 of a specular exponent (256).
pub const EXPONENT_LOG2_MAX: u32 = 8;

/// Turns a classified colour into the one that is composited.
pub trait Shader<P: Precision>: Sync {
    /// Whether normals are read. Without them the pipeline holds no gradient rows and two slices instead of four.
    const LIT: bool;

    /// Shades the colours of a row in place. Seven rows of equal length: components of
    /// g, r, and colours (`P::COLOUR_BITS`).
    fn shade_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], colour: [&mut [i32]; 3]);
}

/// No lights: the classified colour is the colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unlit;

impl<P: Precision> Shader<P> for Unlit {
    const LIT: bool = false;

    #[inline(always)]
    fn shade_row<V: Lanes>(&self, _: [&[i32]; 3], _: &[i32], _: [&mut [i32]; 3]) {}
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

/// Phong illumination by up to eight lights.
#[derive(Clone, Debug)]
pub struct Phong<P> {
    /// Vectors and coefficients hold as many fraction bits as the precision keeps.
    ambient: [u32; 3],
    lights: Vec<Source, LIGHTS_MAX>,
    viewer: [i32; 3],
    highlight: Highlight,
    exponent_log2: u32,
    /// Whether no coefficient differs between the channels: then one sum serves all three.
    grey: bool,
    /// See [`least_bright`].
    least_bright: u32,
    precision: PhantomData<P>,
}

/// A light with the bits that a precision keeps.
#[derive(Clone, Copy, Debug)]
struct Source {
    direction: [i32; 3],
    half: [i32; 3],
    /// V.L.
    along: i64,
    diffuse: [u32; 3],
    specular: [u32; 3],
}

/// Why lights and material are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
        }
    }
}

impl core::error::Error for PhongError {}

/// A coefficient with the bits that a precision keeps, to nearest.
#[inline]
pub fn keep<P: Precision>(coefficient: Coefficient) -> u32 {
    let cut = 31 - P::SHADING.coefficient_bits();
    (coefficient.to_bits() + ((1 << cut) >> 1)) >> cut
}

/// A unit vector with the bits that a precision keeps. At 15 bits it is the nearest lattice vector, or that one of its
/// 26 neighbours whose length is nearest to 1: a highlight raises the length to its exponent. Length error 1.5e-5
/// (plain rounding: 2.2e-5).
pub fn keep_vector<P: Precision>(vector: [Vector; 3]) -> [i32; 3] {
    let exact = vector.map(Vector::to_bits);
    let cut = 30 - P::SHADING.vector_bits();
    if cut == 0 {
        return exact;
    }
    let one = 1i64 << P::SHADING.vector_bits();
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

impl<P: Precision> Phong<P> {
    /// Lights and material. All vectors are unit vectors: their length is not checked, and one of more than 1 makes
    /// highlights that are too bright (or, at 15 bits, wrap). `viewer` is the unit vector towards the eye, in the slice frame; the highlight's exponent
    /// is `2^exponent_log2`.
    ///
    /// # Errors
    /// [`PhongError`], with the value that is out of range.
    pub fn new(
        ambient: [Coefficient; 3],
        lights: &[Light],
        viewer: [Vector; 3],
        highlight: Highlight,
        exponent_log2: u32,
    ) -> Result<Self, PhongError> {
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
        let mut sources = Vec::new();
        for light in lights {
            let direction = keep_vector::<P>(light.direction);
            let source = Source {
                direction,
                along: along(keep_vector::<P>(viewer), direction),
                half: keep_vector::<P>(light.half),
                diffuse: light.diffuse.map(keep::<P>),
                specular: light.specular.map(keep::<P>),
            };
            sources
                .push(source)
                .map_err(|_| PhongError::Lights { given: lights.len() })?;
        }
        let ambient = ambient.map(keep::<P>);
        let equal = |[r, g, b]: [u32; 3]| r == g && g == b;
        let grey = equal(ambient) && sources.iter().all(|l| equal(l.diffuse) && equal(l.specular));
        Ok(Self {
            ambient,
            grey,
            least_bright: least_bright::<P>(exponent_log2),
            lights: sources,
            viewer: keep_vector::<P>(viewer),
            highlight,
            exponent_log2,
            precision: PhantomData,
        })
    }

    /// Colour of a sample with this normal and classified colour. This function is the definition: a row of one.
    #[inline]
    pub fn shade(&self, normal: Normal, colour: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = normal.g.map(|c| [c]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c as i32]);
        Shader::<P>::shade_row::<i32>(
            self,
            [&x, &y, &z],
            &[normal.r as i32],
            [&mut red, &mut green, &mut blue],
        );
        [red, green, blue].map(|[c]| c as u32)
    }

    /// Shades a row, `B` vectors at a time and each step on all of them: one chain of dependent operations as long as
    /// all steps would leave a processor waiting. `N` channels differ in their coefficients: 1 (grey light) or 3.
    #[inline(always)]
    fn shade_row_by<V: Lanes, const B: usize, const N: usize>(
        &self,
        normals: Normals<'_>,
        [red, green, blue]: [&mut [i32]; 3],
    ) {
        let len = normals.r.len();
        let zero = V::splat(0);
        let reflection = self.highlight == Highlight::Reflection;
        for start in (0..len).step_by(B * V::COUNT) {
            let places = (start..len).step_by(V::COUNT);
            let mut sums = [[[zero; 2]; N]; B];
            let mut facing = [zero; B];
            for ((sums, facing), at) in sums.iter_mut().zip(&mut facing).zip(places.clone()) {
                for (sum, k) in sums.iter_mut().zip(self.ambient) {
                    *sum = [ambient::<P, V>(k), zero];
                }
                if reflection {
                    *facing = normals.dot::<P, V>(at, self.viewer);
                }
            }
            for light in &self.lights {
                let (mut towards, mut bases) = ([zero; B], [zero; B]);
                for ((nl, base), (nv, at)) in towards
                    .iter_mut()
                    .zip(&mut bases)
                    .zip(facing.iter().zip(places.clone()))
                {
                    *nl = normals.dot::<P, V>(at, light.direction);
                    if nl.all_zero() {
                        continue;
                    }
                    *base = if !reflection {
                        nl.nonzero_then(normals.dot::<P, V>(at, light.half))
                    } else if nv.all_zero() {
                        zero
                    } else {
                        nl.nonzero_then(nv.nonzero_then(reflected_off::<P, V>(*nv, *nl, light.along)))
                    };
                }
                let least = V::splat(self.least_bright as i32);
                for (sums, base) in sums.iter_mut().zip(&bases) {
                    // A power that products would not see is not formed.
                    let bright = base.at_least_then(least, *base);
                    if !bright.all_zero() {
                        let y = for_products::<P, V>(power_lanes::<P, V>(bright, self.exponent_log2));
                        for ([_, s], k) in sums.iter_mut().zip(light.specular) {
                            *s = s.saturating_add(weighted::<P, V>(k, y));
                        }
                    }
                }
                for (sums, nl) in sums.iter_mut().zip(&towards) {
                    let x = for_products::<P, V>(*nl);
                    for ([d, _], k) in sums.iter_mut().zip(light.diffuse) {
                        *d = d.saturating_add(weighted::<P, V>(k, x));
                    }
                }
            }
            for (sums, at) in sums.iter().zip(places) {
                let sum = |channel: usize| sums.get(channel).copied().unwrap_or([zero; 2]);
                lit::<P, V>(V::load(red, at), sum(0)).store(red, at);
                lit::<P, V>(V::load(green, at), sum(N >> 1)).store(green, at);
                lit::<P, V>(V::load(blue, at), sum(N - 1)).store(blue, at);
            }
        }
    }
}

/// Rows of normals.
#[derive(Clone, Copy)]
struct Normals<'a> {
    g: [&'a [i32]; 3],
    r: &'a [i32],
}

impl Normals<'_> {
    /// [`dot_lanes`] of the normals at a place.
    #[inline(always)]
    fn dot<P: Precision, V: Lanes>(&self, at: usize, vector: [i32; 3]) -> V {
        let [x, y, z] = self.g;
        dot_lanes::<P, V>(
            [V::load(x, at), V::load(y, at), V::load(z, at)],
            V::load(self.r, at),
            vector,
        )
    }
}

/// The least base of a highlight of which products see anything: its power rises with it.
fn least_bright<P: Precision>(exponent_log2: u32) -> u32 {
    let seen = |x: u32| for_products::<P, i32>(power_lanes::<P, i32>(x as i32, exponent_log2)) != 0;
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

/// The ambient coefficient as a sum of products begins with it.
#[inline(always)]
fn ambient<P: Precision, V: Lanes>(k: u32) -> V {
    V::splat(match P::SHADING {
        Shading::Truncated16 => k << 1,
        Shading::Rounded16 => k << 16,
        Shading::Rounded31 => k,
    } as i32)
}

/// A cosine (1.31) with the bits that products take.
#[inline(always)]
fn for_products<P: Precision, V: Lanes>(x: V) -> V {
    match P::SHADING {
        Shading::Truncated16 => x.shr_unsigned(15),
        Shading::Rounded16 => x.wrapping_add(V::splat(1 << 14)).shr_unsigned(15),
        Shading::Rounded31 => x,
    }
}

/// A cosine times its coefficient.
#[inline(always)]
fn weighted<P: Precision, V: Lanes>(k: u32, x: V) -> V {
    let k = V::splat(k as i32);
    match P::SHADING {
        Shading::Truncated16 => k.wrapping_mul(x).shr_unsigned(15),
        Shading::Rounded16 => k.wrapping_mul(x),
        Shading::Rounded31 => k.product(x).shr_narrow(31),
    }
}

/// The colour under this sum of light.
#[inline(always)]
fn lit<P: Precision, V: Lanes>(colour: V, [diffuse, specular]: [V; 2]) -> V {
    let (one15, one16, one31) = (V::splat(1 << 15), V::splat(1 << 16), V::splat(i32::MIN));
    match P::SHADING {
        Shading::Truncated16 => {
            let sum = colour.wrapping_mul(diffuse.at_most(one16)).shr_unsigned(15) + specular;
            (sum >> 1).at_most(one15)
        }
        Shading::Rounded16 => {
            let m = diffuse
                .at_most_unsigned(one31)
                .wrapping_add(V::splat(1 << 14))
                .shr_unsigned(15);
            // O m, and as much of the highlight as there is room for below 1.
            let diffuse = colour.wrapping_mul(m);
            let room = one31.wrapping_sub(diffuse);
            let sum = diffuse.wrapping_add(specular.at_most_unsigned(room));
            sum.wrapping_add(one15).shr_unsigned(16)
        }
        Shading::Rounded31 => {
            let product = colour.product(diffuse.at_most_unsigned(one31)) + V::Wide::splat(1 << 30);
            product
                .shr(31)
                .narrow()
                .saturating_add(specular)
                .at_most_unsigned(one31)
        }
    }
}

impl<P: Precision> Shader<P> for Phong<P> {
    const LIT: bool = true;

    #[inline(always)]
    fn shade_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], colour: [&mut [i32]; 3]) {
        let ([gx, gy, gz], [red, green, blue], len) = (g, colour, r.len());
        let (Some(gx), Some(gy), Some(gz)) = (gx.get(..len), gy.get(..len), gz.get(..len)) else {
            return;
        };
        let (Some(red), Some(green), Some(blue)) = (red.get_mut(..len), green.get_mut(..len), blue.get_mut(..len))
        else {
            return;
        };
        if V::COUNT > 1 {
            let normals = Normals { g: [gx, gy, gz], r };
            return if self.grey {
                self.shade_row_by::<V, 8, 1>(normals, [red, green, blue])
            } else {
                self.shade_row_by::<V, 8, 3>(normals, [red, green, blue])
            };
        }
        for at in places::<V>(len) {
            let one = at..at + 1;
            let normals = Normals {
                g: [gx, gy, gz].map(|row| part(row, one.clone())),
                r: part(r, one.clone()),
            };
            let colour = [&mut *red, &mut *green, &mut *blue].map(|row| part_mut(row, one.clone()));
            if self.grey {
                self.shade_row_by::<V, 1, 1>(normals, colour);
            } else {
                self.shade_row_by::<V, 1, 3>(normals, colour);
            }
        }
    }
}

/// The normal N = -g r / 2^35 with its magnitudes truncated (towards zero, so that opposite gradients have opposite
/// normals) to so many fraction bits, 1 to 15.
#[inline(always)]
pub fn formed<V: Lanes>(g: [V; 3], r: V, bits: u32) -> [V; 3] {
    let [x, y, z] = g;
    [
        formed_component(x, r, bits),
        formed_component(y, r, bits),
        formed_component(z, r, bits),
    ]
}

#[inline(always)]
fn formed_component<V: Lanes>(g: V, r: V, bits: u32) -> V {
    let magnitude = g.abs().product(r).shr_narrow(35 - bits);
    magnitude.with_sign_of(V::splat(0) - g)
}

/// [`dot_lanes`] of one sample.
#[inline]
pub fn dot<P: Precision>(normal: Normal, vector: [i32; 3]) -> Cosine {
    Cosine::from_bits(dot_lanes::<P, i32>(normal.g, normal.r as i32, vector) as u32)
}

/// The normal N = -g r / 2^35 with each component to the nearest of so many fraction bits (1 to 15), at most 1; opposite
/// gradients have opposite normals.
#[inline(always)]
pub fn formed_nearest<V: Lanes>(g: [V; 3], r: V, bits: u32) -> [V; 3] {
    let [x, y, z] = g;
    [
        nearest_component(x, r, bits),
        nearest_component(y, r, bits),
        nearest_component(z, r, bits),
    ]
}

#[inline(always)]
fn nearest_component<V: Lanes>(g: V, r: V, bits: u32) -> V {
    let product = g.abs().product(r) + V::Wide::splat(1 << (34 - bits));
    let magnitude = product.shr_narrow(35 - bits).at_most(V::splat(1 << bits));
    magnitude.with_sign_of(V::splat(0) - g)
}

/// `max(0, N . L)` with N = -g r / 2^35, 1.31. `Formed` normals are truncated first, and so are their products, at 16
/// fraction bits; `Nearest` ones are rounded first. The vector has the precision's bits ([`keep_vector`]).
#[inline(always)]
pub fn dot_lanes<P: Precision, V: Lanes>(g: [V; 3], r: V, vector: [i32; 3]) -> V {
    let zero = V::splat(0);
    let ([x, y, z], [lx, ly, lz]) = (g, vector);
    let (lx, ly, lz) = (V::splat(lx), V::splat(ly), V::splat(lz));
    match P::NORMAL {
        NormalForm::Deferred if P::SHADING.vector_bits() == 15 => {
            // |sum| <= sqrt(3) * 32767 * 32768 < 2^31 for unit vectors; wrapping keeps others from a panic.
            let sum = zero.wrapping_sub(x.wrapping_mul(lx)).wrapping_sub(y.wrapping_mul(ly));
            let sum = sum.wrapping_sub(z.wrapping_mul(lz));
            // d has the 15 fraction bits of the vector and r has 35; the product is brought to 31.
            let product = sum.at_least(zero).product(r) + V::Wide::splat(1 << 18);
            product.shr_to_one(19)
        }
        NormalForm::Deferred => {
            let sum = V::Wide::splat(1 << 8) - x.product_signed(lx) - y.product_signed(ly) - z.product_signed(lz);
            // Nine bits make room for r: 37 and 21 bits fit 64.
            let product = sum.at_least_zero().shr(9).times(r) + V::Wide::splat(1 << 24);
            product.shr_to_one(25)
        }
        NormalForm::Formed(bits) => {
            // bits + 15 fraction bits, truncated to 16.
            let [x, y, z] = formed(g, r, bits);
            let sum = ((x * lx) >> (bits - 1)) + ((y * ly) >> (bits - 1)) + ((z * lz) >> (bits - 1));
            sum.at_least(zero).at_most(V::splat(1 << 16)) << 15
        }
        NormalForm::Nearest(bits) => {
            // |sum| < 2^30 + 2^16 for unit vectors; wrapping keeps others from a panic.
            let [x, y, z] = formed_nearest(g, r, bits);
            let sum = x
                .wrapping_mul(lx)
                .wrapping_add(y.wrapping_mul(ly))
                .wrapping_add(z.wrapping_mul(lz));
            // bits + 15 fraction bits, brought to 31; a rounded normal may be longer than 1.
            let dot = V::Wide::of(sum.at_least(zero)).shl(16 - bits);
            dot.at_most(V::Wide::splat(1 << 31)).narrow()
        }
    }
}

/// R.L = 2 (N.V)(N.L) - V.L, 0 to 1, and 0 where N.V or N.L is 0. The vectors have the precision's bits.
#[inline]
pub fn reflected<P: Precision>(nv: Cosine, nl: Cosine, viewer: [i32; 3], light: [i32; 3]) -> Cosine {
    if nv == Cosine::ZERO || nl == Cosine::ZERO {
        return Cosine::ZERO;
    }
    let [nv, nl] = [nv, nl].map(|c| c.to_bits() as i32);
    Cosine::from_bits(reflected_off::<P, i32>(nv, nl, along(viewer, light)) as u32)
}

/// V.L, with twice the vectors' fraction bits.
fn along(viewer: [i32; 3], light: [i32; 3]) -> i64 {
    viewer
        .iter()
        .zip(light)
        .map(|(v, l)| i64::from(*v) * i64::from(l))
        .sum()
}

/// [`reflected`] with V.L at hand, and N.V and N.L above 0.
#[inline(always)]
fn reflected_off<P: Precision, V: Lanes>(nv: V, nl: V, vl: i64) -> V {
    let product = nv.product(nl);
    let rl = match P::SHADING {
        Shading::Rounded31 => (product + V::Wide::splat(1 << 29)).shr(30) - V::Wide::splat(vl >> 29),
        Shading::Rounded16 => (product + V::Wide::splat(1 << 29)).shr(30) - V::Wide::splat(vl << 1),
        Shading::Truncated16 => (product.shr(45) - V::Wide::splat(vl >> 14)).shl(15),
    };
    rl.at_least_zero().at_most(V::Wide::splat(1 << 31)).narrow()
}

/// [`power_lanes`] of one cosine.
#[inline]
pub fn power<P: Precision>(x: Cosine, n: u32) -> Cosine {
    Cosine::from_bits(power_lanes::<P, i32>(x.to_bits() as i32, n) as u32)
}

/// `x^(2^n)` by squaring, or what a study puts in its place; 1 stays 1. Squeeze, section 4.2.2.
#[inline(always)]
pub fn power_lanes<P: Precision, V: Lanes>(x: V, n: u32) -> V {
    match P::POWER {
        Power::Rounded31 => {
            let mut x = V::Wide::of(x);
            for _ in 0..n {
                x = x.square31();
            }
            x.narrow()
        }
        Power::Truncated16 => {
            let mut x = V::Wide::of(x.shr_unsigned(15));
            for _ in 0..n {
                x = x.square().shr(16);
            }
            x.narrow() << 15
        }
        Power::Parabola => {
            let one = V::splat(i32::MIN);
            let fall = one
                .wrapping_sub(x.at_most_unsigned(one))
                .product(V::splat((1 << n) + 1))
                .shr(1);
            one.wrapping_sub(fall.at_most(V::Wide::splat(1 << 31)).narrow())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normalise::normalise;
    use crate::precision::{Compact, Paper, Wide};
    use proptest::prelude::*;
    use std::vec::Vec as StdVec;

    fn unit(v: [f64; 3]) -> [Vector; 3] {
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| Vector::from_num(c / length))
    }

    fn value(v: [Vector; 3]) -> [f64; 3] {
        v.map(Vector::to_num)
    }

    fn kept<P: Precision>(v: [i32; 3]) -> [f64; 3] {
        v.map(|c| f64::from(c) * 2f64.powi(-(P::SHADING.vector_bits() as i32)))
    }

    fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Equation 10 in f64, on the pipeline's own inputs.
    fn model<P: Precision>(phong: &Phong<P>, normal: Normal, colour: [u32; 3]) -> [f64; 3] {
        let n = normal.g.map(|c| -f64::from(c) * f64::from(normal.r) / 2f64.powi(35));
        let viewer = kept::<P>(phong.viewer);
        let mut out = [0.0; 3];
        for (c, o) in out.iter_mut().enumerate() {
            let one = 2f64.powi(P::SHADING.coefficient_bits() as i32);
            let k = |v: [u32; 3]| f64::from(v[c]) / one;
            let (mut diffuse, mut specular) = (k(phong.ambient), 0.0);
            for light in &phong.lights {
                let l = kept::<P>(light.direction);
                let nl = dot64(n, l).clamp(0.0, 1.0);
                let base = match phong.highlight {
                    Highlight::HalfVector => dot64(n, kept::<P>(light.half)),
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
            *o = (f64::from(colour[c]) / f64::from(P::COLOUR_BITS).exp2() * diffuse.min(1.0) + specular).min(1.0);
        }
        out
    }

    fn vector() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-1.0f64..1.0).prop_filter("a direction", |v| dot64(*v, *v) > 0.01)
    }

    /// The arguments of [`Phong::new`].
    type Scene = ([Coefficient; 3], StdVec<Light>, [Vector; 3], Highlight, u32);

    fn make<P: Precision>((ambient, lights, viewer, highlight, exponent): &Scene) -> Phong<P> {
        Phong::new(*ambient, lights, *viewer, *highlight, *exponent).unwrap()
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
            within::<Compact>(&make(&scene), normal, colour, 1.0)?;
            let exponent = f64::from(scene.4).exp2();
            within::<Wide>(&make(&scene), normal, colour.map(|c| c << 16), 2.0 + 2.0 * 8.0 + 4.25 * exponent)?;
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
            within::<Compact>(&make(&scene), normal, [0; 3], 1.0)?;
            within::<Wide>(&make(&scene), normal, [0; 3], 4.0 + 4.25 * 256.0)?;
        }

        #[test]
        fn powers_are_rounded_squares(x in prop_oneof![0u32..=1 << 31, (1 << 31) - 9..=1u32 << 31], n in 0u32..=8) {
            let squared = (0..n).fold(u64::from(x), |x, _| (x * x + (1 << 30)) >> 31);
            prop_assert_eq!(u64::from(power::<Compact>(Cosine::from_bits(x), n).to_bits()), squared);
        }

        /// Vectors of any length, too: a product beyond 1 is 1.
        #[test]
        fn dots_are_rounded_and_clamped(g in prop::array::uniform3(-32767i32..=32767), v in prop::array::uniform3(-32768i32..=32768)) {
            let normal = normalise(g);
            let sum: i64 = normal.g.iter().zip(v).map(|(g, l)| -i64::from(*g) * i64::from(l)).sum();
            prop_assume!(i32::try_from(sum).is_ok());
            let exact = (sum.max(0) * i64::from(normal.r) + (1 << 18)) >> 19;
            prop_assert_eq!(i64::from(dot::<Compact>(normal, v).to_bits()), exact.min(1 << 31));
            let fine: i64 = sum.max(0) << 15;
            let exact = (((fine + (1 << 8)) >> 9) * i64::from(normal.r) + (1 << 24)) >> 25;
            prop_assert_eq!(i64::from(dot::<Wide>(normal, v.map(|c| c << 15)).to_bits()), exact.min(1 << 31));
        }

        #[test]
        fn sums_of_lights_are_clamped(
            c in 0u32..=1 << 15, ambient in 0u32..=1 << 31, lights in 0usize..=8, k in 0u32..=1 << 31, out in any::<bool>(),
        ) {
            // The light and the eye straight ahead of the surface, or behind it: x and y are 1 or 0.
            let ahead = unit([0.0, 0.0, -1.0]);
            let k = Coefficient::from_bits(k);
            let light = Light { direction: ahead, half: ahead, diffuse: [k; 3], specular: [k; 3] };
            let ambient = Coefficient::from_bits(ambient);
            let phong =
                Phong::<Compact>::new([ambient; 3], &std::vec![light; lights], ahead, Highlight::HalfVector, 0).unwrap();
            let normal = Normal { g: [0, 0, if out { -1 } else { 1 } << 14], r: 1 << 21 };
            let x = if out { 0 } else { 1u64 << 16 };
            let sum = lights as u64 * u64::from(keep::<Compact>(k)) * x;
            let m = (((u64::from(keep::<Compact>(ambient)) << 16) + sum + (1 << 14)) >> 15).min(1 << 16);
            let expected = ((u64::from(c) * m + sum + (1 << 15)) >> 16).min(1 << 15);
            prop_assert_eq!(phong.shade(normal, [c; 3]).map(u64::from), [expected; 3]);
        }

        #[test]
        fn rows_are_the_scalar(scene in scene(3), samples in prop::collection::vec(sample(), 0..34)) {
            let phong = make::<Paper>(&scene);
            let column = |f: &dyn Fn(&Sample) -> i32| samples.iter().map(f).collect::<StdVec<_>>();
            let g = [0, 1, 2].map(|a| column(&|s| s.0.g[a]));
            let r = column(&|s| s.0.r as i32);
            let mut c = [0, 1, 2].map(|a| column(&|s| s.1[a] as i32));
            let [cr, cg, cb] = &mut c;
            Shader::<Paper>::shade_row::<i32>(&phong, [&g[0], &g[1], &g[2]], &r, [cr, cg, cb]);
            for (i, (normal, colour)) in samples.iter().enumerate() {
                let out = phong.shade(*normal, *colour).map(|c| c as i32);
                prop_assert_eq!([c[0][i], c[1][i], c[2][i]], out);
            }
        }
    }

    fn within<P: Precision>(
        phong: &Phong<P>,
        normal: Normal,
        colour: [u32; 3],
        bound: f64,
    ) -> Result<(), TestCaseError> {
        // A dot product that rounds to 0 takes its highlight with it; the model's threshold is exact.
        let grazing = phong.lights.iter().any(|l| dot::<P>(normal, l.direction).to_bits() < 4)
            || dot::<P>(normal, phong.viewer).to_bits() < 4;
        if grazing && phong.exponent_log2 < 6 {
            return Ok(());
        }
        let exact = model(phong, normal, colour);
        for (got, exact) in phong.shade(normal, colour).iter().zip(exact) {
            let error = f64::from(*got) - exact * f64::from(P::COLOUR_BITS).exp2();
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
            let u = kept::<Compact>(keep_vector::<Compact>(unit(v)));
            let length = dot64(u, u).sqrt();
            worst = worst.max((length - 1.0).abs());
            assert!(dot64(u, v) > 0.99999999 * length, "{v:?} {u:?}");
            let w = kept::<Wide>(keep_vector::<Wide>(unit(v)));
            assert!((dot64(w, w).sqrt() - 1.0).abs() < 2e-9);
        }
        assert!(worst < 1.5e-5, "{worst}");
        assert_eq!(keep_vector::<Compact>(unit([0.0, -3.0, 0.0])), [0, -32768, 0]);
    }

    #[test]
    fn one_stays_one_and_zero_stays_zero() {
        for n in 0..=8 {
            assert_eq!(power::<Compact>(Cosine::ONE, n), Cosine::ONE);
            assert_eq!(power::<Paper>(Cosine::ONE, n), Cosine::ONE);
            assert_eq!(power::<Compact>(Cosine::ZERO, n), Cosine::ZERO);
        }
    }

    /// A precision of a study: nearest normals of so many bits, and the parabola.
    #[derive(Clone, Copy, Debug, Default)]
    struct Study<const BITS: u32>;

    impl<const BITS: u32> Precision for Study<BITS> {
        type Sample = crate::format::Sample12;
        type Pixel = crate::composite::Truncating15;
        const NAME: &'static str = "study";
        const WEIGHT_BITS: u32 = 16;
        const LERP_BITS: u32 = 16;
        const LERP_ROUNDING: crate::format::Rounding = crate::format::Rounding::Nearest;
        const NORMAL: NormalForm = NormalForm::Nearest(BITS);
        const SHADING: Shading = Shading::Rounded16;
        const POWER: Power = Power::Parabola;
    }

    /// The dot product's bound, in units of the normal's last place.
    fn nearest_dot<const BITS: u32>(normal: Normal, vector: [f64; 3]) -> f64 {
        let kept_vector = keep_vector::<Study<BITS>>(unit(vector));
        let got = dot::<Study<BITS>>(normal, kept_vector).to_num::<f64>();
        let n = normal.g.map(|c| -f64::from(c) * f64::from(normal.r) / 2f64.powi(35));
        let exact = dot64(n, kept::<Study<BITS>>(kept_vector)).clamp(0.0, 1.0);
        (got - exact).abs() * f64::from(1 << BITS)
    }

    proptest! {
        #[test]
        fn nearest_normals_are_within_half_a_unit((normal, _) in sample(), v in vector()) {
            // Three components of half a unit each, weighted by a unit vector: sqrt(3) / 2.
            for error in [nearest_dot::<4>(normal, v), nearest_dot::<10>(normal, v), nearest_dot::<15>(normal, v)] {
                prop_assert!(error <= 0.867, "{error}");
            }
            let mirrored = Normal { g: normal.g.map(|c| -c), ..normal };
            prop_assert_eq!(formed_nearest(mirrored.g, mirrored.r as i32, 9), formed_nearest(normal.g, normal.r as i32, 9).map(|c| -c));
        }

        #[test]
        fn rows_of_a_study_are_the_scalar(scene in scene(3), samples in prop::collection::vec(sample(), 0..34)) {
            let phong = make::<Study<6>>(&scene);
            let column = |f: &dyn Fn(&Sample) -> i32| samples.iter().map(f).collect::<StdVec<_>>();
            let g = [0, 1, 2].map(|a| column(&|s| s.0.g[a]));
            let r = column(&|s| s.0.r as i32);
            let mut c = [0, 1, 2].map(|a| column(&|s| s.1[a] as i32));
            let [cr, cg, cb] = &mut c;
            Shader::<Study<6>>::shade_row::<i32>(&phong, [&g[0], &g[1], &g[2]], &r, [cr, cg, cb]);
            for (i, (normal, colour)) in samples.iter().enumerate() {
                let out = phong.shade(*normal, *colour).map(|c| c as i32);
                prop_assert_eq!([c[0][i], c[1][i], c[2][i]], out);
            }
        }
    }

    #[test]
    fn the_parabola_has_its_top_and_its_foot_where_it_should() {
        let at = |x: f64, n: u32| power::<Study<15>>(Cosine::from_num(x), n).to_num::<f64>();
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
        let compact = Phong::<Compact>::new(ambient, &[light], viewer, Highlight::Reflection, 5).unwrap();
        assert_eq!(compact.shade(Normal::default(), white), [1 << 13; 3]);
        // Facing the light: everything.
        assert_eq!(compact.shade(normalise([0, 0, 9]), white), white);
        let wide = Phong::<Wide>::new(ambient, &[light], viewer, Highlight::HalfVector, 8).unwrap();
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
            Phong::<Compact>::new(ambient, lights, unit([0.0, 0.0, 1.0]), Highlight::HalfVector, exponent).err()
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
}
