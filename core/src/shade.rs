//! Shading: the colour of a sample under the scene's lights.
//!
//! Source: Squeeze, equations 10 and 11; reflection-vector form as there, or the half-vector form. Lights are
//! directional and the projection is parallel, so every vector but the normal is constant over a frame.
//!
//! | value | format | range |
//! |---|---|---|
//! | g, r | `normalise` | normal N = -g r / 2^35 (towards lower values) |
//! | light L, half vector H, viewer V | s1.15 | -1 to 1 |
//! | dot x | 1.31, `min(1, (d r + 2^18) >> 19)` with d = max(0, -(g . L)) | 0 to 1 |
//! | power x^(2^n) | 1.31, n times `x = (x x + 2^30) >> 31` | 0 to 1, 1 stays 1 |
//! | coefficients ka, kd_i, ks_i | 1.15, a channel each (coefficient times light) | 0 to 1 |
//! | diffuse sum m | 1.16, `min(1, (2^16 ka + sum kd_i x_i + 2^14) >> 15)` with x in 1.16 | 0 to 1 |
//! | colour c | 1.15, `min(1, (O m + sum ks_i y_i + 2^15) >> 16)` with y in 1.16 | 0 to 1 |
//!
//! A highlight needs light on the surface: y = 0 where N.L <= 0 (and, for the reflection, where N.V <= 0).
//! Reflection: R.L = 2 (N.V)(N.L) - V.L. Sums of 8 lights saturate at 2^32 - 1 and are clamped to 1.
//! Error against f64 on the same g, r, O: at most 1.0 ulp of 1.15 while ka + kd + ks <= 1, whatever the exponent and
//! the number of lights. `Paper` truncates instead: N to 1.12, every product to 16.16. State: none.

use heapless::Vec;

use crate::format::{Cosine, Intensity, Rounding, Unit};
use crate::normalise::Normal;
use crate::precision::{NormalForm, Precision};

/// The largest number of lights.
pub const LIGHTS_MAX: usize = 8;
/// The largest log2 of a specular exponent (256).
pub const EXPONENT_LOG2_MAX: u32 = 8;

/// Turns a classified colour into the one that is composited.
pub trait Shader<P: Precision>: Sync {
    /// Whether normals are read. Without them the pipeline holds no gradient rows and two slices instead of four.
    const LIT: bool;

    /// Shades the colours of a row in place. Five rows of equal length: components of g, r, and colours 1.15.
    fn shade_row(&self, g: [&[i32]; 3], r: &[i32], colour: [&mut [i32]; 3]);
}

/// No lights: the classified colour is the colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unlit;

impl<P: Precision> Shader<P> for Unlit {
    const LIT: bool = false;

    #[inline(always)]
    fn shade_row(&self, _: [&[i32]; 3], _: &[i32], _: [&mut [i32]; 3]) {}
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
    pub direction: [Unit; 3],
    /// Unit vector half way between the light and the viewer; read by [`Highlight::HalfVector`] only.
    pub half: [Unit; 3],
    /// Diffuse coefficient times the light's red, green, blue.
    pub diffuse: [Intensity; 3],
    /// Specular coefficient times the light's red, green, blue.
    pub specular: [Intensity; 3],
}

/// Phong illumination by up to eight lights.
#[derive(Clone, Debug)]
pub struct Phong {
    ambient: [Intensity; 3],
    lights: Vec<Light, LIGHTS_MAX>,
    viewer: [Unit; 3],
    /// V.L of each light.
    along: [i64; LIGHTS_MAX],
    highlight: Highlight,
    exponent_log2: u32,
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
        /// The component's bits, s1.15.
        bits: i32,
    },
    /// A coefficient is above 1.
    Coefficient {
        /// The coefficient's bits, 1.15.
        bits: u16,
    },
}

impl core::fmt::Display for PhongError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Lights { given } => write!(f, "{given} lights; accepted: at most {LIGHTS_MAX}"),
            Self::Exponent { given } => {
                write!(f, "an exponent of 2^{given}; accepted: at most 2^{EXPONENT_LOG2_MAX}")
            }
            Self::Vector { bits } => write!(f, "a vector component of {bits}/32768; accepted: -32768 to 32768"),
            Self::Coefficient { bits } => write!(f, "a coefficient of {bits}/32768; accepted: at most 32768"),
        }
    }
}

impl core::error::Error for PhongError {}

