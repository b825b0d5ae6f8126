//! The opponent's lights: the same Phong terms as `slicecast::shade`, in f32.

use slicecast::format::{Coefficient, Vector};
use slicecast::shade::Highlight;

use slicecast_engine::camera::Material;
use slicecast_engine::simd::floats::Floats;

/// Lights and material.
#[derive(Clone, Debug)]
pub struct FloatPhong {
    ambient: [f32; 3],
    lights: Vec<Source>,
    viewer: [f32; 3],
    highlight: Highlight,
    exponent_log2: u32,
    /// The least cosine whose power counts.
    least_bright: f32,
    grey: bool,
}

/// A light.
#[derive(Clone, Copy, Debug)]
struct Source {
    direction: [f32; 3],
    half: [f32; 3],
    /// V.L.
    along: f32,
    diffuse: [f32; 3],
    specular: [f32; 3],
}

fn vector(v: [Vector; 3]) -> [f32; 3] {
    v.map(|c| c.to_bits() as f32 / 1_073_741_824.0)
}

fn coefficients(k: [Coefficient; 3]) -> [f32; 3] {
    k.map(|k| k.to_bits() as f32 / 2_147_483_648.0)
}

impl FloatPhong {
    /// The lights of a scene that the pipeline takes.
    pub fn of(material: &Material) -> Self {
        let viewer = vector(material.viewer);
        let lights: Vec<Source> = (material.lights.iter())
            .map(|light| {
                let direction = vector(light.direction);
                Source {
                    direction,
                    half: vector(light.half),
                    along: viewer.iter().zip(direction).map(|(v, l)| v * l).sum(),
                    diffuse: coefficients(light.diffuse),
                    specular: coefficients(light.specular),
                }
            })
            .collect();
        let ambient = coefficients(material.ambient);
        let equal = |[r, g, b]: [f32; 3]| r == g && g == b;
        Self {
            grey: equal(ambient) && lights.iter().all(|l| equal(l.diffuse) && equal(l.specular)),
            ambient,
            lights,
            viewer,
            highlight: material.highlight,
            exponent_log2: material.exponent_log2,
            least_bright: (-20.0 / f32::from(1u16 << material.exponent_log2)).exp2(),
        }
    }

    /// Colours under the lights. `normal` has length 1, or 0 where there is no gradient.
    #[inline(always)]
    pub(super) fn shade<F: Floats>(&self, normal: [F; 3], colour: [F; 3]) -> [F; 3] {
        let [red, green, blue] = colour;
        if self.grey {
            let [sum] = self.lighting::<F, 1>(normal);
            [lit(red, sum), lit(green, sum), lit(blue, sum)]
        } else {
            let [a, b, c] = self.lighting::<F, 3>(normal);
            [lit(red, a), lit(green, b), lit(blue, c)]
        }
    }

    /// What the first `N` channels receive from all lights: diffuse (with ambient) and specular.
    #[inline(always)]
    fn lighting<F: Floats, const N: usize>(&self, normal: [F; 3]) -> [[F; 2]; N] {
        let zero = F::splat(0.0);
        let mut sums = [[zero; 2]; N];
        for (sum, k) in sums.iter_mut().zip(self.ambient) {
            *sum = [F::splat(k), zero];
        }
        let nv = match self.highlight {
            Highlight::HalfVector => zero,
            Highlight::Reflection => cosine(normal, self.viewer),
        };
        for light in &self.lights {
            let nl = cosine(normal, light.direction);
            if !nl.any_positive() {
                continue;
            }
            let base = match self.highlight {
                Highlight::HalfVector => cosine(normal, light.half),
                Highlight::Reflection => {
                    let reflected = (nv + nv).times_plus(nl, F::splat(-light.along));
                    nv.positive_then(reflected.at_least(zero).at_most(F::splat(1.0)))
                }
            };
            for ([d, _], kd) in sums.iter_mut().zip(light.diffuse) {
                *d = nl.times_plus(F::splat(kd), *d);
            }
            let mut y = nl.positive_then(base);
            // A power below 2^-20 shows in no picture and is not formed.
            y = y.at_least_then(F::splat(self.least_bright), y);
            if !y.any_positive() {
                continue;
            }
            for _ in 0..self.exponent_log2 {
                y = y * y;
            }
            for ([_, s], ks) in sums.iter_mut().zip(light.specular) {
                *s = y.times_plus(F::splat(ks), *s);
            }
        }
        sums
    }
}

/// `max(0, N . L)`.
#[inline(always)]
fn cosine<F: Floats>([x, y, z]: [F; 3], [lx, ly, lz]: [f32; 3]) -> F {
    let sum = x.times_plus(F::splat(lx), y.times_plus(F::splat(ly), z * F::splat(lz)));
    sum.at_least(F::splat(0.0))
}

/// The colour under this sum of light.
#[inline(always)]
fn lit<F: Floats>(colour: F, [diffuse, specular]: [F; 2]) -> F {
    let one = F::splat(1.0);
    colour.times_plus(diffuse.at_most(one), specular).at_most(one)
}
