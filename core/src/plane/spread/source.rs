//! Samples, gradients and steps of one plane of rays that spread.

use core::marker::PhantomData;
use core::ops::Range;

use super::super::scratch::NO_ROW;
use super::super::scratch::SpreadScratch;
use super::super::source::{derivatives, spaced};
use crate::borders::lengths_row;
use crate::format::{Intensity, Weight};
use crate::interpolate::{cut, extend_row, lerp_x, lerp_y, z_difference_row, z_row};
use crate::lanes::{Kernel, Lanes, places};
use crate::locate::{Cell, Plane, cell};
use crate::perspective::{ALONG_K, Line, Spread, Way, square};
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::{part, part_mut, three, two};
use crate::shade::Asked;
use crate::slice::Window;

/// Rows of samples of rays that spread, of one plane.
pub(super) trait Spreads<W> {
    /// The voxel row before the samples of a row of the image.
    fn voxel_row(&self, row: u32) -> i32;
    /// Columns whose samples lie between some voxels of a row and the next ones, counted from the first.
    fn columns(&self, voxels: Range<usize>) -> Range<usize>;
    /// Makes the samples of a run of a row of the image: of some columns, counted from the first.
    fn make(&mut self, row: u32, run: Range<usize>);
    /// Those that were made last.
    fn samples(&self) -> &[W];
    /// The lengths of their steps.
    fn lengths(&self) -> &[W];
    /// Brings opacities to the lengths of their steps.
    fn lengthen(&self, opacities: &mut [W]);
    /// Gradients of a span of the run that was made last, spaced, and the unit vectors towards the eye.
    fn gradients(&mut self, span: Range<usize>, out: [&mut [W]; 3]);
    /// Those vectors.
    fn towards(&self, span: Range<usize>) -> [&[W]; 3];
}

/// A plane's rows on their way.
pub(super) struct Source<'s, 'w, P, V, A> {
    window: &'s Window<'w>,
    /// Columns of the image that have a sample.
    columns: Range<usize>,
    spread: &'s Spread,
    /// Rows of the image.
    line: Line,
    z: Weight,
    spacing: [Intensity; 3],
    rows: SpreadScratch<'s, i32>,
    /// Which voxel rows have been interpolated along z.
    z_row: [i32; 4],
    derivative_row: [usize; 2],
    /// The row that was made last, and the run of it.
    row: u32,
    run: Range<usize>,
    /// The voxel row before its samples, and the weight of the next.
    at: Cell,
    /// Columns of voxels that samples and gradients look at.
    voxels: Range<usize>,
    precision: P,
    kinds: PhantomData<(V, A)>,
}

/// A derivative row that none is.
const NONE: usize = usize::MAX;

