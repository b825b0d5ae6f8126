use super::*;
use crate::precision::{Compact, Wide};
use proptest::prelude::*;
use std::boxed::Box;
use std::vec::Vec;

#[test]
fn every_root_decodes_within_half_a_unit_and_rises() {
    let mut last = None;
    for root in 0..=u16::MAX {
        let a = opacity_of_root(root).to_bits();
        let exact = (f64::from(root) / 65536.0).powi(2) * 2147483648.0;
        assert!((f64::from(a) - exact).abs() <= 0.5);
        assert!(last < Some(a));
        last = Some(a);
    }
    assert_eq!(last, Some(2147418113));
}

#[test]
fn every_byte_survives_a_round_trip() {
    for byte in 0..=255u8 {
        for bits in [15, 31] {
            let c = colour_of_byte(byte, bits);
            let exact = f64::from(byte) / 255.0 * f64::from(bits).exp2();
            assert!((f64::from(c) - exact).abs() <= 0.5, "{byte} {bits}");
            assert_eq!((u64::from(c) * 255 + (1 << (bits - 1))) >> bits, u64::from(byte));
        }
    }
    assert_eq!((colour_of_byte(255, 15), colour_of_byte(255, 31)), (1 << 15, 1 << 31));
}

#[test]
fn every_word_decodes_within_half_a_unit_and_rises() {
    for bits in [15, 31] {
        let mut last = None;
        for word in 0..=u16::MAX {
            let c = colour_of_word(word, bits);
            let exact = f64::from(word) / 65535.0 * f64::from(bits).exp2();
            assert!((f64::from(c) - exact).abs() <= 0.5, "{word} {bits}");
            assert_eq!(colour_of_words(i32::from(word), bits) as u32, c);
            // Two words share a colour of 1.15, none one of 1.31.
            assert!(last <= Some(c) && (bits == 15 || last < Some(c)));
            last = Some(c);
        }
    }
    assert_eq!(
        (colour_of_word(65535, 15), colour_of_word(65535, 31)),
        (1 << 15, 1 << 31)
    );
}

#[test]
fn index_comes_from_the_stored_sample() {
    for (bits, index) in [
        (0, 0),
        (16383, 0),
        (16384, 1),
        (3260415, 99),
        (3260416, 100),
        (134168576, 4095),
    ] {
        assert_eq!(nearest(Wide, bits), index);
    }
    assert_eq!(split(Wide, 3260415), (99, 16383));
    assert_eq!(split(Wide, 134184960), (4095, 0));
}

#[test]
fn support_meets_exactly_the_blocks_of_visible_codes() {
    for code in [0usize, 63, 64, 2000, 4095] {
        let support = Support::of((0..ENTRIES).map(|c| c == code));
        for low in (0..4096).step_by(31) {
            for high in (low..4096).step_by(53) {
                let meets = support.meets(RowRange { low, high });
                let block = code >> 6;
                assert_eq!(meets, usize::from(low >> 6) <= block && block <= usize::from(high >> 6));
            }
        }
    }
    assert!(!Support::NONE.meets(RowRange { low: 0, high: 4095 }));
    assert!(!Support(u64::MAX).meets(RowRange::EMPTY));
    assert!(Support(u64::MAX).meets(RowRange {
        low: 65535,
        high: 65535
    }));
}

fn table(seed: u64) -> (Box<[u32; ENTRIES]>, Box<[u8; ENTRIES]>) {
    let mut state = seed | 1;
    let mut next = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 32) as u32
    };
    let entries: Vec<u32> = (0..ENTRIES).map(|_| next()).collect();
    let plane: Vec<u8> = (0..ENTRIES).map(|_| (next() >> 24) as u8).collect();
    (
        entries.into_boxed_slice().try_into().unwrap(),
        plane.into_boxed_slice().try_into().unwrap(),
    )
}

/// Low bytes of colours, from some of the entries' own bits.
fn low_colours(entries: &[u32; ENTRIES]) -> Box<[[u8; 3]; ENTRIES]> {
    let low = |entry: &u32| {
        let [a, b, c, d] = entry.wrapping_mul(2654435761).to_le_bytes();
        [a ^ d, b, c]
    };
    let low: Vec<_> = entries.iter().map(low).collect();
    low.into_boxed_slice().try_into().unwrap()
}

