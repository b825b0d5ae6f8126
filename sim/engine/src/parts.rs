//! Frames of volumes that stay on disk: a part of the slices after the other, in the order in which rays meet them.
//!
//! A plane reads the slices around it and nothing else, and a pixel is folded plane by plane; so a frame of parts has the
//! bits of the frame of the whole. What stays in memory is the base plane's image. Once all rays are finished nothing more is
//! read.

use std::fmt;
use std::ops::Range;

use slicecast::slice::{RowRange, Slice};
use slicecast::view::Axis;
use slicecast_scene::Classification;
use slicecast_volume::on_disk::OnDisk;

use crate::error::RenderError;
use crate::frame::Prepared;
use crate::image::{BaseImage, Frame};
use crate::oriented::{Held, Oriented, Turned};
use crate::rendering::{Framing, Progress};
use crate::shard::Shard;

/// Slices that a plane may look at: two on each side.
const WINDOW: usize = 4;

/// The fewest slices that a part has: a plane's, and one more so that parts come forward.
const LEAST: usize = WINDOW + 1;

/// What the program takes beside the frame and the slices: its code, tables and threads.
const PROGRAM: u64 = 48 << 20;

/// Planes that are folded from a part of the slices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Numbers of the planes.
    pub planes: Range<u32>,
    /// Numbers of the slices, nearest to the eye first, that these planes look at.
    pub slices: Range<usize>,
}

/// The planes of a volume in parts of at most `most` slices, in the order of folding; `near` is the slice that a plane's window
/// begins with, and rises with the planes.
pub(crate) fn parts(
    planes: Range<u32>,
    depth: u32,
    near: impl Fn(u32) -> i32,
    back_to_front: bool,
    most: usize,
) -> Vec<Part> {
    let depth = depth as usize;
    let looked_at = |plane: u32| {
        let near = near(plane);
        let first = usize::try_from(near - 1).unwrap_or(0).min(depth.saturating_sub(1));
        let end = usize::try_from(near + 3)
            .unwrap_or(0)
            .clamp(first + 1, depth.max(first + 1));
        first..end
    };
    let mut parts: Vec<Part> = Vec::new();
    for step in 0..planes.len() as u32 {
        let plane = if back_to_front {
            planes.end - 1 - step
        } else {
            planes.start + step
        };
        let slices = looked_at(plane);
        let joined = parts.last().map(|part| {
            let all = &part.slices;
            let slices = all.start.min(slices.start)..all.end.max(slices.end);
            (part.planes.start.min(plane)..part.planes.end.max(plane + 1), slices)
        });
        match (joined, parts.last_mut()) {
            (Some((planes, slices)), Some(part)) if slices.len() <= most => *part = Part { planes, slices },
            _ => parts.push(Part {
                planes: plane..plane + 1,
                slices,
            }),
        }
    }
    parts
}

/// What of a volume was read for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Parts that were read.
    pub parts: usize,
    /// Slices of the largest.
    pub largest: usize,
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
            slices,
            depth,
            voxels,
            all,
        } = self;
        write!(
            f,
            "read in {parts} {} of at most {largest} slices: {slices} slices, of {depth}; {:.1} % of the voxels",
            if *parts == 1 { "part" } else { "parts" },
            100.0 * *voxels as f64 / (*all).max(1) as f64
        )
    }
}

impl Prepared<'_> {
    /// Renders the frame of a volume on disk, at most `most` slices of it (5 or more) in memory at a time. `progress` is told
    /// how many planes are folded.
    ///
    /// # Errors
    /// [`RenderError::Automatic`] if segments or samples were to be chosen by a look at all voxels; [`RenderError::Read`] if
    /// the file cannot be read any more.
    pub fn render_in_parts(
        &self,
        volume: &OnDisk,
        most: usize,
        progress: Progress<'_>,
    ) -> Result<(Frame, Reading), RenderError> {
        let (rendering, reading) = self.fold_in_parts(volume, most, Shard::ALL, progress)?;
        let frame = Frame {
            base: rendering.base(),
            picture: rendering.picture(self),
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
        most: usize,
        shard: Shard,
        progress: Progress<'_>,
    ) -> Result<(BaseImage, Reading), RenderError> {
        let (rendering, reading) = self.fold_in_parts(volume, most, shard, progress)?;
        Ok((rendering.base(), reading))
    }

    fn fold_in_parts(
        &self,
        volume: &OnDisk,
        most: usize,
        shard: Shard,
        progress: Progress<'_>,
    ) -> Result<(Box<dyn Framing>, Reading), RenderError> {
        if self.scene.classification == Classification::Auto && self.scene.surfaces.is_empty() {
            return Err(RenderError::Automatic);
        }
        let plan = &self.setup.plan;
        let mut rendering = self.begun()?;
        let parts = rendering.parts(most);
        let planes = parts.iter().map(|part| part.planes.len()).sum();
        let mut reading = Reading {
            parts: 0,
            largest: 0,
            slices: 0,
            depth: plan.volume()[2] as usize,
            voxels: 0,
            all: self.volume.dims.iter().map(|&side| side as u64).product(),
        };
        let support = rendering.support();
        let wanted = support.map(|support| volume.wanted(|[low, high]| support.meets(RowRange { low, high })));
        let mut folded = 0;
        for part in parts {
            let (sub, voxels) = volume.read(self.corner(&part), self.sides(&part), wanted.as_ref())?;
            let mut turned = Turned::whole(&sub, plan.view());
            let slices: Vec<Slice<'_>> = turned.slices()?;
            let new = part.planes.len();
            rendering.fold_part(&Oriented::of(&slices), &part, shard, self.simd, &|tiles, all| {
                progress(folded + new * tiles / all.max(1), planes);
            });
            folded += new;
            reading.parts += 1;
            reading.slices += slices.len();
            reading.largest = reading.largest.max(slices.len());
            reading.voxels += voxels;
            if rendering.is_finished() {
                break;
            }
        }
        progress(planes, planes);
        Ok((rendering, reading))
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

    /// The first voxel of a part of what is held.
    fn corner(&self, part: &Part) -> [usize; 3] {
        let ((axis, reversed), held) = (self.along(), Held::of(&self.setup.plan));
        let mut corner = held.first;
        corner[axis] += if reversed {
            held.dims[axis] - part.slices.end
        } else {
            part.slices.start
        };
        corner
    }

    /// The voxels of a part along each axis.
    fn sides(&self, part: &Part) -> [usize; 3] {
        let (axis, _) = self.along();
        let mut sides = Held::of(&self.setup.plan).dims;
        sides[axis] = part.slices.len();
        sides
    }

    /// How many slices fit into so many bytes of memory, beside the image and all that the program takes.
    ///
    /// # Errors
    /// [`RenderError::Budget`] if not even those around a plane do.
    pub fn slices_within(&self, volume: &OnDisk, memory: u64) -> Result<usize, RenderError> {
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
        let voxels = columns * rows;
        // Codes; a second copy where they are brought into another order; what is measured of blocks and rows.
        let copies = if volume.is_turned() || axis == 0 { 2 } else { 1 };
        let slice = voxels * 2 * copies + voxels * 3 / 8 + rows * 4;
        let beside = PROGRAM + image + volume.reading_bytes(rayon::current_num_threads());
        let least = (beside + LEAST as u64 * slice).max(PROGRAM + image + out);
        if memory < least {
            return Err(RenderError::Budget { memory, least });
        }
        Ok(((memory - beside) / slice) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
