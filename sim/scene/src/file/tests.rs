//! The scenes that ship, the defaults, and every refusal with its field's name and range.

use proptest::prelude::*;

use super::*;
use crate::clip::Clip;
use crate::crop::Crop;
use crate::cueing::Cueing;
use crate::{
    AlphaCodeName, Blend, Borders, Classification, Face, Frame, Highlight, Interpolation, Lighting, LookupName,
    PrecisionName, Sampling, Surface, View,
};

const MINIMAL: &str = "[transfer]\npoints = [{ value = 0, colour = \"#ffffff\", opacity = 0.5 }]\n";

fn scene(text: &str) -> Result<Scene, SceneError> {
    parse(text, "s.toml")
}

/// The minimal scene with more lines after it.
fn with(lines: &str) -> Result<Scene, SceneError> {
    scene(&format!("{MINIMAL}{lines}"))
}

fn points(points: &str) -> Result<Scene, SceneError> {
    scene(&format!("[transfer]\npoints = [{points}]"))
}

#[test]
fn the_scenes_that_ship_are_sound() {
    for (name, _) in BUILT_IN {
        let scene = built_in(name).unwrap();
        assert_eq!(scene.transfer.evaluate(-1024.0).1, 0.0, "{name}: air is transparent");
    }
    let head = built_in(DEFAULT).unwrap();
    assert_eq!(head.lighting.unwrap().lights.len(), 2);
    assert_eq!(
        head.view,
        View {
            azimuth: 30.0,
            elevation: 10.0,
            roll: 0.0
        }
    );
    assert_eq!(
        (
            built_in("ct-fog").unwrap().lighting,
            built_in("ct-fog8").unwrap().sampling.planes_per_voxel
        ),
        (None, 8)
    );
    let text = built_in("fog").unwrap_err().to_string();
    assert_eq!(
        text,
        "fog: is no built-in scene, expected one of headsq, ct-bone, ct-soft-tissue, ct-vessels, ct-fog, ct-fog8"
    );
}

/// Tables hold 8-bit colours, which round ramps: where a shipped scene is visible, its colour does not change.
#[test]
fn the_scenes_that_ship_have_no_visible_colour_ramps() {
    for (name, _) in BUILT_IN {
        for pair in built_in(name).unwrap().transfer.points.windows(2) {
            let visible = pair[0].opacity > 0.0 || pair[1].opacity > 0.0;
            assert!(!visible || pair[0].colour == pair[1].colour, "{name}: {pair:?}");
        }
    }
}

/// The reference file states the defaults as comments and lines; this holds its words to the program.
#[test]
fn the_reference_states_every_field() {
    let (_, text) = BUILT_IN[0];
    for field in [
        "azimuth",
        "elevation",
        "roll",
        "size",
        "zoom",
        "background",
        "planes_per_voxel",
        "rays_per_voxel",
        "interpolation",
        "borders",
        "x",
        "y",
        "z",
        "unit",
        "unit_distance",
        "points",
        "ambient",
        "diffuse",
        "specular",
        "exponent",
        "highlight",
        "direction",
        "frame",
        "colour",
        "blend",
        "precision",
        "table",
        "lookup",
        "early_termination",
        "opacity",
    ] {
        assert!(text.contains(&format!("{field} = ")), "{field}");
    }
    let commented = text.replace("# size =", "size =").replace("# table =", "table =");
    let commented = commented
        .replace("# lookup =", "lookup =")
        .replace("# early_term", "early_term");
    let all = scene(&commented).unwrap();
    assert_eq!((all.image.size, all.early_termination), (Some([512, 512]), Some(12)));
    assert_eq!(
        (all.table, all.lookup),
        (Some(AlphaCodeName::Sqrt16), Some(LookupName::Nearest))
    );
}

