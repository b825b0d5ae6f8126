//! The opponent's transfer-function table: the same entries as the fixed-point one, opacities as floats.

use slicecast::classify::{Classifier, ENTRIES, Support};
use slicecast::precision::Compact;

use super::floats::Floats;
use crate::table::Table;

/// Samples that are looked up at a time: vectors then read what was written long before.
const AHEAD: usize = 64;

/// One value a code, and one more behind the last, which is read with a weight of 0.
type Column = Box<[u32; ENTRIES + 1]>;

/// A table of 16 KiB of opacities and 16 KiB of colours. Colours stay bytes until they are mixed: three conversions of
/// a whole vector cost less than three times the look-ups.
#[derive(Clone, Debug)]
pub struct FloatTable {
    opacities: Column,
    colours: Column,
    pub(super) one_colour: bool,
    pub(super) support: Support,
}

fn column(value: impl Fn(usize) -> u32) -> Column {
    let values: Vec<u32> = (0..=ENTRIES).map(|index| value(index.min(ENTRIES - 1))).collect();
    values
        .into_boxed_slice()
        .try_into()
        .unwrap_or_else(|_| unreachable!("as many as were asked for"))
}

impl FloatTable {
    /// The opacities that a table's codes decode to, and its colours.
    pub fn of(table: &Table) -> Self {
        let opacity = |index| table.opacity(index).to_bits() as f32 / 2_147_483_648.0;
        let colours = column(|index| table.entries[index] & 0x00ff_ffff);
        Self {
            opacities: column(|index| opacity(index).to_bits()),
            one_colour: colours.iter().all(|c| *c == colours[0]),
            colours,
            support: Classifier::<Compact>::support(&table.classifier()),
        }
    }

    /// The only colour of a table of one, 0 to 1.
    pub(super) fn first_colour(&self) -> [f32; 3] {
        [0, 8, 16].map(|shift| f32::from((self.colours[0] >> shift) as u8) / 255.0)
    }

    /// Opacities of a row, linear between entries. `out` is as long as the samples or longer; elements behind the
    /// samples become 0, as far as the last vector reaches.
    #[inline(always)]
    pub(super) fn opacity_row<F: Floats>(&self, samples: &[f32], out: &mut [f32]) {
        let (mut index, mut pairs) = ([0; AHEAD], [0; AHEAD]);
        let mut fractions = [0.0; AHEAD];
        for (samples, out) in samples.chunks(AHEAD).zip(out.chunks_mut(AHEAD)) {
            look_up::<F>(&self.opacities, samples, &mut index, &mut pairs, &mut fractions);
            for at in (0..samples.len()).step_by(F::COUNT) {
                let [a, b] = F::load_pairs(&pairs, at);
                a.towards(b, F::load(&fractions, at)).store(out, at);
            }
        }
    }

    /// Colours of a row, 0 to 1, linear between entries.
    #[inline(always)]
    pub(super) fn colour_row<F: Floats>(&self, samples: &[f32], out: [&mut [f32]; 3]) {
        let (mut index, mut pairs) = ([0; AHEAD], [0; AHEAD]);
        let mut fractions = [0.0; AHEAD];
        let scale = F::splat(1.0 / 255.0);
        let [red, green, blue] = out;
        let rows = red
            .chunks_mut(AHEAD)
            .zip(green.chunks_mut(AHEAD))
            .zip(blue.chunks_mut(AHEAD));
        for (samples, ((red, green), blue)) in samples.chunks(AHEAD).zip(rows) {
            look_up::<F>(&self.colours, samples, &mut index, &mut pairs, &mut fractions);
            for at in (0..samples.len()).step_by(F::COUNT) {
                let [[ar, ag, ab], [br, bg, bb]] = F::load_colours(&pairs, at);
                let f = F::load(&fractions, at);
                (ar.towards(br, f) * scale).store(red, at);
                (ag.towards(bg, f) * scale).store(green, at);
                (ab.towards(bb, f) * scale).store(blue, at);
            }
        }
    }
}

/// Fetches a value and its right neighbour for each sample, and splits the samples.
#[inline(always)]
fn look_up<F: Floats>(
    values: &Column,
    samples: &[f32],
    index: &mut [u32; AHEAD],
    pairs: &mut [u64; AHEAD],
    fractions: &mut [f32; AHEAD],
) {
    for at in (0..samples.len()).step_by(F::COUNT) {
        F::load(samples, at).split(index, at).store(fractions, at);
    }
    for (pair, &index) in pairs.iter_mut().zip(index.iter()).take(samples.len()) {
        let index = index as usize % ENTRIES;
        *pair = u64::from(values[index]) | u64::from(values[index + 1]) << 32;
    }
}
