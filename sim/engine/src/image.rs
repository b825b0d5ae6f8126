//! Base-plane images and pictures.

use slicecast::composite::{Channel, Pixel, Recurrence as _};
use slicecast::format::Intensity;
use slicecast::plan::Plan;
use slicecast::plane::{Pipeline, clear};
use slicecast::precision::Precision as _;
use slicecast::stream::{Needs, base_pixel};

use crate::error::RenderError;

/// The largest base-plane image that is rendered, bytes.
const IMAGE_BYTES_MAX: u64 = 4 << 30;

/// The base-plane image of a frame, all phases interleaved, as raw bits of the precision's channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseImage {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// The channel's format: its name, and the bits of 1.0.
    pub format: &'static str,
    /// See [`BaseImage::format`].
    pub one: u32,
    /// Red, green, blue and transparency, row after row.
    pub planes: [Vec<u32>; 4],
}

/// An 8-bit RGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Red, green, blue, pixel after pixel.
    pub bytes: Vec<u8>,
}

/// A rendered frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What the pipeline made.
    pub base: BaseImage,
    /// What the viewer sees.
    pub picture: Rgb,
}

/// An untouched base-plane image.
///
/// # Errors
/// [`RenderError::Memory`] before anything too large is allocated.
pub(crate) fn new_image<L: Pipeline>(plan: &Plan, pipeline: &L) -> Result<Vec<L::Element>, RenderError> {
    let needs = Needs::of::<L>(plan);
    let bytes = needs.image as u64 * needs.element_bytes as u64;
    if bytes > IMAGE_BYTES_MAX {
        return Err(RenderError::Memory {
            bytes,
            limit: IMAGE_BYTES_MAX,
        });
    }
    let mut image = vec![L::Element::default(); needs.image];
    clear(pipeline, plan, &mut image);
    Ok(image)
}

/// The base-plane image with its phases interleaved.
pub(crate) fn base_image<L: Pipeline>(plan: &Plan, pipeline: &L, image: &[L::Element]) -> BaseImage {
    let n = plan.sampling().rays_per_voxel as usize;
    let size = plan.base().map(|side| side as usize * n);
    let pixel = pipeline.precision().pixel();
    BaseImage {
        size,
        format: pixel.format(),
        one: pixel.one().bits(),
        planes: planes(size, &|[u, v]| {
            let Pixel {
                colour: [r, g, b],
                transparency,
            } = base_pixel(plan, pipeline, image, u as i64, v as i64);
            [r.bits(), g.bits(), b.bits(), transparency.bits()]
        }),
    }
}

/// The channels of all pixels, compiled once.
fn planes([width, height]: [usize; 2], pixel: &dyn Fn([usize; 2]) -> [u32; 4]) -> [Vec<u32>; 4] {
    let mut planes = [(); 4].map(|()| Vec::with_capacity(width * height));
    for v in 0..height {
        for u in 0..width {
            for (plane, bits) in planes.iter_mut().zip(pixel([u, v])) {
                plane.push(bits);
            }
        }
    }
    planes
}

/// A background of 0 to 1, 1.15.
pub fn background(colour: [f64; 3]) -> [Intensity; 3] {
    colour.map(|c| Intensity::from_bits((c * 32768.0).round() as u16))
}
