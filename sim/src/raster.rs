//! Pictures as PNG holds them: 8 or 16 bits, in front of a background or with an opacity of their own.

use slicecast_engine::camera::Picture;
use slicecast_engine::cutout::Cutout;
use slicecast_engine::image::{Frame, Rgb};

/// What a picture is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finish {
    /// Bits of a channel.
    pub depth: Depth,
    /// Whether the volume is left without a background, with an opacity for every pixel.
    pub transparent: bool,
}

/// Bits of a picture's channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits.
    Eight,
    /// 16 bits.
    Sixteen,
}

/// A picture as PNG holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster {
    size: [u32; 2],
    colour: png::ColorType,
    depth: png::BitDepth,
    bytes: Vec<u8>,
}

impl From<Rgb> for Raster {
    fn from(picture: Rgb) -> Self {
        Self {
            size: picture.size,
            colour: png::ColorType::Rgb,
            depth: png::BitDepth::Eight,
            bytes: picture.bytes,
        }
    }
}

impl Raster {
    /// A frame's picture; `background` is the scene's.
    pub fn of(frame: Frame, picture: &Picture, background: [f64; 3], finish: Finish) -> Self {
        if let (Depth::Eight, false) = (finish.depth, finish.transparent) {
            return frame.picture.into();
        }
        let cutout = Cutout::of(&frame.base, picture);
        let pixel = |pixel: &[u32; 4]| {
            if finish.transparent {
                straight(*pixel, cutout.one)
            } else {
                in_front_of(*pixel, cutout.one, background)
            }
        };
        let channels = if finish.transparent { 4 } else { 3 };
        let values = cutout
            .pixels
            .iter()
            .flat_map(|bits| pixel(bits).into_iter().take(channels));
        let (depth, bytes) = match finish.depth {
            Depth::Eight => (
                png::BitDepth::Eight,
                values.map(|value| (value * 255.0).round() as u8).collect(),
            ),
            Depth::Sixteen => (
                png::BitDepth::Sixteen,
                // Most significant byte first, as PNG has it.
                values
                    .flat_map(|value| ((value * 65535.0).round() as u16).to_be_bytes())
                    .collect(),
            ),
        };
        Self {
            size: cutout.size,
            colour: if finish.transparent {
                png::ColorType::Rgba
            } else {
                png::ColorType::Rgb
            },
            depth,
            bytes,
        }
    }

