//! Grey ramps for projections, which show of each ray one value alone.
//!
//! A ramp runs over what projections along x, y and z would keep, whatever the view, so that a turn has one ramp: the
//! whole range of the data would leave the smallest values of rays black, and one outlier would leave all of them black.
//! Values become grey in proportion. Smallest ones become grey by their rank where nearly every ray crosses air: its
//! values lie close together, and in proportion they would all be black.

use slicecast_engine::camera::diagonal;
use slicecast_engine::error::RenderError;
use slicecast_engine::source::{AT_A_TIME, Source, each_slice};
use slicecast_scene::{Blend, Point, TransferFunction};
use slicecast_volume::Volume;

use crate::visibility::rounded;

/// Shares of the largest values that are black and not above white.
const SHARES: [f64; 2] = [0.01, 0.995];

/// Shares of the smallest values at which the ramp by rank has a point.
const RANKS: [f64; 9] = [0.0, 0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98, 1.0];

/// The mean grey below which the smallest values are too dark in proportion.
const DARK: f64 = 0.25;

/// Codes of a volume.
const CODES: usize = 4096;

/// Black to white over the values that a projection of the volume keeps; opaque. One grey if it keeps one value only. The voxels
/// come from a source.
///
/// # Errors
/// [`RenderError::Read`] if a file cannot be read.
pub fn ramp(volume: &Volume, source: &dyn Source, blend: Blend) -> Result<TransferFunction, RenderError> {
    let dims = volume.dims;
    let greys = match blend {
        Blend::Minimum => {
            let counts = kept(dims, source, u16::MAX, u16::min)?;
            let greys = in_proportion(&counts);
            if mean(&counts, &greys) < DARK {
                by_rank(&counts)
            } else {
                greys
            }
        }
        Blend::Average => in_proportion(&summed(dims, source, dims.map(|side| 1.0 / side.max(1) as f64))?),
        Blend::Additive => {
            let diagonal = diagonal(dims, volume.spacing);
            in_proportion(&summed(dims, source, volume.spacing.map(|spacing| spacing / diagonal))?)
        }
        _ => in_proportion(&kept(dims, source, 0, u16::max)?),
    };
    let point = |&(code, grey): &(usize, f64)| Point {
        value: volume.mapping.value(code as f64),
        colour: [grey; 3],
        opacity: 1.0,
    };
    Ok(TransferFunction {
        unit_distance: 1.0,
        points: greys.iter().map(point).collect(),
    })
}

/// Codes and their greys, black and white near the ends of what is kept.
fn in_proportion(counts: &[u64]) -> Vec<(usize, f64)> {
    let [low, high] = SHARES.map(|share| rank(counts, share));
    if low < high {
        vec![(low, 0.0), (high, 1.0)]
    } else {
        vec![(low, 0.5)]
    }
}

/// The mean grey of what is kept, on a ramp in proportion.
fn mean(counts: &[u64], greys: &[(usize, f64)]) -> f64 {
    let total = counts.iter().sum::<u64>().max(1) as f64;
    let grey = |code: usize| match greys {
        [(low, _), .., (high, _)] => ((code as f64 - *low as f64) / (high - low) as f64).clamp(0.0, 1.0),
        _ => 0.5,
    };
    let sum: f64 = counts
        .iter()
        .enumerate()
        .map(|(code, count)| *count as f64 * grey(code))
        .sum();
    sum / total
}

/// Codes and their greys: the share of what is kept that is smaller, one half of the equal ones counted in.
fn by_rank(counts: &[u64]) -> Vec<(usize, f64)> {
    let total = counts.iter().sum::<u64>().max(1) as f64;
    let mut codes = RANKS.map(|share| rank(counts, share)).to_vec();
    codes.dedup();
    let grey = |code: usize| {
        let below: u64 = counts[..code].iter().sum();
        (code, (below as f64 + counts[code] as f64 / 2.0) / total)
    };
    codes.into_iter().map(grey).collect()
}

/// A ramp in words.
pub fn described(ramp: &TransferFunction) -> String {
    match &ramp.points[..] {
        [low, .., high] => format!(
            "grey from {} (dark) to {} (bright)",
            rounded(low.value, 5),
            rounded(high.value, 5)
        ),
        [only] => format!("every ray keeps {}, which is drawn grey", rounded(only.value, 5)),
        [] => "nothing".into(),
    }
}

