//! An opaque voxel in a clear volume, sampled by extinctions and by opacities.
//!
//! Source: Kraus and Bürger, section 3.6 and figure 7: scattered, opaque voxels, of which opacities show stronger diamond-shaped
//! artefacts and a greater variation of intensity from view to view. Rays of one direction cross the voxel's eight cells; their samples lie d
//! = 1 apart on planes across them, at any phase, and are interpolated trilinearly, d' = d.

use serde::Serialize;

use super::rays::Sampling;

/// Extinctions of the voxel.
pub const TAUS: [f64; 2] = [4.0, 8.0];

/// Directions, spread evenly over half the sphere.
const VIEWS: u32 = 120;
/// Phases of the planes.
const PHASES: u32 = 8;
/// Pixels to a voxel.
const PIXELS: i32 = 12;
/// Samples to a voxel of what is called exact.
const FINE: u32 = 50;

/// What pictures of the voxel have in common, and not.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// Brightest pixel: the standard deviation over views and phases, as a share of the mean.
    pub variation: f64,
    /// Light of all pixels, as a share of what is exact.
    pub light: f64,
    /// Along an axis, samples in its plane: how far the half of the brightest reaches along the diagonal, over how far it does along
    /// a side. 1 is round, 0.71 a diamond.
    pub roundness: f64,
}

/// Figure 7 for one extinction.
#[derive(Clone, Debug, Serialize)]
pub struct Points {
    /// Extinction of the voxel.
    pub tau_max: f64,
    /// By opacities.
    pub opacity: Point,
    /// By extinctions.
    pub extinction: Point,
    /// By extinctions, 50 samples to a voxel.
    pub exact: Point,
}

/// The share of the voxel at a place.
fn share(at: [f64; 3]) -> f64 {
    at.iter().map(|c| (1.0 - c.abs()).max(0.0)).product()
}

/// The opacity of the ray through a place, along a unit vector, whose samples are at `phase + k d` from it.
fn opacity(sampling: Sampling, tau_max: f64, (d, phase): (f64, f64), from: [f64; 3], along: [f64; 3]) -> f64 {
    // No ray is longer in the voxel's cells, nor farther from its middle.
    let reach = (4.0 / d).ceil() as i32;
    let mut transparency = 1.0;
    for k in -reach..=reach {
        let way = phase + f64::from(k) * d;
        let share = share([0, 1, 2].map(|a| from[a] + way * along[a]));
        if share > 0.0 {
            transparency *= match sampling {
                Sampling::Opacity => 1.0 + share * (-tau_max * d).exp_m1(),
                Sampling::Extinction => (-share * tau_max * d).exp(),
            };
        }
    }
    1.0 - transparency
}

/// A direction, and two across it and each other: a spiral over half the sphere.
fn view(n: u32) -> [[f64; 3]; 3] {
    let height = (f64::from(n) + 0.5) / f64::from(VIEWS);
    let turn = f64::from(n) * std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let flat = (1.0 - height * height).sqrt();
    let (sin, cos) = turn.sin_cos();
    [
        [flat * cos, flat * sin, height],
        [-sin, cos, 0.0],
        [-height * cos, -height * sin, flat],
    ]
}

/// Brightest pixel and light of one picture.
fn picture(sampling: Sampling, tau_max: f64, steps: (f64, f64), [along, right, up]: [[f64; 3]; 3]) -> [f64; 2] {
    let reach = 7 * PIXELS / 4;
    let (mut most, mut light) = (0.0f64, 0.0);
    for (x, y) in (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y))) {
        let [x, y] = [x, y].map(|c| f64::from(c) / f64::from(PIXELS));
        let found = opacity(
            sampling,
            tau_max,
            steps,
            [0, 1, 2].map(|a| x * right[a] + y * up[a]),
            along,
        );
        most = most.max(found);
        light += found / f64::from(PIXELS * PIXELS);
    }
    [most, light]
}

