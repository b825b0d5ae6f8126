//! The bytes behind a header: skipped, unpacked and turned into values, with no more memory than bytes that arrived.
//!
//! Plain data are refused before anything is allocated unless the file holds exactly the bytes that the shape needs.
//! Compressed data cannot be measured beforehand: their buffer grows as they unpack and stops at the shape's size.

use std::io::{self, BufRead, Read, Write};
use std::str::FromStr;

use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::ZlibDecoder;

use super::error::Problem;
use super::gzip::Members;
use super::limits::MAX_BYTES;
use super::text::shorten_bytes;
use super::values::{Endian, ValueType, Values, voxel_count};

/// Bytes read at a time; a multiple of every value's length.
const CHUNK_LEN: usize = 1 << 16;

/// How the bytes of a data file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// As they are.
    Raw,
    /// One or more gzip members.
    Gzip,
    /// One zlib stream.
    Zlib,
    /// One or more bzip2 streams.
    Bzip2,
    /// Decimal numbers, separated by space or commas.
    Text,
}

impl Encoding {
    /// Its name in messages.
    const fn name(self) -> &'static str {
        match self {
            Self::Raw => "plain",
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Bzip2 => "bzip2",
            Self::Text => "text",
        }
    }
}

/// How many bytes precede the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteSkip {
    /// So many (of the unpacked bytes, if they are packed).
    Bytes(u64),
    /// As many as it takes for the values to end with the file; plain data only.
    FromEnd,
}

/// What becomes of bytes after the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tail {
    /// The data are refused: their shape is in doubt.
    Refused,
    /// They are left out, with a note.
    LeftOut,
}

/// What the bytes mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Voxels along x, y, z.
    pub dims: [u64; 3],
    /// Values of a voxel, side by side.
    pub components: u64,
    /// Number type of a value.
    pub value_type: ValueType,
    /// Byte order.
    pub endian: Endian,
    /// Whether packed.
    pub encoding: Encoding,
    /// Lines to skip before unpacking.
    pub line_skip: u64,
    /// Bytes to skip after unpacking.
    pub byte_skip: ByteSkip,
    /// Bytes after the values.
    pub tail: Tail,
}

impl Layout {
    /// Refuses packed volumes that would take more memory than any volume may. Plain ones are held to their file's length.
    ///
    /// # Errors
    /// [`Problem::TooLarge`], or a shape that no volume has.
    pub fn check_memory(&self) -> Result<(), Problem> {
        let bytes = self.count()? * self.value_type.byte_len();
        if self.encoding == Encoding::Raw {
            Ok(())
        } else {
            check_memory(bytes)
        }
    }

    /// Values in all.
    fn count(&self) -> Result<u64, Problem> {
        Ok(voxel_count(self.dims)? * self.components)
    }

    /// For messages.
    fn describe(&self) -> String {
        let [x, y, z] = self.dims;
        let times = if self.components == 1 {
            String::new()
        } else {
            format!("{} x ", self.components)
        };
        format!("{times}{x} x {y} x {z} {}", self.value_type.name())
    }
}

/// Reads the values that `layout` describes from `source`, which has `source_len` bytes left. Bytes that are left out add
/// a note.
pub(super) fn read_values(
    layout: &Layout,
    source: &mut dyn BufRead,
    source_len: u64,
    notes: &mut Vec<String>,
) -> Result<Values, Problem> {
    let count = layout.count()?;
    let expected = count * layout.value_type.byte_len();
    match layout.encoding {
        Encoding::Raw => {
            plain_start(layout, source, source_len, expected, notes)?;
            // The file was seen to hold all of them, so the whole buffer may be reserved at once.
            let (values, read) = decode(layout, source, count, count)?;
            read.map_err(Problem::io("read the file"))?;
            complete(layout, expected, byte_count(layout, &values))?;
            Ok(values)
        }
        Encoding::Text => {
            skip_lines(source, layout.line_skip)?;
            check_memory(expected)?;
            if let ByteSkip::Bytes(n) = layout.byte_skip {
                skip_bytes(source, n, Problem::io("read the file"))?;
            }
            let values = text_values(layout, source, count)?;
            complete(layout, expected, byte_count(layout, &values))?;
            Ok(values)
        }
        Encoding::Gzip | Encoding::Zlib | Encoding::Bzip2 => {
            skip_lines(source, layout.line_skip)?;
            check_memory(expected)?;
            unpack(layout, source, expected, notes, &mut |unpacked| {
                let (values, end) = decode(layout, unpacked, count, 0)?;
                Ok((byte_count(layout, &values), end, values))
            })
        }
    }
}

