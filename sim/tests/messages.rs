//! What the program says to a mistake on the command line, and that what it prints can be read.

mod support;

use support::Place;

/// A mistake in the scene is told before the volume is read: here there is none.
#[test]
fn a_wrong_scene_is_told_first_and_lists_the_right_ones() {
    let place = Place::new();
    let text = place.refuses("render no-such-volume.nrrd --scene bonez -o a.png");
    assert!(text.contains("invalid value 'bonez' for '--scene <SCENE>'"), "{text}");
    assert!(
        text.contains("headsq, ct-bone, ct-soft-tissue, ct-vessels, ct-fog, ct-fog8,") && text.contains("labels"),
        "{text}"
    );
    assert!(!text.contains("no-such-volume"), "{text}");
    place.write(
        "bad.toml",
        "[view]\nelevation = 100.0\n[transfer]\npoints = [{ value = 0.0, colour = \"#ffffff\", opacity = 1.0 }]\n",
    );
    let text = place.refuses("render no-such-volume.nrrd --scene bad.toml -o a.png");
    assert!(text.contains("'bad.toml'") && text.contains("`view.elevation` is 100, expected a number from -90 to 90"));
    assert!(!text.contains("no-such-volume"), "{text}");
    place.write("bad.vp.json", "{}");
    let text = place.refuses("render no-such-volume.nrrd --transfer bad.vp.json -o a.png");
    assert!(text.contains("'bad.vp.json' for '--transfer <FILE>'"), "{text}");
    assert!(!text.contains("no-such-volume"), "{text}");
    let text = place.refuses("plan --dims 8x8x8 --scene labels");
    assert!(
        text.contains("--scene labels: is fitted to the values of a volume"),
        "{text}"
    );
}

#[test]
fn a_number_out_of_range_is_told_by_its_flag() {
    let place = Place::new();
    for (words, said) in [
        (
            "--elevation 100",
            "'100' for '--elevation <DEGREES>': expected a number from -90 to 90",
        ),
        (
            "--elevation nan",
            "'nan' for '--elevation <DEGREES>': expected a number from -90 to 90",
        ),
        (
            "--azimuth -361",
            "'-361' for '--azimuth <DEGREES>': expected a number from -360 to 360",
        ),
        (
            "--planes 17",
            "'17' for '--planes <N>': expected a whole number from 1 to 16",
        ),
        ("--rays 0", "'0' for '--rays <N>': expected a whole number from 1 to 8"),
        (
            "--rays two",
            "'two' for '--rays <N>': expected a whole number from 1 to 8",
        ),
    ] {
        let text = place.refuses(&format!("render no-such-volume.nrrd {words}"));
        assert!(text.contains(said), "{words}: {text}");
    }
}

/// No flag is meant as a value; what clap says of flags that are alike stays.
#[test]
fn an_unknown_flag_is_no_value() {
    let place = Place::new();
    for words in ["render --blackground white", "--blackground", "bench --blackground"] {
        let text = place.refuses(words);
        assert!(text.contains("unexpected argument '--blackground' found"), "{text}");
        assert!(!text.contains("as a value"), "{text}");
    }
    let text = place.refuses("render --elevatoin 10");
    assert!(text.contains("a similar argument exists: '--elevation'"), "{text}");
}

