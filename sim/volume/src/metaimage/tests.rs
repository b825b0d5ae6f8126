//! Types, orders and packings; orientation; every refusal; mutated files.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
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

/// A header of 3 x 2 x 1 int16, with `replace` in place of the named fields (empty: left out).
fn header(replace: &[(&str, &str)]) -> String {
    let fields = [
        ("ObjectType", "Image"),
        ("NDims", "3"),
        ("BinaryDataByteOrderMSB", "False"),
        ("ElementSpacing", "1 1 2"),
        ("DimSize", "3 2 1"),
        ("ElementType", "MET_SHORT"),
    ];
    let known = |name: &str| fields.iter().any(|(field, _)| *field == name);
    let chosen = fields.iter().map(|&(name, value)| {
        let other = replace.iter().find(|(field, _)| *field == name);
        (name, other.map_or(value, |(_, value)| value))
    });
    let more = replace
        .iter()
        .copied()
        .filter(|(name, _)| !known(name) && *name != DATA_FILE);
    let data = replace
        .iter()
        .find(|(name, _)| *name == DATA_FILE)
        .map_or("LOCAL", |(_, value)| value);
    let lines = chosen.chain(more).filter(|(_, value)| !value.is_empty());
    let text: String = lines.map(|(name, value)| format!("{name} = {value}\n")).collect();
    text + &format!("{DATA_FILE} = {data}\n")
}

const DATA: [u8; 12] = [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0];

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn read_file(replace: &[(&str, &str)], data: &[u8]) -> Result<Decoded, ReadError> {
    read_bytes(&[header(replace).as_bytes(), data].concat(), "t.mha")
}

#[test]
fn packings_and_orders_come_back() {
    let expected = Values::I16(vec![1, 2, 3, 4, 5, 6]);
    let big: Vec<u8> = DATA.chunks(2).flat_map(|pair| [pair[1], pair[0]]).collect();
    for (fields, data) in [
        (vec![], DATA.to_vec()),
        (vec![("BinaryDataByteOrderMSB", "True")], big),
        (vec![("CompressedData", "True")], zlib(&DATA)),
        (vec![("BinaryData", "False")], b"1 2,3\n4 5\t6\n".to_vec()),
        (vec![("HeaderSize", "-1")], [b"xy", &DATA[..]].concat()),
        (vec![("HeaderSize", "3")], [b"xyz", &DATA[..]].concat()),
    ] {
        let volume = read_file(&fields, &data).unwrap();
        assert_eq!(volume.values(), &expected, "{fields:?}");
        assert_eq!((volume.dims(), volume.spacing()), ([3, 2, 1], [1.0, 1.0, 2.0]));
        assert_eq!(volume.orientation(), &Orientation::Unknown);
    }
    let long = [5_i64, -6, 7, 8, 9, 1 << 40].map(i64::to_le_bytes).concat();
    let volume = read_file(&[("ElementType", "MET_LONG_LONG")], &long).unwrap();
    assert_eq!(
        volume.values(),
        &Values::F64(vec![5.0, -6.0, 7.0, 8.0, 9.0, (1_i64 << 40) as f64])
    );
}

#[test]
fn a_stated_packed_size_is_told_but_not_believed() {
    let packed = zlib(&DATA);
    let volume = read_file(&[("CompressedData", "True"), ("CompressedDataSize", "3")], &packed).unwrap();
    assert_eq!(volume.values().len(), 6);
    assert!(
        volume.notes()[0].contains("CompressedDataSize is 3"),
        "{:?}",
        volume.notes()
    );
}

#[test]
fn directions_turn_the_voxels() {
    let volume = read_file(&[("TransformMatrix", "-1 0 0 0 0 1 0 1 0")], &DATA).unwrap();
    assert_eq!((volume.dims(), volume.spacing()), ([3, 1, 2], [1.0, 2.0, 1.0]));
    assert_eq!(volume.values(), &Values::I16(vec![3, 2, 1, 6, 5, 4]));
    let volume = read_file(&[("AnatomicalOrientation", "LPI")], &DATA).unwrap();
    assert_eq!(volume.values(), &Values::I16(vec![6, 5, 4, 3, 2, 1]));
    let volume = read_file(&[("AnatomicalOrientation", "???")], &DATA).unwrap();
    assert_eq!(volume.orientation(), &Orientation::Unknown);
}

