//! Perspective: where the eye stands, and how much it sees.

use serde::Deserialize;

use crate::clip::ClipUnit;

/// Rays from an eye, in place of parallel ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    /// Field of view from the top of the picture to its bottom, degrees.
    pub fov: f64,
    /// Where the eye is; without it, as far from the middle of the volume as the field of view asks for to hold all of it, against the
    /// viewing direction.
    pub eye: Option<Eye>,
}

/// A place in or about the volume; 0, 0, 0 is the centre of the first voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Along x, y and z.
    pub at: [f64; 3],
    /// What these count.
    pub unit: ClipUnit,
}

/// How rays run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// All along the viewing direction.
    #[default]
    Parallel,
    /// From an eye.
    Perspective,
}

/// The field of view of a scene that states none, degrees.
pub const FOV: f64 = 40.0;

/// What an eye is expected to be.
const EXPECTED: &str = "expected X,Y,Z in voxels, like 32,-80,40, or with :mm behind them in the unit of the spacing";

impl Eye {
    /// An eye on the command line: `X,Y,Z`, perhaps with `:mm` behind it.
    ///
    /// # Errors
    /// What was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (numbers, unit) = match text.split_once(':') {
            None => (text, ClipUnit::Voxels),
            Some((numbers, "mm")) => (numbers, ClipUnit::Millimetres),
            Some(_) => return Err(EXPECTED.into()),
        };
        let numbers: Option<Vec<f64>> = numbers.split(',').map(|c| c.trim().parse().ok()).collect();
        let at = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        let eye = Self {
            at: at.ok_or(EXPECTED)?,
            unit,
        };
        eye.is_near().then_some(eye).ok_or_else(|| EXPECTED.into())
    }

    /// Whether its place can be reckoned with.
    pub(crate) fn is_near(&self) -> bool {
        self.at.iter().all(|c| c.is_finite() && c.abs() <= 1e9)
    }

    /// Its place in voxels.
    pub fn in_voxels(&self, spacing: [f64; 3]) -> [f64; 3] {
        match self.unit {
            ClipUnit::Voxels => self.at,
            ClipUnit::Millimetres => [0, 1, 2].map(|axis| self.at[axis] / spacing[axis]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_are_three_numbers() {
        let eye = Eye::parse("1, -2.5,3").unwrap();
        assert_eq!((eye.at, eye.unit), ([1.0, -2.5, 3.0], ClipUnit::Voxels));
        assert_eq!(eye.in_voxels([2.0; 3]), [1.0, -2.5, 3.0]);
        let eye = Eye::parse("1,-2.5,3:mm").unwrap();
        assert_eq!(eye.in_voxels([0.5, 1.0, 2.0]), [2.0, -2.5, 1.5]);
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,1e10", "1,2,3:cm"] {
            assert_eq!(Eye::parse(text), Err(EXPECTED.to_string()), "{text}");
        }
    }
}
