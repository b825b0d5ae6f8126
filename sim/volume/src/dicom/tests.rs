//! Files made element by element: syntaxes, order, orientation; every refusal; mutated files.

mod field;
mod frames;
mod packed;

use proptest::prelude::*;

use super::*;
use crate::choice::Series;
use crate::decoded::Orientation;
use crate::meaning::Modality;
use crate::values::Values;

const EXPLICIT: &str = "1.2.840.10008.1.2.1";

/// An element in explicit little endian.
fn element(tag: (u16, u16), kind: &str, value: &[u8]) -> Vec<u8> {
    let mut out = [tag.0.to_le_bytes(), tag.1.to_le_bytes()].concat();
    out.extend(kind.as_bytes());
    if ["OW", "OB", "SQ", "UN"].contains(&kind) {
        out.extend([0, 0]);
        out.extend((value.len() as u32).to_le_bytes());
    } else {
        out.extend((value.len() as u16).to_le_bytes());
    }
    out.extend(value);
    out
}

/// The same in implicit little endian.
fn implicit(tag: (u16, u16), value: &[u8]) -> Vec<u8> {
    let head = [tag.0.to_le_bytes(), tag.1.to_le_bytes()].concat();
    [head, (value.len() as u32).to_le_bytes().to_vec(), value.to_vec()].concat()
}

