//! Frames through the stream layer, slice by slice, as firmware makes them.

use slicecast::plan::Plan;
use slicecast::plane::{At, Rows, ScratchError, Shape};
use slicecast::slice::{RowRange, Slice, Voxel as _};
use slicecast::stream::{Memory, Needs, Stream, StreamError, Streamed};
use slicecast::tap::Tap;

use crate::folds::{Fold, Folds};
use crate::geometry::Geometry;
use crate::oriented::packed;
use crate::simd::Simd;

/// A pipeline that is an object: streams of all of them are one.
struct Object<'f, F: ?Sized>(&'f F);

impl<F: Folds + ?Sized> Streamed for Object<'_, F> {
    type Voxel = F::Voxel;
    type Element = F::Element;

    fn shape(&self) -> Shape {
        self.0.shape()
    }

    fn clear(&self, plan: &Plan, data: &mut [F::Element]) {
        self.0.clear(plan, data);
    }

    fn fold_plane(
        &self,
        at: &At<'_, F::Voxel>,
        rows: Rows<'_, F::Element>,
        scratch: &mut [i32],
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        let tap = tap.map(|tap| tap as &mut dyn Tap);
        let fold = Fold {
            at,
            rows,
            scratch,
            kept: None,
            tap,
        };
        self.0.fold(Simd::Scalar, fold)
    }
}

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
    let mut stream = Stream::new(*plan, Object(pipeline), memory)?;
    if let Some(clips) = clips {
        stream.clip(clips.clipper())?;
    }
    let mut pushed = 0;
    while let Some(wanted) = stream.wanted() {
        // What is held of the volume begins with this slice.
        let [_, _, first] = plan.first();
        let slice = slices.get((wanted - first) as usize).ok_or(StreamError::Complete)?;
        let (slice, tap) = (packed(slice), tap.as_mut());
        match tap {
            Some(tap) => stream.push_tapped(F::Voxel::given(&slice), *tap)?,
            None => stream.push(F::Voxel::given(&slice))?,
        }
        pushed += 1;
        progress(pushed, slices.len());
    }
    Ok(())
}
