//! Random frames, with everything odd about them that a volume, a view or a table can have.

use std::sync::Arc;

use proptest::prelude::*;
use slicecast::borders::Borders;
use slicecast::clip::{Clip, Cue};
use slicecast::crop::Crop;
use slicecast::format::{Coefficient, Distance, Intensity, Opacity, Position, Step, Vector};
use slicecast::modulate::{Factors, Modulation, NODES};
use slicecast::perspective::{Eye, EyeError, SLOPE_MAX};
use slicecast::plan::PlanError;
use slicecast::shade::{Highlight, Light};
use slicecast::surface::{Face, Surface, VALUE_MAX};
use slicecast_engine::camera::Material;
use slicecast_engine::error::CameraError;
use slicecast_host_tests::frame::{Frame, Stated, fine_table_of};
use slicecast_host_tests::random::{Filling, Random, volume};
use slicecast_scene::reflectance::{Filter, Reflectance};
use slicecast_scene::{AlphaCodeName, Blend, LookupName, PrecisionName};

/// Vectors of length 1 in s1.15 (to 1e-5), and their opposites.
const UNITS: [[i32; 3]; 6] = [
    [0, 0, -32768],
    [19661, 0, -26214],
    [0, -26214, -19661],
    [-18919, 18919, -18918],
    [32768, 0, 0],
    [10923, 21845, 21845],
];

/// Lights by number: up to three of [`UNITS`], each a colour of its own. Low bits are filled, for precisions that keep
/// them.
pub fn light(exponent_log2: u32, seed: u64) -> Material {
    let mut random = Random::new(seed);
    let mut unit = || {
        let low = random.below(9000) as i32;
        UNITS[random.below(6) as usize].map(|c| Vector::from_bits((c << 15) - low * c.signum()))
    };
    let viewer = unit();
    let count = 1 + seed % 3;
    let lights: Vec<Light> = (0..count)
        .map(|n| Light {
            direction: unit(),
            half: unit(),
            diffuse: [9000, 7000 - 900 * n as u32, 5000].map(coefficient),
            specular: [2000, 3000, 4000 + 100 * n as u32].map(coefficient),
        })
        .collect();
    let highlight = if seed & 4 == 0 {
        Highlight::Reflection
    } else {
        Highlight::HalfVector
    };
    Material {
        ambient: [1000, 2000, 3000].map(coefficient),
        lights,
        viewer,
        highlight,
        exponent_log2,
    }
}

/// A coefficient of this many 1.15 units and some more bits.
fn coefficient(units: u32) -> Coefficient {
    Coefficient::from_bits((units << 16) + 12_345)
}

fn dims() -> impl Strategy<Value = [usize; 3]> {
    let side = || prop_oneof![1 => Just(1usize), 1 => Just(2), 4 => 1usize..=7];
    [side(), side(), side()]
}

fn filling() -> impl Strategy<Value = Filling> {
    prop_oneof![
        1 => (0u16..=4095).prop_map(Filling::Constant),
        3 => Just(Filling::Noise),
        2 => Just(Filling::Extremes),
        3 => Just(Filling::Sparse),
        1 => Just(Filling::Linear),
        1 => Just(Filling::Ball),
        1 => Just(Filling::Ripples),
    ]
}

/// Directions: small whole numbers (axes, 45 degrees, whole-voxel shears) or anything.
fn direction() -> impl Strategy<Value = [i64; 3]> {
    let small = prop::array::uniform3(-3i64..=3);
    let any = prop::array::uniform3(-(1i64 << 30)..=1 << 30);
    prop_oneof![small, any].prop_filter("a direction", |d| *d != [0; 3])
}

