//! A tile of the base plane on its way through all planes, as `slicecast::plane` does it: rows that show nothing and
//! rows whose rays are finished are skipped, and gradients are made for visible spans only.

use std::marker::PhantomData;
use std::ops::Range;

use slicecast::classify::Support;
use slicecast::format::Weight;
use slicecast::lanes::Kernel;
use slicecast::locate::{Cell, cell, inside, plane};
use slicecast::plan::Plan;
use slicecast::slice::{RowRange, Slice, Window};

use super::blocks::Batch;
use super::rows::*;
use super::{Opponent, run_len};
use slicecast_engine::occupancy::Sight;
use slicecast_engine::simd::floats::{Floats, OverFloats};
use slicecast_engine::simd::prefetch;
use slicecast_engine::tile::Tile;
use slicecast_engine::tiles::AHEAD;

/// Folds all planes into a tile.
pub(super) struct FoldTile<'a, 's> {
    pub opponent: &'a Opponent,
    pub plan: &'a Plan,
    pub slices: &'a [Slice<'s>],
    pub tile: Tile,
    pub data: &'a mut [f32],
    pub scratch: &'a mut [f32],
    /// A row of scratch memory for codes.
    pub codes: &'a mut [i32],
    /// The blocks that can be seen; none: rows are made as a whole.
    pub seen: Option<&'a Sight>,
    pub batch: &'a mut Batch,
}

/// Rows of scratch memory.
pub(super) const SCRATCH_ROWS: usize = 2 + 2 + 1 + 3 + 1 + 3 + 3;

/// Where a plane meets the image.
pub(super) struct Meeting {
    pub y: Cell,
    pub columns: Range<usize>,
    pub rows: Range<u32>,
    /// Column of the volume under the first of `columns`.
    pub voxel: usize,
    pub width: usize,
    pub height: i32,
    /// Along x, y, z.
    pub weights: [f32; 3],
}

impl Meeting {
    /// The voxel rows around a row of samples.
    pub(super) fn voxel_rows(&self, row: i32) -> [usize; 2] {
        [row, row + 1].map(|row| row.clamp(0, self.height - 1) as usize)
    }

    /// The columns of a row that samples and their neighbours need, whole vectors before and behind.
    fn places(&self) -> Range<usize> {
        let first = FIRST + self.voxel - 1;
        first / FIRST * FIRST..FIRST + self.voxel + self.columns.len() + 1
    }
}

