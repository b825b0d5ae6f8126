//! A voxel of colour and extinction: four bytes, and the codes that it decodes to.
//!
//! Source: Kraus and Bürger, equations 18 to 21: what may be interpolated and filtered is the extinction tau and the colours
//! times tau. tau is a rate, per unit of the volume's spacing; a volume states its largest, `tau_max`.
//!
//! | value      | bits          | range                  | meaning                                    |
//! | ---------- | ------------- | ---------------------- | ------------------------------------------ |
//! | colour O   | 0.8           | 0 ..= 255              | straight, not multiplied                   |
//! | root q     | 0.8, or 0.16  | 0 ..= 255, 0 ..= 65535 | sqrt(tau / tau_max); q16 = 257 q8          |
//! | vt         | 0.15          | 0 ..= 32767            | tau / tau_max, 32767 is 1                  |
//! | vk         | 0.15          | 0 ..= vt               | colour k times tau, on the scale of vt     |
//!
//! The formulas of vt and vk, their ranges and why vk <= vt are core's: `slicecast::extinction`, docs/contract/extinction.md.

/// Red, green, blue and the root of extinction.
pub type Entry = [u8; 4];

/// Red, green and blue times extinction, and extinction; none of the first three is above the fourth, which is at most
/// [`MAX_CODE`].
pub type Codes = [u16; 4];

// What core's slices hold: one arithmetic.
pub use slicecast::extinction::{MAX_CODE, extinction, weighted};

/// The codes of an entry.
pub const fn decode([red, green, blue, root]: Entry) -> Codes {
    let tau = extinction(257 * root as u16);
    [weighted(tau, red), weighted(tau, green), weighted(tau, blue), tau]
}

/// The code of every root in 8 bits, rising.
const EXTINCTIONS: [u16; 256] = {
    let mut codes = [0; 256];
    let mut root = 0;
    while root < 256 {
        codes[root] = extinction(257 * root as u16);
        root += 1;
    }
    codes
};

/// The entry nearest to codes: the root whose extinction is nearest (the smaller of two as near), and the colours in 8 bits.
/// Only no extinction at all gives the root 0.
pub fn encode([red, green, blue, tau]: Codes) -> Entry {
    let above = EXTINCTIONS.partition_point(|&code| code < tau).min(255);
    let below = above.saturating_sub(1);
    let nearer_below = tau.saturating_sub(EXTINCTIONS[below]) <= EXTINCTIONS[above].saturating_sub(tau);
    let root = if nearer_below && EXTINCTIONS[above] != tau {
        below
    } else {
        above
    };
    let colour = |weighted: u16| {
        let tau = u32::from(tau);
        // Below 2^24; weighted <= tau.
        let rounded = (510 * u32::from(weighted) + tau).checked_div(2 * tau);
        rounded.unwrap_or(0).min(255) as u8
    };
    [colour(red), colour(green), colour(blue), root as u8]
}

/// The root, in 8 bits, of a share of the largest extinction; shares outside 0 to 1 are taken as the nearer of the two.
pub fn root(share: f64) -> u8 {
    (255.0 * share.clamp(0.0, 1.0).sqrt()).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half an ulp of each rounding, over every root and colour.
    #[test]
    fn codes_are_the_nearest() {
        for root in 0..=u16::MAX {
            let (tau, exact) = (extinction(root), f64::from(root).powi(2) / f64::from(1 << 17));
            assert!((f64::from(tau) - exact).abs() <= 0.5, "root {root}");
            let share = (f64::from(root) / 65535.0).powi(2) * f64::from(MAX_CODE);
            assert!((f64::from(tau) - share).abs() < 1.01, "root {root}");
            for colour in 0..=u8::MAX {
                let exact = f64::from(tau) * f64::from(colour) / 255.0;
                let found = f64::from(weighted(tau, colour));
                assert!((found - exact).abs() <= 1.0, "root {root}, colour {colour}");
            }
        }
    }

    /// Every entry's extinction comes back; every code finds the nearest root, and only 0 becomes 0.
    #[test]
    fn encoding_finds_the_nearest() {
        for code in 0..=MAX_CODE {
            let [.., root] = encode([0, 0, 0, code]);
            let away = |root: usize| EXTINCTIONS[root].abs_diff(code);
            let nearest = (0..256).map(away).min().unwrap_or_default();
            assert_eq!(away(usize::from(root)), nearest, "code {code}");
            assert_eq!(root == 0, code == 0);
            // The largest step between roots is that of the last two, 256 codes.
            assert!(nearest <= 128);
        }
        for root in 0..=u8::MAX {
            assert_eq!(encode(decode([0, 0, 0, root]))[3], root);
        }
    }

    /// From extinctions of 510 codes on a colour comes back; below it is within what the codes tell apart.
    #[test]
    fn colours_come_back() {
        for root in 1..=u8::MAX {
            let tau = extinction(257 * u16::from(root));
            for colour in 0..=u8::MAX {
                let [back, ..] = encode(decode([colour, 0, 0, root]));
                let away = f64::from(back.abs_diff(colour));
                assert!(tau < 510 || away == 0.0, "root {root}, colour {colour}: {back}");
                assert!(
                    away <= 255.0 / f64::from(tau) + 0.5,
                    "root {root}, colour {colour}: {back}"
                );
            }
        }
    }
}
