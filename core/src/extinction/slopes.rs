//! Gradients of extinctions: codes of 15 bits in the range of voxels of 12.
//!
//! Source: `docs/contract/extinction.md`, "Gradient". A code is read as eighths of a voxel, so that the row kernels of voxels, their
//! ghosts beyond a face and their doubled differences have the range that they are made for, and no bit of the code is lost.

use crate::precision::{Formats, Precision};

/// A precision whose voxels are eighths ([`Precision::VOXEL_FRACTION`]): extinctions of which gradients are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Eighths<P>(pub P);

impl<P: Precision> Precision for Eighths<P> {
    type Pixel = P::Pixel;
    const NAME: &'static str = P::NAME;
    const VOXEL_FRACTION: u32 = 3;

    #[inline(always)]
    fn formats(self) -> Formats {
        self.0.formats()
    }

    #[inline(always)]
    fn pixel(self) -> P::Pixel {
        self.0.pixel()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Weight;
    use crate::interpolate::trilinear_words;
    use crate::precision::{Compact, Wide};
    use proptest::prelude::*;

    /// The formula of the contract in 128 bits.
    fn exact(voxels: [[[i32; 2]; 2]; 2], [wx, wy, wz]: [u32; 3], sample_bits: u32) -> i128 {
        let z = |y: usize, x: usize| {
            let [near, far] = [0, 1].map(|z| i128::from(voxels[z][y][x]));
            (near << 13) + (((far - near) * i128::from(wz) + 4) >> 3)
        };
        let y = |x: usize| z(0, x) + (((z(1, x) - z(0, x)) * i128::from(wy) + (1 << 15)) >> 16);
        let cut = 16 - sample_bits;
        (y(0) + (((y(1) - y(0)) * i128::from(wx)) >> 16) + (1 << cut >> 1)) >> cut
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        /// Derivatives at faces, the widest numbers that the kernels are given, and differences between them of twice that.
        #[test]
        fn eighths_are_the_formula(
            voxels in prop::array::uniform2(prop::array::uniform2(prop::array::uniform2(
                prop_oneof![Just(65534i32), Just(-65534), Just(0), -65534i32..=65534],
            ))),
            weights in prop::array::uniform3(prop_oneof![Just(0u32), Just(65535), 0u32..=65535]),
        ) {
            // Along z derivatives differ by no more than 65534.
            let [near, far] = voxels;
            let far = [0, 1].map(|y| [0, 1].map(|x| far[y][x].clamp(near[y][x] - 65534, near[y][x] + 65534)));
            let (voxels, at) = ([near, far], weights.map(Weight::from_bits));
            prop_assert_eq!(i128::from(trilinear_words(Eighths(Compact), voxels, at)), exact(voxels, weights, 12));
            prop_assert_eq!(i128::from(trilinear_words(Eighths(Wide), voxels, at)), exact(voxels, weights, 15));
        }
    }
}
