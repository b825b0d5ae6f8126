//! A table as vectors like it: the same bits as core's point tables, in more memory.
//!
//! Opacities are decoded beforehand, and both neighbours of a sample are fetched with one load; what is left is done in
//! lanes. A table of one colour is not asked for colours at all. 32 KiB, of which a sample reads 16 bytes.

use slicecast::classify::{AlphaCode, Classifier, Linear, PointTable, Slab, Support, colour_of_entry, mix_colour};
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
    /// R, G, B in bytes.
    colours: Box<Neighboured>,
    /// The entry whose colour is every entry's.
    one_colour: Option<u32>,
    /// The first visible code; behind the last one where none is.
    first_visible: usize,
    support: Support,
    lookup: LookupName,
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
        let colours = column(|index| entries[index] & 0x00ff_ffff);
        let opacities = column(|index| A::opacity(A::root(entries[index], plane, index)).to_bits());
        Self {
            first_visible: opacities.iter().position(|a| *a != 0).unwrap_or(opacities.len()),
            opacities,
            one_colour: Some(colours[0]).filter(|first| colours.iter().all(|c| c == first)),
            colours,
            support: Classifier::<slicecast::precision::Compact>::support(&PointTable::<A, Linear>::new(
                entries, plane,
            )),
            lookup,
        }
    }
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

#[inline(always)]
fn mixed_colour<P: Precision, V: Lanes>(p: P, a: V, b: V, channel: u32, f: V) -> V {
    let bits = p.pixel().colour_bits();
    mix_colour(
        p,
        colour_of_entry(a, channel, bits),
        colour_of_entry(b, channel, bits),
        f,
    )
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
        let entry = self.one_colour? as i32;
        Some([0, 1, 2].map(|channel| colour_of_entry(entry, channel, p.pixel().colour_bits()) as u32))
    }

    #[inline(always)]
    fn opacity_row<V: Lanes>(&self, p: P, Slab { back: samples }: Slab<'_>, out: &mut [i32]) {
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
    fn colour_row<V: Lanes>(&self, p: P, Slab { back: samples }: Slab<'_>, out: [&mut [i32]; 3]) {
        let [red, green, blue] = out;
        if let Some([r, g, b]) = Classifier::one_colour(self, p) {
            red.fill(r as i32);
            green.fill(g as i32);
            blue.fill(b as i32);
            return;
        }
        let (len, colours) = (samples.len(), &*self.colours);
        let (red, green, blue) = (&mut red[..len], &mut green[..len], &mut blue[..len]);
        match self.lookup {
            LookupName::Nearest => {
                for at in places::<V>(len) {
                    let entry = nearest::<P, V>(p, colours, samples, at);
                    colour_of_entry(entry, 0, p.pixel().colour_bits()).store(red, at);
                    colour_of_entry(entry, 1, p.pixel().colour_bits()).store(green, at);
                    colour_of_entry(entry, 2, p.pixel().colour_bits()).store(blue, at);
                }
            }
            LookupName::Linear => {
                for at in places::<V>(len) {
                    let ([a, b], f) = around::<P, V>(p, colours, samples, at);
                    mixed_colour::<P, V>(p, a, b, 0, f).store(red, at);
                    mixed_colour::<P, V>(p, a, b, 1, f).store(green, at);
                    mixed_colour::<P, V>(p, a, b, 2, f).store(blue, at);
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
    use slicecast::classify::{Lookup, Nearest, Sqrt8, Sqrt16};
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
        }
    }
}
