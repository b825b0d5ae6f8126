//! The pipeline `Paper`, unlit, alone.
#![no_std]
#![no_main]

slicecast_firmware::frame_program!(slicecast::precision::Paper, slicecast::shade::Unlit, 0);
