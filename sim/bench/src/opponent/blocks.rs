//! The blocks of a tile that can be seen, as `slicecast::plane` goes through them: samples straight from the voxels, a vector
//! at a time, in batches from many rows; those that are visible lie side by side before they are coloured and shaded.

use std::marker::PhantomData;

use slicecast::lanes::Kernel;
use slicecast::seen::Seen;
use slicecast::slice::Window;

use super::rows::{Pixels, normal, over, slope_at};
use super::tile::{FoldTile, Meeting, slopes};
use super::{Opponent, run_len};
use slicecast_engine::simd::floats::Floats;

/// Samples of a batch.
const SAMPLES: usize = 1024;
/// Behind them: a vector may be written from the last one on.
const ROOM: usize = SAMPLES + 16;

/// A vector of samples.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// Row of the tile.
    row: usize,
    /// Column of the volume.
    column: usize,
    /// How many of its lanes lie in its block and in the image.
    lanes: usize,
}

/// Memory of a batch.
pub(super) struct Batch {
    places: Vec<Place>,
    samples: Vec<f32>,
    codes: Vec<i32>,
    opacities: Vec<f32>,
    colours: [Vec<f32>; 3],
    normals: [Vec<f32>; 3],
}

impl Batch {
    pub(super) fn new() -> Self {
        let row = || vec![0.0; ROOM];
        Self {
            places: Vec::with_capacity(SAMPLES),
            samples: row(),
            codes: vec![0; ROOM],
            opacities: row(),
            colours: [row(), row(), row()],
            normals: [row(), row(), row()],
        }
    }
}

/// The voxels around the samples of a plane.
struct Around<'m, 'w> {
    meeting: &'m Meeting,
    window: &'m Window<'w>,
}

impl Around<'_, '_> {
    /// z interpolation from a column of a voxel row on.
    #[inline(always)]
    fn z<F: Floats>(&self, row: usize, column: usize) -> F {
        let [_, _, weight] = self.meeting.weights;
        let near = F::load_voxels(self.window.near.row(row), column);
        if weight == 0.0 {
            return near;
        }
        near.towards(
            F::load_voxels(self.window.far_or_near().row(row), column),
            F::splat(weight),
        )
    }

    /// The same from a column that may be one before the slice, and up to one behind it: the volume is continued linearly.
    #[inline(always)]
    fn z_across<F: Floats>(&self, row: usize, column: i32) -> F {
        let Meeting { width, .. } = *self.meeting;
        let mut lanes = [0.0; 17];
        let inner = usize::from(width > 1);
        if column < 0 {
            lanes[0] = 2.0 * self.z_of::<F>(row, 0) - self.z_of::<F>(row, inner);
            self.z::<F>(row, 0).store(&mut lanes, 1);
            return F::load(&lanes, 0);
        }
        let here = self.z::<F>(row, column as usize);
        let behind = width - (column as usize).min(width);
        if behind >= F::COUNT {
            return here;
        }
        here.store(&mut lanes, 0);
        lanes[behind] = 2.0 * self.z_of::<F>(row, width - 1) - self.z_of::<F>(row, width - 1 - inner);
        F::load(&lanes, 0)
    }

    /// z interpolation of one voxel, by the same operations.
    #[inline(always)]
    fn z_of<F: Floats>(&self, row: usize, column: usize) -> f32 {
        let mut lanes = [0.0; 16];
        self.z::<F>(row, column).store(&mut lanes, 0);
        lanes[0]
    }

    /// z interpolation from a column of a voxel row on; both may be one beside the slice.
    #[inline(always)]
    fn z_beside<F: Floats>(&self, row: i32, column: i32) -> F {
        let last = self.meeting.height - 1;
        let edge = row.clamp(0, last);
        let across = |row: i32| F::enter(Across(self, row as usize, column, PhantomData::<F>));
        let here = across(edge);
        if edge == row {
            return here;
        }
        let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
        here + here - across(inner)
    }

