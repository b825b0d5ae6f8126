//! How a table entry of a study holds its opacity (Squeeze, section 4.4 and figure 1).
//!
//! | code | entry | opacity |
//! |---|---|---|
//! | [`Plain8`] | α 0.8 in the entry | q / 255 |
//! | [`Plain16`] | α 0.16: the high byte in the entry, the low byte in a plane of its own | q / 65536 |
//! | core's `Sqrt8`, `Sqrt16` | √α 0.8, √α 0.16 | their square |

use slicecast::classify::{AlphaCode, Sqrt8, Sqrt16};
use slicecast::format::Opacity;
use slicecast::table::ENTRIES;

use slicecast_engine::expanded::Expanded;
use slicecast_engine::table::Filled;
use slicecast_scene::LookupName;

/// A code that a study can name and fill a table with.
pub trait Coded: AlphaCode {
    /// The name that reports use.
    const NAME: &'static str;
    /// The nearest code of an opacity: the byte in the entry and the byte in the plane.
    fn encode(opacity: f64) -> [u8; 2];
    /// The opacity of a code.
    fn decode(bytes: [u8; 2]) -> Opacity;
    /// A table filled with this code, decoded for the host's vectors.
    fn expanded(table: &Filled, lookup: LookupName) -> Expanded;
}

/// Opacity in 8 bits, 255 is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plain8;

/// Opacity in 16 bits, 0.16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plain16;

impl AlphaCode for Plain8 {
    type Plane<'a> = ();
    const PLANE_BYTES: usize = 0;
    #[inline(always)]
    fn root(entry: u32, (): (), _: usize) -> u16 {
        (entry >> 24) as u16
    }
    /// `q / 255` in 1.31, to nearest.
    #[inline(always)]
    fn opacity(code: u16) -> Opacity {
        Opacity::from_bits((((u64::from(code) << 32) + 255) / 510) as u32)
    }
}

impl AlphaCode for Plain16 {
    type Plane<'a> = &'a [u8; ENTRIES];
    const PLANE_BYTES: usize = ENTRIES;
    #[inline(always)]
    fn root(entry: u32, plane: &[u8; ENTRIES], index: usize) -> u16 {
        Sqrt16::root(entry, plane, index)
    }
    #[inline(always)]
    fn opacity(code: u16) -> Opacity {
        Opacity::from_bits(u32::from(code) << 15)
    }
}

impl Coded for Plain8 {
    const NAME: &'static str = "alpha8";
    fn encode(opacity: f64) -> [u8; 2] {
        [(opacity * 255.0).round() as u8, 0]
    }
    fn decode([high, _]: [u8; 2]) -> Opacity {
        Self::opacity(u16::from(high))
    }
    fn expanded(table: &Filled, lookup: LookupName) -> Expanded {
        Expanded::of::<Self>(&table.entries, (), lookup)
    }
}

impl Coded for Plain16 {
    const NAME: &'static str = "alpha16";
    fn encode(opacity: f64) -> [u8; 2] {
        ((opacity * 65536.0).round().min(65535.0) as u16).to_be_bytes()
    }
    fn decode(bytes: [u8; 2]) -> Opacity {
        Self::opacity(u16::from_be_bytes(bytes))
    }
    fn expanded(table: &Filled, lookup: LookupName) -> Expanded {
        Expanded::of::<Self>(&table.entries, &table.plane, lookup)
    }
}

impl Coded for Sqrt8 {
    const NAME: &'static str = "sqrt8";
    fn encode(opacity: f64) -> [u8; 2] {
        [(opacity.sqrt() * 255.0).round() as u8, 0]
    }
    fn decode([high, _]: [u8; 2]) -> Opacity {
        Self::opacity(257 * u16::from(high))
    }
    fn expanded(table: &Filled, lookup: LookupName) -> Expanded {
        Expanded::of::<Self>(&table.entries, (), lookup)
    }
}

impl Coded for Sqrt16 {
    const NAME: &'static str = "sqrt16";
    fn encode(opacity: f64) -> [u8; 2] {
        ((opacity.sqrt() * 65536.0).round().min(65535.0) as u16).to_be_bytes()
    }
    fn decode(bytes: [u8; 2]) -> Opacity {
        Self::opacity(u16::from_be_bytes(bytes))
    }
    fn expanded(table: &Filled, lookup: LookupName) -> Expanded {
        Expanded::of::<Self>(&table.entries, &table.plane, lookup)
    }
}

#[cfg(test)]
mod tests {
    use super::super::formats::Study;
    use super::*;
    use slicecast::classify::{Classifier, Linear, Lookup, Nearest, PointTable, Slab};

