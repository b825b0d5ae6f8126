//! Volumes as their files state them: shape, spacing, and values in the file's own number type.
//!
//! Every reader ends in [`Decoded::new`](crate::decoded::Decoded::new), which checks once what the rest of the program relies on: no side is empty or
//! over [`MAX_AXIS`], the spacing is a length, there is one value a voxel, and every value is finite.

use super::error::{Problem, ShapeError};
use super::limits::{MAX_AXIS, MAX_SPACING, MAX_VOXELS, MIN_SPACING};

/// The number types that volume files hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ValueType {
    /// Signed 8-bit integer.
    I8,
    /// Unsigned 8-bit integer.
    U8,
    /// Signed 16-bit integer.
    I16,
    /// Unsigned 16-bit integer.
    U16,
    /// Signed 32-bit integer.
    I32,
    /// Unsigned 32-bit integer.
    U32,
    /// Signed 64-bit integer.
    I64,
    /// Unsigned 64-bit integer.
    U64,
    /// IEEE single precision.
    F32,
    /// IEEE double precision.
    F64,
}

impl ValueType {
    /// Names accepted by [`ValueType::from_name`], the short one of each type.
    pub const NAMES: &'static str = "int8, uint8, int16, uint16, int32, uint32, int64, uint64, float or double";

    /// Bytes of one value.
    pub const fn byte_len(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The type of a name in any of NRRD's spellings, such as `short`, `signed short int` or `int16_t`, in either case.
    pub fn from_name(name: &str) -> Option<Self> {
        let words: Vec<String> = name.split_ascii_whitespace().map(str::to_ascii_lowercase).collect();
        match words.join(" ").as_str() {
            "signed char" | "int8" | "int8_t" => Some(Self::I8),
            "uchar" | "unsigned char" | "uint8" | "uint8_t" => Some(Self::U8),
            "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Some(Self::I16),
            "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Some(Self::U16),
            "int" | "signed int" | "int32" | "int32_t" => Some(Self::I32),
            "uint" | "unsigned int" | "uint32" | "uint32_t" => Some(Self::U32),
            "longlong"
            | "long long"
            | "long long int"
            | "signed long long"
            | "signed long long int"
            | "int64"
            | "int64_t" => Some(Self::I64),
            "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Some(Self::U64),
            "float" => Some(Self::F32),
            "double" => Some(Self::F64),
            _ => None,
        }
    }

    /// The short name, which [`ValueType::from_name`] accepts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::I8 => "int8",
            Self::U8 => "uint8",
            Self::I16 => "int16",
            Self::U16 => "uint16",
            Self::I32 => "int32",
            Self::U32 => "uint32",
            Self::I64 => "int64",
            Self::U64 => "uint64",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }
}

/// The order of the bytes of one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// Values in their file's number type, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Signed 8-bit integers.
    I8(Vec<i8>),
    /// Unsigned 8-bit integers.
    U8(Vec<u8>),
    /// Signed 16-bit integers.
    I16(Vec<i16>),
    /// Unsigned 16-bit integers.
    U16(Vec<u16>),
    /// Signed 32-bit integers.
    I32(Vec<i32>),
    /// Unsigned 32-bit integers.
    U32(Vec<u32>),
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

