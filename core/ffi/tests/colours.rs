//! Volumes of colour and extinction from C: frames have Rust's bits, and every misuse is a code with its numbers.

use core::ffi::c_void;
use core::ptr::{null, null_mut};

use slicecast::absorption::Medium;
use slicecast::borders::Borders;
use slicecast::classify::entry;
use slicecast::composite::{Channel, Weighted};
use slicecast::extinction::Given;
use slicecast::format::{Coefficient, Direction, Intensity, Vector};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::{Pipeline, Rgba};
use slicecast::precision::{Compact, Precision, Wide};
use slicecast::shade::{Highlight, Light, Phong, Shader};
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::view::View;
use slicecast_ffi::*;

const DIMS: [u32; 3] = [7, 6, 5];

/// Directions along each axis, whose slices have different sides.
const TURNS: [[i64; 3]; 3] = [
    [1 << 56, -(1 << 55), 1 << 57],
    [-(1 << 57), 1 << 53, 1 << 56],
    [5 << 52, 1 << 57, -(3 << 54)],
];

const MEDIUM: SlicecastMedium = SlicecastMedium {
    mantissa: 1_400_000_000,
    exponent: 19,
};

const LIGHT: SlicecastLight = SlicecastLight {
    direction: [0, 18918 << 15, -(26755 << 15)],
    half: [0, 9000 << 15, -(31500 << 15)],
    diffuse: [20000 << 16, 18000 << 16, 16000 << 16],
    specular: [6000 << 16; 3],
};

fn lighting() -> SlicecastLighting {
    SlicecastLighting {
        ambient: [5000 << 16; 3],
        viewer: [0, 0, -(32768 << 15)],
        highlight: 1,
        exponent_log2: 4,
        count: 1,
        lights: &LIGHT,
    }
}

/// Entries of as many voxels as a slice has, and low bytes of their roots; a third is empty.
fn slice(number: u32, voxels: usize) -> (Vec<u32>, Vec<u8>) {
    let hash = |i: usize| (i as u32 + 1000 * number).wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995;
    let of = |i: usize| {
        let [r, g, b, root] = hash(i).to_le_bytes();
        if hash(i) % 3 == 0 {
            (entry([r, g, b], 0), 0)
        } else {
            (entry([r, g, b], root), r ^ root)
        }
    };
    (0..voxels).map(of).unzip()
}

fn scene(direction: [i64; 3], lighting: *const SlicecastLighting) -> SlicecastScene {
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
        entries: null(),
        low_roots: null(),
        low_colours: null(),
        lighting,
        integrals: null(),
        surfaces: null(),
        surface_count: 0,
        medium: MEDIUM,
        fast: null(),
    }
}

/// The image of a frame from C, as bits; slices as codes made row by row.
fn from_c(pipeline: *const SlicecastPipeline, scene: &SlicecastScene, fine: bool) -> Vec<u32> {
    let mut needs = SlicecastNeeds::default();
    let (mut stream, mut number, mut image, mut bytes) = (null_mut(), 0, null::<c_void>(), 0);
    // SAFETY: good pointers.
    unsafe {
        assert_eq!(
            slicecast_needs(pipeline, scene, 0, &mut needs, null_mut()),
            SLICECAST_OK
        );
        let mut memory = vec![0x5a5a_5a5a_5a5a_5a5a_u64; needs.bytes.div_ceil(8)];
        let block = memory.as_mut_ptr().cast();
        let code = slicecast_open(pipeline, scene, 0, 0, block, needs.bytes, &mut stream, null_mut());
        assert_eq!(code, SLICECAST_OK);
        let width = needs.slice_width as usize;
        while slicecast_wanted(stream, &mut number, null_mut()) == SLICECAST_OK {
            let (entries, low) = slice(number, needs.slice_voxels);
            let mut codes = vec![0xffff_u16; 4 * needs.slice_voxels];
            for (row, codes) in codes.chunks_mut(4 * width).enumerate() {
                let low = if fine { low[row * width..].as_ptr() } else { null() };
                let entries = entries[row * width..].as_ptr();
                let code = slicecast_codes(entries, low, width, codes.as_mut_ptr(), null_mut());
                assert_eq!(code, SLICECAST_OK);
            }
            assert_eq!(
                slicecast_push(stream, codes.as_ptr(), codes.len(), null_mut()),
                SLICECAST_OK
            );
        }
        assert_eq!(
            slicecast_image(stream, &mut image, &mut bytes, null_mut()),
            SLICECAST_OK
        );
        assert_eq!(bytes, needs.image_bytes);
        if needs.element_bytes == 2 {
            let elements = core::slice::from_raw_parts(image.cast::<u16>(), bytes / 2);
            elements.iter().map(|bits| u32::from(*bits)).collect()
        } else {
            core::slice::from_raw_parts(image.cast::<u32>(), bytes / 4).to_vec()
        }
    }
}

