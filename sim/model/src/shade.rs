//! Shading: Phong's illumination in the frame (i, j, k).
//!
//! Source: paper, section 4.2, equation 10, per colour channel, with directional lights and white ambient light:
//!
//! ```text
//! C = min(1, O min(1, ka + kd sum I (N.L)+) + ks sum I spec)
//! spec = ((R.L)+)^(2^n)   R.L = 2 (N.V)(N.L) - V.L      (the paper's form)
//! spec = ((N.H)+)^(2^n)   H = (L + V) / |L + V|          (half-vector form)
//! ```
//!
//! ()+ is the paper's culling of surfaces that face away: negative scalar products count as zero, and there is no
//! highlight where N.L <= 0 or (first form) N.V <= 0. The two clamps are the project's: the paper clamps each sum of
//! its equation instead and takes ka + kd + ks = 1 for granted.
//!
//! All vectors are unit vectors in world directions along i, j, k; the frame may be left-handed, which scalar
//! products do not see. Intensities, coefficients and colours are 0 to 1.

use super::modulation::Weights;
use super::rays::Geometry;
use super::vector::{add, dot, scale, unit};
use slicecast_scene::{CameraAxes, Frame, Highlight, Lighting};

/// A directional light, resolved into the frame (i, j, k).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolvedLight {
    /// L: unit vector towards the light.
    pub direction: [f64; 3],
    /// H: the unit vector half-way between light and viewer; zero if they are opposite. Used by
    /// [`Highlight::HalfVector`] only.
    pub half: [f64; 3],
    /// V.L: how far the light stands behind the viewer. Used by [`Highlight::Reflection`] only.
    pub viewer_dot: f64,
    /// I: red, green, blue intensity.
    pub colour: [f64; 3],
}

/// Lights and material in the frame (i, j, k). The fields may be replaced, for instance by a pipeline's rounded
/// vectors and coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// ka.
    pub ambient: f64,
    /// kd.
    pub diffuse: f64,
    /// ks.
    pub specular: f64,
    /// n: the specular exponent is 2^n.
    pub exponent_log2: u32,
    /// The form of the specular term.
    pub highlight: Highlight,
    /// V: unit vector towards the viewer, against the viewing direction.
    pub viewer: [f64; 3],
    /// The lights.
    pub lights: Vec<ResolvedLight>,
}

/// The scalar products and powers of one light on one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTerms {
    /// (N.L)+, the diffuse term, 0 to 1.
    pub diffuse: f64,
    /// The specular term before its exponent, 0 to 1: (R.L)+ or (N.H)+, zero without a highlight.
    pub base: f64,
    /// `base^(2^n)`.
    pub specular: f64,
}

impl Lights {
    /// Turns a scene's lights into the frame of a view. Directions are taken as written, without normalising them.
    pub fn new(lighting: &Lighting, camera: &CameraAxes, geometry: &Geometry) -> Self {
        let viewer = geometry.to_frame(scale(camera.forward, -1.0));
        let resolve = |light: &slicecast_scene::Light| {
            let direction = geometry.to_frame(match light.frame {
                Frame::Volume => light.direction,
                Frame::Camera => from_camera(light.direction, camera),
            });
            ResolvedLight {
                direction,
                half: unit(add(direction, viewer)),
                viewer_dot: dot(viewer, direction),
                colour: light.colour,
            }
        };
        Self {
            ambient: lighting.ambient,
            diffuse: lighting.diffuse,
            specular: lighting.specular,
            exponent_log2: lighting.exponent_log2,
            highlight: lighting.highlight,
            viewer,
            lights: lighting.lights.iter().map(resolve).collect(),
        }
    }

    /// The same lights with the viewer elsewhere: V, a unit vector.
    #[must_use]
    pub fn seen_from(&self, viewer: [f64; 3]) -> Self {
        let seen = |light: &ResolvedLight| ResolvedLight {
            half: unit(add(light.direction, viewer)),
            viewer_dot: dot(viewer, light.direction),
            ..*light
        };
        Self {
            viewer,
            lights: self.lights.iter().map(seen).collect(),
            ..self.clone()
        }
    }

    /// What one light does on a surface of normal N (unit, or zero: then nothing).
    pub fn terms(&self, light: &ResolvedLight, normal: [f64; 3]) -> LightTerms {
        let n_l = dot(normal, light.direction);
        let base = match self.highlight {
            _ if n_l <= 0.0 => 0.0,
            Highlight::Reflection => reflection(dot(normal, self.viewer), n_l, light.viewer_dot),
            Highlight::HalfVector => dot(normal, light.half).clamp(0.0, 1.0),
        };
        LightTerms {
            diffuse: n_l.max(0.0),
            base,
            specular: to_power_of_two(base, self.exponent_log2),
        }
    }

