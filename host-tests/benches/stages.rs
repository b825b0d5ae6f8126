//! Throughput of each stage's row kernel (256 samples, at every vector width) and of the whole pipeline (128^3 synthetic
//! volume), in samples.
//! Nothing is asserted: times are for people to read.

use std::hint::black_box;
use std::marker::PhantomData;
use std::sync::Arc;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use slicecast::classify::{Classifier, Linear, Nearest, PointTable, Slab, Sqrt8, Sqrt16, colour_of_byte};
use slicecast::composite::{Colours, Dither, FrontToBack, PixelRow, Recurrence as _, fold_row, fold_visible_row};
use slicecast::format::{Coefficient, Intensity, Vector, Weight};
use slicecast::gradient::{difference_row, space_row};
use slicecast::interpolate::{yx_row, yx_row_in_slice, z_row};
use slicecast::lanes::Lanes;
use slicecast::normalise::normalise_row;
use slicecast::plane::ChannelOf;
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Highlight, Light, Phong, Shader};
use slicecast::slice::Slice;
use slicecast::table::ENTRIES;
use slicecast_engine::camera::Material;
use slicecast_engine::expanded::Expanded;
use slicecast_engine::frame::Prepared;
use slicecast_engine::simd::{OverLanes, Simd, with_lanes};
use slicecast_engine::table::{Table, own_colours};
use slicecast_engine::threads::on_threads;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_host_tests::frame::{Frame, table_of};
use slicecast_host_tests::random::{Filling, Random, volume};
use slicecast_scene::{AlphaCodeName, LookupName, PrecisionName};

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

/// Calls of a kernel at a time, so that entering the code of a width costs nothing beside them.
const CALLS: usize = 16;

/// A row kernel.
#[derive(Clone, Copy, Debug)]
enum Kernel {
    InterpolateZ,
    InterpolateYx,
    InterpolateInSlice,
    Opacity,
    Colour,
    Difference,
    Spacing,
    Normalise,
    Shade,
    Composite,
    CompositeOneColour,
}

impl Kernel {
    /// All of them, in the order of the pipeline.
    const ALL: [(Self, &'static str); 11] = [
        (Self::InterpolateZ, "interpolate-z"),
        (Self::InterpolateYx, "interpolate-yx"),
        (Self::InterpolateInSlice, "interpolate-in-slice"),
        (Self::Opacity, "opacity-linear-16"),
        (Self::Colour, "colour-linear-16"),
        (Self::Difference, "gradient-difference"),
        (Self::Spacing, "gradient-spacing"),
        (Self::Normalise, "normalise"),
        (Self::Shade, "shade"),
        (Self::Composite, "composite"),
        (Self::CompositeOneColour, "composite-one-colour"),
    ];
}

/// What the kernels of a precision read and write.
struct Bench<P: Precision> {
    precision: P,
    near: Vec<u16>,
    far: Vec<u16>,
    /// Voxels interpolated along z.
    between: [Vec<i32>; 2],
    samples: Vec<i32>,
    opacities: Vec<i32>,
    colours: [Vec<i32>; 3],
    gradients: [Vec<i32>; 3],
    normals: [Vec<i32>; 3],
    lengths: Vec<i32>,
    table: Expanded,
    phong: Phong<P>,
    pixels: Vec<ChannelOf<P>>,
    out: [Vec<i32>; 4],
}

impl<P: Precision> Bench<P> {
    fn new(precision: P) -> Self {
        let random = &mut Random::new(1);
        let mut voxels = || volume([WIDTH, 1, 1], Filling::Noise, random.next_bits()).voxels;
        let (near, far) = (voxels(), voxels());
        let mut rows = |end: u32| [(); 3].map(|()| row(random, end));
        let ([a, b, _], [samples, ..]) = (rows(4095 << 16), rows(4095 << precision.formats().sample_bits));
        let ([opacities, ..], colours) = (rows(1 << 24), rows(1 << precision.pixel().colour_bits()));
        let gradients = rows(1 << 28);
        let (mut normals, mut lengths) = (gradients.clone(), vec![0; WIDTH]);
        let [x, y, z] = &mut normals;
        normalise_row::<i32>([x, y, z], &mut lengths);
        let entries = Box::new(std::array::from_fn(|_| random.next_bits() as u32));
        let table = Table {
            colours: own_colours(&entries),
            entries,
            plane: Box::new(std::array::from_fn(|_| random.next_bits() as u8)),
            code: AlphaCodeName::Sqrt16,
            lookup: LookupName::Linear,
            underflows: 0,
        };
        Self {
            precision,
            near,
            far,
            between: [a, b],
            samples,
            opacities,
            colours,
            gradients,
            normals,
            lengths,
            table: table.expanded(),
            phong: lights().phong(precision).expect("one light"),
            pixels: vec![ChannelOf::<P>::default(); 4 * WIDTH],
            out: [(); 4].map(|()| vec![0; WIDTH]),
        }
    }

