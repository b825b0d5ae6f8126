//! Directions that are no axes.

use thiserror::Error;

/// Directions that are no axes of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AxesError {
    /// A direction without length, or with one that is no number.
    #[error("states the direction ({}, {}, {}) for its axis {}, expected a finite vector that is not 0",
        .direction[0], .direction[1], .direction[2], ["x", "y", "z"][*.axis])]
    Direction {
        /// 0, 1, 2 for the file's x, y, z.
        axis: usize,
        /// The direction as stated.
        direction: [f64; 3],
    },
    /// Two axes that are not at right angles.
    #[error(
        "has axes {} and {} at {angle:.2} degrees, expected right angles (a tilted gantry or a sheared volume is not read)",
        ["x", "y", "z"][.axes[0]], ["x", "y", "z"][.axes[1]]
    )]
    Sheared {
        /// The two axes of the file.
        axes: [usize; 2],
        /// The angle between them, degrees.
        angle: f64,
    },
}
