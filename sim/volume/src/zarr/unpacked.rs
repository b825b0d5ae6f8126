//! Packed bytes, unpacked by the libraries.

use std::io::{self, Read};

use ruzstd::decoding::StreamingDecoder;

/// The least limit of what a frame of zstd refers back to; a chunk twice as long as it has its own.
const WINDOW_MIN: u64 = 8 << 20;

/// LZ4 packs no more than so many bytes into one.
const LZ4_MOST: usize = 255;

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
