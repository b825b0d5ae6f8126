//! The bytes of single frames within a file's pixel data: one after another, or in fragments.

use std::borrow::Cow;

use super::NAME;
use super::element::Value;
use super::slice::Slice;
use crate::error::Problem;

/// The pixel data of a file.
pub(super) enum Frames<'a> {
    /// Frames of one length, plain, and how many bytes follow the last one.
    Plain {
        bytes: &'a [u8],
        len: usize,
        padding: usize,
    },
    /// Packed frames, each in its fragments.
    Packed(Vec<Vec<&'a [u8]>>),
}

impl<'a> Frames<'a> {
    /// Frames of plain pixels. More bytes than pixels are padding (PS3.5, 8.1.1), unless another frame would fit.
    pub fn plain(value: Value<'a>, slice: &Slice) -> Result<Self, Problem> {
        let Value::Bytes(bytes, _) = value else {
            let fault = "has pixel data of undefined length, expected plain pixels";
            return Err(Problem::format(NAME, fault));
        };
        let len = slice.columns as usize * slice.rows as usize * slice.form.bytes;
        let expected = len * slice.frames;
        if bytes.len() < expected || bytes.len() >= expected + len.max(2) {
            let (found, columns, rows) = (bytes.len(), slice.columns, slice.rows);
            let of = match slice.frames {
                1 => String::new(),
                frames => format!("{frames} frames of "),
            };
            let bits = 8 * slice.form.bytes;
            let fault =
                format!("has {found} bytes of pixels, expected {expected} for {of}{columns} x {rows} of {bits} bits");
            return Err(Problem::format(NAME, fault));
        }
        Ok(Self::Plain {
            bytes,
            len,
            padding: bytes.len() - expected,
        })
    }

    /// Packed frames: a fragment each, or those between the offsets that the first item lists.
    pub fn packed(value: Value<'a>, count: usize) -> Result<Self, Problem> {
        let Value::Open(_) = value else {
            let fault = "has packed pixel data of a stated length, expected fragments";
            return Err(Problem::format(NAME, fault));
        };
        let mut items = value.items();
        let table = items.next_bytes()?.unwrap_or(&[]);
        let mut fragments = Vec::new();
        while let Some(fragment) = items.next_bytes()? {
            fragments.push(fragment);
        }
        let fault = |found: String| Problem::format(NAME, format!("has {found}, expected {count} packed frames"));
        if count == 1 && !fragments.is_empty() {
            return Ok(Self::Packed(vec![fragments]));
        }
        if fragments.len() == count {
            return Ok(Self::Packed(fragments.into_iter().map(|one| vec![one]).collect()));
        }
        if table.len() != 4 * count {
            let found = format!("{} fragments and {} bytes of offsets", fragments.len(), table.len());
            return Err(fault(found));
        }
        let mut starts = table
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]) as usize)
            .peekable();
        let (mut frames, mut at) = (Vec::new(), 0);
        for fragment in fragments {
            if starts.next_if_eq(&at).is_some() {
                frames.push(Vec::new());
            }
            let frame = frames.last_mut().ok_or_else(|| fault("no frame at offset 0".into()))?;
            frame.push(fragment);
            // An item's tag and length.
            at += 8 + fragment.len();
        }
        if frames.len() != count {
            return Err(fault(format!("{} fragments at the offsets stated", frames.len())));
        }
        Ok(Self::Packed(frames))
    }

    /// The bytes of one frame; empty if there is no such frame.
    pub fn bytes(&self, frame: usize) -> Cow<'a, [u8]> {
        match self {
            Self::Plain { bytes, len, .. } => bytes.get(frame * len..(frame + 1) * len).unwrap_or(&[]).into(),
            Self::Packed(frames) => match frames.get(frame).map_or(&[][..], Vec::as_slice) {
                [one] => (*one).into(),
                fragments => fragments.concat().into(),
            },
        }
    }
}