/// How far the half of the brightest reaches along a vector, from the voxel's middle.
fn half(sampling: Sampling, tau_max: f64, d: f64, along: [f64; 2]) -> f64 {
    let at = |way: f64| {
        opacity(
            sampling,
            tau_max,
            (d, 0.0),
            [way * along[0], way * along[1], 0.0],
            [0.0, 0.0, 1.0],
        )
    };
    let (top, mut near, mut far) = (at(0.0), 0.0, 2.0);
    for _ in 0..50 {
        let middle = 0.5 * (near + far);
        if at(middle) > 0.5 * top {
            near = middle;
        } else {
            far = middle;
        }
    }
    near
}

/// All of one way of sampling; light as it is.
fn point(sampling: Sampling, tau_max: f64, d: f64, phases: u32) -> Point {
    let pictures: Vec<[f64; 2]> = (0..VIEWS)
        .flat_map(|n| (0..phases).map(move |phase| (n, phase)))
        .map(|(n, phase)| {
            picture(
                sampling,
                tau_max,
                (d, d * f64::from(phase) / f64::from(phases)),
                view(n),
            )
        })
        .collect();
    let mean = |values: &dyn Fn(&[f64; 2]) -> f64| pictures.iter().map(values).sum::<f64>() / pictures.len() as f64;
    let most = mean(&|[most, _]| *most);
    let variance = mean(&|[value, _]| (value - most).powi(2));
    let diagonal = std::f64::consts::FRAC_1_SQRT_2;
    Point {
        variation: variance.sqrt() / most,
        light: mean(&|[_, light]| *light),
        roundness: half(sampling, tau_max, d, [diagonal; 2]) / half(sampling, tau_max, d, [1.0, 0.0]),
    }
}

/// Figure 7.
pub fn points() -> Vec<Points> {
    let of = |tau_max: f64| {
        let exact = point(Sampling::Extinction, tau_max, f64::from(FINE).recip(), 1);
        let ways = Sampling::ALL.map(|sampling| {
            let point = point(sampling, tau_max, 1.0, PHASES);
            Point {
                light: point.light / exact.light,
                ..point
            }
        });
        let [opacity, extinction] = ways;
        Points {
            tau_max,
            opacity,
            extinction,
            exact: Point { light: 1.0, ..exact },
        }
    };
    TAUS.map(of).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions are unit vectors across each other, and none is twice there.
    #[test]
    fn views_are_frames() {
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        for n in 0..VIEWS {
            let axes = view(n);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                assert!(
                    (dot(axes[i], axes[j]) - f64::from(u8::from(i == j))).abs() < 1e-12,
                    "{n}"
                );
            }
            assert!((0..n).all(|m| dot(view(m)[0], axes[0]) < 0.9999));
        }
    }

    /// Known shapes: by opacities the picture along an axis is the product of two tents, whose half lies at 1/2 along a side and at
    /// 1 - sqrt(1/2) along both.
    #[test]
    fn a_point_by_opacities_is_a_diamond() {
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        let found = half(Sampling::Opacity, 4.0, 1.0, [diagonal; 2]) / half(Sampling::Opacity, 4.0, 1.0, [1.0, 0.0]);
        let expected = (1.0 - diagonal) * std::f64::consts::SQRT_2 / 0.5;
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }

    /// The paper's words, in numbers.
    #[test]
    fn points_vary_less_by_extinctions() {
        for points in points() {
            let Points {
                opacity,
                extinction,
                exact,
                ..
            } = points;
            assert!(opacity.variation > 5.0 * extinction.variation, "{points:?}");
            assert!(
                (extinction.light - 1.0).abs() < 0.05 && opacity.light < 0.6,
                "{points:?}"
            );
            assert!(
                opacity.roundness < extinction.roundness && exact.variation < extinction.variation,
                "{points:?}"
            );
        }
    }
}
