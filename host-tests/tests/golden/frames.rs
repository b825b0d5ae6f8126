//! The named frames of the golden manifest.

use std::sync::Arc;

use slicecast::borders::Borders;
use slicecast::clip::{Clip, Cue};
use slicecast::crop::Crop;
use slicecast::format::{Coefficient, Distance, Intensity, Position, Step, Vector};
use slicecast::modulate::{Factors, Modulation};
use slicecast::perspective::Eye;
use slicecast::shade::{Highlight, Light};
use slicecast::splat::Layout;
use slicecast_engine::camera::Material;
use slicecast_firmware_shared::scene::SURFACES;
use slicecast_host_tests::colours::{ColourFrame, colour_volume};
use slicecast_host_tests::frame::{Frame, Stated, fine_table_of, table_of};
use slicecast_host_tests::random::{Filling, volume};
use slicecast_scene::reflectance::{Filter, Reflectance};
use slicecast_scene::{AlphaCodeName, Blend, LookupName};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

/// The skull opaque, the skin a faint shell: the built-in scene with 16-bit roots in whole numbers. Codes are
/// Hounsfield units + 1024.
fn head_table() -> Frame {
    let head: Volume = load(None, Window::Auto).unwrap().volume;
    Frame::new(
        Arc::new(head),
        table_of(&[
            (274, [230, 176, 140], 0),
            (524, [230, 176, 140], 16_000),
            (774, [230, 176, 140], 0),
            (1124, [242, 232, 208], 0),
            (1324, [242, 232, 208], 46_000),
        ]),
    )
}

/// A unit vector from s1.15; the low bits are there for precisions that keep them.
fn vector(v: [i32; 3]) -> [Vector; 3] {
    v.map(|c| Vector::from_bits((c << 15) - 4_321 * c.signum()))
}

/// A coefficient of this many 1.15 units; the low bits are there for precisions that keep them.
fn coefficient(units: u32) -> Coefficient {
    Coefficient::from_bits((units << 16) + 9_876)
}

/// A white key light and a coloured fill light; unit vectors in s1.15.
fn two_lights(highlight: Highlight, exponent_log2: u32) -> Option<Material> {
    let lights = [
        Light {
            direction: vector([-16_384, -16_384, -23_170]),
            half: vector([-8_867, -8_867, -30_273]),
            diffuse: [coefficient(20_000); 3],
            specular: [coefficient(6_000); 3],
        },
        Light {
            direction: vector([26_214, 0, -19_661]),
            half: vector([14_654, 0, -29_309]),
            diffuse: [2_000, 3_000, 4_000].map(coefficient),
            specular: [500, 1_000, 1_500].map(coefficient),
        },
    ];
    Some(Material {
        ambient: [coefficient(5_000); 3],
        lights: lights.to_vec(),
        viewer: vector([0, 0, -32_768]),
        highlight,
        exponent_log2,
    })
}

/// Nothing of what is flatter than 32 codes over two voxels, all of what is steeper than 512, linear in half octaves between.
fn surfaces_only() -> Factors {
    let bits = |node: usize| (2048 * node.saturating_sub(28)).min(32_768) as u16;
    Factors::new(&std::array::from_fn(|node| Intensity::from_bits(bits(node)))).expect("factors of at most 1")
}

/// An eye at this place of a frame's slices, which sees all that lies within 45 degrees of them.
fn eye(position: [f64; 3]) -> Eye {
    Eye {
        position: position.map(|c| Step::from_bits((c * 4_294_967_296.0) as i64)),
        low: [Vector::from_bits(-(1 << 30)); 2],
        high: [Vector::from_bits(1 << 30); 2],
    }
}

/// A segment of one reference length: log2(e), 27 fraction bits.
const SEGMENT: u32 = 193_635_251;

