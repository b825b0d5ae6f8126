//! Frames of volumes that stay on disk: a part of the slices after the other, in the order in which rays meet them.
//!
//! A plane reads the slices around it and nothing else, and a pixel is folded plane by plane; so a frame of parts has the
//! bits of the frame of the whole. What stays in memory is the base plane's image. Once all rays are finished nothing more is
//! read.
//!
//! A part may be cut into bricks across its slices, after LaMar: a sample belongs to the brick whose cell it lies in. Along a ray
//! the cells rise or fall with the planes along either side, so that bricks visited in that order meet the samples of each
//! pixel in theirs; positions, weights, dither and what counts of a segment depend on plane and pixel alone. The bits are those of the
//! whole. A brick has the voxels that the samples of its cells look at: of segments one cell beside, and one voxel more for
//! gradients.

use std::fmt;
use std::ops::Range;

use slicecast::locate::plane;
use slicecast::plan::Phase;
use slicecast::slice::{RowRange, Slice};
use slicecast::view::Axis;
use slicecast_volume::on_disk::OnDisk;

use crate::error::RenderError;
use crate::frame::Prepared;
use crate::image::{BaseImage, Frame};
use crate::oriented::{Held, Oriented, Turned};
use crate::part::{BESIDE, Brick, Part};
use crate::progress::Progress;
use crate::rendering::Framing;
use crate::shard::Shard;

/// Slices that a plane may look at: two on each side.
const WINDOW: usize = 4;

/// The fewest slices that a part has: a plane's, and one more so that parts come forward.
const LEAST: usize = WINDOW + 1;

/// The fewest rows of a brick's cells where slices are cut.
const LEAST_ROWS: usize = 8;

/// What the program takes beside the frame and the slices: its code, tables and threads.
pub(crate) const PROGRAM: u64 = 48 << 20;

/// How a volume is cut: the most that a part has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Slices, 5 or more.
    pub slices: usize,
    /// Columns and rows of cells; those of a slice, or more: slices are whole.
    pub cells: [usize; 2],
}

impl Cut {
    /// Runs of so many whole slices.
    pub const fn of_slices(slices: usize) -> Self {
        Self {
            slices,
            cells: [usize::MAX; 2],
        }
    }

    /// The bricks of a part, in the order of folding, given the steps of rays along i and j.
    fn bricks(&self, part: &Part, size: [usize; 2], rising: [bool; 2]) -> Vec<Part> {
        if (0..2).all(|axis| self.cells[axis] >= size[axis]) {
            return vec![part.clone()];
        }
        let [columns, rows] = [0, 1].map(|axis| {
            let cells = self.cells[axis].clamp(1, size[axis]);
            let ranges = (0..size[axis])
                .step_by(cells)
                .map(|first| first..(first + cells).min(size[axis]));
            let mut ranges: Vec<Range<usize>> = ranges.collect();
            if !rising[axis] {
                ranges.reverse();
            }
            ranges
        });
        let cells = rows
            .iter()
            .flat_map(|rows| columns.iter().map(|columns| [columns.clone(), rows.clone()]));
        let brick = |cells| Part {
            brick: Some(Brick::of(cells, size)),
            ..part.clone()
        };
        cells.map(brick).collect()
    }
}

/// What of a volume was read for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Parts, or bricks of them, that were read.
    pub parts: usize,
    /// Slices of the largest.
    pub largest: usize,
    /// Columns and rows of the largest brick, if slices were cut.
    pub brick: Option<[usize; 2]>,
    /// Slices that were read, those of two parts twice.
    pub slices: usize,
    /// Slices of the volume.
    pub depth: usize,
    /// Voxels that were read, those of two parts twice: what the table hides is left out.
    pub voxels: u64,
    /// Voxels of the volume.
    pub all: u64,
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            parts,
            largest,
            brick,
            slices,
            depth,
            voxels,
            all,
        } = self;
        let share = 100.0 * *voxels as f64 / (*all).max(1) as f64;
        if let Some([columns, rows]) = brick {
            return write!(
                f,
                "read in {parts} {} of at most {columns} x {rows} voxels of {largest} slices; {share:.1} % of the voxels",
                if *parts == 1 { "brick" } else { "bricks" },
            );
        }
        write!(
            f,
            "read in {parts} {} of at most {largest} slices: {slices} slices, of {depth}; {share:.1} % of the voxels",
            if *parts == 1 { "part" } else { "parts" },
        )
    }
}

