//! Drift: 2048 slices at 16 planes per voxel, 32752 steps along a ray.

use slicecast::format::Direction;
use slicecast::locate::plane;
use slicecast::plan::{Phase, Plan, Sampling, Spacing};
use slicecast::view::View;

use super::{Case, Size};

/// The plan of a view with these shears.
fn plan([si, sj]: [f64; 2]) -> Option<(Plan, [f64; 2])> {
    let one = 1i64 << 56;
    let components = [si, sj].map(|s| (s * one as f64) as i64);
    let view = View::new([components[0], components[1], one].map(Direction::from_bits)).ok()?;
    let sampling = Sampling {
        planes_per_voxel: 16,
        rays_per_voxel: 1,
    };
    let plan = Plan::whole(view, [64, 64, 2048], Spacing::CUBIC, sampling).ok()?;
    // The shears that the integers stand for.
    Some((plan, components.map(|c| c as f64 / one as f64)))
}

/// The worst distance of a ray's positions from the line, in units of 2^-16 voxel.
fn worst(plan: &Plan, shears: [f64; 2]) -> f64 {
    let origin = plan.origin().map(f64::from);
    let mut worst: f64 = 0.0;
    for index in 0..plan.planes() {
        let at = plane(plan, Phase::default(), index);
        let k = f64::from(index) / 16.0;
        for (fixed, exact) in [
            (at.x, origin[0] + shears[0] * k),
            (at.y, origin[1] + shears[1] * k),
            (at.z, k),
        ] {
            worst = worst.max((f64::from(fixed.to_bits()) - exact * 65536.0).abs());
        }
    }
    worst
}

/// All of them.
pub fn cases(size: Size) -> Vec<Case> {
    let views = match size {
        Size::Full => 200,
        Size::Reduced => 10,
    };
    let mut case = Case::new(
        "drift",
        format!("2048 slices x 16 planes, {views} views"),
        "worst position error, units of 2^-16 voxel",
        0.0,
        "half a unit of rounding, and half a unit of the step's last bit each step: 0.5 + K 2^(15 - bits)",
    );
    let bits = [6u32, 8, 10, 12, 14, 16, 20, 24, 28, 32];
    let mut found = vec![0.0f64; bits.len()];
    let mut state = 2026u64;
    let mut next = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    for _ in 0..views {
        if let Some((plan, shears)) = plan([next(), next()]) {
            for (found, bits) in found.iter_mut().zip(bits) {
                *found = found.max(worst(&plan.with_step_bits(bits), shears));
            }
        }
    }
    let steps = 2047.0 * 16.0;
    for (found, bits) in found.into_iter().zip(bits) {
        let who = if bits == 32 {
            "32.32 step (all precisions)".to_owned()
        } else {
            format!("step of {bits} fraction bits")
        };
        // A shorter step is a rounded step of 32 bits, which is itself a rounded one.
        let twice = if bits < 32 { steps * 2f64.powi(-17) } else { 0.0 };
        let allowed = 0.5 + steps * 2f64.powi(15 - bits as i32) + twice + 1e-3;
        case.outcome(who, found, Some(allowed));
    }
    case.paper = Some("14 of 16 bits may be wrong after 2048 slices x 4 planes (13 by its own formula)".into());
    case.study = Some("12 / 16 / 20 / 24 / 28 / 32 bits: 261493 / 16331 / 1023 / 64 / 4.3 / 0.69".into());
    vec![case]
}
