//! Splatting against its formulas: sums in 128 bits without bins, bands or rings; closed forms; what is left out.

use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::kernel::{integral, spline};
use super::*;
use crate::classify::Support;
use crate::format::Intensity;
use crate::slice::RowRange;

/// s31.32.
pub(super) fn step(c: f64) -> Step {
    Step::from_bits((c * 4294967296.0).round() as i64)
}

/// A volume of these sides seen along a turned axis, in the middle of an image that holds it.
fn turned(dims: [u32; 3], [a, b]: [f64; 2], rates: [f64; 2], spacing: [f64; 3], layout: Layout) -> Splatting {
    let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
    let rows = [[ca, sa, 0.0], [-sa * cb, ca * cb, sb], [sa * sb, -ca * sb, cb]];
    let scale = [rates[0], rates[0], rates[1]];
    let steps = [0, 1, 2].map(|m| [0, 1, 2].map(|axis| rows[axis][m] * spacing[m] * scale[axis]));
    let half = [0, 1].map(|axis| -> f64 {
        (0..3)
            .map(|m| steps[m][axis].abs() * f64::from(dims[m] - 1) / 2.0)
            .sum()
    });
    let size = half.map(|half| (2.0 * half).ceil() as u32 + 1);
    let origin = [0, 1].map(|axis| {
        let middle: f64 = (0..3).map(|m| steps[m][axis] * f64::from(dims[m] - 1) / 2.0).sum();
        step((f64::from(size[axis]) - 1.0) / 2.0 - middle)
    });
    Splatting::new(dims, origin, steps.map(|s| s.map(step)), size, layout).unwrap()
}

/// Sums of weights and of weights times values of each sheet's pixels, voxel by voxel from the formulas.
fn sums(splatting: &Splatting, voxels: &[u16]) -> Vec<[u128; 2]> {
    let memory = kernel_of(splatting);
    let kernel = Kernel::of(splatting, &memory).unwrap();
    let ([width, height], [nx, ny, nz]) = (splatting.size(), splatting.dims());
    let mut sums = vec![[0; 2]; (width * height * splatting.sheets()) as usize];
    let layout = splatting.layout();
    let [mx, my] = splatting.margin.map(i64::from);
    for (number, &code) in voxels.iter().enumerate() {
        let number = number as u32;
        let [x, y, z] = splatting.place([number % nx, number / nx % ny, number / (nx * ny)]);
        assert!(number < nx * ny * nz);
        let near = |c: i64, bits: u32| (i128::from(c) * (1 << bits) + (1 << 31)).div_euclid(1 << 32) as i64;
        let [x, y] = [x, y].map(|c| near(c, layout.position_bits()) << (13 - layout.position_bits()));
        let q = near(z, layout.depth_bits());
        let u = q.rem_euclid(1 << layout.depth_bits()) as u32;
        let value = layout.code(layout.stored(code));
        for (j, &slab) in kernel.slabs(u).iter().enumerate() {
            let sheet = (q >> layout.depth_bits()) + j as i64;
            for row in 0..i64::from(height) {
                for column in 0..i64::from(width) {
                    let [dx, dy] = [((column + mx) << 13) - x, ((row + my) << 13) - y].map(|d| d.unsigned_abs() as u32);
                    if dx > 40 << 13 || dy > 40 << 13 {
                        continue;
                    }
                    let weight = u128::from(product(slab, kernel.weight(1, dy), kernel.weight(0, dx)));
                    let at = (sheet * i64::from(height) + row) * i64::from(width) + column;
                    let [weights, values] = &mut sums[at as usize];
                    *weights += weight;
                    *values += weight * u128::from(value);
                }
            }
        }
    }
    sums
}

pub(super) fn kernel_of(splatting: &Splatting) -> Vec<u32> {
    let mut memory = vec![0; Kernel::len(splatting)];
    Kernel::fill(splatting, &mut memory).unwrap();
    memory
}

/// Blocks that a support needs; the voxels' ranges in the order of layers.
pub(super) fn needed(splatting: &Splatting, voxels: &[u16], support: Support) -> Vec<u8> {
    let [width, height, depth] = splatting.dims();
    let layer_len = width.div_ceil(BLOCK) * height.div_ceil(BLOCK);
    let mut ranges = vec![RowRange::EMPTY; Needed::len(splatting)];
    for (first, ranges) in (0..depth).step_by(4).zip(ranges.chunks_mut(layer_len as usize)) {
        let end = (first + BLOCK).min(depth);
        let slices = &voxels[(first * width * height) as usize..(end * width * height) as usize];
        let slices = Voxels::new(splatting, first..end, slices).unwrap();
        measure_layer(splatting, &slices, ranges).unwrap();
    }
    let mut blocks = vec![0; ranges.len()];
    Needed::find(splatting, &ranges, support, &mut blocks).unwrap();
    blocks
}

