//! Compositing of the blocks that can be seen, for planes that show little.
//!
//! Short spans make short loops, whose ends a processor guesses wrong and whose chains of operations it waits for. So a
//! batch of blocks from many rows goes through one stage after the other: which rays are not finished, samples and
//! opacities, gradients; the visible samples of all of them are packed side by side for colours, normals and shading, and
//! spread again for compositing.

use super::composite::Composite;
use super::meeting::Meeting;
use super::probe::Probe;
use super::{ChannelOf, Rows};
use crate::classify::Classifier;
use crate::composite::{Channel, Dither, Order, PixelRow, fold_at};
use crate::gradient::{coarsen_row, space_row};
use crate::lanes::Lanes;
use crate::locate::Plane;
use crate::normalise::normalise_row;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::{part, part_mut, take};
use crate::seen::Seen;
use crate::shade::Shader;
use crate::slice::Window;

/// Samples of a batch.
const BATCH: usize = 1024;

/// Words of scratch memory: two lists of places and nine rows.
pub(super) const SCRATCH: usize = 11 * BATCH;

/// Vectors of a plane: the row that each lies in and its first column in the volume.
struct Places<'s> {
    rows: &'s mut [i32],
    columns: &'s mut [i32],
}

impl Places<'_> {
    #[inline(always)]
    fn set(&mut self, number: usize, (row, column): (usize, usize)) {
        if let (Some(r), Some(c)) = (self.rows.get_mut(number), self.columns.get_mut(number)) {
            (*r, *c) = (row as i32, column as i32);
        }
    }

    #[inline(always)]
    fn get(&self, number: usize) -> (usize, usize) {
        match (self.rows.get(number), self.columns.get(number)) {
            (Some(row), Some(column)) => (*row as usize, *column as usize),
            _ => (0, 0),
        }
    }
}

/// The way through the blocks of some rows, vector by vector.
struct Walk<'a> {
    seen: Seen<'a>,
    meeting: &'a Meeting,
    /// Number of the first row in the image.
    first: u32,
    /// The row of the present block, counted from the first.
    row: usize,
    /// The next row, and the one behind the last.
    next: usize,
    end: usize,
    /// What is left of the row's blocks, and of the present one.
    blocks: u64,
    column: usize,
    column_end: usize,
}

impl<'a> Walk<'a> {
    #[inline(always)]
    fn new(seen: Seen<'a>, meeting: &'a Meeting, first: u32, rows: usize) -> Self {
        let met = |row: u32| (row.saturating_sub(first) as usize).min(rows);
        Self {
            seen,
            meeting,
            first,
            row: 0,
            next: met(meeting.rows.start),
            end: met(meeting.rows.end),
            blocks: 0,
            column: 0,
            column_end: 0,
        }
    }

    /// Row, counted from the first, and column in the volume of the next vector.
    #[inline(always)]
    fn next<V: Lanes>(&mut self) -> Option<(usize, usize)> {
        while self.column >= self.column_end {
            while self.blocks == 0 {
                if self.next >= self.end {
                    return None;
                }
                self.row = self.next;
                self.next += 1;
                self.blocks = self.seen.row(self.voxel_row(self.row) as usize);
            }
            let block = self.seen.grain().block(self.blocks.trailing_zeros());
            self.blocks &= self.blocks - 1;
            self.column = block.start.max(self.meeting.voxel);
            self.column_end = self.clip(block.end);
        }
        let place = (self.row, self.column);
        self.column += V::COUNT;
        Some(place)
    }

    /// Voxel row of the samples of a row.
    #[inline(always)]
    fn voxel_row(&self, row: usize) -> i32 {
        (self.first as i32)
            .wrapping_add(row as i32)
            .wrapping_add(self.meeting.y.index)
    }

    /// A column of the volume, or the one behind the last sample.
    #[inline(always)]
    fn clip(&self, column: usize) -> usize {
        column.min(self.meeting.voxel + self.meeting.columns.len())
    }

    /// Columns of the image that the vector at a column of the volume covers: those of its block.
    #[inline(always)]
    fn pixels<V: Lanes>(&self, column: usize) -> core::ops::Range<usize> {
        let columns = self.seen.grain().columns();
        let block_end = (column & !(columns - 1)) + columns;
        let end = self.clip(block_end.min(column + V::COUNT));
        let first = self.meeting.columns.start + (column - self.meeting.voxel);
        first..first + end.saturating_sub(column)
    }
}

impl<P: Precision, C: Classifier<P>, S: Shader<P>, O: Order> Composite<P, C, S, O> {
    /// The rays of the vector at a place that are not finished; a finished one is 0.
    #[inline(always)]
    fn unfinished<V: Lanes>(
        data: &[ChannelOf<P>],
        base_width: usize,
        walk: &Walk<'_>,
        (row, column): (usize, usize),
    ) -> V {
        let pixels = walk.pixels::<V>(column);
        let start = (4 * row + 3) * base_width;
        let run = data.get(start..start + pixels.end).unwrap_or(&[]);
        V::load_as(run, pixels.start, Channel::bits)
    }

