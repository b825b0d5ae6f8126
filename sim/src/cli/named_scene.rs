//! `--scene`: a scene file, or the name of a scene that comes with the program; `--transfer`: another program's function.
//!
//! A file is read, and a name looked up, while the command line is read: a mistake in either is told before a volume is.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{OsStringValueParser, TypedValueParser};
use slicecast_scene::Scene;
use slicecast_scene::file;
use slicecast_scene::import::{self, Imported};

use crate::presets;

/// A scene as it was asked for.
#[derive(Clone)]
pub enum NamedScene {
    /// A scene that comes with the program; some are fitted to a volume.
    Known(String),
    /// A file, and what it holds.
    File(PathBuf, Box<Scene>),
}

/// The names of all scenes that come with the program.
fn names() -> Vec<&'static str> {
    let built_in = file::BUILT_IN.iter().map(|(name, _)| *name);
    let fitted = presets::NAMES.into_iter().filter(|name| is_fitted(name));
    built_in.chain(fitted).collect()
}

/// Whether a scene is fitted to a volume's values, and does not exist without one.
pub fn is_fitted(name: &str) -> bool {
    file::BUILT_IN.iter().all(|(known, _)| *known != name)
}

impl NamedScene {
    /// Reads the file, or finds the name.
    fn of(text: OsString) -> Result<Self, String> {
        let path = Path::new(&text);
        let known = text.to_str().filter(|name| names().contains(name));
        match known {
            Some(name) if !path.is_file() => Ok(Self::Known(name.to_owned())),
            None if !path.exists() => Err(format!(
                "no such file, and no scene of that name; accepted: a TOML file, or one of {}",
                names().join(", ")
            )),
            _ => match file::read(path) {
                Ok(scene) => Ok(Self::File(path.to_owned(), Box::new(scene))),
                Err(error) => Err(error.fault.to_string()),
            },
        }
    }

    /// The parser of the command line.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        OsStringValueParser::new().try_map(Self::of)
    }

    /// The name for headings: a file's without its folders.
    pub fn name(&self) -> String {
        match self {
            Self::Known(name) => name.clone(),
            Self::File(path, _) => path
                .file_name()
                .unwrap_or(path.as_os_str())
                .to_string_lossy()
                .into_owned(),
        }
    }
}

/// The transfer function of another program: the file, and what came out of it.
#[derive(Clone)]
pub struct Transfer {
    pub path: PathBuf,
    pub imported: Imported,
}

impl Transfer {
    /// The parser of the command line.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        OsStringValueParser::new().try_map(|text| {
            let path = PathBuf::from(text);
            match import::read(&path) {
                Ok(imported) => Ok(Self { path, imported }),
                Err(error) => Err(error.fault.to_string()),
            }
        })
    }
}
