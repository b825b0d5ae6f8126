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
mod ring;
mod streamed;

use core::ops::Range;

pub use self::reserved::Reserved;
use self::ring::Ring;
pub use self::streamed::Streamed;
use crate::clip::Clipper;
use crate::composite::{Pixel, Recurrence as _};
use crate::plan::Plan;
use crate::plane::{At, ChannelOf, Pipeline, Rows, ScratchError, Shape};
use crate::precision::Precision as _;
use crate::slice::{RowRange, SliceError, Voxel};
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
        Self::of_shape(L::SHAPE, plan, rows)
    }

    /// What pipelines of a shape need for a band of this many rows of the image (of each phase).
    pub const fn of_shape(shape: Shape, plan: &Plan, rows: u32) -> Self {
        let [width, height, _] = plan.dims();
        Self {
            slices: shape.slices * shape.words * width as usize * height as usize,
            ranges: shape.slices * height as usize,
            scratch: shape.scratch_len(plan.longest_row()),
            image: shape.rows_len(plan, rows).saturating_mul(plan.phases() as usize),
            element_bytes: shape.element_bytes,
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
pub type Given<'g, L> = <<L as Streamed>::Voxel as Voxel>::Given<'g>;

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
pub struct Stream<'m, L: Streamed> {
    ring: Ring<'m, L::Voxel>,
    pipeline: L,
    scratch: &'m mut [i32],
    image: &'m mut [L::Element],
}

impl<'m, L: Streamed> Stream<'m, L> {
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
        let Memory {
            slices,
            ranges,
            scratch,
            image,
        } = memory;
        let others = [scratch.len(), image.len()];
        let ring = Ring::new(pipeline.shape(), plan, (slices, ranges), others, band)?;
        let stream = Self {
            ring,
            pipeline,
            scratch,
            image,
        };
        let len = stream.image_len();
        let image = stream.image.get_mut(..len).unwrap_or(&mut []);
        stream.pipeline.clear(&plan, image);
        Ok(stream)
    }

    /// Puts the frame behind clip planes ([`Clips::clipper`](crate::clip::Clips::clipper)), made for its plan.
    ///
    /// # Errors
    /// [`StreamError::Begun`] after the first slice.
    pub fn clip(&mut self, clips: Clipper<'m>) -> Result<(), StreamError> {
        if self.ring.pushed > 0 {
            return Err(StreamError::Begun);
        }
        self.ring.clips = Some(clips);
        Ok(())
    }

    /// The number, along k in the whole volume, of the slice that is wanted next; `None` when the frame is complete.
    pub fn wanted(&self) -> Option<u32> {
        let [_, _, first] = self.ring.plan.first();
        Some(first + self.ring.wanted(self.pipeline.shape())?)
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
    fn take(&mut self, slice: Given<'_, L>, mut tap: Option<&mut dyn Tap>) -> Result<(), StreamError> {
        let shape = self.pipeline.shape();
        self.ring.take(shape, slice)?;
        let plan = &self.ring.plan;
        let Range { start: first, end } = self.ring.band;
        let phase_len = shape.rows_len(plan, end - first).max(1);
        while let Some(index) = self.ring.ready(shape) {
            if let Some(window) = self.ring.window(shape, index) {
                let plan = &self.ring.plan;
                for (number, data) in (0..plan.phases()).zip(self.image.chunks_exact_mut(phase_len)) {
                    let at = At {
                        plan,
                        plane: shape.plane(plan, plan.phase(number), index),
                        window,
                        seen: None,
                        clips: self.ring.clips,
                        reading: None,
                    };
                    let rows = Rows { first, data };
                    let tap: Option<&mut dyn Tap> = match &mut tap {
                        Some(tap) => Some(*tap),
                        None => None,
                    };
                    self.pipeline.fold_plane(&at, rows, self.scratch, tap)?;
                }
            }
            self.ring.folded += 1;
        }
        Ok(())
    }

    /// Elements of the image.
    fn image_len(&self) -> usize {
        let Range { start, end } = self.ring.band;
        Needs::of_shape(self.pipeline.shape(), &self.ring.plan, end - start).image
    }

    /// The base-plane image (or the band of it) as it stands: phase after phase, row after row, `CHANNELS` runs of
    /// `plan.base()[0]` elements a row.
    pub fn image(&self) -> &[L::Element] {
        self.image.get(..self.image_len()).unwrap_or(&[])
    }

    /// The plan.
    pub const fn plan(&self) -> &Plan {
        &self.ring.plan
    }
}

impl<L: Pipeline> Stream<'_, L> {
    /// A pixel of the whole base-plane image (all phases), clear outside it and outside the band.
    pub fn pixel(&self, u: i64, v: i64) -> Pixel<ChannelOf<L::Precision>> {
        band_pixel(
            &self.ring.plan,
            &self.pipeline,
            self.image(),
            self.ring.band.clone(),
            [u, v],
        )
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
    at: [i64; 2],
) -> Pixel<ChannelOf<L::Precision>> {
    L::SHAPE
        .place(plan, rows, at)
        .and_then(|(start, column)| {
            let row = image.get(start..start + L::SHAPE.row_len(plan))?;
            Some(pipeline.pixel(row, column))
        })
        .unwrap_or(pipeline.precision().pixel().clear())
}
