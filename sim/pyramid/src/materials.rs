//! Volumes of materials: voxels of colour and extinction from shares.
//!
//! A voxel has a share p of each material, in 255ths, whose sum is at most 255; the rest is empty. Extinctions, and colours times
//! extinction, are mixed by shares, as matter side by side in a voxel is.
//!
//! | value | formula | range |
//! |---|---|---|
//! | extinction of a material | `t = round(32767 tau / tau_max)`, tau_max the largest of the table | 0 to 32767 |
//! | its colour times extinction | `c = (257 O t + 2^15) >> 16`, O in 0.8 | 0 to t |
//! | a voxel's | `v = (257 sum(p t) + 2^15) >> 16`, of c alike | 0 to 32767 |
//!
//! Overflow: 257 · 255 · 32767 + 2^15 = 2147418113 < 2^31. A share of 255 of one material is that material, to the bit; c <= t, the sums
//! keep that order and so does the rounding. Error against the mixture in real numbers: 1.5 codes of extinction, half of them t's rounding,
//! half the division by 2^16 / 257 in place of 255, half the mixture's rounding; 2.5 of a colour, of which c has three halves itself.

use slicecast_volume::colours::Colours;
use slicecast_volume::values::Values;
use thiserror::Error;

use crate::volume::{RgbaVolume, Voxels};
use crate::voxel::{Codes, MAX_CODE};

/// Shares of a whole voxel.
const WHOLE: u32 = 255;

/// A material: its colour, and its extinction per unit of the spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Red, green, blue, 0 to 255.
    pub colour: [u8; 3],
    /// Extinction, finite and 0 or more.
    pub extinction: f64,
}

/// What the values of a voxel are.
#[derive(Clone, Debug, PartialEq)]
pub enum Shared {
    /// A share of each material.
    Each(Vec<Material>),
    /// A label and its share; label 0 is nothing.
    Labelled(Vec<(u8, Material)>),
}

impl Shared {
    fn materials(&self) -> Vec<Material> {
        match self {
            Self::Each(materials) => materials.clone(),
            Self::Labelled(materials) => materials.iter().map(|(_, material)| *material).collect(),
        }
    }

    /// Values of a voxel.
    fn components(&self) -> usize {
        match self {
            Self::Each(materials) => materials.len(),
            Self::Labelled(_) => 2,
        }
    }
}

/// Why values are no shares of materials.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MaterialError {
    /// A number type that is none of shares.
    #[error("has shares of type {found}, expected uint8: 255ths of a voxel")]
    Type {
        /// The type's name.
        found: &'static str,
    },
    /// Another number of values than the table has materials.
    #[error("has {found} values a voxel, expected {expected}: {what}")]
    Components {
        /// Values of a voxel.
        found: usize,
        /// What the table asks for.
        expected: usize,
        /// Why.
        what: &'static str,
    },
    /// More than a voxel holds.
    #[error("voxel ({}, {}, {}) has shares that add up to {sum}, expected at most 255", .voxel[0], .voxel[1], .voxel[2])]
    Sum {
        /// x, y, z of the first such voxel.
        voxel: [usize; 3],
        /// The sum.
        sum: u32,
    },
    /// A label without a material.
    #[error("voxel ({}, {}, {}) has the label {label}, expected 0 or one of the table of materials", .voxel[0], .voxel[1], .voxel[2])]
    Label {
        /// x, y, z of the first such voxel.
        voxel: [usize; 3],
        /// The label.
        label: u8,
    },
}

/// A material's codes, red, green, blue and extinction.
fn codes_of(material: &Material, tau_max: f64) -> Codes {
    let t = (f64::from(MAX_CODE) * material.extinction / tau_max).round() as u16;
    let [red, green, blue] = material.colour.map(|colour| slicecast::extinction::weighted(t, colour));
    [red, green, blue, t]
}

/// The codes of a mixture, of sums of shares times codes.
fn mixed(sums: [u32; 4]) -> Codes {
    sums.map(|sum| ((257 * sum + (1 << 15)) >> 16) as u16)
}

