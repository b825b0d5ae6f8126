//! docs/formats.md says what the program does.

mod support;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use support::Place;

/// Voxels of every file below: 4 x 3 x 2, x fastest.
const DIMS: [u16; 3] = [4, 3, 2];

fn voxels() -> Vec<u8> {
    (0..24).map(|index| 7 * index + 1).collect()
}

/// The page.
fn page() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap()
}

/// The rows of the first table of a section, cell by cell.
fn rows(heading: &str) -> Vec<Vec<String>> {
    let page = page();
    let section = page
        .split(&format!("\n## {heading}\n"))
        .nth(1)
        .unwrap_or_else(|| panic!("no section {heading}"));
    let table = section
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'));
    let cells = |line: &str| {
        line.trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    // The header and the rule.
    table.skip(2).map(cells).collect()
}

/// What stands in back quotes.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn first_cells(heading: &str) -> BTreeSet<String> {
    let cells = rows(heading).into_iter().flat_map(|row| quoted(&row[0]));
    cells.collect()
}

fn keys(json: &str) -> BTreeSet<String> {
    let value: serde_json::Value = serde_json::from_str(json).unwrap();
    value.as_object().unwrap().keys().cloned().collect()
}

/// A NIfTI-1 header of this volume, with its magic and where the voxels begin.
fn nifti_header(magic: &[u8; 4], offset: f32) -> Vec<u8> {
    let mut head = vec![0; 348];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    put(40, &3_i16.to_le_bytes());
    for (axis, side) in DIMS.iter().enumerate() {
        put(42 + 2 * axis, &side.to_le_bytes());
        put(80 + 4 * axis, &1.0_f32.to_le_bytes());
    }
    put(48, &1_i16.to_le_bytes());
    put(70, &2_i16.to_le_bytes());
    put(72, &8_i16.to_le_bytes());
    put(108, &offset.to_le_bytes());
    put(112, &1.0_f32.to_le_bytes());
    put(344, magic);
    head
}

/// gzip of stored blocks (RFC 1951, 3.2.4).
fn gzip(data: &[u8]) -> Vec<u8> {
    let mut out = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255, 1];
    let len = u16::try_from(data.len()).unwrap();
    out.extend(len.to_le_bytes());
    out.extend((!len).to_le_bytes());
    out.extend(data);
    out.extend(crc32fast::hash(data).to_le_bytes());
    out.extend(u32::from(len).to_le_bytes());
    out
}

/// A slice as explicit little endian DICOM.
fn dicom(slice: usize) -> Vec<u8> {
    let mut out = vec![0; 128];
    out.extend(b"DICM");
    let mut element = |group: u16, number: u16, kind: &[u8; 2], value: &[u8]| {
        let mut value = value.to_vec();
        if value.len() % 2 == 1 {
            value.push(if kind == b"UI" { 0 } else { b' ' });
        }
        out.extend([group.to_le_bytes(), number.to_le_bytes()].concat());
        out.extend(kind);
        if kind == b"OB" {
            out.extend([0, 0]);
            out.extend((value.len() as u32).to_le_bytes());
        } else {
            out.extend((value.len() as u16).to_le_bytes());
        }
        out.extend(value);
    };
    let short = |value: u16| value.to_le_bytes();
    element(2, 0x10, b"UI", b"1.2.840.10008.1.2.1");
    element(8, 0x60, b"CS", b"OT");
    element(0x20, 0xe, b"UI", b"1.2.3");
    element(0x20, 0x13, b"IS", format!("{}", slice + 1).as_bytes());
    element(0x20, 0x32, b"DS", format!("0\\0\\{slice}").as_bytes());
    element(0x20, 0x37, b"DS", b"1\\0\\0\\0\\1\\0");
    element(0x28, 2, b"US", &short(1));
    element(0x28, 4, b"CS", b"MONOCHROME2");
    element(0x28, 0x10, b"US", &short(DIMS[1]));
    element(0x28, 0x11, b"US", &short(DIMS[0]));
    element(0x28, 0x30, b"DS", b"1\\1");
    element(0x28, 0x100, b"US", &short(8));
    element(0x28, 0x101, b"US", &short(8));
    element(0x28, 0x102, b"US", &short(7));
    element(0x28, 0x103, b"US", &short(0));
    element(0x7fe0, 0x10, b"OB", &voxels()[12 * slice..12 * (slice + 1)]);
    out
}

