//! Blosc, version 1: blocks of bytes whose values were shuffled and then packed.
//!
//! Source: c-blosc 1.21, `README_CHUNK_FORMAT.rst`, `blosc.c` (`blosc_d`), `bitshuffle-generic.c` and `blosclz.c`.
//!
//! | bytes | header |
//! |---|---|
//! | 0 | version of the format, 1 or 2 |
//! | 1 | version of the packer |
//! | 2 | flags: 1 bytes shuffled, 2 plain, 4 bits shuffled, 16 blocks not split; above 32: packer |
//! | 3 | bytes of a value |
//! | 4 to 7, 8 to 11, 12 to 15 | unpacked bytes, bytes of a block, packed bytes with this header |
//!
//! Where each block begins follows, 4 bytes each. A block that is split has a stream for every byte of a value.

use std::io;

use flate2::read::ZlibDecoder;

use super::unpacked::{damage, drained, ended, unpacked_lz4, unpacked_zstd};

const HEADER: usize = 16;
const SHUFFLED: u8 = 1;
const PLAIN: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const NOT_SPLIT: u8 = 16;

/// Blocks of values of more bytes are never split, nor those of fewer values.
const SPLITS_MAX: usize = 16;
const SPLIT_VALUES_MIN: usize = 128;

/// The bytes behind a header, of which more than `limit` are refused.
///
/// # Errors
/// What is damaged or not read.
pub(super) fn unpacked(packed: &[u8], limit: usize) -> io::Result<Vec<u8>> {
    let number = |at: usize| -> io::Result<usize> {
        let bytes = packed.get(at..).and_then(<[u8]>::first_chunk::<4>).ok_or_else(ended)?;
        Ok(u32::from_le_bytes(*bytes) as usize)
    };
    let (len, block_len, packed_len) = (number(4)?, number(8)?, number(12)?);
    let [version, _, flags, value_len, ..] = *packed else {
        return Err(ended());
    };
    if !(1..=2).contains(&version) {
        return Err(damage(format!("the format's version is {version}, expected 1 or 2")));
    }
    if len > limit {
        return Err(damage(format!("holds {len} bytes, expected at most {limit}")));
    }
    let packed = packed.get(..packed_len).ok_or_else(ended)?;
    if flags & PLAIN != 0 {
        let plain = packed.get(HEADER..HEADER + len).ok_or_else(ended)?;
        return Ok(plain.to_vec());
    }
    if len == 0 {
        return Ok(Vec::new());
    }
    let packer = Packer::of(flags >> 5)?;
    let value_len = usize::from(value_len).max(1);
    if block_len == 0 || len.div_ceil(block_len) > packed.len() / 4 {
        return Err(damage(format!("blocks of {block_len} bytes cannot be so many")));
    }
    let mut bytes = Vec::new();
    for (number_of_block, first) in (0..len).step_by(block_len).enumerate() {
        let this_len = block_len.min(len - first);
        let can_split = value_len <= SPLITS_MAX && this_len / value_len >= SPLIT_VALUES_MIN;
        let is_split = flags & NOT_SPLIT == 0 && can_split && this_len == block_len;
        let streams = if is_split { value_len } else { 1 };
        let mut block = Vec::new();
        let mut at = number(HEADER + 4 * number_of_block)?;
        for _ in 0..streams {
            let (stream_len, plain_len) = (number(at)?, this_len / streams);
            let end = (at + 4).checked_add(stream_len).ok_or_else(ended)?;
            let stream = packed.get(at + 4..end).ok_or_else(ended)?;
            at = end;
            if stream_len == plain_len {
                block.extend_from_slice(stream);
                continue;
            }
            let plain = packer.unpacked(stream, plain_len)?;
            if plain.len() != plain_len {
                return Err(damage(format!(
                    "a block has {} bytes, expected {plain_len}",
                    plain.len()
                )));
            }
            block.extend_from_slice(&plain);
        }
        if block.len() != this_len {
            return Err(damage(format!(
                "a block has {} bytes, expected {this_len}",
                block.len()
            )));
        }
        if flags & SHUFFLED != 0 && value_len > 1 {
            bytes.extend(unshuffled(&block, value_len));
        } else if flags & BITS_SHUFFLED != 0 && value_len <= this_len && (this_len / value_len).is_multiple_of(8) {
            bytes.extend(bits_unshuffled(&block, value_len));
        } else {
            bytes.extend(block);
        }
    }
    Ok(bytes)
}

