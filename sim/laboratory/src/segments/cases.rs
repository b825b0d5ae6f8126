//! Fields and transfer functions on which classifications of segments are compared.

use slicecast_scene::{Point, TransferFunction};

/// A field of voxels, in codes, and a transfer function over codes.
pub struct Case {
    /// Its name.
    pub name: &'static str,
    side: usize,
    voxels: Vec<f64>,
    /// Values are codes, the unit distance is a voxel.
    pub transfer: TransferFunction,
}

impl Case {
    fn new(
        name: &'static str,
        side: usize,
        field: impl Fn([f64; 3]) -> f64,
        points: Vec<(f64, [f64; 3], f64)>,
    ) -> Self {
        let middle = (side - 1) as f64 / 2.0;
        let place = |n: usize| (n as f64 - middle) / middle;
        let voxel = |n: usize| field([n % side, n / side % side, n / side / side].map(place));
        let point = |(value, colour, opacity)| Point { value, colour, opacity };
        Self {
            name,
            side,
            voxels: (0..side.pow(3)).map(|n| voxel(n).round().clamp(0.0, 4095.0)).collect(),
            transfer: TransferFunction {
                unit_distance: 1.0,
                points: points.into_iter().map(point).collect(),
            },
        }
    }

    /// The harmonic of 16³ under 256 random points.
    pub fn harmonic() -> Self {
        Self::new("harmonic, 256 random", 16, harmonic, random(256))
    }

    /// Voxels along an edge.
    pub fn side(&self) -> usize {
        self.side
    }

    /// The voxels, x fastest: whole numbers of 0 to 4095.
    pub fn codes(&self) -> impl Iterator<Item = f64> + '_ {
        self.voxels.iter().copied()
    }

    /// The trilinear field at a place in voxels.
    pub fn at(&self, place: [f64; 3]) -> f64 {
        let low = place.map(|c| (c.max(0.0) as usize).min(self.side - 2));
        let [x, y, z] = [0, 1, 2].map(|axis| place[axis] - low[axis] as f64);
        let voxel = |n: usize| {
            let at = [0, 1, 2].map(|axis| low[axis] + (n >> axis & 1));
            self.voxels[at[0] + self.side * (at[1] + self.side * at[2])]
        };
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let row = |n: usize| mix(voxel(n), voxel(n + 1), x);
        mix(mix(row(0), row(2), y), mix(row(4), row(6), y), z)
    }
}

/// Numbers of 0 to 1 from a fixed seed (splitmix64).
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ a >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((b ^ b >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Spherical harmonic of degree 4, order 0, decaying outwards: the kind of field of the paper's figure 10.
fn harmonic([x, y, z]: [f64; 3]) -> f64 {
    let r = (x * x + y * y + z * z).sqrt().max(1e-9);
    let c = z / r;
    let legendre = (35.0 * c.powi(4) - 30.0 * c * c + 3.0) / 8.0;
    2048.0 + 2047.0 * legendre * r * (2.0 - r).max(0.0)
}

/// Marschner and Lobb's test signal, f_M = 6 and alpha = 0.25.
pub(crate) fn marschner_lobb([x, y, z]: [f64; 3]) -> f64 {
    use std::f64::consts::PI;
    let rho = (2.0 * PI * 6.0 * (PI * (x * x + y * y).sqrt() / 2.0).cos()).cos();
    4095.0 * (1.0 - (PI * z / 2.0).sin() + 0.25 * (1.0 + rho)) / 2.5
}

fn sphere([x, y, z]: [f64; 3]) -> f64 {
    4095.0 * (1.0 - (x * x + y * y + z * z).sqrt() / 3f64.sqrt())
}

fn random(points: usize) -> Vec<(f64, [f64; 3], f64)> {
    let mut random = Random::new(points as u64);
    let mut point = |n: usize| {
        let colour = [(); 3].map(|()| random.number());
        (
            n as f64 * 4095.0 / (points - 1) as f64,
            colour,
            -f64::exp_m1(-6.0 * random.number().powi(3)),
        )
    };
    (0..points).map(&mut point).collect()
}

fn bands() -> Vec<(f64, [f64; 3], f64)> {
    let mut random = Random::new(24);
    let band = |n: usize| {
        let (low, colour) = (100.0 + 165.0 * n as f64, [(); 3].map(|()| random.number()));
        [(low, colour, 0.0), (low + 20.0, colour, 0.5), (low + 40.0, colour, 0.0)]
    };
    (0..24).flat_map(band).collect()
}

fn shells(width: f64) -> Vec<(f64, [f64; 3], f64)> {
    let opaque = -f64::exp_m1(-16.0);
    let shell = |(n, colour): (usize, [f64; 3])| {
        let low = 1400.5 + 400.0 * n as f64;
        [
            (low, colour, 0.0),
            (low, colour, opaque),
            (low + width, colour, opaque),
            (low + width, colour, 0.0),
        ]
    };
    let colours = [
        [1.0, 0.2, 0.1],
        [0.2, 1.0, 0.1],
        [0.1, 0.3, 1.0],
        [1.0; 3],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 1.0],
    ];
    colours.into_iter().enumerate().flat_map(shell).collect()
}

/// Voxels along an edge.
fn edge(reduced: bool) -> usize {
    if reduced { 24 } else { 64 }
}

/// Marschner and Lobb's signal under a transfer function without detail: what is undersampled here is the field.
pub fn smooth(reduced: bool) -> Case {
    let points = vec![
        (0.0, [0.2, 0.3, 0.9], 0.0),
        (2048.0, [0.9, 0.8, 0.3], 0.1),
        (4095.0, [1.0, 0.2, 0.1], 0.2),
    ];
    Case::new("Marschner-Lobb, smooth", edge(reduced), marschner_lobb, points)
}

/// The cases, in the order of the report. Edges of 64 voxels, or of `reduced` 24.
pub fn cases(reduced: bool) -> Vec<Case> {
    let side = edge(reduced);
    let fog = vec![(0.0, [1.0; 3], 0.0), (4095.0, [0.7, 0.8, 1.0], 0.01)];
    vec![
        Case::harmonic(),
        Case::new("harmonic, 64 random", 16, harmonic, random(64)),
        Case::new("Marschner-Lobb, 24 bands", side, marschner_lobb, bands()),
        Case::new("sphere, shells of 1 code", side, sphere, shells(1.0)),
        Case::new("sphere, shells of 3 codes", side, sphere, shells(3.0)),
        Case::new("sphere, thin fog", side, sphere, fog),
    ]
}