#[test]
fn what_is_left_out_has_its_default() {
    let scene = with("").unwrap();
    assert_eq!((scene.view, scene.image, scene.sampling), Default::default());
    assert_eq!(
        (scene.interpolation, scene.borders),
        (Interpolation::Linear, Borders::Cells)
    );
    assert_eq!((scene.lighting, scene.transfer.unit_distance), (None, 1.0));
    assert_eq!(
        (scene.blend, scene.precision),
        (Blend::FrontToBack, PrecisionName::Compact)
    );
    assert_eq!((scene.table, scene.lookup, scene.early_termination), (None, None, None));
    assert_eq!(with("[lighting]").unwrap().lighting, Some(Lighting::default()));
}

#[test]
fn boxes_arrive() {
    let cropped = |lines: &str| {
        let scene = with(&format!("[sampling]\nborders = \"cells\"\n[crop]\n{lines}")).unwrap();
        scene.crop.unwrap()
    };
    assert_eq!(cropped(""), Crop::NONE);
    assert_eq!(
        cropped("x = \"1.5:\"\nz = \":9\"\nunit = \"voxels\""),
        Crop::parse("1.5:,:,:9").unwrap()
    );
    assert_eq!(cropped("y = \"2:3\"\nunit = \"mm\""), Crop::parse(":,2:3,:mm").unwrap());
    assert_eq!(with("").unwrap().crop, None);
    let clipped = with("[[clip]]\npoint = [1, 2.5, -3]\nnormal = [0, 0, 1]\nfalloff = 2\nkeep = \"outside\"\nunit = \"mm\"\n[cueing]\nfrom = 0.25").unwrap();
    assert_eq!(
        clipped.clips,
        [Clip::parse("1,2.5,-3:0,0,1:falloff=2:outside:mm").unwrap()]
    );
    assert_eq!(clipped.cueing.unwrap(), Cueing::parse("0.7,0.25,1").unwrap());
    let seven = "[[clip]]\npoint = [1, 2, 3]\nnormal = [0, 0, 1]\n".repeat(7);
    assert!(
        with(&seven)
            .unwrap_err()
            .to_string()
            .contains("`clip` is 7, expected at most 6 planes")
    );
}

#[test]
fn every_field_arrives() {
    let scene = with(
        "[view]\nroll = -5\n[image]\nsize = [3, 4]\nzoom = 2\nbackground = [0, 0.5, 1]\n\
         [sampling]\nplanes_per_voxel = 16\nrays_per_voxel = 8\ninterpolation = \"nearest\"\nborders = \"nodes\"\n\
         [lighting]\nexponent = 256\nhighlight = \"half-vector\"\n\
         [[lighting.lights]]\ndirection = [0, -3e200, 4e200]\nframe = \"volume\"\ncolour = \"#ff0000\"\n\
         [render]\nblend = \"minimum\"\nprecision = \"wide\"\ntable = \"sqrt8\"\nlookup = \"linear\"\nearly_termination = 20",
    )
    .unwrap();
    assert_eq!(
        (scene.interpolation, scene.borders),
        (Interpolation::Nearest, Borders::Nodes)
    );
    assert_eq!(
        (scene.view.roll, scene.image.size, scene.image.zoom),
        (-5.0, Some([3, 4]), 2.0)
    );
    assert_eq!(scene.image.background, [0.0, 0.5, 1.0]);
    assert_eq!(
        scene.sampling,
        Sampling {
            planes_per_voxel: 16,
            rays_per_voxel: 8
        }
    );
    let lighting = scene.lighting.unwrap();
    assert_eq!((lighting.exponent_log2, lighting.highlight), (8, Highlight::HalfVector));
    assert_eq!(
        (lighting.lights[0].frame, lighting.lights[0].colour),
        (Frame::Volume, [1.0, 0.0, 0.0])
    );
    for (got, want) in lighting.lights[0].direction.iter().zip([0.0, -0.6, 0.8]) {
        assert!((got - want).abs() < 1e-15, "{got} {want}");
    }
    assert_eq!((scene.blend, scene.precision), (Blend::Minimum, PrecisionName::Wide));
    assert_eq!(
        (scene.table, scene.lookup),
        (Some(AlphaCodeName::Sqrt8), Some(LookupName::Linear))
    );
    assert_eq!(scene.early_termination, Some(20));
}

