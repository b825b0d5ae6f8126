use super::*;
use proptest::prelude::*;

fn opacity() -> impl Strategy<Value = Opacity> {
    prop_oneof![0u32..=1 << 31, 0u32..100_000, Just(1 << 31), Just(2147418113), Just(0)].prop_map(Opacity::from_bits)
}

/// Colours in 1.15; [`scaled`] takes them to a pixel's own bits.
fn colour() -> impl Strategy<Value = [u32; 3]> {
    prop::array::uniform3(prop_oneof![0u32..=32768, Just(32768), Just(0)])
}

fn scaled<R: Recurrence>(r: R, colour: [u32; 3]) -> [u32; 3] {
    colour.map(|c| c << (r.colour_bits() - 15))
}

/// One sample folded by the scalar functions and [`settle`].
fn folded<R: Recurrence, O: Order>(
    recurrence: R,
    pixel: Pixel<R::Channel>,
    colour: [u32; 3],
    opacity: Opacity,
    dither: Dither,
) -> Pixel<R::Channel> {
    if O::BACK_TO_FRONT {
        return recurrence.under(pixel, colour, opacity, dither);
    }
    let mut out = recurrence.over(pixel, colour, opacity, dither);
    out.transparency = settle(out.transparency, recurrence.floor());
    out
}

