//! The stream layer: slices go in one at a time, in the caller's memory, and the image grows.
//!
//! Slices are copied into a ring of as many as the pipeline looks at (2, or 4 where gradients are needed); every sample
//! plane is folded as soon as its slices are there. The same bits as the plane layer on the whole volume.
//!
//! A slice has `plan.dims()[0]` x `plan.dims()[1]` voxels, rows of i: of a cropped plan those that it holds, which begin at
//! `plan.first()`. Slices are pushed nearest first ([`Stream::wanted`] says which); a back-to-front pipeline wants them farthest
//! first.
//!
//! An image that does not fit is rendered in bands of rows ([`Stream::band`]), each with a stream of its own over the
//! same slices and the same memory: the same bits again, for one more reading of the volume a band.

mod reserved;

use core::ops::Range;

pub use self::reserved::Reserved;
use crate::clip::Clipper;
use crate::composite::{Pixel, Recurrence as _};
use crate::lanes::{Lanes as _, Native};
use crate::plan::Plan;
use crate::plane::{
    At, ChannelOf, Pipeline, Rows, ScratchError, clear, fold_native, near_slice, plane, planes, scratch_len,
};
use crate::precision::Precision as _;
use crate::rows::three;
use crate::slice::{Region, RowRange, Slice, SliceError, Voxel, Window};
use crate::tap::Tap;

/// Memory that a stream needs, in elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Needs {
    /// Words of the ring, 2 bytes each: one a voxel, or more ([`Voxel::WORDS`]).
    pub slices: usize,
    /// Row ranges of the ring, 4 bytes each.
    pub ranges: usize,
    /// Words of scratch memory, 4 bytes each.
    pub scratch: usize,
    /// Elements of the base-plane image.
    pub image: usize,
    /// Bytes of an element of the image.
    pub element_bytes: usize,
}

impl Needs {
    /// What a pipeline needs for a plan. A number that `usize` cannot hold (images of some scenes on 32-bit machines)
    /// is `usize::MAX`, which no memory has.
    pub const fn of<L: Pipeline>(plan: &Plan) -> Self {
        let [_, base_height] = plan.base();
        Self::of_band::<L>(plan, base_height)
    }

    /// What a pipeline needs for a band of this many rows of the image (of each phase).
    pub const fn of_band<L: Pipeline>(plan: &Plan, rows: u32) -> Self {
        let [width, height, _] = plan.dims();
        Self {
            slices: L::SLICES * L::Voxel::WORDS * width as usize * height as usize,
            ranges: L::SLICES * height as usize,
            scratch: scratch_len::<L>(plan.longest_row()),
            image: rows_len::<L>(plan, rows).saturating_mul(plan.phases() as usize),
            element_bytes: size_of::<L::Element>(),
        }
    }

    /// Bytes of the four parts, in the order of the fields.
    pub const fn bytes(&self) -> [usize; 4] {
        [
            self.slices.saturating_mul(2),
            self.ranges.saturating_mul(size_of::<RowRange>()),
            self.scratch.saturating_mul(4),
            self.image.saturating_mul(self.element_bytes),
        ]
    }
}

/// A slice as a pipeline's stream is given it.
pub type Given<'g, L> = <<L as Pipeline>::Voxel as Voxel>::Given<'g>;

/// Elements of one phase of the base-plane image.
pub const fn phase_len<L: Pipeline>(plan: &Plan) -> usize {
    let [_, height] = plan.base();
    rows_len::<L>(plan, height)
}

/// Elements of some rows of one phase.
const fn rows_len<L: Pipeline>(plan: &Plan, rows: u32) -> usize {
    let [width, _] = plan.base();
    (L::CHANNELS * width as usize).saturating_mul(rows as usize)
}

/// Memory lent to a stream: at least as much of each as [`Needs`] says. It need not be initialised to anything.
#[derive(Debug)]
pub struct Memory<'m, E> {
    /// The ring of slices.
    pub slices: &'m mut [u16],
    /// The ranges of their rows.
    pub ranges: &'m mut [RowRange],
    /// Rows under way.
    pub scratch: &'m mut [i32],
    /// The base-plane image, phase after phase.
    pub image: &'m mut [E],
}

