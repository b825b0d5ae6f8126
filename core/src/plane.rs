//! The plane layer: fold one sample plane into some rows of the image.
//!
//! It keeps nothing between calls and reads the voxels by reference, so a host may run it on a volume in memory, tile
//! by tile, on all its cores; the stream layer runs it on its ring. A pipeline is a type: precision, classifier,
//! shader and order of compositing ([`Composite`]), or an extreme of the samples ([`Project`]). Who names one pays for
//! that one.
//!
//! Only what the scene needs, and the same bits with all of it or without: a row whose voxels all classify to nothing
//! is not interpolated, nor is one whose rays are all finished; colours, gradients and shading are computed for spans
//! of visible samples (opacity above 0 on a ray that is not finished). Who knows the whole volume can leave out blocks of
//! rows too ([`Pipeline::fold_seen`]).

mod blocks;
mod composite;
mod meeting;
mod normals;
mod probe;
mod project;
mod sampler;
mod spans;

use core::fmt::Debug;

pub use self::composite::Composite;
pub use self::project::Project;
use crate::classify::Support;
use crate::composite::{Pixel, Recurrence};
use crate::lanes::Lanes;
use crate::locate::Plane;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::take;
use crate::seen::Seen;
use crate::slice::Window;
use crate::tap::Tap;

/// The channel format of a precision.
pub type ChannelOf<P> = <<P as Precision>::Pixel as Recurrence>::Channel;

/// A pipeline: what is done with a sample plane.
pub trait Pipeline: Sync {
    /// Its number formats.
    type Precision: Precision;
    /// What a base-plane image is made of. A row of the image is `CHANNELS` runs of `width` elements.
    type Element: Copy + Debug + Send + Sync + 'static;
    /// Runs in a row of the image.
    const CHANNELS: usize;
    /// Slices that must be at hand at a time: 2, or 4 for gradients.
    const SLICES: usize;
    /// Rows of scratch memory.
    const SCRATCH_ROWS: usize;
    /// Words of scratch memory for [`Pipeline::fold_seen`].
    const SEEN_SCRATCH: usize = 0;
    /// Whether planes go from the last to the first.
    const BACK_TO_FRONT: bool;
    /// Which voxel ranges can change the image; `None` where any can.
    fn support(&self) -> Option<Support> {
        None
    }
    /// What an element of an untouched image holds, for the run of that number.
    fn empty(channel: usize) -> Self::Element;

    /// Folds a plane into rows, `V::COUNT` samples at a time; the bits do not depend on `V`. `scratch` holds at least
    /// [`scratch_len`] words; with less, nothing is folded.
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        tap: &mut T,
    );

    /// Like [`Pipeline::fold`], for planes of which little is seen: only the blocks in `seen` are looked at, and rows are
    /// not interpolated as a whole. The same bits if `seen` holds all blocks that its [`support`](Pipeline::support)
    /// meets; slower than `fold` where they are many. `scratch` holds at least `SEEN_SCRATCH` words; with less, nothing
    /// is folded. Only where `support` says something.
    fn fold_seen<V: Lanes>(
        &self,
        _plan: &Plan,
        _plane: &Plane,
        _window: &Window<'_>,
        _seen: Seen<'_>,
        _rows: Rows<'_, Self::Element>,
        _scratch: &mut [i32],
    ) {
    }

    /// Whether no further plane can change these whole rows.
    fn finished<V: Lanes>(&self, _plan: &Plan, _data: &[Self::Element]) -> bool {
        false
    }

    /// The pixel in a column of a finished row.
    fn pixel(&self, row: &[Self::Element], column: usize) -> Pixel<ChannelOf<Self::Precision>>;
}

impl<L: Pipeline> Pipeline for &L {
    type Precision = L::Precision;
    type Element = L::Element;
    const CHANNELS: usize = L::CHANNELS;
    const SLICES: usize = L::SLICES;
    const SCRATCH_ROWS: usize = L::SCRATCH_ROWS;
    const SEEN_SCRATCH: usize = L::SEEN_SCRATCH;
    const BACK_TO_FRONT: bool = L::BACK_TO_FRONT;

    fn support(&self) -> Option<Support> {
        L::support(self)
    }

    fn empty(channel: usize) -> Self::Element {
        L::empty(channel)
    }

    #[inline(always)]
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        tap: &mut T,
    ) {
        L::fold::<V, T>(self, plan, plane, window, rows, scratch, tap);
    }

    #[inline(always)]
    fn fold_seen<V: Lanes>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        seen: Seen<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
    ) {
        L::fold_seen::<V>(self, plan, plane, window, seen, rows, scratch);
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[Self::Element]) -> bool {
        L::finished::<V>(self, plan, data)
    }

    fn pixel(&self, row: &[Self::Element], column: usize) -> Pixel<ChannelOf<Self::Precision>> {
        L::pixel(self, row, column)
    }
}

/// Words of scratch memory that a pipeline needs for slices of this width.
pub const fn scratch_len<L: Pipeline>(width: u32) -> usize {
    L::SCRATCH_ROWS * row_len(width)
}

/// Words of a row: its voxels, and one place at each end.
const fn row_len(width: u32) -> usize {
    width as usize + 2
}

/// Cuts a row off scratch memory.
#[inline(always)]
fn take_row<'m>(memory: &mut &'m mut [i32], width: u32) -> &'m mut [i32] {
    take(memory, row_len(width))
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
pub fn clear<L: Pipeline>(plan: &Plan, data: &mut [L::Element]) {
    let [width, _] = plan.base();
    for (index, run) in data.chunks_mut((width as usize).max(1)).enumerate() {
        let channel = index.checked_rem(L::CHANNELS).unwrap_or(0);
        run.fill(L::empty(channel));
    }
}
