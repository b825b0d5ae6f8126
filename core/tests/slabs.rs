//! Frames whose segments are classified: the plane layer, whole rows and blocks, by both single lanes, and the stream, against
//! the definitions ray by ray. The stream makes the front rows from its ring, the plane layer from all slices.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use slicecast::borders::{Borders, Part};
use slicecast::classify::Classifier;
use slicecast::composite::{BackToFront, Channel, Dither, FrontToBack, Order, Recurrence, settle};
use slicecast::cut::Cut;
use slicecast::format::{Coefficient, Direction, Intensity, Opacity, Position, Vector, Weight};
use slicecast::gradient::space;
use slicecast::integral::{Colours, Integral, Length};
use slicecast::interpolate::trilinear;
use slicecast::lanes::{Lanes, Small};
use slicecast::locate::{Cell, cell, cut, plane};
use slicecast::normalise::normalise;
use slicecast::plan::{Phase, Plan, Sampling, Spacing};
use slicecast::plane::{At, ChannelOf, Composite, Depth, Kept, NO_DEPTH, Pipeline, Rows, clear};
use slicecast::precision::{Compact, Precision, Wide};
use slicecast::seen::{Grain, Seen};
use slicecast::shade::{Highlight, Light, Phong, Shader, Unlit};
use slicecast::sides::Side;
use slicecast::sides::along_k;
use slicecast::slice::{Code12, RowRange, Slice, Window};
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::surface::{Face, Surface, VALUE_MAX};
use slicecast::view::View;

/// A volume in the slice frame.
struct Volume {
    voxels: Vec<u16>,
    dims: [usize; 3],
}

impl Volume {
    /// A voxel; the last one stands for those behind it.
    fn voxel(&self, at: [i32; 3]) -> i32 {
        let [w, h, _] = self.dims;
        let [i, j, k] = [0, 1, 2].map(|axis| (at[axis] as usize).min(self.dims[axis] - 1));
        i32::from(self.voxels[(k * h + j) * w + i])
    }

    /// A line of voxels continued linearly by one at each end.
    fn beyond(place: i32, n: i32, line: impl Fn(i32) -> i32) -> i32 {
        match place {
            _ if n == 1 => line(0),
            -1 => 2 * line(0) - line(1),
            p if p == n => 2 * line(n - 1) - line(n - 2),
            p => line(p),
        }
    }

    fn sides(&self) -> [i32; 3] {
        self.dims.map(|side| side as i32)
    }

    fn continued(&self, [i, j, k]: [i32; 3]) -> i32 {
        let [ni, nj, _] = self.sides();
        Self::beyond(i.min(ni), ni, |i| {
            Self::beyond(j.min(nj), nj, |j| self.voxel([i, j, k]))
        })
    }

    fn derivative(&self, [i, j, k]: [i32; 3]) -> i32 {
        let [_, _, nk] = self.sides();
        let along = |k: i32| Self::beyond(k, nk, |k| self.voxel([i, j, k]));
        let k = k.min(nk - 1);
        along(k + 1) - along(k - 1)
    }
}

fn at_cells<P: Precision>(p: P, cells: [Cell; 3], [di, dj]: [i32; 2], value: impl Fn([i32; 3]) -> i32) -> i32 {
    let [i, j, k] = cells.map(|cell| cell.index);
    let corners = [0, 1].map(|z| [0, 1].map(|y| [0, 1].map(|x| value([i + di + x, j + dj + y, k + z]) as i16)));
    trilinear(p, corners, cells.map(|cell| cell.weight))
}

/// The cells of a pixel's sample on a plane, if it lies inside.
fn cells(plan: &Plan, index: u32, [u, v]: [u32; 2]) -> Option<[Cell; 3]> {
    let at = plane(plan, Phase::default(), index);
    let mut cells = [at.x, at.y, at.z].map(cell);
    cells[0].index += u as i32;
    cells[1].index += v as i32;
    let inside = |(cell, side): (&Cell, u32)| {
        let last = side as i32 - 1;
        0 <= cell.index && (cell.index < last || cell.index == last && cell.weight == Weight::ZERO)
    };
    cells.iter().zip(plan.dims()).all(inside).then_some(cells)
}

/// The part of a pixel's segment that counts: the cells of its ends and where it lies in the segment, which begins at the plane
/// with this number.
struct Segment {
    ends: [[Cell; 3]; 2],
    part: Part,
}

