//! A table as vectors like it: the same bits as core's point tables, in more memory.
//!
//! Opacities are decoded beforehand, and both neighbours of a sample are fetched with one load; what is left is done in
//! lanes. A table of one colour is not asked for colours at all. 32 KiB, of which a sample reads 16 bytes; 48 and 24 where
//! colours have more than 8 bits.

use slicecast::classify::{
    AlphaCode, Classifier, Linear, PointTable, Slab, Support, colour_of_word, colour_of_words, mix_colour,
};
use slicecast::composite::Recurrence as _;
use slicecast::format::Opacity;
use slicecast::lanes::{Lanes, places};
use slicecast::precision::Precision;
use slicecast::table::ENTRIES;
use slicecast::table::{Coding, Neighboured};

use slicecast_scene::LookupName;

/// Samples that are not looked up where none of them is bright enough to be visible.
const TOGETHER: usize = 64;

/// A classifier over decoded entries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expanded {
    /// 1.31.
    opacities: Box<Neighboured>,
    colours: Colours,
    /// The first visible code; behind the last one where none is.
    first_visible: usize,
    support: Support,
    lookup: LookupName,
}

/// The colours of all entries.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Colours {
    /// The same for all: R, G, B, 65535 is 1.
    One([u16; 3]),
    /// R, G, B in bytes.
    Bytes(Box<Neighboured>),
    /// R and G in 16 bits each, and B.
    Words([Box<Neighboured>; 2]),
}

fn column(value: impl FnMut(usize) -> u32) -> Box<Neighboured> {
    let values: Vec<u32> = (0..=ENTRIES).map(|index| index.min(ENTRIES - 1)).map(value).collect();
    values
        .into_boxed_slice()
        .try_into()
        .unwrap_or_else(|_| unreachable!("as many as were asked for"))
}

impl Expanded {
    /// Decodes the entries of a point table.
    pub fn of<'a, A: AlphaCode>(entries: &'a [u32; ENTRIES], plane: A::Plane<'a>, lookup: LookupName) -> Self {
        let table = PointTable::<A, Linear>::new(entries, plane);
        let opacities = column(|code| table.code_opacity(code).to_bits());
        Self {
            first_visible: opacities.iter().position(|a| *a != 0).unwrap_or(opacities.len()),
            opacities,
            colours: Colours::of(|code| table.code_colour(code)),
            support: Classifier::<slicecast::precision::Compact>::support(&table),
            lookup,
        }
    }
}

impl Colours {
    fn of(colour: impl Fn(usize) -> [u16; 3]) -> Self {
        let first = colour(0);
        if (0..ENTRIES).all(|code| colour(code) == first) {
            return Self::One(first);
        }
        if (0..ENTRIES).all(|code| colour(code).iter().all(|word| word % 257 == 0)) {
            return Self::Bytes(column(|code| {
                let [r, g, b] = colour(code).map(|word| u32::from(word / 257));
                r | g << 8 | b << 16
            }));
        }
        let [red_green, blue] = [0, 1].map(|place| {
            column(|code| {
                let [r, g, b] = colour(code).map(u32::from);
                if place == 0 { r | g << 16 } else { b }
            })
        });
        Self::Words([red_green, blue])
    }
}

/// 16-bit colours of three bytes.
#[inline(always)]
fn of_bytes<V: Lanes>(bytes: V) -> [V; 3] {
    let (mask, twice) = (V::splat(0xff), V::splat(257));
    [
        (bytes & mask) * twice,
        (bytes.shr_unsigned(8) & mask) * twice,
        (bytes.shr_unsigned(16) & mask) * twice,
    ]
}

/// 16-bit colours of their two columns.
#[inline(always)]
fn of_words<V: Lanes>(red_green: V, blue: V) -> [V; 3] {
    [red_green & V::splat(0xffff), red_green.shr_unsigned(16), blue]
}

/// Decodes colours and writes them.
#[inline(always)]
fn store_decoded<P: Precision, V: Lanes>(p: P, [r, g, b]: [V; 3], [red, green, blue]: [&mut [i32]; 3], at: usize) {
    let bits = p.pixel().colour_bits();
    colour_of_words(r, bits).store(red, at);
    colour_of_words(g, bits).store(green, at);
    colour_of_words(b, bits).store(blue, at);
}

/// Decodes the colours of two entries, mixes them and writes them.
#[inline(always)]
fn store_mixed<P: Precision, V: Lanes>(
    p: P,
    [[r0, g0, b0], [r1, g1, b1]]: [[V; 3]; 2],
    f: V,
    [red, green, blue]: [&mut [i32]; 3],
    at: usize,
) {
    mixed(p, r0, r1, f).store(red, at);
    mixed(p, g0, g1, f).store(green, at);
    mixed(p, b0, b1, f).store(blue, at);
}

