//! Alpha compositing of the samples of a plane.

use core::marker::PhantomData;

use super::blocks::Blocks;
use super::canvas::{Image, Packing, rows_finished};
use super::clipped::{Clipped, Rest};
use super::extent::Extent;
use super::fold::WholeRows;
use super::kept::{Kept, KeptRows};
use super::kernels::{Kernels, PartRows, ShaderRows};
use super::parts::{Columns, Parts, Segments, code};
use super::probe::Probes;
use super::scratch::{self, BATCH, BATCH_WIDTH, Scratch, ScratchError};
use super::slabs::{SlabProbes, Slabs};
use super::slots::{AnySlots, Slots};
use super::source::{Sheared, Source, SourceAt};
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::{Classifier, Support};
use crate::composite::{Channel, Order, Pixel, Recurrence};
use crate::lanes::Lanes;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::part_mut;
use crate::seen::Seen;
use crate::shade::{Asked, Shader};
use crate::slice::{Code12, Window};
use crate::tap::Tap;

/// Alpha compositing of classified, perhaps shaded samples.
#[derive(Clone, Debug)]
pub struct Composite<P: Precision, C, S, O> {
    pub(super) precision: P,
    pub(super) classifier: C,
    pub(super) shader: S,
    pub(super) floor: ChannelOf<P>,
    order: PhantomData<O>,
}

impl<P: Precision, C: Classifier<P>, S: Shader<P>, O: Order> Composite<P, C, S, O> {
    /// A pipeline whose rays go on to the precision's own floor of transparency.
    pub fn new(precision: P, classifier: C, shader: S) -> Self {
        Self {
            precision,
            classifier,
            shader,
            floor: precision.pixel().floor(),
            order: PhantomData,
        }
    }

    /// Ends a ray when its transparency falls below `2^-bits` (which changes an 8-bit value by at most
    /// `255 * 2^-bits`), or at the precision's own floor if that is higher. Back to front no ray ends.
    #[must_use]
    pub fn with_early_termination(mut self, bits: u32) -> Self {
        self.floor = floor_of(self.precision, bits);
        self
    }
}

/// `2^-bits`, or the precision's own floor of transparency if that is higher.
pub(super) fn floor_of<P: Precision>(precision: P, bits: u32) -> ChannelOf<P> {
    let pixel = precision.pixel();
    let floor = pixel.one().bits().checked_shr(bits).unwrap_or(0);
    ChannelOf::<P>::from_bits(floor).max(pixel.floor())
}

/// What an untouched run of a row holds: red, green, blue, transparency.
pub(super) fn empty<P: Precision>(precision: P, channel: usize) -> ChannelOf<P> {
    if channel == 3 {
        precision.pixel().one()
    } else {
        ChannelOf::<P>::default()
    }
}

/// The pixel in a column of a row of four runs.
pub(super) fn pixel_of_runs<P: Precision>(precision: P, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
    let width = row.len() >> 2;
    let run = |channel: usize| {
        let inside = column < width;
        let element = row.get(channel * width + column).filter(|_| inside);
        element.copied().unwrap_or(empty(precision, channel))
    };
    Pixel {
        colour: [run(0), run(1), run(2)],
        transparency: run(3),
    }
}

/// How a pipeline's samples are laid out: constants where it is compiled as one.
#[derive(Clone, Copy)]
struct Layout {
    slabs: bool,
    scratch: scratch::Rows,
}

