//! A checksum of words.

/// A running checksum: `h = (rotate_left(h, 5) ^ word) * 0x9e3779b1`.
///
/// For a given word the step is one to one in `h`, and for a given `h` it is one to one in the word, so two streams
/// that differ in exactly one word always have different sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sum(u32);

impl Sum {
    /// The sum of nothing.
    pub const fn new() -> Self {
        Self(0)
    }

    /// Takes one more word.
    #[inline]
    pub const fn word(&mut self, word: u32) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b1);
    }

    /// Takes a row of words, its length first.
    #[inline]
    pub fn row(&mut self, words: impl ExactSizeIterator<Item = u32>) {
        self.word(words.len() as u32);
        for word in words {
            self.word(word);
        }
    }

    /// The sum so far.
    pub const fn get(self) -> u32 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::Sum;

    fn sum(words: [u32; 3]) -> u32 {
        let mut sum = Sum::default();
        sum.row(words.into_iter());
        sum.get()
    }

    #[test]
    fn one_changed_bit_changes_the_sum() {
        let words = [1, 0x8000_0000, 77];
        for place in 0..3 {
            for bit in 0..32 {
                let mut changed = words;
                changed[place] ^= 1 << bit;
                assert_ne!(sum(words), sum(changed));
            }
        }
    }
}
