//! Frames of colour and extinction: the plane layer in tiles of any height, by both single lanes, and the stream, from codes and
//! from entries of both kinds, against the formulas of `docs/contract/extinction.md` ray by ray, in 128 bits.

#[path = "rgba/light.rs"]
mod light;

use self::light::{Material, cued, cues, materials, normal};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use slicecast::absorption::CENTRED_PHI;
use slicecast::absorption::Medium;
use slicecast::absorption::PHI;
use slicecast::borders::{Borders, WHOLE};
use slicecast::clip::{Clips, Cue};
use slicecast::composite::{Channel, Dither, Weighted};
use slicecast::extinction::{Given, Rgba15, decode};
use slicecast::format::{Direction, Intensity, Weight};
use slicecast::interpolate::trilinear;
use slicecast::lanes::{Lanes, Small};
use slicecast::locate::plane;
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::{At, ChannelOf, Filter, Pipeline, Rgba, Rows, ScratchError, Triquadratic, clear};
use slicecast::precision::{Compact, Precision, Wide};
use slicecast::quadratic::{is_behind, triquadratic};
use slicecast::shade::Shader;
use slicecast::sides::Side;
use slicecast::slice::{RowRange, Slice, Window};
use slicecast::stream::{Memory, Needs, Stream, base_pixel};
use slicecast::view::View;

/// A volume in the slice frame.
#[derive(Clone, Debug)]
struct Volume {
    entries: Vec<u32>,
    low: Vec<u8>,
    dims: [usize; 3],
}

impl Volume {
    fn codes(&self, at: [usize; 3]) -> [u16; 4] {
        let [w, h, _] = self.dims;
        let index = (at[2] * h + at[1]) * w + at[0];
        decode(self.entries[index], self.low[index])
    }

    /// The codes of a slice, each row four runs.
    fn words(&self, k: usize) -> Vec<u16> {
        let [w, h, _] = self.dims;
        let run = |j: usize, channel: usize| (0..w).map(move |i| self.codes([i, j, k])[channel]);
        (0..h)
            .flat_map(|j| (0..4).flat_map(move |channel| run(j, channel)))
            .collect()
    }
}

/// A frame: where it looks from, and how.
#[derive(Clone, Debug)]
struct Frame {
    plan: Plan,
    medium: [u32; 2],
    early: Option<u32>,
    material: Option<Material>,
    cue: Option<Cue>,
    smooth: bool,
}

impl Frame {
    fn clips(&self) -> Option<Clips> {
        let cue = self.cue?;
        Some(Clips::new(&self.plan, &[]).unwrap().with_cue(&self.plan, &cue).unwrap())
    }
}

/// The samples of a ray, in its order: number of the plane, fraction of its step, extinction and colours times extinction.
fn samples<P: Precision>(
    p: P,
    view: &Frame,
    clips: Option<&Clips>,
    volume: &Volume,
    phase: u32,
    [u, v]: [u32; 2],
) -> Vec<(u32, u32, [i64; 4])> {
    let plan = &view.plan;
    let phase = plan.phase(phase);
    let [start_i, start_j] = plan.start(phase);
    let mut found = Vec::new();
    for index in 0..plan.planes() {
        let at = plane(plan, phase, index);
        let place = [
            at.x.to_bits() + ((u as i32) << 16),
            at.y.to_bits() + ((v as i32) << 16),
            at.z.to_bits(),
        ];
        let last = plan.dims().map(|side| (side as i32 - 1) << 16);
        let fraction = match plan.borders() {
            Borders::Whole if (0..3).all(|a| (0..=last[a]).contains(&place[a])) => WHOLE,
            Borders::Whole => 0,
            _ => {
                let part = |start, axis, pixel| Side::of(plan, start, axis, index).part(pixel);
                part(start_i, 0, u).fraction(part(start_j, 1, v))
            }
        };
        if fraction == 0 {
            continue;
        }
        let held = [0, 1, 2].map(|a| place[a].clamp(0, last[a]));
        let weights = held.map(|bits| Weight::from_bits((bits & 0xffff) as u32));
        let corner = |channel: usize, d: [usize; 3]| {
            let at = [0, 1, 2].map(|a| ((held[a] >> 16) as usize + d[a]).min(volume.dims[a] - 1));
            volume.codes(at)[channel] as i16
        };
        let about = |channel: usize, d: [usize; 3]| {
            let place = |a: usize| (held[a] >> 16) + i32::from(is_behind(weights[a])) + d[a] as i32 - 1;
            let at = [0, 1, 2].map(|a| place(a).clamp(0, volume.dims[a] as i32 - 1) as usize);
            volume.codes(at)[channel]
        };
        let sample = [0, 1, 2, 3].map(|channel| {
            if view.smooth {
                let voxels = [0, 1, 2].map(|z| [0, 1, 2].map(|y| [0, 1, 2].map(|x| about(channel, [x, y, z]))));
                return i64::from(triquadratic(p, voxels, weights));
            }
            let corners = [0, 1].map(|z| [0, 1].map(|y| [0, 1].map(|x| corner(channel, [x, y, z]))));
            i64::from(trilinear(p, corners, weights))
        });
        let [tau, ..] = sample;
        assert!(sample.iter().all(|channel| (0..=tau).contains(channel)), "{sample:?}");
        let sample = view.material.as_ref().map_or(sample, |material| {
            material.lit(p, normal(p, plan, volume, held.map(|bits| bits >> 16), weights), sample)
        });
        let sample = clips.map_or(sample, |clips| {
            let start = [
                start_i.to_bits() + (i64::from(u) << 32),
                start_j.to_bits() + (i64::from(v) << 32),
            ];
            cued(clips, view.cue.unwrap().colour, plan, start, index, sample)
        });
        found.push((index, fraction, sample));
    }
    found
}

