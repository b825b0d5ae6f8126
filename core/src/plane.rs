//! The plane layer: fold one sample plane into some rows of the image.
//!
//! It keeps nothing between calls and reads the voxels by reference, so a host may run it on a volume in memory, tile
//! by tile, on all its cores; the stream layer runs it on its ring. A pipeline is a type: precision, classifier,
//! shader and order of compositing ([`Composite`]), or an extreme of the samples ([`Project`]). Who names one pays for
//! that one.
//!
//! Only what the scene needs, and the same bits with all of it or without: a row whose voxels all classify to nothing
//! is not interpolated, nor is one whose rays are all finished; colours, gradients and shading are computed for spans
//! of visible samples (opacity above 0 on a ray that is not finished).

use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Range;

use crate::classify::{Classifier, Support};
use crate::composite::{Channel, Dither, Order, Pixel, PixelRow, Recurrence, fold_row};
use crate::format::Weight;
use crate::gradient::{coarsen_row, difference_row, space_row};
use crate::interpolate::{Difference, extend_ends, extend_row, yx_row, z_difference_row, z_row};
use crate::lanes::{Lanes, SMALL};
use crate::locate::{Cell, Plane, cell, inside};
use crate::normalise::normalise_row;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::project::{Extreme, keep_row, resolve};
use crate::rows::{part, part_mut, take};
use crate::shade::Shader;
use crate::slice::{RowRange, Slice, Window};
use crate::tap::{Beam, Tap};

/// The channel format of a precision.
pub type ChannelOf<P> = <<P as Precision>::Pixel as Recurrence>::Channel;

/// A pipeline: what is done with a sample plane.
pub trait Pipeline: Sync {
    /// Its number formats.
    type Precision: Precision;
    /// What a base-plane image is made of. A row of the image is `CHANNELS` runs of `width` elements.
    type Element: Copy + Debug + Send + Sync + 'static;
    /// Runs in a row of the image.
    const CHANNELS: usize;
    /// Slices that must be at hand at a time: 2, or 4 for gradients.
    const SLICES: usize;
    /// Rows of scratch memory.
    const SCRATCH_ROWS: usize;
    /// Whether planes go from the last to the first.
    const BACK_TO_FRONT: bool;
    /// What an element of an untouched image holds, for the run of that number.
    fn empty(channel: usize) -> Self::Element;

    /// Folds a plane into rows, `V::COUNT` samples at a time; the bits do not depend on `V`. `scratch` holds at least
    /// [`scratch_len`] words; with less, nothing is folded.
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        tap: &mut T,
    );

    /// The pixel in a column of a finished row.
    fn pixel(&self, row: &[Self::Element], column: usize) -> Pixel<ChannelOf<Self::Precision>>;
}

impl<L: Pipeline> Pipeline for &L {
    type Precision = L::Precision;
    type Element = L::Element;
    const CHANNELS: usize = L::CHANNELS;
    const SLICES: usize = L::SLICES;
    const SCRATCH_ROWS: usize = L::SCRATCH_ROWS;
    const BACK_TO_FRONT: bool = L::BACK_TO_FRONT;

    fn empty(channel: usize) -> Self::Element {
        L::empty(channel)
    }

    #[inline(always)]
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        tap: &mut T,
    ) {
        L::fold::<V, T>(self, plan, plane, window, rows, scratch, tap);
    }

    fn pixel(&self, row: &[Self::Element], column: usize) -> Pixel<ChannelOf<Self::Precision>> {
        L::pixel(self, row, column)
    }
}

/// Words of scratch memory that a pipeline needs for slices of this width.
pub const fn scratch_len<L: Pipeline>(width: u32) -> usize {
    L::SCRATCH_ROWS * row_len(width)
}

/// Words of a row: its voxels, and one place at each end.
const fn row_len(width: u32) -> usize {
    width as usize + 2
}

/// Cuts a row off scratch memory.
#[inline(always)]
fn take_row<'m>(memory: &mut &'m mut [i32], width: u32) -> &'m mut [i32] {
    take(memory, row_len(width))
}

/// Consecutive rows of one phase of the base-plane image.
#[derive(Debug)]
pub struct Rows<'a, E> {
    /// Number of the first row.
    pub first: u32,
    /// Whole rows, `CHANNELS * base[0]` elements each.
    pub data: &'a mut [E],
}