/// The same from Rust, from entries.
fn from_rust<P: Precision<Pixel: Weighted>, S: Shader<P>>(
    scene: &SlicecastScene,
    pipeline: Rgba<P, S>,
    fine: bool,
) -> Vec<u32>
where
    <Rgba<P, S> as Pipeline>::Element: Channel,
{
    let view = View::new(scene.direction.map(Direction::from_bits)).unwrap();
    let sampling = Sampling {
        planes_per_voxel: scene.planes_per_voxel,
        rays_per_voxel: scene.rays_per_voxel,
    };
    let spacing = Spacing(scene.spacing.map(Intensity::from_bits));
    let plan = Plan::with_borders(view, scene.dims, spacing, sampling, Borders::Cells).unwrap();
    let needs = Needs::of::<Rgba<P, S>>(&plan);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![Default::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    let [width, height, _] = plan.dims();
    while let Some(number) = stream.wanted() {
        let (entries, low) = slice(number, (width * height) as usize);
        let low = fine.then_some(&low[..]);
        stream.push(Given::Entries { entries: &entries, low }).unwrap();
    }
    stream.image().iter().map(|element| element.bits()).collect()
}

fn phong<P: Precision>(p: P) -> Phong<P> {
    let vector = |bits: [i32; 3]| bits.map(Vector::from_bits);
    let coefficient = |bits: [u32; 3]| bits.map(Coefficient::from_bits);
    let SlicecastLighting { ambient, viewer, .. } = lighting();
    let light = Light {
        direction: vector(LIGHT.direction),
        half: vector(LIGHT.half),
        diffuse: coefficient(LIGHT.diffuse),
        specular: coefficient(LIGHT.specular),
    };
    let (ambient, viewer) = (coefficient(ambient), vector(viewer));
    Phong::new(p, ambient, &[light], viewer, Highlight::HalfVector, 4).unwrap()
}

#[test]
fn frames_of_colours_are_those_of_rust() {
    let lighting = lighting();
    let medium = Medium::new(MEDIUM.mantissa, MEDIUM.exponent).unwrap();
    for direction in TURNS {
        let scene = scene(direction, &lighting);
        for fine in [false, true] {
            let images = [
                (
                    from_c(slicecast_compact_unlit_rgba(), &scene, fine),
                    from_rust(&scene, Rgba::new(Compact, medium), fine),
                ),
                (
                    from_c(slicecast_compact_lit_rgba(), &scene, fine),
                    from_rust(&scene, Rgba::shaded(Compact, medium, phong(Compact)), fine),
                ),
                (
                    from_c(slicecast_wide_unlit_rgba(), &scene, fine),
                    from_rust(&scene, Rgba::new(Wide, medium), fine),
                ),
                (
                    from_c(slicecast_wide_lit_rgba(), &scene, fine),
                    from_rust(&scene, Rgba::shaded(Wide, medium, phong(Wide)), fine),
                ),
            ];
            for (number, (c, rust)) in images.iter().enumerate() {
                assert_eq!(c, rust, "{direction:?}, {fine}, pipeline {number}");
                assert!(c.iter().collect::<std::collections::BTreeSet<_>>().len() > 40);
            }
            assert_ne!(images[0].0, images[1].0);
        }
    }
}

/// Code, argument, needed, given, row and column of what was reported.
type Found = (i32, u32, i64, i64, u32, u32);

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
    (code, error.argument, error.needed, error.given, error.row, error.column)
}

/// What a scene is refused with.
fn opened(scene: &SlicecastScene, lit: bool) -> Found {
    let pipeline = if lit {
        slicecast_compact_lit_rgba()
    } else {
        slicecast_compact_unlit_rgba()
    };
    let mut memory = vec![0_u64; 1 << 16];
    let mut stream = null_mut();
    found(|error| {
        // SAFETY: good pointers, but for those of the scene that are refused.
        unsafe {
            slicecast_open(
                pipeline,
                scene,
                0,
                0,
                memory.as_mut_ptr().cast(),
                8 << 16,
                &mut stream,
                error,
            )
        }
    })
}

