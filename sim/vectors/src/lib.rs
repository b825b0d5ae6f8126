//! Vectors for a device or an RTL bench: what goes into each stage of the pipeline, and what comes out.

pub mod directed;
pub mod set;
