//! Which reader a file is for: by its first bytes, then by its name.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::error::{Problem, ReadError};
use super::mapping::{MappingError, MappingReport, Window, map};
use super::values::Decoded;
use super::{Volume, nrrd};

/// The CT head that comes with the program, 64 x 64 x 93 voxels (see `sim/data/LICENSE-headsq.txt`).
const BUILT_IN: &[u8] = include_bytes!("../../data/headsq-quarter.nrrd");

/// What [`load`] and [`prepare`] can fail with.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Its values cannot be mapped to 12 bits as asked.
    #[error("{name}: {error}")]
    Mapping {
        /// Where the volume came from.
        name: String,
        /// What is wrong.
        error: MappingError,
    },
}

/// Reads a volume file of any format that states its own shape (raw files do not; see [`super::raw`]).
///
/// # Errors
/// [`ReadError`] if the file is no regular file, is of no known format, or its reader refuses it.
pub fn read(path: &Path) -> Result<Decoded, ReadError> {
    let (mut source, _) = open_regular(path)?;
    let fail = |problem| ReadError::new(path, problem);
    let start = source.fill_buf().map_err(Problem::io("read the file")).map_err(fail)?;
    let named = |name: &str| {
        path.extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case(name))
    };
    if start.starts_with(b"NRRD") || named("nrrd") || named("nhdr") {
        return nrrd::read(path);
    }
    let first_bytes = start.iter().take(8).copied().collect::<Vec<u8>>();
    Err(fail(Problem::UnknownFormat {
        first_bytes: format!("\"{}\"", first_bytes.escape_ascii()),
    }))
}

/// Reads the built-in CT head: stored values 0 to 3926, in Hounsfield units after its offset of -1024.
///
/// # Errors
/// None in a sound build; a test reads it.
pub fn read_built_in() -> Result<Decoded, ReadError> {
    nrrd::read_bytes(BUILT_IN, "built-in CT head")
}

/// A volume ready for the pipeline, and what the user should know about it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The volume in 12-bit codes.
    pub volume: Volume,
    /// What the mapping to codes did to the values.
    pub report: MappingReport,
    /// What was assumed or left aside in reading the file, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a volume file, or the built-in CT head if there is no path, and maps it to 12 bits.
///
/// # Errors
/// [`LoadError`] if the file cannot be read or its values cannot be mapped as asked.
pub fn load(path: Option<&Path>, window: Window) -> Result<Loaded, LoadError> {
    let decoded = match path {
        Some(path) => read(path)?,
        None => read_built_in()?,
    };
    prepare(&decoded, window)
}

/// Maps a volume that has been read (as raw files have to be, by [`super::raw::read`]) to 12 bits.
///
/// # Errors
/// [`LoadError::Mapping`] if its values cannot be mapped as asked.
pub fn prepare(decoded: &Decoded, window: Window) -> Result<Loaded, LoadError> {
    match map(decoded, window) {
        Ok((volume, report)) => Ok(Loaded {
            volume,
            report,
            notes: decoded.notes().to_vec(),
        }),
        Err(error) => Err(LoadError::Mapping {
            name: decoded.name().to_owned(),
            error,
        }),
    }
}

/// Opens a file that is not empty and neither a folder nor a device; its length in bytes comes with it.
///
/// The kind is looked at before opening, since opening a pipe would wait for its writer.
pub(super) fn open_regular(path: &Path) -> Result<(BufReader<File>, u64), ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let kind = fs::metadata(path).map_err(Problem::io("find the file")).map_err(fail)?;
    if kind.is_dir() {
        return Err(fail(Problem::NotAFile { found: "a folder" }));
    }
    if !kind.is_file() {
        return Err(fail(Problem::NotAFile {
            found: "a device, pipe or socket",
        }));
    }
    let file = File::open(path).map_err(Problem::io("open the file")).map_err(fail)?;
    let len = file
        .metadata()
        .map_err(Problem::io("measure the file"))
        .map_err(fail)?
        .len();
    if len == 0 {
        return Err(fail(Problem::Empty));
    }
    Ok((BufReader::with_capacity(1 << 16, file), len))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_volume_is_the_documented_one() {
        let Loaded { volume, report, notes } = load(None, Window::Auto).unwrap();
        assert!(notes.is_empty());
        assert_eq!(volume.dims, [64, 64, 93]);
        assert_eq!(volume.spacing, [3.2, 3.2, 1.5]);
        assert_eq!(volume.voxels.iter().max(), Some(&3926));
        assert_eq!(volume.voxels.iter().min(), Some(&0));
        assert_eq!((volume.mapping.scale, volume.mapping.offset), (1.0, -1024.0));
        assert!(report.lossless);
    }

    #[test]
    fn content_decides_before_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("head.raw");
        fs::write(&path, BUILT_IN).unwrap();
        assert_eq!(read(&path).unwrap().dims(), [64, 64, 93]);
        let path = folder.path().join("head.NRRD");
        fs::write(&path, b"P5 1 1 255\n").unwrap();
        assert!(matches!(read(&path).unwrap_err().problem, Problem::Magic { .. }));
        let path = folder.path().join("head.xyz");
        fs::write(&path, b"\x1f\x8b\x08\0abcdefgh").unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(
            message.contains("begins with \"\\x1f\\x8b\\x08\\x00abcd\", expected NRRD"),
            "{message}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused() {
        let error = read(Path::new("/dev/zero")).unwrap_err().to_string();
        assert_eq!(error, "/dev/zero: is a device, pipe or socket, expected a regular file");
    }
}