/// Unpacks the bytes of the values, `expected` of them, into another file.
pub(super) fn unpack_into(
    layout: &Layout,
    source: &mut dyn BufRead,
    expected: u64,
    notes: &mut Vec<String>,
    out: &mut dyn Write,
) -> Result<(), Problem> {
    skip_lines(source, layout.line_skip)?;
    unpack(layout, source, expected, notes, &mut |unpacked| {
        let mut chunk = vec![0; CHUNK_LEN];
        let mut done = 0;
        let mut end = Ok(());
        while done < expected && end.is_ok() {
            let wanted = (expected - done).min(CHUNK_LEN as u64) as usize;
            let (len, read) = read_full(unpacked, &mut chunk[..wanted]);
            end = read;
            let written = out.write_all(&chunk[..len]);
            written.map_err(Problem::io("write the unpacked values to a scratch file"))?;
            done += len as u64;
            if len < wanted {
                break;
            }
        }
        Ok((done, end, ()))
    })
}

/// Passes over what precedes plain values, after a look at whether the source has exactly as many bytes as they need; the
/// bytes passed.
pub(super) fn plain_start(
    layout: &Layout,
    source: &mut dyn BufRead,
    source_len: u64,
    expected: u64,
    notes: &mut Vec<String>,
) -> Result<u64, Problem> {
    let lines = skip_lines(source, layout.line_skip)?;
    let remaining = source_len.saturating_sub(lines);
    let skip = match layout.byte_skip {
        ByteSkip::Bytes(n) => n,
        ByteSkip::FromEnd => remaining.saturating_sub(expected),
    };
    let end = skip.checked_add(expected);
    let rest = end.and_then(|end| remaining.checked_sub(end));
    let Some(rest) = rest.filter(|&rest| rest == 0 || layout.tail == Tail::LeftOut) else {
        let place = if skip == 0 {
            String::new()
        } else {
            format!(" after the {skip} skipped")
        };
        let found = remaining.saturating_sub(skip);
        return Err(Problem::Length {
            expected,
            found,
            place,
            shape: layout.describe(),
        });
    };
    if rest > 0 {
        notes.push(format!("{rest} bytes after the voxels are left out"));
    }
    skip_bytes(source, skip, Problem::io("read the file"))?;
    Ok(lines + skip)
}

/// Refuses volumes that a small packed file could claim without end.
fn check_memory(bytes: u64) -> Result<(), Problem> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    Err(Problem::TooLarge {
        bytes,
        what: "the unpacked values",
        limit: MAX_BYTES,
    })
}

/// What takes unpacked bytes: how many it took, how reading ended, and what became of them.
type Take<'a, T> = &'a mut dyn FnMut(&mut dyn Read) -> Result<(u64, io::Result<()>, T), Problem>;

/// Hands the unpacked values to `take`.
fn unpack<T>(
    layout: &Layout,
    source: &mut dyn BufRead,
    expected: u64,
    notes: &mut Vec<String>,
    take: Take<'_, T>,
) -> Result<T, Problem> {
    match layout.encoding {
        Encoding::Zlib => unpack_from(layout, &mut ZlibDecoder::new(source), expected, notes, take),
        Encoding::Bzip2 => unpack_from(layout, &mut MultiBzDecoder::new(source), expected, notes, take),
        Encoding::Gzip | Encoding::Raw | Encoding::Text => {
            let mut members = Members::new(source);
            let taken = unpack_from(layout, &mut members, expected, notes, take)?;
            if members.padded {
                notes.push("bytes after the gzip data are left out".into());
            }
            Ok(taken)
        }
    }
}

/// Hands an unpacker's values to `take`, and asks it for one byte more than they need.
fn unpack_from<T>(
    layout: &Layout,
    unpacked: &mut dyn Read,
    expected: u64,
    notes: &mut Vec<String>,
    take: Take<'_, T>,
) -> Result<T, Problem> {
    let packing = layout.encoding.name();
    let damaged = |done: u64| {
        move |error: io::Error| Problem::Damaged {
            packing,
            unpacked: done,
            expected,
            message: error.to_string(),
        }
    };
    if let ByteSkip::Bytes(n) = layout.byte_skip {
        // A skip longer than any volume would unpack a small file for ever.
        if n > MAX_BYTES {
            return Err(Problem::Skip {
                field: "byte skip",
                asked: n,
            });
        }
        skip_bytes(unpacked, n, damaged(0))?;
    }
    let (done, end, taken) = take(unpacked)?;
    end.map_err(damaged(done))?;
    complete(layout, expected, done)?;
    match read_full(unpacked, &mut [0]) {
        (0, Ok(())) => Ok(taken),
        (0, Err(error)) => Err(damaged(expected)(error)),
        _ if layout.tail == Tail::LeftOut => {
            notes.push("more data follow the voxels and are left out".into());
            Ok(taken)
        }
        _ => Err(Problem::UnpacksTooLong {
            expected,
            shape: layout.describe(),
        }),
    }
}