/// Tables: nothing visible, everything, a band of codes, ramps, or every entry on its own.
fn points() -> impl Strategy<Value = Vec<(u16, [u16; 3], u16)>> {
    let colour = || any::<[u16; 3]>();
    let root = || prop_oneof![0u16..=65535, 0u16..=600, Just(65535u16)];
    let ramp = prop::collection::vec((0u16..=4095, colour(), root()), 1..6);
    let band = (0u16..=4095, 1u16..=300, colour(), root()).prop_map(|(low, width, c, r)| {
        let high = (low + width).min(4095);
        vec![(low, c, 0), (low, c, r), (high, c, r), (high, c, 0)]
    });
    prop_oneof![
        1 => Just(vec![(0, [65535; 3], 0)]),
        1 => root().prop_map(|r| vec![(0, [65535; 3], r)]),
        4 => band,
        4 => ramp.prop_map(|mut points| {
            points.sort_by_key(|p| p.0);
            points
        }),
    ]
}

pub fn material() -> impl Strategy<Value = Option<Material>> {
    prop_oneof![
        1 => Just(None),
        2 => (0u32..=8, any::<u64>()).prop_map(|(exponent, seed)| Some(light(exponent, seed))),
    ]
}

/// Segments: some whole, some cut at surfaces whose values and faces have everything odd about them, some into pieces.
fn segments() -> impl Strategy<Value = Stated> {
    let opacity = || prop_oneof![1 => Just(0u32), 1 => Just(1u32 << 31), 3 => 0u32..=1 << 31];
    let face = move || {
        (opacity(), prop::array::uniform3(0u32..=1 << 31)).prop_map(|(opacity, colour)| Face {
            colour,
            opacity: Opacity::from_bits(opacity),
        })
    };
    let value = prop_oneof![
        4 => 0..=VALUE_MAX,
        2 => (0u32..=4096).prop_map(|code| code << 16),
        1 => prop_oneof![Just(0), Just(4095 << 16), Just(VALUE_MAX)],
    ];
    let surface = (value, face(), face()).prop_map(|(value, front, back)| Surface { value, front, back });
    let surfaces = prop_oneof![
        1 => Just(Vec::new()),
        3 => prop::collection::vec(surface.clone(), 1..5),
        1 => prop::collection::vec(surface, 20..60),
    ];
    let scaled = prop_oneof![1u32.., 1u32 << 22..1 << 28];
    let pieces = prop_oneof![2 => Just(1u32), 1 => Just(2), 1 => Just(4)];
    let alone = prop_oneof![3 => Just(false), 1 => Just(true)];
    (scaled, alone, surfaces, pieces).prop_map(|(scaled, alone, mut surfaces, pieces)| {
        surfaces.sort_by_key(|surface| surface.value);
        Stated {
            scaled,
            alone,
            surfaces,
            pieces,
        }
    })
}

fn factor() -> impl Strategy<Value = u16> {
    prop_oneof![2 => Just(32768u16), 1 => 1u16..=32768]
}

fn blend() -> impl Strategy<Value = Blend> {
    prop_oneof![
        8 => Just(Blend::FrontToBack),
        4 => Just(Blend::BackToFront),
        1 => Just(Blend::Maximum),
        1 => Just(Blend::Minimum),
        1 => Just(Blend::Average),
        1 => Just(Blend::Additive),
    ]
}

/// Borders that a volume can have: there is nothing between the first and the last of one voxel.
pub fn borders_of(borders: Borders, dims: [usize; 3]) -> Borders {
    match borders {
        Borders::Nodes if dims.contains(&1) => Borders::Cells,
        borders => borders,
    }
}

/// A box that holds something of most small volumes: faces at voxels, halves and anywhere, thin boxes, open ends.
fn box_of(seed: u64) -> Crop {
    let mut random = Random::new(seed);
    let mut pick = |low: i32, high: i32| low + random.below((high - low + 1) as u32) as i32;
    let axes = [(); 3].map(|()| {
        let low = match pick(0, 2) {
            0 => i32::MIN,
            1 => pick(-2, 12) << 15,
            _ => pick(-40_000, 500_000),
        };
        let side = match pick(0, 5) {
            0 => pick(1, 60_000),
            1..=3 => pick(60_000, 700_000),
            _ => i32::MAX,
        };
        [low, low.max(-40_000).saturating_add(side)].map(Position::from_bits)
    });
    Crop {
        low: axes.map(|[low, _]| low),
        high: axes.map(|[_, high]| high),
    }
}

