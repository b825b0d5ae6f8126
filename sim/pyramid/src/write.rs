//! Levels as NRRD files, which [`of_colours`](crate::read::of_colours) understands again.

use slicecast_volume::nrrd::write::Written;
use slicecast_volume::values::ValueType;

use crate::volume::{RgbaVolume, Voxels};
use crate::voxel::{Entry, encode};

/// The key that says what a voxel's four values are: [`ENTRIES`] or [`CODES`].
pub const VOXEL: &str = "slicecast_voxel";

/// Red, green, blue in 8 bits, and the root of extinction over `tau_max` in 8 bits.
pub const ENTRIES: &str = "root8";

/// Red, green, blue times extinction, and extinction; 32767 is `tau_max`.
pub const CODES: &str = "extinction15";

/// The key of the largest extinction, per unit of the spacing.
pub const TAU_MAX: &str = "slicecast_tau_max";

/// The key of the distance over which opacities are, or were, meant, in the unit of the spacing.
pub const ALPHA_DISTANCE: &str = "slicecast_alpha_distance";

/// A level, and how it was made.
#[derive(Clone, Copy, Debug)]
pub struct Level<'a> {
    /// The volume.
    pub volume: &'a RgbaVolume,
    /// Whether its voxels are nodes, and not cells.
    pub on_nodes: bool,
    /// 0 for the finest.
    pub number: usize,
    /// The filter's name, of levels above 0.
    pub filter: &'a str,
    /// Whether codes are written, which are exactly what was computed, and not entries.
    pub exact: bool,
}

impl Level<'_> {
    /// The file.
    pub fn file(&self) -> Vec<u8> {
        let volume = self.volume;
        let (kind, value_type, data) = if self.exact {
            let codes = (0..volume.voxels.len()).flat_map(|index| volume.voxels.codes(index));
            let data: Vec<u8> = codes.flat_map(u16::to_le_bytes).collect();
            (CODES, ValueType::U16, data)
        } else {
            let data: Vec<u8> = entries(&volume.voxels).into_flattened();
            (ENTRIES, ValueType::U8, data)
        };
        let mut keys = vec![
            (VOXEL.into(), kind.into()),
            (TAU_MAX.into(), volume.tau_max.to_string()),
            ("slicecast_level".into(), self.number.to_string()),
        ];
        if let Some(distance) = volume.alpha_distance {
            keys.push((ALPHA_DISTANCE.into(), distance.to_string()));
        }
        if self.number > 0 {
            keys.push(("slicecast_filter".into(), self.filter.into()));
        }
        let written = Written {
            dims: volume.dims,
            spacing: volume.spacing,
            orientation: &volume.orientation,
            value_type,
            components: 4,
            centering: if self.on_nodes { "node" } else { "cell" },
            keys: &keys,
        };
        written.file(&data)
    }
}

/// Voxels in four bytes.
fn entries(voxels: &Voxels) -> Vec<Entry> {
    match voxels {
        Voxels::Entries(entries) => entries.clone(),
        Voxels::Codes(codes) => codes.iter().copied().map(encode).collect(),
    }
}
