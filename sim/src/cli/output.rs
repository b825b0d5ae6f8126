//! Files that are written: whole or not at all, and never over somebody else's.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::Failure;

/// Writes a file: first beside it under a temporary name, then in its place. Its folder is made where it is missing.
///
/// An existing file is only replaced with `force`.
pub fn write_file(path: &Path, force: bool, contents: &[u8]) -> Result<(), Failure> {
    if !force && fs::symlink_metadata(path).is_ok() {
        return Err(Failure::input(format!(
            "{} exists; --force replaces it",
            path.display()
        )));
    }
    replace(path, contents).map_err(|error| Failure::machine(format!("{}: {error}", path.display())))
}

/// Refuses now what [`write_file`] would refuse later: a file that exists, a folder that can neither be written nor made.
pub fn check_free<'a>(paths: impl IntoIterator<Item = &'a PathBuf>, force: bool) -> Result<(), Failure> {
    for path in paths {
        let shown = path.display();
        if !force && fs::symlink_metadata(path).is_ok() {
            return Err(Failure::input(format!("{shown} exists; --force replaces it")));
        }
        if path.is_dir() {
            return Err(Failure::input(format!(
                "{shown}: is a folder, expected the name of a file"
            )));
        }
        let part = part(path).map_err(|error| Failure::machine(format!("{shown}: {error}")))?;
        // Folders are made with the file; now the first one that exists has to take one.
        let there = folder(&part)
            .ancestors()
            .find(|folder| folder.symlink_metadata().is_ok());
        let trial = there
            .unwrap_or(Path::new("."))
            .join(part.file_name().unwrap_or_default());
        let tried = fs::File::create_new(&trial).and_then(|_| fs::remove_file(&trial));
        tried.map_err(|error| Failure::machine(format!("{shown}: cannot be written: {error}")))?;
    }
    Ok(())
}

/// Where a command's figures go besides the terminal.
#[derive(clap::Args)]
pub struct JsonArgs {
    /// Write the figures as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
}

impl JsonArgs {
    /// [`check_free`].
    pub fn check_free(&self) -> Result<(), Failure> {
        check_free(&self.json, self.force)
    }

    /// Writes figures, if they are asked for.
    pub fn write(&self, figures: &impl Serialize) -> Result<(), Failure> {
        let Some(path) = &self.json else { return Ok(()) };
        let json = serde_json::to_vec_pretty(figures).map_err(Failure::machine)?;
        write_file(path, self.force, &json)
    }
}

/// Where a file is written before it takes its place.
fn part(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| io::Error::other("not a file name"))?;
    let mut part = std::ffi::OsString::from(".");
    part.push(name);
    part.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(part))
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

fn replace(path: &Path, contents: &[u8]) -> io::Result<()> {
    let temporary = part(path)?;
    fs::create_dir_all(folder(path))?;
    let written = fs::File::create_new(&temporary).and_then(|mut file| {
        file.write_all(contents)?;
        file.sync_all()
    });
    written.and_then(|()| fs::rename(&temporary, path)).inspect_err(|_| {
        // The part is of no use; that it cannot be removed either is no news.
        let _ = fs::remove_file(&temporary);
    })
}

/// A folder that remembers what was written into it, so that the same job can run again without `--force` and still
/// never replaces a file that it did not write.
pub struct Folder {
    path: PathBuf,
    force: bool,
    /// Name and CRC-32 of every file written.
    written: BTreeMap<String, u32>,
}

/// Where a folder keeps its memory.
const LEDGER: &str = ".slicecast-files.json";

impl Folder {
    /// Opens or makes a folder.
    pub fn open(path: &Path, force: bool) -> Result<Self, Failure> {
        fs::create_dir_all(path).map_err(|error| Failure::machine(format!("{}: {error}", path.display())))?;
        let written = fs::read(path.join(LEDGER))
            .ok()
            .and_then(|bytes| serde_json::from_slice(&bytes).ok())
            .unwrap_or_default();
        Ok(Self {
            path: path.to_owned(),
            force,
            written,
        })
    }

    /// Refuses now what [`Folder::write`] would refuse later.
    pub fn check(&self, names: &[String]) -> Result<(), Failure> {
        names.iter().try_for_each(|name| self.check_one(name))
    }

    fn check_one(&self, name: &str) -> Result<(), Failure> {
        let path = self.path.join(name);
        if self.force || fs::symlink_metadata(&path).is_err() {
            return Ok(());
        }
        let own = fs::read(&path).is_ok_and(|bytes| self.written.get(name) == Some(&crc32fast::hash(&bytes)));
        if own {
            Ok(())
        } else {
            Err(Failure::input(format!(
                "{} was not written by slicecast, or has been changed since; --force replaces it",
                path.display()
            )))
        }
    }

    /// Writes a file into the folder.
    pub fn write(&mut self, name: &str, contents: &[u8]) -> Result<PathBuf, Failure> {
        self.check_one(name)?;
        let path = self.path.join(name);
        write_file(&path, true, contents)?;
        self.written.insert(name.to_owned(), crc32fast::hash(contents));
        let ledger = serde_json::to_vec_pretty(&self.written).map_err(Failure::machine)?;
        write_file(&self.path.join(LEDGER), true, &ledger)?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_others_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "mine").unwrap();
        assert_eq!(write_file(&path, false, b"new").unwrap_err().code, 2);
        assert_eq!(fs::read(&path).unwrap(), b"mine");
        write_file(&path, true, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_replaces_only_what_it_wrote_and_nobody_changed() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("other"), "mine").unwrap();
        let mut folder = Folder::open(place.path(), false).unwrap();
        folder.write("own", b"1").unwrap();
        assert_eq!(folder.write("other", b"2").unwrap_err().code, 2);
        let mut again = Folder::open(place.path(), false).unwrap();
        again.write("own", b"3").unwrap();
        fs::write(place.path().join("own"), "changed").unwrap();
        assert!(again.check(&["own".into()]).is_err());
        let mut forced = Folder::open(place.path(), true).unwrap();
        forced.write("own", b"4").unwrap();
        assert_eq!(fs::read(place.path().join("own")).unwrap(), b"4");
    }

    #[test]
    fn folders_are_made_with_the_file_and_not_before() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("new/folder/a.png");
        check_free([&path], false).unwrap();
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
        write_file(&path, false, b"x").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"x");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_the_machines_fault_and_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("file"), "mine").unwrap();
        let path = place.path().join("file/new/a.png");
        assert_eq!(check_free([&path], false).unwrap_err().code, 1);
        assert_eq!(write_file(&path, false, b"x").unwrap_err().code, 1);
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }
}
