//! What a raw file holds, as a user states it: a sidecar file, a line of words, or the file's own name.
//!
//! A sidecar is a TOML file called like the raw file with `.toml` after it (`bonsai.raw.toml`):
//!
//! ```toml
//! size = [256, 256, 128]       # voxels along x (fastest), y, z
//! type = "uint16"              # int8 … uint64, float, double
//! endian = "little"            # or "big"; only needed for more than one byte
//! spacing = [0.5, 0.5, 1.0]    # default 1
//! skip = 0                     # bytes before the first voxel
//! scale = 1.0                  # value = stored * scale + offset
//! offset = -1024.0
//! modality = "CT"              # or "MR"
//! axes = "RAS"                 # where x, y, z run to in the patient: R or L, A or P, S or I
//! ```
//!
//! The line of words says the same in short: `256x256x128,uint16,big,spacing=0.5x0.5x1,skip=16,axes=RAS`.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{NAME, RawShape};
use crate::error::Problem;
use crate::meaning::Modality;
use crate::text::shorten;
use crate::values::{Endian, ValueType};

/// A raw file's shape and what its values mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// Shape and number type.
    pub shape: RawShape,
    /// What to multiply stored values by.
    pub scale: f64,
    /// What to add to them then.
    pub offset: f64,
    /// What made them.
    pub modality: Option<Modality>,
    /// Directions of the file's axes in LPS.
    pub directions: Option<[[f64; 3]; 3]>,
}

/// A sidecar as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sidecar {
    size: [u64; 3],
    #[serde(rename = "type")]
    value_type: String,
    endian: Option<String>,
    spacing: Option<[f64; 3]>,
    skip: Option<u64>,
    scale: Option<f64>,
    offset: Option<f64>,
    modality: Option<String>,
    axes: Option<String>,
}

/// The sidecar's path of a raw file.
pub fn sidecar_path(raw: &Path) -> PathBuf {
    let mut name = raw.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}

/// Reads the text of a sidecar.
///
/// # Errors
/// [`Problem::Format`] if it is not TOML, has an unknown field, lacks one or has one that is not usable.
pub fn from_toml(text: &str) -> Result<Description, Problem> {
    let one_line = |error: toml::de::Error| Problem::format(NAME, shorten(error.message()));
    toml::from_str::<Sidecar>(text).map_err(one_line)?.describe()
}

/// Reads a line of words.
///
/// # Errors
/// As [`from_toml`].
pub fn from_words(text: &str) -> Result<Description, Problem> {
    let refuse = |word: &str, expected: &str| {
        Problem::format(
            NAME,
            format!("shape `{}`: `{}` is not {expected}", shorten(text), shorten(word)),
        )
    };
    let mut words = text.split(',').map(str::trim);
    let size = words.next().unwrap_or_default();
    let sides = triple::<u64>(size).ok_or_else(|| refuse(size, "a size such as 256x256x128"))?;
    let mut sidecar = Sidecar {
        size: sides,
        value_type: "uint8".into(),
        endian: None,
        spacing: None,
        skip: None,
        scale: None,
        offset: None,
        modality: None,
        axes: None,
    };
    for word in words {
        match word.split_once('=') {
            None if ["little", "big"].contains(&word) => sidecar.endian = Some(word.into()),
            None => sidecar.value_type = word.into(),
            Some(("spacing", value)) => {
                sidecar.spacing = Some(triple(value).ok_or_else(|| refuse(value, "a spacing such as 1x1x2.5"))?);
            }
            Some(("skip", value)) => {
                sidecar.skip = Some(value.parse().map_err(|_| refuse(value, "a number of bytes"))?);
            }
            Some(("scale", value)) => sidecar.scale = Some(value.parse().map_err(|_| refuse(value, "a number"))?),
            Some(("offset", value)) => sidecar.offset = Some(value.parse().map_err(|_| refuse(value, "a number"))?),
            Some(("modality", value)) => sidecar.modality = Some(value.into()),
            Some(("axes", value)) => sidecar.axes = Some(value.into()),
            Some(_) => return Err(refuse(word, "spacing=, skip=, scale=, offset=, modality= or axes=")),
        }
    }
    sidecar.describe()
}

/// The shape that a file's name tells, such as `bonsai_256x256x256_uint8.raw`.
pub fn from_name(path: &Path) -> Option<Description> {
    let stem = path.file_stem()?.to_str()?;
    let words: Vec<&str> = stem.split('_').collect();
    let size = words.iter().find_map(|word| triple::<u64>(word))?;
    let value_type = words
        .iter()
        .find_map(|word| ValueType::from_name(word).or_else(|| float_name(word)))?;
    Some(Description {
        shape: RawShape {
            dims: size,
            spacing: [1.0; 3],
            value_type,
            endian: Endian::Little,
            skip: 0,
        },
        scale: 1.0,
        offset: 0.0,
        modality: None,
        directions: None,
    })
}

/// Names of floating-point types that NRRD does not know.
fn float_name(name: &str) -> Option<ValueType> {
    match name {
        "float32" => Some(ValueType::F32),
        "float64" => Some(ValueType::F64),
        _ => None,
    }
}

/// Three numbers with `x` between.
fn triple<T: std::str::FromStr>(text: &str) -> Option<[T; 3]> {
    let numbers: Vec<T> = text
        .split('x')
        .map(|word| word.trim().parse().ok())
        .collect::<Option<_>>()?;
    numbers.try_into().ok()
}

