//! Files made byte by byte: both versions and orders, orientation, scaling; every refusal; mutated files.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;

use super::*;
use crate::decoded::Orientation;
use crate::values::Values;

/// As [`super::read_bytes`], without a choice.
fn read_bytes(bytes: &[u8], name: &str) -> Result<Decoded, ReadError> {
    super::read_bytes(bytes, name, &Choice::default())
}

/// As [`super::read`], without a choice.
fn read(path: &Path) -> Result<Decoded, ReadError> {
    super::read(path, &Choice::default())
}

/// A NIfTI-1 file of 2 x 3 x 1 int16 with an RAS sform of 2 x 3 x 4 mm, as (field offset, bytes) overrides allow.
fn file(changes: &[(usize, &[u8])]) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, &348_i32.to_le_bytes());
    for (i, side) in [3_i16, 2, 3, 1, 1, 1, 1, 1].iter().enumerate() {
        put(40 + 2 * i, &side.to_le_bytes());
    }
    put(70, &4_i16.to_le_bytes());
    put(72, &16_i16.to_le_bytes());
    for (at, length) in [(76, 1.0_f32), (80, 2.0), (84, 3.0), (88, 4.0), (108, 352.0)] {
        put(at, &length.to_le_bytes());
    }
    put(123, &[2]);
    put(254, &1_i16.to_le_bytes());
    for (at, entry) in [(280, 2.0_f32), (300, 3.0), (320, 4.0)] {
        put(at, &entry.to_le_bytes());
    }
    put(344, b"n+1\0");
    for &(at, value) in changes {
        put(at, value);
    }
    bytes.extend((1_i16..=6).flat_map(i16::to_le_bytes));
    bytes
}

fn message(bytes: &[u8]) -> String {
    read_bytes(bytes, "t.nii").unwrap_err().to_string()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn ras_is_turned_to_lps() {
    for bytes in [file(&[]), gzip(&file(&[]))] {
        let volume = read_bytes(&bytes, "t").unwrap();
        assert_eq!((volume.dims(), volume.spacing()), ([2, 3, 1], [2.0, 3.0, 4.0]));
        assert_eq!(volume.values(), &Values::I16(vec![6, 5, 4, 3, 2, 1]));
        assert!(matches!(volume.orientation(), Orientation::Patient { file_axes, .. } if file_axes == "RAS"));
    }
}

#[test]
fn scale_and_display_range_are_kept() {
    let scaled = file(&[
        (112, &0.5_f32.to_le_bytes()),
        (116, &(-3.0_f32).to_le_bytes()),
        (124, &9.0_f32.to_le_bytes()),
    ]);
    let volume = read_bytes(&scaled, "t").unwrap();
    assert_eq!((volume.value_scale(), volume.value_offset()), (0.5, -3.0));
    assert_eq!(volume.stated_window(), Some([0.0, 9.0]));
    let negative = read_bytes(&file(&[(112, &(-1.0_f32).to_le_bytes())]), "t").unwrap();
    assert_eq!(
        negative.values(),
        &Values::F32(vec![-6.0, -5.0, -4.0, -3.0, -2.0, -1.0])
    );
    let none = read_bytes(&file(&[(112, &f32::NAN.to_le_bytes())]), "t").unwrap();
    assert_eq!((none.value_scale(), none.notes().len()), (1.0, 2));
}

#[test]
fn the_qform_counts_without_an_sform() {
    // Half a turn about z: b = c = 0, d = 1; in RAS x and y run backwards, which is LPS.
    let turned = file(&[(254, &[0, 0]), (252, &[1, 0]), (264, &1.0_f32.to_le_bytes())]);
    let volume = read_bytes(&turned, "t").unwrap();
    assert_eq!(volume.values(), &Values::I16(vec![1, 2, 3, 4, 5, 6]));
    let unknown = read_bytes(&file(&[(254, &[0, 0])]), "t").unwrap();
    assert_eq!(unknown.orientation(), &Orientation::Unknown);
    // Metres.
    let metres = read_bytes(&file(&[(254, &[0, 0]), (123, &[1])]), "t").unwrap();
    assert_eq!(metres.spacing(), [2000.0, 3000.0, 4000.0]);
}

/// RGB24 and RGBA32: colours side by side, turned as a whole, without the slope.
#[test]
fn colours_are_read_beside_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("colours.nii.gz");
    let written = |datatype: i16, bits: i16, data: &[u8]| {
        let changes = [
            (70, &datatype.to_le_bytes()[..]),
            (72, &bits.to_le_bytes()),
            (112, &2.0_f32.to_le_bytes()),
        ];
        let mut bytes = file(&changes);
        bytes.truncate(352);
        bytes.extend(data);
        std::fs::write(&path, gzip(&bytes)).unwrap();
        read_colours(&path)
    };
    for (datatype, components) in [(128, 3), (2304, 4)] {
        let data: Vec<u8> = (0..6 * components as u8).collect();
        let colours = written(datatype, 8 * components as i16, &data).unwrap().unwrap();
        assert_eq!((colours.dims(), colours.components()), ([2, 3, 1], components));
        assert_eq!(colours.spacing(), [2.0, 3.0, 4.0]);
        assert!(matches!(colours.orientation(), Orientation::Patient { .. }));
        // From RAS to LPS x and y change sides, the values of a voxel stay together.
        let turned: Vec<u8> = data.chunks(components).rev().flatten().copied().collect();
        assert_eq!(*colours.values(), Values::U8(turned));
    }
    let error = written(128, 24, &[0; 17]).unwrap_err().to_string();
    assert!(error.contains("has 17 bytes of data"), "{error}");
    std::fs::write(&path, gzip(&file(&[]))).unwrap();
    assert_eq!(read_colours(&path).unwrap(), None);
}

