//! The directed vectors are met by a model that was written from the contract alone, and they find every mistake that it
//! can be made to make.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use slicecast::borders::Borders;
use slicecast_host_tests::found::{departures, mutations, table};
use slicecast_host_tests::frame::{Frame, fine_table_of};
use slicecast_host_tests::framed::first_departure;
use slicecast_host_tests::random::{Filling, volume};
use slicecast_host_tests::second::Width;
use slicecast_scene::{AlphaCodeName, Blend, LookupName, PrecisionName};
use slicecast_vectors::directed;
use slicecast_vectors::files::{Format, bytes_of_vector};
use slicecast_vectors::frame::{self, Part};
use slicecast_vectors::set::Set;

use super::frames::light;

#[test]
fn the_second_model_meets_every_directed_vector() {
    let mut wrong = Vec::new();
    for set in directed::sets() {
        let departures = departures(&set, None);
        if let Some(first) = departures.first() {
            wrong.push((set.name.clone(), departures.len(), *first));
        }
    }
    assert!(wrong.is_empty(), "set, how many, first: {wrong:?}");
}

#[test]
fn directed_vectors_find_every_mistake() {
    let found = mutations();
    let missed: Vec<_> = found
        .iter()
        .filter(|found| found.vectors == 0)
        .map(|found| found.mistake)
        .collect();
    assert!(missed.is_empty(), "not found: {missed:?}");
    assert!(found.len() >= 90, "{}", found.len());
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/verification.md");
    let page = std::fs::read_to_string(page).expect("a page of the documentation");
    assert!(
        page.contains(&table(&found)),
        "docs/verification.md has another table of mutations; `cargo run -p slicecast-host-tests --bin mutations` prints it"
    );
}

/// A frame with everything on: three precisions, both orders, lights, phases, spacing, ties.
fn frames() -> Vec<Frame> {
    let points = [
        (0, [65535, 20_000, 0], 0),
        (900, [300, 65535, 7_000], 9_000),
        (2_500, [65535, 65535, 65535], 60_000),
        (4_095, [0, 3, 65535], 0),
    ];
    let noise = Frame::new(Arc::new(volume([6, 5, 7], Filling::Noise, 1)), fine_table_of(&points));
    let lit = Frame {
        direction: [3, -2, -7],
        factors: [32768, 20_001, 29_127],
        planes_per_voxel: 2,
        rays_per_voxel: 2,
        material: Some(light(3, 5)),
        ..noise.clone()
    };
    let mut frames = Vec::new();
    for precision in [PrecisionName::Paper, PrecisionName::Compact, PrecisionName::Wide] {
        let lit = lit.in_precision(precision);
        let thin = |dims, direction| Frame {
            volume: Arc::new(volume(dims, Filling::Extremes, 3)),
            direction,
            ..lit.clone()
        };
        frames.extend([
            noise.in_precision(precision),
            lit.clone(),
            Frame {
                blend: Blend::BackToFront,
                material: Some(light(5, 2)),
                direction: [-5, 5, 3],
                ..lit.clone()
            },
            // Sides of one and of two voxels, where borders are made of borders.
            thin([1, 2, 5], [1, 1, 4]),
            thin([4, 1, 2], [-3, 8, 5]),
            thin([2, 2, 1], [1, -1, 2]),
            Frame {
                nearest: true,
                lookup: Some(LookupName::Nearest),
                ..lit.clone()
            },
            Frame {
                early_termination: Some(3),
                code: Some(AlphaCodeName::Sqrt8),
                ..lit.clone()
            },
            Frame {
                blend: Blend::Maximum,
                ..lit.clone()
            },
            Frame {
                blend: Blend::Minimum,
                direction: [7, 2, -3],
                ..lit.clone()
            },
            Frame {
                borders: Borders::Cells,
                ..lit.clone()
            },
            Frame {
                borders: Borders::Nodes,
                rays_per_voxel: 3,
                direction: [7, -7, -7],
                ..lit.clone()
            },
            Frame {
                borders: Borders::Cells,
                ..thin([1, 2, 5], [1, 1, 4])
            },
            Frame {
                borders: Borders::Cells,
                blend: Blend::Maximum,
                ..noise.in_precision(precision)
            },
        ]);
    }
    frames
}

#[test]
fn the_second_model_meets_the_vectors_of_frames() {
    let mut stages = BTreeSet::new();
    for frame in frames() {
        let width = Width::of_name(frame.precision.name()).expect("one of three precisions");
        let sets = frame.with_prepared(|prepared, _| {
            let whole = Part::whole(&prepared.setup.plan);
            frame::sets(prepared, &whole).expect("a small frame")
        });
        let (departure, count) = first_departure(&sets, width);
        assert_eq!(departure, None, "{:?} after {count} vectors", frame.precision);
        assert!(count > 100, "{count}");
        stages.extend(sets.sets.iter().map(|set| set.stage));
    }
    assert_eq!(stages.len(), 12, "{stages:?}");
}

#[test]
fn a_part_of_a_frame_is_that_part_of_the_whole() {
    let all = frames();
    let parts = all[1].with_prepared(|prepared, _| {
        let whole = Part::whole(&prepared.setup.plan);
        let part = Part {
            planes: 3..6,
            rows: 1..4,
        };
        let formats = Format::ALL;
        let [samples, bytes] = frame::at_most(prepared, &part, &formats);
        let [whole, part] = [whole, part].map(|part| frame::sets(prepared, &part).expect("a small frame"));
        let interpolation = part
            .sets
            .iter()
            .find(|set| set.stage == "interpolation")
            .expect("samples");
        assert!(interpolation.len() as u64 <= samples);
        let of = |set: &Set| set.len() as u64 * bytes_of_vector(set, &formats);
        assert!(part.sets.iter().map(of).sum::<u64>() <= bytes);
        (whole, part)
    });
    for set in &parts.1.sets {
        let whole = parts
            .0
            .sets
            .iter()
            .find(|whole| whole.name == set.name)
            .expect("a set of the whole");
        let inside = |index: &usize| {
            let place = &whole.inputs.row(*index)[..whole.place];
            let plane = place.first().is_none_or(|plane| (3..6).contains(plane));
            plane && place.get(2).is_none_or(|row| (1..4).contains(row))
        };
        let expected: Vec<_> = (0..whole.len())
            .filter(inside)
            .map(|index| whole.inputs.row(index))
            .collect();
        let found: Vec<_> = (0..set.len()).map(|index| set.inputs.row(index)).collect();
        assert_eq!(expected, found, "{}", set.name);
    }
    assert!(
        parts
            .1
            .sets
            .iter()
            .all(|set| set.stage != "image" && set.stage != "picture")
    );
}
