//! What levels of a pyramid keep of the opacity of a picture: by the integer pyramid itself.
//!
//! Source: Kraus and Bürger, section 4.1. Figures 2 and 3 are eight voxels, four with an extinction of 4. A sheet keeps its
//! opacity by extinctions and loses it by opacities. The paper does not say that matter which does not fill its voxels becomes
//! denser by extinctions: where voxels are opaque here and there, the mean of 1 - e^-tau is less than 1 - e^(-mean tau).

use serde::Serialize;
use slicecast_volume::values::Orientation;

use crate::filter::Filter;
use crate::pyramid::{By, next};
use crate::volume::{RgbaVolume, Voxels};
use crate::voxel::{Codes, MAX_CODE};

/// Voxels along each axis of a sheet or of points.
const SIDE: usize = 64;

/// Levels below the finest.
const LEVELS: usize = 3;

/// Opacity along z, level after level.
#[derive(Clone, Debug, Serialize)]
pub struct Kept {
    /// What the volume holds.
    pub what: &'static str,
    /// By which filter.
    pub filter: Filter,
    /// Filtered by extinctions.
    pub extinction: Vec<f64>,
    /// Filtered by opacities over a voxel.
    pub opacity: Vec<f64>,
}

fn volume(side: usize, tau_max: f64, share: impl FnMut([usize; 3]) -> f64) -> RgbaVolume {
    let places = (0..side.pow(3)).map(|i| [i % side, i / side % side, i / side / side]);
    let codes = places
        .map(share)
        .map(|share| [(share * f64::from(MAX_CODE)).round() as u16; 4]);
    RgbaVolume {
        name: String::new(),
        dims: [side; 3],
        spacing: [1.0; 3],
        orientation: Orientation::Unknown,
        tau_max,
        alpha_distance: None,
        voxels: Voxels::Codes(codes.collect::<Vec<Codes>>()),
    }
}

fn kept(what: &'static str, filter: Filter, levels: usize, finest: &RgbaVolume) -> Kept {
    let by = |by: By| {
        let mut level = finest.clone();
        let mut opacities = vec![level.opacity_along_z()];
        while opacities.len() <= levels {
            let Some(coarse) = next(&level, filter, by) else { break };
            level = coarse;
            opacities.push(level.opacity_along_z());
        }
        opacities
    };
    Kept {
        what,
        filter,
        extinction: by(By::Extinction),
        opacity: by(By::Opacity { distance: 1.0 }),
    }
}

/// Figures 2 and 3; a sheet across the view, 1.4 voxels thick; and points, one voxel in forty opaque.
pub fn figures() -> Vec<Kept> {
    // Pairs behind each other: what is behind the first is clear.
    let pair = volume(2, 4.0, |[_, _, z]| if z == 0 { 1.0 } else { 0.0 });
    let normal = [0.35, 0.2, 1.0].map(|c: f64| c / (0.35_f64.powi(2) + 0.2_f64.powi(2) + 1.0).sqrt());
    let sheet = volume(SIDE, 4.0, |place| {
        let middle = (SIDE - 1) as f64 / 2.0;
        let away: f64 = (0..3).map(|axis| normal[axis] * (place[axis] as f64 - middle)).sum();
        (0.7 + 0.5 - away.abs()).clamp(0.0, 1.0)
    });
    let mut state = 2008_u64;
    let points = volume(SIDE, 8.0, |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        if (state >> 33).is_multiple_of(40) { 1.0 } else { 0.0 }
    });
    let mut all = vec![kept("eight voxels, four of extinction 4", Filter::Two, 1, &pair)];
    for filter in [Filter::Two, Filter::Four, Filter::Six] {
        all.push(kept(
            "a sheet of extinction 4, 1.4 thick, oblique",
            filter,
            LEVELS,
            &sheet,
        ));
        all.push(kept("points of extinction 8, one voxel in 40", filter, LEVELS, &points));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_keep_what_the_page_says() {
        let all = figures();
        let pair = &all[0];
        assert!((pair.extinction[1] - 0.981_684).abs() < 1e-5 && (pair.opacity[1] - 0.740_758).abs() < 1e-4);
        for kept in &all[1..] {
            let [fine, extinction, opacity] = [kept.extinction[0], kept.extinction[1], kept.opacity[1]];
            assert_eq!(kept.extinction.len(), LEVELS + 1);
            if kept.what.starts_with("points") {
                assert!(
                    extinction > fine + 0.1 && (opacity - fine).abs() < 0.05,
                    "denser: {kept:?}"
                );
            } else {
                assert!(opacity < fine - 0.01 && extinction >= fine - 1e-3, "{kept:?}");
            }
        }
    }
}
