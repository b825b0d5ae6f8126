//! Data elements one after another, without allocating: PS3.5, section 7.
//!
//! Values are borrowed from the file's bytes; what a length field claims is checked against them first. A sequence comes
//! out whole, to be opened with [`Value::items`]; one of undefined length is followed to its end, to a stated depth.

use super::NAME;
use crate::error::Problem;

/// Group and element number.
pub(super) type Tag = (u16, u16);

/// Pixel Data.
pub(super) const PIXEL_DATA: Tag = (0x7fe0, 0x0010);

const ITEM: Tag = (0xfffe, 0xe000);
const ITEM_END: Tag = (0xfffe, 0xe00d);
const SEQUENCE_END: Tag = (0xfffe, 0xe0dd);

/// How deep sequences may nest; real files stay below 15.
const MAX_DEPTH: usize = 64;

/// How elements are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Encoding {
    pub explicit: bool,
    pub big: bool,
}

impl Encoding {
    pub const EXPLICIT: Self = Self {
        explicit: true,
        big: false,
    };
    pub const EXPLICIT_BIG: Self = Self {
        explicit: true,
        big: true,
    };
    pub const IMPLICIT: Self = Self {
        explicit: false,
        big: false,
    };
}

/// A value's length field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Length {
    Known(usize),
    Undefined,
}

/// What an element holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    /// Bytes: a plain value, or a sequence whose items are written in this encoding.
    Bytes(&'a [u8], Encoding),
    /// Everything after an undefined length: fragments (pixel data).
    Open(&'a [u8]),
}

impl<'a> Value<'a> {
    /// The items of a sequence.
    pub fn items(self) -> Items<'a> {
        Items(match self {
            Self::Bytes(bytes, encoding) => Elements::new(bytes, encoding),
            // Fragments stand in items, too.
            Self::Open(bytes) => Elements::new(bytes, Encoding::EXPLICIT),
        })
    }
}

/// The items of a sequence, one after another.
pub(super) struct Items<'a>(Elements<'a>);

impl<'a> Items<'a> {
    /// The next item's bytes; `None` at the end.
    pub fn next_bytes(&mut self) -> Result<Option<&'a [u8]>, Problem> {
        let elements = &mut self.0;
        let start = elements.at;
        if start == elements.bytes.len() {
            return Ok(None);
        }
        let tag = elements.peek().unwrap_or_default();
        if tag == SEQUENCE_END {
            return Ok(None);
        }
        if tag != ITEM {
            let fault = format!(
                "element {} at byte {start} stands between the items of a sequence",
                name(tag)
            );
            return Err(Problem::format(NAME, fault));
        }
        if let (_, _, Length::Known(len)) = elements.header()? {
            return elements.take(len, tag, start).map(Some);
        }
        let inside = elements.at;
        loop {
            let end = elements.at;
            match elements.next()? {
                Some((ITEM_END, _)) => return Ok(Some(&elements.bytes[inside..end])),
                Some(_) => {}
                None => {
                    let fault = format!("the item at byte {start} of a sequence has no end");
                    return Err(Problem::format(NAME, fault));
                }
            }
        }
    }

    /// The next item's elements; `None` at the end.
    pub fn next(&mut self) -> Result<Option<Elements<'a>>, Problem> {
        let encoding = self.0.encoding;
        Ok(self.next_bytes()?.map(|bytes| Elements::new(bytes, encoding)))
    }
}

