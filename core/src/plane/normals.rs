//! Rows of gradients and normals under visible spans.

use core::ops::Range;

use super::meeting::Meeting;
use super::sampler::Sampler;
use super::take_row;
use crate::gradient::{coarsen_row, difference_row, space_row};
use crate::interpolate::{Difference, yx_row, z_difference_row};
use crate::lanes::Lanes;
use crate::normalise::normalise_row;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::{part, part_mut};
use crate::shade::Shader;
use crate::slice::{Slice, Window};
use crate::tap::{Beam, Tap};

/// Rows of normals of a span; no memory in an unlit scene.
pub(super) struct NormalRows<'s, const LIT: bool> {
    g: [&'s mut [i32]; 3],
    r: &'s mut [i32],
    /// z interpolation of derivatives along z, of an even and an odd voxel row: which row, and which columns of it.
    z: [&'s mut [i32]; 2],
    z_made: [(usize, Range<usize>); 2],
    len: usize,
}

impl<'s, const LIT: bool> NormalRows<'s, LIT> {
    /// Rows of scratch memory.
    pub(super) const ROWS: usize = 6;

    #[inline(always)]
    pub(super) fn new(memory: &mut &'s mut [i32], width: u32) -> Self {
        let mut row = || if LIT { take_row(memory, width) } else { &mut [] };
        Self {
            g: [row(), row(), row()],
            r: row(),
            z: [row(), row()],
            z_made: [(0, 0..0), (0, 0..0)],
            len: 0,
        }
    }

    /// Makes some columns of the z interpolation of a voxel row's derivatives along z.
    #[inline(always)]
    fn make_z<P: Precision, V: Lanes>(
        &mut self,
        meeting: &Meeting,
        window: &Window<'_>,
        row: usize,
        columns: &Range<usize>,
    ) {
        let ([even, odd], [even_made, odd_made]) = (&mut self.z, &mut self.z_made);
        let (out, made) = if row & 1 == 0 {
            (even, even_made)
        } else {
            (odd, odd_made)
        };
        if made.0 == row && made.1.start <= columns.start && columns.end <= made.1.end {
            return;
        }
        *made = (row, columns.clone());
        let (near, far) = derivatives(window, row);
        let (near, far) = (near.columns(columns.clone()), far.columns(columns.clone()));
        z_difference_row::<P, V>(near, far, meeting.z.weight, part_mut(out, columns.clone()));
    }

    /// Gradients of the samples at `places` of a row.
    #[inline(always)]
    pub(super) fn make<P: Precision, V: Lanes>(
        &mut self,
        plan: &Plan,
        meeting: &Meeting,
        window: &Window<'_>,
        sampler: &Sampler<'_, P, LIT>,
        row: i32,
        places: Range<usize>,
    ) {
        self.len = places.len();
        // Along z: derivatives in place of voxels, one column more than the span where there is one.
        let columns = places.start.saturating_sub(1)..places.end.min(window.near.width());
        let (this, next) = meeting.voxel_rows(row);
        self.make_z::<P, V>(meeting, window, this, &columns);
        self.make_z::<P, V>(meeting, window, next, &columns);
        let [even, odd] = &self.z;
        let pick = |row: usize| part(if row & 1 == 0 { even } else { odd }, columns.clone());

        let [gx, gy, gz] = self.g.each_mut().map(|g| part_mut(g, 0..places.len()));
        yx_row::<P, V>(pick(this), pick(next), meeting.in_slice(), meeting.weights(), gz);
        let here = sampler.row(row);
        // A row has a place before its first voxel, so there is one to the left of every sample.
        let (right, left) = (
            places.start + 1..places.end + 1,
            places.start.saturating_sub(1)..places.end - 1,
        );
        difference_row::<V>(part(here, right), part(here, left), gx);
        let (next, previous) = (sampler.row(row + 1), sampler.row(row - 1));
        difference_row::<V>(part(next, places.clone()), part(previous, places), gy);

        let [fx, fy, fz] = plan.spacing();
        space_row::<V>(gx, fx);
        space_row::<V>(gy, fy);
        space_row::<V>(gz, fz);
    }

    /// Normalises the gradients and shades the colours of the span, or the one colour that all its samples have.
    #[inline(always)]
    pub(super) fn shade<P: Precision, S: Shader<P>, V: Lanes, T: Tap>(
        &mut self,
        shader: &S,
        at: Beam<'_>,
        classified: Option<[u32; 3]>,
        colours: [&mut [i32]; 3],
        tap: &mut T,
    ) {
        let [gx, gy, gz] = self.g.each_mut().map(|g| part_mut(g, 0..self.len));
        let r = part_mut(self.r, 0..self.len);
        if P::GRADIENT_BITS < 15 {
            coarsen_row::<V>([&mut *gx, &mut *gy, &mut *gz], P::GRADIENT_BITS);
        }
        tap.gradients(at, [gx, gy, gz]);
        normalise_row::<V>([&mut *gx, &mut *gy, &mut *gz], r);
        tap.normals(at, [gx, gy, gz], r);
        let [cr, cg, cb] = colours;
        shader.shade_row::<V>([gx, gy, gz], r, classified, [&mut *cr, &mut *cg, &mut *cb]);
        tap.shaded(at, [cr, cg, cb]);
    }
}

/// Derivatives along z at the slices before and behind a plane, for a voxel row.
#[inline(always)]
pub(super) fn derivatives<'a>(window: &Window<'a>, row: usize) -> (Difference<'a>, Difference<'a>) {
    let of = |scale, minuend: Slice<'a>, subtrahend: Slice<'a>| Difference {
        scale,
        minuend: minuend.row(row),
        subtrahend: subtrahend.row(row),
    };
    let near = match (window.before, window.far) {
        (Some(before), Some(far)) => of(1, far, before),
        (None, Some(far)) => of(2, far, window.near),
        (Some(before), None) => of(2, window.near, before),
        (None, None) => of(0, window.near, window.near),
    };
    let far = match (window.far, window.after) {
        (Some(_), Some(after)) => of(1, after, window.near),
        (Some(far), None) => of(2, far, window.near),
        // Behind the last slice there is none; its weight is zero.
        (None, _) => near,
    };
    (near, far)
}