impl Prepared<'_> {
    /// Renders the frame of a volume on disk, a part of it in memory at a time. `progress` is told how far it is.
    ///
    /// # Errors
    /// [`RenderError::Read`] if the file cannot be read any more.
    pub fn render_in_parts(
        &self,
        volume: &OnDisk,
        cut: Cut,
        progress: Progress<'_>,
    ) -> Result<(Frame, Reading), RenderError> {
        let (rendering, reading) = self.fold_in_parts(volume, cut, Shard::ALL, progress)?;
        let frame = Frame {
            base: rendering.base(),
            picture: rendering.picture(&self.shown()),
        };
        Ok((frame, reading))
    }

    /// As [`Prepared::render_in_parts`], one shard of the frame: its base-plane image, of which only [`Shard::rows`] are to
    /// be read.
    ///
    /// # Errors
    /// As [`Prepared::render_in_parts`].
    pub fn render_shard_in_parts(
        &self,
        volume: &OnDisk,
        cut: Cut,
        shard: Shard,
        progress: Progress<'_>,
    ) -> Result<(BaseImage, Reading), RenderError> {
        let (rendering, reading) = self.fold_in_parts(volume, cut, shard, progress)?;
        Ok((rendering.base(), reading))
    }

    fn fold_in_parts(
        &self,
        volume: &OnDisk,
        cut: Cut,
        shard: Shard,
        progress: Progress<'_>,
    ) -> Result<(Box<dyn Framing>, Reading), RenderError> {
        let plan = &self.setup.plan;
        let mut rendering = self.begun()?;
        let parts = self.parts(&*rendering, cut);
        let mut reading = Reading {
            parts: 0,
            largest: 0,
            brick: None,
            slices: 0,
            depth: plan.volume()[2] as usize,
            voxels: 0,
            all: self.volume.dims.iter().map(|&side| side as u64).product(),
        };
        let support = rendering.support();
        let wanted = support.map(|support| volume.wanted(|[low, high]| support.meets(RowRange { low, high })));
        // Steps of a thousandth of a part.
        let steps = 1000 * parts.len();
        for (number, part) in parts.iter().enumerate() {
            progress(1000 * number, steps);
            if rendering.is_finished(self.rows(part)) {
                continue;
            }
            let (first, dims) = self.region(part);
            if self.is_clipped_away(first, dims) {
                continue;
            }
            let (sub, voxels) = volume.read(first, dims, wanted.as_ref())?;
            // Nothing was read because nothing can be seen.
            if voxels == 0 {
                continue;
            }
            let mut turned = Turned::whole(&sub, plan.view());
            let slices: Vec<Slice<'_>> = turned.slices()?;
            rendering.fold_part(&Oriented::of(&slices), part, shard, self.simd, &|tiles, all| {
                progress(1000 * number + 1000 * tiles / all.max(1), steps);
            });
            reading.parts += 1;
            reading.slices += slices.len();
            reading.largest = reading.largest.max(slices.len());
            if let Some(Brick { voxels, .. }) = &part.brick {
                let sides = voxels.each_ref().map(Range::len);
                let largest = reading.brick.unwrap_or_default();
                reading.brick = Some([0, 1].map(|axis| largest[axis].max(sides[axis])));
            }
            reading.voxels += voxels;
        }
        progress(steps, steps);
        Ok((rendering, reading))
    }

    /// The parts of a rendering, in the order of folding.
    pub fn parts(&self, rendering: &dyn Framing, cut: Cut) -> Vec<Part> {
        let plan = &self.setup.plan;
        let [width, height, _] = plan.dims().map(|side| side as usize);
        let [step_i, step_j, _] = plan.step();
        let rising = [step_i, step_j].map(|step| (step.to_bits() >= 0) != rendering.back_to_front());
        let parts = rendering.parts(cut.slices).into_iter();
        parts
            .flat_map(|part| cut.bricks(&part, [width, height], rising))
            .collect()
    }

    /// Rows of the base plane, of any phase, that a part can change, and a few more.
    fn rows(&self, part: &Part) -> Range<u32> {
        /// What phases and ends of segments lie beside a plane's samples.
        const MORE: i64 = 3;
        let plan = &self.setup.plan;
        let [_, all] = plan.base();
        let Some(brick) = &part.brick else {
            return 0..all;
        };
        let plan = brick.plan(plan);
        let ends = [part.planes.start, part.planes.end.saturating_sub(1)];
        let rows = ends.map(|index| {
            let at = plane(&plan, Phase::default(), index).y;
            let least = brick.pixels(1, at, 0..all);
            let [start, end] = [i64::from(least.start) - MORE, i64::from(least.end) + MORE];
            [start.max(0) as u32, end.min(all.into()) as u32]
        });
        rows[0][0].min(rows[1][0])..rows[0][1].max(rows[1][1])
    }

    /// The axis of the volume along which its slices lie, and whether they come from its far end.
    fn along(&self) -> (usize, bool) {
        let view = self.setup.plan.view();
        let axis = match view.major() {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        (axis, view.reversed())
    }

    /// The first voxel of a part of what is held, and its voxels along each axis.
    pub fn region(&self, part: &Part) -> ([usize; 3], [usize; 3]) {
        let ((axis, reversed), held) = (self.along(), Held::of(&self.setup.plan));
        let (mut first, mut dims) = (held.first, held.dims);
        first[axis] += if reversed {
            held.dims[axis] - part.slices.end
        } else {
            part.slices.start
        };
        dims[axis] = part.slices.len();
        if let Some(brick) = &part.brick {
            let [i, j, _] = self.setup.plan.view().arrange([0_usize, 1, 2]);
            for (axis, voxels) in [i, j].into_iter().zip(&brick.voxels) {
                first[axis] += voxels.start;
                dims[axis] = voxels.len();
            }
        }
        (first, dims)
    }

    /// Whether clip planes leave nothing of the samples and segments about some voxels.
    fn is_clipped_away(&self, first: [usize; 3], dims: [usize; 3]) -> bool {
        let (Some(clips), plan) = (&self.setup.clips, &self.setup.plan) else {
            return false;
        };
        // Cells reach half a voxel beyond the first and the last one, steps a little further.
        let mut low = first.map(|at| at as i64 - 2);
        let mut high = [0, 1, 2].map(|axis| (first[axis] + dims[axis]) as i64 + 1);
        let (axis, reversed) = self.along();
        if reversed {
            let last = plan.volume()[2] as i64 - 1;
            (low[axis], high[axis]) = (last - high[axis], last - low[axis]);
        }
        clips.hides(plan.view().arrange(low), plan.view().arrange(high))
    }

    /// How the volume is cut for so many bytes of memory, beside the image and all that the program takes: into runs of slices, or
    /// of rows of them where no run of six fits.
    ///
    /// # Errors
    /// [`RenderError::Budget`] if not even some rows of the slices around a plane fit.
    pub fn cut_within(&self, volume: &OnDisk, memory: u64) -> Result<Cut, RenderError> {
        let plan = &self.setup.plan;
        let rendering = self.rendering()?;
        let needs = rendering.needs();
        let image = needs.image as u64 * needs.element_bytes as u64;
        let [across, down] = plan.base().map(u64::from);
        let rays = u64::from(plan.sampling().rays_per_voxel);
        let [width, height] = self.setup.picture.size.map(u64::from);
        // Four channels of 32 bits; the picture in bytes, and again as its file is made.
        let out = across * down * rays * rays * 16 + width * height * 16;
        let (axis, _) = self.along();
        let [columns, rows, _] = plan.dims().map(u64::from);
        // Codes; a second copy where they are brought into another order; what is measured of blocks and rows.
        let copies = if volume.is_turned() || axis == 0 { 2 } else { 1 };
        let row = columns * 2 * copies + columns * 3 / 8 + 4;
        let beside = PROGRAM + image + volume.reading_bytes(rayon::current_num_threads());
        let least_rows = (LEAST_ROWS + 2 * BESIDE + 1) as u64;
        let least = (beside + LEAST as u64 * row * rows.min(least_rows)).max(PROGRAM + image + out);
        if memory < least {
            return Err(RenderError::Budget { memory, least });
        }
        Ok(Cut::of_rows(((memory - beside) / row) as usize, rows as usize))
    }
}