impl Values {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::I8(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::I16(v) => v.len(),
            Self::U16(v) => v.len(),
            Self::I32(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their number type; 64-bit integers are kept as 32-bit ones or as doubles.
    pub const fn value_type(&self) -> ValueType {
        match self {
            Self::I8(_) => ValueType::I8,
            Self::U8(_) => ValueType::U8,
            Self::I16(_) => ValueType::I16,
            Self::U16(_) => ValueType::U16,
            Self::I32(_) => ValueType::I32,
            Self::U32(_) => ValueType::U32,
            Self::F32(_) => ValueType::F32,
            Self::F64(_) => ValueType::F64,
        }
    }

    /// Hands the values over, one after another, until `take` returns false.
    pub(super) fn for_each(&self, mut take: impl FnMut(f64) -> bool) {
        fn all<T: Copy + Into<f64>>(values: &[T], take: &mut impl FnMut(f64) -> bool) {
            // `all` ends with the first false.
            let _ended = values.iter().all(|&value| take(value.into()));
        }
        match self {
            Self::I8(v) => all(v, &mut take),
            Self::U8(v) => all(v, &mut take),
            Self::I16(v) => all(v, &mut take),
            Self::U16(v) => all(v, &mut take),
            Self::I32(v) => all(v, &mut take),
            Self::U32(v) => all(v, &mut take),
            Self::F32(v) => all(v, &mut take),
            Self::F64(v) => all(v, &mut take),
        }
    }

    /// Whether all of them are whole numbers that doubles tell apart, whatever their type.
    pub fn are_whole(&self) -> bool {
        const EXACT: f64 = 9_007_199_254_740_992.0;
        let mut whole = true;
        if matches!(self, Self::F32(_) | Self::F64(_)) {
            self.for_each(|value| {
                whole = value.fract() == 0.0 && value.abs() <= EXACT;
                whole
            });
        }
        whole
    }

    /// The values times `scale` plus `offset`, as single precision if their type has at most 16 bits.
    pub(super) fn rescaled(&self, scale: f64, offset: f64) -> Result<Self, Problem> {
        Ok(match self {
            Self::I8(v) => Self::F32(converted(v, |x| (f64::from(x) * scale + offset) as f32)?),
            Self::U8(v) => Self::F32(converted(v, |x| (f64::from(x) * scale + offset) as f32)?),
            Self::I16(v) => Self::F32(converted(v, |x| (f64::from(x) * scale + offset) as f32)?),
            Self::U16(v) => Self::F32(converted(v, |x| (f64::from(x) * scale + offset) as f32)?),
            Self::I32(v) => Self::F64(converted(v, |x| f64::from(x) * scale + offset)?),
            Self::U32(v) => Self::F64(converted(v, |x| f64::from(x) * scale + offset)?),
            Self::F32(v) => Self::F64(converted(v, |x| f64::from(x) * scale + offset)?),
            Self::F64(v) => Self::F64(converted(v, |x| x * scale + offset)?),
        })
    }

    /// Adds values of the same type; `false`, and nothing changed, if theirs is another.
    pub(super) fn append(&mut self, more: &Self) -> Result<bool, Problem> {
        fn extend<T: Copy>(values: &mut Vec<T>, more: &[T]) -> Result<bool, Problem> {
            values.try_reserve(more.len()).map_err(|_| Problem::Memory {
                bytes: ((values.len() + more.len()) * size_of::<T>()) as u64,
            })?;
            values.extend_from_slice(more);
            Ok(true)
        }
        match (self, more) {
            (Self::I8(v), Self::I8(m)) => extend(v, m),
            (Self::U8(v), Self::U8(m)) => extend(v, m),
            (Self::I16(v), Self::I16(m)) => extend(v, m),
            (Self::U16(v), Self::U16(m)) => extend(v, m),
            (Self::I32(v), Self::I32(m)) => extend(v, m),
            (Self::U32(v), Self::U32(m)) => extend(v, m),
            (Self::F32(v), Self::F32(m)) => extend(v, m),
            (Self::F64(v), Self::F64(m)) => extend(v, m),
            _ => Ok(false),
        }
    }

    /// Exchanges the least and the greatest value of an unsigned type, and all between; `false` of any other type.
    pub(super) fn invert(&mut self) -> bool {
        match self {
            Self::U8(v) => v.iter_mut().for_each(|value| *value = !*value),
            Self::U16(v) => v.iter_mut().for_each(|value| *value = !*value),
            Self::U32(v) => v.iter_mut().for_each(|value| *value = !*value),
            _ => return false,
        }
        true
    }

    /// Puts the least number in place of NaN (the greatest one where `falling`) and returns how often; `None` if there is
    /// no number at all.
    pub(super) fn fill_nan(&mut self, falling: bool) -> Option<usize> {
        fn fill<T: Copy>(values: &mut [T], is_nan: fn(T) -> bool, pick: fn(T, T) -> T) -> Option<usize> {
            let background = values.iter().copied().filter(|&v| !is_nan(v)).reduce(pick)?;
            let holes = values.iter_mut().filter(|v| is_nan(**v));
            Some(holes.map(|value| *value = background).count())
        }
        match self {
            Self::F32(v) => fill(v, f32::is_nan, if falling { f32::max } else { f32::min }),
            Self::F64(v) => fill(v, f64::is_nan, if falling { f64::max } else { f64::min }),
            _ => Some(0),
        }
    }

    /// CRC-32 (as zlib's) of the values as little-endian bytes, for comparison with other readers.
    pub fn crc32(&self) -> u32 {
        fn sum<T: Copy, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N]) -> u32 {
            let mut crc = flate2::Crc::new();
            for part in values.chunks(1 << 14) {
                let packed: Vec<u8> = part.iter().flat_map(|&v| bytes(v)).collect();
                crc.update(&packed);
            }
            crc.sum()
        }
        match self {
            Self::I8(v) => sum(v, i8::to_le_bytes),
            Self::U8(v) => sum(v, u8::to_le_bytes),
            Self::I16(v) => sum(v, i16::to_le_bytes),
            Self::U16(v) => sum(v, u16::to_le_bytes),
            Self::I32(v) => sum(v, i32::to_le_bytes),
            Self::U32(v) => sum(v, u32::to_le_bytes),
            Self::F32(v) => sum(v, f32::to_le_bytes),
            Self::F64(v) => sum(v, f64::to_le_bytes),
        }
    }

