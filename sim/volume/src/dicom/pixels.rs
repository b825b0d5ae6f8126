//! Stored pixels to integers: bit fields, signs, and the RLE of PS3.5, annex G.

use super::NAME;
use super::element::{Elements, Encoding, Value};
use super::file::{Packing, PixelForm, Slice};
use crate::error::Problem;

/// The pixels of a file as integers, row after row.
pub(super) fn decode(slice: &Slice, bytes: &[u8]) -> Result<Vec<i64>, Problem> {
    let packed = Slice::pixels(bytes)?;
    let count = slice.columns as usize * slice.rows as usize;
    let expected = count * slice.form.bytes;
    let plain = match slice.packing {
        Packing::Plain => packed,
        Packing::Rle => unpack(&packed, count, slice.form)?,
    };
    // Pixel data are padded to an even length.
    if plain.len() != expected && plain.len() != expected + 1 {
        let (found, columns, rows) = (plain.len(), slice.columns, slice.rows);
        let bits = 8 * slice.form.bytes;
        let fault = format!("has {found} bytes of pixels, expected {expected} for {columns} x {rows} of {bits} bits");
        return Err(Problem::format(NAME, fault));
    }
    Ok(plain[..expected]
        .chunks_exact(slice.form.bytes)
        .map(|pixel| slice.form.value(pixel))
        .collect())
}

impl PixelForm {
    /// The number that a pixel's bits stand for.
    fn value(&self, pixel: &[u8]) -> i64 {
        let place = |bits: u32, &byte: &u8| bits << 8 | u32::from(byte);
        let bits = if self.big {
            pixel.iter().fold(0, place)
        } else {
            pixel.iter().rev().fold(0, place)
        };
        let field = i64::from(bits >> self.shift) & ((1 << self.stored) - 1);
        let sign = 1 << (self.stored - 1);
        if self.signed && field & sign != 0 {
            field - 2 * sign
        } else {
            field
        }
    }
}

/// Unpacks the one frame of RLE pixel data to little-endian pixels.
fn unpack(packed: &[u8], count: usize, form: PixelForm) -> Result<Vec<u8>, Problem> {
    let damaged = |fault: &str| Problem::format(NAME, format!("RLE pixel data {fault}"));
    // The first item is the table of offsets; the frame is the second.
    let mut items = Elements::new(packed, Encoding::EXPLICIT);
    let _offsets = items.next()?;
    let Some((_, Value::Bytes(frame))) = items.next()? else {
        return Err(damaged("have no frame"));
    };
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
    let mut out = vec![0; count * form.bytes];
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
        let byte = form.bytes - 1 - segment;
        let mut pixels = out.iter_mut().skip(byte).step_by(form.bytes);
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
                    pixels.by_ref().take(repeat).for_each(|pixel| *pixel = value);
                    left = left.saturating_sub(repeat);
                }
                -128 => {}
                literal => {
                    let len = literal as usize + 1;
                    let values = bytes
                        .as_slice()
                        .get(..len)
                        .ok_or_else(|| damaged("end inside a literal run"))?;
                    for (pixel, &value) in pixels.by_ref().zip(values) {
                        *pixel = value;
                    }
                    bytes = bytes.as_slice()[len..].iter();
                    left = left.saturating_sub(len);
                }
            }
        }
    }
    if form.big {
        out.chunks_exact_mut(form.bytes).for_each(<[u8]>::reverse);
    }
    Ok(out)
}
