//! A fixed-point, slice-order volume renderer: the pipeline of VolumePro and Cube-4 as a library.
//!
//! Voxel slices go in, nearest first; every sample passes through [`locate`], [`interpolate`], [`classify`],
//! [`gradient`], [`normalise`], [`shade`] and [`composite`]; a base-plane image comes out, which [`warp`] turns into
//! the viewer's picture. Each stage is a file with its contract, its scalar definition and its row kernel.
//!
//! The library needs no operating system, no heap and no floating point in the pipeline, and it works on memory that
//! the caller lends. [`plan::Plan`] checks a scene once and says what it needs; [`stream::Stream`] accepts one slice
//! at a time (firmware), [`plane::Pipeline::fold`] folds one sample plane into some rows of the image (a host with
//! the volume in memory and many threads). Both give the same bits.
//!
//! Number formats are declared in [`mod@format`], the three named precisions in [`precision`].
//!
//! # Example
//!
//! White fog of 8 slices, 8 x 8 voxels each, pushed one by one:
//!
//! ```
//! use slicecast::classify::{Linear, PointTable, Sqrt16, entry};
//! use slicecast::table::ENTRIES;
//! use slicecast::composite::{FrontToBack, Unorm16};
//! use slicecast::plan::{Plan, Sampling, Spacing};
//! use slicecast::plane::{Composite, Pipeline};
//! use slicecast::precision::Compact;
//! use slicecast::shade::Unlit;
//! use slicecast::slice::RowRange;
//! use slicecast::stream::{Memory, Needs, Stream};
//! use slicecast::view::View;
//!
//! // Only the combination that you name is compiled.
//! type Unshaded<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Unlit, FrontToBack>;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Every code is white, with the root of its opacity at 0x2000 / 0x10000: 1/64 a step.
//! static WHITE: [u32; ENTRIES] = [entry([255; 3], 0x20); ENTRIES];
//! static LOW: [u8; ENTRIES] = [0; ENTRIES];
//! let pipeline = Unshaded::new(Compact, PointTable::new(&WHITE, &LOW), Unlit);
//!
//! let view = View::from_angles(0.0, 0.0, [1.0; 3])?;
//! let plan = Plan::new(view, [8, 8, 8], Spacing::CUBIC, Sampling::default())?;
//! let needs = Needs::of::<Unshaded>(&plan);
//! let mut slices = vec![0; needs.slices];
//! let mut ranges = vec![RowRange::EMPTY; needs.ranges];
//! let mut scratch = vec![0; needs.scratch];
//! let mut image = vec![Unorm16::default(); needs.image];
//! let memory = Memory { slices: &mut slices, ranges: &mut ranges, scratch: &mut scratch, image: &mut image };
//!
//! let mut stream = Stream::new(plan, pipeline, memory)?;
//! while let Some(_number) = stream.wanted() {
//!     stream.push(&[1000; 64])?;
//! }
//! // Eight samples of 1/64 leave (63/64)^8 of the light: 57780 of 65535.
//! let left = stream.pixel(4, 4).transparency.0;
//! assert!((57779..=57781).contains(&left));
//! # Ok(())
//! # }
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented,
        clippy::indexing_slicing,
        clippy::float_arithmetic,
        clippy::integer_division
    )
)]

#[cfg(test)]
extern crate std;

pub mod absorption;
pub mod borders;
pub mod classify;
pub mod clip;
pub mod composite;
pub mod crop;
pub mod cut;
#[cfg(feature = "embedded-graphics")]
pub mod display;
mod error;
pub mod exp2;
pub mod extinction;
pub mod fast;
pub mod format;
pub mod gradient;
pub mod integral;
pub mod interpolate;
pub mod lanes;
pub mod locate;
#[cfg(feature = "defmt")]
mod log;
pub mod modulate;
pub mod normalise;
pub mod perspective;
pub mod plan;
pub mod plane;
pub mod precision;
pub mod project;
pub mod quadratic;
pub mod reciprocal;
pub mod root;
mod rows;
pub mod screen;
pub mod seen;
pub mod shade;
pub mod sides;
pub mod slice;
pub mod splat;
pub mod stage;
pub mod stream;
pub mod surface;
pub mod table;
pub mod tap;
pub mod view;
pub mod warp;

pub use error::Error;
