//! One configuration against another over many views.
//!
//! A single picture decides nothing in its third digit: which of two formats rounds better depends on where the samples
//! happen to lie. Both render the same views, so the difference is taken view by view.

/// How far a configuration's error is from another's, in the unit of the errors; below 0 it is more exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean over the views.
    pub mean: f64,
    /// Standard error of that mean; `None` for a single view.
    pub standard_error: Option<f64>,
    /// Views in which the configuration errs less.
    pub better: usize,
    /// Views.
    pub views: usize,
}

/// A difference of more standard errors than this is one. Student's t for 12 views and 2.5 % at each end is 2.2.
pub const CLEAR: f64 = 2.2;

impl Difference {
    /// The errors of a configuration less those of another, in the same views.
    pub fn between(own: &[f64], other: &[f64]) -> Self {
        let differences: Vec<f64> = own.iter().zip(other).map(|(own, other)| own - other).collect();
        let views = differences.len();
        Self {
            mean: mean(&differences),
            standard_error: spread(&differences).map(|spread| spread / (views as f64).sqrt()),
            better: differences.iter().filter(|d| **d < 0.0).count(),
            views,
        }
    }

    /// Whether the configuration is more exact, and by more than the views scatter.
    pub fn is_clear_gain(&self) -> bool {
        self.mean < -CLEAR * self.standard_error.unwrap_or(0.0)
    }
}

/// The mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The standard deviation of a sample of at least two.
pub fn spread(values: &[f64]) -> Option<f64> {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_is_clear_where_the_views_agree() {
        let other = [1.0, 2.0, 3.0, 4.0];
        let agreed = Difference::between(&[0.9, 1.8, 2.9, 3.8], &other);
        assert!((agreed.mean + 0.15).abs() < 1e-12 && agreed.is_clear_gain());
        // Spread of 0.1, 0.2, 0.1, 0.2 is 0.0577; of the mean of four, half of that.
        assert!((agreed.standard_error.unwrap() - 0.0577 / 2.0).abs() < 1e-4);
        assert_eq!((agreed.better, agreed.views), (4, 4));
        let scattered = Difference::between(&[0.5, 2.3, 2.6, 4.2], &other);
        assert!(scattered.mean < 0.0 && !scattered.is_clear_gain());
        assert_eq!(scattered.better, 2);
        // One view has no spread to compare with: it says what it says.
        let single = Difference::between(&[0.9], &[1.0]);
        assert_eq!(single.standard_error, None);
        assert!(single.is_clear_gain());
        assert!(!Difference::between(&[1.0], &[1.0]).is_clear_gain());
    }
}
