//! Compositing in 16-bit lanes: the pipeline of the `fast` precision.

mod blocks;
mod kernels;
mod pixels;
mod project;
mod runs;
mod source;

use core::marker::PhantomData;
use core::ops::{Deref, Range};

use self::blocks::{Blocks, WIDTH_LEAST};
use self::kernels::{FastKernels, Lit};
use self::pixels::Pixels;
use self::runs::Runs;
use self::source::Short;
use super::canvas::{Canvas, rows_finished};
use super::composite::again;
use super::extent::Extent;
use super::fold::{WholeRows, fold};
use super::kernels::{ClassifierRows, ShaderRows};
use super::parts::{Columns, Parts, Samples, code};
use super::scratch::{self, BATCH_WIDTH, BatchRows, FastScratch, ScratchError};
use super::source::Source;
use super::{At, Kept, Pipeline, Rows};
use crate::classify::Support;
use crate::composite::{Order, Pixel, Unorm16};
use crate::fast::{self, RootTable};
use crate::lanes::{Halves, Lanes};
use crate::plan::Plan;
use crate::precision;
use crate::rows::{part_mut, three};
use crate::seen::Seen;
use crate::slice::{Code12, Window};
use crate::tap::Tap;

pub use self::kernels::FastShader;
pub use self::project::FastProject;

/// Alpha compositing of classified, perhaps shaded samples in 16-bit lanes: it looks at no clip planes.
#[derive(Clone, Debug)]
pub struct Fast<R, C, S, O> {
    table: RootTable<R, C>,
    shader: S,
    floor: u16,
    order: PhantomData<O>,
}

impl<R, C, S, O> Fast<R, C, S, O> {
    /// A pipeline whose rays go on until nothing is left of the light.
    pub const fn new(table: RootTable<R, C>, shader: S) -> Self {
        Self {
            table,
            shader,
            floor: 1,
            order: PhantomData,
        }
    }

    /// Ends a ray when its transparency falls below `2^-bits` (which changes an 8-bit value by at most
    /// `255 * 2^-bits`). Back to front no ray ends.
    #[must_use]
    pub fn with_early_termination(mut self, bits: u32) -> Self {
        self.floor = u16::MAX.checked_shr(bits).unwrap_or(0).max(1);
        self
    }
}

