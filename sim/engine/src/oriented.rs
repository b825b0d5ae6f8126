//! What a plan holds of a volume, read along the view's major axis: measured slices, nearest to the eye first.
//!
//! Slices across y and z are read in place (rows along x are contiguous); slices across x need a transposed copy, as
//! large as the volume. Copying and measuring take all threads; many frames along the same axis need it
//! once ([`Prepared::render_oriented`](crate::frame::Prepared::render_oriented)).

use std::borrow::Cow;

use rayon::prelude::*;
use slicecast::classify::Support;
use slicecast::plan::Plan;
use slicecast::slice::{RowRange, Slice, SliceError, Voxel};
use slicecast::view::{Axis, View};

use crate::occupancy::{Looks, Occupancy, Sight};
use crate::simd::Simd;
use slicecast_volume::Volume;

/// The voxels of a volume as a view reads them, with room for what is measured of them.
#[derive(Clone, Debug)]
pub struct Turned<'v> {
    voxels: Cow<'v, [u16]>,
    /// Width and height of a slice.
    size: [usize; 2],
    /// Voxels from one slice to the next, and from one row to the next.
    strides: [usize; 2],
    reversed: bool,
    /// Of each row of each slice.
    ranges: Vec<RowRange>,
}

impl<'v> Turned<'v> {
    /// What a plan holds of a volume.
    pub fn new(volume: &'v Volume, plan: &Plan) -> Self {
        Self::of(volume, plan.view(), Held::of(plan))
    }

    /// All of a volume under a view.
    pub fn whole(volume: &'v Volume, view: &View) -> Self {
        let held = Held {
            first: [0; 3],
            dims: volume.dims,
        };
        Self::of(volume, view, held)
    }

    fn of(volume: &'v Volume, view: &View, held: Held) -> Self {
        let [nx, ny, _] = volume.dims;
        let [width, height, depth] = view.arrange(held.dims);
        let [x, y, z] = held.first;
        // Rows along x lie as they are; a plan that holds nothing else never looks at what is around them.
        let in_place = || Cow::from(volume.voxels.get(x + nx * (y + ny * z)..).unwrap_or(&[]));
        let (voxels, strides) = match view.major() {
            Axis::Z => (in_place(), [nx * ny, nx]),
            Axis::Y => (in_place(), [nx, nx * ny]),
            Axis::X => (
                Cow::from(transpose(&volume.voxels, volume.dims, held)),
                [width * height, width],
            ),
        };
        Self {
            voxels,
            size: [width, height],
            strides,
            reversed: view.reversed(),
            ranges: vec![RowRange::EMPTY; height * depth],
        }
    }

    /// Measures the slices, in the order in which the view meets them.
    ///
    /// # Errors
    /// [`SliceError`] if a voxel that is held is above 4095 or the volume has fewer voxels than its shape says.
    pub fn slices(&mut self) -> Result<Vec<Slice<'_>>, SliceError> {
        let ([width, height], [next, row_stride]) = (self.size, self.strides);
        let measure = |(k, ranges)| {
            let voxels = self.voxels.get(k * next..).unwrap_or(&[]);
            Slice::measure(voxels, width, height, row_stride, ranges)
        };
        let ranges = self.ranges.par_chunks_mut(height);
        let mut slices = ranges.enumerate().map(measure).collect::<Result<Vec<_>, _>>()?;
        if self.reversed {
            slices.reverse();
        }
        Ok(slices)
    }
}

/// A volume as views along one axis and direction meet it.
#[derive(Clone, Debug)]
pub struct Oriented<'a> {
    /// Its slices, nearest to the eye first.
    pub slices: &'a [Slice<'a>],
    occupancy: Occupancy,
    /// Share of blocks that can be seen from which on rows are made as a whole, where it is not the usual one.
    dense: Option<f64>,
}

/// Share of blocks that can be seen from which on these vectors make whole rows faster (docs/speed.md): one lane gains
/// nothing by short ways through many samples, and from back to front no ray is finished that blocks could leave out.
fn dense(simd: Simd, back_to_front: bool) -> f64 {
    match (simd, back_to_front) {
        (Simd::Scalar, _) => 0.125,
        (Simd::Avx2(_) | Simd::Avx512(_), true) => 0.4,
        (Simd::Avx2(_) | Simd::Avx512(_), false) => 0.5,
    }
}

impl<'a> Oriented<'a> {
    /// Measures the blocks of slices that [`Turned::slices`] has made.
    pub fn of(slices: &'a [Slice<'a>]) -> Self {
        Self {
            slices,
            occupancy: Occupancy::of(slices),
            dense: None,
        }
    }

    /// The same with another share of visible blocks from which on rows are made as a whole: 0 is always, and above 1
    /// never. Nothing but time depends on it.
    #[must_use]
    pub fn dense_from(self, share: f64) -> Self {
        Self {
            dense: Some(share),
            ..self
        }
    }

    /// What the blocks of the volume hold.
    pub fn occupancy(&self) -> &Occupancy {
        &self.occupancy
    }

    /// The blocks that a pipeline with this support can show, given what it looks at; none where they are so many that these vectors make rows faster
    /// as a whole.
    pub fn sight(&self, looks: Looks, support: Option<Support>, back_to_front: bool, simd: Simd) -> Option<Sight> {
        let support = support?;
        let few = self.occupancy.share(looks, support) < self.dense.unwrap_or(dense(simd, back_to_front));
        few.then(|| self.occupancy.sight(looks, support))
    }
}

/// Slices across x that are filled together: so many voxels of a row lie in one line of the cache.
const TOGETHER: usize = 32;

/// What a plan holds of a volume, along x, y and z.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// The first voxel.
    pub first: [usize; 3],
    /// How many.
    pub dims: [usize; 3],
}

impl Held {
    /// What a plan holds.
    pub fn of(plan: &Plan) -> Self {
        let ([i, j, mut k], dims) = (plan.first(), plan.dims());
        if plan.view().reversed() {
            k = plan.volume()[2] - dims[2] - k;
        }
        let along = |ijk: [u32; 3]| plan.view().restore(ijk).map(|n| n as usize);
        Self {
            first: along([i, j, k]),
            dims: along(dims),
        }
    }
}

/// The voxels of slices across x, rows along y, of what is held: `out[(x * nz + z) * ny + y]`.
fn transpose(voxels: &[u16], [width, height, _]: [usize; 3], held: Held) -> Vec<u16> {
    let ([x0, y0, z0], [nx, ny, nz]) = (held.first, held.dims);
    let mut out = vec![0; nx * ny * nz];
    let slice = ny * nz;
    out.par_chunks_mut(TOGETHER * slice)
        .enumerate()
        .for_each(|(group, out)| {
            let first = x0 + group * TOGETHER;
            let columns = first..first + out.len() / slice;
            for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
                let row = &voxels[((z0 + z) * height + y0 + y) * width..][..width];
                for (slice_out, &v) in out.chunks_exact_mut(slice).zip(&row[columns.clone()]) {
                    slice_out[z * ny + y] = v;
                }
            }
        });
    out
}

/// A slice's voxels as one run, as a scanner would deliver them.
pub fn packed<X: Voxel>(slice: &Slice<'_, X>) -> Vec<u16> {
    (0..slice.height()).flat_map(|row| slice.words(row)).copied().collect()
}