#[inline(always)]
fn mixed<P: Precision, V: Lanes>(p: P, a: V, b: V, f: V) -> V {
    let bits = p.pixel().colour_bits();
    mix_colour(p, colour_of_words(a, bits), colour_of_words(b, bits), f)
}

/// Whether no sample lies above a code.
#[inline(always)]
fn none_above<P: Precision, V: Lanes>(p: P, samples: &[i32], code: usize) -> bool {
    let least = V::splat(((code as i32) << p.formats().sample_bits) + 1);
    let mut above = V::splat(0);
    for at in places::<V>(samples.len()) {
        let sample = V::load(samples, at);
        above = above | sample.at_least_then(least, sample);
    }
    above.all_zero()
}

/// The values of the entries nearest to a row's samples.
#[inline(always)]
fn nearest<P: Precision, V: Lanes>(p: P, values: &Neighboured, samples: &[i32], at: usize) -> V {
    let (offset, bits) = (1 << p.formats().sample_bits >> 1, p.formats().sample_bits);
    let [value, _] = V::look_up(values, samples, at, Coding { offset, bits });
    value
}

/// The values of the entries on both sides of a row's samples, and the weights of the second ones.
#[inline(always)]
fn around<P: Precision, V: Lanes>(p: P, values: &Neighboured, samples: &[i32], at: usize) -> ([V; 2], V) {
    let (offset, bits) = (0, p.formats().sample_bits);
    let fraction = V::load(samples, at) & V::splat((1 << bits) - 1);
    (V::look_up(values, samples, at, Coding { offset, bits }), fraction)
}

impl<P: Precision> Classifier<P> for Expanded {
    fn opacity(&self, p: P, sample: i32) -> Opacity {
        let mut out = [0];
        self.opacity_row::<i32>(p, Slab::of(&[sample]), &mut out);
        Opacity::from_bits(out[0] as u32)
    }

    fn colour(&self, p: P, sample: i32) -> [u32; 3] {
        let [mut red, mut green, mut blue] = [[0]; 3];
        self.colour_row::<i32>(p, Slab::of(&[sample]), [&mut red, &mut green, &mut blue]);
        [red, green, blue].map(|[c]| c as u32)
    }

    fn support(&self) -> Support {
        self.support
    }

    #[inline(always)]
    fn one_colour(&self, p: P) -> Option<[u32; 3]> {
        let Colours::One(words) = self.colours else {
            return None;
        };
        Some(words.map(|word| colour_of_word(word, p.pixel().colour_bits())))
    }

