//! Perspective: rays that spread from an eye, through the same stages as parallel ones.
//!
//! A row of the image lies in one place between two voxel rows of a plane, so that z and y interpolation are those of parallel rays: rows
//! with one weight. Along x each column has a cell and a weight of its own, the same in all rows of a plane; voxels are gathered there.
//! Opacities are those of a step along k, brought to the length of the ray's own step.

mod project;
mod source;

use core::ops::Range;

pub use self::project::ProjectFromEye;
use self::source::{Source, Spreads};
use super::canvas::{Image, Packing};
use super::composite::Composite;
use super::extent::around;
use super::fold::Batches;
use super::kept::Kept;
use super::kernels::{ClassifierRows, Kernels, PartRows, ShaderRows, Towards};
use super::scratch::{self, ScratchError, SpreadScratch};
use super::slots::{AnySlots, Slots};
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::{Classifier, Slab, Support};
use crate::composite::{Colours, Order, Pixel};
use crate::lanes::Lanes;
use crate::locate::Plane;
use crate::perspective::{Line, Spread};
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::{part, part_mut};
use crate::seen::{Grain, Seen};
use crate::shade::{Asked, Shader};
use crate::slice::{Code12, Window};
use crate::tap::{Beam, Tap};

/// [`Composite`] of rays that spread from an eye: points, whole borders, no modulation. It folds planes of the plan that was made with its
/// rays ([`Plan::perspective`]), and nothing of others.
#[derive(Clone, Debug)]
pub struct Perspective<P: Precision, C, S, O> {
    pipeline: Composite<P, C, S, O>,
    spread: Spread,
}

impl<P: Precision, C: Classifier<P>, S: Shader<P>, O: Order> Perspective<P, C, S, O> {
    /// The same pipeline over these rays.
    pub const fn new(pipeline: Composite<P, C, S, O>, spread: Spread) -> Self {
        Self { pipeline, spread }
    }
}

/// Runs of rows, one after the other. Without known blocks a run is a whole row, which is left out when all its rays have terminated or
/// all voxels around it are transparent; with them it is what blocks beside each other cover that can be seen, where rays go on.
struct SpreadRows<'s, 'w, S: ?Sized> {
    plane: &'s Plane,
    /// Columns of the image that have a sample.
    columns: Range<usize>,
    window: &'s Window<'w>,
    support: Support,
    seen: Option<Seen<'s>>,
    source: &'s mut S,
    rows: Range<u32>,
    row: u32,
    /// What is left of the row's blocks.
    blocks: u64,
    /// The run, counted from the first of the columns.
    run: Range<usize>,
    from: usize,
}

impl<'s, 'w, S: ?Sized> SpreadRows<'s, 'w, S> {
    #[inline(always)]
    fn new(
        plane: &'s Plane,
        columns: Range<usize>,
        window: &'s Window<'w>,
        (support, seen): (Support, Option<Seen<'s>>),
        source: &'s mut S,
        rows: Range<u32>,
    ) -> Self {
        Self {
            plane,
            run: 0..columns.len(),
            columns,
            window,
            support,
            seen,
            source,
            rows,
            row: 0,
            blocks: 0,
            from: 0,
        }
    }
}

impl<S: Spreads<i32> + ?Sized> SpreadRows<'_, '_, S> {
    /// Whether rays of some columns go on: the canvas then shows these.
    #[inline(always)]
    fn goes_on<X: Packing<i32> + ?Sized>(&self, canvas: &mut X, run: &Range<usize>) -> bool {
        let first = self.columns.start;
        canvas.begin(first + run.start..first + run.end);
        !run.is_empty() && !canvas.finished(self.row)
    }

    /// The next run of the row's blocks.
    #[inline(always)]
    fn next_run<X: Packing<i32> + ?Sized>(&mut self, canvas: &mut X, grain: Grain) -> Option<Range<usize>> {
        let mut run: Option<Range<usize>> = None;
        let mut voxels_end = 0;
        while self.blocks != 0 {
            let voxels = grain.block(self.blocks.trailing_zeros());
            if run.is_some() && voxels.start != voxels_end {
                break;
            }
            self.blocks &= self.blocks - 1;
            let columns = self.source.columns(voxels.clone());
            if !self.goes_on(canvas, &columns) {
                if run.is_some() {
                    break;
                }
                continue;
            }
            voxels_end = voxels.end;
            run = Some(run.map_or(columns.start, |run| run.start)..columns.end);
        }
        run
    }
}

impl<X: Packing<i32> + ?Sized, S: Spreads<i32> + ?Sized> Batches<i32, X> for SpreadRows<'_, '_, S> {
    const WHOLE_ROWS: bool = true;

