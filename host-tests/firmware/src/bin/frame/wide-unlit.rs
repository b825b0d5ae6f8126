//! The pipeline `Wide`, unlit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(slicecast::precision::Wide, slicecast::shade::Unlit, 0);
