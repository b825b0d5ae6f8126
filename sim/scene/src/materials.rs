//! Tables of materials: what the shares of a volume's voxels are shares of. TOML in, a checked [`MaterialTable`] out.
//!
//! ```toml
//! voxel = "shares"         # a share of each material; or "label-share": one material's label, and its share
//!
//! [[material]]
//! name = "bone"            # for people
//! colour = "#e8d8c0"
//! extinction = 2.5         # 0 to 1e6, per unit of the volume's spacing
//! label = 3                # 1 to 255, of "label-share" alone
//! ```

use std::ops::RangeInclusive;
use std::path::Path;

use serde::Deserialize;

use crate::check::{COLOURS, FieldError};
use crate::colour::Colour;
use crate::file::{SceneError, SceneFault, read_by};

/// Materials whose shares a voxel can have side by side.
pub const SHARES: RangeInclusive<usize> = 1..=8;

/// Extinctions, per unit of the volume's spacing.
const EXTINCTIONS: RangeInclusive<f64> = 0.0..=1e6;

/// What the values of a voxel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VoxelOfMaterials {
    /// A share of each material, in their order.
    Shares,
    /// The label of a material, 0 being none, and its share.
    LabelShare,
}

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its label, where voxels have labels; else 0.
    pub label: u8,
    /// Red, green, blue, 0 to 1.
    pub colour: [f64; 3],
    /// What a voxel of it alone has, per unit of the volume's spacing.
    pub extinction: f64,
}

/// A table of materials: some, of which one at least has an extinction.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTable {
    /// What the values of a voxel are.
    pub voxel: VoxelOfMaterials,
    /// The materials; their labels differ.
    pub materials: Vec<Material>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    voxel: VoxelOfMaterials,
    material: Vec<Part>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Part {
    #[serde(rename = "name")]
    _name: Option<String>,
    label: Option<i64>,
    colour: Colour,
    extinction: f64,
}

/// Reads a table of materials.
///
/// # Errors
/// [`SceneError`] names the file, and the field that is out of range.
pub fn read(path: &Path) -> Result<MaterialTable, SceneError> {
    read_by(path, parse)
}

/// Reads a table from TOML text; `name` stands for the file in messages.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, name: &str) -> Result<MaterialTable, SceneError> {
    let fail = |fault| SceneError {
        name: name.to_owned(),
        fault,
    };
    let file: File = toml::from_str(text).map_err(|error| fail(SceneFault::Syntax(error.to_string())))?;
    table(file).map_err(|error| fail(error.into()))
}

fn table(File { voxel, material }: File) -> Result<MaterialTable, FieldError> {
    let most = match voxel {
        VoxelOfMaterials::Shares => *SHARES.end(),
        VoxelOfMaterials::LabelShare => 255,
    };
    if !(1..=most).contains(&material.len()) {
        return Err(FieldError::new(
            "material",
            material.len(),
            format!("1 to {most} materials"),
        ));
    }
    let mut materials: Vec<Material> = Vec::new();
    for (i, part) in material.into_iter().enumerate() {
        let made = material_of(voxel, i, &part)?;
        if voxel == VoxelOfMaterials::LabelShare && materials.iter().any(|other| other.label == made.label) {
            let field = format!("material[{i}].label");
            return Err(FieldError::new(&field, made.label, "another label than those before"));
        }
        materials.push(made);
    }
    if materials.iter().all(|material| material.extinction == 0.0) {
        return Err(FieldError::new(
            "material",
            "without any extinction",
            "one that is above 0",
        ));
    }
    Ok(MaterialTable { voxel, materials })
}

