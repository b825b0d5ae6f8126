//! TIFF stacks: the pages of one file, or a folder of files in the order of the numbers in their names.
//!
//! Read by the `tiff` crate under limits: grey pages of one size and type (8 to 32 bits, signed or not, single or double
//! precision), and, for who asks for colours, RGB and RGBA of 8 or 16 bits; plain, LZW, deflate or packbits. What pages are, TIFF itself does not say: ImageJ's description and OME-XML
//! tell channels, slices and time points, of which one channel and one time point become the volume (`planes`), and the
//! distance between slices (`description`). Without them every page is a slice.

mod damage;
mod description;
mod ome;
mod patched;
mod pixels;
mod planes;
mod stack;
mod told;

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use self::patched::Source;
use self::pixels::{Wanted, is_coloured};
use self::stack::Stack;
use super::choice::Choice;
use super::colours::Colours;
use super::decoded::Decoded;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::limits::MAX_AXIS;

/// The format's name in messages.
const NAME: &str = "TIFF";

/// Reads the pages of a TIFF file as slices.
///
/// # Errors
/// [`ReadError`] names the file, what was wrong and what was expected; see [`Problem`].
pub fn read(path: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let (mut source, len) = open_regular(path)?;
    read_source(&mut source, len, path.display().to_string(), choice).map_err(fail)
}

/// Reads a TIFF file that is already in memory; `name` stands for its path in messages.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, choice: &Choice) -> Result<Decoded, ReadError> {
    let read = read_source(&mut Cursor::new(bytes), bytes.len() as u64, name.to_owned(), choice);
    read.map_err(|problem| ReadError::new(Path::new(name), problem))
}

/// Reads a folder of TIFF files, each one slice or more. Names that begin with a dot are passed over: `._` files are
/// what other systems keep beside the files of a Macintosh.
///
/// # Errors
/// As [`read`]; [`Problem::Format`] if there is no TIFF file in it.
pub fn read_folder(folder: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    let stack = stack_of(folder, choice, Wanted::Grey)?;
    let decoded = stack.finish(folder.display().to_string());
    decoded.map_err(|problem| ReadError::new(folder, problem))
}

/// Reads a file or folder of colours; `None` if the first page has none.
///
/// # Errors
/// As [`read`] and [`read_folder`].
pub fn read_colours(path: &Path, choice: &Choice) -> Result<Option<Colours>, ReadError> {
    let stack = if path.is_dir() {
        let (_, paths) = files_of(path)?;
        match paths.first() {
            Some(first) if is_coloured(&mut open_regular(first)?.0) => stack_of(path, choice, Wanted::Colours)?,
            _ => return Ok(None),
        }
    } else {
        if !is_coloured(&mut open_regular(path)?.0) {
            return Ok(None);
        }
        let (mut source, len) = open_regular(path)?;
        let mut stack = Stack::new(choice.clone(), Wanted::Colours);
        stack
            .add_file(&mut source, len)
            .map_err(|problem| ReadError::new(path, problem))?;
        stack
    };
    let colours = stack.finish_colours(path.display().to_string());
    colours.map(Some).map_err(|problem| ReadError::new(path, problem))
}

/// The TIFF files of a folder: those whose names begin with a dot, and the others in their order.
fn files_of(folder: &Path) -> Result<(Vec<PathBuf>, Vec<PathBuf>), ReadError> {
    let fail = |problem| ReadError::new(folder, problem);
    let entries = fs::read_dir(folder)
        .map_err(Problem::io("read the folder"))
        .map_err(fail)?;
    let paths = entries.flatten().take(2 * MAX_AXIS).map(|entry| entry.path());
    let (hidden, mut paths): (Vec<PathBuf>, Vec<PathBuf>) = paths
        .filter(|path| path.is_file() && has_name(path))
        .partition(|path| is_hidden(path));
    paths.sort_by_cached_key(|path| natural_key(path));
    Ok((hidden, paths))
}

/// The slices of a folder's files.
fn stack_of(folder: &Path, choice: &Choice, wanted: Wanted) -> Result<Stack, ReadError> {
    let (hidden, paths) = files_of(folder)?;
    let mut stack = Stack::new(choice.clone(), wanted);
    for path in &paths {
        let (mut source, len) = open_regular(path)?;
        stack
            .add_file(&mut source, len)
            .map_err(|problem| ReadError::new(path, problem))?;
    }
    if !hidden.is_empty() {
        let count = hidden.len();
        stack.note(format!("{count} files whose names begin with a dot are passed over"));
    }
    stack.note(format!(
        "{} files in the order of the numbers in their names: a TIFF states no position",
        paths.len()
    ));
    Ok(stack)
}

/// Whether a file that begins so is a TIFF.
pub(super) fn recognise(start: &[u8]) -> bool {
    [&b"II*\0"[..], b"MM\0*", b"II+\0", b"MM\0+"]
        .iter()
        .any(|magic| start.starts_with(magic))
}

/// Whether a file is called a TIFF.
pub(super) fn has_name(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "tif" || extension == "tiff"
}

/// Whether a file's name begins with a dot.
fn is_hidden(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default();
    name.as_encoded_bytes().starts_with(b".")
}

/// A name with its numbers as numbers, so that `s10` follows `s9`.
fn natural_key(path: &Path) -> Vec<(u8, u128, String)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut parts: Vec<(u8, u128, String)> = Vec::new();
    for c in name.chars() {
        match (c.to_digit(10), parts.last_mut()) {
            (Some(digit), Some((0, number, _))) => *number = number.saturating_mul(10).saturating_add(digit.into()),
            (Some(digit), _) => parts.push((0, digit.into(), String::new())),
            (None, Some((1, _, text))) => text.push(c),
            (None, _) => parts.push((1, 0, c.to_string())),
        }
    }
    parts
}

fn read_source(source: &mut dyn Source, len: u64, name: String, choice: &Choice) -> Result<Decoded, Problem> {
    let mut stack = Stack::new(choice.clone(), Wanted::Grey);
    stack.add_file(source, len)?;
    stack.finish(name)
}

#[cfg(test)]
mod field_tests;
#[cfg(test)]
mod tests;
