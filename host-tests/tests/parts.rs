//! Frames of volumes that stay on disk have the bits of frames of the same volumes in memory, however small the parts.

use std::fs;

use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::parts::Cut;
use slicecast_engine::shard::Shard;
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_host_tests::random::{Filling, Random, volume};
use slicecast_scene::clip::Clip;
use slicecast_scene::crop::{Crop, CropUnit};
use slicecast_scene::cueing::Cueing;
use slicecast_scene::file::built_in;
use slicecast_scene::{Blend, Borders, Classification, Face, Point, PrecisionName, Scene, Surface};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::on_disk::OnDisk;
use slicecast_volume::open::{Loaded, Options};
use slicecast_volume::raw::RawShape;
use slicecast_volume::raw::describe::Description;
use slicecast_volume::values::{Endian, ValueType};

/// A volume as a raw file, opened where it lies.
pub(crate) fn on_disk(volume: &Volume, folder: &tempfile::TempDir) -> (Loaded, OnDisk) {
    let path = folder.path().join("v.raw");
    let bytes: Vec<u8> = volume.voxels.iter().flat_map(|code| code.to_be_bytes()).collect();
    fs::write(&path, bytes).unwrap();
    let shape = RawShape {
        dims: volume.dims.map(|side| side as u64),
        spacing: volume.spacing,
        value_type: ValueType::U16,
        endian: Endian::Big,
        skip: 0,
    };
    let options = Options {
        raw: Some(Description {
            shape,
            scale: 1.0,
            offset: 0.0,
            modality: None,
            directions: None,
        }),
        ..Options::default()
    };
    let window = Window::Range { low: 0.0, high: 4095.0 };
    OnDisk::open(&path, window, &options, &|_, _| {}).unwrap()
}

/// A volume as a store of Zarr 2 of plain chunks of these sides, opened where it lies.
fn in_chunks(volume: &Volume, folder: &tempfile::TempDir, side: [usize; 3]) -> (Loaded, OnDisk) {
    let path = folder.path().join("v.zarr");
    fs::create_dir_all(&path).unwrap();
    for entry in fs::read_dir(&path).unwrap().flatten() {
        fs::remove_file(entry.path()).unwrap();
    }
    let [nx, ny, nz] = volume.dims;
    let [sx, sy, sz] = side;
    let metadata = format!(
        "{{\"zarr_format\":2,\"shape\":[{nz},{ny},{nx}],\"chunks\":[{sz},{sy},{sx}],\"dtype\":\">u2\",\"compressor\":null,\
         \"fill_value\":0,\"order\":\"C\",\"filters\":null}}"
    );
    fs::write(path.join(".zarray"), metadata).unwrap();
    let code = |x: usize, y: usize, z: usize| {
        let inside = x < nx && y < ny && z < nz;
        if inside {
            volume.voxels[(z * ny + y) * nx + x]
        } else {
            9
        }
    };
    for k in 0..nz.div_ceil(sz) {
        for j in 0..ny.div_ceil(sy) {
            for i in 0..nx.div_ceil(sx) {
                let mut chunk = Vec::new();
                for (z, y) in (0..sz).flat_map(|z| (0..sy).map(move |y| (z, y))) {
                    let row = (0..sx).flat_map(|x| code(i * sx + x, j * sy + y, k * sz + z).to_be_bytes());
                    chunk.extend(row);
                }
                fs::write(path.join(format!("{k}.{j}.{i}")), chunk).unwrap();
            }
        }
    }
    let window = Window::Range { low: 0.0, high: 4095.0 };
    OnDisk::open(&path, window, &Options::default(), &|_, _| {}).unwrap()
}