impl Sidecar {
    fn describe(&self) -> Result<Description, Problem> {
        let refuse = |field: &'static str, value: &str, expected: &'static str| Problem::FieldValue {
            field,
            value: shorten(value),
            expected,
        };
        let value_type = ValueType::from_name(&self.value_type)
            .or_else(|| float_name(&self.value_type))
            .ok_or_else(|| refuse("type", &self.value_type, ValueType::NAMES))?;
        let endian = match self.endian.as_deref() {
            Some("little") => Endian::Little,
            Some("big") => Endian::Big,
            None if value_type.byte_len() == 1 => Endian::Little,
            Some(other) => return Err(refuse("endian", other, "`little` or `big`")),
            None => {
                return Err(Problem::MissingField {
                    field: "endian",
                    expected: "`little` or `big`",
                });
            }
        };
        let directions = match self.axes.as_deref() {
            None => None,
            Some(letters) => {
                let expected = "three letters, one of L R, one of P A, one of S I";
                Some(axes(letters).ok_or_else(|| refuse("axes", letters, expected))?)
            }
        };
        Ok(Description {
            shape: RawShape {
                dims: self.size,
                spacing: self.spacing.unwrap_or([1.0; 3]),
                value_type,
                endian,
                skip: self.skip.unwrap_or(0),
            },
            scale: self.scale.unwrap_or(1.0),
            offset: self.offset.unwrap_or(0.0),
            modality: self.modality.as_deref().and_then(Modality::from_code),
            directions,
        })
    }
}

/// The LPS directions of letters that say where axes run to.
fn axes(letters: &str) -> Option<[[f64; 3]; 3]> {
    let mut directions = Vec::new();
    for letter in letters.chars() {
        directions.push(match letter.to_ascii_uppercase() {
            'L' => [1.0, 0.0, 0.0],
            'R' => [-1.0, 0.0, 0.0],
            'P' => [0.0, 1.0, 0.0],
            'A' => [0.0, -1.0, 0.0],
            'S' => [0.0, 0.0, 1.0],
            'I' => [0.0, 0.0, -1.0],
            _ => return None,
        });
    }
    let directions: [[f64; 3]; 3] = directions.try_into().ok()?;
    let covered = (0..3).all(|axis| directions.iter().any(|d| d[axis] != 0.0));
    covered.then_some(directions)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sidecar_and_words_say_the_same() {
        let toml = "size = [4, 5, 6]\ntype = 'uint16'\nendian = 'big'\nspacing = [0.5, 0.5, 1]\nskip = 16\n\
                    offset = -1024\nmodality = 'CT'\naxes = 'RAS'";
        let words = "4x5x6, uint16, big, spacing=0.5x0.5x1, skip=16, offset=-1024, modality=CT, axes=RAS";
        let description = from_toml(toml).unwrap();
        assert_eq!(description, from_words(words).unwrap());
        assert_eq!(description.directions.unwrap()[0], [-1.0, 0.0, 0.0]);
        assert_eq!(description.shape.endian, Endian::Big);
    }

    #[test]
    fn names_tell_a_shape() {
        let found = from_name(Path::new("a/bonsai_256x256x128_uint8.raw")).unwrap();
        assert_eq!(
            (found.shape.dims, found.shape.value_type),
            ([256, 256, 128], ValueType::U8)
        );
        for none in ["bonsai.raw", "a_2x2_uint8.raw", "a_2x2x2.raw"] {
            assert_eq!(from_name(Path::new(none)), None);
        }
    }

    #[test]
    fn other_descriptions_are_refused() {
        for bad in [
            "",
            "4x5",
            "4x5x6,uint16",
            "4x5x6,nibble",
            "4x5x6,spacing=1",
            "4x5x6,skip=-1",
            "4x5x6,axes=LLS",
            "4x5x6,a=1",
        ] {
            assert!(from_words(bad).is_err(), "{bad}");
        }
        for bad in [
            "",
            "size = 4",
            "size = [1,1,1]",
            "size = [1,1,1]\ntype = 'uint8'\nfoo = 1",
            "size = [-1,1,1]\ntype='uint8'",
        ] {
            let message = from_toml(bad).unwrap_err().to_string();
            assert!(!message.contains('\n'), "{message}");
        }
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig {
            cases: 1000,
            failure_persistence: None,
            rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
            ..proptest::prelude::ProptestConfig::default()
        })]

        /// Whatever a description says, reading it ends with one or an error of one line.
        #[test]
        fn mutated_descriptions_never_panic(edits in proptest::collection::vec((0_usize..200, 0_u8..128), 0..6)) {
            let words = "4x5x6,uint16,big,spacing=0.5x0.5x1,skip=16,offset=-1024,axes=RAS";
            let toml = "size = [4, 5, 6]\ntype = 'uint16'\nendian = 'big'\naxes = 'RAS'\n";
            for (text, read) in [(words, from_words as fn(&str) -> _), (toml, from_toml)] {
                let mut bytes = text.as_bytes().to_vec();
                for &(at, byte) in &edits {
                    let at = at % bytes.len();
                    bytes[at] = byte;
                }
                if let Err(problem) = read(&String::from_utf8(bytes).unwrap()) {
                    proptest::prop_assert!(!problem.to_string().contains('\n'));
                }
            }
        }
    }
}
