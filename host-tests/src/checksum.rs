//! One number a stage, for golden manifests.
//!
//! A stage's checksum is the sum, modulo 2^64, of a mixture of place and bits of every value at its boundary. A sum
//! does not depend on the order, so tiles, threads and streams give the same number; and only visible samples count, so
//! a pipeline that learns to skip more keeps its checksums as long as it changes no bit that matters. A base-plane image
//! and a picture get the ordinary FNV-1a of their bytes.

use slicecast::composite::{Channel, PixelRow};
use slicecast::locate::Plane;
use slicecast::plan::Plan;
use slicecast::plane::Pipeline;
use slicecast::slice::Slice;
use slicecast::tap::{Beam, Tap};
use slicecast_engine::frame::Layer;
use slicecast_engine::image::{BaseImage, new_image};
use slicecast_engine::pipelines::Job;
use slicecast_engine::tiles::fold_tiles_tapped;

use crate::frame::Frame;
use crate::random::mixed;
use crate::record::Stage;

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
    samples: Vec<i32>,
    opacities: Vec<i32>,
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

    fn row(&mut self, stage: Stage, at: Beam<'_>, len: usize, bits: impl Fn(usize) -> [u32; 4]) {
        for n in 0..len {
            self.value(stage, at.plane, [at.row, at.column + n as u32], bits(n));
        }
    }

    fn pixels<C: Channel>(&mut self, stage: Stage, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        let [r, g, b] = &pixels.colour;
        let t = &pixels.transparency;
        self.row(stage, at, t.len(), |n| [r[n], g[n], b[n], t[n]].map(Channel::bits));
    }
}

fn bits3([a, b, c]: [&[i32]; 3], n: usize) -> [u32; 4] {
    [a[n] as u32, b[n] as u32, c[n] as u32, 0]
}

impl Tap for Sums {
    fn samples(&mut self, at: Beam<'_>, samples: &[i32]) {
        self.column = at.column;
        self.samples.clear();
        self.samples.extend_from_slice(samples);
    }

    fn opacities(&mut self, _: Beam<'_>, opacities: &[i32]) {
        self.opacities.clear();
        self.opacities.extend_from_slice(opacities);
    }

    fn colours(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        let len = colours[0].len();
        let start = (at.column - self.column) as usize;
        let (samples, opacities) = (std::mem::take(&mut self.samples), std::mem::take(&mut self.opacities));
        let Plane { x, y, z, .. } = at.plane;
        let position = [x, y, z].map(|p| p.to_bits() as u32);
        self.row(Stage::Location, at, len, |_| [position[0], position[1], position[2], 0]);
        self.row(Stage::Interpolation, at, len, |n| [samples[start + n] as u32, 0, 0, 0]);
        self.row(Stage::Opacity, at, len, |n| [opacities[start + n] as u32, 0, 0, 0]);
        self.row(Stage::Colour, at, len, |n| bits3(colours, n));
        (self.samples, self.opacities) = (samples, opacities);
    }

    fn gradients(&mut self, at: Beam<'_>, gradients: [&[i32]; 3]) {
        self.row(Stage::Gradient, at, gradients[0].len(), |n| bits3(gradients, n));
    }

    fn normals(&mut self, at: Beam<'_>, g: [&[i32]; 3], r: &[i32]) {
        self.row(Stage::Normal, at, r.len(), |n| {
            let [x, y, z, _] = bits3(g, n);
            [x, y, z, r[n] as u32]
        });
    }

    fn shaded(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        self.row(Stage::Shading, at, colours[0].len(), |n| bits3(colours, n));
    }

    fn after<C: Channel>(&mut self, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        self.pixels(Stage::After, at, pixels);
    }
}

/// Every checksum of a frame, by name: the stages that it has, then `image` and `picture`.
///
/// # Panics
/// If core or the engine refuses the frame.
pub fn of_frame(frame: &Frame) -> Vec<(&'static str, u64)> {
    struct Fold<'a>(&'a Plan, &'a [Slice<'a>]);
    impl Job for Fold<'_> {
        type Output = Sums;

        fn run<L: Pipeline>(self, pipeline: &L) -> Sums {
            let Self(plan, slices) = self;
            let mut image = new_image::<L>(plan).expect("a small image");
            let taps = fold_tiles_tapped(plan, pipeline, slices, &mut image, 16, &|_, _| (), |_| Sums::default());
            let mut all = Sums::default();
            taps.iter().for_each(|tap| all.add(tap));
            all
        }
    }
    frame.with_prepared(|prepared, slices| {
        let sums = prepared
            .dispatch(Fold(&prepared.setup.plan, slices))
            .expect("a material that core takes");
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
