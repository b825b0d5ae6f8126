//! Files that are to be read.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use super::error::{Problem, ReadError};

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
