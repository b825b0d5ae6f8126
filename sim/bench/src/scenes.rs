//! What is rendered: synthetic fog, in which no sample is invisible and no ray ends, so that nothing can be skipped.

use rayon::prelude::*;

use slicecast_scene::{Blend, Light, Lighting, Point, PrecisionName, Sampling, Scene, TransferFunction, View};
use slicecast_volume::{Mapping, Volume};

/// Sides of a synthetic volume, voxels.
pub const SIDES: std::ops::RangeInclusive<usize> = 16..=1024;

/// Bytes of the voxels of a cube.
pub const fn cube_bytes(side: usize) -> usize {
    2 * side * side * side
}

/// A cube of soft waves along all axes, codes 256 to 3840: every voxel differs from its neighbours, and none is empty.
pub fn cube(side: usize) -> Volume {
    let wave = |place: usize, period: usize| {
        let phase = (place * 4096 / period % 4096) as i32;
        (phase - 2048).abs()
    };
    let mut voxels = vec![0; side * side * side];
    voxels.par_chunks_mut(side * side).enumerate().for_each(|(z, slice)| {
        for (at, voxel) in slice.iter_mut().enumerate() {
            let (x, y) = (at % side, at / side);
            let sum = wave(x + y / 3, 47) + wave(y + z / 2, 61) + wave(z + x / 5, 37);
            *voxel = (256 + sum * 7 / 12) as u16;
        }
    });
    Volume {
        name: format!("fog {side} x {side} x {side}"),
        dims: [side; 3],
        spacing: [1.0; 3],
        voxels,
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    }
}

/// What a scene of fog varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fog {
    /// Lights, 0 to 8.
    pub lights: usize,
    /// Whether the table has many colours.
    pub colourful: bool,
}

/// Fog of a tenth of the light from side to side, seen askew: shears of about 0.31 and -0.22 voxels a plane, one plane
/// and one ray per voxel.
pub fn fog(volume: &Volume, fog: Fog) -> Scene {
    Scene {
        view: View {
            azimuth: 17.0,
            elevation: 12.0,
            roll: 0.0,
        },
        image: slicecast_scene::Image::default(),
        sampling: Sampling {
            planes_per_voxel: 1,
            rays_per_voxel: 1,
        },
        transfer: everything(volume, fog.colourful),
        lighting: (fog.lights > 0).then(|| lights(fog.lights)),
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

/// A transfer function under which every sample is visible and a tenth of the light passes.
pub fn everything(volume: &Volume, colourful: bool) -> TransferFunction {
    let longest = (0..3)
        .map(|a| volume.dims[a] as f64 * volume.spacing[a])
        .fold(1.0, f64::max);
    let [low, high] = [0.0, 4095.0].map(|code| volume.mapping.value(code));
    let thin = (2.3 / longest).min(0.5);
    let point = |place: f64, colour: [f64; 3], opacity: f64| Point {
        value: low + place * (high - low),
        colour: if colourful { colour } else { [1.0; 3] },
        opacity,
    };
    TransferFunction {
        unit_distance: 1.0,
        points: vec![
            point(0.0, [0.2, 0.3, 0.9], 0.5 * thin),
            point(0.4, [0.9, 0.8, 0.3], 0.8 * thin),
            point(0.7, [0.8, 0.3, 0.2], 1.2 * thin),
            point(1.0, [1.0, 1.0, 1.0], 1.5 * thin),
        ],
    }
}

/// White lights around the viewer.
fn lights(count: usize) -> Lighting {
    let light = |index: usize| {
        let turn = index as f64 * std::f64::consts::TAU / 8.0;
        Light {
            direction: [0.6 * turn.cos(), 0.6 * turn.sin(), 0.8],
            colour: [1.0 / count as f64; 3],
            ..Light::default()
        }
    };
    Lighting {
        lights: (0..count).map(light).collect(),
        ..Lighting::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_engine::frame::{Layer, Prepared};
    use slicecast_engine::tile::TILE_ROWS;

    #[test]
    fn fog_hides_nothing_and_ends_no_ray() {
        let volume = cube(24);
        assert!(volume.voxels.iter().all(|v| (256..=3840).contains(v)));
        assert!(volume.voxels.windows(2).filter(|pair| pair[0] == pair[1]).count() < volume.voxels.len() / 10);
        let scene = fog(
            &volume,
            Fog {
                lights: 8,
                colourful: true,
            },
        );
        scene.check().unwrap();
        let prepared = Prepared::new(&scene, &volume).unwrap();
        assert!((0..prepared.table.entries.len()).all(|entry| prepared.table.opacity(entry).to_bits() > 0));
        let frame = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        let least = frame.base.planes[3].iter().min().copied().unwrap();
        assert!(
            (1.0 / 64.0..0.5).contains(&(f64::from(least) / f64::from(frame.base.one))),
            "{least}"
        );
    }
}
