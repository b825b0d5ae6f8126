#![no_main]
//! Scene files; what passes is compiled to a table.

use libfuzzer_sys::fuzz_target;
use slicecast_engine::table::{Correction, Table};
use slicecast_scene::{AlphaCodeName, LookupName, file};
use slicecast_volume::Mapping;

fuzz_target!(|text: &str| {
    if let Ok(scene) = file::parse(text, "fuzz") {
        let mapping = Mapping {
            scale: 1.0,
            offset: -1024.0,
        };
        let table = Table::compile(
            &scene.transfer,
            &mapping,
            Correction::Step(0.5),
            AlphaCodeName::Sqrt16,
            LookupName::Nearest,
        );
        assert!(table.underflows <= table.entries.len());
    }
});
