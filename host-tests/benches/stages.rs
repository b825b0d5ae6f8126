//! Throughput of each stage's row kernel (256 samples) and of the whole pipeline (128^3 synthetic volume), in samples.
//! Nothing is asserted: times are for people to read.

use std::hint::black_box;
use std::sync::Arc;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use slicecast::classify::{Classifier, ENTRIES, Linear, Nearest, PointTable, Sqrt8, Sqrt16};
use slicecast::composite::{Channel, Dither, FrontToBack, PixelRow, Recurrence, fold_row};
use slicecast::format::{Coefficient, Intensity, Vector, Weight};
use slicecast::gradient::{difference_row, space_row};
use slicecast::interpolate::{yx_row, z_row};
use slicecast::normalise::normalise_row;
use slicecast::plan::Plan;
use slicecast::plane::Pipeline;
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Highlight, Light, Shader};
use slicecast::slice::Slice;
use slicecast_host_tests::frame::{Frame, table_of};
use slicecast_host_tests::random::{Filling, Random, volume};
use slicecast_sim::camera::Material;
use slicecast_sim::engine::{fold_tiles, new_image, on_threads};
use slicecast_sim::pipelines::Job;
use slicecast_sim::scene::PrecisionName;
use slicecast_sim::simd::Simd;

const WIDTH: usize = 256;

fn row(random: &mut Random, end: u32) -> Vec<i32> {
    (0..WIDTH).map(|_| random.below(end) as i32).collect()
}

fn lights() -> Material {
    let light = Light {
        direction: [-16_384, -16_384, -23_170].map(|c| Vector::from_bits(c << 15)),
        half: [-8_867, -8_867, -30_273].map(|c| Vector::from_bits(c << 15)),
        diffuse: [Coefficient::from_bits(20_000 << 16); 3],
        specular: [Coefficient::from_bits(6_000 << 16); 3],
    };
    let viewer = [0, 0, -32_768].map(|c| Vector::from_bits(c << 15));
    Material {
        ambient: [Coefficient::from_bits(5_000 << 16); 3],
        lights: vec![light],
        viewer,
        highlight: Highlight::Reflection,
        exponent_log2: 5,
    }
}

/// The kernels whose arithmetic depends on the precision.
fn kernels<P: Precision>(group: &mut BenchmarkGroup<'_, WallTime>) {
    let random = &mut Random::new(1);
    let voxels = || volume([WIDTH, 4, 1], Filling::Noise, 2).voxels;
    let (near, far) = (voxels(), voxels());
    let weight = Weight::from_bits(21_845);
    let name = |stage: &str| format!("{stage}/{}", P::NAME);
    let mut out = vec![0; WIDTH];
    group.bench_function(name("interpolate-z"), |b| {
        b.iter(|| {
            z_row::<P, i32>(
                black_box(&near[..WIDTH]),
                black_box(&far[..WIDTH]),
                weight,
                black_box(&mut out),
            )
        });
    });
    let (a, b16) = (row(random, 4095 << 16), row(random, 4095 << 16));
    group.bench_function(name("interpolate-yx"), |b| {
        b.iter(|| {
            yx_row::<P, i32>(
                black_box(&a),
                black_box(&b16),
                false,
                [weight, weight],
                black_box(&mut out),
            )
        });
    });

    let samples = row(random, 4095 << P::SAMPLE_BITS);
    let entries: Box<[u32; ENTRIES]> = Box::new(std::array::from_fn(|_| random.next_bits() as u32));
    let plane: Box<[u8; ENTRIES]> = Box::new(std::array::from_fn(|_| random.next_bits() as u8));
    let mut colours = [(); 3].map(|()| vec![0; WIDTH]);
    classify::<P>(
        group,
        "nearest-8",
        &PointTable::<Sqrt8, Nearest>::new(&entries, ()),
        &samples,
    );
    classify::<P>(
        group,
        "linear-16",
        &PointTable::<Sqrt16, Linear>::new(&entries, &plane),
        &samples,
    );

    let g = [(); 3].map(|()| row(random, 1 << 28));
    let mut normals = g.clone();
    let mut r = vec![0; WIDTH];
    {
        let [x, y, z] = &mut normals;
        normalise_row::<i32>([x, y, z], &mut r);
    }
    let phong = lights().phong::<P>().expect("one light");
    group.bench_function(name("shade"), |b| {
        let [x, y, z] = &normals;
        let [cr, cg, cb] = &mut colours;
        b.iter(|| {
            let colours = [&mut cr[..], &mut cg[..], &mut cb[..]];
            Shader::shade_row::<i32>(
                &phong,
                [black_box(x), black_box(y), black_box(z)],
                black_box(&r),
                colours,
            );
        });
    });

    let colours = [(); 3].map(|()| row(random, 1 << P::COLOUR_BITS));
    let opacities = row(random, 1 << 24);
    let mut pixels = vec![<P::Pixel as Recurrence>::Channel::default(); 4 * WIDTH];
    group.bench_function(name("composite"), |b| {
        let [cr, cg, cb] = &colours;
        b.iter(|| {
            let one = <<P::Pixel as Recurrence>::Channel as Channel>::ONE;
            pixels[..3 * WIDTH].fill(Channel::from_bits(0));
            pixels[3 * WIDTH..].fill(one);
            let mut row = PixelRow::of_runs(black_box(&mut pixels), WIDTH, 0..WIDTH);
            let floor = P::Pixel::FLOOR;
            fold_row::<P::Pixel, FrontToBack, i32>(
                &mut row,
                [cr, cg, cb],
                black_box(&opacities),
                Dither::of_plane(7),
                floor,
            );
        });
    });
}