/// A random scene of any kind that a pipeline has.
fn scene(random: &mut Random) -> Scene {
    let mut pick = |count: u32| random.below(count);
    let mut scene = built_in(["headsq", "ct-fog", "ct-bone", "ct-fog8"][pick(4) as usize]).unwrap();
    scene.precision = [PrecisionName::Paper, PrecisionName::Compact, PrecisionName::Wide][pick(3) as usize];
    scene.view.azimuth = f64::from(pick(360)) - 180.0;
    scene.view.elevation = f64::from(pick(181)) - 90.0;
    scene.sampling.planes_per_voxel = 1 + pick(4);
    scene.sampling.rays_per_voxel = 1 + pick(2);
    let mapping = |point: &mut slicecast_scene::Point| point.value += 1024.0;
    scene.transfer.points.iter_mut().for_each(mapping);
    match pick(8) {
        0 => scene.blend = Blend::BackToFront,
        1 => scene.blend = Blend::Maximum,
        2 => scene.blend = Blend::Minimum,
        5 => scene.blend = Blend::Average,
        6 => scene.blend = Blend::Additive,
        3 => scene.classification = Classification::Integral,
        4 => {
            scene.classification = Classification::None;
            let face = Face {
                opacity: 0.4,
                ..Face::default()
            };
            scene.surfaces = vec![Surface::of(900.0, face), Surface::of(2500.5, face)];
        }
        _ => scene.borders = [Borders::Whole, Borders::Cells, Borders::Nodes][pick(3) as usize],
    }
    if pick(3) == 0 {
        if scene.borders == Borders::Whole {
            scene.borders = Borders::Cells;
        }
        scene.crop = Some(crop(&mut pick));
    }
    if pick(3) == 0 {
        scene.clips = (0..=pick(2)).map(|_| clip(&mut pick)).collect();
        scene.cueing = (pick(2) == 0 && !matches!(scene.blend, Blend::Maximum | Blend::Minimum)).then(Cueing::default);
    }
    scene
}

/// A plane through a place of a small volume, or a slab behind it, drawn or cut away.
fn clip(pick: &mut impl FnMut(u32) -> u32) -> Clip {
    let mut number = |count: u32| f64::from(pick(count));
    let point = [(); 3].map(|()| number(90) / 4.0);
    let normal = [number(9) - 4.0, number(9) - 4.0, number(4) + 0.5];
    Clip {
        thickness: Some(1.0 + number(40) / 4.0).filter(|t| *t < 6.0),
        falloff: [0.0, 0.0, 5.0][number(3) as usize],
        outside: number(3) == 0.0,
        ..Clip::new(point, normal)
    }
}

/// A box that holds something of every volume of two voxels or more along each side.
pub(super) fn crop(pick: &mut impl FnMut(u32) -> u32) -> Crop {
    let mut range = || {
        [
            [-1.0, 0.3, 0.75][pick(3) as usize],
            [1.2, 6.6, f64::INFINITY][pick(3) as usize],
        ]
    };
    Crop {
        ranges: [range(), range(), range()],
        unit: CropUnit::Voxels,
    }
}

/// What random volumes hold.
const FILLINGS: [Filling; 6] = [
    Filling::Noise,
    Filling::Extremes,
    Filling::Sparse,
    Filling::Boxes,
    Filling::Ball,
    Filling::Ripples,
];

#[test]
fn parts_are_the_whole_frame() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(1024);
    let mut cut = 0;
    for case in 0..120_u64 {
        let dims = [(); 3].map(|()| 2 + random.below(22) as usize);
        let mut volume = volume(dims, FILLINGS[random.below(6) as usize], case);
        volume.spacing = [1.0, 0.7, 1.9];
        // Every third one in chunks, whose store tells no spacing.
        let (loaded, on_disk) = if case % 3 == 2 {
            volume.spacing = [1.0; 3];
            in_chunks(&volume, &folder, [(); 3].map(|()| 1 + random.below(12) as usize))
        } else {
            on_disk(&volume, &folder)
        };
        let mut scene = scene(&mut random);
        scene.transfer.unit_distance = 1.0;
        let simd: Vec<Simd> = Simd::available().collect();
        let simd = simd[random.below(simd.len() as u32) as usize];
        let whole = Prepared::new(&scene, &volume).unwrap().with_simd(simd);
        let parted = Prepared::new(&scene, &loaded.volume).unwrap().with_simd(simd);
        let expected = whole.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        let most = 5 + random.below(4) as usize;
        let (found, reading) = parted
            .render_in_parts(&on_disk, Cut::of_slices(most), &|_, _| ())
            .unwrap();
        assert!(
            expected == found,
            "case {case}: {}, {scene:?}, parts of {most} slices",
            volume.name
        );
        assert!(reading.largest <= most.max(5));
        cut += u32::from(reading.parts > 1);
    }
    assert!(cut > 60, "{cut} of 120 frames had more than one part");
}

