//! Alpha compositing of classified samples by splines: whole rows, of which no blocks are left out.

use super::canvas::Image;
use super::clipped::{Clipped, Rest};
use super::composite::{Composite, again, fold_rows};
use super::fold::{WholeRows, fold};
use super::kept::Kept;
use super::kernels::Kernels;
use super::parts::{Columns, Parts, Samples};
use super::scratch::{self, ScratchError, SplineScratch};
use super::smooth::Sloped;
use super::source::Source;
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::Classifier;
use crate::composite::{Order, Pixel, Recurrence as _};
use crate::lanes::Lanes;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::part_mut;
use crate::shade::Shader;
use crate::slice::Code12;
use crate::tap::Tap;

/// A pipeline of samples by splines of second degree ([`quadratic`](crate::quadratic)) in place of linear ones. Their gradients are the
/// spline's. Segments and modulation are of linear samples alone.
#[derive(Clone, Debug)]
pub struct Splines<L>(pub L);

impl<P, C, S, O> Splines<Composite<P, C, S, O>>
where
    P: Precision,
    C: Classifier<P>,
    S: Shader<P>,
    O: Order,
{
    /// Folds the samples of an extent.
    #[inline(always)]
    fn fold_extent<V: Lanes>(
        &self,
        (at, rest): (&At<'_>, &Rest<'_>),
        Samples {
            extent,
            window,
            whole_rows,
        }: &Samples<'_>,
        (first, data): (u32, &mut [ChannelOf<P>]),
        memory: SplineScratch<'_, i32>,
        tap: Option<&mut dyn Tap>,
    ) {
        let Composite {
            precision,
            classifier,
            shader,
            floor,
            ..
        } = &self.0;
        let (plan, plane, precision) = (at.plan, &at.plane, *precision);
        let SplineScratch {
            samples,
            slopes,
            mut batch,
        } = memory;
        let base_width = plan.base()[0] as usize;
        let Some(count) = data.len().checked_div(4 * base_width) else {
            return;
        };
        let n = extent.columns.len();
        if n == 0 {
            return;
        }
        let mut canvas = Image::<P::Pixel, O, V>::new(
            (first, data),
            base_width,
            extent.columns.clone(),
            plane.index,
            (precision.pixel(), *floor),
        );
        let support = classifier.support();
        let classifier = Kernels::<C, P, V>::of(classifier, precision).of_fractions(extent, plan.exact());
        let shader = Kernels::<S, P, V>::of(shader, precision);
        let clipped = Clipped::of(rest, extent, precision.pixel().colour_bits());
        batch.opacities = part_mut(batch.opacities, 0..n);
        let (met, support) = (extent.met(first, count), (support, clipped.as_ref()));
        let mut sloped = Sloped::<P, V, S::Asked>::new(precision, extent, window, plan.spacing(), (samples, slopes));
        let around = (extent, window);
        if V::SMALL {
            let mut rows = WholeRows::new(plane, around, None, support, &mut sloped, met, None).by_splines();
            fold(&mut rows, (&classifier, &shader), &mut canvas, batch, tap);
        } else {
            let reading = at.reading.filter(|_| *whole_rows);
            let source: &mut dyn Source<i32> = &mut sloped;
            let mut rows = WholeRows::new(plane, around, None, support, source, met, reading).by_splines();
            fold_rows(&mut rows, (&classifier, &shader), &mut canvas, batch, tap);
        }
    }
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
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        const {
            assert!(!C::SLABS, "segments lie between linear samples");
            assert!(!S::MODULATES, "modulation is of linear samples");
        }
        let At {
            plan, plane, window, ..
        } = at;
        let count = data.len().checked_div(4 * plan.base()[0] as usize).unwrap_or(0);
        let rest = Rest::of(at, false, (first, count), true);
        let [width, _, _] = plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        if matches!(rest, Rest::Nothing) {
            return Ok(());
        }
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        while let Some(mut samples) = parts.samples::<V>(window) {
            if tap.is_none() {
                rest.narrow(plan, core::slice::from_mut(&mut samples), false, (first, count));
            }
            let memory = SplineScratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
            self.fold_extent::<V>((at, &rest), &samples, (first, &mut *data), memory, again(&mut tap));
        }
        Ok(())
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        self.0.finished::<V>(plan, data)
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        self.0.pixel(row, column)
    }
}
