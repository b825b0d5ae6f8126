//! A pixel and one more sample, in both orders, and projection.

use slicecast::composite::{Channel, Dither, Pixel, Recurrence, settle};
use slicecast::format::Opacity;
use slicecast::precision::Precision;
use slicecast::project::{Extreme, Maximum, Minimum, resolve};

use super::classification::{Entry, Memories, entry};
use super::{Numbers, channel, colour, sample_unit};
use crate::set::{Field, Set, rgb, s, u};

/// A pixel's channels.
pub fn pixel<P: Precision>(p: P, name: &str) -> Vec<Field> {
    let mut fields = rgb(&channel(p, name)).to_vec();
    fields.push(channel(p, &format!("{name}_t")));
    fields
}

type ChannelOf<P> = <<P as Precision>::Pixel as Recurrence>::Channel;

fn pixel_of<C: Channel>([red, green, blue, t]: [i64; 4]) -> Pixel<C> {
    Pixel {
        colour: [red, green, blue].map(|c| C::from_bits(c as u32)),
        transparency: C::from_bits(t as u32),
    }
}

fn values<C: Channel>(pixel: Pixel<C>) -> [i64; 4] {
    let [red, green, blue] = pixel.colour.map(|c| c.bits().into());
    [red, green, blue, pixel.transparency.bits().into()]
}

/// What a sample brings: opacity, colour, plane.
fn sample_fields<P: Precision>(p: P) -> Vec<Field> {
    let mut fields = pixel(p, "before");
    fields.push(u("opacity", 32, "2^-31"));
    fields.extend(rgb(&colour(p, "colour")));
    fields.push(u("plane", 16, "number from the eye"));
    fields
}

/// Opacities: the ends, one unit of 1.31 and of 1.16, the most that a table gives, and 1.
const OPACITIES: [i64; 12] = [
    0,
    1,
    32767,
    32768,
    32769,
    65536,
    1 << 24,
    1 << 30,
    (1 << 30) + 12345,
    2_147_418_113,
    (1 << 31) - 1,
    1 << 31,
];

/// Planes whose offsets stand at an end: dT = 0, 32767; dC = 0, 32767.
const PLANES: [i64; 6] = [0, 1, 3309, 13007, 25346, 32768];

/// Pixels and samples: `each` is called with the pixel before, opacity, colour, plane.
fn samples<P: Precision>(p: P, mut each: impl FnMut([i64; 4], i64, [i64; 3], i64)) {
    let (one, full) = (i64::from(p.pixel().one().bits()), 1_i64 << p.pixel().colour_bits());
    for t in [0, 1, 2, one / 2, one - 1, one] {
        for opacity in OPACITIES {
            for plane in PLANES {
                each(
                    [0, (one - t) / 2, one - t, t],
                    opacity,
                    [full, full / 2, full - 1],
                    plane,
                );
                each([one - t, 0, 0, t], opacity, [0, 1, full], plane);
            }
        }
    }
    let mut numbers = Numbers(13);
    for _ in 0..400 {
        let t = numbers.within(0, one);
        let before = [numbers.within(0, one - t), numbers.within(0, one - t), one - t, t];
        let opacity = match numbers.within(0, 2) {
            0 => numbers.within(0, 1 << 31),
            1 => numbers.within(0, 1 << 20),
            _ => numbers.of(&OPACITIES),
        };
        let colour = [(); 3].map(|()| numbers.within(0, full));
        each(before, opacity, colour, numbers.within(0, 32768));
    }
}

/// Over, and the floor.
pub fn front_to_back<P: Precision>(p: P) -> Set {
    let mut inputs = sample_fields(p);
    inputs.push(channel(p, "floor"));
    let about = "a pixel with one more sample behind it; transparency below the floor becomes 0";
    let mut set = Set::new(Some(P::NAME), "compositing", about, inputs, pixel(p, "after"));
    let mut push = |before: [i64; 4], opacity: i64, colour: [i64; 3], plane: i64, floor: i64| {
        let dither = Dither::of_plane(plane as u32);
        let opaque = Opacity::from_bits(opacity as u32);
        let pixel = pixel_of::<ChannelOf<P>>(before);
        let mut after = p.pixel().over(pixel, colour.map(|c| c as u32), opaque, dither);
        after.transparency = settle(after.transparency, Channel::from_bits(floor as u32));
        let inputs = [&before[..], &[opacity], &colour, &[plane, floor]].concat();
        set.push(&inputs, &values(after));
    };
    let (one, own) = (i64::from(p.pixel().one().bits()), i64::from(p.pixel().floor().bits()));
    samples(p, |before, opacity, colour, plane| {
        push(before, opacity, colour, plane, own)
    });
    // Both sides of the floor, its own and those of early termination.
    for floor in [own, one >> 8, one >> 1] {
        for t in [floor - 1, floor, floor + 1] {
            for opacity in [0, 1, 32768, 1 << 20] {
                push([0, 0, one - t, t], opacity, [1, 2, 3], 0, floor);
            }
        }
    }
    set
}

