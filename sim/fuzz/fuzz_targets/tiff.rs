#![no_main]
//! Whatever a file says, reading ends with a volume or an error of one line.

use libfuzzer_sys::fuzz_target;
use slicecast_volume::choice::Choice;
use slicecast_volume::mapping::Window;
use slicecast_volume::{open, tiff};

fuzz_target!(|bytes: &[u8]| {
    match tiff::read_bytes(bytes, "fuzz", &Choice::default()) {
        Ok(decoded) => {
            assert_eq!(decoded.values().len(), decoded.dims().iter().product::<usize>());
            let _ = open::prepare(&decoded, Window::Auto);
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
});
