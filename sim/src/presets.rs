//! Scenes that fit a volume: for CT in Hounsfield units, for everything else by the data's own histogram.
//!
//! | preset         | for                              | shows                                    |
//! |----------------|----------------------------------|------------------------------------------|
//! | headsq         | CT                               | skin as a faint shell, bone              |
//! | ct-bone        | CT                               | bone alone                               |
//! | ct-soft-tissue | CT                               | skin and muscle, opaque                  |
//! | ct-vessels     | CT with contrast                 | vessels and bone                         |
//! | mr             | anything without a unit          | two surfaces where the histogram splits  |
//! | labels         | whole numbers that are names     | every label in a colour of its own       |
//! | fog            | anything                         | everything, thin                         |
//! | mip            | angiograms, anything             | the largest value of each ray, in grey   |

use crate::labels::labels;
use crate::projection;
use slicecast_engine::error::RenderError;
use slicecast_engine::source::Source;
use slicecast_scene::file::{self, SceneError};
use slicecast_scene::{Blend, check};
use slicecast_scene::{Image, Interpolation, Lighting, Point, PrecisionName, Sampling, Scene, TransferFunction, View};
use slicecast_volume::Volume;
use slicecast_volume::meaning::Modality;
use slicecast_volume::open::Loaded;
use slicecast_volume::statistics::Statistics;

/// The names of the presets, those for CT first.
pub const NAMES: [&str; 8] = [
    "headsq",
    "ct-bone",
    "ct-soft-tissue",
    "ct-vessels",
    "mr",
    "labels",
    "fog",
    "mip",
];

/// Whether a scene speaks of Hounsfield units: all that are not fitted to the volume do.
pub fn is_for_hounsfield(name: &str) -> bool {
    file::BUILT_IN.iter().any(|(known, _)| *known == name)
}

/// The most voxels that are sampled by two rays and planes per voxel by default.
const SMALL: usize = 1 << 24;

/// The preset that fits a volume, and why.
pub fn suggest(loaded: &Loaded) -> (&'static str, String) {
    let [low, high] = loaded.report.range;
    match loaded.modality {
        Some(Modality::Ct) => ("headsq", "the file says CT".into()),
        Some(Modality::Mr) => ("mr", "the file says MR".into()),
        _ if looks_hounsfield(loaded) => ("headsq", format!("values {low} to {high} look like Hounsfield units")),
        _ => match &loaded.labels {
            Some(labels) => (
                "labels",
                format!("{} whole values look like labels", labels.entries().len()),
            ),
            None => (
                "mr",
                "values have no known unit: surfaces where the histogram splits".into(),
            ),
        },
    }
}

/// Presets that can be used on a volume, the fitting one first.
pub fn fitting(loaded: &Loaded) -> Vec<&'static str> {
    let (first, _) = suggest(loaded);
    let hounsfield = first == "headsq";
    let fits = |name: &&str| match *name {
        "mr" | "fog" | "mip" => true,
        "labels" => loaded.labels.is_some(),
        _ => hounsfield,
    };
    let others = NAMES.into_iter().filter(|name| *name != first).filter(fits);
    std::iter::once(first).chain(others).collect()
}

/// Air, water and bone of CT.
fn looks_hounsfield(loaded: &Loaded) -> bool {
    let [low, high] = loaded.report.range;
    loaded.integers && (-4096.0..=-500.0).contains(&low) && (300.0..=40000.0).contains(&high)
}

