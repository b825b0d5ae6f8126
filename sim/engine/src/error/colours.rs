//! Why a volume of colours is not rendered.

use slicecast_scene::check::shown;

/// Why a volume of colour and extinction is not rendered as a scene asks.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ColourError {
    /// A precision without such pixels.
    #[error("volumes of colours are not rendered in paper or fast, expected --precision compact or wide")]
    Paper,
    /// Another order, or no compositing.
    #[error("volumes of colours are composited from front to back, expected no other --blend")]
    Blend,
    /// A step that is opaque, so that its depth has no number.
    #[error(
        "a step of {} through the largest extinction, {} per unit of length, has the optical depth {}, expected at most 15; \
         a smaller --tau-max or more --planes make it less", brief(*.step), brief(*.tau_max), brief(.step * .tau_max)
    )]
    Opaque {
        /// Length of a step, in the unit of the spacing.
        step: f64,
        /// The volume's largest extinction.
        tau_max: f64,
    },
}

/// Four digits of a number.
fn brief(value: f64) -> String {
    shown(format!("{value:.3e}").parse().unwrap_or(value))
}
