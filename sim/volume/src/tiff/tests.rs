//! Stacks written by the library itself; every refusal; mutated files.

use proptest::prelude::*;
use tiff::encoder::{Compression, TiffEncoder, colortype};

use tiff::tags::Tag;

use super::*;
use crate::values::Values;

/// As [`super::read_bytes`], without a choice.
fn read_bytes(bytes: &[u8], name: &str) -> Result<Decoded, ReadError> {
    super::read_bytes(bytes, name, &Choice::default())
}

/// As [`super::read_folder`], without a choice.
fn read_folder(path: &Path) -> Result<Decoded, ReadError> {
    super::read_folder(path, &Choice::default())
}

/// Pages of 3 x 2 16-bit pixels, values 10 i … 10 i + 5.
fn stack(pages: u16, compression: Compression) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap().with_compression(compression);
    for page in 0..pages {
        let values: Vec<u16> = (0..6).map(|i| 10 * page + i).collect();
        encoder.write_image::<colortype::Gray16>(3, 2, &values).unwrap();
    }
    out.into_inner()
}

fn message(bytes: &[u8]) -> String {
    read_bytes(bytes, "t.tif").unwrap_err().to_string()
}

#[test]
fn pages_become_slices() {
    for compression in [Compression::Uncompressed, Compression::Lzw, Compression::Packbits] {
        let volume = read_bytes(&stack(2, compression), "t").unwrap();
        assert_eq!((volume.dims(), volume.spacing()), ([3, 2, 2], [1.0; 3]));
        assert_eq!(
            volume.values(),
            &Values::U16(vec![0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 15])
        );
    }
}

#[test]
fn imagej_states_spacing() {
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    let mut image = encoder.new_image::<colortype::Gray8>(1, 1).unwrap();
    let text = "ImageJ=1.53\nimages=1\nunit=mm\nspacing=2.5\n";
    image.encoder().write_tag(Tag::ImageDescription, text).unwrap();
    image.x_resolution(tiff::encoder::Rational { n: 4, d: 1 });
    image.y_resolution(tiff::encoder::Rational { n: 2, d: 1 });
    image.write_data(&[7]).unwrap();
    let volume = read_bytes(&out.into_inner(), "t").unwrap();
    assert_eq!(volume.spacing(), [0.25, 0.5, 2.5]);
}

#[test]
fn folders_are_read_in_the_order_of_numbers() {
    let folder = tempfile::tempdir().unwrap();
    assert!(
        read_folder(folder.path())
            .unwrap_err()
            .to_string()
            .contains("has no page")
    );
    for (name, value) in [("s10.tif", 10), ("s9.tiff", 9), ("S.txt", 0)] {
        let mut out = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut out).unwrap();
        encoder.write_image::<colortype::Gray8>(1, 1, &[value]).unwrap();
        std::fs::write(folder.path().join(name), out.into_inner()).unwrap();
    }
    assert_eq!(read_folder(folder.path()).unwrap().values(), &Values::U8(vec![9, 10]));
    assert_eq!(crate::open::read(folder.path()).unwrap().dims(), [1, 1, 2]);
}