fn classify<P: Precision>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    table: &str,
    classifier: &impl Classifier<P>,
    samples: &[i32],
) {
    let mut out = vec![0; WIDTH];
    let mut colours = [(); 3].map(|()| vec![0; WIDTH]);
    group.bench_function(format!("opacity-{table}/{}", P::NAME), |b| {
        b.iter(|| classifier.opacity_row::<i32>(black_box(samples), black_box(&mut out)));
    });
    group.bench_function(format!("colour-{table}/{}", P::NAME), |b| {
        let [r, g, blue] = &mut colours;
        b.iter(|| classifier.colour_row::<i32>(black_box(samples), [&mut r[..], &mut g[..], &mut blue[..]]));
    });
}

fn stages(c: &mut Criterion) {
    let mut group = c.benchmark_group("row-256");
    group.throughput(Throughput::Elements(WIDTH as u64));
    kernels::<Paper>(&mut group);
    kernels::<Compact>(&mut group);
    kernels::<Wide>(&mut group);
    let random = &mut Random::new(3);
    let (a, b28) = (row(random, 1 << 28), row(random, 1 << 28));
    let mut out = vec![0; WIDTH];
    group.bench_function("gradient-difference", |b| {
        b.iter(|| difference_row::<i32>(black_box(&a), black_box(&b28), black_box(&mut out)));
    });
    group.bench_function("gradient-spacing", |b| {
        out.copy_from_slice(&a);
        b.iter(|| space_row::<i32>(black_box(&mut out), Intensity::from_bits(32_767)));
    });
    let g = [(); 3].map(|()| row(random, 1 << 28));
    let mut work = g.clone();
    group.bench_function("normalise", |b| {
        b.iter(|| {
            for (work, g) in work.iter_mut().zip(&g) {
                work.copy_from_slice(g);
            }
            let [x, y, z] = &mut work;
            normalise_row::<i32>([x, y, z], black_box(&mut out));
        });
    });
    group.finish();
}

/// Folds all planes into a fresh image on the current threads.
struct Fold<'a>(&'a Plan, &'a [Slice<'a>]);

impl Job for Fold<'_> {
    type Output = ();

    fn run<L: Pipeline>(self, pipeline: &L) {
        let Self(plan, slices) = self;
        let mut image = new_image::<L>(plan).expect("a small image");
        fold_tiles(plan, pipeline, slices, &mut image, 32, Simd::widest(), &|_, _| ());
        black_box(&image);
    }
}

/// The whole pipeline on one thread. Samples: all that lie in the volume, whether skipped or not.
fn whole(c: &mut Criterion) {
    const SIDE: usize = 128;
    let mut group = c.benchmark_group("volume-128");
    group.throughput(Throughput::Elements((SIDE * SIDE * SIDE) as u64));
    group.sample_size(10);
    let ripples = Arc::new(volume([SIDE; 3], Filling::Ripples, 0));
    let table = table_of(&[
        (1200, [255, 80, 0], 0),
        (2400, [255, 240, 20], 9_000),
        (4095, [20, 60, 255], 20_000),
    ]);
    let unlit = Frame {
        direction: [300, -200, 1000],
        ..Frame::new(ripples, table)
    };
    let lit = Frame {
        material: Some(lights()),
        ..unlit.clone()
    };
    for (name, frame) in [("unlit", unlit), ("lit", lit)] {
        for precision in PrecisionName::ALL {
            let frame = frame.in_precision(precision);
            frame.with_prepared(|prepared, slices| {
                group.bench_function(format!("{name}/{}", precision.name()), |b| {
                    let run = || b.iter(|| prepared.dispatch(Fold(&prepared.setup.plan, slices)).expect("a frame"));
                    on_threads(Some(1), run).expect("a thread");
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, stages, whole);
criterion_main!(benches);
