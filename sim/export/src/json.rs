//! All numbers in one JSON object, a quantity a line.

use std::fmt::Write;

use serde::Serialize;

use crate::Numbers;
use crate::quantity::{Quantity, of_scene, of_table, of_voxels};

/// The file of the scene, and with voxels that of the voxels.
pub fn files(numbers: &Numbers<'_>, name: &str, voxels: Option<&[u16]>) -> Vec<(String, String)> {
    let scene: Vec<_> = of_scene(numbers).into_iter().chain(of_table(numbers.table)).collect();
    let mut files = vec![(
        format!("{name}.json"),
        object(numbers, scene.iter().map(|q| (q.name, q))),
    )];
    if let Some(voxels) = voxels {
        let voxels = of_voxels(numbers, voxels);
        files.push((format!("{name}_voxels.json"), object(numbers, [(voxels.name, &voxels)])));
    }
    files
}

/// `about` and `quantities`.
pub fn object<'q, T: Serialize + 'q>(
    numbers: &Numbers<'_>,
    quantities: impl IntoIterator<Item = (&'q str, &'q T)>,
) -> String {
    let about = numbers.about();
    let about = lines(about.iter().map(|(name, words)| (*name, words)));
    format!("{{\n\"about\": {about},\n\"quantities\": {}\n}}\n", lines(quantities))
}

fn lines<'q, T: Serialize + 'q>(members: impl IntoIterator<Item = (&'q str, &'q T)>) -> String {
    let mut out = String::from("{");
    for (index, (name, value)) in members.into_iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        // Neither a string nor a list of integers can fail.
        let value = serde_json::to_string(value).unwrap_or_default();
        let _ = write!(out, "{comma}\n  \"{name}\": {value}");
    }
    out.push_str("\n}");
    out
}

/// A quantity whose values are in a file.
#[derive(Serialize)]
pub struct Filed {
    /// The file's name.
    pub file: String,
    /// The words in it.
    pub words: usize,
    /// What they are.
    #[serde(flatten)]
    pub quantity: Quantity,
}
