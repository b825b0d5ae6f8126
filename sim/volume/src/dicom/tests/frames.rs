//! Files of several frames: where each lies, in which fragments, and what is missing.

use super::packed::{items, unsigned};
use super::*;

/// A sequence of items of elements.
fn sequence(tag: (u16, u16), items_of: &[Vec<u8>]) -> Field {
    let mut all = Vec::new();
    for item in items_of {
        all.extend([0xfe, 0xff, 0x00, 0xe0]);
        all.extend((item.len() as u32).to_le_bytes());
        all.extend(item);
    }
    (tag, "SQ", all)
}

/// Elements as a syntax writes them.
fn elements(fields: &[Field], syntax: &str) -> Vec<u8> {
    let none = file_of(&[], syntax).len();
    file_of(fields, syntax).split_off(none)
}

/// A functional group of one item.
fn group(tag: (u16, u16), fields: &[Field], syntax: &str) -> Field {
    sequence(tag, &[elements(fields, syntax)])
}

fn position(z: f64, syntax: &str) -> Field {
    let position = text((0x0020, 0x0032), "DS", &format!("0\\0\\{z}"));
    group((0x0020, 0x9113), &[position], syntax)
}

fn temporal(index: u32) -> Field {
    let index = ((0x0020, 0x9128), "UL", index.to_le_bytes().to_vec());
    group((0x0020, 0x9111), &[index], EXPLICIT)
}

/// The fields of a file of 2 x 2 pixels with these frames; what all have in common stands apart.
fn several(frames: &[Vec<Field>], pixels: &[i16], syntax: &str) -> Vec<Field> {
    let single = [
        (0x0020, 0x0032),
        (0x0020, 0x0037),
        (0x0028, 0x0030),
        (0x0028, 0x1052),
        (0x0028, 0x1053),
    ];
    let mut all = fields(0);
    all.retain(|(tag, ..)| !single.contains(tag));
    all.pop();
    let scale = [
        text((0x0028, 0x1052), "DS", "-1000 "),
        text((0x0028, 0x1053), "DS", "1 "),
    ];
    let directions = text((0x0020, 0x0037), "DS", "1\\0\\0\\0\\1\\0");
    let spacing = text((0x0028, 0x0030), "DS", "0.5\\0.75");
    let shared = [
        group((0x0020, 0x9116), &[directions], syntax),
        group((0x0028, 0x9110), &[spacing], syntax),
        group((0x0028, 0x9145), &scale, syntax),
    ];
    all.push(text((0x0028, 0x0008), "IS", &format!("{} ", frames.len())));
    all.push(sequence((0x5200, 0x9229), &[elements(&shared, syntax)]));
    let frames: Vec<_> = frames.iter().map(|frame| elements(frame, syntax)).collect();
    all.push(sequence((0x5200, 0x9230), &frames));
    all.push((
        (0x7fe0, 0x0010),
        "OW",
        pixels.iter().flat_map(|p| p.to_le_bytes()).collect(),
    ));
    all.sort_by_key(|(tag, ..)| *tag);
    all
}

/// Three frames in another order than that of their positions.
fn three(syntax: &str) -> Vec<Field> {
    let frames = [5.0, 0.0, 2.5].map(|z| vec![position(z, syntax)]);
    let pixels: Vec<i16> = (0..12).collect();
    several(&frames, &pixels, syntax)
}

#[test]
fn frames_are_put_in_order_by_position() {
    for syntax in [EXPLICIT, "1.2.840.10008.1.2"] {
        let volume = read_all(vec![file_of(&three(syntax), syntax)]).unwrap();
        assert_eq!((volume.dims(), volume.spacing()), ([2, 2, 3], [0.75, 0.5, 2.5]));
        let expected = vec![4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 2, 3];
        assert_eq!(volume.values(), &Values::I16(expected));
        assert_eq!(volume.value_offset(), -1000.0);
    }
}

#[test]
fn sequences_without_a_length_are_the_same() {
    // The same frames, sequence and items by their delimiters.
    let mut file = Vec::new();
    for (tag, kind, value) in three(EXPLICIT) {
        if tag != (0x5200, 0x9230) {
            file.push((tag, kind, value));
            continue;
        }
        let frames = [5.0, 0.0, 2.5].map(|z| {
            let item = elements(&[position(z, EXPLICIT)], EXPLICIT);
            [
                &[0xfe, 0xff, 0x00, 0xe0, 255, 255, 255, 255][..],
                &item,
                &[0xfe, 0xff, 0x0d, 0xe0, 0, 0, 0, 0],
            ]
            .concat()
        });
        file.push((
            tag,
            "",
            [frames.concat(), vec![0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]].concat(),
        ));
    }
    let mut bytes = file_of(&[], EXPLICIT);
    for (tag, kind, value) in file {
        if kind.is_empty() {
            let head = [tag.0.to_le_bytes(), tag.1.to_le_bytes()].concat();
            bytes.extend([&head, &b"SQ\0\0"[..], &[255; 4], &value].concat());
        } else {
            bytes.extend(element(tag, kind, &value));
        }
    }
    let volume = read_all(vec![bytes]).unwrap();
    assert_eq!(
        volume.values(),
        read_all(vec![file_of(&three(EXPLICIT), EXPLICIT)]).unwrap().values()
    );
}

