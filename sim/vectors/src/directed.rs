//! Directed vectors: the extremes and corners that pictures never reach, each stage by itself.
//!
//! Inputs are the ends of every format, both sides of every bound, ties and halves of every rounding, and numbers that a
//! fixed generator makes in between. Outputs come from core's scalar definitions, one call a vector. Sentences of the
//! contract that could be read in two ways have vectors on which the readings differ
//! (`host-tests/src/second/mistakes.rs` lists the readings that must be found).

pub(crate) mod borders;
pub(crate) mod classification;
pub(crate) mod compositing;
pub(crate) mod gradient;
pub(crate) mod interpolation;
mod location;
pub(crate) mod normalisation;
mod picture;
pub(crate) mod shading;

use slicecast::composite::{Channel, ChannelFormat, Recurrence};
use slicecast::precision::{Compact, Paper, Precision, Wide};

use crate::set::{Field, Set, u};

/// All directed sets, in the order of the stages; those of a precision for `paper`, `compact` and `wide`.
pub fn sets() -> Vec<Set> {
    let mut sets = vec![
        location::plan(),
        location::start(),
        location::location(),
        location::dither(),
        borders::borders(),
        borders::power(),
        normalisation::normalisation(),
        normalisation::export(),
        picture::coordinate(),
    ];
    sets.extend(of(Paper));
    sets.extend(of(Compact));
    sets.extend(of(Wide));
    sets
}

fn of<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(p: P) -> Vec<Set> {
    vec![
        interpolation::interpolation(p),
        classification::classification(p),
        gradient::gradient(p),
        shading::vector(p),
        shading::coefficient(p),
        shading::cosine(p),
        shading::reflection(p),
        shading::power(p),
        shading::shading(p),
        compositing::front_to_back(p),
        compositing::back_to_front(p),
        compositing::projection(p),
        compositing::resolution(p),
        picture::mixture(p),
        picture::background(p),
        picture::output(p),
    ]
}

/// A channel of the precision's pixel.
pub(crate) fn channel<P: Precision>(p: P, name: &str) -> Field {
    let one = p.pixel().one().bits();
    let unit = match one {
        65535 => "1/65535",
        32768 => "2^-15",
        _ => "2^-31",
    };
    u(name, 32 - one.leading_zeros(), unit)
}

/// A colour's channel in front of the pixel.
pub(crate) fn colour<P: Precision>(p: P, name: &str) -> Field {
    let bits = p.pixel().colour_bits();
    u(name, bits + 1, if bits == 15 { "2^-15" } else { "2^-31" })
}

/// The unit of a sample.
pub(crate) fn sample_unit<P: Precision>(p: P) -> &'static str {
    if p.formats().sample_bits == 15 {
        "2^-15 code"
    } else {
        "2^-12 code"
    }
}

/// Numbers that are the same on every machine (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// One of `low ..= high`.
    fn within(&mut self, low: i64, high: i64) -> i64 {
        let count = (i128::from(high) - i128::from(low) + 1) as u128;
        (i128::from(low) + (u128::from(self.next()) % count) as i128) as i64
    }

    /// One of a list.
    fn of(&mut self, list: &[i64]) -> i64 {
        list[self.within(0, list.len() as i64 - 1) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::sets;

    #[test]
    fn every_set_has_vectors_and_its_own_name() {
        let sets = sets();
        for (at, set) in sets.iter().enumerate() {
            println!("{} {}", set.name, set.len());
            assert!(set.len() >= 16, "{}: {}", set.name, set.len());
            assert!(sets[..at].iter().all(|other| other.name != set.name), "{}", set.name);
            assert_eq!(set.outputs.values.len(), set.len() * set.outputs.fields.len());
        }
    }
}
