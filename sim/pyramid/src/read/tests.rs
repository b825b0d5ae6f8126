use super::*;
use crate::voxel::decode;
use crate::write::Level;

/// A volume of one row.
fn row(components: usize, values: Values) -> Colours {
    let voxels = values.len() / components;
    Colours::new("c".into(), [voxels, 1, 1], [1.0, 2.0, 3.0], components, values).unwrap()
}

fn over(distance: f64) -> Stated {
    Stated {
        alpha_distance: Some(distance),
        ..Stated::default()
    }
}

fn entries(read: &Read) -> Vec<Entry> {
    match &read.volume.voxels {
        Voxels::Entries(entries) => entries.clone(),
        Voxels::Codes(_) => panic!("codes"),
    }
}

#[test]
fn opacities_become_extinctions() {
    let read = of_colours(
        &row(4, Values::U8(vec![10, 20, 30, 0, 255, 0, 1, 128, 1, 2, 3, 200])),
        &over(0.5),
    )
    .unwrap();
    let tau = |alpha: f64| -(1.0 - alpha / 255.0).ln() / 0.5;
    assert!((read.volume.tau_max / tau(200.0) - 1.0).abs() < 1e-6);
    let half = (255.0 * (tau(128.0) / tau(200.0)).sqrt()).round() as u8;
    assert_eq!(entries(&read), [[10, 20, 30, 0], [255, 0, 1, half], [1, 2, 3, 255]]);
    assert_eq!((read.capped, read.lost), (0, 0));
    assert_eq!(
        (read.volume.spacing, read.volume.alpha_distance),
        ([1.0, 2.0, 3.0], Some(0.5))
    );
    assert!(read.notes().is_empty());
    // The same opacities over another distance: the same roots of another largest extinction.
    let other = of_colours(
        &row(4, Values::U8(vec![10, 20, 30, 0, 255, 0, 1, 128, 1, 2, 3, 200])),
        &over(2.0),
    )
    .unwrap();
    assert_eq!(entries(&other), entries(&read));
    assert!((other.volume.tau_max * 4.0 / read.volume.tau_max - 1.0).abs() < 1e-12);
}

#[test]
fn every_type_has_its_full_scale() {
    let eight = of_colours(&row(4, Values::U8(vec![0, 51, 255, 51, 0, 0, 0, 102])), &over(1.0)).unwrap();
    for values in [
        Values::U16(vec![0, 13107, 65535, 13107, 0, 0, 0, 26214]),
        Values::F32(vec![0.0, 0.2, 1.0, 0.2, 0.0, 0.0, 0.0, 0.4]),
        Values::F64(vec![0.0, 0.2, 1.0, 0.2, 0.0, 0.0, 0.0, 0.4]),
    ] {
        let read = of_colours(&row(4, values), &over(1.0)).unwrap();
        assert_eq!(entries(&read), entries(&eight));
        assert!((read.volume.tau_max / eight.volume.tau_max - 1.0).abs() < 1e-6);
    }
}

/// What is opaque is held to the limit, and counted; what is too faint for the root is counted too.
#[test]
fn what_is_capped_or_lost_is_counted() {
    let opaque = row(
        4,
        Values::F64(vec![1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 0.0]),
    );
    let read = of_colours(&opaque, &over(2.0)).unwrap();
    assert_eq!(read.volume.tau_max, OPAQUE / 2.0);
    assert_eq!((read.capped, read.lost), (1, 1));
    assert_eq!(entries(&read), [[255, 255, 255, 255], [0; 4], [0; 4]]);
    let notes = read.notes();
    assert!(
        notes[0].starts_with("1 of 3 voxels block more than tau_max = 7.500000 can"),
        "{notes:?}"
    );
    assert!(notes[1].starts_with("1 of 3 voxels block less than"), "{notes:?}");
    let stated = Stated {
        tau_max: Some(1.0),
        ..over(2.0)
    };
    let values = vec![
        0.0,
        0.0,
        0.0,
        0.9,
        0.0,
        0.0,
        0.0,
        0.8,
        0.0,
        0.0,
        0.0,
        1.0 - (-1.99_f64).exp(),
    ];
    let read = of_colours(&row(4, Values::F64(values)), &stated).unwrap();
    assert_eq!((read.volume.tau_max, read.capped), (1.0, 1));
    assert_eq!(entries(&read)[2][3], 254);
    let nothing = of_colours(&row(4, Values::U8(vec![1, 2, 3, 0])), &over(3.0)).unwrap();
    assert_eq!((nothing.volume.tau_max, entries(&nothing)), (5.0, vec![[1, 2, 3, 0]]));
}

