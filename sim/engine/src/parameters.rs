//! What a pipeline needs to know of a scene.

use slicecast::modulate::Modulation;
use slicecast::perspective::Spread;
use slicecast::project::Sum;

use crate::camera::{Material, Setup};

/// What a pipeline needs to know of a scene on a volume besides geometry and classifier.
#[derive(Clone, Copy, Debug)]
pub struct Parameters<'a> {
    /// Lights; `None` is unlit.
    pub material: Option<&'a Material>,
    /// Factors by the magnitude of the gradient, of samples.
    pub modulation: Option<&'a Modulation>,
    /// What an additive projection makes of a sum.
    pub additive: Sum,
    /// The rays of a plan in perspective.
    pub spread: Option<&'a Spread>,
}

impl<'a> Parameters<'a> {
    /// Those of a setup and a modulation.
    pub const fn of(setup: &'a Setup, modulation: Option<&'a Modulation>) -> Self {
        Self {
            material: setup.material.as_ref(),
            modulation,
            additive: setup.additive,
            spread: setup.spread.as_ref(),
        }
    }
}
