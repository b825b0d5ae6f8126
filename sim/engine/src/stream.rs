//! Frames through the stream layer, slice by slice, as firmware makes them.

use slicecast::plane::Pipeline;
use slicecast::slice::{RowRange, Slice, Voxel as _};
use slicecast::stream::{Memory, Needs, Stream, StreamError};
use slicecast::tap::Tap;

use crate::oriented::packed;
use crate::tiles::Geometry;

/// Renders through the stream layer, perhaps under a tap.
///
/// # Errors
/// [`StreamError`] if a slice is refused.
pub fn fold_stream<L: Pipeline>(
    Geometry { plan, clips }: Geometry<'_>,
    pipeline: &L,
    slices: &[Slice<'_, L::Voxel>],
    image: &mut [L::Element],
    progress: &(dyn Fn(usize, usize) + Sync),
    mut tap: Option<&mut dyn Tap>,
) -> Result<(), StreamError> {
    let needs = Needs::of::<L>(plan);
    let (mut ring, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let mut scratch = vec![0; needs.scratch];
    let memory = Memory {
        slices: &mut ring,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image,
    };
    let mut stream = Stream::new(*plan, pipeline, memory)?;
    if let Some(clips) = clips {
        stream.clip(clips.clipper())?;
    }
    let mut pushed = 0;
    while let Some(wanted) = stream.wanted() {
        // What is held of the volume begins with this slice.
        let [_, _, first] = plan.first();
        let slice = slices.get((wanted - first) as usize).ok_or(StreamError::Complete)?;
        match &mut tap {
            Some(tap) => stream.push_tapped(L::Voxel::given(&packed(slice)), *tap)?,
            None => stream.push(L::Voxel::given(&packed(slice)))?,
        }
        pushed += 1;
        progress(pushed, slices.len());
    }
    Ok(())
}
