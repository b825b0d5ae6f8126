//! The headers of JPEG and JPEG-LS frames, read before a decoder is trusted with them.

use super::super::NAME;
use super::super::slice::PixelForm;
use super::compare;
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
    /// After how many samples JPEG-LS halves its statistics, if it says so.
    reset: u16,
    /// Where the scan's bits begin.
    scan: usize,
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
                (0xf8, &[1, .., a, b]) => header.reset = u16::from_be_bytes([a, b]),
                (0xdd, interval) => header.restarts |= interval != [0, 0],
                (0xda, &[1, _, _, selection, interleave, low]) => {
                    (header.selection, header.interleave) = (selection, interleave);
                    header.point_transform = low & 15;
                    header.scan = frame.len() - rest.len();
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
            0xc0 | 0xc1 if self.precision == 8 => return Ok(()),
            0xc0 | 0xc1 => format!("JPEG with loss of {} bits", self.precision),
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
            // The decoder's sums overflow above.
            0xf7 if self.reset > 255 => format!("JPEG-LS with statistics reset after {} samples", self.reset),
            0xf7 => return Ok(()),
            process => format!("JPEG process FF{process:02X}"),
        };
        refuse(found, "JPEG-LS in a single plain scan")
    }

    /// The frame with 16 bytes of ones after its scan. Past the end of a cut scan the decoder would go on with zeros and
    /// yield a picture; ones are no code, so that it fails. A complete scan is read no further.
    pub fn sealed(&self, frame: &[u8]) -> Result<Vec<u8>, Problem> {
        let bits = frame.get(self.scan..).unwrap_or(&[]);
        let is_marker = |pair: &[u8]| {
            let restart = self.restarts && (0xd0..=0xd7).contains(&pair[1]);
            pair[0] == 0xff && ![0x00, 0xff].contains(&pair[1]) && !restart
        };
        let end = bits.windows(2).position(is_marker).unwrap_or(bits.len());
        if let Some(&[_, marker]) = bits.get(end..end + 2)
            && marker != 0xd9
        {
            let fault = format!("JPEG data have a marker FF{marker:02X} within their scan, expected one scan");
            return Err(Problem::format(NAME, fault));
        }
        let mut sealed = frame[..self.scan + end].to_vec();
        sealed.extend([0xff, 0x00].repeat(16));
        sealed.extend([0xff, 0xd9]);
        Ok(sealed)
    }
}

fn refuse(found: String, expected: &'static str) -> Result<(), Problem> {
    Err(Problem::Unsupported {
        format: NAME,
        found,
        expected,
    })
}
