//! The pipeline `Compact`, unlit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(
    slicecast::precision::Compact,
    slicecast::shade::Unlit,
    slicecast::composite::Unorm16(0)
);