#[test]
fn colours_without_opacity_need_a_rule() {
    let colours = row(3, Values::U8(vec![255, 255, 255, 0, 0, 0, 255, 0, 0]));
    assert_eq!(of_colours(&colours, &over(1.0)).unwrap_err(), RgbaError::NoOpacity);
    let stated = |rule| Stated {
        opacity: Some(rule),
        ..over(1.0)
    };
    let luminance = of_colours(&colours, &stated(OpacityRule::Luminance)).unwrap();
    let red = (255.0 * (-(1.0_f64 - 0.2126).ln() / OPAQUE).sqrt()).round() as u8;
    assert_eq!(entries(&luminance), [[255, 255, 255, 255], [0; 4], [255, 0, 0, red]]);
    assert_eq!(luminance.capped, 1);
    let constant = of_colours(&colours, &stated(OpacityRule::Constant(0.25))).unwrap();
    assert!(entries(&constant).iter().all(|entry| entry[3] == 255));
    assert!((constant.volume.tau_max + 0.75_f64.ln()).abs() < 1e-9);
    // White lies behind the last point, black before the first, red half-way between: 0.5, 0 and 0.25.
    let curve = Curve::new(&[[0.1126, 0.0], [0.3126, 0.5]]).unwrap();
    let found = of_colours(&colours, &stated(OpacityRule::Curve(curve))).unwrap();
    let root = (255.0 * (0.75_f64.ln() / 0.5_f64.ln()).sqrt()).round() as u8;
    assert!((found.volume.tau_max + 0.5_f64.ln()).abs() < 1e-6);
    assert_eq!(entries(&found), [[255, 255, 255, 255], [0; 4], [255, 0, 0, root]]);
}

/// Points that are no transfer function.
#[test]
fn curves_are_checked() {
    for points in [
        &[[0.5, 1.0]][..],
        &[[0.0, 0.0], [0.0, 1.0]],
        &[[0.5, 0.0], [0.2, 1.0]],
        &[[0.0, 0.0], [1.1, 1.0]],
        &[[0.0, -0.1], [1.0, 1.0]],
        &[[0.0, f64::NAN], [1.0, 1.0]],
        &[[0.0; 2]; 9],
    ] {
        assert_eq!(Curve::new(points), None, "{points:?}");
    }
    let nine: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i) / 8.0, 0.5]).collect();
    assert_eq!(Curve::new(&nine), None);
    let eight = Curve::new(&nine[..8]).unwrap();
    assert_eq!([0.0, 0.3, 1.0].map(|luminance| eight.at(luminance)), [0.5; 3]);
    let steps = Curve::new(&[[0.0, 0.0], [0.5, 0.2], [1.0, 1.0]]).unwrap();
    let found = [0.0, 0.25, 0.5, 0.75, 1.0].map(|luminance| (10.0 * steps.at(luminance)).round());
    assert_eq!(found, [0.0, 1.0, 2.0, 6.0, 10.0]);
}

#[test]
fn missing_or_surplus_meanings_are_refused() {
    let four = row(4, Values::U8(vec![1, 2, 3, 4]));
    assert_eq!(
        of_colours(&four, &Stated::default()).unwrap_err(),
        RgbaError::NoDistance
    );
    let stated = Stated {
        opacity: Some(OpacityRule::Luminance),
        ..over(1.0)
    };
    assert_eq!(of_colours(&four, &stated).unwrap_err(), RgbaError::OwnOpacity);
    let wrong = row(4, Values::I16(vec![1, 2, 3, 4]));
    assert_eq!(
        of_colours(&wrong, &over(1.0)).unwrap_err(),
        RgbaError::Type { found: "int16" }
    );
    for bad in [-0.1, 1.001, f32::NAN, f32::INFINITY] {
        let values = row(4, Values::F32(vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, bad]));
        let error = of_colours(&values, &over(1.0)).unwrap_err().to_string();
        assert!(
            error.starts_with("voxel (1, 0, 0) has the value") && error.ends_with("from 0 to 1"),
            "{error}"
        );
    }
}

#[test]
fn scalars_are_classified_voxel_by_voxel() {
    let volume = slicecast_volume::Volume {
        name: "s".into(),
        dims: [4, 1, 1],
        spacing: [0.5; 3],
        voxels: vec![0, 1, 4095, 1],
        mapping: slicecast_volume::Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    };
    let mut classified = vec![([0.5, 1.0, 0.0], 0.0); 4096];
    classified[1].1 = 0.25;
    classified[4095] = ([1.0, 0.0, 0.2], 0.75);
    let read = of_scalars(&volume, &Orientation::Space, &classified, 2.0, None);
    assert!((read.volume.tau_max - extinction_of(0.75, 2.0)).abs() < 1e-12);
    let root = (255.0 * (0.75_f64.ln() / 0.25_f64.ln()).sqrt()).round() as u8;
    assert_eq!(
        entries(&read),
        [
            [128, 255, 0, 0],
            [128, 255, 0, root],
            [255, 0, 51, 255],
            [128, 255, 0, root]
        ]
    );
    assert_eq!(
        (read.volume.name.as_str(), read.volume.dims, read.volume.spacing),
        ("s", [4, 1, 1], [0.5; 3])
    );
}

