//! What the firmware image and the host that checks it have in common.
//!
//! [`boundary`] is the tap that sums up every stage boundary, [`scene`] describes the scenes that a machine renders,
//! [`image`] sums up pictures, [`angles`] the views that a device makes from angles. The same source runs on both
//! sides; everything else differs (compiler target, layer, classifier type, memory), and the sums must be equal.
#![no_std]
#![forbid(unsafe_code)]

pub mod angles;
pub mod boundary;
pub mod image;
pub mod scene;
pub mod sum;
