//! Frames packed by JPEG, JPEG-LS and JPEG 2000: equal to what other programs packed, and every way to be damaged.
//!
//! The frames hold [`picture`] and were packed by imagecodecs 2026.3.6, which wraps libjpeg-turbo, CharLS and OpenJPEG:
//! `jpeg8_encode(v, lossless=True, predictor=P, bitspersample=B, optimize=True)`, `jpeg8_encode(v >> 4, level=95,
//! optimize=True)`, `jpegls_encode(v, level=NEAR)`, `jpeg2k_encode(v, level=L, reversible=R, codecformat="j2k",
//! resolutions=3)`.

use super::*;

const JPEG: &str = "1.2.840.10008.1.2.4.70";
const JPEG_LS: &str = "1.2.840.10008.1.2.4.80";
const JPEG_2000: &str = "1.2.840.10008.1.2.4.90";

/// 16 bits, predictor 1.
const LOSSLESS_FIRST_HEX: &str = "ffd8ffe000104a46494600010100000100010000ffc3000b100006000801011100ffc4001b00010100030003000000000000\
    00000000090806070a050c10ffda0008010100010000fbcfedda6ed945d5564fa05cb37555173248b1341d02e73bdeb5bcd3\
    15bdade81763509612009f2f8dd740bb4e91b3d0d52d8971fa05dc14f5b88d2b0cb7a3a7ffd9";
/// 12 bits, predictor 7.
const LOSSLESS_SEVENTH_HEX: &str = "ffd8ffe000104a46494600010100000100010000ffc3000b0c0006000801011100ffc4001900010100030100000000000000\
    00000000090a05080c07ffda0008010100070000e7ff00cffaeecdeeca2eaab2740a8fa8ab5320dabb740140a93296b8b2cd\
    e3c340f40a962a4bbb3ae13d141b40a99ab0bf346e4bdd42940a9cabec2354e7bebc433fffd9";
/// 8 bits.
const WITH_LOSS_HEX: &str = "ffd8ffe000104a46494600010100000100010000ffdb00430002010101010102010101020202020204030202020205040403\
    04060506060605060606070908060709070606080b08090a0a0a0a0a06080b0c0b0a0c090a0a0affc0000b08000600080101\
    1100ffc40014000100000000000000000000000000000004ffc4001d10000202030101010000000000000000000102030405\
    0608070911ffda0008010100003f006f307c74e66f05d1b69e8cf40aab6f09a16af91d933357154d64b5355a35a4b53242b2\
    144694a44c1433aa96201651fa47ffd9";
/// 16 bits.
const JPEG_LS_HEX: &str = "ffd8ffe800205350494646000200000100000006000000080a1006010000012c0000012cffe8000800000001ffd8fff7000b\
    100006000801011100fff8000d01ffff0012004301140040ffda0008010100000000a1ecb9a6b6c715aa563e8151626a54eb\
    999236174040a8e1756c97932f2d8eb081144601bd7f89d17777040aa69146390a28a609e210235c943448b15031a0117cff\
    d9";
/// 16 bits, at most 2 off.
const JPEG_LS_NEAR_HEX: &str = "ffd8ffe800205350494646000200000100000006000000080a1006010000012c0000012cffe8000800000001ffd8fff7000b\
    100006000801011100fff8000d01ffff0018004d01220040ffda0008010100020000a17259eeadbf0e9fe744a5589b576c76\
    9ba12d5d9160bd24b55ce9ce499c9fc985873b0784eec412696dcec9e953c10ca00015a0ffd9";
/// 16 bits, unsigned.
const JPEG_2000_HEX: &str = "ff4fff5100290000000000080000000600000000000000000000000800000006000000000000000000010f0101ff52000c00\
    000001000004040001ff5c00044080ff640025000143726561746564206279204f70656e4a5045472076657273696f6e2032\
    2e352e34ff90000a0000000000640001ff93dff8929012281a4d226d5803ff4f572cbc608884627b7c207fe2750cd6942bde\
    ad031489a74caa465277abb2e78e6dd8f2b2a8badace74639f9e419aca828d428b49457d32dfb7b0ba82b94a38487c6a31bc\
    11898319ffd9";
/// 16 bits, less 2048.
const JPEG_2000_SIGNED_HEX: &str = "ff4fff5100290000000000080000000600000000000000000000000800000006000000000000000000018f0101ff52000c00\
    000001000004040001ff5c00044080ff640025000143726561746564206279204f70656e4a5045472076657273696f6e2032\
    2e352e34ff90000a0000000000590001ff93c1fe11c01229d111a64d5be6a6e5b059b724c50df4ae630c8dce829786dff05a\
    cb0cbd7971bc534040b2200a6e5412109e10ce161595ba1574d40f57027dd3455973a7a03af969bafa1957ffd9";
