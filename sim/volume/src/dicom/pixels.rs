//! Stored pixels to integers: bit fields, signs, and the RLE of PS3.5, annex G.

use super::element::{Elements, PIXEL_DATA};
use super::file::{File, Packing};
use super::frames::Frames;
use super::slice::{PixelForm, Slice};
use super::{Found, NAME, codec};
use crate::error::Problem;

/// Reads the pixels of slices of one file, in the order of the slices; returns how many bytes of padding follow them.
pub(super) fn decode(
    bytes: &[u8],
    slices: &[Found],
    mut take: impl FnMut(&Slice, Vec<i64>) -> Result<(), Problem>,
) -> Result<usize, Problem> {
    let file = File::open(bytes)?;
    file.packing.check()?;
    let mut elements = Elements::new(&file.data, file.encoding);
    let pixels = loop {
        match elements.next()? {
            Some((PIXEL_DATA, value)) => break value,
            Some(_) => {}
            None => {
                return Err(Problem::format(
                    NAME,
                    "has no pixel data (7FE0,0010), expected an image",
                ));
            }
        }
    };
    let Some(Found { slice: first, .. }) = slices.first() else {
        return Ok(0);
    };
    let frames = match file.packing {
        Packing::Plain => Frames::plain(pixels, first)?,
        _ => Frames::packed(pixels, first.frames)?,
    };
    for Found { slice, .. } in slices {
        let frame = frames.bytes(slice.frame);
        let [columns, rows] = [slice.columns, slice.rows];
        let cells = match file.packing {
            Packing::Plain => plain(&frame, slice.form),
            Packing::Rle => unpack(&frame, columns as usize * rows as usize, slice.form)?,
            ref packing => codec::unpack(packing, &frame, [columns, rows], slice.form)?,
        };
        take(slice, cells.into_iter().map(|cell| slice.form.value(cell)).collect())?;
    }
    Ok(match frames {
        // An even length is asked for.
        Frames::Plain { padding, .. } if padding > 1 => padding,
        _ => 0,
    })
}

/// Plain pixels as the bits that are stored for each.
fn plain(bytes: &[u8], form: PixelForm) -> Vec<u32> {
    let place = |bits: u32, &byte: &u8| bits << 8 | u32::from(byte);
    let cell = |pixel: &[u8]| match form.big {
        true => pixel.iter().fold(0, place),
        false => pixel.iter().rev().fold(0, place),
    };
    bytes.chunks_exact(form.bytes).map(cell).collect()
}

impl PixelForm {
    /// The number that a pixel's bits stand for.
    fn value(&self, cell: u32) -> i64 {
        let field = i64::from(cell >> self.shift) & ((1 << self.stored) - 1);
        let sign = 1 << (self.stored - 1);
        if self.signed && field & sign != 0 {
            field - 2 * sign
        } else {
            field
        }
    }
}

/// Unpacks a frame of RLE pixel data.
fn unpack(frame: &[u8], count: usize, form: PixelForm) -> Result<Vec<u32>, Problem> {
    let damaged = |fault: &str| Problem::format(NAME, format!("RLE pixel data {fault}"));
    let word = |i: usize| {
        let bytes = frame.get(4 * i..4 * i + 4)?;
        Some(u32::from_le_bytes(<[u8; 4]>::try_from(bytes).ok()?) as usize)
    };
    let segments = word(0).ok_or_else(|| damaged("end inside their header"))?;
    if segments != form.bytes {
        return Err(damaged(&format!("have {segments} segments, expected {}", form.bytes)));
    }
    // A run of 128 pixels takes two bytes.
    if count * form.bytes > 64 * frame.len() {
        return Err(damaged(&format!("of {} bytes cannot hold {count} pixels", frame.len())));
    }
    let mut out = vec![0_u32; count];
    for segment in 0..segments {
        let start = word(segment + 1).unwrap_or(usize::MAX);
        let end = if segment + 1 < segments {
            word(segment + 2).unwrap_or(0)
        } else {
            frame.len()
        };
        let part = frame
            .get(start..end)
            .ok_or_else(|| damaged("have a segment outside their frame"))?;
        // The first segment holds the highest bytes.
        let mut pixels = out.iter_mut();
        let place = |pixel: &mut u32, byte: u8| *pixel = *pixel << 8 | u32::from(byte);
        let mut left = count;
        let mut bytes = part.iter();
        while left > 0 {
            let Some(&code) = bytes.next() else {
                return Err(damaged(&format!("end {left} pixels early")));
            };
            match code as i8 {
                run @ -127..=-1 => {
                    let repeat = (1 - isize::from(run)) as usize;
                    let &value = bytes.next().ok_or_else(|| damaged("end inside a run"))?;
                    pixels.by_ref().take(repeat).for_each(|pixel| place(pixel, value));
                    left = left.saturating_sub(repeat);
                }
                -128 => {}
                literal => {
                    let len = literal as usize + 1;
                    let values = bytes
                        .as_slice()
                        .get(..len)
                        .ok_or_else(|| damaged("end inside a literal run"))?;
                    pixels
                        .by_ref()
                        .zip(values)
                        .for_each(|(pixel, &value)| place(pixel, value));
                    bytes = bytes.as_slice()[len..].iter();
                    left = left.saturating_sub(len);
                }
            }
        }
    }
    Ok(out)
}