/// The bytes that values took in their file.
fn byte_count(layout: &Layout, values: &Values) -> u64 {
    values.len() as u64 * layout.value_type.byte_len()
}

/// Refuses data that ended early.
fn complete(layout: &Layout, expected: u64, found: u64) -> Result<(), Problem> {
    if found == expected {
        return Ok(());
    }
    Err(Problem::Length {
        expected,
        found,
        place: " that can be read".into(),
        shape: layout.describe(),
    })
}

/// Passes over `lines` line ends and returns the bytes passed.
fn skip_lines(source: &mut dyn BufRead, lines: u64) -> Result<u64, Problem> {
    let mut passed = 0;
    for _ in 0..lines {
        match source.skip_until(b'\n').map_err(Problem::io("read the file"))? {
            0 => {
                return Err(Problem::Skip {
                    field: "line skip",
                    asked: lines,
                });
            }
            n => passed += n as u64,
        }
    }
    Ok(passed)
}

/// Passes over `bytes` bytes.
fn skip_bytes(source: &mut dyn Read, bytes: u64, on_error: impl FnOnce(io::Error) -> Problem) -> Result<(), Problem> {
    let passed = io::copy(&mut source.take(bytes), &mut io::sink()).map_err(on_error)?;
    if passed == bytes {
        Ok(())
    } else {
        Err(Problem::Skip {
            field: "byte skip",
            asked: bytes,
        })
    }
}

/// Up to `count` values and whether reading ended well. Room for `reserve` of them is made at once.
pub(super) fn decode(
    layout: &Layout,
    source: &mut dyn Read,
    count: u64,
    reserve: u64,
) -> Result<(Values, io::Result<()>), Problem> {
    use Endian::{Big, Little};
    use ValueType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    let mut end = Ok(());
    let values = match (layout.value_type, layout.endian) {
        (I8, _) => Values::I8(collect(source, count, reserve, &mut end, i8::from_ne_bytes)?),
        (U8, _) => Values::U8(collect(source, count, reserve, &mut end, u8::from_ne_bytes)?),
        (I16, Little) => Values::I16(collect(source, count, reserve, &mut end, i16::from_le_bytes)?),
        (I16, Big) => Values::I16(collect(source, count, reserve, &mut end, i16::from_be_bytes)?),
        (U16, Little) => Values::U16(collect(source, count, reserve, &mut end, u16::from_le_bytes)?),
        (U16, Big) => Values::U16(collect(source, count, reserve, &mut end, u16::from_be_bytes)?),
        (I32, Little) => Values::I32(collect(source, count, reserve, &mut end, i32::from_le_bytes)?),
        (I32, Big) => Values::I32(collect(source, count, reserve, &mut end, i32::from_be_bytes)?),
        (U32, Little) => Values::U32(collect(source, count, reserve, &mut end, u32::from_le_bytes)?),
        (U32, Big) => Values::U32(collect(source, count, reserve, &mut end, u32::from_be_bytes)?),
        (I64, Little) => narrow(&collect(source, count, reserve, &mut end, i64::from_le_bytes)?)?,
        (I64, Big) => narrow(&collect(source, count, reserve, &mut end, i64::from_be_bytes)?)?,
        (U64, Little) => narrow(&collect(source, count, reserve, &mut end, u64::from_le_bytes)?)?,
        (U64, Big) => narrow(&collect(source, count, reserve, &mut end, u64::from_be_bytes)?)?,
        (F32, Little) => Values::F32(collect(source, count, reserve, &mut end, f32::from_le_bytes)?),
        (F32, Big) => Values::F32(collect(source, count, reserve, &mut end, f32::from_be_bytes)?),
        (F64, Little) => Values::F64(collect(source, count, reserve, &mut end, f64::from_le_bytes)?),
        (F64, Big) => Values::F64(collect(source, count, reserve, &mut end, f64::from_be_bytes)?),
    };
    Ok((values, end))
}

/// Reads up to `count` values of `N` bytes; stops early, with the reason in `end`, when the source does.
fn collect<const N: usize, T>(
    source: &mut dyn Read,
    count: u64,
    reserve: u64,
    end: &mut io::Result<()>,
    from_bytes: impl Fn([u8; N]) -> T,
) -> Result<Vec<T>, Problem> {
    const { assert!(CHUNK_LEN.is_multiple_of(N)) };
    let out_of_memory = |values: u64| Problem::Memory {
        bytes: values * N as u64,
    };
    let mut values = Vec::new();
    values
        .try_reserve_exact(reserve as usize)
        .map_err(|_| out_of_memory(reserve))?;
    let mut chunk = vec![0; CHUNK_LEN];
    let mut left = count * N as u64;
    while left > 0 && end.is_ok() {
        let want = left.min(CHUNK_LEN as u64) as usize;
        let (read_len, result) = read_full(source, &mut chunk[..want]);
        *end = result;
        let (whole, _) = chunk[..read_len].as_chunks::<N>();
        values
            .try_reserve(whole.len())
            .map_err(|_| out_of_memory(values.len() as u64))?;
        values.extend(whole.iter().map(|&bytes| from_bytes(bytes)));
        left -= read_len as u64;
        if read_len < want {
            break;
        }
    }
    Ok(values)
}