/// Rows of samples of one plane, made when asked for and kept while their neighbours may need them.
struct Sampler<'s> {
    z: [&'s mut [f32]; 2],
    z_row: [i32; 2],
    inner: &'s mut [f32],
    samples: [&'s mut [f32]; 3],
    sample_row: [i32; 3],
    slopes: [&'s mut [f32]; 2],
    slopes_made: [(usize, Range<usize>); 2],
}

/// A row number that no row has.
const NO_ROW: i32 = i32::MIN;

impl Sampler<'_> {
    fn slot(row: i32) -> usize {
        (row + 1).rem_euclid(3) as usize
    }

    /// Makes the samples between voxel rows `row` and `row + 1`; `LIT` may ask for one row beyond each face.
    #[inline(always)]
    fn make<F: Floats, const LIT: bool>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        if self.sample_row[Self::slot(row)] == row {
            return;
        }
        if LIT {
            // Called from three places.
            F::enter(Make {
                sampler: self,
                meeting,
                window,
                row,
                lanes: PhantomData::<F>,
            });
        } else {
            self.make_anew::<F, false>(meeting, window, row);
        }
    }

    #[inline(always)]
    fn make_anew<F: Floats, const LIT: bool>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        let slot = Self::slot(row);
        let beyond = if LIT { meeting.height } else { meeting.height - 1 };
        let next = if row < beyond { row + 1 } else { row };
        let places = meeting.places();
        let [wx, wy, wz] = meeting.weights;
        self.sample_row[slot] = row;
        if !LIT && wz == 0.0 {
            let [a, b] = [row, next].map(|row| window.near.row(row as usize));
            let voxels = FIRST..FIRST + meeting.width.next_multiple_of(F::COUNT);
            yx_row::<F>(a, b, [wx, wy], &mut self.samples[slot][voxels]);
            return;
        }
        self.make_z::<F, LIT>(meeting, window, row);
        self.make_z::<F, LIT>(meeting, window, next);
        let [even, odd] = &self.z;
        let pick = |row: i32| if row & 1 == 0 { even } else { odd };
        let (a, b) = (&pick(row)[places.start..], &pick(next)[places.start..]);
        yx_row::<F>(a, b, [wx, wy], &mut self.samples[slot][places]);
    }

    /// Makes the z interpolation of a voxel row.
    #[inline(always)]
    fn make_z<F: Floats, const LIT: bool>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        let index = (row & 1) as usize;
        if self.z_row[index] == row {
            return;
        }
        self.z_row[index] = row;
        let out = &mut *self.z[index];
        let far = window.far_or_near();
        let last = meeting.height - 1;
        let edge = row.clamp(0, last);
        let [_, _, wz] = meeting.weights;
        let (near_row, far_row) = (window.near.row(edge as usize), far.row(edge as usize));
        z_row::<F>(near_row, far_row, wz, &mut out[FIRST..]);
        if LIT {
            if edge != row {
                let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) } as usize;
                z_row::<F>(window.near.row(inner), far.row(inner), wz, &mut self.inner[FIRST..]);
                extend_row::<F>(&mut out[FIRST..], &self.inner[FIRST..]);
            }
            extend_ends(out, meeting.width);
        }
    }

    /// Makes some columns of the z interpolation of a voxel row's derivatives along z.
    #[inline(always)]
    fn make_slopes<F: Floats>(&mut self, meeting: &Meeting, window: &Window<'_>, row: usize, columns: &Range<usize>) {
        let made = &mut self.slopes_made[row & 1];
        if made.0 == row && made.1.start <= columns.start && columns.end <= made.1.end {
            return;
        }
        *made = (row, columns.clone());
        let [near, far] = slopes(window, row, columns);
        let out = &mut self.slopes[row & 1][FIRST + columns.start..];
        z_slope_row::<F>(near, far, meeting.weights[2], out);
    }
}

/// Samples of a lit row to be made.
struct Make<'a, 's, 'w, F> {
    sampler: &'a mut Sampler<'s>,
    meeting: &'a Meeting,
    window: &'a Window<'w>,
    row: i32,
    lanes: PhantomData<F>,
}

impl<F: Floats> Kernel for Make<'_, '_, '_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.sampler.make_anew::<F, true>(self.meeting, self.window, self.row);
    }
}

/// Derivatives along z at the slices before and behind a plane, for columns of a voxel row.
pub(super) fn slopes<'a>(window: &Window<'a>, row: usize, columns: &Range<usize>) -> [Slope<'a>; 2] {
    let of = |scale, behind: Slice<'a>, before: Slice<'a>| {
        let columns = columns.clone();
        Slope(scale, &behind.row(row)[columns.clone()], &before.row(row)[columns])
    };
    let near = match (window.before, window.far) {
        (Some(before), Some(far)) => of(1.0, far, before),
        (None, Some(far)) => of(2.0, far, window.near),
        (Some(before), None) => of(2.0, window.near, before),
        (None, None) => of(0.0, window.near, window.near),
    };
    let far = match (window.far, window.after) {
        (Some(_), Some(after)) => of(1.0, after, window.near),
        (Some(far), None) => of(2.0, far, window.near),
        (None, _) => near,
    };
    [near, far]
}

/// Whether samples between these voxel rows can be visible.
fn meets(support: Support, window: &Window<'_>, [row, next]: [usize; 2]) -> bool {
    let far = window.far_or_near();
    let range = |s: &Slice<'_>| -> RowRange { s.range(row).union(s.range(next)) };
    support.meets(range(&window.near).union(range(&far)))
}

#[inline(always)]
fn any_visible<F: Floats>(opacities: &[f32], transparencies: &[f32], at: usize) -> bool {
    (F::load(opacities, at) * F::load(transparencies, at)).any_positive()
}

/// The next span of visible samples at or after `from`, in whole vectors.
#[inline(always)]
fn visible_span<F: Floats>(opacities: &[f32], transparencies: &[f32], from: usize) -> Option<Range<usize>> {
    let mut start = from;
    while start < opacities.len() && !any_visible::<F>(opacities, transparencies, start) {
        start += F::COUNT;
    }
    let mut end = start;
    while end < opacities.len() && any_visible::<F>(opacities, transparencies, end) {
        end += F::COUNT;
    }
    (start < end).then_some(start..end)
}