#[test]
fn other_files_are_refused() {
    assert!(message(b"").starts_with("t.tif: TIFF: "));
    assert!(message(b"II*\0\xff\xff\xff\xff").starts_with("t.tif: TIFF: "));
    let whole = stack(2, Compression::Lzw);
    for len in 0..whole.len() {
        assert!(read_bytes(&whole[..len], "t").is_err(), "cut to {len}");
    }
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    encoder.write_image::<colortype::RGB8>(1, 1, &[1, 2, 3]).unwrap();
    assert!(message(&out.into_inner()).contains("a page of colour type RGB(8) is not read"));
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    encoder.write_image::<colortype::Gray8>(1, 1, &[1]).unwrap();
    encoder.write_image::<colortype::Gray8>(2, 1, &[1, 2]).unwrap();
    assert!(message(&out.into_inner()).contains("page 2 is 2 x 1, expected 1 x 1"));
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    encoder.write_image::<colortype::Gray8>(1, 1, &[1]).unwrap();
    encoder.write_image::<colortype::Gray16>(1, 1, &[1]).unwrap();
    assert!(message(&out.into_inner()).contains("page 2 is of type uint16, expected uint8"));
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    encoder
        .write_image::<colortype::Gray32Float>(1, 1, &[f32::NAN])
        .unwrap();
    assert!(message(&out.into_inner()).contains("voxel (0, 0, 0) is NaN"));
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
        let mut bytes = stack(2, if packed { Compression::Lzw } else { Compression::Uncompressed });
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

/// A page of two pixels for each text of colours.
fn coloured<C: colortype::ColorType<Inner = u8>>(pages: &[&[u8]]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap().with_compression(Compression::Lzw);
    for page in pages {
        encoder.write_image::<C>(2, 1, page).unwrap();
    }
    out.into_inner()
}

#[test]
fn colours_are_read_by_who_asks_for_them() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("c.tif");
    let pages: [&[u8]; 2] = [b"abcdef", b"ghijkl"];
    std::fs::write(&path, coloured::<colortype::RGB8>(&pages)).unwrap();
    let colours = crate::open::read_colours(&path, &Choice::default()).unwrap().unwrap();
    assert_eq!((colours.dims(), colours.components()), ([2, 1, 2], 3));
    assert_eq!(colours.values(), &Values::U8(b"abcdefghijkl".to_vec()));
    let four: [&[u8]; 1] = [b"abcdefgh"];
    let rgba = coloured::<colortype::RGBA8>(&four);
    std::fs::write(&path, &rgba).unwrap();
    let colours = crate::open::read_colours(&path, &Choice::default()).unwrap().unwrap();
    assert_eq!((colours.dims(), colours.components()), ([2, 1, 1], 4));
    assert_eq!(colours.values(), &Values::U8(b"abcdefgh".to_vec()));
    assert!(message(&rgba).contains("a page of colour type RGBA(8) is not read"));
    let second = Choice {
        time: Some(2),
        ..Choice::default()
    };
    let message = crate::open::read_colours(&path, &second).unwrap_err().to_string();
    assert!(
        message.contains("has 1 time point, expected one of them: time point 2"),
        "{message}"
    );
    std::fs::write(&path, stack(1, Compression::Lzw)).unwrap();
    assert_eq!(crate::open::read_colours(&path, &Choice::default()).unwrap(), None);
}

#[test]
fn folders_of_colours_have_pages_of_one_kind() {
    let place = tempfile::tempdir().unwrap();
    assert_eq!(
        crate::open::read_colours(place.path(), &Choice::default()).unwrap(),
        None
    );
    let write = |name: &str, bytes: Vec<u8>| std::fs::write(place.path().join(name), bytes).unwrap();
    write("s2.tif", coloured::<colortype::RGB8>(&[b"ghijkl"]));
    write("s1.tif", coloured::<colortype::RGB8>(&[b"abcdef"]));
    let colours = crate::open::read_colours(place.path(), &Choice::default())
        .unwrap()
        .unwrap();
    assert_eq!(colours.values(), &Values::U8(b"abcdefghijkl".to_vec()));
    assert!(colours.notes()[0].contains("2 files in the order of the numbers"));
    write("s3.tif", coloured::<colortype::RGBA8>(&[b"abcdefgh"]));
    let message = crate::open::read_colours(place.path(), &Choice::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("s3.tif: TIFF: page 3 has 4 colours a pixel, expected 3"),
        "{message}"
    );
    write("s3.tif", stack(1, Compression::Lzw));
    let message = crate::open::read_colours(place.path(), &Choice::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("Gray(16) is not read, expected RGB or RGBA of 8 or 16 bits"),
        "{message}"
    );
}

/// Tags whose meaning is not that of straight colours side by side.
#[test]
fn colours_of_another_meaning_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("c.tif");
    let mut out = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    let mut image = encoder.new_image::<colortype::RGBA8>(2, 1).unwrap();
    image.encoder().write_tag(Tag::ExtraSamples, &[1_u16][..]).unwrap();
    image.write_data(b"abcdefgh").unwrap();
    std::fs::write(&path, out.into_inner()).unwrap();
    let message = crate::open::read_colours(&path, &Choice::default())
        .unwrap_err()
        .to_string();
    assert!(message.contains("associated opacity is not read"), "{message}");
}
