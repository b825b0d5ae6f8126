//! Shading of one lane: what a machine without vectors runs.
//!
//! Numbers of 16 bits stay in registers of 32, where none of them overflows, and what no light reaches is not computed: with a cosine of 0
//! neither the root nor the highlight. The bits are those of [`FastPhong::shade`].

use super::{FastPhong, Light, ROOT, ROOT_HALF};
use crate::composite::Colours;
use crate::shade::Highlight;

/// 1, of which 65535 stands for all.
const ONE: u32 = 0xffff;

/// [`root`](super::root) of one number.
#[inline(always)]
pub(in crate::fast) fn root(h: u32) -> u32 {
    let top = h >> 15 != 0;
    let t = (if top { h << 1 } else { h << 2 }) & ONE;
    let [a, b, c, d, e, f, last] = ROOT.map(u32::from);
    // They fall, so that no difference is below 0.
    let below = |c: u32, v: u32| c - ((t * v) >> 16);
    let r = below(a, below(b, below(c, below(d, below(e, below(f, last))))));
    if top { (r * u32::from(ROOT_HALF)) >> 16 } else { r }
}

/// D of a gradient, held to 0 and 65535.
#[inline(always)]
fn facing([ax, ay, az]: [i32; 3], [bx, by, bz]: [i16; 3], k: u32) -> u32 {
    let dot = (ax * i32::from(bx) + ay * i32::from(by) + az * i32::from(bz)) << k;
    ((dot + (1 << 14)) >> 15).clamp(0, ONE as i32) as u32
}

/// A number below 2^31, at most 1: one instruction where a minimum takes three.
#[inline(always)]
fn held(sum: u32) -> u32 {
    (sum as i32).clamp(0, ONE as i32) as u32
}

/// The cosine of D that is not 0.
#[inline(always)]
fn cosine(d: u32, r: u32) -> u32 {
    held(((d * r) >> 15) + 1)
}

/// The upper half of a product.
#[inline(always)]
const fn high(a: u32, b: u32) -> u32 {
    (a * b) >> 16
}

/// The first channels.
#[inline(always)]
fn first<const CHANNELS: usize>([red, green, blue]: &[u16; 3]) -> [u32; CHANNELS] {
    core::array::from_fn(|channel| match channel {
        0 => u32::from(*red),
        1 => u32::from(*green),
        _ => u32::from(*blue),
    })
}

/// A channel of a colour under a light: in the lower half a factor, in the upper half what is added.
#[inline(always)]
fn shaded(colour: u32, light: u32) -> u16 {
    held(high(colour, light & ONE) + (light >> 16)) as u16
}

impl FastPhong {
    /// Shades a row.
    #[inline(always)]
    pub(super) fn shade_one_by_one(&self, g: [&[u16]; 3], colours: &mut Colours<'_, u16>) {
        let one = colours.one.take();
        match (self.grey, one) {
            (true, None) => self.shade_channels::<1>(g, &mut colours.rows),
            (false, None) => self.shade_channels::<3>(g, &mut colours.rows),
            (_, Some(one)) => self.shade_one_colour(one, g, &mut colours.rows),
        }
    }

    /// Shades samples of many colours. A function of its own, for which a machine's registers are enough.
    #[inline(never)]
    fn shade_channels<const CHANNELS: usize>(&self, [x, y, z]: [&[u16]; 3], [red, green, blue]: &mut [&mut [u16]; 3]) {
        let gradients = x.iter().zip(y).zip(z);
        let rows = red.iter_mut().zip(green.iter_mut()).zip(blue.iter_mut());
        for (((x, y), z), ((red, green), blue)) in gradients.zip(rows) {
            let light = self.light::<CHANNELS>(*x, *y, *z);
            let of = |channel: usize| light.get(channel.min(CHANNELS - 1)).copied().unwrap_or(0);
            *red = shaded(u32::from(*red), of(0));
            *green = shaded(u32::from(*green), of(1));
            *blue = shaded(u32::from(*blue), of(2));
        }
    }

    /// Shades samples of one colour.
    #[inline(never)]
    fn shade_one_colour(&self, [r, g, b]: [u32; 3], [x, y, z]: [&[u16]; 3], [red, green, blue]: &mut [&mut [u16]; 3]) {
        let gradients = x.iter().zip(y).zip(z);
        let rows = red.iter_mut().zip(green.iter_mut()).zip(blue.iter_mut());
        for (((x, y), z), ((red, green), blue)) in gradients.zip(rows) {
            let [of_red, of_green, of_blue] = if self.grey {
                let [light] = self.light::<1>(*x, *y, *z);
                [light; 3]
            } else {
                self.light::<3>(*x, *y, *z)
            };
            *red = shaded(r, of_red);
            *green = shaded(g, of_green);
            *blue = shaded(b, of_blue);
        }
    }

    /// The light on a surface with this gradient, as [`shaded`] takes it. A call costs less than registers that are too few.
    #[inline(never)]
    fn light<const CHANNELS: usize>(&self, x: u16, y: u16, z: u16) -> [u32; CHANNELS] {
        let gradient @ [x, y, z] = [x, y, z].map(|c| i32::from(c as i16));
        let square = (x * x) as u32 + (y * y) as u32 + (z * z) as u32;
        let k = (square.leading_zeros() >> 1).min(15);
        let mut m = first(&self.ambient);
        let mut lights = self.lights.iter();
        let mut next = || loop {
            let light = lights.next()?;
            let d = facing(gradient, light.away, k);
            if d != 0 {
                return Some((light, d));
            }
        };
        let Some(mut faced) = next() else {
            return m;
        };
        let mut e = [0; CHANNELS];
        let r = root((square << (2 * k)) >> 16);
        let towards = |vector| match facing(gradient, vector, k) {
            0 => 0,
            d => cosine(d, r),
        };
        let viewer = match self.highlight {
            Highlight::Reflection => towards(self.away_from_viewer),
            Highlight::HalfVector => 0,
        };
        loop {
            let (light, d) = faced;
            let x = cosine(d, r);
            let mut y = match self.highlight {
                Highlight::Reflection => reflected(x, viewer, light),
                Highlight::HalfVector => towards(light.away_from_half),
            };
            if y != 0 {
                for _ in 0..self.exponent_log2 {
                    y = high(y, y);
                }
            }
            for (m, diffuse) in m.iter_mut().zip(first::<CHANNELS>(&light.diffuse)) {
                *m = held(*m + high(x, diffuse));
            }
            for (e, specular) in e.iter_mut().zip(first::<CHANNELS>(&light.specular)) {
                *e = held(*e + high(y, specular));
            }
            match next() {
                Some(another) => faced = another,
                None => break,
            }
        }
        for (m, e) in m.iter_mut().zip(e) {
            *m |= e << 16;
        }
        m
    }
}

/// R.L of the cosines N.L, which is not 0, and N.V.
#[inline(always)]
fn reflected(x: u32, viewer: u32, light: &Light) -> u32 {
    if viewer == 0 {
        return 0;
    }
    let product = x * viewer;
    let t = (product >> 16).saturating_sub(u32::from(light.along));
    held(2 * t + u32::from(light.against) + (product >> 15 & 1))
}
