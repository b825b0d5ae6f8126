//! The C functions, called as C would: the same bits as from Rust, and every misuse is a code with its numbers.

use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use slicecast::borders::Borders;
use slicecast::classify::{Classifier, Colour16, Linear, PointTable, Sqrt16, entry};
use slicecast::clip::{Clip, Clips, Cue};
use slicecast::composite::FrontToBack;
use slicecast::composite::Unorm16;
use slicecast::crop::Crop;
use slicecast::format::{Coefficient, Direction, Distance, Intensity, Position, Vector};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::Compact;
use slicecast::shade::{Highlight, Light, Phong};
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast_ffi::*;

const DIMS: [u32; 3] = [7, 6, 5];

/// Data that a scene borrows.
struct Data {
    entries: Box<[u32; ENTRIES]>,
    low: Box<[u8; ENTRIES]>,
    low_colours: Box<[[u8; 3]; ENTRIES]>,
    lights: [SlicecastLight; 1],
    lighting: SlicecastLighting,
    voxels: Vec<u16>,
}

impl Data {
    fn new() -> Box<Self> {
        let mut data = Box::new(Self {
            entries: Box::new([0; ENTRIES]),
            low: Box::new([3; ENTRIES]),
            low_colours: Box::new([[200, 7, 99]; ENTRIES]),
            lights: [SlicecastLight {
                direction: [0, 18918, -26755].map(|c| c << 15),
                half: [0, 9000, -31500].map(|c| c << 15),
                diffuse: [20000, 18000, 16000],
                specular: [6000 << 16; 3],
            }],
            lighting: SlicecastLighting {
                ambient: [5000 << 16; 3],
                viewer: [0, 0, -32768 << 15],
                highlight: 0,
                exponent_log2: 4,
                count: 1,
                lights: null(),
            },
            voxels: Vec::new(),
        });
        for (i, e) in data.entries.iter_mut().enumerate() {
            *e = entry([i as u8, (i >> 3) as u8, 200], (i >> 5) as u8);
        }
        let len: u32 = DIMS.iter().product();
        data.voxels = (0..len).map(|i| (i.wrapping_mul(2_654_435_761) >> 20) as u16).collect();
        data.lighting.lights = data.lights.as_ptr();
        data
    }

    fn scene(&self) -> SlicecastScene {
        SlicecastScene {
            version: SLICECAST_VERSION,
            dims: DIMS,
            direction: [1 << 56, -(1 << 55), 1 << 57],
            spacing: [32768, 32768, 20000],
            planes_per_voxel: 2,
            rays_per_voxel: 2,
            interpolation: 0,
            borders: 0,
            crop_low: [0; 3],
            crop_high: [0; 3],
            entries: self.entries.as_ptr(),
            low_roots: self.low.as_ptr(),
            low_colours: self.low_colours.as_ptr().cast(),
            lighting: &self.lighting,
            integrals: null(),
            surfaces: null(),
            surface_count: 0,
            medium: SlicecastMedium::default(),
            fast: null(),
        }
    }
}

fn needs(pipeline: *const SlicecastPipeline, scene: &SlicecastScene, rows: u32) -> SlicecastNeeds {
    let mut needs = SlicecastNeeds::default();
    // SAFETY: good pointers.
    let code = unsafe { slicecast_needs(pipeline, scene, rows, &mut needs, null_mut()) };
    assert_eq!(code, SLICECAST_OK);
    needs
}

/// A block of memory, aligned to 8.
fn block(bytes: usize) -> Vec<u64> {
    vec![0x5a5a_5a5a_5a5a_5a5a; bytes.div_ceil(8)]
}

fn no_error() -> SlicecastError {
    SlicecastError {
        code: 99,
        argument: 99,
        needed: 99,
        given: 99,
        row: 99,
        column: 99,
    }
}

fn render(pipeline: *const SlicecastPipeline, data: &Data, first: u32, rows: u32) -> Vec<u16> {
    render_scene(pipeline, data, data.scene(), first, rows)
}

fn render_scene(
    pipeline: *const SlicecastPipeline,
    data: &Data,
    scene: SlicecastScene,
    first: u32,
    rows: u32,
) -> Vec<u16> {
    render_clipped(pipeline, data, scene, [first, rows], &[], null())
}

