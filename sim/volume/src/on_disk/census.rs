//! The census of values that stay in their files: slice by slice or chunk by chunk, in parallel.
//!
//! Values of 8 and 16 bits are counted once, each on its own; what is asked then costs nothing. Of others every question
//! is a pass over the file, and a rank is four.

use std::collections::BTreeMap;
use std::sync::Mutex;

use rayon::prelude::*;

use super::pairs::{Pairs, face, far_face};
use super::store::{Region, Store};
use super::strips;
use crate::error::{Problem, ReadError, ShapeError};
use crate::mapping::census::Census;
use crate::mapping::labels::are_flat;
use crate::values::Values;

/// What is told how many blocks of how many are done.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// Blocks that a thread reads after one another where neighbours count, of a file that has others to read beside.
const RUN: usize = 8;

/// A block of the file, as a pass sees it.
pub(super) struct Block {
    pub number: usize,
    pub region: Region,
    pub values: Values,
    /// The values beside its near face along the axis of the pass, if it has one and there are any.
    pub before: Option<Values>,
}

/// Does something with each block of the file, as it comes, and joins what comes of it. Along `axis`, if it is one, blocks come
/// with what lies before them; a block is read once for that, but for the first of a run of plain ones.
pub(super) fn each_block<T: Send>(
    store: &Store,
    axis: Option<usize>,
    progress: Progress<'_>,
    none: impl Fn() -> T + Sync,
    take: impl Fn(T, Block) -> Result<T, ReadError> + Sync,
    join: impl Fn(T, T) -> T + Sync,
) -> Result<T, ReadError> {
    let blocks = store.blocks();
    let along = axis.map_or(1, |axis| blocks.counts()[axis]);
    let run_len = if store.is_plain() { RUN.min(along) } else { along };
    let done = std::sync::atomic::AtomicUsize::new(0);
    // A run begins with every block that has a multiple of its length before it.
    let starts = |number: &usize| axis.is_none_or(|axis| blocks.place(*number)[axis].is_multiple_of(run_len));
    let run = |taken: Result<T, ReadError>, number: usize| {
        let (mut taken, mut before) = (taken?, None);
        let mut place = blocks.place(number);
        let end = axis.map_or(0, |axis| (place[axis] + run_len).min(blocks.counts()[axis]));
        loop {
            let region = blocks.region(place);
            if let Some(axis) = axis.filter(|&axis| before.is_none() && region.first[axis] > 0) {
                before = Some(store.read(face(region, axis, region.first[axis] - 1))?);
            }
            let values = store.read(region)?;
            let next = axis.filter(|&axis| place[axis] + 1 < end);
            let last = next.map(|axis| far_face(&values, region.dims, axis));
            let number = blocks.number(place);
            let block = Block {
                number,
                region,
                values,
                before,
            };
            taken = take(taken, block)?;
            progress(
                done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1,
                blocks.len(),
            );
            before = last;
            match next {
                Some(axis) => place[axis] += 1,
                None => return Ok(taken),
            }
        }
    };
    let both = |a: Result<T, ReadError>, b: Result<T, ReadError>| Ok(join(a?, b?));
    (0..blocks.len())
        .into_par_iter()
        .filter(starts)
        .fold(|| Ok(none()), run)
        .reduce(|| Ok(none()), both)
}

/// How often each value of 8 or 16 bits occurs.
pub(super) struct Histogram {
    /// By value, the least one first.
    counts: Vec<u64>,
    /// The value of the first of them.
    first: i32,
    pairs: Pairs,
    /// Of each block, as they came.
    pub strips: Measured,
}

/// Blocks by number, and the least and greatest value of their strips.
pub(super) type Measured = Vec<(usize, Vec<[f64; 2]>)>;

/// What is counted of some blocks.
type Counts = (Vec<u64>, Pairs, Option<i32>, Measured);

