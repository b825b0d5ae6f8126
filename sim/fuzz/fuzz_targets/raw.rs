#![no_main]
//! Descriptions of raw files: sidecars and lines of words.

use libfuzzer_sys::fuzz_target;
use slicecast_volume::raw::describe;

fuzz_target!(|text: &str| {
    for read in [describe::from_toml(text), describe::from_words(text)] {
        if let Err(problem) = read {
            assert!(!problem.to_string().contains('\n'), "{problem}");
        }
    }
    let _ = describe::from_name(std::path::Path::new(text));
});
