//! The arithmetic of small machines, on the host: whole frames by the lane that Cortex-M and RV32 run, with the point table
//! that firmware reads, against the scalar definitions.

use std::ops::Range;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use slicecast::classify::Classifier;
use slicecast::clip::Clips;
use slicecast::composite::{BackToFront, Channel as _, FrontToBack, Order};
use slicecast::lanes::Small;
use slicecast::modulate::Modulated;
use slicecast::plane::{At, Composite, Pipeline, Project, Rows, Splines, clear};
use slicecast::precision::Precision;
use slicecast::project::{Maximum, Minimum, Sum};
use slicecast::shade::{Shader, Unlit};
use slicecast::slice::{Code12, Slice, Window};
use slicecast::stream::{Needs, base_pixel};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::geometry::Geometry;
use slicecast_engine::reflectance;
use slicecast_engine::with_precision;
use slicecast_host_tests::frame::Frame;
use slicecast_scene::{Blend, PrecisionName};

use super::frames::{self, frame};

/// The channels of a base-plane image, pixel after pixel.
type Bits = Vec<[u32; 4]>;

/// Folds all planes with [`Small`] lanes.
fn folded<L: Pipeline<Voxel = Code12>>(
    Geometry { plan, clips }: Geometry<'_>,
    slices: &[Slice<'_>],
    pipeline: &L,
) -> Bits {
    let mut image = vec![L::Element::default(); Needs::of::<L>(plan).image];
    clear(pipeline, plan, &mut image);
    let mut scratch = vec![0; L::SHAPE.scratch_len(plan.dims()[0])];
    for (number, data) in image.chunks_mut(L::SHAPE.phase_len(plan)).enumerate() {
        let Range { start, end } = L::SHAPE.planes(plan);
        for step in 0..end - start {
            let index = if L::BACK_TO_FRONT { end - 1 - step } else { start + step };
            let plane = L::SHAPE.plane(plan, plan.phase(number as u32), index);
            let slice = |z: i32| usize::try_from(z).ok().and_then(|z| slices.get(z)).copied();
            let Some(window) = Window::at(L::SHAPE.near_slice(plan, index), slice) else {
                continue;
            };
            let at = At {
                plan,
                plane,
                window,
                seen: None,
                clips: clips.map(Clips::clipper),
                reading: None,
            };
            let rows = Rows { first: 0, data };
            pipeline.fold::<Small>(&at, rows, &mut scratch, None, None).unwrap();
        }
    }
    let [width, height] = plan.base().map(|side| i64::from(side * plan.sampling().rays_per_voxel));
    let places = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
    let bits = |(u, v)| {
        let pixel = base_pixel(plan, pipeline, &image, u, v);
        let [red, green, blue] = pixel.colour.map(|c| c.bits());
        [red, green, blue, pixel.transparency.bits()]
    };
    places.map(bits).collect()
}

fn composited<P: Precision, C: Classifier<P>, S: Shader<P>, O: Order>(
    p: P,
    prepared: &Prepared<'_>,
    slices: &[Slice<'_>],
    (classifier, shader): (C, S),
) -> Bits {
    let mut pipeline = Composite::<P, _, S, O>::new(p, classifier, shader);
    if let Some(bits) = prepared.scene.early_termination {
        pipeline = pipeline.with_early_termination(bits);
    }
    folded(prepared.setup.geometry(), slices, &pipeline)
}

fn small<P: Precision>(p: P, prepared: &Prepared<'_>, slices: &[Slice<'_>]) -> Bits {
    let (geometry, table) = (prepared.setup.geometry(), prepared.table.classifier());
    match (prepared.scene.blend, &prepared.segments) {
        (Blend::Maximum, _) => folded(geometry, slices, &Project::<_, _, Maximum>::new(p, table)),
        (Blend::Minimum, _) => folded(geometry, slices, &Project::<_, _, Minimum>::new(p, table)),
        (Blend::Average, _) => folded(geometry, slices, &Project::of(p, table, Sum::Average)),
        (Blend::Additive, _) => folded(geometry, slices, &Project::of(p, table, prepared.setup.additive)),
        (_, Some(segments)) => classified(p, prepared, slices, segments.clone()),
        (_, None) => classified(p, prepared, slices, table),
    }
}

fn classified<P: Precision, C: Classifier<P>>(
    p: P,
    prepared: &Prepared<'_>,
    slices: &[Slice<'_>],
    classifier: C,
) -> Bits {
    let back_to_front = prepared.scene.blend == Blend::BackToFront;
    if let (Some(modulation), None) = (&prepared.modulation, &prepared.segments) {
        let table = prepared.table.classifier();
        let phong = prepared
            .setup
            .material
            .as_ref()
            .map(|material| material.phong(p).unwrap());
        let shader = Modulated::new(p, phong, modulation.clone());
        return if back_to_front {
            composited::<_, _, _, BackToFront>(p, prepared, slices, (table, shader))
        } else {
            composited::<_, _, _, FrontToBack>(p, prepared, slices, (table, shader))
        };
    }
    if let (Some(map), None, Some(material)) =
        (prepared.scene.reflectance, &prepared.segments, &prepared.setup.material)
    {
        let shader = reflectance::of(&material.phong(p).unwrap(), map).unwrap();
        let table = prepared.table.classifier();
        return if back_to_front {
            composited::<_, _, _, BackToFront>(p, prepared, slices, (table, shader))
        } else {
            composited::<_, _, _, FrontToBack>(p, prepared, slices, (table, shader))
        };
    }
    match (back_to_front, &prepared.setup.material) {
        (false, Some(material)) => {
            let phong = material.phong(p).unwrap();
            composited::<_, _, _, FrontToBack>(p, prepared, slices, (classifier, phong))
        }
        (false, None) => composited::<_, _, _, FrontToBack>(p, prepared, slices, (classifier, Unlit)),
        (true, Some(material)) => {
            let phong = material.phong(p).unwrap();
            composited::<_, _, _, BackToFront>(p, prepared, slices, (classifier, phong))
        }
        (true, None) => composited::<_, _, _, BackToFront>(p, prepared, slices, (classifier, Unlit)),
    }
}

fn splined<P: Precision>(p: P, prepared: &Prepared<'_>, slices: &[Slice<'_>]) -> Bits {
    let back_to_front = prepared.scene.blend == Blend::BackToFront;
    match (back_to_front, &prepared.setup.material) {
        (false, Some(material)) => by_splines::<_, _, FrontToBack>(p, prepared, slices, material.phong(p).unwrap()),
        (false, None) => by_splines::<_, _, FrontToBack>(p, prepared, slices, Unlit),
        (true, Some(material)) => by_splines::<_, _, BackToFront>(p, prepared, slices, material.phong(p).unwrap()),
        (true, None) => by_splines::<_, _, BackToFront>(p, prepared, slices, Unlit),
    }
}

fn by_splines<P: Precision, S: Shader<P>, O: Order>(
    p: P,
    prepared: &Prepared<'_>,
    slices: &[Slice<'_>],
    shader: S,
) -> Bits {
    let mut pipeline = Composite::<P, _, S, O>::new(p, prepared.table.classifier(), shader);
    if let Some(bits) = prepared.scene.early_termination {
        pipeline = pipeline.with_early_termination(bits);
    }
    folded(prepared.setup.geometry(), slices, &Splines(pipeline))
}

/// The image of the stream layer with one lane.
fn expected(prepared: &Prepared<'_>) -> Bits {
    let base = prepared.render(Layer::Stream, &|_, _| ()).unwrap().base;
    let [red, green, blue, transparency] = &base.planes;
    let colours = red.iter().zip(green).zip(blue).zip(transparency);
    colours.map(|(((r, g), b), t)| [*r, *g, *b, *t]).collect()
}

proptest! {
    #![proptest_config(Config { cases: 400, rng_seed: RngSeed::Fixed(44), failure_persistence: None, ..Config::default() })]

    /// Every fifth by splines, if it can be.
    #[test]
    fn small_lanes_make_the_same_frames((frame, smooth) in (frame(), 0..5)) {
        let frame = if smooth == 0 { frames::splined(frame) } else { frame };
        for precision in PrecisionName::STAGED {
            let frame: Frame = frame.in_precision(precision);
            let (expected, found) = frame.with_prepared(|prepared, slices| {
                let found = if frame.splines {
                    with_precision!(precision, p => splined(p, prepared, slices))
                } else {
                    with_precision!(precision, p => small(p, prepared, slices))
                };
                (expected(prepared), found)
            });
            let first = expected.iter().zip(&found).position(|(a, b)| a != b);
            prop_assert_eq!(first, None, "{}: {} pixels", precision.name(), expected.len());
            prop_assert_eq!(expected.len(), found.len());
        }
    }
}