/// A level that was written, read again.
fn again(volume: &RgbaVolume, exact: bool) -> Read {
    let file = Level {
        volume,
        on_nodes: false,
        number: 3,
        filter: "(1,1)/2",
        exact,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.nrrd");
    std::fs::write(&path, file.file()).unwrap();
    let colours = slicecast_volume::nrrd::read_colours(&path).unwrap().unwrap();
    assert!(colours.notes().is_empty());
    of_colours(&colours, &Stated::default()).unwrap()
}

#[test]
fn levels_come_back() {
    let codes: Vec<Codes> = (0..24).map(|i| [i, 20 * i, 1300 * i, 1400 * i]).collect();
    let volume = RgbaVolume {
        name: "v".into(),
        dims: [4, 3, 2],
        spacing: [0.1, 0.2, 1.0 / 3.0],
        orientation: Orientation::Unknown,
        tau_max: 0.1 + 0.2,
        alpha_distance: Some(1.0 / 7.0),
        voxels: Voxels::Codes(codes.clone()),
    };
    let exact = again(&volume, true).volume;
    assert_eq!(exact.voxels, volume.voxels);
    assert_eq!(
        (exact.dims, exact.spacing, exact.tau_max),
        (volume.dims, volume.spacing, volume.tau_max)
    );
    assert_eq!(exact.alpha_distance, volume.alpha_distance);
    let bytes = again(&volume, false).volume;
    assert!(matches!(bytes.voxels, Voxels::Entries(_)));
    for (index, code) in codes.iter().enumerate() {
        // Half the distance of the roots around it.
        let away = f64::from(bytes.voxels.codes(index)[3].abs_diff(code[3]));
        assert!(
            away <= 1.0 + (2.0 * f64::from(code[3]) / 32767.0).sqrt() * 128.0,
            "{index}: {away}"
        );
    }
    // What was stored in bytes is stored in the same bytes again.
    assert_eq!(again(&bytes, false).volume.voxels, bytes.voxels);
}

#[test]
fn extinctions_of_files_are_checked() {
    let dims = [1, 1, 1];
    let with = |lines: &str, kind: &str, data: &[u8]| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("l.nrrd");
        let head = format!(
            "NRRD0005\ntype: {kind}\ndimension: 4\nsizes: 4 1 1 1\nkinds: 4-color domain domain domain\nencoding: raw\n\
             endian: little\nspacings: nan 1 1 1\n{lines}\n\n"
        );
        std::fs::write(&path, [head.as_bytes(), data].concat()).unwrap();
        let colours = slicecast_volume::nrrd::read_colours(&path).unwrap().unwrap();
        assert_eq!(colours.dims(), dims);
        colours
    };
    let refusal = |lines: &str, kind: &str, data: &[u8]| {
        of_colours(&with(lines, kind, data), &Stated::default())
            .unwrap_err()
            .to_string()
    };
    let eight = [1, 2, 3, 4, 5, 6, 7, 8];
    let found = refusal("slicecast_voxel:=root8", "uint8", &eight[..4]);
    assert_eq!(
        found,
        "header has no key `slicecast_tau_max`, expected the largest extinction, per unit of the spacing"
    );
    for bad in ["0", "-1", "1e-61", "1e13", "nan", "inf", "x", ""] {
        let found = refusal(
            &format!("slicecast_voxel:=root8\nslicecast_tau_max:={bad}"),
            "uint8",
            &eight[..4],
        );
        assert!(
            found.contains(&format!(
                "key `slicecast_tau_max` is `{bad}`, expected a number from 1e-60 to 1e12"
            )),
            "{found}"
        );
    }
    let found = refusal("slicecast_voxel:=root16\nslicecast_tau_max:=1", "uint8", &eight[..4]);
    assert!(
        found.contains("key `slicecast_voxel` is `root16`, expected `root8` or `extinction15`"),
        "{found}"
    );
    let found = refusal(
        "slicecast_voxel:=extinction15\nslicecast_tau_max:=1",
        "uint8",
        &eight[..4],
    );
    assert_eq!(
        found,
        "has 4 values of type uint8 a voxel, expected 4 of uint16 for `slicecast_voxel:=extinction15`"
    );
    let found = refusal("slicecast_voxel:=root8\nslicecast_tau_max:=1", "uint16", &eight);
    assert!(
        found.contains("expected 4 of uint8 for `slicecast_voxel:=root8`"),
        "{found}"
    );
    let codes = |codes: Codes| codes.map(u16::to_le_bytes).concat();
    for bad in [[0, 0, 0, 32768], [5, 4, 4, 4], [0, 0, 5, 4]] {
        let found = refusal(
            "slicecast_voxel:=extinction15\nslicecast_tau_max:=1",
            "uint16",
            &codes(bad),
        );
        assert!(found.contains("voxel (0, 0, 0) is ["), "{found}");
    }
    let own = with("slicecast_voxel:=root8\nslicecast_tau_max:=0.5", "uint8", &eight[..4]);
    assert_eq!(of_colours(&own, &over(1.0)).unwrap_err(), RgbaError::OwnExtinction);
    let read = of_colours(&own, &Stated::default()).unwrap();
    assert_eq!(
        (read.volume.tau_max, read.volume.voxels.codes(0)),
        (0.5, decode([1, 2, 3, 4]))
    );
}
