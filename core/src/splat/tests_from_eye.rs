//! Splatting in perspective against its formulas: sums in 128 bits without bins, bands or rings; closed forms; what is left out; what
//! is refused.

use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::tests::{kernel_of, needed, noise, samples, step};
use super::*;
use crate::classify::Support;

/// A volume of these sides, turned, its middle so far in front of an eye and beside its axis, in voxels; pixels of an image of
/// this field of view.
#[derive(Clone, Copy, Debug)]
struct Seen {
    dims: [u32; 3],
    angles: [f64; 2],
    rate: f64,
    spacing: [f64; 3],
    middle: [f64; 3],
    half_fov: f64,
    size: [u32; 2],
    layout: Layout,
}

impl Seen {
    fn splatting(&self) -> Result<Splatting, SplatError> {
        let ([a, b], rate) = (self.angles, self.rate);
        let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
        let rows = [[ca, sa, 0.0], [-sa * cb, ca * cb, sb], [sa * sb, -ca * sb, cb]];
        let steps = [0, 1, 2].map(|m| [0, 1, 2].map(|axis| rows[axis][m] * self.spacing[m] * rate));
        let first = [0, 1, 2].map(|axis| {
            let half: f64 = (0..3).map(|m| steps[m][axis] * f64::from(self.dims[m] - 1) / 2.0).sum();
            step(self.middle[axis] * rate - half)
        });
        let distance = f64::from(self.size[1]) / 2.0 / self.half_fov.to_radians().tan();
        let distance = (distance * 65536.0).round() as u32;
        Splatting::from_eye(
            self.dims,
            first,
            steps.map(|s| s.map(step)),
            (distance, self.size),
            self.layout,
        )
    }
}

/// A cube of 9 voxels 20 in front of an eye.
const PLAIN: Seen = Seen {
    dims: [9; 3],
    angles: [0.3, 0.7],
    rate: 1.0,
    spacing: [1.0; 3],
    middle: [0.0, 0.0, 20.0],
    half_fov: 20.0,
    size: [24, 24],
    layout: Layout::FINE,
};

/// x, y with 13 bits, and depth behind the first bin of a voxel, from the formulas.
fn record(splatting: &Splatting, voxel: [u32; 3]) -> Option<([i128; 2], i128)> {
    let eye = splatting.eye().unwrap();
    let [x, y, z] = splatting.place(voxel).map(i128::from);
    if z < i128::from(eye.near()) {
        return None;
    }
    let k = 128 - z.leading_zeros() - 30;
    let short = |c: i128| (c + (1 << (k - 1))).div_euclid(1 << k);
    let reciprocal = ((1 << 61) + short(z)) / (2 * short(z));
    let bits = splatting.layout().position_bits();
    let mut place = [0; 2];
    for axis in 0..2 {
        let slope = (short([x, y][axis]) * reciprocal + (1 << 25)).div_euclid(1 << 26);
        let (side, margin) = (i128::from(splatting.size()[axis]), i128::from(eye.margin()[axis]));
        let half = (side + 2 * margin) << 49;
        if slope.abs() > half / i128::from(eye_distance(splatting)) + 1 {
            return None;
        }
        let exact = slope * i128::from(eye_distance(splatting)) + ((side - 1) << 49) + (margin << 50);
        let near = (exact + (1 << (49 - bits))).div_euclid(1 << (50 - bits));
        if near < 0 || near > (side + 2 * margin - 1) << bits {
            return None;
        }
        place[axis] = near << (13 - bits);
    }
    Some((place, z - i128::from(eye.near())))
}

/// From the slope of the next pixel, which is its reciprocal.
fn eye_distance(splatting: &Splatting) -> u32 {
    splatting.eye().unwrap().distance()
}

