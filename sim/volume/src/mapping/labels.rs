//! Label maps: volumes whose values are names, not measurements.
//!
//! A volume is a label map if its values are whole, the least is 0, and either
//!
//! * the file stores integers of which at most 64 differ, and more than 0.3 of the voxels are 0; or
//! * at most 4096 values differ, and of the neighbours along x of which neither is 0 more than half are equal. Of the
//!   developers' volumes, label maps have 0.80 to 0.99, images 0.03 to 0.32 (`host-tests/peers/value_tails.py`).
//!
//! CT and MR are never label maps. Labels above 4095 would lose their identity in 12 bits: they become codes 0, 1, 2, … in
//! ascending order.

use std::collections::BTreeMap;

use super::census::Census;
use crate::meaning::Meaning;
use crate::meaning::Modality;
use crate::values::Values;

/// Integers that may differ in any volume that is mostly 0.
const FEW: usize = 64;

/// Labels that codes can tell apart.
const MOST: usize = 4096;

/// The share of voxels that are 0 where [`FEW`] values differ.
const BACKGROUND: f64 = 0.3;

/// The share of equal neighbours inside a label map.
const FLAT: f64 = 0.5;

/// A label of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Label {
    /// The code of its voxels.
    pub code: u16,
    /// The label as the file states it.
    pub value: f64,
    /// How many voxels have it.
    pub voxels: u64,
}

/// The labels of a volume, in ascending order of code and of value; the background, 0, is the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    entries: Vec<Label>,
    renumbered: bool,
}

impl Labels {
    /// Every label that occurs.
    pub fn entries(&self) -> &[Label] {
        &self.entries
    }

    /// Whether codes count labels; otherwise the volume's [`Mapping`](crate::Mapping) leads from codes to labels.
    pub const fn renumbered(&self) -> bool {
        self.renumbered
    }

    /// The label of a code; `None` if no voxel has the code.
    pub fn of(&self, code: u16) -> Option<f64> {
        let found = self.entries.binary_search_by_key(&code, |label| label.code);
        found
            .ok()
            .and_then(|index| self.entries.get(index))
            .map(|label| label.value)
    }

    /// The code of a label as the file states it.
    pub fn code_of(&self, value: f64) -> Option<u16> {
        let found = self.entries.binary_search_by(|label| label.value.total_cmp(&value));
        found
            .ok()
            .and_then(|index| self.entries.get(index))
            .map(|label| label.code)
    }

    /// The same labels with the codes that `code` gives to their values; `None` if not every label has one of its own.
    pub(super) fn recoded(&self, code: impl Fn(f64) -> Option<u16>) -> Option<Self> {
        let recoded = |label: &Label| {
            let code = code(label.value)?;
            Some(Label { code, ..*label })
        };
        let entries: Vec<Label> = self.entries.iter().map(recoded).collect::<Option<_>>()?;
        let apart = entries.windows(2).all(|pair| pair[0].code < pair[1].code);
        apart.then_some(Self {
            entries,
            renumbered: false,
        })
    }

    /// The labels of a volume, if it is a label map; `code` is the linear code of a label, where there is one for each.
    pub(super) fn detect(
        meaning: &Meaning,
        census: &dyn Census,
        is_whole: bool,
        code: impl Fn(f64) -> Option<u16>,
    ) -> Option<Self> {
        let image = matches!(meaning.modality, Some(Modality::Ct | Modality::Mr));
        if image || !is_whole || meaning.scale != 1.0 {
            return None;
        }
        let shift = meaning.offset;
        let flat = census.is_flat(-shift);
        let counts = census.counts(if flat { MOST } else { FEW })?;
        let (&least, &background) = counts.first_key_value()?;
        let mostly_background = background as f64 > BACKGROUND * census.count() as f64;
        let few = meaning.has_integers() && counts.len() <= FEW && mostly_background;
        if least as f64 + shift != 0.0 || counts.len() < 2 || !(flat || few) {
            return None;
        }
        let linear: Option<Vec<u16>> = counts.keys().map(|&stored| code(stored as f64)).collect();
        let renumbered = linear.is_none();
        let codes = linear.unwrap_or_else(|| (0..=u16::MAX).take(counts.len()).collect());
        let entries = counts.iter().zip(codes).map(|((&stored, &voxels), code)| Label {
            code,
            value: stored as f64 + shift,
            voxels,
        });
        Some(Self {
            entries: entries.collect(),
            renumbered,
        })
    }
}

/// Whether so many equal pairs of so many make a label map.
pub(crate) fn are_flat(equal: u64, pairs: u64) -> bool {
    pairs > 0 && equal as f64 > FLAT * pairs as f64
}

/// Whether most neighbours along x, of which neither is background, are equal.
pub(super) fn is_flat(values: &Values, width: usize, background: f64) -> bool {
    let (mut pairs, mut equal) = (0_u64, 0_u64);
    let mut before = background;
    let mut x = 0;
    values.for_each(|value| {
        if x > 0 && value != background && before != background {
            pairs += 1;
            equal += u64::from(value == before);
        }
        before = value;
        x = if x + 1 == width { 0 } else { x + 1 };
        true
    });
    are_flat(equal, pairs)
}

/// How often each whole value occurs; `None` if more than `most` differ.
pub(super) fn count(values: &Values, most: usize) -> Option<BTreeMap<i64, u64>> {
    let mut counts = BTreeMap::new();
    // Equal voxels follow each other: each run is looked up once.
    let mut run: Option<(f64, u64)> = None;
    values.for_each(|value| {
        match &mut run {
            Some((of, len)) if *of == value => *len += 1,
            _ => {
                if let Some((of, len)) = run.replace((value, 1)) {
                    *counts.entry(of as i64).or_insert(0) += len;
                }
            }
        }
        counts.len() <= most
    });
    if let Some((of, len)) = run {
        *counts.entry(of as i64).or_insert(0) += len;
    }
    (counts.len() <= most).then_some(counts)
}