#[test]
fn other_files_are_refused_by_the_field_at_fault() {
    for (at, value, expected) in [
        (0, &[0, 0, 0, 0][..], "states a header of 0 bytes, expected 348 or 540"),
        (344, b"\0\0\0\0", "magic is \"\\x00\\x00\\x00\\x00\", expected"),
        (344, b"ni1\0", "is a header without data"),
        (40, &[8, 0], "dim[0] is 8, expected 1 to 7"),
        (40, &[255, 255], "dim[0] is -1"),
        (42, &[0, 0], "dim[1] is 0, expected 1 or more"),
        (
            40,
            &[4, 0, 2, 0, 3, 0, 1, 0, 9, 0],
            "a file of 9 volumes or components (dim[4]) is not read",
        ),
        (42, &[0xff, 0x7f], "has 32767 voxels along x, expected 1 to 8192"),
        (
            42,
            &[0, 1, 0, 1, 0, 1],
            "has 12 bytes of data after the 352 skipped, expected 33554432",
        ),
        (70, &[32, 0], "datatype 32 is not read"),
        (
            70,
            &[128, 0],
            "a volume of 3 colours a voxel is not read, expected one value a voxel",
        ),
        (70, &[0, 9], "a volume of 4 colours a voxel is not read"),
        (108, &f32::NAN.to_le_bytes(), "vox_offset is NaN"),
        (108, &0.0_f32.to_le_bytes(), "vox_offset is 0, expected 352 or more"),
        (
            108,
            &1e9_f32.to_le_bytes(),
            "has 0 bytes of data after the 1000000000 skipped",
        ),
        (
            280,
            &0.0_f32.to_le_bytes(),
            "states the direction (-0, -0, 0) for its axis x",
        ),
        (280, &f32::NAN.to_le_bytes(), "for its axis x"),
        (284, &2.0_f32.to_le_bytes(), "has axes x and y at"),
        (112, &1e38_f32.to_le_bytes(), "values are scaled by"),
    ] {
        let text = message(&file(&[(at, value)]));
        assert!(text.starts_with("t.nii: ") && text.contains(expected), "{at}: {text}");
    }
    let flat = file(&[(254, &[0, 0]), (84, &0.0_f32.to_le_bytes())]);
    assert!(message(&flat).contains("has spacing 0 along y"));
    assert!(message(b"").contains("has 0 bytes, expected a header"));
    assert!(message(&gzip(b"short")).contains("has 5 bytes, expected a header"));
    let whole = file(&[]);
    for len in 0..whole.len() {
        assert!(read_bytes(&whole[..len], "t").is_err(), "cut to {len}");
    }
}

