//! Memory for a stream, reserved before the program runs.

use slicecast::slice::RowRange;
use slicecast::stream::Memory;

/// Memory of a stream, in elements: slices, row ranges, scratch, image.
#[derive(Debug)]
pub struct Reserved<E, const SLICES: usize, const RANGES: usize, const SCRATCH: usize, const IMAGE: usize> {
    slices: [u16; SLICES],
    ranges: [RowRange; RANGES],
    scratch: [i32; SCRATCH],
    image: [E; IMAGE],
}

impl<E: Copy, const SLICES: usize, const RANGES: usize, const SCRATCH: usize, const IMAGE: usize>
    Reserved<E, SLICES, RANGES, SCRATCH, IMAGE>
{
    /// Zeroed memory: it takes no place in flash.
    pub const fn new(zero: E) -> Self {
        Self {
            slices: [0; SLICES],
            ranges: [RowRange { low: 0, high: 0 }; RANGES],
            scratch: [0; SCRATCH],
            image: [zero; IMAGE],
        }
    }

    /// Lends it.
    pub fn lend(&mut self) -> Memory<'_, E> {
        Memory {
            slices: &mut self.slices,
            ranges: &mut self.ranges,
            scratch: &mut self.scratch,
            image: &mut self.image,
        }
    }
}

/// The same memory with another image: precisions differ in their pixels.
pub fn with_image<'m, A, B>(memory: Memory<'m, A>, image: &'m mut [B]) -> Memory<'m, B> {
    Memory {
        slices: memory.slices,
        ranges: memory.ranges,
        scratch: memory.scratch,
        image,
    }
}