    /// The light that a surface of normal N and colour O sends to the viewer: the equation at the head of this file.
    pub fn shade(&self, normal: [f64; 3], colour: [f64; 3]) -> [f64; 3] {
        self.shade_weighed(normal, colour, Weights::ONE)
    }

    /// The same with weights of diffuse and specular light.
    pub fn shade_weighed(&self, normal: [f64; 3], colour: [f64; 3], weights: Weights) -> [f64; 3] {
        let mut coloured = [self.ambient; 3];
        let mut highlight = [0.0; 3];
        for light in &self.lights {
            let terms = self.terms(light, normal);
            for c in 0..3 {
                coloured[c] += weights.diffuse * self.diffuse * light.colour[c] * terms.diffuse;
                highlight[c] += weights.specular * self.specular * light.colour[c] * terms.specular;
            }
        }
        [0, 1, 2].map(|c| (colour[c] * coloured[c].min(1.0) + highlight[c]).min(1.0))
    }
}

/// A direction given as right, up, towards the viewer, in the volume's x, y, z.
fn from_camera(d: [f64; 3], camera: &CameraAxes) -> [f64; 3] {
    let across = add(scale(camera.right, d[0]), scale(camera.up, d[1]));
    add(across, scale(camera.forward, -d[2]))
}

/// (R.L)+ from the three scalar products: R = 2 (N.V) N - V is the viewer's direction mirrored at the normal.
/// Clamped to 0 to 1; zero where the surface faces away from the viewer.
pub fn reflection(n_v: f64, n_l: f64, v_l: f64) -> f64 {
    if n_v <= 0.0 {
        return 0.0;
    }
    (2.0 * n_v * n_l - v_l).clamp(0.0, 1.0)
}