/// The named frames, in `Compact`.
pub fn frames() -> Vec<(&'static str, Frame)> {
    let head = head_table();
    let lit = |direction: [i64; 3]| Frame {
        direction,
        material: two_lights(Highlight::Reflection, 5),
        ..head.clone()
    };
    let made = |dims, filling| Arc::new(volume(dims, filling, 77));
    let ripples = Frame {
        material: two_lights(Highlight::HalfVector, 8),
        direction: [300, -200, 1000],
        ..Frame::new(
            made([40, 37, 41], Filling::Ripples),
            table_of(&[
                (1500, [255, 80, 0], 0),
                (1900, [255, 240, 20], 52_000),
                (4095, [20, 60, 255], 65_535),
            ]),
        )
    };
    let fog = Frame::new(
        made([9, 8, 130], Filling::Constant(2000)),
        table_of(&[(0, [255, 128, 1], 2_896)]),
    );
    let noise = Frame::new(
        made([31, 33, 29], Filling::Noise),
        table_of(&[
            (0, [0, 255, 9], 0),
            (2900, [200, 3, 90], 9_000),
            (3400, [2, 30, 255], 60_000),
        ]),
    );
    vec![
        ("head-lit", lit([500, 866, -174])),
        (
            "head-unlit",
            Frame {
                direction: [500, 866, -174],
                ..head.clone()
            },
        ),
        (
            "head-unlit-splines",
            Frame {
                direction: [500, 866, -174],
                borders: Borders::Cells,
                splines: true,
                ..head.clone()
            },
        ),
        (
            "head-lit-splines",
            Frame {
                planes_per_voxel: 2,
                splines: true,
                ..lit([-310, 90, 1000])
            },
        ),
        (
            "ripples-lit-splines-back-to-front",
            Frame {
                borders: Borders::Nodes,
                blend: Blend::BackToFront,
                splines: true,
                ..ripples.clone()
            },
        ),
        ("head-lit-from-the-side", lit([-1000, 350, -280])),
        ("head-lit-from-above", lit([0, 0, -1])),
        ("head-lit-from-behind-45", lit([1, -1, 0])),
        (
            "head-mip",
            Frame {
                direction: [-866, 500, 100],
                blend: Blend::Maximum,
                ..head.clone()
            },
        ),
        (
            "head-minip",
            Frame {
                direction: [100, 200, 900],
                blend: Blend::Minimum,
                ..head.clone()
            },
        ),
        (
            "head-modulated",
            Frame {
                modulation: Some(Modulation {
                    opacity: Some(surfaces_only()),
                    diffuse: Some(surfaces_only()),
                    specular: Some(surfaces_only()),
                }),
                ..lit([500, 866, -174])
            },
        ),
        (
            "head-modulated-opacity",
            Frame {
                modulation: Some(Modulation {
                    opacity: Some(surfaces_only()),
                    ..Modulation::default()
                }),
                direction: [-500, 866, 174],
                planes_per_voxel: 2,
                ..head.clone()
            },
        ),
        (
            "noise-cropped-modulated",
            Frame {
                modulation: Some(Modulation {
                    specular: Some(surfaces_only()),
                    ..Modulation::default()
                }),
                material: two_lights(Highlight::HalfVector, 4),
                blend: Blend::BackToFront,
                direction: [300, -200, 1000],
                ..cropped(noise.clone(), [[2.0, -9.0, 7.5], [20.625, 20.0, 99.0]])
            },
        ),
        (
            "head-mapped",
            Frame {
                reflectance: Some(Reflectance {
                    side: 32,
                    filter: Filter::Bilinear,
                }),
                ..lit([500, 866, -174])
            },
        ),
        (
            "noise-mapped-nearest",
            Frame {
                reflectance: Some(Reflectance {
                    side: 17,
                    filter: Filter::Nearest,
                }),
                material: two_lights(Highlight::HalfVector, 4),
                blend: Blend::BackToFront,
                direction: [300, -200, 1000],
                ..noise.clone()
            },
        ),
        (
            "head-perspective",
            Frame {
                eye: Some(eye([31.25, 40.5, -60.0])),
                planes_per_voxel: 2,
                ..lit([0, 0, -1])
            },
        ),
        (
            "head-perspective-within",
            Frame {
                eye: Some(eye([31.25, 30.0, 40.125])),
                rays_per_voxel: 2,
                blend: Blend::BackToFront,
                ..lit([0, 1000, 0])
            },
        ),
        (
            "head-perspective-unlit",
            Frame {
                eye: Some(eye([-20.0, 30.0, 10.75])),
                ..head.clone()
            },
        ),
        (
            "head-perspective-mip",
            Frame {
                eye: Some(eye([31.25, 40.5, -60.0])),
                rays_per_voxel: 2,
                blend: Blend::Maximum,
                direction: [0, 0, -1],
                ..head.clone()
            },
        ),
        (
            "head-perspective-minip",
            Frame {
                eye: Some(eye([-20.0, 30.0, 10.75])),
                blend: Blend::Minimum,
                ..head.clone()
            },
        ),
        (
            "head-perspective-average",
            Frame {
                eye: Some(eye([31.25, 30.0, 40.125])),
                blend: Blend::Average,
                direction: [0, 1000, 0],
                ..head.clone()
            },
        ),
        (
            "head-perspective-additive",
            Frame {
                eye: Some(eye([31.25, 40.5, -60.0])),
                planes_per_voxel: 2,
                blend: Blend::Additive,
                direction: [0, 0, -1],
                ..head.clone()
            },
        ),
        (
            "head-average",
            Frame {
                direction: [-866, 500, 100],
                blend: Blend::Average,
                ..head.clone()
            },
        ),
        (
            "head-additive",
            Frame {
                direction: [100, 200, 900],
                blend: Blend::Additive,
                ..head.clone()
            },
        ),
        (
            "head-cropped-additive",
            Frame {
                blend: Blend::Additive,
                rays_per_voxel: 2,
                direction: [500, 866, -174],
                ..cropped(head.clone(), [[5.25, 11.0, 3.5], [40.75, 33.0, 60.0]])
            },
        ),
        (
            "head-back-to-front",
            Frame {
                blend: Blend::BackToFront,
                ..lit([500, 866, -174])
            },
        ),
        (
            "head-phases",
            Frame {
                rays_per_voxel: 2,
                ..lit([300, 500, 1000])
            },
        ),
        (
            "head-fine-planes",
            Frame {
                planes_per_voxel: 4,
                ..lit([-20, 1000, 310])
            },
        ),
        (
            "head-flat-voxels",
            Frame {
                factors: [32_768, 21_845, 10_923],
                ..lit([500, 866, -174])
            },
        ),
        (
            "head-cells",
            Frame {
                borders: Borders::Cells,
                rays_per_voxel: 2,
                ..lit([500, 866, -174])
            },
        ),
        (
            "head-cropped",
            Frame {
                rays_per_voxel: 2,
                ..cropped(lit([500, 866, -174]), [[5.25, 11.0, 3.5], [40.75, 33.0, 60.0]])
            },
        ),
        (
            "noise-cropped-maximum",
            Frame {
                blend: Blend::Maximum,
                direction: [300, -200, 1000],
                ..cropped(noise.clone(), [[2.0, -9.0, 7.5], [2.625, 20.0, 99.0]])
            },
        ),
        (
            "head-cropped-segments",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                planes_per_voxel: 3,
                blend: Blend::BackToFront,
                direction: [-500, -866, 174],
                ..cropped(head.clone(), [[10.0, 8.125, 20.0], [50.0, 60.5, 80.3]])
            },
        ),
        (
            "head-cropped-surfaces",
            Frame {
                segments: Some(Stated {
                    surfaces: SURFACES.to_vec(),
                    ..Stated::whole(SEGMENT)
                }),
                ..cropped(lit([300, 500, 1000]), [[12.0, 30.3, 15.5], [99.0, 99.0, 70.0]])
            },
        ),
        (
            "head-clipped",
            Frame {
                clips: vec![clip([0.5, 1.0, -0.3], -21.3, None, 0.0, false)],
                borders: Borders::Cells,
                rays_per_voxel: 2,
                ..lit([500, 866, -174])
            },
        ),
        (
            "head-cued",
            Frame {
                cue: Some(cue([0.2, 0.5, 0.1], -11.0, 40.0)),
                clips: vec![clip([1.0, 0.0, -0.3], -5.5, None, 3.0, false)],
                borders: Borders::Cells,
                ..lit([500, 866, -174])
            },
        ),
        (
            "ripples-cued-back-to-front",
            Frame {
                cue: Some(cue([0.0, 0.3, 0.6], 2.0, 9.0)),
                blend: Blend::BackToFront,
                planes_per_voxel: 2,
                ..ripples.clone()
            },
        ),
        (
            "noise-clipped-maximum",
            Frame {
                blend: Blend::Maximum,
                direction: [300, -200, 1000],
                clips: vec![clip([1.0, 0.2, 0.4], -9.0, Some(2.5), 0.0, false)],
                ..noise.clone()
            },
        ),
        (
            "head-clipped-soft-segments",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                planes_per_voxel: 3,
                blend: Blend::BackToFront,
                direction: [-500, -866, 174],
                borders: Borders::Nodes,
                clips: vec![
                    clip([0.3, -0.9, 0.1], 19.7, None, 9.5, false),
                    clip([0.0, 0.0, 1.0], -40.0, Some(6.25), 0.0, true),
                ],
                ..head.clone()
            },
        ),
        (
            "head-clipped-surfaces",
            Frame {
                segments: Some(Stated {
                    surfaces: SURFACES.to_vec(),
                    ..Stated::whole(SEGMENT)
                }),
                clips: vec![
                    clip([1.0, 0.0, 0.0], -30.5, None, 0.0, false),
                    clip([0.2, 0.7, 0.6], -50.0, Some(30.0), 12.0, true),
                ],
                borders: Borders::Cells,
                ..lit([300, 500, 1000])
            },
        ),
        (
            "ripples-nodes",
            Frame {
                borders: Borders::Nodes,
                planes_per_voxel: 3,
                ..ripples.clone()
            },
        ),
        (
            "noise-cells-maximum",
            Frame {
                borders: Borders::Cells,
                blend: Blend::Maximum,
                direction: [300, -200, 1000],
                ..noise.clone()
            },
        ),
        (
            "head-early-termination",
            Frame {
                early_termination: Some(7),
                ..lit([500, 866, -174])
            },
        ),
        ("ripples-half-vector", ripples.clone()),
        (
            "ripples-segments",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                ..ripples.clone()
            },
        ),
        (
            "head-segments",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                direction: [500, 866, -174],
                ..head.clone()
            },
        ),
        (
            "head-segments-back-to-front",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                planes_per_voxel: 2,
                blend: Blend::BackToFront,
                ..lit([300, 500, 1000])
            },
        ),
        (
            "ripples-segments-cells",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                borders: Borders::Cells,
                rays_per_voxel: 2,
                ..ripples.clone()
            },
        ),
        (
            "head-segments-nodes",
            Frame {
                segments: Some(Stated::whole(SEGMENT)),
                borders: Borders::Nodes,
                planes_per_voxel: 2,
                blend: Blend::BackToFront,
                direction: [500, 866, -174],
                ..head.clone()
            },
        ),
        (
            "head-surfaces-cells",
            Frame {
                segments: Some(Stated {
                    surfaces: SURFACES.to_vec(),
                    pieces: 2,
                    ..Stated::whole(SEGMENT)
                }),
                borders: Borders::Cells,
                ..lit([300, 500, 1000])
            },
        ),
        (
            "head-surfaces",
            Frame {
                segments: Some(Stated {
                    alone: true,
                    surfaces: SURFACES.to_vec(),
                    ..Stated::whole(SEGMENT)
                }),
                ..lit([500, 866, -174])
            },
        ),
        (
            "head-surfaces-in-volume",
            Frame {
                segments: Some(Stated {
                    surfaces: SURFACES.to_vec(),
                    ..Stated::whole(SEGMENT)
                }),
                rays_per_voxel: 2,
                ..lit([300, 500, 1000])
            },
        ),
        (
            "ripples-surfaces-back-to-front",
            Frame {
                segments: Some(Stated {
                    surfaces: SURFACES.to_vec(),
                    pieces: 4,
                    ..Stated::whole(SEGMENT)
                }),
                blend: Blend::BackToFront,
                ..ripples.clone()
            },
        ),
        (
            "noise-pieces",
            Frame {
                segments: Some(Stated {
                    pieces: 4,
                    ..Stated::whole(SEGMENT)
                }),
                ..noise.clone()
            },
        ),
        (
            "ripples-fine-colours",
            Frame {
                code: Some(AlphaCodeName::Colour16),
                table: fine_table_of(&[
                    (1500, [65_535, 20_500, 77], 0),
                    (1900, [65_001, 61_777, 5_201], 52_000),
                    (4095, [5_003, 15_432, 65_533], 65_535),
                ]),
                ..ripples.clone()
            },
        ),
        (
            "ripples-other-table",
            Frame {
                code: Some(AlphaCodeName::Sqrt8),
                lookup: Some(LookupName::Linear),
                ..ripples
            },
        ),
        ("fog", fog.clone()),
        (
            "fog-16-planes",
            Frame {
                planes_per_voxel: 16,
                ..fog
            },
        ),
        (
            "noise-tie",
            Frame {
                direction: [-1, 1, -1],
                rays_per_voxel: 3,
                ..noise.clone()
            },
        ),
        (
            "noise-lit",
            Frame {
                direction: [7, 3, -5],
                material: two_lights(Highlight::Reflection, 0),
                ..noise
            },
        ),
    ]
}