type Field = ((u16, u16), &'static str, Vec<u8>);

fn text(tag: (u16, u16), kind: &'static str, value: &str) -> Field {
    (tag, kind, value.as_bytes().to_vec())
}

fn short(tag: (u16, u16), value: u16) -> Field {
    (tag, "US", value.to_le_bytes().to_vec())
}

/// The fields of a slice of 2 x 2 signed 16-bit pixels at z = 2.5 * i; its pixels are 10 i … 10 i + 3.
fn fields(i: i16) -> Vec<Field> {
    vec![
        text((0x0008, 0x0060), "CS", "CT"),
        text((0x0020, 0x000e), "UI", "1.2.3\0"),
        text((0x0020, 0x0011), "IS", "7 "),
        text((0x0020, 0x0032), "DS", &format!("0\\0\\{}", 2.5 * f64::from(i))),
        text((0x0020, 0x0037), "DS", "1\\0\\0\\0\\1\\0"),
        short((0x0028, 0x0002), 1),
        text((0x0028, 0x0004), "CS", "MONOCHROME2 "),
        short((0x0028, 0x0010), 2),
        short((0x0028, 0x0011), 2),
        text((0x0028, 0x0030), "DS", "0.5\\0.75"),
        short((0x0028, 0x0100), 16),
        short((0x0028, 0x0101), 16),
        short((0x0028, 0x0102), 15),
        short((0x0028, 0x0103), 1),
        text((0x0028, 0x1052), "DS", "-1024 "),
        text((0x0028, 0x1053), "DS", "1 "),
        (
            (0x7fe0, 0x0010),
            "OW",
            (0..4).flat_map(|p| (10 * i + p).to_le_bytes()).collect(),
        ),
    ]
}

fn file_of(fields: &[Field], syntax: &str) -> Vec<u8> {
    let mut out = vec![0; 128];
    out.extend(b"DICM");
    out.extend(element((0x0002, 0x0010), "UI", syntax.as_bytes()));
    for (tag, kind, value) in fields {
        if syntax == "1.2.840.10008.1.2" {
            out.extend(implicit(*tag, value));
        } else {
            out.extend(element(*tag, kind, value));
        }
    }
    out
}

/// A slice with fields replaced, or added where they belong.
fn slice(i: i16, changes: &[Field]) -> Vec<u8> {
    let mut all = fields(i);
    all.retain(|(tag, ..)| !changes.iter().any(|(other, ..)| other == tag));
    all.extend(changes.iter().cloned());
    all.sort_by_key(|(tag, ..)| *tag);
    file_of(&all, EXPLICIT)
}

fn read_all(files: Vec<Vec<u8>>) -> Result<Decoded, ReadError> {
    let named: Vec<_> = files
        .into_iter()
        .enumerate()
        .map(|(i, bytes)| (format!("{i}.dcm"), bytes))
        .collect();
    read_bytes(&named, "series", &Choice::default())
}

fn message(files: Vec<Vec<u8>>) -> String {
    read_all(files).unwrap_err().to_string()
}

/// Three slices, one of them changed.
fn with(changes: &[Field]) -> String {
    message(vec![slice(0, &[]), slice(1, changes), slice(2, &[])])
}

#[test]
fn slices_are_put_in_order_by_position() {
    for syntax in [EXPLICIT, "1.2.840.10008.1.2"] {
        let volume = read_all([2, 0, 1].map(|i| file_of(&fields(i), syntax)).to_vec()).unwrap();
        assert_eq!((volume.dims(), volume.spacing()), ([2, 2, 3], [0.75, 0.5, 2.5]));
        assert_eq!(
            volume.values(),
            &Values::I16(vec![0, 1, 2, 3, 10, 11, 12, 13, 20, 21, 22, 23])
        );
        assert_eq!(
            (volume.value_offset(), volume.modality()),
            (-1024.0, Some(Modality::Ct))
        );
        assert!(matches!(volume.orientation(), Orientation::Patient { file_axes, .. } if file_axes == "LPS"));
    }
}

#[test]
fn bit_fields_and_signs_are_decoded() {
    let twelve = [short((0x0028, 0x0101), 12), short((0x0028, 0x0102), 11)];
    let pixels = (
        (0x7fe0, 0x0010),
        "OW",
        [0xf7ff_u16, 0x0800, 0x0fff, 0x0001].map(u16::to_le_bytes).concat(),
    );
    let signed = [&twelve[..], &[pixels]].concat();
    let volume = read_all(vec![slice(0, &signed)]).unwrap();
    assert_eq!(volume.values(), &Values::I16(vec![0x7ff, -2048, -1, 1]));
    let unsigned = [&signed[..], &[short((0x0028, 0x0103), 0)]].concat();
    let volume = read_all(vec![slice(0, &unsigned)]).unwrap();
    assert_eq!(volume.values(), &Values::U16(vec![0x7ff, 0x800, 0xfff, 1]));
}

#[test]
fn slices_of_other_scales_meet_in_the_datas_unit() {
    let volume = read_all(vec![slice(0, &[]), slice(1, &[text((0x0028, 0x1053), "DS", "2")])]).unwrap();
    let expected = vec![-1024.0, -1023.0, -1022.0, -1021.0, -1004.0, -1002.0, -1000.0, -998.0];
    assert_eq!(volume.values(), &Values::F32(expected));
}

#[test]
fn rle_is_unpacked() {
    // Two segments: the high bytes are a run of four zeros, the low bytes a literal run.
    let mut frame: Vec<u8> = [2_u32, 64, 66].iter().flat_map(|word| word.to_le_bytes()).collect();
    frame.resize(64, 0);
    frame.extend([0xfd, 0, 3, 5, 6, 7, 8, 0]);
    let item = |bytes: &[u8]| {
        [
            &[0xfe, 0xff, 0x00, 0xe0][..],
            &(bytes.len() as u32).to_le_bytes(),
            bytes,
        ]
        .concat()
    };
    let build = |frame: &[u8]| {
        let mut all = fields(0);
        all.pop();
        let mut file = file_of(&all, "1.2.840.10008.1.2.5");
        file.extend([0xe0, 0x7f, 0x10, 0, b'O', b'B', 0, 0, 255, 255, 255, 255]);
        file.extend([item(&[]), item(frame), vec![0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]].concat());
        file
    };
    let volume = read_all(vec![build(&frame)]).unwrap();
    assert_eq!(volume.values(), &Values::I16(vec![5, 6, 7, 8]));
    for (at, byte, expected) in [
        (0, 3, "have 3 segments, expected 2"),
        (4, 255, "outside their frame"),
        (66, 9, "inside a literal run"),
    ] {
        let mut damaged = frame.clone();
        damaged[at] = byte;
        let text = message(vec![build(&damaged)]);
        assert!(text.contains(expected), "{text}");
    }
    assert!(message(vec![build(&frame[..67])]).contains("RLE pixel data"));
}

#[test]
fn series_are_told_apart() {
    let other = [text((0x0020, 0x000e), "UI", "9.9"), text((0x0020, 0x0011), "IS", "8")];
    let files: Vec<_> = [slice(0, &[]), slice(1, &[]), slice(0, &other)].to_vec();
    let volume = read_all(files.clone()).unwrap();
    assert_eq!(volume.dims()[2], 2);
    assert!(
        volume.notes()[0].contains("several series: shown is series 7"),
        "{:?}",
        volume.notes()
    );
    let named: Vec<_> = files
        .into_iter()
        .enumerate()
        .map(|(i, bytes)| (format!("{i}"), bytes))
        .collect();
    let choose = |name: &str| {
        let choice = Choice {
            series: Series::Named(name.into()),
            ..Choice::default()
        };
        read_bytes(&named, "s", &choice)
    };
    assert_eq!(choose("8").unwrap().dims()[2], 1);
    assert_eq!(choose("9.9").unwrap().dims()[2], 1);
    let text = choose("5").unwrap_err().to_string();
    assert!(text.contains("has no series `5`, expected one of: series 7"), "{text}");
}

#[test]
fn stacks_that_are_no_volume_are_refused() {
    let at = |z: &str| text((0x0020, 0x0032), "DS", z);
    let gap = message(vec![slice(0, &[]), slice(1, &[]), slice(2, &[]), slice(4, &[])]);
    assert!(
        gap.contains("1 slices are missing, first between 2.dcm at 5.000 mm and 3.dcm at 10.000 mm"),
        "{gap}"
    );
    for (change, expected) in [
        (at("0\\0\\3.1"), "slices are unevenly spaced"),
        (
            at("0\\0\\0"),
            "slices share a position (0.dcm at 0.000 mm and 1.dcm at 0.000 mm)",
        ),
        (
            at("0\\0.5\\2.5"),
            "slices are shifted against each other: 1.dcm lies 0.333 mm aside, expected at most 0.250 mm",
        ),
        (at(""), "1.dcm states no position"),
        (
            at("0\\0"),
            "1.dcm: DICOM: element (0020,0032) is `0\\\\0`, expected 3 finite numbers",
        ),
        (at("0\\nan\\1"), "expected 3 finite numbers"),
        (
            text((0x0028, 0x0030), "DS", "0.5\\0.5"),
            "1.dcm has pixel spacing [0.5, 0.5], expected [0.75, 0.5]",
        ),
        (
            text((0x0028, 0x0004), "CS", "RGB"),
            "photometric interpretation RGB is not read",
        ),
        (
            short((0x0028, 0x0002), 3),
            "1.dcm: DICOM: a picture of 3 samples per pixel is not read",
        ),
        (
            text((0x0028, 0x0008), "IS", "12"),
            "a file of 12 frames that does not say where each lies is not read",
        ),
        (short((0x0028, 0x0100), 12), "bits allocated 12, stored 16, high bit 15"),
        (short((0x0028, 0x0101), 0), "bits allocated 16, stored 0"),
        (short((0x0028, 0x0102), 3), "high bit 3"),
        (
            ((0x7fe0, 0x0010), "OW", vec![0; 6]),
            "1.dcm: DICOM: has 6 bytes of pixels, expected 8 for 2 x 2 of 16 bits",
        ),
        (text((0x0028, 0x1053), "DS", "inf"), "expected 1 finite numbers"),
    ] {
        let message = with(&[change]);
        assert!(message.contains(expected), "{message}");
    }
    let all = |change: Field| message([0, 1].map(|i| slice(i, std::slice::from_ref(&change))).to_vec());
    assert!(all(text((0x0028, 0x1053), "DS", "0")).contains("values are scaled by 0"));
    assert!(all(text((0x0028, 0x0030), "DS", "0\\-1")).contains("has spacing"));
    assert!(all(text((0x0020, 0x0037), "DS", "1\\0\\0\\1\\0\\0")).contains("is not two unit vectors"));
    assert!(all(text((0x0020, 0x0037), "DS", "")).contains("states no orientation"));
    assert!(all(short((0x0028, 0x0010), 0)).contains("has 0 voxels along y"));
    assert!(all(short((0x0028, 0x0010), 65535)).contains("has 65535 voxels along y"));
}

#[test]
fn damaged_files_are_refused() {
    let whole = slice(0, &[]);
    for len in 0..whole.len() - 1 {
        // Cut between two fields before the image begins, it is a sound file without one.
        assert!(read_all(vec![whole[..len].to_vec()]).is_err(), "cut to {len}");
    }
    let text = message(vec![whole[..whole.len() - 3].to_vec()]);
    assert!(
        text.contains("element (7FE0,0010) at byte") && text.contains("claims 8 bytes, the file has 5 left"),
        "{text}"
    );
    assert!(message(vec![vec![0; 200]]).contains("has no `DICM` after a preamble"));
    let unread = |syntax: &str| message(vec![file_of(&fields(0), syntax)]);
    assert!(unread("1.2.840.10008.1.2.4.110").contains("(JPEG XL) is not read"));
    assert!(unread("1.2").contains("transfer syntax 1.2 (unknown)"));
    assert!(message(vec![file_of(&[], "1.2.840.10008.1.2.1.99")]).contains("deflated data are damaged"));
    assert!(message(Vec::new()).contains("has no DICOM image"));
    // A sequence in a sequence, and so on.
    let mut deep = file_of(&[], EXPLICIT);
    for _ in 0..100_000 {
        deep.extend([
            0x08, 0, 0x10, 0x11, b'S', b'Q', 0, 0, 255, 255, 255, 255, 0xfe, 0xff, 0, 0xe0, 255, 255, 255, 255,
        ]);
    }
    assert!(message(vec![deep.clone()]).contains("sequences nest deeper than 64"));
    deep.truncate(file_of(&[], EXPLICIT).len() + 10 * 20);
    assert!(message(vec![deep]).contains("has no end"));
    let huge = element((0x0009, 0x0001), "UN", &[]);
    let mut lying = file_of(&[], EXPLICIT);
    lying.extend(&huge[..8]);
    lying.extend(0xffff_fff0_u32.to_le_bytes());
    assert!(message(vec![lying]).contains("claims 4294967280 bytes, the file has 0 left"));
}

#[test]
fn folders_are_read_by_content() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    assert!(matches!(
        read_folder(folder.path(), &Choice::default()).unwrap_err().problem,
        Problem::NoImages
    ));
    put("z", &slice(0, &[]));
    put("a.dcm", &slice(1, &[]));
    put("notes.txt", b"text");
    put("empty", b"");
    put("DICOMDIR", &file_of(&[], EXPLICIT));
    let volume = read_folder(folder.path(), &Choice::default()).unwrap();
    assert_eq!(volume.values(), &Values::I16(vec![0, 1, 2, 3, 10, 11, 12, 13]));
    let notes = volume.notes();
    assert!(
        notes[0].contains("3 files are no DICOM images: DICOMDIR, empty, notes.txt"),
        "{notes:?}"
    );
    assert_eq!(
        read_with_file(&folder.path().join("z"), &Choice::default())
            .unwrap()
            .dims(),
        [2, 2, 2]
    );
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
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = slice(1, &[]);
        for (at, byte) in edits {
            let at = 128 + at.index(bytes.len() - 128);
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        match read_all(vec![slice(0, &[]), bytes, slice(2, &[])]) {
            Ok(volume) => prop_assert_eq!(volume.values().len(), volume.dims().iter().product::<usize>()),
            Err(error) => prop_assert!(!error.to_string().contains('\n')),
        }
    }
}
