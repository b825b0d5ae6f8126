//! The pipeline `Compact`, lit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(slicecast::precision::Compact, slicecast::shade::Phong, u16, 4, 17);
