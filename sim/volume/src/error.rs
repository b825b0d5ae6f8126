//! What can be wrong with a volume file.

mod axes;

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use self::axes::AxesError;
use super::limits::MAX_AXIS;
use super::limits::MAX_SPACING;
use super::limits::MAX_VOXELS;
use super::limits::MIN_SPACING;
use super::text::number;

/// A volume that could not be read: which file, and why.
#[derive(Debug, Error)]
#[error("{}: {problem}", .path.display())]
pub struct ReadError {
    /// The file at fault: for a detached header this may be the data file.
    pub path: PathBuf,
    /// What is wrong with it, and what was expected.
    pub problem: Problem,
}

impl ReadError {
    /// Names the file that has the problem.
    pub fn new(path: &Path, problem: impl Into<Problem>) -> Self {
        Self {
            path: path.to_path_buf(),
            problem: problem.into(),
        }
    }
}

/// What is wrong with a volume file.
#[derive(Debug, Error)]
pub enum Problem {
    /// Shares of materials are asked for, and the file is none that has them.
    #[error("has no shares of materials, expected an NRRD file with 1 to 8 values a voxel")]
    NoShares,
    /// The operating system refused.
    #[error("cannot {action}: {source}")]
    Io {
        /// What was tried.
        action: &'static str,
        /// The system's answer.
        source: io::Error,
    },
    /// A folder, a device, a pipe.
    #[error("is {found}, expected a regular file")]
    NotAFile {
        /// What it is.
        found: &'static str,
    },
    /// Zero bytes.
    #[error("is empty, expected a volume")]
    Empty,
    /// Neither the first bytes nor the name tell a format.
    #[error(
        "is of no known format: it begins with {first_bytes}, expected NRRD, NIfTI, MetaImage, DICOM, TIFF or a Zarr \
         folder; raw data need their shape stated"
    )]
    UnknownFormat {
        /// The first bytes, escaped.
        first_bytes: String,
    },
    /// The first line of an NRRD file.
    #[error("begins with `{found}`, expected `NRRD0001` to `NRRD0005`")]
    Magic {
        /// The first line.
        found: String,
    },
    /// The header does not end.
    #[error("header has no end within {limit} bytes, expected an empty line before the data")]
    HeaderTooLong {
        /// Bytes that a header may have.
        limit: u64,
    },
    /// A header line of no known form.
    #[error("header line {line} is `{text}`, expected `# comment`, `field: value` or `key:=value`")]
    HeaderLine {
        /// Line, from 1.
        line: usize,
        /// Its text, shortened.
        text: String,
    },
    /// A field that the format does not define, or one given twice.
    #[error("header line {line}: field `{field}` is {fault}")]
    HeaderField {
        /// Line, from 1.
        line: usize,
        /// The field's name, shortened.
        field: String,
        /// What is wrong with its being there.
        fault: &'static str,
    },
    /// A field that has to be there.
    #[error("header has no field `{field}`, expected {expected}")]
    MissingField {
        /// The field's name.
        field: &'static str,
        /// What it should say.
        expected: &'static str,
    },
    /// A field whose value is not usable.
    #[error("header field `{field}` is `{value}`, expected {expected}")]
    FieldValue {
        /// The field's name.
        field: &'static str,
        /// What the file says, shortened.
        value: String,
        /// What can be read.
        expected: &'static str,
    },
    /// Attached data are missing altogether.
    #[error("header ends without an empty line and names no `data file`, expected one of the two")]
    NoData,
    /// A file that its format does not allow; the fault names the place and the numbers.
    #[error("{format}: {fault}")]
    Format {
        /// The format as which it was read.
        format: &'static str,
        /// What was found and what was expected.
        fault: String,
    },
    /// A folder without slices.
    #[error("has no DICOM image, expected the slices of a series")]
    NoImages,
    /// A sound file of a kind that is not read.
    #[error("{format}: {found} is not read, expected {expected}")]
    Unsupported {
        /// The format as which it was read.
        format: &'static str,
        /// What the file has.
        found: String,
        /// What can be read.
        expected: &'static str,
    },
    /// More memory than this program asks for.
    #[error("would take {bytes} bytes of memory for {what}, expected at most {limit}")]
    TooLarge {
        /// Bytes that it would take.
        bytes: u64,
        /// For what.
        what: &'static str,
        /// Bytes allowed.
        limit: u64,
    },
    /// A companion file outside the folder.
    #[error("names the data file `{name}`, expected a file in its own folder or below it")]
    Outside {
        /// The name, shortened.
        name: String,
    },
    /// A channel, time point or the like that the file does not have.
    #[error("has {count} {what}{}, expected one of them: {what} {asked} was asked for", if *.count == 1 { "" } else { "s" })]
    Choice {
        /// What there are several of.
        what: &'static str,
        /// The one asked for, from 1.
        asked: usize,
        /// How many there are.
        count: usize,
    },
    /// Directions that are no axes.
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// A shape that is not usable.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Fewer or more data than the shape needs.
    #[error("has {found} bytes of data{place}, expected {expected} for {shape}")]
    Length {
        /// Bytes that the shape needs.
        expected: u64,
        /// Bytes that are there.
        found: u64,
        /// After what they are counted.
        place: String,
        /// The shape and type, in words.
        shape: String,
    },
    /// A compressed stream holds more than the shape needs.
    #[error("unpacks to more than the {expected} bytes expected for {shape}")]
    UnpacksTooLong {
        /// Bytes that the shape needs.
        expected: u64,
        /// The shape and type, in words.
        shape: String,
    },
    /// A compressed stream is damaged.
    #[error("{packing} data are damaged after {unpacked} unpacked bytes of {expected}: {message}")]
    Damaged {
        /// How the data are packed.
        packing: &'static str,
        /// Bytes unpacked before the damage.
        unpacked: u64,
        /// Bytes that the shape needs.
        expected: u64,
        /// The unpacker's message.
        message: String,
    },
    /// The data end before the skipped part does.
    #[error("ends inside the part to be skipped (`{field}`: {asked})")]
    Skip {
        /// Which skip.
        field: &'static str,
        /// How far to skip.
        asked: u64,
    },
    /// The machine has not enough memory.
    #[error("needs {bytes} bytes of memory, which the system does not give")]
    Memory {
        /// Bytes asked for.
        bytes: u64,
    },
}

