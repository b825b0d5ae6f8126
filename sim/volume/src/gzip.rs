//! Gzip streams that may end in padding.

use std::io::{self, BufRead, Read};

use flate2::bufread::GzDecoder;

/// Gzip members one after another. What follows the last one and begins no member is padding, as on tapes.
pub(super) struct Members<R> {
    /// `None` once the last member has ended.
    member: Option<GzDecoder<R>>,
    /// Whether bytes follow the last member.
    pub padded: bool,
}

impl<R: BufRead> Members<R> {
    /// A stream at its first byte.
    pub fn new(source: R) -> Self {
        Self {
            member: Some(GzDecoder::new(source)),
            padded: false,
        }
    }
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        while let Some(member) = &mut self.member {
            match member.read(buffer)? {
                0 => {}
                n => return Ok(n),
            }
            let mut source = match self.member.take() {
                Some(member) => member.into_inner(),
                None => break,
            };
            match source.fill_buf()?.first() {
                None => {}
                Some(0x1f) => self.member = Some(GzDecoder::new(source)),
                Some(_) => self.padded = true,
            }
        }
        Ok(0)
    }
}
