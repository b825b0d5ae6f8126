//! The transfer function as a function of real numbers.

use super::{Point, TransferFunction};

impl TransferFunction {
    /// Nothing is visible.
    pub fn clear() -> Self {
        Self {
            unit_distance: 1.0,
            points: vec![Point {
                value: 0.0,
                colour: [0.0; 3],
                opacity: 0.0,
            }],
        }
    }

    /// Colour and opacity (over one unit distance) at a data value, in f64.
    ///
    /// Linear between points, colour and opacity each by itself; constant below the first point and above the last; at
    /// a step the later point holds. A value that is NaN counts as below the first point. A function of no points,
    /// which [`check`](super::check) refuses, is black and transparent.
    pub fn evaluate(&self, value: f64) -> ([f64; 3], f64) {
        let after = self.points.partition_point(|point| point.value <= value);
        let (below, above) = self.points.split_at(after);
        match (below.last(), above.first()) {
            (Some(a), Some(b)) => between(a, b, value),
            (Some(only), None) | (None, Some(only)) => (only.colour, only.opacity),
            (None, None) => ([0.0; 3], 0.0),
        }
    }
}

/// Linear between two points of different values, `a.value <= value < b.value`.
fn between(a: &Point, b: &Point, value: f64) -> ([f64; 3], f64) {
    let t = (value - a.value) / (b.value - a.value);
    let lerp = |a: f64, b: f64| a + (b - a) * t;
    (
        [0, 1, 2].map(|i| lerp(a.colour[i], b.colour[i])),
        lerp(a.opacity, b.opacity),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(points: &[(f64, f64)]) -> TransferFunction {
        let point = |&(value, opacity)| Point {
            value,
            colour: [opacity, 0.5, 1.0 - opacity],
            opacity,
        };
        TransferFunction {
            unit_distance: 1.0,
            points: points.iter().map(point).collect(),
        }
    }

    fn opacities(points: &[(f64, f64)], values: &[f64]) -> Vec<f64> {
        values.iter().map(|&value| function(points).evaluate(value).1).collect()
    }

    #[test]
    fn linear_between_and_constant_outside() {
        let points = [(-10.0, 0.25), (10.0, 0.75)];
        let values = [
            f64::NEG_INFINITY,
            -10.5,
            -10.0,
            -5.0,
            0.0,
            10.0,
            11.0,
            f64::INFINITY,
            f64::NAN,
        ];
        assert_eq!(
            opacities(&points, &values),
            [0.25, 0.25, 0.25, 0.375, 0.5, 0.75, 0.75, 0.75, 0.25]
        );
        assert_eq!(function(&points).evaluate(-5.0).0, [0.375, 0.5, 0.625]);
    }

    #[test]
    fn the_later_point_of_a_step_holds_at_the_value() {
        let points = [(0.0, 0.0), (1.0, 0.5), (1.0, 1.0), (2.0, 0.0)];
        assert_eq!(opacities(&points, &[0.5, 1.0, 1.5]), [0.25, 1.0, 0.5]);
        assert_eq!(opacities(&points, &[1.0_f64.next_down()]), [0.5 * 1.0_f64.next_down()]);
        // A step at either end of the function.
        assert_eq!(opacities(&[(1.0, 0.0), (1.0, 1.0)], &[0.9, 1.0, 1.1]), [0.0, 1.0, 1.0]);
    }

    #[test]
    fn one_point_is_a_constant_and_none_is_nothing() {
        assert_eq!(opacities(&[(3.0, 0.5)], &[2.0, 3.0, 4.0]), [0.5; 3]);
        assert_eq!(function(&[]).evaluate(1.0), ([0.0; 3], 0.0));
    }

    #[test]
    fn points_return_their_own_numbers() {
        let points = [(-0.3, 0.1), (0.1, 0.7), (0.7, 0.2), (1e9, 0.9)];
        for (value, opacity) in points {
            assert_eq!(opacities(&points, &[value]), [opacity]);
        }
    }
}
