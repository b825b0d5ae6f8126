//! Opacities filtered in place of extinctions, for comparison.
//!
//! Source: Kraus and Bürger, section 4.1 and figure 3: opacities alpha over one distance d', and colours times alpha, are
//! averaged; the extinction of the mean is -ln(1 - alpha) / d'. Since alpha is concave in the extinction, matter is lost. In f64,
//! each code rounded to the nearest; an opacity of 1 is the largest extinction.

use std::ops::AddAssign;

use crate::filter::Filter;
use crate::reduce::{Channels, gain, sum_rows};
use crate::volume::RgbaVolume;
use crate::voxel::{Codes, MAX_CODE};

/// Red, green and blue times opacity, and opacity.
#[derive(Clone, Copy, Default)]
struct Opacities([f64; 4]);

impl AddAssign for Opacities {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += more);
    }
}

impl Channels for Opacities {
    fn times(self, weight: u32) -> Self {
        Self(self.0.map(|value| f64::from(weight) * value))
    }
}

/// The codes of the coarse volume.
pub fn reduce(volume: &RgbaVolume, filter: Filter, distance: f64) -> Vec<Codes> {
    let scale = volume.tau_max * distance;
    let one = f64::from(MAX_CODE);
    let opacities = |codes: Codes| match codes[3] {
        0 => Opacities::default(),
        tau => {
            let alpha = -(-scale * f64::from(tau) / one).exp_m1();
            Opacities(codes.map(|code| f64::from(code) / f64::from(tau) * alpha))
        }
    };
    let area = volume.dims[0] * volume.dims[1];
    let slice = |z: usize, out: &mut Vec<Opacities>| {
        out.extend((z * area..(z + 1) * area).map(|index| opacities(volume.voxels.codes(index))));
    };
    let share = f64::from(gain(filter, volume.dims)).exp2().recip();
    let mut coarse = Vec::new();
    sum_rows(filter, volume.dims, &slice, &mut |row: &[Opacities]| {
        coarse.extend(row.iter().map(|Opacities(sums)| {
            let alpha = (sums[3] * share).min(1.0);
            let tau = (-one * (-alpha).ln_1p() / scale).min(one).round();
            let codes = sums.map(|sum| {
                if alpha > 0.0 {
                    (sum * share / alpha * tau).round().min(tau)
                } else {
                    0.0
                }
            });
            codes.map(|code| code as u16)
        }));
    });
    coarse
}
