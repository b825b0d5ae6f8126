//! Crop boxes as the user states them: ranges along x, y and z, `10:40.5`, `:40` or `10:`, in voxels or in the unit of the
//! spacing.

/// What a crop box's numbers count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CropUnit {
    /// Voxels.
    #[default]
    Voxels,
    /// The volume's unit of spacing, millimetres in medical files.
    Millimetres,
}

/// A box of the volume, outside which nothing is drawn. 0 is the centre of the first voxel; an open end is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crop {
    /// From where to where along x, y and z.
    pub ranges: [[f64; 2]; 3],
    /// What these numbers count.
    pub unit: CropUnit,
}

/// Parts of a voxel that a face's place is rounded to: the scene's own, so that all who read it cut at the same place.
const PARTS: f64 = 65536.0;

impl Crop {
    /// The box that cuts nothing.
    pub const NONE: Self = Self {
        ranges: [[f64::NEG_INFINITY, f64::INFINITY]; 3],
        unit: CropUnit::Voxels,
    };

    /// Reads `x0:x1,y0:y1,z0:z1`, in millimetres with `mm` behind it.
    ///
    /// # Errors
    /// What was wrong and what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (ranges, unit) = match text.trim().strip_suffix("mm") {
            Some(ranges) => (ranges, CropUnit::Millimetres),
            None => (text, CropUnit::Voxels),
        };
        let parts: Vec<&str> = ranges.split(',').collect();
        let Ok([x, y, z]) = <[&str; 3]>::try_from(parts) else {
            return Err("expected three ranges, x0:x1,y0:y1,z0:z1, each of which may be open, as in :,:40,10:".into());
        };
        let read = |axis: &str, range: &str| parse_range(range).map_err(|why| format!("{axis}: {why}"));
        Ok(Self {
            ranges: [read("x", x)?, read("y", y)?, read("z", z)?],
            unit,
        })
    }

    /// The faces along x, y and z in voxels of a volume with this spacing, to the nearest 2^-16 voxel.
    pub fn faces(&self, spacing: [f64; 3]) -> [[f64; 2]; 3] {
        std::array::from_fn(|axis| {
            let voxel = match self.unit {
                CropUnit::Voxels => 1.0,
                CropUnit::Millimetres => spacing[axis],
            };
            self.ranges[axis].map(|face| (face / voxel * PARTS).round() / PARTS)
        })
    }
}

/// Reads a range with or without ends.
///
/// # Errors
/// What was wrong and what is expected.
pub(crate) fn parse_range(text: &str) -> Result<[f64; 2], String> {
    let expected = "expected a range such as 10:40.5, :40, 10: or :";
    let (low, high) = text
        .split_once(':')
        .ok_or_else(|| format!("{:?}: {expected}", text.trim()))?;
    let end = |end: &str, open: f64| match end.trim() {
        "" => Ok(open),
        number => (number.parse().ok())
            .filter(|n: &f64| n.is_finite() && n.abs() <= 1e9)
            .ok_or_else(|| format!("{number:?}: {expected}, of numbers up to 1e9")),
    };
    let (low, high) = (end(low, f64::NEG_INFINITY)?, end(high, f64::INFINITY)?);
    if low < high {
        Ok([low, high])
    } else {
        Err(format!("{:?}: {expected}, its first end below its second", text.trim()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_may_be_open() {
        let (none, all) = (f64::NEG_INFINITY, f64::INFINITY);
        let crop = Crop::parse("10:40.5, :30,:").unwrap();
        assert_eq!(crop.ranges, [[10.0, 40.5], [none, 30.0], [none, all]]);
        assert_eq!(crop.unit, CropUnit::Voxels);
        let crop = Crop::parse("-2.5:,:,1e1:2e1 mm").unwrap();
        assert_eq!(crop.ranges, [[-2.5, all], [none, all], [10.0, 20.0]]);
        assert_eq!(crop.faces([0.5, 1.0, 4.0]), [[-5.0, all], [none, all], [2.5, 5.0]]);
        assert_eq!(Crop::parse(":,:,:").unwrap(), Crop::NONE);
    }

    #[test]
    fn what_is_no_box_is_named() {
        for (text, why) in [
            ("1:2,3:4", "expected three ranges"),
            ("1:2,3:4,5:6,7:8", "expected three ranges"),
            ("1:2,3,5:6", "y: \"3\": expected a range"),
            ("1:2,4:3,5:6", "y: \"4:3\""),
            ("2:2,:,:", "x: \"2:2\""),
            (":,:,a:6", "z: \"a\""),
            (":,:,nan:6", "z: \"nan\""),
            (":,inf:,:", "y: \"inf\""),
            (":,:,:2e9", "z: \"2e9\""),
        ] {
            let error = Crop::parse(text).unwrap_err();
            assert!(error.starts_with(why), "{text}: {error}");
        }
    }

    /// A third of a voxel lies at the nearest 2^-16.
    #[test]
    fn faces_are_rounded_once() {
        let crop = Crop {
            ranges: [[1.0 / 3.0, 2.0], [0.0, 1.0], [0.0, 1.0]],
            unit: CropUnit::Voxels,
        };
        assert_eq!(crop.faces([7.0; 3])[0], [21845.0 / 65536.0, 2.0]);
    }
}
