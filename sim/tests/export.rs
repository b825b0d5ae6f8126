//! `slicecast export`: its files, its refusals, and that it leaves the files of others alone.

mod support;

use std::fs;

use support::Place;

fn names(place: &Place, folder: &str) -> Vec<String> {
    let entries = fs::read_dir(place.path(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| !name.starts_with('.')).collect();
    names.sort();
    names
}

#[test]
fn every_format_has_its_files() {
    let place = Place::new();
    place.block("a.nrrd");
    let export = |words: &str, folder: &str| {
        let [out, _] = place.succeeds(&format!("export a.nrrd {words} -o {folder}"));
        for said in [
            "program   slicecast ",
            "another number of planes per voxel needs another table",
            "memory ",
        ] {
            assert!(out.contains(said), "{out}");
        }
        names(&place, folder)
    };
    assert_eq!(export("--scene ct-bone --format rust", "r"), ["scene.rs"]);
    assert_eq!(
        export("--scene ct-bone --format c --name bone --voxels", "c"),
        ["bone.h", "bone_voxels.h"]
    );
    assert_eq!(export("--scene ct-fog --format json", "j"), ["scene.json"]);
    let hex = export("--scene ct-bone --format hex --voxels", "h");
    for name in [
        "direction.hex",
        "light_directions.hex",
        "manifest.json",
        "table.hex",
        "voxels.hex",
    ] {
        assert!(hex.iter().any(|written| written == name), "{name}: {hex:?}");
    }
    // The size of the picture is asked for, or the scene's.
    let read =
        |name: &str| -> serde_json::Value { serde_json::from_slice(&fs::read(place.path(name)).unwrap()).unwrap() };
    place.succeeds("export a.nrrd --scene ct-fog --format json --size 40x30 -o s");
    assert_eq!(
        read("s/scene.json")["quantities"]["picture"]["value"],
        serde_json::json!([40, 30])
    );
    // The table of `slicecast table` is the one that the bench reads.
    place.succeeds("table a.nrrd --scene ct-bone --format hex -o table.hex");
    assert_eq!(
        fs::read(place.path("table.hex")).unwrap(),
        fs::read(place.path("h/table.hex")).unwrap()
    );
}

#[test]
fn files_of_others_stay() {
    let place = Place::new();
    place.block("a.nrrd");
    let words = "export a.nrrd --scene ct-bone --format rust -o out";
    place.write("out/scene.rs", "mine");
    let said = place.refuses(words);
    assert!(
        said.contains("scene.rs was not written by slicecast, or has been changed since; --force replaces it"),
        "{said}"
    );
    assert_eq!(fs::read(place.path("out/scene.rs")).unwrap(), b"mine");
    place.succeeds(&format!("{words} --force"));
    // What it wrote it writes again.
    place.succeeds(words);
}

#[test]
fn what_does_not_go_together_is_one_line() {
    let place = Place::new();
    place.block("a.nrrd");
    for (words, expected) in [
        (
            "--format c --blend back-to-front",
            "--format c: the C interface has no pipeline of compact",
        ),
        (
            "--format c --lookup nearest",
            "with sqrt16 and nearest, front-to-back; accepted:",
        ),
        (
            "--format rust --name slicecast",
            "--name slicecast: expected letters, digits and _",
        ),
        ("--format rust --size 0x4", "expected 1 to 16384 pixels along each side"),
        ("--format verilog", "[possible values: rust, c, json, hex]"),
    ] {
        let said = place.refuses(&format!("export a.nrrd --scene ct-bone {words} -o out"));
        assert!(said.contains(expected), "{words}: {said}");
    }
    assert!(!place.path("out").exists());
    let said = place.refuses("export a.nrrd --scene ct-bone --format rust");
    assert!(said.contains("--output <DIR>"), "{said}");
}

/// Exported scenes classify samples: another setting is named, and what is accepted.
#[test]
fn segments_are_refused_by_the_scenes_setting() {
    let place = Place::new();
    place.block("a.nrrd");
    let refused = |words: &str, asked: &str| {
        let said = place.refuses(&format!("export a.nrrd {words} -o out"));
        let expected =
            format!("the scene asks for segments (render.classification = {asked}); use --classification point");
        assert!(said.contains(&expected), "{words}: {said}");
        assert!(!place.path("out").exists());
    };
    for format in ["rust", "c", "json", "hex"] {
        let words = format!("--scene ct-bone --classification integral --format {format}");
        refused(&words, "\"integral\"");
    }
    // A peak one code wide in a steep field: `auto` chooses segments.
    place.write("thin.toml", THIN);
    refused("--scene thin.toml --format json", "\"auto\", which chose them");
    place.succeeds("export a.nrrd --scene thin.toml --classification point --format json -o out");
}

const THIN: &str = "[render]\nclassification = \"auto\"\n[transfer]\npoints = [\n\
    { value = 600.0, colour = \"#ffffff\", opacity = 0.0 },\n\
    { value = 601.0, colour = \"#ffffff\", opacity = 0.9 },\n\
    { value = 602.0, colour = \"#ffffff\", opacity = 0.0 },\n]\n";
