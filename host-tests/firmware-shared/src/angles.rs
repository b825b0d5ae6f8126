//! Views made on the device from angles.

use slicecast::view::{Axis, View};

use crate::sum::Sum;

/// Sum of the views from a round of angles, with cubic and with stretched voxels: axis, side and shear of each.
#[must_use]
pub fn sum() -> u32 {
    let mut sum = Sum::new();
    for azimuth in -18..=18i16 {
        for elevation in -8..=8i16 {
            for spacing in [[1.0, 1.0, 1.0], [3.2, 3.2, 1.5]] {
                // Tenths of radians: no angle is special.
                let (a, e) = (f32::from(azimuth) / 5.8, f32::from(elevation) / 5.3);
                match View::from_angles(a, e, spacing) {
                    Ok(view) => add(&mut sum, &view),
                    Err(_) => sum.word(u32::MAX),
                }
            }
        }
    }
    sum.get()
}

fn add(sum: &mut Sum, view: &View) {
    sum.word(match view.major() {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    });
    sum.word(u32::from(view.reversed()));
    for step in view.shear(3) {
        let bits = step.to_bits() as u64;
        sum.word(bits as u32);
        sum.word((bits >> 32) as u32);
    }
}
