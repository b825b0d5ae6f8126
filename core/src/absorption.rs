//! The factor of a sample: what its extinction and its colours times extinction are multiplied with.
//!
//! Source: Kraus and Bürger, section 3.4: over a step d a sample's opacity is `1 - e^-(tau d) = tau d phi(tau d)` with
//! `phi(x) = (1 - e^-x) / x`, and its colour `C tau d phi(tau d)`: the factor `G = d phi(tau d)` serves all four.
//!
//! | value | format | range |
//! |---|---|---|
//! | scale M, N | `M 2^-N = tau_max d 2^28 / 32767` | M < 2^31, N 14 to 35; tau_max d at most 15 |
//! | sample s_t | 15.S, n = N + S | 0 to 32767 · 2^S |
//! | optical depth X | u4.28 | 0 to 15 · 2^28 |
//! | phi p | u1.31 | 0 to 2^31 |
//! | factor G | u31 | 0 to M |
//!
//! `X = (s_t M) >> n`, `G = (M p) >> 31`; the opacity is `s_t G / 2^(n - 3)`, 1.31, never above 1 (`no_opacity_is_above_one`). Error
//! of phi: 1.01e-5, never low, of the opacity 5.2e-6; of [`CENTRED_PHI`] 7.1e-6 and 3.5e-6, high and low. State: none.

use crate::borders::WHOLE;
use crate::lanes::{Lanes, Wide as _};
use crate::table::Coding;

/// The largest optical depth of a step, u4.28.
pub const DEPTH_MAX: u32 = 15 << 28;

/// Bits of the fraction between two entries of [`PHI`].
const FRACTION_BITS: u32 = 22;

/// Values of phi at steps of 1/64, u1.31, between which it is linear.
pub type Phi = [u32; 1025];

/// `phi(i / 64)`, u1.31, to nearest.
pub static PHI: Phi = table(false);

/// The same less what lines between them lie above phi in the mean, a twelfth of the second difference; 1 at 0. So errors of phi do not
/// add up along a ray.
pub static CENTRED_PHI: Phi = table(true);

#[cfg_attr(
    not(test),
    expect(
        clippy::indexing_slicing,
        clippy::integer_division,
        reason = "evaluated by the compiler, never on the target"
    )
)]
const fn table(centred: bool) -> Phi {
    let mut table = [0; 1025];
    let mut i = 0;
    while i < table.len() {
        let (at, here) = (i as i128, exact(i as i128));
        let above = if centred && i > 0 {
            (exact(at - 1) - 2 * here + exact(at + 1)) / 12
        } else {
            0
        };
        table[i] = ((here - above + (1 << 48)) >> 49) as u32;
        i += 1;
    }
    table
}

/// The series of phi, `1 - x / 2! + x² / 3! - ...` with x = i / 64, in 80 fraction bits: the largest term has 96 bits, and what
/// is cut off the terms amounts to 2^-58.
#[cfg_attr(
    not(test),
    expect(clippy::integer_division, reason = "evaluated by the compiler, never on the target")
)]
const fn exact(i: i128) -> i128 {
    let (mut sum, mut term, mut k) = (0, 1i128 << 80, 2);
    while term != 0 {
        sum += term;
        term = -term * i / (64 * k);
        k += 1;
    }
    sum
}

/// What a step through the largest extinction amounts to: the scale of a volume under a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Medium {
    mantissa: u32,
    exponent: u32,
}

/// Why a scale is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MediumError {
    /// The mantissa has more than 31 bits, or the exponent is not 14 to 35.
    Scale {
        /// M.
        mantissa: u32,
        /// N.
        exponent: u32,
    },
    /// A step through the largest extinction has an optical depth above 15.
    Opaque,
}

impl core::fmt::Display for MediumError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Scale { mantissa, exponent } => write!(
                f,
                "the scale {mantissa} / 2^{exponent} of extinctions; accepted: a mantissa below 2^31, an exponent from 14 to 35"
            ),
            Self::Opaque => f.write_str("a step through the largest extinction has an optical depth above 15"),
        }
    }
}

impl core::error::Error for MediumError {}

impl Medium {
    /// The scale `mantissa 2^-exponent = tau_max d 2^28 / 32767`. The mantissa has 31 bits where the exponent is below 35, or
    /// accuracy is lost.
    ///
    /// # Errors
    /// [`MediumError`].
    pub const fn new(mantissa: u32, exponent: u32) -> Result<Self, MediumError> {
        if mantissa >> 31 != 0 || exponent < 14 || exponent > 35 {
            return Err(MediumError::Scale { mantissa, exponent });
        }
        // With larger exponents the scale is below 2^16, and no depth reaches 2^31.
        if exponent == 14 && mantissa as u64 * 32767 > (DEPTH_MAX as u64) << 14 {
            return Err(MediumError::Opaque);
        }
        Ok(Self { mantissa, exponent })
    }