/// A box in voxels along x, y and z, its low faces and its high ones.
fn crop_of(faces: [[f64; 3]; 2]) -> Option<Crop> {
    let [low, high] = faces.map(|face| face.map(|at| Position::from_bits((at * 65536.0) as i32)));
    Some(Crop { low, high })
}

/// A clip plane with these slopes, of this distance from the first voxel, in voxels.
fn clip(slope: [f64; 3], distance: f64, thickness: Option<f64>, falloff: f64, outside: bool) -> Clip {
    let length = |length: f64| Distance::from_num(length);
    Clip {
        slope: slope.map(Vector::from_num),
        distance: length(distance),
        thickness: thickness.map(length),
        falloff: length(falloff),
        outside,
    }
}

/// Depth cueing with these slopes and this depth of the first voxel, in voxels.
fn cue(slope: [f64; 3], distance: f64, depth: f64) -> Cue {
    Cue {
        slope: slope.map(Vector::from_num),
        distance: Distance::from_num(distance),
        depth: Distance::from_num(depth),
        most: 60_000,
        colour: [1000, 8000, 30_000].map(Intensity::from_bits),
    }
}

/// A frame of cells, cropped.
fn cropped(frame: Frame, faces: [[f64; 3]; 2]) -> Frame {
    Frame {
        borders: Borders::Cells,
        crop: crop_of(faces),
        ..frame
    }
}

