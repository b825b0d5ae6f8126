//! Compositing of the samples of a sheet: the driver of planes, fed from memory.

use core::marker::PhantomData;
use core::ops::Range;

use super::canvas::{Canvas, Image};
use super::composite::Composite;
use super::fold::{Batches, fold};
use super::kernels::{ClassifierRows, Kernels, ShaderRows, Towards};
use super::scratch::{BatchRows, Scratch, ScratchError};
use super::source::spaced;
use super::{ChannelOf, Pipeline, Rows};
use crate::borders::lengths_row;
use crate::classify::{Classifier, Slab, Support};
use crate::composite::{Channel as _, Colours, FrontToBack};
use crate::format::Intensity;
use crate::gradient::coarsen_row;
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::rows::{part, part_mut};
use crate::shade::Shader;
use crate::slice::RowRange;
use crate::splat::{MISSING, Rays, Sheet, slope};
use crate::tap::Beam;

/// A pipeline that takes the samples of [sheets](crate::splat).
pub trait FoldSheet: Pipeline {
    /// Whether it reads gradients.
    const LIT: bool;

    /// Whether a transparency is 0.
    fn is_zero(left: Self::Element) -> bool;

    /// Folds a sheet into rows of the image, of four runs as wide as the sheet.
    ///
    /// # Errors
    /// [`ScratchError`] if `scratch` holds fewer words than [`Shape::scratch_len`](super::Shape::scratch_len) of the image's width; no row is changed
    /// then.
    fn fold_sheet<V: Lanes>(
        &self,
        sheet: &Sheet<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
    ) -> Result<(), ScratchError>;
}

impl<P: Precision, C: Classifier<P>, S: Shader<P>> FoldSheet for Composite<P, C, S, FrontToBack> {
    const LIT: bool = S::LIT;

    fn is_zero(left: ChannelOf<P>) -> bool {
        left.bits() == 0
    }

    fn fold_sheet<V: Lanes>(
        &self,
        sheet: &Sheet<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
    ) -> Result<(), ScratchError> {
        const { assert!(!C::SLABS && !S::MODULATES, "sheets have samples, and no modulation") };
        let width = sheet.width();
        let Scratch { source, mut batch, .. } = Scratch::cut(scratch, Self::SCRATCH, width as u32, !V::SMALL)?;
        let Some(count) = rows.data.len().checked_div(4 * width) else {
            return Ok(());
        };
        let (precision, first) = (self.precision, rows.first);
        let mut canvas = Image::<P::Pixel, FrontToBack, V>::new(
            (first, rows.data),
            width,
            0..width,
            sheet.number(),
            (precision.pixel(), self.floor),
        );
        let classifier = Kernels::<C, P, V>::of(&self.classifier, precision);
        let shader = Kernels::<S, P, V>::of(&self.shader, precision);
        let towards = Towards(Kernels::<S, P, V>::of(&self.shader, precision));
        // The viewer of rays that spread is another in each column.
        let shader: &dyn ShaderRows<i32> = match sheet.rays() {
            Some(_) => &towards,
            None => &shader,
        };
        let [samples, ..] = source.samples;
        batch.opacities = part_mut(batch.opacities, 0..width);
        let spacing: &dyn Spacing = &SpacedBy::<P, V>(precision, PhantomData);
        let mut rows = SheetRows {
            sheet,
            rows: first..first + count as u32,
            samples: part_mut(samples, 0..width),
            sample_bits: precision.formats().sample_bits,
            support: self.classifier.support(),
            spacing,
            row: first,
            from: 0,
        };
        fold_rows(&mut rows, (&classifier, shader), &mut canvas, batch);
        Ok(())
    }
}

/// Rows through the driver, of which there is one copy for all pipelines.
#[inline(never)]
fn fold_rows(
    rows: &mut SheetRows<'_>,
    slots: (&dyn ClassifierRows<i32>, &dyn ShaderRows<i32>),
    canvas: &mut dyn Canvas<i32>,
    memory: BatchRows<'_, i32>,
) {
    fold(rows, slots, canvas, memory, None);
}

/// Brings gradients to the spacing of pixels and sheets, and opacities to the lengths of steps.
trait Spacing {
    fn apply(&self, g: [&mut [i32]; 3], factors: [Intensity; 3]);
    fn lengthen(&self, opacities: &mut [i32], lengths: &[i32]);
    fn tilt(&self, rays: &Rays<'_>, at: (u32, usize), g: [&mut [i32]; 3]);
}

struct SpacedBy<P, V>(P, PhantomData<V>);

impl<P: Precision, V: Lanes> Spacing for SpacedBy<P, V> {
    fn apply(&self, g: [&mut [i32]; 3], factors: [Intensity; 3]) {
        V::enter((Space, self, g, factors));
    }

    fn lengthen(&self, opacities: &mut [i32], lengths: &[i32]) {
        V::enter((Lengthen, PhantomData::<V>, opacities, lengths));
    }

    fn tilt(&self, rays: &Rays<'_>, at: (u32, usize), g: [&mut [i32]; 3]) {
        V::enter((Tilt, self, (rays, at), g));
    }
}

struct Lengthen;

impl<V: Lanes> Kernel for (Lengthen, PhantomData<V>, &mut [i32], &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, opacities, lengths) = self;
        lengths_row::<V>(opacities, lengths);
    }
}

struct Tilt;