/// It, where there is one: between samples that both lie inside, or what of it lies in the box, its ends held to the voxels.
fn segment(plan: &Plan, index: u32, [u, v]: [u32; 2]) -> Option<Segment> {
    if plan.borders() == Borders::Whole {
        let ends = [cells(plan, index, [u, v])?, cells(plan, index + 1, [u, v])?];
        return Some(Segment {
            ends,
            part: Part::WHOLE,
        });
    }
    let [start_i, start_j] = plan.start(Phase::default());
    let part = Side::behind(plan, start_i, 0, index)
        .part(u)
        .and(Side::behind(plan, start_j, 1, index).part(v))
        .and(along_k(plan, index));
    let held = |place| {
        let [x, y, z] = cut(plan, Phase::default(), index, place).map(|at| at.to_bits());
        let own = [x + ((u as i32) << 16), y + ((v as i32) << 16), z];
        [0, 1, 2].map(|axis| {
            let last = (plan.dims()[axis] as i32 - 1) << 16;
            cell(Position::from_bits(own[axis].clamp(0, last)))
        })
    };
    let ends = [part.from, part.to].map(held);
    (part.length() > 0).then_some(Segment { ends, part })
}

/// The classifier: segments of a table, or of none, cut at surfaces and into pieces.
type Segments<'a> = Cut<&'a [u32], &'a [Surface]>;

/// The frame, ray by ray: red, green, blue and transparency of each pixel.
fn defined<P: Precision>(
    p: P,
    plan: &Plan,
    volume: &Volume,
    table: &Segments<'_>,
    phong: Option<&Phong<P>>,
    back_to_front: bool,
) -> Vec<[u32; 4]> {
    let [width, height] = plan.base();
    let recurrence = p.pixel();
    let gradient = |cells| {
        let beside = |di, dj| at_cells(p, cells, [di, dj], |at| volume.continued(at));
        let g = [
            beside(1, 0) - beside(-1, 0),
            beside(0, 1) - beside(0, -1),
            at_cells(p, cells, [0; 2], |at| volume.derivative(at)),
        ];
        let factors = plan.spacing();
        [0, 1, 2].map(|axis| space(g[axis], factors[axis]))
    };
    let pixel = |at: [u32; 2]| {
        let mut pixel = recurrence.clear();
        for step in 1..plan.ends() {
            let index = if back_to_front { plan.ends() - step } else { step };
            let Some(Segment {
                ends: [front, back],
                part,
            }) = segment(plan, index - 1, at)
            else {
                continue;
            };
            let fraction = part.length();
            let ends = [front, back].map(|cells| at_cells(p, cells, [0; 2], |at| volume.voxel(at)));
            let parts = table.parts_of(p, ends);
            for turn in 0..parts {
                let part = if back_to_front { parts - 1 - turn } else { turn };
                let opacity = table.part_opacity(p, ends, fraction, part);
                let mut colour = table.part_colour(p, ends, fraction, part);
                if let Some(phong) = phong {
                    let (front, back) = (gradient(front), gradient(back));
                    let turn = table.turn(p, ends, part);
                    let normal = [0, 1, 2].map(|axis| match part % 2 {
                        0 => front[axis] + back[axis],
                        _ => turn.gradient(front[axis], back[axis]),
                    });
                    colour = phong.shade(normalise(normal), colour);
                }
                let dither = Dither::of_part(index, part);
                if back_to_front {
                    pixel = recurrence.under(pixel, colour, opacity, dither);
                } else {
                    pixel = recurrence.over(pixel, colour, opacity, dither);
                    pixel.transparency = settle(pixel.transparency, recurrence.floor());
                }
            }
        }
        let [r, g, b] = pixel.colour.map(Channel::bits);
        [r, g, b, pixel.transparency.bits()]
    };
    (0..height)
        .flat_map(|v| (0..width).map(move |u| [u, v]))
        .map(pixel)
        .collect()
}

/// The pixels of an image whose rows are runs.
fn pixels<C: Channel>(plan: &Plan, image: &[C]) -> Vec<[u32; 4]> {
    let width = plan.base()[0] as usize;
    let rows = image.chunks_exact(4 * width);
    rows.flat_map(|row| (0..width).map(move |u| [0, 1, 2, 3].map(|channel| row[channel * width + u].bits())))
        .collect()
}

