//! The configurations that are instantiated: the named precisions, each parameter varied from `compact` one at a time,
//! and a few combinations.
//!
//! Every line but the positions' and the tables' is a pipeline of its own in the program, lit and (surfaces apart) unlit:
//! under the tap that gathers errors, with one lane and with eight. That is what building this crate takes longest for.

use slicecast::classify::{Linear, Lookup, Nearest, Sqrt8, Sqrt16};
use slicecast::composite::{Dithered, Unorm16};
use slicecast::format::{Sample12, Sample15};
use slicecast::plane::ChannelOf;
use slicecast::precision::{Compact, Paper, Precision, Wide};

use super::channels::{Byte, Long, Packed, Short};
use super::codes::{Coded, Plain8, Plain16};
use super::formats::{
    Blend, CompactPixel, CompactSurface, CompactValues, Cut, Deep, Deferred, Near, ParabolicPower, Sample4, Sample6,
    Sample8, Sample10, Study, TruncatedPower, TruncatedShading,
};
use super::measure::Runner;
use super::parameters::{self, Name, Parameter};
use super::pixels::{Carrying, Described, Product, Scaled, Telescoping};

/// A pipeline that a study can run.
#[derive(Clone, Debug)]
pub struct Configuration {
    /// Its name in reports.
    pub name: String,
    /// What it is made of.
    pub parameters: Vec<Parameter>,
    /// Bytes of a pixel.
    pub pixel_bytes: usize,
    /// Bytes of the table.
    pub table_bytes: usize,
    /// Fraction bits of a ray's step; 32 are all.
    pub step_bits: u32,
    /// What runs it.
    pub runner: Runner,
}

impl Configuration {
    fn of<P, A, L>(name: &str) -> Self
    where
        P: Precision<Pixel: Described>,
        A: Coded,
        L: Lookup,
    {
        Self::made::<P, P, A, L>(name)
    }

    /// See [`Runner::of`].
    fn made<P, U, A, L>(name: &str) -> Self
    where
        P: Precision<Pixel: Described>,
        U: Precision<Pixel: Described>,
        A: Coded,
        L: Lookup,
    {
        Self {
            name: name.to_owned(),
            parameters: parameters::of::<P, A, L>(),
            pixel_bytes: 4 * size_of::<ChannelOf<P>>(),
            table_bytes: slicecast::classify::PointTable::<A, L>::BYTES,
            step_bits: 32,
            runner: Runner::of::<P, U, A, L>(),
        }
    }

    /// `compact` with other samples.
    fn values<V: super::formats::Values>(name: &str) -> Self {
        Self::of::<Study<V, CompactSurface, CompactPixel>, Sqrt16, Linear>(name)
    }

    /// `compact` with another surface.
    fn surface<S: super::formats::Surface>(name: &str) -> Self {
        Self::made::<Study<CompactValues, S, CompactPixel>, Compact, Sqrt16, Linear>(name)
    }

    /// `compact` with another pixel.
    fn pixel<X: Described>(name: &str) -> Self {
        Self::of::<Study<CompactValues, CompactSurface, X>, Sqrt16, Linear>(name)
    }

    /// `compact` with a shorter step.
    fn step(bits: u32) -> Self {
        let mut configuration = Self::of::<Compact, Sqrt16, Linear>(&format!("position-{bits}"));
        configuration.step_bits = bits;
        for (name, value) in &mut configuration.parameters {
            if *name == Name::PositionBits {
                *value = bits.to_string();
            }
        }
        configuration
    }

    /// The value of a parameter.
    pub fn parameter(&self, name: Name) -> &str {
        let found = self.parameters.iter().find(|(n, _)| *n == name);
        found.map_or("", |(_, value)| value)
    }
}

/// The configuration that speeds are related to, and that parameters are varied from.
pub const BASE: &str = "compact";

