//! Vectors for a device or an RTL bench: what goes into each stage of the pipeline, and what comes out.
//!
//! | module | holds |
//! |---|---|
//! | [`set`] | a table of vectors: named inputs and outputs with their widths |
//! | [`directed`] | the ends and halves of every format, stage by stage, from core's scalar definitions |
//! | [`frame`] | what a tap sees of a frame, with its voxels, table and constants |
//! | [`files`] | sets as files: words for `$readmemh`, NPY, and a manifest |
//! | [`answer`] | a device's files read back, and the first place where they depart |

pub mod answer;
pub mod directed;
pub mod files;
pub mod frame;
pub mod set;