    /// An image that nothing has been folded into, so that no ray is finished.
    fn clear(&mut self) {
        let (colour, transparency) = self.pixels.split_at_mut(3 * WIDTH);
        colour.fill(ChannelOf::<P>::default());
        transparency.fill(self.precision.pixel().one());
    }
}

/// A kernel over the rows of a bench, [`CALLS`] times.
struct Call<'a, P: Precision>(Kernel, &'a mut Bench<P>);

impl<P: Precision> OverLanes for Call<'_, P> {
    type Output = ();

    fn run<V: Lanes>(self) {
        V::enter(InLanes::<_, V>(self, PhantomData));
    }
}

struct InLanes<'a, P: Precision, V>(Call<'a, P>, PhantomData<V>);

impl<P: Precision, V: Lanes> slicecast::lanes::Kernel for InLanes<'_, P, V> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.call::<V>();
    }
}

impl<P: Precision> Call<'_, P> {
    #[inline(always)]
    fn call<V: Lanes>(self) {
        let Self(kernel, bench) = self;
        let weight = Weight::from_bits(21_845);
        for _ in 0..CALLS {
            let bench = black_box(&mut *bench);
            let [out, red, green, blue] = &mut bench.out;
            match kernel {
                Kernel::InterpolateZ => z_row::<P, V>(bench.precision, &bench.near, &bench.far, weight, out),
                Kernel::InterpolateYx => {
                    let [a, b] = &bench.between;
                    yx_row::<P, V>(bench.precision, a, b, false, [weight, weight], out);
                }
                Kernel::InterpolateInSlice => {
                    yx_row_in_slice::<P, V>(bench.precision, &bench.near, &bench.far, [weight, weight], out);
                }
                Kernel::Opacity => {
                    Classifier::opacity_row::<V>(&bench.table, bench.precision, Slab::of(&bench.samples), out)
                }
                Kernel::Colour => Classifier::colour_row::<V>(
                    &bench.table,
                    bench.precision,
                    Slab::of(&bench.samples),
                    [red, green, blue],
                ),
                Kernel::Difference => {
                    let [a, b, _] = &bench.gradients;
                    difference_row::<V>(a, b, out);
                }
                Kernel::Spacing => space_row::<V>(out, Intensity::from_bits(32_767)),
                Kernel::Normalise => {
                    let [x, y, z] = &bench.gradients;
                    red.copy_from_slice(x);
                    green.copy_from_slice(y);
                    blue.copy_from_slice(z);
                    normalise_row::<V>([red, green, blue], out);
                }
                Kernel::Shade => {
                    let [x, y, z] = &bench.normals;
                    let mut colours = Colours {
                        one: None,
                        rows: [red, green, blue],
                    };
                    Shader::<P>::shade_row::<V>(&bench.phong, [x, y, z], &bench.lengths, &mut colours);
                }
                Kernel::Composite => {
                    let [red, green, blue] = &bench.colours;
                    let mut row = PixelRow::of_runs(&mut bench.pixels, WIDTH, 0..WIDTH);
                    let (dither, pixel) = (Dither::of_plane(7), bench.precision.pixel());
                    fold_row::<P::Pixel, FrontToBack, V>(
                        pixel,
                        &mut row,
                        [&red[..], green, blue],
                        &bench.opacities,
                        dither,
                        pixel.floor(),
                    );
                }
                Kernel::CompositeOneColour => {
                    let mut row = PixelRow::of_runs(&mut bench.pixels, WIDTH, 0..WIDTH);
                    let (dither, pixel) = (Dither::of_plane(7), bench.precision.pixel());
                    let colour = [242, 232, 208].map(|byte| colour_of_byte(byte, pixel.colour_bits()));
                    fold_visible_row::<P::Pixel, FrontToBack, V>(
                        pixel,
                        &mut row,
                        colour,
                        &bench.opacities,
                        dither,
                        pixel.floor(),
                    );
                }
            }
        }
    }
}

