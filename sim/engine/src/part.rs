//! Planes that are folded from some of the slices, or from some of their columns and rows.

use std::ops::Range;

use slicecast::format::Position;
use slicecast::locate::cell;
use slicecast::plan::Plan;

/// Voxels that a brick has beside its cells, on each side.
pub(crate) const BESIDE: usize = 3;

/// Planes that are folded from a part of the slices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Numbers of the planes.
    pub planes: Range<u32>,
    /// Numbers of the slices, nearest to the eye first, that these planes look at.
    pub slices: Range<usize>,
    /// What of the slices there is, if they are not whole.
    pub brick: Option<Brick>,
}

/// Some columns and rows of slices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Brick {
    /// The voxels that there are, along i and j.
    pub voxels: [Range<usize>; 2],
    /// The cells whose samples are folded, counted from the first of these voxels; without an end where the volume ends.
    cells: [Range<i64>; 2],
}

impl Brick {
    /// The brick of some cells of slices of this size.
    pub(crate) fn of(cells: [Range<usize>; 2], size: [usize; 2]) -> Self {
        let voxels = [0, 1].map(|axis| {
            let Range { start, end } = cells[axis].clone();
            start.saturating_sub(BESIDE)..(end + 1 + BESIDE).min(size[axis])
        });
        let ends = [0, 1].map(|axis| {
            let (Range { start, end }, first) = (cells[axis].clone(), voxels[axis].start as i64);
            let start = if start == 0 { i64::MIN / 2 } else { start as i64 - first };
            let end = if end >= size[axis] {
                i64::MAX / 2
            } else {
                end as i64 - first
            };
            start..end
        });
        Self { voxels, cells: ends }
    }

    /// The plan of its voxels.
    pub(crate) fn plan(&self, plan: &Plan) -> Plan {
        let [i, j] = &self.voxels;
        plan.of_voxels([i.start as u32, j.start as u32], [i.len() as u32, j.len() as u32])
    }

    /// Those of some pixels along an axis whose samples lie in its cells, given where that of pixel 0 lies among its voxels.
    pub(crate) fn pixels(&self, axis: usize, at: Position, pixels: Range<u32>) -> Range<u32> {
        let (Range { start, end }, first) = (self.cells[axis].clone(), i64::from(cell(at).index));
        let held = |pixel: i64| pixel.clamp(pixels.start.into(), pixels.end.into()) as u32;
        let start = held(start - first);
        start..held(end - first).max(start)
    }
}

/// The planes of a volume in parts of at most `most` slices, in the order of folding; `near` is the slice that a plane's window
/// begins with, and rises with the planes.
pub(crate) fn parts(
    planes: Range<u32>,
    depth: u32,
    near: impl Fn(u32) -> i32,
    back_to_front: bool,
    most: usize,
) -> Vec<Part> {
    let depth = depth as usize;
    let looked_at = |plane: u32| {
        let near = near(plane);
        let first = usize::try_from(near - 1).unwrap_or(0).min(depth.saturating_sub(1));
        let end = usize::try_from(near + 3)
            .unwrap_or(0)
            .clamp(first + 1, depth.max(first + 1));
        first..end
    };
    let mut parts: Vec<Part> = Vec::new();
    for step in 0..planes.len() as u32 {
        let plane = if back_to_front {
            planes.end - 1 - step
        } else {
            planes.start + step
        };
        let slices = looked_at(plane);
        let joined = parts.last().map(|part| {
            let all = &part.slices;
            let slices = all.start.min(slices.start)..all.end.max(slices.end);
            (part.planes.start.min(plane)..part.planes.end.max(plane + 1), slices)
        });
        match (joined, parts.last_mut()) {
            (Some((planes, slices)), Some(part)) if slices.len() <= most => {
                (part.planes, part.slices) = (planes, slices)
            }
            _ => parts.push(Part {
                planes: plane..plane + 1,
                slices,
                brick: None,
            }),
        }
    }
    parts
}
