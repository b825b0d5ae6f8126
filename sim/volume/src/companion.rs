//! The data file that a header names: beside the header or below it, never elsewhere.

use std::path::{Component, Path, PathBuf};

use super::error::{Problem, ReadError};
use super::text::shorten;

/// The path of the data file `name`, which a header at `header` states.
///
/// # Errors
/// [`Problem::Outside`] if the name, or a symbolic link on the way, leads out of the header's folder.
pub(super) fn data_file(header: &Path, name: &str) -> Result<PathBuf, ReadError> {
    let outside = || ReadError::new(header, Problem::Outside { name: shorten(name) });
    let relative = Path::new(name);
    let inside = relative
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !inside || relative.file_name().is_none() {
        return Err(outside());
    }
    let folder = match header.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let path = header.parent().unwrap_or(Path::new("")).join(relative);
    // A file that is not there is reported where it is opened.
    if let (Ok(folder), Ok(real)) = (folder.canonicalize(), path.canonicalize())
        && !real.starts_with(folder)
    {
        return Err(outside());
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_leave_the_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let header = folder.path().join("h.mhd");
        for bad in ["", "..", "../a", "a/../../b", "/etc/passwd", "."] {
            let error = data_file(&header, bad).unwrap_err().to_string();
            assert!(error.contains("h.mhd: names the data file"), "{bad}: {error}");
        }
        assert_eq!(
            data_file(&header, "./a b.raw").unwrap(),
            folder.path().join("./a b.raw")
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_that_leave_the_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let other = tempfile::NamedTempFile::new().unwrap();
        std::os::unix::fs::symlink(other.path(), folder.path().join("l.raw")).unwrap();
        let error = data_file(&folder.path().join("h.mhd"), "l.raw").unwrap_err();
        assert!(matches!(error.problem, Problem::Outside { .. }));
    }
}
