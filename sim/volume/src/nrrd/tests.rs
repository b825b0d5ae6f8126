//! Round trips of every type, order and encoding; every refusal; mutated headers.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;

use super::*;
use crate::choice::NanRule;
use crate::values::Values;

/// As [`super::read_bytes`], without a choice.
fn read_bytes(bytes: &[u8], name: &str) -> Result<Decoded, ReadError> {
    super::read_bytes(bytes, name, &Choice::default())
}

/// As [`super::read`], without a choice.
fn read(path: &Path) -> Result<Decoded, ReadError> {
    super::read(path, &Choice::default())
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// An attached file of 3 x 2 x 1 bytes, with `replace` in place of the named field's line.
fn file(replace: &[(&str, &str)], data: &[u8]) -> Vec<u8> {
    let fields = [
        ("type", "uint8"),
        ("dimension", "3"),
        ("sizes", "3 2 1"),
        ("spacings", "1 1 2"),
        ("encoding", "raw"),
    ];
    let mut text = String::from("NRRD0004\n");
    for (name, value) in fields {
        if !replace.iter().any(|(other, _)| *other == name) {
            text += &format!("{name}: {value}\n");
        }
    }
    for (name, value) in replace.iter().filter(|(_, value)| !value.is_empty()) {
        text += &format!("{name}: {value}\n");
    }
    text += "\n";
    [text.as_bytes(), data].concat()
}

fn read_file(replace: &[(&str, &str)], data: &[u8]) -> Result<Decoded, ReadError> {
    read_bytes(&file(replace, data), "t.nrrd")
}

fn message(replace: &[(&str, &str)], data: &[u8]) -> String {
    read_file(replace, data).unwrap_err().to_string()
}

/// One volume a type: its name, its values, and the same as little-endian bytes a value.
fn samples() -> Vec<(&'static str, Values, Vec<Vec<u8>>)> {
    fn bytes<T: Copy, const N: usize>(values: &[T], to: impl Fn(T) -> [u8; N]) -> Vec<Vec<u8>> {
        values.iter().map(|&v| to(v).to_vec()).collect()
    }
    let i8s = vec![-128, -1, 0, 1, 2, 127];
    let u8s = vec![0, 1, 2, 128, 254, 255];
    let i16s = vec![i16::MIN, -2, 0, 1, 0x0102, i16::MAX];
    let u16s = vec![0, 1, 2, 3, 0x0102, u16::MAX];
    let i32s = vec![i32::MIN, -2, 0, 1, 0x01020304, i32::MAX];
    let u32s = vec![0, 1, 2, 3, 0x01020304, u32::MAX];
    let f32s = vec![f32::MIN, -0.5, 0.0, 1.0, 1e-40, f32::MAX];
    let f64s = vec![f64::MIN, -0.5, 0.0, 1.0, 1e-310, f64::MAX];
    vec![
        ("signed char", Values::I8(i8s.clone()), bytes(&i8s, i8::to_le_bytes)),
        ("unsigned char", Values::U8(u8s.clone()), bytes(&u8s, u8::to_le_bytes)),
        ("short", Values::I16(i16s.clone()), bytes(&i16s, i16::to_le_bytes)),
        (
            "unsigned short",
            Values::U16(u16s.clone()),
            bytes(&u16s, u16::to_le_bytes),
        ),
        ("int", Values::I32(i32s.clone()), bytes(&i32s, i32::to_le_bytes)),
        (
            "unsigned int",
            Values::U32(u32s.clone()),
            bytes(&u32s, u32::to_le_bytes),
        ),
        ("float", Values::F32(f32s.clone()), bytes(&f32s, f32::to_le_bytes)),
        ("double", Values::F64(f64s.clone()), bytes(&f64s, f64::to_le_bytes)),
    ]
}

#[test]
fn every_type_order_and_encoding_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    for (name, values, words) in samples() {
        for endian in ["little", "big"] {
            let in_order = |word: &Vec<u8>| match endian {
                "big" => word.iter().rev().copied().collect(),
                _ => word.clone(),
            };
            let plain: Vec<u8> = words.iter().flat_map(in_order).collect();
            for (encoding, data) in [("raw", plain.clone()), ("gzip", gzip(&plain)), ("gz", gzip(&plain))] {
                let fields = [("type", name), ("endian", endian), ("encoding", encoding)];
                let attached = folder.path().join("a.nrrd");
                fs::write(&attached, file(&fields, &data)).unwrap();
                let volume = read(&attached).unwrap();
                assert_eq!(volume.values(), &values, "{name} {endian} {encoding}");
                assert_eq!((volume.dims(), volume.spacing()), ([3, 2, 1], [1.0, 1.0, 2.0]));
                fs::write(folder.path().join("d e.raw"), &data).unwrap();
                let header = folder.path().join("d.nhdr");
                let fields = [&fields[..], &[("data file", "./d e.raw")]].concat();
                fs::write(&header, file(&fields, &[])).unwrap();
                assert_eq!(
                    read(&header).unwrap().values(),
                    &values,
                    "{name} {endian} {encoding} detached"
                );
            }
        }
    }
}

