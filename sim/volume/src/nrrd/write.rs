//! NRRD files of colours: a header, and the values behind it, as [`read_colours`](super::read_colours) reads them.

use std::fmt::Write as _;

use crate::decoded::Orientation;
use crate::values::ValueType;

/// What a header says of a volume of colours.
#[derive(Clone, Copy, Debug)]
pub struct Written<'a> {
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// Distance between voxels along x, y and z.
    pub spacing: [f64; 3],
    /// How the volume lies in the patient.
    pub orientation: &'a Orientation,
    /// Type of a value, little-endian; unsigned.
    pub value_type: ValueType,
    /// Values of a voxel, 3 or 4.
    pub components: usize,
    /// `cell` or `node`: whether the volume reaches half a voxel beyond its outer voxels, or ends at them.
    pub centering: &'a str,
    /// Keys and values, each of one line.
    pub keys: &'a [(String, String)],
}

impl Written<'_> {
    /// The file: the header and `data`, voxel after voxel, x fastest.
    pub fn file(&self, data: &[u8]) -> Vec<u8> {
        let mut file = self.header().into_bytes();
        file.extend_from_slice(data);
        file
    }

    fn header(&self) -> String {
        let ([x, y, z], [sx, sy, sz]) = (self.dims, self.spacing);
        let (count, centering) = (self.components, self.centering);
        let mut text = format!(
            "NRRD0005\ntype: {}\ndimension: 4\nsizes: {count} {x} {y} {z}\nkinds: {count}-color domain domain domain\n\
             centers: none {centering} {centering} {centering}\nencoding: raw\n",
            self.value_type.name()
        );
        if self.value_type.byte_len() > 1 {
            text.push_str("endian: little\n");
        }
        let directions = format!("space directions: none ({sx},0,0) (0,{sy},0) (0,0,{sz})\n");
        match self.orientation {
            Orientation::Unknown => {
                let _ = writeln!(text, "spacings: nan {sx} {sy} {sz}");
            }
            Orientation::Space => text += &format!("space dimension: 3\n{directions}"),
            Orientation::Patient { .. } => text += &format!("space: left-posterior-superior\n{directions}"),
        }
        for (key, value) in self.keys {
            let _ = writeln!(text, "{key}:={value}");
        }
        text.push('\n');
        text
    }
}
