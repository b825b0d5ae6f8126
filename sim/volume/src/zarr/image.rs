//! Which array of a store is the volume, and what the store says of it: OME-NGFF, versions 0.1 to 0.5.
//!
//! Source: the specification of OME-NGFF 0.4 and 0.5, `multiscales` and `omero`.

use std::path::{Component, Path};

use serde_json::Value;

use super::NAME;
use super::node::{Node, Object, is_node, listed};
use crate::error::{Problem, ReadError};
use crate::text::shorten;

/// Groups above an array that are looked at for what they say of it.
const ABOVE: usize = 8;

/// What a store says of an array.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// Of each axis.
    pub axes: Vec<Axis>,
    /// Distance between entries along each axis, in its unit.
    pub scale: Option<Vec<f64>>,
    /// The window of each channel.
    pub windows: Vec<Option<[f64; 2]>>,
    pub notes: Vec<String>,
}

/// An axis that a store names.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub name: String,
    /// `space`, `time`, `channel` or another.
    pub kind: Option<String>,
    pub unit: Option<String>,
}

/// The array that a path leads to, and what is told of it.
///
/// # Errors
/// [`ReadError`] if there is no such node, or a group has no array or more than one to choose from.
pub(super) fn find(path: &Path) -> Result<(Node, Told), ReadError> {
    if !path.exists() {
        return Err(missing(path));
    }
    let mut node = Node::read(path)?;
    let mut passed = Vec::new();
    // A group of one image leads to it; those of several want a name.
    loop {
        if node.is_array {
            let mut told = told_above(&node.folder)?;
            told.notes.splice(0..0, passed);
            return Ok((node, told));
        }
        if let Some(multiscale) = multiscale(&node)? {
            let level = multiscale.level(&node, 0)?;
            let array = Node::read(&node.folder.join(&level))?;
            if !array.is_array {
                return Err(array.fault("is a group, expected the array of a level"));
            }
            let mut told = multiscale.told(&node, 0)?;
            if multiscale.levels.len() > 1 {
                passed.push(format!(
                    "level {} of {}; the path of another chooses it, like {}",
                    shorten(&level),
                    listed(multiscale.names().iter().map(String::as_str)),
                    node.folder.join(&multiscale.names()[1]).display()
                ));
            }
            told.notes.splice(0..0, passed);
            return Ok((array, told));
        }
        let children = node.children();
        // Beside its images a file of Bio-Formats has a group of metadata.
        let images: Vec<&String> = children.iter().filter(|name| *name != "OME").collect();
        match images[..] {
            [only] => {
                passed.push(format!("the group's only image is `{}`", shorten(only)));
                node = Node::read(&node.folder.join(only))?;
                if passed.len() > ABOVE {
                    return Err(node.fault("groups nest deeper than any image"));
                }
            }
            [] => return Err(node.fault("is a group without an array or `multiscales`, expected an image")),
            _ => {
                return Err(node.fault(format!(
                    "is a group of {}, expected one of them: its path chooses it, like {}",
                    listed(images.iter().map(|name| name.as_str())),
                    node.folder.join(images[0]).display()
                )));
            }
        }
    }
}

/// The fault of a path that leads to nothing in a store.
fn missing(path: &Path) -> ReadError {
    let Some(around) = path.ancestors().skip(1).find(|folder| is_node(folder)) else {
        return ReadError::new(path, Problem::NotAFile { found: "nothing" });
    };
    let listing = Node::read(around).and_then(|node| {
        let levels = multiscale(&node)?.map(|multiscale| multiscale.names());
        Ok(levels.unwrap_or_else(|| node.children()))
    });
    match listing {
        Err(error) => error,
        Ok(names) => {
            let name = path.strip_prefix(around).unwrap_or(path).display().to_string();
            let names = if names.is_empty() {
                "none".into()
            } else {
                listed(names.iter().map(String::as_str))
            };
            let fault = format!("has no level `{}`, expected one of {names}", shorten(&name));
            ReadError::new(around, Problem::format(NAME, fault))
        }
    }
}

/// What the groups above an array say of it.
fn told_above(array: &Path) -> Result<Told, ReadError> {
    let Ok(array) = array.canonicalize() else {
        return Ok(Told::default());
    };
    for folder in array
        .ancestors()
        .skip(1)
        .take(ABOVE)
        .take_while(|folder| is_node(folder))
    {
        let node = Node::read(folder)?;
        let Some(multiscale) = multiscale(&node)? else {
            continue;
        };
        let names = multiscale.names();
        let level = names.iter().position(|name| folder.join(name) == array);
        return level.map_or(Ok(Told::default()), |level| multiscale.told(&node, level));
    }
    Ok(Told::default())
}