fn render_clipped(
    pipeline: *const SlicecastPipeline,
    data: &Data,
    scene: SlicecastScene,
    [first, rows]: [u32; 2],
    planes: &[SlicecastClip],
    cue: *const SlicecastCue,
) -> Vec<u16> {
    let needs = needs(pipeline, &scene, rows);
    let mut memory = block(needs.bytes);
    let (mut stream, mut image, mut bytes) = (null_mut(), null::<c_void>(), 0);
    // SAFETY: good pointers.
    unsafe {
        let block = memory.as_mut_ptr().cast();
        let code = slicecast_open(
            pipeline,
            &scene,
            first,
            rows,
            block,
            needs.bytes,
            &mut stream,
            null_mut(),
        );
        assert_eq!(code, SLICECAST_OK);
        let mut clips = MaybeUninit::<SlicecastClips>::uninit();
        if !planes.is_empty() || !cue.is_null() {
            let given = slicecast_clip(
                stream,
                planes.as_ptr(),
                planes.len(),
                cue,
                clips.as_mut_ptr(),
                null_mut(),
            );
            assert_eq!(given, SLICECAST_OK);
        }
        let mut number = 0;
        while slicecast_wanted(stream, &mut number, null_mut()) == SLICECAST_OK {
            // What the scene looks at, row by row.
            let (width, [column, row, _]) = (needs.slice_width as usize, needs.first.map(|n| n as usize));
            let rows = row..row + needs.slice_voxels / width;
            let [columns, all, _] = DIMS.map(|side| side as usize);
            let slice: Vec<u16> = rows
                .flat_map(|row| {
                    let start = (number as usize * all + row) * columns + column;
                    data.voxels[start..start + width].iter().copied()
                })
                .collect();
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

/// The same frame from Rust.
fn from_rust(data: &Data) -> Vec<u16> {
    type Table<'a> = PointTable<'a, Sqrt16, Linear>;
    from_rust_over(data, Table::new(&data.entries, &data.low), |plan| plan)
}

/// The same frame from Rust, over a table, on a plan changed as given.
fn from_rust_over<C: Classifier<Compact>>(data: &Data, table: C, change: impl Fn(Plan) -> Plan) -> Vec<u16> {
    from_rust_clipped(data, table, change, &[], None)
}

fn from_rust_clipped<C: Classifier<Compact>>(
    data: &Data,
    table: C,
    change: impl Fn(Plan) -> Plan,
    clips: &[Clip],
    cue: Option<Cue>,
) -> Vec<u16> {
    let scene = data.scene();
    let view = View::new(scene.direction.map(Direction::from_bits)).unwrap();
    let sampling = Sampling {
        planes_per_voxel: 2,
        rays_per_voxel: 2,
    };
    let plan = change(Plan::whole(view, DIMS, Spacing(scene.spacing.map(Intensity::from_bits)), sampling).unwrap());
    let lights = data.lights.map(|l| Light {
        direction: l.direction.map(Vector::from_bits),
        half: l.half.map(Vector::from_bits),
        diffuse: l.diffuse.map(Coefficient::from_bits),
        specular: l.specular.map(Coefficient::from_bits),
    });
    let (ambient, viewer) = (
        data.lighting.ambient.map(Coefficient::from_bits),
        data.lighting.viewer.map(Vector::from_bits),
    );
    let phong = Phong::new(Compact, ambient, &lights, viewer, Highlight::Reflection, 4).unwrap();
    let pipeline = Composite::<Compact, _, _, FrontToBack>::new(Compact, table, phong);
    let needs = Needs::of::<Composite<Compact, C, Phong<Compact>, FrontToBack>>(&plan);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![Unorm16(0); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut clips = Clips::new(&plan, clips).unwrap();
    if let Some(cue) = cue {
        clips = clips.with_cue(&plan, &cue).unwrap();
    }
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    if !clips.planes().is_empty() || clips.cue().is_some() {
        stream.clip(clips.clipper()).unwrap();
    }
    let len = (DIMS[0] * DIMS[1]) as usize;
    while let Some(number) = stream.wanted() {
        stream.push(&data.voxels[number as usize * len..][..len]).unwrap();
    }
    stream.image().iter().map(|c| c.0).collect()
}

#[test]
fn c_and_rust_have_the_same_bits() {
    let data = Data::new();
    let rust = from_rust(&data);
    assert!(
        rust.iter().any(|c| *c != 0 && *c != u16::MAX),
        "an empty picture proves nothing"
    );
    assert_eq!(render(slicecast_compact_lit(), &data, 0, 0), rust);
}

#[test]
fn colours_of_16_bits_are_those_of_rust() {
    let data = Data::new();
    let table = PointTable::<Colour16, Linear>::new(&data.entries, (&data.low, &data.low_colours));
    let rust = from_rust_over(&data, table, |plan| plan);
    assert_eq!(render(slicecast_compact_lit_colour16(), &data, 0, 0), rust);
    assert_ne!(rust, from_rust(&data), "low bytes that change nothing prove nothing");
}

#[test]
fn nearest_samples_are_those_of_rust() {
    let data = Data::new();
    let table = PointTable::<Sqrt16, Linear>::new(&data.entries, &data.low);
    let rust = from_rust_over(&data, table, Plan::with_nearest);
    let scene = SlicecastScene {
        interpolation: 1,
        ..data.scene()
    };
    assert_eq!(render_scene(slicecast_compact_lit(), &data, scene, 0, 0), rust);
    assert_ne!(
        rust,
        from_rust(&data),
        "interpolation that changes nothing proves nothing"
    );
}

#[test]
fn exact_borders_are_those_of_rust() {
    let data = Data::new();
    let whole = from_rust(&data);
    for (number, borders) in [(1, Borders::Cells), (2, Borders::Nodes)] {
        let exact = |plan: Plan| {
            let [factors, dims] = [
                plan.view().restore(plan.spacing()).map(|f| f.to_bits() as u32),
                plan.view().restore(plan.dims()),
            ];
            let spacing = Spacing(factors.map(|f| Intensity::from_bits(f as u16)));
            Plan::with_borders(*plan.view(), dims, spacing, plan.sampling(), borders).unwrap()
        };
        let table = PointTable::<Sqrt16, Linear>::new(&data.entries, &data.low);
        let rust = from_rust_over(&data, table, exact);
        let scene = SlicecastScene {
            borders: number,
            ..data.scene()
        };
        assert_eq!(render_scene(slicecast_compact_lit(), &data, scene, 0, 0), rust);
        assert_ne!(rust, whole, "borders that change nothing prove nothing");
    }
}

/// A box, of whose slices Rust is given all and C what it looks at; open along y.
#[test]
fn crops_are_those_of_rust() {
    let data = Data::new();
    let (low, high) = ([180_000, i32::MIN, 131_072], [229_000, i32::MAX, 200_000]);
    let table = PointTable::<Sqrt16, Linear>::new(&data.entries, &data.low);
    let cells = |plan: Plan| {
        let spacing = Spacing(plan.view().restore(plan.spacing()));
        Plan::with_borders(*plan.view(), DIMS, spacing, plan.sampling(), Borders::Cells).unwrap()
    };
    let crop = Crop {
        low: low.map(Position::from_bits),
        high: high.map(Position::from_bits),
    };
    let rust = from_rust_over(&data, table, |plan| cells(plan).with_crop(crop).unwrap());
    let scene = SlicecastScene {
        borders: 1,
        crop_low: [low[0], 0, low[2]],
        crop_high: [high[0], 0, high[2]],
        ..data.scene()
    };
    let needs = needs(slicecast_compact_lit(), &scene, 0);
    // From 2.75 to 3.49, half a voxel and one more on each side; from 2 to 3.05.
    assert_eq!((needs.first, needs.slice_width, needs.slices), ([1, 0, 0], 5, 5));
    assert_eq!(render_scene(slicecast_compact_lit(), &data, scene, 0, 0), rust);
    assert!(rust.iter().any(|c| *c != 0 && *c != u16::MAX), "an empty picture");
}

/// A plane and a soft slab that is cut away.
#[test]
fn clip_planes_are_those_of_rust() {
    let data = Data::new();
    let planes = [
        SlicecastClip {
            slope: [1 << 29, -(1 << 30), 1 << 28],
            outside: 0,
            distance: 3 << 29,
            thickness: 0,
            falloff: 0,
        },
        SlicecastClip {
            slope: [0, 1 << 28, 1 << 30],
            outside: 1,
            distance: -(2 << 30),
            thickness: 1 << 29,
            falloff: 3 << 29,
        },
    ];
    let clips = planes.map(|plane| Clip {
        slope: plane.slope.map(Vector::from_bits),
        distance: Distance::from_bits(plane.distance),
        thickness: (plane.thickness > 0).then(|| Distance::from_bits(plane.thickness)),
        falloff: Distance::from_bits(plane.falloff),
        outside: plane.outside == 1,
    });
    let table = || PointTable::<Sqrt16, Linear>::new(&data.entries, &data.low);
    let whole = from_rust_over(&data, table(), |plan| plan);
    for count in [1, 2] {
        let rust = from_rust_clipped(&data, table(), |plan| plan, &clips[..count], None);
        let (lit, scene) = (slicecast_compact_lit(), data.scene());
        let found = render_clipped(lit, &data, scene, [0, 0], &planes[..count], null());
        assert_eq!(found, rust);
        assert_ne!(rust, whole, "planes that change nothing prove nothing");
    }
    let cue = SlicecastCue {
        slope: [1 << 28, 0, 1 << 29],
        most: 50_000,
        distance: 1 << 28,
        depth: 2 << 30,
        colour: [3000, 0, 20_000],
    };
    let rust_cue = Cue {
        slope: cue.slope.map(Vector::from_bits),
        distance: Distance::from_bits(cue.distance),
        depth: Distance::from_bits(cue.depth),
        most: cue.most,
        colour: cue.colour.map(Intensity::from_bits),
    };
    for count in [0, 1] {
        let rust = from_rust_clipped(&data, table(), |plan| plan, &clips[..count], Some(rust_cue));
        let (lit, scene) = (slicecast_compact_lit(), data.scene());
        let found = render_clipped(lit, &data, scene, [0, 0], &planes[..count], &cue);
        assert_eq!(found, rust);
        assert_ne!(
            rust,
            from_rust_clipped(&data, table(), |plan| plan, &clips[..count], None)
        );
    }
}

/// Every misuse of clip planes.
#[test]
fn clip_planes_that_are_none_are_codes() {
    let data = Data::new();
    let scene = data.scene();
    let needs = needs(slicecast_compact_lit(), &scene, 0);
    let mut memory = block(needs.bytes);
    let good = SlicecastClip {
        slope: [1 << 30, 0, 0],
        outside: 0,
        distance: 0,
        thickness: 0,
        falloff: 0,
    };
    let mut stream = null_mut();
    // SAFETY: good pointers, but for those that are meant to be refused.
    unsafe {
        let block = memory.as_mut_ptr().cast();
        let opened = slicecast_open(
            slicecast_compact_lit(),
            &scene,
            0,
            0,
            block,
            needs.bytes,
            &mut stream,
            null_mut(),
        );
        assert_eq!(opened, SLICECAST_OK);
        let mut clips = MaybeUninit::<SlicecastClips>::uninit();
        let mut give_both = |planes: &[SlicecastClip], cue: *const SlicecastCue| {
            let mut error = MaybeUninit::<SlicecastError>::uninit();
            let code = slicecast_clip(
                stream,
                planes.as_ptr(),
                planes.len(),
                cue,
                clips.as_mut_ptr(),
                error.as_mut_ptr(),
            );
            let SlicecastError { needed, given, row, .. } = error.assume_init();
            (code, needed, given, row)
        };
        let turned = SlicecastCue {
            slope: [1 << 30; 3],
            most: 65536,
            distance: 0,
            depth: 1,
            colour: [32768; 3],
        };
        for wrong in [
            SlicecastCue { most: 65537, ..turned },
            SlicecastCue { depth: 0, ..turned },
            SlicecastCue {
                colour: [0, 32769, 0],
                ..turned
            },
            SlicecastCue {
                slope: [0, i32::MAX, 0],
                ..turned
            },
            SlicecastCue {
                distance: i64::MIN,
                ..turned
            },
        ] {
            assert_eq!(give_both(&[], &wrong).0, SLICECAST_CUE);
        }
        assert_eq!(give_both(&[], &turned).0, SLICECAST_OK);
        let mut give = |planes: &[SlicecastClip]| give_both(planes, null());
        assert_eq!(give(&[good; 7]), (SLICECAST_CLIP_COUNT, 6, 7, 0));
        let none = SlicecastClip { slope: [0; 3], ..good };
        assert_eq!(give(&[good, none]), (SLICECAST_CLIP, 1, 0, 1));
        let steep = SlicecastClip {
            slope: [0, 0, i32::MIN],
            ..good
        };
        assert_eq!(give(&[steep]), (SLICECAST_CLIP, 1 << 30, 0, 0));
        for far in [
            SlicecastClip {
                distance: (1 << 46) + 1,
                ..good
            },
            SlicecastClip {
                distance: i64::MIN,
                ..good
            },
            SlicecastClip { thickness: -1, ..good },
            SlicecastClip { falloff: -1, ..good },
            SlicecastClip {
                falloff: i64::MAX,
                ..good
            },
        ] {
            assert_eq!(give(&[good, good, far]), (SLICECAST_CLIP, 1 << 46, 0, 2));
        }
        assert_eq!(give(&[good; 6]), (SLICECAST_OK, 0, 0, 0));
        let mut number = 0;
        assert_eq!(slicecast_wanted(stream, &mut number, null_mut()), SLICECAST_OK);
        let slice = &data.voxels[number as usize * needs.slice_voxels..][..needs.slice_voxels];
        assert_eq!(
            slicecast_push(stream, slice.as_ptr(), slice.len(), null_mut()),
            SLICECAST_OK
        );
        assert_eq!(give(&[good]).0, SLICECAST_BEGUN);
    }
}

#[test]
fn bands_are_the_whole() {
    let data = Data::new();
    let whole = render(slicecast_compact_lit(), &data, 0, 0);
    let needs = needs(slicecast_compact_lit(), &data.scene(), 0);
    let row = 4 * needs.columns as usize;
    let phase = row * needs.rows as usize;
    for rows in 1..=needs.rows {
        let mut first = 0;
        while first < needs.rows {
            let rows = rows.min(needs.rows - first);
            let band = render(slicecast_compact_lit(), &data, first, rows);
            let band_phase = row * rows as usize;
            for (number, part) in band.chunks_exact(band_phase).enumerate() {
                let start = number * phase + first as usize * row;
                assert_eq!(part, &whole[start..start + band_phase]);
            }
            first += rows;
        }
    }
}

#[test]
fn every_pipeline_runs() {
    let data = Data::new();
    let all: [(*const SlicecastPipeline, u32); 10] = [
        (slicecast_paper_unlit(), 2),
        (slicecast_paper_lit(), 2),
        (slicecast_compact_unlit(), 2),
        (slicecast_compact_lit(), 2),
        (slicecast_wide_unlit(), 4),
        (slicecast_wide_lit(), 4),
        (slicecast_compact_unlit_colour16(), 2),
        (slicecast_compact_lit_colour16(), 2),
        (slicecast_wide_unlit_colour16(), 4),
        (slicecast_wide_lit_colour16(), 4),
    ];
    let mut images: Vec<Vec<u16>> = Vec::new();
    for (pipeline, element_bytes) in all {
        assert_eq!(needs(pipeline, &data.scene(), 0).element_bytes, element_bytes);
        let image = render(pipeline, &data, 0, 0);
        assert!(!images.contains(&image));
        images.push(image);
    }
}

#[test]
fn misused_arguments_are_named_with_numbers() {
    let data = Data::new();
    let (pipeline, scene) = (slicecast_compact_lit(), data.scene());
    let needs = needs(pipeline, &scene, 0);
    let mut memory = block(needs.bytes + 8);
    let memory: *mut c_void = memory.as_mut_ptr().cast();
    let mut error = no_error();
    let mut stream = null_mut();
    // SAFETY: good pointers, and the bad ones that the functions promise to refuse.
    unsafe {
        let mut out = SlicecastNeeds::default();
        assert_eq!(slicecast_needs(null(), &scene, 0, &mut out, &mut error), SLICECAST_NULL);
        assert_eq!(error.argument, 1);
        assert_eq!(
            slicecast_needs(pipeline, null(), 0, &mut out, &mut error),
            SLICECAST_NULL
        );
        assert_eq!(error.argument, 2);
        assert_eq!(
            slicecast_needs(pipeline, &scene, 0, null_mut(), &mut error),
            SLICECAST_NULL
        );
        assert_eq!(error.argument, 4);
        let crooked = (&raw const scene).byte_add(1);
        assert_eq!(
            slicecast_needs(pipeline, crooked, 0, &mut out, &mut error),
            SLICECAST_MISALIGNED
        );
        assert_eq!(
            (error.argument, error.needed, error.given),
            (2, 8, crooked.addr() as i64)
        );

        let mut open = |memory: *mut c_void, bytes, scene: &SlicecastScene, first, rows| {
            let code = slicecast_open(pipeline, scene, first, rows, memory, bytes, &mut stream, &mut error);
            assert_eq!(code, error.code);
            assert_eq!(code != SLICECAST_OK, stream.is_null());
            (code, error.argument, error.needed, error.given)
        };
        let short = needs.bytes - 1;
        assert_eq!(
            open(memory, short, &scene, 0, 0),
            (SLICECAST_LENGTH, 6, needs.bytes as i64, short as i64)
        );
        assert_eq!(open(null_mut(), needs.bytes, &scene, 0, 0).0, SLICECAST_NULL);
        let crooked = memory.byte_add(4);
        assert_eq!(
            open(crooked, needs.bytes, &scene, 0, 0),
            (SLICECAST_MISALIGNED, 5, 8, crooked.addr() as i64)
        );
        let other = SlicecastScene { version: 1, ..scene };
        assert_eq!(
            open(memory, needs.bytes, &other, 0, 0),
            (SLICECAST_VERSION_MISMATCH, 0, 7, 1)
        );
        let rows = i64::from(needs.rows);
        assert_eq!(
            open(memory, needs.bytes, &scene, 3, needs.rows),
            (SLICECAST_BAND, 0, rows, rows + 3)
        );
        assert_eq!(open(memory, needs.bytes, &scene, u32::MAX, 1).0, SLICECAST_BAND);
        let huge = SlicecastScene {
            dims: [8192; 3],
            rays_per_voxel: 8,
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &huge, 0, 0).0, SLICECAST_LENGTH);
        let flat = SlicecastScene {
            dims: [7, 0, 5],
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &flat, 0, 0), (SLICECAST_SIDE, 0, 8192, 0));
        let still = SlicecastScene {
            direction: [0; 3],
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &still, 0, 0).0, SLICECAST_DIRECTION);
        let between = SlicecastScene {
            interpolation: 2,
            ..scene
        };
        assert_eq!(
            open(memory, needs.bytes, &between, 0, 0),
            (SLICECAST_INTERPOLATION, 0, 1, 2)
        );
        let nowhere = SlicecastScene { borders: 3, ..scene };
        assert_eq!(open(memory, needs.bytes, &nowhere, 0, 0), (SLICECAST_BORDERS, 0, 2, 3));
        let thin = SlicecastScene {
            dims: [7, 1, 5],
            borders: 2,
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &thin, 0, 0), (SLICECAST_BORDERS, 0, 1, 2));
        let cropped = SlicecastScene {
            borders: 1,
            crop_low: [0, 1 << 16, 0],
            crop_high: [0, 1 << 16, 0],
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &cropped, 0, 0), (SLICECAST_CROP, 0, 0, 1));
        let beside = SlicecastScene {
            crop_low: [0, 0, 1 << 22],
            crop_high: [0, 0, 1 << 23],
            ..cropped
        };
        assert_eq!(open(memory, needs.bytes, &beside, 0, 0), (SLICECAST_CROP, 0, 1, 2));
        let whole = SlicecastScene { borders: 0, ..beside };
        assert_eq!(open(memory, needs.bytes, &whole, 0, 0), (SLICECAST_CROP, 0, 2, 0));
        let bare = SlicecastScene {
            entries: null(),
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &bare, 0, 0).0, SLICECAST_NULL);
        let dark = SlicecastScene {
            lighting: null(),
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &dark, 0, 0).0, SLICECAST_NULL);
        let lit = |lighting: SlicecastLighting| lighting;
        let crowd = lit(SlicecastLighting {
            count: 9,
            ..data.lighting
        });
        let crowded = SlicecastScene {
            lighting: &crowd,
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &crowded, 0, 0), (SLICECAST_LIGHTS, 0, 8, 9));
        let third = lit(SlicecastLighting {
            highlight: 2,
            ..data.lighting
        });
        let odd = SlicecastScene {
            lighting: &third,
            ..scene
        };
        assert_eq!(open(memory, needs.bytes, &odd, 0, 0), (SLICECAST_HIGHLIGHT, 0, 1, 2));
        assert_eq!(open(memory, needs.bytes, &scene, 0, 0).0, SLICECAST_OK);
    }
}