/// Sums of weights and of weights times values of each sheet's pixels, voxel by voxel from the formulas.
fn sums(splatting: &Splatting, voxels: &[u16]) -> Vec<[u128; 2]> {
    let memory = kernel_of(splatting);
    let kernel = Kernel::of(splatting, &memory).unwrap();
    let ([width, height], [nx, ny, _]) = (splatting.size(), splatting.dims());
    let mut sums = vec![[0; 2]; (width * height * splatting.sheets()) as usize];
    let (layout, eye) = (splatting.layout(), splatting.eye().unwrap());
    let widths = eye.widths();
    for (number, &code) in voxels.iter().enumerate() {
        let number = number as u32;
        let Some((place, depth)) = record(splatting, [number % nx, number / nx % ny, number / (nx * ny)]) else {
            continue;
        };
        let q = (depth * (1 << layout.depth_bits()) + (1 << 31)).div_euclid(1 << 32);
        let (bin, u) = (q >> layout.depth_bits(), q & ((1 << layout.depth_bits()) - 1));
        let middle = (i128::from(eye.near()) + (bin << 32) + (1 << 31)) >> 16;
        let weight = |axis: usize, pixel: u32| {
            let width = (i128::from(widths[axis]) * i128::from(eye_distance(splatting)) / middle).max(1 << 16);
            let inverse = ((1 << 41) + width) / (2 * width);
            let distance = (i128::from(pixel + eye.margin()[axis]) << 13) - place[axis];
            // 20 fraction bits, their square 40.
            let t = (distance.abs() * inverse + (1 << 16)) >> 17;
            let b = match t {
                t if t < 1 << 19 => (3 << 39) - 2 * t * t,
                t if t < 3 << 19 => ((3 << 19) - t).pow(2),
                _ => 0,
            };
            ((b + (1 << 24)) >> 25) as u32
        };
        let value = layout.code(layout.stored(code));
        for (j, &slab) in kernel.slabs(u as u32).iter().enumerate() {
            for row in 0..height {
                for column in 0..width {
                    let weight = u128::from(product(slab, weight(1, row), weight(0, column)));
                    let at = (bin as u32 + j as u32) * height * width + row * width + column;
                    let [weights, values] = &mut sums[at as usize];
                    *weights += weight;
                    *values += weight * u128::from(value);
                }
            }
        }
    }
    sums
}