/// Values of 16 bits, and of fewer.
const NARROW: usize = 1 << 16;

impl Histogram {
    /// Counts the values; `axis` is that of the file along which the volume's rows run, `background` the value that labels
    /// do not count. `None` of values of more bits.
    ///
    /// # Errors
    /// [`ReadError`] if a file cannot be read.
    pub fn of(store: &Store, axis: usize, background: f64, progress: Progress<'_>) -> Result<Option<Self>, ReadError> {
        let strip_len = strips::cut(store).side.iter().product();
        let none = || (vec![0_u64; NARROW], Pairs::default(), None, Vec::new());
        let take = |(mut counts, pairs, _, mut strips): Counts, block: Block| {
            strips.push((block.number, strips::measured(&block.values, strip_len)));
            macro_rules! count {
                ($kind:ident, $type:ty, $values:expr) => {{
                    for &value in $values {
                        counts[(i32::from(value) - i32::from(<$type>::MIN)) as usize] += 1;
                    }
                    let before: &[$type] = match &block.before {
                        Some(Values::$kind(before)) => before,
                        _ => &[],
                    };
                    let exact = background as $type;
                    let background = (f64::from(exact) == background).then_some(exact);
                    let of_block = Pairs::of($values, before, block.region.dims, axis, background);
                    Ok((
                        counts,
                        pairs.with(of_block),
                        Some(i32::from(<$type>::MIN)),
                        strips,
                    ))
                }};
            }
            match &block.values {
                Values::I8(v) => count!(I8, i8, v),
                Values::U8(v) => count!(U8, u8, v),
                Values::I16(v) => count!(I16, i16, v),
                Values::U16(v) => count!(U16, u16, v),
                _ => Ok((counts, pairs, None, strips)),
            }
        };
        let join = |(mut counts, pairs, first, mut strips): Counts, (others, more, other, others_strips): Counts| {
            counts.iter_mut().zip(others).for_each(|(count, other)| *count += other);
            strips.extend(others_strips);
            (counts, pairs.with(more), first.or(other), strips)
        };
        let (counts, pairs, first, strips) = each_block(store, Some(axis), progress, none, take, join)?;
        Ok(first.map(|first| Self {
            counts,
            first,
            pairs,
            strips,
        }))
    }

    /// Every value that occurs, the least one first, and how often it does.
    pub fn entries(&self) -> impl DoubleEndedIterator<Item = (f64, u64)> {
        let value = |index: usize| f64::from(self.first + index as i32);
        let entries = self.counts.iter().enumerate();
        entries
            .filter(|(_, count)| **count > 0)
            .map(move |(index, &count)| (value(index), count))
    }
}

impl Census for Histogram {
    fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    fn is_whole(&self) -> bool {
        true
    }

    fn range(&self) -> [f64; 2] {
        let (first, last) = (self.entries().next(), self.entries().next_back());
        [first, last].map(|entry| entry.map_or(0.0, |(value, _)| value))
    }

    fn at_ranks(&self, ranks: [u64; 2]) -> [f64; 2] {
        ranks.map(|rank| {
            let mut seen = 0;
            let found = self.entries().find(|(_, count)| {
                seen += count;
                seen > rank
            });
            found.map_or(self.range()[1], |(value, _)| value)
        })
    }

    fn within(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let inside = || self.entries().filter(|(value, _)| (low..=high).contains(value));
        [
            inside().next().map_or(f64::INFINITY, |(value, _)| value),
            inside().next_back().map_or(f64::NEG_INFINITY, |(value, _)| value),
        ]
    }

    fn counts(&self, most: usize) -> Option<BTreeMap<i64, u64>> {
        let differ = self.counts.iter().filter(|count| **count > 0).count();
        (differ <= most).then(|| self.entries().map(|(value, count)| (value as i64, count)).collect())
    }

    fn is_flat(&self, _background: f64) -> bool {
        are_flat(self.pairs.equal, self.pairs.all)
    }
}