    /// Every opacity comes back within half a step of its code (as the code's own scale has it).
    fn within<A: Coded>(step: impl Fn(f64) -> f64) {
        for i in 0..=20_000 {
            let opacity = f64::from(i) / 20_000.0;
            let got = f64::from(A::decode(A::encode(opacity)).to_bits()) / 2147483648.0;
            assert!(
                (got - opacity).abs() <= step(opacity) + 1e-9,
                "{} {opacity} {got}",
                A::NAME
            );
        }
    }

    #[test]
    fn codes_come_back_within_half_a_step() {
        within::<Plain8>(|_| 0.5 / 255.0);
        // The largest code is 65535 / 65536.
        within::<Plain16>(|_| 1.0 / 65536.0);
        // A code is 257 q / 65536, which is 2^-16 less than q / 255.
        within::<Sqrt8>(|a| a.sqrt() / 255.0 + 0.25 / 65025.0 + 2.0 * a / 65536.0);
        within::<Sqrt16>(|a| 2.0 * a.sqrt() / 65536.0 + 1.0 / 4294967296.0);
    }

    /// The classifier reads what `decode` says.
    #[test]
    fn the_pipeline_decodes_alike() {
        for byte in [0u8, 1, 127, 128, 254, 255] {
            for low in [0u8, 1, 255] {
                let entry = u32::from(byte) << 24;
                let plane = [low; ENTRIES];
                assert_eq!(Plain8::opacity(Plain8::root(entry, (), 0)), Plain8::decode([byte, 0]));
                assert_eq!(
                    Plain16::opacity(Plain16::root(entry, &plane, 7)),
                    Plain16::decode([byte, low])
                );
                assert_eq!(Sqrt8::opacity(Sqrt8::root(entry, (), 0)), Sqrt8::decode([byte, 0]));
                assert_eq!(
                    Sqrt16::opacity(Sqrt16::root(entry, &plane, 7)),
                    Sqrt16::decode([byte, low])
                );
            }
        }
        assert_eq!(Plain8::decode([255, 0]).to_bits(), 1 << 31);
    }

    /// What a study runs, decoded tables, has the bits of the definition, whatever the sample's width and the lanes.
    fn held<'a, A: Coded, L: Lookup>(sample_bits: u32, filled: &'a Filled, plane: A::Plane<'a>) {
        let mut study = Study::compact();
        study.formats.sample_bits = sample_bits;
        let table = PointTable::<A, L>::new(&filled.entries, plane);
        let lookup = if L::LINEAR {
            LookupName::Linear
        } else {
            LookupName::Nearest
        };
        let expanded = &A::expanded(filled, lookup);
        let samples: Vec<i32> = (0..=4095 << sample_bits).step_by(7).collect();
        let row = || vec![0; samples.len()];
        let (mut expected, mut found) = (row(), row());
        table.opacity_row::<i32>(study, Slab::of(&samples), &mut expected);
        expanded.opacity_row::<i32>(study, Slab::of(&samples), &mut found);
        assert!(expected == found, "{} {lookup:?} {sample_bits}", A::NAME);
        let [mut expected, mut found] = [(); 2].map(|()| [row(), row(), row()]);
        table.colour_row::<i32>(study, Slab::of(&samples), expected.each_mut().map(|r| &mut r[..]));
        expanded.colour_row::<i32>(study, Slab::of(&samples), found.each_mut().map(|r| &mut r[..]));
        assert!(expected == found, "{} {lookup:?} {sample_bits}", A::NAME);
    }

    #[test]
    fn decoded_tables_are_the_definition() {
        let word = |index: usize| (index as u32).wrapping_mul(0x9e37_79b9);
        let filled = Filled {
            entries: Box::new(std::array::from_fn(word)),
            plane: Box::new(std::array::from_fn(|index| word(index + 1) as u8)),
            underflows: 0,
        };
        held::<Plain8, Nearest>(12, &filled, ());
        held::<Plain8, Linear>(12, &filled, ());
        held::<Plain16, Nearest>(12, &filled, &filled.plane);
        held::<Plain16, Linear>(12, &filled, &filled.plane);
        held::<Sqrt16, Linear>(4, &filled, &filled.plane);
        held::<Sqrt16, Linear>(6, &filled, &filled.plane);
        held::<Sqrt16, Linear>(8, &filled, &filled.plane);
        held::<Sqrt16, Linear>(10, &filled, &filled.plane);
        held::<Sqrt16, Linear>(15, &filled, &filled.plane);
    }
}