/// A part of [`Memory`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Part {
    /// `slices`.
    Slices,
    /// `ranges`.
    Ranges,
    /// `scratch`.
    Scratch,
    /// `image`.
    Image,
}

/// Why a stream does not go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StreamError {
    /// A part of the memory is too small.
    Memory {
        /// Which.
        part: Part,
        /// Elements needed.
        needed: usize,
        /// Elements given.
        given: usize,
    },
    /// A band reaches beyond the image, or is empty.
    Band {
        /// Its first row.
        first: u32,
        /// The row behind its last.
        end: u32,
        /// Rows of the image.
        rows: u32,
    },
    /// A slice has the wrong size or a voxel that is none; it has not been taken.
    Slice(SliceError),
    /// All slices have been pushed.
    Complete,
    /// A slice has been taken; clip planes come before.
    Begun,
    /// A plan in perspective and a pipeline of parallel rays, or the other way round.
    Rays,
}

impl core::fmt::Display for StreamError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Memory { part, needed, given } => {
                let name = match part {
                    Part::Slices => "slices",
                    Part::Ranges => "ranges",
                    Part::Scratch => "scratch",
                    Part::Image => "image",
                };
                write!(f, "the memory for {name} needs {needed} elements, {given} given")
            }
            Self::Band { first, end, rows } => {
                write!(f, "a band from row {first} to {end}; the image has rows 0 to {rows}")
            }
            Self::Slice(error) => error.fmt(f),
            Self::Rays => {
                f.write_str("a plan and a pipeline of which one is in perspective and the other has parallel rays")
            }
            Self::Begun => f.write_str("clip planes after the first slice; they come before"),
            Self::Complete => f.write_str("all slices of the volume have been pushed"),
        }
    }
}

impl core::error::Error for StreamError {}

impl From<ScratchError> for StreamError {
    fn from(ScratchError { needed, given }: ScratchError) -> Self {
        let part = Part::Scratch;
        Self::Memory { part, needed, given }
    }
}

impl From<SliceError> for StreamError {
    fn from(error: SliceError) -> Self {
        Self::Slice(error)
    }
}

/// A frame in the making.
#[derive(Debug)]
pub struct Stream<'m, L: Pipeline> {
    plan: Plan,
    pipeline: L,
    memory: Memory<'m, L::Element>,
    first: u32,
    rows: u32,
    clips: Option<Clipper<'m>>,
    pushed: u32,
    folded: u32,
}

impl<'m, L: Pipeline> Stream<'m, L> {
    /// Begins a frame: checks the memory and clears the image.
    ///
    /// # Errors
    /// [`StreamError::Memory`] for the first part that is too small, [`StreamError::Rays`].
    pub fn new(plan: Plan, pipeline: L, memory: Memory<'m, L::Element>) -> Result<Self, StreamError> {
        let [_, base_height] = plan.base();
        Self::band(plan, pipeline, memory, 0..base_height)
    }

    /// Begins a band of a frame: some rows of the base-plane image (of each phase), for which [`Needs::of_band`] says
    /// the memory. The image that the stream keeps is the band's.
    ///
    /// # Errors
    /// [`StreamError::Band`] if the band is empty or not inside the image, [`StreamError::Memory`] for the first part
    /// that is too small.
    pub fn band(
        plan: Plan,
        pipeline: L,
        memory: Memory<'m, L::Element>,
        band: Range<u32>,
    ) -> Result<Self, StreamError> {
        let Range { start: first, end } = band;
        let [_, base_height] = plan.base();
        if L::SPREADS != plan.spreads() {
            return Err(StreamError::Rays);
        }
        if first >= end || end > base_height {
            let rows = base_height;
            return Err(StreamError::Band { first, end, rows });
        }
        let rows = end - first;
        let needs = Needs::of_band::<L>(&plan, rows);
        for (part, needed, given) in [
            (Part::Slices, needs.slices, memory.slices.len()),
            (Part::Ranges, needs.ranges, memory.ranges.len()),
            (Part::Scratch, needs.scratch, memory.scratch.len()),
            (Part::Image, needs.image, memory.image.len()),
        ] {
            if given < needed {
                return Err(StreamError::Memory { part, needed, given });
            }
        }
        let stream = Self {
            plan,
            pipeline,
            memory,
            first,
            rows,
            clips: None,
            pushed: 0,
            folded: 0,
        };
        clear(
            &stream.pipeline,
            &plan,
            stream.memory.image.get_mut(..needs.image).unwrap_or(&mut []),
        );
        Ok(stream)
    }

