//! Which configurations nothing beats.
//!
//! One beats another if it is at least as fast and, over the views, at least as exact, and clearly better in one of the
//! two: faster by more than the clock tells apart, or more exact by more than the views scatter
//! ([`Difference::is_clear_gain`]).

use super::ensemble::Difference;
use super::rows::Row;

/// A configuration on the plane of speed against error.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// More is better.
    pub speed: f64,
    /// Mean error of each view; less is better.
    pub errors: Vec<f64>,
}

/// Speeds closer than this are one speed: what differs is the clock.
pub const RESOLUTION: f64 = 0.01;

impl Point {
    /// The speed in steps of [`RESOLUTION`].
    fn step(&self) -> i64 {
        (self.speed / RESOLUTION).round() as i64
    }

    /// Whether this point beats another one.
    pub fn beats(&self, other: &Self) -> bool {
        let (a, b) = (self.step(), other.step());
        let difference = Difference::between(&self.errors, &other.errors);
        a >= b && difference.mean <= 0.0 && (a > b || difference.is_clear_gain())
    }
}

/// For each point, whether it is on the front.
pub fn front(points: &[Point]) -> Vec<bool> {
    let beaten = |point: &Point| points.iter().any(|other| other.beats(point));
    points.iter().map(|point| !beaten(point)).collect()
}

/// For each row, whether it is on the front of relative speed against mean error.
pub fn on_front(rows: &[Row]) -> Vec<bool> {
    let point = |row: &Row| Point {
        speed: row.relative_speed,
        errors: row.errors(),
    };
    front(&rows.iter().map(point).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::row;
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let point = |speed, error| Point {
            speed,
            errors: vec![error],
        };
        let points = [
            point(1.0, 5.0),
            point(2.0, 5.0),
            point(0.5, 1.0),
            point(0.5, 2.0),
            point(1.5, 6.0),
            // As fast as the second within the clock, and as exact.
            point(2.001, 5.0),
        ];
        assert_eq!(front(&points), [false, true, true, false, false, true]);
        assert_eq!(front(&[]), [false; 0]);
        assert_eq!(on_front(&[row("a", 0, 1.0, 1.0), row("b", 1, 2.0, 1.0)]), [true, false]);
    }

    #[test]
    fn what_scatters_more_than_it_gains_beats_nothing() {
        let point = |errors: [f64; 3]| Point {
            speed: 1.0,
            errors: errors.into(),
        };
        let base = point([1.0, 2.0, 3.0]);
        assert!(point([0.9, 1.9, 2.8]).beats(&base));
        assert!(!point([1.1, 1.7, 3.1]).beats(&base));
        // Unless it is faster.
        let faster = Point {
            speed: 1.1,
            ..point([1.1, 1.7, 3.1])
        };
        assert!(faster.beats(&base));
    }
}