impl Phong {
    /// Lights and material. `viewer` is the unit vector towards the eye, in the slice frame; the highlight's exponent
    /// is `2^exponent_log2`.
    ///
    /// # Errors
    /// [`PhongError`], with the value that is out of range.
    pub fn new(
        ambient: [Intensity; 3],
        lights: &[Light],
        viewer: [Unit; 3],
        highlight: Highlight,
        exponent_log2: u32,
    ) -> Result<Self, PhongError> {
        if exponent_log2 > EXPONENT_LOG2_MAX {
            return Err(PhongError::Exponent { given: exponent_log2 });
        }
        let vectors = lights.iter().flat_map(|l| [l.direction, l.half]).chain([viewer]);
        for component in vectors.flatten() {
            if component.unsigned_abs() > Unit::ONE.unsigned_abs() {
                return Err(PhongError::Vector {
                    bits: component.to_bits(),
                });
            }
        }
        let coefficients = lights.iter().flat_map(|l| [l.diffuse, l.specular]).chain([ambient]);
        for coefficient in coefficients.flatten() {
            if coefficient > Intensity::ONE {
                return Err(PhongError::Coefficient {
                    bits: coefficient.to_bits(),
                });
            }
        }
        let mut along_viewer = [0; LIGHTS_MAX];
        for (vl, light) in along_viewer.iter_mut().zip(lights) {
            *vl = along(viewer, light.direction);
        }
        Ok(Self {
            ambient,
            along: along_viewer,
            lights: Vec::from_slice(lights).map_err(|_| PhongError::Lights { given: lights.len() })?,
            viewer,
            highlight,
            exponent_log2,
        })
    }

    /// The lights, as the pipeline sees them.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Unit vector towards the eye.
    pub const fn viewer(&self) -> [Unit; 3] {
        self.viewer
    }

    /// Ambient coefficient, a channel each.
    pub const fn ambient(&self) -> [Intensity; 3] {
        self.ambient
    }

    /// Colour of a sample with this normal and classified colour. This function is the definition.
    #[inline]
    pub fn shade<P: Precision>(&self, normal: Normal, colour: [Intensity; 3]) -> [Intensity; 3] {
        match P::SHADE_ROUNDING {
            Rounding::Nearest => self.shade_nearest::<P>(normal, colour),
            Rounding::Truncate => self.shade_truncated::<P>(normal, colour),
        }
    }

    #[inline]
    fn shade_nearest<P: Precision>(&self, normal: Normal, colour: [Intensity; 3]) -> [Intensity; 3] {
        let mut diffuse = self.ambient.map(|k| u32::from(k.to_bits()) << 16);
        let mut specular = [0u32; 3];
        let nv = self.facing::<P>(normal);
        for (light, vl) in self.lights.iter().zip(&self.along) {
            let (nl, y) = self.cosines::<P>(normal, light, nv, *vl);
            let (x16, y16) = (to_16(nl), to_16(y));
            add_products(&mut diffuse, light.diffuse, x16);
            add_products(&mut specular, light.specular, y16);
        }
        let mut out = [Intensity::ZERO; 3];
        for (((o, c), d), s) in out.iter_mut().zip(colour).zip(diffuse).zip(specular) {
            let m = (d.saturating_add(1 << 14) >> 15).min(1 << 16);
            let sum = (u32::from(c.to_bits()) * m).saturating_add(s).saturating_add(1 << 15);
            *o = Intensity::from_bits((sum >> 16).min(1 << 15) as u16);
        }
        out
    }

    /// Squeeze to the letter: 16.16, every product truncated.
    #[inline]
    fn shade_truncated<P: Precision>(&self, normal: Normal, colour: [Intensity; 3]) -> [Intensity; 3] {
        let mut diffuse = self.ambient.map(|k| u32::from(k.to_bits()) << 1);
        let mut specular = [0u32; 3];
        let nv = self.facing::<P>(normal);
        for (light, vl) in self.lights.iter().zip(&self.along) {
            let (nl, y) = self.cosines::<P>(normal, light, nv, *vl);
            let (x16, y16) = (nl.to_bits() >> 15, y.to_bits() >> 15);
            for (((d, s), kd), ks) in diffuse
                .iter_mut()
                .zip(&mut specular)
                .zip(light.diffuse)
                .zip(light.specular)
            {
                *d += scale15(kd, x16);
                *s += scale15(ks, y16);
            }
        }
        let mut out = [Intensity::ZERO; 3];
        for (((o, c), d), s) in out.iter_mut().zip(colour).zip(diffuse).zip(specular) {
            let sum = scale15(c, d.min(1 << 16)) + s;
            *o = Intensity::from_bits((sum >> 1).min(1 << 15) as u16);
        }
        out
    }