/// Whether all rays of a row are finished.
#[inline(always)]
fn all_finished<F: Floats>(transparencies: &[f32]) -> bool {
    for at in (0..transparencies.len()).step_by(F::COUNT) {
        if F::load(transparencies, at).any_positive() {
            return false;
        }
    }
    true
}

impl OverFloats for FoldTile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Floats>(mut self) {
        self.walk::<F, false>();
    }
}

/// A tile of blocks, compiled apart: with both in one function the rows of dense volumes were 4 to 9 % slower.
pub(super) struct FoldBlocks<'a, 's>(pub FoldTile<'a, 's>);

impl OverFloats for FoldBlocks<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Floats>(mut self) {
        self.0.walk::<F, true>();
    }
}

impl FoldTile<'_, '_> {
    /// Goes through all planes.
    #[inline(always)]
    fn walk<F: Floats, const BLOCKS: bool>(&mut self) {
        let slices = self.slices;
        let slice = |z: i32| usize::try_from(z).ok().and_then(|z| slices.get(z)).copied();
        let mut ahead = None;
        for index in 0..self.plan.planes() {
            let plane = plane(self.plan, self.plan.phase(self.tile.phase), index);
            let (x, y, z) = (cell(plane.x), cell(plane.y), cell(plane.z));
            if ahead != Some(z.index) {
                ahead = Some(z.index);
                if let Some(slice) = slice(z.index + AHEAD) {
                    let first = (i64::from(self.tile.first) + i64::from(y.index)).max(0) as usize;
                    for row in first..first + self.tile.rows as usize + 1 {
                        prefetch(slice.row(row));
                    }
                }
            }
            if BLOCKS && index % FINISHED_EVERY == 0 && self.finished::<F>() {
                break;
            }
            let Some(window) = Window::at(z.index, slice) else {
                continue;
            };
            let [width, height, _] = self.plan.dims();
            let [base_width, base_height] = self.plan.base();
            let columns = inside(x, width, base_width);
            let weight = |w: Weight| w.to_bits() as f32 / 65536.0;
            let meeting = Meeting {
                y,
                voxel: (i64::from(columns.start) + i64::from(x.index)).max(0) as usize,
                columns: columns.start as usize..columns.end as usize,
                rows: inside(y, height, base_height),
                width: width as usize,
                height: height as i32,
                weights: [weight(x.weight), weight(y.weight), weight(z.weight)],
            };
            if meeting.columns.is_empty() {
                continue;
            }
            let seen = self.seen.filter(|_| BLOCKS).map(|seen| seen.at(z.index as usize));
            match (seen, self.opponent.phong.is_some()) {
                (Some(seen), true) => self.fold_blocks::<F, true>(&meeting, &window, seen),
                (Some(seen), false) => self.fold_blocks::<F, false>(&meeting, &window, seen),
                (None, true) => self.fold_plane::<F, true>(&meeting, &window),
                (None, false) => self.fold_plane::<F, false>(&meeting, &window),
            }
        }
    }
}

/// After how many planes a tile of blocks is asked whether its rays are all finished.
const FINISHED_EVERY: u32 = 16;