#[test]
fn values_out_of_range_are_refused_with_field_value_and_range() {
    for (lines, expected) in [
        (
            "[view]\nazimuth = nan",
            "`view.azimuth` is NaN, expected a number from -360 to 360",
        ),
        ("[view]\nazimuth = inf", "`view.azimuth` is inf, expected"),
        (
            "[view]\nelevation = 90.5",
            "`view.elevation` is 90.5, expected a number from -90 to 90",
        ),
        (
            "[view]\nroll = 361",
            "`view.roll` is 361, expected a number from -360 to 360",
        ),
        (
            "[image]\nsize = [0, 1]",
            "`image.size[0]` is 0, expected a whole number from 1 to 16384",
        ),
        ("[image]\nsize = [1, 16385]", "`image.size[1]` is 16385, expected"),
        (
            "[image]\nzoom = 0",
            "`image.zoom` is 0, expected a number from 0.01 to 100",
        ),
        (
            "[image]\nbackground = [0, 0, 1.5]",
            "`image.background` is [0.0, 0.0, 1.5], expected \"#rrggbb\" or",
        ),
        (
            "[image]\nbackground = \"black\"",
            "`image.background` is \"black\", expected \"#rrggbb\" or three numbers",
        ),
        (
            "[sampling]\nplanes_per_voxel = 0",
            "`sampling.planes_per_voxel` is 0, expected a whole number from 1 to 16",
        ),
        ("[sampling]\nplanes_per_voxel = 17", "`sampling.planes_per_voxel` is 17"),
        (
            "[sampling]\nborders = \"cells\"\n[crop]\nx = \"4:3\"",
            "`crop.x` is \"4:3\", expected a range such as",
        ),
        (
            "[sampling]\nborders = \"cells\"\n[crop]\nunit = \"cm\"",
            "`crop.unit` is \"cm\", expected \"voxels\" or \"mm\"",
        ),
        (
            "[sampling]\nborders = \"whole\"\n[crop]\nz = \"1:2\"",
            "`crop` is given, expected sampling.borders \"cells\" or \"nodes\"",
        ),
        (
            "[[clip]]\npoint = [1, 2, 3]\nnormal = [0, 0, 0]",
            "`clip[0].normal` is 0, 0, 0, expected three numbers",
        ),
        (
            "[[clip]]\npoint = [1, 2, 3]\nnormal = [0, 0, 1]\n[[clip]]\npoint = [1, 2, 3]\nnormal = [0, 0, 1]\nthickness = 0",
            "`clip[1].thickness` is 0, expected above 0",
        ),
        (
            "[[clip]]\npoint = [1, 2, inf]\nnormal = [0, 0, 1]",
            "`clip[0].point` is 1, 2, inf, expected three numbers",
        ),
        (
            "[[clip]]\npoint = [1, 2, 3]\nnormal = [0, 0, 1]\nfalloff = -2.5",
            "`clip[0].falloff` is -2.5, expected 0 to 1e9",
        ),
        ("[cueing]\nstrength = 1.5", "`cueing.strength` is 1.5, expected 0 to 1"),
        (
            "[cueing]\nfrom = 0.5\nto = 0.25",
            "`cueing.to` is 0.25, expected above `from`",
        ),
        (
            "[cueing]\n[render]\nblend = \"maximum\"",
            "`cueing` is given, expected render.blend",
        ),
        (
            "[sampling]\nrays_per_voxel = -9",
            "`sampling.rays_per_voxel` is -9, expected a whole number from 1 to 8",
        ),
        (
            "[lighting]\nambient = 1.1",
            "`lighting.ambient` is 1.1, expected a number from 0 to 1",
        ),
        ("[lighting]\ndiffuse = -0.1", "`lighting.diffuse` is -0.1"),
        ("[lighting]\nspecular = nan", "`lighting.specular` is NaN"),
        (
            "[lighting]\nexponent = 33",
            "`lighting.exponent` is 33, expected a power of two from 1 to 256",
        ),
        ("[lighting]\nexponent = 0", "`lighting.exponent` is 0"),
        ("[lighting]\nexponent = 512", "`lighting.exponent` is 512"),
        (
            "[lighting]\nexponent = -4294967295",
            "`lighting.exponent` is -4294967295",
        ),
        (
            "[lighting]\nlights = []",
            "`lighting.lights` is a list of 0, expected 1 to 8 entries",
        ),
        (
            "[[lighting.lights]]\ndirection = [0, 0, 0]",
            "`lighting.lights[0].direction` is [0.0, 0.0, 0.0], expected three",
        ),
        (
            "[[lighting.lights]]\ndirection = [0, nan, 1]",
            "`lighting.lights[0].direction` is [0.0, NaN, 1.0]",
        ),
        (
            "[[lighting.lights]]\ndirection = [0, inf, 1]",
            "`lighting.lights[0].direction`",
        ),
        (
            "[[lighting.lights]]\ndirection = [0, 0, 1]\ncolour = [2, 0, 0]",
            "`lighting.lights[0].colour` is [2.0, 0.0",
        ),
        (
            "[render]\nearly_termination = 0",
            "`render.early_termination` is 0, expected a whole number from 1 to 20",
        ),
        ("[render]\nearly_termination = 21", "`render.early_termination` is 21"),
    ] {
        let text = with(lines).unwrap_err().to_string();
        assert!(
            text.starts_with("s.toml: ") && text.contains(expected),
            "{lines}: {text}"
        );
    }
    let nine = "[[lighting.lights]]\ndirection = [0, 0, 1]\n".repeat(9);
    assert!(
        with(&nine)
            .unwrap_err()
            .to_string()
            .contains("`lighting.lights` is a list of 9, expected 1 to 8 entries")
    );
}