#[test]
fn tables_that_a_pipeline_needs_are_asked_for() {
    let data = Data::new();
    let scene = SlicecastScene {
        low_colours: null(),
        ..data.scene()
    };
    for (pipeline, expected) in [
        (slicecast_wide_unlit(), SLICECAST_OK),
        (slicecast_wide_unlit_colour16(), SLICECAST_NULL),
    ] {
        let needs = needs(pipeline, &scene, 0);
        let mut memory = block(needs.bytes);
        let (mut stream, mut error) = (null_mut(), no_error());
        // SAFETY: good pointers, and a null one that the function promises to refuse.
        let code = unsafe {
            let block = memory.as_mut_ptr().cast();
            slicecast_open(pipeline, &scene, 0, 0, block, needs.bytes, &mut stream, &mut error)
        };
        assert_eq!(code, expected);
    }
}

#[test]
fn misused_streams_are_refused_and_go_on() {
    let data = Data::new();
    let (pipeline, scene) = (slicecast_wide_unlit(), data.scene());
    let needs = needs(pipeline, &scene, 0);
    let mut memory = block(needs.bytes);
    let mut error = no_error();
    let mut stream = null_mut();
    // SAFETY: good pointers, and the bad ones that the functions promise to refuse.
    unsafe {
        let block: *mut c_void = memory.as_mut_ptr().cast();
        // A block that no stream was opened in.
        assert_eq!(
            slicecast_push(block.cast(), data.voxels.as_ptr(), 42, &mut error),
            SLICECAST_FOREIGN
        );
        let opened = slicecast_open(pipeline, &scene, 0, 0, block, needs.bytes, &mut stream, &mut error);
        assert_eq!(opened, SLICECAST_OK);
        assert_eq!(
            slicecast_push(null_mut(), data.voxels.as_ptr(), 42, &mut error),
            SLICECAST_NULL
        );
        assert_eq!(slicecast_push(stream, null(), 42, &mut error), SLICECAST_NULL);
        assert_eq!(
            slicecast_push(stream, data.voxels.as_ptr(), 41, &mut error),
            SLICECAST_LENGTH
        );
        assert_eq!((error.needed, error.given), (42, 41));
        assert_eq!(
            slicecast_push(stream, data.voxels.as_ptr(), usize::MAX, &mut error),
            SLICECAST_LENGTH
        );
        let mut bad = data.voxels[..42].to_vec();
        bad[10] = 4096;
        assert_eq!(slicecast_push(stream, bad.as_ptr(), 42, &mut error), SLICECAST_VOXEL);
        assert_eq!((error.needed, error.given, error.row, error.column), (4095, 4096, 1, 3));
        let mut number = 77;
        assert_eq!(slicecast_wanted(stream, &mut number, null_mut()), SLICECAST_OK);
        assert_eq!(number, 0);
        assert_eq!(slicecast_wanted(stream, null_mut(), null_mut()), SLICECAST_NULL);
        for slice in data.voxels.chunks_exact(42) {
            assert_eq!(slicecast_push(stream, slice.as_ptr(), 42, &mut error), SLICECAST_OK);
            assert_eq!(
                error,
                SlicecastError {
                    code: 0,
                    argument: 0,
                    needed: 0,
                    given: 0,
                    row: 0,
                    column: 0
                }
            );
        }
        assert_eq!(
            slicecast_push(stream, data.voxels.as_ptr(), 42, &mut error),
            SLICECAST_COMPLETE
        );
        assert_eq!(slicecast_wanted(stream, &mut number, null_mut()), SLICECAST_COMPLETE);
        let warp = SlicecastWarp {
            origin: [0; 2],
            right: [1 << 32, 0],
            down: [0, 1 << 32],
        };
        let (background, mut rgb) = ([0u16; 3], [0u8; 10]);
        let mut row = |bytes| {
            slicecast_picture_row(
                stream,
                &warp,
                5,
                background.as_ptr(),
                rgb.as_mut_ptr(),
                bytes,
                &mut error,
            )
        };
        assert_eq!(row(10), SLICECAST_LENGTH);
        assert_eq!(row(9), SLICECAST_OK);
        assert!(rgb.iter().any(|c| *c != 0));
    }
}

