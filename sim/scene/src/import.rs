//! Transfer functions that other programs write: 3D Slicer's volume properties (`.vp`, `.vp.json`), ParaView's JSON.
//!
//! All three hold colour and opacity as separate curves over the data value; here they are joined point by point, so that
//! the joined function equals both. What has no counterpart (opacity by gradient, several components, colour spaces other
//! than RGB, curves that are bent) is left out or straightened, and told.

mod curve;
mod paraview;
mod slicer;

use std::path::Path;

use self::curve::{Curve, join};
use super::file::{SceneError, SceneFault, read_text};
use super::{Lighting, TransferFunction, check};

/// The programs' formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 3D Slicer up to 5.8: lines of numbers.
    SlicerText,
    /// 3D Slicer from 5.9 on.
    SlicerJson,
    /// ParaView's colour maps.
    ParaView,
}

impl Kind {
    /// The format that a name's ending tells.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        match () {
            () if name.ends_with(".vp.json") => Some(Self::SlicerJson),
            () if name.ends_with(".vp") => Some(Self::SlicerText),
            () if name.ends_with(".json") => Some(Self::ParaView),
            () => None,
        }
    }
}

/// What came out of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The transfer function; its values are in the data's unit.
    pub transfer: TransferFunction,
    /// The material under a light from the viewer, if the file asks for shading; `None` if it does not say.
    pub shading: Option<Shading>,
    /// What was left out or assumed, a sentence each.
    pub notes: Vec<String>,
}

/// Whether a file asks for light.
#[derive(Clone, Debug, PartialEq)]
pub enum Shading {
    /// Unlit.
    Off,
    /// Lit.
    On(Lighting),
}

/// Reads a file by its name's ending.
///
/// # Errors
/// [`SceneError`] names the file and what is wrong with it.
pub fn read(path: &Path) -> Result<Imported, SceneError> {
    let fail = |fault| SceneError {
        name: path.display().to_string(),
        fault,
    };
    let Some(kind) = Kind::of(path) else {
        let expected = "is of no known kind, expected .vp, .vp.json (3D Slicer) or .json (ParaView)";
        return Err(fail(SceneFault::Import(expected.into())));
    };
    let text = read_text(path).map_err(fail)?;
    parse(&text, kind).map_err(fail)
}

/// Reads a file's text.
///
/// # Errors
/// [`SceneFault`]: what is wrong, in one line.
pub fn parse(text: &str, kind: Kind) -> Result<Imported, SceneFault> {
    let parts = match kind {
        Kind::SlicerText => slicer::parse_text(text)?,
        Kind::SlicerJson => slicer::parse_json(text)?,
        Kind::ParaView => paraview::parse(text)?,
    };
    let mut notes = parts.notes;
    let colour = parts.colour.straight(&mut notes);
    let opacity = parts.opacity.straight(&mut notes);
    let transfer = TransferFunction {
        unit_distance: parts.unit_distance,
        points: join(&colour, &opacity),
    };
    check::transfer(&transfer)?;
    notes.sort();
    notes.dedup();
    Ok(Imported {
        transfer,
        shading: parts.shading,
        notes,
    })
}

/// A file's curves before they are joined.
struct Parts {
    colour: Curve<3>,
    opacity: Curve<1>,
    unit_distance: f64,
    shading: Option<Shading>,
    notes: Vec<String>,
}

/// A material of VTK's numbers.
fn material([ambient, diffuse, specular, power]: [f64; 4]) -> Result<Shading, SceneFault> {
    let lighting = Lighting {
        ambient,
        diffuse,
        specular,
        exponent_log2: power.clamp(1.0, 256.0).log2().round() as u32,
        ..Lighting::default()
    };
    check::lighting(&lighting)?;
    Ok(Shading::On(lighting))
}

#[cfg(test)]
mod tests;
