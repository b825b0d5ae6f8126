//! The source of samples and gradients: what a plane finds between the voxels.
//!
//! [`Sheared`] makes rows of parallel rays through 12-bit voxels, as a whole, and keeps them while their neighbours may need
//! them. [`Probes`](super::probe::Probes) makes single vectors of them. Voxels of another type, or rays that spread, are
//! further implementations of these two traits.

use core::marker::PhantomData;
use core::ops::Range;

use super::extent::Extent;
use super::kept::KeptRows;
use super::places::Places;
use super::scratch::{NO_ROW, SourceRows};
use crate::classify::Slab;
use crate::format::{Intensity, Weight};
use crate::gradient::{coarsen_row, difference_row, space_row};
use crate::interpolate::{Difference, extend_ends, extend_row, yx_row, yx_row_in_slice, z_difference_row, z_row};
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::rows::{part, part_mut, three};
use crate::shade::Asked;
use crate::slice::{Slice, Window};

/// Rows of samples and gradients of one plane, in words `W`. A row is named by the voxel row before its samples.
pub(super) trait Source<W> {
    /// Makes the samples of a row, one for each column of the plane's extent.
    fn make(&mut self, row: i32);
    /// The samples of the row that was made last, and those in front of them where segments are classified.
    fn slab(&self, row: i32) -> Slab<'_, W>;
    /// The gradients of a span of the row's samples, spaced and coarsened. Three rows, as long as the span. With a row of
    /// turns, those of crossings.
    fn gradients(&mut self, row: i32, span: Range<usize>, turns: Option<&[W]>, out: [&mut [W]; 3]);
}

/// Samples and gradients of single vectors of one plane.
pub(super) trait SourceAt<W> {
    /// The samples of the first `count` places, one vector behind the other: those in front where segments are classified,
    /// and those of the plane.
    fn samples_at(&self, places: &Places<'_>, count: usize, out: [&mut [W]; 2]);
    /// The gradients where `chosen` is not 0, packed side by side; `chosen` holds a vector per place. With turns, packed as
    /// well, those of crossings.
    fn gradients_at(
        &mut self,
        places: &Places<'_>,
        count: usize,
        chosen: &[W],
        turns: Option<&[W]>,
        out: [&mut [W]; 3],
    );
}

/// Rows of samples of a plane: the three that gradients look at, or one, and those that outlive the fold of the plane.
struct Samples<'s> {
    rows: [&'s mut [i32]; 3],
    /// Which they are.
    names: [i32; 3],
    /// What lies beyond the voxels of rows in which samples are held to them.
    beyond: [[Beyond; 2]; 3],
    kept: KeptRows<'s>,
}

/// What lies about the face voxel of a lit row, at one of its ends, whose sample is held there.
#[derive(Clone, Copy, Default)]
struct Beyond {
    /// Samples at the voxel before the face voxel, at it and behind it, along x.
    held: [i32; 3],
    /// The sample that would lie where the held one is stored.
    free: i32,
}

impl Samples<'_> {
    /// Where the samples of a row lie that is not kept.
    #[inline(always)]
    fn slot(row: i32, lit: bool) -> usize {
        if lit { (row + 1).rem_euclid(3) as usize } else { 0 }
    }

    /// The row that is held in the place of a row, and its samples.
    #[inline(always)]
    fn at<V: Lanes>(&self, row: i32, lit: bool) -> Option<(i32, &[i32])> {
        // Small machines have no memory for more rows.
        if !V::SMALL
            && let Some(number) = self.kept.number(row)
        {
            return self.kept.row(number);
        }
        let slot = Self::slot(row, lit);
        Some((*self.names.get(slot)?, self.rows.get(slot)?))
    }

    /// To be written.
    #[inline(always)]
    fn at_mut<V: Lanes>(&mut self, row: i32, lit: bool) -> Option<(&mut i32, &mut [i32])> {
        if !V::SMALL
            && let Some(number) = self.kept.number(row)
        {
            return self.kept.row_mut(number);
        }
        let slot = Self::slot(row, lit);
        Some((self.names.get_mut(slot)?, self.rows.get_mut(slot)?))
    }
}

