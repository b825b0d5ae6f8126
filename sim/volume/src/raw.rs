//! Raw volumes: values without a header, in a shape that the user states ([`describe`]).

pub mod describe;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use self::describe::Description;
use super::axes::Directions;
use super::choice::{Choice, NanRule};
use super::decoded::Decoded;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::payload::{ByteSkip, Encoding, Layout, Tail};
use super::placed::{Place, Placed};
use super::values::{Endian, ValueType, check_spacing};

/// The format's name in messages.
const NAME: &str = "raw";

/// Bytes that a sidecar may have.
const SIDECAR_MAX: u64 = 1 << 16;

/// What a raw file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawShape {
    /// Voxels along x (fastest), y and z.
    pub dims: [u64; 3],
    /// Distance between voxels along x, y and z; any unit of length.
    pub spacing: [f64; 3],
    /// Number type of a voxel.
    pub value_type: ValueType,
    /// Byte order of a voxel; without effect on single bytes.
    pub endian: Endian,
    /// Bytes before the first voxel.
    pub skip: u64,
}

/// Reads a raw file, which has to hold exactly the skipped bytes and the voxels.
///
/// # Errors
/// [`ReadError`] if the shape is out of range, the file is no regular file, cannot be read or is shorter or longer than
/// the shape says, or a voxel is NaN or infinite.
pub fn read(path: &Path, shape: &RawShape) -> Result<Decoded, ReadError> {
    let plain = Description {
        shape: *shape,
        scale: 1.0,
        offset: 0.0,
        modality: None,
        directions: None,
    };
    place(path, &plain)?.read(NanRule::Refuse)
}

/// Reads a raw file as described.
///
/// # Errors
/// As [`read`]; and if the scale or the axes are not usable.
pub fn read_described(path: &Path, description: &Description, choice: &Choice) -> Result<Decoded, ReadError> {
    place(path, description)?.read(choice.nan)
}

/// What is described, and where its values are.
///
/// # Errors
/// [`ReadError`] if the spacing is no length.
pub(super) fn place(path: &Path, description: &Description) -> Result<Placed, ReadError> {
    let shape = &description.shape;
    check_spacing(shape.spacing).map_err(|error| ReadError::new(path, error))?;
    Ok(Placed {
        name: path.display().to_string(),
        format: NAME,
        place: Place::File(path.to_owned(), 0),
        layout: Layout {
            dims: shape.dims,
            components: 1,
            value_type: shape.value_type,
            endian: shape.endian,
            encoding: Encoding::Raw,
            line_skip: 0,
            byte_skip: ByteSkip::Bytes(shape.skip),
            tail: Tail::Refused,
        },
        spacing: shape.spacing,
        directions: description.directions.map(Directions::Patient),
        rescale: Some([description.scale, description.offset]),
        modality: description.modality,
        stated_window: None,
        packed_len: None,
        notes: Vec::new(),
    })
}

/// What the sidecar beside a raw file tells, else its name, and where its values are; `None` if neither tells a shape.
///
/// # Errors
/// As [`read_described`]; a sidecar that cannot be read is the file at fault.
pub(super) fn place_by_sidecar(path: &Path) -> Option<Result<Placed, ReadError>> {
    let sidecar = describe::sidecar_path(path);
    if sidecar.exists() {
        return Some(sidecar_text(&sidecar).and_then(|text| {
            let description = describe::from_toml(&text).map_err(|problem| ReadError::new(&sidecar, problem))?;
            place(path, &description)
        }));
    }
    let description = describe::from_name(path)?;
    let note = "shape and type come from the file's name; little endian and spacing 1 are assumed";
    Some(place(path, &description).map(|mut placed| {
        placed.notes.push(note.into());
        placed
    }))
}

