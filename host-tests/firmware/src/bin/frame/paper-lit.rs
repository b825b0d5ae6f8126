//! The pipeline `Paper`, lit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(
    slicecast::precision::Paper,
    slicecast::shade::Phong<slicecast::precision::Paper>,
    0
);
