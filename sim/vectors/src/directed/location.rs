//! View, plan, starts, positions, and the dither of a plane.

use slicecast::borders::Borders;
use slicecast::composite::Dither;
use slicecast::format::{Direction, Step};
use slicecast::locate::{cell, inside, position, settled};
use slicecast::plan::{Phase, Plan, Sampling, Spacing};
use slicecast::view::{Axis, View};

use super::{Numbers, borders};
use crate::set::{Set, s, u, xyz};

/// The plan of sides along x, y, z, planes and rays per voxel.
pub(super) fn planned(direction: [i64; 3], dims: [i64; 3], [planes, rays]: [i64; 2], borders: Borders) -> Option<Plan> {
    let view = View::new(direction.map(Direction::from_bits)).ok()?;
    let sampling = Sampling {
        planes_per_voxel: planes as u32,
        rays_per_voxel: rays as u32,
    };
    let dims = dims.map(|side| side as u32);
    Plan::with_borders(view, dims, Spacing::CUBIC, sampling, borders).ok()
}

/// From a direction and the volume's sides to axes, steps and the base plane.
pub fn plan() -> Set {
    let mut inputs = xyz(&s("direction", 60, "2^-58 of any length")).to_vec();
    inputs.extend(xyz(&u("side", 14, "voxels")));
    inputs.extend([
        u("planes_per_voxel", 5, "planes"),
        u("rays_per_voxel", 4, "rays"),
        borders::field(),
    ]);
    let outputs = vec![
        u("major", 2, "0 x, 1 y, 2 z"),
        u("reversed", 1, "1: slices are read from the far end"),
        s("step_i", 34, "2^-32 voxel"),
        s("step_j", 34, "2^-32 voxel"),
        s("step_k", 34, "2^-32 voxel"),
        u("columns", 15, "pixels of a phase"),
        u("rows", 15, "pixels of a phase"),
        s("origin_i", 14, "voxels"),
        s("origin_j", 14, "voxels"),
        u("planes", 16, "planes"),
    ];
    let mut set = Set::new(None, "plan", "axes, steps and base plane of a view", inputs, outputs);
    let one = 1_i64 << 58;
    let mut push = |direction: [i64; 3], dims: [i64; 3], planes: i64| {
        let cases = [
            (Borders::Whole, 1),
            (Borders::Cells, 1),
            (Borders::Cells, 3),
            (Borders::Nodes, 1),
            (Borders::Nodes, 3),
        ];
        for (kind, rays) in cases {
            let Some(plan) = planned(direction, dims, [planes, rays], kind) else {
                continue;
            };
            let major = match plan.view().major() {
                Axis::X => 0,
                Axis::Y => 1,
                Axis::Z => 2,
            };
            let [step_i, step_j, step_k] = plan.step().map(|step| step.to_bits());
            let ([columns, rows], [origin_i, origin_j]) = (plan.base().map(i64::from), plan.origin().map(i64::from));
            let [dx, dy, dz] = direction;
            let [nx, ny, nz] = dims;
            set.push(
                &[dx, dy, dz, nx, ny, nz, planes, rays, borders::number(kind)],
                &[
                    major,
                    plan.view().reversed().into(),
                    step_i,
                    step_j,
                    step_k,
                    columns,
                    rows,
                    origin_i,
                    origin_j,
                    plan.planes().into(),
                ],
            );
        }
    };
    // Along the axes, from both sides; ties of two and of three components, with every sign.
    for z in [-1, 0, 1] {
        for y in [-1, 0, 1] {
            for x in [-1, 0, 1] {
                push([x, y, z].map(|c| c * one), [5, 7, 9], 1);
                push([x, y, z].map(|c| c * one - c), [9, 5, 7], 3);
            }
        }
    }
    // Halves of a step: d_i 2^32 / d_k = 1/2, 3/2, 5/2; away from zero.
    for half in [1, 3, 5] {
        for planes in [1, 2, 4, 16] {
            push([half, -half, (1 << 33) / planes], [4, 4, 9], planes);
            push([-half, half, -(1 << 33) / planes], [4, 4, 9], planes);
        }
    }
    // The base plane ends by the step as it is coded: two thirds are rounded up, one third down.
    for (numerator, denominator) in [(2, 3), (1, 3), (5, 7), (1, 2)] {
        for side in [1, 2, 4, 7, 8] {
            push([numerator, -numerator, denominator], [8, 8, side], 1);
            push([-numerator, denominator, numerator], [8, side, 8], 2);
        }
    }
    for planes in 1..=16 {
        push([one / 3, one / 5, one], [3, 2, 8], planes);
    }
    // The longest volume, and the most planes.
    push([one, -one, one], [1, 1, 8192], 1);
    push([one, one, one], [8192; 3], 4);
    push([-one, one, one], [8192; 3], 4);
    push([1, 0, one], [2, 2, 8192], 1);
    let mut numbers = Numbers(1);
    for _ in 0..64 {
        let direction = [(); 3].map(|()| numbers.within(-one, one));
        let dims = [(); 3].map(|()| numbers.within(1, 300));
        push(direction, dims, numbers.within(1, 16));
    }
    set
}

