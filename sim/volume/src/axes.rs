//! From a file's axes to the patient's: x to the patient's left, y to the back, z to the head (LPS).
//!
//! A file states, for each of its own axes, a direction in space. Voxels are reordered and reversed so that every axis
//! of the volume runs along the patient axis nearest to it; nothing is resampled. A volume that lies obliquely keeps its
//! own right-angled axes and is shown as if it were straight, with the angle told. Axes that are not at right angles (a
//! tilted gantry) would be shown sheared and are refused.

use super::error::AxesError;
use super::error::Problem;
use super::values::Values;

/// The largest cosine between two axes that still counts as a right angle (0.1 degrees).
const RIGHT_ANGLE: f64 = 0.002;

/// Angles from the patient's axes that are not worth a note, degrees.
const STRAIGHT: f64 = 0.1;

/// Where a file's axes run to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Directions {
    /// In the patient (LPS).
    Patient([[f64; 3]; 3]),
    /// In a space that is not a patient's.
    Space([[f64; 3]; 3]),
}

impl Directions {
    /// The turn that brings the file's axes there.
    ///
    /// # Errors
    /// [`AxesError`] if they are no axes.
    pub fn turn(self) -> Result<Turn, AxesError> {
        match self {
            Self::Patient(directions) | Self::Space(directions) => Turn::upright(directions),
        }
    }

    /// What the axes are brought to, in words.
    pub(super) const fn space(self) -> &'static str {
        match self {
            Self::Patient(_) => "the patient's axes",
            Self::Space(_) => "the file's space",
        }
    }
}

/// How a file's axes become the volume's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// For each axis of the volume, the file's axis that it comes from.
    pub source: [usize; 3],
    /// For each axis of the volume, whether it runs against the file's.
    pub reversed: [bool; 3],
    /// The largest angle between an axis of the volume and its patient axis, degrees.
    pub tilt: f64,
}

impl Turn {
    /// Nothing changes.
    pub const NONE: Self = Self {
        source: [0, 1, 2],
        reversed: [false; 3],
        tilt: 0.0,
    };

    /// Whether nothing changes.
    pub fn is_none(&self) -> bool {
        (self.source, self.reversed) == (Self::NONE.source, Self::NONE.reversed)
    }

    /// The turn for directions of the file's x, y and z axis in LPS; their lengths do not matter.
    ///
    /// # Errors
    /// [`AxesError`] if one has no direction or two are not at right angles.
    pub fn upright(directions: [[f64; 3]; 3]) -> Result<Self, AxesError> {
        let mut unit = [[0.0; 3]; 3];
        for (axis, direction) in directions.into_iter().enumerate() {
            let length = dot(direction, direction).sqrt();
            if !(length.is_finite() && length > 0.0) {
                return Err(AxesError::Direction { axis, direction });
            }
            unit[axis] = direction.map(|c| c / length);
        }
        for axes in [[0, 1], [0, 2], [1, 2]] {
            let cosine = dot(unit[axes[0]], unit[axes[1]]);
            if cosine.is_nan() || cosine.abs() > RIGHT_ANGLE {
                let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
                return Err(AxesError::Sheared { axes, angle });
            }
        }
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let along = |order: &[usize; 3]| (0..3).map(|to| unit[order[to]][to].abs()).sum::<f64>();
        // The first order wins a tie, so that the file's own order is kept where it can be.
        let source = ORDERS.into_iter().fold(ORDERS[0], |best, order| {
            if along(&order) > along(&best) + 1e-9 {
                order
            } else {
                best
            }
        });
        let smallest = (0..3).map(|to| unit[source[to]][to].abs()).fold(1.0, f64::min);
        Ok(Self {
            source,
            reversed: [0, 1, 2].map(|to| unit[source[to]][to] < 0.0),
            tilt: smallest.min(1.0).acos().to_degrees(),
        })
    }

    /// The letters that tell where the file's axes run to, such as `RAS`.
    pub fn letters(&self) -> String {
        let mut letters = ['?'; 3];
        for (to, ends) in [['L', 'R'], ['P', 'A'], ['S', 'I']].into_iter().enumerate() {
            letters[self.source[to]] = ends[usize::from(self.reversed[to])];
        }
        letters.into_iter().collect()
    }

    /// What the user should know, a sentence each; `space` names what the axes were brought to.
    pub(super) fn notes(&self, space: &str) -> Vec<String> {
        let mut notes = Vec::new();
        if self.source != [0, 1, 2] || self.reversed != [false; 3] {
            let signed = [0, 1, 2].map(|to| {
                let sign = if self.reversed[to] { "-" } else { "" };
                format!("{sign}{}", ["x", "y", "z"][self.source[to]])
            });
            notes.push(format!(
                "voxels reordered: the volume's x, y, z are the file's {} so that they run along {space}",
                signed.join(", ")
            ));
        }
        if self.tilt > STRAIGHT {
            notes.push(format!(
                "the volume lies {:.1} degrees oblique to {space}: shown along its own axes",
                self.tilt
            ));
        }
        notes
    }

    /// Three numbers of the file's axes in the volume's order.
    pub(super) fn permuted<T: Copy>(&self, of_file: [T; 3]) -> [T; 3] {
        self.source.map(|axis| of_file[axis])
    }

