//! The pipeline `Compact`, lit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(
    slicecast::precision::Compact,
    slicecast::shade::Phong<slicecast::precision::Compact>,
    slicecast::composite::Unorm16(0)
);