    #[inline(always)]
    fn opacity_row<V: Lanes>(&self, p: P, Slab { back: samples, .. }: Slab<'_>, out: &mut [i32]) {
        // Its place does not change while rows are written.
        let opacities = &*self.opacities;
        for (samples, out) in samples.chunks(TOGETHER).zip(out.chunks_mut(TOGETHER)) {
            let samples = &samples[..out.len()];
            // Up to the code before the first visible one, neither neighbour is visible.
            if self.first_visible > 0 && none_above::<P, V>(p, samples, self.first_visible - 1) {
                out.fill(0);
                continue;
            }
            match self.lookup {
                LookupName::Nearest => {
                    for at in places::<V>(samples.len()) {
                        nearest::<P, V>(p, opacities, samples, at).store(out, at);
                    }
                }
                LookupName::Linear => {
                    for at in places::<V>(samples.len()) {
                        let ([a, b], f) = around::<P, V>(p, opacities, samples, at);
                        a.mix(b, f, p.formats().sample_bits).store(out, at);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn colour_row<V: Lanes>(&self, p: P, Slab { back: samples, .. }: Slab<'_>, out: [&mut [i32]; 3]) {
        let [red, green, blue] = out;
        let len = samples.len();
        let (red, green, blue) = (&mut red[..len], &mut green[..len], &mut blue[..len]);
        match (&self.colours, self.lookup) {
            (Colours::One(words), _) => {
                for (word, row) in words.iter().zip([red, green, blue]) {
                    row.fill(colour_of_word(*word, p.pixel().colour_bits()) as i32);
                }
            }
            (Colours::Bytes(bytes), LookupName::Nearest) => {
                for at in places::<V>(len) {
                    let words = of_bytes(nearest::<P, V>(p, bytes, samples, at));
                    store_decoded(p, words, [&mut *red, green, blue], at);
                }
            }
            (Colours::Bytes(bytes), LookupName::Linear) => {
                for at in places::<V>(len) {
                    let ([a, b], f) = around::<P, V>(p, bytes, samples, at);
                    store_mixed(p, [of_bytes(a), of_bytes(b)], f, [&mut *red, green, blue], at);
                }
            }
            (Colours::Words([red_green, other]), LookupName::Nearest) => {
                for at in places::<V>(len) {
                    let rg = nearest::<P, V>(p, red_green, samples, at);
                    let words = of_words(rg, nearest::<P, V>(p, other, samples, at));
                    store_decoded(p, words, [&mut *red, green, blue], at);
                }
            }
            (Colours::Words([red_green, other]), LookupName::Linear) => {
                for at in places::<V>(len) {
                    let ([rg0, rg1], f) = around::<P, V>(p, red_green, samples, at);
                    let ([b0, b1], _) = around::<P, V>(p, other, samples, at);
                    let both = [of_words(rg0, b0), of_words(rg1, b1)];
                    store_mixed(p, both, f, [&mut *red, green, blue], at);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use slicecast::classify::{Colour16, Lookup, Nearest, Sqrt8, Sqrt16};
    use slicecast::precision::{Compact, Wide};

    /// Every `step`th sample of a table, by the definition and expanded.
    fn held<'a, P: Precision, A: AlphaCode, L: Lookup>(
        p: P,
        entries: &'a [u32; ENTRIES],
        plane: A::Plane<'a>,
        step: usize,
    ) -> Result<(), TestCaseError> {
        let table = PointTable::<A, L>::new(entries, plane);
        let lookup = if L::LINEAR {
            LookupName::Linear
        } else {
            LookupName::Nearest
        };
        let expanded = Expanded::of::<A>(entries, plane, lookup);
        let samples: Vec<i32> = (0..=4095 << p.formats().sample_bits).step_by(step).collect();
        let mut rows = [(); 8].map(|()| vec![0; samples.len()]);
        let [a, r, g, b, found_a, found_r, found_g, found_b] = &mut rows;
        Classifier::opacity_row::<i32>(&table, p, Slab::of(&samples), a);
        Classifier::colour_row::<i32>(&table, p, Slab::of(&samples), [r, g, b]);
        Classifier::opacity_row::<i32>(&expanded, p, Slab::of(&samples), found_a);
        Classifier::colour_row::<i32>(&expanded, p, Slab::of(&samples), [found_r, found_g, found_b]);
        prop_assert!(a == found_a, "opacities");
        if let Some(colour) = Classifier::one_colour(&expanded, p) {
            for (row, c) in [&*r, &*g, &*b].into_iter().zip(colour) {
                prop_assert!(row.iter().all(|r| *r as u32 == c), "one colour");
            }
        }
        prop_assert!([r, g, b] == [found_r, found_g, found_b], "colours");
        prop_assert_eq!(Classifier::<P>::support(&table), Classifier::<P>::support(&expanded));
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 12, rng_seed: RngSeed::Fixed(4096), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn expanded_tables_are_the_definition(
            words in prop::collection::vec(any::<u32>(), ENTRIES),
            low in prop::collection::vec(any::<u8>(), ENTRIES),
            one_colour in any::<bool>(),
            dark in prop_oneof![Just(0), Just(ENTRIES), 1..ENTRIES],
            step in 301usize..399,
        ) {
            let mut entries: Box<[u32; ENTRIES]> = words.into_boxed_slice().try_into().unwrap();
            let mut low = low;
            // Codes that are invisible, up to some code.
            for (entry, low) in entries.iter_mut().zip(&mut low).take(dark) {
                *entry &= 0x00ff_ffff;
                *low = 0;
            }
            if one_colour {
                let colour = entries[0] & 0x00ff_ffff;
                for entry in entries.iter_mut() {
                    *entry = *entry & 0xff00_0000 | colour;
                }
            }
            let low: Box<[u8; ENTRIES]> = low.into_boxed_slice().try_into().unwrap();
            held::<_, Sqrt8, Linear>(Compact, &entries, (), step)?;
            held::<_, Sqrt16, Linear>(Compact, &entries, &low, step)?;
            held::<_, Sqrt16, Nearest>(Compact, &entries, &low, step)?;
            held::<_, Sqrt8, Nearest>(Wide, &entries, (), step)?;
            held::<_, Sqrt16, Linear>(Wide, &entries, &low, step)?;
            let colours: Vec<[u8; 3]> = entries.iter().map(|e| (e >> 3).to_le_bytes()).map(|[r, g, b, _]| [b, r, g]).collect();
            let colours: Box<[[u8; 3]; ENTRIES]> = colours.into_boxed_slice().try_into().unwrap();
            held::<_, Colour16, Linear>(Compact, &entries, (&low, &colours), step)?;
            held::<_, Colour16, Nearest>(Compact, &entries, (&low, &colours), step)?;
            held::<_, Colour16, Nearest>(Wide, &entries, (&low, &colours), step)?;
            held::<_, Colour16, Linear>(Wide, &entries, (&low, &colours), step)?;
        }
    }
}