/// Clip planes that meet most volumes of these sides: along the voxels or askew, through voxels or anywhere, half spaces, slabs
/// thinner than a step, hard and soft, either side.
pub fn clips_of(seed: u64, dims: [usize; 3]) -> Vec<Clip> {
    let mut random = Random::new(seed);
    let mut pick = |low: i64, high: i64| low + i64::from(random.below((high - low + 1) as u32));
    let one = 1i64 << 30;
    let count = pick(1, 3);
    (0..count)
        .map(|_| {
            let slope = match pick(0, 3) {
                0 => {
                    let axis = pick(0, 2) as usize;
                    let sign = 2 * pick(0, 1) - 1;
                    [0, 1, 2].map(|a| if a == axis { sign * one } else { 0 })
                }
                1 => [(); 3].map(|()| pick(-2, 2) * one / 4),
                _ => [(); 3].map(|()| pick(-one, one)),
            };
            let slope = if slope == [0; 3] { [0, 0, one] } else { slope };
            // Through a place in the volume, at a voxel, between two, or anywhere.
            let place = dims.map(|side| {
                let side = side as i64;
                match pick(0, 2) {
                    0 => pick(0, side) * one,
                    1 => (2 * pick(0, side) - 1) * one / 2,
                    _ => pick(-1, side) * one + pick(0, one - 1),
                }
            });
            let distance: i64 = (slope.iter().zip(place))
                .map(|(slope, place)| ((i128::from(*slope) * i128::from(place)) >> 30) as i64)
                .sum();
            let mut length = || match pick(0, 2) {
                0 => 0,
                1 => pick(1, one / 2),
                _ => pick(one / 2, 8 * one),
            };
            let (thickness, falloff) = (length(), length());
            Clip {
                slope: slope.map(|slope| Vector::from_bits(slope as i32)),
                distance: Distance::from_bits(-distance),
                thickness: (thickness > 0).then(|| Distance::from_bits(thickness)),
                falloff: Distance::from_bits(falloff),
                outside: pick(0, 2) == 0,
            }
        })
        .collect()
}

/// Depth cueing that turns something of most volumes.
pub fn cue_of(seed: u64) -> Cue {
    let mut random = Random::new(seed);
    let mut pick = |low: i64, high: i64| low + i64::from(random.below((high - low + 1) as u32));
    let one = 1i64 << 30;
    Cue {
        slope: [(); 3].map(|()| Vector::from_bits(pick(-one, one) as i32)),
        distance: Distance::from_bits(pick(-4 * one / 2, one) + pick(0, one)),
        depth: Distance::from_bits(pick(1, 3 * one)),
        most: pick(0, 65536) as u32,
        colour: [(); 3].map(|()| Intensity::from_bits(pick(0, 32768) as u16)),
    }
}

/// Modulation of some of opacity, diffuse and specular light: by nothing, by all, by a step, or by any factors.
pub fn modulation_of(seed: u64) -> Modulation {
    let mut random = Random::new(seed);
    let mut factors = || {
        let kind = random.below(6);
        let at = random.below(NODES as u32);
        let nodes = std::array::from_fn(|node| {
            let beyond = 32768 * u16::from(node as u32 >= at);
            Intensity::from_bits(match kind {
                0 => 0,
                1 => 32768,
                2 => beyond,
                3 => 32768 - beyond,
                _ => random.below(32769) as u16,
            })
        });
        (kind < 5).then(|| Factors::new(&nodes).expect("factors of at most 1"))
    };
    Modulation {
        opacity: factors(),
        diffuse: factors(),
        specular: factors(),
    }
}

/// A reflectance map of a few nodes.
pub fn reflectance_of(seed: u64) -> Reflectance {
    let mut random = Random::new(seed);
    Reflectance {
        side: 2 + random.below(20),
        filter: [Filter::Nearest, Filter::Bilinear][random.below(2) as usize],
    }
}

