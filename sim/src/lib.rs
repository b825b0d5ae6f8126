//! The host side of slicecast: real volumes in, pictures and error figures out.

#![deny(unsafe_code)]

pub mod bench;
pub mod camera;
pub mod compare;
pub mod engine;
pub mod exchange;
pub mod expanded;
pub mod explain;
pub mod export;
pub use slicecast_model as model;
pub mod occupancy;
pub mod opponent;
pub mod oriented;
mod picture;
pub mod pipelines;
pub mod presets;
pub mod rays;
pub mod report;
pub use slicecast_scene as scene;
pub mod simd;
pub mod study;
pub mod table;
pub use slicecast_volume as volume;