    /// Puts the frame behind clip planes ([`Clips::clipper`](crate::clip::Clips::clipper)), made for its plan.
    ///
    /// # Errors
    /// [`StreamError::Begun`] after the first slice.
    pub fn clip(&mut self, clips: Clipper<'m>) -> Result<(), StreamError> {
        if self.pushed > 0 {
            return Err(StreamError::Begun);
        }
        self.clips = Some(clips);
        Ok(())
    }

    /// The number, along k in the whole volume, of the slice that is wanted next; `None` when the frame is complete.
    pub fn wanted(&self) -> Option<u32> {
        let [_, _, first] = self.plan.first();
        Some(first + self.wanted_of_held()?)
    }

    /// The same, counted from the first slice that is held.
    fn wanted_of_held(&self) -> Option<u32> {
        let [_, _, depth] = self.plan.dims();
        let left = depth.checked_sub(self.pushed + 1)?;
        Some(if L::BACK_TO_FRONT { left } else { self.pushed })
    }

    /// Takes a slice (rows one after the other) and folds all planes that it completes. Of a cropped plan: what it holds of the
    /// slice, or the whole slice, of which nothing else is looked at (codes of colours: what it holds).
    ///
    /// # Errors
    /// [`StreamError::Slice`] if the slice is not of the plan's size or holds a voxel above 4095: the slice is then not
    /// taken, and the stream can go on with a good one. [`StreamError::Complete`] after the last slice.
    pub fn push(&mut self, slice: Given<'_, L>) -> Result<(), StreamError> {
        self.take(slice, None)
    }

    /// [`Stream::push`] under an observer.
    ///
    /// # Errors
    /// As [`Stream::push`].
    pub fn push_tapped(&mut self, slice: Given<'_, L>, tap: &mut dyn Tap) -> Result<(), StreamError> {
        self.take(slice, Some(tap))
    }

    #[inline(always)]
    fn take(&mut self, slice: Given<'_, L>, tap: Option<&mut dyn Tap>) -> Result<(), StreamError> {
        let number = self.wanted_of_held().ok_or(StreamError::Complete)?;
        let [width, height, _] = three(self.plan.dims(), |side| side as usize);
        let ([whole_width, whole_height, _], [column, row, _]) = (self.plan.volume(), self.plan.first());
        let region = Region {
            whole: [whole_width as usize, whole_height as usize],
            first: [column as usize, row as usize],
            size: [width, height],
        };
        let len = L::Voxel::WORDS * width * height;
        let slot = (number as usize).checked_rem(L::SLICES).unwrap_or(0);
        let ranges = self.memory.ranges.get_mut(slot * height..(slot + 1) * height);
        let kept = self.memory.slices.get_mut(slot * len..(slot + 1) * len);
        // Where a slice is refused its slot is left with wrong ranges, but the next good one overwrites them.
        L::Voxel::keep(slice, region, kept.unwrap_or(&mut []), ranges.unwrap_or(&mut []))?;
        self.pushed += 1;
        self.fold_ready(tap)
    }

