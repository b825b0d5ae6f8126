//! A source of samples by splines of second degree: rows between three slices, three rows and three columns.
//!
//! Beyond its faces the volume's outermost voxels are repeated. A sample that is held to the voxels lies at one of them.

use core::marker::PhantomData;
use core::ops::Range;

use super::extent::Extent;
use super::scratch::SmoothRows;
use super::source::NO_ROW;
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::quadratic::{is_behind, weights, x_row, y_row, z_row};
use crate::rows::{part, part_mut, three};
use crate::slice::{RowRange, Slice, Window};

/// Rows of samples of one plane. A row is named by the voxel row before its samples.
pub(super) struct Smooth<'s, 'w, P, V> {
    extent: &'s Extent,
    /// The slice nearest to the plane, and those before and behind it.
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
        let [a, b, c] = &self.z;
        let of = |row: i32| match row.rem_euclid(3) {
            0 => &**a,
            1 => &**b,
            _ => &**c,
        };
        y_row::<V>(three(rows, of), weights(self.extent.y.weight), self.y);
        let about = part(self.y, self.places());
        x_row::<P, V>(self.precision, about, weights(self.extent.x.weight), self.samples);
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
        z_row::<V>(voxels, weights(self.extent.z.weight), part_mut(out, inner));
        if let [before, inner @ .., after] = &mut **out
            && let (Some(low), Some(high)) = (inner.first(), inner.last())
        {
            (*before, *after) = (*low, *high);
        }
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
