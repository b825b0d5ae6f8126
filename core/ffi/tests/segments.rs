//! Segments from C: frames and the stage have Rust's bits, one table serves all views, and every misuse is a code.

use core::ffi::c_void;
use core::ptr::{null, null_mut};

use slicecast::borders::Borders;
use slicecast::classify::Classifier;
use slicecast::composite::{Channel, ChannelFormat, FrontToBack, Recurrence};
use slicecast::cut::Cut;
use slicecast::format::{Coefficient, Direction, Intensity, Opacity, Vector};
use slicecast::integral::{Colours, Integral, Length, NODE_MAX, nodes};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::{Composite, Depth, NO_DEPTH, Pipeline};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Highlight, Light, Phong, Shader, Unlit};
use slicecast::slice::{Code12, RowRange};
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::surface::{Face, Surface, VALUE_MAX};
use slicecast::view::View;
use slicecast_ffi::*;

const DIMS: [u32; 3] = [7, 6, 5];

/// Directions along each axis, whose steps have different lengths.
const TURNS: [[i64; 3]; 3] = [
    [1 << 56, -(1 << 55), 1 << 57],
    [-(1 << 57), 1 << 53, 1 << 56],
    [5 << 52, 1 << 57, -(3 << 54)],
];

/// Numbers from a seed (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (((self.0 >> 32) * u64::from(end)) >> 32) as u32
    }
}

/// A table of 4 lists and of 1, and the numbers that a scene borrows.
struct Data {
    lists: [Vec<u32>; 4],
    grain: u32,
    voxels: Vec<u16>,
    lights: Box<[SlicecastLight; 1]>,
}

/// What nodes of the tests are multiplied by, log2.
const EXPONENT: u32 = 20;

impl Data {
    /// Bins of which a third is empty.
    fn new(grain: u32) -> Self {
        let mut random = Random(0x5e67_0001 + u64::from(grain));
        let mut lists = [(); 4].map(|()| vec![0_u32; nodes(grain)]);
        for n in 1..nodes(grain) {
            let rise = random.below(3).min(1) * (random.below(2 << EXPONENT >> 4) << grain);
            let shares = [rise, random.below(rise + 1), random.below(rise + 1), rise];
            for (list, share) in lists.iter_mut().zip(shares) {
                list[n] = list[n - 1] + share;
            }
        }
        let count: u32 = DIMS.iter().product();
        Self {
            lists,
            grain,
            voxels: (0..count).map(|_| random.below(4096) as u16).collect(),
            lights: Box::new([SlicecastLight {
                direction: [0, 18918, -26755].map(|c| c << 15),
                half: [0, 9000, -31500].map(|c| c << 15),
                diffuse: [20000 << 16, 18000 << 16, 16000 << 16],
                specular: [6000 << 16; 3],
            }]),
        }
    }

    fn integrals(&self, lists: u32) -> SlicecastIntegrals {
        let [extinction, red, green, blue] = self.lists.each_ref().map(|list| list.as_ptr());
        SlicecastIntegrals {
            nodes: nodes(self.grain),
            lists,
            grain: self.grain,
            exponent: EXPONENT,
            colour: [1 << 31, 3 << 28, 12345],
            extinction,
            colours: if lists == 4 { [red, green, blue] } else { [null(); 3] },
        }
    }

    fn table(&self, lists: u32, length: Length) -> Integral<&[u32]> {
        let [extinction, red, green, blue] = self.lists.each_ref().map(Vec::as_slice);
        let colours = if lists == 4 {
            Colours::Each([red, green, blue])
        } else {
            Colours::One(self.integrals(1).colour)
        };
        Integral::new(extinction, colours, self.grain, EXPONENT, length).unwrap()
    }

    fn lighting(&self) -> SlicecastLighting {
        SlicecastLighting {
            ambient: [5000 << 16; 3],
            viewer: [0, 0, -32768 << 15],
            highlight: 0,
            exponent_log2: 4,
            count: 1,
            lights: self.lights.as_ptr(),
        }
    }
}