/// Any of these boxes.
pub fn crop() -> impl Strategy<Value = Crop> {
    any::<u64>().prop_map(box_of)
}

/// The frame without its box where that holds nothing of the volume, or where the borders cut no step.
pub fn cropped(frame: Frame) -> Frame {
    match frame.plan() {
        Err(CameraError::Plan(PlanError::Beside { .. } | PlanError::WholeCropped)) => Frame { crop: None, ..frame },
        _ => frame,
    }
}

/// The frame by splines, of which there are composited samples alone.
pub fn splined(frame: Frame) -> Frame {
    Frame {
        splines: true,
        blend: match frame.blend {
            Blend::BackToFront => Blend::BackToFront,
            _ => Blend::FrontToBack,
        },
        segments: None,
        modulation: None,
        reflectance: None,
        ..frame
    }
}

/// Frames of more than one block a row, most of which are empty: along the rows, across them, and between slices.
pub fn wide_frame() -> impl Strategy<Value = Frame> {
    let long = 17usize..=100;
    let dims = prop_oneof![
        4 => (long.clone(), 1usize..=12, 1usize..=12).prop_map(|(x, y, z)| [x, y, z]),
        1 => (1usize..=12, long.clone(), 1usize..=12).prop_map(|(x, y, z)| [x, y, z]),
        1 => (1usize..=12, 1usize..=12, long).prop_map(|(x, y, z)| [x, y, z]),
        1 => (1030usize..=1100, 1usize..=3, 2usize..=4).prop_map(|(x, y, z)| [x, y, z]),
    ];
    let filling = prop_oneof![
        9 => Just(Filling::Boxes),
        1 => Just(Filling::Sparse),
        1 => Just(Filling::Ball),
        1 => Just(Filling::Ripples),
    ];
    (frame(), dims, filling, any::<u64>()).prop_map(|(frame, dims, filling, seed)| Frame {
        volume: Arc::new(volume(dims, filling, seed)),
        borders: borders_of(frame.borders, dims),
        // Small frames have more planes: here a frame of thousands takes as long as all others together.
        planes_per_voxel: frame
            .planes_per_voxel
            .min(if dims.iter().any(|side| *side > 100) { 2 } else { 4 }),
        // Boxes leave few rows of several blocks: they have a test of their own.
        crop: None,
        ..frame
    })
}

/// Any small frame, in `Compact`: the tests go through the precisions themselves.
pub fn frame() -> impl Strategy<Value = Frame> {
    let borders = prop_oneof![2 => Just(Borders::Whole), 1 => Just(Borders::Cells), 1 => Just(Borders::Nodes)];
    let shape = (
        dims(),
        filling(),
        any::<u64>(),
        direction(),
        prop::array::uniform3(factor()),
        borders,
    );
    let rates = (
        prop_oneof![2 => Just(1u32), 2 => 1u32..=4, 1 => 5u32..=16],
        prop_oneof![2 => Just(1u32), 1 => 2u32..=3],
    );
    let code = prop::option::of(prop_oneof![
        Just(AlphaCodeName::Sqrt8),
        Just(AlphaCodeName::Sqrt16),
        Just(AlphaCodeName::Colour16),
    ]);
    let lookup = prop::option::of(prop_oneof![Just(LookupName::Nearest), Just(LookupName::Linear)]);
    let segments = prop::option::of(segments());
    let look = (
        points(),
        material(),
        blend(),
        code,
        lookup,
        prop::option::of(1u32..=20),
        segments,
    );
    (shape, rates, look).prop_map(|(shape, rates, look)| {
        let (dims, filling, seed, direction, factors, borders) = shape;
        let (planes_per_voxel, rays_per_voxel) = rates;
        let (points, material, blend, code, lookup, early_termination, segments) = look;
        let borders = borders_of(borders, dims);
        let modulated = segments.is_none() && blend.is_composited() && seed % 13 < 5;
        let mapped = segments.is_none() && blend.is_composited() && !modulated && material.is_some() && seed % 3 == 0;
        cropped(Frame {
            volume: Arc::new(volume(dims, filling, seed)),
            direction,
            eye: None,
            factors,
            planes_per_voxel,
            rays_per_voxel,
            table: fine_table_of(&points),
            material,
            blend,
            precision: PrecisionName::Compact,
            nearest: seed & 7 == 5,
            splines: false,
            borders,
            // Two in five.
            crop: (seed % 5 < 2).then(|| box_of(seed.rotate_left(21))),
            clips: if seed % 7 < 2 {
                clips_of(seed.rotate_left(13), dims)
            } else {
                Vec::new()
            },
            cue: (seed % 11 < 3).then(|| cue_of(seed.rotate_left(29))),
            modulation: modulated.then(|| modulation_of(seed.rotate_left(37))),
            reflectance: mapped.then(|| reflectance_of(seed.rotate_left(43))),
            code,
            lookup,
            early_termination,
            segments,
        })
    })
}