impl<P: Precision, V: Lanes> Kernel for (Tilt, &SpacedBy<P, V>, (&Rays<'_>, (u32, usize)), [&mut [i32]; 3]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, SpacedBy(precision, _), (rays, at), [gx, gy, gz]) = self;
        rays.tilt(at, [&mut *gx, &mut *gy, &mut *gz]);
        if precision.formats().gradient_bits < 15 {
            coarsen_row::<V>([gx, gy, gz], precision.formats().gradient_bits);
        }
    }
}

struct Space;

impl<P: Precision, V: Lanes> Kernel for (Space, &SpacedBy<P, V>, [&mut [i32]; 3], [Intensity; 3]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, SpacedBy(precision, _), g, factors) = self;
        spaced::<P, V>(*precision, g, factors);
    }
}

/// Rows of a sheet, one after the other: those without samples, or none that can be visible, are left out.
struct SheetRows<'s> {
    sheet: &'s Sheet<'s>,
    rows: Range<u32>,
    /// Those of the row, 0 where there is none.
    samples: &'s mut [i32],
    sample_bits: u32,
    support: Support,
    spacing: &'s dyn Spacing,
    row: u32,
    from: usize,
}

impl SheetRows<'_> {
    /// The codes that samples lie between.
    fn range(&self, row: &[i32]) -> RowRange {
        let (mut low, mut high) = (i32::MAX, -1);
        for &sample in row {
            low = low.min(if sample == MISSING { i32::MAX } else { sample });
            high = high.max(sample);
        }
        if high < 0 {
            return RowRange::EMPTY;
        }
        RowRange {
            low: (low >> self.sample_bits) as u16,
            high: ((high + (1 << self.sample_bits) - 1) >> self.sample_bits) as u16,
        }
    }
}

impl<X: Canvas<i32> + ?Sized> Batches<i32, X> for SheetRows<'_> {
    const WHOLE_ROWS: bool = true;

    fn next(&mut self, canvas: &mut X) -> Option<usize> {
        loop {
            self.row = self.rows.next()?;
            let row = self.sheet.row(1, self.row.into());
            if row.is_empty() || canvas.finished(self.row) || !self.support.meets(self.range(row)) {
                continue;
            }
            for (out, &sample) in self.samples.iter_mut().zip(row) {
                *out = sample.max(0);
            }
            self.from = 0;
            return Some(row.len());
        }
    }

    fn slab(&self) -> Slab<'_> {
        Slab::of(self.samples)
    }

    fn again(&mut self) {
        self.from = 0;
    }

    /// There is nothing where no sample exists; where rays spread, steps are as long as they are.
    fn clip<C: ClassifierRows<i32> + ?Sized>(&self, _: &C, _: u32, opacities: &mut [i32]) {
        for (opacity, &sample) in opacities.iter_mut().zip(self.sheet.row(1, self.row.into())) {
            if sample == MISSING {
                *opacity = 0;
            }
        }
        if let Some(rays) = self.sheet.rays() {
            self.spacing.lengthen(opacities, rays.lengths(self.row));
        }
    }

    fn towards(&self, visible: Range<usize>) -> [&[i32]; 3] {
        match self.sheet.rays() {
            Some(rays) => rays.towards(self.row).map(|row| part(row, visible.clone())),
            None => [&[]; 3],
        }
    }

    fn visible(&mut self, canvas: &mut X, opacities: &mut [i32]) -> Option<Range<usize>> {
        if self.from >= opacities.len() {
            return None;
        }
        let span = canvas.visible(self.row, opacities, self.from)?;
        self.from = span.end;
        Some(span)
    }

    fn gradients(&mut self, visible: Range<usize>, _: &[i32], _: Option<&[i32]>, [gx, gy, gz]: [&mut [i32]; 3]) {
        let row = i64::from(self.row);
        let here = self.sheet.row(1, row);
        let at = part(here, visible.clone());
        let sample = |row: &[i32], at: Option<usize>| at.and_then(|at| row.get(at)).copied().unwrap_or(MISSING);
        for ((column, out), &at) in visible.clone().zip(&mut *gx).zip(at) {
            *out = slope(sample(here, column.checked_sub(1)), at, sample(here, Some(column + 1)));
        }
        for (out, [before, behind]) in [
            (&mut *gy, [self.sheet.row(1, row - 1), self.sheet.row(1, row + 1)]),
            (&mut *gz, [self.sheet.row(0, row), self.sheet.row(2, row)]),
        ] {
            let [before, behind] = [before, behind].map(|row| part(row, visible.clone()));
            for (number, (out, &at)) in out.iter_mut().zip(at).enumerate() {
                *out = slope(sample(before, Some(number)), at, sample(behind, Some(number)));
            }
        }
        // An invisible sample of a span may not exist.
        let none = at.iter().enumerate().filter(|(_, at)| **at == MISSING);
        for (number, _) in none {
            for out in [&mut *gx, &mut *gy, &mut *gz] {
                if let Some(out) = out.get_mut(number) {
                    *out = 0;
                }
            }
        }
        match self.sheet.rays() {
            Some(rays) => self.spacing.tilt(&rays, (self.row, visible.start), [gx, gy, gz]),
            None => self.spacing.apply([gx, gy, gz], self.sheet.spacing()),
        }
    }

    fn weigh(&self, canvas: &X, visible: Range<usize>, opacities: &mut [i32], factors: &[i32]) {
        canvas.weigh(part_mut(opacities, visible), factors);
    }

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

    fn beam(&self, _: usize, _: u32) -> Option<Beam<'_>> {
        None
    }
}