/// Spacings that leave no view, and values that no scene can state, name what is at fault.
#[test]
fn extremes_are_refused_by_name_or_rendered() {
    let place = Place::new();
    let text = place.refuses("plan --dims 8x8x8 --spacing 1e-320,1,1");
    assert!(
        text.contains("a voxel spacing of 1e-320 x 1 x 1; accepted: 1e-100 to 1e100"),
        "{text}"
    );
    let doubles = |last: f64| [0.0, 1e18, 5e18, last].map(f64::to_le_bytes).concat();
    place.nrrd("beyond.nrrd", "double", [2, 2, 1], &doubles(1e200));
    let text = place.refuses("render beyond.nrrd -o a.png");
    assert!(
        text.contains("beyond.nrrd: values from 0 to 1e200 cannot be divided into 4096 codes"),
        "{text}"
    );
    // Of 64 bits, what scenes can state.
    let integers = |last: u64| [0, 1 << 20, 1 << 39, last].map(u64::to_le_bytes).concat();
    place.nrrd("beyond.nrrd", "uint64", [2, 2, 1], &integers(u64::MAX));
    let text = place.refuses("render beyond.nrrd -o b.png");
    assert!(
        text.contains("beyond.nrrd: values from 0 to 18446744073709552000"),
        "{text}"
    );
    place.nrrd("large.nrrd", "uint64", [2, 2, 1], &integers(999_999_999_999));
    place.succeeds("render large.nrrd -o b.png");
}

/// 16-bit lanes know some scenes, and some commands do not know them: each says which field or precision it is.
#[test]
fn what_sixteen_bit_lanes_do_not_know_is_refused() {
    let place = Place::new();
    for (words, said) in [
        ("render --fov 40 -o a.png", "`view.projection` is given"),
        (
            "render --interpolation quadratic -o a.png",
            "`sampling.interpolation` is given",
        ),
        (
            "render --blend maximum --lookup nearest -o a.png",
            "`render.lookup` is given",
        ),
        (
            "render --classification integral -o a.png",
            "`render.classification` is given",
        ),
        ("render --reflectance 32 -o a.png", "`reflectance` is given"),
        ("render --lookup nearest -o a.png", "`render.lookup` is given"),
        ("render --splat -o a.png", "render.precision is given"),
        ("explain --scene ct-bone --ray 40,40", "use --precision compact"),
        ("vectors --scene ct-bone -o sets", "use --precision compact"),
        (
            "export --scene ct-bone --format rust -o numbers",
            "use --precision compact",
        ),
    ] {
        let text = place.refuses(&format!("{words} --precision fast"));
        assert!(text.contains(said) && !text.contains("panicked"), "{words}: {text}");
    }
    place.succeeds(
        "render --precision fast --scene ct-bone --crop 10:50,:,: --blend back-to-front --rays 1 --planes 1 -o a.png",
    );
    for blend in ["maximum", "minimum", "average", "additive"] {
        place.succeeds(&format!(
            "render --precision fast --scene mip --blend {blend} --rays 1 --planes 1 -o {blend}.png"
        ));
    }
}

/// What is outside of what 16-bit lanes do well is said: an opacity that climbs at once, gradients of few codes. Other precisions say
/// nothing.
#[test]
fn what_sixteen_bit_lanes_do_badly_is_said() {
    let place = Place::new();
    let codes = |most: u16| -> Vec<u8> { (0..512u16).flat_map(|n| (n * 37 % (most + 1)).to_le_bytes()).collect() };
    place.nrrd("many.nrrd", "uint16", [8, 8, 8], &codes(511));
    place.nrrd("few.nrrd", "uint16", [8, 8, 8], &codes(99));
    let scene = |from: u32, to: u32| {
        let point = |value, opacity| format!("{{ value = {value}.0, colour = \"#ffffff\", opacity = {opacity} }}");
        let points = [point(from, "0.0"), point(to, "0.9")].join(", ");
        format!("[transfer]\npoints = [{points}]\n[lighting]\n")
    };
    place.write("steep.toml", scene(30, 32));
    place.write("gentle.toml", scene(0, 99));
    for (volume, scene, said) in [
        ("many.nrrd", "steep.toml", Some("climbs by")),
        ("few.nrrd", "gentle.toml", Some("the volume has 100 codes, too few")),
        ("many.nrrd", "gentle.toml", None),
    ] {
        let warned = |precision: &str| {
            let [_, text] = place.succeeds(&format!(
                "render {volume} --scene {scene} --precision {precision} --rays 1 --planes 1 -o a.png --force"
            ));
            text
        };
        let text = warned("fast");
        match said {
            Some(said) => assert!(
                text.contains("warning: precision \"fast\"") && text.contains(said),
                "{text}"
            ),
            None => assert!(!text.contains("warning"), "{text}"),
        }
        assert!(!warned("compact").contains("warning"));
    }
}

