//! What the choice of a mapping asks of a volume's stored values, wherever they are.

use std::collections::BTreeMap;

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
