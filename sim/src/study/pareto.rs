//! Which configurations nothing beats: none is at once at least as fast and at least as exact, and better in one of
//! the two.

/// A configuration on the plane of speed against error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// More is better.
    pub speed: f64,
    /// Less is better.
    pub error: f64,
}

/// Speeds closer than this are one speed: what differs is the clock.
pub const RESOLUTION: f64 = 0.01;

impl Point {
    /// The speed in steps of [`RESOLUTION`].
    fn step(self) -> i64 {
        (self.speed / RESOLUTION).round() as i64
    }

    /// Whether this point beats another one.
    pub fn beats(self, other: Self) -> bool {
        let (a, b) = (self.step(), other.step());
        a >= b && self.error <= other.error && (a > b || self.error < other.error)
    }
}

/// For each point, whether it is on the front.
pub fn front(points: &[Point]) -> Vec<bool> {
    let beaten = |point: &Point| points.iter().any(|other| other.beats(*point));
    points.iter().map(|point| !beaten(point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let point = |speed, error| Point { speed, error };
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
    }
}
