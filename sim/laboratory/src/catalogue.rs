//! The configurations that a sweep runs by itself: the named precisions, each parameter varied from `compact` one at a
//! time, and a few combinations.
//!
//! The named precisions are pipelines of their own, whose widths are constants. All others are one pipeline, whose widths
//! are values ([`Study`]): a further one is a line here, or none at all ([`Configuration::varied`]).

use slicecast::classify::{AlphaCode, Sqrt8, Sqrt16};
use slicecast::fast::{Colours, Roots};
use slicecast::format::Rounding;
use slicecast::precision::{Compact, Fast, Formats, NormalForm, Paper, Power, Precision, Shading, Wide};
use slicecast_scene::LookupName::{Linear, Nearest};
use slicecast_scene::{LookupName, PrecisionName};

use super::channels::Scale::{self, Binary, Carrying, Full};
use super::codes::{Coded, Plain8, Plain16};
use super::formats::Study;
use super::measure::{Kind, Runner};
use super::parameters::{self, Name, Parameter};
use super::pixels::Arithmetic::{self, Dithered, Product, Telescoping};
use super::pixels::StudyPixel;

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
    /// A precision with a table.
    fn of<A: Coded>(name: &str, kind: Kind, lookup: LookupName) -> Self {
        let (formats, pixel, rounding) = match kind {
            Kind::Named(PrecisionName::Paper) => (Paper.formats(), Binary(15), "truncated"),
            Kind::Named(PrecisionName::Compact) => (Compact.formats(), Full(16), "dithered"),
            Kind::Named(PrecisionName::Wide) => (Wide.formats(), Binary(31), "telescoping"),
            Kind::Named(PrecisionName::Fast) => (Fast.formats(), Full(16), "dithered"),
            Kind::Study(study) => (study.formats, study.pixel.scale(), study.pixel.rounding()),
        };
        Self {
            name: name.to_owned(),
            parameters: parameters::of(formats, (pixel.bits(), rounding), A::NAME, lookup),
            pixel_bytes: 4 * pixel.bytes(),
            table_bytes: 4 * slicecast::table::ENTRIES + <A as AlphaCode>::PLANE_BYTES,
            step_bits: 32,
            runner: Runner::of::<A>(kind, lookup),
        }
    }

    /// A precision with the table of 16-bit roots.
    fn linear(name: &str, kind: Kind) -> Self {
        Self::of::<Sqrt16>(name, kind, Linear)
    }

    /// 16-bit lanes, whose table holds roots and colours of two codes each.
    fn fast() -> Self {
        Self {
            table_bytes: size_of::<Roots>() + size_of::<Colours>(),
            ..Self::linear(FAST, Kind::Named(PrecisionName::Fast))
        }
    }

    /// `compact` with other formats.
    fn formats(name: &str, change: impl FnOnce(&mut Formats)) -> Self {
        let mut study = Study::compact();
        change(&mut study.formats);
        Self::linear(name, Kind::Study(study))
    }

    /// `compact` with another pixel.
    fn pixel(name: &str, pixel: StudyPixel) -> Self {
        let study = Study {
            pixel,
            ..Study::compact()
        };
        Self::linear(name, Kind::Study(study))
    }

    /// `compact` with a shorter step.
    fn step(bits: u32) -> Self {
        let mut configuration = Self::linear(&format!("position-{bits}"), COMPACT);
        configuration.step_bits = bits;
        for (name, value) in &mut configuration.parameters {
            if *name == Name::PositionBits {
                *value = bits.to_string();
            }
        }
        configuration
    }

    /// `compact` with one number changed, under the name that the catalogue would give it. A normal is truncated to so many
    /// bits; a pixel is dithered up to 15 bits, and telescoping beyond.
    ///
    /// # Errors
    /// The widths that the parameter has, in words; for a parameter that is not a number, that it is none.
    pub fn varied(name: Name, bits: u32) -> Result<Self, &'static str> {
        let within = |least: u32, most: u32, accepted| {
            if (least..=most).contains(&bits) {
                Ok(())
            } else {
                Err(accepted)
            }
        };
        let stage = name.stage();
        let formats = |change: &dyn Fn(&mut Formats)| Self::formats(&format!("{stage}-{bits}"), change);
        match name {
            Name::PositionBits => within(1, 32, "1 to 32").map(|()| Self::step(bits)),
            Name::WeightBits => within(1, 16, "1 to 16").map(|()| formats(&|f| f.weight_bits = bits)),
            Name::SampleBits => within(1, 15, "1 to 15").map(|()| formats(&|f| f.sample_bits = bits)),
            Name::GradientBits => within(1, 15, "1 to 15").map(|()| formats(&|f| f.gradient_bits = bits)),
            Name::NormalBits => within(1, 15, "1 to 15").map(|()| formats(&|f| f.normal = NormalForm::Formed(bits))),
            Name::CompositingBits => {
                let (arithmetic, rounding) = if bits <= 15 {
                    (Dithered, "dithered")
                } else {
                    (TELESCOPING, "telescoping")
                };
                let pixel = StudyPixel::new(arithmetic, Binary(bits)).ok_or("1 to 31")?;
                Ok(Self::pixel(&format!("pixel-{bits}-{rounding}"), pixel))
            }
            _ => Err("no number"),
        }
    }

    /// `compact` in a pipeline of the same kind: what the speed of this one is related to.
    pub fn base(&self) -> Self {
        if self.runner.is_study() {
            Self::linear(BASE, Kind::Study(Study::compact()))
        } else {
            Self::linear(BASE, COMPACT)
        }
    }

    /// The value of a parameter.
    pub fn parameter(&self, name: Name) -> &str {
        let found = self.parameters.iter().find(|(n, _)| *n == name);
        found.map_or("", |(_, value)| value)
    }
}