/// Values of more bits: every question reads the file.
pub(super) struct Passes<'s> {
    store: &'s Store,
    /// The file's axis along which the volume's rows run.
    axis: usize,
    range: [f64; 2],
    is_whole: bool,
    strips: Measured,
    progress: Progress<'s>,
    /// The first pass that failed; later ones are not begun.
    failed: Mutex<Option<ReadError>>,
}

/// A number whose order as a whole number is that of the doubles.
fn key(value: f64) -> u64 {
    // Both zeros are one value.
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// The double of a [`key`].
fn of_key(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}

impl<'s> Passes<'s> {
    /// Looks at every value once.
    ///
    /// # Errors
    /// [`ReadError`] if a file cannot be read or a value is not finite.
    pub fn new(store: &'s Store, axis: usize, progress: Progress<'s>) -> Result<Self, ReadError> {
        let strip_len = strips::cut(store).side.iter().product();
        type Looked = ([f64; 2], bool, Measured);
        let none = || ([f64::INFINITY, f64::NEG_INFINITY], true, Vec::new());
        let take = |(mut range, is_whole, mut strips): Looked, block: Block| {
            if let Some((index, value)) = block.values.first_not_finite() {
                let ([nx, ny, _], [x, y, z]) = (block.region.dims, block.region.first);
                let voxel = [x + index % nx, y + index / nx % ny, z + index / nx / ny];
                return Err(ReadError::new(store.path(), ShapeError::NotFinite { voxel, value }));
            }
            let measured = strips::measured(&block.values, strip_len);
            for [low, high] in &measured {
                range = [range[0].min(*low), range[1].max(*high)];
            }
            strips.push((block.number, measured));
            Ok((range, is_whole && block.values.are_whole(), strips))
        };
        let join = |(a, whole, mut strips): Looked, (b, other, others): Looked| {
            strips.extend(others);
            ([a[0].min(b[0]), a[1].max(b[1])], whole && other, strips)
        };
        let (range, is_whole, strips) = each_block(store, None, progress, none, take, join)?;
        Ok(Self {
            store,
            axis,
            range,
            is_whole,
            strips,
            progress,
            failed: Mutex::new(None),
        })
    }

    /// The strips that were measured.
    ///
    /// # Errors
    /// What went wrong in a pass, if anything did: what was answered is then worth nothing.
    pub fn end(self) -> Result<Measured, ReadError> {
        let failed = self
            .failed
            .into_inner()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        failed.map_or(Ok(self.strips), Err)
    }

    /// A pass; nothing of one that fails.
    fn pass<T: Send>(
        &self,
        axis: Option<usize>,
        none: impl Fn() -> T + Sync,
        take: impl Fn(T, Block) -> Result<T, ReadError> + Sync,
        join: impl Fn(T, T) -> T + Sync,
    ) -> T {
        let mut failed = self.failed.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if failed.is_some() {
            return none();
        }
        match each_block(self.store, axis, self.progress, &none, take, join) {
            Ok(taken) => taken,
            Err(error) => {
                *failed = Some(error);
                none()
            }
        }
    }
}

impl Census for Passes<'_> {
    fn count(&self) -> u64 {
        self.store.dims().iter().map(|&side| side as u64).product()
    }

    fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn range(&self) -> [f64; 2] {
        self.range
    }

    fn at_ranks(&self, ranks: [u64; 2]) -> [f64; 2] {
        let (mut prefixes, mut ranks) = ([0_u64; 2], ranks.map(|rank| rank.min(self.count().saturating_sub(1))));
        for shift in [48, 32, 16, 0] {
            let none = || [(); 2].map(|()| vec![0_u64; NARROW]);
            let take = |mut counts: [Vec<u64>; 2], block: Block| {
                block.values.for_each(|value| {
                    let key = key(value);
                    for (counts, prefix) in counts.iter_mut().zip(prefixes) {
                        if shift == 48 || key >> (shift + 16) == prefix {
                            counts[(key >> shift) as usize & (NARROW - 1)] += 1;
                        }
                    }
                    true
                });
                Ok(counts)
            };
            let join = |mut a: [Vec<u64>; 2], b: [Vec<u64>; 2]| {
                for (a, b) in a.iter_mut().zip(b) {
                    a.iter_mut().zip(b).for_each(|(count, other)| *count += other);
                }
                a
            };
            let counts = self.pass(None, none, take, join);
            for ((counts, prefix), rank) in counts.iter().zip(&mut prefixes).zip(&mut ranks) {
                let bin = counts.iter().position(|&count| {
                    let here = *rank < count;
                    *rank -= if here { 0 } else { count };
                    here
                });
                *prefix = *prefix << 16 | bin.unwrap_or(0) as u64;
            }
        }
        prefixes.map(of_key)
    }

    fn within(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let none = || [f64::INFINITY, f64::NEG_INFINITY];
        let take = |mut range: [f64; 2], block: Block| {
            block.values.for_each(|value| {
                if (low..=high).contains(&value) {
                    range = [range[0].min(value), range[1].max(value)];
                }
                true
            });
            Ok(range)
        };
        self.pass(None, none, take, |a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    fn counts(&self, most: usize) -> Option<BTreeMap<i64, u64>> {
        let take = |counts: Option<BTreeMap<i64, u64>>, block: Block| {
            let Some(mut counts) = counts else { return Ok(None) };
            block.values.for_each(|value| {
                *counts.entry(value as i64).or_insert(0) += 1;
                counts.len() <= most
            });
            Ok((counts.len() <= most).then_some(counts))
        };
        let join = |a: Option<BTreeMap<i64, u64>>, b: Option<BTreeMap<i64, u64>>| {
            let (mut a, b) = (a?, b?);
            for (value, count) in b {
                *a.entry(value).or_insert(0) += count;
            }
            (a.len() <= most).then_some(a)
        };
        self.pass(None, || Some(BTreeMap::new()), take, join)
    }

    fn is_flat(&self, background: f64) -> bool {
        let doubles = |values: &Values| {
            let mut doubles = Vec::with_capacity(values.len());
            values.for_each(|value| {
                doubles.push(value);
                true
            });
            doubles
        };
        let take = |pairs: Pairs, block: Block| {
            let before = block.before.as_ref().map_or(Vec::new(), doubles);
            let (values, dims) = (doubles(&block.values), block.region.dims);
            Ok(pairs.with(Pairs::of(&values, &before, dims, self.axis, Some(background))))
        };
        let pairs = self.pass(Some(self.axis), Pairs::default, take, Pairs::with);
        are_flat(pairs.equal, pairs.all)
    }
}

/// Refuses NaN where it was to be background: which value that is, is known when all have been read.
pub(super) fn background_needs_all(error: ReadError) -> ReadError {
    match &error.problem {
        Problem::Shape(ShapeError::NotFinite { voxel, value }) if value.is_nan() => {
            let [x, y, z] = voxel;
            let fault =
                format!("voxel ({x}, {y}, {z}) is NaN, expected finite numbers where a volume is read in parts");
            ReadError {
                problem: Problem::format("--nan background", fault),
                path: error.path,
            }
        }
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_in_the_order_of_doubles() {
        let values = [
            f64::MIN,
            -1e300,
            -2.5,
            -1.0,
            -f64::MIN_POSITIVE,
            0.0,
            5e-324,
            0.1,
            1.0,
            3e9,
            f64::MAX,
        ];
        for pair in values.windows(2) {
            assert!(key(pair[0]) < key(pair[1]), "{pair:?}");
        }
        for value in values {
            assert_eq!(of_key(key(value)), value);
        }
        assert_eq!(key(-0.0), key(0.0));
    }
}
