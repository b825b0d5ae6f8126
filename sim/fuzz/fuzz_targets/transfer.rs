#![no_main]
//! Transfer functions of other programs; what passes is compiled to a table.

use libfuzzer_sys::fuzz_target;
use slicecast_engine::table::{Correction, Table};
use slicecast_scene::import::{self, Kind};
use slicecast_scene::{AlphaCodeName, LookupName};
use slicecast_volume::Mapping;

fuzz_target!(|text: &str| {
    for kind in [Kind::SlicerText, Kind::SlicerJson, Kind::ParaView] {
        match import::parse(text, kind) {
            Ok(imported) => {
                let mapping = Mapping {
                    scale: 1.0,
                    offset: -1024.0,
                };
                let (code, lookup) = (AlphaCodeName::Sqrt8, LookupName::Nearest);
                let table = Table::compile(&imported.transfer, &mapping, Correction::Step(0.5), code, lookup);
                assert!(table.underflows <= table.entries.len());
            }
            Err(fault) => assert!(!fault.to_string().contains('\n'), "{fault}"),
        }
    }
});
