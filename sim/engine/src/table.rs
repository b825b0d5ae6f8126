//! Transfer functions compiled to the pipeline's table.
//!
//! A code is at most half a step away from the opacity it stands for, but in fog of one density every sample would be
//! wrong by the same amount. So the rounding error of an entry is handed on to the next one (error diffusion along the
//! table): neighbouring entries are wrong in opposite directions, and samples that differ by a few codes cancel. It
//! costs at most one more half step in a single entry.
//!
//! Colours of 8 bits are enough where every visible entry has a colour of 8 bits, as scenes do that give each structure one
//! colour. Where colours change with the value, half an 8-bit step is wrong in what is seen, and colours get 16 bits.

use slicecast::classify::{
    Classifier, Colour16, Linear, Nearest, PointTable, Slab, Sqrt8, Sqrt16, Support, entry, opacity_of_root,
};
use slicecast::format::Opacity;
use slicecast::lanes::Lanes;
use slicecast::precision::Precision;
use slicecast::table::ENTRIES;

use crate::expanded::Expanded;
use slicecast_scene::{AlphaCodeName, LookupName, TransferFunction};
use slicecast_volume::Mapping;

/// A compiled table: what the pipeline's point tables borrow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// R, G, B and the square root of the opacity (or its high byte).
    pub entries: Box<[u32; ENTRIES]>,
    /// The root's low byte; all zero where the code has 8 bits.
    pub plane: Box<[u8; ENTRIES]>,
    /// The colours' low bytes; the entries' own where the code has colours of 8 bits.
    pub colours: Box<[[u8; 3]; ENTRIES]>,
    /// How root and colours are coded.
    pub code: AlphaCodeName,
    /// How samples find entries.
    pub lookup: LookupName,
    /// Entries that the transfer function makes visible and the code makes invisible.
    pub underflows: usize,
}

/// What an opacity is corrected for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Correction {
    /// The length of a ray's step, in the unit of the spacing.
    Step(f64),
    /// Nothing: the opacity as written.
    None,
}

impl Correction {
    /// `1 - (1 - opacity)^(step / unit)` (Squeeze, equation 7).
    pub fn apply(self, opacity: f64, unit_distance: f64) -> f64 {
        match self {
            Self::None => opacity,
            Self::Step(_) if opacity >= 1.0 => 1.0,
            Self::Step(length) => -((-opacity).ln_1p() * (length / unit_distance)).exp_m1(),
        }
    }
}

impl Table {
    /// Compiles a transfer function for 12-bit codes.
    pub fn compile(
        transfer: &TransferFunction,
        mapping: &Mapping,
        correction: Correction,
        code: AlphaCodeName,
        lookup: LookupName,
    ) -> Self {
        let encode = |opacity| encode(opacity, code);
        let decode = |[high, low]: [u8; 2]| decode(high, low, code);
        let Filled {
            entries,
            plane,
            underflows,
        } = fill(transfer, mapping, correction, encode, decode);
        let mut table = Self {
            colours: own_colours(&entries),
            entries,
            plane,
            code,
            lookup,
            underflows,
        };
        if code == AlphaCodeName::Colour16 {
            for code in 0..ENTRIES {
                let (colour, _) = transfer.evaluate(mapping.value(code as f64));
                table.set_colour(code, colour.map(|c| (c * 65535.0).round() as u16));
            }
        }
        table
    }

    /// Gives an entry a colour of 16 bits, 65535 is 1.
    pub fn set_colour(&mut self, index: usize, colour: [u16; 3]) {
        let [_, _, _, root] = self.entries[index].to_le_bytes();
        self.entries[index] = entry(colour.map(|c| (c >> 8) as u8), root);
        self.colours[index] = colour.map(|c| c as u8);
    }

    /// The colour of an entry, 65535 is 1.
    pub fn colour(&self, index: usize) -> [u16; 3] {
        let [r, g, b, _] = self.entries[index].to_le_bytes();
        let [r_low, g_low, b_low] = self.colours[index];
        [[r, r_low], [g, g_low], [b, b_low]].map(u16::from_be_bytes)
    }

    /// The colour of an entry to the nearest 8 bits.
    pub fn colour_bytes(&self, index: usize) -> [u8; 3] {
        self.colour(index).map(|c| ((u32::from(c) + 128) / 257) as u8)
    }

