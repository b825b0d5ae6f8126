//! Whether a transfer function is finer than the field that it is sampled on.
//!
//! A peak of the extinction that is narrower, in codes, than what neighbouring samples differ by where they meet it falls
//! between them: point classification then shows wood grain, or nothing. The measure is the peak's width at half its height
//! against the median difference of neighbouring voxels that have some of it, but not only of it, between them, divided by the planes per voxel.

use rayon::prelude::*;
use slicecast_scene::{Interpolation, Scene};
use slicecast_volume::Volume;

use crate::error::RenderError;
use crate::source::Source;

/// Codes.
const CODES: usize = 4096;

/// Peaks below this share of the highest are not looked at.
const LOWEST: f64 = 1.0 / 16.0;

/// The most peaks that are looked at, the narrowest first.
const PEAKS: usize = 32;

/// About how many pairs of voxels are looked at along each axis.
const PAIRS: usize = 20_000;

/// Pairs that must meet a peak before anything is said about it.
const PAIRS_LEAST: u32 = 16;

/// The peak of a transfer function that is finest beside the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finest {
    /// The first and the last code of the peak, at half its height.
    pub codes: [u16; 2],
    /// Codes of the peak, at half its height.
    pub width: f64,
    /// What neighbouring samples that meet it differ by, codes; the median.
    pub difference: f64,
}

impl Finest {
    /// Whether samples step over the peak.
    pub fn is_missed(&self) -> bool {
        self.difference > self.width
    }
}

/// The finest peak of a scene's transfer function on a volume, whose voxels come from a source; `None` where there is none, or
/// nothing is integrated.
///
/// # Errors
/// [`RenderError::Read`] if a file cannot be read.
pub fn of(scene: &Scene, volume: &Volume, source: &dyn Source) -> Result<Option<Finest>, RenderError> {
    let composited = scene.blend.is_composited();
    if !composited || scene.interpolation == Interpolation::Nearest {
        return Ok(None);
    }
    let depths: Vec<f64> = (0..CODES)
        .map(|code| scene.transfer.evaluate(volume.mapping.value(code as f64)).1)
        .map(|opacity| -(-opacity.min(1.0 - 1e-7)).ln_1p())
        .collect();
    let mut peaks = peaks(&depths);
    if peaks.is_empty() {
        return Ok(None);
    }
    peaks.sort_by_key(|[low, high]| high - low);
    peaks.truncate(PEAKS);
    let planes = f64::from(scene.sampling.planes_per_voxel);
    let finest = (differences(volume.dims, source, &peaks)?.into_iter().zip(peaks))
        .filter_map(|(difference, [low, high])| {
            let difference = difference? / planes;
            Some(Finest {
                codes: [low as u16, high as u16],
                width: (high - low + 1) as f64,
                difference,
            })
        })
        .max_by(|a, b| (a.difference / a.width).total_cmp(&(b.difference / b.width)));
    Ok(finest)
}

/// First and last codes, at half height, of the peaks that fall off on both sides.
fn peaks(depths: &[f64]) -> Vec<[usize; 2]> {
    let highest = depths.iter().copied().fold(0.0, f64::max);
    let mut peaks = Vec::new();
    let mut code = 0;
    while code < depths.len() {
        let height = depths[code];
        let end = code + depths[code..].iter().take_while(|depth| **depth == height).count();
        let rises = code > 0 && depths[code - 1] < height;
        let falls = end < depths.len() && depths[end] < height;
        if rises && falls && height >= LOWEST * highest {
            let below = |depth: &f64| *depth < height / 2.0;
            let low = depths[..code].iter().rposition(below);
            let high = depths[end..].iter().position(below);
            if let (Some(low), Some(high)) = (low, high) {
                peaks.push([low + 1, end + high - 1]);
            }
        }
        code = end;
    }
    peaks
}

