//! How far sampling a coarse level is from a convolution of the finest one.
//!
//! Source: Kraus and Bürger, section 4.2, after Kraus, "Quasi-Convolution Pyramidal Blurring", 2008; the paper gives errors
//! without their formulas. With these it is met to every printed digit for linear interpolation:
//!
//! A fine voxel at p gives `phi(p - j)` to the coarse voxel j, phi being the filter applied level after level, of integral 1; a
//! sample at p + u takes `beta(p + u - j)` of that. The response `K_p(u) = Σ_j phi(p - j) beta(p + u - j)` of a convolution
//! would not depend on p. Over all p of a coarse voxel, with the mean response K:
//!
//! `eps = sqrt(∫ mean_p (K_p(u) - K(u))² du)`, `eps0 = sqrt(mean_p (K_p(0) - K(0))²)`.
//!
//! In two dimensions responses are products, so that with `A = ∫ mean_p K_p²` and `B = ∫ K²` eps is sqrt(A - B) along a line and
//! sqrt(A² - B²) in a picture; eps0 alike.

use std::collections::BTreeMap;

use serde::Serialize;

/// Levels that stand for all.
const LEVELS: u32 = 7;

/// Points of the integral, per coarse voxel.
const POINTS: usize = 128;

/// How a coarse level is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Kernel {
    /// Linear interpolation.
    Linear,
    /// Quadratic B-spline.
    Quadratic,
}

impl Kernel {
    fn at(self, x: f64) -> f64 {
        let x = x.abs();
        match self {
            Self::Linear => (1.0 - x).max(0.0),
            Self::Quadratic if x < 0.5 => 0.75 - x * x,
            Self::Quadratic => 0.5 * (1.5 - x).max(0.0).powi(2),
        }
    }

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Quadratic => "quadratic B-spline",
        }
    }
}

/// eps and eps0.
pub type Pair = [f64; 2];

/// Errors of a filter.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// How levels are sampled.
    pub kernel: Kernel,
    /// Weights of the filter; an odd number of them lies on nodes.
    pub weights: Vec<f64>,
    /// Along a line.
    pub line: Pair,
    /// In a picture.
    pub picture: Pair,
    /// What the paper prints for this filter.
    pub paper: Option<Pair>,
}

/// Mean squares of responses, and squares of their means: over all u, and at 0.
struct Squares {
    all: [f64; 2],
    centre: [f64; 2],
}

/// Errors along a line and in a picture.
pub fn errors(kernel: Kernel, weights: &[f64], levels: u32) -> [Pair; 2] {
    let Squares { all, centre } = squares(kernel, weights, levels);
    let root = |[mean, square]: [f64; 2], power: i32| (mean.powi(power) - square.powi(power)).max(0.0).sqrt();
    [1, 2].map(|power| [root(all, power), root(centre, power)])
}

/// phi at the fine voxels of all coarse ones around 0: from the index of a fine voxel, and the place of index 0.
fn response(weights: &[f64], levels: u32) -> (BTreeMap<i64, f64>, f64) {
    let sum: f64 = weights.iter().sum();
    let half = (weights.len() as i64 - 1) / 2;
    let mut phi = BTreeMap::from([(0_i64, 1.0)]);
    for _ in 0..levels {
        let mut finer = BTreeMap::new();
        for (m, value) in phi {
            for (weight, index) in weights.iter().zip(2 * m - half..) {
                // A fine voxel is half as long: its density is twice its share.
                *finer.entry(index).or_insert(0.0) += 2.0 * value * weight / sum;
            }
        }
        phi = finer;
    }
    let fine = f64::from(levels).exp2();
    let place = if weights.len() % 2 == 1 { 0.0 } else { 0.5 / fine - 0.5 };
    (phi, place)
}

fn squares(kernel: Kernel, weights: &[f64], levels: u32) -> Squares {
    let (phi, place) = response(weights, levels);
    let fine = 1_i64 << levels;
    // Voxels that a fine one reaches: phi is at most as wide as the filter, less one voxel.
    let reach = weights.len() as i64;
    let half = reach as usize + 2;
    let count = 2 * half * POINTS;
    let (mut means, mut square, mut centre) = (vec![0.0; count], 0.0, [0.0; 2]);
    for n in 0..fine {
        let p = n as f64 / fine as f64 + place;
        let given: Vec<(f64, f64)> = (-reach..=reach)
            .filter_map(|j| Some((j as f64, *phi.get(&(n - j * fine))?)))
            .collect();
        let at = |u: f64| -> f64 { given.iter().map(|(j, share)| share * kernel.at(p + u - j)).sum() };
        for (i, mean) in means.iter_mut().enumerate() {
            let value = at((i as f64 + 0.5) / POINTS as f64 - half as f64);
            *mean += value / fine as f64;
            square += value * value;
        }
        let value = at(0.0);
        centre[0] += value * value / fine as f64;
        centre[1] += value / fine as f64;
    }
    Squares {
        all: [
            square / fine as f64 / POINTS as f64,
            means.iter().map(|mean| mean * mean).sum::<f64>() / POINTS as f64,
        ],
        centre: [centre[0], centre[1] * centre[1]],
    }
}