/// 64-bit integers as 32-bit ones where all of them fit, otherwise as doubles (nearest, which twelve bits do not see).
fn narrow<T: Copy + TryInto<i32> + TryInto<u32> + Into<i128>>(wide: &[T]) -> Result<Values, Problem> {
    fn all<T: Copy, U>(wide: &[T], convert: impl Fn(T) -> Option<U>) -> Result<Option<Vec<U>>, Problem> {
        let mut out = Vec::new();
        out.try_reserve_exact(wide.len()).map_err(|_| Problem::Memory {
            bytes: (wide.len() * size_of::<U>()) as u64,
        })?;
        for &value in wide {
            match convert(value) {
                Some(narrow) => out.push(narrow),
                None => return Ok(None),
            }
        }
        Ok(Some(out))
    }
    if let Some(v) = all(wide, |x| TryInto::<i32>::try_into(x).ok())? {
        return Ok(Values::I32(v));
    }
    if let Some(v) = all(wide, |x| TryInto::<u32>::try_into(x).ok())? {
        return Ok(Values::U32(v));
    }
    let doubles = all(wide, |x| Some(Into::<i128>::into(x) as f64))?;
    Ok(Values::F64(doubles.unwrap_or_default()))
}

/// Characters that one number of a text may have.
const WORD_MAX: usize = 64;

/// Up to one number more than `count` from text, in the layout's type.
fn text_values(layout: &Layout, source: &mut dyn BufRead, count: u64) -> Result<Values, Problem> {
    use ValueType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    Ok(match layout.value_type {
        I8 => Values::I8(words(layout, source, count)?),
        U8 => Values::U8(words(layout, source, count)?),
        I16 => Values::I16(words(layout, source, count)?),
        U16 => Values::U16(words(layout, source, count)?),
        I32 => Values::I32(words(layout, source, count)?),
        U32 => Values::U32(words(layout, source, count)?),
        I64 => narrow(&words::<i64>(layout, source, count)?)?,
        U64 => narrow(&words::<u64>(layout, source, count)?)?,
        F32 => Values::F32(words(layout, source, count)?),
        F64 => Values::F64(words(layout, source, count)?),
    })
}

/// Numbers of a text; more than `count` of them, or a word that is none, are refused.
fn words<T: FromStr>(layout: &Layout, source: &mut dyn BufRead, count: u64) -> Result<Vec<T>, Problem> {
    let mut values = Vec::new();
    let mut word = Vec::new();
    let mut take = |word: &mut Vec<u8>| -> Result<(), Problem> {
        if word.is_empty() {
            return Ok(());
        }
        let number = str::from_utf8(word).ok().and_then(|text| text.parse::<T>().ok());
        let Some(number) = number else {
            let place = format!("value {} of the text is `{}`", values.len(), shorten_bytes(word));
            let expected = format!("{place}, expected a number of type {}", layout.value_type.name());
            return Err(Problem::format("text data", expected));
        };
        if values.len() as u64 == count {
            return Err(Problem::format(
                "text data",
                format!("has more than the {count} numbers expected"),
            ));
        }
        values.push(number);
        word.clear();
        Ok(())
    };
    loop {
        let part = source.fill_buf().map_err(Problem::io("read the file"))?;
        let len = part.len();
        if len == 0 {
            take(&mut word)?;
            return Ok(values);
        }
        for &byte in part {
            match byte {
                b' ' | b'\t' | b'\r' | b'\n' | b',' | 0x0b | 0x0c => take(&mut word)?,
                _ if word.len() < WORD_MAX => word.push(byte),
                _ => {
                    let shown = shorten_bytes(&word);
                    return Err(Problem::format("text data", format!("`{shown}` is no number")));
                }
            }
        }
        source.consume(len);
    }
}

/// Fills `buffer` as far as the source goes: the bytes read, and the error that stopped it if one did.
fn read_full(source: &mut dyn Read, buffer: &mut [u8]) -> (usize, io::Result<()>) {
    let mut filled = 0;
    while filled < buffer.len() {
        match source.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return (filled, Err(error)),
        }
    }
    (filled, Ok(()))
}
