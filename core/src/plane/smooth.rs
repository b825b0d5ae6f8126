//! Sources of samples by splines of second degree: rows between three slices, three rows and three columns. [`Smooth`] makes samples, of
//! values or of one channel of colours; [`Sloped`] makes the gradients of values besides.
//!
//! Beyond its faces the volume's outermost voxels are repeated. A sample that is held to the voxels lies at one of them.

use core::marker::PhantomData;
use core::ops::Range;

use super::extent::Extent;
use super::scratch::{NO_ROW, SlopeRows, SmoothRows};
use super::source::{Source, spaced};
use crate::classify::Slab;
use crate::format::Intensity;
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::quadratic::{is_behind, slopes, weights, x_row, x_slope_row, y_row, y_slope_row, z_row, z_slope_row};
use crate::rows::{part, part_mut, three};
use crate::shade::Asked;
use crate::slice::{RowRange, Slice, Window};

/// Rows of samples of one plane. A row is named by the voxel row before its samples.
pub(super) struct Smooth<'s, 'w, P, V> {
    extent: &'s Extent,
    /// The slice before the one nearest to the plane, that one, and the one behind it.
    slices: [Slice<'w>; 3],
    /// Voxels interpolated along z, of three voxel rows, by their numbers modulo 3; a row has a place for one voxel beyond each end.
    z: [&'s mut [i32]; 3],
    z_row: [i32; 3],
    /// The same interpolated along y.
    y: &'s mut [i32],
    samples: &'s mut [i32],
    precision: P,
    lanes: PhantomData<V>,
}

/// The slice nearest to a plane and its neighbours; an outermost one is its own.
fn nearest<'w>(window: &Window<'w>, extent: &Extent) -> [Slice<'w>; 3] {
    let far = window.far_or_near();
    if is_behind(extent.z.weight) {
        [window.near, far, window.after.unwrap_or(far)]
    } else {
        [window.before.unwrap_or(window.near), window.near, far]
    }
}

/// The voxel rows about the samples behind a voxel row: the nearest and its neighbours, held to the slice.
fn rows_about(extent: &Extent, row: i32) -> [i32; 3] {
    let at = row + i32::from(is_behind(extent.y.weight));
    let last = extent.height - 1;
    // Not `clamp`, which may panic.
    three([at - 1, at, at + 1], |row| row.min(last).max(0))
}

/// Those of three rows, each in the place of its number modulo 3, that have these numbers.
#[inline(always)]
fn of_three<'r>([a, b, c]: &'r [&mut [i32]; 3], rows: [i32; 3]) -> [&'r [i32]; 3] {
    three(rows, |row| match row.rem_euclid(3) {
        0 => &**a,
        1 => &**b,
        _ => &**c,
    })
}

/// Fills the places beyond both ends of a row with its outermost elements.
#[inline(always)]
fn repeat_ends(row: &mut [i32]) {
    if let [before, inner @ .., after] = row
        && let (Some(low), Some(high)) = (inner.first(), inner.last())
    {
        (*before, *after) = (*low, *high);
    }
}

/// The range of the voxels about the samples behind a voxel row.
pub(super) fn around(window: &Window<'_>, extent: &Extent, row: i32) -> RowRange {
    let mut range = RowRange::EMPTY;
    for slice in nearest(window, extent) {
        for row in rows_about(extent, row) {
            range = range.union(slice.range(row as usize));
        }
    }
    range
}

impl<'s, 'w, P: Precision, V: Lanes> Smooth<'s, 'w, P, V> {
    #[inline(always)]
    pub(super) fn new(precision: P, extent: &'s Extent, window: &Window<'w>, rows: SmoothRows<'s, i32>) -> Self {
        let len = window.near.width() + 2;
        let cut = |row: &'s mut [i32]| {
            let len = len.min(row.len());
            part_mut(row, 0..len)
        };
        Self {
            extent,
            slices: nearest(window, extent),
            z: three(rows.z, cut),
            z_row: [NO_ROW; 3],
            y: cut(rows.y),
            samples: part_mut(rows.samples, 0..extent.columns.len()),
            precision,
            lanes: PhantomData,
        }
    }

    /// Makes the samples of a row, one for each column of the plane's extent.
    #[inline(always)]
    pub(super) fn make(&mut self, row: i32) {
        V::enter((MakeRow, self, row));
    }

    /// The samples of the row that was made last.
    #[inline(always)]
    pub(super) fn samples(&self) -> &[i32] {
        self.samples
    }

    /// The same, to be changed.
    #[inline(always)]
    pub(super) fn samples_mut(&mut self) -> &mut [i32] {
        self.samples
    }

    /// Places, in a row with those beyond its ends, of the voxels about the samples.
    #[inline(always)]
    fn places(&self) -> Range<usize> {
        let nearest = self.extent.x.index + i32::from(is_behind(self.extent.x.weight));
        // The one before the nearest voxel lies at the nearest one's number.
        let first = (nearest as isize)
            .wrapping_add_unsigned(self.extent.columns.start)
            .max(0) as usize;
        first..first + self.extent.columns.len() + 2
    }

    #[inline(always)]
    fn make_row(&mut self, row: i32) {
        let rows = rows_about(self.extent, row);
        for row in rows {
            self.make_z(row);
        }
        let (p, places, Extent { x, y, .. }) = (self.precision, self.places(), self.extent);
        y_row::<P, V>(p, of_three(&self.z, rows), weights(p, y.weight), self.y);
        x_row::<P, V>(p, part(self.y, places), weights(p, x.weight), self.samples);
    }

    /// Makes the z interpolation of a voxel row.
    #[inline(always)]
    fn make_z(&mut self, row: i32) {
        let slot = row.rem_euclid(3) as usize;
        let (Some(out), Some(name)) = (self.z.get_mut(slot), self.z_row.get_mut(slot)) else {
            return;
        };
        if *name == row {
            return;
        }
        *name = row;
        let voxels = three(self.slices, |slice| slice.row(row as usize));
        let inner = 1..out.len().saturating_sub(1);
        z_row::<V>(
            voxels,
            weights(self.precision, self.extent.z.weight),
            part_mut(out, inner),
        );
        repeat_ends(out);
    }
}

