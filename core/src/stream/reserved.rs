//! Memory of a stream whose size the compiler counts.

use super::Memory;
use crate::slice::RowRange;

/// Memory of a stream, reserved before the program runs: slices, row ranges, scratch and image, in elements. With a `const`
/// plan the sizes are those of its [`Needs`](super::Needs):
///
/// ```
/// use slicecast::classify::{Linear, PointTable, Sqrt16};
/// use slicecast::composite::{FrontToBack, Unorm16};
/// use slicecast::format::Direction;
/// use slicecast::plan::{Plan, Sampling, Spacing};
/// use slicecast::plane::Composite;
/// use slicecast::precision::Compact;
/// use slicecast::shade::Unlit;
/// use slicecast::stream::{Needs, Reserved};
/// use slicecast::view::View;
///
/// type Unshaded<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Unlit, FrontToBack>;
///
/// const PLAN: Plan = match View::new([Direction::ZERO, Direction::ONE, Direction::ZERO]) {
///     Ok(view) => match Plan::new(view, [64; 3], Spacing::CUBIC, Sampling { planes_per_voxel: 1, rays_per_voxel: 1 }) {
///         Ok(plan) => plan,
///         Err(_) => panic!("sizes or rates"),
///     },
///     Err(_) => panic!("direction"),
/// };
/// const NEEDS: Needs = Needs::of::<Unshaded<'_>>(&PLAN);
/// static MEMORY: Reserved<Unorm16, { NEEDS.slices }, { NEEDS.ranges }, { NEEDS.scratch }, { NEEDS.image }> =
///     Reserved::new(Unorm16(0));
///
/// // What does not fit is a fault of the build: two slices of 64 x 64 and an image of four channels.
/// assert_eq!(NEEDS.bytes(), [16384, 512, 1848, 32768]);
/// assert_eq!(size_of_val(&MEMORY), 51512);
/// ```
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
    /// Zeroed memory: with an element of zeroes it takes no place in flash.
    pub const fn new(element: E) -> Self {
        Self {
            slices: [0; SLICES],
            ranges: [RowRange { low: 0, high: 0 }; RANGES],
            scratch: [0; SCRATCH],
            image: [element; IMAGE],
        }
    }

    /// Lends it.
    pub const fn lend(&mut self) -> Memory<'_, E> {
        Memory {
            slices: &mut self.slices,
            ranges: &mut self.ranges,
            scratch: &mut self.scratch,
            image: &mut self.image,
        }
    }
}
