//! Alpha compositing of classified samples by splines: whole rows, of which no blocks are left out.

use super::canvas::{Image, Packing};
use super::clipped::{Clipped, Rest};
use super::composite::{Composite, again};
use super::fold::WholeRows;
use super::kept::Kept;
use super::kernels::{Kernels, PartRows, ShaderRows};
use super::parts::{Columns, Parts, Samples, code};
use super::scratch::{self, ScratchError, SplineScratch};
use super::slots::{AnySlots, Slots};
use super::smooth::Sloped;
use super::source::Source;
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::Classifier;
use crate::composite::{Order, Pixel, Recurrence as _};
use crate::lanes::Lanes;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::part_mut;
use crate::shade::{Asked, Shader};
use crate::slice::Code12;
use crate::tap::Tap;

/// A pipeline of samples by splines of second degree ([`quadratic`](crate::quadratic)) in place of linear ones. Their gradients are the
/// spline's. Segments and modulation are of linear samples alone.
#[derive(Clone, Debug)]
pub struct Splines<L>(pub L);

/// Folds the samples of a plane.
#[inline(always)]
fn fold_plane<V, A, P, C, S, X>(
    slots: &mut Slots<'_, P, C, S, X>,
    memory: scratch::Rows,
    at: &At<'_>,
    scratch: &mut [i32],
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
    let (precision, met) = (slots.precision, (slots.first, slots.count));
    let rest = Rest::of(at, false, met, true);
    let [width, _, _] = plan.dims();
    let (scratch, _) = scratch::with_spare(scratch, memory, width, false)?;
    if let Some(tap) = &mut tap {
        tap.plane(plane);
    }
    if matches!(rest, Rest::Nothing) {
        return Ok(());
    }
    let mut parts = Parts::of(plan, plane, Columns::Alone);
    while let Some(mut samples) = parts.samples::<V>(window) {
        if tap.is_none() {
            rest.narrow(plan, core::slice::from_mut(&mut samples), false, met);
        }
        let Samples {
            extent,
            window,
            whole_rows,
        } = &samples;
        let SplineScratch {
            samples,
            slopes,
            mut batch,
        } = SplineScratch::cut(&mut *scratch, memory, width, !V::SMALL)?;
        if extent.columns.is_empty() {
            continue;
        }
        slots.canvas.begin(extent.columns.clone());
        slots.classifier.begin(extent, code(plan));
        let clipped = Clipped::of(&rest, extent, precision.pixel().colour_bits());
        batch.opacities = part_mut(batch.opacities, 0..extent.columns.len());
        let (rows, support) = (extent.met(slots.first, slots.count), (slots.support, clipped.as_ref()));
        let mut sloped = Sloped::<P, V, A>::new(precision, extent, window, plan.spacing(), (samples, slopes));
        let around = (extent, window);
        if V::SMALL {
            let mut rows = WholeRows::new(plane, around, None, support, &mut sloped, rows, None).by_splines();
            slots.fold(&mut rows, batch, again(&mut tap));
        } else {
            let reading = at.reading.filter(|_| *whole_rows);
            let source: &mut dyn Source<i32> = &mut sloped;
            let mut rows = WholeRows::new(plane, around, None, support, source, rows, reading).by_splines();
            slots.fold_apart(&mut rows, batch, again(&mut tap));
        }
    }
    Ok(())
}

/// [`fold_plane`] of any pipeline of a precision.
#[inline(never)]
fn fold_plane_of<V: Lanes, A: Asked, P: Precision>(
    slots: &mut AnySlots<'_, '_, P>,
    memory: scratch::Rows,
    at: &At<'_>,
    scratch: &mut [i32],
    tap: Option<&mut dyn Tap>,
) -> Result<(), ScratchError> {
    fold_plane::<V, A, _, _, _, _>(slots, memory, at, scratch, tap)
}

impl<P, C, S, O> Pipeline for Splines<Composite<P, C, S, O>>
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
    const SLICES: usize = 4;
    const SCRATCH: scratch::Rows = if S::LIT {
        scratch::Rows::LitSplines
    } else {
        scratch::Rows::Splines
    };
    const BACK_TO_FRONT: bool = O::BACK_TO_FRONT;

    fn precision(&self) -> P {
        self.0.precision
    }

    fn empty(&self, channel: usize) -> ChannelOf<P> {
        self.0.empty(channel)
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        Rows { first, data }: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        _: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        const {
            assert!(!C::SLABS, "segments lie between linear samples");
            assert!(!S::MODULATES, "modulation is of linear samples");
        }
        let Composite {
            precision,
            classifier,
            shader,
            floor,
            ..
        } = &self.0;
        let (precision, width) = (*precision, at.plan.base()[0] as usize);
        let count = data.len().checked_div(4 * width).unwrap_or(0);
        let kinds = (precision.pixel(), *floor);
        let mut canvas = Image::<P::Pixel, O, V>::new((first, data), width, 0..0, at.plane.index, kinds);
        let mut slots = Slots {
            precision,
            classifier: &mut Kernels::<C, P, V>::of(classifier, precision),
            shader: &Kernels::<S, P, V>::of(shader, precision),
            canvas: &mut canvas,
            support: classifier.support(),
            first,
            count,
        };
        if V::SMALL {
            fold_plane::<V, S::Asked, _, _, _, _>(&mut slots, Self::SCRATCH, at, scratch, tap)
        } else {
            fold_plane_of::<V, S::Asked, P>(&mut slots.any(), Self::SCRATCH, at, scratch, tap)
        }
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        self.0.finished::<V>(plan, data)
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        self.0.pixel(row, column)
    }
}