    /// The low bytes of roots and of colours.
    fn planes(&self) -> (&[u8; ENTRIES], &[[u8; 3]; ENTRIES]) {
        (&self.plane, &self.colours)
    }

    /// The classifier over this table, by core's definition.
    pub fn classifier(&self) -> AnyTable<'_> {
        match (self.code, self.lookup) {
            (AlphaCodeName::Sqrt8, LookupName::Nearest) => AnyTable::Nearest8(PointTable::new(&self.entries, ())),
            (AlphaCodeName::Sqrt8, LookupName::Linear) => AnyTable::Linear8(PointTable::new(&self.entries, ())),
            (AlphaCodeName::Sqrt16, LookupName::Nearest) => {
                AnyTable::Nearest16(PointTable::new(&self.entries, &*self.plane))
            }
            (AlphaCodeName::Sqrt16, LookupName::Linear) => {
                AnyTable::Linear16(PointTable::new(&self.entries, &*self.plane))
            }
            (AlphaCodeName::Colour16, LookupName::Nearest) => {
                AnyTable::NearestColour16(PointTable::new(&self.entries, self.planes()))
            }
            (AlphaCodeName::Colour16, LookupName::Linear) => {
                AnyTable::LinearColour16(PointTable::new(&self.entries, self.planes()))
            }
        }
    }

    /// The same as [`Table::classifier`], decoded for vectors: what frames are rendered with.
    pub fn expanded(&self) -> Expanded {
        match self.code {
            AlphaCodeName::Sqrt8 => Expanded::of::<Sqrt8>(&self.entries, (), self.lookup),
            AlphaCodeName::Sqrt16 => Expanded::of::<Sqrt16>(&self.entries, &self.plane, self.lookup),
            AlphaCodeName::Colour16 => Expanded::of::<Colour16>(&self.entries, self.planes(), self.lookup),
        }
    }

    /// The opacity that an entry decodes to, 1.31.
    pub fn opacity(&self, index: usize) -> Opacity {
        decode((self.entries[index] >> 24) as u8, self.plane[index], self.code)
    }

    /// Bytes that the pipeline reads.
    pub fn bytes(&self) -> usize {
        table_bytes(self.code)
    }
}

/// What a table holds, whatever its code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filled {
    /// See [`Table::entries`].
    pub entries: Box<[u32; ENTRIES]>,
    /// The second byte of every code.
    pub plane: Box<[u8; ENTRIES]>,
    /// See [`Table::underflows`].
    pub underflows: usize,
}

/// Fills a table with a code, given as the bytes of an opacity and the opacity of bytes (first the one in the entry,
/// then the one in the plane).
pub fn fill(
    transfer: &TransferFunction,
    mapping: &Mapping,
    correction: Correction,
    encode: impl Fn(f64) -> [u8; 2],
    decode: impl Fn([u8; 2]) -> Opacity,
) -> Filled {
    let mut filled = Filled {
        entries: Box::new([0; ENTRIES]),
        plane: Box::new([0; ENTRIES]),
        underflows: 0,
    };
    // What coding has added to or taken from the entries so far (see the head of this file).
    let mut owed = 0.0;
    for (index, (slot, low)) in filled.entries.iter_mut().zip(filled.plane.iter_mut()).enumerate() {
        let (colour, opacity) = transfer.evaluate(mapping.value(index as f64));
        let opacity = correction.apply(opacity, transfer.unit_distance);
        let wanted = if opacity > 0.0 && opacity < 1.0 {
            (opacity + owed).clamp(0.0, 1.0)
        } else {
            opacity
        };
        let code = encode(wanted);
        let [high, low_byte] = code;
        *low = low_byte;
        *slot = entry(colour.map(|c| (c * 255.0).round() as u8), high);
        owed = if opacity > 0.0 && opacity < 1.0 {
            wanted - f64::from(decode(code).to_bits()) / 2147483648.0
        } else {
            0.0
        };
        if opacity > 0.0 && code == [0, 0] {
            filled.underflows += 1;
        }
    }
    filled
}

