//! Volumes in boxes of several levels: the bits of the whole where there is one level, the model's numbers where there are more.

use std::ops::Range;

use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::LevelsError;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::Frame;
use slicecast_engine::levels::Leveled;
use slicecast_engine::levels::budget::{Limits, Losses};
use slicecast_engine::levels::tree::Tree;
use slicecast_engine::simd::Simd;
use slicecast_engine::source::Source;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_host_tests::random::{Filling, Random, volume};
use slicecast_model::{BoxOfLevel, Levels, Segments};
use slicecast_pyramid::scalar::halved;
use slicecast_scene::file::built_in;
use slicecast_scene::{Blend, Borders, Classification, Interpolation, PrecisionName, Scene, Surface};
use slicecast_volume::Volume;

use crate::parts::{crop, on_disk};

/// A scene that is rendered in several levels.
fn scene(random: &mut Random) -> Scene {
    let mut pick = |count: u32| random.below(count);
    let mut scene = built_in(["headsq", "ct-fog", "ct-bone", "ct-fog8"][pick(4) as usize]).unwrap();
    scene.precision = [PrecisionName::Paper, PrecisionName::Compact, PrecisionName::Wide][pick(3) as usize];
    scene.view.azimuth = f64::from(pick(360)) - 180.0;
    scene.view.elevation = f64::from(pick(181)) - 90.0;
    if pick(4) == 0 {
        scene.view.azimuth = 45.0 * f64::from(pick(8));
        scene.view.elevation = 90.0 * f64::from(pick(3)) - 90.0;
    }
    scene.sampling.planes_per_voxel = 1 + pick(3);
    scene.sampling.rays_per_voxel = 1 + pick(3);
    scene.borders = Borders::Cells;
    scene.classification = [Classification::Point, Classification::Point, Classification::Integral][pick(3) as usize];
    scene.transfer.unit_distance = 1.0;
    scene.transfer.points.iter_mut().for_each(|point| point.value += 1024.0);
    if pick(4) == 0 {
        scene.blend = Blend::BackToFront;
    }
    if pick(4) == 0 {
        scene.crop = Some(crop(&mut pick));
    }
    scene
}

/// A tree of cuts anywhere, down to boxes of one voxel, of levels that fit their faces.
fn tree(random: &mut Random, dims: [usize; 3], voxels: &[Range<usize>; 3], depth: u32) -> Tree {
    let axis = random.below(3) as usize;
    let grain = 1 << random.below(4);
    let (Range { start, end }, cut) = (voxels[axis].clone(), random.below(depth + 2) > 0);
    let at = (start + random.below((end - start) as u32) as usize) / grain * grain;
    if depth > 0 && cut && at > start {
        let part = |random: &mut Random, range: Range<usize>| {
            let mut voxels = voxels.clone();
            voxels[axis] = range;
            tree(random, dims, &voxels, depth - 1)
        };
        let parts = Box::new([part(random, start..at), part(random, at..end)]);
        return Tree::Cut { axis, at, parts };
    }
    let fits = |level: u32| {
        let whole = |at: usize, all: usize| at.is_multiple_of(1 << level) || at == all;
        (voxels.iter().zip(dims)).all(|(side, all)| whole(side.start, 0) && whole(side.end, all))
    };
    Tree::Leaf((0..=random.below(4)).rev().find(|level| fits(*level)).unwrap_or(0))
}

fn random_tree(random: &mut Random, dims: [usize; 3]) -> Tree {
    tree(random, dims, &dims.map(|side| 0..side), 4)
}

fn rendered(prepared: &Prepared<'_>, tree: &Tree) -> Frame {
    let leveled = Leveled::new(prepared, tree).unwrap();
    let bricks = leveled.bricks(prepared.volume, &|_, _| ()).unwrap();
    leveled.render(&bricks, &|_, _| ()).unwrap()
}

#[test]
fn one_box_of_level_0_is_the_whole_frame() {
    let mut random = Random::new(77);
    let fillings = [Filling::Noise, Filling::Sparse, Filling::Ball, Filling::Ripples];
    for case in 0..80_u64 {
        let dims = [(); 3].map(|()| 2 + random.below(22) as usize);
        let mut volume = volume(dims, fillings[random.below(4) as usize], case);
        volume.spacing = [1.0, 0.7, 1.9];
        let scene = scene(&mut random);
        let simd: Vec<Simd> = Simd::available().collect();
        let prepared = Prepared::new(&scene, &volume)
            .unwrap()
            .with_simd(simd[random.below(simd.len() as u32) as usize]);
        let expected = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap();
        assert!(
            expected == rendered(&prepared, &Tree::Leaf(0)),
            "case {case}: {scene:?}"
        );
        // A grid whose bricks are all of level 0 is one box.
        assert_eq!(Tree::of_grid(dims, 8, &|_| 0), Tree::Leaf(0));
    }
}