fn any_seen() -> impl Strategy<Value = Seen> {
    let volume = (
        prop::array::uniform3(1u32..=7),
        prop::array::uniform2(-3.2..3.2f64),
        1u32..=2,
    );
    let spacing = prop::array::uniform3(prop::sample::select(vec![1.0, 1.0, 1.5]));
    let eye = (prop::array::uniform2(-4.0..4.0f64), -1.0..14.0f64, 3.0..60.0f64);
    let image = prop::array::uniform2(1u32..=14);
    let layout = (6u32..=13, 1u32..=10, 4u32..=12).prop_map(|(f, u, v)| Layout::new(f, u, v).unwrap_or(Layout::FINE));
    (volume, spacing, eye, image, layout).prop_map(|((dims, angles, rate), spacing, eye, size, layout)| {
        let ([x, y], z, half_fov) = eye;
        Seen {
            dims,
            angles,
            rate: f64::from(rate),
            spacing,
            middle: [x, y, z],
            half_fov,
            size,
            layout,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 160,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x5eed_0121),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn bands_and_runs_are_the_formulas(
        seen in any_seen(), seed: u32, rows in 1u32..9, lit: bool, run in 1u32..8,
    ) {
        let found = seen.splatting();
        // Small images of what is far away or too near, and nothing else, are refused; and are not counted.
        if let Err(error) = found {
            prop_assert!(
                matches!(error, SplatError::Crowded { .. } | SplatError::Nothing | SplatError::Slopes),
                "{error}"
            );
        }
        prop_assume!(found.is_ok());
        let splatting = found.unwrap();
        let voxels = noise(splatting.dims(), seed);
        let [width, height] = splatting.size();
        let wanted: Vec<i32> = (sums(&splatting, &voxels).into_iter().enumerate())
            .map(|(at, [weights, values])| {
                assert!(weights < 1 << 26 && values < 1 << 38);
                let sheet = at as u32 / (width * height);
                if weights < u128::from(splatting.least(sheet)) {
                    MISSING
                } else {
                    (((values << 15) + weights / 2).checked_div(weights)).map_or(MISSING, |sample| sample as i32)
                }
            })
            .collect();
        let found = samples(&splatting, &voxels, Bands::new(rows, lit), run, None);
        prop_assert!(wanted == found);
    }

    /// Records lie where division without rounding has them.
    #[test]
    fn places_are_as_near_as_stated(seen in any_seen(), far in 1.0..400.0f64) {
        let seen = Seen {
            middle: [seen.middle[0] * far / 8.0, seen.middle[1] * far / 8.0, far],
            layout: Layout::new(13, 8, 8).unwrap(),
            size: [700, 500],
            ..seen
        };
        let found = seen.splatting();
        prop_assume!(found.is_ok());
        let splatting = found.unwrap();
        let distance = f64::from(eye_distance(&splatting)) / 65536.0;
        let [nx, ny, nz] = splatting.dims();
        for (i, j, k) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j, k)))) {
            let place = splatting.place([i, j, k]);
            let Some(found) = splatting.eye().unwrap().project(place, 13) else { continue };
            let margin = splatting.eye().unwrap().margin();
            for axis in 0..2 {
                let beside = distance * (place[axis] as f64 / place[2] as f64);
                let exact = beside + (f64::from(splatting.size()[axis]) - 1.0) / 2.0 + f64::from(margin[axis]);
                let most = (1.04 * distance + 1.5 * beside.abs()) / 1073741824.0 + 0.5 / 8192.0 + 1e-9;
                prop_assert!((f64::from(found[axis]) / 8192.0 - exact).abs() <= most);
            }
        }
    }

    /// Every visible sample is there with the same bits, and so are its neighbours.
    #[test]
    fn what_is_left_out_is_not_seen(
        angles in prop::array::uniform2(-3.2..3.2f64), z in 6.0..60.0f64, half_fov in 8.0..50.0f64, seed: u32,
    ) {
        let seen = Seen { dims: [33, 30, 29], angles, middle: [2.0, -3.0, z], half_fov, size: [40, 36], ..PLAIN };
        let found = seen.splatting();
        prop_assume!(found.is_ok());
        let splatting = found.unwrap();
        let mut voxels = noise(splatting.dims(), seed);
        voxels.iter_mut().for_each(|code| *code >>= 2);
        let inside = |seed: u32| (0..3).fold(0, |at, axis| 30 * at + (4 + (seed >> (8 * axis)) % 21) as usize);
        let spots = [inside(seed), inside(seed.rotate_left(13))].map(|at| at % 30 + 33 * (at / 30));
        spots.iter().for_each(|at| voxels[*at] = 4095);
        let support = Support::of((0..4096).map(|code| code >= 1088));
        let blocks = needed(&splatting, &voxels, support);
        let bands = Bands::new(16, true);
        let all = samples(&splatting, &voxels, bands, 40, None);
        let some = samples(&splatting, &voxels, bands, 40, Some(&blocks));
        let [width, height] = splatting.size().map(|side| side as usize);
        for (at, sample) in all.iter().enumerate().skip(width * height * splatting.first_sheet() as usize) {
            if *sample <= 1087 << 15 {
                prop_assert!(some[at] <= 1087 << 15);
                continue;
            }
            let (column, row, sheet) = (at % width, at / width % height, at / width / height);
            let about = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then_some(at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < height).then_some(at + width),
                (sheet > splatting.first_sheet() as usize).then(|| at - width * height),
                (sheet + 1 < splatting.sheets() as usize).then_some(at + width * height),
                Some(at),
            ];
            for at in about.into_iter().flatten() {
                prop_assert_eq!(all[at], some[at]);
            }
        }
    }
}

