//! Tolerance lines of what is beside the stages of every frame: modulation, sums, reflectance maps, splatting. As in
//! [`tolerance`](crate::tolerance), a line is exceeded, or stale below [`STALE`](crate::tolerance::STALE) of it.

/// A line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Whose output.
    pub quantity: &'static str,
    /// Units of the last place of its format.
    pub ulp: f64,
    /// Why as much as that.
    pub reason: &'static str,
}

/// The lines, by the functions of `host-tests/tests/beside.rs` that measure them.
pub const LINES: [Line; 10] = [
    Line {
        quantity: "modulation: factor, 1.15",
        ulp: 0.74,
        reason: "half a unit, and a place off by 4 x 2^-13.2 of a node and cut to 2^-15, of nodes 512 units apart",
    },
    Line {
        quantity: "modulation: opacity, 1.31",
        ulp: 0.5,
        reason: "one rounding of the product with the factor: proved",
    },
    Line {
        quantity: "average, 12.12",
        ulp: 0.5,
        reason: "exact sums, one rounding: proved",
    },
    Line {
        quantity: "additive, 12.12",
        ulp: 0.51,
        reason: "exact sums, one rounding, and what the product's lower part loses, below 2^-16: proved",
    },
    Line {
        quantity: "reflectance map, bilinear, 32 nodes, 1.15",
        ulp: 2.6,
        reason: "half a unit along a, along b and of the colour; places 1.01 x 31 / 2^16 of a node and 2^-15 off, of nodes up to 1480 units apart along both",
    },
    Line {
        quantity: "splatting: weight, 1.18",
        ulp: 7.8,
        reason: "nodes and the line between them 1.25 of 2^-15 along x and along y, a slab half of 2^-16, two roundings: 14.4 if all met; measured",
    },
    Line {
        quantity: "splatting: sample, 12.15",
        ulp: 0.5,
        reason: "exact sums, one rounding of the quotient: proved",
    },
    Line {
        quantity: "splatting in perspective: x and y, 13 fraction bits",
        ulp: 0.53,
        reason: "one rounding, and 1.04 phi 2^-17 + 1.5 |x| 2^-17 of the division at phi of 2000: proved",
    },
    Line {
        quantity: "splatting in perspective: weight along an axis, 1.16",
        ulp: 0.54,
        reason: "one rounding, and half of 2^-20 of a distance times a slope of at most 1: proved",
    },
    Line {
        quantity: "splatting in perspective: gradient along z, 12.15",
        ulp: 0.5,
        reason: "one rounding of exact products: proved",
    },
];
