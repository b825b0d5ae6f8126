//! Clip planes as the user states them: a point, a normal, perhaps a thickness and a falloff.

use serde::Deserialize;

/// What a clip plane's lengths count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum ClipUnit {
    /// Voxels; thickness and falloff, voxels of the smallest spacing.
    #[default]
    #[serde(rename = "voxels")]
    Voxels,
    /// The volume's unit of spacing, millimetres in medical files.
    #[serde(rename = "mm")]
    Millimetres,
}

/// A clip plane: what lies on the side of its normal is drawn, or a slab there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// A point of the plane; 0 is the centre of the first voxel.
    pub point: [f64; 3],
    /// Its normal along x, y and z, in the volume's proportions; its length does not matter.
    pub normal: [f64; 3],
    /// How far behind the plane what is drawn ends again.
    pub thickness: Option<f64>,
    /// The width of the ramp on which what is drawn fades, half of it on each side of a face.
    pub falloff: f64,
    /// Whether the side, or the slab, is cut away, and everything else drawn.
    pub outside: bool,
    /// What point, thickness and falloff count.
    pub unit: ClipUnit,
}

/// A clip plane on a volume: distances in lengths, each as long as the volume's largest spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipInVoxels {
    /// By how much the distance grows per voxel along x, y and z.
    pub slope: [f64; 3],
    /// The distance of the first voxel's centre.
    pub distance: f64,
    /// The distance of the far face.
    pub thickness: Option<f64>,
    /// The width of the ramp.
    pub falloff: f64,
}

/// Parts of a length that these numbers are rounded to: the scene's own, so that all who read it cut at the same place.
const PARTS: f64 = 1_073_741_824.0;

/// What `--clip` takes.
const EXPECTED: &str = "expected X,Y,Z:NX,NY,NZ, a point and a normal, and behind them, with colons, any of thickness=T, falloff=F, \
                        outside, mm";

impl Clip {
    /// The half space on the side of the normal.
    pub const fn new(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self {
            point,
            normal,
            thickness: None,
            falloff: 0.0,
            outside: false,
            unit: ClipUnit::Voxels,
        }
    }

    /// Reads `x,y,z:nx,ny,nz`, with `:thickness=t`, `:falloff=f`, `:outside` and `:mm` behind it.
    ///
    /// # Errors
    /// What was wrong and what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':').map(str::trim);
        let mut three = || {
            let part = parts.next().ok_or_else(|| EXPECTED.to_string())?;
            let numbers: Vec<f64> = part.split(',').map(number).collect::<Result<_, _>>()?;
            <[f64; 3]>::try_from(numbers).map_err(|_| format!("{part:?}: {EXPECTED}"))
        };
        let mut clip = Self::new(three()?, three()?);
        for part in parts {
            match part.split_once('=') {
                Some(("thickness", length)) => clip.thickness = Some(number(length)?),
                Some(("falloff", length)) => clip.falloff = number(length)?,
                None if part == "outside" => clip.outside = true,
                None if part == "mm" => clip.unit = ClipUnit::Millimetres,
                _ => return Err(format!("{part:?}: {EXPECTED}")),
            }
        }
        clip.check()
            .map_err(|(name, value, expected)| format!("{name} is {value}, expected {expected}"))?;
        Ok(clip)
    }

    /// The field that is out of range, what it is and what is expected.
    ///
    /// # Errors
    /// The first such field.
    pub fn check(&self) -> Result<(), (&'static str, String, &'static str)> {
        let shown = |[x, y, z]: [f64; 3]| format!("{x}, {y}, {z}");
        let bounded = |numbers: &[f64]| numbers.iter().all(|n| n.is_finite() && n.abs() <= 1e9);
        if !bounded(&self.point) {
            return Err(("point", shown(self.point), "three numbers from -1e9 to 1e9"));
        }
        if !bounded(&self.normal) || self.normal.iter().all(|n| n.abs() < 1e-9) {
            return Err((
                "normal",
                shown(self.normal),
                "three numbers from -1e9 to 1e9, not all 0",
            ));
        }
        if let Some(thickness) = self.thickness.filter(|t| !(*t > 0.0 && *t <= 1e9)) {
            return Err(("thickness", thickness.to_string(), "above 0 to 1e9"));
        }
        if !(0.0..=1e9).contains(&self.falloff) {
            return Err(("falloff", self.falloff.to_string(), "0 to 1e9"));
        }
        Ok(())
    }

    /// The plane on a volume with this spacing, to the nearest 2^-30 length.
    pub fn in_voxels(&self, spacing: [f64; 3]) -> ClipInVoxels {
        let length = spacing.into_iter().fold(0.0, f64::max);
        let smallest = spacing.into_iter().fold(f64::INFINITY, f64::min);
        let (voxel, unit) = match self.unit {
            ClipUnit::Voxels => ([1.0; 3], smallest),
            ClipUnit::Millimetres => (spacing, 1.0),
        };
        let norm = self.normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        let rounded = |x: f64| (x * PARTS).round() / PARTS;
        let slope = [0, 1, 2].map(|axis| self.normal[axis] / norm * spacing[axis] / length);
        let point = [0, 1, 2].map(|axis| self.point[axis] / voxel[axis]);
        ClipInVoxels {
            slope: slope.map(rounded),
            distance: rounded(-(0..3).map(|axis| slope[axis] * point[axis]).sum::<f64>()),
            thickness: self.thickness.map(|thickness| rounded(thickness * unit / length)),
            falloff: rounded(self.falloff * unit / length),
        }
    }
}

