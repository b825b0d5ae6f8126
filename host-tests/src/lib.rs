//! What slicecast's bit-exactness tests share.
//!
//! | module | holds |
//! |---|---|
//! | [`random`] | numbers and volumes that are the same on every machine |
//! | [`frame`] | a frame stated in integers: view, table, lights, volume |
//! | [`reference`](mod@reference) | the pipeline's definitions applied one ray at a time: no rows, spans or skipping |
//! | [`record`] | a tap that keeps everything, and the first place where two runs part |
//! | [`checksum`] | a tap that keeps one number a stage |
//! | [`exhaustive`] | properties that hold for every input |
//! | [`second`] | the pipeline once more, from the contract's pages alone, and the mistakes that vectors must find |
//! | [`found`] | which directed vectors find which mistake of the second model |
//! | [`framed`] | the vectors of a frame, computed once more by the second model |
//! | [`tolerance`] | how far each stage may be from f64 |
//! | [`beside`] | the same of modulation, sums, reflectance maps and splatting |
//!
//! Frames are stated in integers because a sine or a logarithm may differ in its last bit between machines; the tests
//! are about what the pipeline makes of its inputs, and those must not move.

pub mod beside;
pub mod checksum;
pub mod colours;
pub mod exhaustive;
pub mod found;
pub mod frame;
pub mod framed;
pub mod random;
pub mod record;
pub mod reference;
pub mod second;
pub mod tolerance;
