//! The `fast` precision from C: frames have Rust's bits, and every misuse is a code with its numbers.

use core::ffi::c_void;
use core::ptr::{null, null_mut};
use std::collections::BTreeSet;

use slicecast::borders::Borders;
use slicecast::classify::{Colour16, Linear, PointTable, Sqrt16, entry};
use slicecast::composite::FrontToBack;
use slicecast::fast::table::{fill_colours, fill_roots};
use slicecast::fast::{Colours, FastPhong, RootTable, Roots};
use slicecast::format::{Coefficient, Direction, Intensity, Vector};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::{Fast, Pipeline};
use slicecast::shade::{Highlight, Light, Unlit};
use slicecast::slice::{Code12, RowRange};
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast_ffi::*;

const DIMS: [u32; 3] = [7, 6, 5];

/// Directions along each axis, whose slices have different sides.
const TURNS: [[i64; 3]; 3] = [
    [1 << 56, -(1 << 55), 1 << 57],
    [-(1 << 57), 1 << 53, 1 << 56],
    [5 << 52, 1 << 57, -(3 << 54)],
];

const LIGHT: SlicecastLight = SlicecastLight {
    direction: [0, 18918 << 15, -(26755 << 15)],
    half: [0, 9000 << 15, -(31500 << 15)],
    diffuse: [20000 << 16, 18000 << 16, 16000 << 16],
    specular: [6000 << 16; 3],
};

fn lighting(highlight: u32) -> SlicecastLighting {
    SlicecastLighting {
        ambient: [5000 << 16; 3],
        viewer: [0, 0, -(32768 << 15)],
        highlight,
        exponent_log2: 4,
        count: 1,
        lights: &LIGHT,
    }
}

/// What a scene borrows.
struct Data {
    entries: Box<[u32; ENTRIES]>,
    low: Box<[u8; ENTRIES]>,
    low_colours: Box<[[u8; 3]; ENTRIES]>,
    voxels: Vec<u16>,
}

impl Data {
    /// Values of one colour, or of many.
    fn new(one: bool) -> Self {
        let colour = |i: usize| {
            if one {
                [9, 200, 77]
            } else {
                [i as u8, (i >> 3) as u8, 200]
            }
        };
        let entries: Vec<u32> = (0..ENTRIES).map(|i| entry(colour(i), (i >> 5) as u8)).collect();
        let voxels = (0..DIMS.iter().product()).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 20) as u16);
        Self {
            entries: entries.try_into().unwrap(),
            low: Box::new([3; ENTRIES]),
            low_colours: Box::new([[200, 7, 99]; ENTRIES]),
            voxels: voxels.collect(),
        }
    }

    fn scene(&self, direction: [i64; 3], lighting: *const SlicecastLighting, fine: bool) -> SlicecastScene {
        SlicecastScene {
            version: SLICECAST_VERSION,
            dims: DIMS,
            direction,
            spacing: [32768, 32768, 20000],
            planes_per_voxel: 2,
            rays_per_voxel: 2,
            interpolation: 0,
            borders: 1,
            crop_low: [0; 3],
            crop_high: [0; 3],
            entries: self.entries.as_ptr(),
            low_roots: self.low.as_ptr(),
            low_colours: if fine { self.low_colours.as_ptr().cast() } else { null() },
            lighting,
            integrals: null(),
            surfaces: null(),
            surface_count: 0,
            medium: SlicecastMedium::default(),
            fast: null(),
        }
    }

    fn slice(&self, number: u32, voxels: usize) -> &[u16] {
        let first = number as usize * 17 % (self.voxels.len() - voxels);
        &self.voxels[first..first + voxels]
    }
}

/// A table of C's, and the memory in which it lies.
struct Made {
    roots: Box<Roots>,
    colours: Box<Colours>,
    table: SlicecastFastTable,
}

fn made(scene: &SlicecastScene) -> Made {
    let (mut roots, mut colours) = (Box::new([0; ENTRIES]), Box::new([[7; 4]; ENTRIES + 1]));
    let mut table = SlicecastFastTable {
        roots: null(),
        colours: null(),
        colour: [0; 3],
    };
    // SAFETY: good pointers.
    let code = unsafe {
        slicecast_fast_table(
            scene,
            roots.as_mut_ptr(),
            colours.as_mut_ptr().cast(),
            &mut table,
            null_mut(),
        )
    };
    assert_eq!(code, SLICECAST_OK);
    Made { roots, colours, table }
}