#[test]
fn skips_are_passed_over() {
    let expected = Values::U8(vec![1, 2, 3, 4, 5, 6]);
    let data = b"a line\n\nab\x01\x02\x03\x04\x05\x06";
    let values = |fields: &[(&str, &str)], data: &[u8]| read_file(fields, data).unwrap().values().clone();
    assert_eq!(values(&[("line skip", "2"), ("byte skip", "2")], data), expected);
    assert_eq!(values(&[("lineskip", "1"), ("byteskip", "3")], data), expected);
    assert_eq!(values(&[("byte skip", "-1")], data), expected);
    assert_eq!(values(&[("line skip", "1"), ("byte skip", "-1")], data), expected);
    let packed = [b"a line\n", gzip(b"ab\x01\x02\x03\x04\x05\x06").as_slice()].concat();
    assert_eq!(
        values(&[("encoding", "gzip"), ("line skip", "1"), ("byte skip", "2")], &packed),
        expected
    );
}

#[test]
fn packed_members_follow_each_other() {
    let data = [gzip(&[1, 2]), gzip(&[3, 4, 5, 6])].concat();
    let volume = read_file(&[("encoding", "gzip")], &data).unwrap();
    assert_eq!(volume.values(), &Values::U8(vec![1, 2, 3, 4, 5, 6]));
}

#[test]
fn text_and_bzip2_and_long_integers_are_read() {
    let expected = Values::U8(vec![1, 2, 3, 4, 5, 255]);
    assert_eq!(
        read_file(&[("encoding", "ascii")], b"1 2 3\n4 5 255\n")
            .unwrap()
            .values(),
        &expected
    );
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    encoder.write_all(&[1, 2, 3, 4, 5, 255]).unwrap();
    let packed = encoder.finish().unwrap();
    assert_eq!(
        read_file(&[("encoding", "bzip2")], &packed).unwrap().values(),
        &expected
    );
    assert!(message(&[("encoding", "bzip2")], &packed[..20]).contains("bzip2 data are damaged"));
    assert!(message(&[("encoding", "ascii")], b"1 2 3 4 5 256").contains("value 5 of the text is `256`"));
    assert!(message(&[("encoding", "ascii")], b"1 2 3 4 5").contains("has 5 bytes of data that can be read"));
    let long = |values: [i64; 6]| {
        let fields = [("type", "long long int"), ("endian", "big")];
        read_file(&fields, &values.map(i64::to_be_bytes).concat())
            .unwrap()
            .values()
            .clone()
    };
    assert_eq!(long([0, 1, -2, 3, 4, 5]), Values::I32(vec![0, 1, -2, 3, 4, 5]));
    assert_eq!(
        long([0, 1, 2, 3, 4, 4_000_000_000]),
        Values::U32(vec![0, 1, 2, 3, 4, 4_000_000_000])
    );
    assert_eq!(
        long([0, 0, 0, 0, 0, 1 << 50]),
        Values::F64(vec![0.0, 0.0, 0.0, 0.0, 0.0, (1_i64 << 50) as f64])
    );
}

#[test]
fn directions_turn_the_voxels() {
    let fields = [
        ("space", "right-anterior-superior"),
        ("space directions", "(2,0,0) (0,0,1) (0,3,0)"),
        ("spacings", ""),
    ];
    let volume = read_file(&fields, &[1, 2, 3, 4, 5, 6]).unwrap();
    assert_eq!((volume.dims(), volume.spacing()), ([3, 1, 2], [2.0, 3.0, 1.0]));
    assert_eq!(volume.values(), &Values::U8(vec![3, 2, 1, 6, 5, 4]));
}

