use super::*;
use crate::plan::{Plan, Sampling, Spacing};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const TWO_44: f64 = 17_592_186_044_416.0;
const TWO_32: f64 = 4_294_967_296.0;

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 2000,
        rng_seed: RngSeed::Fixed(21),
        ..ProptestConfig::default()
    }
}

fn step(voxels: f64) -> Step {
    Step::from_bits((voxels * TWO_32) as i64)
}

fn vector(slope: f64) -> Vector {
    Vector::from_bits((slope * f64::from(1 << 30)) as i32)
}

fn eye_of(position: [f64; 3], [low, high]: [f64; 2]) -> Eye {
    Eye {
        position: position.map(step),
        low: [vector(low); 2],
        high: [vector(high); 2],
    }
}

fn spread(eye: Eye, volume: [u32; 3], rates: (u32, u32)) -> Result<Spread, EyeError> {
    Spread::of(eye, volume, Spacing::CUBIC.0, rates)
}

fn side() -> impl Strategy<Value = u32> {
    prop_oneof![1 => 1u32..=3, 3 => 2u32..=64, 1 => 500u32..=2048]
}

proptest! {
    #![proptest_config(config())]

    /// Positions against real numbers, and what lies inside: within the stated error of the face.
    #[test]
    fn positions_are_the_nearest(
        volume in prop::array::uniform3(side()), rays in 1u32..=8, rate in 1u32..=16,
        at in prop::array::uniform3(-1.5f64..=1.5), seed in any::<u64>(),
    ) {
        let sides = volume.map(f64::from);
        let position = [0, 1, 2].map(|axis| (at[axis] * sides[axis]).min(sides[2] * 10.0));
        let Ok(spread) = spread(eye_of(position, [-1.0, 1.0]), volume, (rays, rate)) else {
            return Ok(());
        };
        let base = spread.base();
        let eye = spread.eye().map(|c| c.to_bits() as f64 / TWO_32);
        let way = sides[2] - 1.0 - eye[2];
        let planes = (volume[2] - 1) * rate;
        for draw in 0..40u64 {
            let mixed = seed.wrapping_add(draw).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let plane = spread.first_plane() + (mixed >> 40) as u32 % (planes - spread.first_plane() + 1);
            let ahead = f64::from(plane) / f64::from(rate) - eye[2];
            for (axis, line) in spread.lines(plane).into_iter().enumerate() {
                let pixel = (mixed >> 8) as u32 % base[axis];
                let place = (f64::from(spread.first()[axis]) + f64::from(pixel)) / f64::from(rays);
                let exact = eye[axis] + (place - eye[axis]) * ahead / way;
                let bound = 0.5 / 65536.0 + 0.5 * f64::from(plane + 1) * f64::from(pixel + 1) / TWO_44 + 1e-9;
                let error = line.exact(pixel) as f64 / 65536.0 - exact;
                prop_assert!(error.abs() <= bound, "{error} of {exact}, bound {bound}");
                let inside = line.inside(volume[axis], base[axis]);
                let is_inside = (0..=i64::from(volume[axis] - 1) << 16).contains(&line.exact(pixel));
                prop_assert_eq!(inside.contains(&pixel), is_inside);
                let slope = (place - eye[axis]) / way;
                let found = f64::from(spread.slope(axis, pixel)) / f64::from(1 << 27);
                // One bit of 4.27, and the step's rounding times the planes of a voxel.
                let bound = 1.1 / f64::from(1 << 27) + f64::from(rate * (pixel + 2)) / TWO_44;
                prop_assert!((found - slope).abs() <= bound, "slope {found} of {slope}");
            }
        }
    }

    /// The image holds every ray that meets the volume between the slopes, and no column beyond those of any plane.
    #[test]
    fn the_image_is_what_is_seen(
        volume in prop::array::uniform3(1u32..=12), rays in 1u32..=3,
        at in prop::array::uniform3(-20i32..=30), slopes in prop::array::uniform2(-40i32..=40),
    ) {
        let position = at.map(|at| f64::from(at) / 2.0);
        let [a, b] = slopes.map(|slope| f64::from(slope) / 32.0);
        let slopes = [a.min(b), a.max(b)];
        let made = spread(eye_of(position, slopes), volume, (rays, 1));
        let way = f64::from(volume[2]) - 1.0 - position[2];
        let ahead = (0..volume[2]).map(|plane| f64::from(plane) - position[2]).filter(|ahead| *ahead >= 0.5);
        let ahead: std::vec::Vec<f64> = ahead.collect();
        let mut sees = !ahead.is_empty();
        let mut ends = [[0; 2]; 2];
        for axis in 0..2 {
            let thrown = |face: f64| {
                let all = ahead.iter().map(move |ahead| position[axis] + (face - position[axis]) * way / ahead);
                all.collect::<std::vec::Vec<f64>>()
            };
            let low = thrown(0.0).into_iter().fold(position[axis] + way * slopes[1] + 1e9, f64::min);
            let high = thrown(f64::from(volume[axis]) - 1.0).into_iter().fold(-1e9, f64::max);
            let (low, high) = (low.max(position[axis] + way * slopes[0]), high.min(position[axis] + way * slopes[1]));
            // What lies on a face but for the last bits may be left out or not.
            let (first, last) = ((low * f64::from(rays) - 1e-6).ceil(), (high * f64::from(rays) + 1e-6).floor());
            sees &= first <= last;
            ends[axis] = [first as i32, last as i32];
        }
        match made {
            Ok(spread) => {
                let base = spread.base();
                prop_assert!(sees);
                for axis in 0..2 {
                    let [first, last] = ends[axis];
                    let found = [spread.first()[axis], spread.first()[axis] + base[axis] as i32 - 1];
                    prop_assert!((found[0] - first).abs() <= 1 && (found[1] - last).abs() <= 1, "{found:?} {first} {last}");
                }
            }
            Err(EyeError::Nothing) => {
                let thin = ends.iter().any(|[first, last]| last.saturating_sub(*first) <= 1);
                prop_assert!(!sees || thin, "{ends:?}");
            }
            Err(error) => prop_assert!(false, "{error}"),
        }
    }

    /// Lengths and vectors against real numbers.
    #[test]
    fn ways_are_close(i in -4.9f64..=4.9, j in -4.9f64..=4.9) {
        let slopes = [i, j].map(|slope| (slope * f64::from(1 << 27)) as i32);
        let [i, j] = slopes.map(|slope| f64::from(slope) / f64::from(1 << 27));
        let way = Way::of(slopes.map(square));
        let length = (1.0 + i * i + j * j).sqrt();
        let found = f64::from(way.length()) / f64::from(1 << 20);
        prop_assert!((found / length - 1.0).abs() <= LENGTH_ERROR, "{found} of {length}");
        let mut sum = 0.0;
        for (slope, exact) in [(slopes[0], i), (slopes[1], j), (ALONG_K, 1.0)] {
            let found = f64::from(way.towards(slope)) / f64::from(1 << 30);
            prop_assert!((found + exact / length).abs() <= TOWARDS_ERROR, "{found} of {}", exact / length);
            sum += found * found;
        }
        prop_assert!((sum - 1.0).abs() <= 4.0 * TOWARDS_ERROR);
    }
}

