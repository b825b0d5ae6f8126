//! The census of values in memory.

use std::collections::BTreeMap;

use super::census::Census;
use super::{labels, outliers};
use crate::values::Values;

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
