//! Levels of a pyramid.

use crate::filter::Filter;
use crate::opacity;
use crate::reduce::{axes, reduce};
use crate::volume::{RgbaVolume, Voxels};

/// What is filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum By {
    /// Extinctions, and colours times extinction: in integers, as [`reduce`].
    Extinction,
    /// Opacities over this distance, and colours times opacity: what most programs filter, for comparison, in f64.
    Opacity {
        /// In the unit of the spacing; above 0.
        distance: f64,
    },
}

/// The next level; `None` if no axis can become shorter.
pub fn next(volume: &RgbaVolume, filter: Filter, by: By) -> Option<RgbaVolume> {
    let axes = axes(filter, volume.dims);
    if !axes.iter().any(|axis| axis.is_reduced()) {
        return None;
    }
    let codes = match by {
        By::Extinction => reduce(filter, volume.dims, &|z, out| volume.slice(z, out)),
        By::Opacity { distance } => opacity::reduce(volume, filter, distance),
    };
    let factor = |axis: usize| if axes[axis].is_reduced() { 2.0 } else { 1.0 };
    Some(RgbaVolume {
        name: volume.name.clone(),
        dims: axes.map(|axis| axis.coarse),
        spacing: [0, 1, 2].map(|axis| volume.spacing[axis] * factor(axis)),
        orientation: volume.orientation.clone(),
        tau_max: volume.tau_max,
        alpha_distance: volume.alpha_distance,
        voxels: Voxels::Codes(codes),
    })
}