    /// The values in the volume's order, of voxels that have `components` (1, 3 or 4) side by side; `dims` are the file's.
    pub(super) fn values(&self, values: Values, components: usize, dims: [usize; 3]) -> Result<Values, Problem> {
        Ok(match values {
            Values::I8(v) => Values::I8(self.groups(v, components, dims)?),
            Values::U8(v) => Values::U8(self.groups(v, components, dims)?),
            Values::I16(v) => Values::I16(self.groups(v, components, dims)?),
            Values::U16(v) => Values::U16(self.groups(v, components, dims)?),
            Values::I32(v) => Values::I32(self.groups(v, components, dims)?),
            Values::U32(v) => Values::U32(self.groups(v, components, dims)?),
            Values::F32(v) => Values::F32(self.groups(v, components, dims)?),
            Values::F64(v) => Values::F64(self.groups(v, components, dims)?),
        })
    }

    fn groups<T: Copy>(&self, values: Vec<T>, components: usize, dims: [usize; 3]) -> Result<Vec<T>, Problem> {
        if self.is_none() {
            return Ok(values);
        }
        Ok(match components {
            1 => self.reorder(&values, dims)?,
            3 => self.reorder(values.as_chunks::<3>().0, dims)?.into_flattened(),
            _ => self.reorder(values.as_chunks::<4>().0, dims)?.into_flattened(),
        })
    }

    fn reorder<T: Copy>(&self, values: &[T], dims: [usize; 3]) -> Result<Vec<T>, Problem> {
        let file_strides = [1, dims[0], dims[0] * dims[1]];
        let sides = self.permuted(dims);
        let strides = self.permuted(file_strides);
        // Where step i along an axis of the volume lies in the file, relative to the others.
        let place = |axis: usize, i: usize| match self.reversed[axis] {
            true => (sides[axis] - 1 - i) * strides[axis],
            false => i * strides[axis],
        };
        let mut out = Vec::new();
        out.try_reserve_exact(values.len()).map_err(|_| Problem::Memory {
            bytes: size_of_val(values) as u64,
        })?;
        for z in 0..sides[2] {
            for y in 0..sides[1] {
                let row = place(2, z) + place(1, y);
                out.extend((0..sides[0]).map(|x| values[row + place(0, x)]));
            }
        }
        Ok(out)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signed_axes_come_back_to_lps() {
        // RAS, as most NIfTI files: x and y run against LPS.
        let turn = Turn::upright([[-2.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 3.0]]).unwrap();
        assert_eq!((turn.source, turn.reversed), ([0, 1, 2], [true, true, false]));
        assert_eq!(turn.letters(), "RAS");
        // A sagittal stack: the file's x runs to the back, its y down, its z to the left.
        let turn = Turn::upright([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]).unwrap();
        assert_eq!((turn.source, turn.reversed), ([2, 0, 1], [false, false, true]));
        assert_eq!(turn.letters(), "PIL");
        assert!(turn.notes("the patient's axes")[0].contains("the file's z, x, -y"));
    }

    #[test]
    fn every_voxel_finds_its_place() {
        let dims = [2, 3, 4];
        let values: Vec<u8> = (0..24).collect();
        let turn = Turn::upright([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]).unwrap();
        let Values::U8(out) = turn.values(Values::U8(values.clone()), 1, dims).unwrap() else {
            panic!()
        };
        let sides = turn.permuted(dims);
        assert_eq!(sides, [4, 2, 3]);
        for z in 0..3 {
            for y in 0..2 {
                for x in 0..4 {
                    let from = y + 2 * (2 - z) + 6 * x;
                    assert_eq!(out[x + 4 * (y + 2 * z)], values[from]);
                }
            }
        }
        for components in [3, 4] {
            let side_by_side = |values: &[u8]| values.iter().flat_map(|&v| vec![v; components]).collect::<Vec<u8>>();
            let turned = turn.values(Values::U8(side_by_side(&values)), components, dims);
            assert_eq!(turned.unwrap(), Values::U8(side_by_side(&out)));
        }
    }

    #[test]
    fn oblique_volumes_are_told_and_sheared_ones_refused() {
        let (s, c) = 10.0_f64.to_radians().sin_cos();
        let turn = Turn::upright([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]).unwrap();
        assert!((turn.tilt - 10.0).abs() < 1e-9);
        assert!(turn.notes("the patient's axes")[0].contains("10.0 degrees oblique"));
        let error = Turn::upright([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, 0.0, 1.0]]).unwrap_err();
        assert!(error.to_string().contains("y and z at 80.00 degrees"), "{error}");
        for bad in [[0.0; 3], [f64::NAN, 0.0, 0.0], [1e200, 1e200, 0.0]] {
            let error = Turn::upright([[0.0, 1.0, 0.0], bad, [0.0, 0.0, 1.0]]).unwrap_err();
            assert!(matches!(error, AxesError::Direction { axis: 1, .. }));
        }
    }

    #[test]
    fn a_tie_keeps_the_files_order() {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let turn = Turn::upright([[h, h, 0.0], [-h, h, 0.0], [0.0, 0.0, 1.0]]).unwrap();
        assert_eq!(turn.source, [0, 1, 2]);
    }
}