    /// Grey levels of 16 bits.
    pub fn grey16(size: [u32; 2], levels: &[u16]) -> Self {
        Self {
            size,
            colour: png::ColorType::Grayscale,
            depth: png::BitDepth::Sixteen,
            bytes: levels.iter().flat_map(|level| level.to_be_bytes()).collect(),
        }
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// A pixel in front of a background: red, green, blue, and an opacity of 1.
fn in_front_of(bits: [u32; 4], one: u32, background: [f64; 3]) -> [f64; 4] {
    let [red, green, blue, transparency] = bits.map(|channel| f64::from(channel) / f64::from(one));
    let [r, g, b] = background;
    let seen = |colour: f64, behind: f64| (colour + transparency * behind).min(1.0);
    [seen(red, r), seen(green, g), seen(blue, b), 1.0]
}

/// A pixel as PNG wants it: colours that are not multiplied by the opacity. A clear pixel is black.
fn straight(bits: [u32; 4], one: u32) -> [f64; 4] {
    let opacity = one - bits[3].min(one);
    let [red, green, blue, _] = bits.map(|channel| (f64::from(channel) / f64::from(opacity.max(1))).min(1.0));
    let [red, green, blue] = if opacity == 0 { [0.0; 3] } else { [red, green, blue] };
    [red, green, blue, f64::from(opacity) / f64::from(one)]
}

/// A PNG of a picture of 8 bits.
pub fn rgb_png(picture: Rgb) -> Result<Vec<u8>, png::EncodingError> {
    png(&picture.into())
}

/// A PNG of one picture.
pub fn png(picture: &Raster) -> Result<Vec<u8>, png::EncodingError> {
    encode(std::slice::from_ref(picture), None)
}

/// An endless animated PNG of pictures of one size, each shown for so many milliseconds.
pub fn animated(pictures: &[Raster], delay: u16) -> Result<Vec<u8>, png::EncodingError> {
    encode(pictures, Some(delay))
}

fn encode(pictures: &[Raster], delay: Option<u16>) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let Some(first) = pictures.first() else {
        return Ok(bytes);
    };
    let [width, height] = first.size;
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(first.colour);
    encoder.set_depth(first.depth);
    // Levels that are measures have no gamma.
    if first.colour != png::ColorType::Grayscale {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    if first.colour == png::ColorType::Rgba {
        let text = "straight (not premultiplied): each colour is to be multiplied by alpha";
        encoder.add_text_chunk("Alpha".into(), text.into())?;
    }
    if let Some(delay) = delay {
        encoder.set_animated(pictures.len() as u32, 0)?;
        encoder.set_frame_delay(delay, 1000)?;
    }
    let mut writer = encoder.write_header()?;
    for picture in pictures {
        writer.write_image_data(&picture.bytes)?;
    }
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast::format::Step;
    use slicecast::warp::Warp;
    use slicecast_engine::image::BaseImage;

    /// A frame of three pixels: orange and half clear, clear, white and opaque.
    fn frame() -> (Frame, Picture) {
        let base = BaseImage {
            size: [3, 1],
            format: "1.15",
            one: 32768,
            planes: [
                vec![16384, 0, 32768],
                vec![8192, 0, 32768],
                vec![0, 0, 32768],
                vec![16384, 32768, 0],
            ],
        };
        let one = [Step::ONE, Step::ZERO];
        let picture = Picture {
            size: [3, 1],
            warp: Warp {
                origin: [Step::ZERO; 2],
                right: one,
                down: [Step::ZERO, Step::ONE],
            },
            affine: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        };
        let bytes = vec![128, 64, 0, 0, 0, 0, 255, 255, 255];
        let rgb = Rgb { size: [3, 1], bytes };
        (Frame { base, picture: rgb }, picture)
    }

    fn raster(depth: Depth, transparent: bool, background: [f64; 3]) -> Raster {
        let (frame, picture) = frame();
        Raster::of(frame, &picture, background, Finish { depth, transparent })
    }

    #[test]
    fn without_a_background_colours_are_straight() {
        let eight = raster(Depth::Eight, true, [1.0; 3]);
        assert_eq!(eight.bytes, [255, 128, 0, 128, 0, 0, 0, 0, 255, 255, 255, 255]);
        let sixteen = raster(Depth::Sixteen, true, [1.0; 3]);
        let first: Vec<u16> = sixteen
            .bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| u16::from_be_bytes(*b))
            .collect();
        assert_eq!(first[..8], [65535, 32768, 0, 32768, 0, 0, 0, 0]);
    }

    #[test]
    fn sixteen_bits_in_front_of_a_background() {
        let raster = raster(Depth::Sixteen, false, [0.0, 0.5, 1.0]);
        let values: Vec<u16> = raster
            .bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| u16::from_be_bytes(*b))
            .collect();
        assert_eq!(values[..6], [32768, 32768, 32768, 0, 32768, 65535]);
    }

    #[test]
    fn files_say_what_they_hold() {
        for (depth, transparent) in [
            (Depth::Eight, false),
            (Depth::Eight, true),
            (Depth::Sixteen, false),
            (Depth::Sixteen, true),
        ] {
            let raster = raster(depth, transparent, [0.0; 3]);
            let file = png(&raster).unwrap();
            let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
            let info = reader.info();
            assert_eq!((info.color_type, info.bit_depth), (raster.colour, raster.depth));
            let texts: Vec<&str> = info.uncompressed_latin1_text.iter().map(|t| &*t.keyword).collect();
            assert_eq!(texts, if transparent { vec!["Alpha"] } else { vec![] });
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut bytes).unwrap();
            assert_eq!(bytes, raster.bytes);
        }
    }
}