#[test]
fn impossible_transfer_functions_are_refused() {
    let a = "{ value = 5, colour = [1, 1, 1], opacity = 0.5 }";
    for (text, expected) in [
        (
            String::new(),
            "`transfer.points` is a list of 0, expected 1 to 4096 entries",
        ),
        (
            format!("{a}, {{ value = 4, colour = [1, 1, 1], opacity = 0 }}"),
            "`transfer.points[1].value` is 4, expected 5 or more: points ascend",
        ),
        (
            format!("{a}, {a}, {a}"),
            "`transfer.points[2].value` is 5, expected at most two points of a value",
        ),
        (
            format!("{a}, {{ value = nan, colour = [1, 1, 1], opacity = 0 }}"),
            "`transfer.points[1].value` is NaN, expected a number from -1e100 to 1e100",
        ),
        (
            "{ value = 0, colour = [1, 1, 1], opacity = 1.01 }".into(),
            "`transfer.points[0].opacity` is 1.01, expected a number from 0 to 1",
        ),
        (
            "{ value = 0, colour = \"#12345\", opacity = 1 }".into(),
            "`transfer.points[0].colour` is \"#12345\", expected \"#rrggbb\"",
        ),
        (
            "{ value = 0, colour = [1, 1, -1], opacity = 1 }".into(),
            "`transfer.points[0].colour` is [1.0, 1.0, -1.0]",
        ),
        (vec![a; 4097].join(","), "`transfer.points` is a list of 4097"),
    ] {
        let message = points(&text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text:.60}: {message}");
    }
    let text = format!("[transfer]\nunit_distance = 0\npoints = [{a}]");
    let message = scene(&text).unwrap_err().to_string();
    assert!(
        message.contains("`transfer.unit_distance` is 0, expected a number from 0.000001 to 1000000"),
        "{message}"
    );
}

