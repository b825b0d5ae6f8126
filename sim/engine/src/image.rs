//! Base-plane images and pictures.

use slicecast::format::Intensity;

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

/// A background of 0 to 1, 1.15.
pub fn background(colour: [f64; 3]) -> [Intensity; 3] {
    colour.map(|c| Intensity::from_bits((c * 32768.0).round() as u16))
}