    #[inline(always)]
    fn next(&mut self, canvas: &mut X) -> Option<usize> {
        let run = loop {
            if let Some(seen) = self.seen
                && let Some(run) = self.next_run(canvas, seen.grain())
            {
                break run;
            }
            self.row = self.rows.next()?;
            let row = self.source.voxel_row(self.row);
            if let Some(seen) = self.seen {
                self.blocks = seen.row(row.max(0) as usize);
                continue;
            }
            if canvas.finished(self.row) {
                continue;
            }
            let last = self.window.near.height() as i32 - 1;
            let rows = [row, row + 1].map(|row| row.min(last).max(0) as usize);
            if self.support.meets(around(self.window, rows.into())) {
                break 0..self.columns.len();
            }
        };
        if self.seen.is_some() {
            let first = self.columns.start;
            canvas.begin(first + run.start..first + run.end);
        }
        (self.run, self.from) = (run.clone(), 0);
        self.source.make(self.row, run.clone());
        Some(run.len())
    }

    #[inline(always)]
    fn slab(&self) -> Slab<'_> {
        Slab::of(self.source.samples())
    }

    #[inline(always)]
    fn again(&mut self) {
        self.from = 0;
    }

    #[inline(always)]
    fn clip<C: ClassifierRows<i32> + ?Sized>(&self, _: &C, _: u32, opacities: &mut [i32]) {
        self.source.lengthen(opacities);
    }

    #[inline(always)]
    fn visible(&mut self, canvas: &mut X, opacities: &mut [i32]) -> Option<Range<usize>> {
        if self.from >= opacities.len() {
            return None;
        }
        let span = canvas.visible(self.row, opacities, self.from)?;
        self.from = span.end;
        Some(span)
    }

    #[inline(always)]
    fn gradients(&mut self, visible: Range<usize>, _: &[i32], _: Option<&[i32]>, out: [&mut [i32]; 3]) {
        self.source.gradients(visible, out);
    }

    #[inline(always)]
    fn towards(&self, visible: Range<usize>) -> [&[i32]; 3] {
        self.source.towards(visible)
    }

    #[inline(always)]
    fn weigh(&self, canvas: &X, visible: Range<usize>, opacities: &mut [i32], factors: &[i32]) {
        canvas.weigh(part_mut(opacities, visible), factors);
    }

    #[inline(always)]
    fn fold(
        &mut self,
        canvas: &mut X,
        visible: Range<usize>,
        colours: &Colours<'_, i32>,
        opacities: &[i32],
        _: Option<&[i32]>,
    ) {
        canvas.fold(self.row, visible.clone(), colours, part(opacities, visible));
    }

    #[inline(always)]
    fn beam(&self, offset: usize, part: u32) -> Option<Beam<'_>> {
        Some(Beam {
            plane: self.plane,
            row: self.row,
            column: (self.columns.start + self.run.start + offset) as u32,
            part,
        })
    }
}

/// What rays reach of a plane.
struct Reach {
    lines: [Line; 2],
    /// Columns of the image that have a sample.
    columns: Range<usize>,
    /// Rows of it, of those that are folded.
    met: Range<u32>,
}

/// What rays reach of a plane in some rows of the image; `None` is nothing.
#[inline(always)]
fn reach(spread: &Spread, at: &At<'_>, (first, count): (u32, usize)) -> Option<Reach> {
    let (plan, plane) = (at.plan, &at.plane);
    let ([width, height, _], [base_width, base_height]) = (plan.dims(), plan.base());
    // What lies behind the eye or about it, and what is another plan's.
    if plane.index < spread.first_plane() || !plan.spreads() || spread.base() != plan.base() {
        return None;
    }
    let lines = spread.lines(plane.index);
    let [across, down] = &lines;
    let (columns, met) = (across.inside(width, base_width), down.inside(height, base_height));
    let columns = columns.start as usize..columns.end as usize;
    let met = met.start.max(first)..met.end.min(first + count as u32);
    (!columns.is_empty() && !met.is_empty()).then_some(Reach { lines, columns, met })
}

