use super::*;

const VP: &str = "1\n1\n0.9\n0.1\n0.2\n10\n6 -100 0 0 0.5 100 1\n4 0 1 255 1\n8 -100 0 0 0 100 1 0.5 0\n";

fn values(imported: &Imported) -> Vec<(f64, f64)> {
    imported.transfer.points.iter().map(|p| (p.value, p.opacity)).collect()
}

#[test]
fn slicers_lines_are_joined() {
    let imported = parse(VP, Kind::SlicerText).unwrap();
    assert_eq!(values(&imported), [(-100.0, 0.0), (0.0, 0.5), (100.0, 1.0)]);
    assert_eq!(imported.transfer.points[1].colour, [0.5, 0.25, 0.0]);
    let Some(Shading::On(lighting)) = imported.shading else {
        panic!()
    };
    assert_eq!(
        (lighting.diffuse, lighting.ambient, lighting.exponent_log2),
        (0.9, 0.1, 3)
    );
    let graded = parse(&VP.replace("4 0 1 255 1", "4 0 0 255 1"), Kind::SlicerText).unwrap();
    assert!(graded.notes.iter().any(|note| note.contains("gradient")));
}

#[test]
fn slicers_json_follows_midpoints_and_steps() {
    let text = r#"{"@schema": "s", "volumeProperties": [{"effectiveRange": [0, 8], "components": [{
        "shade": false, "scalarOpacityUnitDistance": 2.5,
        "scalarOpacity": {"type": "piecewiseLinearFunction", "points": [
            {"x": 0, "y": 0, "midpoint": 0.25, "sharpness": 0}, {"x": 4, "y": 1, "midpoint": 0.5, "sharpness": 1},
            {"x": 8, "y": 0, "midpoint": 0.5, "sharpness": 0}]},
        "rgbTransferFunction": {"points": [{"x": 4, "color": [0, 0, 0]}, {"x": 4, "color": [1, 1, 1]}]}}]}]}"#;
    let imported = parse(text, Kind::SlicerJson).unwrap();
    assert_eq!(imported.transfer.unit_distance, 2.5);
    assert_eq!(imported.shading, Some(Shading::Off));
    let expected = [
        (0.0, 0.0),
        (1.0, 0.5),
        (4.0, 1.0),
        (4.0, 1.0),
        (6.0, 1.0),
        (6.0, 0.0),
        (8.0, 0.0),
    ];
    assert_eq!(values(&imported), expected);
    let f = |x| imported.transfer.evaluate(x);
    assert_eq!((f(3.9).0, f(4.0).0), ([0.0; 3], [1.0; 3]));
    assert_eq!((f(0.5).1, f(5.9).1, f(6.0).1), (0.25, 1.0, 0.0));
}

#[test]
fn paraviews_maps_are_read() {
    let text = r#"[{"ColorSpace": "Diverging", "Name": "a", "RGBPoints": [0, 0, 0, 0, 10, 1, 1, 1],
        "Points": [0, 0, 0.5, 0, 5, 0.25, 0.5, 0, 10, 1, 0.5, 0]}, {"RGBPoints": [0, 0, 0, 0]}]"#;
    let imported = parse(text, Kind::ParaView).unwrap();
    assert_eq!(values(&imported), [(0.0, 0.0), (5.0, 0.25), (10.0, 1.0)]);
    assert_eq!(imported.notes.len(), 3);
    let plain = parse(r#"{"RGBPoints": [-1, 0, 0, 0, 3, 1, 1, 1]}"#, Kind::ParaView).unwrap();
    assert_eq!(plain.transfer.evaluate(1.0), ([0.5; 3], 0.5));
}

#[test]
fn damaged_files_are_refused_in_one_line() {
    for (kind, text, expected) in [
        (Kind::SlicerText, "", "ends before line 1"),
        (Kind::SlicerText, "1\nx", "line 2 is no number"),
        (
            Kind::SlicerText,
            &VP.replace("6 -100", "8 -100"),
            "line 7 has 6 numbers, expected 8",
        ),
        (
            Kind::SlicerText,
            &VP.replace("6 -100", "6 nan"),
            "line 7 has a word that is no finite number",
        ),
        (
            Kind::SlicerText,
            &VP.replace("100 1\n4", "100 2\n4"),
            "`transfer.points[2].opacity` is 2",
        ),
        (Kind::SlicerJson, "{}", "missing field `volumeProperties`"),
        (
            Kind::SlicerJson,
            r#"{"volumeProperties": []}"#,
            "`volumeProperties` is empty",
        ),
        (
            Kind::SlicerJson,
            r#"{"volumeProperties": [{"components": [{}]}]}"#,
            "no points in `scalarOpacity`",
        ),
        (Kind::ParaView, "[]", "is an empty list"),
        (
            Kind::ParaView,
            r#"[{"RGBPoints": [1, 2, 3]}]"#,
            "`RGBPoints` has 3 numbers",
        ),
        (
            Kind::ParaView,
            r#"[{"RGBPoints": [1e300, 0, 0, 0]}]"#,
            "`transfer.points[0].value` is 1",
        ),
        (Kind::ParaView, &"[".repeat(1000), "recursion limit"),
    ] {
        let message = parse(text, kind).unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn names_tell_the_kind() {
    for (name, kind) in [
        ("a.vp", Some(Kind::SlicerText)),
        ("a.VP.json", Some(Kind::SlicerJson)),
        ("a.json", Some(Kind::ParaView)),
        ("a.toml", None),
    ] {
        assert_eq!(Kind::of(Path::new(name)), kind);
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig {
        cases: 1000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
        ..proptest::prelude::ProptestConfig::default()
    })]

    /// Whatever a file says, reading ends with a checked function or an error of one line.
    #[test]
    fn mutated_files_never_panic(edits in proptest::collection::vec((0_usize..300, 0_u8..128), 0..6)) {
        let json = r#"{"volumeProperties":[{"components":[{"scalarOpacity":{"points":[{"x":0,"y":0},{"x":9,"y":1}]},
            "rgbTransferFunction":{"points":[{"x":0,"color":[0,0,0]},{"x":9,"color":[1,1,1]}]}}]}]}"#;
        let map = r#"[{"ColorSpace":"Step","RGBPoints":[0,0,0,0,9,1,1,1],"Points":[0,0,0.5,0,9,1,0.5,0]}]"#;
        for (kind, text) in [(Kind::SlicerText, VP), (Kind::SlicerJson, json), (Kind::ParaView, map)] {
            let mut bytes = text.as_bytes().to_vec();
            for &(at, byte) in &edits {
                let at = at % bytes.len();
                bytes[at] = byte;
            }
            let text = String::from_utf8(bytes).unwrap();
            match parse(&text, kind) {
                Ok(imported) => proptest::prop_assert!(check::transfer(&imported.transfer).is_ok()),
                Err(fault) => proptest::prop_assert!(!fault.to_string().contains('\n')),
            }
        }
    }
}