    /// The samples at a place between voxel row `row` and the next.
    #[inline(always)]
    fn samples<F: Floats>(&self, row: i32, column: usize) -> F {
        let [wx, wy, _] = self.meeting.weights.map(F::splat);
        let [a, b] = self.meeting.voxel_rows(row);
        let here = self.z::<F>(a, column).towards(self.z(b, column), wy);
        let next = self.z::<F>(a, column + 1).towards(self.z(b, column + 1), wy);
        here.towards(next, wx)
    }

    /// y interpolation between voxel row `row` and the next, from a column on.
    #[inline(always)]
    fn zy<F: Floats>(&self, row: i32, column: i32) -> F {
        let [_, wy, _] = self.meeting.weights;
        let a = self.z_beside::<F>(row, column);
        a.towards(self.z_beside(row + 1, column), F::splat(wy))
    }

    /// y and x interpolation of the derivatives along z.
    #[inline(always)]
    fn slope<F: Floats>(&self, row: i32, column: usize) -> F {
        let ([a, b], [wx, wy, wz]) = (self.meeting.voxel_rows(row), self.meeting.weights);
        let columns = column..(column + F::COUNT + 1).min(self.meeting.width);
        let [near, far] = slopes(self.window, a, &columns);
        let [near_next, far_next] = slopes(self.window, b, &columns);
        let wy = F::splat(wy);
        let here = slope_at::<F>(near, far, wz, 0).towards(slope_at(near_next, far_next, wz, 0), wy);
        let next = slope_at::<F>(near, far, wz, 1).towards(slope_at(near_next, far_next, wz, 1), wy);
        here.towards(next, F::splat(wx))
    }

    /// y interpolation between consecutive voxel rows around a place inside the slice: along it, and beside it in both directions.
    #[inline(always)]
    fn around<F: Floats>(&self, row: usize, column: usize) -> Beside<F> {
        let [wx, wy, wz] = self.meeting.weights.map(F::splat);
        let far = self.window.far_or_near();
        let rows = |row: usize| [self.window.near.row(row), far.row(row)];
        let [before, here, next, behind] = [rows(row - 1), rows(row), rows(row + 1), rows(row + 2)];
        let still = self.meeting.weights[2] == 0.0;
        let [h0, h1] = [
            z_of_rows::<F>(here, column, wz, still),
            z_of_rows(here, column + 1, wz, still),
        ];
        let [n0, n1] = [
            z_of_rows::<F>(next, column, wz, still),
            z_of_rows(next, column + 1, wz, still),
        ];
        let left = z_of_rows::<F>(here, column - 1, wz, still).towards(z_of_rows(next, column - 1, wz, still), wy);
        let right = z_of_rows::<F>(here, column + 2, wz, still).towards(z_of_rows(next, column + 2, wz, still), wy);
        let [b0, b1] = [
            z_of_rows::<F>(before, column, wz, still),
            z_of_rows(before, column + 1, wz, still),
        ];
        let [e0, e1] = [
            z_of_rows::<F>(behind, column, wz, still),
            z_of_rows(behind, column + 1, wz, still),
        ];
        let (c0, c1) = (h0.towards(n0, wy), h1.towards(n1, wy));
        Beside {
            left: left.towards(c0, wx),
            right: c1.towards(right, wx),
            previous: b0.towards(h0, wy).towards(b1.towards(h1, wy), wx),
            next: n0.towards(e0, wy).towards(n1.towards(e1, wy), wx),
        }
    }

    /// The same at a face.
    #[inline(always)]
    fn around_at_face<F: Floats>(&self, row: i32, column: i32) -> Beside<F> {
        let wx = F::splat(self.meeting.weights[0]);
        let (here, right, next) = (self.zy::<F>(row, column), self.zy::<F>(row, column + 1), column + 1);
        Beside {
            left: self.zy::<F>(row, column - 1).towards(here, wx),
            right: right.towards(self.zy(row, column + 2), wx),
            previous: self.zy::<F>(row - 1, column).towards(self.zy(row - 1, next), wx),
            next: self.zy::<F>(row + 1, column).towards(self.zy(row + 1, next), wx),
        }
    }