/// Where the rays of a phase begin.
pub fn start() -> Set {
    let inputs = vec![
        s("origin", 14, "voxels"),
        u("phase", 3, "number along the axis"),
        u("rays_per_voxel", 4, "rays"),
    ];
    let outputs = vec![s("start", 46, "2^-32 voxel")];
    let mut set = Set::new(None, "start", "start of a phase's rays along i or j", inputs, outputs);
    let one = 1 << 50;
    for depth in [1, 2, 100, 8192] {
        for rays in 1..=8 {
            let Some(plan) = planned([one, 0, one], [2, 2, depth], [1, rays], Borders::Whole) else {
                continue;
            };
            for u in 0..rays {
                let [start, _] = plan.start(Phase { u: u as u32, v: 0 });
                set.push(&[plan.origin()[0].into(), u, rays], &[start.to_bits()]);
            }
        }
    }
    set
}

/// Position, cell, weight, and the pixels that have a sample.
pub fn location() -> Set {
    let inputs = vec![
        s("start", 46, "2^-32 voxel"),
        s("step", 34, "2^-32 voxel"),
        u("plane", 16, "number from the eye"),
        u("nearest", 1, "1: at the nearest voxel"),
        u("side", 14, "voxels"),
        u("pixels", 15, "pixels of a phase"),
    ];
    let outputs = vec![
        s("position", 30, "2^-16 voxel"),
        s("cell", 14, "voxels"),
        u("weight", 16, "2^-16"),
        u("first", 15, "pixel"),
        u("end", 15, "pixel behind the last"),
    ];
    let about = "position of a plane along an axis, and its pixels inside the volume";
    let mut set = Set::new(None, "location", about, inputs, outputs);
    let plain = planned([0, 0, 1], [2; 3], [1, 1], Borders::Whole).expect("a plan");
    let plans = [plain, plain.with_nearest()];
    let mut push = |start: i64, step: i64, plane: i64, side: i64, pixels: i64| {
        for (nearest, plan) in (0..).zip(&plans) {
            let exact = position(Step::from_bits(start), Step::from_bits(step), plane as u32);
            let position = settled(plan, exact);
            let at = cell(position);
            let range = inside(at, side as u32, pixels as u32);
            set.push(
                &[start, step, plane, nearest, side, pixels],
                &[
                    position.to_bits().into(),
                    at.index.into(),
                    at.weight.to_bits().into(),
                    range.start.into(),
                    range.end.into(),
                ],
            );
        }
    };
    let voxel = 1_i64 << 32;
    // Halves of a position, from both sides, above and below zero.
    for start in [0, 3 * voxel, -3 * voxel] {
        for half in [-1, 0, 1] {
            push(start, (1 << 15) + half, 1, 8, 12);
            push(start, -(1 << 15) + half, 1, 8, 12);
            push(start, (3 << 15) + half, 1, 8, 12);
            push(start, -(3 << 15) + half, 1, 8, 12);
        }
        // Half a voxel, for what is nearest.
        for off in [-(1 << 16), -1, 0, 1, 1 << 16] {
            push(start, voxel / 2 + off, 1, 8, 12);
            push(start, -voxel / 2 + off, 1, 8, 12);
        }
    }
    // The last sample: on the last voxel, and up to 15 / 65536 beyond it, which 12 bits of a weight do not see.
    for beyond in [0, 1, 8, 15, 16, 65535] {
        push((3 << 32) + (beyond << 16), 0, 0, 4, 5);
        push(-(3 << 32) + (beyond << 16), 0, 0, 4, 9);
        push(beyond << 16, 0, 0, 1, 3);
    }
    // The ends of the range.
    push(-8191 * voxel, voxel, 8191, 8192, 16383);
    push(0, -voxel, 8191, 8192, 16383);
    push(0, voxel, 8191, 8192, 1);
    push(-8192 * voxel, 0, 0, 1, 16383);
    push(0, (1 << 28) + 1, 32764, 8192, 16383);
    push(0, -(1 << 28) - 1, 32764, 8192, 16383);
    let mut numbers = Numbers(2);
    for _ in 0..64 {
        let plane = numbers.within(0, 4000);
        let start = numbers.within(-2000, 0) * voxel + numbers.within(0, voxel - 1);
        push(
            start,
            numbers.within(-voxel, voxel),
            plane,
            numbers.within(1, 8192),
            numbers.within(1, 16383),
        );
    }
    set
}

/// The offsets of a plane.
pub fn dither() -> Set {
    let inputs = vec![u("plane", 16, "number from the eye")];
    let outputs = vec![u("dither_t", 15, "2^-15"), u("dither_c", 15, "2^-15")];
    let mut set = Set::new(None, "dither", "offsets of a plane", inputs, outputs);
    for plane in (0..64).chain([3309, 13007, 16384, 25346, 29391, 32767, 32768]) {
        let dither = Dither::of_plane(plane);
        set.push(&[plane.into()], &[dither.transparency.into(), dither.colour.into()]);
    }
    set
}