/// Samples of all sheets, in bands, of voxels binned in runs of slices; of blocks that are needed.
pub(super) fn samples(
    splatting: &Splatting,
    voxels: &[u16],
    bands: Bands,
    run: u32,
    blocks: Option<&[u8]>,
) -> Vec<i32> {
    let memory = kernel_of(splatting);
    let kernel = Kernel::of(splatting, &memory).unwrap();
    let ([width, height], [nx, ny, nz]) = (splatting.size(), splatting.dims());
    let needed = blocks.map(|blocks| Needed::of_blocks(splatting, blocks));
    let mut memories: Vec<_> = (0..nz)
        .step_by(run as usize)
        .map(|first| {
            let end = (first + run).min(nz);
            let slices = &voxels[(first * nx * ny) as usize..(end * nx * ny) as usize];
            let slices = Voxels::new(splatting, first..end, slices).unwrap();
            let mut starts = vec![0; Bins::len(splatting, bands)];
            let count = Bins::count(splatting, bands, &slices, needed.as_ref(), &mut starts).unwrap();
            (slices, starts, vec![0; count])
        })
        .collect();
    let bins: Vec<_> = memories
        .iter_mut()
        .map(|(slices, starts, records)| {
            Bins::fill(splatting, bands, slices, needed.as_ref(), starts, records).unwrap()
        })
        .collect();
    let mut out = vec![MISSING; (width * height * splatting.sheets()) as usize];
    for band in 0..bands.count(splatting) {
        let (first, rows) = bands.rows(splatting, band);
        let [of_sums, of_samples] = Sheets::len(splatting, bands.most(), true);
        let (mut sums, mut kept) = (vec![7; of_sums], vec![7; of_samples]);
        let mut sheets = Sheets::new(splatting, kernel, (first, rows), true, &mut sums, &mut kept).unwrap();
        for number in 0..splatting.sheets() {
            bins.iter()
                .for_each(|bins| sheets.add::<i32>(number, bins.records(band, number)));
            sheets.settle(number, 15);
            let sheet = sheets.sheet(number, [Intensity::ONE; 3], None);
            for row in first..first + rows {
                let start = ((number * height + row) * width) as usize;
                for (out, &sample) in out[start..].iter_mut().zip(sheet.row(1, row.into())) {
                    *out = sample;
                }
            }
        }
    }
    out
}

pub(super) fn noise(dims: [u32; 3], seed: u32) -> Vec<u16> {
    let mut state = seed | 1;
    let next = |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 20) as u16
    };
    (0..dims.iter().product::<u32>()).map(next).collect()
}

