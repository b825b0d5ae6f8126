//! `slicecast vectors`: what it writes is what it takes back, and an answer that departs is named by its first place.

mod support;

use std::fs;
use std::path::Path;

use support::Place;

fn files(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if entry.file_type().unwrap().is_dir() {
            names.extend(files(&entry.path()).into_iter().map(|file| format!("{name}/{file}")));
        } else {
            names.push(name);
        }
    }
    names
}

/// What a comparison says that does not hold: its words on standard error.
fn departs(place: &Place, words: &str) -> String {
    let output = place.run(words);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{words}: {text}");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Changes a line of a file.
fn change(place: &Place, name: &str, line: usize, change: impl Fn(&str) -> String) {
    let text = fs::read_to_string(place.path(name)).unwrap();
    let lines = text.lines().enumerate();
    let changed: Vec<_> = lines
        .map(|(at, own)| if at == line { change(own) } else { own.into() })
        .collect();
    place.write(name, changed.join("\n"));
}

#[test]
fn directed_vectors_come_back_and_a_fault_is_named() {
    let place = Place::new();
    let [out, err] = place.succeeds("vectors --directed --format hex -o v");
    assert!(out.contains("57 sets") && err.contains("MB of files"), "{out} {err}");
    let manifest: serde_json::Value =
        serde_json::from_slice(&fs::read(place.path("v/manifest.json")).unwrap()).unwrap();
    let sets = manifest["sets"].as_array().unwrap();
    let named: Vec<_> = sets.iter().flat_map(|set| set["files"].as_array().unwrap()).collect();
    let mut there = files(&place.path("v"));
    there.retain(|name| !name.starts_with('.') && name != "manifest.json");
    assert_eq!(named.len(), there.len());
    assert!(
        named.iter().all(|name| there.iter().any(|file| *name == file)),
        "{named:?}"
    );
    for set in sets {
        // A line has the digits that the manifest states.
        for (side, fields) in [("in", &set["inputs"]), ("out", &set["outputs"])] {
            let text =
                fs::read_to_string(place.path(&format!("v/{}.{side}.hex", set["name"].as_str().unwrap()))).unwrap();
            let digits = fields
                .as_array()
                .unwrap()
                .iter()
                .map(|field| field["digits"].as_u64().unwrap() as usize);
            let expected: Vec<_> = digits.collect();
            assert_eq!(text.lines().count() as u64, set["vectors"].as_u64().unwrap());
            let found: Vec<_> = text.lines().next().unwrap().split('_').map(str::len).collect();
            assert_eq!(found, expected, "{}", set["name"]);
        }
    }
    let [out, _] = place.succeeds("vectors --directed --compare v");
    assert!(
        out.contains("57 sets") && out.contains("all as the pipeline has them"),
        "{out}"
    );

    // A fault in each of two stages: the earlier one is named.
    change(&place, "v/compact/power.out.hex", 20, |_| "00000001".into());
    change(&place, "v/compact/cosine.out.hex", 7, |line| {
        line.replace(line, "0000000x")
    });
    let text = departs(&place, "vectors --directed --compare v");
    assert!(
        text.contains("first divergence at stage compact/cosine, vector 7, cosine: expected"),
        "{text}"
    );
    assert!(text.contains("found unknown (x); 1 of"), "{text}");
    let text = departs(&place, "vectors --directed --stage power --compare v");
    assert!(
        text.contains("stage compact/power, vector 20, power: expected") && text.contains("found 1;"),
        "{text}"
    );
    place.succeeds("vectors --directed --stage wide/power,shading --compare v");

    // The folder's files have been changed: they are not written over.
    let text = place.refuses("vectors --directed --format hex -o v");
    assert!(text.contains("cosine.out.hex") && text.contains("--force"), "{text}");
}

#[test]
fn what_is_no_answer_is_refused_by_its_file() {
    let place = Place::new();
    place.succeeds("vectors --directed --stage power -o v");
    let compare = "vectors --directed --stage power --compare v";
    place.succeeds(compare);
    // An array of another type is as good.
    change(&place, "v/wide/power.out.hex", 3, |_| "garbage".into());
    let text = place.refuses(compare);
    assert!(
        text.contains("wide/power.out.hex: line 4: `garbage` is no hexadecimal word of 8 digits"),
        "{text}"
    );
    let text = fs::read_to_string(place.path("v/paper/power.out.hex")).unwrap();
    place.write("v/paper/power.out.hex", &text[..text.len() / 2 / 9 * 9]);
    let text = place.refuses(compare);
    assert!(
        text.contains("paper/power.out.hex: 342 vectors, expected 684"),
        "{text}"
    );
    place.succeeds("vectors --directed --stage compact/power --compare v");
    let npy = fs::read(place.path("v/compact/power.out.npy")).unwrap();
    place.write("v/compact/power.out.npy", &npy[..npy.len() - 3]);
    let text = place.refuses("vectors --directed --stage compact/power --compare v");
    assert!(text.contains("compact/power.out.npy: no NPY array"), "{text}");
    fs::remove_file(place.path("v/compact/power.out.npy")).unwrap();
    place.succeeds("vectors --directed --stage compact/power --compare v");
    fs::remove_file(place.path("v/compact/power.out.hex")).unwrap();
    let text = place.refuses("vectors --directed --stage compact/power --compare v");
    assert!(text.contains("compact/power.out.hex: missing"), "{text}");
    let text = place.refuses("vectors --directed --stage powre --compare v");
    assert!(
        text.contains("--stage powre: no such stage here; there are: plan, start"),
        "{text}"
    );
}

#[test]
fn a_frame_comes_back_and_its_first_fault_has_plane_row_and_column() {
    let place = Place::new();
    place.block("block.nrrd");
    let frame = "vectors block.nrrd --scene ct-bone --planes 1";
    let [out, err] = place.succeeds(&format!("{frame} -o f"));
    assert!(out.contains("12 sets") && err.contains("at most"), "{out} {err}");
    let [out, _] = place.succeeds(&format!("{frame} --compare f"));
    assert!(out.contains("10 sets"), "{out}");
    let manifest: serde_json::Value =
        serde_json::from_slice(&fs::read(place.path("f/manifest.json")).unwrap()).unwrap();
    assert_eq!(manifest["constants"]["side_k"]["value"], 8);
    assert_eq!(manifest["constants"]["lights"]["bits"], 4);

    // Two faults: the later stage in the earlier plane comes first.
    let inputs = fs::read_to_string(place.path("f/compositing.in.hex")).unwrap();
    let lines: Vec<&str> = inputs.lines().collect();
    let at = lines.len() / 3;
    let words: Vec<i64> = lines[at]
        .split('_')
        .map(|word| i64::from_str_radix(word, 16).unwrap())
        .collect();
    fs::remove_file(place.path("f/compositing.out.npy")).unwrap();
    change(&place, "f/compositing.out.hex", at, |line| {
        let (start, _) = line.rsplit_once('_').unwrap();
        format!("{start}_abcd")
    });
    let last = fs::read_to_string(place.path("f/interpolation.out.hex"))
        .unwrap()
        .lines()
        .count()
        - 1;
    change(&place, "f/interpolation.out.hex", last, |_| "000001".into());
    let text = departs(&place, &format!("{frame} --compare f"));
    let [plane, phase, row, column] = words[..4] else {
        panic!("{words:?}")
    };
    let expected = format!(
        "first divergence at stage compositing, plane {plane}, phase {phase}, row {row}, column {column}, vector {at}, \
         after_t: expected"
    );
    assert!(text.contains(&expected) && text.contains("found 43981; 1 of"), "{text}");

    // Only a part, and what is too much.
    let [_, err] = place.succeeds(&format!(
        "{frame} --only-planes 2:3 --only-rows 1:4 --format npy -o part"
    ));
    assert!(err.contains("at most"), "{err}");
    assert!(!place.path("part/image.in.npy").exists());
    let text = place.refuses(&format!("{frame} --limit 0 -o large"));
    assert!(
        text.contains("more than --limit 0") && text.contains("--only-planes A:B"),
        "{text}"
    );
    assert!(!place.path("large").exists());
    let text = place.refuses(&format!("{frame} --stage voxels,table --compare f"));
    assert!(text.contains("only memories are named"), "{text}");
    let text = place.refuses(&format!("{frame} --only-planes 5:99 -o part"));
    assert!(text.contains("--only-planes 5:99: the frame ends at 8"), "{text}");
    let text = place.refuses(&format!("{frame} --only-rows 4:4 -o part"));
    assert!(text.contains("expected A:B with A below B"), "{text}");
    let text = place.refuses("vectors block.nrrd --directed -o d");
    assert!(text.contains("cannot be used with"), "{text}");
}

/// The sets of a frame have one sample an opacity.
#[test]
fn segments_are_refused_by_the_scenes_setting() {
    let place = Place::new();
    place.block("a.nrrd");
    for way in ["-o v", "--compare v"] {
        let said = place.refuses(&format!(
            "vectors a.nrrd --scene ct-bone --classification integral --only-planes 1:2 {way}"
        ));
        let expected = "segments (render.classification = \"integral\"); use --classification point";
        assert!(said.contains(expected), "{said}");
        assert!(!place.path("v").exists());
    }
}
