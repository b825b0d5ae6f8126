//! Blocks: the way through a plane that visits only the blocks of columns that can be seen.
//!
//! Short spans mean short loops: their exits are mispredicted and their latency is not hidden. A batch of blocks from many
//! rows therefore goes through one stage after the other, and its visible samples are packed side by side.

use core::ops::Range;

use super::canvas::Packing;
use super::clipped::Clipped;
use super::extent::Extent;
use super::fold::Batches;
use super::kernels::ClassifierRows;
use super::places::Places;
use super::scratch::BATCH;
use super::source::SourceAt;
use crate::classify::Slab;
use crate::composite::Colours;
use crate::rows::part_mut;
use crate::seen::Seen;
use crate::tap::Beam;

/// The way through the blocks of some rows, vector by vector.
struct Walk<'a> {
    seen: Seen<'a>,
    /// The row of the present block, counted from the first.
    row: usize,
    /// The next row, and the one behind the last.
    next: usize,
    end: usize,
    clipped: Option<&'a Clipped<'a>>,
    /// The row of the image from which rows are counted.
    first: u32,
    /// Columns of the volume under those of the row of which clip planes leave something.
    left: Range<usize>,
    /// What is left of the row's blocks, and of the present one.
    blocks: u64,
    column: usize,
    column_end: usize,
}

impl Walk<'_> {
    /// Columns of the volume under those of the row of which something may be left.
    #[inline(always)]
    fn left(&self, places: &Places<'_>) -> Range<usize> {
        let Some(clipped) = self.clipped else {
            return places.inside.clone();
        };
        let [left, _] = clipped.reach(self.first + self.row as u32);
        let voxel = |column: usize| places.inside.start + column.saturating_sub(places.first);
        voxel(left.start)..voxel(left.end)
    }

    /// Row, counted from the first, and column in the volume of the next vector.
    #[inline(always)]
    fn next(&mut self, places: &Places<'_>) -> Option<(usize, usize)> {
        while self.column >= self.column_end {
            while self.blocks == 0 {
                if self.next >= self.end {
                    return None;
                }
                self.row = self.next;
                self.next += 1;
                self.blocks = self.seen.row(places.voxel_row(self.row) as usize);
                if self.blocks != 0 {
                    self.left = self.left(places);
                    if self.left.is_empty() {
                        self.blocks = 0;
                    }
                }
            }
            let block = self.seen.grain().block(self.blocks.trailing_zeros());
            self.blocks &= self.blocks - 1;
            self.column = block.start.max(self.left.start);
            self.column_end = block.end.min(self.left.end);
        }
        let place = (self.row, self.column);
        self.column += places.lanes;
        Some(place)
    }
}

/// Scratch memory of [`BATCH`] words each: rows and columns of places, samples of both planes, and room to store all four.
pub(super) type Lists<'s> = ([&'s mut [i32]; 2], [&'s mut [i32]; 2], [[&'s mut [i32]; 2]; 2]);

