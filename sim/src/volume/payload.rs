//! The bytes behind a header: skipped, unpacked and turned into values, with no more memory than bytes that arrived.
//!
//! Plain data are refused before anything is allocated unless the file holds exactly the bytes that the shape needs.
//! Compressed data cannot be measured beforehand: their buffer grows as they unpack and stops at the shape's size.

use std::io::{self, BufRead, Read};

use flate2::bufread::MultiGzDecoder;

use super::error::Problem;
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
}

/// How many bytes precede the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteSkip {
    /// So many (of the unpacked bytes, if they are packed).
    Bytes(u64),
    /// As many as it takes for the values to end with the file; plain data only.
    FromEnd,
}

/// What the bytes mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Voxels along x, y, z.
    pub dims: [u64; 3],
    /// Number type of a voxel.
    pub value_type: ValueType,
    /// Byte order.
    pub endian: Endian,
    /// Whether packed.
    pub encoding: Encoding,
    /// Lines to skip before unpacking.
    pub line_skip: u64,
    /// Bytes to skip after unpacking.
    pub byte_skip: ByteSkip,
}

impl Layout {
    /// For messages.
    fn describe(&self) -> String {
        let [x, y, z] = self.dims;
        format!("{x} x {y} x {z} {}", self.value_type.name())
    }
}

/// Reads the values that `layout` describes from `source`, which has `source_len` bytes left.
pub(super) fn read_values<R: BufRead>(layout: &Layout, source: &mut R, source_len: u64) -> Result<Values, Problem> {
    let voxels = voxel_count(layout.dims)?;
    let expected = voxels * layout.value_type.byte_len();
    let remaining = source_len.saturating_sub(skip_lines(source, layout.line_skip)?);
    match layout.encoding {
        Encoding::Raw => {
            let skip = match layout.byte_skip {
                ByteSkip::Bytes(n) => n,
                ByteSkip::FromEnd => remaining.saturating_sub(expected),
            };
            if skip.checked_add(expected) != Some(remaining) {
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
            }
            skip_bytes(source, skip, Problem::io("read the file"))?;
            // The file was seen to hold all of them, so the whole buffer may be reserved at once.
            let (values, read) = decode(layout, source, voxels, voxels)?;
            read.map_err(Problem::io("read the file"))?;
            complete(layout, expected, values)
        }
        Encoding::Gzip => {
            let mut unpacked = MultiGzDecoder::new(source);
            let damaged = |done: u64| {
                move |error: io::Error| Problem::Gzip {
                    unpacked: done,
                    expected,
                    message: error.to_string(),
                }
            };
            if let ByteSkip::Bytes(n) = layout.byte_skip {
                skip_bytes(&mut unpacked, n, damaged(0))?;
            }
            let (values, read) = decode(layout, &mut unpacked, voxels, 0)?;
            read.map_err(damaged(values.len() as u64 * layout.value_type.byte_len()))?;
            let values = complete(layout, expected, values)?;
            match read_full(&mut unpacked, &mut [0]) {
                (0, Ok(())) => Ok(values),
                (0, Err(error)) => Err(damaged(expected)(error)),
                _ => Err(Problem::UnpacksTooLong {
                    expected,
                    shape: layout.describe(),
                }),
            }
        }
    }
}

/// Refuses data that ended early.
fn complete(layout: &Layout, expected: u64, values: Values) -> Result<Values, Problem> {
    let found = values.len() as u64 * layout.value_type.byte_len();
    if found == expected {
        return Ok(values);
    }
    Err(Problem::Length {
        expected,
        found,
        place: " that can be read".into(),
        shape: layout.describe(),
    })
}

/// Passes over `lines` line ends and returns the bytes passed.
fn skip_lines<R: BufRead>(source: &mut R, lines: u64) -> Result<u64, Problem> {
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
fn skip_bytes<R: Read>(source: &mut R, bytes: u64, on_error: impl FnOnce(io::Error) -> Problem) -> Result<(), Problem> {
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
fn decode<R: Read>(
    layout: &Layout,
    source: &mut R,
    count: u64,
    reserve: u64,
) -> Result<(Values, io::Result<()>), Problem> {
    use Endian::{Big, Little};
    use ValueType::{F32, F64, I8, I16, I32, U8, U16, U32};
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
        (F32, Little) => Values::F32(collect(source, count, reserve, &mut end, f32::from_le_bytes)?),
        (F32, Big) => Values::F32(collect(source, count, reserve, &mut end, f32::from_be_bytes)?),
        (F64, Little) => Values::F64(collect(source, count, reserve, &mut end, f64::from_le_bytes)?),
        (F64, Big) => Values::F64(collect(source, count, reserve, &mut end, f64::from_be_bytes)?),
    };
    Ok((values, end))
}

/// Reads up to `count` values of `N` bytes; stops early, with the reason in `end`, when the source does.
fn collect<const N: usize, T>(
    source: &mut impl Read,
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

/// Fills `buffer` as far as the source goes: the bytes read, and the error that stopped it if one did.
fn read_full(source: &mut impl Read, buffer: &mut [u8]) -> (usize, io::Result<()>) {
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