/// 16 bits, with the wavelet that loses.
const JPEG_2000_LOSSY_HEX: &str = "ff4fff5100290000000000080000000600000000000000000000000800000006000000000000000000010f0101ff52000d01\
    02000100000404000088ff5c0005428000ff640025000143726561746564206279204f70656e4a5045472076657273696f6e\
    20322e352e34ff90000a0000000000330001ff93df791012281a4d226d5803ff4f572cbc608884627b7c207fe2750cd6942b\
    dead031489a74cffd9";

/// What the frames hold: 8 x 6 pixels of 12 bits.
fn picture() -> Vec<i64> {
    let pixel = |(y, x): (i64, i64)| (x * x * 31 + y * 517 + x * y * 13) % 4096;
    (0..6).flat_map(|y| (0..8).map(move |x| (y, x))).map(pixel).collect()
}

fn bytes_of(hex: &str) -> Vec<u8> {
    let digit = |c: u8| char::from(c).to_digit(16).unwrap() as u8;
    let pairs = hex.as_bytes().chunks_exact(2);
    pairs.map(|pair| digit(pair[0]) << 4 | digit(pair[1])).collect()
}

/// Items of pixel data, and their end.
pub(super) fn items(fragments: &[&[u8]]) -> Vec<u8> {
    let mut out = Vec::new();
    for fragment in fragments {
        out.extend([0xfe, 0xff, 0x00, 0xe0]);
        out.extend((fragment.len() as u32).to_le_bytes());
        out.extend(*fragment);
    }
    out.extend([0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]);
    out
}

/// A file of 8 x 6 pixels with these fields and fragments.
pub(super) fn packed(syntax: &str, changes: &[Field], fragments: &[&[u8]]) -> Vec<u8> {
    let mut all = fields(0);
    all.pop();
    let size = [short((0x0028, 0x0010), 6), short((0x0028, 0x0011), 8)];
    let changes = [&size[..], changes].concat();
    all.retain(|(tag, ..)| !changes.iter().any(|(other, ..)| other == tag));
    all.extend(changes);
    all.sort_by_key(|(tag, ..)| *tag);
    let mut file = file_of(&all, syntax);
    file.extend([0xe0, 0x7f, 0x10, 0, b'O', b'B', 0, 0, 255, 255, 255, 255]);
    file.extend(items(fragments));
    file
}

/// Unsigned pixels of so many bits.
pub(super) fn unsigned(allocated: u16, stored: u16) -> Vec<Field> {
    vec![
        short((0x0028, 0x0100), allocated),
        short((0x0028, 0x0101), stored),
        short((0x0028, 0x0102), stored - 1),
        short((0x0028, 0x0103), 0),
    ]
}

fn read_one(syntax: &str, changes: &[Field], hex: &str) -> Values {
    let volume = read_all(vec![packed(syntax, changes, &[&[], &bytes_of(hex)])]).unwrap();
    assert_eq!(volume.dims(), [8, 6, 1]);
    volume.values().clone()
}

#[test]
fn lossless_frames_are_the_picture() {
    let words = || Values::U16(picture().into_iter().map(|v| v as u16).collect());
    let wide = unsigned(16, 16);
    assert_eq!(read_one(JPEG, &wide, LOSSLESS_FIRST_HEX), words());
    assert_eq!(
        read_one("1.2.840.10008.1.2.4.57", &unsigned(16, 12), LOSSLESS_SEVENTH_HEX),
        words()
    );
    assert_eq!(read_one(JPEG_LS, &wide, JPEG_LS_HEX), words());
    assert_eq!(read_one(JPEG_2000, &wide, JPEG_2000_HEX), words());
    let signed = picture().into_iter().map(|v| (v - 2048) as i16).collect();
    assert_eq!(read_one(JPEG_2000, &[], JPEG_2000_SIGNED_HEX), Values::I16(signed));
    // Signed pixels are packed as the bits that they have: 12 bits, the highest of which is the sign.
    let twelve = [short((0x0028, 0x0101), 12), short((0x0028, 0x0102), 11)];
    let folded = picture()
        .into_iter()
        .map(|v| if v < 2048 { v as i16 } else { (v - 4096) as i16 });
    assert_eq!(
        read_one(JPEG, &twelve, LOSSLESS_SEVENTH_HEX),
        Values::I16(folded.collect())
    );
}

