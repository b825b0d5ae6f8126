//! What levels of a pyramid keep of the opacity of a picture: by the integer pyramid itself.
//!
//! Source: Kraus and Bürger, section 4.1. Figures 2 and 3 are eight voxels, four with an extinction of 4. A sheet keeps its
//! opacity by extinctions and loses it by opacities. The paper does not say that matter which does not fill its voxels becomes
//! denser by extinctions: where voxels are opaque here and there, the mean of 1 - e^-tau is less than 1 - e^(-mean tau).

use serde::Serialize;
use slicecast_volume::decoded::Orientation;

use crate::filter::Filter;
use crate::pyramid::{By, next};
use crate::reduce::{Sums, gain, sum_rows};
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

/// Mean codes of thin matter, level after level.
#[derive(Clone, Debug, Serialize)]
pub struct Thin {
    /// By which filter.
    pub filter: Filter,
    /// What is left over is carried along the row: the pyramid.
    pub carried: Vec<f64>,
    /// Every voxel is rounded to the nearest code, halves up.
    pub rounded: Vec<f64>,
}

/// Codes from 0 to 5, every one as often.
pub fn thin() -> Vec<Thin> {
    let mut state = 17_u64;
    let finest = volume(SIDE, 1.0, |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % 6) as f64 / f64::from(MAX_CODE)
    });
    let mean = |level: &RgbaVolume| {
        let codes = (0..level.voxels.len()).map(|index| f64::from(level.voxels.codes(index)[3]));
        codes.sum::<f64>() / level.voxels.len() as f64
    };
    let by = |filter: Filter| {
        let levels = |next: &dyn Fn(&RgbaVolume) -> Option<RgbaVolume>| {
            let levels = std::iter::successors(Some(finest.clone()), |level| next(level));
            levels.take(LEVELS + 1).map(|level| mean(&level)).collect()
        };
        Thin {
            filter,
            carried: levels(&|level| next(level, filter, By::Extinction)),
            rounded: levels(&|level| next_rounded(level, filter)),
        }
    };
    Filter::ALL.map(by).to_vec()
}

/// The next level with every voxel rounded by itself.
fn next_rounded(level: &RgbaVolume, filter: Filter) -> Option<RgbaVolume> {
    let bits = gain(filter, level.dims);
    let mut codes = Vec::new();
    sum_rows(
        filter,
        level.dims,
        &|z, out| level.slice(z, out),
        &mut |row: &[Sums]| {
            codes.extend(
                row.iter()
                    .map(|sums| sums.0.map(|sum| ((sum + ((1 << bits) >> 1)) >> bits) as u16)),
            );
        },
    );
    let coarse = next(level, filter, By::Extinction)?;
    Some(RgbaVolume {
        voxels: Voxels::Codes(codes),
        ..coarse
    })
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

    /// Rounding drifts in thin matter, up or down; what is carried keeps it.
    #[test]
    fn thin_matter_is_kept() {
        for Thin {
            filter,
            carried,
            rounded,
        } in thin()
        {
            let away = |means: &[f64]| means.iter().map(|mean| (mean - means[0]).abs()).fold(0.0, f64::max);
            // Rows of 32, 16 and 8 voxels lose or win half a code at most; the mean of nodes is not the sum that is kept.
            assert!(
                filter.on_nodes() || away(&carried) <= 0.5 * (1.0 / 32.0 + 1.0 / 16.0 + 1.0 / 8.0),
                "{carried:?}"
            );
            assert!(
                3.0 * away(&carried) < away(&rounded),
                "{filter:?} {carried:?} {rounded:?}"
            );
        }
    }
}
