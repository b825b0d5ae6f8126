//! The picture without its background: what pictures of more than 8 bits, or with an opacity, are made from.
//!
//! It is the final warp of core by its definition, pixel by pixel. In front of the scene's background and rounded to
//! 8 bits it is [`Framing::picture`](crate::rendering::Framing::picture), to the last bit (tests).

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Layer, Prepared};
    use crate::image::Frame;
    use slicecast_scene::{Blend, Image, Point, PrecisionName, Sampling, Scene, TransferFunction, View};
    use slicecast_volume::{Mapping, Volume};

    /// A ball in a box, seen askew.
    fn framed(precision: PrecisionName, background: [f64; 3], check: impl Fn(&Frame, &Picture)) {
        let voxel = |index: usize| {
            let place = [index % 9, index / 9 % 9, index / 81].map(|c| c as f64 - 4.0);
            (4000.0 - 60.0 * place.iter().map(|c| c * c).sum::<f64>()).max(0.0) as u16
        };
        let volume = Volume {
            name: "ball".into(),
            dims: [9; 3],
            spacing: [1.0, 1.0, 1.5],
            voxels: (0..729).map(voxel).collect(),
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        };
        let point = |value, colour, opacity| Point { value, colour, opacity };
        let scene = Scene {
            view: View {
                azimuth: 37.0,
                elevation: 21.0,
                roll: 5.0,
            },
            image: Image {
                size: Some([61, 47]),
                background,
                ..Image::default()
            },
            sampling: Sampling {
                planes_per_voxel: 1,
                rays_per_voxel: 2,
            },
            transfer: TransferFunction {
                unit_distance: 1.0,
                points: vec![point(1500.0, [1.0, 0.5, 0.2], 0.0), point(4000.0, [0.3, 0.7, 1.0], 0.4)],
            },
            lighting: None,
            blend: Blend::FrontToBack,
            precision,
            table: None,
            lookup: None,
            interpolation: slicecast_scene::Interpolation::Linear,
            early_termination: None,
        };
        let prepared = Prepared::new(&scene, &volume).unwrap();
        let frame = prepared.render(Layer::Tiles(8), &|_, _| {}).unwrap();
        check(&frame, &prepared.setup.picture);
    }

    #[test]
    fn in_front_of_the_background_it_is_the_picture() {
        let background = [0.25, 1.0, 0.625];
        for precision in PrecisionName::ALL {
            framed(precision, background, |frame, picture| {
                let cutout = Cutout::of(&frame.base, picture);
                let one = u64::from(cutout.one);
                let bytes = cutout.pixels.iter().flat_map(|[red, green, blue, transparency]| {
                    [(red, 0.25), (green, 1.0), (blue, 0.625)].map(|(channel, behind): (_, f64)| {
                        let behind = (u64::from(*transparency) * (behind * 32768.0) as u64 + (1 << 14)) >> 15;
                        let sum = (u64::from(*channel) + behind).min(one);
                        ((sum * 255 + one / 2) / one) as u8
                    })
                });
                assert_eq!(bytes.collect::<Vec<_>>(), frame.picture.bytes, "{}", precision.name());
                let opaque = cutout.pixels.iter().filter(|pixel| pixel[3] < cutout.one).count();
                assert!((500..2000).contains(&opaque), "{opaque}");
            });
        }
    }
}
