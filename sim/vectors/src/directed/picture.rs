//! The warp, the background, and 8 bits.

use slicecast::composite::{Channel, ChannelFormat, Pixel, Recurrence, to_byte};
use slicecast::format::{Intensity, Step};
use slicecast::precision::Precision;
use slicecast::warp::{Warp, in_front_of, mix};

use super::{Numbers, channel};
use crate::set::{Set, s, u};

type ChannelOf<P> = <<P as Precision>::Pixel as Recurrence>::Channel;

/// Where a picture pixel looks.
pub fn coordinate() -> Set {
    let unit = "2^-32 base-plane pixel";
    let inputs = vec![
        s("origin", 64, unit),
        s("right", 64, unit),
        s("down", 64, unit),
        u("x", 14, "picture pixels"),
        u("y", 14, "picture pixels"),
    ];
    let outputs = vec![s("pixel", 32, "base-plane pixels"), u("weight", 16, "2^-16")];
    let about = "where a picture pixel looks along u or v";
    let mut set = Set::new(None, "coordinate", about, inputs, outputs);
    let mut push = |map: [i64; 3], x: i64, y: i64| {
        let [origin, right, down] = map.map(|c| [Step::from_bits(c); 2]);
        let point = Warp { origin, right, down }.point(x as u32, y as u32);
        let [origin, right, down] = map;
        set.push(&[origin, right, down, x, y], &[point.pixel[0], point.weight[0].into()]);
    };
    let one = 1_i64 << 32;
    for around in [-1, 0, 1] {
        for place in [0, 5 * one, -5 * one] {
            // Halves of the rounding, and the weight that a rounding carries over.
            push([place + (1 << 15) + around, one, -one], 0, 0);
            push([place - (1 << 15) + around, one, -one], 3, 2);
            push([place - (1 << 16) + (1 << 15) + around, one / 3, one / 7], 0, 0);
        }
    }
    // It wraps.
    push([i64::MAX, 1, 0], 0, 0);
    push([i64::MAX, 0, i64::MAX], 0, 3);
    push([i64::MIN, -1, -1], 16383, 16383);
    let mut numbers = Numbers(14);
    for _ in 0..64 {
        let map = [
            numbers.within(-400 * one, 400 * one),
            numbers.within(-one, one),
            numbers.within(-one, one),
        ];
        push(map, numbers.within(0, 16383), numbers.within(0, 16383));
    }
    set
}

/// The mixture of four pixels, one channel of them.
pub fn mixture<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(p: P) -> Set {
    let mut inputs: Vec<_> = ["p00", "p01", "p10", "p11"].map(|name| channel(p, name)).to_vec();
    inputs.extend([u("weight_u", 16, "2^-16"), u("weight_v", 16, "2^-16")]);
    let about = "one channel of four base-plane pixels, p_vu, along u and then along v";
    let mut set = Set::new(Some(P::NAME), "mixture", about, inputs, vec![channel(p, "mixed")]);
    let mut push = |corners: [i64; 4], wu: i64, wv: i64| {
        let [a, b, c, d] = corners.map(|bits| ChannelOf::<P>::from_bits(bits as u32));
        let mixed = mix(mix(a, b, wu as u32), mix(c, d, wu as u32), wv as u32);
        set.push(&[&corners[..], &[wu, wv]].concat(), &[mixed.bits().into()]);
    };
    let one = i64::from(ChannelOf::<P>::ONE.bits());
    let weights = [0, 1, 0x7fff, 0x8000, 0x8001, 0xffff];
    for corners in [
        [0, one, one, 0],
        [one, 0, 0, one],
        [one; 4],
        [0; 4],
        [0, 1, 2, 3],
        [3, 2, 1, 0],
        [one - 1, one, one, one - 1],
    ] {
        for wu in weights {
            weights.iter().for_each(|wv| push(corners, wu, *wv));
        }
    }
    let mut numbers = Numbers(15);
    for _ in 0..200 {
        let corners = [(); 4].map(|()| numbers.within(0, one));
        push(corners, numbers.within(0, 65535), numbers.within(0, 65535));
    }
    set
}

/// A channel in front of a background, as a byte.
pub fn background<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(p: P) -> Set {
    let inputs = vec![channel(p, "colour"), channel(p, "t"), u("background", 16, "2^-15")];
    let about = "a channel in front of the background's, to 8 bits";
    let mut set = Set::new(Some(P::NAME), "background", about, inputs, vec![u("byte", 8, "1/255")]);
    let mut push = |colour: i64, t: i64, k: i64| {
        let [c, transparency] = [colour, t].map(|bits| ChannelOf::<P>::from_bits(bits as u32));
        let pixel = Pixel {
            colour: [c; 3],
            transparency,
        };
        let [byte, _, _] = in_front_of(pixel, [Intensity::from_bits(k as u16); 3]);
        set.push(&[colour, t, k], &[byte.into()]);
    };
    let one = i64::from(ChannelOf::<P>::ONE.bits());
    for t in [0, 1, one / 2, one - 1, one] {
        for k in [0, 1, 16384, 32767, 32768] {
            // A sum above 1 is held to it.
            for colour in [0, one - t, one] {
                push(colour, t, k);
            }
        }
    }
    // Where a byte begins: the least sum that rounds to it, made of a background that has a half to round.
    for byte in 1..=255 {
        let begins = ((2 * byte - 1) * one + 509) / 510;
        for around in [-1, 0] {
            push((begins + around - 1).max(0), 1, 16384);
            push((begins + around).min(one), 1, 16383);
        }
    }
    let mut numbers = Numbers(16);
    for _ in 0..100 {
        let t = numbers.within(0, one);
        push(numbers.within(0, one - t), t, numbers.within(0, 32768));
    }
    set
}

/// A channel as a byte.
pub fn output<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(p: P) -> Set {
    let about = "a channel to the nearest 8 bits";
    let mut set = Set::new(
        Some(P::NAME),
        "output",
        about,
        vec![channel(p, "channel")],
        vec![u("byte", 8, "1/255")],
    );
    let one = i64::from(ChannelOf::<P>::ONE.bits());
    let mut push = |bits: i64| set.push(&[bits], &[to_byte(ChannelOf::<P>::from_bits(bits as u32)).into()]);
    push(0);
    push(one);
    for byte in 1..=255 {
        let begins = ((2 * byte - 1) * one + 509) / 510;
        (-1..=1).for_each(|around| push(begins + around));
    }
    set
}