    /// N.V, where the highlight asks for it.
    #[inline(always)]
    fn facing<P: Precision>(&self, normal: Normal) -> Cosine {
        match self.highlight {
            Highlight::HalfVector => Cosine::ZERO,
            Highlight::Reflection => dot::<P>(normal, self.viewer),
        }
    }

    /// N.L and the highlight of one light, given N.V and V.L.
    #[inline]
    fn cosines<P: Precision>(&self, normal: Normal, light: &Light, nv: Cosine, vl: i64) -> (Cosine, Cosine) {
        let nl = dot::<P>(normal, light.direction);
        if nl == Cosine::ZERO {
            return (nl, Cosine::ZERO);
        }
        let base = match self.highlight {
            Highlight::HalfVector => dot::<P>(normal, light.half),
            Highlight::Reflection if nv == Cosine::ZERO => Cosine::ZERO,
            Highlight::Reflection => reflected_off::<P>(nv, nl, vl),
        };
        (nl, power::<P>(base, self.exponent_log2))
    }
}

impl<P: Precision> Shader<P> for Phong {
    const LIT: bool = true;

    #[inline]
    fn shade_row(&self, g: [&[i32]; 3], r: &[i32], colour: [&mut [i32]; 3]) {
        let [gx, gy, gz] = g;
        let [red, green, blue] = colour;
        let normals = gx.iter().zip(gy).zip(gz).zip(r);
        for ((((r, g), b), (((x, y), z), norm)), _) in red.iter_mut().zip(green).zip(blue).zip(normals).zip(0..) {
            let normal = Normal {
                g: [*x, *y, *z],
                r: *norm as u32,
            };
            let c = [*r, *g, *b].map(|c| Intensity::from_bits(c as u16));
            [*r, *g, *b] = self.shade::<P>(normal, c).map(|c| i32::from(c.to_bits()));
        }
    }
}

/// `max(0, N . L)` with N = -g r / 2^35, 1.31. `Formed` normals are truncated first, and so are their products, at 16
/// fraction bits.
#[inline]
pub fn dot<P: Precision>(normal: Normal, vector: [Unit; 3]) -> Cosine {
    match P::NORMAL {
        NormalForm::Deferred => {
            let mut sum = 0i32;
            for (g, l) in normal.g.iter().zip(vector) {
                // |sum| <= sqrt(3) * 32767 * 32768 < 2^31 for unit vectors; wrapping keeps others from a panic.
                sum = sum.wrapping_sub(g.wrapping_mul(l.to_bits()));
            }
            // d r <= 2^35 |L| with |L| <= sqrt(3) 2^15: the shifted product fits 32 bits.
            let product = u64::from(sum.max(0) as u32) * u64::from(normal.r);
            Cosine::from_bits((((product + (1 << 18)) >> 19) as u32).min(1 << 31))
        }
        NormalForm::Formed(bits) => {
            let mut sum = 0i32;
            for (g, l) in normal.g.iter().zip(vector) {
                let magnitude = ((u64::from(g.unsigned_abs()) * u64::from(normal.r)) >> (35 - bits)) as i32;
                let n = if *g > 0 { -magnitude } else { magnitude };
                // bits + 15 fraction bits, truncated to 16.
                sum += (n * l.to_bits()) >> (bits - 1);
            }
            Cosine::from_bits((sum.clamp(0, 1 << 16) as u32) << 15)
        }
    }
}

/// R.L = 2 (N.V)(N.L) - V.L, 0 to 1, and 0 where N.V or N.L is 0.
#[inline]
pub fn reflected<P: Precision>(nv: Cosine, nl: Cosine, viewer: [Unit; 3], light: [Unit; 3]) -> Cosine {
    if nv == Cosine::ZERO || nl == Cosine::ZERO {
        return Cosine::ZERO;
    }
    reflected_off::<P>(nv, nl, along(viewer, light))
}

/// V.L, s2.30.
fn along(viewer: [Unit; 3], light: [Unit; 3]) -> i64 {
    let products = viewer.iter().zip(light);
    products
        .map(|(v, l)| i64::from(v.to_bits()) * i64::from(l.to_bits()))
        .sum()
}