/// Fills rows with what an untouched image holds.
pub fn clear<L: Pipeline>(plan: &Plan, data: &mut [L::Element]) {
    let [width, _] = plan.base();
    for (index, run) in data.chunks_mut((width as usize).max(1)).enumerate() {
        let channel = index.checked_rem(L::CHANNELS).unwrap_or(0);
        run.fill(L::empty(channel));
    }
}

/// Where a plane meets the image: its cells, and the pixels whose samples lie inside the volume.
struct Meeting {
    x: Cell,
    y: Cell,
    z: Cell,
    columns: Range<usize>,
    rows: Range<u32>,
    /// Column of the volume under the first of `columns`.
    voxel: usize,
    height: i32,
}

impl Meeting {
    fn of(plan: &Plan, plane: &Plane) -> Self {
        let [width, height, _] = plan.dims();
        let [base_width, base_height] = plan.base();
        let (x, y, z) = (cell(plane.x), cell(plane.y), cell(plane.z));
        let columns = inside(x, width, base_width);
        Self {
            x,
            y,
            z,
            voxel: (i64::from(columns.start) + i64::from(x.index)).max(0) as usize,
            columns: columns.start as usize..columns.end as usize,
            rows: inside(y, height, base_height),
            height: height as i32,
        }
    }

    /// Whether the plane lies in a slice.
    fn in_slice(&self) -> bool {
        self.z.weight == Weight::ZERO
    }

    /// The weights along x and y.
    fn weights(&self) -> [Weight; 2] {
        [self.x.weight, self.y.weight]
    }

    /// The voxel rows around a row of samples: its own and the next, which is itself behind the last.
    fn voxel_rows(&self, row: i32) -> (usize, usize) {
        let last = self.height - 1;
        // Not `clamp`, which may panic.
        (row.min(last).max(0) as usize, (row + 1).min(last).max(0) as usize)
    }
}

/// The rows of the image that the plane meets: number of the row, its elements, and the voxel row before its samples.
///
/// No closure does the work: a vector of the processor stays one only in functions that are always inlined.
#[inline(always)]
fn met_rows<'m, E>(
    meeting: &'m Meeting,
    rows: Rows<'m, E>,
    row_len: usize,
) -> impl Iterator<Item = (u32, &'m mut [E], i32)> {
    let numbered = (rows.first..).zip(rows.data.chunks_exact_mut(row_len.max(1)));
    let met = numbered.filter(|(row, _)| meeting.rows.contains(row));
    met.map(|(row, data)| (row, data, row as i32 + meeting.y.index))
}

/// Whether samples between these voxel rows can be visible.
fn meets(support: Support, window: &Window<'_>, (row, next): (usize, usize)) -> bool {
    let far = window.far_or_near();
    let range = |s: &Slice<'_>| s.range(row).union(s.range(next));
    let range: RowRange = range(&window.near).union(range(&far));
    support.meets(range)
}

