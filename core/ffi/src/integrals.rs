//! Tables of integrals as C structures.

use slicecast::integral::{Colours, Integral, Length};

use crate::error::{SLICECAST_LISTS, SlicecastError};
use crate::slice;

/// A transfer function's integrals, by which segments between two samples are classified: one table for every view, step and
/// number of planes per voxel. docs/contract/integral.md; `slicecast table --classification integral --format c` writes it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastIntegrals {
    /// Nodes of a list: 4096 divided by the codes of a bin, and one.
    pub nodes: usize,
    /// 1: extinction alone, and all values have one colour; 4: extinction, and extinction times red, green and blue.
    pub lists: u32,
    /// log2 of the codes of a bin, 0 to 4.
    pub grain: u32,
    /// log2 of what the integrals were multiplied by, 15 to 28.
    pub exponent: u32,
    /// The colour of all values, red, green, blue, 1.31; read where `lists` is 1.
    pub colour: [u32; 3],
    /// Integrals of the extinction per smallest voxel spacing up to each node; they never fall.
    pub extinction: *const u32,
    /// Integrals of extinction times red, green, blue; read where `lists` is 4.
    pub colours: [*const u32; 3],
}

impl SlicecastIntegrals {
    /// The table for segments of a length; `argument` is the place of this structure, or of what it belongs to.
    ///
    /// # Safety
    /// The lists are null, misaligned, or point to `nodes` values that stay readable and unchanged.
    pub(crate) unsafe fn table(
        &self,
        argument: u32,
        length: Length,
    ) -> Result<Integral<&'static [u32]>, SlicecastError> {
        // SAFETY: the caller's promise.
        let list = |nodes: *const u32| unsafe { slice(nodes, self.nodes, argument) };
        let colours = match self.lists {
            1 => Colours::One(self.colour),
            4 => {
                let [red, green, blue] = self.colours;
                Colours::Each([list(red)?, list(green)?, list(blue)?])
            }
            given => return Err(SlicecastError::numbers(SLICECAST_LISTS, 4, given.into())),
        };
        Ok(Integral::new(
            list(self.extinction)?,
            colours,
            self.grain,
            self.exponent,
            length,
        )?)
    }
}
