//! Whatever a file of colours says, reading ends with a volume or an error, and a volume has its levels.

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::RngSeed;
use slicecast_pyramid::filter::Filter;
use slicecast_pyramid::pyramid::{By, next};
use slicecast_pyramid::read::{OpacityRule, Stated, of_colours};
use slicecast_volume::nrrd::read_colours;

/// A file of 4 x 3 x 2 voxels of a kind.
fn file(kind: usize) -> Vec<u8> {
    let (value_type, count, bytes, keys) = [
        ("uint8", 4, 1, ""),
        ("uint8", 3, 1, "slicecast_alpha_distance:=0.5\n"),
        ("uint8", 4, 1, "slicecast_voxel:=root8\nslicecast_tau_max:=0.25\n"),
        (
            "uint16",
            4,
            2,
            "slicecast_voxel:=extinction15\nslicecast_tau_max:=4\nslicecast_alpha_distance:=2\n",
        ),
        ("float", 4, 4, ""),
    ][kind];
    let head = format!(
        "NRRD0005\ntype: {value_type}\ndimension: 4\nsizes: {count} 4 3 2\nkinds: {count}-color space space space\n\
         space: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,2)\nendian: little\nencoding: raw\n{keys}\n"
    );
    [head.into_bytes(), vec![0; count * bytes * 24]].concat()
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(0x51CE_CA58), failure_persistence: None, ..ProptestConfig::with_cases(1500)
    })]

    #[test]
    fn mutated_files_never_panic(
        kind in 0..5_usize,
        edits in prop::collection::vec((any::<Index>(), any::<u8>()), 0..6),
        cut in prop::option::of(any::<Index>()),
        filter in (0..4_usize).prop_map(|index| Filter::ALL[index]),
    ) {
        let mut bytes = file(kind);
        for (at, byte) in &edits {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        if let Some(cut) = &cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.nrrd");
        std::fs::write(&path, bytes).unwrap();
        let stated = match kind {
            0 | 4 => Stated { alpha_distance: Some(1.0), ..Stated::default() },
            1 => Stated { opacity: Some(OpacityRule::Luminance), ..Stated::default() },
            _ => Stated::default(),
        };
        let read = read_colours(&path);
        prop_assert!(!edits.is_empty() || cut.is_some() || matches!(read, Ok(Some(_))));
        let Ok(Some(colours)) = read else { return Ok(()) };
        let read = of_colours(&colours, &stated);
        prop_assert!(!edits.is_empty() || cut.is_some() || read.is_ok());
        let Ok(read) = read else { return Ok(()) };
        let mut volume = read.volume;
        prop_assert!(volume.tau_max > 0.0 && volume.tau_max.is_finite());
        for by in [By::Extinction, By::Opacity { distance: 1.0 }] {
            if let Some(coarse) = next(&volume, filter, by) {
                let voxels = 0..coarse.voxels.len();
                prop_assert_eq!(coarse.voxels.len(), coarse.dims.iter().product::<usize>());
                prop_assert!(voxels.map(|index| coarse.voxels.codes(index)).all(|c| c.iter().all(|code| *code <= c[3])));
                volume = coarse;
            }
        }
    }
}