#[test]
fn a_pair_is_read_from_its_header() {
    let folder = tempfile::tempdir().unwrap();
    let header = folder.path().join("v.hdr");
    let whole = file(&[(344, b"ni1\0"), (108, &0.0_f32.to_le_bytes())]);
    std::fs::write(&header, &whole[..348]).unwrap();
    assert!(
        read(&header)
            .unwrap_err()
            .to_string()
            .contains("v.img: cannot find the file")
    );
    let data = folder.path().join("v.img");
    std::fs::write(&data, &whole[352..]).unwrap();
    let volume = read(&header).unwrap();
    assert_eq!(volume.dims(), [2, 3, 1]);
    let by_data = crate::open::read(&data).unwrap();
    assert_eq!(
        (by_data.values(), by_data.spacing()),
        (volume.values(), volume.spacing())
    );
    assert!(
        by_data.notes().first().unwrap().ends_with("v.hdr"),
        "{:?}",
        by_data.notes()
    );
    std::fs::rename(&data, folder.path().join("v.img.gz")).unwrap();
    std::fs::write(folder.path().join("v.img.gz"), gzip(&whole[352..])).unwrap();
    assert_eq!(
        crate::open::read(&folder.path().join("v.img.gz")).unwrap().values(),
        volume.values()
    );
    // Data without a header are of no known format.
    let alone = folder.path().join("w.img");
    std::fs::write(&alone, &whole[352..]).unwrap();
    assert!(
        crate::open::read(&alone)
            .unwrap_err()
            .to_string()
            .contains("is of no known format")
    );
}

#[test]
fn what_follows_the_voxels_is_left_out_with_a_note() {
    let expected = Values::I16(vec![6, 5, 4, 3, 2, 1]);
    let longer = [&file(&[])[..], &[9; 5]].concat();
    for (bytes, note) in [
        (longer.clone(), "5 bytes after the voxels are left out"),
        (gzip(&longer), "more data follow the voxels and are left out"),
        (
            [&gzip(&file(&[]))[..], &[0; 512]].concat(),
            "bytes after the gzip data are left out",
        ),
    ] {
        let volume = read_bytes(&bytes, "t").unwrap();
        assert_eq!(volume.values(), &expected);
        assert!(
            volume.notes().iter().any(|found| found == note),
            "{note}: {:?}",
            volume.notes()
        );
    }
    let members = [gzip(&file(&[])[..355]), gzip(&file(&[])[355..])].concat();
    let volume = read_bytes(&members, "t").unwrap();
    assert_eq!((volume.values(), volume.notes().len()), (&expected, 1));
}

#[test]
fn axes_of_one_entry_or_none_are_left_out() {
    for sides in [[5_i16, 2, 3, 1, 1, 1], [5, 2, 3, 1, 1, 0], [5, 2, 3, 1, 0, 0]] {
        let bytes = sides.map(i16::to_le_bytes).concat();
        let volume = read_bytes(&file(&[(40, &bytes)]), "t").unwrap();
        assert_eq!(volume.dims(), [2, 3, 1]);
        let told = volume
            .notes()
            .iter()
            .filter(|note| note.contains("the axis is left out"))
            .count();
        assert_eq!(told, sides.iter().filter(|&&side| side == 0).count());
    }
}

#[test]
fn nan_is_background_on_demand() {
    let values = [f32::NAN, 1.0, 2.0, 3.0, f32::NAN, 0.5].map(f32::to_le_bytes).concat();
    let with = |slope: f32| {
        let head = file(&[(70, &[16, 0]), (112, &slope.to_le_bytes())]);
        [&head[..352], &values].concat()
    };
    assert!(message(&with(1.0)).contains("`--nan background`"));
    let choice = Choice {
        nan: crate::choice::NanRule::Background,
        ..Choice::default()
    };
    let volume = super::read_bytes(&with(1.0), "t", &choice).unwrap();
    assert_eq!(volume.values(), &Values::F32(vec![0.5, 0.5, 3.0, 2.0, 1.0, 0.5]));
    assert!(
        volume.notes()[0].starts_with("2 of 6 voxels are NaN"),
        "{:?}",
        volume.notes()
    );
    // Values that fall: the greatest stored one is the least.
    let volume = super::read_bytes(&with(-1.0), "t", &choice).unwrap();
    assert_eq!(volume.values(), &Values::F64(vec![-0.5, -3.0, -3.0, -2.0, -1.0, -3.0]));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
        ..ProptestConfig::default()
    })]

    /// Whatever a header says, reading ends with a volume or an error.
    #[test]
    fn mutated_files_never_panic(
        edits in prop::collection::vec((0_usize..364, any::<u8>()), 0..8),
        packed: bool,
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = file(&[]);
        for (at, byte) in edits {
            bytes[at] = byte;
        }
        if packed {
            bytes = gzip(&bytes);
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        match read_bytes(&bytes, "t") {
            Ok(volume) => prop_assert_eq!(volume.values().len(), volume.dims().iter().product::<usize>()),
            Err(error) => prop_assert!(!error.to_string().contains('\n')),
        }
    }
}
