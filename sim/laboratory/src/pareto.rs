//! Which configurations nothing beats.
//!
//! One beats another if it is at least as fast and, over the views, at least as exact, and clearly better in one of the
//! two: faster by more than the rounds scatter, or more exact by more than the views do ([`Difference::is_clear_gain`]).
//! Speeds that differ by no more than they scatter are one speed. What they would decide if they were exact is told apart
//! ([`Place::WithinSpread`]), so that the front of a second run is the same.

use super::ensemble::Difference;
use super::rows::Row;

/// A configuration on the plane of speed against error.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// More is better.
    pub speed: f64,
    /// How far the speed scatters, as a share of it.
    pub spread: f64,
    /// Mean error of each view; less is better.
    pub errors: Vec<f64>,
}

/// Where a configuration stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nothing beats it.
    Front,
    /// Something beats it that is as fast within the spread, and measured as slower.
    WithinSpread,
    /// Something beats it.
    Beaten,
}

impl Place {
    /// The sign in tables.
    pub const fn sign(self) -> &'static str {
        match self {
            Self::Front => "*",
            Self::WithinSpread => "~",
            Self::Beaten => "",
        }
    }
}

/// Speeds closer than this are one speed, however little they scatter: what differs is the clock.
pub const RESOLUTION: f64 = 0.01;

impl Point {
    /// Whether this point beats another one, if speeds that differ by no more than a share of `tolerance` are one speed.
    fn beats_within(&self, other: &Self, tolerance: f64) -> bool {
        let slower = self.speed * (1.0 + tolerance) < other.speed;
        let faster = self.speed > other.speed * (1.0 + tolerance);
        let difference = Difference::between(&self.errors, &other.errors);
        !slower && difference.mean <= 0.0 && (faster || difference.is_clear_gain())
    }

    /// Whether this point beats another one.
    pub fn beats(&self, other: &Self) -> bool {
        self.beats_within(other, self.spread.hypot(other.spread).max(RESOLUTION))
    }
}

/// For each point, where it stands.
pub fn front(points: &[Point]) -> Vec<Place> {
    let place = |point: &Point| {
        let beaten = |how: &dyn Fn(&Point) -> bool| points.iter().any(how);
        if !beaten(&|other| other.beats(point)) {
            Place::Front
        } else if !beaten(&|other| other.beats_within(point, 0.0)) {
            Place::WithinSpread
        } else {
            Place::Beaten
        }
    };
    points.iter().map(place).collect()
}

/// For each row, where it stands on the plane of relative speed against mean error.
pub fn places(rows: &[Row]) -> Vec<Place> {
    let point = |row: &Row| Point {
        speed: row.relative_speed,
        spread: row.speed_spread.unwrap_or(0.0),
        errors: row.errors(),
    };
    front(&rows.iter().map(point).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::row;
    use super::Place::{Beaten, Front, WithinSpread};
    use super::*;

    fn point(speed: f64, spread: f64, error: f64) -> Point {
        Point {
            speed,
            spread,
            errors: vec![error],
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [
            point(1.0, 0.0, 5.0),
            point(2.0, 0.0, 5.0),
            point(0.5, 0.0, 1.0),
            point(0.5, 0.0, 2.0),
            point(1.5, 0.0, 6.0),
            // As fast as the second within the clock, and as exact.
            point(2.001, 0.0, 5.0),
        ];
        assert_eq!(front(&points), [Beaten, Front, Front, Beaten, Beaten, Front]);
        assert_eq!(front(&[]), []);
        assert_eq!(places(&[row("a", 0, 1.0, 1.0), row("b", 1, 2.0, 1.0)]), [Front, Beaten]);
    }

    /// The same machine run twice: what is on the front does not depend on which of two equal speeds came out higher.
    #[test]
    fn the_front_does_not_change_by_noise() {
        // Four that are as fast as each other, and one that is faster and less exact.
        let truth = [(1.0, 1.0), (1.0, 2.0), (1.0, 3.0), (1.0, 1.5), (1.2, 2.5)];
        let mut marked = 0;
        for run in 0_u32..64 {
            // Each speed off by up to 1.3 % either way, of a spread of 2 %.
            let noise = |place: usize| 0.013 * (f64::from((run * 37 + place as u32 * 11) % 15) / 7.0 - 1.0);
            let points = truth.iter().enumerate();
            let points: Vec<_> = points
                .map(|(place, (speed, error))| point(speed * (1.0 + noise(place)), 0.02, *error))
                .collect();
            let places = front(&points);
            let on: Vec<bool> = places.iter().map(|place| *place == Front).collect();
            assert_eq!(on, [true, false, false, false, true], "{run}: {places:?}");
            // What came out faster than all that are more exact says that it might be.
            for (place, point) in places.iter().zip(&points) {
                let overtaken = |other: &Point| other.errors < point.errors && other.speed >= point.speed;
                let alone = *place != Front && !points.iter().any(overtaken);
                assert_eq!(*place == WithinSpread, alone, "{run}: {point:?}");
                marked += u32::from(alone);
            }
        }
        assert!(marked > 0);
    }

    #[test]
    fn what_scatters_more_than_it_gains_beats_nothing() {
        let point = |errors: [f64; 3]| Point {
            speed: 1.0,
            spread: 0.0,
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
        // By more than both scatter: here it is one speed.
        let scattered = Point { spread: 0.2, ..faster };
        assert!(!scattered.beats(&base));
    }
}
