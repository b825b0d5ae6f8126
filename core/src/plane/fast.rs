//! Compositing in 16-bit lanes: the pipeline of the `fast` precision.

mod kernels;
mod pixels;
mod source;

use core::marker::PhantomData;
use core::ops::{Deref, Range};

use self::kernels::{FastKernels, Lit};
use self::pixels::Pixels;
use self::source::Short;
use super::canvas::Canvas;
use super::composite::again;
use super::extent::{Extent, around};
use super::fold::{Batches, fold};
use super::kernels::{ClassifierRows, ShaderRows};
use super::parts::{Columns, Parts, Samples};
use super::scratch::{self, BatchRows, FastScratch, ScratchError};
use super::source::Source;
use super::{At, Kept, Pipeline, Reading, Rows};
use crate::classify::{Slab, Support};
use crate::composite::{Colours, Order, Pixel, Unorm16};
use crate::fast::{self, RootTable};
use crate::lanes::{Halves as _, Kernel, Lanes, each};
use crate::locate::Plane;
use crate::plan::Plan;
use crate::precision;
use crate::rows::{part, part_mut, three};
use crate::slice::{Code12, Window};
use crate::tap::{Beam, Tap};

pub use self::kernels::FastShader;

/// Alpha compositing of classified, perhaps shaded samples in 16-bit lanes, rows as a whole: it looks at no clip planes and no blocks.
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
        Samples {
            extent,
            window,
            whole_rows,
        }: &Samples<'_>,
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
        let Some(count) = data.len().checked_div(4 * base_width) else {
            return;
        };
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
        let classifier = FastKernels::<_, V>::of(&self.table, extent, plan.exact());
        let shader = Lit::<S, V>::of(&self.shader);
        batch.opacities = part_mut(batch.opacities, 0..n);
        let mut short = Short::<V, S>::new((extent, window), plan.spacing(), (z, samples), (derivatives, slope));
        let (rows, support) = (extent.met(first, count), self.table.support());
        if V::SMALL {
            let mut rows = ShortRows::new(plane, (extent, window), support, &mut short, rows, None);
            fold(&mut rows, (&classifier, &shader), &mut pixels, batch, tap);
        } else {
            let reading = at.reading.filter(|_| *whole_rows);
            let source: &mut dyn Source<u16> = &mut short;
            let mut rows = ShortRows::new(plane, (extent, window), support, source, rows, reading);
            fold_rows(&mut rows, (&classifier, &shader), &mut pixels, batch, tap);
        }
    }
}

/// Whole rows through the driver, of which there is one copy for all pipelines of 16 bits.
#[inline(never)]
fn fold_rows(
    rows: &mut ShortRows<'_, '_, dyn Source<u16> + '_>,
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
        let [width, _, _] = plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        while let Some(samples) = parts.samples::<V>(window) {
            let memory = FastScratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
            self.fold_extent::<V>(at, &samples, (first, &mut *data), memory, again(&mut tap));
        }
        Ok(())
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[u16]) -> bool {
        if O::BACK_TO_FRONT {
            return false;
        }
        let width = plan.base()[0] as usize;
        for row in data.chunks_exact((4 * width).max(1)) {
            if !V::enter((AllZero, PhantomData::<V>, part(row, 3 * width..4 * width))) {
                return false;
            }
        }
        true
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

/// Whether all of a row is 0.
struct AllZero;

impl<V: Lanes> Kernel for (AllZero, PhantomData<V>, &[u16]) {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let (_, _, row) = self;
        each!(V::Halves, row.len(), |at, WHOLE| {
            if !V::Halves::load::<WHOLE>(row, at).all_zero() {
                return false;
            }
        });
        true
    }
}

/// Whole rows, one after the other, as [`WholeRows`](super::fold::WholeRows): nothing is clipped or cut.
struct ShortRows<'s, 'w, S: ?Sized> {
    plane: &'s Plane,
    extent: &'s Extent,
    window: &'s Window<'w>,
    support: Support,
    source: &'s mut S,
    rows: Range<u32>,
    reading: Option<&'s dyn Reading>,
    row: u32,
    from: usize,
}

impl<'s, 'w, S: ?Sized> ShortRows<'s, 'w, S> {
    #[inline(always)]
    fn new(
        plane: &'s Plane,
        (extent, window): (&'s Extent, &'s Window<'w>),
        support: Support,
        source: &'s mut S,
        rows: Range<u32>,
        reading: Option<&'s dyn Reading>,
    ) -> Self {
        Self {
            plane,
            extent,
            window,
            support,
            source,
            rows,
            reading,
            row: 0,
            from: 0,
        }
    }

    #[inline(always)]
    fn voxel_row(&self) -> i32 {
        self.extent.voxel_row(self.row)
    }
}

impl<X: Canvas<u16> + ?Sized, S: Source<u16> + ?Sized> Batches<u16, X> for ShortRows<'_, '_, S> {
    const WHOLE_ROWS: bool = true;

    #[inline(always)]
    fn next(&mut self, canvas: &mut X) -> Option<usize> {
        loop {
            self.row = self.rows.next()?;
            if canvas.finished(self.row) {
                continue;
            }
            let voxel_row = self.voxel_row();
            if self
                .support
                .meets(around(self.window, self.extent.voxel_rows(voxel_row)))
            {
                if let Some(reading) = self.reading {
                    reading.row(voxel_row);
                }
                self.source.make(voxel_row);
                self.from = 0;
                return Some(self.extent.columns.len());
            }
        }
    }

    #[inline(always)]
    fn slab(&self) -> Slab<'_, u16> {
        self.source.slab(self.voxel_row())
    }

    #[inline(always)]
    fn again(&mut self) {
        self.from = 0;
    }

    #[inline(always)]
    fn clip<C: ClassifierRows<u16> + ?Sized>(&self, _: &C, _: u32, _: &mut [u16]) {}

    #[inline(always)]
    fn visible(&mut self, canvas: &mut X, opacities: &mut [u16]) -> Option<Range<usize>> {
        if self.from >= opacities.len() {
            return None;
        }
        let span = canvas.visible(self.row, opacities, self.from)?;
        self.from = span.end;
        Some(span)
    }

    #[inline(always)]
    fn gradients(&mut self, visible: Range<usize>, _: &[u16], turns: Option<&[u16]>, out: [&mut [u16]; 3]) {
        self.source.gradients(self.voxel_row(), visible, turns, out);
    }

    #[inline(always)]
    fn weigh(&self, _: &X, _: Range<usize>, _: &mut [u16], _: &[u16]) {}

    #[inline(always)]
    fn fold(
        &mut self,
        canvas: &mut X,
        visible: Range<usize>,
        colours: &Colours<'_, u16>,
        opacities: &[u16],
        _: Option<&[u16]>,
    ) {
        canvas.fold(self.row, visible.clone(), colours, part(opacities, visible));
    }

    #[inline(always)]
    fn beam(&self, offset: usize, part: u32) -> Option<Beam<'_>> {
        Some(Beam {
            plane: self.plane,
            row: self.row,
            column: (self.extent.columns.start + offset) as u32,
            part,
        })
    }
}
