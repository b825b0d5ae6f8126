//! Base-plane images of pipelines.

use slicecast::plan::Plan;
use slicecast::stream::Needs;

use crate::error::RenderError;
use crate::folds::Folds;
use crate::image::BaseImage;

/// The largest base-plane image that is rendered, bytes.
const IMAGE_BYTES_MAX: u64 = 4 << 30;

/// An untouched base-plane image.
///
/// # Errors
/// [`RenderError::Memory`] before anything too large is allocated.
pub(crate) fn new_image<F: Folds + ?Sized>(plan: &Plan, pipeline: &F) -> Result<Vec<F::Element>, RenderError> {
    let [_, height] = plan.base();
    let needs = Needs::of_shape(pipeline.shape(), plan, height);
    let bytes = needs.image as u64 * needs.element_bytes as u64;
    if bytes > IMAGE_BYTES_MAX {
        return Err(RenderError::Memory {
            bytes,
            limit: IMAGE_BYTES_MAX,
        });
    }
    let mut image = vec![F::Element::default(); needs.image];
    pipeline.clear(plan, &mut image);
    Ok(image)
}

/// The base-plane image with its phases interleaved.
pub(crate) fn base_image<F: Folds + ?Sized>(plan: &Plan, pipeline: &F, image: &[F::Element]) -> BaseImage {
    let n = plan.sampling().rays_per_voxel as usize;
    let (shape, [base_width, rows]) = (pipeline.shape(), plan.base());
    let [width, height] = [base_width, rows].map(|side| side as usize * n);
    let (format, one) = pipeline.format();
    let mut planes = [(); 4].map(|()| Vec::with_capacity(width * height));
    for v in 0..height as i64 {
        for u in 0..width as i64 {
            let Some((start, column)) = shape.place(plan, 0..rows, [u, v]) else {
                unreachable!("the image has all of its pixels");
            };
            let row = &image[start..start + shape.row_len(plan)];
            for (plane, bits) in planes.iter_mut().zip(pipeline.pixel(row, column)) {
                plane.push(bits);
            }
        }
    }
    BaseImage {
        size: [width, height],
        format,
        one,
        planes,
    }
}