/// All configurations, in the order of reports.
pub fn all() -> Vec<Configuration> {
    type C = Configuration;
    let mut all = vec![
        C::of::<Paper, Sqrt8, Nearest>("paper"),
        C::of::<Compact, Sqrt16, Linear>(BASE),
        C::of::<Wide, Sqrt16, Linear>("wide"),
    ];
    all.extend([6, 8, 10, 12, 14, 16].map(C::step));
    all.extend([
        C::values::<Blend<Sample12, 6, false>>("weight-6"),
        C::values::<Blend<Sample12, 8, false>>("weight-8"),
        C::values::<Blend<Sample12, 10, false>>("weight-10"),
        C::values::<Blend<Sample12, 12, false>>("weight-12"),
        C::values::<Blend<Sample4, 16, false>>("sample-4"),
        C::values::<Blend<Sample6, 16, false>>("sample-6"),
        C::values::<Blend<Sample8, 16, false>>("sample-8"),
        C::values::<Blend<Sample10, 16, false>>("sample-10"),
        C::values::<Blend<Sample15, 16, false>>("sample-15"),
        C::values::<Blend<Sample12, 16, true>>("sample-12-truncated"),
    ]);
    all.extend([
        C::surface::<Deferred<4>>("gradient-4"),
        C::surface::<Deferred<6>>("gradient-6"),
        C::surface::<Deferred<8>>("gradient-8"),
        C::surface::<Deferred<10>>("gradient-10"),
        C::surface::<Deferred<12>>("gradient-12"),
        C::surface::<Cut<4>>("normal-4"),
        C::surface::<Cut<6>>("normal-6"),
        C::surface::<Cut<8>>("normal-8"),
        C::surface::<Cut<10>>("normal-10"),
        C::surface::<Cut<12>>("normal-12"),
        C::surface::<Cut<14>>("normal-14"),
        C::surface::<Near<15>>("normal-15-nearest"),
        C::surface::<TruncatedPower>("power-truncated"),
        C::surface::<ParabolicPower>("power-parabola"),
        C::surface::<TruncatedShading>("shading-truncated"),
    ]);
    all.extend([
        C::of::<Compact, Plain8, Nearest>("table-alpha8-nearest"),
        C::of::<Compact, Plain8, Linear>("table-alpha8"),
        C::of::<Compact, Sqrt8, Nearest>("table-sqrt8-nearest"),
        C::of::<Compact, Sqrt8, Linear>("table-sqrt8"),
        C::of::<Compact, Plain16, Nearest>("table-alpha16-nearest"),
        C::of::<Compact, Plain16, Linear>("table-alpha16"),
        C::of::<Compact, Sqrt16, Nearest>("table-sqrt16-nearest"),
    ]);
    all.extend([
        C::pixel::<Product<Short<8>, false, 15>>("pixel-8-truncated"),
        C::pixel::<Product<Short<10>, false, 15>>("pixel-10-truncated"),
        C::pixel::<Product<Short<12>, false, 15>>("pixel-12-truncated"),
        C::pixel::<Product<Short<14>, false, 15>>("pixel-14-truncated"),
        C::pixel::<Product<Short<15>, false, 15>>("pixel-15-truncated"),
        C::pixel::<Product<Long<16>, false, 15>>("pixel-16-truncated"),
        C::pixel::<Product<Short<12>, true, 15>>("pixel-12-rounded"),
        C::pixel::<Product<Short<15>, true, 15>>("pixel-15-rounded"),
        C::pixel::<Product<Packed<23>, true, 15>>("pixel-23-rounded"),
        C::pixel::<Telescoping<Short<15>, false, 15>>("pixel-15-telescoping"),
        C::pixel::<Telescoping<Packed<23>, true, 15>>("pixel-23-telescoping"),
        C::pixel::<Telescoping<Long<31>, false, 15>>("pixel-31-telescoping"),
        C::pixel::<Dithered<Short<10>>>("pixel-10-dithered"),
        C::pixel::<Dithered<Short<12>>>("pixel-12-dithered"),
        C::pixel::<Dithered<Short<14>>>("pixel-14-dithered"),
        C::pixel::<Dithered<Short<15>>>("pixel-15-dithered"),
        C::pixel::<Carrying<12>>("pixel-12-carry"),
        C::pixel::<Carrying<15>>("pixel-15-carry"),
        C::pixel::<Scaled<Byte, true>>("pixel-255-blinn"),
        C::pixel::<Scaled<Unorm16, true>>("pixel-65535-blinn"),
    ]);
    all.extend([
        C::of::<Paper, Sqrt16, Linear>("paper-sqrt16-linear"),
        C::of::<Wide, Sqrt16, Nearest>("wide-nearest"),
        C::of::<Study<Blend<Sample15, 16, false>, Deep, Telescoping<Packed<23>, true, 31>>, Sqrt16, Linear>("deep-23"),
    ]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn configurations_differ_in_name_and_in_what_they_are() {
        let all = all();
        let names: BTreeSet<_> = all.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        let made: BTreeSet<_> = all.iter().map(|c| format!("{:?}", c.parameters)).collect();
        assert_eq!(made.len(), all.len());
    }

    /// Names say what varies: each such configuration differs from the base in one stage only.
    #[test]
    fn one_stage_varies_at_a_time() {
        let all = all();
        let base = all.iter().find(|c| c.name == BASE).unwrap();
        let varied = all.iter().filter(|c| {
            let stage = c.name.split('-').next().unwrap();
            [
                "position", "weight", "sample", "gradient", "normal", "power", "table", "pixel",
            ]
            .contains(&stage)
        });
        let mut count = 0;
        for configuration in varied {
            let stages: BTreeSet<_> = configuration
                .parameters
                .iter()
                .filter(|(name, value)| base.parameter(*name) != value)
                .map(|(name, _)| name.stage())
                .collect();
            assert_eq!(stages.len(), 1, "{}: {stages:?}", configuration.name);
            count += 1;
        }
        assert!(count > 50);
    }

    #[test]
    fn memory_is_what_the_types_take() {
        let all = all();
        let bytes = |name: &str| {
            let c = all.iter().find(|c| c.name == name).unwrap();
            (c.pixel_bytes, c.table_bytes)
        };
        assert_eq!(bytes("paper"), (8, 16384));
        assert_eq!(bytes("compact"), (8, 20480));
        assert_eq!(bytes("wide"), (16, 20480));
        assert_eq!(bytes("deep-23"), (12, 20480));
        assert_eq!(bytes("pixel-255-blinn"), (4, 20480));
        assert_eq!(bytes("pixel-15-carry"), (16, 20480));
        assert_eq!(bytes("table-alpha8"), (8, 16384));
    }
}