/// A field without a place where its gradient has no direction.
fn slope([nx, ny, nz]: [usize; 3]) -> Volume {
    let code = |n: usize| {
        let [x, y, z] = [n % nx, n / nx % ny, n / nx / ny];
        (1200 + 55 * x + 40 * y + 30 * z + x * y) as u16
    };
    Volume {
        voxels: (0..nx * ny * nz).map(code).collect(),
        ..volume([nx, ny, nz], Filling::Constant(0), 0)
    }
}

/// All levels, odd sides and boxes of one voxel against the model, which clips each ray at each box and sorts them by where it enters.
/// And the boxes in the other order, which differ.
#[test]
fn boxes_of_levels_are_those_of_the_model() {
    let mut random = Random::new(1206);
    let (mut wrong, mut several, mut worst) = (0, 0, [0.0f64; 2]);
    for case in 0..130_u64 {
        let dims = [(); 3].map(|()| 1 + random.below(20) as usize);
        let mut scene = scene(&mut random);
        scene.precision = PrecisionName::Wide;
        // Of samples, steps eight voxels long through what is nearly opaque in one are beyond a table's opacities:
        // docs/contract/levels.md, Error.
        if scene.classification != Classification::Integral {
            scene.transfer.points.iter_mut().for_each(|point| point.opacity *= 0.5);
        }
        let mut finest = volume(dims, [Filling::Ball, Filling::Ripples][case as usize % 2], case);
        if scene.lighting.is_some() {
            finest = slope(dims);
        }
        finest.spacing = [1.0, 0.8, 1.25];
        let tree = random_tree(&mut random, dims);
        let Ok(prepared) = Prepared::new(&scene, &finest) else {
            continue;
        };
        let leveled = Leveled::new(&prepared, &tree).unwrap();
        let mut bricks = leveled.bricks(&finest, &|_, _| ()).unwrap();
        let found = leveled.render(&bricks, &|_, _| ()).unwrap();
        let mut volumes = vec![finest.clone()];
        for level in 0..3 {
            volumes.push(halved(&volumes[level]));
        }
        let leaves = tree.leaves(dims, [true; 3]).unwrap();
        let boxes: Vec<BoxOfLevel<'_>> = (leaves.iter())
            .map(|leaf| BoxOfLevel {
                volume: &volumes[leaf.level as usize],
                level: leaf.level,
                voxels: leaf.voxels.clone(),
            })
            .collect();
        let uncropped = Scene {
            crop: None,
            ..scene.clone()
        };
        let lattice = model(&prepared, ModelPositions::Exact).lattice();
        let segments = match scene.classification {
            Classification::Integral => Segments::Binned,
            _ => Segments::Not,
        };
        let crop = scene.crop.map(|crop| crop.faces(finest.spacing));
        let of_model = Levels::new(&uncropped, (dims, finest.spacing), lattice, &boxes, crop, segments).render();
        let [width, height] = lattice.size;
        assert_eq!(found.base.size, lattice.size);
        for at in 0..width * height {
            let [red, green, blue] = &of_model.rgb;
            for (plane, exact) in found.base.planes.iter().zip([red, green, blue, &of_model.t]) {
                let away = 255.0 * (f64::from(plane[at]) / f64::from(found.base.one) - exact[at]).abs();
                let lit = usize::from(scene.lighting.is_some());
                worst[lit] = worst[lit].max(away);
                assert!(
                    away < [0.01, 0.1][lit],
                    "case {case}: {away} at {} {}: {scene:?} {tree:?}",
                    at % width,
                    at / width
                );
            }
        }
        if bricks.len() > 1 {
            several += 1;
            bricks.reverse();
            wrong += u32::from(leveled.render(&bricks, &|_, _| ()).unwrap().base != found.base);
        }
    }
    println!("unlit, lit: at most {worst:?} of 255; {wrong} of {several} differ in the other order");
    assert!(several > 50 && wrong > several / 2, "{wrong} of {several}");
}