/// The frame, ray by ray: red, green, blue and transparency of each pixel, phase after phase.
fn defined<P: Precision>(p: P, view: &Frame, volume: &Volume) -> Vec<[u32; 4]> {
    let Frame {
        plan,
        medium: [mantissa, exponent],
        early,
        ..
    } = view;
    let clips = view.clips();
    let bits = p.formats().sample_bits;
    let (n, wide) = (exponent + bits, bits == 15);
    let one: i128 = if wide { 1 << 31 } else { 65535 };
    let own = if wide { 1 << 11 } else { 1 };
    let floor = early.map_or(own, |bits| (one >> bits).max(own));
    let [width, height] = plan.base();
    let mut pixels = Vec::new();
    for (phase, v, u) in
        (0..plan.phases()).flat_map(|p| (0..height).flat_map(move |v| (0..width).map(move |u| (p, v, u))))
    {
        let (mut t, mut c) = (one, [0i128; 3]);
        for (index, fraction, [tau, colours @ ..]) in samples(p, view, clips.as_ref(), volume, phase, [u, v]) {
            assert!(
                colours.iter().all(|colour| (0..=tau).contains(colour)),
                "{tau} {colours:?}"
            );
            let m = if fraction < WHOLE {
                (i128::from(*mantissa) * i128::from(fraction)) >> 16
            } else {
                i128::from(*mantissa)
            };
            let x = (i128::from(tau) * m) >> n;
            assert!(x <= 15 << 28);
            let (i, f) = ((x >> 22) as usize, x & 0x3f_ffff);
            let values = if wide { &CENTRED_PHI } else { &PHI };
            let (here, next) = (i128::from(values[i]), i128::from(values[i + 1]));
            let phi = here - (((here - next) * f + (1 << 21)) >> 22);
            let g = (m * phi) >> 31;
            let dither = i128::from(Dither::of_plane(index).transparency);
            let given = |s: i64| {
                if wide {
                    (i128::from(s) * ((t * g) >> 31)) >> (n - 3)
                } else {
                    (i128::from(s) * ((t * g) >> 15) + ((2 * dither + 1) << (n - 3))) >> (n + 13)
                }
            };
            let taken = given(tau);
            let gifts = colours.map(given);
            assert!(taken <= t && gifts.iter().all(|gift| (0..=taken).contains(gift)));
            t -= taken;
            c = [0, 1, 2].map(|k| c[k] + gifts[k]);
            assert!(c.iter().all(|c| c + t <= one));
            if t < floor {
                t = 0;
                break;
            }
        }
        pixels.push([c[0], c[1], c[2], t].map(|bits| bits as u32));
    }
    pixels
}