/// The least share of rays that keep the background as their smallest value where a minimum shows nothing else.
const CROSSING: f64 = 0.9;

/// The least share of background on the sides of a volume that lies in it.
const AROUND: f64 = 0.5;

/// The share of rays along x, y and z whose smallest value is that of the background around what is in the volume, if they
/// are nearly all. Background are the codes below `first`; a volume that they do not surround, as a piece cut out of a
/// lung, has none.
pub fn in_background(volume: &Volume, first: usize) -> Option<f64> {
    let below = |code: u16| usize::from(code) < first;
    let [nx, ny, nz] = volume.dims;
    let (mut sides, mut dark) = (0_u64, 0_u64);
    for (row, codes) in volume.voxels.chunks_exact(nx.max(1)).enumerate() {
        let (y, z) = (row % ny, row / ny);
        let inside = |at: usize, side: usize| at > 0 && at + 1 < side;
        let ends = if inside(y, ny) && inside(z, nz) {
            nx.max(2) - 1
        } else {
            1
        };
        for &code in codes.iter().step_by(ends) {
            sides += 1;
            dark += u64::from(below(code));
        }
    }
    let counts = kept(volume.dims, volume, u16::MAX, u16::min).ok()?;
    let rays: u64 = counts.iter().sum();
    let crossing = counts.iter().take(first).sum::<u64>() as f64 / rays.max(1) as f64;
    let surrounded = dark as f64 > AROUND * sides as f64;
    (surrounded && crossing > CROSSING).then_some(crossing)
}

/// How often rays along x, y and z keep each code.
fn kept(dims: [usize; 3], source: &dyn Source, none: u16, keep: fn(u16, u16) -> u16) -> Result<Vec<u64>, RenderError> {
    let [nx, ny, _] = dims;
    let mut counts = vec![0; CODES];
    let mut count = |codes: &[u16]| {
        for &code in codes {
            counts[usize::from(code).min(CODES - 1)] += 1;
        }
    };
    let mut along_z = vec![none; nx * ny];
    each_slice(source, dims, AT_A_TIME, &mut |slice| {
        let mut along_y = vec![none; nx];
        for (row, along_z) in slice.chunks_exact(nx).zip(along_z.chunks_exact_mut(nx)) {
            for ((&code, y), z) in row.iter().zip(&mut along_y).zip(along_z) {
                (*y, *z) = (keep(*y, code), keep(*z, code));
            }
            count(&[row.iter().copied().fold(none, keep)]);
        }
        count(&along_y);
    })?;
    count(&along_z);
    Ok(counts)
}

/// How often the sums of rays along x, y and z, times what a voxel along them counts, lie next to each code.
fn summed(dims: [usize; 3], source: &dyn Source, [x, y, z]: [f64; 3]) -> Result<Vec<u64>, RenderError> {
    let [nx, ny, _] = dims;
    let mut counts = vec![0; CODES];
    let mut count = |sums: &[u64], voxel: f64| {
        for &sum in sums {
            counts[((sum as f64 * voxel).round() as usize).min(CODES - 1)] += 1;
        }
    };
    let mut along_z = vec![0; nx * ny];
    each_slice(source, dims, AT_A_TIME, &mut |slice| {
        let mut along_y = vec![0; nx];
        for (row, along_z) in slice.chunks_exact(nx).zip(along_z.chunks_exact_mut(nx)) {
            for ((&code, y), z) in row.iter().zip(&mut along_y).zip(along_z) {
                (*y, *z) = (*y + u64::from(code), *z + u64::from(code));
            }
            count(&[row.iter().copied().map(u64::from).sum()], x);
        }
        count(&along_y, y);
    })?;
    count(&along_z, z);
    Ok(counts)
}

