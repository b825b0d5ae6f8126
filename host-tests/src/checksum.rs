//! One number a stage, for golden manifests.
//!
//! A stage's checksum is the sum, modulo 2^64, of a mixture of place and bits of every value at its boundary. A sum
//! does not depend on the order, so tiles, threads and streams give the same number; and only visible samples count, so
//! a pipeline that learns to skip more keeps its checksums as long as it changes no bit that matters. A base-plane image
//! and a picture get the ordinary FNV-1a of their bytes.

use slicecast::locate::Plane;
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits, Tap};
use slicecast_engine::frame::Layer;
use slicecast_engine::image::BaseImage;
use slicecast_engine::rendering::tapped;

use crate::frame::Frame;
use crate::random::mixed;
use crate::record::bits;

/// FNV-1a, 64 bits.
pub fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, step)
}

/// FNV-1a of an image's size, its 1.0 and raw channels, little-endian.
pub fn of_image(image: &BaseImage) -> u64 {
    let head = [image.size[0] as u32, image.size[1] as u32, image.one];
    let words = head.into_iter().chain(image.planes.iter().flatten().copied());
    fnv(words.flat_map(u32::to_le_bytes))
}

/// Checksums and numbers of values of the nine stages, in the order of [`Stage::ALL`].
#[derive(Clone, Debug, Default)]
pub struct Sums {
    sums: [u64; Stage::ALL.len()],
    counts: [u64; Stage::ALL.len()],
    /// The row under way: its first column, samples and opacities, of which the visible ones are still to be told.
    column: u32,
    samples: Vec<[u32; 4]>,
    opacities: Vec<u32>,
}

impl Sums {
    /// The checksum of a stage, or `None` if nothing was seen there.
    pub fn of(&self, stage: Stage) -> Option<u64> {
        let index = stage as usize;
        (self.counts[index] > 0).then_some(self.sums[index])
    }

    /// Adds what another tap has seen.
    pub fn add(&mut self, other: &Self) {
        for (a, b) in self.sums.iter_mut().zip(other.sums) {
            *a = a.wrapping_add(b);
        }
        for (a, b) in self.counts.iter_mut().zip(other.counts) {
            *a += b;
        }
    }

    fn value(&mut self, stage: Stage, plane: &Plane, [row, column]: [u32; 2], bits: [u32; 4]) {
        let [a, b, c, d] = bits.map(u64::from);
        let phase = (u64::from(plane.phase.u) << 4) | u64::from(plane.phase.v);
        let place = (u64::from(plane.index) << 40) | (phase << 32) | (u64::from(row) << 16) | u64::from(column);
        let mixture = mixed(mixed(mixed(place ^ ((stage as u64) << 60)) ^ ((a << 32) | b)) ^ ((c << 32) | d));
        self.sums[stage as usize] = self.sums[stage as usize].wrapping_add(mixture);
        self.counts[stage as usize] += 1;
    }

    fn values(&mut self, stage: Stage, at: Beam<'_>, len: usize, bits: impl Fn(usize) -> [u32; 4]) {
        for n in 0..len {
            self.value(stage, at.plane, [at.row, at.column + n as u32], bits(n));
        }
    }
}

impl Tap for Sums {
    fn row(&mut self, stage: Stage, at: Beam<'_>, rows: &[&dyn Bits]) {
        let len = rows.first().map_or(0, |row| row.len());
        let first = || (0..len).map(|n| bits(rows, n)[0]).collect();
        match stage {
            Stage::Interpolation => {
                (self.column, self.samples) = (at.column, (0..len).map(|n| bits(rows, n)).collect());
            }
            Stage::Opacity => self.opacities = first(),
            Stage::Colour => {
                let start = (at.column - self.column) as usize;
                let (samples, opacities) = (std::mem::take(&mut self.samples), std::mem::take(&mut self.opacities));
                let Plane { x, y, z, .. } = at.plane;
                let position = [x, y, z].map(|p| p.to_bits() as u32);
                self.values(Stage::Location, at, len, |_| [position[0], position[1], position[2], 0]);
                self.values(Stage::Interpolation, at, len, |n| samples[start + n]);
                self.values(Stage::Opacity, at, len, |n| [opacities[start + n], 0, 0, 0]);
                self.values(stage, at, len, |n| bits(rows, n));
                (self.samples, self.opacities) = (samples, opacities);
            }
            Stage::Location | Stage::Before => {}
            _ => self.values(stage, at, len, |n| bits(rows, n)),
        }
    }
}

/// Every checksum of a frame, by name: the stages that it has, then `image` and `picture`.
///
/// # Panics
/// If core or the engine refuses the frame.
pub fn of_frame(frame: &Frame) -> Vec<(&'static str, u64)> {
    frame.with_prepared(|prepared, slices| {
        let mut rendering = prepared.begun().expect("a small image of a material that core takes");
        let mut sums = Sums::default();
        for tap in tapped(&mut *rendering, slices, 16, &|_, _| (), |_| Sums::default()) {
            sums.add(&tap);
        }
        let stages = Stage::ALL
            .into_iter()
            .filter_map(|stage| Some((stage.name(), sums.of(stage)?)));
        let made = prepared.render(Layer::Tiles(16), &|_, _| ()).expect("a frame");
        let images = [
            ("image", of_image(&made.base)),
            ("picture", fnv(made.picture.bytes.iter().copied())),
        ];
        stages.chain(images).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fnv_is_the_published_one() {
        assert_eq!(fnv([]), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv(*b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv(*b"foobar"), 0x8594_4171_f739_67e8);
    }
}