impl<R, C, S, O> Fast<R, C, S, O>
where
    R: Deref<Target = fast::Roots> + Sync,
    C: Deref<Target = fast::Colours> + Sync,
    S: FastShader,
    O: Order,
{
    #[inline(always)]
    fn fold_extent<V: Lanes>(
        &self,
        at: &At<'_>,
        (extent, window, rows): (&Extent, &Window<'_>, Range<u32>),
        (first, data): (u32, &mut [u16]),
        memory: FastScratch<'_>,
        tap: Option<&mut dyn Tap>,
    ) {
        let At { plan, plane, .. } = at;
        let FastScratch {
            z,
            samples,
            derivatives,
            slope,
            mut batch,
        } = memory;
        let base_width = plan.base()[0] as usize;
        let n = extent.columns.len();
        if n == 0 {
            return;
        }
        let mut pixels = Pixels::<O, V>::new(
            (first, data),
            base_width,
            extent.columns.clone(),
            plane.index,
            self.floor,
        );
        let classifier = FastKernels::<_, V>::of(&self.table, extent, code(plan));
        let shader = Lit::<S, V>::of(&self.shader);
        batch.opacities = part_mut(batch.opacities, 0..n);
        let mut short = Short::<V, S>::new((extent, window), plan.spacing(), (z, samples), (derivatives, slope));
        let support = self.table.support();
        if V::SMALL {
            let mut rows = WholeRows::new(plane, (extent, window), None, (support, None), &mut short, rows, None);
            fold(&mut rows, (&classifier, &shader), &mut pixels, batch, tap);
        } else {
            let source: &mut dyn Source<u16> = &mut short;
            let mut rows = WholeRows::new(plane, (extent, window), None, (support, None), source, rows, at.reading);
            fold_rows(&mut rows, (&classifier, &shader), &mut pixels, batch, tap);
        }
    }

    /// Folds the blocks of an extent that can be seen.
    #[inline(always)]
    fn fold_blocks<V: Lanes>(
        &self,
        at: &At<'_>,
        (extent, window, rows): (&Extent, &Window<'_>, Range<u32>),
        (first, data): (u32, &mut [u16]),
        (memory, seen): (FastScratch<'_>, Seen<'_>),
    ) {
        let At { plan, plane, .. } = at;
        let [samples, ..] = memory.samples;
        let (width, columns) = (plan.base()[0] as usize, extent.columns.clone());
        let mut pixels = Pixels::<O, V>::new((first, data), width, columns, plane.index, self.floor);
        let classifier = FastKernels::<_, V>::of(&self.table, extent, code(plan));
        let shader = Lit::<S, V>::of(&self.shader);
        let mut blocks = Blocks::<V, S>::new(seen, (extent, window, rows), plan.spacing(), samples);
        fold(&mut blocks, (&classifier, &shader), &mut pixels, memory.batch, None);
    }
}

/// Whole rows through the driver, of which there is one copy for all pipelines of 16 bits.
#[inline(never)]
fn fold_rows(
    rows: &mut WholeRows<'_, '_, dyn Source<u16> + '_>,
    slots: (&dyn ClassifierRows<u16>, &dyn ShaderRows<u16>),
    canvas: &mut dyn Canvas<u16>,
    memory: BatchRows<'_, u16>,
    tap: Option<&mut dyn Tap>,
) {
    fold(rows, slots, canvas, memory, tap);
}

impl<R, C, S, O> Pipeline for Fast<R, C, S, O>
where
    R: Deref<Target = fast::Roots> + Sync,
    C: Deref<Target = fast::Colours> + Sync,
    S: FastShader,
    O: Order,
{
    type Precision = precision::Fast;
    type Voxel = Code12;
    type Element = u16;
    const CHANNELS: usize = 4;
    const SLICES: usize = if S::LIT { 4 } else { 2 };
    const SCRATCH: scratch::Rows = if S::LIT {
        scratch::Rows::LitFast
    } else {
        scratch::Rows::Fast
    };
    const BACK_TO_FRONT: bool = O::BACK_TO_FRONT;

    fn support(&self) -> Option<Support> {
        Some(self.table.support())
    }

    fn precision(&self) -> precision::Fast {
        precision::Fast
    }

    fn empty(&self, channel: usize) -> u16 {
        if channel == 3 { u16::MAX } else { 0 }
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        Rows { first, data }: Rows<'_, u16>,
        scratch: &mut [i32],
        _: Option<&mut Kept<'_>>,
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        let At {
            plan, plane, window, ..
        } = at;
        let [mut width, _, _] = plan.dims();
        // Small machines have no whole volume at hand, and observers see whole rows.
        let seen = at.seen.filter(|_| !V::SMALL && tap.is_none());
        // One lane goes through runs of blocks row by row.
        let in_vectors = V::Halves::COUNT > 1 && width as usize >= WIDTH_LEAST;
        if seen.is_some() {
            width = width.max(BATCH_WIDTH);
        }
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let Some(count) = data.len().checked_div(4 * plan.base()[0] as usize) else {
            return Ok(());
        };
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        while let Some(Samples {
            mut extent,
            window,
            whole_rows,
        }) = parts.samples::<V>(window)
        {
            let met = extent.met(first, count);
            // A constant, before which no code for blocks is compiled.
            if const { V::Halves::COUNT > 1 }
                && in_vectors
                && let Some(seen) = seen.filter(|_| whole_rows)
            {
                let memory = FastScratch::cut(&mut *scratch, Self::SCRATCH, width, true)?;
                self.fold_blocks::<V>(at, (&extent, &window, met), (first, &mut *data), (memory, seen));
                continue;
            }
            let whole = extent.clone();
            let mut runs = seen
                .filter(|_| whole_rows)
                .map(|seen| Runs::of(seen, &whole, met.clone()));
            // What is read is told of whole rows.
            let at = At {
                reading: at.reading.filter(|_| whole_rows && runs.is_none()),
                ..*at
            };
            let mut all = Some(met);
            while let Some(rows) = match &mut runs {
                None => all.take(),
                Some(runs) => runs.next().map(|(rows, columns)| {
                    extent = whole.clone();
                    extent.keep(columns);
                    rows
                }),
            } {
                let memory = FastScratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
                let rows = (&extent, &window, rows);
                self.fold_extent::<V>(&at, rows, (first, &mut *data), memory, again(&mut tap));
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[u16]) -> bool {
        !O::BACK_TO_FRONT && rows_finished::<_, V>(plan.base()[0] as usize, data)
    }

    fn pixel(&self, row: &[u16], column: usize) -> Pixel<Unorm16> {
        let width = row.len() >> 2;
        let run = |channel: usize| {
            let inside = column < width;
            let element = row.get(channel * width + column).filter(|_| inside);
            Unorm16(element.copied().unwrap_or(self.empty(channel)))
        };
        Pixel {
            colour: three([0, 1, 2], run),
            transparency: run(3),
        }
    }
}