const PAPER: Kind = Kind::Named(PrecisionName::Paper);
const COMPACT: Kind = Kind::Named(PrecisionName::Compact);
const WIDE: Kind = Kind::Named(PrecisionName::Wide);

const TRUNCATED: Arithmetic = Product { rounded: false };
const ROUNDED: Arithmetic = Product { rounded: true };
const TELESCOPING: Arithmetic = Telescoping { rounded: false };
const NEAREST: Arithmetic = Telescoping { rounded: true };

/// A pixel that there is.
const fn pixel(arithmetic: Arithmetic, scale: Scale) -> StudyPixel {
    StudyPixel::new(arithmetic, scale).expect("a format that the arithmetic has")
}

/// The configuration that speeds are related to, and that parameters are varied from.
pub const BASE: &str = "compact";

/// The configuration of 16-bit lanes, which do not know every scene.
pub const FAST: &str = "fast";

/// All configurations, in the order of reports.
pub fn all() -> Vec<Configuration> {
    type C = Configuration;
    let mut all = vec![
        C::of::<Sqrt8>("paper", PAPER, Nearest),
        C::linear(BASE, COMPACT),
        C::linear("wide", WIDE),
        C::fast(),
    ];
    all.extend([6, 8, 10, 12, 14, 16].map(C::step));
    let numbers = [
        (Name::WeightBits, &[6, 8, 10, 12][..]),
        (Name::SampleBits, &[4, 6, 8, 10, 15]),
    ];
    all.extend(varied(&numbers));
    all.push(C::formats("sample-12-truncated", |f| {
        (f.lerp_bits, f.lerp_rounding) = (12, Rounding::Truncate);
    }));
    let numbers = [
        (Name::GradientBits, &[4, 6, 8, 10, 12][..]),
        (Name::NormalBits, &[4, 6, 8, 10, 12, 14]),
    ];
    all.extend(varied(&numbers));
    all.extend([
        C::formats("normal-15-nearest", |f| f.normal = NormalForm::Nearest(15)),
        C::formats("power-truncated", |f| f.power = Power::Truncated16),
        C::formats("power-parabola", |f| f.power = Power::Parabola),
        C::formats("shading-truncated", |f| {
            (f.shading, f.power) = (Shading::Truncated16, Power::Truncated16);
        }),
    ]);
    all.extend([
        C::of::<Plain8>("table-alpha8-nearest", COMPACT, Nearest),
        C::of::<Plain8>("table-alpha8", COMPACT, Linear),
        C::of::<Sqrt8>("table-sqrt8-nearest", COMPACT, Nearest),
        C::of::<Sqrt8>("table-sqrt8", COMPACT, Linear),
        C::of::<Plain16>("table-alpha16-nearest", COMPACT, Nearest),
        C::of::<Plain16>("table-alpha16", COMPACT, Linear),
        C::of::<Sqrt16>("table-sqrt16-nearest", COMPACT, Nearest),
    ]);
    all.extend([8, 10, 12, 14, 15, 16].map(|bits| {
        let name = format!("pixel-{bits}-truncated");
        C::pixel(&name, pixel(TRUNCATED, Binary(bits)))
    }));
    all.extend([
        C::pixel("pixel-12-rounded", pixel(ROUNDED, Binary(12))),
        C::pixel("pixel-15-rounded", pixel(ROUNDED, Binary(15))),
        C::pixel("pixel-23-rounded", pixel(ROUNDED, Binary(23))),
        C::pixel("pixel-15-telescoping", pixel(TELESCOPING, Binary(15))),
        C::pixel("pixel-23-telescoping", pixel(NEAREST, Binary(23))),
        C::pixel("pixel-31-telescoping", pixel(TELESCOPING, Binary(31))),
    ]);
    all.extend(varied(&[(Name::CompositingBits, &[10, 12, 14, 15])]));
    all.extend([
        C::pixel("pixel-12-carry", pixel(TELESCOPING, Carrying(12))),
        C::pixel("pixel-15-carry", pixel(TELESCOPING, Carrying(15))),
        C::pixel("pixel-255-blinn", pixel(ROUNDED, Full(8))),
        C::pixel("pixel-65535-blinn", pixel(ROUNDED, Full(16))),
    ]);
    let deep = Study {
        formats: Wide.formats(),
        pixel: pixel(NEAREST, Binary(23)).deep().expect("room for 31-bit colours"),
    };
    all.extend([
        C::linear("paper-sqrt16-linear", PAPER),
        C::of::<Sqrt16>("wide-nearest", WIDE, Nearest),
        C::linear("deep-23", Kind::Study(deep)),
    ]);
    all
}

/// One configuration per number.
fn varied<'a>(numbers: &'a [(Name, &'a [u32])]) -> impl Iterator<Item = Configuration> + 'a {
    let of = |(name, bits): &'a (Name, &'a [u32])| bits.iter().map(|bits| (*name, *bits));
    let made = |(name, bits)| Configuration::varied(name, bits).expect("a width within its range");
    numbers.iter().flat_map(of).map(made)
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
        assert_eq!(bytes("fast"), (8, 16384 + 32776));
        assert_eq!(bytes("deep-23"), (12, 20480));
        assert_eq!(bytes("pixel-255-blinn"), (4, 20480));
        assert_eq!(bytes("pixel-15-carry"), (16, 20480));
        assert_eq!(bytes("table-alpha8"), (8, 16384));
    }
}