fn any_splatting() -> impl Strategy<Value = Splatting> {
    let angles = prop::array::uniform2(-3.2..3.2f64);
    let rates = ((1u32..=3), (1u32..=3)).prop_map(|(n, r)| [f64::from(n), f64::from(r)]);
    let spacing = prop::array::uniform3(prop::sample::select(vec![1.0, 1.0, 1.5, 2.0]));
    let layout = (6u32..=13, 1u32..=10, 4u32..=12).prop_map(|(f, u, v)| Layout::new(f, u, v).unwrap_or(Layout::FINE));
    (prop::array::uniform3(1u32..=7), angles, rates, spacing, layout)
        .prop_map(|(dims, angles, rates, spacing, layout)| turned(dims, angles, rates, spacing, layout))
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 60,
        rng_seed: proptest::test_runner::RngSeed::Fixed(0x5eed_0021),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn bands_and_runs_are_the_formulas(
        splatting in any_splatting(), seed: u32, rows in 1u32..9, lit: bool, run in 1u32..8,
    ) {
        let voxels = noise(splatting.dims(), seed);
        let wanted: Vec<i32> = sums(&splatting, &voxels)
            .into_iter()
            .map(|[weights, values]| {
                assert!(weights < 1 << 26 && values < 1 << 38);
                if weights < u128::from(splatting.least(0)) {
                    MISSING
                } else {
                    (((values << 15) + weights / 2) / weights) as i32
                }
            })
            .collect();
        let found = samples(&splatting, &voxels, Bands::new(rows, lit), run, None);
        prop_assert!(wanted == found);
        prop_assert!(found.iter().all(|s| *s == MISSING || (0..=4095 << 15).contains(s)));
    }

    /// Every visible sample is there with the same bits, and so are its neighbours.
    #[test]
    fn what_is_left_out_is_not_seen(
        angles in prop::array::uniform2(-3.2..3.2f64), spacing in prop::sample::select(vec![1.0, 1.5]), seed: u32,
        layout in prop::sample::select(vec![Layout::FINE, Layout::PAPER]),
    ) {
        let splatting = turned([33, 30, 29], angles, [1.0, 1.0], [1.0, 1.0, spacing], layout);
        // Two spots in faint noise, and a half of codes that 8 bits bring over the edge of what is seen.
        let mut voxels = noise(splatting.dims(), seed);
        voxels.iter_mut().for_each(|code| *code >>= 2);
        if seed & 1 == 1 {
            voxels.iter_mut().take(33 * 30 * 8).for_each(|code| *code = 1087);
        }
        let inside = |seed: u32| (0..3).fold(0, |at, axis| 30 * at + (4 + (seed >> (8 * axis)) % 21) as usize);
        let spots = [inside(seed), inside(seed.rotate_left(13))].map(|at| at % 30 + 33 * (at / 30));
        spots.iter().for_each(|at| voxels[*at] = 4095);
        let support = Support::of((0..4096).map(|code| code >= 1088));
        let blocks = needed(&splatting, &voxels, support);
        let left = Needed::of_blocks(&splatting, &blocks).count();
        prop_assert!(left > 0 && left < blocks.len());
        let bands = Bands::new(16, true);
        let all = samples(&splatting, &voxels, bands, 40, None);
        let some = samples(&splatting, &voxels, bands, 40, Some(&blocks));
        let ([width, height], mut seen) = (splatting.size().map(|side| side as usize), 0);
        for (at, sample) in all.iter().enumerate() {
            if *sample <= 1087 << 15 {
                prop_assert!(some[at] <= 1087 << 15);
                continue;
            }
            seen += 1;
            let (column, row, sheet) = (at % width, at / width % height, at / width / height);
            let sheets = all.len() / width / height;
            let about = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then_some(at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < height).then_some(at + width),
                (sheet > 0).then(|| at - width * height),
                (sheet + 1 < sheets).then_some(at + width * height),
                Some(at),
            ];
            for at in about.into_iter().flatten() {
                prop_assert_eq!(all[at], some[at]);
            }
        }
prop_assert!(seen > 0);
    }
}

#[test]
fn homogeneous_volumes_stay_so() {
    for code in [1, 2000, 4095] {
        for (angles, [n, r]) in [
            ([0.0, 0.0], [1, 1]),
            ([0.3, 0.7], [1, 1]),
            ([0.785, 0.615], [1, 1]),
            ([0.3, 0.7], [2, 1]),
            ([0.3, 0.7], [1, 3]),
            ([0.0, 0.0], [3, 2]),
        ] {
            let splatting = turned([12; 3], angles, [f64::from(n), f64::from(r)], [1.0; 3], Layout::FINE);
            let found = samples(&splatting, &vec![code; 12 * 12 * 12], Bands::new(8, false), 12, None);
            assert!(found.iter().all(|s| *s == MISSING || *s == i32::from(code) << 15));
            // As many as there are voxels, but for the borders.
            let count = found.iter().filter(|s| **s != MISSING).count() as u32 / (n * n * r);
            assert!((1200..=1950).contains(&count), "{count} at {angles:?}, {n} {r}");
        }
    }
}

/// Along an axis kernels add up to 1, and a ramp stays one.
#[test]
fn along_an_axis_ramps_stay_ramps() {
    let splatting = turned([12; 3], [0.0, 0.0], [1.0, 1.0], [1.0; 3], Layout::FINE);
    assert_eq!(splatting.least(0), 1 << 17);
    let voxels: Vec<u16> = (0..12 * 12 * 12).map(|at: usize| 300 * (at % 12) as u16).collect();
    let found = samples(&splatting, &voxels, Bands::new(32, false), 12, None);
    let [width, height] = splatting.size().map(|side| side as usize);
    assert_eq!([width, height], [12, 12]);
    let mut seen = 0;
    for (at, sample) in found.iter().enumerate().filter(|(_, s)| **s != MISSING) {
        let column = at % width;
        if (1..11).contains(&column) {
            assert!(
                (sample - ((300 * column as i32) << 15)).abs() <= 300 << 3,
                "{column}: {sample}"
            );
            seen += 1;
        }
    }
    assert!(seen >= 10 * 10 * 12, "{seen}");
}