#[test]
fn frames_with_loss_are_what_other_decoders_yield() {
    // As libjpeg-turbo and OpenJPEG decode them; inverse transforms may round differently by one.
    let jpeg: [i64; 48] = [
        2, 0, 7, 17, 31, 47, 67, 94, 32, 32, 44, 52, 65, 87, 105, 134, 63, 71, 74, 86, 101, 121, 144, 169, 97, 99, 110,
        125, 136, 156, 182, 208, 130, 134, 142, 154, 173, 196, 214, 246, 158, 168, 182, 188, 210, 227, 255, 29,
    ];
    let wavelet: [i64; 48] = [
        0, 128, 128, 384, 384, 896, 1152, 1408, 640, 640, 640, 896, 1152, 1408, 1664, 2176, 1152, 1152, 1152, 1408,
        1664, 1920, 2432, 2688, 1664, 1664, 1664, 1920, 2176, 2432, 2944, 3456, 2176, 2176, 2176, 2432, 2688, 3200,
        3456, 3968, 2688, 2688, 2944, 2944, 3456, 3712, 3968, 384,
    ];
    let near = |values: Vec<i64>, expected: &[i64], bound: i64| {
        let off = values.iter().zip(expected).map(|(a, b)| (a - b).abs()).max();
        assert!(off <= Some(bound), "{values:?}");
    };
    let Values::U8(values) = read_one("1.2.840.10008.1.2.4.50", &unsigned(8, 8), WITH_LOSS_HEX) else {
        panic!()
    };
    near(values.into_iter().map(i64::from).collect(), &jpeg, 1);
    for (syntax, hex, expected, bound) in [
        ("1.2.840.10008.1.2.4.81", JPEG_LS_NEAR_HEX, picture(), 2),
        ("1.2.840.10008.1.2.4.91", JPEG_2000_LOSSY_HEX, wavelet.to_vec(), 1),
    ] {
        let Values::U16(values) = read_one(syntax, &unsigned(16, 16), hex) else {
            panic!()
        };
        near(values.into_iter().map(i64::from).collect(), &expected, bound);
    }
}

/// Every frame with its syntax and bits.
const ALL: [(&str, u16, &str); 7] = [
    (JPEG, 16, LOSSLESS_FIRST_HEX),
    (JPEG, 16, LOSSLESS_SEVENTH_HEX),
    (JPEG, 8, WITH_LOSS_HEX),
    (JPEG_LS, 16, JPEG_LS_HEX),
    (JPEG_LS, 16, JPEG_LS_NEAR_HEX),
    (JPEG_2000, 16, JPEG_2000_HEX),
    (JPEG_2000, 16, JPEG_2000_LOSSY_HEX),
];

#[test]
fn cut_frames_are_refused() {
    for (syntax, bits, hex) in ALL {
        let frame = bytes_of(hex);
        // A JPEG scan may be complete a few bytes before the end marker.
        for len in 0..frame.len() - 6 {
            let read = read_all(vec![packed(syntax, &unsigned(bits, bits), &[&[], &frame[..len]])]);
            assert!(read.is_err(), "{syntax} cut to {len} of {}", frame.len());
        }
    }
}