#[test]
fn colours_of_8_bits_are_those_of_16_that_have_the_byte_twice() {
    let (entries, plane) = table(9);
    let twice: Vec<[u8; 3]> = entries
        .iter()
        .map(|e| e.to_le_bytes())
        .map(|[r, g, b, _]| [r, g, b])
        .collect();
    let twice: Box<[[u8; 3]; ENTRIES]> = twice.into_boxed_slice().try_into().unwrap();
    let narrow = PointTable::<Sqrt16, Linear>::new(&entries, &plane);
    let wide = PointTable::<Colour16, Linear>::new(&entries, (&plane, &twice));
    for s in (0..=4095 << 15).step_by(97) {
        assert_eq!(Classifier::colour(&narrow, Wide, s), Classifier::colour(&wide, Wide, s));
        assert_eq!(
            Classifier::opacity(&narrow, Wide, s),
            Classifier::opacity(&wide, Wide, s)
        );
    }
    let bytes = |code: usize| {
        let [r, g, b, _] = entries[code].to_le_bytes();
        [r, g, b].map(|byte| 257 * u16::from(byte))
    };
    assert_eq!(narrow.code_colour(77), bytes(77));
    let low = low_colours(&entries);
    let other = PointTable::<Colour16, Linear>::new(&entries, (&plane, &low));
    let expected = [0, 1, 2].map(|c| (bytes(77)[c] & 0xff00) | u16::from(low[77][c]));
    assert_eq!(other.code_colour(77), expected);
}

proptest! {
    #[test]
    fn linear_is_the_nearest_value_between_two_entries(seed in any::<u64>(), bits in 0i32..=4095 << 15) {
        let (entries, plane) = table(seed);
        let low = low_colours(&entries);
        let t = PointTable::<Colour16, Linear>::new(&entries, (&plane, &low));
        let s = bits;
        let (i, f) = (bits as usize >> 15, f64::from(bits & 32767) / 32768.0);
        let between = |a: u32, b: u32| f64::from(a) * (1.0 - f) + f64::from(b) * f;
        let exact = between(t.opacity_at(i), t.opacity_at(i + 1));
        let got = f64::from(Classifier::opacity(&t, Wide, s).to_bits());
        prop_assert!((got - exact).abs() <= 0.5 + 1e-6, "{got} {exact}");
        let colour = Classifier::colour(&t, Wide, s);
        for (c, (a, b)) in colour.iter().zip(t.colour_at(Wide, i).into_iter().zip(t.colour_at(Wide, i + 1))) {
            prop_assert!((f64::from(*c) - between(a, b)).abs() <= 0.5 + 1e-6);
        }
    }

    #[test]
    fn linear_meets_nearest_at_entries(seed in any::<u64>(), code in 0i32..4096) {
        let (entries, plane) = table(seed);
        let linear = PointTable::<Sqrt16, Linear>::new(&entries, &plane);
        let nearest = PointTable::<Sqrt16, Nearest>::new(&entries, &plane);
        let s = code << 12;
        prop_assert_eq!(Classifier::opacity(&linear, Compact, s), Classifier::opacity(&nearest, Compact, s));
        prop_assert_eq!(Classifier::colour(&linear, Compact, s), Classifier::colour(&nearest, Compact, s));
    }

    #[test]
    fn rows_are_the_scalar(seed in any::<u64>(), samples in prop::collection::vec(0i32..=4095 << 12, 0..34)) {
        let (entries, _) = table(seed);
        let t = PointTable::<Sqrt8, Linear>::new(&entries, ());
        let mut a = std::vec![0; samples.len()];
        let mut c = [a.clone(), a.clone(), a.clone()];
        Classifier::opacity_row::<i32>(&t, Compact, Slab::of(&samples), &mut a);
        let [r, g, b] = &mut c;
        Classifier::colour_row::<i32>(&t, Compact, Slab::of(&samples), [r, g, b]);
        for (i, &s) in samples.iter().enumerate() {
            prop_assert_eq!(a[i] as u32, Classifier::opacity(&t, Compact, s).to_bits());
            let colour = Classifier::colour(&t, Compact, s).map(|c| c as i32);
            prop_assert_eq!([c[0][i], c[1][i], c[2][i]], colour);
        }
    }
}
