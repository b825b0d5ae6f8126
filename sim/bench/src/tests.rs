use super::scenes::{Fog, cube, fog};
use super::*;

#[test]
fn samples_are_what_the_rays_meet() {
    struct Count(u64);
    impl rays::Witness for Count {
        const EVERYTHING: bool = true;
        fn sample(&mut self, _: rays::Visit, _: i32, _: Option<i32>) {
            self.0 += 1;
        }
    }
    let volume = cube(16);
    let mut scene = fog(
        &volume,
        Fog {
            lights: 0,
            colourful: false,
        },
    );
    scene.sampling.rays_per_voxel = 2;
    scene.sampling.planes_per_voxel = 3;
    let prepared = Prepared::new(&scene, &volume).unwrap();
    let mut count = Count(0);
    let by_rays = rays::render(&prepared, &mut count).unwrap();
    assert_eq!(samples(&prepared.setup.plan), count.0);
    // The definitions, skipping nothing, against the engine.
    let frame = prepared
        .render(slicecast_engine::frame::Layer::Tiles(TILE_ROWS), &|_, _| ())
        .unwrap();
    assert!(by_rays == frame.base);
}

#[test]
fn every_subject_is_measured_and_compared_with_its_own_kind() {
    let volume = cube(16);
    let scene = fog(
        &volume,
        Fog {
            lights: 1,
            colourful: true,
        },
    );
    let subject = |engine, simd, all_threads| Subject {
        engine,
        simd,
        all_threads,
    };
    let subjects = [
        subject(Engine::Fixed(PrecisionName::Compact), Simd::Scalar, false),
        subject(Engine::Fixed(PrecisionName::Wide), Simd::Scalar, true),
        subject(Engine::Float, Simd::Scalar, false),
        subject(Engine::Rays(PrecisionName::Paper), Simd::Scalar, false),
    ];
    let threads = Threads::start(Some(2)).unwrap();
    let (samples, rows) = measure(&scene, &volume, &subjects, 2, &threads, &|_, _| ()).unwrap();
    assert_eq!(rows.iter().map(|row| row.threads).collect::<Vec<_>>(), [1, 2, 1, 1]);
    assert_eq!(rows[0].against_compact, Some(1.0));
    assert_eq!(rows[1].against_compact, None);
    for row in &rows {
        assert!(row.milliseconds > 0.0 && row.milliseconds.is_finite(), "{row:?}");
        let product = row.samples_per_second * row.milliseconds / 1e3;
        assert!((product / samples as f64 - 1.0).abs() < 1e-9, "{row:?}");
    }
    let ratio = rows[2].against_compact.unwrap();
    assert!((ratio / (rows[0].milliseconds / rows[2].milliseconds) - 1.0).abs() < 1e-9);
}

/// Vectors whose operations were not inlined into the code for the processor take thirty times as long: `vector_calls.py`
/// finds where. An unoptimised build inlines nothing.
#[cfg(not(debug_assertions))]
#[test]
fn vectors_are_faster_than_one_lane() {
    let volume = cube(48);
    for lights in [0, 1] {
        let scene = fog(
            &volume,
            Fog {
                lights,
                colourful: true,
            },
        );
        for engine in [Engine::Fixed(PrecisionName::Compact), Engine::Float] {
            let subject = |simd| Subject {
                engine,
                simd,
                all_threads: false,
            };
            let subjects: Vec<_> = Simd::available().map(subject).collect();
            let threads = Threads::start(Some(1)).unwrap();
            let (_, rows) = measure(&scene, &volume, &subjects, 5, &threads, &|_, _| ()).unwrap();
            let [scalar, vectors @ ..] = &rows[..] else {
                panic!("no row of one lane")
            };
            for row in vectors {
                assert!(
                    row.milliseconds < scalar.milliseconds,
                    "{lights} lights: {row:?}, {scalar:?}"
                );
            }
        }
    }
}