/// The paper's filters and others.
pub fn figures() -> Vec<Figures> {
    use Kernel::{Linear, Quadratic};
    let quadratic = Some([0.0276, 0.0027]);
    let filters: [(Kernel, &[f64], Option<Pair>); 13] = [
        (Linear, &[1.0, 1.0], Some([0.34, 0.14])),
        (Linear, &[1.0, 1.0, 1.0, 1.0], Some([0.057, 0.0093])),
        (Linear, &[1.0, 3.0, 3.0, 1.0], None),
        (Linear, &[3.0, 2.0, 3.0, 3.0, 2.0, 3.0], None),
        (Linear, &[1.0, 2.0, 1.0], None),
        (Linear, &[1.0, 4.0, 6.0, 4.0, 1.0], None),
        (Linear, &[1.0, 2.0, 2.0, 2.0, 1.0], None),
        (Quadratic, &[1.0, 1.0], None),
        (Quadratic, &[1.0, 1.0, 1.0, 1.0], None),
        (Quadratic, &[13.0, 19.0, 19.0, 13.0], quadratic),
        (Quadratic, &[2.0, 3.0, 3.0, 2.0], quadratic),
        (Quadratic, &[9.0, 9.0, 14.0, 14.0, 9.0, 9.0], None),
        (Quadratic, &[1.0, 2.0, 2.0, 2.0, 1.0], None),
    ];
    let figures = filters.map(|(kernel, weights, paper)| {
        let [line, picture] = errors(kernel, weights, LEVELS);
        Figures {
            kernel,
            weights: weights.to_vec(),
            line,
            picture,
            paper,
        }
    });
    figures.to_vec()
}

/// Errors of a pyramid of few levels.
#[derive(Clone, Debug, Serialize)]
pub struct OfLevels {
    /// How many.
    pub levels: u32,
    /// Along a line.
    pub line: Pair,
    /// In a picture.
    pub picture: Pair,
}

/// (13,19,19,13)/64 under a quadratic B-spline, the filter whose printed errors are not met, by levels.
pub fn by_levels() -> Vec<OfLevels> {
    let of = |levels: u32| {
        let [line, picture] = errors(Kernel::Quadratic, &[13.0, 19.0, 19.0, 13.0], levels);
        OfLevels { levels, line, picture }
    };
    (1..=LEVELS).map(of).collect()
}

/// The symmetric filter (a, 1/2 - a, 1/2 - a, a) with the smallest error of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct Best {
    /// How levels are sampled.
    pub kernel: Kernel,
    /// Of eps, or of eps0.
    pub of: &'static str,
    /// Whether of a picture, and not of a line.
    pub picture: bool,
    /// The outer weight.
    pub a: f64,
    /// Both errors there.
    pub errors: Pair,
}

/// The best filters of four weights, a to 0.001; of 5 levels, from which the place of a minimum hardly moves.
pub fn best() -> Vec<Best> {
    let mut best = Vec::new();
    for kernel in [Kernel::Linear, Kernel::Quadratic] {
        let all: Vec<(f64, [Pair; 2])> = (150..=280)
            .map(|n| f64::from(n) / 1000.0)
            .map(|a| (a, errors(kernel, &[a, 0.5 - a, 0.5 - a, a], 5)))
            .collect();
        for (picture, of) in [(false, 0), (false, 1), (true, 0), (true, 1)] {
            let side = usize::from(picture);
            let least = all.iter().min_by(|(_, a), (_, b)| a[side][of].total_cmp(&b[side][of]));
            if let Some(&(a, _)) = least {
                best.push(Best {
                    kernel,
                    of: ["eps", "eps0"][of],
                    picture,
                    a,
                    errors: errors(kernel, &[a, 0.5 - a, 0.5 - a, a], LEVELS)[side],
                });
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Pair, expected: Pair) {
        let near = (0..2).all(|i| (found[i] - expected[i]).abs() < 6e-5);
        assert!(near, "{found:?} {expected:?}");
    }

    /// Section 4.2, as the study has its numbers with one digit more.
    #[test]
    fn errors_are_those_of_the_paper() {
        close(errors(Kernel::Linear, &[1.0, 1.0], LEVELS)[0], [0.3416, 0.1443]);
        close(errors(Kernel::Linear, &[1.0; 4], LEVELS)[0], [0.0573, 0.0093]);
    }

    /// The box of two: K_p(0) is 1 - |p| for p to 1/2, and |p| takes 256 values in the middle of equal parts of 1/2.
    #[test]
    fn the_box_has_a_closed_form() {
        let [line, _] = errors(Kernel::Linear, &[1.0, 1.0], 9);
        assert!(
            (line[1] - ((1.0 - 256.0_f64.powi(-2)) / 48.0).sqrt()).abs() < 1e-12,
            "{line:?}"
        );
    }

    /// A filter of infinitely many weights would be a convolution; six are nearer than four.
    #[test]
    fn more_weights_are_nearer() {
        let of = |weights: &[f64]| errors(Kernel::Linear, weights, LEVELS)[0];
        let [four, six] = [of(&[1.0; 4]), of(&[3.0, 2.0, 3.0, 3.0, 2.0, 3.0])];
        close(six, [0.0196, 0.0020]);
        assert!(2.9 * six[0] < four[0] && 4.6 * six[1] < four[1], "{four:?} {six:?}");
    }

    #[test]
    fn kernels_add_up() {
        for kernel in [Kernel::Linear, Kernel::Quadratic] {
            for n in 0..10 {
                let x = f64::from(n) / 10.0;
                let sum: f64 = (-3..=3).map(|j| kernel.at(x + f64::from(j))).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{kernel:?} {x}");
            }
        }
    }
}
