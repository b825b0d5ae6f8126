//! What the bare-metal programs share.
#![no_std]

pub mod boundaries;
pub mod float;
pub mod frame;
pub mod machine;
pub mod memory;
pub mod scenes;
pub mod stack;
pub mod timer;