/// Folds the samples of a plane, or the segments that end in it.
#[inline(always)]
fn fold_plane<V, A, P, C, S, X>(
    slots: &mut Slots<'_, P, C, S, X>,
    layout: Layout,
    at: &At<'_>,
    scratch: &mut [i32],
    kept: Option<&mut Kept<'_>>,
    mut tap: Option<&mut dyn Tap>,
) -> Result<(), ScratchError>
where
    V: Lanes,
    A: Asked,
    P: Precision,
    C: PartRows<i32> + ?Sized,
    S: ShaderRows<i32> + ?Sized,
    X: Packing<i32> + ?Sized,
{
    let At {
        plan, plane, window, ..
    } = at;
    let Layout { slabs, scratch: memory } = layout;
    let met = (slots.first, slots.count);
    // Small machines have no whole volume at hand, and observers see whole rows; segments that are cut and colours that turn lie
    // in rows too.
    let rest = Rest::of(at, slabs, met, true);
    let seen = at.seen.filter(|_| !V::SMALL && tap.is_none() && !rest.cuts_rows(slabs));
    let [mut width, _, _] = plan.dims();
    if seen.is_some() {
        width = width.max(BATCH_WIDTH);
    }
    let (scratch, spare) = scratch::with_spare(scratch, memory, width, seen.is_some())?;
    if let Some(tap) = &mut tap {
        tap.plane(plane);
    }
    if matches!(rest, Rest::Nothing) {
        return Ok(());
    }
    // What is read is told of whole rows.
    let at_rows = |whole: bool| At {
        reading: at.reading.filter(|_| whole),
        ..*at
    };
    let columns = if seen.is_some() {
        Columns::InBlocks
    } else {
        Columns::InRows
    };
    let mut parts = Parts::of(plan, plane, columns);
    // Behind the first plane there is no segment.
    if slabs {
        let mut kept = kept.filter(|_| !V::SMALL);
        while let Some(Segments { mut ends, inner, .. }) = parts.segments::<V>(window, A::GRADIENTS) {
            let narrowed = tap.is_none() && rest.narrow(plan, &mut ends, true, met);
            let [front, back] = &ends;
            let memory = Scratch::cut(&mut *scratch, memory, width, !V::SMALL)?;
            let kept = match &mut kept {
                Some(kept) if inner && !narrowed => kept.of(plane.index, [&front.extent, &back.extent]),
                _ => Default::default(),
            };
            fold_extent::<V, A, P, C, S, X>(
                slots,
                (&at_rows(back.whole_rows), &rest),
                (&back.extent, &back.window, seen),
                Some((&front.extent, &front.window, kept)),
                (memory, &mut *spare),
                again(&mut tap),
            );
        }
        return Ok(());
    }
    while let Some(mut samples) = parts.samples::<V>(window) {
        if seen.is_none() && tap.is_none() {
            rest.narrow(plan, core::slice::from_mut(&mut samples), false, met);
        }
        let memory = Scratch::cut(&mut *scratch, memory, width, !V::SMALL)?;
        fold_extent::<V, A, P, C, S, X>(
            slots,
            (&at_rows(samples.whole_rows), &rest),
            (&samples.extent, &samples.window, seen),
            None,
            (memory, &mut *spare),
            again(&mut tap),
        );
    }
    Ok(())
}

/// [`fold_plane`] of any pipeline of a precision.
#[inline(never)]
fn fold_plane_of<V: Lanes, A: Asked, P: Precision>(
    slots: &mut AnySlots<'_, '_, P>,
    layout: Layout,
    at: &At<'_>,
    scratch: &mut [i32],
    kept: Option<&mut Kept<'_>>,
    tap: Option<&mut dyn Tap>,
) -> Result<(), ScratchError> {
    fold_plane::<V, A, _, _, _, _>(slots, layout, at, scratch, kept, tap)
}

/// Folds the samples of an extent, or the segments between them and those of the extent in front.
#[inline(always)]
fn fold_extent<V, A, P, C, S, X>(
    slots: &mut Slots<'_, P, C, S, X>,
    (at, rest): (&At<'_>, &Rest<'_>),
    (extent, behind, seen): (&Extent, &Window<'_>, Option<Seen<'_>>),
    before: Option<(&Extent, &Window<'_>, [KeptRows<'_>; 2])>,
    (scratch, spare): (Scratch<'_, i32>, &mut [i32]),
    tap: Option<&mut dyn Tap>,
) where
    V: Lanes,
    A: Asked,
    P: Precision,
    C: PartRows<i32> + ?Sized,
    S: ShaderRows<i32> + ?Sized,
    X: Packing<i32> + ?Sized,
{
    let At {
        plan, plane, reading, ..
    } = at;
    let Scratch {
        mut source,
        mut front,
        front_gradients,
        mut batch,
    } = scratch;
    let n = extent.columns.len();
    if n == 0 {
        return;
    }
    let (precision, first, count) = (slots.precision, slots.first, slots.count);
    slots.canvas.begin(extent.columns.clone());
    slots.classifier.begin(extent, code(plan));
    let clipped = Clipped::of(rest, extent, precision.pixel().colour_bits());
    let spacing = plan.spacing();
    // Two constants, before which no code for blocks is compiled.
    if !V::SMALL
        && let Some(seen) = seen
    {
        let mut probes = Probes::<P, V> {
            extent,
            window: behind,
            spacing,
            precision,
            lanes: PhantomData,
        };
        let [rows, columns] = &mut source.z;
        let lists = [part_mut(rows, 0..BATCH), part_mut(columns, 0..BATCH)];
        let ([back, ..], [ahead, ..]) = (&mut source.samples, &mut front.samples);
        let samples = [part_mut(ahead, 0..BATCH), part_mut(back, 0..BATCH)];
        let [ahead, back] = &mut front.z;
        let (spare_rows, spare_columns) = spare.split_at_mut(spare.len().min(BATCH));
        let stored = [
            [spare_rows, spare_columns],
            [part_mut(ahead, 0..BATCH), part_mut(back, 0..BATCH)],
        ];
        let mut slabs;
        let probes: &mut dyn SourceAt<i32> = match &before {
            Some((before, ahead, _)) => {
                slabs = SlabProbes {
                    front: Probes {
                        extent: before,
                        window: ahead,
                        ..probes
                    },
                    back: probes,
                    gradients: front_gradients,
                };
                &mut slabs
            }
            None => &mut probes,
        };
        let lists = (lists, samples, stored);
        let mut blocks = Blocks::new(seen, extent, (first, count), V::COUNT, probes, clipped.as_ref(), lists);
        slots.fold_apart(&mut blocks, batch, None);
        return;
    }
    batch.opacities = part_mut(batch.opacities, 0..n);
    let (support, met) = ((slots.support, clipped.as_ref()), extent.met(first, count));
    let around = (extent, behind);
    if let Some((before, ahead, [front_kept, kept])) = before {
        let sheared = Sheared::<P, V, A>::new(precision, extent, behind, spacing, source, kept);
        let front = Sheared::<P, V, A>::new(precision, before, ahead, spacing, front, front_kept);
        let mut slabs = Slabs::new([front, sheared], [before, extent], front_gradients);
        let before = Some((before, ahead));
        if V::SMALL {
            let mut rows = WholeRows::new(plane, around, before, support, &mut slabs, met, None);
            slots.fold(&mut rows, batch, tap);
        } else {
            let source: &mut dyn Source<i32> = &mut slabs;
            let mut rows = WholeRows::new(plane, around, before, support, source, met, *reading);
            slots.fold_apart(&mut rows, batch, tap);
        }
        return;
    }
    let mut sheared = Sheared::<P, V, A>::new(precision, extent, behind, spacing, source, KeptRows::default());
    if V::SMALL {
        let mut rows = WholeRows::new(plane, around, None, support, &mut sheared, met, None);
        slots.fold(&mut rows, batch, tap);
    } else {
        let source: &mut dyn Source<i32> = &mut sheared;
        let mut rows = WholeRows::new(plane, around, None, support, source, met, *reading);
        slots.fold_apart(&mut rows, batch, tap);
    }
}

