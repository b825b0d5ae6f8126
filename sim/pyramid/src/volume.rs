//! A volume of colour and extinction.

use slicecast_volume::decoded::Orientation;

use crate::reduce::Sums;
use crate::voxel::{Codes, Entry, MAX_CODE, decode};

/// Voxels, x fastest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Voxels {
    /// As they are stored: four bytes.
    Entries(Vec<Entry>),
    /// As they are computed with: eight bytes.
    Codes(Vec<Codes>),
}

impl Voxels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Entries(entries) => entries.len(),
            Self::Codes(codes) => codes.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The codes of one.
    ///
    /// # Panics
    /// If there is no such voxel.
    pub fn codes(&self, index: usize) -> Codes {
        match self {
            Self::Entries(entries) => decode(entries[index]),
            Self::Codes(codes) => codes[index],
        }
    }
}

/// A volume whose voxels have a colour and an extinction.
#[derive(Clone, Debug)]
pub struct RgbaVolume {
    /// Where it came from, for messages.
    pub name: String,
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// Distance between voxels along x, y and z.
    pub spacing: [f64; 3],
    /// How it lies in the patient.
    pub orientation: Orientation,
    /// The extinction of the largest code, per unit of the spacing; above 0.
    pub tau_max: f64,
    /// The distance over which opacities were meant, if the extinctions were made of some.
    pub alpha_distance: Option<f64>,
    /// One for each voxel.
    pub voxels: Voxels,
}

impl RgbaVolume {
    /// Adds the codes of a slice to `out`.
    pub fn slice(&self, z: usize, out: &mut Vec<Sums>) {
        let area = self.dims[0] * self.dims[1];
        out.extend((z * area..(z + 1) * area).map(|index| Sums(self.voxels.codes(index).map(u32::from))));
    }

    /// The extinction of a code, per unit of the spacing.
    pub fn tau(&self, code: u16) -> f64 {
        self.tau_max * f64::from(code) / f64::from(MAX_CODE)
    }

    /// Extinction times volume, over all voxels: what a pyramid keeps. Voxels are cells, or nodes whose outer ones count half.
    pub fn content(&self, on_nodes: bool) -> f64 {
        let [x, y, z] = self.dims;
        let share = |at: usize, len: usize| {
            if on_nodes && len > 1 && (at == 0 || at + 1 == len) {
                0.5
            } else {
                1.0
            }
        };
        let mut sum = 0.0;
        for k in 0..z {
            for j in 0..y {
                let row = (0..x).map(|i| share(i, x) * f64::from(self.voxels.codes(i + x * (j + y * k))[3]));
                sum += share(k, z) * share(j, y) * row.sum::<f64>();
            }
        }
        sum * self.tau_max / f64::from(MAX_CODE) * self.spacing.iter().product::<f64>()
    }

    /// The mean opacity of all columns along z, each voxel a cell.
    pub fn opacity_along_z(&self) -> f64 {
        let area = self.dims[0] * self.dims[1];
        let column = |first: usize| {
            let codes = (0..self.dims[2]).map(|k| f64::from(self.voxels.codes(first + k * area)[3]));
            -(-codes.sum::<f64>() * self.tau_max / f64::from(MAX_CODE) * self.spacing[2]).exp_m1()
        };
        (0..area).map(column).sum::<f64>() / area as f64
    }
}
