//! What packed frames say of themselves, before a decoder is trusted with them.

use super::super::NAME;
use super::super::slice::PixelForm;
use crate::error::Problem;

/// The headers of a JPEG or JPEG-LS frame, up to its first scan.
#[derive(Debug, Default)]
pub(super) struct JpegHeader {
    /// The low byte of the frame's marker: 0xc0 to 0xcf, or 0xf7 of JPEG-LS.
    process: u8,
    pub precision: u8,
    size: [u32; 2],
    components: u8,
    /// Whether the scan is cut by restart markers.
    restarts: bool,
    /// Predictor, or near-lossless bound.
    selection: u8,
    /// How components are interleaved in JPEG-LS.
    interleave: u8,
    /// Low bits left out.
    point_transform: u8,
}

impl JpegHeader {
    /// Reads marker segments up to the first scan.
    pub fn read(frame: &[u8]) -> Result<Self, Problem> {
        let short = || Problem::format(NAME, "JPEG data end inside their headers");
        if !frame.starts_with(&[0xff, 0xd8]) {
            return Err(Problem::format(NAME, "a packed frame has no JPEG data, expected FFD8"));
        }
        let mut header = Self::default();
        let mut rest = &frame[2..];
        loop {
            let (marker, after) = match rest {
                [0xff, 0xff, ..] => {
                    rest = &rest[1..];
                    continue;
                }
                [0xff, marker, after @ ..] => (*marker, after),
                [] | [0xff] => return Err(short()),
                [byte, ..] => {
                    let fault = format!("JPEG data have {byte:02X} between their headers, expected a marker");
                    return Err(Problem::format(NAME, fault));
                }
            };
            let len = after
                .first_chunk()
                .map(|pair| usize::from(u16::from_be_bytes(*pair)))
                .ok_or_else(short)?;
            let body = after.get(2..len).ok_or_else(short)?;
            rest = &after[len..];
            match (marker, body) {
                (0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf | 0xf7, _) => {
                    let &[precision, a, b, c, d, components, ..] = body else {
                        return Err(short());
                    };
                    header.process = marker;
                    header.precision = precision;
                    header.size = [[c, d], [a, b]].map(|pair| u32::from(u16::from_be_bytes(pair)));
                    header.components = components;
                    if body.len() != 6 + 3 * usize::from(components) {
                        return Err(Problem::format(NAME, "JPEG data have a frame header of another length"));
                    }
                }
                (0xdd, interval) => header.restarts |= interval != [0, 0],
                (0xda, &[1, _, _, selection, interleave, low]) => {
                    (header.selection, header.interleave) = (selection, interleave);
                    header.point_transform = low & 15;
                    return Ok(header);
                }
                (0xda, _) => {
                    return Err(Problem::format(
                        NAME,
                        "JPEG data have a scan of other than one component",
                    ));
                }
                _ => {}
            }
        }
    }

    /// Compares the frame with the image.
    pub fn check(&self, size: [u32; 2], form: PixelForm) -> Result<(), Problem> {
        let precision = u32::from(self.precision);
        compare("JPEG", self.size, u32::from(self.components), precision, size, form)?;
        if form.signed && precision < form.stored {
            let fault = format!(
                "a JPEG frame has {precision} bits, expected {} of signed pixels",
                form.stored
            );
            return Err(Problem::format(NAME, fault));
        }
        Ok(())
    }

    /// Refuses what the JPEG decoder does not read, or reads wrongly.
    pub fn check_jpeg(&self) -> Result<(), Problem> {
        let lossless = self.process == 0xc3;
        let found = match self.process {
            0xc0..=0xc2 if self.precision == 8 => return Ok(()),
            0xc0..=0xc2 => format!("JPEG with loss of {} bits", self.precision),
            0xc3 if self.restarts => "lossless JPEG with restart markers".into(),
            0xc3 if self.point_transform != 0 => "lossless JPEG with a point transform".into(),
            0xc3 if !(1..=7).contains(&self.selection) => format!("lossless JPEG with predictor {}", self.selection),
            0xc3 => return Ok(()),
            process => format!("JPEG process FF{process:02X}"),
        };
        let expected = if lossless {
            "a single plain scan"
        } else {
            "8 bits with loss, or lossless"
        };
        refuse(found, expected)
    }

    /// Refuses what the JPEG-LS decoder does not read, or reads wrongly.
    pub fn check_jpeg_ls(&self) -> Result<(), Problem> {
        let found = match self.process {
            0xf7 if self.restarts => "JPEG-LS with restart markers".into(),
            0xf7 if self.interleave != 0 || self.point_transform != 0 => "JPEG-LS with a point transform".into(),
            0xf7 => return Ok(()),
            process => format!("JPEG process FF{process:02X}"),
        };
        refuse(found, "JPEG-LS in a single plain scan")
    }
}

/// The header of a JPEG 2000 codestream.
#[derive(Debug)]
pub(super) struct Codestream {
    pub precision: u32,
    pub signed: bool,
    size: [u32; 2],
    components: u32,
    tiles: u64,
}

impl Codestream {
    /// Finds the codestream, which a file wraps in JP2 boxes against the standard at times, and reads its size.
    pub fn find(frame: &[u8]) -> Result<(&[u8], Self), Problem> {
        const START: [u8; 4] = [0xff, 0x4f, 0xff, 0x51];
        let start = frame.windows(4).take(1024).position(|window| window == START);
        let codestream = start.and_then(|start| frame.get(start..)).unwrap_or(&[]);
        let word = |at: usize| {
            let bytes = codestream.get(at..)?.first_chunk()?;
            Some(u32::from_be_bytes(*bytes))
        };
        let read = || {
            let [x1, y1, x0, y0, tile_x, tile_y, tile_x0, tile_y0] =
                [8, 12, 16, 20, 24, 28, 32, 36].map(word).map(Option::unwrap_or_default);
            // Components, then the first one's depth.
            let tail = word(40)?;
            let depth = (tail >> 8) & 0xff;
            let tiles =
                |end: u32, start: u32, side: u32| u64::from(end.saturating_sub(start)).div_ceil(u64::from(side).max(1));
            Some(Self {
                precision: (depth & 0x7f) + 1,
                signed: depth & 0x80 != 0,
                size: [x1.saturating_sub(x0), y1.saturating_sub(y0)],
                components: tail >> 16,
                tiles: tiles(x1, tile_x0, tile_x).saturating_mul(tiles(y1, tile_y0, tile_y)),
            })
        };
        match read() {
            Some(header) => Ok((codestream, header)),
            None => Err(Problem::format(
                NAME,
                "a packed frame has no JPEG 2000 data, expected FF4F FF51",
            )),
        }
    }

    /// Compares the codestream with the image.
    pub fn check(&self, size: [u32; 2], form: PixelForm) -> Result<(), Problem> {
        compare("JPEG 2000", self.size, self.components, self.precision, size, form)?;
        if form.signed && !self.signed && self.precision < form.stored {
            let (found, stored) = (self.precision, form.stored);
            let fault = format!("a JPEG 2000 frame has {found} unsigned bits, expected {stored} of signed pixels");
            return Err(Problem::format(NAME, fault));
        }
        // A tile's number has 16 bits.
        if self.tiles > 65535 {
            let fault = format!("JPEG 2000 data have {} tiles, expected at most 65535", self.tiles);
            return Err(Problem::format(NAME, fault));
        }
        Ok(())
    }
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

fn refuse(found: String, expected: &'static str) -> Result<(), Problem> {
    Err(Problem::Unsupported {
        format: NAME,
        found,
        expected,
    })
}
