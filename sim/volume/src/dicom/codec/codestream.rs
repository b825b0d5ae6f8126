//! The headers of a JPEG 2000 codestream, read before the decoder is trusted with it.

use super::super::NAME;
use super::super::slice::PixelForm;
use super::compare;
use crate::error::Problem;

/// Precincts, and code blocks times layers, that a frame may have: the decoder allocates for each. A frame of the largest
/// size has 5,500 of the one and 4,096 of the other by the usual settings.
const MAX_PARTS: u64 = 1 << 18;

const SOC_SIZ: [u8; 4] = [0xff, 0x4f, 0xff, 0x51];
const COD: u8 = 0x52;
const COC: u8 = 0x53;
const SOT: u8 = 0x90;
const SOD: u8 = 0x93;
const EOC: [u8; 2] = [0xff, 0xd9];

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
        let start = frame.windows(4).take(1024).position(|window| window == SOC_SIZ);
        let codestream = start.and_then(|start| frame.get(start..)).unwrap_or(&[]);
        let word = |at: usize| {
            codestream
                .get(at..)?
                .first_chunk()
                .map(|bytes| u32::from_be_bytes(*bytes))
        };
        let read = || {
            let (x1, y1, x0, y0) = (word(8)?, word(12)?, word(16)?, word(20)?);
            let tiles =
                |end: u32, start: u32, side: u32| u64::from(end.saturating_sub(start)).div_ceil(u64::from(side).max(1));
            // Components, then the first one's depth.
            let tail = word(40)?;
            let depth = (tail >> 8) & 0xff;
            Some(Self {
                precision: (depth & 0x7f) + 1,
                signed: depth & 0x80 != 0,
                size: [x1.saturating_sub(x0), y1.saturating_sub(y0)],
                components: tail >> 16,
                tiles: tiles(x1, word(32)?, word(24)?).saturating_mul(tiles(y1, word(36)?, word(28)?)),
            })
        };
        let none = || damaged("a packed frame has no JPEG 2000 data, expected FF4F FF51".into());
        Ok((codestream, read().ok_or_else(none)?))
    }

    /// Compares the codestream with the image, and checks that its parts are few and all there.
    pub fn check(&self, codestream: &[u8], size: [u32; 2], form: PixelForm) -> Result<(), Problem> {
        compare("JPEG 2000", self.size, self.components, self.precision, size, form)?;
        if form.signed && !self.signed && self.precision < form.stored {
            let (found, stored) = (self.precision, form.stored);
            return Err(damaged(format!(
                "a JPEG 2000 frame has {found} unsigned bits, expected {stored} of signed pixels"
            )));
        }
        // A tile's number has 16 bits.
        if self.tiles > 65535 {
            return Err(damaged(format!(
                "JPEG 2000 data have {} tiles, expected at most 65535",
                self.tiles
            )));
        }
        let mut at = 2;
        let mut tiles = 0;
        loop {
            let (marker, body) = segment(codestream, at)?;
            match marker {
                COD if tiles == 0 => self.check_style(body)?,
                // A style of its own for a component or tile would go past that check.
                COD | COC => {
                    return Err(Problem::Unsupported {
                        format: NAME,
                        found: "JPEG 2000 with several coding styles".into(),
                        expected: "one",
                    });
                }
                SOT => {
                    tiles += 1;
                    at = tile_part(codestream, at, body)?;
                    if codestream
                        .get(at..at + 2)
                        .is_none_or(|next| next == EOC || next[0] != 0xff)
                    {
                        return Ok(());
                    }
                    continue;
                }
                _ => {}
            }
            at += 4 + body.len();
        }
    }

    /// Refuses more precincts, code blocks and layers than a picture needs.
    fn check_style(&self, body: &[u8]) -> Result<(), Problem> {
        let &[
            style,
            _,
            layers_high,
            layers_low,
            _,
            levels,
            block_x,
            block_y,
            _,
            _,
            ref precincts @ ..,
        ] = body
        else {
            return Err(damaged("JPEG 2000 data have no coding style".into()));
        };
        let layers = u64::from(u16::from_be_bytes([layers_high, layers_low]));
        let side =
            |axis: usize, shift: u32| u64::from(self.size[axis]).div_ceil(1_u64.checked_shl(shift).unwrap_or(u64::MAX));
        let blocks = side(0, u32::from(block_x & 15) + 2).saturating_mul(side(1, u32::from(block_y & 15) + 2));
        let mut parts = blocks.saturating_mul(layers);
        for level in (0..=u32::from(levels)).take_while(|_| style & 1 != 0) {
            let &both = precincts
                .get(level as usize)
                .ok_or_else(|| damaged("JPEG 2000 data have too few precinct sizes".into()))?;
            // A level's pixels stand for this many of the picture.
            let shift = u32::from(levels) - level;
            let across = side(0, shift + u32::from(both & 15)).saturating_mul(side(1, shift + u32::from(both >> 4)));
            parts = parts.max(across);
        }
        if parts > MAX_PARTS {
            return Err(damaged(format!(
                "JPEG 2000 data are cut into {parts} precincts or code blocks, expected at most {MAX_PARTS}"
            )));
        }
        Ok(())
    }
}

/// The marker segment at a place.
fn segment(codestream: &[u8], at: usize) -> Result<(u8, &[u8]), Problem> {
    let read = || {
        let &[0xff, marker, high, low] = codestream.get(at..)?.first_chunk()? else {
            return None;
        };
        let len = usize::from(u16::from_be_bytes([high, low]));
        Some((marker, codestream.get(at + 4..at + 2 + len)?))
    };
    read().ok_or_else(|| {
        damaged(format!(
            "JPEG 2000 data end or are damaged at byte {at} of their headers"
        ))
    })
}

/// Passes a part of a tile: where the next one begins.
fn tile_part(codestream: &[u8], start: usize, body: &[u8]) -> Result<usize, Problem> {
    let &[_, _, a, b, c, d, ..] = body else {
        return Err(damaged("JPEG 2000 data have a tile without a length".into()));
    };
    let mut at = start + 4 + body.len();
    while codestream.get(at..at + 2) != Some(&[0xff, SOD]) {
        let (marker, body) = segment(codestream, at)?;
        if [COD, COC].contains(&marker) {
            return Err(Problem::Unsupported {
                format: NAME,
                found: "JPEG 2000 with a coding style for a single tile".into(),
                expected: "one for all",
            });
        }
        at += 4 + body.len();
    }
    let end = match u32::from_be_bytes([a, b, c, d]) as usize {
        // Up to the end of the codestream, which is followed by padding at most.
        0 => codestream.windows(2).rposition(|pair| pair == EOC),
        len => start.checked_add(len),
    };
    match end {
        Some(end) if (at..=codestream.len()).contains(&end) => Ok(end),
        _ => Err(damaged(format!(
            "JPEG 2000 data have {} bytes, expected more for the tile at byte {start}",
            codestream.len()
        ))),
    }
}

fn damaged(fault: String) -> Problem {
    Problem::format(NAME, fault)
}