    /// Index and value of the first NaN or infinity.
    pub(super) fn first_not_finite(&self) -> Option<(usize, f64)> {
        let find = |found: Option<(usize, f64)>| found.filter(|(_, value)| !value.is_finite());
        match self {
            Self::F32(v) => find(v.iter().position(|x| !x.is_finite()).map(|i| (i, f64::from(v[i])))),
            Self::F64(v) => find(v.iter().position(|x| !x.is_finite()).map(|i| (i, v[i]))),
            _ => None,
        }
    }
}

/// Every value through `convert`, in memory that was asked for first.
fn converted<T: Copy, U>(values: &[T], convert: impl Fn(T) -> U) -> Result<Vec<U>, Problem> {
    let mut out = Vec::new();
    out.try_reserve_exact(values.len()).map_err(|_| Problem::Memory {
        bytes: (values.len() * size_of::<U>()) as u64,
    })?;
    out.extend(values.iter().map(|&v| convert(v)));
    Ok(out)
}

/// The number of voxels of a shape, checked.
///
/// # Errors
/// [`ShapeError::Axis`] or [`ShapeError::Voxels`] if a side or the product is out of range.
pub(super) fn voxel_count(dims: [u64; 3]) -> Result<u64, ShapeError> {
    let voxels = side_product(dims)?;
    if voxels > MAX_VOXELS {
        return Err(ShapeError::Voxels { voxels });
    }
    Ok(voxels)
}

/// The number of voxels of a shape that need not be held in memory.
///
/// # Errors
/// [`ShapeError::Axis`] if a side is out of range.
pub(super) fn side_product(dims: [u64; 3]) -> Result<u64, ShapeError> {
    if let Some(axis) = (0..3).find(|&axis| !(1..=MAX_AXIS as u64).contains(&dims[axis])) {
        return Err(ShapeError::Axis { axis, len: dims[axis] });
    }
    // At most 2^39, since each side is at most 2^13.
    Ok(dims[0] * dims[1] * dims[2])
}

/// Refuses spacings that are no lengths.
pub(super) fn check_spacing(spacing: [f64; 3]) -> Result<(), ShapeError> {
    match (0..3).find(|&axis| !(MIN_SPACING..=MAX_SPACING).contains(&spacing[axis])) {
        Some(axis) => Err(ShapeError::Spacing {
            axis,
            spacing: spacing[axis],
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoded::Decoded;

    #[test]
    fn names_of_types_come_back() {
        for name in [
            "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float", "double",
        ] {
            assert_eq!(ValueType::from_name(name).unwrap().name(), name);
        }
        assert_eq!(ValueType::from_name("Signed  Short INT"), Some(ValueType::I16));
        assert_eq!(ValueType::from_name("block"), None);
    }

    #[test]
    fn shapes_out_of_range_are_refused() {
        assert_eq!(voxel_count([1, 0, 1]), Err(ShapeError::Axis { axis: 1, len: 0 }));
        assert_eq!(
            voxel_count([8192, 1, 8193]),
            Err(ShapeError::Axis { axis: 2, len: 8193 })
        );
        assert_eq!(voxel_count([8192, 8192, 32]), Ok(MAX_VOXELS));
        assert_eq!(
            voxel_count([8192, 8192, 33]),
            Err(ShapeError::Voxels {
                voxels: 8192 * 8192 * 33
            })
        );
        assert_eq!(
            voxel_count([u64::MAX; 3]),
            Err(ShapeError::Axis { axis: 0, len: u64::MAX })
        );
    }

    #[test]
    fn spacings_that_are_no_lengths_are_refused() {
        for bad in [0.0, -1.0, 1e-320, 1e31, f64::INFINITY] {
            let result = Decoded::new("t".into(), [1; 3], [1.0, bad, 1.0], Values::U8(vec![0]));
            assert_eq!(result, Err(ShapeError::Spacing { axis: 1, spacing: bad }));
        }
        let message = check_spacing([1.0, 1e-320, 1.0]).unwrap_err().to_string();
        assert_eq!(
            message,
            "has spacing 1e-320 along y, expected a length from 1e-30 to 1e30"
        );
        assert!(check_spacing([f64::NAN, 1.0, 1.0]).is_err());
    }

    #[test]
    fn one_finite_value_a_voxel_is_required() {
        let result = Decoded::new("t".into(), [2, 1, 1], [1.0; 3], Values::U8(vec![0]));
        assert_eq!(result, Err(ShapeError::Values { expected: 2, found: 1 }));
        let mut values = vec![0.0_f32; 12];
        values[2 * 2 + 2 + 1] = f32::NEG_INFINITY;
        let result = Decoded::new("t".into(), [2, 2, 3], [1.0; 3], Values::F32(values));
        assert_eq!(
            result,
            Err(ShapeError::NotFinite {
                voxel: [1, 1, 1],
                value: f64::NEG_INFINITY
            })
        );
        let message = result.unwrap_err().to_string();
        assert_eq!(message, "voxel (1, 1, 1) is -inf, expected finite numbers only");
    }
}