/// What packs the blocks.
#[derive(Clone, Copy)]
enum Packer {
    BloscLz,
    Lz4,
    Zlib,
    Zstd,
}

impl Packer {
    fn of(number: u8) -> io::Result<Self> {
        match number {
            0 => Ok(Self::BloscLz),
            1 => Ok(Self::Lz4),
            3 => Ok(Self::Zlib),
            4 => Ok(Self::Zstd),
            2 => Err(damage("snappy is not read, expected blosclz, lz4, zlib or zstd".into())),
            _ => Err(damage(format!("packer {number} is none, expected 0 to 4"))),
        }
    }

    fn unpacked(self, stream: &[u8], len: usize) -> io::Result<Vec<u8>> {
        match self {
            Self::BloscLz => unpacked_blosclz(stream, len),
            Self::Lz4 => unpacked_lz4(stream, len),
            Self::Zlib => drained(ZlibDecoder::new(stream), len),
            Self::Zstd => unpacked_zstd(stream, len),
        }
    }
}

/// The packer of its own: literals, and matches up to 8191 bytes back or, behind a mark, 16 bits more.
fn unpacked_blosclz(stream: &[u8], len: usize) -> io::Result<Vec<u8>> {
    const FAR: usize = 8191;
    let mut bytes: Vec<u8> = Vec::new();
    let mut stream = stream.iter().copied();
    let mut next = || stream.next().ok_or_else(ended);
    // The first byte's upper bits tell the version.
    let mut control = usize::from(next()? & 31);
    loop {
        if control < 32 {
            for _ in 0..=control {
                bytes.push(next()?);
            }
        } else {
            let mut count = (control >> 5) + 2;
            let high = control & 31;
            if count == 9 {
                loop {
                    let more = next()?;
                    count += usize::from(more);
                    if more != 255 {
                        break;
                    }
                }
            }
            let low = usize::from(next()?);
            let mut back = (high << 8) + low + 1;
            if low == 255 && high == 31 {
                back = (usize::from(next()?) << 8) + usize::from(next()?) + FAR + 1;
            }
            let from = bytes.len().checked_sub(back).ok_or_else(ended)?;
            if bytes.len() + count > len {
                return Err(damage(format!("a block has more than {len} bytes")));
            }
            // Byte by byte: a match may reach into what it makes.
            for at in from..from + count {
                bytes.push(bytes[at]);
            }
        }
        if bytes.len() >= len {
            return Ok(bytes);
        }
        control = usize::from(next()?);
    }
}

/// Values whose first bytes stand side by side, then all second bytes; what is no whole value stays at the end.
fn unshuffled(block: &[u8], value_len: usize) -> Vec<u8> {
    let values = block.len() / value_len;
    let mut bytes = block.to_vec();
    for (byte, plane) in block.chunks_exact(values.max(1)).take(value_len).enumerate() {
        for (value, &part) in bytes.chunks_exact_mut(value_len).zip(plane) {
            value[byte] = part;
        }
    }
    bytes
}

/// Values whose lowest bits stand side by side, then all second bits; a multiple of eight values.
fn bits_unshuffled(block: &[u8], value_len: usize) -> Vec<u8> {
    let values = block.len() / value_len;
    let row_len = (values / 8).max(1);
    let mut bytes = block.to_vec();
    bytes[..values * value_len].fill(0);
    for (bit, row) in block.chunks_exact(row_len).take(8 * value_len).enumerate() {
        for (eight, &bits) in row.iter().enumerate() {
            for value in 0..8 {
                bytes[(8 * eight + value) * value_len + bit / 8] |= (bits >> value & 1) << (bit % 8);
            }
        }
    }
    bytes
}
