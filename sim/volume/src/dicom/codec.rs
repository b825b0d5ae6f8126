//! Frames packed by JPEG, JPEG-LS and JPEG 2000, unpacked by crates in Rust alone.
//!
//! What the decoders allocate follows from the size that a frame's own header states, so that size is compared with the
//! image's first. What a decoder is known to read wrongly is refused by name before.

mod codestream;
mod jpeg_header;

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};
use jpeg_decoder::Decoder;

use self::codestream::Codestream;
use self::jpeg_header::JpegHeader;
use super::NAME;
use super::file::Packing;
use super::slice::PixelForm;
use crate::error::Problem;

/// Pixels that a packed frame may have: decoders take up to 32 bytes per pixel.
const MAX_PIXELS: u64 = 1 << 24;

/// Unpacks a frame to the bits that are stored for each pixel.
pub(super) fn unpack(packing: &Packing, frame: &[u8], size: [u32; 2], form: PixelForm) -> Result<Vec<u32>, Problem> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if pixels > MAX_PIXELS {
        return Err(Problem::TooLarge {
            bytes: 32 * pixels,
            what: "unpacking one frame",
            limit: 32 * MAX_PIXELS,
        });
    }
    let cells = match packing {
        Packing::JpegLs => jpeg_ls(frame, size, form)?,
        Packing::Jpeg2000 => jpeg_2000(frame, size, form)?,
        _ => jpeg(frame, size, form)?,
    };
    if cells.len() as u64 != pixels {
        let fault = format!("a packed frame has {} pixels, expected {pixels}", cells.len());
        return Err(Problem::format(NAME, fault));
    }
    Ok(cells)
}

/// JPEG: sequential with loss at 8 bits, or lossless.
fn jpeg(frame: &[u8], size: [u32; 2], form: PixelForm) -> Result<Vec<u32>, Problem> {
    let header = JpegHeader::read(frame)?;
    header.check(size, form)?;
    header.check_jpeg()?;
    let sealed = header.sealed(frame)?;
    let mut decoder = Decoder::new(sealed.as_slice());
    let bytes = decoder.decode().map_err(|error| damaged("JPEG", &error))?;
    Ok(if header.precision == 8 {
        bytes.into_iter().map(u32::from).collect()
    } else {
        let pairs = bytes.chunks_exact(2);
        pairs
            .map(|pair| u32::from(u16::from_ne_bytes([pair[0], pair[1]])))
            .collect()
    })
}

/// JPEG-LS, lossless or with a stated loss.
fn jpeg_ls(frame: &[u8], size: [u32; 2], form: PixelForm) -> Result<Vec<u32>, Problem> {
    let header = JpegHeader::read(frame)?;
    header.check(size, form)?;
    header.check_jpeg_ls()?;
    let (pixels, ..) = jpegls::decode(frame, size[0], size[1]).map_err(|error| damaged("JPEG-LS", &error))?;
    Ok(pixels.into_iter().map(u32::from).collect())
}

/// JPEG 2000, with and without loss, up to 16 bits: samples pass through single precision, which holds those exactly.
fn jpeg_2000(frame: &[u8], size: [u32; 2], form: PixelForm) -> Result<Vec<u32>, Problem> {
    let (codestream, header) = Codestream::find(frame)?;
    header.check(codestream, size, form)?;
    let settings = DecodeSettings {
        strict: true,
        ..DecodeSettings::default()
    };
    let fail = |error| damaged("JPEG 2000", &error);
    let image = Image::new(codestream, &settings).map_err(fail)?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(fail)?;
    let component = decoded.components().first();
    let samples = component.map_or(&[][..], |component| component.samples());
    // The decoder shifts signed samples, too, by half of their range.
    let range = 1_i64 << header.precision;
    let shift = if header.signed { range / 2 } else { 0 };
    let cell = |&sample: &f32| ((sample.round() as i64).clamp(0, range - 1) - shift) as u32;
    Ok(samples.iter().map(cell).collect())
}

/// A decoder's complaint, in one line.
fn damaged(packing: &str, error: &dyn std::fmt::Display) -> Problem {
    let error = error.to_string().replace(['\n', '\r'], " ");
    Problem::format(
        NAME,
        format!("{packing} data are damaged or of a kind that is not read: {error}"),
    )
}

/// Compares a packed frame with the image that it should hold.
fn compare(
    packing: &str,
    size: [u32; 2],
    components: u32,
    precision: u32,
    expected: [u32; 2],
    form: PixelForm,
) -> Result<(), Problem> {
    let [columns, rows] = expected;
    if size != expected || components != 1 {
        let fault = format!(
            "a {packing} frame has {} x {} pixels of {components} components, expected {columns} x {rows} of 1",
            size[0], size[1]
        );
        return Err(Problem::format(NAME, fault));
    }
    let room = 8 * form.bytes as u32;
    if !(2..=room.min(16)).contains(&precision) {
        let fault = format!("a {packing} frame has {precision} bits, expected 2 to {}", room.min(16));
        return Err(Problem::format(NAME, fault));
    }
    Ok(())
}
