//! Modulation: factors of opacity and light by the magnitude of the gradient.
//!
//! Source: VolumePro (Pfister et al. 1999). A factor is a function of |grad f|, linear between the scene's points and
//! constant outside: `a' = a f_o(|grad f|)`, diffuse light times f_d, specular light times f_s. Ambient light is not modulated.

use slicecast_scene::modulation::Modulation;

/// The factors of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Of its opacity.
    pub opacity: f64,
    /// Of diffuse light.
    pub diffuse: f64,
    /// Of specular light.
    pub specular: f64,
}

impl Weights {
    /// 1 each.
    pub const ONE: Self = Self {
        opacity: 1.0,
        diffuse: 1.0,
        specular: 1.0,
    };

    /// Those of a magnitude, values per unit of length.
    pub fn of(modulation: &Modulation, magnitude: f64) -> Self {
        Self {
            opacity: at(&modulation.opacity, magnitude),
            diffuse: at(&modulation.diffuse, magnitude),
            specular: at(&modulation.specular, magnitude),
        }
    }
}

/// A function of points at a magnitude; without points it is 1.
fn at(points: &[[f64; 2]], magnitude: f64) -> f64 {
    let (Some([first, low]), Some([last, high])) = (points.first(), points.last()) else {
        return 1.0;
    };
    if magnitude <= *first {
        return *low;
    }
    if magnitude >= *last {
        return *high;
    }
    let between = points.windows(2).find(|pair| magnitude <= pair[1][0]);
    between.map_or(*high, |pair| {
        let t = (magnitude - pair[0][0]) / (pair[1][0] - pair[0][0]);
        (1.0 - t) * pair[0][1] + t * pair[1][1]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{scene_along, volume_of};
    use crate::{Model, Pixel};

    #[test]
    fn factors_go_through_their_points() {
        let points = [[1.0, 0.25], [3.0, 0.75], [4.0, 0.0]];
        let cases = [
            (0.0, 0.25),
            (1.0, 0.25),
            (2.0, 0.5),
            (3.0, 0.75),
            (3.5, 0.375),
            (4.0, 0.0),
            (9.0, 0.0),
        ];
        for (magnitude, expected) in cases {
            assert!((at(&points, magnitude) - expected).abs() < 1e-15);
        }
        assert_eq!(at(&[], 7.0), 1.0);
    }

    /// A ramp along x of 10 codes a voxel: its magnitude is 10 values per unit of length, whatever the direction of the view, and the
    /// factor that of 10.
    #[test]
    fn a_ramp_has_one_factor() {
        let mut volume = volume_of([7, 7, 7], |x, _, _| 10 * x);
        for (spacing, scale, direction) in [
            ([1.0; 3], 1.0, [0.0, 0.0, 1.0]),
            ([1.0; 3], -3.0, [0.3, -0.2, 1.0]),
            ([2.0, 1.0, 4.0], 1.0, [1.0, 0.0, 0.2]),
        ] {
            volume.spacing = spacing;
            volume.mapping.scale = scale;
            let steep = 10.0 * f64::abs(scale) / spacing[0];
            let mut scene = scene_along(direction, &[(-1000.0, 0.1), (1000.0, 0.1)]);
            scene.transfer.unit_distance = 1.0;
            let plain = Model::natural(&scene, &volume).ray(3, 3);
            scene.modulation = Some(Modulation {
                opacity: vec![[0.0, 0.0], [2.0 * steep, 1.0]],
                ..Modulation::default()
            });
            let halved = Model::natural(&scene, &volume);
            let expected = (0..halved.planes())
                .filter(|plane| halved.place(*plane, 3, 3).is_some())
                .fold(Pixel::TRANSPARENT, |pixel, _| {
                    let step = halved.geometry().step_length();
                    pixel.front_to_back([1.0; 3], 0.5 * (1.0 - 0.9f64.powf(step)))
                });
            let found = halved.ray(3, 3);
            assert!(
                (found.transparency - expected.transparency).abs() < 1e-12,
                "{spacing:?}"
            );
            assert!(plain.transparency < found.transparency);
        }
    }
}