/// The pixels of an image in the same order.
fn pixels<P: Precision<Pixel: Weighted>, S: Shader<P>, F: Filter>(
    plan: &Plan,
    pipeline: &Rgba<P, S, F>,
    image: &[ChannelOf<P>],
) -> Vec<[u32; 4]> {
    let [width, height] = plan.base();
    let n = plan.sampling().rays_per_voxel;
    let places = (0..n * n).flat_map(|p| (0..height).flat_map(move |v| (0..width).map(move |u| (p, v, u))));
    let pixel = |(p, v, u)| {
        let pixel = base_pixel(
            plan,
            pipeline,
            image,
            i64::from(u * n + p % n),
            i64::from(v * n + p / n),
        );
        let [r, g, b] = pixel.colour.map(Channel::bits);
        [r, g, b, pixel.transparency.bits()]
    };
    places.map(pixel).collect()
}

/// By the plane layer, in tiles of some rows.
fn by_planes<P: Precision<Pixel: Weighted>, S: Shader<P>, F: Filter, V: Lanes>(
    (plan, clips): (&Plan, Option<&Clips>),
    pipeline: &Rgba<P, S, F>,
    volume: &Volume,
    tile: usize,
) -> Vec<[u32; 4]> {
    let [w, h, d] = volume.dims;
    let words: Vec<Vec<u16>> = (0..d).map(|k| volume.words(k)).collect();
    let mut ranges = vec![RowRange::EMPTY; h * d];
    let slices: Vec<Slice<'_, Rgba15>> = (words.iter().zip(ranges.chunks_mut(h)))
        .map(|(words, ranges)| Slice::of_codes(words, w, h, ranges).unwrap())
        .collect();
    let mut image = vec![Default::default(); Needs::of::<Rgba<P, S, F>>(plan).image];
    clear(pipeline, plan, &mut image);
    let shape = Rgba::<P, S, F>::SHAPE;
    let mut scratch = vec![0x5555_5555; shape.scratch_len(w as u32)];
    let row_len = 4 * plan.base()[0] as usize;
    for (number, data) in image.chunks_mut(shape.phase_len(plan)).enumerate() {
        for (tile_number, data) in data.chunks_mut(row_len * tile).enumerate() {
            for index in 0..plan.planes() {
                let slice = |z: i32| usize::try_from(z).ok().and_then(|z| slices.get(z)).copied();
                let at = At {
                    plan,
                    plane: plane(plan, plan.phase(number as u32), index),
                    window: Window::at(shape.near_slice(plan, index), slice).unwrap(),
                    seen: None,
                    clips: clips.map(Clips::clipper),
                    reading: None,
                };
                let rows = || (tile_number * tile) as u32;
                let len = scratch.len() - 1;
                let short = pipeline.fold::<V>(
                    &at,
                    Rows {
                        first: rows(),
                        data: &mut *data,
                    },
                    &mut scratch[..len],
                    None,
                    None,
                );
                assert_eq!(
                    short,
                    Err(ScratchError {
                        needed: len + 1,
                        given: len
                    })
                );
                pipeline
                    .fold::<V>(
                        &at,
                        Rows {
                            first: rows(),
                            data: &mut *data,
                        },
                        &mut scratch,
                        None,
                        None,
                    )
                    .unwrap();
            }
        }
    }
    pixels(plan, pipeline, &image)
}

