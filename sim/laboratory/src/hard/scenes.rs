//! Small volumes and scenes that several groups use.

use slicecast_compare::{Comparison, ModelPositions, compare};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_scene::{
    Blend, Highlight, Image, Light, Lighting, Point, PrecisionName, Sampling, Scene, TransferFunction, View,
};
use slicecast_volume::{Mapping, Volume};

/// A volume of codes as a function of the voxel.
pub fn volume(dims: [usize; 3], spacing: [f64; 3], code: impl Fn([usize; 3]) -> f64) -> Volume {
    let mut voxels = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                voxels.push(code([x, y, z]).round().clamp(0.0, 4095.0) as u16);
            }
        }
    }
    Volume {
        name: "hard case".into(),
        dims,
        spacing,
        voxels,
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    }
}

/// A white unlit scene from the front: opacities (a voxel) of codes.
pub fn scene(points: &[(f64, f64)]) -> Scene {
    let point = |&(value, opacity): &(f64, f64)| Point {
        value,
        colour: [1.0; 3],
        opacity,
    };
    Scene {
        view: View::default(),
        image: Image::default(),
        sampling: Sampling::default(),
        transfer: TransferFunction {
            unit_distance: 1.0,
            points: points.iter().map(point).collect(),
        },
        lighting: None,
        blend: Blend::FrontToBack,
        precision: PrecisionName::Compact,
        table: None,
        lookup: None,
        interpolation: slicecast_scene::Interpolation::Linear,
        borders: slicecast_scene::Borders::Whole,
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
    }
}

/// Light from the viewer on a matt white material with a highlight of exponent 2^n.
pub fn lit(specular: f64, exponent_log2: u32) -> Option<Lighting> {
    Some(Lighting {
        ambient: 0.1,
        diffuse: 0.9 - specular,
        specular,
        exponent_log2,
        highlight: Highlight::HalfVector,
        lights: vec![Light::default()],
    })
}

/// A scene against the model, at a named precision.
pub fn compared(scene: &Scene, volume: &Volume, precision: PrecisionName) -> Result<Comparison, RenderError> {
    let scene = Scene {
        precision,
        ..scene.clone()
    };
    let prepared = Prepared::new(&scene, volume)?;
    compare(&prepared, ModelPositions::Pipeline, &|_, _| ())
}

/// Waves of 9 x 8 x 7 voxels, askew.
pub fn waves() -> Volume {
    volume([9, 8, 7], [1.0; 3], |[x, y, z]| {
        2000.0 + 2000.0 * (1.3 * x as f64 + 0.7 * y as f64 - 1.9 * z as f64).sin()
    })
}