/// The image of a frame from C.
fn from_c(pipeline: *const SlicecastPipeline, scene: &SlicecastScene, data: &Data) -> Vec<u16> {
    let mut needs = SlicecastNeeds::default();
    let (mut stream, mut number, mut image, mut bytes) = (null_mut(), 0, null::<c_void>(), 0);
    // SAFETY: good pointers.
    unsafe {
        assert_eq!(
            slicecast_needs(pipeline, scene, 0, &mut needs, null_mut()),
            SLICECAST_OK
        );
        assert_eq!(needs.element_bytes, 2);
        let mut memory = vec![0x5a5a_5a5a_5a5a_5a5a_u64; needs.bytes.div_ceil(8)];
        let block = memory.as_mut_ptr().cast();
        let code = slicecast_open(pipeline, scene, 0, 0, block, needs.bytes, &mut stream, null_mut());
        assert_eq!(code, SLICECAST_OK);
        while slicecast_wanted(stream, &mut number, null_mut()) == SLICECAST_OK {
            let slice = data.slice(number, needs.slice_voxels);
            assert_eq!(
                slicecast_push(stream, slice.as_ptr(), slice.len(), null_mut()),
                SLICECAST_OK
            );
        }
        assert_eq!(
            slicecast_image(stream, &mut image, &mut bytes, null_mut()),
            SLICECAST_OK
        );
        assert_eq!(bytes, needs.image_bytes);
        core::slice::from_raw_parts(image.cast::<u16>(), bytes / 2).to_vec()
    }
}