/// Any cut into bricks, of raw files and of chunks; and the same bricks in the other order beside each other, which are not it.
#[test]
fn bricks_are_the_whole_frame() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(4096);
    let (mut cut_across, mut wrong) = (0, 0);
    for case in 0..210_u64 {
        let dims = [(); 3].map(|()| 2 + random.below(28) as usize);
        let mut volume = volume(dims, FILLINGS[random.below(6) as usize], case);
        let (loaded, on_disk) = if case % 2 == 0 {
            volume.spacing = [1.0, 0.7, 1.9];
            on_disk(&volume, &folder)
        } else {
            volume.spacing = [1.0; 3];
            in_chunks(&volume, &folder, [(); 3].map(|()| 1 + random.below(12) as usize))
        };
        let mut scene = scene(&mut random);
        scene.precision = [PrecisionName::Paper, PrecisionName::Compact, PrecisionName::Wide][case as usize % 3];
        scene.transfer.unit_distance = 1.0;
        if random.below(2) == 0 {
            scene.borders = [Borders::Cells, Borders::Nodes][random.below(2) as usize];
        }
        let simd: Vec<Simd> = Simd::available().collect();
        let simd = simd[random.below(simd.len() as u32) as usize];
        let whole = Prepared::new(&scene, &volume).unwrap().with_simd(simd);
        let parted = Prepared::new(&scene, &loaded.volume).unwrap().with_simd(simd);
        let expected = whole.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        let mut side = |least: u32| match random.below(4) {
            0 => usize::MAX,
            _ => (least + random.below(14)) as usize,
        };
        let cut = Cut {
            slices: side(5),
            cells: [side(1), side(1)],
        };
        let (found, reading) = parted.render_in_parts(&on_disk, cut, &|_, _| ()).unwrap();
        assert!(expected == found, "case {case}: {}, {scene:?}, {cut:?}", volume.name);
        if reading.brick.is_none() || reading.parts < 2 {
            continue;
        }
        cut_across += 1;
        let mut rendering = parted.begun().unwrap();
        let mut parts = parted.parts(&*rendering, cut);
        for layer in parts.chunk_by_mut(|a, b| a.planes == b.planes) {
            layer.reverse();
        }
        for part in parts {
            let (first, dims) = parted.region(&part);
            let (sub, _) = on_disk.read(first, dims, None).unwrap();
            let mut turned = Turned::whole(&sub, parted.setup.plan.view());
            let slices = turned.slices().unwrap();
            rendering.fold_part(&Oriented::of(&slices), &part, Shard::ALL, simd, &|_, _| ());
        }
        wrong += u32::from(rendering.base() != expected.base);
    }
    assert!(
        cut_across > 100,
        "{cut_across} of 210 frames were cut across their slices"
    );
    assert!(
        wrong > 30,
        "{wrong} of {cut_across} frames differ where bricks come in the wrong order"
    );
}

/// Something in the middle of a volume that is empty elsewhere, from all sides.
#[test]
fn what_the_table_hides_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(77);
    let mut hidden = 0;
    for case in 0..40 {
        let dims = [19, 80, 40];
        let mut volume = volume(dims, Filling::Noise, case);
        for (index, code) in volume.voxels.iter_mut().enumerate() {
            let (y, z) = (index / dims[0] % dims[1], index / dims[0] / dims[1]);
            if !(33..46).contains(&y) || !(17..22).contains(&z) {
                *code = 7;
            }
        }
        let (loaded, on_disk) = on_disk(&volume, &folder);
        let scene = scene(&mut random);
        let whole = Prepared::new(&scene, &volume).unwrap();
        let parted = Prepared::new(&scene, &loaded.volume).unwrap();
        let expected = whole.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        let (found, reading) = parted.render_in_parts(&on_disk, Cut::of_slices(9), &|_, _| ()).unwrap();
        assert!(expected == found, "case {case}: {scene:?}");
        hidden += u32::from(2 * reading.voxels < reading.all);
    }
    assert!(hidden > 20, "of {hidden} of 40 frames half was left out");
}