fn material_of(voxel: VoxelOfMaterials, i: usize, part: &Part) -> Result<Material, FieldError> {
    let field = |name: &str| format!("material[{i}].{name}");
    let label = match (voxel, part.label) {
        (VoxelOfMaterials::Shares, None) => 0,
        (VoxelOfMaterials::Shares, Some(label)) => {
            let expected = "none: shares stand in the materials' order";
            return Err(FieldError::new(&field("label"), label, expected));
        }
        (VoxelOfMaterials::LabelShare, label) => {
            let given = label.map_or_else(|| "missing".to_owned(), |label| label.to_string());
            let label = label
                .and_then(|label| u8::try_from(label).ok())
                .filter(|label| *label > 0);
            label.ok_or_else(|| FieldError::new(&field("label"), given, "1 to 255"))?
        }
    };
    let colour = part
        .colour
        .rgb()
        .filter(|rgb| rgb.iter().all(|c| (0.0..=1.0).contains(c)));
    let Some(colour) = colour else {
        let given = match &part.colour {
            Colour::Text(text) => format!("{text:?}"),
            Colour::Numbers(rgb) => format!("{rgb:?}"),
        };
        return Err(FieldError::new(&field("colour"), given, COLOURS));
    };
    if !EXTINCTIONS.contains(&part.extinction) {
        return Err(FieldError::new(&field("extinction"), part.extinction, "0 to 1e6"));
    }
    Ok(Material {
        label,
        colour,
        extinction: part.extinction,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read() {
        let table = parse(
            "voxel = \"label-share\"\n[[material]]\nname = \"bone\"\nlabel = 3\ncolour = \"#ff0080\"\nextinction = 2.5\n\
             [[material]]\nlabel = 255\ncolour = [0, 0.5, 1]\nextinction = 0",
            "t",
        );
        let material = |label, colour, extinction| Material {
            label,
            colour,
            extinction,
        };
        assert_eq!(
            table.unwrap(),
            MaterialTable {
                voxel: VoxelOfMaterials::LabelShare,
                materials: vec![
                    material(3, [1.0, 0.0, 128.0 / 255.0], 2.5),
                    material(255, [0.0, 0.5, 1.0], 0.0)
                ],
            }
        );
        let one = "[[material]]\ncolour = \"#ffffff\"\nextinction = 1\n";
        let table = parse(&format!("voxel = \"shares\"\n{}", one.repeat(8)), "t").unwrap();
        assert_eq!((table.voxel, table.materials.len()), (VoxelOfMaterials::Shares, 8));
    }

    #[test]
    fn what_is_no_table_is_refused_by_its_field() {
        let one = "[[material]]\ncolour = \"#ffffff\"\nextinction = 1\n";
        let dark = "[[material]]\ncolour = \"#ffffff\"\nextinction = 0\n";
        let labelled = "[[material]]\nlabel = 4\ncolour = \"#ffffff\"\nextinction = 1\n";
        for (voxel, materials, message) in [
            ("shares", String::new(), "missing field `material`"),
            ("shares", one.repeat(9), "t: `material` is 9, expected 1 to 8 materials"),
            (
                "shares",
                dark.repeat(2),
                "t: `material` is without any extinction, expected one that is above 0",
            ),
            (
                "shares",
                labelled.to_owned(),
                "t: `material[0].label` is 4, expected none: shares stand in the materials' order",
            ),
            (
                "label-share",
                one.to_owned(),
                "t: `material[0].label` is missing, expected 1 to 255",
            ),
            (
                "label-share",
                labelled.replace("4", "0"),
                "t: `material[0].label` is 0, expected 1 to 255",
            ),
            (
                "label-share",
                labelled.replace("4", "256"),
                "t: `material[0].label` is 256, expected 1 to 255",
            ),
            (
                "label-share",
                labelled.repeat(2),
                "t: `material[1].label` is 4, expected another label than those before",
            ),
            (
                "shares",
                one.replace("#ffffff", "white"),
                "t: `material[0].colour` is \"white\", expected ",
            ),
            (
                "shares",
                one.replace("\"#ffffff\"", "[0, 2, 0]"),
                "t: `material[0].colour` is [0.0, 2.0, 0.0], expected ",
            ),
            (
                "shares",
                one.replace("= 1", "= -1"),
                "t: `material[0].extinction` is -1, expected 0 to 1e6",
            ),
            (
                "shares",
                one.replace("= 1", "= nan"),
                "t: `material[0].extinction` is NaN, expected 0 to 1e6",
            ),
            (
                "shares",
                one.replace("extinction = 1", "extinction = 1\nopacity = 1"),
                "unknown field `opacity`",
            ),
            ("percent", one.to_owned(), "unknown variant `percent`"),
        ] {
            let found = parse(&format!("voxel = \"{voxel}\"\n{materials}"), "t")
                .unwrap_err()
                .to_string();
            assert!(found.contains(message), "{found}, not {message}");
        }
    }
}
