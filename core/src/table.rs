//! The shape of a look-up table over 12-bit codes.

/// Entries of a table: one for each 12-bit code.
pub const ENTRIES: usize = 4096;

/// A value a code, and one more behind the last for its neighbour.
pub type Neighboured = [u32; ENTRIES + 1];

/// How samples find their codes: `(sample + offset) >> bits`, of which the low 12 bits count. Samples are 0 to 2^28, offsets
/// below 2^15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coding {
    /// What is added before the fraction is cut off.
    pub offset: i32,
    /// Bits of the fraction.
    pub bits: u32,
}
