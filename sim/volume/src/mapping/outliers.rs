//! Which values lie so far out that they must not decide the mapping: one hot pixel would leave the rest one code.

use std::cmp::Ordering;

use super::census::Census;
use crate::values::Values;

/// The share of the voxels, at each end, that may be outliers; at least one voxel may.
const SHARE: f64 = 1e-4;

/// Fewer voxels have no outliers: one of them is no exception.
const LEAST_VOXELS: u64 = 1000;

/// How many times the range of the other voxels an outlier lies beyond them.
///
/// Of the developers' volumes the farthest tail reaches 0.93 times (and that of vessels 0.51 times) beyond the middle
/// 99.98 % of the voxels; a hot voxel in a head reaches 53 times (`host-tests/peers/value_tails.py`).
const DISTANCE: f64 = 2.0;

/// Least and greatest of the stored values that are no outliers; `range` is that of all.
///
/// In a volume of at least [`LEAST_VOXELS`], an outlier is one of at most [`SHARE`] of the voxels at its end and lies beyond all others by more than [`DISTANCE`]
/// times their range.
pub(super) fn inliers(census: &dyn Census, range: [f64; 2]) -> [f64; 2] {
    let count = census.count();
    if count < LEAST_VOXELS {
        return range;
    }
    let rank = ((SHARE * count as f64) as u64).max(1);
    let [low, high] = census.at_ranks([rank, count - 1 - rank]);
    let reach = DISTANCE * (high - low);
    // All but the ends have one value: the ends are the data.
    if reach == 0.0 || (range[0] >= low - reach && range[1] <= high + reach) {
        return range;
    }
    census.within([low - reach, high + reach])
}

/// The stored values at two ranks, counted from 0.
pub(super) fn at_ranks(values: &Values, ranks: [usize; 2]) -> [f64; 2] {
    fn select<T: Copy>(values: &[T], ranks: [usize; 2], order: impl Fn(&T, &T) -> Ordering) -> Option<[T; 2]> {
        let mut copy = values.to_vec();
        let last = copy.len().checked_sub(1)?;
        Some(ranks.map(|rank| *copy.select_nth_unstable_by(rank.min(last), &order).1))
    }
    let found = match values {
        Values::I8(v) => select(v, ranks, i8::cmp).map(|r| r.map(f64::from)),
        Values::U8(v) => select(v, ranks, u8::cmp).map(|r| r.map(f64::from)),
        Values::I16(v) => select(v, ranks, i16::cmp).map(|r| r.map(f64::from)),
        Values::U16(v) => select(v, ranks, u16::cmp).map(|r| r.map(f64::from)),
        Values::I32(v) => select(v, ranks, i32::cmp).map(|r| r.map(f64::from)),
        Values::U32(v) => select(v, ranks, u32::cmp).map(|r| r.map(f64::from)),
        Values::F32(v) => select(v, ranks, f32::total_cmp).map(|r| r.map(f64::from)),
        Values::F64(v) => select(v, ranks, f64::total_cmp),
    };
    found.unwrap_or([0.0; 2])
}

/// Least and greatest of the values between two bounds.
pub(super) fn within(values: &Values, [low, high]: [f64; 2]) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    values.for_each(|value| {
        if (low..=high).contains(&value) {
            range = [range[0].min(value), range[1].max(value)];
        }
        true
    });
    range
}