/// The lines of a page have at most 100 columns.
#[test]
fn pages_fit_a_hundred_columns() {
    let place = Place::new();
    place.block("a.nrrd");
    for words in [
        "compare a.nrrd --scene headsq --converged",
        "compare a.nrrd --scene headsq --precision paper",
        "explain a.nrrd --scene headsq --ray 4,4 --all",
        "explain a.nrrd --scene ct-fog --precision wide --ray 5,3",
    ] {
        let [out, _] = place.succeeds(words);
        assert!(out.lines().count() > 15, "{words}: {out}");
        for line in out.lines() {
            assert!(line.chars().count() <= 100, "{words}: {line}");
        }
        // A word or number that was broken would begin a line of its own.
        for word in ["compositing: colour", "transparency"] {
            assert!(out.contains(word) || words.contains("explain"), "{words}: {out}");
        }
    }
}

#[test]
fn a_table_that_is_written_is_not_drawn() {
    let place = Place::new();
    place.block("a.nrrd");
    let chart = "opacity a step";
    let [shown, _] = place.succeeds("table a.nrrd --scene ct-bone");
    assert!(shown.contains(chart) && shown.lines().count() > 10, "{shown}");
    let [out, _] = place.succeeds("table a.nrrd --scene ct-bone --format c -o t.h");
    assert!(!out.contains(chart) && out.lines().count() == 2, "{out}");
    assert!(out.contains("t.h: ") && out.contains("4096 entries"), "{out}");
}

/// A scene of segments has a table of integrals, the same from every view.
#[test]
fn a_table_of_integrals_is_that_of_every_view() {
    let place = Place::new();
    place.block("a.nrrd");
    let table = "table a.nrrd --scene ct-bone --classification integral";
    let [shown, _] = place.succeeds(table);
    assert!(
        shown.contains("1024 bins of 4 code(s)") && shown.contains("opacity over the smallest spacing"),
        "{shown}"
    );
    assert!(shown.lines().count() > 10, "{shown}");
    let written = |name: &str, bins: usize, words: &str| {
        let [out, _] = place.succeeds(&format!("{table} --format hex --bins {bins} {words} -o {name}"));
        assert!(
            out.starts_with(&format!("{bins} bins of ")) && out.lines().count() == 2,
            "{out}"
        );
        let text = std::fs::read_to_string(place.path(name)).unwrap();
        let nodes = text.lines().filter(|line| !line.starts_with("//")).count();
        assert_eq!(nodes, bins + 1);
        for said in ["// scene     ct-bone\n", "// volume    a.nrrd, 8 x 8 x 8 voxels"] {
            assert!(text.contains(said), "{said}");
        }
        text
    };
    let turned = written("b.hex", 512, "--azimuth 40 --planes 3");
    assert!(written("a.hex", 512, "--azimuth 0 --planes 1") == turned);
    written("c.hex", 4096, "--azimuth 0");
    let said = place.refuses(&format!("{table} --bins 1000"));
    assert!(said.contains("expected 4096, 2048, 1024, 512 or 256"), "{said}");
    let said = place.refuses("table a.nrrd --scene ct-bone --bins 512");
    assert!(said.contains("--bins: the scene classifies samples"), "{said}");
}

