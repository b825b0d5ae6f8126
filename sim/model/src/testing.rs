//! What the model's tests share: small volumes and scenes, and a comparison.

use slicecast_scene::{Blend, Image, Lighting, Point, PrecisionName, Sampling, Scene, TransferFunction, View};
use slicecast_volume::{Mapping, Volume};

/// One plane and one ray per voxel.
pub(super) const SAMPLING_ONCE: Sampling = Sampling {
    planes_per_voxel: 1,
    rays_per_voxel: 1,
};

/// A volume of unit spacing and identical mapping from a function of the voxel.
pub(super) fn volume_of(dims: [usize; 3], value: impl Fn(usize, usize, usize) -> usize) -> Volume {
    let mut voxels = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                voxels.push(u16::try_from(value(x, y, z)).expect("a 12-bit code"));
            }
        }
    }
    Volume {
        name: "test".into(),
        dims,
        spacing: [1.0; 3],
        voxels,
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    }
}

/// The angles that look along a direction (roll 0).
pub(super) fn view_along(forward: [f64; 3]) -> View {
    let [x, y, z] = forward;
    View {
        azimuth: (-x).atan2(y).to_degrees(),
        elevation: (-z).atan2(x.hypot(y)).to_degrees(),
        roll: 0.0,
    }
}

/// An unlit scene looking along a direction, with opacity per voxel by points (value, opacity), all white.
pub(super) fn scene_along(forward: [f64; 3], opacities: &[(f64, f64)]) -> Scene {
    let point = |&(value, opacity): &(f64, f64)| Point {
        value,
        colour: [1.0; 3],
        opacity,
    };
    Scene {
        view: view_along(forward),
        image: Image {
            size: None,
            zoom: 1.0,
            background: [0.0; 3],
        },
        sampling: SAMPLING_ONCE,
        transfer: TransferFunction {
            unit_distance: 1.0,
            points: opacities.iter().map(point).collect(),
        },
        lighting: None::<Lighting>,
        blend: Blend::FrontToBack,
        precision: PrecisionName::Wide,
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

/// Fails unless each component is within `tolerance`.
#[track_caller]
pub(super) fn close(got: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for a in 0..3 {
        assert!(
            (got[a] - expected[a]).abs() <= tolerance,
            "got {got:?}, expected {expected:?} within {tolerance:e}"
        );
    }
}