fn keeps_its_bounds<R: Recurrence>(r: R, samples: &[([u32; 3], Opacity)]) -> Result<(), TestCaseError> {
    let one = r.one().bits();
    let (mut over, mut under) = (r.clear(), r.clear());
    for (k, &(c, a)) in samples.iter().enumerate() {
        let dither = Dither::of_plane(k as u32);
        let c = scaled(r, c);
        over = r.over(over, c, a, dither);
        under = r.under(under, c, a, dither);
        for channel in over.colour {
            prop_assert!(channel.bits() + over.transparency.bits() <= one);
        }
        for channel in under.colour {
            prop_assert!(channel.bits() <= one);
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn nothing_ever_needs_a_clamp(samples in prop::collection::vec((colour(), opacity()), 0..200)) {
        keeps_its_bounds(Truncating15, &samples)?;
        keeps_its_bounds(Dithered, &samples)?;
        keeps_its_bounds(Telescoping31, &samples)?;
    }

    #[test]
    fn white_fog_keeps_all_light(samples in prop::collection::vec(opacity(), 0..400)) {
        let white = [1 << 15; 3];
        let (mut wide, mut compact) = (Telescoping31.clear(), Dithered.clear());
        for (k, &a) in samples.iter().enumerate() {
            let dither = Dither::of_plane(k as u32);
            wide = Telescoping31.over(wide, scaled(Telescoping31, white), a, dither);
            compact = Dithered.over(compact, white, a, dither);
        }
        prop_assert_eq!(wide.colour[0] + wide.transparency, 1 << 31);
        prop_assert_eq!(compact.colour[0].0 + compact.transparency.0, u16::MAX);
    }

    #[test]
    fn transparent_samples_and_finished_rays_change_nothing(
        t in 0u32..=1 << 31, c in any::<u32>(), sample in colour(), a in opacity(), k in any::<u32>(),
    ) {
        fn unchanged<R: Recurrence>(
            r: R, t: u32, c: u32, sample: [u32; 3], a: Opacity, k: u32,
        ) -> Result<(), TestCaseError> {
            let t = ((u64::from(t) * u64::from(r.one().bits())) >> 31) as u32;
            let c = c.checked_rem(r.one().bits() - t + 1).unwrap_or(0);
            let pixel = Pixel { colour: [R::Channel::from_bits(c); 3], transparency: R::Channel::from_bits(t) };
            let (sample, dither) = (scaled(r, sample), Dither::of_plane(k));
            prop_assert_eq!(r.over(pixel, sample, Opacity::ZERO, dither), pixel);
            prop_assert_eq!(r.under(pixel, sample, Opacity::ZERO, dither), pixel);
            let finished = Pixel { transparency: R::Channel::default(), ..pixel };
            prop_assert_eq!(r.over(finished, sample, a, dither), finished);
            Ok(())
        }
        unchanged(Truncating15, t, c, sample, a, k)?;
        unchanged(Dithered, t, c, sample, a, k)?;
        unchanged(Telescoping31, t, c, sample, a, k)?;
    }

    #[test]
    fn two_together_are_the_scalar(samples in any::<[([u32; 3], u16); 2]>(), a in [opacity(), opacity()], t in any::<[u16; 2]>(), k in any::<u32>()) {
        fn same<R: Recurrence>(
            r: R, samples: [([u32; 3], u16); 2], a: [Opacity; 2], t: [u16; 2], k: u32,
        ) -> Result<(), TestCaseError> {
            let one = u64::from(r.one().bits());
            let channel = |share: u16| R::Channel::from_bits((one * u64::from(share) / 65535) as u32);
            // Colours and transparencies whose sums fit, as those of a pixel do.
            let clear = t.map(channel);
            let old = [0, 1].map(|i| channel((u32::from(65535 - t[i]) * u32::from(samples[i].1) / 65535) as u16));
            let colours = samples.map(|(c, _)| c.map(|c| c % ((1 << r.colour_bits()) + 1)));
            let dither = Dither::of_plane(k);
            let mut row = [old, old, old, clear].concat();
            let mut pixels = PixelRow::of_runs(&mut row, 2, 0..2);
            let two = [0, 1].map(|i| (colours[i].map(|c| c as i32), a[i].to_bits() as i32));
            r.over_two::<i32>(&mut pixels, 0, two, dither, r.floor().bits() as i32);
            for i in [0, 1] {
                let pixel = Pixel { colour: [old[i]; 3], transparency: clear[i] };
                let out = folded::<_, FrontToBack>(r, pixel, colours[i], a[i], dither);
                prop_assert_eq!([row[i], row[2 + i], row[4 + i]], out.colour);
                prop_assert_eq!(row[6 + i], out.transparency);
            }
            Ok(())
        }
        same(Truncating15, samples, a, t, k)?;
        same(Dithered, samples, a, t, k)?;
        same(Telescoping31, samples, a, t, k)?;
    }

    #[test]
    fn rows_are_the_scalar(samples in prop::collection::vec((colour(), opacity()), 0..34), k in any::<u32>()) {
        fn same<R: Recurrence, O: Order>(
            r: R, samples: &[([u32; 3], Opacity)], k: u32,
        ) -> Result<(), TestCaseError> {
            let n = samples.len();
            let dither = Dither::of_plane(k);
            let mut row = std::vec![R::Channel::default(); 4 * n];
            for (i, v) in row.iter_mut().enumerate() {
                let share = r.one().bits() / (4 * n as u32 + 1);
                *v = R::Channel::from_bits(share * (i as u32 % 7));
            }
            let before = row.clone();
            let column = |c: usize| samples.iter().map(|s| scaled(r, s.0)[c] as i32).collect::<std::vec::Vec<_>>();
            let [red, green, blue] = [0, 1, 2].map(column);
            let a: std::vec::Vec<i32> = samples.iter().map(|s| s.1.to_bits() as i32).collect();
            let mut pixels = PixelRow::of_runs(&mut row, n, 0..n);
            fold_row::<_, O, i32>(r, &mut pixels, [&red[..], &green, &blue], &a, dither, r.floor());
            for (i, &(c, a)) in samples.iter().enumerate() {
                let pixel = Pixel {
                    colour: [before[i], before[n + i], before[2 * n + i]], transparency: before[3 * n + i],
                };
                let out = folded::<_, O>(r, pixel, scaled(r, c), a, dither);
                prop_assert_eq!([row[i], row[n + i], row[2 * n + i]], out.colour);
                prop_assert_eq!(row[3 * n + i], out.transparency);
            }
            // One colour is a row of it, and what is left out changes nothing.
            let one = samples.first().map_or([0; 3], |s| scaled(r, s.0));
            let rows = one.map(|c| std::vec![c as i32; n]);
            let (mut by_row, mut at_once) = (before.clone(), before);
            let mut pixels = PixelRow::of_runs(&mut by_row, n, 0..n);
            fold_row::<_, O, i32>(r, &mut pixels, rows.each_ref().map(|row| &row[..]), &a, dither, r.floor());
            let mut pixels = PixelRow::of_runs(&mut at_once, n, 0..n);
            fold_visible_row::<_, O, i32>(r, &mut pixels, one, &a, dither, r.floor());
            prop_assert_eq!(by_row, at_once);
            Ok(())
        }
        same::<_, FrontToBack>(Truncating15, &samples, k)?;
        same::<_, FrontToBack>(Dithered, &samples, k)?;
        same::<_, FrontToBack>(Telescoping31, &samples, k)?;
        same::<_, BackToFront>(Dithered, &samples, k)?;
        same::<_, BackToFront>(Telescoping31, &samples, k)?;
    }
}

#[test]
fn bytes_are_exactly_rounded() {
    for bits in 0..=1u16 << 15 {
        let exact = (f64::from(bits) / 32768.0 * 255.0 + 0.5).floor();
        assert_eq!(f64::from(to_byte(bits)), exact);
    }
    assert_eq!(
        (
            to_byte(0u32),
            to_byte(1u32 << 31),
            to_byte(4210752u32),
            to_byte(4210753u32)
        ),
        (0, 255, 0, 1)
    );
}