/// Reads elements from bytes.
#[derive(Clone, Debug)]
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Elements<'a> {
    /// Elements from the first byte on.
    pub fn new(bytes: &'a [u8], encoding: Encoding) -> Self {
        Self { bytes, at: 0, encoding }
    }

    /// Bytes passed.
    pub fn position(&self) -> usize {
        self.at
    }

    /// The next element's tag, which is then read again by [`Elements::next`].
    pub fn peek(&self) -> Option<Tag> {
        self.clone().tag().ok()
    }

    /// The next element; `None` at the end.
    pub fn next(&mut self) -> Result<Option<(Tag, Value<'a>)>, Problem> {
        let start = self.at;
        if start >= self.bytes.len() {
            return Ok(None);
        }
        let (tag, _, length) = self.header()?;
        // Unknown types hold implicit elements.
        let inner = if self.is_unknown_type(start) {
            Encoding::IMPLICIT
        } else {
            self.encoding
        };
        let value = match length {
            Length::Known(len) => Value::Bytes(self.take(len, tag, start)?, inner),
            Length::Undefined if tag == PIXEL_DATA => {
                let rest = &self.bytes[self.at..];
                self.at = self.bytes.len();
                Value::Open(rest)
            }
            Length::Undefined => {
                let inside = self.at;
                let own = std::mem::replace(&mut self.encoding, inner);
                self.pass_sequence(tag, start)?;
                self.encoding = own;
                Value::Bytes(&self.bytes[inside..self.at], inner)
            }
        };
        Ok(Some((tag, value)))
    }

    /// Follows a sequence of undefined length to its end; the stack of open levels is a flag per level.
    fn pass_sequence(&mut self, tag: Tag, start: usize) -> Result<(), Problem> {
        // Each level is `true` inside an item and `false` between items.
        let mut levels = vec![false];
        while let Some(in_item) = levels.last_mut() {
            let at = self.at;
            if at >= self.bytes.len() {
                let fault = format!("sequence {} at byte {start} has no end", name(tag));
                return Err(Problem::format(NAME, fault));
            }
            let (inner, is_sequence, length) = self.header()?;
            match (inner, length) {
                (ITEM_END, _) => *in_item = false,
                (SEQUENCE_END, _) => {
                    levels.pop();
                }
                (ITEM, Length::Undefined) => *in_item = true,
                (_, Length::Known(len)) if inner == ITEM || *in_item => {
                    self.take(len, inner, at)?;
                }
                (_, Length::Undefined) if *in_item && (is_sequence || inner != PIXEL_DATA) => {
                    if levels.len() == MAX_DEPTH {
                        let fault = format!("sequences nest deeper than {MAX_DEPTH} at byte {at}");
                        return Err(Problem::format(NAME, fault));
                    }
                    levels.push(false);
                }
                // Fragments inside an item (an icon) look like a sequence of plain items.
                (_, Length::Undefined) if *in_item => levels.push(false),
                _ => {
                    let fault = format!(
                        "element {} at byte {at} stands between the items of a sequence",
                        name(inner)
                    );
                    return Err(Problem::format(NAME, fault));
                }
            }
        }
        Ok(())
    }

    /// Whether the element at `start` is of the type `UN`.
    fn is_unknown_type(&self, start: usize) -> bool {
        self.encoding.explicit && self.bytes.get(start + 4..start + 6) == Some(b"UN")
    }

    /// Tag, whether it is a sequence, and length.
    fn header(&mut self) -> Result<(Tag, bool, Length), Problem> {
        let start = self.at;
        let tag = self.tag()?;
        if tag.0 == 0xfffe || !self.encoding.explicit {
            let length = self.u32(tag, start)?;
            return Ok((tag, false, Self::length(length)));
        }
        let kind = self.take(2, tag, start)?;
        if !kind.iter().all(u8::is_ascii_uppercase) {
            let kind = kind.escape_ascii();
            let fault = format!(
                "element {} at byte {start} has the value type \"{kind}\", expected two capitals",
                name(tag)
            );
            return Err(Problem::format(NAME, fault));
        }
        let long = [
            &b"OB"[..],
            b"OD",
            b"OF",
            b"OL",
            b"OV",
            b"OW",
            b"SQ",
            b"SV",
            b"UC",
            b"UN",
            b"UR",
            b"UT",
            b"UV",
        ];
        if long.contains(&kind) {
            self.take(2, tag, start)?;
            let length = self.u32(tag, start)?;
            return Ok((tag, kind == b"SQ", Self::length(length)));
        }
        let bytes = self.take(2, tag, start)?;
        let length = u16_of(bytes, self.encoding.big);
        Ok((tag, false, Length::Known(usize::from(length))))
    }

    fn length(value: u32) -> Length {
        if value == u32::MAX {
            Length::Undefined
        } else {
            Length::Known(value as usize)
        }
    }

    fn tag(&mut self) -> Result<Tag, Problem> {
        let start = self.at;
        let big = self.encoding.big;
        let group = u16_of(self.take(2, (0, 0), start)?, big);
        Ok((group, u16_of(self.take(2, (group, 0), start)?, big)))
    }

    fn u32(&mut self, tag: Tag, start: usize) -> Result<u32, Problem> {
        let bytes = self.take(4, tag, start)?;
        let array = <[u8; 4]>::try_from(bytes).unwrap_or_default();
        Ok(if self.encoding.big {
            u32::from_be_bytes(array)
        } else {
            u32::from_le_bytes(array)
        })
    }

    /// The next `len` bytes, if the file has them.
    fn take(&mut self, len: usize, tag: Tag, start: usize) -> Result<&'a [u8], Problem> {
        let part = self.at.checked_add(len).and_then(|end| self.bytes.get(self.at..end));
        let Some(part) = part else {
            let left = self.bytes.len() - self.at;
            let fault = format!(
                "element {} at byte {start} claims {len} bytes, the file has {left} left",
                name(tag)
            );
            return Err(Problem::format(NAME, fault));
        };
        self.at += len;
        Ok(part)
    }
}

/// A tag as it is written.
pub(super) fn name((group, element): Tag) -> String {
    format!("({group:04X},{element:04X})")
}

/// Two bytes as a number; 0 of another count.
pub(super) fn u16_of(bytes: &[u8], big: bool) -> u16 {
    let array = <[u8; 2]>::try_from(bytes).unwrap_or_default();
    if big {
        u16::from_be_bytes(array)
    } else {
        u16::from_le_bytes(array)
    }
}
