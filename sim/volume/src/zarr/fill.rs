//! The value of voxels that no chunk holds.

use serde_json::Value;

use crate::text::shorten;
use crate::values::{Endian, ValueType};

/// The bytes of a fill value; one that is not stated is 0.
///
/// # Errors
/// What was expected.
pub(super) fn bytes(value: Option<&Value>, value_type: ValueType, endian: Endian) -> Result<Vec<u8>, String> {
    let len = value_type.byte_len() as usize;
    let little = match value {
        None => Some(vec![0; len]),
        Some(value) => little(value, value_type),
    };
    let mut bytes = little.ok_or_else(|| {
        let found = value.map_or(String::new(), Value::to_string);
        let type_name = value_type.name();
        format!(
            "`fill_value` is {}, expected a value of type {type_name}",
            shorten(&found)
        )
    })?;
    if endian == Endian::Big {
        bytes.reverse();
    }
    Ok(bytes)
}

/// The bytes, the least significant first.
fn little(value: &Value, value_type: ValueType) -> Option<Vec<u8>> {
    // Zarr 2 writes whole numbers with a point now and then.
    let whole = || {
        let float = value.as_f64().filter(|x| x.fract() == 0.0 && x.abs() < 9e15);
        let exact = value.as_i64().map(i128::from).or(value.as_u64().map(i128::from));
        exact.or(float.map(|x| x as i128))
    };
    macro_rules! whole {
        ($type:ty) => {
            <$type>::try_from(whole()?).ok()?.to_le_bytes().to_vec()
        };
    }
    Some(match value_type {
        ValueType::I8 => whole!(i8),
        ValueType::U8 => whole!(u8),
        ValueType::I16 => whole!(i16),
        ValueType::U16 => whole!(u16),
        ValueType::I32 => whole!(i32),
        ValueType::U32 => whole!(u32),
        ValueType::I64 => whole!(i64),
        ValueType::U64 => whole!(u64),
        ValueType::F32 | ValueType::F64 => {
            let word = value.as_str();
            if let Some(digits) = word.and_then(|word| word.strip_prefix("0x")) {
                let bits = u64::from_str_radix(digits, 16).ok()?;
                let is_whole = digits.len() == 2 * value_type.byte_len() as usize;
                return is_whole.then(|| bits.to_le_bytes()[..value_type.byte_len() as usize].to_vec());
            }
            let number = match word {
                None => value.as_f64()?,
                Some("NaN") => f64::NAN,
                Some("Infinity") => f64::INFINITY,
                Some("-Infinity") => f64::NEG_INFINITY,
                Some(_) => return None,
            };
            match value_type {
                ValueType::F32 => (number as f32).to_le_bytes().to_vec(),
                _ => number.to_le_bytes().to_vec(),
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_their_bytes() {
        let of = |text: &str, value_type| {
            let value: Value = serde_json::from_str(text).unwrap();
            bytes(Some(&value), value_type, Endian::Big)
        };
        assert_eq!(bytes(None, ValueType::I16, Endian::Little), Ok(vec![0, 0]));
        assert_eq!(of("-2", ValueType::I16), Ok(vec![0xff, 0xfe]));
        assert_eq!(of("7.0", ValueType::U8), Ok(vec![7]));
        assert_eq!(of("18446744073709551615", ValueType::U64), Ok(vec![0xff; 8]));
        assert_eq!(of("1.5", ValueType::F32), Ok(1.5_f32.to_be_bytes().to_vec()));
        assert_eq!(of("\"0x7fc00000\"", ValueType::F32), Ok(vec![0x7f, 0xc0, 0, 0]));
        assert_eq!(of("\"NaN\"", ValueType::F64), Ok(f64::NAN.to_be_bytes().to_vec()));
        assert_eq!(
            of("\"-Infinity\"", ValueType::F32),
            Ok(f32::NEG_INFINITY.to_be_bytes().to_vec())
        );
        for (text, value_type) in [
            ("300", ValueType::U8),
            ("-1", ValueType::U32),
            ("1.5", ValueType::I32),
            ("\"x\"", ValueType::F32),
            ("\"0x7fc0\"", ValueType::F32),
            ("[0]", ValueType::U8),
        ] {
            assert!(
                of(text, value_type).unwrap_err().contains("expected a value of type"),
                "{text}"
            );
        }
    }
}