/// Where standard error is no terminal, the parts of a report are told; and one can be left out.
#[cfg(feature = "laboratory")]
#[test]
fn a_report_tells_its_parts_and_leaves_out_what_it_is_told_to() {
    let place = Place::new();
    place.block("a.nrrd");
    let report = "report a.nrrd --scene ct-bone --no-sweep --no-hard";
    let [_, err] = place.succeeds(&format!("{report} -o all.html"));
    for part in [
        "paper: comparing",
        "compact: comparing",
        "wide: comparing",
        "compact: comparing with the converged integral",
    ] {
        assert!(err.contains(part), "{err}");
    }
    let [_, err] = place.succeeds(&format!("{report} --no-converged -o short.html"));
    assert!(!err.contains("converged"), "{err}");
    let page = |name| std::fs::read_to_string(place.path(name)).unwrap();
    assert!(page("all.html").contains("Arithmetic and algorithm"));
    assert!(!page("short.html").contains("Arithmetic and algorithm"));
}

/// Every speed has its spread beside it, and one thread gives each row once.
#[test]
fn speeds_have_a_spread_and_rows_are_told_once() {
    let place = Place::new();
    place.block("a.nrrd");
    let [out, _] = place.succeeds("bench a.nrrd --scene ct-bone --sides 0 --frames 4 --threads 1 --json b.json");
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(place.path("b.json")).unwrap()).unwrap();
    for section in report["sections"].as_array().unwrap() {
        let mut seen = Vec::new();
        for row in section["rows"].as_array().unwrap() {
            let who = ["engine", "width", "threads"].map(|key| row[key].to_string());
            assert!(!seen.contains(&who), "{who:?}");
            seen.push(who);
            let number = |key: &str| row[key].as_f64().unwrap_or(-1.0);
            assert!(number("spread") >= 0.0 && number("against_f32") > 0.0, "{row}");
            assert!(
                number("against_compact") > 0.0 && number("samples_per_second") > 0.0,
                "{row}"
            );
        }
        assert_eq!(seen.len(), 4, "fast, compact, wide and f32");
        // Of the scene as it is and of the one with nothing to skip.
        if section["name"].as_str().unwrap().ends_with("unlit") {
            assert!(section["ways"].is_null(), "{section}");
            continue;
        }
        let ways = section["ways"].as_array().unwrap();
        let names: Vec<_> = ways.iter().map(|way| way["way"].as_str().unwrap()).collect();
        let wanted = [
            "rays, parallel",
            "rays, in perspective",
            "splats, parallel",
            "splats, in perspective",
        ];
        assert_eq!(names, wanted);
        for way in ways {
            let keys: Vec<_> = way.as_object().unwrap().keys().map(String::as_str).collect();
            let wanted = ["against_rays", "count", "milliseconds", "spread", "threads", "way"];
            assert!(
                wanted.iter().all(|key| keys.contains(key)) && keys.len() == wanted.len(),
                "{way}"
            );
            let number = |key: &str| way[key].as_f64().unwrap_or(-1.0);
            assert!(number("milliseconds") > 0.0 && number("against_rays") > 0.0, "{way}");
            assert!(
                number("count") > 0.0 && number("threads") == 1.0 && number("spread") >= 0.0,
                "{way}"
            );
        }
    }
    assert!(out.contains("± %") && out.contains("to f32"), "{out}");
}

#[cfg(feature = "laboratory")]
#[test]
fn speeds_of_a_sweep_have_a_spread() {
    let place = Place::new();
    place.block("a.nrrd");
    let sweep = "sweep a.nrrd --scene ct-fog --only compact,paper,position-8 --rounds 4 --json s.json";
    let [out, _] = place.succeeds(sweep);
    let head = out.lines().next().unwrap();
    assert!(head.contains(" speed |") && head.contains("± %"), "{out}");
    let rows: serde_json::Value = serde_json::from_slice(&std::fs::read(place.path("s.json")).unwrap()).unwrap();
    for row in rows.as_array().unwrap() {
        assert!(
            row["speed_spread"].as_f64().unwrap() >= 0.0 && row["within_spread"].is_boolean(),
            "{row}"
        );
    }
}

/// A reader that has enough of the output is no fault of the program's.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_panic() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_slicecast"))
        .args(["plan", "--dims", "64x64x64"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
