//! Differences, and their spacing factors.

use slicecast::format::Intensity;
use slicecast::gradient::{difference_row, space};
use slicecast::precision::Precision;

use super::{Numbers, sample_unit};
use crate::set::{Field, Set, ijk, s, u};

/// The gradient's components.
pub fn outputs<P: Precision>(p: P) -> Vec<Field> {
    ijk(&s("gradient", 14 + p.formats().sample_bits, sample_unit(p))).to_vec()
}

/// Halves of the product, both ends of the range, and factors from 1 / 32768 to 1.
pub fn gradient<P: Precision>(p: P) -> Set {
    let bits = p.formats().sample_bits;
    let sample = |name| s(name, 14 + bits, sample_unit(p));
    let mut inputs = ["next_i", "previous_i", "next_j", "previous_j", "along_k"]
        .map(sample)
        .to_vec();
    inputs.extend(ijk(&u("factor", 16, "2^-15")));
    let about = "differences of neighbouring samples, the interpolated difference along k, and their spacing factors";
    let mut set = Set::new(Some(P::NAME), "gradient", about, inputs, outputs(p));
    let mut push = |samples: [i64; 5], factors: [i64; 3]| {
        let [next_i, previous_i, next_j, previous_j, along_k] = samples.map(|c| c as i32);
        let mut differences = [0; 2];
        difference_row::<i32>(&[next_i, next_j], &[previous_i, previous_j], &mut differences);
        let [along_i, along_j] = differences;
        let [fi, fj, fk] = factors.map(|f| Intensity::from_bits(f as u16));
        let gradient = [space(along_i, fi), space(along_j, fj), space(along_k, fk)];
        set.push(&[&samples[..], &factors].concat(), &gradient.map(i64::from));
    };
    let end = 8190_i64 << bits;
    let factors = [1, 2, 3, 16383, 16384, 16385, 20001, 32767, 32768];
    for f in factors {
        for d in [0, 1, 2, 3, 5, 32767, 32768, 32769, end - 1, end] {
            push([d, 0, 0, d, d], [f; 3]);
            push([0, d, d, 0, -d], [f; 3]);
        }
        // Where the product of a difference is not the difference of products.
        push([3, 2, 4, 1, 1], [f; 3]);
        push([-2, -3, -1, -4, -1], [f; 3]);
    }
    let mut numbers = Numbers(5);
    for _ in 0..200 {
        let mut sample = || numbers.within(-end / 2, end / 2);
        let samples = [sample(), sample(), sample(), sample(), sample()];
        push(samples, [(); 3].map(|()| numbers.within(1, 32768)));
    }
    set
}
