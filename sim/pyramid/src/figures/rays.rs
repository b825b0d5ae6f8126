//! A ray across one layer of matter, sampled by extinctions and by opacities.
//!
//! Source: Kraus and Bürger, section 3.5 and figure 1: of five columns of voxels the middle one has the extinction tau_max, the
//! others none; a ray crosses them at right angles. Its samples lie d apart, the first at any phase, and are interpolated
//! linearly: the extinction, or the opacity over d' = d. The layer blocks 1 - e^-tau_max of the light.
//!
//! Figures 5 and 6 show a wall of this kind. A picture of it has artefacts where neighbouring rays, which have other phases, are
//! blocked differently: what is measured here is the ripple, the largest less the smallest opacity over all phases.

use serde::Serialize;

/// Extinctions of figure 4.
pub const TAUS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// Phases of a step.
const PHASES: usize = 512;

/// Steps of a range; 2/3 and 3/4, where errors are largest, are among them.
const STEPS: u32 = 300;

/// What is interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Opacities over the step.
    Opacity,
    /// Extinctions.
    Extinction,
}

impl Sampling {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Opacity, Self::Extinction];
}

/// The opacity of the ray whose samples are at `phase + k d`, measured from the layer.
pub fn opacity(sampling: Sampling, tau_max: f64, d: f64, phase: f64) -> f64 {
    let first = ((-1.0 - phase) / d).floor() as i64;
    let last = ((1.0 - phase) / d).ceil() as i64;
    let mut transparency = 1.0;
    for k in first..=last {
        let share = (1.0 - (phase + k as f64 * d).abs()).max(0.0);
        transparency *= match sampling {
            Sampling::Opacity => 1.0 + share * (-tau_max * d).exp_m1(),
            Sampling::Extinction => (-share * tau_max * d).exp(),
        };
    }
    1.0 - transparency
}

/// Opacities over all phases of a step.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spread {
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// Their mean.
    pub mean: f64,
}

/// Opacities of a step, over all phases.
pub fn spread(sampling: Sampling, tau_max: f64, d: f64) -> Spread {
    let all = (0..PHASES).map(|n| opacity(sampling, tau_max, d, d * n as f64 / PHASES as f64));
    let start = Spread {
        least: f64::INFINITY,
        most: 0.0,
        mean: 0.0,
    };
    all.fold(start, |spread, opacity| Spread {
        least: spread.least.min(opacity),
        most: spread.most.max(opacity),
        mean: spread.mean + opacity / PHASES as f64,
    })
}

/// A cut through the surfaces of figure 4 at one step.
#[derive(Clone, Debug, Serialize)]
pub struct Cut {
    /// The step.
    pub d: f64,
    /// By opacities.
    pub opacity: Spread,
    /// By extinctions.
    pub extinction: Spread,
}

/// Errors over a range of steps and all phases.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// The steps, from above the first up to the second.
    pub steps: [f64; 2],
    /// The largest error and the mean deviation by opacities.
    pub opacity: [f64; 2],
    /// The same by extinctions.
    pub extinction: [f64; 2],
}

/// Figure 4 for one extinction.
#[derive(Clone, Debug, Serialize)]
pub struct Layer {
    /// Extinction of the layer.
    pub tau_max: f64,
    /// What it blocks.
    pub exact: f64,
    /// The surfaces, cut.
    pub cuts: Vec<Cut>,
    /// Errors by ranges of steps.
    pub errors: Vec<Errors>,
}

/// Figure 4.
pub fn layers() -> Vec<Layer> {
    let layer = |tau_max: f64| {
        let exact = -(-tau_max).exp_m1();
        let cut = |n: u32| {
            let d = f64::from(n) / 10.0;
            let [opacity, extinction] = Sampling::ALL.map(|sampling| spread(sampling, tau_max, d));
            Cut { d, opacity, extinction }
        };
        let errors = [[0.0, 0.5], [0.5, 1.0], [1.0, 1.5]].map(|steps| {
            let [opacity, extinction] = Sampling::ALL.map(|sampling| {
                let all = (1..=STEPS).map(|n| {
                    let d = steps[0] + (steps[1] - steps[0]) * f64::from(n) / f64::from(STEPS);
                    let Spread { least, most, mean } = spread(sampling, tau_max, d);
                    [(exact - least).abs().max((most - exact).abs()), mean - exact]
                });
                all.fold([0.0, 0.0], |[most, sum]: [f64; 2], [error, mean]| {
                    [most.max(error), sum + mean / f64::from(STEPS)]
                })
            });
            Errors {
                steps,
                opacity,
                extinction,
            }
        });
        Layer {
            tau_max,
            exact,
            cuts: (1..=15).map(cut).collect(),
            errors: errors.to_vec(),
        }
    };
    TAUS.map(layer).to_vec()
}