/// A tap for one fold of several.
pub(super) fn again<'t>(tap: &'t mut Option<&mut dyn Tap>) -> Option<&'t mut dyn Tap> {
    match tap {
        Some(tap) => Some(&mut **tap),
        None => None,
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
    type Voxel = Code12;
    type Element = ChannelOf<P>;
    const CHANNELS: usize = 4;
    const SLICES: usize = if S::LIT { 4 } else { 2 };
    const SCRATCH: scratch::Rows = match (S::LIT, C::SLABS) {
        (true, false) if S::MODULATES => scratch::Rows::Modulated,
        (true, false) => scratch::Rows::Lit,
        (false, false) => scratch::Rows::Unlit,
        (true, true) => scratch::Rows::LitSlabs,
        (false, true) => scratch::Rows::UnlitSlabs,
    };
    const SLABS: bool = C::SLABS;
    const BACK_TO_FRONT: bool = O::BACK_TO_FRONT;

    fn support(&self) -> Option<Support> {
        Some(self.classifier.support())
    }

    fn precision(&self) -> P {
        self.precision
    }

    fn empty(&self, channel: usize) -> ChannelOf<P> {
        empty(self.precision, channel)
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        kept: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        // The gradient of a segment is the sum of two.
        const { assert!(!(C::SLABS && S::MODULATES), "modulation is of samples") };
        let (precision, width) = (self.precision, at.plan.base()[0] as usize);
        let (first, count) = (rows.first, rows.data.len().checked_div(4 * width).unwrap_or(0));
        let kinds = (precision.pixel(), self.floor);
        let mut canvas = Image::<P::Pixel, O, V>::new((first, rows.data), width, 0..0, at.plane.index, kinds);
        let mut classifier = Kernels::<C, P, V>::of(&self.classifier, precision);
        let mut slots = Slots {
            precision,
            classifier: &mut classifier,
            shader: &Kernels::<S, P, V>::of(&self.shader, precision),
            canvas: &mut canvas,
            support: self.classifier.support(),
            first,
            count,
        };
        let layout = Layout {
            slabs: C::SLABS,
            scratch: Self::SCRATCH,
        };
        if V::SMALL {
            fold_plane::<V, S::Asked, _, _, _, _>(&mut slots, layout, at, scratch, kept, tap)
        } else {
            fold_plane_of::<V, S::Asked, P>(&mut slots.any(), layout, at, scratch, kept, tap)
        }
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        !O::BACK_TO_FRONT && rows_finished::<_, V>(plan.base()[0] as usize, data)
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        pixel_of_runs(self.precision, row, column)
    }
}