#[test]
fn unknown_and_missing_fields_and_wrong_types_are_refused() {
    for (lines, expected) in [
        (
            "[view]\nazimut = 1",
            "unknown field `azimut`, expected one of `azimuth`, `elevation`, `roll`",
        ),
        ("[camera]", "unknown field `camera`"),
        (
            "[render]\nblend = \"mip\"",
            "unknown variant `mip`, expected one of `front-to-back`",
        ),
        ("[render]\ntable = \"linear\"", "unknown variant `linear`"),
        ("[view]\nazimuth = \"left\"", "expected f64"),
        ("[image]\nsize = [1]", "expected an array of length 2"),
        ("[image]\nbackground = [1, 2]", "expected a colour"),
        ("[image]\nbackground = 7", "expected a colour"),
        ("[[lighting.lights]]\ncolour = \"#ffffff\"", "missing field `direction`"),
        ("[view", "TOML parse error at line 3"),
    ] {
        let text = with(lines).unwrap_err().to_string();
        assert!(
            text.starts_with("s.toml: ") && text.contains(expected),
            "{lines}: {text}"
        );
    }
    assert!(
        scene("[view]")
            .unwrap_err()
            .to_string()
            .contains("`transfer` is missing, expected a table")
    );
    assert!(
        scene("[transfer]")
            .unwrap_err()
            .to_string()
            .contains("missing field `points`")
    );
}

#[test]
fn files_are_read_and_bad_ones_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let read_these = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        read(&path)
    };
    assert_eq!(read_these(MINIMAL.as_bytes()).unwrap(), with("").unwrap());
    assert!(matches!(
        read_these(b"# \xff\n").unwrap_err().fault,
        SceneFault::NotUtf8
    ));
    let mut long = MINIMAL.as_bytes().to_vec();
    long.resize(MAX_LEN as usize, b'\n');
    assert!(read_these(&long).is_ok());
    long.push(b'\n');
    assert!(matches!(read_these(&long).unwrap_err().fault, SceneFault::TooLong));
    assert!(matches!(read(folder.path()).unwrap_err().fault, SceneFault::NotAFile));
    let missing = read(&folder.path().join("none.toml")).unwrap_err();
    assert!(matches!(missing.fault, SceneFault::Io(_)) && missing.to_string().contains("none.toml: cannot read"));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 500,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x51CE_CA57),
        ..ProptestConfig::default()
    })]

    /// Whatever a scene file says, reading ends with a checked scene or an error.
    #[test]
    fn mutated_scenes_never_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), 0x20_u8..0x7f), 1..6)) {
        let mut bytes = BUILT_IN[0].1.as_bytes().to_vec();
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(scene) = scene(str::from_utf8(&bytes).unwrap()) {
            prop_assert!(scene.check().is_ok());
        }
    }
}

/// What is left out follows from what is stated: both faces alike, the volume classified by segments, or surfaces alone.
#[test]
fn modulation_arrives_and_is_refused_where_there_is_none() {
    let modulation = "[modulation]\nopacity = [[0, 0.25], [120.5, 1]]\n";
    let read = with(modulation).unwrap().modulation.unwrap();
    assert_eq!(read.opacity, [[0.0, 0.25], [120.5, 1.0]]);
    assert!(read.diffuse.is_empty() && read.specular.is_empty());
    for (lines, expected) in [
        (
            "[modulation]\nopacity = [[0, 1.5]]",
            "`modulation.opacity[0]` is 1.5, expected a factor from 0 to 1",
        ),
        (
            "[modulation]\nopacity = [[2, 1], [2, 0]]",
            "`modulation.opacity[1]` is 2, expected a magnitude above",
        ),
        (
            "[modulation]\ndiffuse = [[0, 1]]",
            "`modulation` is given, expected [lighting]",
        ),
        ("[modulation]\nambient = [[0, 1]]", "unknown field"),
        (
            "[modulation]\nopacity = [[0, 1]]\n[render]\nblend = \"average\"",
            "`modulation` is given, expected render.blend",
        ),
        (
            "[modulation]\nopacity = [[0, 1]]\n[render]\nclassification = \"integral\"",
            "`modulation` is given, expected render.classification \"point\"",
        ),
    ] {
        let error = with(lines).unwrap_err().to_string();
        assert!(error.contains(expected), "{lines}: {error}");
    }
}