/// A voxel alone makes no place gather half of what it does within, so that it has no sample; in an empty volume it is spread by the
/// kernel's own values: 3/4 along x and y, and of a sheet 2/3.
#[test]
fn one_voxel_is_its_kernel() {
    let alone = turned([1; 3], [0.4, 0.2], [1.0, 1.0], [1.0; 3], Layout::FINE);
    let found = samples(&alone, &[3000], Bands::new(8, true), 1, None);
    assert!(found.iter().all(|s| *s == MISSING));
    let splatting = turned([9; 3], [0.0, 0.0], [1.0, 1.0], [1.0; 3], Layout::FINE);
    let mut voxels = vec![0; 729];
    voxels[4 + 9 * (4 + 9 * 4)] = 4000;
    let found = samples(&splatting, &voxels, Bands::new(4, true), 9, None);
    let seen: Vec<(usize, i32)> = (found.iter().copied().enumerate()).filter(|(_, s)| *s > 0).collect();
    // The middle and its neighbours along each axis: 3 x 3 pixels of 3 sheets.
    assert_eq!(seen.len(), 27);
    let (at, most) = seen.iter().copied().max_by_key(|(_, s)| *s).unwrap();
    assert_eq!([at % 9, at / 9 % 9], [4, 4]);
    let exact = 4000.0 * 0.75 * 0.75 * 2.0 / 3.0;
    assert!((f64::from(most) / 32768.0 - exact).abs() < 0.1, "{most}");
    let sum: f64 = seen.iter().map(|(_, s)| f64::from(*s) / 32768.0).sum();
    assert!((sum - 4000.0).abs() < 1.0, "{sum}");
}

#[test]
fn the_kernel_is_the_spline() {
    for number in 0..=40_000u64 {
        let t = number << 16;
        let x = t as f64 / 1073741824.0;
        let (b, a) = if x < 0.5 {
            (0.75 - x * x, 0.75 * x - x.powi(3) / 3.0)
        } else if x < 1.5 {
            ((1.5 - x).powi(2) / 2.0, 0.5 - (1.5 - x).powi(3) / 6.0)
        } else {
            (0.0, 0.5)
        };
        assert!((spline(t) as f64 / 1073741824.0 - b).abs() < 3e-9);
        assert!((integral(t) as f64 / 1073741824.0 - a).abs() < 3e-9);
    }
    for rate in [1.0, 3.0, 16.0] {
        let splatting = turned([4; 3], [0.3, 0.2], [1.0, rate], [1.0; 3], Layout::FINE);
        let memory = kernel_of(&splatting);
        let kernel = Kernel::of(&splatting, &memory).unwrap();
        for u in 0..256 {
            let slabs = kernel.slabs(u);
            assert_eq!(slabs.len(), splatting.reached() as usize);
            // Each is rounded for itself.
            let sum: u32 = slabs.iter().sum();
            assert!(
                sum.abs_diff(splatting.widths()[2]) <= slabs.len() as u32 / 2 + 1,
                "{u}: {sum}"
            );
            assert!(slabs.iter().all(|slab| *slab <= 49152));
        }
        assert_eq!(kernel.weight(0, 0), 49152);
        for distance in 0..3 << 13 {
            let t = f64::from(distance) / 8192.0 / (f64::from(splatting.widths()[0]) / 65536.0);
            let exact = spline((t * 1073741824.0) as u64) as f64 / 32768.0;
            // Between nodes the chord of a parabola: h^2 / 8, h of 1/128.
            assert!(
                (f64::from(kernel.weight(0, distance)) / 2.0 - exact).abs() < 1.3,
                "{distance}"
            );
        }
    }
}

#[test]
fn records_keep_what_they_hold() {
    for layout in [
        Layout::PAPER,
        Layout::FINE,
        Layout::new(6, 10, 4).unwrap(),
        Layout::new(12, 10, 8).unwrap(),
    ] {
        let last = (PIXELS << layout.position_bits()) - 1;
        for (x, y) in [(0, last), (last, 0), (12_345, 54_321)] {
            for u in [0, (1 << layout.depth_bits()) - 1] {
                for code in 0..=4095u16 {
                    let ([a, b], c, value) = layout.unpack(layout.pack([x, y], u, code));
                    assert_eq!([a, b, c], [x, y, u]);
                    // Half a step, rounded to a code.
                    let step = 4095.0 / f64::from((1u32 << layout.value_bits()) - 1);
                    let most = if layout.value_bits() == 12 {
                        0.0
                    } else {
                        step / 2.0 + 0.5
                    };
                    assert!((f64::from(value) - f64::from(code)).abs() <= most && value <= 4095);
                }
            }
        }
        assert_eq!(layout.code(layout.stored(4095)), 4095);
        assert_eq!(layout.code(layout.stored(0)), 0);
    }
    let [x, u, y, v] = [3u64, 1, 2, 255];
    assert_eq!(Layout::PAPER.pack([3, 2], 1, 4095), x << 40 | u << 32 | y << 8 | v);
    for (f, u, v) in [
        (5, 8, 8),
        (14, 8, 8),
        (13, 8, 9),
        (11, 0, 12),
        (11, 11, 4),
        (11, 8, 3),
        (11, 8, 13),
    ] {
        assert!(
            matches!(Layout::new(f, u, v), Err(SplatError::Layout { .. })),
            "{f} {u} {v}"
        );
    }
}

