//! Classification: colour and opacity of a sample's value, and the correction of opacity for the length of a step.
//!
//! Source: paper, section 4.4 (transfer function) and equation 7 (alpha correction).
//!
//! | value   | unit                                                                         |
//! | code    | 12-bit code units, with fraction; the volume's mapping makes data units of it |
//! | colour  | 0 to 1, red, green, blue, not multiplied by opacity                          |
//! | opacity | fraction of light blocked, 0 to 1, over a stated length                      |

use slicecast_scene::{Point, TransferFunction};
use slicecast_volume::Mapping;

/// Colour and opacity of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Classified {
    /// Red, green, blue: the paper's O.
    pub colour: [f64; 3],
    /// Fraction of light blocked over the length that the producer states.
    pub opacity: f64,
}

impl Classified {
    /// Nothing.
    pub const CLEAR: Self = Self {
        colour: [0.0; 3],
        opacity: 0.0,
    };

    /// The same of a step of which a fraction lies in the volume; a whole one is left as it is.
    pub fn of_fraction(self, fraction: f64) -> Self {
        match fraction {
            0.0 => Self { opacity: 0.0, ..self },
            1.0.. => self,
            _ => self.shared(fraction),
        }
    }

    /// The same over a share of the length.
    pub fn shared(self, share: f64) -> Self {
        Self {
            opacity: -(share * (-self.opacity).ln_1p()).exp_m1(),
            ..self
        }
    }
}

/// A transfer function applied to codes, for rays of a given step length.
#[derive(Clone, Copy, Debug)]
pub struct Classifier<'a> {
    points: &'a [Point],
    unit_distance: f64,
    mapping: Mapping,
    step_length: f64,
}

impl<'a> Classifier<'a> {
    /// `mapping` turns codes into data values; `step_length` is the world length between samples, in the unit of
    /// `transfer.unit_distance`.
    ///
    /// # Panics
    /// If the transfer function has no point or its unit distance is not positive.
    pub fn new(transfer: &'a TransferFunction, mapping: Mapping, step_length: f64) -> Self {
        assert!(!transfer.points.is_empty(), "a transfer function without points");
        assert!(transfer.unit_distance > 0.0, "unit distance {}", transfer.unit_distance);
        Self {
            points: &transfer.points,
            unit_distance: transfer.unit_distance,
            mapping,
            step_length,
        }
    }

    /// Colour and opacity of a code, the opacity over one step of the ray ([`corrected`]).
    pub fn classify(&self, code: f64) -> Classified {
        let written = self.as_written(code);
        Classified {
            opacity: corrected(written.opacity, self.step_in_units()),
            ..written
        }
    }

    /// Colour and opacity of a code as the user wrote them, the opacity over one unit distance.
    pub fn as_written(&self, code: f64) -> Classified {
        evaluate(self.points, self.mapping.value(code))
    }

    /// The data value of a code.
    pub(super) fn value(&self, code: f64) -> f64 {
        self.mapping.value(code)
    }

    /// The data values of the transfer function's points, ascending.
    pub(super) fn corners(&self) -> impl Iterator<Item = f64> + '_ {
        self.points.iter().map(|point| point.value)
    }

    /// Colour and opacity, as written, at a data value, by the straight piece that holds at another.
    pub(super) fn on_piece_of(&self, inside: f64, value: f64) -> Classified {
        on_piece(
            self.points,
            self.points.iter().take_while(|p| p.value <= inside).count(),
            value,
        )
    }

    /// The step in unit distances.
    pub(super) fn step_in_units(&self) -> f64 {
        self.step_length / self.unit_distance
    }

    /// The straight piece of the transfer function that a code lies on: how many points it has passed.
    pub fn piece(&self, code: f64) -> usize {
        let value = self.mapping.value(code);
        self.points.iter().take_while(|p| p.value <= value).count()
    }

    /// The length that opacities are written for, in the unit of the spacing.
    pub fn unit_distance(&self) -> f64 {
        self.unit_distance
    }

    /// Whether everything between two codes is transparent.
    pub fn is_clear(&self, low: f64, high: f64) -> bool {
        let (first, last) = (self.piece(low), self.piece(high));
        let between = self.points.get(first..last.max(first)).unwrap_or(&[]);
        let clear = |code: f64| self.as_written(code).opacity == 0.0;
        clear(low) && clear(high) && between.iter().all(|point| point.opacity == 0.0)
    }
}

