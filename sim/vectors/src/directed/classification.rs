//! Opacity and colour of a sample.

use slicecast::classify::{Classifier, Colour16, Linear, Nearest, PointTable, Sqrt8, Sqrt16};
use slicecast::precision::Precision;
use slicecast::table::ENTRIES;

use super::{Numbers, colour, sample_unit};
use crate::set::{Field, Set, rgb, u};

/// An entry as the table's memories hold it.
pub fn entry(name: &str) -> Vec<Field> {
    let mut fields = vec![
        u(name, 32, "0xAABBGGRR"),
        u(format!("{name}_low_root"), 8, "low byte of the root"),
    ];
    fields.extend(rgb(&u(format!("{name}_low"), 8, "low byte of the colour")));
    fields
}

/// Opacity and colour.
pub fn outputs<P: Precision>(p: P) -> Vec<Field> {
    let mut fields = vec![u("opacity", 32, "2^-31")];
    fields.extend(rgb(&colour(p, "colour")));
    fields
}

/// An entry: the word, and the low bytes of root, red, green and blue.
pub type Entry = [i64; 5];

/// The low bytes of roots and of colours.
type LowBytes<'a> = (&'a [u8; ENTRIES], &'a [[u8; 3]; ENTRIES]);

/// The memories of a table, all entries 0 but some.
pub struct Memories {
    words: Box<[u32; ENTRIES]>,
    roots: Box<[u8; ENTRIES]>,
    colours: Box<[[u8; 3]; ENTRIES]>,
}

impl Memories {
    /// A table of nothing.
    pub fn new() -> Self {
        Self {
            words: Box::new([0; ENTRIES]),
            roots: Box::new([0; ENTRIES]),
            colours: Box::new([[0; 3]; ENTRIES]),
        }
    }

    /// Writes an entry.
    pub fn set(&mut self, at: usize, [word, root, red, green, blue]: Entry) {
        self.words[at] = word as u32;
        self.roots[at] = root as u8;
        self.colours[at] = [red, green, blue].map(|c| c as u8);
    }

    /// Words, low bytes of the roots, and both planes of low bytes.
    pub(super) fn memories(&self) -> (&[u32; ENTRIES], &[u8; ENTRIES], LowBytes<'_>) {
        (&self.words, &self.roots, (&self.roots, &self.colours))
    }

    /// Calls with the classifier of a code (0 `Sqrt8`, 1 `Sqrt16`, 2 `Colour16`) and a look-up (0 nearest, 1 linear).
    pub fn with<P: Precision, T>(&self, code: i64, lookup: i64, with: impl FnOnce(&dyn Classified<P>) -> T) -> T {
        let (words, roots, both) = self.memories();
        match (code, lookup) {
            (0, 0) => with(&PointTable::<Sqrt8, Nearest>::new(words, ())),
            (0, _) => with(&PointTable::<Sqrt8, Linear>::new(words, ())),
            (1, 0) => with(&PointTable::<Sqrt16, Nearest>::new(words, roots)),
            (1, _) => with(&PointTable::<Sqrt16, Linear>::new(words, roots)),
            (_, 0) => with(&PointTable::<Colour16, Nearest>::new(words, both)),
            (_, _) => with(&PointTable::<Colour16, Linear>::new(words, both)),
        }
    }
}

/// What a classifier says of one sample.
pub trait Classified<P: Precision> {
    /// Opacity, red, green, blue.
    fn of(&self, p: P, sample: i32) -> [i64; 4];
}

impl<P: Precision, C: Classifier<P>> Classified<P> for C {
    fn of(&self, p: P, sample: i32) -> [i64; 4] {
        let [red, green, blue] = self.colour(p, sample).map(i64::from);
        [self.opacity(p, sample).to_bits().into(), red, green, blue]
    }
}

/// All codes and look-ups; the ends of roots, colours and fractions.
pub fn classification<P: Precision>(p: P) -> Set {
    let bits = p.formats().sample_bits;
    let mut inputs = vec![
        u("code", 2, "0 sqrt8, 1 sqrt16, 2 colour16"),
        u("lookup", 1, "0 nearest, 1 linear"),
        u("sample", 12 + bits, sample_unit(p)),
    ];
    inputs.extend(entry("entry"));
    inputs.extend(entry("next"));
    let about = "opacity and colour of a sample between the entry of its code and the next";
    let mut set = Set::new(Some(P::NAME), "classification", about, inputs, outputs(p));
    let mut push = |sample: i64, here: Entry, next: Entry| {
        for code in 0..3 {
            for lookup in 0..2 {
                let at = (sample >> bits) as usize;
                let mut memories = Memories::new();
                // The entry behind 4095 is not read: what stands there is any number.
                if at + 1 < ENTRIES {
                    memories.set(at + 1, next);
                }
                memories.set(at, here);
                let seen = memories.with(code, lookup, |table| table.of(p, sample as i32));
                let inputs = [&[code, lookup, sample][..], &here, &next].concat();
                set.push(&inputs, &seen);
            }
        }
    };
    let (one, half) = (1_i64 << bits, 1_i64 << (bits - 1));
    let fractions = [0, 1, half - 1, half, half + 1, one - 1];
    // Every byte another, so that an exchanged one is seen.
    let distinct: [Entry; 2] = [
        [0x4433_2211, 0x55, 0x66, 0x77, 0x88],
        [0xccbb_aa99, 0xdd, 0xee, 0xf0, 0x0f],
    ];
    let (clear, full): (Entry, Entry) = ([0; 5], [0xffff_ffff, 255, 255, 255, 255]);
    let pairs = [
        [distinct[0], distinct[1]],
        [distinct[1], distinct[0]],
        [clear, full],
        [full, clear],
        [full, full],
        // Roots and colours of one unit, and of one byte's unit.
        [[0, 1, 1, 1, 1], clear],
        [clear, [0, 1, 1, 1, 1]],
        [[0x0101_0101, 0, 0, 0, 0], [0x0101_0101, 1, 1, 1, 1]],
        [[0x7fff_ffff, 255, 255, 255, 255], [0x8000_0000, 0, 0, 0, 0]],
        [[0x8080_8080, 128, 128, 128, 128], [0x7f7f_7f7f, 127, 127, 127, 127]],
    ];
    for [here, next] in pairs {
        for fraction in fractions {
            for code in [0, 1, 100, 4094] {
                push((code << bits) + fraction, here, next);
            }
        }
        push(4095 << bits, here, next);
    }
    let mut numbers = Numbers(4);
    for _ in 0..100 {
        let [here, next] = [(); 2].map(|()| {
            let byte = |numbers: &mut Numbers| numbers.within(0, 255);
            let word = numbers.within(0, u32::MAX.into());
            let [a, b, c, d] = [(); 4].map(|()| byte(&mut numbers));
            [word, a, b, c, d]
        });
        push(numbers.within(0, (4095 << bits) - 1), here, next);
    }
    set
}