/// How the plane layer makes the samples of a slab.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Whole rows, those in front again.
    Rows,
    /// Whole rows, those in front kept where they have been made.
    Kept,
    /// All blocks.
    Blocks,
}

/// The image by the plane layer, in tiles of some rows.
fn by_planes<L: Pipeline<Voxel = Code12>, V: Lanes>(
    pipeline: &L,
    plan: &Plan,
    slices: &[Slice<'_>],
    tile: usize,
    way: Way,
) -> Vec<L::Element> {
    let [base_width, base_height] = plan.base().map(|side| side as usize);
    let [width, height, _] = plan.dims();
    let row_len = L::CHANNELS * base_width;
    let mut image = vec![L::Element::default(); row_len * base_height];
    clear(pipeline, plan, &mut image);
    let blocks = way == Way::Blocks;
    let len = if blocks {
        L::SHAPE.blocks_scratch_len(width)
    } else {
        L::SHAPE.scratch_len(width)
    };
    let mut scratch = vec![0x5555_5555; len];
    let every =
        vec![u64::MAX >> (64 - (width as usize).div_ceil(Grain::of(width as usize).columns())); height as usize];
    let mut memory = vec![0x5555_5555; Kept::len(tile, width)];
    for (number, data) in image.chunks_mut(row_len * tile).enumerate() {
        let first = (number * tile) as u32;
        let mut kept = (way == Way::Kept).then(|| Kept::new(&mut memory, first, tile, width).unwrap());
        for step in 0..plan.ends() {
            let index = if L::BACK_TO_FRONT { plan.ends() - 1 - step } else { step };
            let slice = |z: i32| usize::try_from(z).ok().and_then(|z| slices.get(z)).copied();
            let at = At {
                plan,
                plane: L::SHAPE.plane(plan, Phase::default(), index),
                window: Window::at(L::SHAPE.near_slice(plan, index), slice).unwrap(),
                seen: blocks.then(|| Seen::new(&every, Grain::of(width as usize))),
                clips: None,
                reading: None,
            };
            let rows = Rows {
                first,
                data: &mut *data,
            };
            pipeline
                .fold::<V>(&at, rows, &mut scratch, kept.as_mut(), None)
                .unwrap();
        }
    }
    image
}

fn by_stream<L: Pipeline<Voxel = Code12>>(pipeline: L, plan: &Plan, volume: &Volume) -> Vec<L::Element> {
    let needs = Needs::of::<L>(plan);
    let (mut slices, mut ranges) = (vec![0xffff; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![-1; needs.scratch], vec![L::Element::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let len = volume.dims[0] * volume.dims[1];
    let mut stream = Stream::new(*plan, pipeline, memory).unwrap();
    while let Some(wanted) = stream.wanted() {
        let first = wanted as usize * len;
        stream.push(&volume.voxels[first..first + len]).unwrap();
    }
    image
}

/// The depth of the first surface, ray by ray, against the plane layer and the stream.
fn depths_held<P: Precision>(p: P, plan: &Plan, volume: &Volume, surfaces: &[Surface]) -> Result<(), TestCaseError> {
    let pipeline = Depth::new(p, surfaces, plan).unwrap();
    let [width, height] = plan.base();
    let depth = |at: [u32; 2]| {
        let met = |step: u32| {
            let Segment { ends, part } = segment(plan, step - 1, at)?;
            let position = pipeline.first(ends.map(|cells| at_cells(p, cells, [0; 2], |at| volume.voxel(at))))?;
            Some(((step - 1) << 16) + part.from + ((u64::from(part.length()) * u64::from(position)) >> 16) as u32)
        };
        (1..plan.ends()).find_map(met).unwrap_or(NO_DEPTH)
    };
    let expected: Vec<u32> = (0..height)
        .flat_map(|v| (0..width).map(move |u| [u, v]))
        .map(depth)
        .collect();
    with_slices(volume, |slices| {
        prop_assert_eq!(&by_planes::<_, i32>(&pipeline, plan, slices, 3, Way::Rows), &expected);
        prop_assert_eq!(&by_planes::<_, i32>(&pipeline, plan, slices, 3, Way::Kept), &expected);
        prop_assert_eq!(
            &by_planes::<_, Small>(&pipeline, plan, slices, 1000, Way::Rows),
            &expected
        );
        prop_assert_eq!(&by_stream(pipeline.clone(), plan, volume), &expected);
        Ok(())
    })
}

/// Gives the slices of a volume.
fn with_slices<R>(volume: &Volume, run: impl FnOnce(&[Slice<'_>]) -> R) -> R {
    let [width, height, depth] = volume.dims;
    let mut ranges = vec![RowRange::EMPTY; height * depth];
    let slices: Vec<Slice<'_>> = (volume.voxels.chunks(width * height).zip(ranges.chunks_mut(height)))
        .map(|(voxels, ranges)| Slice::measure(voxels, width, height, width, ranges).unwrap())
        .collect();
    run(&slices)
}

/// Every way to a frame against the definitions.
fn held<P: Precision, S: Shader<P> + Clone, O: Order + Clone>(
    pipeline: &Composite<P, Segments<'_>, S, O>,
    plan: &Plan,
    volume: &Volume,
    expected: &[[u32; 4]],
) -> Result<(), TestCaseError> {
    let same = |image: &[ChannelOf<P>], name: &str| {
        let found = pixels(plan, image);
        let first = found
            .iter()
            .zip(expected)
            .position(|(found, expected)| found != expected);
        prop_assert!(first.is_none(), "{name}: pixel {first:?}");
        prop_assert_eq!(found.len(), expected.len());
        Ok(())
    };
    with_slices(volume, |slices| {
        same(
            &by_planes::<_, i32>(pipeline, plan, slices, 1000, Way::Rows),
            "whole rows",
        )?;
        same(
            &by_planes::<_, i32>(pipeline, plan, slices, 1000, Way::Kept),
            "rows that are kept",
        )?;
        same(
            &by_planes::<_, i32>(pipeline, plan, slices, 3, Way::Rows),
            "rows in tiles",
        )?;
        same(
            &by_planes::<_, i32>(pipeline, plan, slices, 3, Way::Kept),
            "rows that are kept, in tiles",
        )?;
        same(
            &by_planes::<_, Small>(pipeline, plan, slices, 5, Way::Rows),
            "a small machine",
        )?;
        same(&by_planes::<_, i32>(pipeline, plan, slices, 4, Way::Blocks), "blocks")
    })?;
    same(&by_stream(pipeline.clone(), plan, volume), "stream")
}

fn light<P: Precision>(p: P) -> Phong<P> {
    let vector = |v: [i32; 3]| v.map(|c| Vector::from_bits(c << 15));
    let light = Light {
        direction: vector([-16_384, -16_384, -23_170]),
        half: vector([-8_867, -8_867, -30_273]),
        diffuse: [20_000, 17_000, 9_000].map(|c| Coefficient::from_bits(c << 16)),
        specular: [Coefficient::from_bits(6_000 << 16); 3],
    };
    let ambient = [Coefficient::from_bits(5_000 << 16); 3];
    Phong::new(p, ambient, &[light], vector([0, 0, -32_768]), Highlight::Reflection, 3).unwrap()
}

fn every_way<P: Precision>(
    p: P,
    plan: &Plan,
    volume: &Volume,
    table: Segments<'_>,
    lit: bool,
) -> Result<(), TestCaseError> {
    let phong = light(p);
    let phong_or_none = lit.then_some(&phong);
    let front = defined(p, plan, volume, &table, phong_or_none, false);
    let back = defined(p, plan, volume, &table, phong_or_none, true);
    if lit {
        held(
            &Composite::<_, _, _, FrontToBack>::new(p, table, phong.clone()),
            plan,
            volume,
            &front,
        )?;
        held(
            &Composite::<_, _, _, BackToFront>::new(p, table, phong),
            plan,
            volume,
            &back,
        )
    } else {
        held(
            &Composite::<_, _, _, FrontToBack>::new(p, table, Unlit),
            plan,
            volume,
            &front,
        )?;
        held(
            &Composite::<_, _, _, BackToFront>::new(p, table, Unlit),
            plan,
            volume,
            &back,
        )
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 450, rng_seed: RngSeed::Fixed(150), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_way_to_a_frame_follows_the_definitions(
        dims in (1u32..=19, 1u32..=8, 1u32..=8),
        direction in prop_oneof![prop::array::uniform3(-3i64..=3), prop::array::uniform3(-1000i64..=1000)],
        factors in prop_oneof![Just([32768u16; 3]), prop::array::uniform3(1u16..=32768)],
        planes_per_voxel in 1u32..=5,
        seeds in prop::collection::vec((any::<u16>(), any::<u16>()), 8..40),
        bands in prop::collection::vec((1usize..900, 0u32..3, 0u32..200_000, prop::array::uniform3(0u32..=4)), 3..12),
        grain in prop_oneof![Just(0u32), Just(2)],
        scaled in 1u32 << 20..1 << 29,
        one_colour in any::<bool>(),
        lit in any::<bool>(),
        wide in any::<bool>(),
        faces in prop::collection::vec((0..=VALUE_MAX, prop_oneof![Just(0u32), 0u32..=1 << 31, Just(1u32 << 31)], 0u32..=1 << 31, prop::array::uniform3(0u32..=1 << 31)), 0..6),
        on_codes in any::<bool>(),
        alone in prop_oneof![3 => Just(false), 1 => Just(true)],
        pieces in prop_oneof![3 => Just(1u32), 1 => Just(2), 1 => Just(4)],
        borders in prop_oneof![Just(Borders::Whole), Just(Borders::Cells), Just(Borders::Nodes)],
    ) {
        prop_assume!(direction != [0; 3]);
        let view = View::new(direction.map(|c| Direction::from_bits(c << 40))).unwrap();
        let sampling = Sampling { planes_per_voxel, rays_per_voxel: 1 };
        let spacing = Spacing(factors.map(Intensity::from_bits));
        let sides = [dims.0, dims.1, dims.2];
        let borders = if borders == Borders::Nodes && sides.contains(&1) { Borders::Cells } else { borders };
        let plan = Plan::with_borders(view, sides, spacing, sampling, borders).unwrap();
        let dims = plan.dims().map(|side| side as usize);
        // Flat runs, small steps and jumps over the whole range.
        let len = dims.iter().product::<usize>();
        let voxels = (0..len).map(|n| {
            let (value, kind) = seeds[(n / 3) % seeds.len()];
            let noise = (n as u32).wrapping_mul(2_654_435_761) >> 20;
            match kind % 4 {
                0 => value >> 4,
                1 => ((u32::from(value >> 4) + noise % 9).min(4095)) as u16,
                2 => if noise & 1 == 0 { 0 } else { 4095 },
                _ => noise as u16,
            }
        });
        let volume = Volume { voxels: voxels.collect(), dims };
        let mut lists = [(); 4].map(|()| vec![0u32]);
        let mut sums = [0u32; 4];
        let mut runs = bands.iter().cycle();
        let mut band = *runs.next().unwrap();
        for _ in 0..4096 >> grain {
            if band.0 == 0 {
                band = *runs.next().unwrap();
            }
            band.0 -= 1;
            let (_, kind, extinction, colour) = band;
            let extinction = if kind == 0 { extinction } else { 0 };
            let parts = [extinction, extinction * colour[0] / 4, extinction * colour[1] / 4, extinction * colour[2] / 4];
            for ((sum, list), part) in sums.iter_mut().zip(&mut lists).zip(parts) {
                *sum += part;
                list.push(*sum);
            }
        }
        let [t, r, g, b] = lists.each_ref().map(|list| &list[..]);
        let colours = if one_colour { Colours::One([1 << 31, 123 << 22, 0]) } else { Colours::Each([r, g, b]) };
        let table = Integral::new(t, colours, grain, 17, Length { scaled, bits: 27 }).unwrap();
        let mut surfaces: Vec<Surface> = (faces.into_iter())
            .map(|(value, front, back, colour)| {
                let face = |opacity| Face { colour, opacity: Opacity::from_bits(opacity) };
                Surface {
                    value: if on_codes { value & 0xffff_0000 } else { value },
                    front: face(front),
                    back: face(back),
                }
            })
            .collect();
        surfaces.sort_by_key(|surface| surface.value);
        let table = Cut::new(Some(table).filter(|_| !alone), &surfaces[..], pieces).unwrap();
        if wide {
            depths_held(Wide, &plan, &volume, &surfaces)?;
        } else {
            depths_held(Compact, &plan, &volume, &surfaces)?;
        }
        if wide {
            every_way(Wide, &plan, &volume, table, lit)?;
        } else {
            every_way(Compact, &plan, &volume, table, lit)?;
        }
    }
}
