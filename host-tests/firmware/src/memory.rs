//! Memory for a stream, reserved before the program runs.

use slicecast::stream::Memory;
pub use slicecast::stream::Reserved;

/// The same memory with another image: precisions differ in their pixels.
pub fn with_image<'m, A, B>(memory: Memory<'m, A>, image: &'m mut [B]) -> Memory<'m, B> {
    Memory {
        slices: memory.slices,
        ranges: memory.ranges,
        scratch: memory.scratch,
        image,
    }
}