    /// Folds the blocks of a plane that are seen.
    #[inline(always)]
    pub(super) fn fold_blocks<V: Lanes, const LIT: bool>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        seen: Seen<'_>,
        rows: Rows<'_, ChannelOf<P>>,
        mut scratch: &mut [i32],
    ) {
        let meeting = Meeting::of(plan, plane);
        let [base_width, _] = plan.base().map(|side| side as usize);
        let row_len = 4 * base_width;
        let Some(count) = rows.data.len().checked_div(row_len) else {
            return;
        };
        if meeting.columns.is_empty() {
            return;
        }
        let data = rows.data;
        let mut walk = Walk::new(seen, &meeting, rows.first, count);
        let probe = Probe::<P, V>::new(&meeting, window);
        let dither = Dither::of_plane(plane.index);
        let floor = V::splat(self.floor.bits() as i32);
        let [fx, fy, fz] = plan.spacing();

        let mut row = || take(&mut scratch, BATCH);
        let mut places = Places {
            rows: row(),
            columns: row(),
        };
        let (samples, opacities) = (row(), row());
        let ([gx, gy, gz], r) = ([row(), row(), row()], row());
        let [red, green, blue] = [row(), row(), row()];
        let mut more = true;
        while more {
            let mut vectors = 0;
            while (vectors + 1) * V::COUNT <= BATCH {
                let Some(place) = walk.next::<V>() else {
                    more = false;
                    break;
                };
                // Kept only if a ray goes on; without a branch, which nobody could foresee.
                places.set(vectors, place);
                vectors += if O::BACK_TO_FRONT {
                    1
                } else {
                    usize::from(!Self::unfinished::<V>(data, base_width, &walk, place).all_zero())
                };
            }

            for number in 0..vectors {
                let (row, column) = places.get(number);
                let sample = probe.sample(walk.voxel_row(row), column as i32);
                sample.store(samples, number * V::COUNT);
            }
            let made = vectors * V::COUNT;
            self.classifier
                .opacity_row::<V>(part(samples, 0..made), part_mut(opacities, 0..made));

            // Vectors in which a sample is visible move to the front, visible samples side by side.
            let (mut kept, mut packed) = (0, 0);
            for number in 0..vectors {
                let place = places.get(number);
                let at = number * V::COUNT;
                let opacity = V::load(opacities, at);
                let opacity = if O::BACK_TO_FRONT {
                    // Lanes beyond the block see nothing.
                    V::load(part(opacities, at..at + walk.pixels::<V>(place.1).len()), 0)
                } else {
                    Self::unfinished::<V>(data, base_width, &walk, place).nonzero_then(opacity)
                };
                V::load(samples, at).packed(opacity).store(samples, packed);
                packed += opacity.count();
                opacity.store(opacities, kept * V::COUNT);
                places.set(kept, place);
                kept += usize::from(!opacity.all_zero());
            }

            let [cr, cg, cb] = [&mut *red, &mut *green, &mut *blue].map(|c| part_mut(c, 0..packed));
            // One colour needs no rows to be shaded.
            let one_colour = self.classifier.one_colour().filter(|_| LIT);
            if one_colour.is_none() {
                self.classifier
                    .colour_row::<V>(part(samples, 0..packed), [&mut *cr, &mut *cg, &mut *cb]);
            }
            if LIT {
                let mut at = 0;
                for number in 0..kept {
                    let (row, column) = places.get(number);
                    let opacity = V::load(opacities, number * V::COUNT);
                    let [x, y, z] = probe.gradient(walk.voxel_row(row), column as i32);
                    x.packed(opacity).store(gx, at);
                    y.packed(opacity).store(gy, at);
                    z.packed(opacity).store(gz, at);
                    at += opacity.count();
                }
                let [gx, gy, gz] = [&mut *gx, &mut *gy, &mut *gz].map(|g| part_mut(g, 0..packed));
                let r = part_mut(r, 0..packed);
                space_row::<V>(gx, fx);
                space_row::<V>(gy, fy);
                space_row::<V>(gz, fz);
                if P::GRADIENT_BITS < 15 {
                    coarsen_row::<V>([&mut *gx, &mut *gy, &mut *gz], P::GRADIENT_BITS);
                }
                normalise_row::<V>([&mut *gx, &mut *gy, &mut *gz], r);
                self.shader.shade_row::<V>([gx, gy, gz], r, one_colour, [cr, cg, cb]);
            }

            let mut at = 0;
            for number in 0..kept {
                let (row, column) = places.get(number);
                let opacity = V::load(opacities, number * V::COUNT);
                let colour = [
                    V::load(red, at).spread(opacity),
                    V::load(green, at).spread(opacity),
                    V::load(blue, at).spread(opacity),
                ];
                at += opacity.count();
                let data = data.get_mut(row * row_len..(row + 1) * row_len).unwrap_or(&mut []);
                let mut pixels = PixelRow::of_runs(data, base_width, walk.pixels::<V>(column));
                fold_at::<P::Pixel, O, V>(&mut pixels, 0, (colour, opacity), dither, floor);
            }
        }
    }
}