    /// Folds the planes whose slices are all there.
    #[inline(always)]
    fn fold_ready(&mut self, mut tap: Option<&mut dyn Tap>) -> Result<(), StreamError> {
        let [width, height, depth] = self.plan.dims();
        let (slice_len, rows) = (L::Voxel::WORDS * width as usize * height as usize, height as usize);
        let phase_len = rows_len::<L>(&self.plan, self.rows).max(1);
        let planes = planes::<L>(&self.plan);
        // How far a plane looks beyond its two slices.
        let reach = i64::from(L::SLICES > 2);
        while self.folded < planes.end - planes.start {
            let index = if L::BACK_TO_FRONT {
                planes.end - 1 - self.folded
            } else {
                planes.start + self.folded
            };
            let z = near_slice::<L>(&self.plan, index);
            let last = i64::from(depth) - 1;
            let ready = if L::BACK_TO_FRONT {
                last - (i64::from(z) - reach).max(0) < i64::from(self.pushed)
            } else {
                (i64::from(z) + 1 + reach).min(last) < i64::from(self.pushed)
            };
            if !ready {
                return Ok(());
            }
            let Memory {
                slices,
                ranges,
                scratch,
                image,
            } = &mut self.memory;
            let slice = |z: i32| -> Option<Slice<'_, L::Voxel>> {
                let z = usize::try_from(z).ok().filter(|z| *z < depth as usize)?;
                let slot = z.checked_rem(L::SLICES)?;
                Some(Slice::measured(
                    slices.get(slot * slice_len..(slot + 1) * slice_len)?,
                    ranges.get(slot * rows..(slot + 1) * rows)?,
                    width as usize,
                ))
            };
            let outer = |z: i32| slice(z).filter(|_| L::SLICES > 2);
            let window = slice(z).map(|near| Window {
                before: outer(z - 1),
                near,
                far: slice(z + 1),
                after: outer(z + 2),
            });
            if let Some(window) = window {
                for (number, data) in (0..self.plan.phases()).zip(image.chunks_exact_mut(phase_len)) {
                    let at = At {
                        plan: &self.plan,
                        plane: plane::<L>(&self.plan, self.plan.phase(number), index),
                        window,
                        seen: None,
                        clips: self.clips,
                        reading: None,
                    };
                    let rows = Rows {
                        first: self.first,
                        data,
                    };
                    let tap: Option<&mut dyn Tap> = match &mut tap {
                        Some(tap) => Some(*tap),
                        None => None,
                    };
                    // A small machine has no other that folds.
                    if Native::SMALL {
                        self.pipeline.fold::<Native>(&at, rows, scratch, None, tap)?;
                    } else {
                        fold_native(&self.pipeline, &at, rows, scratch, None, tap)?;
                    }
                }
            }
            self.folded += 1;
        }
        Ok(())
    }

    /// The base-plane image (or the band of it) as it stands: phase after phase, row after row, `CHANNELS` runs of
    /// `plan.base()[0]` elements a row.
    pub fn image(&self) -> &[L::Element] {
        let needs = Needs::of_band::<L>(&self.plan, self.rows);
        self.memory.image.get(..needs.image).unwrap_or(&[])
    }

    /// A pixel of the whole base-plane image (all phases), clear outside it and outside the band.
    pub fn pixel(&self, u: i64, v: i64) -> Pixel<ChannelOf<L::Precision>> {
        let rows = self.first..self.first + self.rows;
        band_pixel(&self.plan, &self.pipeline, self.image(), rows, [u, v])
    }

    /// The plan.
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }
}

/// A pixel of a whole base-plane image (all phases, as [`Stream::image`] lays them out), clear outside it. `u` counts
/// along i and `v` along j, `rays_per_voxel` to a voxel.
pub fn base_pixel<L: Pipeline>(
    plan: &Plan,
    pipeline: &L,
    image: &[L::Element],
    u: i64,
    v: i64,
) -> Pixel<ChannelOf<L::Precision>> {
    let [_, height] = plan.base();
    band_pixel(plan, pipeline, image, 0..height, [u, v])
}

/// A pixel of a band of the image.
fn band_pixel<L: Pipeline>(
    plan: &Plan,
    pipeline: &L,
    image: &[L::Element],
    rows: Range<u32>,
    [u, v]: [i64; 2],
) -> Pixel<ChannelOf<L::Precision>> {
    let find = || {
        let n = u64::from(plan.sampling().rays_per_voxel);
        let (u, v) = (u64::try_from(u).ok()?, u64::try_from(v).ok()?);
        let [width, _] = plan.base();
        let (column, row) = (u.checked_div(n)? as usize, u32::try_from(v.checked_div(n)?).ok()?);
        if column >= width as usize || !rows.contains(&row) {
            return None;
        }
        let phase = (u.checked_rem(n)? + n * v.checked_rem(n)?) as usize;
        let row_len = L::CHANNELS * width as usize;
        let start = phase * rows_len::<L>(plan, rows.end - rows.start) + (row - rows.start) as usize * row_len;
        Some(pipeline.pixel(image.get(start..start + row_len)?, column))
    };
    find().unwrap_or(pipeline.precision().pixel().clear())
}
