//! Exact borders: where a pixel's sample lies, what of its segment counts, and the opacity of a fraction.

use slicecast::borders::{Borders, WHOLE, fraction_of};
use slicecast::format::Opacity;
use slicecast::locate::plane;
use slicecast::plan::Phase;
use slicecast::sides::Side;

use super::Numbers;
use super::location::planned;
use crate::set::{Field, Set, s, u};

/// The borders of a plan.
pub fn field() -> Field {
    u("borders", 2, "0 whole, 1 cells, 2 nodes")
}

/// Their number.
pub fn number(borders: Borders) -> i64 {
    match borders {
        Borders::Whole => 0,
        Borders::Cells => 1,
        Borders::Nodes => 2,
    }
}

/// What of a segment counts.
pub fn fraction() -> Field {
    u("fraction", 17, "2^-16 segment")
}

/// A pixel's sample and its part of the segment, along one axis.
pub fn borders() -> Set {
    let inputs = vec![
        s("start", 46, "2^-32 voxel"),
        s("step", 34, "2^-32 voxel"),
        u("plane", 16, "number from the eye"),
        u("planes_per_voxel", 5, "planes"),
        field(),
        u("nearest", 1, "1: at the nearest voxel"),
        u("side", 14, "voxels"),
        u("pixel", 15, "of the phase"),
    ];
    let outputs = vec![
        u("position", 30, "2^-16 voxel, held to the voxels"),
        u("from", 17, "2^-16 segment"),
        u("to", 17, "2^-16 segment"),
    ];
    let about = "a pixel's sample, and the part of its segment between the faces of an axis";
    let mut set = Set::new(None, "borders", about, inputs, outputs);
    let mut push = |direction: [i64; 3], [side, depth]: [i64; 2], [planes, rays]: [i64; 2]| {
        for kind in [Borders::Cells, Borders::Nodes] {
            let dims = [side, 2, depth];
            let Some(plan) = planned(direction, dims, [planes, rays], kind) else {
                continue;
            };
            // Others than along z have their sides elsewhere.
            if plan.dims().map(i64::from) != dims {
                continue;
            }
            for (nearest, plan) in (0..).zip([plan, plan.with_nearest()]) {
                let phase = Phase {
                    u: rays as u32 - 1,
                    v: 0,
                };
                let ([start, _], [step, ..], [pixels, _]) = (plan.start(phase), plan.step(), plan.base());
                let last = plan.planes() - 1;
                for index in [0, 1, last / 2, last] {
                    let along = Side::of(&plan, start, 0, index);
                    let of_pixel_0 = i64::from(plane(&plan, phase, index).x.to_bits());
                    let faces = [0, side << 16].map(|face: i64| (face - of_pixel_0) >> 16);
                    let mut seen: Vec<i64> = faces.iter().flat_map(|face| face - 2..face + 3).collect();
                    seen.extend([0, i64::from(pixels) - 1]);
                    seen.retain(|pixel| (0..i64::from(pixels)).contains(pixel));
                    seen.sort_unstable();
                    seen.dedup();
                    for pixel in seen {
                        let held = (of_pixel_0 + (pixel << 16)).clamp(0, (side - 1) << 16);
                        let part = along.part(pixel as u32);
                        set.push(
                            &[
                                start.to_bits(),
                                step.to_bits(),
                                index.into(),
                                planes,
                                number(kind),
                                nearest,
                                side,
                                pixel,
                            ],
                            &[held, part.from.into(), part.to.into()],
                        );
                    }
                }
            }
        }
    };
    let one = 1_i64 << 58;
    // Along the faces, a voxel a plane, the smallest step, halves of a position.
    for x in [0, one, -one, 1 << 26, -(1 << 26), one / 2, -one / 2] {
        for rates in [[1, 1], [2, 1], [3, 2], [16, 3]] {
            push([x, 0, one], [5, 4], rates);
            push([x, 0, one], [2, 9], rates);
        }
    }
    // One voxel, which only cells have.
    push([one / 3, 0, one], [1, 3], [1, 2]);
    push([-one / 3, 0, one], [1, 3], [2, 1]);
    let mut numbers = Numbers(7);
    for _ in 0..32 {
        let x = numbers.within(-one, one);
        let sides = [numbers.within(1, 40), numbers.within(2, 40)];
        push([x, 0, one], sides, [numbers.within(1, 16), numbers.within(1, 8)]);
    }
    set
}

/// The opacity of a fraction of a step.
pub fn power() -> Set {
    let inputs = vec![u("opacity", 32, "2^-31"), fraction()];
    let outputs = vec![u("opacity", 32, "2^-31")];
    let about = "opacity of a fraction of a step";
    let mut set = Set::new(None, "fraction", about, inputs, outputs);
    let mut push = |opacity: i64, fraction: i64| {
        let found = fraction_of(Opacity::from_bits(opacity as u32), fraction as u32);
        set.push(&[opacity, fraction], &[found.to_bits().into()]);
    };
    let (one, whole) = (1_i64 << 31, i64::from(WHOLE));
    let fractions = [
        1,
        2,
        3,
        255,
        whole / 3,
        whole / 2 - 1,
        whole / 2,
        whole / 2 + 1,
        whole - 2,
        whole - 1,
        whole,
    ];
    for fraction in fractions {
        // Clear, opaque, next to both; half and its neighbours, where the exponent changes.
        for opacity in [
            0,
            1,
            2,
            3,
            100,
            one - 1,
            one - 2,
            one - 3,
            one,
            one / 2 - 1,
            one / 2,
            one / 2 + 1,
        ] {
            push(opacity, fraction);
        }
        for shift in 2..31 {
            push(one - (one >> shift), fraction);
            push(one >> shift, fraction);
        }
    }
    let mut numbers = Numbers(8);
    for _ in 0..400 {
        push(numbers.within(0, one), numbers.within(1, whole));
    }
    set
}