/// A volume of shares of materials, of which one at least has an extinction.
///
/// # Errors
/// [`MaterialError`] if the values are no shares of these.
pub fn of_shares(shares: &Colours, shared: &Shared) -> Result<RgbaVolume, MaterialError> {
    let (found, expected) = (shares.components(), shared.components());
    if found != expected {
        let what = match shared {
            Shared::Each(_) => "a share of each material of the table",
            Shared::Labelled(_) => "a label and its share",
        };
        return Err(MaterialError::Components { found, expected, what });
    }
    let Values::U8(values) = shares.values() else {
        let found = shares.values().value_type().name();
        return Err(MaterialError::Type { found });
    };
    let materials = shared.materials();
    let tau_max = materials
        .iter()
        .fold(0.0, |most: f64, material| most.max(material.extinction));
    let codes: Vec<Codes> = materials.iter().map(|material| codes_of(material, tau_max)).collect();
    let place = |index: usize| {
        let [x, y, _] = shares.dims();
        [index % x, index / x % y, index / x / y]
    };
    let each = |index: usize, shares: &[u8]| {
        let sum: u32 = shares.iter().copied().map(u32::from).sum();
        if sum > WHOLE {
            return Err(MaterialError::Sum {
                voxel: place(index),
                sum,
            });
        }
        let mut sums = [0; 4];
        for (share, codes) in shares.iter().zip(&codes) {
            for (sum, code) in sums.iter_mut().zip(codes) {
                *sum += u32::from(*share) * u32::from(*code);
            }
        }
        Ok(mixed(sums))
    };
    // The codes of every label.
    let mut known = [None; 256];
    known[0] = Some([0; 4]);
    if let Shared::Labelled(labelled) = shared {
        for ((label, _), codes) in labelled.iter().zip(&codes) {
            known[usize::from(*label)] = Some(*codes);
        }
    }
    let labelled = |index: usize, label: u8, share: u8| match known[usize::from(label)] {
        Some(codes) => Ok(mixed(codes.map(|code| u32::from(share) * u32::from(code)))),
        None => Err(MaterialError::Label {
            voxel: place(index),
            label,
        }),
    };
    let voxels = values.chunks_exact(found).enumerate();
    let voxels: Result<Vec<Codes>, MaterialError> = match shared {
        Shared::Each(_) => voxels.map(|(index, shares)| each(index, shares)).collect(),
        Shared::Labelled(_) => voxels.map(|(index, pair)| labelled(index, pair[0], pair[1])).collect(),
    };
    Ok(RgbaVolume {
        name: shares.name().to_owned(),
        dims: shares.dims(),
        spacing: shares.spacing(),
        orientation: shares.orientation().clone(),
        tau_max,
        alpha_distance: None,
        voxels: Voxels::Codes(voxels?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn volume(components: usize, values: Vec<u8>) -> Colours {
        let len = values.len() / components;
        Colours::new("made".into(), [len, 1, 1], [1.0; 3], components, Values::U8(values)).unwrap()
    }

    fn material(colour: [u8; 3], extinction: f64) -> Material {
        Material { colour, extinction }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

        /// Against the mixture in real numbers; the order of codes; a whole voxel of one material.
        #[test]
        fn mixtures_are_as_near_as_stated(
            table in prop::collection::vec((any::<[u8; 3]>(), prop_oneof![Just(0.0), 0.0f64..9.0]), 1..=8),
            shares in prop::collection::vec(any::<u8>(), 8),
            whole in 0usize..8,
        ) {
            let mut table: Vec<Material> = table.into_iter().map(|(colour, tau)| material(colour, tau)).collect();
            table[0].extinction += 0.01;
            let count = table.len();
            // As many of the shares as fit.
            let mut left = 255u8;
            let mut values: Vec<u8> = shares[..count].iter().map(|share| { let p = (*share).min(left); left -= p; p }).collect();
            let mixture = values.clone();
            values.extend((0..count).map(|i| if i == whole % count { 255 } else { 0 }));
            let made = of_shares(&volume(count, values), &Shared::Each(table.clone())).unwrap();
            let real = |k: usize| {
                let of = |m: &Material| m.extinction * if k < 3 { f64::from(m.colour[k]) / 255.0 } else { 1.0 };
                let sum: f64 = mixture.iter().zip(&table).map(|(p, m)| f64::from(*p) * of(m)).sum();
                sum / 255.0 / made.tau_max * 32767.0
            };
            let codes = made.voxels.codes(0);
            for k in 0..4 {
                prop_assert!((f64::from(codes[k]) - real(k)).abs() <= if k < 3 { 2.5 } else { 1.5 }, "{k}: {codes:?}");
                prop_assert!(codes[k] <= codes[3]);
            }
            prop_assert_eq!(made.voxels.codes(1), codes_of(&table[whole % count], made.tau_max));
        }
    }

    #[test]
    fn labels_are_materials_in_parts() {
        let table = vec![(7, material([255, 0, 128], 3.0)), (2, material([10, 20, 30], 1.5))];
        let values = vec![0, 255, 7, 255, 2, 255, 7, 0, 7, 51];
        let made = of_shares(&volume(2, values), &Shared::Labelled(table)).unwrap();
        assert_eq!(made.tau_max, 3.0);
        let codes: Vec<Codes> = (0..5).map(|index| made.voxels.codes(index)).collect();
        assert_eq!(codes[0], [0; 4]);
        assert_eq!(codes[1], [32767, 0, 16447, 32767]);
        assert_eq!((codes[2][3], codes[3]), (16384, [0; 4]));
        // A fifth.
        assert_eq!((codes[4][3], codes[4][0]), (6553, 6553));
    }

    #[test]
    fn what_are_no_shares_is_refused_with_its_place() {
        let two = Shared::Each(vec![material([9; 3], 1.0); 2]);
        let one = Shared::Labelled(vec![(3, material([9; 3], 1.0))]);
        let refused = |shares: &Colours, shared: &Shared| of_shares(shares, shared).unwrap_err().to_string();
        assert_eq!(
            refused(&volume(2, vec![1, 254, 200, 56]), &two),
            "voxel (1, 0, 0) has shares that add up to 256, expected at most 255"
        );
        assert_eq!(
            refused(&volume(3, vec![0; 3]), &two),
            "has 3 values a voxel, expected 2: a share of each material of the table"
        );
        assert_eq!(
            refused(&volume(1, vec![0; 3]), &one),
            "has 1 values a voxel, expected 2: a label and its share"
        );
        assert_eq!(
            refused(&volume(2, vec![3, 0, 4, 0]), &one),
            "voxel (1, 0, 0) has the label 4, expected 0 or one of the table of materials"
        );
        let wide = Colours::new("made".into(), [1; 3], [1.0; 3], 2, Values::U16(vec![0, 0])).unwrap();
        assert_eq!(
            refused(&wide, &two),
            "has shares of type uint16, expected uint8: 255ths of a voxel"
        );
    }
}