#[test]
fn keys_and_comments_are_read() {
    let text =
        b"NRRD0005\r\n# c\r\ntype: uchar\r\ndimension: 3\r\nsizes: 1 1 1\r\nencoding: raw\r\nspacings: 1 1 1\r\n\
        kinds: domain space Domain\r\nhounsfield_offset:=-1024\r\n\r\n\x05";
    let volume = read_bytes(text, "t").unwrap();
    assert_eq!((volume.value_offset(), volume.notes().len()), (-1024.0, 0));
}

#[test]
fn wrong_fields_are_refused_by_name() {
    let six = [0; 6];
    for (field, value, expected) in [
        ("dimension", "4", "field `dimension` is `4`, expected 3"),
        ("dimension", "", "no field `dimension`"),
        ("type", "block", "field `type` is `block`, expected int8"),
        ("type", "short", "no field `endian`, expected `little` or `big`"),
        ("type", "", "no field `type`"),
        ("sizes", "3 2", "field `sizes` is `3 2`, expected three whole numbers"),
        ("sizes", "3 2 -1", "field `sizes`"),
        ("sizes", "3 2 1 1", "field `sizes`"),
        ("sizes", "3 2 99999999999999999999", "field `sizes`"),
        ("sizes", "3 0 1", "has 0 voxels along y, expected 1 to 8192"),
        ("sizes", "8193 1 1", "has 8193 voxels along x, expected 1 to 8192"),
        (
            "sizes",
            "8192 8192 8192",
            "has 549755813888 voxels, expected at most 2147483648",
        ),
        (
            "sizes",
            "8192 8192 32",
            "has 6 bytes of data, expected 2147483648 for 8192 x 8192 x 32 uint8",
        ),
        ("spacings", "1 0 1", "has spacing 0 along y"),
        ("spacings", "1 1 -1", "has spacing -1 along z"),
        ("spacings", "nan 1 1", "has spacing NaN along x"),
        ("spacings", "1 inf 1", "has spacing inf along y"),
        ("spacings", "1 1", "field `spacings` is `1 1`"),
        (
            "space directions",
            "(1,1,0) (0,1,0) (0,0,1)",
            "field `spacings` is `1 1 2`, expected the lengths",
        ),
        (
            "encoding",
            "hex",
            "field `encoding` is `hex`, expected `raw`, `gzip`, `bzip2` or `ascii`",
        ),
        ("encoding", "", "no field `encoding`"),
        ("endian", "middle", "field `endian` is `middle`"),
        ("kinds", "RGB-color domain domain", "field `kinds`"),
        ("line skip", "-1", "field `line skip`"),
        ("line skip", "2", "ends inside the part to be skipped (`line skip`: 2)"),
        ("byte skip", "-2", "field `byte skip`"),
        ("byte skip", "1", "has 5 bytes of data after the 1 skipped, expected 6"),
        ("byte skip", "18446744073709551615", "has 0 bytes of data after"),
        (
            "hounsfield_offset:=1.5\ncontent",
            "x",
            "field `hounsfield_offset` is `1.5`",
        ),
        (
            "data file",
            "a.raw",
            "field `data file` is `a.raw`, expected no such field",
        ),
        ("data file", "/etc/passwd", "expected no such field"),
        ("data file", "../a.raw", "expected no such field"),
        ("data file", "a/../../b.raw", "expected no such field"),
        ("data file", "LIST", "expected no such field"),
        ("data file", "s%03d.raw 0 9 1", "expected no such field"),
    ] {
        let text = message(&[(field, value)], &six);
        assert!(
            text.starts_with("t.nrrd: ") && text.contains(expected),
            "{field}: {value}: {text}"
        );
    }
}

#[test]
fn axes_not_at_right_angles_are_refused() {
    let fields = [("spacings", ""), ("space directions", "(1,1,0) (0,1,0) (0,0,1)")];
    assert!(message(&fields, &[0; 6]).contains("has axes x and y at 45.00 degrees"));
}

