//! The engine: a scene on a volume, folded tile by tile with the vectors of the processor, or streamed as firmware does.

#![deny(unsafe_code)]

mod base;
pub mod bundle;
pub mod camera;
pub mod cutout;
pub mod depth;
pub mod error;
pub mod expanded;
pub mod fast;
pub mod fineness;
pub mod folds;
pub mod frame;
pub mod geometry;
pub mod image;
pub mod integrals;
pub mod key;
pub mod levels;
pub mod modulation;
pub mod occupancy;
pub mod oriented;
pub mod parameters;
pub mod part;
pub mod parts;
pub mod perspective;
pub mod picture;
pub mod pipelines;
pub mod progress;
pub mod reflectance;
pub mod rendering;
pub mod segments;
pub mod shard;
pub mod simd;
pub mod source;
mod stream;
pub mod table;
pub mod threads;
pub mod tile;
pub mod tiles;
