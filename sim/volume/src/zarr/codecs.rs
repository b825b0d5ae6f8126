//! How the bytes of a chunk are packed.
//!
//! Every unpacker stops one byte behind what is expected, so that a small chunk cannot fill the memory.

use std::io::{self, Read};

use bzip2::read::MultiBzDecoder;
use flate2::read::{MultiGzDecoder, ZlibDecoder};
use ruzstd::decoding::StreamingDecoder;
use serde_json::Value;

use super::blosc;
use crate::text::shorten;

/// The codecs that are read, for messages.
pub(super) const READ: &str = "gzip, zlib, zstd, blosc, lz4, bz2 or crc32c";

/// The least limit of what a frame of zstd refers back to; a chunk twice as long as it has its own.
const WINDOW_MIN: u64 = 8 << 20;

/// LZ4 packs no more than so many bytes into one.
const LZ4_MOST: usize = 255;

/// A way of packing bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    Gzip,
    Zlib,
    Bzip2,
    Zstd,
    /// A length of four bytes, and a block of LZ4.
    Lz4,
    Blosc,
    /// A sum behind the bytes.
    Crc32c,
}

impl Codec {
    /// The codec that metadata name, in Zarr 2 by `id`, in Zarr 3 by `name`.
    ///
    /// # Errors
    /// The name.
    pub fn named(value: &Value) -> Result<Self, String> {
        let name = ["name", "id"].into_iter().find_map(|key| value.get(key)?.as_str());
        let name = name.or(value.as_str()).unwrap_or("one without a name");
        match name.strip_prefix("numcodecs.").unwrap_or(name) {
            "gzip" => Ok(Self::Gzip),
            "zlib" => Ok(Self::Zlib),
            "bz2" => Ok(Self::Bzip2),
            "zstd" => Ok(Self::Zstd),
            "lz4" => Ok(Self::Lz4),
            "blosc" => Ok(Self::Blosc),
            "crc32c" if name == "crc32c" => Ok(Self::Crc32c),
            _ => Err(shorten(name)),
        }
    }

    /// Its name in messages.
    const fn name(self) -> &'static str {
        match self {
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Bzip2 => "bz2",
            Self::Zstd => "zstd",
            Self::Lz4 => "lz4",
            Self::Blosc => "blosc",
            Self::Crc32c => "crc32c",
        }
    }

    /// The bytes, at most one more than `limit`.
    fn unpacked(self, packed: &[u8], limit: usize) -> io::Result<Vec<u8>> {
        match self {
            Self::Gzip => drained(MultiGzDecoder::new(packed), limit),
            Self::Zlib => drained(ZlibDecoder::new(packed), limit),
            Self::Bzip2 => drained(MultiBzDecoder::new(packed), limit),
            Self::Zstd => unpacked_zstd(packed, limit),
            Self::Lz4 => {
                let (len, block) = packed.split_first_chunk::<4>().ok_or_else(ended)?;
                let len = u32::from_le_bytes(*len) as usize;
                if len > limit {
                    return Err(damage(format!("holds {len} bytes, expected at most {limit}")));
                }
                unpacked_lz4(block, len)
            }
            Self::Blosc => blosc::unpacked(packed, limit),
            Self::Crc32c => {
                let (bytes, sum) = packed.split_last_chunk::<4>().ok_or_else(ended)?;
                let (stated, found) = (u32::from_le_bytes(*sum), crc32c::crc32c(bytes));
                if stated != found {
                    return Err(damage(format!("has the sum {found:08x}, expected {stated:08x}")));
                }
                Ok(bytes.to_vec())
            }
        }
    }
}

/// Unpacks what codecs have packed, the first of them first, to `expected` bytes.
///
/// # Errors
/// What is wrong.
pub(super) fn unpacked(codecs: &[Codec], packed: Vec<u8>, expected: usize) -> Result<Vec<u8>, String> {
    // What one packer hands to the next may be a little longer than the values.
    let between = expected + expected / 64 + 4096;
    let mut bytes = packed;
    for (number, codec) in codecs.iter().enumerate().rev() {
        let limit = if number == 0 { expected } else { between };
        let unpacked = codec.unpacked(&bytes, limit);
        bytes = unpacked.map_err(|error| format!("{} data are damaged: {error}", codec.name()))?;
    }
    if bytes.len() == expected {
        return Ok(bytes);
    }
    let more = if bytes.len() > expected { "more than " } else { "" };
    let found = bytes.len().min(expected);
    Err(format!("has {more}{found} bytes of values, expected {expected}"))
}

/// Bytes that no packer has written.
pub(super) fn damage(fault: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, fault)
}

/// Packed bytes that are too few.
pub(super) fn ended() -> io::Error {
    damage("they end early".into())
}

/// Everything from a source, at most one byte more than `limit`.
pub(super) fn drained(source: impl Read, limit: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(limit as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A frame of zstd, whose sum is compared if it has one.
pub(super) fn unpacked_zstd(packed: &[u8], limit: usize) -> io::Result<Vec<u8>> {
    let window = WINDOW_MIN.max(2 * limit as u64);
    let decoder = StreamingDecoder::new_with_max_window_size(packed, window);
    let mut decoder = decoder.map_err(|error| damage(error.to_string()))?;
    let bytes = drained(&mut decoder, limit)?;
    let stated = decoder.decoder.get_checksum_from_data();
    if bytes.len() <= limit && stated.is_some() && stated != decoder.decoder.get_calculated_checksum() {
        return Err(damage("the values are not those of the sum behind them".into()));
    }
    Ok(bytes)
}

/// A block of LZ4 of `len` bytes.
pub(super) fn unpacked_lz4(block: &[u8], len: usize) -> io::Result<Vec<u8>> {
    if len / LZ4_MOST > block.len() {
        return Err(damage(format!("{} bytes cannot hold {len}", block.len())));
    }
    let mut bytes = vec![0; len];
    let written = lz4_flex::block::decompress_into(block, &mut bytes).map_err(|error| damage(error.to_string()))?;
    if written == len { Ok(bytes) } else { Err(ended()) }
}