#[test]
fn wrong_fields_and_data_are_refused_by_name() {
    for (field, value, expected) in [
        ("NDims", "2", "field `NDims` is `2`, expected 3"),
        ("NDims", "", "no field `NDims`"),
        ("DimSize", "3 2", "field `DimSize` is `3 2`"),
        ("DimSize", "3 2 -1", "field `DimSize`"),
        ("DimSize", "3 2 0", "has 0 voxels along z"),
        ("DimSize", "8192 8192 8192", "has 549755813888 voxels"),
        ("DimSize", "300 200 100", "has 12 bytes of data, expected 12000000"),
        ("ElementSpacing", "1 0 1", "has spacing 0 along y"),
        ("ElementSpacing", "1 -1 1", "has spacing -1 along y"),
        ("ElementSpacing", "1 nan 1", "has spacing NaN along y"),
        ("ElementSpacing", "a b c", "field `ElementSpacing`"),
        ("ElementType", "MET_OTHER", "field `ElementType` is `MET_OTHER`"),
        ("ElementNumberOfChannels", "3", "field `ElementNumberOfChannels` is `3`"),
        (
            "BinaryData",
            "maybe",
            "field `BinaryData` is `maybe`, expected True or False",
        ),
        ("TransformMatrix", "1 0 0", "field `TransformMatrix`"),
        (
            "TransformMatrix",
            "1 0 0 0 0 0 0 0 1",
            "states the direction (0, 0, 0) for its axis y",
        ),
        (
            "TransformMatrix",
            "1 0 0 1 1 0 0 0 1",
            "has axes x and y at 45.00 degrees",
        ),
        (
            "CompressedData",
            "True",
            "zlib data are damaged after 0 unpacked bytes of 12",
        ),
        ("BinaryData", "False", "value 0 of the text is"),
        ("HeaderSize", "-2", "field `HeaderSize`"),
        ("ElementDataFile", "a.raw", "expected `LOCAL`"),
        ("ElementDataFile", "", "expected `LOCAL`"),
    ] {
        let text = read_file(&[(field, value)], &DATA).unwrap_err().to_string();
        assert!(
            text.starts_with("t.mha: ") && text.contains(expected),
            "{field} = {value}: {text}"
        );
    }
    let plain = |text: &[u8]| read_bytes(text, "t").unwrap_err().to_string();
    assert!(plain(b"").contains("no field `ElementDataFile`"));
    assert!(plain(b"NDims = 3\n").contains("no field `ElementDataFile`"));
    assert!(plain(b"NDims: 3\n").contains("header line 1 is `NDims: 3`, expected `Key = Value`"));
    assert!(plain(b"NDims = \xff\n").contains("no field `ElementDataFile`"));
    assert!(plain(b"NDims = 3\nNDims = 3\n").contains("field `NDims` is given twice"));
    let text = read_file(&[("BinaryData", "False")], b"1 2 3 4 5 6 7")
        .unwrap_err()
        .to_string();
    assert!(text.contains("more than the 6 numbers expected"), "{text}");
    let text = read_file(&[("BinaryData", "False")], b"1 2 3 4 5 70000")
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("value 5 of the text is `70000`, expected a number of type int16"),
        "{text}"
    );
    let text = read_file(&[("CompressedData", "True")], &zlib(&[0; 13]))
        .unwrap_err()
        .to_string();
    assert!(text.contains("unpacks to more than the 12 bytes expected"), "{text}");
    let huge = [
        ("CompressedData", "True"),
        ("DimSize", "8192 8192 32"),
        ("ElementType", "MET_DOUBLE"),
    ];
    let text = read_file(&huge, &zlib(&DATA)).unwrap_err().to_string();
    assert!(text.contains("would take 17179869184 bytes of memory"), "{text}");
}