    /// For samples of so many fraction bits, of which this fraction of a step counts, 0.16.
    pub const fn absorption(self, sample_bits: u32, fraction: u32) -> Absorption {
        let scale = if fraction < WHOLE {
            ((self.mantissa as u64 * fraction as u64) >> 16) as u32
        } else {
            self.mantissa
        };
        Absorption {
            scale,
            shift: self.exponent + sample_bits,
        }
    }
}

/// What the samples of a plane are multiplied with: the same for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Absorption {
    /// M.
    pub scale: u32,
    /// n, 14 to 50.
    pub shift: u32,
}

impl Absorption {
    /// The factors of samples of extinction, 15.S, by these values of phi. With one lane this function is the definition.
    #[inline(always)]
    pub fn factor<V: Lanes>(self, values: &Phi, extinction: V) -> V {
        const { assert!(V::COUNT <= 16) };
        let mut depths = [0; 16];
        self.depth(extinction).store(&mut depths, 0);
        self.factor_at(values, &depths, 0)
    }

    /// The optical depths of samples of extinction, u4.28.
    #[inline(always)]
    pub(crate) fn depth<V: Lanes>(self, extinction: V) -> V {
        extinction.product(V::splat(self.scale as i32)).shr(self.shift).narrow()
    }

    /// The factors of optical depths `at ..` of a row.
    #[inline(always)]
    pub(crate) fn factor_at<V: Lanes>(self, values: &Phi, depths: &[i32], at: usize) -> V {
        scale_by(V::splat(self.scale as i32), phi(values, depths, at))
    }
}

/// `(M p) >> 31`: p is at most 2^31, M below.
#[inline(always)]
fn scale_by<V: Lanes>(scale: V, phi: V) -> V {
    phi.product31(scale)
}