/// Under.
pub fn back_to_front<P: Precision>(p: P) -> Set {
    let about = "a pixel with one more sample in front of it; no floor";
    let mut set = Set::new(
        Some(P::NAME),
        "compositing-back",
        about,
        sample_fields(p),
        pixel(p, "after"),
    );
    samples(p, |before, opacity, colour, plane| {
        let dither = Dither::of_plane(plane as u32);
        let opaque = Opacity::from_bits(opacity as u32);
        let pixel = pixel_of::<ChannelOf<P>>(before);
        let after = p.pixel().under(pixel, colour.map(|c| c as u32), opaque, dither);
        set.push(&[&before[..], &[opacity], &colour, &[plane]].concat(), &values(after));
    });
    set
}

fn extreme() -> Field {
    u("extreme", 1, "0 maximum, 1 minimum")
}

/// The bits of an empty ray.
const EMPTY: [i64; 2] = [-1, i32::MAX as i64];

/// The kept sample.
pub fn projection<P: Precision>(p: P) -> Set {
    let bits = p.formats().sample_bits;
    let inputs = vec![
        extreme(),
        s("kept", 32, sample_unit(p)),
        u("sample", 12 + bits, sample_unit(p)),
    ];
    let outputs = vec![s("kept_after", 32, sample_unit(p))];
    let about = "the larger or the smaller of the kept sample and one more; an empty ray has -1 or 2^31 - 1";
    let mut set = Set::new(Some(P::NAME), "projection", about, inputs, outputs);
    let end = 4095_i64 << bits;
    for extreme in [0, 1] {
        for kept in [EMPTY[extreme as usize], 0, 1, end / 2, end - 1, end] {
            for sample in [0, 1, end / 2, end / 2 + 1, end - 1, end] {
                let (a, b) = (kept as i32, sample as i32);
                let after = if extreme == 0 {
                    Maximum::keep(a, b)
                } else {
                    Minimum::keep(a, b)
                };
                set.push(&[extreme, kept, sample], &[after.into()]);
            }
        }
    }
    set
}

/// The pixel of a kept sample.
pub fn resolution<P: Precision>(p: P) -> Set {
    let bits = p.formats().sample_bits;
    let mut inputs = vec![
        extreme(),
        s("kept", 32, sample_unit(p)),
        u("code", 2, "0 sqrt8, 1 sqrt16, 2 colour16"),
    ];
    inputs.extend(entry("entry"));
    let about = "the pixel of a kept sample that lies at its entry; over a clear pixel with a dither of 0, no floor";
    let mut set = Set::new(Some(P::NAME), "resolution", about, inputs, pixel(p, "after"));
    let roots = [0_i64, 1, 255, 256, 257, 0x7fff, 0xff00, 0xffff];
    for extreme in [0, 1] {
        for (at, root) in (0..).zip(roots) {
            let colour = [0x00, 0x7f, 0xff, 0x80][at % 4];
            let entry: Entry = [root >> 8 << 24 | colour << 16 | 0x01ff, root & 255, 0xff, 0x80, colour];
            for code in 0..3 {
                let code_at = [0, 7, 4095][at % 3];
                for kept in [EMPTY[extreme as usize], code_at << bits] {
                    let mut memories = Memories::new();
                    memories.set(code_at as usize, entry);
                    let pixel = memories.resolved(p, code, extreme, kept as i32);
                    set.push(&[&[extreme, kept, code][..], &entry].concat(), &pixel);
                }
            }
        }
    }
    set
}

impl Memories {
    /// The pixel of a kept sample.
    fn resolved<P: Precision>(&self, p: P, code: i64, extreme: i64, kept: i32) -> [i64; 4] {
        use slicecast::classify::{Colour16, Linear, PointTable, Sqrt8, Sqrt16};
        fn of<P: Precision>(
            p: P,
            extreme: i64,
            kept: i32,
            table: &impl slicecast::classify::Classifier<P>,
        ) -> [i64; 4] {
            values(if extreme == 0 {
                resolve::<P, Maximum>(p, kept, table)
            } else {
                resolve::<P, Minimum>(p, kept, table)
            })
        }
        let (words, roots, both) = self.memories();
        match code {
            0 => of(p, extreme, kept, &PointTable::<Sqrt8, Linear>::new(words, ())),
            1 => of(p, extreme, kept, &PointTable::<Sqrt16, Linear>::new(words, roots)),
            _ => of(p, extreme, kept, &PointTable::<Colour16, Linear>::new(words, both)),
        }
    }
}