/// An image in several sizes.
struct Multiscale<'n> {
    of: &'n Object,
    levels: Vec<&'n Value>,
    /// Others of the group, which are passed over.
    others: usize,
    omero: Option<&'n Value>,
}

/// The image of a group, if it is one.
fn multiscale(node: &Node) -> Result<Option<Multiscale<'_>>, ReadError> {
    let attributes = match node.attributes.get("ome") {
        Some(Value::Object(ome)) => ome,
        _ => &node.attributes,
    };
    let Some(list) = attributes.get("multiscales").and_then(Value::as_array) else {
        return Ok(None);
    };
    let fault = || node.told_fault("`multiscales` has no `datasets`, expected a list of levels");
    let of = list.first().and_then(Value::as_object).ok_or_else(fault)?;
    let levels = of.get("datasets").and_then(Value::as_array).ok_or_else(fault)?;
    if levels.is_empty() {
        return Err(fault());
    }
    Ok(Some(Multiscale {
        of,
        levels: levels.iter().collect(),
        others: list.len() - 1,
        omero: attributes.get("omero"),
    }))
}

impl Multiscale<'_> {
    /// The paths of the levels, the finest first.
    fn names(&self) -> Vec<String> {
        let path = |level: &&Value| level.get("path").and_then(Value::as_str).unwrap_or("?").to_owned();
        self.levels.iter().map(path).collect()
    }

    /// The path of a level, which has to be in the group.
    fn level(&self, node: &Node, level: usize) -> Result<String, ReadError> {
        let name = &self.names()[level];
        let mut parts = Path::new(name).components();
        if name.is_empty() || !parts.all(|part| matches!(part, Component::Normal(_))) {
            let name = shorten(name);
            return Err(ReadError::new(&node.told_in, Problem::Outside { name }));
        }
        Ok(name.clone())
    }

    /// What is told of a level.
    fn told(&self, node: &Node, level: usize) -> Result<Told, ReadError> {
        let mut notes = Vec::new();
        if self.others > 0 {
            notes.push(format!("{} images in the group: shown is the first", self.others + 1));
        }
        let axes = match self.of.get("axes").and_then(Value::as_array) {
            // The first versions had these, always.
            None => ["t", "c", "z", "y", "x"].map(|name| axis(&name.into())).to_vec(),
            Some(axes) => axes.iter().map(axis).collect(),
        };
        let mut scale = None;
        for holder in [self.levels[level].as_object(), Some(self.of)].into_iter().flatten() {
            let list = holder.get("coordinateTransformations").and_then(Value::as_array);
            for transformation in list.into_iter().flatten() {
                let kind = transformation.get("type").and_then(Value::as_str).unwrap_or_default();
                match kind {
                    // Where it begins does not matter here.
                    "translation" | "identity" => {}
                    "scale" => {
                        let factors = transformation.get("scale").and_then(Value::as_array);
                        let factors: Option<Vec<f64>> =
                            factors.and_then(|factors| factors.iter().map(Value::as_f64).collect());
                        let factors = factors.filter(|factors| factors.len() == axes.len());
                        let factors = factors.ok_or_else(|| {
                            node.told_fault(format!(
                                "`scale` is not a list of {} numbers, one for each axis",
                                axes.len()
                            ))
                        })?;
                        let before = scale.take().unwrap_or_else(|| vec![1.0; factors.len()]);
                        scale = Some(before.iter().zip(&factors).map(|(a, b)| a * b).collect());
                    }
                    _ => {
                        let found = format!("the coordinate transformation `{}`", shorten(kind));
                        let problem = Problem::Unsupported {
                            format: NAME,
                            found,
                            expected: "scale and translation",
                        };
                        return Err(ReadError::new(&node.told_in, problem));
                    }
                }
            }
        }
        let channels = self.omero.and_then(|omero| omero.get("channels")?.as_array());
        let window = |channel: &Value| {
            let end = |name: &str| channel.get("window")?.get(name)?.as_f64();
            Some([end("start")?, end("end")?])
        };
        Ok(Told {
            axes,
            scale,
            windows: channels.into_iter().flatten().map(window).collect(),
            notes,
        })
    }
}

/// An axis: a name alone, or an object.
fn axis(value: &Value) -> Axis {
    let text = |key: &str| value.get(key).and_then(Value::as_str).map(String::from);
    Axis {
        name: value.as_str().map(String::from).or(text("name")).unwrap_or_default(),
        kind: text("type"),
        unit: text("unit"),
    }
}
