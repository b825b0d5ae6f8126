//! The metadata of a folder of a store: a group's or an array's.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::NAME;
use crate::error::{Problem, ReadError};
use crate::text::shorten;

/// Bytes that metadata may have; those of a group may hold all metadata below it.
const METADATA_MAX: u64 = 1 << 26;

/// Metadata of Zarr 3.
const THIRD: &str = "zarr.json";
/// Metadata of an array of Zarr 2.
const ARRAY: &str = ".zarray";
/// Metadata of a group of Zarr 2.
const GROUP: &str = ".zgroup";
/// What either of them says beside.
const ATTRIBUTES: &str = ".zattrs";

/// A JSON object.
pub(super) type Object = Map<String, Value>;

/// A folder of a store.
#[derive(Debug)]
pub(super) struct Node {
    pub folder: PathBuf,
    /// The file that the metadata come from.
    pub file: PathBuf,
    /// 2 or 3.
    pub version: u8,
    pub is_array: bool,
    pub metadata: Object,
    pub attributes: Object,
    /// The file that the attributes come from.
    pub told_in: PathBuf,
}

/// Whether a folder is a node of a store.
pub(super) fn is_node(folder: &Path) -> bool {
    [THIRD, ARRAY, GROUP].iter().any(|name| folder.join(name).is_file())
}

impl Node {
    /// Reads the metadata of a folder.
    ///
    /// # Errors
    /// [`ReadError`] if there are none or they are no JSON of a node.
    pub fn read(folder: &Path) -> Result<Self, ReadError> {
        let found = [THIRD, ARRAY, GROUP].map(|name| folder.join(name));
        let Some(file) = found.into_iter().find(|file| file.is_file()) else {
            let fault = format!("has none of {THIRD}, {ARRAY} and {GROUP}, expected one of them");
            return Err(ReadError::new(folder, Problem::format(NAME, fault)));
        };
        let fail = |fault: String| ReadError::new(&file, Problem::format(NAME, fault));
        let mut metadata = object(&file)?;
        let format = metadata.get("zarr_format").and_then(Value::as_u64);
        let is_third = file.ends_with(THIRD);
        let (version, expected) = if is_third { (3, 3) } else { (2, 2) };
        if format != Some(expected) {
            let found = format.map_or("no".into(), |format| format.to_string());
            return Err(fail(format!("states {found} `zarr_format`, expected {expected}")));
        }
        let is_array = match metadata.get("node_type").and_then(Value::as_str) {
            _ if !is_third => file.ends_with(ARRAY),
            Some("array") => true,
            Some("group") => false,
            other => {
                let found = shorten(other.unwrap_or("missing"));
                return Err(fail(format!("`node_type` is {found}, expected `array` or `group`")));
            }
        };
        let beside = folder.join(ATTRIBUTES);
        let attributes = if is_third {
            match metadata.remove("attributes") {
                Some(Value::Object(attributes)) => attributes,
                _ => Object::new(),
            }
        } else if beside.is_file() {
            object(&beside)?
        } else {
            Object::new()
        };
        Ok(Self {
            folder: folder.to_owned(),
            file: file.clone(),
            version,
            is_array,
            metadata,
            attributes,
            told_in: if is_third || !beside.is_file() { file } else { beside },
        })
    }

    /// A fault of the metadata.
    pub fn fault(&self, fault: impl Into<String>) -> ReadError {
        ReadError::new(&self.file, Problem::format(NAME, fault))
    }

    /// A fault of the attributes.
    pub fn told_fault(&self, fault: impl Into<String>) -> ReadError {
        ReadError::new(&self.told_in, Problem::format(NAME, fault))
    }

    /// The nodes in the folder, in the order of their names.
    pub fn children(&self) -> Vec<String> {
        let entries = self.folder.read_dir().into_iter().flatten().flatten();
        let nodes = entries.take(1 << 16).filter(|entry| is_node(&entry.path()));
        let mut names: Vec<String> = nodes
            .map(|node| node.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort_by_key(|name| (name.len(), name.clone()));
        names
    }
}

/// Names for a message: the first dozen.
pub(super) fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let count = names.len();
    let shown: Vec<String> = names.take(12).map(|name| format!("`{}`", shorten(name))).collect();
    let more = if count > 12 {
        format!(" and {} more", count - 12)
    } else {
        String::new()
    };
    shown.join(", ") + &more
}

/// The object that a file of JSON holds.
fn object(path: &Path) -> Result<Object, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let mut text = Vec::new();
    let file = File::open(path).map_err(Problem::io("open the file")).map_err(fail)?;
    let read = file.take(METADATA_MAX + 1).read_to_end(&mut text);
    read.map_err(Problem::io("read the file")).map_err(fail)?;
    if text.len() as u64 > METADATA_MAX {
        let fault = format!("metadata have more than {METADATA_MAX} bytes");
        return Err(fail(Problem::format(NAME, fault)));
    }
    serde_json::from_slice(&text).map_err(|error| {
        let fault = format!("metadata are no JSON object: {}", shorten(&error.to_string()));
        fail(Problem::format(NAME, fault))
    })
}