/// Rows of samples of one plane, made when asked for and kept while their neighbours may need them.
///
/// Every buffer has a place for the voxel before the first and one for the voxel behind the last; `LIT` fills them
/// (the volume continued linearly), because gradients look one sample beyond the row.
struct Sampler<'s, P, const LIT: bool> {
    z: [&'s mut [i32]; 2],
    z_row: [i32; 2],
    inner: &'s mut [i32],
    samples: [&'s mut [i32]; 3],
    sample_row: [i32; 3],
    precision: PhantomData<P>,
}

/// A row number that no row has.
const NO_ROW: i32 = i32::MIN;

impl<'s, P: Precision, const LIT: bool> Sampler<'s, P, LIT> {
    /// Rows of scratch memory.
    const ROWS: usize = if LIT { 6 } else { 3 };

    #[inline(always)]
    fn new(memory: &mut &'s mut [i32], width: u32) -> Self {
        let z = [take_row(memory, width), take_row(memory, width)];
        let (samples, inner) = if LIT {
            let samples = [(); 3].map(|()| take_row(memory, width));
            (samples, take_row(memory, width))
        } else {
            ([take_row(memory, width), &mut [], &mut []], &mut [][..])
        };
        Self {
            z,
            z_row: [NO_ROW; 2],
            samples,
            sample_row: [NO_ROW; 3],
            inner,
            precision: PhantomData,
        }
    }

    /// Where the samples of a row are kept.
    #[inline(always)]
    fn slot(row: i32) -> usize {
        if LIT { (row + 1).rem_euclid(3) as usize } else { 0 }
    }

    /// The samples of a row, one place beyond each end included. Empty unless [`Sampler::make`] made it.
    #[inline(always)]
    fn row(&self, row: i32) -> &[i32] {
        self.samples.get(Self::slot(row)).map_or(&[], |s| s)
    }

    /// Makes the samples between voxel rows `row` and `row + 1`; a lit scene may ask for one row beyond each face.
    #[inline(always)]
    fn make<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        if self.sample_row.get(Self::slot(row)) == Some(&row) {
            return;
        }
        if SMALL {
            self.make_once::<V>(meeting, window, row);
        } else {
            self.make_anew::<V>(meeting, window, row);
        }
    }

    /// Small machines have the code once: it may be called, because it holds no vectors.
    #[inline(never)]
    fn make_once<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        self.make_anew::<V>(meeting, window, row);
    }

    #[inline(always)]
    fn make_anew<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        let slot = Self::slot(row);
        let beyond = if LIT { meeting.height } else { meeting.height - 1 };
        // Behind the last row there is none; its weight is zero.
        let next = if row < beyond { row + 1 } else { row };
        self.make_z::<V>(meeting, window, row);
        self.make_z::<V>(meeting, window, next);
        let [even, odd] = &self.z;
        let pick = |row: i32| if row & 1 == 0 { &**even } else { &**odd };
        if let (Some(out), Some(key)) = (self.samples.get_mut(slot), self.sample_row.get_mut(slot)) {
            yx_row::<P, V>(pick(row), pick(next), meeting.in_slice(), meeting.weights(), out);
            *key = row;
        }
    }

    /// Makes the z interpolation of a voxel row.
    #[inline(always)]
    fn make_z<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        let [even, odd] = &mut self.z;
        let [even_row, odd_row] = &mut self.z_row;
        let (out, key) = if row & 1 == 0 { (even, even_row) } else { (odd, odd_row) };
        if *key == row {
            return;
        }
        *key = row;
        let voxels = 1..out.len().saturating_sub(1);
        let far = window.far_or_near();
        let last = meeting.height - 1;
        let edge = row.min(last).max(0);
        let rows = |row: i32| (window.near.row(row as usize), far.row(row as usize));
        let (near_row, far_row) = rows(edge);
        z_row::<P, V>(near_row, far_row, meeting.z.weight, part_mut(out, voxels.clone()));
        if LIT {
            if edge != row {
                // One row beyond a face: twice the edge less the row inside it.
                let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
                let (near_row, far_row) = rows(inner);
                z_row::<P, V>(
                    near_row,
                    far_row,
                    meeting.z.weight,
                    part_mut(self.inner, voxels.clone()),
                );
                extend_row(part_mut(out, voxels.clone()), part(self.inner, voxels));
            }
            extend_ends(out);
        }
    }
}