/// Parts that lie on the side of a clip plane that is cut away.
#[test]
fn what_clip_planes_hide_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(91);
    let mut hidden = 0;
    for case in 0..40 {
        let volume = volume([14, 16, 120], Filling::Noise, case);
        let (loaded, on_disk) = on_disk(&volume, &folder);
        let mut scene = scene(&mut random);
        scene.crop = None;
        (scene.view.azimuth, scene.view.elevation) = (f64::from(random.below(30)), 80.0);
        let falloff = [0.0, 7.0][random.below(2) as usize];
        let slab = Clip {
            thickness: Some(9.0),
            falloff,
            ..Clip::new([5.0, 5.0, 50.0], [0.1, 0.0, [1.0, -1.0][random.below(2) as usize]])
        };
        let side = Clip {
            falloff,
            outside: random.below(2) == 0,
            ..Clip::new([5.0, 5.0, 60.0], [0.0, 0.2, 1.0])
        };
        scene.clips = [vec![slab], vec![side], vec![slab, side]][random.below(3) as usize].clone();
        let whole = Prepared::new(&scene, &volume).unwrap();
        let parted = Prepared::new(&scene, &loaded.volume).unwrap();
        let expected = whole.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        let (found, reading) = parted.render_in_parts(&on_disk, Cut::of_slices(8), &|_, _| ()).unwrap();
        assert!(expected == found, "case {case}: {scene:?}");
        let all = parted.parts(&*parted.begun().unwrap(), Cut::of_slices(8)).len();
        hidden += u32::from(3 * reading.parts < 2 * all);
    }
    assert!(
        hidden > 36,
        "a third of the parts was left out of {hidden} of 40 frames"
    );
}

#[test]
fn nothing_is_read_behind_what_is_opaque() {
    let folder = tempfile::tempdir().unwrap();
    let volume = volume([20, 20, 400], Filling::Constant(3000), 1);
    let (loaded, on_disk) = on_disk(&volume, &folder);
    let mut scene = built_in("ct-bone").unwrap();
    (scene.view.azimuth, scene.view.elevation) = (0.0, 90.0);
    scene.sampling.planes_per_voxel = 1;
    let whole = Prepared::new(&scene, &volume).unwrap();
    let parted = Prepared::new(&scene, &loaded.volume).unwrap();
    let expected = whole.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
    let (found, reading) = parted
        .render_in_parts(&on_disk, Cut::of_slices(12), &|_, _| ())
        .unwrap();
    assert!(expected == found);
    assert!(reading.slices <= 100 && reading.depth == 400, "{reading}");
}

#[test]
fn what_needs_more_memory_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (loaded, on_disk) = on_disk(&volume([9; 3], Filling::Noise, 1), &folder);
    let scene = built_in("ct-fog").unwrap();
    let prepared = Prepared::new(&scene, &loaded.volume).unwrap();
    let Err(RenderError::Budget { least, .. }) = prepared.cut_within(&on_disk, 1 << 20) else {
        panic!("1 MiB is enough");
    };
    assert!(matches!(
        prepared.cut_within(&on_disk, least - 1),
        Err(RenderError::Budget { .. })
    ));
    assert!(prepared.cut_within(&on_disk, least).unwrap().slices >= 5);
}

/// The same choice, and so the same bits.
#[test]
fn auto_looks_at_the_same_voxels_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = built_in("ct-fog").unwrap();
    scene.classification = Classification::Auto;
    let mut chosen = [0; 2];
    for case in 0..24 {
        let volume = volume([31, 33, 35], FILLINGS[case as usize % 6], case);
        let (loaded, on_disk) = if case % 2 == 0 {
            on_disk(&volume, &folder)
        } else {
            in_chunks(&volume, &folder, [7, 9, 8])
        };
        let peak = 1500.0 + 30.0 * case as f64;
        let wide = if case % 4 < 2 { 20.0 } else { 2600.0 };
        let point = |(value, opacity): (f64, f64)| Point {
            value,
            colour: [1.0, 0.8, 0.5],
            opacity,
        };
        let points = [(peak - wide, 0.0), (peak, 0.6), (peak + wide, 0.0)];
        scene.transfer.points = points.map(point).into();
        scene.transfer.unit_distance = 1.0;
        let mut whole = volume.clone();
        whole.spacing = loaded.volume.spacing;
        let whole = Prepared::new(&scene, &whole).unwrap();
        let parted = Prepared::of(&scene, &loaded.volume, &on_disk).unwrap();
        assert_eq!(whole.finest, parted.finest, "case {case}");
        chosen[usize::from(parted.segments.is_some())] += 1;
        let expected = whole.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        let (found, _) = parted.render_in_parts(&on_disk, Cut::of_slices(9), &|_, _| ()).unwrap();
        assert!(expected == found, "case {case}");
    }
    assert!(chosen[0] > 3 && chosen[1] > 3, "{chosen:?} of points and segments");
}
