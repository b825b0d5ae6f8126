use std::fs;
use std::path::PathBuf;

use super::read_colours;
use super::write::Written;
use crate::choice::Choice;
use crate::colours::Colours;
use crate::decoded::Orientation;
use crate::error::ReadError;
use crate::open;
use crate::values::{ValueType, Values};

/// A file of these header lines (after `type` and `encoding`) and bytes, read.
fn read(lines: &str, data: &[u8]) -> Result<Option<Colours>, ReadError> {
    let (_folder, path) = file(lines, data);
    read_colours(&path)
}

fn file(lines: &str, data: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.nrrd");
    let head = format!("NRRD0004\ntype: uint8\nencoding: raw\n{lines}\n\n");
    fs::write(&path, [head.as_bytes(), data].concat()).unwrap();
    (folder, path)
}

fn refusal(lines: &str, data: &[u8]) -> String {
    read(lines, data).unwrap_err().to_string()
}

const TWO: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

#[test]
fn colours_are_read_side_by_side() {
    let lines = "dimension: 4\nsizes: 4 2 1 1\nspacings: nan 1 2 3\nkinds: RGBA-color domain domain domain\nk:=v";
    let colours = read(lines, &TWO).unwrap().unwrap();
    assert_eq!(
        (colours.dims(), colours.spacing(), colours.components()),
        ([2, 1, 1], [1.0, 2.0, 3.0], 4)
    );
    assert_eq!(colours.values(), &Values::U8(TWO.to_vec()));
    assert_eq!((colours.key("k"), colours.key("l")), (Some("v"), None));
    assert!(colours.notes().is_empty(), "{:?}", colours.notes());
    // Axes of one entry are left out, as of other volumes.
    let lines = "dimension: 5\nsizes: 3 1 2 1 1\nspacings: nan 1 2 3 4\nkinds: 3-color space space space time";
    let colours = read(lines, &TWO[..6]).unwrap().unwrap();
    assert_eq!((colours.dims(), colours.spacing()), ([1, 2, 1], [1.0, 2.0, 3.0]));
}

#[test]
fn what_is_not_stated_is_told() {
    for kinds in [
        "",
        "\nkinds: list domain domain domain",
        "\nkinds: ??? ??? ??? ???",
        "\nkinds: vector space space space",
    ] {
        let lines = format!("dimension: 4\nsizes: 4 2 2 2\nspacings: nan 1 1 1{kinds}");
        let notes = read(&lines, &[7; 32]).unwrap().unwrap().notes().to_vec();
        assert_eq!(
            notes,
            ["the file does not say what the 4 values of a voxel are: they are taken for red, green, blue and opacity"]
        );
    }
}

#[test]
fn other_axes_are_no_colours() {
    for lines in [
        "dimension: 3\nsizes: 4 2 1",
        "dimension: 4\nsizes: 2 4 1 1",
        "dimension: 4\nsizes: 4 2 1 1",
        "dimension: 4\nsizes: 4 2 1 1\nkinds: ??? ??? ??? ???",
        "dimension: 4\nsizes: 4 2 1 1\nkinds: 4-vector domain domain domain",
        "dimension: 4\nsizes: 4 2 1 1\nkinds: domain domain domain time",
        "dimension: 4\nsizes: 4 2 1 1\nkinds: quaternion domain domain domain",
    ] {
        assert_eq!(read(lines, &TWO).unwrap(), None, "{lines}");
    }
}

