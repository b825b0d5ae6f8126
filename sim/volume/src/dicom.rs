//! DICOM series: a folder of slices, or one of its files, put in order by position.
//!
//! Source: DICOM PS3.3 (image plane, pixel, rescale), PS3.5 (encoding, transfer syntaxes), PS3.10 (files). The parser is
//! this program's own: the dicom-object crate allocates what a file's length fields claim, which a hostile file abuses.
//! Read: files with a preamble; explicit and implicit little endian, explicit big endian, deflated, RLE; monochrome, 8,
//! 16 or 32 bits, signed or not, rescaled. Refused by name: JPEG and its kin, colour, multi-frame files.

mod element;
mod file;
mod pixels;
mod series;

use std::fs;
use std::path::{Path, PathBuf};

pub use self::file::MAX_FILE_LEN;
use self::file::Slice;
use self::series::Stack;
use super::error::{Problem, ReadError};
use super::open::open_regular;
use super::values::Decoded;

/// The format's name in messages.
const NAME: &str = "DICOM";

/// Files of a folder that are looked at.
const MAX_FILES: usize = 65536;

/// Which of several series is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// The one with the most slices.
    #[default]
    Largest,
    /// The one whose number or UID this is.
    Named(String),
}

/// Reads a series from a folder.
///
/// # Errors
/// [`ReadError`] names the folder or file, what was wrong and what was expected: no DICOM file, no such series, slices
/// missing or unevenly spaced, a tilted gantry, slices that disagree.
pub fn read_folder(folder: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(folder, problem);
    let entries = fs::read_dir(folder)
        .map_err(Problem::io("read the folder"))
        .map_err(fail)?;
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.map_err(Problem::io("read the folder")).map_err(fail)?.path();
        if paths.len() == MAX_FILES {
            let fault = format!("the folder has more than {MAX_FILES} files, expected a series");
            return Err(fail(Problem::format(NAME, fault)));
        }
        if path.is_file() {
            paths.push(path);
        }
    }
    // The system's order is no order; names decide nothing but which error comes first.
    paths.sort();
    let (mut slices, mut others) = (Vec::new(), 0);
    for path in paths {
        match load(&path)? {
            Some(bytes) => match Slice::parse(&bytes) {
                Ok(Some(slice)) => slices.push(Found { path, slice }),
                Ok(None) => others += 1,
                Err(problem) => return Err(ReadError::new(&path, problem)),
            },
            None => others += 1,
        }
    }
    let mut notes = Vec::new();
    if others > 0 && !slices.is_empty() {
        notes.push(format!("{others} files of the folder are no DICOM images"));
    }
    assemble(folder, slices, choice, notes)
}

/// Reads the series that a file belongs to, from the folder in which it lies.
///
/// # Errors
/// As [`read_folder`]; other files of the folder count only if they belong to the same series.
pub fn read_with_file(path: &Path) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let bytes = load(path)?.ok_or_else(|| fail(Problem::format(NAME, "has no `DICM` after its preamble")))?;
    let no_image = || fail(Problem::format(NAME, "is no image, expected a slice of a series"));
    let own = Slice::parse(&bytes).map_err(fail)?.ok_or_else(no_image)?;
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let mut slices = Vec::new();
    let entries = fs::read_dir(folder)
        .map_err(Problem::io("read the folder"))
        .map_err(fail)?;
    let mut paths: Vec<PathBuf> = entries.flatten().take(MAX_FILES).map(|entry| entry.path()).collect();
    paths.sort();
    for other in paths.into_iter().filter(|other| other.is_file()) {
        // Files beside it that cannot be read are no part of what was asked for.
        if let Ok(Some(bytes)) = load(&other)
            && let Ok(Some(slice)) = Slice::parse(&bytes)
            && slice.series_key() == own.series_key()
        {
            slices.push(Found { path: other, slice });
        }
    }
    let notes = vec![format!(
        "{} files of the folder belong to the file's series",
        slices.len()
    )];
    assemble(path, slices, &Choice::Largest, notes)
}

/// Reads a series from files in memory, as (name, bytes).
///
/// # Errors
/// As [`read_folder`].
pub fn read_bytes(files: &[(String, Vec<u8>)], name: &str, choice: &Choice) -> Result<Decoded, ReadError> {
    let mut slices = Vec::new();
    for (file, bytes) in files {
        let path = PathBuf::from(file);
        if let Some(slice) = Slice::parse(bytes).map_err(|problem| ReadError::new(&path, problem))? {
            slices.push(Found { path, slice });
        }
    }
    let bytes_of = |path: &Path| {
        let found = files.iter().find(|(file, _)| Path::new(file) == path);
        Ok(found.map(|(_, bytes)| bytes.clone()).unwrap_or_default())
    };
    let at = Path::new(name);
    let stack = Stack::choose(slices, choice).map_err(|problem| ReadError::new(at, problem))?;
    stack.decode(at, Vec::new(), bytes_of)
}

/// Whether a file that begins so is a DICOM file.
pub(super) fn recognise(start: &[u8]) -> bool {
    start.get(128..132) == Some(b"DICM")
}

/// One file of a folder.
struct Found {
    path: PathBuf,
    slice: Slice,
}

/// Orders the slices and reads their pixels, file by file.
fn assemble(name: &Path, slices: Vec<Found>, choice: &Choice, notes: Vec<String>) -> Result<Decoded, ReadError> {
    let stack = Stack::choose(slices, choice).map_err(|problem| ReadError::new(name, problem))?;
    stack.decode(name, notes, |path| {
        let gone = || ReadError::new(path, Problem::format(NAME, "is no DICOM file any more"));
        load(path)?.ok_or_else(gone)
    })
}

/// A file's bytes; `None` if it is no DICOM file (empty files included).
fn load(path: &Path) -> Result<Option<Vec<u8>>, ReadError> {
    use std::io::{BufRead, Read};
    let (mut source, len) = match open_regular(path) {
        Ok(opened) => opened,
        Err(ReadError {
            problem: Problem::Empty,
            ..
        }) => return Ok(None),
        Err(error) => return Err(error),
    };
    let fail = |problem| ReadError::new(path, problem);
    let start = source.fill_buf().map_err(Problem::io("read the file")).map_err(fail)?;
    if !recognise(start) {
        return Ok(None);
    }
    if len > MAX_FILE_LEN {
        return Err(fail(Problem::TooLarge {
            bytes: len,
            what: "one file",
            limit: MAX_FILE_LEN,
        }));
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(len as usize)
        .map_err(|_| fail(Problem::Memory { bytes: len }))?;
    let read = source.take(len).read_to_end(&mut bytes);
    read.map_err(Problem::io("read the file")).map_err(fail)?;
    Ok(Some(bytes))
}

#[cfg(test)]
mod tests;