/// Why there is no preset.
#[derive(Debug, thiserror::Error)]
pub enum PresetError {
    /// None of that name, or the volume's values are beyond what scenes may state.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// The voxels cannot be read.
    #[error("{0}")]
    Read(#[from] RenderError),
}

/// A preset, or another built-in scene, for a volume whose voxels come from a source.
///
/// # Errors
/// [`PresetError`].
pub fn scene(name: &str, loaded: &Loaded, statistics: &Statistics, source: &dyn Source) -> Result<Scene, PresetError> {
    let volume = &loaded.volume;
    let transfer = match name {
        "mr" => two_surfaces(volume, statistics),
        "labels" => coloured(loaded, statistics, source)?,
        "fog" => fog(volume, statistics),
        "mip" => projection::ramp(volume, source, Blend::Maximum)?,
        _ => return Ok(thrifty(file::built_in(name)?, volume)),
    };
    let lit = !["fog", "mip"].contains(&name);
    let scene = Scene {
        view: View {
            azimuth: 30.0,
            elevation: if is_slab(volume) { 40.0 } else { 10.0 },
            roll: 0.0,
        },
        image: Image::default(),
        sampling: Sampling {
            planes_per_voxel: 2,
            rays_per_voxel: 2,
        },
        transfer,
        lighting: lit.then(Lighting::default),
        blend: if name == "mip" {
            Blend::Maximum
        } else {
            Blend::FrontToBack
        },
        precision: PrecisionName::Compact,
        table: None,
        lookup: None,
        interpolation: if name == "labels" {
            Interpolation::Nearest
        } else {
            Interpolation::Linear
        },
        borders: slicecast_scene::Borders::default(),
        early_termination: None,
        classification: slicecast_scene::Classification::Point,
        pieces: 1,
        colours: None,
        crop: None,
        clips: Vec::new(),
        cueing: None,
        perspective: None,
        modulation: None,
        reflectance: None,
        surfaces: Vec::new(),
    };
    scene.check().map_err(|error| SceneError {
        name: format!("{}: the scene `{name}`", volume.name),
        fault: error.into(),
    })?;
    Ok(thrifty(scene, volume))
}

/// Whether a volume is much lower than wide: from the front it would show its edge.
fn is_slab(volume: &Volume) -> bool {
    let side = |axis: usize| volume.dims[axis] as f64 * volume.spacing[axis];
    side(2) < 0.6 * side(0).min(side(1))
}

/// One ray per voxel where a volume is large enough to give a picture of a good size.
fn thrifty(mut scene: Scene, volume: &Volume) -> Scene {
    let voxels: usize = volume.dims.iter().product();
    if voxels > SMALL / 8 {
        scene.sampling.rays_per_voxel = 1;
    }
    if voxels > SMALL {
        scene.sampling.planes_per_voxel = 1;
    }
    scene
}

/// The length of a voxel's side, for opacities that are meant a voxel.
fn voxel_length(volume: &Volume) -> f64 {
    let [x, y, z] = volume.spacing;
    let (low, high) = check::UNIT_DISTANCE.into_inner();
    (x * y * z).cbrt().clamp(low, high)
}

/// Points from (code, colour, opacity), in ascending order, of each code the last.
fn points(volume: &Volume, listed: &[(f64, [u8; 3], f64)]) -> TransferFunction {
    let mut points: Vec<Point> = Vec::new();
    let mut before = f64::NEG_INFINITY;
    for &(code, colour, opacity) in listed {
        let code = code.max(before);
        let point = Point {
            value: volume.mapping.value(code),
            colour: colour.map(|c| f64::from(c) / 255.0),
            opacity,
        };
        if code == before {
            points.pop();
        }
        points.push(point);
        before = code;
    }
    TransferFunction {
        unit_distance: voxel_length(volume),
        points,
    }
}

/// A thin shell where the volume parts from its background, and an opaque core where what is left parts again.
fn two_surfaces(volume: &Volume, statistics: &Statistics) -> TransferFunction {
    let [first, last] = statistics.range().map(|code| code as f64);
    let outer = statistics.split(0);
    let inner = statistics.split(outer) as f64;
    let outer = outer as f64;
    let top = (statistics.percentile(0.999) as f64).max(inner);
    let (tan, ivory) = ([214, 158, 128], [242, 232, 208]);
    // From a little below the threshold, where surfaces lie, to the second one. All on codes: the table mixes its entries,
    // and a corner between two of them would be cut off.
    let foot = (outer - 0.25 * (outer - first)).floor();
    let shoulder = (outer + 0.7 * (inner - outer)).floor();
    points(
        volume,
        &[
            (first, tan, 0.0),
            (foot, tan, 0.0),
            (outer, tan, 0.06),
            (shoulder, tan, 0.06),
            (inner, ivory, 0.35),
            (top.min(last), ivory, 0.8),
        ],
    )
}

/// A colour for every label, on an invisible background.
fn coloured(loaded: &Loaded, statistics: &Statistics, source: &dyn Source) -> Result<TransferFunction, RenderError> {
    let labels = labels(loaded, statistics, source)?;
    let [background, _] = statistics.range().map(|code| code as f64);
    // The background fades in the colour of the label next to it.
    let ground = labels.first().map_or([0; 3], |label| label.colour);
    let mut listed = vec![(background, ground, 0.0)];
    listed.extend(labels.iter().map(|label| (f64::from(label.code), label.colour, 0.5)));
    Ok(points(&loaded.volume, &listed))
}

/// Everything above the background, thin enough that about half of the light passes.
fn fog(volume: &Volume, statistics: &Statistics) -> TransferFunction {
    let [first, last] = statistics.range().map(|code| code as f64);
    let outer = statistics.split(0) as f64;
    let side = volume.dims.iter().max().copied().unwrap_or(1) as f64;
    let white = [255; 3];
    points(
        volume,
        &[
            (first, white, 0.0),
            (outer, white, 0.0),
            (last, white, (2.0 / side).min(0.5)),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_volume::decoded::Decoded;
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open;
    use slicecast_volume::values::Values;

    fn loaded(values: Values, modality: Option<Modality>) -> Loaded {
        let decoded = Decoded::new("t".into(), [values.len(), 1, 1], [1.0; 3], values).unwrap();
        open::prepare(&decoded.with_modality(modality), Window::Auto).unwrap()
    }

    fn suggested(values: Values, modality: Option<Modality>) -> &'static str {
        suggest(&loaded(values, modality)).0
    }

    #[test]
    fn values_and_modality_choose_the_preset() {
        assert_eq!(suggested(Values::I16(vec![0, 1, 2]), Some(Modality::Ct)), "headsq");
        assert_eq!(suggested(Values::I16(vec![-1000, 40, 1200]), None), "headsq");
        assert_eq!(suggested(Values::I16(vec![-1000, 40, 1200]), Some(Modality::Mr)), "mr");
        assert_eq!(suggested(Values::U8(vec![0, 0, 0, 0, 3, 7]), None), "labels");
        assert_eq!(suggested(Values::F32(vec![0.0, 0.5, 0.25]), None), "mr");
    }

    /// 98 labels up to 2035 and 98 up to 98,000, in runs of three: each has an opacity of its own.
    #[test]
    fn every_label_of_a_map_of_many_is_visible() {
        for step in [21_u32, 1000] {
            let values = (0..297).map(|index| index / 3 * step).collect();
            let loaded = loaded(Values::U32(values), None);
            assert_eq!(suggest(&loaded).0, "labels", "{step}");
            assert_eq!(fitting(&loaded), ["labels", "mr", "fog", "mip"]);
            let statistics = Statistics::of(&loaded.volume);
            let scene = scene("labels", &loaded, &statistics, &loaded.volume).unwrap();
            let codes = loaded.labels.as_ref().unwrap().entries().iter().map(|label| label.code);
            let opacity = |code| scene.transfer.evaluate(loaded.volume.mapping.value(f64::from(code))).1;
            let opacities: Vec<f64> = codes.map(opacity).collect();
            assert_eq!((opacities.len(), opacities[0]), (99, 0.0));
            assert!(opacities[1..].iter().all(|opacity| *opacity == 0.5), "{opacities:?}");
        }
    }

    #[test]
    fn every_preset_is_a_scene_on_any_volume() {
        for values in [
            Values::U8(vec![0; 3]),
            Values::U8(vec![255; 3]),
            Values::U16(vec![0, 65535, 3]),
            Values::F32(vec![-1e9, 1e9, 0.0]),
            Values::F64(vec![1e-9, 2e-9, 2e-9]),
        ] {
            let loaded = loaded(values, None);
            let statistics = Statistics::of(&loaded.volume);
            for name in NAMES {
                scene(name, &loaded, &statistics, &loaded.volume).unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
    }

    /// Corners between two codes would be cut off by the table.
    #[test]
    fn corners_of_fitted_scenes_are_codes() {
        let loaded = loaded(
            Values::U16((0..4000_u16).map(|i| i % 7 * (i % 83) + i / 9).collect()),
            None,
        );
        let statistics = Statistics::of(&loaded.volume);
        for name in ["mr", "fog", "mip"] {
            let scene = scene(name, &loaded, &statistics, &loaded.volume).unwrap();
            assert!(scene.transfer.points.len() > 1, "{name}");
            for point in scene.transfer.points {
                assert_eq!(point.value.fract(), 0.0, "{name}");
            }
        }
    }

    #[test]
    fn values_beyond_scenes_are_refused_by_name() {
        let mut loaded = loaded(Values::F64(vec![0.0, 0.5]), None);
        loaded.volume.mapping.scale = 1e200;
        let error = scene("mr", &loaded, &Statistics::of(&loaded.volume), &loaded.volume).unwrap_err();
        assert!(
            error.to_string().starts_with("t: the scene `mr`: `transfer.points"),
            "{error}"
        );
    }
}
