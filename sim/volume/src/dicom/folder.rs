//! The files of a folder, or of all folders below it: slices, and what is passed over.

use std::fs;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use super::file::MAX_FILE_LEN;
use super::names::{file_name, list};
use super::series::{self, Wanted};
use super::slice::{Object, Refusal};
use super::stack::Stack;
use super::{Found, NAME, recognise};
use crate::choice::Choice;
use crate::decoded::Decoded;
use crate::error::{Problem, ReadError};
use crate::file::open_regular;

/// Files and folders that are looked at.
const MAX_FILES: usize = 65536;

/// How deep folders are walked down; media nest patient, study and series.
const MAX_DEPTH: usize = 8;

/// Reads a series from a folder. If its DICOM files hold no slice (a DICOMDIR, reports), those in the folders below are
/// looked at.
///
/// # Errors
/// [`ReadError`] names the folder or file, what was wrong and what was expected: no DICOM file, no such series, slices
/// missing or unevenly spaced, several phases, a tilted gantry, slices that disagree.
pub fn read_folder(folder: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    let gathered = Gathered::of_folder(folder)?;
    if gathered.slices.is_empty() && gathered.has_dicom {
        return read_tree(folder, choice);
    }
    gathered.assemble(folder, &Wanted::of(choice), choice)
}

/// Reads a series from a folder and all folders below it, to a stated depth and number of files.
///
/// # Errors
/// As [`read_folder`].
pub fn read_tree(folder: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    let mut gathered = Gathered::default();
    gathered.walk(folder, MAX_DEPTH)?;
    gathered.assemble(folder, &Wanted::of(choice), choice)
}

/// What the files of a folder are.
#[derive(Default)]
pub(super) struct Gathered {
    pub slices: Vec<Found>,
    /// Whether any file is a DICOM file.
    has_dicom: bool,
    refused: Vec<(PathBuf, Refusal)>,
    others: Vec<PathBuf>,
    looked_at: usize,
}

impl Gathered {
    /// Looks at the files of one folder.
    pub fn of_folder(folder: &Path) -> Result<Self, ReadError> {
        let mut gathered = Self::default();
        gathered.walk(folder, 0)?;
        Ok(gathered)
    }

    /// Looks at the files of a folder and of those `depth` levels below it.
    fn walk(&mut self, folder: &Path, depth: usize) -> Result<(), ReadError> {
        let fail = |problem| ReadError::new(folder, problem);
        let entries = fs::read_dir(folder)
            .map_err(Problem::io("read the folder"))
            .map_err(fail)?;
        let (mut files, mut folders) = (Vec::new(), Vec::new());
        for entry in entries {
            let entry = entry.map_err(Problem::io("read the folder")).map_err(fail)?;
            self.looked_at += 1;
            if self.looked_at > MAX_FILES {
                let fault = format!("the folder has more than {MAX_FILES} files, expected a series");
                return Err(fail(Problem::format(NAME, fault)));
            }
            // What systems leave beside files: `._name`, `.DS_Store`.
            if entry.file_name().as_encoded_bytes().starts_with(b".") {
                continue;
            }
            let path = entry.path();
            // Links to folders may lead round in a circle.
            if path.is_file() {
                files.push(path);
            } else if depth > 0 && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.push(path);
            }
        }
        // The system's order is no order; names decide nothing but which of several equals comes first.
        files.sort();
        folders.sort();
        for path in files {
            match load(&path) {
                Ok(bytes) => self.add(path, bytes.as_deref()),
                Err(error) => self.refused.push((path, Refusal::unread(error.problem))),
            }
        }
        for path in folders {
            // A folder that may not be read is none of a series.
            match self.walk(&path, depth - 1) {
                Err(ReadError {
                    problem: Problem::Io { .. },
                    ..
                }) => {}
                walked => walked?,
            }
        }
        Ok(())
    }

    /// Looks at one file; without bytes, it is no DICOM file.
    pub fn add(&mut self, path: PathBuf, bytes: Option<&[u8]>) {
        self.has_dicom |= bytes.is_some();
        match bytes.map(Object::parse) {
            Some(Ok(Object::Slices(slices))) => {
                let found = |slice| Found {
                    path: path.clone(),
                    slice,
                };
                self.slices.extend(slices.into_iter().map(found));
            }
            Some(Err(refusal)) => self.refused.push((path, refusal)),
            Some(Ok(Object::Directory)) => {}
            Some(Ok(Object::NoImage)) | None => self.others.push(path),
        }
    }

    /// Orders the slices of the wanted series and reads their pixels, file by file.
    pub fn assemble(self, name: &Path, wanted: &Wanted<'_>, choice: &Choice) -> Result<Decoded, ReadError> {
        self.decode(name, wanted, choice, |path| {
            let gone = || ReadError::new(path, Problem::format(NAME, "is no DICOM file any more"));
            load(path)?.ok_or_else(gone)
        })
    }

    /// As [`Gathered::assemble`]; `bytes_of` yields a file's bytes.
    pub fn decode(
        mut self,
        name: &Path,
        wanted: &Wanted<'_>,
        choice: &Choice,
        bytes_of: impl Fn(&Path) -> Result<Vec<u8>, ReadError>,
    ) -> Result<Decoded, ReadError> {
        let fail = |problem| ReadError::new(name, problem);
        if self.slices.is_empty() && !self.refused.is_empty() {
            let (path, refusal) = self.refused.swap_remove(0);
            return Err(ReadError::new(&path, refusal.problem));
        }
        let (slices, mut notes) = series::choose(self.slices, wanted, choice).map_err(fail)?;
        let uid = slices.first().map_or("", |found| found.slice.series_uid.as_str());
        // A slice of the series that cannot be read would leave a hole, or a shorter stack.
        let is_missed = |refusal: &Refusal| refusal.may_be_slice && refusal.series_uid == uid && !uid.is_empty();
        if let Some(at) = self.refused.iter().position(|(_, refusal)| is_missed(refusal)) {
            let (path, refusal) = self.refused.swap_remove(at);
            return Err(ReadError::new(&path, refusal.problem));
        }
        if let Some(folder) = slices.first().and_then(|found| found.path.parent())
            && let Ok(below) = folder.strip_prefix(name)
            && below != Path::new("")
        {
            notes.push(format!("the slices lie in {}", below.display()));
        }
        if !self.refused.is_empty() {
            let refused = self.refused.iter();
            let reasons = refused.map(|(path, refusal)| format!("{} ({})", file_name(path), refusal.problem));
            notes.push(format!("passed over: {}", list(reasons)));
        }
        if !self.others.is_empty() {
            let names = list(self.others.iter().map(|path| file_name(path)));
            notes.push(match self.others.len() {
                1 => format!("1 file is no DICOM image: {names}"),
                count => format!("{count} files are no DICOM images: {names}"),
            });
        }
        let stack = Stack::order(slices, notes).map_err(fail)?;
        stack.decode(name, bytes_of)
    }
}

impl Refusal {
    /// A file that the system does not let be read.
    fn unread(problem: Problem) -> Self {
        Self {
            problem,
            series_uid: String::new(),
            may_be_slice: true,
        }
    }
}

/// A file's bytes; `None` if it is no DICOM file (empty files included).
pub(super) fn load(path: &Path) -> Result<Option<Vec<u8>>, ReadError> {
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
