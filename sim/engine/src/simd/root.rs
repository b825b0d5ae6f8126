//! What the vectors' reciprocal roots share (`slicecast::root::reciprocal_root`).
//!
//! `floor(2^35 / sqrt(s))` is estimated in f32. 2^35 / sqrt(s) is at most 2^21, of which f32 has eighths: roundings of s,
//! of 1 - s y^2, of the scale and of the result cost 1/16 each, so the estimate to nearest is the floor or one more, and
//! r^2 s > 2^70 tells which. Host-tests check every s (`exhaustive vector-roots`).

/// 2^35.
pub const ROOT_SCALE: f32 = 34_359_738_368.0;

/// 2^70, which r^2 s must not exceed.
pub const ROOT_LIMIT: f64 = 1_180_591_620_717_411_303_424.0;
