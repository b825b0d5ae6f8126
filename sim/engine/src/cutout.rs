//! The picture without its background: what pictures of more than 8 bits, or with an opacity, are made from.
//!
//! It is the final warp of core by its definition, pixel by pixel. In front of the scene's background and rounded to
//! 8 bits it is [`Framing::picture`](crate::rendering::Framing::picture), to the last bit (`tests/frames.rs`).

use rayon::prelude::*;
use slicecast::composite::Pixel;

use crate::camera::Picture;
use crate::image::BaseImage;

/// A picture as bits of a channel whose 1.0 is [`one`](Cutout::one).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cutout {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// The bits of 1.0.
    pub one: u32,
    /// Red, green, blue, multiplied by the opacity, and transparency; row after row.
    pub pixels: Vec<[u32; 4]>,
}

impl Cutout {
    /// The picture of a base-plane image.
    pub fn of(base: &BaseImage, picture: &Picture) -> Self {
        let [width, height] = picture.size;
        let pixel = |u: i64, v: i64| {
            let [red, green, blue, transparency] = at(base, u, v).unwrap_or([0, 0, 0, base.one]);
            Pixel {
                colour: [red, green, blue],
                transparency,
            }
        };
        let mut pixels = vec![[0; 4]; width as usize * height as usize];
        pixels
            .par_chunks_mut((width as usize).max(1))
            .zip(0..height)
            .for_each(|(row, y)| {
                for (out, x) in row.iter_mut().zip(0..width) {
                    // A mixture is the same in every channel's format: here all are 32 bits wide.
                    let Pixel {
                        colour: [red, green, blue],
                        transparency,
                    } = picture.warp.pixel::<u32>(x, y, pixel);
                    *out = [red, green, blue, transparency];
                }
            });
        Self {
            size: picture.size,
            one: base.one,
            pixels,
        }
    }
}

/// A pixel of a base-plane image, if it has one there.
fn at(base: &BaseImage, u: i64, v: i64) -> Option<[u32; 4]> {
    let [width, height] = base.size;
    let u = usize::try_from(u).ok().filter(|u| *u < width)?;
    let v = usize::try_from(v).ok().filter(|v| *v < height)?;
    Some(base.planes.each_ref().map(|plane| plane[v * width + u]))
}