/// A sidecar's text.
fn sidecar_text(path: &Path) -> Result<String, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let (_, len) = open_regular(path)?;
    if len > SIDECAR_MAX {
        let limit = SIDECAR_MAX;
        return Err(fail(Problem::HeaderTooLong { limit }));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(Problem::io("open the file")).map_err(fail)?;
    let read = file.take(SIDECAR_MAX).read_to_end(&mut bytes);
    read.map_err(Problem::io("read the file")).map_err(fail)?;
    String::from_utf8(bytes).map_err(|_| fail(Problem::format(NAME, "sidecar is not UTF-8 text")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Values;

    const SHAPE: RawShape = RawShape {
        dims: [2, 1, 1],
        spacing: [1.0, 2.0, 3.0],
        value_type: ValueType::I16,
        endian: Endian::Big,
        skip: 1,
    };

    fn read_these(bytes: &[u8], shape: &RawShape) -> Result<Decoded, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("v.raw");
        std::fs::write(&path, bytes).unwrap();
        read(&path, shape)
    }

    #[test]
    fn the_stated_shape_is_read() {
        let volume = read_these(&[9, 0x01, 0x02, 0xff, 0xfe], &SHAPE).unwrap();
        assert_eq!(volume.values(), &Values::I16(vec![0x0102, -2]));
        assert_eq!((volume.dims(), volume.spacing()), ([2, 1, 1], [1.0, 2.0, 3.0]));
        let little = RawShape {
            endian: Endian::Little,
            ..SHAPE
        };
        let volume = read_these(&[9, 0x01, 0x02, 0xff, 0xfe], &little).unwrap();
        assert_eq!(volume.values(), &Values::I16(vec![0x0201, -257]));
    }

    #[test]
    fn other_lengths_are_refused_before_memory_is_taken() {
        for len in [1, 4, 6, 100] {
            let error = read_these(&vec![0; len], &SHAPE).unwrap_err();
            assert!(
                matches!(error.problem, Problem::Length { expected: 4, .. }),
                "{len}: {error}"
            );
        }
        let huge = RawShape {
            dims: [8192, 8192, 32],
            value_type: ValueType::F64,
            ..SHAPE
        };
        let error = read_these(&[0; 5], &huge).unwrap_err().to_string();
        assert!(
            error
                .ends_with("has 4 bytes of data after the 1 skipped, expected 17179869184 for 8192 x 8192 x 32 double"),
            "{error}"
        );
        let far = RawShape {
            skip: u64::MAX,
            ..SHAPE
        };
        assert!(matches!(
            read_these(&[0; 5], &far).unwrap_err().problem,
            Problem::Length { found: 0, .. }
        ));
    }

    #[test]
    fn impossible_shapes_and_values_are_refused() {
        let flat = RawShape {
            dims: [2, 0, 1],
            ..SHAPE
        };
        assert!(matches!(
            read_these(&[0; 5], &flat).unwrap_err().problem,
            Problem::Shape(_)
        ));
        let spacing = RawShape {
            spacing: [1.0, f64::NAN, 1.0],
            ..SHAPE
        };
        assert!(matches!(
            read_these(&[0; 5], &spacing).unwrap_err().problem,
            Problem::Shape(_)
        ));
        let float = RawShape {
            dims: [1, 1, 1],
            value_type: ValueType::F32,
            ..SHAPE
        };
        let mut bytes = vec![0];
        bytes.extend(f32::NAN.to_be_bytes());
        assert!(matches!(
            read_these(&bytes, &float).unwrap_err().problem,
            Problem::Shape(_)
        ));
    }

    #[test]
    fn folders_and_missing_and_empty_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = read(folder.path(), &SHAPE).unwrap_err();
        assert!(matches!(error.problem, Problem::NotAFile { found: "a folder" }));
        let error = read(&folder.path().join("none"), &SHAPE).unwrap_err();
        assert!(matches!(error.problem, Problem::Io { .. }));
        assert!(matches!(read_these(&[], &SHAPE).unwrap_err().problem, Problem::Empty));
    }
}