/// Two pages of a little-endian TIFF.
fn tiff() -> Vec<u8> {
    let mut out = b"II*\0".to_vec();
    let (voxels, entries) = (voxels(), 8_u32);
    // The pixels of both pages, then their directories.
    let directory = |page: u32| 8 + 24 + page * (2 + 12 * entries + 4);
    out.extend(directory(0).to_le_bytes());
    out.extend(&voxels);
    for page in 0..2 {
        out.extend((entries as u16).to_le_bytes());
        for (tag, kind, value) in [
            (256_u16, 3_u16, u32::from(DIMS[0])),
            (257, 3, u32::from(DIMS[1])),
            (258, 3, 8),
            (259, 3, 1),
            (262, 3, 1),
            (273, 4, 8 + 12 * page),
            (278, 3, u32::from(DIMS[1])),
            (279, 4, 12),
        ] {
            out.extend(tag.to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(1_u32.to_le_bytes());
            out.extend(value.to_le_bytes());
        }
        let next = if page == 0 { directory(1) } else { 0 };
        out.extend(next.to_le_bytes());
    }
    out
}

/// Writes the volume in every format, and gives the arguments that name each, by format and ending.
fn volumes(place: &Place) -> Vec<(&'static str, &'static str, String)> {
    let voxels = voxels();
    let nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\nencoding: raw\n";
    place.write("a.nrrd", [format!("{nrrd}\n").as_bytes(), &voxels].concat());
    place.write("b.bin", &voxels);
    place.write("b.nhdr", format!("{nrrd}data file: b.bin\n"));
    let one = [nifti_header(b"n+1\0", 352.0), vec![0; 4], voxels.clone()].concat();
    place.write("c.nii", &one);
    place.write("d.nii.gz", gzip(&one));
    place.write("e.hdr", nifti_header(b"ni1\0", 0.0));
    place.write("e.img", &voxels);
    let meta = |data: &str| {
        format!(
            "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = {data}\n"
        )
    };
    place.write("f.bin", &voxels);
    place.write("f.mhd", meta("f.bin"));
    place.write("g.mha", [meta("LOCAL").as_bytes(), &voxels].concat());
    for slice in 0..2 {
        place.write(&format!("h/{slice}.dcm"), dicom(slice));
    }
    place.write("i.tif", tiff());
    place.write("j.tiff", tiff());
    place.write("k.raw", &voxels);
    place.write("k_4x3x2_uint8.raw", &voxels);
    let array = r#"{"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "|u1", "order": "C",
        "compressor": null, "filters": null, "fill_value": 0}"#;
    for folder in ["l.zarr", "m.ome.zarr/0"] {
        place.write(&format!("{folder}/.zarray"), array);
        place.write(&format!("{folder}/0.0.0"), &voxels);
    }
    let axis = |name: &str| format!(r#"{{"name": "{name}", "type": "space", "unit": "millimeter"}}"#);
    let axes = ["z", "y", "x"].map(axis).join(", ");
    let level = r#"{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}"#;
    place.write("m.ome.zarr/.zgroup", r#"{"zarr_format": 2}"#);
    place.write(
        "m.ome.zarr/.zattrs",
        format!(r#"{{"multiscales": [{{"version": "0.4", "axes": [{axes}], "datasets": [{level}]}}]}}"#),
    );
    let named = |name: &str| name.to_owned();
    vec![
        ("Zarr", ".zarr", named("l.zarr")),
        ("Zarr", ".ome.zarr", named("m.ome.zarr")),
        ("NRRD", ".nrrd", named("a.nrrd")),
        ("NRRD", ".nhdr", named("b.nhdr")),
        ("NIfTI", ".nii", named("c.nii")),
        ("NIfTI", ".nii.gz", named("d.nii.gz")),
        ("NIfTI", ".hdr", named("e.hdr")),
        ("MetaImage", ".mhd", named("f.mhd")),
        ("MetaImage", ".mha", named("g.mha")),
        ("DICOM", ".dcm", named("h/0.dcm")),
        ("DICOM", ".dcm", named("h")),
        ("TIFF", ".tif", named("i.tif")),
        ("TIFF", ".tiff", named("j.tiff")),
        ("raw", ".raw", named("k_4x3x2_uint8.raw")),
        ("raw", ".raw", named("k.raw --raw 4x3x2,uint8")),
    ]
}

/// Every format and ending of the table is read, to the same voxels, and no other is known.
#[test]
fn formats_are_those_of_the_table() {
    let place = Place::new();
    let volumes = volumes(&place);
    let crc = format!("{:08x}", crc32fast::hash(&voxels()));
    for (format, ending, words) in &volumes {
        let [json, _] = place.succeeds(&format!("inspect {words} --json"));
        let facts: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(facts["dims"], serde_json::json!(DIMS), "{format} {ending}: {json}");
        assert_eq!(facts["crc32"], serde_json::json!(crc), "{format} {ending}: {json}");
        assert_eq!(
            facts["range"],
            serde_json::json!([1.0, 162.0]),
            "{format} {ending}: {json}"
        );
    }
    let table = rows("Formats");
    let name = |row: &[String]| row[0].split([' ', ',']).next().unwrap().to_owned();
    // `.img` is the other half of `.hdr`.
    let listed: BTreeSet<(String, String)> = table
        .iter()
        .flat_map(|row| quoted(&row[0]).into_iter().map(|ending| (name(row), ending)))
        .filter(|(_, ending)| ending != ".img")
        .collect();
    let read: BTreeSet<(String, String)> = volumes
        .iter()
        .map(|(format, ending, _)| ((*format).to_owned(), (*ending).to_owned()))
        .collect();
    assert_eq!(listed, read);
    // What the program says it knows.
    place.write("l.vtk", "# vtk DataFile Version 3.0\n");
    let said = place.refuses("inspect l.vtk");
    let known = said.split("expected ").nth(1).unwrap().split("; raw").next().unwrap();
    let known = known.replace(" or a ", ", ").replace(" folder", "");
    let known: BTreeSet<String> = known.split(", ").map(str::to_owned).collect();
    let named: BTreeSet<String> = table.iter().map(|row| name(row)).filter(|name| name != "raw").collect();
    assert_eq!(known, named);
}

#[test]
fn scenes_are_those_of_the_table() {
    let place = Place::new();
    let said = place.refuses("render --scene no-such-scene");
    let known = said
        .split("or one of ")
        .nth(1)
        .unwrap()
        .split(" For more")
        .next()
        .unwrap();
    let known: BTreeSet<String> = known.split(", ").map(str::to_owned).collect();
    assert_eq!(first_cells("Scenes that come with the program"), known);
    place.block("a.nrrd");
    for scene in known {
        place.succeeds(&format!("render a.nrrd --scene {scene} -o {scene}.png"));
    }
}

#[test]
fn keys_of_inspect_and_plan_are_those_of_the_tables() {
    let place = Place::new();
    place.block("a.nrrd");
    let [json, _] = place.succeeds("inspect a.nrrd --json");
    assert_eq!(first_cells("What inspect tells as JSON"), keys(&json));
    let facts: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(facts["scene"], "headsq");
    assert_eq!(facts["presets"][0], facts["scene"]);
    assert_eq!(facts["warnings"], serde_json::json!([]));
    assert_eq!(facts["labels"], serde_json::json!(null));
    let [json, _] = place.succeeds("plan --dims 64x64x64 --scene ct-fog --precision compact --json");
    assert_eq!(first_cells("What plan tells as JSON"), keys(&json));
    let facts: serde_json::Value = serde_json::from_str(&json).unwrap();
    let number = |key: &str| facts[key].as_u64().unwrap();
    let parts = ["slices_bytes", "ranges_bytes", "scratch_bytes", "image_bytes"].map(number);
    assert_eq!(number("ram_bytes"), parts.iter().sum::<u64>());
    assert_eq!(number("table_bytes"), 20_480);
}

/// What inspect notes and warns of is what render says.
#[test]
fn inspect_and_render_say_the_same() {
    let place = Place::new();
    let told = |words: &str| {
        let [json, _] = place.succeeds(&format!("inspect {words} --json"));
        let facts: serde_json::Value = serde_json::from_str(&json).unwrap();
        let [_, said] = place.succeeds(&format!("render {words} -o out.png --force"));
        for kind in ["note", "warning"] {
            let said: Vec<&str> = said
                .lines()
                .filter_map(|line| line.strip_prefix(&format!("{kind}: ")))
                .collect();
            assert_eq!(facts[format!("{kind}s")], serde_json::json!(said), "{words}");
        }
        facts
    };
    place.nrrd("flat.nrrd", "uint8", [3, 3, 1], &[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(told("flat.nrrd")["notes"], serde_json::json!([]));
    place.block("a.nrrd");
    let facts = told("a.nrrd --window 0,100");
    assert_eq!(facts["clipped"][0], 128);
    // All that the window leaves is air, of which the scene shows nothing.
    let warning = told("a.nrrd --window -1024,-900")["warnings"][0].to_string();
    assert!(
        warning.contains("the picture shows nothing: no value between -999.99 and -900 is visible")
            && warning.contains("`--scene fog` shows everything above the background"),
        "{warning}"
    );
}

/// A label map is told label by label, with the numbers of the file.
#[test]
fn inspect_lists_labels() {
    let place = Place::new();
    let voxels = [0, 0, 0, 0, 7, 7, 0, 60_000].map(u16::to_le_bytes).concat();
    place.nrrd("labels.nrrd", "uint16", [2, 2, 2], &voxels);
    let [json, _] = place.succeeds("inspect labels.nrrd --json");
    let facts: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(facts["scene"], "labels");
    let column = |key: &str| [0, 1, 2].map(|line| facts["labels"][line][key].clone());
    assert_eq!(column("code"), [1.into(), 2.into(), serde_json::Value::Null]);
    assert_eq!(column("label"), [7.0.into(), 60_000.0.into(), serde_json::Value::Null]);
    assert_eq!(column("voxels"), [2.into(), 1.into(), serde_json::Value::Null]);
    place.succeeds("render labels.nrrd -o l.png");
    let legend: serde_json::Value = serde_json::from_slice(&fs::read(place.path("l.legend.json")).unwrap()).unwrap();
    assert_eq!(legend["labels"], facts["labels"]);
}
