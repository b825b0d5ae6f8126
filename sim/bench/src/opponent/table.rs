//! The opponent's transfer-function table: the same entries as the fixed-point one, opacities as floats.

use slicecast::classify::{Classifier, Support};
use slicecast::precision::Compact;
use slicecast::table::ENTRIES;
use slicecast::table::Neighboured;

use slicecast_engine::simd::floats::Floats;
use slicecast_engine::table::Table;

/// A table of 16 KiB of opacities and 16 KiB of colours. Colours stay bytes until they are mixed: three conversions of
/// a whole vector cost less than three times the look-ups.
#[derive(Clone, Debug)]
pub struct FloatTable {
    opacities: Box<Neighboured>,
    colours: Box<Neighboured>,
    pub(super) one_colour: bool,
    pub(super) support: Support,
}

fn column(value: impl Fn(usize) -> u32) -> Box<Neighboured> {
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
        let colours = column(|index| {
            let [r, g, b] = table.colour_bytes(index);
            u32::from_le_bytes([r, g, b, 0])
        });
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

    /// Opacities of a row, linear between entries. All have room for whole vectors; what the last one holds behind the
    /// samples is finite.
    #[inline(always)]
    pub(super) fn opacity_row<F: Floats>(&self, samples: &[f32], codes: &mut [i32], out: &mut [f32]) {
        let opacities = &*self.opacities;
        code_row::<F>(samples, codes);
        for at in (0..samples.len()).step_by(F::COUNT) {
            let [a, b] = F::look_up(opacities, codes, at);
            a.towards(b, F::load(samples, at) - F::load_whole(codes, at))
                .store(out, at);
        }
    }

    /// Colours of a row, 0 to 1, linear between entries.
    #[inline(always)]
    pub(super) fn colour_row<F: Floats>(&self, samples: &[f32], codes: &mut [i32], out: [&mut [f32]; 3]) {
        let colours = &*self.colours;
        code_row::<F>(samples, codes);
        let scale = F::splat(1.0 / 255.0);
        let [red, green, blue] = out;
        for at in (0..samples.len()).step_by(F::COUNT) {
            let [[ar, ag, ab], [br, bg, bb]] = F::look_up_colours(colours, codes, at);
            let f = F::load(samples, at) - F::load_whole(codes, at);
            (ar.towards(br, f) * scale).store(red, at);
            (ag.towards(bg, f) * scale).store(green, at);
            (ab.towards(bb, f) * scale).store(blue, at);
        }
    }
}

/// The codes of a row of samples, in memory, from where they are looked up.
#[inline(always)]
fn code_row<F: Floats>(samples: &[f32], codes: &mut [i32]) {
    for at in (0..samples.len()).step_by(F::COUNT) {
        F::load(samples, at).store_whole(codes, at);
    }
}
