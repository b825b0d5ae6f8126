//! Alpha compositing of the samples of a plane.

use core::marker::PhantomData;

use super::meeting::{Meeting, meets, met_rows};
use super::normals::NormalRows;
use super::sampler::{Sampler, aligned};
use super::spans::{all_finished, visible_span};
use super::{ChannelOf, Pipeline, Rows, blocks, scratch_len, take_row};
use crate::classify::{Classifier, Support};
use crate::composite::{Channel, Dither, OneColour, Order, Pixel, PixelRow, Recurrence, fold_row, fold_visible_row};
use crate::lanes::Lanes;
use crate::locate::Plane;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::{part, part_mut};
use crate::seen::Seen;
use crate::shade::Shader;
use crate::slice::Window;
use crate::tap::{Beam, Tap};

/// Alpha compositing of classified, perhaps shaded samples.
#[derive(Clone, Debug)]
pub struct Composite<P: Precision, C, S, O> {
    pub(super) classifier: C,
    pub(super) shader: S,
    pub(super) floor: ChannelOf<P>,
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
        scratch: &mut [i32],
        tap: &mut T,
    ) {
        let meeting = Meeting::of(plan, plane);
        let n = meeting.columns.len();
        if n == 0 {
            return;
        }
        let [base_width, _] = plan.base().map(|side| side as usize);
        let [slice_width, _, _] = plan.dims();
        let (mut scratch, room) = aligned(scratch, Self::SCRATCH_ROWS, slice_width);
        let mut sampler = Sampler::<P, LIT>::new(&mut scratch, slice_width, room);
        let opacities = part_mut(take_row(&mut scratch, room), 0..n);
        let mut colours = [(); 3].map(|()| take_row(&mut scratch, room));
        let mut normals = NormalRows::<LIT>::new(&mut scratch, room);
        let dither = Dither::of_plane(plane.index);
        let support = self.classifier.support();
        // One colour needs no rows to be shaded, or looked at; one lane is faster without a decision at each sample.
        let one_colour = self.classifier.one_colour().filter(|_| !T::LOOKS && V::COUNT > 1);

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
            let place = meeting.voxel + Sampler::<P, LIT>::FIRST;
            let samples = part(sampler.row(voxel_row), place..place + n);
            tap.samples(beam(0), samples);
            self.classifier.opacity_row::<V>(samples, opacities);
            tap.opacities(beam(0), opacities);
            // Unlit, it needs no spans either.
            if let Some(colour) = one_colour.filter(|_| !LIT) {
                fold_visible_row::<P::Pixel, O, V>(&mut pixels, OneColour(colour), opacities, dither, self.floor);
                continue;
            }

            let mut from = 0;
            while let Some(span) = visible_span::<O, _, V>(opacities, pixels.transparency, from) {
                from = span.end;
                let at = beam(span.start);
                let places = place + span.start..place + span.end;
                let [cr, cg, cb] = colours.each_mut().map(|c| part_mut(c, 0..span.len()));
                if one_colour.is_none() {
                    let samples = part(sampler.row(voxel_row), places.clone());
                    self.classifier.colour_row::<V>(samples, [&mut *cr, &mut *cg, &mut *cb]);
                    tap.colours(at, [cr, cg, cb]);
                }
                if LIT {
                    sampler.make::<V>(&meeting, window, voxel_row - 1);
                    sampler.make::<V>(&meeting, window, voxel_row + 1);
                    normals.make::<P, V>(plan, &meeting, window, &sampler, voxel_row, places);
                    normals.shade::<P, S, V, T>(&self.shader, at, one_colour, [&mut *cr, &mut *cg, &mut *cb], tap);
                }
                let mut pixels = pixels.span(span.clone());
                tap.before(at, &pixels);
                fold_row::<P::Pixel, O, V>(
                    &mut pixels,
                    [&*cr, &*cg, &*cb],
                    part(opacities, span),
                    dither,
                    self.floor,
                );
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
    const SEEN_SCRATCH: usize = blocks::SCRATCH;
    const BACK_TO_FRONT: bool = O::BACK_TO_FRONT;

    fn support(&self) -> Option<Support> {
        Some(self.classifier.support())
    }

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

    #[inline(always)]
    fn fold_seen<V: Lanes>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        seen: Seen<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
    ) {
        if S::LIT {
            self.fold_blocks::<V, true>(plan, plane, window, seen, rows, scratch);
        } else {
            self.fold_blocks::<V, false>(plan, plane, window, seen, rows, scratch);
        }
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        if O::BACK_TO_FRONT {
            return false;
        }
        let [width, _] = plan.base().map(|side| side as usize);
        for row in data.chunks_exact((4 * width).max(1)) {
            if !all_finished::<_, V>(row.get(3 * width..).unwrap_or(&[])) {
                return false;
            }
        }
        true
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