struct MakeRow;

impl<P: Precision, V: Lanes> Kernel for (MakeRow, &mut Smooth<'_, '_, P, V>, i32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row) = self;
        source.make_row(row);
    }
}

/// Rows of samples of values, and of their gradients: those of the spline itself, of the same 27 voxels.
pub(super) struct Sloped<'s, 'w, P, V, A> {
    smooth: Smooth<'s, 'w, P, V>,
    spacing: [Intensity; 3],
    /// Slopes along z, of three voxel rows, as [`Smooth`] has its rows.
    z: [&'s mut [i32]; 3],
    z_row: [i32; 3],
    /// What is made along y, on its way to x.
    y: &'s mut [i32],
    asked: PhantomData<A>,
}

impl<'s, 'w, P: Precision, V: Lanes, A: Asked> Sloped<'s, 'w, P, V, A> {
    #[inline(always)]
    pub(super) fn new(
        precision: P,
        extent: &'s Extent,
        window: &Window<'w>,
        spacing: [Intensity; 3],
        (samples, SlopeRows { z, y }): (SmoothRows<'s, i32>, SlopeRows<'s, i32>),
    ) -> Self {
        let smooth = Smooth::new(precision, extent, window, samples);
        let len = smooth.y.len();
        Self {
            smooth,
            spacing,
            z: three(z, |row| {
                let len = len.min(row.len());
                part_mut(row, 0..len)
            }),
            z_row: [NO_ROW; 3],
            y,
            asked: PhantomData,
        }
    }

    /// Makes the slopes along z of a voxel row.
    #[inline(always)]
    fn make_z(&mut self, row: i32) {
        let slot = row.rem_euclid(3) as usize;
        let (Some(out), Some(name)) = (self.z.get_mut(slot), self.z_row.get_mut(slot)) else {
            return;
        };
        if *name == row {
            return;
        }
        *name = row;
        let Smooth {
            slices,
            extent,
            precision,
            ..
        } = &self.smooth;
        let voxels = three(*slices, |slice| slice.row(row as usize));
        let inner = 1..out.len().saturating_sub(1);
        z_slope_row::<V>(voxels, slopes(*precision, extent.z.weight), part_mut(out, inner));
        repeat_ends(out);
    }

    /// Makes the gradients of a span of the row that was made last.
    #[inline(always)]
    fn make_gradients(&mut self, row: i32, span: Range<usize>, [gx, gy, gz]: [&mut [i32]; 3]) {
        let rows = rows_about(self.smooth.extent, row);
        for row in rows {
            self.make_z(row);
        }
        let Smooth {
            extent,
            precision: p,
            z,
            ..
        } = &self.smooth;
        let (p, Extent { x, y, .. }) = (*p, extent);
        let first = self.smooth.places().start;
        let about = first + span.start..first + span.end + 2;
        x_slope_row::<P, V>(p, part(self.smooth.y, about.clone()), slopes(p, x.weight), gx);
        let weights_x = weights(p, x.weight);
        let along_y = part_mut(self.y, 0..about.len());
        let values = three(of_three(z, rows), |row| part(row, about.clone()));
        y_slope_row::<P, V>(p, values, slopes(p, y.weight), along_y);
        x_row::<P, V>(p, along_y, weights_x, gy);
        let values = three(of_three(&self.z, rows), |row| part(row, about.clone()));
        y_row::<P, V>(p, values, weights(p, y.weight), along_y);
        x_row::<P, V>(p, along_y, weights_x, gz);
        spaced::<P, V>(p, [gx, gy, gz], self.spacing);
    }
}

impl<P: Precision, V: Lanes, A: Asked> Source<i32> for Sloped<'_, '_, P, V, A> {
    #[inline(always)]
    fn make(&mut self, row: i32) {
        self.smooth.make(row);
    }

    #[inline(always)]
    fn slab(&self, _: i32) -> Slab<'_> {
        Slab::of(self.smooth.samples())
    }

    #[inline(always)]
    fn gradients(&mut self, row: i32, span: Range<usize>, _: Option<&[i32]>, out: [&mut [i32]; 3]) {
        // Unlit pipelines have no such code.
        if A::GRADIENTS {
            V::enter((MakeGradients, self, row, span, out));
        }
    }
}

struct MakeGradients;

impl<P: Precision, V: Lanes, A: Asked> Kernel
    for (
        MakeGradients,
        &mut Sloped<'_, '_, P, V, A>,
        i32,
        Range<usize>,
        [&mut [i32]; 3],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row, span, out) = self;
        source.make_gradients(row, span, out);
    }
}