/// Of a length, relative.
const LENGTH_ERROR: f64 = 2.5e-6;
/// Of a component towards the eye.
const TOWARDS_ERROR: f64 = 1.7e-6;

#[test]
fn what_is_out_of_range_is_named() {
    let ok = |position, volume| spread(eye_of(position, [-1.0, 1.0]), volume, (1, 1));
    assert!(ok([4.0, 4.0, -10.0], [9; 3]).is_ok());
    assert_eq!(ok([-32768.0, 4.0, -10.0], [9; 3]), Err(EyeError::Far { axis: 0 }));
    assert_eq!(ok([4.0, 32777.0, -10.0], [9; 3]), Err(EyeError::Far { axis: 1 }));
    assert_eq!(ok([4.0, 4.0, -40000.0], [9; 3]), Err(EyeError::Far { axis: 2 }));
    for k in [7.6, 8.0, 9.0, 100.0] {
        assert_eq!(ok([4.0, 4.0, k], [9; 3]), Err(EyeError::Nothing), "{k}");
    }
    let steep = eye_of([4.0, 4.0, -10.0], [-1.0, 1.26]);
    let bits = steep.high[0].to_bits();
    assert_eq!(spread(steep, [9; 3], (1, 1)), Err(EyeError::Slope { bits }));
    // Voxels eight times as long across as along: 1 + 64 is beyond 63.
    let thin = [4096u16, 32768, 32768].map(Intensity::from_bits);
    let eye = eye_of([4.0, 4.0, -3.0], [-1.0, 1.0]);
    assert_eq!(Spread::of(eye, [64, 9, 64], thin, (1, 1)), Err(EyeError::Length));
    assert!(Spread::of(eye, [64, 9, 64], [8192, 32768, 32768].map(Intensity::from_bits), (1, 1)).is_ok());
}

/// The farthest eye, the largest volume, the most rays: nothing overflows, which debug builds check.
#[test]
fn extremes_have_plans() {
    let sampling = Sampling {
        planes_per_voxel: 4,
        rays_per_voxel: 8,
    };
    let view = crate::view::View::new([0, 0, 1].map(|c| crate::format::Direction::from_bits(c << 58))).unwrap();
    for position in [
        [-32767.0; 3],
        [40959.0, 40959.0, -32767.0],
        [4096.0, 4096.0, 8190.5],
        [0.0, 8191.0, 0.0],
    ] {
        for slopes in [[-1.25, 1.25], [-1.0, 1.0]] {
            let Ok((plan, spread)) =
                Plan::perspective(view, [8192; 3], Spacing::CUBIC, sampling, eye_of(position, slopes))
            else {
                continue;
            };
            let base = plan.base();
            for index in [spread.first_plane(), plan.planes() / 2, plan.planes() - 1] {
                for (line, pixels) in spread.lines(index).into_iter().zip(base) {
                    let _ = (line.exact(0), line.exact(pixels - 1), line.inside(8192, pixels));
                }
            }
            for (axis, pixels) in base.into_iter().enumerate() {
                let _ = (spread.slope(axis, 0), spread.slope(axis, pixels - 1));
            }
            assert_eq!((plan.phases(), plan.planes(), plan.spreads()), (1, 8191 * 4 + 1, true));
            assert_eq!(base, spread.base());
        }
    }
}