#[test]
fn what_is_out_of_range_is_named() {
    let axes = |x: f64, y: f64, z: f64| {
        [
            [step(x), step(0.0), step(0.0)],
            [step(0.0), step(y), step(0.0)],
            [step(0.0), step(0.0), step(z)],
        ]
    };
    let of = |dims, steps, size| Splatting::new(dims, [step(0.0); 2], steps, size, Layout::FINE);
    assert!(matches!(
        of([0, 1, 1], axes(1.0, 1.0, 1.0), [4; 2]),
        Err(SplatError::Sides { .. })
    ));
    assert!(matches!(
        of([8193, 1, 1], axes(1.0, 1.0, 1.0), [4; 2]),
        Err(SplatError::Sides { .. })
    ));
    assert!(matches!(
        of([4; 3], axes(0.5, 1.0, 1.0), [4; 2]),
        Err(SplatError::Width { .. })
    ));
    assert!(matches!(
        of([4; 3], axes(1.0, 33.0, 1.0), [4; 2]),
        Err(SplatError::Width { .. })
    ));
    assert!(matches!(
        of([4; 3], axes(1.0, 1.0, 1.0), [0, 4]),
        Err(SplatError::Image { .. })
    ));
    assert!(matches!(
        of([4; 3], axes(1.0, 1.0, 1.0), [2043, 4]),
        Err(SplatError::Image { .. })
    ));
    assert!(of([4; 3], axes(1.0, 1.0, 1.0), [2042, 4]).is_ok());
    let flat = [
        [step(1.0), step(1.0), step(0.0)],
        [step(1.0), step(1.0), step(0.0)],
        [step(0.0), step(0.0), step(1.0)],
    ];
    assert_eq!(of([4; 3], flat, [4; 2]), Err(SplatError::Flat));
    // A lattice that is nearly flat.
    let mut thin = flat;
    thin[1][0] = step(1.01);
    assert!(matches!(of([4; 3], thin, [4; 2]), Err(SplatError::Crowded { .. })));
    let splatting = of([4; 3], axes(1.0, 1.0, 1.0), [4; 2]).unwrap();
    assert!(matches!(
        Voxels::new(&splatting, 0..4, &[0; 63]),
        Err(SplatError::Memory { needed: 64, given: 63 })
    ));
    let mut voxels = [0; 64];
    voxels[9] = 4096;
    assert!(matches!(
        Voxels::new(&splatting, 0..4, &voxels),
        Err(SplatError::Value { value: 4096 })
    ));
    assert!(matches!(
        Kernel::of(&splatting, &[0; 4]),
        Err(SplatError::Memory { .. })
    ));
}

/// All turns of cubic lattices are taken, whatever the rates.
#[test]
fn cubes_are_never_crowded() {
    for (a, b) in (0..24).flat_map(|a| (0..24).map(move |b| (a, b))) {
        for rates in [[1.0, 1.0], [8.0, 1.0], [1.0, 16.0], [8.0, 16.0]] {
            turned(
                [3; 3],
                [f64::from(a) * 0.14, f64::from(b) * 0.14],
                rates,
                [1.0; 3],
                Layout::FINE,
            );
        }
    }
}

#[test]
fn slopes_look_at_what_there_is() {
    assert_eq!(slope(1, 5, 11), 10);
    assert_eq!(slope(MISSING, 5, 11), 12);
    assert_eq!(slope(1, 5, MISSING), 8);
    assert_eq!(slope(MISSING, 5, MISSING), 0);
    assert_eq!(slope(1, MISSING, 11), 10);
    assert_eq!(slope(MISSING, MISSING, 11) | slope(1, MISSING, MISSING), 0);
    assert_eq!(sample(0, 1, 15), MISSING);
    assert_eq!(sample((100 << 38) | (100 * 4095), 100, 15), 4095 << 15);
    assert_eq!(sample((99 << 38) | (99 * 4095), 100, 15), MISSING);
}
