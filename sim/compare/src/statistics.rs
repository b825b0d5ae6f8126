//! Error figures of a stage.

use serde::Serialize;

/// Errors gathered over samples, in units of the last place of the stage's format.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    samples: u64,
    max: f64,
    sum: f64,
    sum_abs: f64,
    sum_squares: f64,
    exact: u64,
}

impl Errors {
    /// Adds one error (fixed minus f64), in ulp.
    #[inline]
    pub fn add(&mut self, ulp: f64) {
        self.samples += 1;
        self.max = self.max.max(ulp.abs());
        self.sum += ulp;
        self.sum_abs += ulp.abs();
        self.sum_squares += ulp * ulp;
        self.exact += u64::from(ulp.abs() <= 0.5 + 1e-9);
    }

    /// Adds what another place has gathered.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.max = self.max.max(other.max);
        self.sum += other.sum;
        self.sum_abs += other.sum_abs;
        self.sum_squares += other.sum_squares;
        self.exact += other.exact;
    }

    /// The figures; the format has `per_unit` ulp in 1.0.
    pub fn figures(&self, per_unit: f64) -> Figures {
        let mean = |sum: f64| sum / (self.samples.max(1) as f64);
        Figures {
            samples: self.samples,
            max_ulp: self.max,
            mean_ulp: mean(self.sum_abs),
            rms_ulp: mean(self.sum_squares).sqrt(),
            bias_ulp: mean(self.sum),
            exact_percent: 100.0 * mean(self.exact as f64),
            bits: (self.max > 0.0).then(|| (per_unit / self.max).log2()),
        }
    }
}

/// Error figures of a stage, as reports show them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// How many values were compared.
    pub samples: u64,
    /// Largest absolute error, ulp of the format.
    pub max_ulp: f64,
    /// Mean absolute error, ulp.
    pub mean_ulp: f64,
    /// Root of the mean squared error, ulp.
    pub rms_ulp: f64,
    /// Mean error, ulp: fixed minus f64.
    pub bias_ulp: f64,
    /// Share of values that are the nearest of their format (error at most half an ulp), percent.
    pub exact_percent: f64,
    /// Fraction bits that every value has right: -log2 of the largest absolute error. `None` if there is no error.
    pub bits: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_known_series() {
        let mut a = Errors::default();
        let mut b = Errors::default();
        for e in [0.5, -1.5] {
            a.add(e);
        }
        b.add(2.0);
        b.add(0.0);
        a.merge(&b);
        let f = a.figures(4096.0);
        assert_eq!((f.samples, f.max_ulp, f.mean_ulp, f.bias_ulp), (4, 2.0, 1.0, 0.25));
        assert_eq!((f.exact_percent, f.bits), (50.0, Some(11.0)));
        assert!((f.rms_ulp - (6.5f64 / 4.0).sqrt()).abs() < 1e-15);
        assert_eq!(Errors::default().figures(4096.0).bits, None);
    }
}