/// The same from Rust.
fn from_rust<L: Pipeline<Element = u16, Voxel = Code12>>(scene: &SlicecastScene, data: &Data, pipeline: L) -> Vec<u16> {
    let view = View::new(scene.direction.map(Direction::from_bits)).unwrap();
    let sampling = Sampling {
        planes_per_voxel: scene.planes_per_voxel,
        rays_per_voxel: scene.rays_per_voxel,
    };
    let spacing = Spacing(scene.spacing.map(Intensity::from_bits));
    let plan = Plan::with_borders(view, scene.dims, spacing, sampling, Borders::Cells).unwrap();
    let needs = Needs::of::<L>(&plan);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![0; needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    let [width, height, _] = plan.dims();
    while let Some(number) = stream.wanted() {
        stream.push(data.slice(number, (width * height) as usize)).unwrap();
    }
    stream.image().to_vec()
}

/// The table from Rust.
fn table(data: &Data, fine: bool) -> RootTable<Box<Roots>, Box<Colours>> {
    let (mut roots, mut colours) = (Box::new([0; ENTRIES]), Box::new([[0; 4]; ENTRIES + 1]));
    let one = if fine {
        let points = PointTable::<Colour16, Linear>::new(&data.entries, (&data.low, &data.low_colours));
        fill_roots(&points, &mut roots);
        fill_colours(&points, &mut colours)
    } else {
        let points = PointTable::<Sqrt16, Linear>::new(&data.entries, &data.low);
        fill_roots(&points, &mut roots);
        fill_colours(&points, &mut colours)
    };
    RootTable::new(roots, one.ok_or(colours))
}

fn phong(highlight: Highlight) -> FastPhong {
    let vector = |bits: [i32; 3]| bits.map(Vector::from_bits);
    let coefficient = |bits: [u32; 3]| bits.map(Coefficient::from_bits);
    let SlicecastLighting { ambient, viewer, .. } = lighting(0);
    let light = Light {
        direction: vector(LIGHT.direction),
        half: vector(LIGHT.half),
        diffuse: coefficient(LIGHT.diffuse),
        specular: coefficient(LIGHT.specular),
    };
    FastPhong::new(coefficient(ambient), &[light], vector(viewer), highlight, 4).unwrap()
}

#[test]
fn frames_of_16_bit_lanes_are_those_of_rust() {
    for (one, fine) in [(true, false), (true, true), (false, false), (false, true)] {
        let data = Data::new(one);
        for (direction, (number, highlight)) in TURNS.into_iter().zip([
            (0, Highlight::Reflection),
            (1, Highlight::HalfVector),
            (0, Highlight::Reflection),
        ]) {
            let lighting = lighting(number);
            let mut scene = data.scene(direction, &lighting, fine);
            let made = made(&scene);
            assert_eq!(made.table.colours.is_null(), one);
            // What is not needed is not written.
            assert_eq!(made.colours[0] == [7; 4], one);
            assert_eq!(made.table.roots, made.roots.as_ptr());
            scene.fast = &made.table;
            let unlit = from_c(slicecast_fast_unlit(), &scene, &data);
            assert_eq!(
                unlit,
                from_rust(
                    &scene,
                    &data,
                    Fast::<_, _, _, FrontToBack>::new(table(&data, fine), Unlit)
                )
            );
            let lit = from_c(slicecast_fast_lit(), &scene, &data);
            assert_eq!(
                lit,
                from_rust(
                    &scene,
                    &data,
                    Fast::<_, _, _, FrontToBack>::new(table(&data, fine), phong(highlight))
                )
            );
            assert_ne!(unlit, lit);
            assert!(lit.iter().collect::<BTreeSet<_>>().len() > 40);
        }
    }
}

/// Code and argument of what was reported.
type Found = (i32, u32);

fn found(run: impl FnOnce(*mut SlicecastError) -> i32) -> Found {
    let mut error = SlicecastError {
        code: 99,
        argument: 99,
        needed: 99,
        given: 99,
        row: 99,
        column: 99,
    };
    let code = run(&mut error);
    assert_eq!(code, error.code);
    (code, error.argument)
}

/// What a scene is refused with.
fn opened(scene: &SlicecastScene, pipeline: *const SlicecastPipeline) -> Found {
    let mut memory = vec![0_u64; 1 << 16];
    let (block, mut stream) = (memory.as_mut_ptr().cast(), null_mut());
    // SAFETY: good pointers, but for those of the scene that are refused.
    found(|error| unsafe { slicecast_open(pipeline, scene, 0, 0, block, 8 << 16, &mut stream, error) })
}

#[test]
fn what_is_no_scene_of_16_bit_lanes_is_refused() {
    let (data, lights) = (Data::new(false), lighting(0));
    let good = data.scene(TURNS[0], &lights, false);
    let made = made(&good);
    let (unlit, lit) = (slicecast_fast_unlit(), slicecast_fast_lit());
    let over = |table: &SlicecastFastTable, lighting| SlicecastScene {
        fast: table,
        lighting,
        ..good
    };
    assert_eq!(opened(&over(&made.table, null()), unlit), (SLICECAST_OK, 0));
    assert_eq!(opened(&over(&made.table, &lights), lit), (SLICECAST_OK, 0));
    assert_eq!(opened(&good, unlit), (SLICECAST_NULL, 2));
    assert_eq!(opened(&over(&made.table, null()), lit), (SLICECAST_NULL, 2));
    let no_roots = SlicecastFastTable {
        roots: null(),
        ..made.table
    };
    assert_eq!(opened(&over(&no_roots, null()), unlit), (SLICECAST_NULL, 2));
    let beside = SlicecastFastTable {
        colours: made.table.colours.cast::<u8>().wrapping_add(1).cast(),
        ..made.table
    };
    assert_eq!(opened(&over(&beside, null()), unlit), (SLICECAST_MISALIGNED, 2));
    let strong = SlicecastLighting {
        ambient: [u32::MAX; 3],
        ..lights
    };
    assert_eq!(opened(&over(&made.table, &strong), lit).0, SLICECAST_COEFFICIENT);
    let highlight = lighting(2);
    assert_eq!(opened(&over(&made.table, &highlight), lit).0, SLICECAST_HIGHLIGHT);
}

#[test]
fn what_is_no_table_of_16_bit_lanes_is_refused() {
    let data = Data::new(false);
    let good = data.scene(TURNS[0], null(), true);
    let (mut roots, mut colours) = ([0; ENTRIES], [[0; 4]; ENTRIES + 1]);
    let (roots, colours) = (roots.as_mut_ptr(), colours.as_mut_ptr().cast::<u16>());
    let mut table = SlicecastFastTable {
        roots: null(),
        colours: null(),
        colour: [0; 3],
    };
    let mut of = |scene: *const SlicecastScene, roots: *mut u32, colours: *mut u16| {
        // SAFETY: good pointers, but for those that are refused.
        found(|error| unsafe { slicecast_fast_table(scene, roots, colours, &mut table, error) })
    };
    assert_eq!(of(&good, roots, colours), (SLICECAST_OK, 0));
    assert_eq!(of(null(), roots, colours), (SLICECAST_NULL, 1));
    assert_eq!(of(&good, null_mut(), colours), (SLICECAST_NULL, 2));
    assert_eq!(
        of(&good, roots.cast::<u8>().wrapping_add(1).cast(), colours),
        (SLICECAST_MISALIGNED, 2)
    );
    assert_eq!(of(&good, roots, null_mut()), (SLICECAST_NULL, 3));
    assert_eq!(
        of(&good, roots, colours.cast::<u8>().wrapping_add(1).cast()),
        (SLICECAST_MISALIGNED, 3)
    );
    let no_entries = SlicecastScene {
        entries: null(),
        ..good
    };
    assert_eq!(of(&no_entries, roots, colours), (SLICECAST_NULL, 1));
    let no_low = SlicecastScene {
        low_roots: null(),
        ..good
    };
    assert_eq!(of(&no_low, roots, colours), (SLICECAST_NULL, 1));
    // One colour needs no memory.
    let one = Data::new(true);
    let scene = one.scene(TURNS[0], null(), false);
    assert_eq!(of(&scene, roots, null_mut()), (SLICECAST_OK, 0));
    // SAFETY: good pointers, but for the one that is refused.
    let code = unsafe { slicecast_fast_table(&scene, roots, null_mut(), null_mut(), null_mut()) };
    assert_eq!(code, SLICECAST_NULL);
    assert_eq!(table.colour, [9, 200, 77].map(|byte| byte * 257));
}