#[test]
fn reflectance_maps_arrive_and_are_refused_where_there_are_none() {
    use crate::reflectance::{Filter, Reflectance};
    let lit = |lines: &str| with(&format!("{lines}\n[lighting]\nambient = 0.5"));
    let bilinear = Reflectance {
        side: 32,
        filter: Filter::Bilinear,
    };
    assert_eq!(lit("[reflectance]\nside = 32").unwrap().reflectance, Some(bilinear));
    let nearest = lit("[reflectance]\nside = 8\nfilter = \"nearest\"").unwrap();
    assert_eq!(nearest.reflectance.map(|map| map.filter), Some(Filter::Nearest));
    for (lines, expected) in [
        (
            "[reflectance]\nside = 1",
            "`reflectance.side` is 1, expected a whole number from 2 to 256",
        ),
        ("[reflectance]\nside = -8", "`reflectance.side` is -8, expected"),
        ("[reflectance]\nfilter = \"nearest\"", "missing field `side`"),
        ("[reflectance]\nside = 8\nfilter = \"cubic\"", "unknown variant `cubic`"),
        (
            "[reflectance]\nside = 8\n[render]\nblend = \"maximum\"",
            "`reflectance` is given, expected render.blend",
        ),
        (
            "[reflectance]\nside = 8\n[modulation]\nopacity = [[0, 1]]",
            "`reflectance` is given, expected no [modulation]",
        ),
        (
            "[reflectance]\nside = 8\n[sampling]\ninterpolation = \"quadratic\"",
            "`reflectance` is given, expected sampling.interpolation",
        ),
        (
            "[reflectance]\nside = 8\n[render]\nclassification = \"integral\"",
            "`reflectance` is given, expected render.classification \"point\"",
        ),
    ] {
        let error = lit(lines).unwrap_err().to_string();
        assert!(error.contains(expected), "{lines}: {error}");
    }
    let unlit = with("[reflectance]\nside = 8").unwrap_err().to_string();
    assert!(unlit.contains("`reflectance` is given, expected [lighting]"), "{unlit}");
}

#[test]
fn splines_arrive_and_are_refused_where_there_are_none() {
    let splines = "[sampling]\ninterpolation = \"quadratic\"\n";
    let read = with(splines).unwrap();
    assert_eq!(read.interpolation, Interpolation::Quadratic);
    for (lines, expected) in [
        (
            "[render]\nblend = \"maximum\"",
            "`sampling.interpolation` is \"quadratic\", expected \"linear\" or \"nearest\" under a projection",
        ),
        (
            "[render]\nclassification = \"integral\"",
            "`render.classification` is \"integral\", expected \"point\" with quadratic interpolation",
        ),
        (
            "[modulation]\nopacity = [[0, 0.25], [120.5, 1]]",
            "`modulation` is given, expected sampling.interpolation \"linear\"",
        ),
    ] {
        let error = with(&format!("{splines}{lines}")).unwrap_err().to_string();
        assert!(error.contains(expected), "{lines}: {error}");
    }
}

