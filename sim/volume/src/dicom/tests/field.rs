//! What people really have, after public reports on other programs: each by small files made here.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::*;

const POSITION: (u16, u16) = (0x0020, 0x0032);
const DIRECTIONS: (u16, u16) = (0x0020, 0x0037);
const PIXELS: (u16, u16) = (0x7fe0, 0x0010);

/// A folder of files; names may have folders before them.
fn folder(files: &[(&str, Vec<u8>)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    folder
}

fn read(path: &Path) -> Result<Decoded, ReadError> {
    crate::open::read(path)
}

fn read_phase(path: &Path, phase: usize) -> Result<Decoded, ReadError> {
    let choice = Choice {
        phase: Some(phase),
        ..Choice::default()
    };
    read_folder(path, &choice)
}

fn at(position: &str) -> Field {
    text(POSITION, "DS", position)
}

/// The values of slices by number.
fn values_of(slices: impl Iterator<Item = i16>) -> Values {
    Values::I16(slices.flat_map(|i| (0..4).map(move |p| 10 * i + p)).collect())
}

#[test]
fn directions_that_jitter_are_one_series() {
    // Rounded to thousandths, 0.01249767 and 0.01250167 differ.
    let slices = (0..16).map(|i| {
        let directions = match i % 2 {
            0 => "1\\0\\0\\0\\0.99992190\\0.01249767",
            _ => "1\\0\\0\\0\\0.99992185\\0.01250167",
        };
        let (y, z) = (-0.0125 * 1.4 * f64::from(i), 0.999_921_9 * 1.4 * f64::from(i));
        slice(
            i,
            &[at(&format!("0\\{y:.6}\\{z:.6}")), text(DIRECTIONS, "DS", directions)],
        )
    });
    let volume = read_all(slices.collect()).unwrap();
    assert_eq!(volume.dims(), [2, 2, 16]);
    assert!((volume.spacing()[2] - 1.4).abs() < 1e-6, "{:?}", volume.spacing());
    assert_eq!(volume.values(), &values_of(0..16));
}

#[test]
fn spacings_and_scales_that_jitter_are_one_series() {
    let changes = [
        text((0x0028, 0x0030), "DS", "0.5000\\0.75020"),
        text((0x0028, 0x1053), "DS", "1.0000001"),
        text((0x0028, 0x1052), "DS", "-1024.0001"),
    ];
    let volume = read_all(vec![slice(0, &[]), slice(1, &changes), slice(2, &[])]).unwrap();
    assert_eq!((volume.values(), volume.value_scale()), (&values_of(0..3), 1.0));
    let other = [text((0x0028, 0x0030), "DS", "0.5\\0.752")];
    assert!(with(&other).contains("1.dcm has pixel spacing [0.752, 0.5], expected [0.75, 0.5]"));
}

#[test]
fn rounded_positions_are_judged_against_an_even_stack() {
    let rounded = |step: f64, digits: usize| {
        let slices = (0..16).map(move |i| slice(i, &[at(&format!("0\\0\\{:.digits$}", step * f64::from(i)))]));
        read_all(slices.collect())
    };
    // 0.33 and 0.34 mm in turn.
    let volume = rounded(1.0 / 3.0, 2).unwrap();
    assert!((volume.spacing()[2] - 1.0 / 3.0).abs() < 1e-3, "{:?}", volume.spacing());
    assert!(
        volume.notes()[0].contains("slices lie up to 0.004 mm off an even stack of 0.3334 mm, 1.1 % of it"),
        "{:?}",
        volume.notes()
    );
    // 0.1 mm of rounding is 8 % of 0.6 mm.
    let refused = rounded(0.6125, 1).unwrap_err().to_string();
    assert!(refused.contains("slices are unevenly spaced"), "{refused}");
    // No step is far from its neighbours, and yet the last slices lie off.
    let drift = (0..30).map(|i| slice(i, &[at(&format!("0\\0\\{}", f64::from(i) + 0.002 * f64::from(i * i)))]));
    let refused = message(drift.collect());
    assert!(
        refused.contains("lies 0.271 mm off an even stack of 1.058 mm, expected at most 0.053"),
        "{refused}"
    );
}

#[test]
fn a_file_without_a_folder_before_it_is_found_in_its_own() {
    for (path, folder, own) in [
        ("a.dcm", ".", "./a.dcm"),
        ("d/a.dcm", "d", "d/a.dcm"),
        ("/a", "/", "/a"),
    ] {
        assert_eq!(in_folder(Path::new(path)), (folder.into(), own.into()));
    }
}

#[test]
fn rounding_aside_is_no_tilt() {
    // 0.007 mm aside on a way of 0.33 mm would be an angle of 1.2 degrees.
    let volume = read_all(vec![slice(0, &[at("0.005\\0.005\\0")]), slice(1, &[at("0\\0\\0.33")])]).unwrap();
    assert_eq!(volume.spacing()[2], 0.33);
}

#[test]
fn a_tilted_gantry_is_refused_with_its_angle() {
    let leaning = |i: i16| slice(i, &[at(&format!("0\\{}\\{}", 0.67 * f64::from(i), 2.5 * f64::from(i)))]);
    let refused = message((0..4).map(leaning).collect());
    assert!(
        refused.contains("the stack leans by 15.00 degrees off its slices' normal (a tilted gantry), 2.010 mm"),
        "{refused}"
    );
}

#[test]
fn pages_and_reports_are_passed_over_by_name() {
    let mut page = fields(0);
    page.retain(|(tag, ..)| {
        let other = [(0x0020, 0x000e), (0x0028, 0x0002), (0x0028, 0x0004)];
        ![POSITION, DIRECTIONS].contains(tag) && !other.contains(tag)
    });
    page.push(text((0x0020, 0x000e), "UI", "9.9"));
    page.push(short((0x0028, 0x0002), 3));
    page.push(text((0x0028, 0x0004), "CS", "RGB "));
    page.sort_by_key(|(tag, ..)| *tag);
    let report = file_of(&[text((0x0008, 0x0060), "CS", "SR")], EXPLICIT);
    let folder = folder(&[
        ("0.dcm", slice(0, &[])),
        ("1.dcm", slice(1, &[])),
        ("99-dose.dcm", file_of(&page, EXPLICIT)),
        ("capture.dcm", file_of(&page, "1.2.840.10008.1.2.4.110")),
        ("report.dcm", report),
    ]);
    let volume = read(folder.path()).unwrap();
    assert_eq!(volume.values(), &values_of(0..2));
    let notes = volume.notes().join("\n");
    for expected in [
        "99-dose.dcm (DICOM: a picture of 3 samples per pixel is not read",
        "capture.dcm (DICOM: ",
        "1 file is no DICOM image: report.dcm",
    ] {
        assert!(notes.contains(expected), "{notes}");
    }
    // A page alone says what it is.
    let alone = read(&folder.path().join("99-dose.dcm")).unwrap_err().to_string();
    assert!(
        alone.contains("a picture of 3 samples per pixel is not read"),
        "{alone}"
    );
}

#[test]
fn an_unreadable_slice_of_the_series_is_no_page() {
    // Left out, it would make a volume of two slices at twice the distance, or of one slice less.
    for i in 0..3 {
        let mut files: Vec<_> = (0..3).map(|i| slice(i, &[])).collect();
        let len = files[i].len() - 3;
        files[i].truncate(len);
        let text = message(files);
        assert!(text.contains(&format!("{i}.dcm: DICOM: element (7FE0,0010)")), "{text}");
    }
}

#[test]
fn padding_after_the_pixels_is_told() {
    let padded = |len: usize| {
        let mut pixels: Vec<u8> = (0_i16..4).flat_map(|p| (10 + p).to_le_bytes()).collect();
        pixels.resize(len, 0xaa);
        vec![slice(0, &[]), slice(1, &[(PIXELS, "OW", pixels)])]
    };
    let volume = read_all(padded(14)).unwrap();
    assert_eq!(volume.values(), &values_of(0..2));
    assert!(
        volume.notes()[0].contains("padding after the pixels is ignored: 1.dcm (6 bytes)"),
        "{:?}",
        volume.notes()
    );
    // As much as a further frame is no padding.
    assert!(message(padded(16)).contains("has 16 bytes of pixels, expected 8 for 2 x 2 of 16 bits"));
    // Nor is a set of trailing elements after the pixels.
    let mut trailing = slice(1, &[]);
    trailing.extend(element((0xfffc, 0xfffc), "OB", &[0; 30]));
    assert!(read_all(vec![slice(0, &[]), trailing]).unwrap().notes().is_empty());
}

#[test]
fn a_medium_is_walked_down() {
    let mut directory = vec![0; 128];
    directory.extend(b"DICM");
    directory.extend(element((0x0002, 0x0002), "UI", b"1.2.840.10008.1.3.10"));
    directory.extend(element((0x0002, 0x0010), "UI", EXPLICIT.as_bytes()));
    let below = "PT000000/ST000000/SE000000";
    let folder = folder(&[
        ("DICOMDIR", directory.clone()),
        ("README.TXT", b"text".to_vec()),
        (&format!("{below}/IM000000"), slice(0, &[])),
        (&format!("{below}/IM000001"), slice(1, &[])),
        (
            "PT000000/ST000000/SE000001/IM000000",
            slice(0, &[text((0x0020, 0x0011), "IS", "9")]),
        ),
    ]);
    for path in [folder.path().to_path_buf(), folder.path().join("DICOMDIR")] {
        let volume = read(&path).unwrap();
        assert_eq!(volume.values(), &values_of(0..2));
        let notes = volume.notes().join("\n");
        assert!(notes.contains(&format!("the slices lie in {below}")), "{notes}");
    }
    // A folder without a DICOMDIR is one, too, to a stated depth.
    let patient = folder.path().join("PT000000");
    assert_eq!(read(&patient).unwrap().dims(), [2, 2, 2]);
    let deep = self::folder(&[("1/2/3/4/5/6/7/8/9/0.dcm", slice(0, &[]))]);
    assert!(matches!(read(deep.path()).unwrap_err().problem, Problem::NoImages));
    assert_eq!(read(&deep.path().join("1")).unwrap().dims(), [2, 2, 1]);
    // The files that a DICOMDIR names are not followed: those below it are the medium.
    let listed = element((0x0004, 0x1500), "CS", b"..\\OUTSIDE.DCM");
    let outside = self::folder(&[
        ("OUTSIDE.DCM", slice(0, &[])),
        ("medium/DICOMDIR", [directory, listed].concat()),
    ]);
    let error = read(&outside.path().join("medium/DICOMDIR")).unwrap_err();
    assert!(matches!(error.problem, Problem::NoImages));
    assert!(error.path.ends_with("medium/DICOMDIR"), "{error}");
}

#[test]
fn hidden_files_are_passed_over() {
    let folder = folder(&[
        ("0.dcm", slice(0, &[])),
        ("1.dcm", slice(1, &[])),
        ("._1.dcm", slice(1, &[])),
        (".DS_Store", b"Bud1".to_vec()),
    ]);
    let volume = read(folder.path()).unwrap();
    assert_eq!((volume.values(), volume.notes()), (&values_of(0..2), &[][..]));
}

#[test]
fn phases_are_chosen_by_number() {
    let phase = |i: i16, field: (u16, u16), value: &str| {
        slice(
            i,
            &[
                at(&format!("0\\0\\{}", 2.5 * f64::from(i % 2))),
                text(field, "IS", value),
            ],
        )
    };
    // By the order of their numbers, not of their letters: 2 comes before 10.
    let folder = folder(&[
        ("a", phase(0, (0x0020, 0x0012), "10")),
        ("b", phase(1, (0x0020, 0x0012), "10")),
        ("c", phase(2, (0x0020, 0x0012), "2 ")),
        ("d", phase(3, (0x0020, 0x0012), "2 ")),
    ]);
    let refused = read(folder.path()).unwrap_err().to_string();
    assert!(
        refused.contains(
            "holds 2 phases of 2 slices at the same positions (by acquisition number: 2, 10), expected one: `--phase N` \
             chooses it"
        ),
        "{refused}"
    );
    let first = read_phase(folder.path(), 1).unwrap();
    assert_eq!(first.values(), &values_of(2..4));
    assert!(
        first.notes()[0].contains("shown is phase 1 (acquisition number 2) of 2 phases"),
        "{:?}",
        first.notes()
    );
    assert_eq!(read_phase(folder.path(), 2).unwrap().values(), &values_of(0..2));
    for wrong in [0, 3] {
        let refused = read_phase(folder.path(), wrong).unwrap_err().to_string();
        assert!(
            refused.contains(&format!("has no phase {wrong}, expected 1 to 2")),
            "{refused}"
        );
    }
    // Without a field that tells them apart, by instance number.
    let instance = (0x0020, 0x0013);
    let numbered = [(0, "4 "), (1, "2 "), (2, "1 "), (3, "3 ")].map(|(i, number)| phase(i, instance, number));
    let files: Vec<_> = numbered
        .into_iter()
        .zip(0..)
        .map(|(bytes, i)| (format!("{i}"), bytes))
        .collect();
    let choice = Choice {
        phase: Some(1),
        ..Choice::default()
    };
    let volume = read_bytes(&files, "s", &choice).unwrap();
    assert_eq!(volume.values(), &values_of([2, 1].into_iter()));
    let single = read_bytes(
        &[("0".into(), slice(0, &[]))],
        "s",
        &Choice {
            phase: Some(2),
            ..choice
        },
    );
    assert!(
        single
            .unwrap_err()
            .to_string()
            .contains("has no phase 2: there is one slice at each position")
    );
}

#[test]
fn copies_of_a_slice_are_passed_over() {
    let uid = |i: i16| text((0x0008, 0x0018), "UI", &format!("1.2.{i}"));
    let one = |i: i16| slice(i, &[uid(i)]);
    let volume = read_all(vec![one(0), one(1), one(1), one(2)]).unwrap();
    assert_eq!(volume.values(), &values_of(0..3));
    assert!(
        volume.notes()[0].contains("passed over as copies of other slices: 2.dcm"),
        "{:?}",
        volume.notes()
    );
}

#[test]
fn localizers_of_the_same_series_are_named() {
    let localizer = |directions: &str| slice(0, &[at("10\\0\\20"), text(DIRECTIONS, "DS", directions)]);
    let folder = folder(&[
        ("0.dcm", slice(0, &[])),
        ("1.dcm", slice(1, &[])),
        ("2.dcm", slice(2, &[])),
        ("loc1.dcm", localizer("0\\1\\0\\0\\0\\-1")),
        ("loc2.dcm", localizer("1\\0\\0\\0\\0\\-1")),
    ]);
    let check = |volume: Decoded| {
        assert_eq!(volume.values(), &values_of(0..3));
        let note = &volume.notes()[0];
        assert!(note.contains("loc1.dcm") && note.contains("loc2.dcm"), "{note}");
    };
    check(read(folder.path()).unwrap());
    check(read(&folder.path().join("1.dcm")).unwrap());
    // Named by its number, it is the largest of them.
    let choice = Choice {
        series: Series::Named("7".into()),
        ..Choice::default()
    };
    check(read_folder(folder.path(), &choice).unwrap());
    assert_eq!(read(&folder.path().join("loc2.dcm")).unwrap().dims(), [2, 1, 2]);
}