impl<'s, 'w, P: Precision, V: Lanes, A: Asked> Source<'s, 'w, P, V, A> {
    #[inline(always)]
    pub(super) fn new(
        precision: P,
        (plan, spread, plane): (&Plan, &'s Spread, &Plane),
        [across, line]: [Line; 2],
        columns: Range<usize>,
        window: &'s Window<'w>,
        rows: SpreadScratch<'s, i32>,
    ) -> Self {
        let width = window.near.width();
        let mut slopes = rows.slopes.iter_mut();
        let places = rows.cells.iter_mut().zip(&mut *rows.weights).zip(&mut *rows.squares);
        for (column, ((place, weight), own)) in columns.clone().zip(places) {
            let at = cell(across.at(column as u32));
            let slope = spread.slope(0, column as u32);
            *place = at.index.max(0);
            *weight = cut(precision, at.weight);
            *own = square(slope);
            if let Some(place) = slopes.next() {
                *place = slope;
            }
        }
        let all = 0..columns.len();
        Self {
            window,
            voxels: voxels_about(rows.cells, all.clone(), width),
            columns,
            spread,
            line,
            z: cell(plane.z).weight,
            spacing: plan.spacing(),
            rows,
            z_row: [NO_ROW; 4],
            derivative_row: [NONE; 2],
            row: 0,
            run: all,
            at: Cell {
                index: 0,
                weight: Weight::ZERO,
            },
            precision,
            kinds: PhantomData,
        }
    }

    /// Where a voxel row's interpolation along z lies.
    #[inline(always)]
    fn slot(row: i32) -> usize {
        (row & if A::GRADIENTS { 3 } else { 1 }) as usize
    }

    /// Places of the voxels that a run looks at, with those beyond faces, in a row.
    #[inline(always)]
    fn places(&self, run: Range<usize>) -> Range<usize> {
        let width = self.window.near.width();
        let Range { start, end } = voxels_about(self.rows.cells, run, width);
        start + usize::from(start > 0)..end + 1 + usize::from(end == width)
    }

    /// Columns of a span of the run, counted from the first.
    #[inline(always)]
    fn within(&self, span: Range<usize>) -> Range<usize> {
        self.run.start + span.start..self.run.start + span.end
    }

    /// Makes the z interpolation of a voxel row; in lit scenes also of one beyond each face.
    #[inline(always)]
    fn make_z(&mut self, row: i32) {
        let slot = Self::slot(row);
        let (Some(out), Some(name)) = (self.rows.z.get_mut(slot), self.z_row.get_mut(slot)) else {
            return;
        };
        if *name == row {
            return;
        }
        *name = row;
        let (near, far) = (self.window.near, self.window.far_or_near());
        let (width, last) = (near.width(), near.height() as i32 - 1);
        let voxels = self.voxels.clone();
        let own = voxels.start + 1..voxels.end + 1;
        let edge = row.min(last).max(0);
        let of = |row: i32| {
            let (near, far) = (near.row(row as usize), far.row(row as usize));
            (part(near, voxels.clone()), part(far, voxels.clone()))
        };
        let (near_row, far_row) = of(edge);
        z_row::<P, V>(self.precision, near_row, far_row, self.z, part_mut(out, own.clone()));
        if edge != row {
            // One row beyond a face: twice the edge less the row inside it.
            let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
            let (near_row, far_row) = of(inner);
            let inner = part_mut(self.rows.inner, own.clone());
            z_row::<P, V>(self.precision, near_row, far_row, self.z, inner);
            extend_row(part_mut(out, own.clone()), part(self.rows.inner, own));
        }
        // One voxel beyond a face that the samples come near to, likewise.
        let place = |row: &[i32], place: usize| row.get(place).copied().unwrap_or(0);
        if voxels.start == 0 {
            let beyond = 2 * place(out, 1) - place(out, if width > 1 { 2 } else { 1 });
            if let Some(out) = out.first_mut() {
                *out = beyond;
            }
        }
        if voxels.end == width {
            let beyond = 2 * place(out, width) - place(out, if width > 1 { width - 1 } else { width });
            if let Some(out) = out.get_mut(width + 1) {
                *out = beyond;
            }
        }
    }

    /// Makes a voxel row's interpolation along y under a run, between it and the next, in one of three rows.
    #[inline(always)]
    fn make_y(&mut self, row: i32, number: usize, run: Range<usize>) {
        let height = self.window.near.height() as i32;
        let beyond = if A::GRADIENTS { height } else { height - 1 };
        // Behind the last row there is none; its weight is zero.
        let next = if row < beyond { row + 1 } else { row };
        V::enter((MakeZ, &mut *self, row));
        V::enter((MakeZ, &mut *self, next));
        let places = self.places(run);
        let SpreadScratch { z, y, .. } = &mut self.rows;
        let pick = |row: i32| z.get(Self::slot(row)).map_or(&[][..], |z| part(z, places.clone()));
        let (a, b) = (pick(row), pick(next));
        let Some(out) = y.get_mut(number) else { return };
        along_y::<P, V>(self.precision, [a, b], self.at.weight, part_mut(out, places.clone()));
    }

    #[inline(always)]
    fn make_row(&mut self, row: u32, run: Range<usize>) {
        (self.row, self.run, self.at) = (row, run.clone(), cell(self.line.at(row)));
        let voxel_row = self.at.index;
        V::enter((MakeY, &mut *self, voxel_row, 0, run.clone()));
        let all = 0..self.window.near.width() + 2;
        let SpreadScratch {
            y: [y, ..],
            cells,
            weights,
            squares,
            samples,
            lengths,
            ..
        } = &mut self.rows;
        let (y, cells, weights) = (part(y, all), part(cells, run.clone()), part(weights, run.clone()));
        let (squares, down) = (part(squares, run.clone()), V::splat(square(self.spread.slope(1, row))));
        let (samples, lengths) = (part_mut(samples, run.clone()), part_mut(lengths, run));
        for at in places::<V>(cells.len()) {
            let here = cells_at::<V>(cells, at);
            between::<P, V>(self.precision, y, here, 1, V::load(weights, at)).store(samples, at);
            Way::of([V::load(squares, at), down]).length().store(lengths, at);
        }
    }

    /// Makes the z interpolation of a voxel row's derivatives along z.
    #[inline(always)]
    fn make_derivatives(&mut self, row: usize) {
        let slot = row & 1;
        let (Some(out), Some(name)) = (self.rows.derivatives.get_mut(slot), self.derivative_row.get_mut(slot)) else {
            return;
        };
        if *name == row {
            return;
        }
        *name = row;
        let voxels = self.voxels.clone();
        let (near, far) = derivatives(self.window, row);
        let (near, far) = (near.columns(voxels.clone()), far.columns(voxels.clone()));
        let own = voxels.start + 1..voxels.end + 1;
        z_difference_row::<P, V>(self.precision, near, far, self.z, part_mut(out, own.clone()));
        // Read with a weight of 0 only.
        if let Some(out) = out.get_mut(own.end) {
            *out = 0;
        }
    }

    #[inline(always)]
    fn make_gradients(&mut self, span: Range<usize>, [gx, gy, gz]: [&mut [i32]; 3]) {
        let (p, at, span) = (self.precision, self.at, self.within(span));
        V::enter((MakeY, &mut *self, at.index - 1, 1, span.clone()));
        V::enter((MakeY, &mut *self, at.index + 1, 2, span.clone()));
        let last = self.window.near.height() as i32 - 1;
        let [this, next] = two([at.index, at.index + 1], |row| row.min(last).max(0) as usize);
        self.make_derivatives(this);
        self.make_derivatives(next);
        let voxels = voxels_about(self.rows.cells, span.clone(), self.window.near.width());
        let voxels = voxels.start + 1..voxels.end + 2;
        let down = self.spread.slope(1, self.row);
        let SpreadScratch {
            y: [y, above, below],
            derivatives,
            derivative,
            cells,
            weights,
            squares,
            slopes,
            towards: [ti, tj, tk],
            ..
        } = &mut self.rows;
        let pick = |row: usize| {
            derivatives
                .get(row & 1)
                .map_or(&[][..], |row| part(row, voxels.clone()))
        };
        let (a, b) = (pick(this), pick(next));
        along_y::<P, V>(p, [a, b], at.weight, part_mut(derivative, voxels.clone()));
        let all = 0..self.window.near.width() + 2;
        let [y, above, below] = three([y, above, below], |row| part(row, all.clone()));
        let derivative = part(derivative, all);
        let (cells, weights) = (part(cells, span.clone()), part(weights, span.clone()));
        let (squares, slopes) = (part(squares, span.clone()), part(slopes, span.clone()));
        let [ti, tj, tk] = three([ti, tj, tk], |row| part_mut(row, span.clone()));
        let (down, down_square) = (V::splat(down), V::splat(square(down)));
        for at in places::<V>(cells.len()) {
            let (w, here) = (V::load(weights, at), cells_at::<V>(cells, at));
            (between::<P, V>(p, y, here, 2, w) - between::<P, V>(p, y, here, 0, w)).store(gx, at);
            (between::<P, V>(p, below, here, 1, w) - between::<P, V>(p, above, here, 1, w)).store(gy, at);
            between::<P, V>(p, derivative, here, 1, w).store(gz, at);
            let way = Way::of([V::load(squares, at), down_square]);
            way.towards(V::load(slopes, at)).store(ti, at);
            way.towards(down).store(tj, at);
            way.towards(V::splat(ALONG_K)).store(tk, at);
        }
        spaced::<P, V>(p, [gx, gy, gz], self.spacing);
    }
}

/// Columns of voxels that samples and gradients of a run look at, of so many.
#[inline(always)]
fn voxels_about(cells: &[i32], run: Range<usize>, width: usize) -> Range<usize> {
    let cells = part(cells, run);
    let [first, last] = two([cells.first(), cells.last()], |cell| {
        cell.copied().unwrap_or(0) as usize
    });
    first.saturating_sub(1)..(last + 3).min(width)
}

/// The first of the cells `at ..`, and how far behind it they lie: pixels are at most a voxel apart, and what is behind the
/// last cell is not stored.
#[inline(always)]
fn cells_at<V: Lanes>(cells: &[i32], at: usize) -> (usize, V) {
    let first = cells.get(at).copied().unwrap_or(0);
    (first as usize, V::load(cells, at).wrapping_sub(V::splat(first)))
}

/// x interpolation between the places `beside` those of cells and the next ones.
#[inline(always)]
fn between<P: Precision, V: Lanes>(p: P, row: &[i32], (first, offsets): (usize, V), beside: usize, w: V) -> V {
    let place = first + beside;
    let (a, b) = (V::picked(row, place, offsets), V::picked(row, place + 1, offsets));
    lerp_x(p, a, b, w)
}

/// y interpolation between two rows.
#[inline(always)]
fn along_y<P: Precision, V: Lanes>(p: P, [a, b]: [&[i32]; 2], weight: Weight, out: &mut [i32]) {
    let w = V::splat(cut(p, weight));
    for at in places::<V>(out.len()) {
        lerp_y::<P, V, false>(p, V::load(a, at), V::load(b, at), w).store(out, at);
    }
}

impl<P: Precision, V: Lanes, A: Asked> Spreads<i32> for Source<'_, '_, P, V, A> {
    #[inline(always)]
    fn voxel_row(&self, row: u32) -> i32 {
        cell(self.line.at(row)).index
    }

