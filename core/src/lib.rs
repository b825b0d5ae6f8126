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

pub mod classify;
pub mod composite;
pub mod format;
pub mod gradient;
pub mod interpolate;
pub mod locate;
pub mod normalise;
pub mod plan;
pub mod plane;
pub mod precision;
mod product;
pub mod project;
mod rows;
pub mod shade;
pub mod slice;
pub mod stream;
pub mod tap;
pub mod view;
pub mod warp;