/// The median difference of neighbouring voxels that have some of each peak between them, and something else.
fn differences(dims: [usize; 3], source: &dyn Source, peaks: &[[usize; 2]]) -> Result<Vec<Option<f64>>, RenderError> {
    let (all, [nx, ny, _]) = (dims.iter().product::<usize>(), dims);
    let step = (all / PAIRS).max(1) | 1;
    let none = || vec![vec![0u32; CODES]; peaks.len()];
    let count = |mut counts: Vec<Vec<u32>>, number: usize| {
        let place = number * step;
        let first = [place % nx, place / nx % ny, place / nx / ny];
        let sides = [0, 1, 2].map(|axis| (dims[axis] - first[axis]).min(2));
        let about = source.voxels(first, sides)?;
        let code = |at: usize| about.voxels.get(at).map_or(0, |code| usize::from(*code));
        let neighbours = [1, sides[0], sides[0] * sides[1]].into_iter().zip(sides);
        for (stride, _) in neighbours.filter(|(_, side)| *side > 1) {
            let ends = [code(0), code(stride)];
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            for (counts, [from, to]) in counts.iter_mut().zip(peaks) {
                let (meets, inside) = (low <= *to && *from <= high, *from <= low && high <= *to);
                if meets && !inside {
                    counts[(high - low).min(CODES - 1)] += 1;
                }
            }
        }
        Ok::<_, RenderError>(counts)
    };
    let join = |mut counts: Vec<Vec<u32>>, others: Vec<Vec<u32>>| {
        for (count, other) in counts.iter_mut().flatten().zip(others.iter().flatten()) {
            *count += other;
        }
        Ok(counts)
    };
    let counts = (0..all.div_ceil(step))
        .into_par_iter()
        .try_fold(none, count)
        .try_reduce(none, join)?;
    let median = |counts: Vec<u32>| {
        let pairs: u32 = counts.iter().sum();
        let mut seen = 0;
        let middle = counts.iter().position(|count| {
            seen += count;
            2 * seen >= pairs
        });
        (pairs >= PAIRS_LEAST).then(|| middle.unwrap_or(0) as f64)
    };
    Ok(counts.into_iter().map(median).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_scene::Point;
    use slicecast_scene::file::built_in;
    use slicecast_volume::Mapping;

    fn ramp(per_voxel: usize) -> Volume {
        Volume {
            name: "ramp".into(),
            dims: [20, 20, 20],
            spacing: [1.0; 3],
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
            voxels: (0..8000).map(|n| (n / 400 * per_voxel) as u16).collect(),
        }
    }

    fn with_points(points: &[(f64, f64)]) -> Scene {
        let mut scene = built_in("ct-fog").unwrap();
        let point = |&(value, opacity)| Point {
            value,
            colour: [1.0; 3],
            opacity,
        };
        scene.transfer.points = points.iter().map(point).collect();
        scene
    }

    fn finest_of(scene: &Scene) -> Option<Finest> {
        let volume = ramp(50);
        of(scene, &volume, &volume).unwrap()
    }

    #[test]
    fn a_thin_shell_is_missed_until_planes_are_as_fine() {
        let mut scene = with_points(&[(400.0, 0.0), (410.0, 0.9), (420.0, 0.0)]);
        let finest = finest_of(&scene).unwrap();
        // The extinction of an opacity of 0.9 is at half its height where the opacity is 1 - sqrt(0.1).
        assert_eq!((finest.codes, finest.width, finest.difference), ([408, 412], 5.0, 50.0));
        assert!(finest.is_missed());
        scene.sampling.planes_per_voxel = 16;
        assert!(!finest_of(&scene).unwrap().is_missed());
    }

    #[test]
    fn ramps_and_flat_tables_have_no_peak() {
        assert_eq!(finest_of(&with_points(&[(0.0, 0.0), (4000.0, 0.9)])), None);
        assert_eq!(finest_of(&with_points(&[(0.0, 0.5)])), None);
        let mut scene = with_points(&[(400.0, 0.0), (410.0, 0.9), (420.0, 0.0)]);
        scene.blend = slicecast_scene::Blend::Maximum;
        assert_eq!(finest_of(&scene), None);
    }
}