#[test]
fn frames_of_another_kind_are_refused() {
    let refusal =
        |syntax: &str, bits: u16, frame: &[u8]| message(vec![packed(syntax, &unsigned(bits, bits), &[&[], frame])]);
    let changed = |hex: &str, at: usize, byte: u8| {
        let mut frame = bytes_of(hex);
        frame[at] = byte;
        frame
    };
    let inserted = |hex: &str, at: usize, segment: &[u8]| {
        let mut frame = bytes_of(hex);
        frame.splice(at..at, segment.iter().copied());
        frame
    };
    let frame_at = |hex: &str, marker: [u8; 2]| bytes_of(hex).windows(2).position(|pair| pair == marker).unwrap();
    for (text, expected) in [
        (
            refusal(JPEG, 16, &bytes_of(JPEG_LS_HEX)),
            "JPEG process FFF7 is not read",
        ),
        (
            refusal(JPEG_LS, 16, &bytes_of(LOSSLESS_FIRST_HEX)),
            "JPEG process FFC3 is not read",
        ),
        (
            refusal(JPEG_2000, 16, &bytes_of(JPEG_LS_HEX)),
            "has no JPEG 2000 data, expected FF4F FF51",
        ),
        (
            refusal(JPEG, 16, &bytes_of(JPEG_2000_HEX)),
            "has no JPEG data, expected FFD8",
        ),
        // Twelve bits with loss.
        (
            refusal(
                JPEG,
                16,
                &changed(WITH_LOSS_HEX, frame_at(WITH_LOSS_HEX, [0xff, 0xc0]) + 4, 12),
            ),
            "JPEG with loss of 12 bits is not read",
        ),
        // Nine columns, then two components.
        (
            refusal(
                JPEG,
                16,
                &changed(LOSSLESS_FIRST_HEX, frame_at(LOSSLESS_FIRST_HEX, [0xff, 0xc3]) + 8, 9),
            ),
            "a JPEG frame has 9 x 6 pixels of 1 components, expected 8 x 6 of 1",
        ),
        (
            refusal(JPEG_2000, 16, &changed(JPEG_2000_HEX, 11, 9)),
            "a JPEG 2000 frame has 9 x 6 pixels of 1 components",
        ),
        (
            refusal(JPEG_2000, 16, &changed(JPEG_2000_HEX, 41, 2)),
            "a JPEG 2000 frame has 8 x 6 pixels of 2 components",
        ),
        (
            refusal(JPEG, 8, &bytes_of(LOSSLESS_FIRST_HEX)),
            "a JPEG frame has 16 bits, expected 2 to 8",
        ),
        // What the decoders are known to read wrongly.
        (
            refusal(JPEG, 16, &inserted(LOSSLESS_FIRST_HEX, 2, &[0xff, 0xdd, 0, 4, 0, 8])),
            "lossless JPEG with restart markers is not read",
        ),
        (
            refusal(
                JPEG_LS,
                16,
                &changed(JPEG_LS_HEX, frame_at(JPEG_LS_HEX, [0xff, 0xf8]) + 13, 255),
            ),
            "JPEG-LS with statistics reset after 65344 samples is not read",
        ),
        // A marker in the middle of a scan ends it for the decoder.
        (
            refusal(JPEG, 16, &changed(LOSSLESS_FIRST_HEX, 100, 0xff)),
            "within their scan, expected one scan",
        ),
    ] {
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn frames_cut_into_too_many_parts_are_refused() {
    let large = [short((0x0028, 0x0010), 4096), short((0x0028, 0x0011), 4096)];
    let changes = [unsigned(16, 16), large.to_vec()].concat();
    let with = |tile: u32, style: &[u8]| {
        let mut frame = bytes_of(JPEG_2000_HEX);
        frame[8..16].copy_from_slice(&[0, 0, 16, 0, 0, 0, 16, 0]);
        frame[24..28].copy_from_slice(&tile.to_be_bytes());
        frame[28..32].copy_from_slice(&tile.to_be_bytes());
        let at = frame.windows(2).position(|pair| pair == [0xff, 0x52]).unwrap();
        frame.splice(at + 2..at + 14, style.iter().copied());
        message(vec![packed(JPEG_2000, &changes, &[&[], &frame])])
    };
    // Precincts of one pixel, code blocks of 4 x 4 in 32 layers, tiles of 15 x 15.
    let text = with(4096, &[0, 13, 1, 0, 0, 1, 0, 0, 4, 4, 0, 1, 0]);
    assert!(
        text.contains("16777216 precincts or code blocks, expected at most 262144"),
        "{text}"
    );
    let text = with(4096, &[0, 12, 0, 0, 0, 32, 0, 2, 0, 0, 0, 1]);
    assert!(text.contains("33554432 precincts or code blocks"), "{text}");
    let text = with(15, &[0, 12, 0, 0, 0, 1, 0, 2, 4, 4, 0, 1]);
    assert!(text.contains("have 75076 tiles, expected at most 65535"), "{text}");
    let huge = [short((0x0028, 0x0010), 8192), short((0x0028, 0x0011), 8192)];
    let text = message(vec![packed(
        JPEG_2000,
        &[unsigned(16, 16), huge.to_vec()].concat(),
        &[&[], &[0; 4]],
    )]);
    assert!(
        text.contains("bytes of memory for unpacking one frame, expected at most 536870912"),
        "{text}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
        ..ProptestConfig::default()
    })]

    /// Whatever a packed frame says, reading ends with a volume or an error of one line.
    #[test]
    fn mutated_frames_never_panic(
        which in 0..ALL.len(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let (syntax, bits, hex) = ALL[which];
        let mut frame = bytes_of(hex);
        for (at, byte) in edits {
            let at = at.index(frame.len());
            frame[at] = byte;
        }
        if let Some(cut) = cut {
            frame.truncate(cut.index(frame.len()));
        }
        match read_all(vec![packed(syntax, &unsigned(bits, bits), &[&[], &frame])]) {
            Ok(volume) => prop_assert_eq!(volume.dims(), [8, 6, 1]),
            Err(error) => prop_assert!(!error.to_string().contains('\n')),
        }
    }
}