#[test]
fn the_library_tells_its_version() {
    assert_eq!(slicecast_version(), SLICECAST_VERSION);
}

/// The warp of a view is core's, and what is out of range comes back as a number.
#[test]
fn warps_of_views_are_cores() {
    use slicecast::format::Step;
    use slicecast::screen::Screen;
    let data = Data::new();
    let scene = data.scene();
    let screen = SlicecastScreen {
        size: [40, 30],
        right: [1 << 31, 1 << 29, -(1 << 30)],
        down: [3, -(1 << 31), 1 << 28],
    };
    let mut warp = SlicecastWarp {
        origin: [0; 2],
        right: [0; 2],
        down: [0; 2],
    };
    let mut error = no_error();
    let mut made = |screen: &SlicecastScreen, error: &mut SlicecastError| {
        // SAFETY: good pointers.
        unsafe { slicecast_warp(&scene, screen, &mut warp, error) }
    };
    assert_eq!(made(&screen, &mut error), SLICECAST_OK);
    let wide = SlicecastScreen {
        size: [40, 16385],
        ..screen
    };
    assert_eq!(made(&wide, &mut error), SLICECAST_PICTURE);
    assert_eq!((error.needed, error.given), (16384, 16385));
    let coarse = SlicecastScreen {
        down: [0, 0, i64::MIN],
        ..screen
    };
    assert_eq!(made(&coarse, &mut error), SLICECAST_PIXEL);
    assert_eq!((error.needed, error.given), (1024 << 32, i64::MIN));
    // SAFETY: null is refused.
    let code = unsafe { slicecast_warp(&scene, null(), &mut warp, &mut error) };
    assert_eq!((code, error.argument), (SLICECAST_NULL, 2));

    let view = View::new(scene.direction.map(Direction::from_bits)).unwrap();
    let sampling = Sampling {
        planes_per_voxel: 2,
        rays_per_voxel: 2,
    };
    let plan = Plan::whole(view, DIMS, Spacing(scene.spacing.map(Intensity::from_bits)), sampling).unwrap();
    let expected = Screen {
        size: screen.size,
        right: screen.right.map(Step::from_bits),
        down: screen.down.map(Step::from_bits),
    };
    let expected = expected.warp(&plan).unwrap();
    assert_eq!(warp.origin.map(Step::from_bits), expected.origin);
    assert_eq!(warp.right.map(Step::from_bits), expected.right);
    assert_eq!(warp.down.map(Step::from_bits), expected.down);
}

/// Codes are numbers that programs have compiled: they stay.
#[test]
fn one_error_has_the_codes_of_its_steps() {
    use slicecast::plan::PlanError;
    use slicecast::shade::PhongError;
    use slicecast::stream::StreamError;
    use slicecast::view::ViewError;
    let code = |error: slicecast::Error| SlicecastError::from(error).code;
    assert_eq!(code(ViewError::NoDirection.into()), -6);
    assert_eq!(code(PlanError::Side { given: 0 }.into()), -7);
    assert_eq!(code(PhongError::Lights { given: 9 }.into()), -12);
    assert_eq!(code(StreamError::Complete.into()), 1);
    assert_eq!(code(slicecast::screen::ScreenError::Side { given: 0 }.into()), -20);
}