#[test]
fn steps_that_are_too_opaque_are_said_to_be() {
    let volume = volume([16; 3], Filling::Ball, 1);
    let mut scene = Scene {
        borders: Borders::Cells,
        ..built_in("ct-bone").unwrap()
    };
    scene.transfer.unit_distance = 1.0;
    scene.sampling.planes_per_voxel = 1;
    let said = |scene: &Scene, level: u32| {
        let prepared = Prepared::new(scene, &volume).unwrap();
        let leveled = Leveled::new(&prepared, &Tree::Leaf(level)).unwrap();
        leveled.opaque_steps().map(|steps| steps.to_string())
    };
    let most = |scene: &mut Scene, opacity: f64| {
        scene
            .transfer
            .points
            .iter_mut()
            .for_each(|point| point.opacity = point.opacity.min(opacity));
    };
    most(&mut scene, 0.6);
    assert_eq!(said(&scene, 0), None);
    let words = said(&scene, 3).unwrap();
    assert!(words.contains("at level 3") && words.contains("--planes 2 "), "{words}");
    let finer = Scene {
        sampling: slicecast_scene::Sampling {
            planes_per_voxel: 2,
            ..scene.sampling
        },
        ..scene.clone()
    };
    assert_eq!(said(&finer, 3), None);
    let segments = Scene {
        classification: Classification::Integral,
        ..scene.clone()
    };
    assert_eq!(said(&segments, 3), None);
    most(&mut scene, 0.1);
    assert_eq!(said(&scene, 3), None);
}

#[test]
fn what_levels_do_not_do_is_refused() {
    let volume = volume([9, 8, 7], Filling::Ball, 1);
    let fog = Scene {
        borders: Borders::Cells,
        ..built_in("ct-fog").unwrap()
    };
    let refused = |scene: Scene, tree: Tree| match Prepared::new(&scene, &volume)
        .map(|prepared| Leveled::new(&prepared, &tree).err())
    {
        Ok(Some(RenderError::Levels(error))) => error,
        other => panic!("{other:?}"),
    };
    let leaf = || Tree::Leaf(1);
    assert_eq!(
        refused(
            Scene {
                borders: Borders::Nodes,
                ..fog.clone()
            },
            leaf()
        ),
        LevelsError::Borders
    );
    assert_eq!(
        refused(
            Scene {
                blend: Blend::Maximum,
                ..fog.clone()
            },
            leaf()
        ),
        LevelsError::Projection
    );
    let surfaces = vec![Surface::of(900.0, slicecast_scene::Face::default())];
    assert_eq!(
        refused(
            Scene {
                surfaces,
                ..fog.clone()
            },
            leaf()
        ),
        LevelsError::Surfaces
    );
    let clipped = Scene {
        clips: vec![slicecast_scene::clip::Clip::new([4.0; 3], [1.0, 0.0, 0.0])],
        ..fog.clone()
    };
    assert_eq!(refused(clipped, leaf()), LevelsError::Clipped);
    let cued = Scene {
        cueing: Some(slicecast_scene::cueing::Cueing::default()),
        ..fog.clone()
    };
    assert_eq!(refused(cued, leaf()), LevelsError::Clipped);
    let nearest = Interpolation::Nearest;
    assert_eq!(
        refused(
            Scene {
                interpolation: nearest,
                ..fog.clone()
            },
            leaf()
        ),
        LevelsError::Nearest
    );
    let auto = Classification::Auto;
    assert_eq!(
        refused(
            Scene {
                classification: auto,
                ..fog.clone()
            },
            leaf()
        ),
        LevelsError::Automatic
    );
    assert!(matches!(refused(fog.clone(), Tree::Leaf(4)), LevelsError::Level(_)));
    let cut = Tree::Cut {
        axis: 2,
        at: 3,
        parts: Box::new([Tree::Leaf(0), Tree::Leaf(1)]),
    };
    assert!(matches!(
        refused(fog, cut),
        LevelsError::Face {
            level: 1,
            from: 3,
            to: 7
        }
    ));
}

