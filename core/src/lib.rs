//! slicecast: a fixed-point, slice-order volume renderer.
#![no_std]
#![forbid(unsafe_code)]
