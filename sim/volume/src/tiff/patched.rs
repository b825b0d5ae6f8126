//! A source in which some bytes read as others.
//!
//! Where a page says that white is 0, the library inverts its values, floats as 1 - v, which cannot be undone. With the
//! page's word for it replaced by "black is 0" the values arrive as they are stored.

use std::io::{self, Read, Seek, SeekFrom};

/// A file or bytes in memory: as an object, so that the library's decoder is compiled for one type.
pub(super) trait Source: Read + Seek {}

impl<R: Read + Seek> Source for R {}

/// What reads the pages.
pub(super) type Decoder<'s> = tiff::decoder::Decoder<Patched<'s>>;

/// A source with replaced bytes.
pub(super) struct Patched<'s> {
    source: &'s mut dyn Source,
    at: u64,
    patches: Vec<(u64, u8)>,
}

/// `PhotometricInterpretation`.
const PHOTOMETRIC: u16 = 262;

impl<'s> Patched<'s> {
    /// A source at its first byte.
    pub fn new(source: &'s mut dyn Source) -> Self {
        Self {
            source,
            at: 0,
            patches: Vec::new(),
        }
    }

    /// Makes the directory at `directory` say that black is 0; `false` if its entry for that is not found.
    pub fn set_black_is_zero(&mut self, directory: u64) -> io::Result<bool> {
        let mut head = [0; 4];
        self.seek(SeekFrom::Start(0))?;
        self.read_exact(&mut head)?;
        let little = head[0] == b'I';
        let number = |bytes: &[u8]| {
            let place = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
            if little {
                bytes.iter().rev().fold(0, place)
            } else {
                bytes.iter().fold(0, place)
            }
        };
        let big = number(&head[2..]) == 43;
        let (count_len, entry_len, value_at) = if big { (8, 20, 12) } else { (2, 12, 8) };
        self.seek(SeekFrom::Start(directory))?;
        let mut entry = [0; 20];
        self.read_exact(&mut entry[..count_len])?;
        let count = number(&entry[..count_len]);
        for index in 0..count.min(1 << 16) {
            self.read_exact(&mut entry[..entry_len])?;
            if number(&entry[..2]) == u64::from(PHOTOMETRIC) {
                let value = directory + count_len as u64 + index * entry_len as u64 + value_at;
                self.patches.push((if little { value } else { value + 1 }, 1));
                return Ok(true);
            }
        }
        Ok(false)
    }
}

impl Read for Patched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let len = self.source.read(buffer)?;
        for &(at, byte) in &self.patches {
            let place = at.checked_sub(self.at).and_then(|place| usize::try_from(place).ok());
            if let Some(target) = place.and_then(|place| buffer[..len].get_mut(place)) {
                *target = byte;
            }
        }
        self.at += len as u64;
        Ok(len)
    }
}

impl Seek for Patched<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.source.seek(to)?;
        Ok(self.at)
    }
}