#[test]
fn surfaces_are_read_with_their_defaults() {
    let two =
        "[[surface]]\nvalue = -300\ncolour = \"#ff0000\"\nopacity = 0.25\nback_opacity = 0.5\n[[surface]]\nvalue = 9";
    let alone = scene(two).unwrap();
    assert_eq!(alone.classification, Classification::None);
    let red = Face {
        colour: [1.0, 0.0, 0.0],
        opacity: 0.25,
    };
    let first = Surface {
        value: -300.0,
        front: red,
        back: Face { opacity: 0.5, ..red },
    };
    assert_eq!(alone.surfaces, [first, Surface::of(9.0, Face::default())]);
    let with_volume = with(two).unwrap();
    assert_eq!(with_volume.classification, Classification::Integral);
    let point = with(&format!("[render]\nclassification = \"point\"\n{two}"))
        .unwrap_err()
        .to_string();
    assert!(
        point.contains("`render.classification` is \"point\", expected \"integral\" beside surfaces"),
        "{point}"
    );
    for (lines, expected) in [
        ("[render]\nclassification = \"none\"", "expected a [[surface]]"),
        (
            "[[surface]]\nvalue = 1\nopacity = 1.5",
            "`surface[0].opacity` is 1.5, expected a number from 0 to 1",
        ),
        (
            "[[surface]]\nvalue = 1\nback_colour = \"red\"",
            "`surface[0].back_colour` is \"red\", expected \"#rrggbb\"",
        ),
        ("[[surface]]\ncolour = \"#ff0000\"", "missing field `value`"),
        (
            "[[surface]]\nvalue = 1\n[sampling]\ninterpolation = \"nearest\"",
            "no [[surface]], and \"point\" with nearest interpolation",
        ),
        (
            "[[surface]]\nvalue = 1\n[sampling]\ninterpolation = \"quadratic\"",
            "no [[surface]], and \"point\" with quadratic interpolation",
        ),
        (
            "[[surface]]\nvalue = 1\n[render]\nblend = \"maximum\"",
            "under a projection",
        ),
        ("[render]\npieces = 3", "`render.pieces` is 3, expected 1, 2 or 4"),
        ("[render]\npieces = -1", "`render.pieces` is -1, expected 1, 2 or 4"),
    ] {
        let text = with(lines).unwrap_err().to_string();
        assert!(text.contains(expected), "{lines}: {text}");
    }
    let missing = scene("[render]\nclassification = \"integral\"\n[[surface]]\nvalue = 1")
        .unwrap_err()
        .to_string();
    assert!(missing.contains("`transfer` is missing"), "{missing}");
}

/// What is said of a volume of colours, and what has no place beside it.
#[test]
fn scenes_of_colours() {
    let scene = |text: &str| parse(text, "c.toml").map_err(|error| error.to_string());
    let read = scene("[colours]\nalpha_distance = 2.5\ntau_max = 4\nopacity = \"luminance\"\n").unwrap();
    let stated = crate::Colours {
        alpha_distance: Some(2.5),
        tau_max: Some(4.0),
        opacity: Some(crate::ColourOpacity::Luminance),
    };
    assert_eq!((read.colours, read.lighting), (Some(stated), None));
    let constant = scene("[colours]\nopacity = 0.25\n")
        .unwrap()
        .colours
        .and_then(|colours| colours.opacity);
    assert_eq!(constant, Some(crate::ColourOpacity::Constant(0.25)));
    assert_eq!(scene("[colours]\n").unwrap().colours, Some(crate::Colours::default()));
    for (text, words) in [
        (
            "[colours]\nopacity = \"dark\"",
            "`colours.opacity` is \"dark\", expected \"luminance\"",
        ),
        ("[colours]\nopacity = 1.5", "`colours.opacity` is 1.5, expected"),
        (
            "[colours]\nalpha_distance = 0",
            "`colours.alpha_distance` is 0, expected",
        ),
        ("[colours]\ntau_max = 1e9", "`colours.tau_max` is 1000000000, expected"),
        ("[colours]\ncolour = 1", "unknown field `colour`"),
        (
            "[colours]\n[transfer]\npoints = []",
            "`transfer` is given beside [colours]",
        ),
        (
            "[colours]\n[[surface]]\nvalue = 1",
            "`surface` is given, expected nothing beside [colours]",
        ),
        (
            "[colours]\n[render]\ntable = \"sqrt8\"",
            "`render.table` is given, expected nothing beside [colours]",
        ),
        (
            "[colours]\n[render]\nclassification = \"auto\"",
            "`render.classification` is given",
        ),
    ] {
        let error = scene(text).unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
}