/// The named frames of colour and extinction.
pub fn colour_frames() -> Vec<(&'static str, ColourFrame)> {
    let ball = ColourFrame {
        direction: [300, -200, 1000],
        ..ColourFrame::new(colour_volume([40, 37, 41], Filling::Ball, 77, Some(5)))
    };
    let noise = ColourFrame::new(colour_volume([31, 33, 29], Filling::Sparse, 77, Some(6)));
    vec![
        ("colours-ball", ball.clone()),
        (
            "colours-ball-cells",
            ColourFrame {
                borders: Borders::Cells,
                planes_per_voxel: 2,
                early_termination: Some(8),
                ..ball.clone()
            },
        ),
        (
            "colours-ball-cropped",
            ColourFrame {
                borders: Borders::Cells,
                crop: crop_of([[3.0, 9.5, 20.5], [30.25, 28.0, 21.0]]),
                ..ball.clone()
            },
        ),
        (
            "colours-ball-clipped",
            ColourFrame {
                borders: Borders::Cells,
                clips: vec![
                    clip([0.6, 0.8, 0.1], -25.0, None, 0.0, false),
                    clip([0.0, -0.2, 1.0], -11.0, Some(4.0), 3.0, true),
                ],
                ..ball.clone()
            },
        ),
        (
            "colours-ball-lit",
            ColourFrame {
                planes_per_voxel: 2,
                borders: Borders::Nodes,
                material: two_lights(Highlight::Reflection, 4),
                ..ball.clone()
            },
        ),
        (
            "colours-ball-cued",
            ColourFrame {
                borders: Borders::Cells,
                cue: Some(cue([0.1, -0.2, 0.9], -9.5, 22.0)),
                clips: vec![clip([0.6, 0.8, 0.1], -25.0, None, 0.0, false)],
                material: two_lights(Highlight::HalfVector, 6),
                ..ball.clone()
            },
        ),
        (
            "colours-noise-tie",
            ColourFrame {
                direction: [-1, 1, -1],
                rays_per_voxel: 2,
                ..noise.clone()
            },
        ),
        (
            "colours-ball-quadratic",
            ColourFrame {
                borders: Borders::Cells,
                quadratic: true,
                ..ball
            },
        ),
        (
            "colours-noise-quadratic",
            ColourFrame {
                direction: [-310, 90, 1000],
                rays_per_voxel: 2,
                quadratic: true,
                material: two_lights(Highlight::Reflection, 5),
                ..noise.clone()
            },
        ),
        (
            "colours-noise-lit",
            ColourFrame {
                direction: [90, -1000, 410],
                material: two_lights(Highlight::HalfVector, 8),
                early_termination: Some(10),
                ..noise.clone()
            },
        ),
        (
            "colours-thin",
            ColourFrame {
                direction: [1000, 20, -310],
                medium: [1_400_000_000, 24],
                ..noise
            },
        ),
    ]
}