fn scene(direction: [i64; 3], lighting: &SlicecastLighting, integrals: &SlicecastIntegrals) -> SlicecastScene {
    SlicecastScene {
        version: SLICECAST_VERSION,
        dims: DIMS,
        direction,
        spacing: [32768, 32768, 20000],
        planes_per_voxel: 2,
        rays_per_voxel: 2,
        interpolation: 0,
        borders: 0,
        crop_low: [0; 3],
        crop_high: [0; 3],
        entries: null(),
        low_roots: null(),
        low_colours: null(),
        lighting,
        integrals,
        surfaces: null(),
        surface_count: 0,
        medium: SlicecastMedium::default(),
        fast: null(),
    }
}

fn plan(scene: &SlicecastScene) -> Plan {
    let view = View::new(scene.direction.map(Direction::from_bits)).unwrap();
    let sampling = Sampling {
        planes_per_voxel: scene.planes_per_voxel,
        rays_per_voxel: scene.rays_per_voxel,
    };
    let borders = [Borders::Whole, Borders::Cells, Borders::Nodes][scene.borders as usize];
    let spacing = Spacing(scene.spacing.map(Intensity::from_bits));
    Plan::with_borders(view, scene.dims, spacing, sampling, borders).unwrap()
}

/// The image, or rows of it, from C; elements as bits.
fn from_c(
    pipeline: *const SlicecastPipeline,
    scene: &SlicecastScene,
    voxels: &[u16],
    band: [u32; 2],
) -> (SlicecastNeeds, Vec<u32>) {
    let ([first, rows], mut needs) = (band, SlicecastNeeds::default());
    let (mut stream, mut image, mut bytes) = (null_mut(), null::<c_void>(), 0);
    // SAFETY: good pointers.
    unsafe {
        let code = slicecast_needs(pipeline, scene, rows, &mut needs, null_mut());
        assert_eq!(code, SLICECAST_OK);
        let mut memory = vec![0x5a5a_5a5a_5a5a_5a5a_u64; needs.bytes.div_ceil(8)];
        let block = memory.as_mut_ptr().cast();
        let code = slicecast_open(
            pipeline,
            scene,
            first,
            rows,
            block,
            needs.bytes,
            &mut stream,
            null_mut(),
        );
        assert_eq!(code, SLICECAST_OK);
        let mut number = 0;
        while slicecast_wanted(stream, &mut number, null_mut()) == SLICECAST_OK {
            let slice = &voxels[number as usize * needs.slice_voxels..][..needs.slice_voxels];
            let code = slicecast_push(stream, slice.as_ptr(), slice.len(), null_mut());
            assert_eq!(code, SLICECAST_OK);
        }
        let code = slicecast_image(stream, &mut image, &mut bytes, null_mut());
        assert_eq!((code, bytes), (SLICECAST_OK, needs.image_bytes));
        let found = if needs.element_bytes == 2 {
            let image = core::slice::from_raw_parts(image.cast::<u16>(), bytes / 2);
            image.iter().map(|element| u32::from(*element)).collect()
        } else {
            core::slice::from_raw_parts(image.cast::<u32>(), bytes / 4).to_vec()
        };
        (needs, found)
    }
}

/// The same image from Rust.
fn from_rust<P, C, S>(p: P, table: C, shader: S, plan: Plan, voxels: &[u16]) -> Vec<u32>
where
    P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>,
    C: Classifier<P>,
    S: Shader<P>,
{
    let pipeline = Composite::<P, C, S, FrontToBack>::new(p, table, shader);
    let image = streamed(pipeline, plan, voxels);
    image.iter().map(|element| element.bits()).collect()
}