/// By the stream, which is given slices as `given` says.
fn by_stream<P: Precision<Pixel: Weighted>, S: Shader<P>, F: Filter>(
    (plan, clips): (&Plan, Option<&Clips>),
    pipeline: &Rgba<P, S, F>,
    volume: &Volume,
    given: usize,
) -> Vec<[u32; 4]> {
    let needs = Needs::of::<Rgba<P, S, F>>(plan);
    let (mut slices, mut ranges) = (vec![0xffff; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![-1; needs.scratch], vec![Default::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let len = volume.dims[0] * volume.dims[1];
    let mut stream = Stream::new(*plan, pipeline, memory).unwrap();
    if let Some(clips) = clips {
        stream.clip(clips.clipper()).unwrap();
    }
    while let Some(wanted) = stream.wanted() {
        let part = wanted as usize * len..(wanted as usize + 1) * len;
        let (entries, low, words) = (
            &volume.entries[part.clone()],
            &volume.low[part],
            volume.words(wanted as usize),
        );
        stream
            .push(match given {
                0 => Given::Codes(&words),
                1 => Given::Entries {
                    entries,
                    low: Some(low),
                },
                _ => Given::Entries { entries, low: None },
            })
            .unwrap();
    }
    pixels(plan, pipeline, &image)
}

fn held<P: Precision<Pixel: Weighted>>(p: P, view: &Frame, volume: &Volume, tile: usize) -> Result<(), TestCaseError> {
    let [mantissa, exponent] = view.medium;
    let medium = Medium::new(mantissa, exponent).unwrap();
    match &view.material {
        None if view.smooth => held_by(p, Rgba::new(p, medium).with_filter(Triquadratic), view, volume, tile),
        None => held_by(p, Rgba::new(p, medium), view, volume, tile),
        Some(material) => {
            let pipeline = Rgba::shaded(p, medium, material.phong(p));
            if view.smooth {
                held_by(p, pipeline.with_filter(Triquadratic), view, volume, tile)
            } else {
                held_by(p, pipeline, view, volume, tile)
            }
        }
    }
}

fn held_by<P: Precision<Pixel: Weighted>, S: Shader<P>, F: Filter>(
    p: P,
    mut pipeline: Rgba<P, S, F>,
    view: &Frame,
    volume: &Volume,
    tile: usize,
) -> Result<(), TestCaseError> {
    if let Some(bits) = view.early {
        pipeline = pipeline.with_early_termination(bits);
    }
    let clips = view.clips();
    let at = (&view.plan, clips.as_ref());
    let expected = defined(p, view, volume);
    prop_assert_eq!(&by_planes::<P, S, F, i32>(at, &pipeline, volume, tile), &expected);
    prop_assert_eq!(&by_planes::<P, S, F, Small>(at, &pipeline, volume, 100), &expected);
    let doubled = volume
        .entries
        .iter()
        .zip(&volume.low)
        .all(|(entry, low)| (entry >> 24) as u8 == *low);
    for given in 0..if doubled { 3 } else { 2 } {
        prop_assert_eq!(&by_stream(at, &pipeline, volume, given), &expected, "given {}", given);
    }
    Ok(())
}

fn volumes() -> impl Strategy<Value = Volume> {
    let root = prop_oneof![3 => Just(0u8), 2 => any::<u8>(), 1 => Just(255)];
    let colour = prop_oneof![1 => Just([255u8; 3]), 1 => Just([0; 3]), 3 => any::<[u8; 3]>()];
    let dims = prop::array::uniform3(1usize..=7);
    (dims, any::<bool>()).prop_flat_map(move |(dims, fine)| {
        let voxels = prop::collection::vec(
            (root.clone(), colour.clone(), any::<u8>()),
            dims.iter().product::<usize>(),
        );
        voxels.prop_map(move |voxels| Volume {
            entries: voxels
                .iter()
                .map(|(root, [r, g, b], _)| u32::from_le_bytes([*r, *g, *b, *root]))
                .collect(),
            low: voxels
                .iter()
                .map(|(root, _, low)| if fine { *low } else { *root })
                .collect(),
            dims,
        })
    })
}

fn views(dims: [usize; 3]) -> impl Strategy<Value = Option<Frame>> {
    let shear = || prop_oneof![Just(0i64), Just(1 << 58), Just(-1 << 58), -(1i64 << 58)..=1 << 58];
    let medium = prop_oneof![
        (1u32 << 30..1 << 31, 15u32..=35).prop_map(|(m, n)| [m, n]),
        Just([(((15u64 << 42) / 32767) as u32), 14]),
        (0u32..1 << 31).prop_map(|m| [m, 35]),
    ];
    let borders = prop_oneof![Just(Borders::Whole), Just(Borders::Cells), Just(Borders::Nodes)];
    let spacing = prop_oneof![Just([1 << 15; 3]), prop::array::uniform3(1u16..=1 << 15)].prop_map(|mut factors| {
        factors[0] = 1 << 15;
        Spacing(factors.map(Intensity::from_bits))
    });
    let turned = (
        spacing,
        prop::option::weighted(0.6, materials()),
        prop::option::weighted(0.4, cues()),
        any::<bool>(),
    );
    (
        shear(),
        shear(),
        1u32..=4,
        1u32..=2,
        borders,
        medium,
        prop::option::of(1u32..=12),
        turned,
    )
        .prop_map(
            move |(i, j, rate, rays, borders, medium, early, (spacing, material, cue, smooth))| {
                let view = View::new([i, j, 1 << 58].map(Direction::from_bits)).unwrap();
                let sampling = Sampling {
                    planes_per_voxel: rate,
                    rays_per_voxel: rays,
                };
                let dims = dims.map(|side| side as u32);
                let plan = Plan::with_borders(view, dims, spacing, sampling, borders).ok()?;
                Some(Frame {
                    plan,
                    medium,
                    early,
                    material,
                    cue,
                    smooth,
                })
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, rng_seed: RngSeed::Fixed(17), failure_persistence: None, ..ProptestConfig::default() })]

    /// Every way to a frame; within the definitions: no colour above its extinction, nothing given that is not taken.
    #[test]
    fn frames_are_as_defined(
        (volume, view) in volumes().prop_flat_map(|volume| { let dims = volume.dims; (Just(volume), views(dims)) }),
        tile in 1usize..=5,
    ) {
        let Some(view) = view else { return Ok(()) };
        held(Compact, &view, &volume, tile)?;
        held(Wide, &view, &volume, tile)?;
    }

    /// White voxels of any extinction: what a ray has lost is what it shows, in both precisions, unlit and under ambient light of 1
    /// alone.
    #[test]
    fn white_keeps_all_light(
        roots in prop::collection::vec(prop_oneof![any::<u8>(), Just(0)], 5 * 4 * 30),
        i in -(1i64 << 58)..=1 << 58, j in -(1i64 << 58)..=1 << 58, rate in 1u32..=3, mantissa in 1u32 << 30..1 << 31, exponent in 15u32..=30,
    ) {
        let volume = Volume {
            entries: roots.iter().map(|root| u32::from_le_bytes([255, 255, 255, *root])).collect(),
            low: roots,
            dims: [5, 4, 30],
        };
        let view = View::new([i, j, 1 << 58].map(Direction::from_bits)).unwrap();
        let sampling = Sampling { planes_per_voxel: rate, rays_per_voxel: 1 };
        let plan = Plan::whole(view, [5, 4, 30], Spacing::CUBIC, sampling).unwrap();
        let medium = Medium::new(mantissa, exponent).unwrap();
        let (at, white) = ((&plan, None), Material::white());
        let compact = by_planes::<_, _, _, i32>(at, &Rgba::new(Compact, medium), &volume, 9);
        for [r, g, b, t] in &compact {
            prop_assert_eq!([r + t, g + t, b + t], [65535; 3]);
        }
        let lit = Rgba::shaded(Compact, medium, white.phong(Compact));
        prop_assert!(by_planes::<_, _, _, i32>(at, &lit, &volume, 9) == compact);
        let wide = by_planes::<_, _, _, i32>(at, &Rgba::new(Wide, medium), &volume, 9);
        let lit = Rgba::shaded(Wide, medium, white.phong(Wide));
        prop_assert!(by_planes::<_, _, _, i32>(at, &lit, &volume, 9) == wide);
        for [r, g, b, t] in wide {
            prop_assert_eq!([r, r], [g, b]);
            // What the floor takes is less than 2^11.
            let rest = (1u32 << 31) - (r + t);
            prop_assert!(rest == 0 || t == 0 && rest < 1 << 11, "{} {}", r, t);
        }
    }
}

/// A slice with a code that is none is refused, and a good one goes on.
#[test]
fn refused_slices_are_not_taken() {
    let view = View::new([0, 0, 1 << 58].map(Direction::from_bits)).unwrap();
    let plan = Plan::whole(view, [2, 1, 2], Spacing::CUBIC, Sampling::default()).unwrap();
    let pipeline = Rgba::new(Compact, Medium::new(1 << 30, 20).unwrap());
    let needs = Needs::of::<Rgba<Compact>>(&plan);
    assert_eq!(needs.slices, 2 * 4 * 2);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![Default::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    let error = stream.push(Given::Codes(&[4, 5, 0, 6, 0, 0, 0, 0])).unwrap_err();
    assert_eq!(
        error.to_string(),
        "voxel at row 0, column 1 has the extinction 5 and colours [6, 0, 0]; accepted: an extinction of at most 32767, and \
         colours of at most the extinction"
    );
    assert_eq!(stream.wanted(), Some(0));
    stream.push(Given::Codes(&[4, 5, 0, 5, 0, 0, 0, 0])).unwrap();
    assert_eq!(stream.wanted(), Some(1));
}
