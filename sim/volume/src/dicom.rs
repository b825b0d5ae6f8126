//! DICOM series: a folder of files, one of them, or a medium with a DICOMDIR, put in order by position.
//!
//! Source: DICOM PS3.3 (image plane, pixel, rescale, functional groups), PS3.5 (encoding, transfer syntaxes), PS3.10
//! (files). The parser is this program's own: the dicom-object crate allocates what a file's length fields claim, which a
//! hostile file abuses. Read: files with a preamble; explicit and implicit little endian, explicit big endian, deflated,
//! RLE, JPEG, JPEG-LS, JPEG 2000; monochrome, 8, 16 or 32 bits, signed or not, rescaled; one slice per file, or several
//! frames that say where they lie. Other files of a folder are passed over with a note.

#[cfg(feature = "jpeg")]
mod codec;
#[cfg(not(feature = "jpeg"))]
#[path = "dicom/codec_absent.rs"]
mod codec;
mod element;
mod fields;
mod file;
mod folder;
mod frames;
mod names;
mod phases;
mod pixels;
mod series;
mod slice;
mod stack;

use std::path::{Path, PathBuf};

pub use self::file::MAX_FILE_LEN;
use self::folder::Gathered;
pub use self::folder::{read_folder, read_tree};
use self::series::Wanted;
use self::slice::{Object, Slice};
use super::choice::Choice;
use super::decoded::Decoded;
use super::error::{Problem, ReadError};

/// The format's name in messages.
const NAME: &str = "DICOM";

/// Reads the series that a file belongs to, from the folder in which it lies. A DICOMDIR stands for the files below its
/// folder.
///
/// # Errors
/// As [`read_folder`]; other files of the folder count only if they belong to the same series.
pub fn read_with_file(path: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let bytes = folder::load(path)?.ok_or_else(|| fail(Problem::format(NAME, "has no `DICM` after its preamble")))?;
    let (folder, own) = in_folder(path);
    match Object::parse(&bytes).map_err(|refusal| fail(refusal.problem))? {
        Object::Directory => read_tree(&folder, choice).map_err(|error| match error.problem {
            Problem::NoImages => fail(Problem::NoImages),
            _ => error,
        }),
        Object::NoImage => Err(fail(Problem::format(NAME, "is no image, expected a slice of a series"))),
        Object::Slices(_) => {
            let mut gathered = Gathered::of_folder(&folder)?;
            // A hidden file is looked at if it is asked for.
            if !gathered.slices.iter().any(|found| found.path == own) {
                gathered.add(own.clone(), Some(&bytes));
            }
            gathered.assemble(path, &Wanted::With(&own), choice)
        }
    }
}

/// Reads a series from files in memory, as (name, bytes).
///
/// # Errors
/// As [`read_folder`].
pub fn read_bytes(files: &[(String, Vec<u8>)], name: &str, choice: &Choice) -> Result<Decoded, ReadError> {
    let mut gathered = Gathered::default();
    for (file, bytes) in files {
        gathered.add(PathBuf::from(file), Some(bytes));
    }
    let bytes_of = |path: &Path| {
        let found = files.iter().find(|(file, _)| Path::new(file) == path);
        Ok(found.map(|(_, bytes)| bytes.clone()).unwrap_or_default())
    };
    gathered.decode(Path::new(name), &Wanted::of(choice), choice, bytes_of)
}

/// The folder of a file, and the file as a listing of that folder names it.
fn in_folder(path: &Path) -> (PathBuf, PathBuf) {
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    (folder.to_path_buf(), folder.join(path.file_name().unwrap_or_default()))
}

/// Whether a file that begins so is a DICOM file.
pub(super) fn recognise(start: &[u8]) -> bool {
    start.get(128..132) == Some(b"DICM")
}

/// A slice, and the file that holds it.
#[derive(Debug)]
struct Found {
    path: PathBuf,
    slice: Slice,
}

#[cfg(test)]
mod tests;