/// phi of the optical depths `at ..` of a row, u4.28 to u1.31, between these values of it.
#[inline(always)]
pub fn phi<V: Lanes>(values: &Phi, depths: &[i32], at: usize) -> V {
    let coding = Coding {
        offset: 0,
        bits: FRACTION_BITS,
    };
    let [here, next] = V::look_up(values, depths, at, coding);
    let depth = V::load(depths, at);
    let fraction = depth & V::splat((1 << FRACTION_BITS) - 1);
    let falls = here.wrapping_sub(next).product(fraction) + V::Wide::splat(1 << (FRACTION_BITS - 1));
    here.wrapping_sub(falls.shr_narrow(FRACTION_BITS))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(x: f64) -> f64 {
        if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
    }

    /// Both tables, and of each how far from phi and from opacities samples may be.
    const TABLES: [(&Phi, [f64; 2]); 2] = [(&PHI, [1.02e-5, 5.3e-6]), (&CENTRED_PHI, [7.1e-6, 3.5e-6])];

    fn of_depth(values: &Phi, depth: u32) -> u32 {
        phi::<i32>(values, &[depth as i32], 0) as u32
    }

    /// The compiler's whole numbers against f64, whose own error is 1e-6 of them.
    #[test]
    fn the_tables_are_the_function() {
        for (i, entry) in PHI.iter().enumerate() {
            let exact = exact(i as f64 / 64.0) * 2_147_483_648.0;
            assert!((f64::from(*entry) - exact).abs() <= 0.500_01, "{i}");
        }
        assert_eq!([PHI[0], PHI[64], PHI[1024]], [1 << 31, 1_357_468_564, 134_217_713]);
        // The mean of a line between two values, less phi, is 0 but for the first.
        for i in 1..1000 {
            let inside = (0..64).map(|f| f64::from(of_depth(&CENTRED_PHI, (i << 22) + (f << 16) + (1 << 15))));
            let above = inside.zip(0..).map(|(found, f)| {
                let x = (f64::from(i) + (f64::from(f) + 0.5) / 64.0) / 64.0;
                found / 2_147_483_648.0 - exact(x)
            });
            assert!((above.sum::<f64>() / 64.0).abs() < 1e-8, "{i}");
        }
        assert_eq!(CENTRED_PHI[0], 1 << 31);
        for (table, _) in TABLES {
            assert!(
                table
                    .windows(2)
                    .all(|pair| pair[1] < pair[0] && pair[0] - pair[1] < 1 << 24)
            );
        }
        assert!(PHI.iter().zip(&CENTRED_PHI).all(|(phi, centred)| centred <= phi));
    }

    /// Every 1021st depth, and the ends of every interval.
    #[test]
    fn phi_is_as_near_as_stated() {
        for (table, [phi_within, opacity_within]) in TABLES {
            let ends = (0..960u32).flat_map(|i| [i << 22, (i << 22) + 1, (i << 22) + (1 << 22) - 1]);
            let mut worst = [0.0f64; 2];
            for depth in (0..=DEPTH_MAX).step_by(1021).chain(ends) {
                let x = f64::from(depth) / 268_435_456.0;
                let away = (f64::from(of_depth(table, depth)) / 2_147_483_648.0 - exact(x)).abs();
                worst = [worst[0].max(away), worst[1].max(away * x)];
            }
            assert!(worst[0] <= phi_within && worst[1] <= opacity_within, "{worst:?}");
            assert!(
                worst[0] > 0.95 * phi_within && worst[1] > 0.95 * opacity_within,
                "stale: {worst:?}"
            );
            assert_eq!(of_depth(table, 0), 1 << 31);
        }
    }

    /// For every depth up to the largest: of an interval p is at most `P - D f / 2^22 + 1/2`, and `(X + 1) p` the parabola whose
    /// vertex is found here in whole numbers. A sample's opacity is below `(X + 1) p / 2^59`.
    #[test]
    fn no_opacity_is_above_one() {
        for (table, _) in TABLES {
            for i in 0..960i128 {
                let (p, d) = (i128::from(table[i as usize]), i128::from(table[i as usize + 1]));
                let d = p - d;
                // 2^23 (X + 1) (p + 1/2 - d f / 2^22), X = i 2^22 + f.
                let bound = |f: i128| ((i << 22) + f + 1) * ((2 * p + 1) * (1 << 22) - 2 * d * f);
                let vertex = ((2 * p + 1) * (1 << 22) - 2 * d * ((i << 22) + 1)) / (4 * d);
                let tops = [0, (1 << 22) - 1, vertex, vertex + 1].map(|f| bound(f.clamp(0, (1 << 22) - 1)));
                assert!(tops.iter().all(|top| *top <= 1 << (59 + 23)), "{i}");
            }
            let last = u128::from(DEPTH_MAX + 1) * u128::from(of_depth(table, DEPTH_MAX));
            assert!(last <= 1 << 59);
        }
    }

    #[test]
    fn opacities_of_known_steps() {
        // tau_max d of 1 and 15: a scale of 2^28 / 32767 and 15 of it.
        let opacity = |depth: f64, code: i32, bits: u32| {
            let (table, _) = TABLES[usize::from(bits == 15)];
            let scale = depth * 268_435_456.0 / 32767.0;
            let exponent = (0..).find(|n| scale * f64::from(1u32 << n) >= 1_073_741_824.0).unwrap();
            let medium = Medium::new((scale * f64::from(1u32 << exponent)).round() as u32, exponent).unwrap();
            let absorption = medium.absorption(bits, WHOLE);
            let sample = code << bits;
            let factor = absorption.factor(table, sample);
            (sample.product(factor) as u64 >> (absorption.shift - 3)) as f64 / 2_147_483_648.0
        };
        for bits in [12, 15] {
            assert!((opacity(1.0, 32767, bits) - 0.632_120_559).abs() < 5.3e-6);
            assert!((opacity(14.999_999, 32767, bits) - 1.0).abs() < 5e-7);
            assert_eq!(opacity(4.0, 0, bits), 0.0);
            // Of thin media too nothing is lost but what has no place in 1.31.
            let (thin, exact) = (opacity(1e-4, 33, bits), 1e-4 * 33.0 / 32767.0);
            assert!((-1e-12..4.7e-10).contains(&(exact - thin)), "{thin}");
        }
    }

    #[test]
    fn scales_that_are_none_are_refused() {
        assert!(Medium::new((1 << 31) - 1, 15).is_ok());
        assert!(Medium::new(1, 35).is_ok());
        for (mantissa, exponent) in [(1 << 31, 20), (1 << 30, 13), (1 << 30, 36)] {
            assert_eq!(
                Medium::new(mantissa, exponent),
                Err(MediumError::Scale { mantissa, exponent })
            );
        }
        let largest = ((u64::from(DEPTH_MAX) << 14) / 32767) as u32;
        assert!(Medium::new(largest, 14).is_ok());
        assert_eq!(Medium::new(largest + 1, 14), Err(MediumError::Opaque));
        // The largest depth that there is stays one.
        let absorption = Medium::new(largest, 14).unwrap().absorption(15, WHOLE);
        let depth = (u64::from(32767u32 << 15) * u64::from(absorption.scale)) >> absorption.shift;
        assert!(depth <= u64::from(DEPTH_MAX) && depth > u64::from(DEPTH_MAX) - 40_000);
    }
}