fn number(text: &str) -> Result<f64, String> {
    (text.trim().parse().ok())
        .filter(|n: &f64| n.is_finite())
        .ok_or_else(|| format!("{:?} is no number: {EXPECTED}", text.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_read() {
        let clip = Clip::parse("1,2.5,-3:0,0,1").unwrap();
        assert_eq!(clip, Clip::new([1.0, 2.5, -3.0], [0.0, 0.0, 1.0]));
        let clip = Clip::parse(" 1,2,3 : 1,1,0 : thickness=4 : falloff=0.5 : outside : mm").unwrap();
        assert_eq!((clip.thickness, clip.falloff, clip.outside), (Some(4.0), 0.5, true));
        assert_eq!(clip.unit, ClipUnit::Millimetres);
    }

    #[test]
    fn what_is_no_plane_is_named() {
        for (text, why) in [
            ("1,2,3", "expected X,Y,Z:NX,NY,NZ"),
            ("1,2:0,0,1", "\"1,2\": expected"),
            ("1,2,3:0,0,0", "normal is 0, 0, 0, expected three numbers"),
            ("1,2,3:a,0,1", "\"a\" is no number"),
            ("1,2,nan:0,0,1", "\"nan\" is no number"),
            ("1,2,3:0,0,1:thickness=0", "thickness is 0, expected above 0"),
            ("1,2,3:0,0,1:falloff=-1", "falloff is -1, expected 0 to 1e9"),
            ("1,2,3:0,0,1:soft", "\"soft\": expected"),
            ("1,2,2e9:0,0,1", "point is 1, 2, 2000000000, expected"),
        ] {
            let error = Clip::parse(text).unwrap_err();
            assert!(error.starts_with(why), "{text}: {error}");
        }
    }

    /// Lengths are the volume's largest spacing; a normal is one of the volume's proportions, whatever its voxels.
    #[test]
    fn planes_lie_where_they_are_stated() {
        let clip = Clip {
            thickness: Some(3.0),
            falloff: 1.0,
            ..Clip::new([2.0, 0.0, 4.0], [3.0, 0.0, 4.0])
        };
        let plane = clip.in_voxels([1.0, 2.0, 0.5]);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        near(plane.slope[0], 0.6 * 1.0 / 2.0);
        near(plane.slope[1], 0.0);
        near(plane.slope[2], 0.8 * 0.5 / 2.0);
        near(plane.distance, -(0.3 * 2.0 + 0.2 * 4.0));
        near(plane.thickness.unwrap(), 3.0 * 0.5 / 2.0);
        near(plane.falloff, 0.25);
        let in_mm = Clip {
            unit: ClipUnit::Millimetres,
            point: [2.0, 0.0, 2.0],
            ..clip
        };
        let plane = in_mm.in_voxels([1.0, 2.0, 0.5]);
        near(plane.distance, -(0.3 * 2.0 + 0.2 * 4.0));
        near(plane.thickness.unwrap(), 1.5);
    }
}
