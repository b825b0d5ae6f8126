//! What a volume's values are like: the histogram of its codes and what can be told from it.

use super::Volume;

/// The histogram of a volume's codes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statistics {
    counts: Vec<u64>,
    total: u64,
}

impl Statistics {
    /// How many codes there are.
    pub const CODES: usize = 4096;

    /// Of voxels that have been counted, by code.
    pub(super) fn from_counts(counts: Vec<u64>) -> Self {
        Self {
            total: counts.iter().sum(),
            counts,
        }
    }

    /// Counts a volume's voxels.
    pub fn of(volume: &Volume) -> Self {
        let mut counts = vec![0; Self::CODES];
        for &code in &volume.voxels {
            if let Some(count) = counts.get_mut(usize::from(code)) {
                *count += 1;
            }
        }
        Self::from_counts(counts)
    }

    /// Voxels of every code.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// The least and the greatest code that occur; 0, 0 of no voxels.
    pub fn range(&self) -> [usize; 2] {
        let first = self.counts.iter().position(|&count| count > 0);
        let last = self.counts.iter().rposition(|&count| count > 0);
        [first.unwrap_or(0), last.unwrap_or(0)]
    }

    /// The least code that is not below `fraction` (0 to 1) of the voxels.
    pub fn percentile(&self, fraction: f64) -> usize {
        let rank = (fraction * self.total as f64).ceil().max(1.0);
        let mut seen = 0.0;
        for (code, &count) in self.counts.iter().enumerate() {
            seen += count as f64;
            if seen >= rank {
                return code;
            }
        }
        Self::CODES - 1
    }

    /// The code from which on voxels differ most from those below it, among codes of `first` and above (Otsu: the
    /// threshold of greatest variance between the two classes). `first` if only one code occurs there.
    pub fn split(&self, first: usize) -> usize {
        let part = self.counts.get(first..).unwrap_or(&[]);
        let weigh = |(i, &count): (usize, &u64)| (first + i) as f64 * count as f64;
        let voxels: f64 = part.iter().map(|&count| count as f64).sum();
        let sum: f64 = part.iter().enumerate().map(weigh).sum();
        let (mut below, mut sum_below) = (0.0, 0.0);
        // The best threshold and its variance; a flat top counts in its middle, which is the valley between two peaks.
        let (mut best, mut from, mut to) = (0.0, first, first);
        for (i, &count) in part.iter().enumerate() {
            if below > 0.0 && below < voxels {
                let apart = sum_below / below - (sum - sum_below) / (voxels - below);
                let variance = below * (voxels - below) * apart * apart;
                if variance > best * (1.0 + 1e-9) {
                    (best, from, to) = (variance, first + i, first + i);
                } else if variance >= best * (1.0 - 1e-9) && to + 1 == first + i {
                    to = first + i;
                }
            }
            below += count as f64;
            sum_below += (first + i) as f64 * count as f64;
        }
        from.midpoint(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mapping;

    fn statistics(voxels: &[u16]) -> Statistics {
        Statistics::of(&Volume {
            name: "t".into(),
            dims: [voxels.len(), 1, 1],
            spacing: [1.0; 3],
            voxels: voxels.to_vec(),
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        })
    }

    #[test]
    fn two_peaks_are_split_in_the_valley() {
        let s = statistics(&[10, 10, 11, 12, 90, 91, 91]);
        assert_eq!(s.split(0), usize::midpoint(13, 90));
        assert_eq!(s.range(), [10, 91]);
        assert_eq!(s.split(91), 91);
        assert_eq!(statistics(&[7; 4]).split(0), 0);
    }

    #[test]
    fn percentiles_are_codes_that_occur() {
        let s = statistics(&[1, 2, 3, 4]);
        assert_eq!([0.0, 0.25, 0.5, 0.51, 1.0].map(|p| s.percentile(p)), [1, 1, 2, 3, 4]);
    }
}
