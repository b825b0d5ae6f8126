//! How the bytes of a chunk are packed.
//!
//! Every unpacker stops one byte behind what is expected, so that a small chunk cannot fill the memory.

use std::io::{self};

use bzip2::read::MultiBzDecoder;
use flate2::read::{MultiGzDecoder, ZlibDecoder};
use serde_json::Value;

use super::blosc;
use super::unpacked::{damage, drained, ended, unpacked_lz4, unpacked_zstd};
use crate::text::shorten;

/// The codecs that are read, for messages.
pub(super) const READ: &str = "gzip, zlib, zstd, blosc, lz4, bz2 or crc32c";

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
