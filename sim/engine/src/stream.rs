//! Frames through the stream layer, slice by slice, as firmware makes them.

use slicecast::clip::Clips;
use slicecast::slice::{RowRange, Slice, Voxel as _};
use slicecast::stream::{Memory, Needs, StreamError};
use slicecast::tap::Tap;

use crate::folds::Folds;
use crate::oriented::packed;
use crate::tiles::Geometry;

/// Renders through the stream layer, perhaps under a tap.
///
/// # Errors
/// [`StreamError`] if a slice is refused.
pub fn fold_stream<F: Folds + ?Sized>(
    Geometry { plan, clips }: Geometry<'_>,
    pipeline: &F,
    slices: &[Slice<'_, F::Voxel>],
    image: &mut [F::Element],
    progress: &(dyn Fn(usize, usize) + Sync),
    mut tap: Option<&mut dyn Tap>,
) -> Result<(), StreamError> {
    let [_, height] = plan.base();
    let needs = Needs::of_shape(pipeline.shape(), plan, height);
    let (mut ring, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let mut scratch = vec![0; needs.scratch];
    let memory = Memory {
        slices: &mut ring,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image,
    };
    let mut stream = pipeline.stream(*plan, memory, clips.map(Clips::clipper))?;
    let mut pushed = 0;
    while let Some(wanted) = stream.wanted() {
        // What is held of the volume begins with this slice.
        let [_, _, first] = plan.first();
        let slice = slices.get((wanted - first) as usize).ok_or(StreamError::Complete)?;
        let tap: Option<&mut dyn Tap> = match &mut tap {
            Some(tap) => Some(*tap),
            None => None,
        };
        stream.push(F::Voxel::given(&packed(slice)), tap)?;
        pushed += 1;
        progress(pushed, slices.len());
    }
    Ok(())
}