/// The least code that is not below this share of the counts.
fn rank(counts: &[u64], share: f64) -> usize {
    let total: u64 = counts.iter().sum();
    let wanted = (share * total as f64).ceil().max(1.0) as u64;
    let mut seen = 0;
    let found = counts.iter().position(|count| {
        seen += count;
        seen >= wanted
    });
    found.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_volume::Mapping;

    /// Noise of 10 to 19 with a bright thread along x, and one outlier.
    fn volume() -> Volume {
        let voxel = |index: usize| match index {
            0 => 4000,
            _ if index / 20 == 205 => 600,
            _ => 10 + ((7 * index + 3 * (index / 20) + index / 400) % 10) as u16,
        };
        Volume {
            name: "t".into(),
            dims: [20; 3],
            spacing: [1.0; 3],
            voxels: (0..8000).map(voxel).collect(),
            mapping: Mapping {
                scale: 2.0,
                offset: -100.0,
            },
        }
    }

    fn ends(volume: &Volume, blend: Blend) -> Vec<(f64, f64)> {
        let points = ramp(volume, volume, blend).unwrap().points;
        points.iter().map(|point| (point.value, point.colour[0])).collect()
    }

    #[test]
    fn ramps_run_over_what_rays_keep() {
        // In the data's unit; the outlier is above the ramp.
        assert_eq!(
            ends(&volume(), Blend::Maximum),
            [(2.0 * 19.0 - 100.0, 0.0), (1100.0, 1.0)]
        );
        // All rays but that along the thread meet the least of the noise.
        assert_eq!(ends(&volume(), Blend::Minimum), [(2.0 * 10.0 - 100.0, 0.5)]);
    }

    #[test]
    fn ramps_of_sums_run_over_what_rays_sum_up() {
        // A slab of 3 of 20 slices across z: rays along z mean 300, those along x and y 0 or 2000.
        let mut slab = volume();
        for (index, code) in slab.voxels.iter_mut().enumerate() {
            *code = if (8..11).contains(&(index / 400)) { 2000 } else { 0 };
        }
        assert_eq!(
            ends(&slab, Blend::Average),
            [(-100.0, 0.0), (2.0 * 2000.0 - 100.0, 1.0)]
        );
        // Over the diagonal: a side of it is 1 / sqrt(3).
        let most = (2000.0 / 3f64.sqrt()).round();
        assert_eq!(ends(&slab, Blend::Additive), [(-100.0, 0.0), (2.0 * most - 100.0, 1.0)]);
    }

    #[test]
    fn background_hides_what_is_smallest_inside() {
        // A ball with a hollow in air: every ray crosses the air.
        let ball = |around: u16, hollow: u16| {
            let voxel = |index: usize| {
                let place = [index % 20, index / 20 % 20, index / 400].map(|c| c as f64 - 9.5);
                let radius = place.iter().map(|c| c * c).sum::<f64>().sqrt();
                [hollow, 1000, around][usize::from(radius > 3.0) + usize::from(radius > 8.0)]
            };
            let voxels = (0..8000).map(voxel).collect();
            Volume { voxels, ..volume() }
        };
        assert_eq!(in_background(&ball(24, 20), 500), Some(1.0));
        // Cut out of tissue, it is what a minimum is for.
        assert_eq!(in_background(&ball(1000, 20), 500), None);
        // Rays that leave no background: a block that reaches from side to side.
        let mut block = ball(24, 20);
        for (index, code) in block.voxels.iter_mut().enumerate() {
            *code = if index / 400 < 8 { 1000 } else { 24 };
        }
        assert_eq!(in_background(&block, 500), None);
        // All six sides are looked at, and nothing else.
        let mut shell = ball(24, 20);
        for (index, code) in shell.voxels.iter_mut().enumerate() {
            let inside = [index % 20, index / 20 % 20, index / 400]
                .iter()
                .all(|c| (1..19).contains(c));
            *code = if inside { 1000 } else { 24 };
        }
        assert_eq!(in_background(&shell, 500), Some(1.0));
    }

    #[test]
    fn smallest_values_are_not_all_black() {
        // A tenth of the slices along z has no air.
        let mut air = volume();
        air.voxels
            .iter_mut()
            .for_each(|code| *code = if *code < 20 { 5 } else { *code });
        for slice in [4, 9] {
            air.voxels[400 * slice..400 * (slice + 1)].fill(3000);
        }
        let ramp = ends(&air, Blend::Minimum);
        let [(low, dark), .., (high, bright)] = ramp[..] else {
            panic!("{ramp:?}");
        };
        assert_eq!((low, high), (2.0 * 5.0 - 100.0, 2.0 * 3000.0 - 100.0));
        assert!((0.4..0.5).contains(&dark) && bright > 0.9, "{ramp:?}");
        // Tissue all around: in proportion.
        let mut dense = volume();
        for (index, code) in dense.voxels.iter_mut().enumerate() {
            *code = if index % 20 == 7 && index / 400 < 4 { 100 } else { 900 };
        }
        assert_eq!(ends(&dense, Blend::Minimum), [(100.0, 0.0), (1700.0, 1.0)]);
    }
}