/// Derivatives along z at the slices before and behind a plane, for a voxel row.
fn derivatives<'a>(window: &Window<'a>, row: usize) -> (Difference<'a>, Difference<'a>) {
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

/// Whether any of the `V::COUNT` samples at `at` is visible.
#[inline(always)]
fn any_visible<O: Order, C: Channel, V: Lanes>(opacities: &[i32], transparencies: &[C], at: usize) -> bool {
    let opacity = V::load(opacities, at);
    let visible = if O::BACK_TO_FRONT {
        opacity
    } else {
        V::load_as(transparencies, at, C::bits).nonzero_then(opacity)
    };
    !visible.all_zero()
}

/// The next span of visible samples at or after `from`, in whole lanes: an invisible sample among them changes nothing.
#[inline(always)]
fn visible_span<O: Order, C: Channel, V: Lanes>(
    opacities: &[i32],
    transparencies: &[C],
    from: usize,
) -> Option<Range<usize>> {
    let transparencies = transparencies.get(..opacities.len())?;
    let mut start = from;
    while start < opacities.len() && !any_visible::<O, C, V>(opacities, transparencies, start) {
        start += V::COUNT;
    }
    let mut end = start;
    while end < opacities.len() && any_visible::<O, C, V>(opacities, transparencies, end) {
        end += V::COUNT;
    }
    (start < end).then_some(start..end.min(opacities.len()))
}

/// Whether all rays of a row are finished.
#[inline(always)]
fn all_finished<C: Channel, V: Lanes>(transparencies: &[C]) -> bool {
    for at in (0..transparencies.len()).step_by(V::COUNT) {
        if !V::load_as(transparencies, at, C::bits).all_zero() {
            return false;
        }
    }
    true
}

/// Alpha compositing of classified, perhaps shaded samples.
#[derive(Clone, Debug)]
pub struct Composite<P: Precision, C, S, O> {
    classifier: C,
    shader: S,
    floor: ChannelOf<P>,
    order: PhantomData<O>,
}

impl<P: Precision, C: Classifier<P>, S: Shader<P>, O: Order> Composite<P, C, S, O> {
    /// A pipeline whose rays go on to the precision's own floor of transparency.
    pub fn new(classifier: C, shader: S) -> Self {
        Self {
            classifier,
            shader,
            floor: P::Pixel::FLOOR,
            order: PhantomData,
        }
    }

    /// Ends a ray when its transparency falls below `2^-bits` (which changes an 8-bit value by at most
    /// `255 * 2^-bits`), or at the precision's own floor if that is higher. Back to front no ray ends.
    #[must_use]
    pub fn with_early_termination(mut self, bits: u32) -> Self {
        let floor = ChannelOf::<P>::ONE.bits().checked_shr(bits).unwrap_or(0);
        self.floor = ChannelOf::<P>::from_bits(floor).max(P::Pixel::FLOOR);
        self
    }
}

impl<P: Precision, C: Classifier<P>, S: Shader<P>, O: Order> Composite<P, C, S, O> {
    #[inline(always)]
    fn fold_plane<V: Lanes, T: Tap, const LIT: bool>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        mut scratch: &mut [i32],
        tap: &mut T,
    ) {
        let meeting = Meeting::of(plan, plane);
        let n = meeting.columns.len();
        if n == 0 {
            return;
        }
        let [base_width, _] = plan.base().map(|side| side as usize);
        let [slice_width, _, _] = plan.dims();
        let mut sampler = Sampler::<P, LIT>::new(&mut scratch, slice_width);
        let opacities = part_mut(take_row(&mut scratch, slice_width), 0..n);
        let mut colours = [(); 3].map(|()| take_row(&mut scratch, slice_width));
        let mut normals = NormalRows::<LIT>::new(&mut scratch, slice_width);
        let dither = Dither::of_plane(plane.index);
        let support = self.classifier.support();

        for (row, data, voxel_row) in met_rows(&meeting, rows, 4 * base_width) {
            let mut pixels = PixelRow::of_runs(data, base_width, meeting.columns.clone());
            if !O::BACK_TO_FRONT && all_finished::<_, V>(pixels.transparency) {
                continue;
            }
            if !meets(support, window, meeting.voxel_rows(voxel_row)) {
                continue;
            }
            let beam = |offset: usize| Beam {
                plane,
                row,
                column: (meeting.columns.start + offset) as u32,
            };
            sampler.make::<V>(&meeting, window, voxel_row);
            let place = meeting.voxel + 1;
            let samples = part(sampler.row(voxel_row), place..place + n);
            tap.samples(beam(0), samples);
            self.classifier.opacity_row::<V>(samples, opacities);
            tap.opacities(beam(0), opacities);

            let mut from = 0;
            while let Some(span) = visible_span::<O, _, V>(opacities, pixels.transparency, from) {
                from = span.end;
                let at = beam(span.start);
                let places = place + span.start..place + span.end;
                let [cr, cg, cb] = colours.each_mut().map(|c| part_mut(c, 0..span.len()));
                let samples = part(sampler.row(voxel_row), places.clone());
                self.classifier.colour_row::<V>(samples, [&mut *cr, &mut *cg, &mut *cb]);
                tap.colours(at, [cr, cg, cb]);
                if LIT {
                    sampler.make::<V>(&meeting, window, voxel_row - 1);
                    sampler.make::<V>(&meeting, window, voxel_row + 1);
                    normals.make::<P, V>(plan, &meeting, window, &sampler, voxel_row, places);
                    normals.shade::<P, S, V, T>(&self.shader, at, [&mut *cr, &mut *cg, &mut *cb], tap);
                }
                let mut pixels = pixels.span(span.clone());
                tap.before(at, &pixels);
                fold_row::<P::Pixel, O, V>(&mut pixels, [cr, cg, cb], part(opacities, span), dither, self.floor);
                tap.after(at, &pixels);
            }
        }
    }
}