    #[inline(always)]
    fn columns(&self, voxels: Range<usize>) -> Range<usize> {
        let cells = part(self.rows.cells, 0..self.columns.len());
        let from = |voxel: usize| cells.partition_point(|cell| (*cell as usize) < voxel);
        from(voxels.start)..from(voxels.end)
    }

    #[inline(always)]
    fn make(&mut self, row: u32, run: Range<usize>) {
        V::enter((MakeRow, self, row, run));
    }

    #[inline(always)]
    fn samples(&self) -> &[i32] {
        part(self.rows.samples, self.run.clone())
    }

    #[inline(always)]
    fn lengths(&self) -> &[i32] {
        part(self.rows.lengths, 0..self.columns.len())
    }

    #[inline(always)]
    fn lengthen(&self, opacities: &mut [i32]) {
        let lengths = part(self.rows.lengths, self.run.clone());
        V::enter((Lengthen, PhantomData::<V>, opacities, lengths));
    }

    #[inline(always)]
    fn gradients(&mut self, span: Range<usize>, out: [&mut [i32]; 3]) {
        // Unlit pipelines have no such code.
        if A::GRADIENTS {
            V::enter((MakeGradients, self, span, out));
        }
    }

    #[inline(always)]
    fn towards(&self, span: Range<usize>) -> [&[i32]; 3] {
        let span = self.within(span);
        three(self.rows.towards.each_ref(), |row| part(row, span.clone()))
    }
}

struct MakeZ;

impl<P: Precision, V: Lanes, A: Asked> Kernel for (MakeZ, &mut Source<'_, '_, P, V, A>, i32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row) = self;
        source.make_z(row);
    }
}

struct MakeY;

impl<P: Precision, V: Lanes, A: Asked> Kernel for (MakeY, &mut Source<'_, '_, P, V, A>, i32, usize, Range<usize>) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row, number, run) = self;
        source.make_y(row, number, run);
    }
}

struct MakeRow;

impl<P: Precision, V: Lanes, A: Asked> Kernel for (MakeRow, &mut Source<'_, '_, P, V, A>, u32, Range<usize>) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row, run) = self;
        source.make_row(row, run);
    }
}

struct MakeGradients;

impl<P: Precision, V: Lanes, A: Asked> Kernel
    for (
        MakeGradients,
        &mut Source<'_, '_, P, V, A>,
        Range<usize>,
        [&mut [i32]; 3],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, span, out) = self;
        source.make_gradients(span, out);
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