/// The low bytes of colours of 8 bits: the entries' own.
pub fn own_colours(entries: &[u32; ENTRIES]) -> Box<[[u8; 3]; ENTRIES]> {
    let mut colours = Box::new([[0; 3]; ENTRIES]);
    for (own, entry) in colours.iter_mut().zip(entries) {
        let [r, g, b, _] = entry.to_le_bytes();
        *own = [r, g, b];
    }
    colours
}

/// Whether an entry that the transfer function makes visible has a colour that 8 bits do not hold.
pub fn has_fine_colours(transfer: &TransferFunction, mapping: &Mapping) -> bool {
    (0..ENTRIES).any(|code| {
        let (colour, opacity) = transfer.evaluate(mapping.value(code as f64));
        // Far below what 16 bits tell apart, far above what f64 loses.
        let fine = |c: f64| (255.0 * c - (255.0 * c).round()).abs() > 1e-6;
        opacity > 0.0 && colour.into_iter().any(fine)
    })
}

/// The nearest code of an opacity: the byte in the entry and the byte in the plane.
fn encode(opacity: f64, code: AlphaCodeName) -> [u8; 2] {
    let root = opacity.sqrt();
    match code {
        AlphaCodeName::Sqrt8 => [(root * 255.0).round() as u8, 0],
        AlphaCodeName::Sqrt16 | AlphaCodeName::Colour16 => ((root * 65536.0).round().min(65535.0) as u16).to_be_bytes(),
    }
}

/// The opacity of a code.
fn decode(high: u8, low: u8, code: AlphaCodeName) -> Opacity {
    opacity_of_root(match code {
        AlphaCodeName::Sqrt8 => 257 * u16::from(high),
        AlphaCodeName::Sqrt16 | AlphaCodeName::Colour16 => u16::from_be_bytes([high, low]),
    })
}

/// Bytes of a table with this code.
pub const fn table_bytes(code: AlphaCodeName) -> usize {
    match code {
        AlphaCodeName::Sqrt8 => PointTable::<Sqrt8, Nearest>::BYTES,
        AlphaCodeName::Sqrt16 => PointTable::<Sqrt16, Nearest>::BYTES,
        AlphaCodeName::Colour16 => PointTable::<Colour16, Nearest>::BYTES,
    }
}

/// One of the point tables, chosen at run time, once per row.
#[derive(Clone, Copy, Debug)]
pub enum AnyTable<'a> {
    /// 8-bit root, nearest entry.
    Nearest8(PointTable<'a, Sqrt8, Nearest>),
    /// 8-bit root, linear.
    Linear8(PointTable<'a, Sqrt8, Linear>),
    /// 16-bit root, nearest entry.
    Nearest16(PointTable<'a, Sqrt16, Nearest>),
    /// 16-bit root, linear.
    Linear16(PointTable<'a, Sqrt16, Linear>),
    /// 16-bit root and colours, nearest entry.
    NearestColour16(PointTable<'a, Colour16, Nearest>),
    /// 16-bit root and colours, linear.
    LinearColour16(PointTable<'a, Colour16, Linear>),
}

macro_rules! with_table {
    ($any:expr, $table:ident => $body:expr) => {
        match $any {
            AnyTable::Nearest8($table) => $body,
            AnyTable::Linear8($table) => $body,
            AnyTable::Nearest16($table) => $body,
            AnyTable::Linear16($table) => $body,
            AnyTable::NearestColour16($table) => $body,
            AnyTable::LinearColour16($table) => $body,
        }
    };
}

pub(crate) use with_table;

impl<P: Precision> Classifier<P> for AnyTable<'_> {
    fn opacity(&self, p: P, sample: i32) -> Opacity {
        with_table!(self, table => Classifier::opacity(table, p, sample))
    }

    fn colour(&self, p: P, sample: i32) -> [u32; 3] {
        with_table!(self, table => Classifier::colour(table, p, sample))
    }

    fn support(&self) -> Support {
        with_table!(self, table => Classifier::<P>::support(table))
    }

    fn opacity_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        with_table!(self, table => Classifier::opacity_row::<V>(table, p, slab, out));
    }

    fn colour_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: [&mut [i32]; 3]) {
        with_table!(self, table => Classifier::colour_row::<V>(table, p, slab, out));
    }
}