/// An eye about or in a volume of these sides: on voxel planes, between them, far away; and slopes of which some see nothing.
fn eye_of(seed: u64, sides: [u32; 3]) -> Eye {
    let mut random = Random::new(seed);
    let mut pick = |low: i64, high: i64| low + i64::from(random.below((high - low + 1) as u32));
    let position = sides.map(|side| {
        let side = i64::from(side);
        let whole = match pick(0, 3) {
            0 => pick(0, side),
            1 => pick(-2 * side, 3 * side),
            _ => pick(-2, side),
        };
        let part = match pick(0, 2) {
            0 => 0,
            1 => 1 << 31,
            _ => pick(0, u32::MAX.into()),
        };
        Step::from_bits((whole << 32) + part)
    });
    let most = i64::from(SLOPE_MAX.to_bits());
    let mut slopes = || {
        let (a, b) = match pick(0, 2) {
            0 => (-most, most),
            1 => (-(1 << 30), 1 << 30),
            _ => (pick(-most, most), pick(-most, most)),
        };
        [a.min(b), a.max(b)].map(|bits| Vector::from_bits(bits as i32))
    };
    let ([low_i, high_i], [low_j, high_j]) = (slopes(), slopes());
    Eye {
        position,
        low: [low_i, low_j],
        high: [high_i, high_j],
    }
}

/// Any small frame in perspective that sees something.
pub fn frame_in_perspective() -> impl Strategy<Value = Frame> {
    in_perspective(frame())
}

/// One with several blocks to a row.
pub fn wide_frame_in_perspective() -> impl Strategy<Value = Frame> {
    in_perspective(wide_frame())
}

/// Frames from an eye.
fn in_perspective(frames: impl Strategy<Value = Frame>) -> impl Strategy<Value = Frame> {
    (frames, any::<u64>()).prop_map(|(frame, seed)| {
        let parallel = Frame {
            borders: Borders::Whole,
            crop: None,
            clips: Vec::new(),
            cue: None,
            modulation: None,
            reflectance: None,
            segments: None,
            nearest: false,
            ..frame
        };
        let view = parallel.plan().expect("a frame that has a plan");
        let sides = view.volume();
        let seeing = |seed: u64, factors| {
            let frame = Frame {
                eye: Some(eye_of(seed, sides)),
                factors,
                ..parallel.clone()
            };
            match frame.plan() {
                Ok(_) => Some(frame),
                Err(CameraError::Eye(EyeError::Nothing | EyeError::Length)) => None,
                Err(error) => panic!("{error}: {frame:?}"),
            }
        };
        // Most spacings are cubic after some tries.
        let tries = (0..).map(|turn| {
            let factors = if turn < 3 { parallel.factors } else { [32768; 3] };
            seeing(seed.wrapping_add(turn), factors)
        });
        tries.flatten().next().expect("an eye that sees something")
    })
}
