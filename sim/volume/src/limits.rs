//! Limits of what is read.

/// Voxels that a volume may have along one axis.
pub const MAX_AXIS: usize = 8192;

/// Voxels that a volume may have in all (2^31, which is 4 GiB of 12-bit voxels).
pub const MAX_VOXELS: u64 = 1 << 31;

/// The shortest distance between voxels; squares and products of shorter ones leave the range of numbers.
pub const MIN_SPACING: f64 = 1e-30;

/// The longest distance between voxels.
pub const MAX_SPACING: f64 = 1e30;

/// Bytes that the stored values of a packed or decoded volume may take (4 GiB). Plain data may take what their file has.
pub const MAX_BYTES: u64 = 1 << 32;