/// Every row kernel of a precision at every width that the processor has.
fn kernels<P: Precision>(precision: P, group: &mut BenchmarkGroup<'_, WallTime>) {
    let mut bench = Bench::new(precision);
    for (kernel, name) in Kernel::ALL {
        for simd in Simd::available() {
            group.bench_function(format!("{name}/{}/{}", P::NAME, simd.name()), |b| {
                bench.clear();
                b.iter(|| with_lanes(simd, Call(kernel, &mut bench)));
            });
        }
    }
}

/// The tables as firmware reads them: entries of 32 bits, decoded at every sample.
fn point_tables<P: Precision>(precision: P, group: &mut BenchmarkGroup<'_, WallTime>) {
    let random = &mut Random::new(2);
    let samples = row(random, 4095 << precision.formats().sample_bits);
    let entries: Box<[u32; ENTRIES]> = Box::new(std::array::from_fn(|_| random.next_bits() as u32));
    let plane: Box<[u8; ENTRIES]> = Box::new(std::array::from_fn(|_| random.next_bits() as u8));
    let nearest = PointTable::<Sqrt8, Nearest>::new(&entries, ());
    let linear = PointTable::<Sqrt16, Linear>::new(&entries, &plane);
    point_table(precision, group, "nearest-8", &nearest, &samples);
    point_table(precision, group, "linear-16", &linear, &samples);
}

fn point_table<P: Precision>(
    precision: P,
    group: &mut BenchmarkGroup<'_, WallTime>,
    table: &str,
    classifier: &impl Classifier<P>,
    samples: &[i32],
) {
    let mut out = vec![0; WIDTH];
    let mut colours = [(); 3].map(|()| vec![0; WIDTH]);
    group.bench_function(format!("point-opacity-{table}/{}", P::NAME), |b| {
        b.iter(|| classifier.opacity_row::<i32>(precision, Slab::of(black_box(samples)), black_box(&mut out)));
    });
    group.bench_function(format!("point-colour-{table}/{}", P::NAME), |b| {
        let [r, g, blue] = &mut colours;
        b.iter(|| {
            classifier.colour_row::<i32>(
                precision,
                Slab::of(black_box(samples)),
                [&mut r[..], &mut g[..], &mut blue[..]],
            )
        });
    });
}

fn stages(c: &mut Criterion) {
    let mut group = c.benchmark_group("row-256");
    group.throughput(Throughput::Elements((CALLS * WIDTH) as u64));
    kernels(Paper, &mut group);
    kernels(Compact, &mut group);
    kernels(Wide, &mut group);
    group.throughput(Throughput::Elements(WIDTH as u64));
    point_tables(Paper, &mut group);
    point_tables(Compact, &mut group);
    point_tables(Wide, &mut group);
    group.finish();
}

/// Folds all planes into a fresh image on the current threads.
fn fold(prepared: &Prepared<'_>, slices: &[Slice<'_>]) {
    let mut rendering = prepared.begun().expect("a small image");
    rendering.fold_rows(slices, TILE_ROWS, Simd::widest(), &|_, _| ());
    black_box(rendering);
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
        for precision in PrecisionName::STAGED {
            let frame = frame.in_precision(precision);
            frame.with_prepared(|prepared, slices| {
                group.bench_function(format!("{name}/{}", precision.name()), |b| {
                    let run = || b.iter(|| fold(prepared, slices));
                    on_threads(Some(1), run).expect("a thread");
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, stages, whole);
criterion_main!(benches);