    /// Their normals.
    #[inline(always)]
    fn normals<F: Floats>(&self, spacing: Option<[f32; 3]>, row: i32, place: Place) -> [F; 3] {
        let Meeting { width, height, .. } = *self.meeting;
        let inside = row >= 1 && row + 2 < height && place.column >= 1 && place.column + place.lanes + 1 < width;
        let beside = if inside {
            self.around::<F>(row as usize, place.column)
        } else {
            F::enter(AtFace(self, row, place.column as i32, PhantomData::<F>))
        };
        let x = beside.left - beside.right;
        let y = beside.previous - beside.next;
        let z = self.slope::<F>(row, place.column);
        match spacing {
            None => normal::<F, true>([x, y, z], [F::splat(1.0); 3]),
            Some([fx, fy, fz]) => normal::<F, false>([x, y, z], [F::splat(fx), F::splat(fy), F::splat(fz)]),
        }
    }
}

/// z interpolation across the ends of a row.
struct Across<'a, 'm, 'w, F>(&'a Around<'m, 'w>, usize, i32, PhantomData<F>);

impl<F: Floats> Kernel for Across<'_, '_, '_, F> {
    type Output = F;

    #[inline(always)]
    fn run(self) -> F {
        self.0.z_across(self.1, self.2)
    }
}

/// Samples beside those of a place at a face.
struct AtFace<'a, 'm, 'w, F>(&'a Around<'m, 'w>, i32, i32, PhantomData<F>);

impl<F: Floats> Kernel for AtFace<'_, '_, '_, F> {
    type Output = Beside<F>;

    #[inline(always)]
    fn run(self) -> Beside<F> {
        self.0.around_at_face(self.1, self.2)
    }
}

/// A batch to be folded.
struct FoldBatch<'a, 't, 's, 'w, F, const LIT: bool>(
    &'a mut FoldTile<'t, 's>,
    &'a Meeting,
    &'a Window<'w>,
    PhantomData<F>,
);

impl<F: Floats, const LIT: bool> Kernel for FoldBatch<'_, '_, '_, '_, F, LIT> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.fold_batch::<F, LIT>(self.1, self.2);
    }
}

/// Samples beside those of a place.
struct Beside<F> {
    left: F,
    right: F,
    previous: F,
    next: F,
}

/// z interpolation between two rows of voxels, from a column on; `still`: the first alone.
#[inline(always)]
fn z_of_rows<F: Floats>([near, far]: [&[u16]; 2], column: usize, weight: F, still: bool) -> F {
    let near = F::load_voxels(near, column);
    if still {
        return near;
    }
    near.towards(F::load_voxels(far, column), weight)
}

impl FoldTile<'_, '_> {
    /// Folds the blocks of a plane that can be seen.
    #[inline(always)]
    pub(super) fn fold_blocks<F: Floats, const LIT: bool>(
        &mut self,
        meeting: &Meeting,
        window: &Window<'_>,
        seen: Seen<'_>,
    ) {
        let run = run_len(self.plan);
        let inside = meeting.voxel..meeting.voxel + meeting.columns.len();
        let block = seen.grain().columns();
        self.batch.places.clear();
        for row in 0..self.tile.rows as usize {
            let number = self.tile.first + row as u32;
            if !meeting.rows.contains(&number) {
                continue;
            }
            let mut blocks = seen.row((number as i32 + meeting.y.index) as usize);
            while blocks != 0 {
                let first = block * blocks.trailing_zeros() as usize;
                blocks &= blocks - 1;
                let end = (first + block).min(inside.end);
                for column in (first.max(inside.start)..end).step_by(F::COUNT) {
                    let pixel = meeting.columns.start + column - inside.start;
                    if F::load(&self.data[(4 * row + 3) * run..][..run], pixel).any_positive() {
                        let lanes = F::COUNT.min(end - column);
                        self.batch.places.push(Place { row, column, lanes });
                    }
                    if self.batch.places.len() == SAMPLES / F::COUNT {
                        F::enter(FoldBatch::<F, LIT>(self, meeting, window, PhantomData));
                    }
                }
            }
        }
        F::enter(FoldBatch::<F, LIT>(self, meeting, window, PhantomData));
    }

