//! The fixed fields of a NIfTI header.

use std::io::Read;

use crate::error::Problem;
use crate::values::{Endian, ValueType};

/// The format's name in messages.
pub(super) const NAME: &str = "NIfTI";

/// Bytes of a NIfTI-1 header.
const LEN_1: usize = 348;
/// Bytes of a NIfTI-2 header.
const LEN_2: usize = 540;

/// What a header says, with its numbers checked as far as they stand for themselves.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub dims: [u64; 3],
    pub value_type: ValueType,
    /// Values of a voxel: 1, or 3 or 4 of colours.
    pub components: u64,
    pub endian: Endian,
    /// Whether the data follow in the same file.
    pub attached: bool,
    /// Bytes before the data.
    pub data_offset: u64,
    pub slope: f64,
    pub intercept: f64,
    /// `cal_min`, `cal_max`.
    pub display_range: [f64; 2],
    /// `pixdim[0]`, the handedness of the qform, and the three spacings in millimetres.
    pub handedness: f64,
    pub spacing: [f64; 3],
    /// Millimetres a unit of space.
    pub unit: f64,
    pub qform_code: i32,
    pub sform_code: i32,
    /// Quaternion b, c, d.
    pub quaternion: [f64; 3],
    /// The first three columns of the sform, rows x, y, z (RAS).
    pub sform: [[f64; 3]; 3],
    pub notes: Vec<String>,
}

/// Whether bytes begin with a NIfTI-1 or NIfTI-2 header.
pub(super) fn has_magic(start: &[u8]) -> bool {
    let at = |offset: usize, magic: &[u8]| start.get(offset..offset + magic.len()) == Some(magic);
    at(344, b"n+1\0") || at(344, b"ni1\0") || at(4, b"n+2\0") || at(4, b"ni2\0")
}

/// Numbers at fixed places of a header in one byte order. The places lie inside by construction.
struct Fields<'a> {
    bytes: &'a [u8],
    endian: Endian,
}

impl Fields<'_> {
    fn array<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut out = [0; N];
        if let Some(part) = self.bytes.get(at..at + N) {
            out.copy_from_slice(part);
        }
        if self.endian == Endian::Big {
            out.reverse();
        }
        out
    }

    fn i16(&self, at: usize) -> i64 {
        i64::from(i16::from_le_bytes(self.array(at)))
    }

    fn i32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.array(at))
    }

    fn i64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.array(at))
    }

    fn f32(&self, at: usize) -> f64 {
        f64::from(f32::from_le_bytes(self.array(at)))
    }

    fn f64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.array(at))
    }
}

impl Header {
    /// Reads a header from its first byte.
    pub fn read(source: &mut impl Read) -> Result<Self, Problem> {
        let mut bytes = Vec::new();
        let read = source.take(LEN_2 as u64).read_to_end(&mut bytes);
        // A damaged gzip stream may still have given the whole header.
        if bytes.len() < LEN_1 {
            let reason = read.err().map_or_else(String::new, |error| format!(" ({error})"));
            let found = bytes.len();
            let fault = format!("has {found} bytes{reason}, expected a header of {LEN_1} or {LEN_2}");
            return Err(Problem::format(NAME, fault));
        }
        let little = Fields {
            bytes: &bytes,
            endian: Endian::Little,
        };
        let big = Fields {
            bytes: &bytes,
            endian: Endian::Big,
        };
        match (little.i32(0), big.i32(0)) {
            (348, _) => Self::first(&little),
            (_, 348) => Self::first(&big),
            (540, _) if bytes.len() == LEN_2 => Self::second(&little),
            (_, 540) if bytes.len() == LEN_2 => Self::second(&big),
            (found, _) => {
                let fault = format!("states a header of {found} bytes, expected {LEN_1} or {LEN_2}");
                Err(Problem::format(NAME, fault))
            }
        }
    }

    /// NIfTI-1.
    fn first(fields: &Fields<'_>) -> Result<Self, Problem> {
        let mut notes = Vec::new();
        let attached = magic(fields.bytes, 344, [b"n+1\0", b"ni1\0"])?;
        let offset = fields.f32(108);
        let whole = (0.0..=4294967296.0).contains(&offset) && offset.fract() == 0.0;
        if !whole {
            return Err(Problem::format(
                NAME,
                format!("vox_offset is {offset}, expected a whole number"),
            ));
        }
        Self {
            dims: dims([0, 1, 2, 3, 4, 5, 6, 7].map(|i| fields.i16(40 + 2 * i)), &mut notes)?,
            value_type: value_type(fields.i16(70))?,
            components: components(fields.i16(70)),
            endian: fields.endian,
            attached,
            data_offset: offset as u64,
            slope: fields.f32(112),
            intercept: fields.f32(116),
            display_range: [fields.f32(128), fields.f32(124)],
            handedness: fields.f32(76),
            spacing: [80, 84, 88].map(|at| fields.f32(at)),
            unit: 1.0,
            qform_code: fields.i16(252) as i32,
            sform_code: fields.i16(254) as i32,
            quaternion: [256, 260, 264].map(|at| fields.f32(at)),
            sform: [280, 296, 312].map(|row| [0, 4, 8].map(|column| fields.f32(row + column))),
            notes,
        }
        .checked(i32::from(fields.bytes.get(123).copied().unwrap_or(0)), LEN_1 as u64 + 4)
    }