/// Batches of the blocks that can be seen.
pub(super) struct Blocks<'s> {
    walk: Walk<'s>,
    places: Places<'s>,
    source: &'s mut dyn SourceAt<i32>,
    /// Of the plane in front, empty where segments are not classified, and of the plane.
    samples: [&'s mut [i32]; 2],
    /// Places and samples of a batch that is gone through several times; empty where segments are not classified.
    stored: [[&'s mut [i32]; 2]; 2],
    /// Vectors whose samples have been made, and vectors in which one of them is visible.
    made: usize,
    kept: usize,
    packed: bool,
}

impl<'s> Blocks<'s> {
    /// Blocks of the image's rows from `first` on.
    pub(super) fn new(
        seen: Seen<'s>,
        extent: &Extent,
        (first, count): (u32, usize),
        lanes: usize,
        source: &'s mut dyn SourceAt<i32>,
        clipped: Option<&'s Clipped<'s>>,
        ([rows, columns], samples, stored): Lists<'s>,
    ) -> Self {
        let met = extent.met(first, count);
        let walk = Walk {
            seen,
            clipped,
            first,
            left: 0..0,
            row: 0,
            next: (met.start - first) as usize,
            end: (met.end - first) as usize,
            blocks: 0,
            column: 0,
            column_end: 0,
        };
        let places = Places {
            rows,
            columns,
            voxel_row: extent.voxel_row(first),
            block: seen.grain().columns(),
            inside: extent.voxel..extent.voxel + extent.columns.len(),
            first: extent.columns.start,
            lanes,
        };
        Self {
            walk,
            places,
            source,
            samples,
            stored,
            made: 0,
            kept: 0,
            packed: true,
        }
    }
}

impl<X: Packing<i32> + ?Sized> Batches<i32, X> for Blocks<'_> {
    const WHOLE_ROWS: bool = false;

    fn next(&mut self, canvas: &mut X) -> Option<usize> {
        let room = BATCH.checked_div(self.places.lanes)?;
        let mut vectors = 0;
        while vectors < room {
            let before = vectors;
            while vectors < room
                && let Some(place) = self.walk.next(&self.places)
            {
                self.places.set(vectors, place);
                vectors += 1;
            }
            if vectors == before {
                break;
            }
            vectors = canvas.unfinished(&mut self.places, before..vectors);
        }
        if vectors == 0 {
            return None;
        }
        let [front, back] = &mut self.samples;
        self.source.samples_at(&self.places, vectors, [front, back]);
        self.made = vectors;
        self.packed = false;
        Some(vectors * self.places.lanes)
    }

    fn slab(&self) -> Slab<'_> {
        let [front, back] = &self.samples;
        Slab::between(front, back)
    }

    /// Samples only: segments under clip planes go by whole rows.
    fn clip<C: ClassifierRows<i32> + ?Sized>(&self, _: &C, _: u32, opacities: &mut [i32]) {
        let Some(clipped) = self.walk.clipped else { return };
        let (first, lanes) = (self.places.first, self.places.lanes);
        let (mut row, mut reach) = (usize::MAX, [0..0, 0..0]);
        for number in 0..self.made {
            let (own, column) = self.places.get(number);
            let image_row = self.walk.first + own as u32;
            if own != row {
                (row, reach) = (own, clipped.reach(image_row));
            }
            let columns = self.places.pixels(column);
            let opacities = part_mut(&mut *opacities, number * lanes..number * lanes + columns.len());
            let [left, cut] = &reach;
            let within = |range: &Range<usize>| range.start <= columns.start && columns.end <= range.end;
            let meets = |range: &Range<usize>| range.start < columns.end && columns.start < range.end;
            if !meets(left) {
                opacities.fill(0);
            } else if !within(left) || meets(cut) {
                clipped.weigh(image_row, columns.start - first..columns.end - first, opacities);
            }
        }
    }

    fn keep(&mut self) {
        let Places { rows, columns, .. } = &self.places;
        let [front, back] = &self.samples;
        for (stored, row) in self.stored.iter_mut().flatten().zip([rows, columns, front, back]) {
            copy(row, stored);
        }
    }

    fn again(&mut self) {
        let Places { rows, columns, .. } = &mut self.places;
        let [front, back] = &mut self.samples;
        for (stored, row) in self.stored.iter().flatten().zip([rows, columns, front, back]) {
            copy(stored, row);
        }
        self.packed = false;
    }

    fn visible(&mut self, canvas: &mut X, opacities: &mut [i32]) -> Option<Range<usize>> {
        if self.packed {
            return None;
        }
        self.packed = true;
        let [front, back] = &mut self.samples;
        let (kept, packed) = canvas.pack(&mut self.places, self.made, [front, back], opacities);
        self.kept = kept;
        (packed > 0).then_some(0..packed)
    }

    fn gradients(&mut self, _: Range<usize>, opacities: &[i32], turns: Option<&[i32]>, out: [&mut [i32]; 3]) {
        self.source.gradients_at(&self.places, self.kept, opacities, turns, out);
    }

    /// Opacities are not packed, as factors are.
    fn weigh(&self, _: &X, _: Range<usize>, _: &mut [i32], _: &[i32]) {}

    fn fold(
        &mut self,
        canvas: &mut X,
        _: Range<usize>,
        colours: &Colours<'_, i32>,
        opacities: &[i32],
        factors: Option<&[i32]>,
    ) {
        match factors {
            None => canvas.fold_packed(&self.places, self.kept, colours, opacities),
            Some(factors) => canvas.fold_weighed(&self.places, self.kept, colours, opacities, factors),
        }
    }

    fn beam(&self, _: usize, _: u32) -> Option<Beam<'_>> {
        None
    }
}

/// Copies what both rows hold.
fn copy(from: &[i32], to: &mut [i32]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}
