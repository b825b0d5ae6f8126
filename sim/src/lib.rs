//! The host side of slicecast: real volumes in, pictures and error figures out.

pub mod model;
pub mod scene;
pub mod volume;