/// The mean of eight voxels is a volume's own where it is read in part.
#[test]
fn parts_of_levels_are_the_levels() {
    let mut random = Random::new(5);
    for case in 0..20_u64 {
        let dims = [(); 3].map(|()| 9 + random.below(12) as usize);
        let volume: Volume = volume(dims, Filling::Noise, case);
        let scene = scene(&mut random);
        let prepared = Prepared::new(&scene, &volume).unwrap();
        let level = 1 + random.below(3);
        let coarse = (0..level).fold(volume.clone(), |volume, _| halved(&volume));
        let cut = Tree::Cut {
            axis: 1,
            at: 8,
            parts: Box::new([Tree::Leaf(level), Tree::Leaf(level)]),
        };
        let leveled = Leveled::new(&prepared, &cut).unwrap();
        for brick in leveled.bricks(&volume, &|_, _| ()).unwrap() {
            let (first, held) = brick.held();
            let [nx, ny, _] = coarse.dims;
            for (number, code) in brick.voxels().voxels.iter().enumerate() {
                let [x, y, z] = [number % held[0], number / held[0] % held[1], number / held[0] / held[1]];
                let at = ((first[2] + z) * ny + first[1] + y) * nx + first[0] + x;
                assert_eq!(*code, coarse.voxels[at], "case {case}");
            }
        }
    }
}

/// Noise that the table hides in one half, something to be seen in the other; from the file and from memory.
#[test]
fn budgets_are_kept_and_spend_on_what_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let mut volume = volume([96, 70, 64], Filling::Noise, 3);
    for (at, code) in volume.voxels.iter_mut().enumerate() {
        let [x, y] = [at % 96, at / 96 % 70];
        *code = if x < 64 {
            *code % 1000
        } else {
            (1300 + 40 * (y % 32)) as u16
        };
    }
    let (loaded, on_disk) = on_disk(&volume, &folder);
    let mut scene = built_in("ct-fog").unwrap();
    scene.borders = Borders::Cells;
    scene.transfer.points = vec![(0.0, 0.0), (1250.0, 0.0), (2600.0, 0.3)]
        .into_iter()
        .map(|(value, opacity)| slicecast_scene::Point {
            value,
            colour: [1.0, 0.8, 0.5],
            opacity,
        })
        .collect();
    scene.transfer.unit_distance = 1.0;
    let prepared = Prepared::new(&scene, &loaded.volume).unwrap();
    let losses = Losses::of(&prepared, &on_disk, &|_, _| ()).unwrap();
    let ordered = losses.ordered(&prepared, &on_disk, false).unwrap();
    let within = |memory: u64| {
        let memory = Some(memory);
        ordered.within(Limits { memory, work: None })
    };
    let whole = within(u64::MAX).unwrap();
    assert_eq!(
        (whole.tree.clone(), whole.bricks, whole.loss),
        (Tree::Leaf(0), [18, 0, 0, 0], 0.0)
    );
    let Err(LevelsError::Budget { least, .. }) = within(1 << 20) else {
        panic!("1 MiB is enough");
    };
    assert!(within(least - 1).is_err());
    assert_eq!(within(least).unwrap().bricks, [0, 0, 0, 18]);
    // Steps of an eighth of what there is between.
    let mut last = whole;
    for eighths in (0..8).rev() {
        let memory = least + (last.all.max(least) - least) / 8 * eighths;
        let chosen = within(memory).unwrap();
        assert!(chosen.all <= memory && chosen.loss >= 0.0);
        last = chosen;
    }
    // Half of the voxels: what is hidden is coarse, and costs nothing.
    let whole = within(u64::MAX).unwrap();
    let chosen = within(whole.all - whole.bytes / 2).unwrap();
    let leaves = chosen.tree.leaves(volume.dims, [true; 3]).unwrap();
    assert!(
        leaves.iter().all(|leaf| leaf.level == 0 || leaf.voxels[0].end <= 64),
        "{leaves:?}"
    );
    assert!(chosen.loss == 0.0 && chosen.bricks[0] >= 6, "{chosen}");
    let of = |prepared: &Prepared<'_>, source: &dyn Source| {
        let leveled = Leveled::new(prepared, &chosen.tree).unwrap();
        let bricks = leveled.bricks(source, &|_, _| ()).unwrap();
        for brick in &bricks {
            assert_eq!(brick.held().1, brick.leaf.held(volume.dims));
        }
        assert_eq!(bricks.iter().map(|brick| brick.bytes()).sum::<u64>(), chosen.bytes);
        leveled.render(&bricks, &|_, _| ()).unwrap()
    };
    let in_memory = Prepared::new(&scene, &volume).unwrap();
    assert!(of(&prepared, &on_disk) == of(&in_memory, &volume));
}