/// Sheared rays: all samples of a plane share their weights, and rows are contiguous.
///
/// In lit scenes every buffer has a place for the voxel before the first and one for the voxel behind the last (the volume
/// continued linearly), because gradients look one sample beyond the row. So it has where samples at an end lie beyond the voxels
/// and are held to them: there the last voxel stands behind itself, whatever the weight.
pub(super) struct Sheared<'s, 'w, P, V, A> {
    extent: &'s Extent,
    window: &'s Window<'w>,
    /// Place of the first voxel, and of the sample behind it, in a row.
    first: usize,
    spacing: [Intensity; 3],
    z: [&'s mut [i32]; 2],
    z_row: [i32; 2],
    inner: &'s mut [i32],
    samples: Samples<'s>,
    derivatives: [&'s mut [i32]; 2],
    /// Which row and which of its columns the derivatives are of.
    made: [(usize, Range<usize>); 2],
    precision: P,
    kinds: PhantomData<(V, A)>,
}

impl<'s, 'w, P: Precision, V: Lanes, A: Asked> Sheared<'s, 'w, P, V, A> {
    #[inline(always)]
    pub(super) fn new(
        precision: P,
        extent: &'s Extent,
        window: &'s Window<'w>,
        spacing: [Intensity; 3],
        rows: SourceRows<'s, i32>,
        kept: KeptRows<'s>,
    ) -> Self {
        let first = usize::from(A::GRADIENTS || extent.is_wide());
        let len = window.near.width() + 2 * first;
        let cut = |row: &'s mut [i32]| {
            let len = len.min(row.len());
            part_mut(row, 0..len)
        };
        let [near, far] = rows.z;
        Self {
            extent,
            window,
            first,
            spacing,
            z: [cut(near), cut(far)],
            z_row: [NO_ROW; 2],
            inner: cut(rows.inner),
            samples: Samples {
                rows: three(rows.samples, cut),
                names: [NO_ROW; 3],
                beyond: [[Beyond::default(); 2]; 3],
                kept: kept.of_len(len),
            },
            derivatives: rows.derivatives,
            made: [(0, 0..0), (0, 0..0)],
            precision,
            kinds: PhantomData,
        }
    }

    /// A row of samples with its places beyond the volume.
    #[inline(always)]
    fn whole(&self, row: i32) -> &[i32] {
        self.samples
            .at::<V>(row, A::GRADIENTS)
            .map_or(&[], |(_, samples)| samples)
    }

    /// Places of the samples of a plane's extent.
    #[inline(always)]
    fn places(&self) -> Range<usize> {
        let first = (self.extent.x.index as isize)
            .wrapping_add_unsigned(self.extent.columns.start)
            .wrapping_add_unsigned(self.first);
        let first = first.max(0) as usize;
        first..first + self.extent.columns.len()
    }

    /// The samples of the row that was made last, to be changed; it is made anew when it is asked for again.
    #[inline(always)]
    pub(super) fn samples_mut(&mut self, row: i32) -> &mut [i32] {
        let places = self.places();
        match self.samples.at_mut::<V>(row, A::GRADIENTS) {
            Some((name, samples)) => {
                *name = NO_ROW;
                part_mut(samples, places)
            }
            None => &mut [],
        }
    }

    /// Places of the face voxels at both ends.
    #[inline(always)]
    fn faces(&self) -> [usize; 2] {
        [self.first, (self.first + self.window.near.width()).saturating_sub(1)]
    }

    #[inline(always)]
    fn make_row(&mut self, row: i32) {
        if self
            .samples
            .at::<V>(row, A::GRADIENTS)
            .is_some_and(|(held, _)| held == row)
        {
            return;
        }
        if V::SMALL {
            self.make_once(row);
        } else {
            V::enter((MakeRow, self, row));
        }
    }

    /// Small machines have the code once: it may be called, because it holds no vectors.
    #[inline(never)]
    fn make_once(&mut self, row: i32) {
        self.make_anew(row);
    }

    /// Makes the samples between voxel rows `row` and `row + 1`; a lit scene may ask for one row beyond each face.
    #[inline(always)]
    fn make_anew(&mut self, row: i32) {
        let extent = self.extent;
        let beyond = if A::GRADIENTS { extent.height } else { extent.height - 1 };
        // Behind the last row there is none; its weight is zero.
        let next = if row < beyond { row + 1 } else { row };
        if !A::GRADIENTS && !V::SMALL && extent.in_slice() {
            let voxels = |row: i32| self.window.near.row(row.max(0) as usize);
            let (a, b) = (voxels(row), voxels(next));
            let (p, first, places) = (self.precision, self.first, self.places());
            if let Some((key, out)) = self.samples.at_mut::<V>(row, A::GRADIENTS) {
                yx_row_in_slice::<P, V>(p, a, b, extent.weights(), part_mut(out, first..first + a.len()));
                let at = |place: usize, (a, b): (Option<&u16>, Option<&u16>), out: &mut [i32]| {
                    if let (Some(a), Some(b)) = (a, b) {
                        let weights = [Weight::ZERO, extent.y.weight];
                        yx_row_in_slice::<P, i32>(p, &[*a], &[*b], weights, part_mut(out, place..place + 1));
                    }
                };
                let [low, high] = extent.held;
                if low {
                    at(places.start, (a.first(), b.first()), out);
                }
                if high {
                    at(places.end - 1, (a.last(), b.last()), out);
                }
                *key = row;
            }
            return;
        }
        self.make_z(row);
        self.make_z(next);
        let (p, places, faces) = (self.precision, self.places(), self.faces());
        let [even, odd] = &self.z;
        let pick = |row: i32| if row & 1 == 0 { &**even } else { &**odd };
        let (a, b, in_slice) = (pick(row), pick(next), extent.in_slice());
        let slot = Samples::slot(row, A::GRADIENTS);
        if let Some((key, out)) = self.samples.at_mut::<V>(row, A::GRADIENTS) {
            yx_row::<P, V>(p, a, b, in_slice, extent.weights(), out);
            *key = row;
            if !A::GRADIENTS || !extent.is_wide() {
                return;
            }
            let ends = [places.start, places.end - 1].into_iter().zip(faces).zip(extent.held);
            let mut beyond = [Beyond::default(); 2];
            for (((place, face), held), beyond) in ends.zip(&mut beyond) {
                if let Some(out) = out.get_mut(place).filter(|_| held) {
                    let about = face.saturating_sub(1)..face + 2;
                    let weights = [Weight::ZERO, extent.y.weight];
                    let voxels = [part(a, about.clone()), part(b, about)];
                    few::<P, V>(p, voxels, in_slice, weights, &mut beyond.held);
                    beyond.free = *out;
                    let [_, held, _] = beyond.held;
                    *out = held;
                }
            }
            if let Some(slot) = self.samples.beyond.get_mut(slot) {
                *slot = beyond;
            }
        }
    }

    /// Makes the z interpolation of a voxel row.
    #[inline(always)]
    fn make_z(&mut self, row: i32) {
        let [even, odd] = &mut self.z;
        let [even_row, odd_row] = &mut self.z_row;
        let (out, key) = if row & 1 == 0 { (even, even_row) } else { (odd, odd_row) };
        if *key == row {
            return;
        }
        *key = row;
        let (window, weight) = (self.window, self.extent.z.weight);
        let voxels = self.first..out.len().saturating_sub(self.first);
        let far = window.far_or_near();
        let last = self.extent.height - 1;
        let edge = row.min(last).max(0);
        let rows = |row: i32| (window.near.row(row as usize), far.row(row as usize));
        let (near_row, far_row) = rows(edge);
        z_row::<P, V>(self.precision, near_row, far_row, weight, part_mut(out, voxels.clone()));
        if A::GRADIENTS {
            if edge != row {
                // One row beyond a face: twice the edge less the row inside it.
                let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
                let (near_row, far_row) = rows(inner);
                z_row::<P, V>(
                    self.precision,
                    near_row,
                    far_row,
                    weight,
                    part_mut(self.inner, voxels.clone()),
                );
                extend_row(part_mut(out, voxels.clone()), part(self.inner, voxels));
            }
            extend_ends(out);
        } else if self.first > 0
            && let [before, inner @ .., after] = &mut **out
            && let (Some(low), Some(high)) = (inner.first(), inner.last())
        {
            (*before, *after) = (*low, *high);
        }
    }

    /// Makes some columns of the z interpolation of a voxel row's derivatives along z.
    #[inline(always)]
    fn make_derivatives(&mut self, row: usize, columns: &Range<usize>) {
        let ([even, odd], [even_made, odd_made]) = (&mut self.derivatives, &mut self.made);
        let (out, made) = if row & 1 == 0 {
            (even, even_made)
        } else {
            (odd, odd_made)
        };
        if made.0 == row && made.1.start <= columns.start && columns.end <= made.1.end {
            return;
        }
        *made = (row, columns.clone());
        let (near, far) = derivatives(self.window, row);
        let (near, far) = (near.columns(columns.clone()), far.columns(columns.clone()));
        z_difference_row::<P, V>(
            self.precision,
            near,
            far,
            self.extent.z.weight,
            part_mut(out, columns.clone()),
        );
    }

    /// Makes the gradients of held samples in some places of a row those at the face voxels, and mends those beside them, which
    /// look at the sample that would lie where the held one is stored.
    #[inline(never)]
    fn hold_gradients(&self, row: i32, places: Range<usize>, [gx, gy, gz]: [&mut [i32]; 3], [this, next]: [&[i32]; 2]) {
        let all = self.places();
        let here = self.whole(row);
        let beyond = |row: i32, end: usize| {
            let slot = Samples::slot(row, true);
            let ends = self.samples.beyond.get(slot).and_then(|ends| ends.get(end));
            ends.copied().unwrap_or_default()
        };
        let (held, ends) = (self.extent.held, [all.start, all.end - 1]);
        // A row's own sample at a place, also where a held one is stored.
        let own = |place: usize| {
            let stored = ends.iter().zip(held).position(|(end, held)| held && *end == place);
            let sample = here.get(place).copied().unwrap_or(0);
            stored.map_or(sample, |end| beyond(row, end).free)
        };
        let faces = ends.into_iter().zip(self.faces()).zip(held);
        for (end, ((place, face), _)) in faces.enumerate().filter(|(_, (_, held))| *held) {
            let Beyond {
                held: [before, _, after],
                ..
            } = beyond(row, end);
            let at = |place: usize| place.checked_sub(places.start).filter(|_| place < places.end);
            let beside = if end == 0 { place + 1 } else { place.saturating_sub(1) };
            if let Some(gx) = at(beside).and_then(|at| gx.get_mut(at)) {
                *gx = own(beside + 1) - own(beside.saturating_sub(1));
            }
            let Some(at) = at(place) else { continue };
            let ([_, below, _], [_, above, _]) = (beyond(row + 1, end).held, beyond(row - 1, end).held);
            let voxel = face - self.first;
            if let (Some(gx), Some(gy), Some(gz)) = (gx.get_mut(at), gy.get_mut(at), gz.get_mut(at)) {
                *gx = after - before;
                *gy = below - above;
                let one = |row| part(row, voxel..voxel + 1);
                let (whole, weights) = (self.extent.in_slice(), [Weight::ZERO, self.extent.y.weight]);
                let mut out = [0];
                few::<P, V>(self.precision, [one(this), one(next)], whole, weights, &mut out);
                [*gz] = out;
            }
        }
    }

    #[inline(always)]
    fn make_gradients(&mut self, row: i32, span: Range<usize>, [gx, gy, gz]: [&mut [i32]; 3]) {
        self.make_row(row - 1);
        self.make_row(row + 1);
        let all = self.places();
        let places = all.start + span.start..all.start + span.end;
        // Along z: derivatives in place of voxels, one column more than the span where there is one; none before the first.
        let before = usize::from(places.start == 0);
        let last = self.window.near.width();
        let columns = (places.start + before - 1).min(last - 1)..places.end.min(last);
        let (this, next) = self.extent.voxel_rows(row);
        self.make_derivatives(this, &columns);
        self.make_derivatives(next, &columns);
        let [even, odd] = &self.derivatives;
        let whole_row = |row: usize| if row & 1 == 0 { &**even } else { &**odd };
        let pick = |row: usize| part(whole_row(row), columns.clone());
        let (whole, weights) = (self.extent.in_slice(), self.extent.weights());
        let behind = before..gz.len();
        yx_row::<P, V>(
            self.precision,
            pick(this),
            pick(next),
            whole,
            weights,
            part_mut(gz, behind),
        );
        let here = self.whole(row);
        // A row has a place before its first voxel, so there is one beside every sample but one that is held.
        let (first, end) = (places.start + before, places.end.min(here.len().saturating_sub(1)));
        let (right, left) = (first + 1..end + 1, first.saturating_sub(1)..end.saturating_sub(1));
        let behind = before..before + end.saturating_sub(first);
        difference_row::<V>(part(here, right), part(here, left), part_mut(gx, behind));
        let (below, above) = (self.whole(row + 1), self.whole(row - 1));
        difference_row::<V>(part(below, places.clone()), part(above, places.clone()), gy);
        if self.extent.is_wide() {
            let derivatives = [whole_row(this), whole_row(next)];
            self.hold_gradients(row, places, [&mut *gx, &mut *gy, &mut *gz], derivatives);
        }
        spaced::<P, V>(self.precision, [gx, gy, gz], self.spacing);
    }
}

/// The samples between a few voxels. Kernels for vectors call it for the ends of rows, of which they would each have a copy.
#[inline(always)]
fn few<P: Precision, V: Lanes>(p: P, voxels: [&[i32]; 2], whole: bool, weights: [Weight; 2], out: &mut [i32]) {
    #[inline(never)]
    fn apart<P: Precision>(p: P, [a, b]: [&[i32]; 2], whole: bool, weights: [Weight; 2], out: &mut [i32]) {
        yx_row::<P, i32>(p, a, b, whole, weights, out);
    }
    if V::SMALL {
        let [a, b] = voxels;
        yx_row::<P, V>(p, a, b, whole, weights, out);
    } else {
        apart(p, voxels, whole, weights, out);
    }
}

/// Gradients with the spacing factors, and with the bits that a precision keeps.
#[inline(always)]
pub(super) fn spaced<P: Precision, V: Lanes>(p: P, [gx, gy, gz]: [&mut [i32]; 3], [fx, fy, fz]: [Intensity; 3]) {
    space_row::<V>(gx, fx);
    space_row::<V>(gy, fy);
    space_row::<V>(gz, fz);
    if p.formats().gradient_bits < 15 {
        coarsen_row::<V>([gx, gy, gz], p.formats().gradient_bits);
    }
}

impl<P: Precision, V: Lanes, A: Asked> Source<i32> for Sheared<'_, '_, P, V, A> {
    #[inline(always)]
    fn make(&mut self, row: i32) {
        self.make_row(row);
    }

    #[inline(always)]
    fn slab(&self, row: i32) -> Slab<'_> {
        Slab::of(part(self.whole(row), self.places()))
    }

    #[inline(always)]
    fn gradients(&mut self, row: i32, span: Range<usize>, _: Option<&[i32]>, out: [&mut [i32]; 3]) {
        // Unlit pipelines have no such code.
        if A::GRADIENTS {
            V::enter((MakeGradients, self, row, span, out));
        }
    }
}

struct MakeRow;

impl<P: Precision, V: Lanes, A: Asked> Kernel for (MakeRow, &mut Sheared<'_, '_, P, V, A>, i32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row) = self;
        source.make_anew(row);
    }
}

struct MakeGradients;

impl<P: Precision, V: Lanes, A: Asked> Kernel
    for (
        MakeGradients,
        &mut Sheared<'_, '_, P, V, A>,
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