    /// NIfTI-2.
    fn second(fields: &Fields<'_>) -> Result<Self, Problem> {
        let mut notes = Vec::new();
        let attached = magic(fields.bytes, 4, [b"n+2\0", b"ni2\0"])?;
        let offset = fields.i64(168);
        let data_offset = u64::try_from(offset)
            .map_err(|_| Problem::format(NAME, format!("vox_offset is {offset}, expected 0 or more")))?;
        Self {
            dims: dims([0, 1, 2, 3, 4, 5, 6, 7].map(|i| fields.i64(16 + 8 * i)), &mut notes)?,
            value_type: value_type(fields.i16(12))?,
            components: components(fields.i16(12)),
            endian: fields.endian,
            attached,
            data_offset,
            slope: fields.f64(176),
            intercept: fields.f64(184),
            display_range: [fields.f64(200), fields.f64(192)],
            handedness: fields.f64(104),
            spacing: [112, 120, 128].map(|at| fields.f64(at)),
            unit: 1.0,
            qform_code: fields.i32(344),
            sform_code: fields.i32(348),
            quaternion: [352, 360, 368].map(|at| fields.f64(at)),
            sform: [400, 432, 464].map(|row| [0, 8, 16].map(|column| fields.f64(row + column))),
            notes,
        }
        .checked(fields.i32(500), LEN_2 as u64 + 4)
    }

    /// Brings lengths to millimetres and refuses data that would begin inside the header.
    fn checked(mut self, units: i32, least_offset: u64) -> Result<Self, Problem> {
        if self.attached && self.data_offset < least_offset {
            let fault = format!("vox_offset is {}, expected {least_offset} or more", self.data_offset);
            return Err(Problem::format(NAME, fault));
        }
        if !(self.slope.is_finite() && self.intercept.is_finite()) {
            self.notes.push(format!(
                "scl_slope {} and scl_inter {} are no numbers: the values are taken as stored",
                self.slope, self.intercept
            ));
            (self.slope, self.intercept) = (0.0, 0.0);
        }
        self.unit = match units & 7 {
            1 => 1000.0,
            3 => 0.001,
            _ => 1.0,
        };
        self.spacing = self.spacing.map(|length| length.abs() * self.unit);
        self.sform = self.sform.map(|row| row.map(|c| c * self.unit));
        Ok(self)
    }
}

/// Whether the data are attached, from one of two magic words.
fn magic(bytes: &[u8], at: usize, words: [&[u8; 4]; 2]) -> Result<bool, Problem> {
    let found = bytes.get(at..at + 4).unwrap_or(&[]);
    match words.iter().position(|word| found == *word) {
        Some(index) => Ok(index == 0),
        None => {
            let found = found.escape_ascii();
            let fault =
                format!("magic is \"{found}\", expected \"n+1\" or \"ni1\" (Analyze 7.5 states no orientation)");
            Err(Problem::format(NAME, fault))
        }
    }
}

/// Voxels along x, y, z; further axes must have one entry each, or none.
fn dims([count, sides @ ..]: [i64; 8], notes: &mut Vec<String>) -> Result<[u64; 3], Problem> {
    let axes = match usize::try_from(count) {
        Ok(axes @ 1..=7) => axes,
        _ => return Err(Problem::format(NAME, format!("dim[0] is {count}, expected 1 to 7"))),
    };
    let mut stated = &sides[..axes];
    // Some programs count axes that they leave at 0.
    while let [space @ .., 0] = stated
        && space.len() >= 3
    {
        notes.push(format!("dim[{}] is 0: the axis is left out", stated.len()));
        stated = space;
    }
    if let Some(i) = stated.iter().position(|&side| side < 1) {
        let fault = format!("dim[{}] is {}, expected 1 or more", i + 1, stated[i]);
        return Err(Problem::format(NAME, fault));
    }
    let (space, more) = stated.split_at(stated.len().min(3));
    if let Some(i) = more.iter().position(|&side| side != 1) {
        return Err(Problem::Unsupported {
            format: NAME,
            found: format!("a file of {} volumes or components (dim[{}])", more[i], i + 4),
            expected: "one volume of one value a voxel",
        });
    }
    let mut dims = [1; 3];
    for (dim, &side) in dims.iter_mut().zip(space) {
        *dim = side as u64;
    }
    Ok(dims)
}

/// Datatype of red, green, blue, 8 bits each.
const RGB: i64 = 128;
/// And of an opacity besides.
const RGBA: i64 = 2304;

/// Values of a voxel by its datatype.
const fn components(code: i64) -> u64 {
    match code {
        RGB => 3,
        RGBA => 4,
        _ => 1,
    }
}

/// The number type of a datatype code.
fn value_type(code: i64) -> Result<ValueType, Problem> {
    Ok(match code {
        2 | RGB | RGBA => ValueType::U8,
        4 => ValueType::I16,
        8 => ValueType::I32,
        16 => ValueType::F32,
        64 => ValueType::F64,
        256 => ValueType::I8,
        512 => ValueType::U16,
        768 => ValueType::U32,
        1024 => ValueType::I64,
        1280 => ValueType::U64,
        other => {
            return Err(Problem::Unsupported {
                format: NAME,
                found: format!("datatype {other}"),
                expected: "2, 4, 8, 16, 64, 256, 512, 768, 1024 or 1280 (real numbers of one component), 128 or 2304 (colours)",
            });
        }
    })
}