/// Opacity over `ratio` times the length that `opacity` is meant for (paper, equation 7): `1 - (1 - a)^ratio`.
///
/// As `-expm1(ratio ln1p(-a))`, whose relative error stays at a few units of f64 however thin the fog.
pub fn corrected(opacity: f64, ratio: f64) -> f64 {
    if opacity >= 1.0 {
        return 1.0;
    }
    -(ratio * (-opacity).ln_1p()).exp_m1()
}

/// The piecewise linear function at a data value; points in ascending order, at least one.
///
/// Constant below the first and above the last point. Of points with the same value the last one holds at the value
/// itself and above, the first one below.
fn evaluate(points: &[Point], value: f64) -> Classified {
    on_piece(points, points.iter().take_while(|p| p.value <= value).count(), value)
}

/// The straight piece behind the first `passed` points, at a data value.
fn on_piece(points: &[Point], passed: usize, value: f64) -> Classified {
    let (from, to) = (passed.saturating_sub(1), passed.min(points.len() - 1));
    let (a, b) = (points[from], points[to]);
    // a = b outside the points; otherwise a.value <= value < b.value.
    let t = if from == to {
        0.0
    } else {
        (value - a.value) / (b.value - a.value)
    };
    let mix = |a: f64, b: f64| a + t * (b - a);
    Classified {
        colour: [0, 1, 2].map(|c| mix(a.colour[c], b.colour[c])),
        opacity: mix(a.opacity, b.opacity),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f64, grey: f64, opacity: f64) -> Point {
        Point {
            value,
            colour: [grey, grey / 2.0, 1.0 - grey],
            opacity,
        }
    }

    const HOUNSFIELD: Mapping = Mapping {
        scale: 1.0,
        offset: -1024.0,
    };

    #[test]
    fn pieces_and_clear_ranges() {
        let transfer = slicecast_scene::TransferFunction {
            unit_distance: 2.0,
            points: vec![point(0.0, 0.0, 0.0), point(100.0, 0.0, 0.0), point(200.0, 1.0, 0.5)],
        };
        let classifier = Classifier::new(&transfer, HOUNSFIELD, 1.0);
        assert_eq!(
            [1000.0, 1024.0, 1124.0, 1500.0].map(|code| classifier.piece(code)),
            [0, 1, 2, 3]
        );
        assert!(classifier.is_clear(0.0, 1124.0));
        assert!(!classifier.is_clear(0.0, 1124.5));
        assert!(!classifier.is_clear(1130.0, 1400.0));
        // A spike between two clear codes.
        let spike = slicecast_scene::TransferFunction {
            unit_distance: 1.0,
            points: vec![point(0.0, 0.0, 0.0), point(1.0, 0.0, 1.0), point(2.0, 0.0, 0.0)],
        };
        assert!(!Classifier::new(&spike, HOUNSFIELD, 1.0).is_clear(1000.0, 2000.0));
    }

    #[test]
    fn linear_between_points_constant_outside() {
        let points = [point(-100.0, 0.0, 0.2), point(100.0, 1.0, 0.6), point(300.0, 0.5, 0.0)];
        for (value, grey, opacity) in [
            (-5000.0, 0.0, 0.2),
            (-100.0, 0.0, 0.2),
            (0.0, 0.5, 0.4),
            (100.0, 1.0, 0.6),
            (250.0, 0.625, 0.15),
            (300.0, 0.5, 0.0),
            (9999.0, 0.5, 0.0),
        ] {
            let got = evaluate(&points, value);
            assert!((got.opacity - opacity).abs() < 1e-15, "{value}: {got:?}");
            assert!((got.colour[0] - grey).abs() < 1e-15);
            assert!((got.colour[1] - grey / 2.0).abs() < 1e-15);
            assert!((got.colour[2] - (1.0 - grey)).abs() < 1e-15);
        }
    }

    #[test]
    fn a_step_takes_the_later_point_at_the_value_itself() {
        let step = [
            point(0.0, 0.0, 0.0),
            point(10.0, 0.0, 0.1),
            point(10.0, 0.9, 0.3),
            point(10.0, 0.5, 0.9),
            point(20.0, 0.5, 0.5),
        ];
        assert!((evaluate(&step, 10.0_f64.next_down()).opacity - 0.1).abs() < 1e-14);
        assert_eq!(evaluate(&step, 10.0).opacity, 0.9);
        assert_eq!(evaluate(&step, 15.0).opacity, 0.7);
        // Steps at either end.
        let ends = [point(5.0, 0.0, 0.25), point(5.0, 0.0, 0.75)];
        assert_eq!(evaluate(&ends, 5.0_f64.next_down()).opacity, 0.25);
        assert_eq!(evaluate(&ends, 5.0).opacity, 0.75);
        assert_eq!(evaluate(&ends, 6.0).opacity, 0.75);
        assert_eq!(evaluate(&ends[..1], 7.0).opacity, 0.25);
    }

    /// The numeric study's path lengths, alpha = 0.5 per voxel.
    #[test]
    fn correction_for_the_path_length() {
        for (length, opacity) in [
            (0.25, 0.159_103_58),
            (0.5, 0.292_893_22),
            (1.5, 0.646_446_61),
            (2.75, 0.851_349_11),
            (4.0, 0.9375),
            (4.0 * 2.0_f64.sqrt(), 0.980_179_38),
        ] {
            assert!((corrected(0.5, length) - opacity).abs() < 5.1e-9, "{length}");
        }
        assert_eq!(corrected(1.0, 0.001), 1.0);
        assert_eq!(corrected(0.0, 7.0), 0.0);
        assert!((corrected(0.25, 1.0) - 0.25).abs() < 1e-16);
    }

    /// For a -> 0, 1 - (1 - a)^r = r a - r (r - 1) a^2 / 2 + ...: no digit may be lost.
    #[test]
    fn thin_fog_keeps_its_digits() {
        for exponent in [20, 31, 40, 60] {
            let a = 2.0_f64.powi(-exponent);
            for r in [0.1, 0.5, 3.0, 17.3] {
                let series = r * a - r * (r - 1.0) / 2.0 * a * a + r * (r - 1.0) * (r - 2.0) / 6.0 * a * a * a;
                let relative = corrected(a, r) / series - 1.0;
                assert!(relative.abs() < 1e-15, "2^-{exponent}, {r}: {relative:e}");
            }
        }
    }

    #[test]
    fn codes_pass_through_the_mapping_and_the_step() {
        let transfer = TransferFunction {
            unit_distance: 2.0,
            points: vec![point(0.0, 0.0, 0.0), point(100.0, 1.0, 0.64)],
        };
        let classifier = Classifier::new(&transfer, HOUNSFIELD, 1.0);
        assert_eq!(classifier.as_written(1124.0).opacity, 0.64);
        // Half the unit distance: 1 - sqrt(0.36).
        assert!((classifier.classify(1124.0).opacity - 0.4).abs() < 1e-15);
        assert_eq!(classifier.classify(1124.0).colour, [1.0, 0.5, 0.0]);
        assert_eq!(classifier.classify(1024.0).opacity, 0.0);
        assert_eq!(classifier.as_written(1074.5).opacity, 0.505 * 0.64);
    }
}