impl FoldTile<'_, '_> {
    /// Whether all rays of the tile are finished.
    #[inline(always)]
    fn finished<F: Floats>(&self) -> bool {
        let (run, [width, _]) = (run_len(self.plan), self.plan.base());
        for row in self.data.chunks_exact(4 * run) {
            if !all_finished::<F>(&row[3 * run..][..width as usize]) {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn fold_plane<F: Floats, const LIT: bool>(&mut self, meeting: &Meeting, window: &Window<'_>) {
        let Opponent {
            table, phong, floor, ..
        } = self.opponent;
        let n = meeting.columns.len();
        let padded = n.next_multiple_of(F::COUNT);
        let run = run_len(self.plan);
        let mut rows = self.scratch.chunks_exact_mut(row_len(meeting.width));
        let mut row = || rows.next().unwrap_or(&mut []);
        let mut sampler = Sampler {
            z: [row(), row()],
            z_row: [NO_ROW; 2],
            inner: row(),
            samples: [row(), row(), row()],
            sample_row: [NO_ROW; 3],
            slopes: [row(), row()],
            slopes_made: [(0, 0..0), (0, 0..0)],
        };
        let (opacities, mut colours, mut normals) = (row(), [row(), row(), row()], [row(), row(), row()]);
        if LIT && table.one_colour {
            for (row, colour) in colours.iter_mut().zip(table.first_colour()) {
                row[..padded].fill(colour);
            }
        }
        let numbered = (self.tile.first..).zip(self.data.chunks_exact_mut(4 * run));
        for (number, data) in numbered.filter(|(number, _)| meeting.rows.contains(number)) {
            let voxel_row = number as i32 + meeting.y.index;
            let mut runs = data.chunks_exact_mut(run);
            let mut pixels = || {
                runs.next()
                    .unwrap_or(&mut [])
                    .get_mut(meeting.columns.start..)
                    .unwrap_or(&mut [])
            };
            let mut pixels: Pixels<'_> = [pixels(), pixels(), pixels(), pixels()];
            if all_finished::<F>(&pixels[3][..n]) || !meets(table.support, window, meeting.voxel_rows(voxel_row)) {
                continue;
            }
            sampler.make::<F, LIT>(meeting, window, voxel_row);
            let place = FIRST + meeting.voxel;
            let samples = &sampler.samples[Sampler::slot(voxel_row)][place..place + padded];
            table.opacity_row::<F>(samples, self.codes, &mut opacities[..padded]);
            opacities[n..padded].fill(0.0);

            if !LIT && table.one_colour {
                fold_one_colour_row::<F>(table.first_colour(), &opacities[..padded], &mut pixels, *floor);
                continue;
            }

            let mut from = 0;
            while let Some(span) = visible_span::<F>(&opacities[..padded], pixels[3], from) {
                from = span.end;
                let length = span.len();
                let samples = &sampler.samples[Sampler::slot(voxel_row)][place + span.start..place + span.end];
                let [cr, cg, cb] = colours.each_mut().map(|c| &mut c[..length]);
                if !table.one_colour {
                    table.colour_row::<F>(samples, self.codes, [&mut *cr, &mut *cg, &mut *cb]);
                }
                let colours = [&*cr, &*cg, &*cb];
                let opacities = &opacities[span.clone()];
                let mut pixels = pixels.each_mut().map(|p| &mut p[span.clone()]);
                if let (true, Some(phong)) = (LIT, phong) {
                    let normals = normals.each_mut().map(|row| &mut row[..length]);
                    let [nx, ny, nz] = normals;
                    make_normals::<F>(
                        self.opponent,
                        &mut sampler,
                        meeting,
                        window,
                        voxel_row,
                        &span,
                        [&mut *nx, &mut *ny, &mut *nz],
                    );
                    shade_and_fold_row::<F>(phong, [nx, ny, nz], colours, opacities, &mut pixels, *floor);
                } else {
                    fold_row::<F>(colours, opacities, &mut pixels, *floor);
                }
            }
        }
    }
}

/// Normals of a span of samples of a row.
#[inline(always)]
fn make_normals<F: Floats>(
    opponent: &Opponent,
    sampler: &mut Sampler<'_>,
    meeting: &Meeting,
    window: &Window<'_>,
    row: i32,
    span: &Range<usize>,
    out: [&mut [f32]; 3],
) {
    sampler.make::<F, true>(meeting, window, row - 1);
    sampler.make::<F, true>(meeting, window, row + 1);
    let first = meeting.voxel + span.start;
    let columns = first..(first + span.len() + 1).min(meeting.width);
    let [this, next] = meeting.voxel_rows(row);
    sampler.make_slopes::<F>(meeting, window, this, &columns);
    sampler.make_slopes::<F>(meeting, window, next, &columns);
    let place = FIRST + first;
    let samples = |row: i32, from: usize| &sampler.samples[Sampler::slot(row)][from..];
    let [wx, wy, _] = meeting.weights;
    let around = Around {
        left: samples(row, place - 1),
        right: samples(row, place + 1),
        previous: samples(row - 1, place),
        next: samples(row + 1, place),
        slopes: [this, next].map(|row| &sampler.slopes[row & 1][place..]),
        weights: [wx, wy],
        spacing: opponent.spacing,
    };
    normal_row::<F>(&around, out);
}