impl Cut {
    /// The cut of slices of `rows` rows, `room` rows of which fit.
    fn of_rows(room: usize, rows: usize) -> Self {
        let whole = room / rows;
        // Of six slices three are new, so that no more than twice as much is read; and rows that are whole fold faster.
        if whole > LEAST {
            return Self::of_slices(whole);
        }
        // As many rows for a slice as both have again.
        let slices = ((room as f64 * (WINDOW - 1) as f64 / (2 * BESIDE + 1) as f64).sqrt() as usize).max(LEAST);
        let cut = (room / slices).min(rows);
        Self {
            slices,
            cells: [usize::MAX, cut.saturating_sub(2 * BESIDE + 1).max(LEAST_ROWS)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::parts;

    /// Every plane once, in order, with the slices around it and no more than asked for.
    #[test]
    fn parts_have_every_plane_and_what_it_looks_at() {
        for (planes, depth, per_voxel) in [(1, 1, 1), (9, 9, 1), (33, 9, 4), (200, 100, 2), (5, 20, 1)] {
            for most in [5, 6, 17, 1000] {
                for back_to_front in [false, true] {
                    let near = |plane: u32| (plane / per_voxel).min(depth - 1) as i32;
                    let parts = parts(0..planes, depth, near, back_to_front, most);
                    let mut seen = Vec::new();
                    for part in &parts {
                        assert!(part.slices.len() <= most.max(LEAST) && part.slices.end <= depth as usize);
                        for plane in part.planes.clone() {
                            let near = near(plane) as usize;
                            let around = near.saturating_sub(1)..(near + 3).min(depth as usize);
                            assert!(part.slices.start <= around.start && around.end <= part.slices.end);
                        }
                        let planes: Vec<u32> = part.planes.clone().collect();
                        seen.extend(if back_to_front {
                            planes.into_iter().rev().collect::<Vec<_>>()
                        } else {
                            planes
                        });
                    }
                    let expected = 0..planes;
                    let expected: Vec<u32> = if back_to_front {
                        expected.rev().collect()
                    } else {
                        expected.collect()
                    };
                    assert_eq!(seen, expected);
                }
            }
        }
    }
}
