//! Block normalisation and the reciprocal root.

use slicecast::normalise::{Normal, normalise, unit};

use super::Numbers;
use crate::set::{Field, Set, ijk, s, u};

/// g and r.
pub fn normal() -> Vec<Field> {
    let mut fields = ijk(&s("g", 16, "block-normalised")).to_vec();
    fields.push(u("r", 22, "2^35 / length of g"));
    fields
}

/// Gradients whose g, S and r stand at an end or beside a half.
fn gradients() -> Vec<[i64; 3]> {
    let mut all = vec![
        [0; 3],
        // S = 898823412: the only S whose root in f64 is wrong. All g at their end: the largest S, the least r.
        [17590, 17356, 16976],
        [-17590, 17356, -16976],
        [32767; 3],
        [-32767; 3],
        // S = 2^28: r = 2^21.
        [16384, 0, 0],
        [0, -16384, 0],
        [0, 0, 1],
        [-1, 0, 0],
        // The lowest number.
        [i32::MIN.into(), 1 << 30, -(1 << 15)],
        [i32::MIN.into(), i32::MIN.into(), i32::MIN.into()],
        [i32::MAX.into(), i32::MIN.into(), 1 << 15],
    ];
    for n in 0..31 {
        let top = 1_i64 << n;
        // A single bit, all bits (which saturate behind a rounding), and the bitwise or of the magnitudes: the largest
        // component alone need not have its highest bit.
        all.extend([[top, 0, 0], [0, -top, top], [2 * top - 1, 0, 0], [top, 0, 1 - 2 * top]]);
        if n >= 15 {
            // Halves of what is rounded off, above and below zero.
            let half = 1_i64 << (n - 15);
            for around in [-1, 0, 1] {
                let c = top + half + around;
                all.extend([[c, -c, 3 * half + around], [-c, c, -half + around]]);
            }
        }
    }
    let mut numbers = Numbers(6);
    for round in 0..300 {
        let end = (1_i64 << (round % 31 + 1)) - 1;
        all.push([(); 3].map(|()| numbers.within(-end, end)));
    }
    all
}

/// Gradients of every size.
pub fn normalisation() -> Set {
    let inputs = ijk(&s("gradient", 32, "any")).to_vec();
    let about = "direction of a gradient: its largest component with 15 bits, and the reciprocal length";
    let mut set = Set::new(None, "normalisation", about, inputs, normal());
    for gradient in gradients() {
        let Normal { g: [x, y, z], r } = normalise(gradient.map(|c| c as i32));
        set.push(&gradient, &[x.into(), y.into(), z.into(), r.into()]);
    }
    set
}

/// The normal for export.
pub fn export() -> Set {
    let outputs = ijk(&s("normal", 17, "2^-15")).to_vec();
    let about = "the normal for export, towards higher values; no later stage reads it";
    let mut set = Set::new(None, "export", about, normal(), outputs);
    for gradient in gradients() {
        let normal = normalise(gradient.map(|c| c as i32));
        let [x, y, z] = normal.g.map(i64::from);
        let exported = unit(normal).map(|c| i64::from(c.to_bits()));
        set.push(&[x, y, z, normal.r.into()], &exported);
    }
    set
}

/// Normals for the shading of directed sets.
pub(super) fn normals() -> Vec<[i64; 4]> {
    let normal = |gradient: [i64; 3]| {
        let Normal { g: [x, y, z], r } = normalise(gradient.map(|c| c as i32));
        [x.into(), y.into(), z.into(), r.into()]
    };
    gradients().into_iter().map(normal).collect()
}
