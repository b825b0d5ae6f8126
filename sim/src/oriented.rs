//! A volume read along the view's major axis: measured slices, nearest to the eye first.
//!
//! Slices across z are read in place. Slices across x need a transposed copy, as large as the volume, and so do those
//! across y: their rows along x are contiguous, but lie a whole slice of the volume apart, which for sides of a power of
//! two is the same few places of the processor's cache for all rows of a tile. Copying and measuring take all threads; who renders many frames does it once for those that look
//! along the same axis ([`Prepared::render_slices`](crate::engine::Prepared::render_slices)).

use rayon::prelude::*;
use slicecast::classify::Support;
use slicecast::slice::{RowRange, Slice, SliceError};
use slicecast::view::{Axis, View};

use crate::occupancy::{Occupancy, Sight};
use crate::volume::Volume;

/// Calls `run` with the slices of a volume in the order in which the view meets them.
///
/// # Errors
/// [`SliceError`] if a voxel is above 4095 or the volume has fewer voxels than its shape says.
pub fn with_slices<R>(volume: &Volume, view: &View, run: impl FnOnce(&[Slice<'_>]) -> R) -> Result<R, SliceError> {
    let [nx, ny, nz] = volume.dims;
    let turned;
    // Width, height and number of slices; where slice k starts; how far its rows are apart.
    let (voxels, [width, height, depth], start, stride) = match view.major() {
        Axis::Z => (&volume.voxels[..], [nx, ny, nz], nx * ny, nx),
        Axis::Y => {
            turned = regroup(&volume.voxels, volume.dims);
            (&turned[..], [nx, nz, ny], nx * nz, nx)
        }
        Axis::X => {
            turned = transpose(&volume.voxels, volume.dims);
            (&turned[..], [ny, nz, nx], ny * nz, ny)
        }
    };
    let mut ranges = vec![RowRange::EMPTY; height * depth];
    let measure = |(k, ranges)| {
        let voxels = voxels.get(k * start..).unwrap_or(&[]);
        Slice::measure(voxels, width, height, stride, ranges)
    };
    let slices: Result<Vec<_>, _> = ranges.par_chunks_mut(height).enumerate().map(measure).collect();
    let mut slices = slices?;
    if view.reversed() {
        slices.reverse();
    }
    Ok(run(&slices))
}

/// A volume as views along one axis and direction meet it.
#[derive(Clone, Debug)]
pub struct Oriented<'a> {
    /// Its slices, nearest to the eye first.
    pub slices: &'a [Slice<'a>],
    /// What their blocks hold. Without it every row is made as a whole: the same bits in more time.
    pub occupancy: Option<Occupancy>,
}

impl<'a> Oriented<'a> {
    /// Measures the blocks of slices that [`with_slices`] has made.
    pub fn of(slices: &'a [Slice<'a>]) -> Self {
        Self {
            slices,
            occupancy: Some(Occupancy::of(slices)),
        }
    }

    /// The blocks that are worth asking under a table of this support. Where most are visible none is left out: to ask
    /// would take longer than what it saves.
    pub fn sight(&self, support: Option<Support>) -> Option<Sight> {
        let sight = self.occupancy.as_ref()?.sight(support?);
        (sight.share < DENSE).then_some(sight)
    }
}

/// Share of visible blocks from which on rows are made as a whole.
const DENSE: f64 = 0.95;

/// The voxels of slices across y, rows along x: `out[(y * nz + z) * nx + x]`.
fn regroup(voxels: &[u16], [nx, ny, nz]: [usize; 3]) -> Vec<u16> {
    let mut out = vec![0; voxels.len()];
    out.par_chunks_mut(nx * nz).enumerate().for_each(|(y, slice)| {
        let rows = voxels.chunks_exact(nx).skip(y).step_by(ny);
        for (out, row) in slice.chunks_exact_mut(nx).zip(rows) {
            out.copy_from_slice(row);
        }
    });
    out
}

/// Slices across x that are filled together: so many voxels of a row lie in one line of the cache.
const TOGETHER: usize = 32;

/// The voxels of slices across x, rows along y: `out[(x * nz + z) * ny + y]`.
fn transpose(voxels: &[u16], [nx, ny, nz]: [usize; 3]) -> Vec<u16> {
    let mut out = vec![0; voxels.len()];
    let slice = ny * nz;
    out.par_chunks_mut(TOGETHER * slice)
        .enumerate()
        .for_each(|(group, out)| {
            let first = group * TOGETHER;
            let columns = first..first + out.len() / slice;
            for (row_index, row) in voxels.chunks_exact(nx).enumerate() {
                let (y, z) = (row_index % ny, row_index / ny);
                for (slice_out, &v) in out.chunks_exact_mut(slice).zip(&row[columns.clone()]) {
                    slice_out[z * ny + y] = v;
                }
            }
        });
    out
}

/// A slice's voxels as one run, as a scanner would deliver them.
pub fn packed(slice: &Slice<'_>) -> Vec<u16> {
    (0..slice.height()).flat_map(|row| slice.row(row)).copied().collect()
}