#[test]
fn colours_that_are_none_are_refused() {
    let lines = "dimension: 4\nsizes: 4 2 1 1\nkinds: RGB-color domain domain domain";
    assert!(
        refusal(lines, &TWO).contains("expected `RGBA-color` or `4-color` for the first axis, which has 4 entries")
    );
    let lines = "dimension: 4\nsizes: 3 2 1 1\nkinds: HSV-color domain domain domain";
    assert!(refusal(lines, &TWO).contains("expected `RGB-color` or `3-color` for the first axis"));
    let lines = "dimension: 4\nsizes: 2 1 1 4\nkinds: domain domain domain RGBA-color";
    assert!(refusal(lines, &TWO).contains("expected the axis of colours first"));
    let lines = "dimension: 4\nsizes: 4 2 2 1\nkinds: RGBA-color domain domain domain";
    let message = refusal(lines, &TWO);
    assert!(
        message.contains("has 8 bytes of data, expected 16 for 4 x 2 x 2 x 1 uint8"),
        "{message}"
    );
    let lines = "dimension: 4\nsizes: 4 8192 8192 8192\nkinds: RGBA-color domain domain domain";
    assert!(refusal(lines, &TWO).contains("expected at most 2147483648"));
    let lines = "dimension: 4\nsizes: 4 8192 8192 32\nencoding: gzip\nkinds: RGBA-color domain domain domain";
    let message = refusal(&lines.replace("encoding: gzip\n", ""), &TWO);
    assert!(
        message.contains("expected 8589934592 for 4 x 8192 x 8192 x 32 uint8"),
        "{message}"
    );
}

/// Where one value a voxel is needed, colours stay refused.
#[test]
fn colours_are_no_scalars() {
    let lines = "dimension: 4\nsizes: 4 2 2 2\nkinds: RGBA-color domain domain domain";
    let (_folder, path) = file(lines, &[7; 32]);
    let message = super::read(&path, &Choice::default()).unwrap_err().to_string();
    assert!(
        message.contains("field `dimension` is `4`, expected 3: a volume of one value a voxel"),
        "{message}"
    );
    assert!(open::read_colours(&path, &Choice::default()).unwrap().is_some());
    // One slice: an axis of one entry beside that of the colours.
    let lines = "dimension: 4\nsizes: 4 2 2 1\nkinds: RGBA-color domain domain domain";
    let (_folder, path) = file(lines, &[7; 16]);
    let message = super::read(&path, &Choice::default()).unwrap_err().to_string();
    assert!(
        message.contains("expected 3: a volume of one value a voxel"),
        "{message}"
    );
    let (_folder, path) = file("dimension: 3\nsizes: 4 2 1", &TWO);
    assert_eq!(open::read_colours(&path, &Choice::default()).unwrap(), None);
}

#[test]
fn voxels_turn_as_a_whole() {
    let lines = "dimension: 4\nsizes: 4 2 1 1\nspace: RAS\nspace directions: none (2,0,0) (0,3,0) (0,0,4)\n\
                 kinds: RGBA-color space space space";
    let colours = read(lines, &TWO).unwrap().unwrap();
    assert_eq!(colours.values(), &Values::U8(vec![5, 6, 7, 8, 1, 2, 3, 4]));
    assert_eq!(colours.spacing(), [2.0, 3.0, 4.0]);
    assert!(matches!(colours.orientation(), Orientation::Patient { file_axes, .. } if file_axes == "RAS"));
    let sheared = lines.replace("(0,3,0)", "(3,3,0)");
    assert!(refusal(&sheared, &TWO).contains("at 45.00 degrees"));
}

#[test]
fn what_is_written_is_read() {
    let patient = Orientation::Patient {
        file_axes: "RAS".into(),
        tilt: 0.0,
    };
    let values: Vec<u16> = (0..4 * 3 * 2).map(|i| 1000 * i).collect();
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    for orientation in [Orientation::Unknown, Orientation::Space, patient] {
        let written = Written {
            dims: [3, 2, 1],
            spacing: [0.1, 1.0 / 3.0, 1e-7],
            orientation: &orientation,
            value_type: ValueType::U16,
            components: 4,
            centering: "cell",
            keys: &[("tau".into(), "0.25".into())],
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("w.nrrd");
        fs::write(&path, written.file(&data)).unwrap();
        let colours = read_colours(&path).unwrap().unwrap();
        assert_eq!(colours.values(), &Values::U16(values.clone()));
        assert_eq!(
            (colours.dims(), colours.spacing(), colours.components()),
            ([3, 2, 1], [0.1, 1.0 / 3.0, 1e-7], 4)
        );
        assert_eq!(colours.key("tau"), Some("0.25"));
        assert!(colours.notes().is_empty(), "{:?}", colours.notes());
        let same = std::mem::discriminant(colours.orientation()) == std::mem::discriminant(&orientation);
        assert!(same, "{:?}", colours.orientation());
    }
}