/// A frame whose voxels are splatted, by steps along x, y and z of the image, s31.32.
pub struct Splat {
    pub frame: Frame,
    pub steps: [[i64; 3]; 3],
    pub size: [u32; 2],
    pub layout: Layout,
    pub spacing: [u16; 3],
}

/// The named frames that are splatted, in `Compact`. Lights are those of the image's frame.
pub fn splats() -> Vec<(&'static str, Splat)> {
    let head = head_table();
    let noise = Frame::new(
        Arc::new(volume([31, 33, 29], Filling::Noise, 77)),
        table_of(&[
            (0, [0, 255, 9], 0),
            (2100, [200, 3, 90], 9_000),
            (2600, [2, 30, 255], 60_000),
        ]),
    );
    let third = (1i64 << 32) / 3;
    let turned = [
        [2 * third, 2 * third, -third],
        [-third, 2 * third, 2 * third],
        [2 * third, -third, 2 * third],
    ];
    let whole = 1i64 << 32;
    vec![
        (
            "splat-head-lit",
            Splat {
                frame: Frame {
                    material: two_lights(Highlight::Reflection, 5),
                    ..head.clone()
                },
                steps: turned,
                size: [108, 105],
                layout: Layout::FINE,
                spacing: [32768; 3],
            },
        ),
        (
            "splat-head-paper",
            Splat {
                frame: head,
                steps: turned.map(|[x, y, z]| [x, y, 2 * z]),
                size: [97, 111],
                layout: Layout::PAPER,
                spacing: [32768; 3],
            },
        ),
        (
            "splat-noise-along-an-axis",
            Splat {
                frame: Frame {
                    material: two_lights(Highlight::HalfVector, 4),
                    early_termination: Some(8),
                    ..noise
                },
                steps: [[0, 0, -whole], [2 * whole, 0, 0], [0, 3 * whole, 0]],
                size: [67, 91],
                layout: Layout::new(12, 6, 12).expect("64 bits"),
                spacing: [32768, 32768, 16384],
            },
        ),
    ]
}

