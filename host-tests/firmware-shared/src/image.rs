//! Checksums of images.

use slicecast::composite::Channel;
use slicecast::format::Intensity;
use slicecast::plane::{ChannelOf, Pictured};
use slicecast::stream::Stream;
use slicecast::warp::{Warp, in_front_of};

use crate::sum::Sum;

/// Adds base-plane rows, as they lie in memory, to a sum. An image in one piece and the same image in bands (of one
/// phase) have the same sum.
pub fn add_rows<C: Channel>(sum: &mut Sum, rows: &[C]) {
    for element in rows {
        sum.word(element.bits());
    }
}

/// Sum of the viewer's picture of a finished frame, 8 bits per channel.
pub fn picture<L: Pictured>(stream: &Stream<'_, L>, size: [u32; 2], warp: &Warp, background: [Intensity; 3]) -> u32 {
    let mut sum = Sum::new();
    let [width, height] = size;
    for y in 0..height {
        for x in 0..width {
            let pixel = warp.pixel::<ChannelOf<L::Precision>>(x, y, |u, v| stream.pixel(u, v));
            add_rgb(&mut sum, in_front_of(pixel, background));
        }
    }
    sum.get()
}

/// Adds a pixel of the viewer's picture to a sum.
pub fn add_rgb(sum: &mut Sum, [r, g, b]: [u8; 3]) {
    sum.word(u32::from_le_bytes([r, g, b, 0]));
}
