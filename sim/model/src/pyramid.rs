//! Pyramids: one axis after another, by the definition of the filter.
//!
//! Source: Kraus and Bürger, "Interpolating and Downsampling RGBA Volume Data", section 4. A voxel has red, green and blue times
//! extinction, and extinction; whatever is linear in these may be filtered.

/// Red, green and blue times extinction, and extinction.
pub type Voxel = [f64; 4];

/// A filter that halves an axis.
#[derive(Clone, Copy, Debug)]
pub struct Halving<'a> {
    /// Its weights, symmetric; their sum divides.
    pub weights: &'a [f64],
    /// Whether coarse voxels lie on fine ones (an odd number of weights), and not between two (an even number).
    pub on_nodes: bool,
}

impl Halving<'_> {
    /// A line of half the voxels; one that cannot be halved stays.
    pub fn line(&self, line: &[Voxel]) -> Vec<Voxel> {
        let least = if self.on_nodes { 3 } else { 2 };
        if line.len() < least {
            return line.to_vec();
        }
        let mut whole = line.to_vec();
        if whole.len().is_multiple_of(2) == self.on_nodes {
            whole.extend(line.last());
        }
        // The mirror images at both ends, written out; nodes have their outer voxel once.
        let once = usize::from(self.on_nodes);
        let image: Vec<Voxel> = whole.iter().rev().copied().collect();
        let before = &image[..image.len() - once];
        let extended = [before, &whole, &image[once..]].concat();
        let sum: f64 = self.weights.iter().sum();
        let coarse = (whole.len() + once) / 2;
        let reach = (self.weights.len() - 1) / 2;
        let voxel = |m: usize| {
            let first = before.len() + 2 * m - reach;
            let window = &extended[first..first + self.weights.len()];
            [0, 1, 2, 3].map(|k| self.weights.iter().zip(window).map(|(w, v)| w * v[k]).sum::<f64>() / sum)
        };
        (0..coarse).map(voxel).collect()
    }

    /// A volume of half the voxels along each axis, and its shape.
    pub fn volume(&self, dims: [usize; 3], voxels: &[Voxel]) -> ([usize; 3], Vec<Voxel>) {
        let (mut dims, mut voxels) = (dims, voxels.to_vec());
        for axis in [2, 1, 0] {
            (dims, voxels) = self.axis(axis, dims, &voxels);
        }
        (dims, voxels)
    }

    fn axis(&self, axis: usize, dims: [usize; 3], voxels: &[Voxel]) -> ([usize; 3], Vec<Voxel>) {
        let place = |at: [usize; 3], dims: [usize; 3]| at[0] + dims[0] * (at[1] + dims[1] * at[2]);
        let [other, another] = [[1, 2], [0, 2], [0, 1]][axis];
        let mut halved = dims;
        let mut all = Vec::new();
        for b in 0..dims[another] {
            for a in 0..dims[other] {
                let mut at = [0; 3];
                (at[other], at[another]) = (a, b);
                let fine: Vec<Voxel> = (0..dims[axis])
                    .map(|n| {
                        at[axis] = n;
                        voxels[place(at, dims)]
                    })
                    .collect();
                let coarse = self.line(&fine);
                halved[axis] = coarse.len();
                all.resize(halved.iter().product(), [0.0; 4]);
                for (n, voxel) in coarse.into_iter().enumerate() {
                    at[axis] = n;
                    all[place(at, halved)] = voxel;
                }
            }
        }
        (halved, all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_the_papers() {
        let line: Vec<Voxel> = [4.0, 0.0, 0.0, 8.0].map(|tau| [tau / 2.0, 0.0, 0.0, tau]).to_vec();
        let of = |weights: &[f64], on_nodes| -> Vec<f64> {
            let coarse = Halving { weights, on_nodes }.line(&line);
            assert!(coarse.iter().all(|v| v[0] == v[3] / 2.0));
            coarse.iter().map(|v| v[3]).collect()
        };
        assert_eq!(of(&[1.0, 1.0], false), [2.0, 4.0]);
        assert_eq!(of(&[1.0; 4], false), [2.0, 4.0]);
        // 0 4 | 4 0 0 8 | 8 0 with (3,2,3,3,2,3): 0·3 + 4·2 + 4·3 + 0 + 0 + 8·3 = 44, and 4·3 + 8·3 + 8·2 = 52.
        assert_eq!(of(&[3.0, 2.0, 3.0, 3.0, 2.0, 3.0], false), [44.0 / 16.0, 52.0 / 16.0]);
        // Nodes 0 0 [4 0 0 8 8] 8 0: 0 + 0 + 8 + 0 + 0, 4 + 0 + 0 + 16 + 8, 0 + 16 + 16 + 16 + 0.
        assert_eq!(of(&[1.0, 2.0, 2.0, 2.0, 1.0], true), [1.0, 28.0 / 8.0, 6.0]);
    }
}