/// From which step on a wall shows.
#[derive(Clone, Debug, Serialize)]
pub struct Wall {
    /// Extinction of the wall.
    pub tau_max: f64,
    /// The ripple that counts as showing.
    pub ripple: f64,
    /// The first step, to 0.01, with a larger ripple; by opacities.
    pub opacity: Option<f64>,
    /// The same by extinctions.
    pub extinction: Option<f64>,
}

/// Figures 5 and 6, for ripples of one 8-bit step and of 7 %.
pub fn walls() -> Vec<Wall> {
    let mut walls = Vec::new();
    for ripple in [1.0 / 255.0, 0.07] {
        for tau_max in TAUS {
            let [opacity, extinction] = Sampling::ALL.map(|sampling| {
                let shows = |d: &f64| {
                    let Spread { least, most, .. } = spread(sampling, tau_max, *d);
                    most - least > ripple
                };
                (1..=300).map(|n| f64::from(n) / 100.0).find(shows)
            });
            walls.push(Wall {
                tau_max,
                ripple,
                opacity,
                extinction,
            });
        }
    }
    walls
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the step divides 1, the samples' shares add up to 1 / d, and extinction is exact for every phase.
    #[test]
    fn steps_that_divide_a_voxel_are_exact() {
        for tau in TAUS {
            for parts in 1..=8 {
                let Spread { least, most, .. } = spread(Sampling::Extinction, tau, f64::from(parts).recip());
                let exact = 1.0 - (-tau).exp();
                assert!(
                    (least - exact).abs() < 1e-12 && (most - exact).abs() < 1e-12,
                    "{tau} {parts}"
                );
            }
        }
    }

    /// Both are right where the step is short; opacities come from below.
    #[test]
    fn short_steps_converge() {
        for tau in TAUS {
            let exact = 1.0 - (-tau).exp();
            let extinction = spread(Sampling::Extinction, tau, 0.003);
            assert!((extinction.least - exact).abs() < 1e-4 && (extinction.most - exact).abs() < 1e-4);
            let opacity = spread(Sampling::Opacity, tau, 0.003);
            assert!(
                opacity.most < exact && opacity.least > exact - 0.01,
                "{tau}: {opacity:?} {exact}"
            );
        }
    }

    /// The largest errors for steps of half a voxel to a voxel, as the page has them.
    #[test]
    fn errors_are_those_of_the_page() {
        let expected = [[0.100, 0.043], [0.187, 0.034], [0.241, 0.0102], [0.250, 0.0005]];
        for (layer, [opacity, extinction]) in layers().iter().zip(expected) {
            let errors = &layer.errors[1];
            assert!((errors.opacity[0] - opacity).abs() < 1e-3, "{errors:?}");
            assert!((errors.extinction[0] - extinction).abs() < 5e-4, "{errors:?}");
            assert!(
                errors.opacity[1] < -0.04 && errors.extinction[1].abs() < 0.01,
                "{errors:?}"
            );
        }
    }

    #[test]
    fn the_wall_shows_where_the_page_says() {
        let wall = walls()
            .into_iter()
            .find(|wall| wall.tau_max == 4.0 && wall.ripple == 0.07)
            .unwrap();
        let [opacity, extinction] = [wall.opacity.unwrap(), wall.extinction.unwrap()];
        assert!(
            (opacity - 0.60).abs() < 0.011 && (extinction - 1.59).abs() < 0.011,
            "{opacity} {extinction}"
        );
    }
}
