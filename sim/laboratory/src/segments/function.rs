//! A transfer function as extinction and colour over codes, and its integral functions, in f64.

use slicecast_scene::TransferFunction;

/// Nodes per code; between nodes extinction, and extinction times colour, are linear.
const NODES: usize = 16;
/// The last code.
pub const LAST: f64 = 4095.0;
/// Extinction per voxel is at most this, as in the contract of segments.
const EXTINCTION_MAX: f64 = 16.0;

/// Of integrals.
const UNIT: f64 = (1u64 << 40) as f64;

fn whole(integral: f64) -> i64 {
    (integral * UNIT).round() as i64
}

/// Extinction, and extinction times red, green, blue; or integrals of them.
pub type Sums = [f64; 4];

/// Extinction and colour of codes 0 to 4095, per voxel, with their integrals. Integrals are whole multiples of 2^-40, at most
/// 2^56 of them, so that a change leaves differences beyond it as they were, to the bit.
#[derive(Clone, Debug)]
pub struct Function {
    at: Vec<Sums>,
    until: Vec<[i64; 4]>,
}

impl Function {
    /// From a transfer function whose values are codes.
    pub fn new(transfer: &TransferFunction) -> Self {
        let per_voxel = 1.0 / transfer.unit_distance;
        Self::of(|code| {
            let (colour, opacity) = transfer.evaluate(code);
            let extinction = (-(-opacity).ln_1p() * per_voxel).min(EXTINCTION_MAX);
            [
                extinction,
                extinction * colour[0],
                extinction * colour[1],
                extinction * colour[2],
            ]
        })
    }

    /// From extinction and extinction times colour at codes.
    pub fn of(at: impl Fn(f64) -> Sums) -> Self {
        let nodes = LAST as usize * NODES + 1;
        let at: Vec<Sums> = (0..nodes).map(|node| at(node as f64 / NODES as f64)).collect();
        let mut sum = [0; 4];
        let mut until = vec![sum];
        for pair in at.windows(2) {
            sum = [0, 1, 2, 3].map(|n| sum[n] + whole((pair[0][n] + pair[1][n]) / (2 * NODES) as f64));
            until.push(sum);
        }
        Self { at, until }
    }

    /// The node below a code, and how far beyond it the code lies, 0 to 1.
    fn place(&self, code: f64) -> (usize, f64) {
        let place = code.clamp(0.0, LAST) * NODES as f64;
        let node = (place as usize).min(self.at.len() - 2);
        (node, place - node as f64)
    }

    /// Extinction, and extinction times colour, at a code.
    pub fn at(&self, code: f64) -> Sums {
        let (node, beyond) = self.place(code);
        let [a, b] = [self.at[node], self.at[node + 1]];
        [0, 1, 2, 3].map(|n| a[n] + (b[n] - a[n]) * beyond)
    }

    /// The integral functions T and K (paper, equations 8 and 10) at a code, in 2^-40.
    fn until(&self, code: f64) -> [i64; 4] {
        let (node, beyond) = self.place(code);
        let [a, b] = [self.at[node], self.at[node + 1]];
        let width = 1.0 / NODES as f64;
        [0, 1, 2, 3].map(|n| self.until[node][n] + whole(width * beyond * (a[n] + (b[n] - a[n]) * beyond / 2.0)))
    }

    /// Mean extinction, and mean extinction times colour, between two codes.
    pub fn mean(&self, front: f64, back: f64) -> Sums {
        self.between((front, self.until(front)), (back, self.until(back)))
    }

    /// The same of equal pieces from one code to another, in this order.
    pub fn means(&self, [front, back]: [f64; 2], pieces: usize) -> impl Iterator<Item = Sums> + '_ {
        let mut from = (front, self.until(front));
        (1..=pieces).map(move |n| {
            let code = front + (back - front) * n as f64 / pieces as f64;
            let to = (code, self.until(code));
            let mean = self.between(from, to);
            from = to;
            mean
        })
    }

    fn between(&self, (front, a): (f64, [i64; 4]), (back, b): (f64, [i64; 4])) -> Sums {
        if (back - front).abs() < 1e-4 {
            return self.at((front + back) / 2.0);
        }
        [0, 1, 2, 3].map(|n| (b[n] - a[n]) as f64 / UNIT / (back - front))
    }
}