/// Folds the samples of a plane.
#[inline(always)]
fn fold_plane<V, A, P, C, S, X>(
    slots: &mut Slots<'_, P, C, S, X>,
    spread: &Spread,
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
    let (plan, plane, window) = (at.plan, &at.plane, &at.window);
    let (source_rows, mut batch) = SpreadScratch::cut(scratch, memory, plan.longest_row(), !V::SMALL)?;
    if let Some(tap) = &mut tap {
        tap.plane(plane);
    }
    let Some(Reach { lines, columns, met }) = reach(spread, at, (slots.first, slots.count)) else {
        return Ok(());
    };
    slots.canvas.begin(columns.clone());
    // Small machines have no whole volume at hand, and observers see whole rows.
    let seen = at.seen.filter(|_| !V::SMALL && tap.is_none());
    batch.opacities = part_mut(batch.opacities, 0..columns.len());
    let (around, place) = ((plan, spread, plane), columns.clone());
    let mut source = Source::<P, V, A>::new(slots.precision, around, lines, place, window, source_rows);
    if V::SMALL {
        let mut rows = SpreadRows::new(plane, columns, window, (slots.support, None), &mut source, met);
        slots.fold(&mut rows, batch, tap);
    } else {
        let source: &mut dyn Spreads<i32> = &mut source;
        let mut rows = SpreadRows::new(plane, columns, window, (slots.support, seen), source, met);
        slots.fold_apart(&mut rows, batch, tap);
    }
    Ok(())
}

/// [`fold_plane`] of any pipeline of a precision.
#[inline(never)]
fn fold_plane_of<V: Lanes, A: Asked, P: Precision>(
    slots: &mut AnySlots<'_, '_, P>,
    spread: &Spread,
    memory: scratch::Rows,
    at: &At<'_>,
    scratch: &mut [i32],
    tap: Option<&mut dyn Tap>,
) -> Result<(), ScratchError> {
    fold_plane::<V, A, _, _, _, _>(slots, spread, memory, at, scratch, tap)
}

impl<P, C, S, O> Pipeline for Perspective<P, C, S, O>
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
    const SCRATCH: scratch::Rows = if S::LIT {
        scratch::Rows::LitSpread
    } else {
        scratch::Rows::Spread
    };
    const SPREADS: bool = true;
    const BACK_TO_FRONT: bool = O::BACK_TO_FRONT;

    fn support(&self) -> Option<Support> {
        self.pipeline.support()
    }

    fn precision(&self) -> P {
        self.pipeline.precision()
    }

    fn empty(&self, channel: usize) -> ChannelOf<P> {
        self.pipeline.empty(channel)
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        _: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        const {
            assert!(
                !C::SLABS && !S::MODULATES,
                "in perspective samples are classified, and not modulated"
            )
        };
        let Composite {
            precision,
            classifier,
            shader,
            floor,
            ..
        } = &self.pipeline;
        let (precision, width) = (*precision, at.plan.base()[0] as usize);
        let (first, count) = (rows.first, rows.data.len().checked_div(4 * width).unwrap_or(0));
        let kinds = (precision.pixel(), *floor);
        let mut canvas = Image::<P::Pixel, O, V>::new((first, rows.data), width, 0..0, at.plane.index, kinds);
        let mut slots = Slots {
            precision,
            classifier: &mut Kernels::<C, P, V>::of(classifier, precision),
            shader: &Towards(Kernels::<S, P, V>::of(shader, precision)),
            canvas: &mut canvas,
            support: classifier.support(),
            first,
            count,
        };
        let (spread, memory) = (&self.spread, Self::SCRATCH);
        if V::SMALL {
            fold_plane::<V, S::Asked, _, _, _, _>(&mut slots, spread, memory, at, scratch, tap)
        } else {
            fold_plane_of::<V, S::Asked, P>(&mut slots.any(), spread, memory, at, scratch, tap)
        }
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        self.pipeline.finished::<V>(plan, data)
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        self.pipeline.pixel(row, column)
    }
}