impl<P, C, S, O> Pipeline for Composite<P, C, S, O>
where
    P: Precision,
    C: Classifier<P>,
    S: Shader<P>,
    O: Order,
{
    type Precision = P;
    type Element = ChannelOf<P>;
    const CHANNELS: usize = 4;
    const SLICES: usize = if S::LIT { 4 } else { 2 };
    const SCRATCH_ROWS: usize = if S::LIT {
        Sampler::<P, true>::ROWS + 4 + NormalRows::<true>::ROWS
    } else {
        Sampler::<P, false>::ROWS + 4
    };
    const BACK_TO_FRONT: bool = O::BACK_TO_FRONT;

    fn empty(channel: usize) -> ChannelOf<P> {
        if channel == 3 {
            ChannelOf::<P>::ONE
        } else {
            ChannelOf::<P>::default()
        }
    }

    #[inline(always)]
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        tap: &mut T,
    ) {
        let [slice_width, _, _] = plan.dims();
        if scratch.len() < scratch_len::<Self>(slice_width) {
            return;
        }
        tap.plane(plane);
        if S::LIT {
            self.fold_plane::<V, T, true>(plan, plane, window, rows, scratch, tap);
        } else {
            self.fold_plane::<V, T, false>(plan, plane, window, rows, scratch, tap);
        }
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        let width = row.len() >> 2;
        let run = |channel: usize| {
            let inside = column < width;
            let element = row.get(channel * width + column).filter(|_| inside);
            element.copied().unwrap_or(Self::empty(channel))
        };
        Pixel {
            colour: [run(0), run(1), run(2)],
            transparency: run(3),
        }
    }
}

/// Rows of normals of a span; no memory in an unlit scene.
struct NormalRows<'s, const LIT: bool> {
    g: [&'s mut [i32]; 3],
    r: &'s mut [i32],
    /// z interpolation of derivatives along z, of an even and an odd voxel row: which row, and which columns of it.
    z: [&'s mut [i32]; 2],
    z_made: [(usize, Range<usize>); 2],
    len: usize,
}

impl<'s, const LIT: bool> NormalRows<'s, LIT> {
    /// Rows of scratch memory.
    const ROWS: usize = 6;

    #[inline(always)]
    fn new(memory: &mut &'s mut [i32], width: u32) -> Self {
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
    fn make<P: Precision, V: Lanes>(
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

    /// Normalises the gradients and shades the colours of the span.
    #[inline(always)]
    fn shade<P: Precision, S: Shader<P>, V: Lanes, T: Tap>(
        &mut self,
        shader: &S,
        at: Beam<'_>,
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
        shader.shade_row::<V>([gx, gy, gz], r, [&mut *cr, &mut *cg, &mut *cb]);
        tap.shaded(at, [cr, cg, cb]);
    }
}

/// Projection of the largest or smallest sample (`project`).
#[derive(Clone, Debug)]
pub struct Project<P, C, X> {
    classifier: C,
    kinds: PhantomData<(P, X)>,
}

impl<P: Precision, C: Classifier<P>, X: Extreme> Project<P, C, X> {
    /// A pipeline that keeps one sample a ray and classifies it at the end.
    pub fn new(classifier: C) -> Self {
        Self {
            classifier,
            kinds: PhantomData,
        }
    }
}

impl<P: Precision, C: Classifier<P>, X: Extreme> Pipeline for Project<P, C, X> {
    type Precision = P;
    type Element = i32;
    const CHANNELS: usize = 1;
    const SLICES: usize = 2;
    const SCRATCH_ROWS: usize = Sampler::<P, false>::ROWS;
    const BACK_TO_FRONT: bool = false;

    fn empty(_: usize) -> i32 {
        X::EMPTY
    }

    #[inline(always)]
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, i32>,
        mut scratch: &mut [i32],
        tap: &mut T,
    ) {
        let [slice_width, _, _] = plan.dims();
        if scratch.len() < scratch_len::<Self>(slice_width) {
            return;
        }
        tap.plane(plane);
        let meeting = Meeting::of(plan, plane);
        let n = meeting.columns.len();
        if n == 0 {
            return;
        }
        let [base_width, _] = plan.base().map(|side| side as usize);
        let mut sampler = Sampler::<P, false>::new(&mut scratch, slice_width);
        for (row, data, voxel_row) in met_rows(&meeting, rows, base_width) {
            sampler.make::<V>(&meeting, window, voxel_row);
            let place = meeting.voxel + 1;
            let samples = part(sampler.row(voxel_row), place..place + n);
            let at = Beam {
                plane,
                row,
                column: meeting.columns.start as u32,
            };
            tap.samples(at, samples);
            keep_row::<X, V>(part_mut(data, meeting.columns.clone()), samples);
        }
    }

    fn pixel(&self, row: &[i32], column: usize) -> Pixel<ChannelOf<P>> {
        let kept = row.get(column).copied().unwrap_or(X::EMPTY);
        resolve::<P, X>(kept, &self.classifier)
    }
}