/// Within, weights add up to what is said; so a homogeneous volume has samples of its value all through the middle.
#[test]
fn homogeneous_volumes_stay_so() {
    for (z, half_fov) in [(20.0, 20.0), (40.0, 14.0), (0.0, 30.0), (0.0, 60.0)] {
        for rate in [1.0, 2.0] {
            let seen = Seen {
                dims: [25; 3],
                middle: [0.0, 0.0, z],
                half_fov,
                rate,
                size: [32, 32],
                ..PLAIN
            };
            let splatting = seen.splatting().unwrap();
            let found = samples(&splatting, &vec![2000; 25 * 25 * 25], Bands::new(8, false), 25, None);
            assert!(found.iter().all(|s| *s == MISSING || *s == 2000 << 15));
            // The ray in the middle meets the cube over 25 voxels at least, of which the eye within does not see the first ones.
            let middle = (0..splatting.sheets()).filter(|sheet| {
                *sheet >= splatting.first_sheet() && found[(sheet * 1024 + 16 * 32 + 16) as usize] != MISSING
            });
            let count = middle.count() as f64 / rate;
            let [least, most] = if z > 0.0 { [24.0, 36.0] } else { [7.0, 16.0] };
            assert!((least..=most).contains(&count), "{count} at {z}, {half_fov}, {rate}");
        }
    }
}

/// From afar places are those of a parallel view, and so are sums but for what a kernel is scaled by.
#[test]
fn from_afar_rays_are_parallel() {
    let far = 30000.0;
    let half_fov = (4.5f64 / far).atan().to_degrees();
    let seen = Seen {
        angles: [0.0; 2],
        middle: [0.0, 0.0, far],
        half_fov,
        size: [9; 2],
        ..PLAIN
    };
    let splatting = seen.splatting().unwrap();
    let voxels: Vec<u16> = noise([9; 3], 77).into_iter().map(|code| code >> 1).collect();
    let found = samples(&splatting, &voxels, Bands::new(9, true), 9, None);
    let identity = [0, 1, 2].map(|m| [0, 1, 2].map(|axis| step(f64::from(u8::from(m == axis)))));
    let parallel = Splatting::new([9; 3], [step(0.0); 2], identity, [9; 2], Layout::FINE).unwrap();
    // The same signs of the axes as a turn by nothing.
    let wanted = samples(&parallel, &voxels, Bands::new(9, true), 9, None);
    let mut both = 0;
    for (a, b) in found.iter().zip(&wanted) {
        if *a != MISSING && *b != MISSING {
            both += 1;
            assert!((a - b).abs() < 12 << 15, "{a} {b}");
        }
    }
    assert!(both > 500, "{both}");
}

#[test]
fn rays_are_close() {
    let seen = Seen {
        half_fov: 60.0,
        size: [90, 60],
        middle: [0.0, 0.0, 8.0],
        ..PLAIN
    };
    let splatting = seen.splatting().unwrap();
    let eye = splatting.eye().unwrap();
    let mut memory = vec![0; Rays::len([90, 60], 60, true)];
    let rays = Rays::make::<i32>(eye, (0, 60), true, &mut memory);
    let distance = f64::from(eye_distance(&splatting)) / 65536.0;
    for (row, column) in (0..60).flat_map(|row| (0..90).map(move |column| (row, column))) {
        let x = (f64::from(column) - 44.5) / distance;
        let y = (f64::from(row) - 29.5) / distance;
        let length = (1.0 + x * x + y * y).sqrt();
        let at = column as usize;
        assert!((f64::from(eye.slope(0, column)) / 134217728.0 - x).abs() < 2e-8);
        // The root is cut off below 2^-20 of itself, and so is the length.
        assert!((f64::from(rays.lengths(row)[at]) / 1048576.0 - length).abs() < (length + 1.0) / 1048576.0 + 2e-8);
        for (found, wanted) in rays.towards(row).into_iter().zip([-x, -y, -1.0]) {
            assert!((f64::from(found[at]) / 1073741824.0 - wanted / length).abs() < 1.8e-6);
        }
        // What rises by 100 a sheet along z and by 20 and -7 along x and y.
        let along = 100.0 + 20.0 * x - 7.0 * y;
        let slopes = [eye.slope(0, column), eye.slope(1, row)];
        let found = tilted([20 << 15, -7 << 15, (along * 32768.0).round() as i32], 1 << 27, slopes);
        assert!((f64::from(found) / 32768.0 - 100.0).abs() < 1e-4);
        // From sheets that are ten times as far apart as pixels.
        let found = tilted(
            [20 << 15, -7 << 15, (along * 327680.0).round() as i32],
            13421773,
            slopes,
        );
        assert!((f64::from(found) / 32768.0 - 100.0).abs() < 1e-4);
    }
    assert_eq!(
        tilted([1 << 28, 1 << 28, 1 << 28], 1 << 27, [-(3 << 27), (-4 << 27) + 1]),
        i32::MAX - 1
    );
}

