#![no_main]
//! Scene files; what passes is compiled to a table.

use libfuzzer_sys::fuzz_target;
use slicecast_engine::table::{Correction, Table, has_fine_colours};
use slicecast_scene::{AlphaCodeName, LookupName, file};
use slicecast_volume::Mapping;

fuzz_target!(|text: &str| {
    if let Ok(scene) = file::parse(text, "fuzz") {
        let mapping = Mapping {
            scale: 1.0,
            offset: -1024.0,
        };
        let compile = |code| {
            Table::compile(
                &scene.transfer,
                &mapping,
                Correction::Step(0.5),
                code,
                LookupName::Nearest,
            )
        };
        let (table, fine) = (compile(AlphaCodeName::Sqrt16), compile(AlphaCodeName::Colour16));
        assert!(table.underflows <= table.entries.len());
        // Where 8 bits are said to hold every colour that is seen, 16 say the same.
        if !has_fine_colours(&scene.transfer, &mapping) {
            for code in 0..table.entries.len() {
                assert_eq!(table.opacity(code), fine.opacity(code));
                let seen = scene.transfer.evaluate(mapping.value(code as f64)).1 > 0.0;
                assert!(!seen || table.colour(code) == fine.colour(code), "code {code}");
            }
        }
    }
});