/// The image of a pipeline.
fn streamed<L: Pipeline<Voxel = Code12>>(pipeline: L, plan: Plan, voxels: &[u16]) -> Vec<L::Element> {
    let needs = Needs::of::<L>(&plan);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![L::Element::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let [width, height, _] = plan.dims();
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    for slice in voxels.chunks_exact((width * height) as usize) {
        stream.push(slice).unwrap();
    }
    stream.image().to_vec()
}

fn phong<P: Precision>(p: P, data: &Data) -> Phong<P> {
    let lighting = data.lighting();
    let lights = data.lights.map(|l| Light {
        direction: l.direction.map(Vector::from_bits),
        half: l.half.map(Vector::from_bits),
        diffuse: l.diffuse.map(Coefficient::from_bits),
        specular: l.specular.map(Coefficient::from_bits),
    });
    let (ambient, viewer) = (
        lighting.ambient.map(Coefficient::from_bits),
        lighting.viewer.map(Vector::from_bits),
    );
    Phong::new(p, ambient, &lights, viewer, Highlight::Reflection, 4).unwrap()
}

/// Both shadings of a precision against Rust.
fn held<P>(p: P, pipelines: [*const SlicecastPipeline; 2], scene: &SlicecastScene, data: &Data, lists: u32) -> Vec<u32>
where
    P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>,
{
    let plan = plan(scene);
    // As the view wants its slices, whichever axis they lie along.
    let (voxels, table) = (&data.voxels, data.table(lists, Length::of(&plan)));
    let [unlit, lit] = pipelines;
    let dark = from_c(unlit, scene, voxels, [0, 0]).1;
    assert!(dark == from_rust(p, table, Unlit, plan, voxels));
    let bright = from_c(lit, scene, voxels, [0, 0]).1;
    assert!(bright == from_rust(p, table, phong(p, data), plan, voxels));
    assert_ne!(dark, bright);
    dark
}

/// Every precision, unlit and lit, one colour and each, all grains, and three views over one table, each with borders of its
/// own.
#[test]
fn frames_have_rusts_bits() {
    let paper = [slicecast_paper_unlit_segments(), slicecast_paper_lit_segments()];
    let compact = [slicecast_compact_unlit_segments(), slicecast_compact_lit_segments()];
    let wide = [slicecast_wide_unlit_segments(), slicecast_wide_lit_segments()];
    let mut images: Vec<Vec<u32>> = Vec::new();
    for grain in 0..=4 {
        let data = Data::new(grain);
        let lighting = data.lighting();
        for lists in [1, 4] {
            let integrals = data.integrals(lists);
            for (direction, borders) in TURNS.into_iter().zip([0, 1, 2]) {
                let scene = SlicecastScene {
                    borders,
                    ..scene(direction, &lighting, &integrals)
                };
                for image in [
                    held(Paper, paper, &scene, &data, lists),
                    held(Compact, compact, &scene, &data, lists),
                    held(Wide, wide, &scene, &data, lists),
                ] {
                    assert!(!images.contains(&image), "an image twice proves nothing");
                    images.push(image);
                }
            }
        }
    }
    assert_eq!(images.len(), 5 * 2 * 3 * 3);
}

#[test]
fn bands_are_the_whole() {
    let data = Data::new(2);
    let (lighting, integrals) = (data.lighting(), data.integrals(4));
    let scene = scene(TURNS[0], &lighting, &integrals);
    let pipeline = slicecast_compact_lit_segments();
    let (needs, whole) = from_c(pipeline, &scene, &data.voxels, [0, 0]);
    let row = 4 * needs.columns as usize;
    let phase = row * needs.rows as usize;
    for rows in [1, 3, needs.rows - 1] {
        for first in 0..=needs.rows - rows {
            let (_, band) = from_c(pipeline, &scene, &data.voxels, [first, rows]);
            for (number, part) in band.chunks_exact(row * rows as usize).enumerate() {
                assert_eq!(part, &whole[number * phase + first as usize * row..][..part.len()]);
            }
        }
    }
}

/// What is told of a failure: code, argument, needed, given, row, column.
fn told(code: i32, error: SlicecastError) -> (i32, u32, i64, i64, u32, u32) {
    assert_eq!(code, error.code);
    (code, error.argument, error.needed, error.given, error.row, error.column)
}

fn error() -> SlicecastError {
    SlicecastError {
        code: 99,
        argument: 99,
        needed: 99,
        given: 99,
        row: 99,
        column: 99,
    }
}

#[test]
fn what_is_no_table_of_segments_is_refused_with_numbers() {
    let mut data = Data::new(2);
    let (lighting, integrals) = (data.lighting(), data.integrals(4));
    let good = scene(TURNS[0], &lighting, &integrals);
    let pipeline = slicecast_compact_unlit_segments();
    let mut needs = SlicecastNeeds::default();
    // SAFETY: good pointers.
    let code = unsafe { slicecast_needs(pipeline, &good, 0, &mut needs, null_mut()) };
    assert_eq!(code, SLICECAST_OK);
    let mut memory = vec![0_u64; needs.bytes.div_ceil(8)];
    let mut open = |scene: &SlicecastScene| {
        let (mut stream, mut error, block) = (null_mut(), error(), memory.as_mut_ptr().cast());
        // SAFETY: good pointers, and the bad ones that the function promises to refuse.
        let code = unsafe { slicecast_open(pipeline, scene, 0, 0, block, 8 * memory.len(), &mut stream, &mut error) };
        assert_eq!(code == SLICECAST_OK, !stream.is_null());
        told(code, error)
    };
    let mut with = |integrals: SlicecastIntegrals| open(&scene(TURNS[0], &lighting, &integrals));
    assert_eq!(with(integrals), (SLICECAST_OK, 0, 0, 0, 0, 0));
    let of = |change: fn(&mut SlicecastIntegrals)| {
        let mut changed = integrals;
        change(&mut changed);
        changed
    };
    assert_eq!(with(of(|i| i.lists = 0)), (SLICECAST_LISTS, 0, 4, 0, 0, 0));
    assert_eq!(with(of(|i| i.grain = 5)), (SLICECAST_GRAIN, 0, 4, 5, 0, 0));
    assert_eq!(
        with(of(|i| i.exponent = 14)),
        (SLICECAST_NODE_EXPONENT, 0, 15, 14, 0, 0)
    );
    assert_eq!(
        with(of(|i| i.exponent = 29)),
        (SLICECAST_NODE_EXPONENT, 0, 28, 29, 0, 0)
    );
    // A table of 1025 nodes is none of single codes.
    assert_eq!(with(of(|i| i.grain = 0)), (SLICECAST_LENGTH, 2, 4097, 1025, 0, 0));
    assert_eq!(with(of(|i| i.extinction = null())).0, SLICECAST_NULL);
    assert_eq!(with(of(|i| i.colours[2] = null())).0, SLICECAST_NULL);
    let crooked = |i: &mut SlicecastIntegrals| i.extinction = i.extinction.cast::<u8>().wrapping_add(2).cast();
    assert_eq!(with(of(crooked)).0, SLICECAST_MISALIGNED);
    let bright = |i: &mut SlicecastIntegrals| (i.lists, i.colour[1]) = (1, (1 << 31) + 1);
    assert_eq!(with(of(bright)), (SLICECAST_COLOUR, 0, 1 << 31, (1 << 31) + 1, 0, 0));

    let bare = SlicecastScene {
        integrals: null(),
        surfaces: null(),
        surface_count: 0,
        medium: SlicecastMedium::default(),
        ..good
    };
    assert_eq!(open(&bare), (SLICECAST_NULL, 2, 0, 0, 0, 0));
    let nowhere = SlicecastScene { borders: 3, ..good };
    assert_eq!(open(&nowhere), (SLICECAST_BORDERS, 0, 2, 3, 0, 0));
    let nearest = SlicecastScene {
        interpolation: 1,
        ..good
    };
    assert_eq!(open(&nearest), (SLICECAST_INTERPOLATION, 0, 0, 1, 0, 0));
    let flat = SlicecastScene {
        dims: [7, 6, 1],
        ..good
    };
    assert_eq!(open(&flat), (SLICECAST_SLICES, 0, 2, 1, 0, 0));

    data.lists[2][77] = NODE_MAX + 1;
    let integrals = data.integrals(4);
    let (value, max) = ((NODE_MAX + 1).into(), NODE_MAX.into());
    let falling = open(&scene(TURNS[0], &lighting, &integrals));
    assert_eq!(falling, (SLICECAST_NODE, 0, max, value, 2, 77));
}

/// The stage in C is core's scalar definition, for every precision, between any two samples.
#[test]
fn the_stage_is_cores() {
    fn check<P: Precision>(p: P, number: u32, data: &Data, lists: u32, scene: &SlicecastScene, random: &mut Random) {
        let (mut length, integrals) = (SlicecastLength::default(), data.integrals(lists));
        // SAFETY: good pointers.
        let code = unsafe { slicecast_stage_length(scene, &mut length, null_mut()) };
        assert_eq!(code, SLICECAST_OK);
        let cores = Length::of(&plan(scene));
        assert_eq!((length.scaled, length.bits), (cores.scaled, cores.bits));
        let table = data.table(lists, cores);
        let last = 4095 << p.formats().sample_bits;
        for n in 0..500 {
            let front = random.below(last + 1) as i32;
            let back = match n % 3 {
                0 => random.below(last + 1) as i32,
                1 => (front + random.below(9) as i32 - 4).clamp(0, last as i32),
                _ => front,
            };
            let (mut opacity, mut colour, mut error) = (0, [0; 3], error());
            let (out, colours) = (&raw mut opacity, colour.as_mut_ptr());
            // SAFETY: good pointers.
            let code =
                unsafe { slicecast_stage_segment(number, &integrals, &length, front, back, out, colours, &mut error) };
            assert_eq!(code, SLICECAST_OK);
            assert_eq!(opacity, table.segment_opacity(p, [front, back]).to_bits());
            assert_eq!(colour, table.segment_colour(p, [front, back]));
        }
    }
    let mut random = Random(7);
    for grain in [0, 2, 4] {
        let data = Data::new(grain);
        let lighting = data.lighting();
        for lists in [1, 4] {
            for direction in TURNS {
                let integrals = data.integrals(lists);
                let scene = scene(direction, &lighting, &integrals);
                check(Paper, SLICECAST_PAPER, &data, lists, &scene, &mut random);
                check(Compact, SLICECAST_COMPACT, &data, lists, &scene, &mut random);
                check(Wide, SLICECAST_WIDE, &data, lists, &scene, &mut random);
            }
        }
    }
}

#[test]
fn the_stage_refuses_with_numbers() {
    let data = Data::new(4);
    let integrals = data.integrals(4);
    let good = SlicecastLength {
        scaled: 1 << 30,
        bits: 27,
    };
    let stage = |precision, length: *const SlicecastLength, front, back| {
        let (mut opacity, mut colour, mut error) = (7, [7; 3], error());
        let (out, colours) = (&raw mut opacity, colour.as_mut_ptr());
        // SAFETY: good pointers, and a null one that the function promises to refuse.
        let code =
            unsafe { slicecast_stage_segment(precision, &integrals, length, front, back, out, colours, &mut error) };
        if code != SLICECAST_OK {
            assert_eq!((opacity, colour), (7, [7; 3]), "nothing is written by a refusal");
        }
        told(code, error)
    };
    let last = 4095 << 12;
    assert_eq!(stage(SLICECAST_COMPACT, &good, 0, last).0, SLICECAST_OK);
    let range = |argument, needed: i32, given: i32| (SLICECAST_RANGE, argument, needed.into(), given.into(), 0, 0);
    assert_eq!(stage(SLICECAST_COMPACT, &good, -1, 0), range(4, 0, -1));
    assert_eq!(stage(SLICECAST_COMPACT, &good, 0, last + 1), range(5, last, last + 1));
    assert_eq!(stage(3, &good, 0, 0), range(1, 2, 3));
    let long = SlicecastLength { bits: 28, ..good };
    assert_eq!(stage(SLICECAST_WIDE, &long, 0, 0), range(3, 27, 28));
    let short = SlicecastLength { bits: 10, ..good };
    assert_eq!(stage(SLICECAST_WIDE, &short, 0, 0), range(3, 11, 10));
    assert_eq!(stage(SLICECAST_WIDE, null(), 0, 0), (SLICECAST_NULL, 3, 0, 0, 0, 0));
}

/// Four surfaces, two of them of one value; faces that differ, one of them clear.
fn surfaces() -> [SlicecastSurface; 4] {
    let face = |seed: u32, opacity: u32| SlicecastFace {
        colour: [seed << 24, (seed * 5 % 128) << 24, (seed * 11 % 128) << 24],
        opacity,
    };
    [(1000, 9), (2000, 77), (2000, 31), (3100, 120)].map(|(code, seed)| SlicecastSurface {
        value: (code << 16) + 12_345,
        front: face(seed, if seed == 77 { 0 } else { 3 << 29 }),
        back: face(seed + 5, 1 << 30),
    })
}

/// Surfaces in a volume and alone, and their depths, in every precision.
#[test]
fn surfaces_and_depths_have_rusts_bits() {
    fn held_by<P>(p: P, pipelines: [*const SlicecastPipeline; 3], data: &Data) -> usize
    where
        P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>,
    {
        let (lighting, integrals, listed) = (data.lighting(), data.integrals(4), surfaces());
        let face = |face: SlicecastFace| Face {
            colour: face.colour,
            opacity: Opacity::from_bits(face.opacity),
        };
        let list = listed.map(|surface| Surface {
            value: surface.value,
            front: face(surface.front),
            back: face(surface.back),
        });
        let mut images: Vec<Vec<u32>> = Vec::new();
        for direction in TURNS {
            for alone in [false, true] {
                let mut scene = scene(direction, &lighting, &integrals);
                (scene.surfaces, scene.surface_count) = (listed.as_ptr(), listed.len());
                if alone {
                    scene.integrals = null();
                }
                let plan = plan(&scene);
                let volume = (!alone).then(|| data.table(4, Length::of(&plan)));
                let cut = Cut::new(volume, &list[..], 1).unwrap();
                let [unlit, lit, depth] = pipelines;
                let dark = from_c(unlit, &scene, &data.voxels, [0, 0]).1;
                assert!(dark == from_rust(p, cut, Unlit, plan, &data.voxels));
                let bright = from_c(lit, &scene, &data.voxels, [0, 0]).1;
                assert!(bright == from_rust(p, cut, phong(p, data), plan, &data.voxels));
                let depths = from_c(depth, &scene, &data.voxels, [0, 0]).1;
                assert!(depths == streamed(Depth::new(p, &list[..], &plan).unwrap(), plan, &data.voxels));
                assert!(depths.iter().any(|depth| *depth < 2 << 16) && depths.contains(&NO_DEPTH));
                images.extend([dark, bright]);
            }
        }
        images.sort();
        images.dedup();
        images.len()
    }
    let data = Data::new(0);
    let compact = [
        slicecast_compact_unlit_surfaces(),
        slicecast_compact_lit_surfaces(),
        slicecast_compact_depth(),
    ];
    assert_eq!(held_by(Compact, compact, &data), 12, "an image twice proves nothing");
    let wide = [
        slicecast_wide_unlit_surfaces(),
        slicecast_wide_lit_surfaces(),
        slicecast_wide_depth(),
    ];
    assert_eq!(held_by(Wide, wide, &data), 12);
    let paper = [
        slicecast_paper_unlit_surfaces(),
        slicecast_paper_lit_surfaces(),
        slicecast_paper_depth(),
    ];
    assert_eq!(held_by(Paper, paper, &data), 12);
}

#[test]
fn what_are_no_surfaces_is_refused_with_numbers() {
    let data = Data::new(2);
    let (lighting, integrals, mut listed) = (data.lighting(), data.integrals(4), surfaces());
    let open = |list: &[SlicecastSurface], pointer: *const SlicecastSurface, pipeline| {
        let mut scene = scene(TURNS[0], &lighting, &integrals);
        (scene.surfaces, scene.surface_count) = (pointer, list.len());
        let (mut needs, mut stream, mut error) = (SlicecastNeeds::default(), null_mut(), error());
        // SAFETY: good pointers, or null.
        let code = unsafe {
            slicecast_needs(pipeline, &scene, 0, &mut needs, null_mut());
            let mut memory = vec![0_u64; needs.bytes.div_ceil(8)];
            let block = memory.as_mut_ptr().cast();
            slicecast_open(pipeline, &scene, 0, 0, block, needs.bytes, &mut stream, &mut error)
        };
        (code, error)
    };
    for pipeline in [slicecast_compact_lit_surfaces(), slicecast_wide_depth()] {
        let (code, found) = open(&listed, null(), pipeline);
        assert_eq!((code, found.argument), (SLICECAST_NULL, 2));
        listed.swap(0, 1);
        let (code, found) = open(&listed, listed.as_ptr(), pipeline);
        assert_eq!(told(code, found), (SLICECAST_SURFACE_ORDER, 0, 0, 0, 1, 0));
        listed.swap(0, 1);
        let good = listed[3];
        listed[3].value = VALUE_MAX + 1;
        let (code, found) = open(&listed, listed.as_ptr(), pipeline);
        let given = i64::from(VALUE_MAX);
        assert_eq!(told(code, found), (SLICECAST_SURFACE_VALUE, 0, given, given + 1, 3, 0));
        listed[3] = good;
        listed[3].back.opacity = u32::MAX;
        let (code, found) = open(&listed, listed.as_ptr(), pipeline);
        assert_eq!(told(code, found), (SLICECAST_FACE, 0, 1 << 31, u32::MAX.into(), 3, 0));
        listed[3] = good;
        assert_eq!(open(&listed, listed.as_ptr(), pipeline).0, SLICECAST_OK);
    }
}
