//! Gradients: the border rule, and the study's linear field through the whole pipeline.

use std::sync::Arc;

use slicecast::format::{Coefficient, Vector};
use slicecast::normalise::{normalise, unit};
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::shade::{Highlight, Light, keep_vector};
use slicecast::stage::Stage;
use slicecast_engine::camera::Material;
use slicecast_engine::frame::Layer;
use slicecast_host_tests::frame::{Frame, table_of};
use slicecast_host_tests::random::{Filling, volume};
use slicecast_host_tests::record::{Place, recorded};
use slicecast_scene::PrecisionName;
use slicecast_volume::Volume;

/// A direction as a unit vector, s1.30.
fn towards(v: [f64; 3]) -> [Vector; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| Vector::from_bits((c / length * 2f64.powi(30)).round() as i32))
}

/// White light of full strength from `direction`, nothing else.
fn diffuse_only(direction: [Vector; 3]) -> Material {
    Material {
        ambient: [Coefficient::ZERO; 3],
        lights: vec![Light {
            direction,
            half: direction,
            diffuse: [Coefficient::ONE; 3],
            specular: [Coefficient::ZERO; 3],
        }],
        viewer: [Vector::ZERO, Vector::ZERO, -Vector::ONE],
        highlight: Highlight::Reflection,
        exponent_log2: 0,
    }
}

/// A frame in which every sample is visible: white, thin.
fn thin_white(volume: Volume, material: Material) -> Frame {
    Frame {
        material: Some(material),
        ..Frame::new(Arc::new(volume), table_of(&[(0, [255; 3], 300)]))
    }
}

/// One row of voxels along x, y or z, looked at along +z (the row along z: from its end). One voxel beyond each end it
/// is continued linearly, so that the ends have twice their one-sided difference: for 10, 13, 40, 0 the central
/// differences are 6, 30, -13, -80. Along the other axes there is one voxel, and no difference.
#[test]
fn a_row_of_voxels_is_continued_linearly() {
    let row = [10, 13, 40, 0];
    for (axis, dims) in [[4, 1, 1], [1, 4, 1], [1, 1, 4]].into_iter().enumerate() {
        let mut volume = volume(dims, Filling::Constant(0), 0);
        volume.voxels = row.to_vec();
        let frame = thin_white(volume, diffuse_only(towards([0.6, 0.0, -0.8])));
        for (precision, bits) in [
            (PrecisionName::Paper, 12),
            (PrecisionName::Compact, 12),
            (PrecisionName::Wide, 15),
        ] {
            let (_, recording) = recorded(&frame.in_precision(precision), Layer::Stream);
            for (n, expected) in [6, 30, -13, -80].into_iter().enumerate() {
                let mut place = Place {
                    step: 0,
                    phase: 0,
                    part: 0,
                    stage: Stage::Gradient,
                    row: 0,
                    column: 0,
                };
                match axis {
                    0 => place.column = n as u32,
                    1 => place.row = n as u32,
                    _ => place.step = n as u32,
                }
                let mut gradient = [0i32; 3];
                gradient[axis] = expected << bits;
                let found = recording.values[&place];
                assert_eq!(
                    [found[0], found[1], found[2]].map(|c| c as i32),
                    gradient,
                    "{precision:?} {place:?}"
                );
            }
        }
    }
}

/// The study's field `7 x - 5 y + 11 z + 400`, shear (0.25, -0.5), two planes per voxel.
///
/// All gradients are 2 (7, -5, 11), borders included, and N = -(7, -5, 11) / sqrt(195). With the light
/// (0.1, 0.2, -0.9) / sqrt(0.86) the cosine is 10.2 / sqrt(195 * 0.86) = 0.787650659 and with
/// (-0.6, 0.3, -0.5) / sqrt(0.7) it is 11.2 / sqrt(195 * 0.7) = 0.958631503. (The study's 0.787665 and 0.958623 are
/// not these cosines; they are not used here.) In 1.15 that is 25809.7 and 31412.4. Lights kept in s1.15 turn by up to
/// 1.5 units a component, as they are chosen for their length, which moves the cosine by at most 2.6 units; lights in
/// s1.30 do not.
#[test]
fn linear_field() {
    for (light, cosine) in [([0.1, 0.2, -0.9], 0.787_650_659), ([-0.6, 0.3, -0.5], 0.958_631_503)] {
        let direction = towards(light);
        let field = volume([7, 6, 5], Filling::Linear, 0);
        let frame = Frame {
            direction: [1, -2, 4],
            planes_per_voxel: 2,
            ..thin_white(field, diffuse_only(direction))
        };
        // The vector kept, fraction bits of it and of the colour, and what may be missing: rounding leaves half a unit
        // of 1.15 and what the 15 bits of the normal do, which is all in 1.31. Paper truncates the normal to 1.12
        // (three components of up to 8 units each, weighted by the light), the product and the result after that.
        for (precision, kept, [vector_bits, colour_bits], low, high) in [
            (
                PrecisionName::Paper,
                keep_vector(Paper, direction),
                [15, 15],
                -16.0,
                8.0,
            ),
            (
                PrecisionName::Compact,
                keep_vector(Compact, direction),
                [15, 15],
                -1.0,
                1.0,
            ),
            (PrecisionName::Wide, keep_vector(Wide, direction), [30, 31], -0.5, 0.5),
        ] {
            let [x, y, z] = kept.map(|c| f64::from(c) / 2f64.powi(vector_bits));
            let rounded = -(7.0 * x - 5.0 * y + 11.0 * z) / 195f64.sqrt();
            let turned = if vector_bits == 15 { 2.6 / 32768.0 } else { 1e-9 };
            assert!((rounded - cosine).abs() < turned, "{precision:?}: {rounded}");
            let (_, recording) = recorded(&frame.in_precision(precision), Layer::Stream);
            let shaded = |place: &Place| place.stage == Stage::Shading;
            let mut samples = 0;
            for (place, bits) in recording.values.iter().filter(|(place, _)| shaded(place)) {
                let found = f64::from(bits[0]) / 2f64.powi(colour_bits);
                let error = (found - rounded) * 32768.0;
                assert!(
                    (low..=high).contains(&error),
                    "{precision:?} {place:?}: {found} is {error} units off"
                );
                samples += 1;
            }
            // Every sample of the 9 planes, borders included: planes on slices with whole-voxel shears have full rows.
            assert!(samples > 150, "{samples}");
        }
    }
}

/// The direction of that gradient, as `normalise` sees it in 12.15 and in 12.12: the same g.
#[test]
fn the_linear_fields_normal() {
    let exact = [7.0, -5.0, 11.0].map(|c: f64| c / 195f64.sqrt() * 32768.0);
    for bits in [12, 15] {
        let normal = normalise([14, -10, 22].map(|c: i32| c << bits));
        for (n, e) in unit(normal).into_iter().zip(exact) {
            assert!((f64::from(n.to_bits()) - e).abs() <= 0.5 + 1e-3, "{n} {e}");
        }
    }
}