#[test]
fn data_of_another_length_are_refused() {
    assert!(message(&[], &[0; 5]).contains("has 5 bytes of data, expected 6 for 3 x 2 x 1 uint8"));
    assert!(message(&[], &[0; 7]).contains("has 7 bytes of data, expected 6"));
    assert!(message(&[("byte skip", "-1")], &[0; 5]).contains("has 5 bytes of data, expected 6"));
    let packed = [("encoding", "gzip")];
    assert!(message(&packed, &gzip(&[0; 5])).contains("has 5 bytes of data that can be read, expected 6"));
    assert!(message(&packed, &gzip(&[0; 7])).contains("unpacks to more than the 6 bytes expected"));
    assert!(message(&[("encoding", "gzip"), ("byte skip", "9")], &gzip(&[0; 7])).contains("`byte skip`: 9"));
    assert!(message(&[("encoding", "gzip"), ("byte skip", "-1")], &gzip(&[0; 6])).contains("`byte skip` is `-1`"));
}

#[test]
fn damaged_packed_data_are_refused() {
    let packed = [("encoding", "gzip")];
    let whole = gzip(&[1, 2, 3, 4, 5, 6]);
    for len in 0..whole.len() {
        assert!(read_file(&packed, &whole[..len]).is_err(), "cut to {len}");
    }
    let mut flipped = whole.clone();
    let crc_at = flipped.len() - 8;
    flipped[crc_at] ^= 1;
    assert!(message(&packed, &flipped).contains("gzip data are damaged after 6 unpacked bytes of 6"));
    assert!(message(&packed, b"not gzip").contains("gzip data are damaged after 0"));
    // A small file that claims 2^31 voxels costs no more than what it unpacks to.
    let lying = [("encoding", "gzip"), ("sizes", "8192 8192 32")];
    assert!(message(&lying, &whole).contains("has 6 bytes of data that can be read, expected 2147483648"));
}

#[test]
fn values_that_are_no_numbers_are_refused() {
    let fields = [("type", "double"), ("endian", "little")];
    let mut values = [0.0_f64; 6];
    values[4] = f64::NAN;
    let text = message(&fields, &values.map(f64::to_le_bytes).concat());
    let expected = "expected finite numbers only; `--nan background` takes NaN for background";
    assert_eq!(text, format!("t.nrrd: voxel (1, 1, 0) is NaN, {expected}"));
}

#[test]
fn nan_is_background_on_demand() {
    let choice = Choice {
        nan: NanRule::Background,
        ..Choice::default()
    };
    let fields = [("type", "float"), ("endian", "little")];
    let read_values =
        |values: [f32; 6]| super::read_bytes(&file(&fields, &values.map(f32::to_le_bytes).concat()), "t", &choice);
    let volume = read_values([f32::NAN, 3.0, 0.5, f32::NAN, 9.0, 0.5]).unwrap();
    assert_eq!(volume.values(), &Values::F32(vec![0.5, 3.0, 0.5, 0.5, 9.0, 0.5]));
    assert!(
        volume.notes()[0].starts_with("2 of 6 voxels are NaN"),
        "{:?}",
        volume.notes()
    );
    let error = read_values([f32::NAN; 6]).unwrap_err().to_string();
    assert_eq!(error, "t: has no voxel that is a number, expected some beside NaN");
    let error = read_values([f32::NAN, f32::INFINITY, 0.0, 0.0, 0.0, 0.0])
        .unwrap_err()
        .to_string();
    assert_eq!(error, "t: voxel (1, 0, 0) is inf, expected finite numbers only");
}

#[test]
fn padding_after_gzip_is_left_out_with_a_note() {
    let packed = [("encoding", "gzip")];
    let whole = gzip(&[1, 2, 3, 4, 5, 6]);
    for tail in [&[0; 512][..], b"tail"] {
        let volume = read_file(&packed, &[whole.as_slice(), tail].concat()).unwrap();
        assert_eq!(volume.values(), &Values::U8(vec![1, 2, 3, 4, 5, 6]));
        assert_eq!(volume.notes(), ["bytes after the gzip data are left out"]);
    }
    // What begins as a member and is none is damage.
    assert!(message(&packed, &[whole.as_slice(), b"\x1f\x8bx"].concat()).contains("damaged"));
}

