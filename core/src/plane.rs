//! The plane layer: folds one sample plane into some rows of the image.
//!
//! It keeps nothing between calls and reads the voxels by reference. A host runs it on a volume in memory, tile by tile, on
//! all its cores; the stream layer runs it on its ring. A pipeline is a type: precision, classifier, shader and order of
//! compositing ([`Composite`]), an extreme of the samples ([`Project`]), the first surface ([`Depth`]), or alpha compositing of
//! colours and extinctions ([`Rgba`]). Only the combinations you name are compiled.
//!
//! Work that cannot change the image is skipped, and skipping never changes a bit. A row is skipped when all its voxels are
//! transparent or all its rays have terminated; colours, gradients and shading are made for spans of visible samples. A
//! caller that knows the whole volume names the blocks of rows that can be seen ([`At::seen`]).
//!
//! | file | what it holds |
//! |---|---|
//! | `extent`, `parts` | which pixels have a sample in a plane, or a segment in front of it |
//! | `clipped` | what clip planes leave of them |
//! | `source`, `probe` | samples and gradients between the voxels, by rows and by vectors |
//! | `slabs` | the same of two planes, for segments |
//! | `spread` | rays that spread from an eye: their samples, gradients and steps |
//! | `smooth` | samples and gradients by splines |
//! | `splines` | compositing of such samples, of values |
//! | `fast`, `fast/` | the same in 16-bit lanes: samples and gradients, kernels, pixels, projection |
//! | `sheets` | compositing of samples that voxels were splatted to |
//! | `kernels`, `slots` | row kernels of a classifier and a shader; what goes through a plane sees them as objects |
//! | `canvas` | pixels |
//! | `shape` | what a pipeline's type says, as values |
//! | `fold`, `blocks` | the driver, and the two ways through a plane |
//! | `scratch` | memory of the rows under way |

mod bands;
mod blocks;
mod canvas;
mod clipped;
mod composite;
mod depth;
mod extent;
mod fast;
mod fold;
mod kept;
mod kernels;
pub(crate) mod parts;
mod places;
mod probe;
mod project;
mod rgba;
mod scratch;
mod shape;
mod sheets;
mod slabs;
mod slots;
mod smooth;
mod source;
mod splines;
mod spread;

use core::fmt::Debug;

pub use self::bands::{BandMemory, fold_band};
pub use self::composite::Composite;
pub use self::depth::{Depth, NO_DEPTH};
pub use self::fast::{Fast, FastProject};
pub use self::kept::Kept;
pub use self::project::Project;
pub use self::rgba::{Filter, Rgba, Trilinear, Triquadratic};
pub use self::scratch::{Rows as ScratchRows, ScratchError};
pub use self::shape::Shape;
pub use self::sheets::FoldSheet;
pub use self::splines::Splines;
pub use self::spread::{Perspective, ProjectFromEye};
use crate::classify::Support;
use crate::clip::Clipper;
use crate::composite::{ChannelFormat, Pixel, Recurrence};
use crate::lanes::{Lanes, Native};
use crate::locate::Plane;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::seen::Seen;
use crate::slice::{Code12, Voxel, Window};
use crate::tap::Tap;

/// The channel format of a precision.
pub type ChannelOf<P> = <<P as Precision>::Pixel as Recurrence>::Channel;

/// A pipeline: what is done with a sample plane.
pub trait Pipeline: Sync {
    /// Its number formats.
    type Precision: Precision;
    /// What its slices are made of.
    type Voxel: Voxel;
    /// What a base-plane image is made of. A row of the image is `CHANNELS` runs of `width` elements.
    type Element: Copy + Debug + Default + Send + Sync + 'static;
    /// Runs in a row of the image.
    const CHANNELS: usize;
    /// Slices that must be at hand at a time: 2, or 4 for gradients.
    const SLICES: usize;
    /// The rows of scratch memory.
    const SCRATCH: ScratchRows;
    /// Whether a plane is folded together with the one in front of it; the first plane then folds to nothing.
    const SLABS: bool = false;
    /// Whether its rays spread from an eye: its plans are those of [`Plan::perspective`], and others' plans are not.
    const SPREADS: bool = false;
    /// Whether planes go from the last to the first.
    const BACK_TO_FRONT: bool;
    /// All of these and what the types say, as values.
    const SHAPE: Shape = Shape {
        channels: Self::CHANNELS,
        element_bytes: size_of::<Self::Element>(),
        slices: Self::SLICES,
        words: Self::Voxel::WORDS,
        scratch: Self::SCRATCH,
        slabs: Self::SLABS,
        spreads: Self::SPREADS,
        back_to_front: Self::BACK_TO_FRONT,
    };
    /// Which voxel ranges can change the image; `None` where any can.
    fn support(&self) -> Option<Support> {
        None
    }
    /// The formats that the pipeline works in.
    fn precision(&self) -> Self::Precision;
    /// What an element of an untouched image holds, for the run of that number.
    fn empty(&self, channel: usize) -> Self::Element;