/// [`reflected`] with V.L at hand, s2.30, and N.V and N.L above 0.
#[inline(always)]
fn reflected_off<P: Precision>(nv: Cosine, nl: Cosine, vl: i64) -> Cosine {
    let product = u64::from(nv.to_bits()) * u64::from(nl.to_bits());
    let rl = match P::SHADE_ROUNDING {
        Rounding::Nearest => ((product + (1 << 29)) >> 30) as i64 - (vl << 1),
        Rounding::Truncate => ((product >> 45) as i64 - (vl >> 14)) << 15,
    };
    Cosine::from_bits(rl.clamp(0, 1 << 31) as u32)
}

/// `x^(2^n)` by squaring; 1 stays 1. Squeeze, section 4.2.2.
#[inline]
pub fn power<P: Precision>(x: Cosine, n: u32) -> Cosine {
    match P::SHADE_ROUNDING {
        Rounding::Nearest => {
            let mut x = x.to_bits();
            for _ in 0..n {
                x = ((u64::from(x) * u64::from(x) + (1 << 30)) >> 31) as u32;
            }
            Cosine::from_bits(x)
        }
        Rounding::Truncate => {
            let mut x = x.to_bits() >> 15;
            for _ in 0..n {
                x = ((u64::from(x) * u64::from(x)) >> 16) as u32;
            }
            Cosine::from_bits(x << 15)
        }
    }
}

/// 1.31 to 1.16, to nearest.
#[inline(always)]
fn to_16(x: Cosine) -> u32 {
    (x.to_bits() + (1 << 14)) >> 15
}

/// `floor(k * x)` of 1.15 and 1.16 (at most 2^17), in 1.16.
#[inline(always)]
fn scale15(k: Intensity, x: u32) -> u32 {
    ((u64::from(k.to_bits()) * u64::from(x)) >> 15) as u32
}