/// `x^(2^n)` by n squarings (paper, section 4.2.2).
pub fn to_power_of_two(x: f64, n: u32) -> f64 {
    (0..n).fold(x, |p, _| p * p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{SAMPLING_ONCE, close};
    use slicecast_scene::{Light, View};

    const VIEWER: [f64; 3] = [0.0, 0.0, -1.0];

    fn one_light(highlight: Highlight, n: u32, direction: [f64; 3]) -> Lights {
        Lights {
            ambient: 0.1,
            diffuse: 0.5,
            specular: 0.3,
            exponent_log2: n,
            highlight,
            viewer: VIEWER,
            lights: vec![ResolvedLight {
                direction,
                half: unit(add(direction, VIEWER)),
                viewer_dot: dot(VIEWER, direction),
                colour: [1.0, 0.5, 0.0],
            }],
        }
    }

    /// In the plane of V = angle 0: with N at angle a and L at angle b, N.L = cos(a - b), R stands at 2a, so
    /// R.L = cos(2a - b); H stands at b / 2, so N.H = cos(a - b / 2).
    fn at_angle(degrees: f64) -> [f64; 3] {
        let (s, c) = degrees.to_radians().sin_cos();
        [s, 0.0, -c]
    }

    #[test]
    fn both_highlights_by_angles() {
        for (a, b) in [(0.0, 0.0), (20.0, 50.0), (-30.0, 10.0), (60.0, 89.0), (44.0, 85.0)] {
            for n in [0, 1, 4, 8] {
                let power = f64::powi;
                let cos = |d: f64| d.to_radians().cos();
                let lights = one_light(Highlight::Reflection, n, at_angle(b));
                let terms = lights.terms(&lights.lights[0], at_angle(a));
                assert!((terms.diffuse - cos(a - b)).abs() < 1e-15);
                assert!((terms.specular - power(cos(2.0 * a - b).max(0.0), 1 << n)).abs() < 1e-13);
                let lights = one_light(Highlight::HalfVector, n, at_angle(b));
                let terms = lights.terms(&lights.lights[0], at_angle(a));
                assert!(
                    (terms.specular - power(cos(a - b / 2.0), 1 << n)).abs() < 1e-13,
                    "{a} {b} {n}"
                );
            }
        }
    }

    #[test]
    fn no_highlight_on_surfaces_that_face_away() {
        for highlight in [Highlight::Reflection, Highlight::HalfVector] {
            let lights = one_light(highlight, 0, at_angle(80.0));
            // 11 degrees past the light's horizon, still facing the viewer.
            let terms = lights.terms(&lights.lights[0], at_angle(-21.0));
            assert_eq!((terms.diffuse, terms.base, terms.specular), (0.0, 0.0, 0.0));
            close(lights.shade(at_angle(-21.0), [1.0, 0.8, 0.0]), [0.1, 0.08, 0.0], 1e-15);
            // No gradient: ambient only.
            close(lights.shade([0.0; 3], [1.0, 0.8, 0.0]), [0.1, 0.08, 0.0], 1e-15);
        }
        // Lit, but turned from the viewer: R.L = cos(2 * 100 - 150) > 0 is not seen.
        let lights = one_light(Highlight::Reflection, 0, at_angle(150.0));
        assert_eq!(lights.terms(&lights.lights[0], at_angle(100.0)).base, 0.0);
        // A light opposite to the viewer has no half vector.
        let lights = one_light(Highlight::HalfVector, 0, [0.0, 0.0, 1.0]);
        assert_eq!(lights.shade([0.0, 0.0, 1.0], [1.0; 3]), [0.6, 0.35, 0.1]);
    }

    #[test]
    fn the_sum_per_channel_and_its_clamps() {
        // N = L = V: every product is 1.
        let mut lights = one_light(Highlight::Reflection, 4, VIEWER);
        close(
            lights.shade(VIEWER, [0.5, 0.5, 0.5]),
            [0.5 * 0.6 + 0.3, 0.5 * 0.35 + 0.15, 0.05],
            1e-15,
        );
        lights.lights.push(lights.lights[0]);
        lights.lights[1].colour = [0.0, 0.0, 1.0];
        close(
            lights.shade(VIEWER, [0.5, 0.5, 0.5]),
            [0.6, 0.325, 0.5 * 0.6 + 0.3],
            1e-15,
        );
        // The coloured part saturates before it meets O, the sum after.
        lights.diffuse = 1.0;
        close(
            lights.shade(VIEWER, [0.5, 0.5, 0.9]),
            [0.8, 0.5 * 0.6 + 0.15, 1.0],
            1e-15,
        );
    }

    #[test]
    fn squaring_is_the_power() {
        for q in (0..=65536).step_by(97) {
            let x = f64::from(q) / 65536.0;
            for n in 0..=8 {
                assert!(
                    (to_power_of_two(x, n) - x.powi(1 << n)).abs() <= 3e-14 * x.powi(1 << n),
                    "{x} {n}"
                );
            }
        }
        // The numeric study's section 6, P, units of 2^-16.
        for (x, six, eight) in [
            (65535.0, 65472.0308, 65280.4974),
            (65282.0, 51114.6326, 24251.6438),
            (64349.0, 20344.1577, 608.5819),
        ] {
            assert!((to_power_of_two(x / 65536.0, 6) * 65536.0 - six).abs() < 5.1e-5);
            assert!((to_power_of_two(x / 65536.0, 8) * 65536.0 - eight).abs() < 5.1e-5);
        }
    }

    #[test]
    fn lights_turn_into_the_frame() {
        // From the right of a patient: looking along -x, the picture's right is +y, its up is +z.
        let camera = View {
            azimuth: 90.0,
            elevation: 0.0,
            roll: 0.0,
        }
        .axes();
        assert_eq!(camera.forward, [-1.0, 0.0, 0.0]);
        let geometry = Geometry::new(camera.forward, [4; 3], [1.0, 2.0, 0.5], SAMPLING_ONCE);
        let light = |direction, frame| Light {
            direction,
            frame,
            colour: [1.0; 3],
        };
        let lighting = Lighting {
            ambient: 0.2,
            diffuse: 0.3,
            specular: 0.4,
            exponent_log2: 5,
            highlight: Highlight::HalfVector,
            lights: vec![
                light([0.6, 0.0, 0.8], Frame::Camera),
                light([0.0, 0.6, 0.8], Frame::Camera),
                light([0.48, 0.6, 0.64], Frame::Volume),
            ],
        };
        let lights = Lights::new(&lighting, &camera, &geometry);
        // Frame: i = y, j = z, k = -x. The viewer stands at +x, that is at -k.
        assert_eq!(lights.viewer, [0.0, 0.0, -1.0]);
        close(lights.lights[0].direction, [0.6, 0.0, -0.8], 1e-15);
        close(lights.lights[1].direction, [0.0, 0.6, -0.8], 1e-15);
        close(lights.lights[2].direction, [0.6, 0.64, -0.48], 1e-15);
        assert!((lights.lights[0].viewer_dot - 0.8).abs() < 1e-15);
        // Half-way between (0.6, 0, -0.8) and (0, 0, -1): (1, 0, -3) / sqrt 10.
        close(lights.lights[0].half, [0.1_f64.sqrt(), 0.0, -0.9_f64.sqrt()], 1e-15);
    }
}
