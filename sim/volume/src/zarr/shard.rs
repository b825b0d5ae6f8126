//! A shard: many chunks in a file, and an index of where each of them is.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use serde_json::Value;

use super::unpacked::damage;

/// Chunks that a shard may have.
const CHUNKS_MAX: u64 = 1 << 20;

/// Of a chunk that is not there, place and length are this.
const MISSING: u64 = u64::MAX;

/// Where the index is, and how it is written.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// Chunks along each axis.
    pub counts: Vec<u64>,
    is_first: bool,
    is_big: bool,
    /// Whether a sum follows it.
    is_summed: bool,
}

/// Where each chunk of a shard is, and its length; `None` of one that is not there.
pub(super) type Places = Vec<Option<[u64; 2]>>;

impl Index {
    /// What a configuration says of it.
    ///
    /// # Errors
    /// What was expected.
    pub fn of(configuration: &Value, counts: Vec<u64>) -> Result<Self, String> {
        let is_first = match configuration.get("index_location").map(Value::as_str) {
            None | Some(Some("end")) => false,
            Some(Some("start")) => true,
            Some(_) => return Err("`index_location` is neither `start` nor `end`".into()),
        };
        let all = counts.iter().copied().try_fold(1, u64::checked_mul);
        if all.is_none_or(|all| all > CHUNKS_MAX) {
            return Err(format!("a shard has more than {CHUNKS_MAX} chunks"));
        }
        let expected = "`index_codecs` are not `bytes`, and `crc32c` or nothing behind it";
        let codecs = configuration.get("index_codecs").and_then(Value::as_array);
        let codecs = codecs.map_or(&[][..], Vec::as_slice);
        let name = |value: &Value| value.get("name").and_then(Value::as_str).map(String::from);
        let names: Vec<Option<String>> = codecs.iter().map(name).collect();
        let names: Vec<&str> = names.iter().map(|name| name.as_deref().unwrap_or_default()).collect();
        let is_summed = match names[..] {
            ["bytes"] => false,
            ["bytes", "crc32c"] => true,
            _ => return Err(expected.into()),
        };
        let endian = codecs
            .first()
            .and_then(|bytes| bytes.get("configuration")?.get("endian"));
        let is_big = match endian.and_then(Value::as_str) {
            Some("little") => false,
            Some("big") => true,
            _ => return Err(expected.into()),
        };
        Ok(Self {
            counts,
            is_first,
            is_big,
            is_summed,
        })
    }

    /// Reads the index of a shard of `len` bytes.
    pub fn read(&self, file: &mut File, len: u64) -> io::Result<Places> {
        let chunks: u64 = self.counts.iter().product();
        let index_len = 16 * chunks + if self.is_summed { 4 } else { 0 };
        let Some(start) = len.checked_sub(index_len) else {
            return Err(damage(format!(
                "the shard has {len} bytes, its index alone {index_len}"
            )));
        };
        file.seek(SeekFrom::Start(if self.is_first { 0 } else { start }))?;
        let mut index = vec![0; index_len as usize];
        file.read_exact(&mut index)?;
        let (numbers, sum) = index.split_at(16 * chunks as usize);
        if self.is_summed && crc32c::crc32c(numbers).to_le_bytes() != *sum {
            return Err(damage(
                "the shard's index has not the sum that is stated behind it".into(),
            ));
        }
        let number = |bytes: [u8; 8]| {
            if self.is_big {
                u64::from_be_bytes(bytes)
            } else {
                u64::from_le_bytes(bytes)
            }
        };
        let (numbers, _) = numbers.as_chunks::<8>();
        let (places, _) = numbers.as_chunks::<2>();
        let place = |pair: &[[u8; 8]; 2]| {
            let [start, part] = pair.map(number);
            if [start, part] == [MISSING; 2] {
                return Ok(None);
            }
            match start.checked_add(part) {
                Some(end) if end <= len => Ok(Some([start, part])),
                _ => Err(damage(format!(
                    "a chunk of {part} bytes begins at byte {start} of the shard, which has {len}"
                ))),
            }
        };
        places.iter().map(place).collect()
    }
}