#[test]
fn comments_axes_of_one_entry_and_units_are_read() {
    let fields = [
        ("NDims", "4"),
        ("DimSize", "3 2 1 1"),
        ("ElementSpacing", "1000 1000 2000 1"),
        ("DistanceUnits", "um"),
        ("TransformMatrix", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"),
    ];
    let text = header(&fields);
    let comments = [
        &b"Comment = Universit\xe4t\nComment = second\n"[..],
        text.as_bytes(),
        &DATA,
    ]
    .concat();
    let volume = read_bytes(&comments, "t").unwrap();
    assert_eq!((volume.dims(), volume.spacing()), ([3, 2, 1], [1.0, 1.0, 2.0]));
    assert_eq!(volume.values(), &Values::I16(vec![1, 2, 3, 4, 5, 6]));
    assert_eq!(volume.notes().len(), 3, "{:?}", volume.notes());
    let text = read_file(&[("NDims", "4"), ("DimSize", "3 1 1 2")], &DATA)
        .unwrap_err()
        .to_string();
    assert!(text.contains("expected 1 for every axis after the third"), "{text}");
}

#[test]
fn data_in_many_files_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    for (index, part) in DATA.chunks(4).enumerate() {
        std::fs::write(folder.path().join(format!("s{index}.raw")), part).unwrap();
        std::fs::write(folder.path().join(format!("s{index}.zraw")), zlib(part)).unwrap();
    }
    let path = folder.path().join("v.mhd");
    let with = |name: &str, packed: &str, names: &str| {
        let fields = [("DimSize", "2 1 3"), ("CompressedData", packed), (DATA_FILE, name)];
        std::fs::write(&path, header(&fields) + names).unwrap();
        read(&path)
    };
    for (name, packed, names) in [
        ("LIST", "False", "s0.raw\ns1.raw\ns2.raw\n"),
        ("LIST 2D", "True", "s0.zraw\ns1.zraw\ns2.zraw"),
        ("LIST 3", "False", "s0.raw\n\ns1.raw\ns2.raw\n"),
        ("s%d.raw 0 2 1", "False", ""),
        ("s%d.raw 0 2", "False", ""),
        ("s%01d.zraw 0 2 1 2", "True", ""),
    ] {
        let volume = with(name, packed, names).unwrap();
        assert_eq!(volume.values(), &Values::I16(vec![1, 2, 3, 4, 5, 6]), "{name}");
        assert_eq!(volume.notes(), ["the data are in 3 files"]);
    }
    for (name, names, expected) in [
        (
            "LIST",
            "s0.raw\n",
            "v.mhd: data in many files: 1 files are named, expected 3 slices",
        ),
        ("LIST", "s0.raw\ns1.raw\n../s2.raw\n", "names the data file `../s2.raw`"),
        ("LIST", "s0.raw\ns1.raw\nv.mhd\n", "v.mhd: has "),
        ("s%d.raw 1 3 1", "", "s3.raw: cannot find the file"),
        ("s%d.raw 0 a 1", "", "PATTERN FIRST LAST STEP"),
    ] {
        let text = with(name, "False", names).unwrap_err().to_string();
        assert!(text.contains(expected), "{name}: {text}");
    }
}

#[test]
fn data_files_stay_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.mhd");
    let with = |name: &str| std::fs::write(&path, header(&[(DATA_FILE, name)])).unwrap();
    for bad in ["/etc/passwd", "../v.raw", "a/../../v.raw"] {
        with(bad);
        let text = read(&path).unwrap_err().to_string();
        assert!(
            text.contains("names the data file") && text.contains("in its own folder"),
            "{text}"
        );
    }
    with("v.raw");
    assert!(
        read(&path)
            .unwrap_err()
            .to_string()
            .contains("v.raw: cannot find the file")
    );
    std::fs::write(folder.path().join("v.raw"), DATA).unwrap();
    assert_eq!(read(&path).unwrap().dims(), [3, 2, 1]);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
        ..ProptestConfig::default()
    })]

    /// Whatever a file says, reading ends with a volume or an error of one line.
    #[test]
    fn mutated_files_never_panic(
        packed: bool,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let fields = [("TransformMatrix", "0 1 0 0 0 -1 1 0 0"), ("CompressedData", if packed { "True" } else { "False" })];
        let data = if packed { zlib(&DATA) } else { DATA.to_vec() };
        let mut bytes = [header(&fields).as_bytes(), &data].concat();
        prop_assert!(read_bytes(&bytes, "t").is_ok());
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
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
