//! The pipeline `Wide`, lit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(
    slicecast::precision::Wide,
    slicecast::shade::Phong<slicecast::precision::Wide>,
    0
);