    /// Folds a plane into rows, with these lanes; the bits do not depend on them, nor on what is kept of the samples of the
    /// plane that was folded before into the same rows.
    ///
    /// # Errors
    /// [`ScratchError`] if `scratch` holds fewer words than [`Shape::scratch_len`], or [`Shape::blocks_scratch_len`] where blocks
    /// are named; no row is changed then.
    fn fold<V: Lanes>(
        &self,
        at: &At<'_, Self::Voxel>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        kept: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError>;

    /// [`Pipeline::fold`] in this machine's one lane: a program of its own, of which a host, whose tiles and streams fold so, needs
    /// one.
    ///
    /// # Errors
    /// As [`Pipeline::fold`].
    #[inline(never)]
    fn fold_native(
        &self,
        at: &At<'_, Self::Voxel>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        kept: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        self.fold::<Native>(at, rows, scratch, kept, tap)
    }

    /// Whether no further plane can change these whole rows.
    fn finished<V: Lanes>(&self, _plan: &Plan, _data: &[Self::Element]) -> bool {
        false
    }

    /// The pixel in a column of a finished row.
    fn pixel(&self, row: &[Self::Element], column: usize) -> Pixel<ChannelOf<Self::Precision>>;
}

/// A pipeline whose channels make pictures: their type says what 1.0 is.
pub trait Pictured: Pipeline<Precision: Precision<Pixel: Recurrence<Channel: ChannelFormat>>> {}

impl<L: Pipeline<Precision: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>> Pictured for L {}

impl<L: Pipeline> Pipeline for &L {
    type Precision = L::Precision;
    type Voxel = L::Voxel;
    type Element = L::Element;
    const CHANNELS: usize = L::CHANNELS;
    const SLICES: usize = L::SLICES;
    const SCRATCH: ScratchRows = L::SCRATCH;
    const SLABS: bool = L::SLABS;
    const SPREADS: bool = L::SPREADS;
    const BACK_TO_FRONT: bool = L::BACK_TO_FRONT;

    fn support(&self) -> Option<Support> {
        L::support(self)
    }

    fn precision(&self) -> L::Precision {
        L::precision(self)
    }

    fn empty(&self, channel: usize) -> Self::Element {
        L::empty(self, channel)
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_, Self::Voxel>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        kept: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        L::fold::<V>(self, at, rows, scratch, kept, tap)
    }

    #[inline(always)]
    fn fold_native(
        &self,
        at: &At<'_, Self::Voxel>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        kept: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        L::fold_native(self, at, rows, scratch, kept, tap)
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[Self::Element]) -> bool {
        L::finished::<V>(self, plan, data)
    }

    fn pixel(&self, row: &[Self::Element], column: usize) -> Pixel<ChannelOf<Self::Precision>> {
        L::pixel(self, row, column)
    }
}

/// A sample plane and what is around it.
#[derive(Clone, Copy, Debug)]
pub struct At<'a, X = Code12> {
    /// The plan.
    pub plan: &'a Plan,
    /// The plane ([`Shape::plane`]).
    pub plane: Plane,
    /// The slices from [`Shape::near_slice`] on.
    pub window: Window<'a, X>,
    /// The blocks that can be seen; `None`: rows are made as a whole. The same bits, if they are all that the pipeline's
    /// [`support`](Pipeline::support) meets; slower where they are many. A tap sees whole rows.
    pub seen: Option<Seen<'a>>,
    /// What is left by clip planes, if there are any.
    pub clips: Option<Clipper<'a>>,
    /// What is told which rows of voxels are read; not by a small machine, nor of blocks.
    pub reading: Option<&'a dyn Reading>,
}

/// What is told that a fold is about to read a row of voxels: a host then asks for those that will be read some slices later.
pub trait Reading: Debug {
    /// The row before a row of samples.
    fn row(&self, row: i32);
}

/// Consecutive rows of one phase of the base-plane image.
#[derive(Debug)]
pub struct Rows<'a, E> {
    /// Number of the first row.
    pub first: u32,
    /// Whole rows, `CHANNELS * base[0]` elements each.
    pub data: &'a mut [E],
}

/// Fills rows with what an untouched image holds.
pub fn clear<L: Pipeline>(pipeline: &L, plan: &Plan, data: &mut [L::Element]) {
    let [width, _] = plan.base();
    for (index, run) in data.chunks_mut((width as usize).max(1)).enumerate() {
        let channel = index.checked_rem(L::CHANNELS).unwrap_or(0);
        run.fill(pipeline.empty(channel));
    }
}
