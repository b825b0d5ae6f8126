//! The driver: takes batches of samples of a plane through the stages.
//!
//! The way through the plane ([`Batches`]) is whole rows or the blocks that can be seen; the stages are the same for both.
//! A small machine compiles this function with its pipeline, as one. Elsewhere the slots are trait objects: the driver is
//! compiled once, and each kernel once for what it reads.

use core::ops::Range;

use super::Reading;
use super::canvas::Canvas;
use super::clipped::{ClipRows, Clipped};
use super::extent::{Extent, around};
use super::kernels::{Beside, ClassifierRows, ShaderRows};
use super::scratch::BatchRows;
use super::smooth;
use super::source::Source;
use crate::classify::{Slab, Support};
use crate::composite::Colours;
use crate::locate::Plane;
use crate::rows::{part, part_mut, three};
use crate::slice::Window;
use crate::stage::Stage;
use crate::tap::{Beam, Bits, Tap};

/// A way through the samples of a plane, batch by batch.
pub(super) trait Batches<W, X: Canvas<W> + ?Sized> {
    /// Whether a batch is a row, of which not all samples need be visible.
    const WHOLE_ROWS: bool;
    /// Makes the samples of the next batch; how many they are.
    fn next(&mut self, canvas: &mut X) -> Option<usize>;
    /// The samples of the batch, and those in front of them where segments are classified.
    fn slab(&self) -> Slab<'_, W>;
    /// Says that the batch is gone through several times, part by part.
    fn keep(&mut self) {}
    /// Begins another part of a batch that was kept.
    fn again(&mut self);
    /// Leaves of the opacities of a part what clip planes leave of the segments; where rays spread, brings them to the lengths of steps.
    fn clip<C: ClassifierRows<W> + ?Sized>(&self, classifier: &C, part: u32, opacities: &mut [W]);
    /// Makes the colours of visible segments those of what is left of them.
    fn clip_colours<C: ClassifierRows<W> + ?Sized>(
        &self,
        classifier: &C,
        part: u32,
        visible: Range<usize>,
        colours: [&mut [W]; 3],
    ) {
        let _ = (classifier, part, visible, colours);
    }
    /// Makes the turns of visible crossings those of what is left of their segments.
    fn clip_turns<C: ClassifierRows<W> + ?Sized>(
        &self,
        classifier: &C,
        part: u32,
        visible: Range<usize>,
        turns: &mut [W],
    ) {
        let _ = (classifier, part, visible, turns);
    }
    /// Whether colours turn with depth.
    fn cues(&self) -> bool {
        false
    }
    /// Turns the colours of visible segments.
    fn turn(&self, _visible: Range<usize>, _colours: &mut Colours<'_, W>) {}
    /// The next visible samples of the batch, side by side.
    fn visible(&mut self, canvas: &mut X, opacities: &mut [W]) -> Option<Range<usize>>;
    /// Their gradients, spaced; with their turns, those of crossings.
    fn gradients(&mut self, visible: Range<usize>, opacities: &[W], turns: Option<&[W]>, out: [&mut [W]; 3]);
    /// The unit vectors from them towards the eye, where rays spread; else empty rows.
    fn towards(&self, _visible: Range<usize>) -> [&[W]; 3] {
        [&[]; 3]
    }
    /// Multiplies their opacities by factors, if that is done before they are folded.
    fn weigh(&self, canvas: &X, visible: Range<usize>, opacities: &mut [W], factors: &[W]);
    /// Folds them into their pixels; factors, if there are any, are those of [`Batches::weigh`].
    fn fold(
        &mut self,
        canvas: &mut X,
        visible: Range<usize>,
        colours: &Colours<'_, W>,
        opacities: &[W],
        factors: Option<&[W]>,
    );
    /// Where a sample of the batch lies, for observers of a part.
    fn beam(&self, offset: usize, part: u32) -> Option<Beam<'_>>;
}

/// Folds all batches of a plane.
#[inline(always)]
pub(super) fn fold<W, B, C, S, X>(
    batches: &mut B,
    (classifier, shader): (&C, &S),
    canvas: &mut X,
    rows: BatchRows<'_, W>,
    mut tap: Option<&mut dyn Tap>,
) where
    for<'r> &'r [W]: Bits,
    B: Batches<W, X>,
    C: ClassifierRows<W> + ?Sized,
    S: ShaderRows<W> + ?Sized,
    X: Canvas<W> + ?Sized,
{
    let BatchRows {
        opacities,
        colours: [red, green, blue],
        g: [gx, gy, gz],
        r,
        magnitudes,
    } = rows;
    let (lit, modulates) = (shader.lit(), shader.modulates());
    // One colour needs no rows, unless they are looked at.
    let cues = batches.cues();
    let one = classifier.one_colour().filter(|_| tap.is_none() && !cues);
    while let Some(len) = batches.next(canvas) {
        let opacities = part_mut(opacities, 0..len);
        if let (Some(tap), Some(at)) = (&mut tap, batches.beam(0, 0)) {
            let Slab { front, back, .. } = batches.slab();
            if front.is_empty() {
                tap.row(Stage::Interpolation, at, &[&back]);
            } else {
                tap.row(Stage::Interpolation, at, &[&back, &front]);
            }
        }
        let parts = classifier.parts(batches.slab().span(0..len));
        if parts > 1 {
            batches.keep();
        }
        for turn in 0..parts {
            let part = if canvas.back_to_front() { parts - 1 - turn } else { turn };
            if parts > 1 {
                batches.again();
                canvas.begin_part(part);
            }
            classifier.opacity_row(batches.slab().span(0..len).of_part(part), opacities);
            batches.clip(classifier, part, opacities);
            if let (Some(tap), Some(at)) = (&mut tap, batches.beam(0, part)) {
                tap.row(Stage::Opacity, at, &[&&*opacities]);
            }
            // Unlit, one colour needs no spans either.
            if B::WHOLE_ROWS && one.is_some() && !lit {
                let colours = Colours {
                    one,
                    rows: [&mut [], &mut [], &mut []],
                };
                batches.fold(canvas, 0..len, &colours, opacities, None);
                continue;
            }
            while let Some(visible) = batches.visible(canvas, opacities) {
                let n = visible.len();
                let mut colours = Colours {
                    one: one.filter(|_| lit),
                    rows: three([&mut *red, &mut *green, &mut *blue], |row| part_mut(row, 0..n)),
                };
                if colours.one.is_none() {
                    let [r, g, b] = &mut colours.rows;
                    let mut slab = batches.slab();
                    // Samples of blocks lie side by side and are all visible; an observer sees every colour.
                    if B::WHOLE_ROWS && tap.is_none() {
                        slab = slab.of_opacities(opacities);
                    }
                    classifier.colour_row(slab.span(visible.clone()).of_part(part), [&mut *r, &mut *g, &mut *b]);
                    batches.clip_colours(classifier, part, visible.clone(), [r, g, b]);
                }
                if cues && !lit {
                    batches.turn(visible.clone(), &mut colours);
                }
                if let (Some(tap), Some(at)) = (&mut tap, batches.beam(visible.start, part)) {
                    see(*tap, Stage::Colour, at, &colours.rows);
                }
                let mut factors = None;
                if lit {
                    let [gx, gy, gz] = three([&mut *gx, &mut *gy, &mut *gz], |row| part_mut(row, 0..n));
                    let r = part_mut(r, 0..n);
                    let gradients = [&mut *gx, &mut *gy, &mut *gz];
                    if part & 1 == 1 {
                        classifier.turn_row(batches.slab().span(visible.clone()).of_part(part), &mut *r);
                        batches.clip_turns(classifier, part, visible.clone(), &mut *r);
                        batches.gradients(visible.clone(), opacities, Some(&*r), gradients);
                    } else {
                        batches.gradients(visible.clone(), opacities, None, gradients);
                    }
                    let magnitudes = part_mut(magnitudes, 0..n);
                    let towards = batches.towards(visible.clone());
                    if modulates {
                        shader.measure([&*gx, &*gy, &*gz], &mut *magnitudes);
                    }
                    let beside = Beside {
                        magnitudes: &*magnitudes,
                        towards,
                    };
                    if let (Some(tap), Some(at)) = (&mut tap, batches.beam(visible.start, part)) {
                        see(*tap, Stage::Gradient, at, &[&mut *gx, &mut *gy, &mut *gz]);
                        shader.normalise([&mut *gx, &mut *gy, &mut *gz], &mut *r);
                        tap.row(Stage::Normal, at, &[&&*gx, &&*gy, &&*gz, &&*r]);
                        shader.shade(([&*gx, &*gy, &*gz], &*r), beside, &mut colours);
                    } else {
                        shader.normalise_and_shade(([gx, gy, gz], r), beside, &mut colours);
                    }
                    if cues {
                        batches.turn(visible.clone(), &mut colours);
                    }
                    if modulates && shader.factors(&mut *magnitudes) {
                        batches.weigh(canvas, visible.clone(), opacities, &*magnitudes);
                        factors = Some(&*magnitudes);
                    }
                    if let (Some(tap), Some(at)) = (&mut tap, batches.beam(visible.start, part)) {
                        if modulates {
                            let [red, green, blue] = &colours.rows;
                            let opacities = self::part(opacities, visible.clone());
                            tap.row(Stage::Shading, at, &[&&**red, &&**green, &&**blue, &opacities]);
                        } else {
                            see(*tap, Stage::Shading, at, &colours.rows);
                        }
                    }
                }
                if let (Some(tap), Some(at)) = (&mut tap, batches.beam(visible.start, part)) {
                    canvas.look(at.row, visible.clone(), &mut |rows| tap.row(Stage::Before, at, rows));
                }
                batches.fold(canvas, visible.clone(), &colours, opacities, factors);
                if let (Some(tap), Some(at)) = (&mut tap, batches.beam(visible.start, part)) {
                    canvas.look(at.row, visible, &mut |rows| tap.row(Stage::After, at, rows));
                }
            }
        }
        if parts > 1 {
            canvas.begin_part(0);
        }
    }
}

/// Shows three rows to a tap.
fn see<W>(tap: &mut dyn Tap, stage: Stage, at: Beam<'_>, [a, b, c]: &[&mut [W]; 3])
where
    for<'r> &'r [W]: Bits,
{
    let rows: [&dyn Bits; 3] = [&&**a, &&**b, &&**c];
    tap.row(stage, at, &rows);
}

/// Whole rows, one after the other: a row is left out when all its rays have terminated or all voxels around it are
/// transparent.
pub(super) struct WholeRows<'s, 'w, S: ?Sized> {
    plane: &'s Plane,
    extent: &'s Extent,
    window: &'s Window<'w>,
    /// The plane in front, where segments are classified.
    front: Option<(&'s Extent, &'s Window<'w>)>,
    support: Support,
    clipped: Option<&'s Clipped<'s>>,
    source: &'s mut S,
    rows: Range<u32>,
    reading: Option<&'s dyn Reading>,
    /// Whether samples are of 27 voxels.
    splines: bool,
    row: u32,
    from: usize,
}

impl<'s, 'w, S: ?Sized> WholeRows<'s, 'w, S> {
    /// Some rows of the image.
    #[inline(always)]
    pub(super) fn new(
        plane: &'s Plane,
        (extent, window): (&'s Extent, &'s Window<'w>),
        front: Option<(&'s Extent, &'s Window<'w>)>,
        (support, clipped): (Support, Option<&'s Clipped<'s>>),
        source: &'s mut S,
        rows: Range<u32>,
        reading: Option<&'s dyn Reading>,
    ) -> Self {
        Self {
            plane,
            extent,
            window,
            front,
            support,
            clipped,
            source,
            rows,
            reading,
            splines: false,
            row: 0,
            from: 0,
        }
    }

    /// The same by splines.
    #[inline(always)]
    pub(super) fn by_splines(self) -> Self {
        Self { splines: true, ..self }
    }

    #[inline(always)]
    fn voxel_row(&self) -> i32 {
        self.extent.voxel_row(self.row)
    }
}

impl<W, X: Canvas<W> + ?Sized, S: Source<W> + ?Sized> Batches<W, X> for WholeRows<'_, '_, S>
where
    for<'c> Clipped<'c>: ClipRows<W>,
{
    const WHOLE_ROWS: bool = true;

    #[inline(always)]
    fn next(&mut self, canvas: &mut X) -> Option<usize> {
        loop {
            self.row = self.rows.next()?;
            if canvas.finished(self.row) || self.clipped.is_some_and(|clipped| clipped.is_empty(self.row)) {
                continue;
            }
            let voxel_row = self.voxel_row();
            let mut range = if self.splines {
                smooth::around(self.window, self.extent, voxel_row)
            } else {
                around(self.window, self.extent.voxel_rows(voxel_row))
            };
            if let Some((extent, window)) = self.front {
                let rows = extent.voxel_rows(extent.voxel_row(self.row));
                range = range.union(around(window, rows));
            }
            if self.support.meets(range) {
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
    fn slab(&self) -> Slab<'_, W> {
        self.source.slab(self.voxel_row())
    }

    #[inline(always)]
    fn clip<C: ClassifierRows<W> + ?Sized>(&self, classifier: &C, part: u32, opacities: &mut [W]) {
        if let Some(clipped) = self.clipped {
            clipped.clip(
                self.row,
                self.source.slab(self.voxel_row()),
                (classifier, part),
                opacities,
            );
        }
    }

    #[inline(always)]
    fn clip_colours<C: ClassifierRows<W> + ?Sized>(
        &self,
        classifier: &C,
        part: u32,
        visible: Range<usize>,
        colours: [&mut [W]; 3],
    ) {
        if let Some(clipped) = self.clipped {
            let slab = self.source.slab(self.voxel_row());
            clipped.clip_colours(self.row, (slab, visible), (classifier, part), colours);
        }
    }

    #[inline(always)]
    fn clip_turns<C: ClassifierRows<W> + ?Sized>(
        &self,
        classifier: &C,
        part: u32,
        visible: Range<usize>,
        turns: &mut [W],
    ) {
        if let Some(clipped) = self.clipped {
            let slab = self.source.slab(self.voxel_row());
            clipped.clip_turns(self.row, (slab, visible), (classifier, part), turns);
        }
    }

    #[inline(always)]
    fn cues(&self) -> bool {
        self.clipped.is_some_and(Clipped::cues)
    }

    #[inline(always)]
    fn turn(&self, visible: Range<usize>, colours: &mut Colours<'_, W>) {
        if let Some(clipped) = self.clipped {
            let [red, green, blue] = &mut colours.rows;
            ClipRows::turn(clipped, self.row, visible.start, [red, green, blue]);
        }
    }

    #[inline(always)]
    fn again(&mut self) {
        self.from = 0;
    }

    #[inline(always)]
    fn visible(&mut self, canvas: &mut X, opacities: &mut [W]) -> Option<Range<usize>> {
        // Most rows are one span, and a call per row counts.
        if self.from >= opacities.len() {
            return None;
        }
        let span = canvas.visible(self.row, opacities, self.from)?;
        self.from = span.end;
        Some(span)
    }

    #[inline(always)]
    fn gradients(&mut self, visible: Range<usize>, _: &[W], turns: Option<&[W]>, out: [&mut [W]; 3]) {
        self.source.gradients(self.voxel_row(), visible, turns, out);
    }

    #[inline(always)]
    fn weigh(&self, canvas: &X, visible: Range<usize>, opacities: &mut [W], factors: &[W]) {
        canvas.weigh(part_mut(opacities, visible), factors);
    }

    #[inline(always)]
    fn fold(
        &mut self,
        canvas: &mut X,
        visible: Range<usize>,
        colours: &Colours<'_, W>,
        opacities: &[W],
        _: Option<&[W]>,
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