/// A frame whose voxels are splatted from an eye: the place of the first voxel and steps, sheets along x, y and z of the image, s31.32; the
/// distance of the image, 16.16.
pub struct SplatFromEye {
    pub frame: Frame,
    pub first: [i64; 3],
    pub steps: [[i64; 3]; 3],
    pub distance: u32,
    pub size: [u32; 2],
    pub layout: Layout,
}

/// The named frames that are splatted from an eye. Lights are those of the image's frame.
pub fn splats_from_eye() -> Vec<(&'static str, SplatFromEye)> {
    let head = Frame {
        material: two_lights(Highlight::Reflection, 5),
        ..head_table()
    };
    let noise = Frame::new(
        Arc::new(volume([31, 33, 29], Filling::Noise, 78)),
        table_of(&[
            (0, [0, 255, 9], 0),
            (2100, [200, 3, 90], 9_000),
            (2600, [2, 30, 255], 60_000),
        ]),
    );
    let whole = 1i64 << 32;
    let third = whole / 3;
    let turned = [
        [2 * third, 2 * third, -third],
        [-third, 2 * third, 2 * third],
        [2 * third, -third, 2 * third],
    ];
    let axes = [[whole, 0, 0], [0, 0, 2 * whole], [0, -whole, 0]];
    vec![
        (
            "splat-head-eye-outside",
            SplatFromEye {
                frame: head.clone(),
                first: [-30 * whole - 7, -31 * whole, 60 * whole + third],
                steps: turned,
                distance: 130 << 16,
                size: [100, 96],
                layout: Layout::FINE,
            },
        ),
        (
            "splat-head-eye-within",
            SplatFromEye {
                frame: head,
                first: [-36 * whole, -30 * whole, -28 * whole],
                steps: turned,
                distance: (40 << 16) + 777,
                size: [91, 97],
                layout: Layout::PAPER,
            },
        ),
        (
            "splat-noise-eye-near-two-sheets",
            SplatFromEye {
                frame: Frame {
                    material: two_lights(Highlight::HalfVector, 4),
                    early_termination: Some(8),
                    ..noise
                },
                first: [-15 * whole, 14 * whole, 3 * whole],
                steps: axes,
                distance: 77 << 16,
                size: [85, 67],
                layout: Layout::new(12, 6, 12).expect("64 bits"),
            },
        ),
    ]
}