/// Adds coefficient (1.15) times cosine (1.16) to sums in 1.31.
#[inline(always)]
fn add_products(sums: &mut [u32; 3], coefficients: [Intensity; 3], cosine: u32) {
    for (sum, k) in sums.iter_mut().zip(coefficients) {
        *sum = sum.saturating_add(u32::from(k.to_bits()) * cosine);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normalise::normalise;
    use crate::precision::{Compact, Paper};
    use proptest::prelude::*;
    use std::vec::Vec as StdVec;

    fn unit(v: [f64; 3]) -> [Unit; 3] {
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| Unit::from_bits((c / length * 32768.0).round() as i32))
    }

    fn value(v: [Unit; 3]) -> [f64; 3] {
        v.map(|c| f64::from(c.to_bits()) / 32768.0)
    }

    fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Equation 10 in f64, on the pipeline's own inputs.
    fn model(phong: &Phong, normal: Normal, colour: [Intensity; 3]) -> [f64; 3] {
        let n = normal.g.map(|c| -f64::from(c) * f64::from(normal.r) / 2f64.powi(35));
        let viewer = value(phong.viewer);
        let mut out = [0.0; 3];
        for (c, o) in out.iter_mut().enumerate() {
            let k = |v: [Intensity; 3]| f64::from(v[c].to_bits()) / 32768.0;
            let (mut diffuse, mut specular) = (k(phong.ambient), 0.0);
            for light in &phong.lights {
                let l = value(light.direction);
                let nl = dot64(n, l).clamp(0.0, 1.0);
                let base = match phong.highlight {
                    Highlight::HalfVector => dot64(n, value(light.half)),
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
            *o = (k(colour) * diffuse.min(1.0) + specular).min(1.0);
        }
        out
    }

    fn vector() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-1.0f64..1.0).prop_filter("a direction", |v| dot64(*v, *v) > 0.01)
    }

    prop_compose! {
        fn phong(count: usize)(
            lights in prop::collection::vec((vector(), prop::array::uniform3(0.0f64..1.0)), 1..=count),
            viewer in vector(), exponent in 0u32..=8, reflection in any::<bool>(),
            shares in prop::array::uniform3(0.01f64..1.0),
        ) -> Phong {
            let sum: f64 = shares.iter().sum();
            let [ka, kd, ks] = shares.map(|s| s / sum);
            let each = 1.0 / lights.len() as f64;
            let scaled = |k: f64, i: [f64; 3]| i.map(|i| Intensity::from_bits((k * each * i * 32768.0) as u16));
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
            let ambient = [Intensity::from_bits((ka * 32768.0) as u16); 3];
            Phong::new(ambient, &lights, viewer, highlight, exponent).unwrap()
        }
    }

    type Sample = (Normal, [Intensity; 3]);

    fn sample() -> impl Strategy<Value = Sample> {
        let gradient = prop::array::uniform3(-100_000i32..100_000);
        let colour = prop::array::uniform3(0u16..=32768).prop_map(|c| c.map(Intensity::from_bits));
        (gradient.prop_map(normalise), colour)
    }

    proptest! {
        #[test]
        fn shading_is_within_one_ulp(phong in phong(8), (normal, colour) in sample()) {
            let exact = model(&phong, normal, colour);
            // A dot product that rounds to 0 takes its highlight with it; the model's threshold is exact.
            let grazing = phong.lights.iter().any(|l| dot::<Compact>(normal, l.direction).to_bits() < 4)
                || dot::<Compact>(normal, phong.viewer).to_bits() < 4;
            prop_assume!(!grazing || phong.exponent_log2 > 5);
            for (got, exact) in phong.shade::<Compact>(normal, colour).iter().zip(exact) {
                let error = f64::from(got.to_bits()) - exact * 32768.0;
                prop_assert!(error.abs() <= 1.0 + 1e-3, "{error}");
            }
        }

        #[test]
        fn rows_are_the_scalar(phong in phong(3), samples in prop::collection::vec(sample(), 0..34)) {
            let column = |f: &dyn Fn(&Sample) -> i32| samples.iter().map(f).collect::<StdVec<_>>();
            let g = [0, 1, 2].map(|a| column(&|s| s.0.g[a]));
            let r = column(&|s| s.0.r as i32);
            let mut c = [0, 1, 2].map(|a| column(&|s| i32::from(s.1[a].to_bits())));
            let [cr, cg, cb] = &mut c;
            Shader::<Paper>::shade_row(&phong, [&g[0], &g[1], &g[2]], &r, [cr, cg, cb]);
            for (i, (normal, colour)) in samples.iter().enumerate() {
                let out = phong.shade::<Paper>(*normal, *colour).map(|c| i32::from(c.to_bits()));
                prop_assert_eq!([c[0][i], c[1][i], c[2][i]], out);
            }
        }
    }

    #[test]
    fn one_stays_one_and_zero_stays_zero() {
        for n in 0..=8 {
            assert_eq!(power::<Compact>(Cosine::ONE, n), Cosine::ONE);
            assert_eq!(power::<Paper>(Cosine::ONE, n), Cosine::ONE);
            assert_eq!(power::<Compact>(Cosine::ZERO, n), Cosine::ZERO);
        }
    }

    #[test]
    fn no_gradient_means_ambient_light_only() {
        let light = Light {
            direction: unit([0.0, 0.0, -1.0]),
            half: unit([0.0, 0.0, -1.0]),
            diffuse: [Intensity::from_bits(16384); 3],
            specular: [Intensity::from_bits(8192); 3],
        };
        let ambient = [Intensity::from_bits(8192); 3];
        let phong = Phong::new(ambient, &[light], unit([0.0, 0.0, -1.0]), Highlight::Reflection, 5).unwrap();
        let white = [Intensity::ONE; 3];
        assert_eq!(phong.shade::<Compact>(Normal::default(), white), ambient);
        // Facing the light: everything.
        assert_eq!(phong.shade::<Compact>(normalise([0, 0, 9]), white), [Intensity::ONE; 3]);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let light = Light {
            direction: unit([0.0, 0.0, 1.0]),
            half: unit([0.0, 0.0, 1.0]),
            diffuse: [Intensity::ONE; 3],
            specular: [Intensity::ZERO; 3],
        };
        let make = |lights: &[Light], ambient: u16, exponent| {
            let ambient = [Intensity::from_bits(ambient); 3];
            Phong::new(ambient, lights, unit([0.0, 0.0, 1.0]), Highlight::HalfVector, exponent).err()
        };
        assert_eq!(make(&[light; 9], 0, 0), Some(PhongError::Lights { given: 9 }));
        assert_eq!(make(&[light], 0, 9), Some(PhongError::Exponent { given: 9 }));
        assert_eq!(make(&[light], 32769, 0), Some(PhongError::Coefficient { bits: 32769 }));
        let long = Light {
            half: [Unit::from_bits(-32769), Unit::ZERO, Unit::ZERO],
            ..light
        };
        assert_eq!(make(&[long], 0, 0), Some(PhongError::Vector { bits: -32769 }));
        assert_eq!(make(&[light; 8], 32768, 8), None);
    }
}
