//! The hard cases: inputs on which numerical errors show, what theory expects of each, and what each precision gives.
//!
//! Every case runs the pipeline, or a stage's own definition where a ray or a step is all that there is to it. A figure
//! has a limit where the contract, algebra or the study gives one; the others are there to be compared. Limits say where
//! they come from.

pub mod borders;
pub mod clip;
pub mod compositing;
pub mod crop;
pub mod extremes;
pub mod fast;
pub mod gradients;
pub mod gradual;
pub mod levels;
pub mod location;
pub mod perspective;
pub mod sampling;
pub(crate) mod scenes;
pub mod segments;
pub mod sphere;
pub mod splat;
pub mod splat_eye;
pub mod surfaces;
pub mod transfer;
pub mod views;

use serde::Serialize;

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Everything, for a release build.
    Full,
    /// A part that a test and a report can afford.
    Reduced,
}

/// What one precision, or one way of doing it, gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// The precision or configuration.
    pub who: String,
    /// The figure.
    pub value: f64,
    /// How far it may be from what theory expects; `None` where no claim is made.
    pub allowed: Option<f64>,
}

/// A hard case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The kind of difficulty.
    pub group: &'static str,
    /// The case.
    pub name: String,
    /// What the figures are, and their unit.
    pub quantity: &'static str,
    /// What theory expects.
    pub expected: f64,
    /// Why.
    pub theory: String,
    /// What there is.
    pub outcomes: Vec<Outcome>,
    /// Squeeze's own figure.
    pub paper: Option<String>,
    /// The pre-project study's figure.
    pub study: Option<String>,
    /// Where limits come from, and what does not reproduce.
    pub note: Option<String>,
}

impl Case {
    /// A case without outcomes yet.
    fn new(
        group: &'static str,
        name: impl Into<String>,
        quantity: &'static str,
        expected: f64,
        theory: impl Into<String>,
    ) -> Self {
        Self {
            group,
            name: name.into(),
            quantity,
            expected,
            theory: theory.into(),
            outcomes: Vec::new(),
            paper: None,
            study: None,
            note: None,
        }
    }

    /// Adds an outcome.
    fn outcome(&mut self, who: impl Into<String>, value: f64, allowed: Option<f64>) {
        self.outcomes.push(Outcome {
            who: who.into(),
            value,
            allowed,
        });
    }

    /// The outcomes that are further from theory than allowed.
    pub fn failures(&self) -> Vec<&Outcome> {
        let failed = |outcome: &&Outcome| {
            let away = (outcome.value - self.expected).abs();
            // A figure that is no number is as wrong as can be.
            outcome.allowed.is_some_and(|allowed| away.is_nan() || away > allowed)
        };
        self.outcomes.iter().filter(failed).collect()
    }

    /// Whether every outcome keeps to its limit.
    pub fn holds(&self) -> bool {
        self.failures().is_empty()
    }
}

/// Runs all hard cases. `progress` is told how many groups of how many are done.
///
/// # Errors
/// [`RenderError`](slicecast_engine::error::RenderError) if the machine cannot run one.
pub fn run(size: Size, progress: &dyn Fn(usize, usize)) -> Result<Vec<Case>, slicecast_engine::error::RenderError> {
    type Group = fn(Size) -> Result<Vec<Case>, slicecast_engine::error::RenderError>;
    let groups: [Group; 19] = [
        |size| Ok(compositing::cases(size)),
        |size| Ok(location::cases(size)),
        extremes::cases,
        gradients::cases,
        sphere::cases,
        transfer::cases,
        views::cases,
        perspective::cases,
        splat::cases,
        splat_eye::cases,
        fast::cases,
        sampling::cases,
        segments::cases,
        surfaces::cases,
        borders::cases,
        crop::cases,
        clip::cases,
        levels::cases,
        gradual::cases,
    ];
    let mut cases = Vec::new();
    for (done, group) in groups.iter().enumerate() {
        progress(done, groups.len());
        cases.extend(group(size)?);
    }
    progress(groups.len(), groups.len());
    Ok(cases)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reduced form of `slicecast hard`: every limit holds, in a build that checks every sum for overflow when it
    /// is a debug one.
    #[test]
    fn every_limit_holds() {
        let cases = run(Size::Reduced, &|_, _| ()).unwrap();
        let claims: usize = cases
            .iter()
            .map(|case| case.outcomes.iter().filter(|o| o.allowed.is_some()).count())
            .sum();
        assert!(claims > 60, "{claims} claims");
        for case in &cases {
            assert!(case.holds(), "{}: {}: {:?}", case.group, case.name, case.failures());
        }
    }

    #[test]
    fn a_figure_beyond_its_limit_fails() {
        let mut case = Case::new("group", "name", "unit", 1.0, "so");
        case.outcome("a", 1.5, Some(0.5));
        case.outcome("b", 9.0, None);
        assert!(case.holds());
        case.outcome("c", 1.6, Some(0.5));
        case.outcome("d", f64::NAN, Some(0.5));
        let failed: Vec<_> = case.failures().iter().map(|o| o.who.clone()).collect();
        assert_eq!(failed, ["c", "d"]);
    }
}