#[test]
fn what_is_no_scale_of_extinctions_is_refused_with_numbers() {
    let with = |mantissa, exponent| SlicecastScene {
        medium: SlicecastMedium { mantissa, exponent },
        ..scene(TURNS[0], null())
    };
    assert_eq!(opened(&with(1 << 30, 20), false), (SLICECAST_OK, 0, 0, 0, 0, 0));
    let one = i64::from(i32::MAX);
    assert_eq!(
        opened(&with(1 << 31, 20), false),
        (SLICECAST_MEDIUM, 0, one, one + 1, 0, 0)
    );
    assert_eq!(opened(&with(1 << 30, 13), false), (SLICECAST_MEDIUM, 0, 14, 13, 0, 0));
    assert_eq!(opened(&with(1 << 30, 36), false), (SLICECAST_MEDIUM, 0, 35, 36, 0, 0));
    assert_eq!(opened(&with(0, 0), false), (SLICECAST_MEDIUM, 0, 14, 0, 0, 0));
    assert_eq!(
        opened(&with(i32::MAX as u32, 14), false),
        (SLICECAST_MEDIUM, 0, 15, 0, 0, 0)
    );
    assert_eq!(opened(&with(1 << 30, 20), true), (SLICECAST_NULL, 2, 0, 0, 0, 0));
}

#[test]
fn what_are_no_codes_is_refused_with_numbers() {
    let scene = scene(TURNS[0], null());
    let (mut needs, mut stream) = (SlicecastNeeds::default(), null_mut());
    let mut memory = vec![0_u64; 1 << 16];
    // SAFETY: good pointers.
    unsafe {
        let pipeline = slicecast_wide_unlit_rgba();
        assert_eq!(
            slicecast_needs(pipeline, &scene, 0, &mut needs, null_mut()),
            SLICECAST_OK
        );
        let block = memory.as_mut_ptr().cast();
        assert_eq!(
            slicecast_open(pipeline, &scene, 0, 0, block, 8 << 16, &mut stream, null_mut()),
            SLICECAST_OK
        );
    }
    let (width, voxels) = (needs.slice_width as usize, needs.slice_voxels);
    let push = |codes: &[u16]| {
        // SAFETY: good pointers.
        found(|error| unsafe { slicecast_push(stream, codes.as_ptr(), codes.len(), error) })
    };
    let good = vec![0; 4 * voxels];
    let bad = |run: usize, code: u16| {
        let mut codes = good.clone();
        codes[2 * 4 * width + 3] = 700;
        codes[2 * 4 * width + run * width + 3] = code;
        codes
    };
    let (needed, given) = ((4 * voxels) as i64, voxels as i64);
    assert_eq!(push(&good[..voxels]), (SLICECAST_LENGTH, 3, needed, given, 0, 0));
    assert_eq!(push(&bad(0, 32768)), (SLICECAST_CODES, 0, 32767, 32768, 2, 3));
    assert_eq!(push(&bad(3, 701)), (SLICECAST_CODES, 0, 700, 701, 2, 3));
    // A good one may follow.
    assert_eq!(push(&bad(2, 700)), (SLICECAST_OK, 0, 0, 0, 0, 0));

    let (entries, mut codes) = ([entry([255, 128, 0], 255); 2], [0_u16; 8]);
    let out = codes.as_mut_ptr();
    // SAFETY: good pointers, but for those that are refused.
    let made = |entries: *const u32, low: *const u8, out: *mut u16, width| {
        found(|error| unsafe { slicecast_codes(entries, low, width, out, error) })
    };
    assert_eq!(made(null(), null(), out, 2), (SLICECAST_NULL, 1, 0, 0, 0, 0));
    assert_eq!(
        made(entries.as_ptr(), null(), null_mut(), 2),
        (SLICECAST_NULL, 4, 0, 0, 0, 0)
    );
    let misaligned = out.cast::<u8>().wrapping_add(1).cast::<u16>();
    assert_eq!(made(entries.as_ptr(), null(), misaligned, 2).0, SLICECAST_MISALIGNED);
    assert_eq!(made(entries.as_ptr(), null(), out, usize::MAX).0, SLICECAST_LENGTH);
    assert_eq!(made(entries.as_ptr(), null(), out, 2), (SLICECAST_OK, 0, 0, 0, 0, 0));
    assert_eq!(codes, [32767, 32767, 32767, 32767, 16447, 16447, 0, 0]);
}
