//! What the choice of a mapping asks of a volume's stored values, wherever they are.

use std::collections::BTreeMap;

use super::{labels, outliers};
use crate::values::{Modality, ValueType, Values};

/// What stored values mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meaning {
    /// Their number type.
    pub value_type: ValueType,
    /// What to multiply a stored value by to get the data's unit; above 0.
    pub scale: f64,
    /// What to add then.
    pub offset: f64,
    /// What made them.
    pub modality: Option<Modality>,
    /// The window that the file asks for, in the data's unit.
    pub stated_window: Option<[f64; 2]>,
}

impl Meaning {
    /// A stored value in the data's unit.
    pub fn data(&self, stored: f64) -> f64 {
        stored * self.scale + self.offset
    }

    /// Whether the values are stored as integers.
    pub const fn has_integers(&self) -> bool {
        !matches!(self.value_type, ValueType::F32 | ValueType::F64)
    }
}

/// All stored values of a volume, counted.
pub(crate) trait Census {
    /// How many there are.
    fn count(&self) -> u64;
    /// Whether all are whole numbers that doubles tell apart.
    fn is_whole(&self) -> bool;
    /// The least and the greatest; 0, 0 of none.
    fn range(&self) -> [f64; 2];
    /// The values at two ranks, counted from 0.
    fn at_ranks(&self, ranks: [u64; 2]) -> [f64; 2];
    /// The least and the greatest between two bounds.
    fn within(&self, bounds: [f64; 2]) -> [f64; 2];
    /// How often each whole value occurs; `None` if more than `most` differ.
    fn counts(&self, most: usize) -> Option<BTreeMap<i64, u64>>;
    /// Whether most neighbours along x, of which neither is `background`, are equal.
    fn is_flat(&self, background: f64) -> bool;
}

/// Values in memory, in rows of `width`.
pub(super) struct InMemory<'v> {
    /// All of them.
    pub values: &'v Values,
    /// Of a row.
    pub width: usize,
}

impl Census for InMemory<'_> {
    fn count(&self) -> u64 {
        self.values.len() as u64
    }

    fn is_whole(&self) -> bool {
        self.values.are_whole()
    }

    fn range(&self) -> [f64; 2] {
        let mut range = None;
        self.values.for_each(|value| {
            let [low, high] = range.unwrap_or([value; 2]);
            range = Some([value.min(low), value.max(high)]);
            true
        });
        range.unwrap_or([0.0; 2])
    }

    fn at_ranks(&self, ranks: [u64; 2]) -> [f64; 2] {
        outliers::at_ranks(self.values, ranks.map(|rank| rank as usize))
    }

    fn within(&self, bounds: [f64; 2]) -> [f64; 2] {
        outliers::within(self.values, bounds)
    }

    fn counts(&self, most: usize) -> Option<BTreeMap<i64, u64>> {
        labels::count(self.values, most)
    }

    fn is_flat(&self, background: f64) -> bool {
        labels::is_flat(self.values, self.width, background)
    }
}
