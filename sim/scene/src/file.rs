//! Scene files: TOML in, a checked [`Scene`] out.
//!
//! `sim/scene/scenes/headsq.toml` is the reference: it states every field with its unit, range and default. Only `[transfer]`
//! is required; a scene without `[lighting]` is unlit. Fields that do not exist are refused.

mod parts;

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use thiserror::Error;

use self::parts::SceneFile;
use super::Scene;
use super::check::FieldError;

/// Bytes that a scene file may have.
pub const MAX_LEN: u64 = 1 << 20;

/// The scenes that come with the program: name and text.
pub const BUILT_IN: [(&str, &str); 6] = [
    ("headsq", include_str!("../scenes/headsq.toml")),
    ("ct-bone", include_str!("../scenes/ct-bone.toml")),
    ("ct-soft-tissue", include_str!("../scenes/ct-soft-tissue.toml")),
    ("ct-vessels", include_str!("../scenes/ct-vessels.toml")),
    ("ct-fog", include_str!("../scenes/ct-fog.toml")),
    ("ct-fog8", include_str!("../scenes/ct-fog8.toml")),
];

/// The name of the scene that is rendered when none is asked for; it is made for the built-in volume.
pub const DEFAULT: &str = "headsq";

/// A scene that could not be read: which, and why.
#[derive(Debug, Error)]
#[error("{name}: {fault}")]
pub struct SceneError {
    /// The file, or the name of a built-in scene.
    pub name: String,
    /// What is wrong with it, and what was expected.
    pub fault: SceneFault,
}

/// What is wrong with a scene.
#[derive(Debug, Error)]
pub enum SceneFault {
    /// The operating system refused.
    #[error("cannot read the file: {0}")]
    Io(#[from] io::Error),
    /// A folder or a device.
    #[error("is a folder or a device, expected a regular file")]
    NotAFile,
    /// Too long to be a scene.
    #[error("is longer than {MAX_LEN} bytes, expected a scene in TOML")]
    TooLong,
    /// Not text.
    #[error("is not UTF-8 text, expected a scene in TOML")]
    NotUtf8,
    /// Not TOML, an unknown or missing field, or one of the wrong type. The message shows the line.
    #[error("{0}")]
    Syntax(String),
    /// A transfer function of another program that cannot be read.
    #[error("{0}")]
    Import(String),
    /// A field out of range.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// No built-in scene has this name.
    #[error("is no built-in scene, expected one of {known}")]
    Unknown {
        /// The names that exist.
        known: String,
    },
}

/// Reads a scene file.
///
/// # Errors
/// [`SceneError`] names the file and, for a field out of range, its full name, the value given and the range.
pub fn read(path: &Path) -> Result<Scene, SceneError> {
    read_by(path, parse)
}

/// Reads a file's text by a parser, which is told the file's name for its messages.
pub(super) fn read_by<T>(path: &Path, parse: impl Fn(&str, &str) -> Result<T, SceneError>) -> Result<T, SceneError> {
    let name = path.display().to_string();
    match read_text(path) {
        Ok(text) => parse(&text, &name),
        Err(fault) => Err(SceneError { name, fault }),
    }
}

/// The built-in scene of a name, [`DEFAULT`] or another of [`BUILT_IN`].
///
/// # Errors
/// [`SceneError`] if there is no scene of that name.
pub fn built_in(name: &str) -> Result<Scene, SceneError> {
    match BUILT_IN.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => parse(text, name),
        None => {
            let known = BUILT_IN.map(|(known, _)| known).join(", ");
            Err(SceneError {
                name: name.to_owned(),
                fault: SceneFault::Unknown { known },
            })
        }
    }
}

/// Reads a scene from TOML text; `name` stands for the file in messages.
///
/// # Errors
/// [`SceneError`], as [`read`].
pub fn parse(text: &str, name: &str) -> Result<Scene, SceneError> {
    let fail = |fault| SceneError {
        name: name.to_owned(),
        fault,
    };
    let file: SceneFile = toml::from_str(text).map_err(|error| fail(SceneFault::Syntax(error.to_string())))?;
    let scene = file.into_scene().map_err(|error| fail(error.into()))?;
    scene.check().map_err(|error| fail(error.into()))?;
    Ok(scene)
}

/// The text of a regular file of at most [`MAX_LEN`] bytes.
pub(super) fn read_text(path: &Path) -> Result<String, SceneFault> {
    if !fs::metadata(path)?.is_file() {
        return Err(SceneFault::NotAFile);
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_LEN + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_LEN {
        return Err(SceneFault::TooLong);
    }
    String::from_utf8(bytes).map_err(|_| SceneFault::NotUtf8)
}

#[cfg(test)]
mod tests;