#[test]
fn phases_within_a_file_are_chosen() {
    let frames: Vec<_> = [(0.0, 2), (0.0, 1), (2.5, 2), (2.5, 1)]
        .map(|(z, index)| vec![position(z, EXPLICIT), temporal(index)])
        .to_vec();
    let pixels: Vec<i16> = (0..16).collect();
    let file = file_of(&several(&frames, &pixels, EXPLICIT), EXPLICIT);
    let refused = message(vec![file.clone()]);
    assert!(
        refused.contains("holds 2 phases of 2 slices at the same positions (by temporal position index: 1, 2)"),
        "{refused}"
    );
    let choice = Choice {
        phase: Some(1),
        ..Choice::default()
    };
    let volume = read_bytes(&[("a".into(), file)], "a", &choice).unwrap();
    assert_eq!(volume.values(), &Values::I16(vec![4, 5, 6, 7, 12, 13, 14, 15]));
}

#[test]
fn packed_frames_are_found_by_fragment_or_offset() {
    // RLE of 2 x 2 pixels of 8 bits: one segment, one literal run.
    let frame = |values: [u8; 4]| {
        let mut frame: Vec<u8> = [1_u32, 64].iter().flat_map(|word| word.to_le_bytes()).collect();
        frame.resize(64, 0);
        frame.push(3);
        frame.extend(values);
        frame.push(128);
        frame
    };
    let frames = [frame([8, 9, 10, 11]), frame([0, 1, 2, 3]), frame([4, 5, 6, 7])];
    let mut fields = three(EXPLICIT);
    fields.pop();
    fields.retain(|(tag, ..)| !(0x0100..=0x0103).contains(&tag.1) || tag.0 != 0x0028);
    fields.extend(unsigned(8, 8));
    fields.sort_by_key(|(tag, ..)| *tag);
    let build = |fragments: &[&[u8]]| {
        let mut file = file_of(&fields, "1.2.840.10008.1.2.5");
        file.extend([0xe0, 0x7f, 0x10, 0, b'O', b'B', 0, 0, 255, 255, 255, 255]);
        file.extend(items(fragments));
        file
    };
    let expected = Values::U8((0..12).collect());
    let [a, b, c] = &frames;
    let whole = build(&[&[], a, b, c]);
    assert_eq!(read_all(vec![whole]).unwrap().values(), &expected);
    // Two fragments each: their items take 8 bytes more.
    let split = |offsets: &[u32]| {
        let table: Vec<u8> = offsets.iter().flat_map(|word| word.to_le_bytes()).collect();
        build(&[&table, &a[..40], &a[40..], &b[..64], &b[64..], &c[..2], &c[2..]])
    };
    let len = a.len() as u32 + 16;
    let read = read_all(vec![split(&[0, len, 2 * len])]).unwrap();
    assert_eq!(read.values(), &expected);
    for (file, expected) in [
        (
            split(&[]),
            "has 6 fragments and 0 bytes of offsets, expected 3 packed frames",
        ),
        (split(&[0, len, 2 * len + 1]), "has 2 fragments at the offsets stated"),
        (split(&[1, len, 2 * len]), "has no frame at offset 0"),
        (build(&[&[], a, b]), "has 2 fragments and 0 bytes of offsets"),
        (build(&[]), "has 0 fragments"),
    ] {
        let text = message(vec![file]);
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn files_whose_frames_are_unknown_are_refused() {
    let mut loose = fields(0);
    loose.push(text((0x0028, 0x0008), "IS", "2 "));
    loose.sort_by_key(|(tag, ..)| *tag);
    let without = |tag: (u16, u16)| {
        let mut fields = three(EXPLICIT);
        fields.retain(|(other, ..)| *other != tag);
        fields
    };
    let with = |tag: (u16, u16), kind: &'static str, value: &str| {
        let mut fields = without(tag);
        fields.push(text(tag, kind, value));
        fields.sort_by_key(|(tag, ..)| *tag);
        fields
    };
    for (fields, expected) in [
        (
            loose,
            "a file of 2 frames that does not say where each lies is not read",
        ),
        (
            without((0x5200, 0x9230)),
            "a file of 3 frames that does not say where each lies is not read",
        ),
        (without((0x5200, 0x9229)), "states no orientation (0020,0037)"),
        (with((0x0028, 0x0008), "IS", "4 "), "states 4 frames and describes 3"),
        (
            with((0x0028, 0x0008), "IS", "0 "),
            "states `0` frames, expected a whole number from 1",
        ),
        (
            with((0x0028, 0x0008), "IS", "-1"),
            "states `-1` frames, expected a whole number from 1",
        ),
        (
            with((0x5200, 0x9230), "SQ", "no items"),
            "stands between the items of a sequence",
        ),
        (
            several(
                &[vec![position(0.0, EXPLICIT)], vec![position(2.5, EXPLICIT)]],
                &[0; 7],
                EXPLICIT,
            ),
            "has 14 bytes of pixels, expected 16 for 2 frames of 2 x 2 of 16 bits",
        ),
        (
            several(&[vec![position(0.0, EXPLICIT)], vec![]], &[0; 8], EXPLICIT),
            "states no position",
        ),
    ] {
        let text = message(vec![file_of(&fields, EXPLICIT)]);
        assert!(text.contains(expected), "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
        ..ProptestConfig::default()
    })]

    /// Whatever a file of frames says, reading ends with a volume or an error of one line.
    #[test]
    fn mutated_frames_never_panic(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        implicit in any::<bool>(),
    ) {
        let syntax = if implicit { "1.2.840.10008.1.2" } else { EXPLICIT };
        let mut bytes = file_of(&three(syntax), syntax);
        for (at, byte) in edits {
            let at = 128 + at.index(bytes.len() - 128);
            bytes[at] = byte;
        }
        match read_all(vec![bytes]) {
            Ok(volume) => prop_assert_eq!(volume.values().len(), volume.dims().iter().product::<usize>()),
            Err(error) => prop_assert!(!error.to_string().contains('\n')),
        }
    }
}