impl Problem {
    /// A file that its format does not allow.
    pub(super) fn format(format: &'static str, fault: impl Into<String>) -> Self {
        Self::Format {
            format,
            fault: fault.into(),
        }
    }

    /// Wraps a system error with what was tried.
    pub(super) fn io(action: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { action, source }
    }
}

/// A shape, spacing or value that no volume can have.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// A side of no voxels, or of too many.
    #[error("has {len} voxels along {}, expected 1 to {MAX_AXIS}", axis_name(*.axis))]
    Axis {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Voxels along it.
        len: u64,
    },
    /// Too many voxels in all.
    #[error(
        "has {voxels} voxels, expected at most {MAX_VOXELS} in memory; `slicecast render --memory` reads more in parts"
    )]
    Voxels {
        /// Voxels in all.
        voxels: u64,
    },
    /// A spacing that is not a length.
    #[error(
        "has spacing {} along {}, expected a length from {MIN_SPACING:e} to {MAX_SPACING:e}",
        number(*.spacing), axis_name(*.axis)
    )]
    Spacing {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// The spacing as given.
        spacing: f64,
    },
    /// The number of values is not that of the voxels.
    #[error("has {found} values, expected {expected}")]
    Values {
        /// Voxels of the shape.
        expected: u64,
        /// Values given.
        found: u64,
    },
    /// NaN or infinity.
    #[error(
        "voxel ({}, {}, {}) is {value}, expected finite numbers only{}",
        .voxel[0], .voxel[1], .voxel[2],
        if value.is_nan() { "; `--nan background` takes NaN for background" } else { "" }
    )]
    NotFinite {
        /// x, y, z of the first such voxel.
        voxel: [usize; 3],
        /// Its value.
        value: f64,
    },
    /// NaN everywhere.
    #[error("has no voxel that is a number, expected some beside NaN")]
    AllNan,
}

/// The letter of an axis.
fn axis_name(axis: usize) -> &'static str {
    ["x", "y", "z"].get(axis).copied().unwrap_or("an axis")
}