#[test]
fn what_is_out_of_range_is_named() {
    let of = |seen: Seen| seen.splatting().map(|_| ());
    assert!(of(PLAIN).is_ok());
    let axes = [0, 1, 2].map(|m| [0, 1, 2].map(|axis| step(f64::from(u8::from(m == axis)))));
    for dims in [[0, 1, 1], [1, 1, 8193]] {
        let found = Splatting::from_eye(
            dims,
            [step(0.0), step(0.0), step(9.0)],
            axes,
            (1 << 20, [4; 2]),
            Layout::FINE,
        );
        assert_eq!(found, Err(SplatError::Sides { dims }));
    }
    assert!(matches!(
        of(Seen {
            half_fov: 1e-4,
            ..PLAIN
        }),
        Err(SplatError::Distance { .. })
    ));
    assert!(matches!(
        of(Seen {
            half_fov: 89.9,
            ..PLAIN
        }),
        Err(SplatError::Distance { .. })
    ));
    let middle = [0.0, 0.0, 1e8];
    assert!(matches!(of(Seen { middle, ..PLAIN }), Err(SplatError::Far)));
    let middle = [0.0, 0.0, -20.0];
    assert_eq!(of(Seen { middle, ..PLAIN }), Err(SplatError::Nothing));
    assert!(matches!(of(Seen { rate: 0.5, ..PLAIN }), Err(SplatError::Width { .. })));
    assert!(matches!(
        of(Seen { size: [0, 4], ..PLAIN }),
        Err(SplatError::Image { .. })
    ));
    assert!(matches!(
        of(Seen {
            size: [2048, 4],
            ..PLAIN
        }),
        Err(SplatError::Image { .. })
    ));
    assert_eq!(
        of(Seen {
            half_fov: 60.0,
            size: [240, 90],
            ..PLAIN
        }),
        Err(SplatError::Slopes)
    );
    // Pixels far wider than voxels.
    assert!(matches!(
        of(Seen { size: [4; 2], ..PLAIN }),
        Err(SplatError::Crowded { .. })
    ));
    let mut flat = axes;
    flat[1] = [step(1.0), step(0.0), step(1.0)];
    flat[0] = [step(1.0), step(1.0), step(0.0)];
    flat[2] = [step(2.0), step(1.0), step(1.0)];
    let found = Splatting::from_eye(
        [4; 3],
        [step(0.0), step(0.0), step(9.0)],
        flat,
        (1 << 20, [4; 2]),
        Layout::FINE,
    );
    assert_eq!(found, Err(SplatError::Flat));
}

/// Cubes at all turns are taken, of square images of up to 120 degrees whose pixels in the farthest sheet are voxels, whatever the rate.
#[test]
fn cubes_are_never_crowded() {
    for (a, b) in (0..24).flat_map(|a| (0..24).map(move |b| (a, b))) {
        for (half_fov, rate) in [(20.0f64, 1.0), (60.0, 1.0), (60.0, 3.0), (60.0, 16.0)] {
            let middle = [0.0, 0.0, 24.0];
            let pixels = (2.0 * (24.0 + 3.0f64.sqrt()) * half_fov.to_radians().tan()).ceil() as u32;
            let seen = Seen {
                dims: [3; 3],
                angles: [f64::from(a) * 0.14, f64::from(b) * 0.14],
                rate,
                middle,
                half_fov,
                size: [pixels; 2],
                ..PLAIN
            };
            assert!(seen.splatting().is_ok(), "{:?}", seen.splatting());
        }
    }
}