#[test]
fn axes_of_one_entry_are_left_out() {
    let six = [1, 2, 3, 4, 5, 6];
    for fields in [
        [("dimension", "4"), ("sizes", "3 2 1 1"), ("spacings", "1 1 2 nan")],
        [("dimension", "4"), ("sizes", "1 3 2 1"), ("spacings", "1 1 2 9")],
        [("dimension", "5"), ("sizes", "3 2 1 1 1"), ("spacings", "1 1 2 0 0")],
    ] {
        let volume = read_file(&fields, &six).unwrap();
        let leading = fields[1].1.starts_with('1');
        assert_eq!(volume.dims(), if leading { [1, 3, 2] } else { [3, 2, 1] });
        assert_eq!(volume.spacing(), [1.0, 1.0, 2.0]);
        assert!(volume.notes()[0].contains("of one entry"), "{:?}", volume.notes());
    }
    let vectors = [
        ("dimension", "4"),
        ("sizes", "1 3 2 1"),
        ("spacings", ""),
        ("kinds", "vector domain domain domain"),
        ("space", "left-posterior-superior"),
        ("space directions", "none (1,0,0) (0, 1, 0) (0,0,2)"),
    ];
    assert_eq!(read_file(&vectors, &six).unwrap().dims(), [3, 2, 1]);
    let between = [("dimension", "4"), ("sizes", "3 1 1 2"), ("spacings", "1 1 1 1")];
    assert_eq!(read_file(&between, &six).unwrap().dims(), [3, 1, 2]);
    let four = [("dimension", "4"), ("sizes", "3 2 2 2"), ("spacings", "1 1 1 1")];
    assert!(message(&four, &six).contains("`dimension` is `4`, expected 3"));
}

/// A folder with a detached header and files of two bytes each, `a1` to `a3` and `b1` to `b3`.
fn parts(data_file: &str, more: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (index, name) in ["a1", "a2", "a3"].iter().enumerate() {
        let first = 2 * index as u8 + 1;
        fs::write(folder.path().join(format!("{name}.raw")), [first, first + 1]).unwrap();
        fs::write(folder.path().join(format!("{name}.gz")), gzip(&[first, first + 1])).unwrap();
    }
    let header = folder.path().join("h.nhdr");
    let fields = [("sizes", "2 1 3"), ("data file", data_file)];
    let text = String::from_utf8(file(&fields, &[])).unwrap();
    fs::write(&header, text.trim_end().to_owned() + "\n" + more).unwrap();
    (folder, header)
}

#[test]
fn data_in_many_files_are_joined() {
    let expected = Values::U8(vec![1, 2, 3, 4, 5, 6]);
    for (data_file, names) in [
        ("LIST", "a1.raw\na2.raw\na3.raw\n"),
        ("LIST 2", "a1.raw\na2.raw\na3.raw"),
        ("LIST 3", "a1.raw\na2.raw\na3.raw\n\n"),
        ("LIST 1", "a1.raw\na2.raw\na3.raw\n"),
        ("a%d.raw 1 3 1", ""),
        ("a%01d.raw 1 3 1 2", ""),
    ] {
        let (_folder, header) = parts(data_file, names);
        let volume = read(&header).unwrap();
        assert_eq!((volume.values(), volume.dims()), (&expected, [2, 1, 3]), "{data_file}");
        assert_eq!(volume.notes(), ["the data are in 3 files"]);
    }
    let (_folder, header) = parts("a%d.raw 3 1 -1", "");
    assert_eq!(read(&header).unwrap().values(), &Values::U8(vec![5, 6, 3, 4, 1, 2]));
    let (_folder, header) = parts("a%d.gz 1 3 1", "");
    let text = fs::read_to_string(&header)
        .unwrap()
        .replace("encoding: raw", "encoding: gzip");
    fs::write(&header, text).unwrap();
    assert_eq!(read(&header).unwrap().values(), &expected);
}

#[test]
fn files_that_do_not_make_up_the_volume_are_refused() {
    for (data_file, names, expected) in [
        (
            "LIST",
            "a1.raw\na2.raw\n",
            "h.nhdr: data in many files: 2 files are named, expected 3 slices",
        ),
        (
            "LIST",
            "",
            "h.nhdr: data in many files: 0 files are named, expected 3 slices",
        ),
        ("LIST x", "a1.raw\n", "a number of axes, 1 to 3"),
        ("LIST 4", "a1.raw\n", "expected files of 1 to 3 axes"),
        ("LIST", "a1.raw\na2.raw\n../h.nhdr\n", "names the data file `../h.nhdr`"),
        (
            "LIST",
            "a1.raw\na2.raw\n/etc/passwd\n",
            "names the data file `/etc/passwd`",
        ),
        ("LIST", "a1.raw\na2.raw\nh.nhdr\n", "h.nhdr: has "),
        ("a%d.raw 1 4 1", "", "4 files are named, expected 3 slices"),
        ("a%d.raw 2 4 1", "", "a4.raw: cannot find the file"),
        ("a%d.raw 1 999999999 1", "", "at most 65536 files"),
        ("a%s.raw 1 3 1", "", "one `%d`, `%i` or `%u`"),
        ("a%d.raw 1 3 x", "", "PATTERN FIRST LAST STEP"),
    ] {
        let (_folder, header) = parts(data_file, names);
        let text = read(&header).unwrap_err().to_string();
        assert!(text.contains(expected), "{data_file}: {text}");
    }
}