    /// Folds the places of a batch, and empties it.
    #[inline(always)]
    fn fold_batch<F: Floats, const LIT: bool>(&mut self, meeting: &Meeting, window: &Window<'_>) {
        let Opponent {
            table,
            phong,
            spacing,
            floor,
            ..
        } = self.opponent;
        let Batch {
            places,
            samples,
            codes,
            opacities,
            colours,
            normals,
        } = &mut *self.batch;
        let around = Around { meeting, window };
        let (run, first) = (run_len(self.plan), self.tile.first as i32 + meeting.y.index);
        for (place, at) in places.iter().zip((0..).step_by(F::COUNT)) {
            let here = around.samples::<F>(first + place.row as i32, place.column);
            here.store(samples, at);
        }
        let made = places.len() * F::COUNT;
        table.opacity_row::<F>(&samples[..made], codes, &mut opacities[..made]);

        // Places with a visible sample, and visible samples.
        let (mut kept, mut packed) = (0, 0);
        for number in 0..places.len() {
            let (place, at) = (places[number], number * F::COUNT);
            opacities[at + place.lanes..at + F::COUNT].fill(0.0);
            let pixel = meeting.columns.start + place.column - meeting.voxel;
            let transparency = F::load(&self.data[(4 * place.row + 3) * run..][..run], pixel);
            let opacity = F::load(opacities, at);
            let visible = (opacity * transparency).positive_then(opacity);
            if visible.any_positive() {
                F::load(samples, at).packed(visible).store(samples, packed);
                packed += visible.count_positive();
                visible.store(opacities, kept * F::COUNT);
                places[kept] = place;
                kept += 1;
            }
        }
        places.truncate(kept);
        let padded = packed.next_multiple_of(F::COUNT);

        let [cr, cg, cb] = colours.each_mut().map(|row| &mut row[..padded]);
        if !table.one_colour {
            table.colour_row::<F>(&samples[..padded], codes, [&mut *cr, &mut *cg, &mut *cb]);
        } else {
            for (row, colour) in [&mut *cr, &mut *cg, &mut *cb].into_iter().zip(table.first_colour()) {
                row.fill(colour);
            }
        }
        if let (true, Some(phong)) = (LIT, phong) {
            let [nx, ny, nz] = normals;
            let mut from = 0;
            for (place, at) in places.iter().zip((0..).step_by(F::COUNT)) {
                let visible = F::load(opacities, at);
                let [x, y, z] = around.normals::<F>(*spacing, first + place.row as i32, *place);
                x.packed(visible).store(nx, from);
                y.packed(visible).store(ny, from);
                z.packed(visible).store(nz, from);
                from += visible.count_positive();
            }
            for at in (0..padded).step_by(F::COUNT) {
                let normal = [F::load(nx, at), F::load(ny, at), F::load(nz, at)];
                let colour = [F::load(cr, at), F::load(cg, at), F::load(cb, at)];
                let [r, g, b] = phong.shade(normal, colour);
                r.store(cr, at);
                g.store(cg, at);
                b.store(cb, at);
            }
        }
        let mut from = 0;
        for (place, at) in places.iter().zip((0..).step_by(F::COUNT)) {
            let opacity = F::load(opacities, at);
            let colour = [
                F::load(cr, from).spread(opacity),
                F::load(cg, from).spread(opacity),
                F::load(cb, from).spread(opacity),
            ];
            from += opacity.count_positive();
            let mut runs = self.data[4 * place.row * run..][..4 * run].chunks_exact_mut(run);
            let [r, g, b, t] = [(); 4].map(|()| runs.next().unwrap_or(&mut []));
            let mut pixels: Pixels<'_> = [r, g, b, t];
            let pixel = meeting.columns.start + place.column - meeting.voxel;
            over(colour, opacity, &mut pixels, pixel, *floor);
        }
        places.clear();
    }
}