#[test]
fn long_integers_in_many_files_have_one_type() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("0"), (-7_i64).to_le_bytes()).unwrap();
    fs::write(folder.path().join("1"), (1_i64 << 40).to_le_bytes()).unwrap();
    let header = folder.path().join("h.nhdr");
    let fields = [
        ("type", "int64"),
        ("endian", "little"),
        ("sizes", "1 1 2"),
        ("data file", "%d 0 1 1"),
    ];
    fs::write(&header, file(&fields, &[])).unwrap();
    assert_eq!(
        read(&header).unwrap().values(),
        &Values::F64(vec![-7.0, (1_i64 << 40) as f64])
    );
}

#[test]
fn data_files_are_looked_for_beside_the_header() {
    let folder = tempfile::tempdir().unwrap();
    let header = folder.path().join("h.nhdr");
    let with = |data_file| fs::write(&header, file(&[("data file", data_file)], &[])).unwrap();
    for outside in ["/etc/passwd", "../a.raw", "a/../../b.raw"] {
        with(outside);
        let text = read(&header).unwrap_err().to_string();
        assert!(text.contains("in its own folder or below it"), "{text}");
    }
    with("none.raw");
    let text = read(&header).unwrap_err().to_string();
    assert!(text.contains("none.raw: cannot find the file: "), "{text}");
    fs::create_dir(folder.path().join("sub")).unwrap();
    with("sub");
    assert!(
        read(&header)
            .unwrap_err()
            .to_string()
            .contains("sub: is a folder, expected a regular file")
    );
    fs::write(folder.path().join("sub/v.raw"), [7; 6]).unwrap();
    with("sub/v.raw");
    assert_eq!(read(&header).unwrap().values(), &Values::U8(vec![7; 6]));
    fs::write(
        &header,
        b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 1\nencoding: raw",
    )
    .unwrap();
    let text = read(&header).unwrap_err().to_string();
    assert!(text.ends_with("header ends without an empty line and names no `data file`, expected one of the two"));
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
        packed: bool,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        swap in prop::option::of((any::<prop::sample::Index>(), any::<prop::sample::Index>())),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let fields = [("type", "short"), ("endian", "big"), ("encoding", if packed { "gzip" } else { "raw" }),
            ("space directions", "(1,0,0) (0,1,0) (0,0,2)"), ("byte skip", "1"), ("line skip", "1")];
        let data = if packed { gzip(&[0; 13]) } else { vec![0; 13] };
        let mut bytes = file(&fields, &[b"line\n", data.as_slice()].concat());
        prop_assert!(read_bytes(&bytes, "t").is_ok());
        if let Some((a, b)) = swap {
            let (a, b) = (a.index(bytes.len()), b.index(bytes.len()));
            bytes.swap(a, b);
        }
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(volume) = read_bytes(&bytes, "t") {
            prop_assert_eq!(volume.values().len(), volume.dims().iter().product::<usize>());
        }
    }

    /// Numbers of any form in the fields that decide sizes.
    #[test]
    fn any_numbers_never_panic(
        sizes in prop::collection::vec(any::<i64>(), 0..5),
        spacings in prop::collection::vec(any::<f64>(), 0..5),
        skip: i64,
        lines: i64,
    ) {
        let words = |numbers: Vec<String>| numbers.join(" ");
        let sizes = words(sizes.iter().map(i64::to_string).collect());
        let spacings = words(spacings.iter().map(f64::to_string).collect());
        let (skip, lines) = (skip.to_string(), lines.to_string());
        let fields = [("sizes", sizes.as_str()), ("spacings", &spacings), ("byte skip", &skip), ("line skip", &lines)];
        prop_assert!(read_file(&fields, &[0; 6]).is_err());
    }
}
