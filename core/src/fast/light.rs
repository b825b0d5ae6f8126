//! Normalisation and shading in 16 bits.
//!
//! Of a gradient G, at whatever scale: `S = |G|^2`, `k = min(15, clz(S) >> 1)`, `h = (S << 2 k) >> 16`, `r = root(h)`, about
//! 2^23 / sqrt(h). A cosine with a vector L of 32767: `D = ((G . L << k) + 2^14) >> 15`, 0 to 65535, and
//! `x = (D r >> 15) + 1`, 0 where D is. No component is divided, so nothing of a weak gradient is lost.
//!
//! Light: `m = ka + sum high(kd, x)`, `e = sum high(ks, y)`, `c = high(o, m) + e`, each held to 65535, with
//! `high(a, b) = (a b) >> 16`. y is the 2^n-th power of R.L or N.H, n times `y = high(y, y)`.
//! R.L = 2 (N.V)(N.L) - V.L, of which V.L is the caller's.
//!
//! Source: Squeeze, sections 4.2 and 4.3 (Phong with powers by squaring).

pub(super) mod one_lane;

use heapless::Vec;

use crate::composite::Colours;
use crate::format::{Coefficient, Vector};
use crate::lanes::{Halves, each};
use crate::shade::{Highlight, LIGHTS_MAX, Light as Given, PhongError};

/// Coefficients of the reciprocal root of 1 + t, t below 1, nested with alternating signs, 0.16.
const ROOT: [u16; 7] = [65535, 32754, 24343, 18950, 12757, 5854, 1264];
/// 2^15.5.
const ROOT_HALF: u16 = 46342;

#[inline(always)]
fn below<H: Halves>(c: u16, t: H, v: H) -> H {
    H::splat(c).minus(t.product_high(v))
}

/// About 2^23 / sqrt(h), h at least 16384 (0: anything): within 2.1.
#[inline(always)]
pub fn root<H: Halves>(h: H) -> H {
    let [a, b, c, d, e, f, last] = ROOT;
    let t = h.top_then_else(h.shl(1), h.shl(2));
    let nest = below(d, t, below(e, t, below(f, t, H::splat(last))));
    let r = below(a, t, below(b, t, below(c, t, nest)));
    h.top_then_else(r.product_high(H::splat(ROOT_HALF)), r)
}

/// `(D r >> 15) + 1`, at most 65535; 0 where D is.
#[inline(always)]
fn cosine<H: Halves>(d: H, r: H) -> H {
    let (high, low) = (d.product_high(r), d.product_low(r));
    let x = high
        .plus_saturating(high)
        .plus_saturating(low.shr(15).plus(H::splat(1)));
    d.nonzero_then(x)
}

/// A light as shading multiplies by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Light {
    /// -L, 32767 is 1.
    away: [i16; 3],
    /// -H, likewise.
    away_from_half: [i16; 3],
    /// V.L where it is positive, 0.15.
    along: u16,
    /// -V.L where it is negative, 0.16.
    against: u16,
    diffuse: [u16; 3],
    specular: [u16; 3],
}

impl Light {
    /// What sheds none.
    const NONE: Self = Self {
        away: [0; 3],
        away_from_half: [0; 3],
        along: 0,
        against: 0,
        diffuse: [0; 3],
        specular: [0; 3],
    };
}

/// Phong illumination by up to eight lights.
#[derive(Clone, Debug)]
pub struct FastPhong {
    ambient: [u16; 3],
    lights: Vec<Light, LIGHTS_MAX>,
    away_from_viewer: [i16; 3],
    highlight: Highlight,
    exponent_log2: u32,
    grey: bool,
}

/// A coefficient of which 65535 is 1, to nearest, larger by so many 2^-30 of itself (at most 2^26), and at most 1.
#[inline]
const fn keep(coefficient: Coefficient, larger: u64) -> u16 {
    // At most 2^31, with 15 fraction bits.
    let fine = (coefficient.to_bits() as u64 * 65535) >> 16;
    let kept = (fine + ((fine * larger) >> 30) + (1 << 14)) >> 15;
    if kept > 0xffff { 0xffff } else { kept as u16 }
}

/// What 1 lacks in vectors of which 32767 is 1: a cosine is too small by 2^-15 of itself, 2^-30.
const LACK: u64 = 1 << 15;

/// The opposite of a unit vector, 32767 is 1: the nearest lattice vector, or that one of its 26 neighbours no longer than 32767 whose
/// length is nearest to it.
fn opposite(vector: [Vector; 3]) -> [i16; 3] {
    const ONE: i64 = 32767;
    let exact = vector.map(|c| -i64::from(c.to_bits()) * ONE);
    let nearest = exact.map(|c| (c + (1 << 29)) >> 30);
    let mut best = ((i64::MAX, i64::MAX), [0i64; 3]);
    for at in 0i64..27 {
        let [x, y, z] = nearest;
        // Thirds of a number below 27, without a division.
        let (slow, rest) = ((at * 57) >> 9, at - 9 * ((at * 57) >> 9));
        let (middle, fast) = ((rest * 86) >> 8, rest - 3 * ((rest * 86) >> 8));
        let candidate = [x + slow - 1, y + middle - 1, z + fast - 1];
        let square: i64 = candidate.iter().map(|c| c * c).sum();
        let short = ONE * ONE - square;
        if short < 0 {
            continue;
        }
        let away = candidate
            .iter()
            .zip(exact)
            .map(|(c, e)| (((c << 30) - e) >> 15).pow(2))
            .sum();
        if (short, away) < best.0 {
            best = ((short, away), candidate);
        }
    }
    best.1.map(|c| c as i16)
}

impl FastPhong {
    /// Lights and material. All vectors are unit vectors, `viewer` towards the eye, in the slice frame; the highlight's exponent is
    /// `2^exponent_log2`.
    ///
    /// # Errors
    /// [`PhongError`], with the value that is out of range.
    pub fn new(
        ambient: [Coefficient; 3],
        lights: &[Given],
        viewer: [Vector; 3],
        highlight: Highlight,
        exponent_log2: u32,
    ) -> Result<Self, PhongError> {
        crate::shade::check(ambient, lights, viewer, exponent_log2)?;
        let mut kept = Vec::new();
        for light in lights {
            let along: i64 = viewer
                .iter()
                .zip(light.direction)
                .map(|(v, l)| i64::from(v.to_bits()) * i64::from(l.to_bits()))
                .sum();
            let held = |c: i64| c.clamp(0, 0xffff) as u16;
            // A highlight's base lacks as much at its top, where 2 (N.V)(N.L) is 1 + V.L; its power 2^n times that.
            let lack = match highlight {
                Highlight::HalfVector => LACK,
                Highlight::Reflection => 2 * ((LACK as i64 + (along >> 45)).max(0) as u64),
            };
            let light = Light {
                away: opposite(light.direction),
                away_from_half: opposite(light.half),
                along: held((along + (1 << 44)) >> 45),
                against: held((-along + (1 << 43)) >> 44),
                diffuse: light.diffuse.map(|c| keep(c, LACK)),
                specular: light.specular.map(|c| keep(c, lack << exponent_log2)),
            };
            let given = lights.len();
            kept.push(light).map_err(|_| PhongError::Lights { given })?;
        }
        // Products are cut off, by half a unit in the mean: that of each light, and that with the colour.
        let lost = (lights.len() as u16 + 1) >> 1;
        let ambient = ambient.map(|c| keep(c, 0).saturating_add(lost));
        let equal = |[r, g, b]: [u16; 3]| r == g && g == b;
        Ok(Self {
            ambient,
            grey: equal(ambient) && kept.iter().all(|light| equal(light.diffuse) && equal(light.specular)),
            lights: kept,
            away_from_viewer: opposite(viewer),
            highlight,
            exponent_log2,
        })
    }

    /// Colour of a sample with this gradient and classified colour. This function is the definition: a row of one.
    #[inline]
    pub fn shade(&self, gradient: [i16; 3], colour: [u16; 3]) -> [u16; 3] {
        let [x, y, z] = gradient.map(|c| [c as u16]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c]);
        let mut colours = Colours {
            one: None,
            rows: [&mut red, &mut green, &mut blue],
        };
        self.shade_as::<u16, ASKED>([&x, &y, &z], &mut colours);
        [red, green, blue].map(|[c]| c)
    }

    /// Shades the colours of a row in place, so that its rows hold them. Vectors have code of their own for each kind of light, in
    /// which nothing is asked in the loop.
    #[inline(always)]
    pub(crate) fn shade_row<H: Halves>(&self, g: [&[u16]; 3], colours: &mut Colours<'_, u16>) {
        if H::COUNT == 1 {
            return self.shade_one_by_one(g, colours);
        }
        match (self.highlight, self.grey, self.lights.len()) {
            (Highlight::Reflection, true, 1) => self.shade_as::<H, { REFLECTION | GREY | ALONE }>(g, colours),
            (Highlight::Reflection, true, _) => self.shade_as::<H, { REFLECTION | GREY }>(g, colours),
            (Highlight::Reflection, false, _) => self.shade_as::<H, REFLECTION>(g, colours),
            (Highlight::HalfVector, true, 1) => self.shade_as::<H, { GREY | ALONE }>(g, colours),
            (Highlight::HalfVector, true, _) => self.shade_as::<H, GREY>(g, colours),
            (Highlight::HalfVector, false, _) => self.shade_as::<H, 0>(g, colours),
        }
    }

    /// Whether light is of a kind, which may be known to the compiler.
    #[inline(always)]
    fn is<const KIND: u32>(&self, asked: u32) -> bool {
        match KIND {
            ASKED if asked == GREY => self.grey,
            ASKED => self.highlight == Highlight::Reflection,
            kind => kind & asked != 0,
        }
    }

    /// Shades by lights of a kind. Without a highlight's vectors where no light has one.
    #[inline(always)]
    fn shade_as<H: Halves, const KIND: u32>(&self, [x, y, z]: [&[u16]; 3], colours: &mut Colours<'_, u16>) {
        let (one, [red, green, blue], len) = (colours.one.take(), &mut colours.rows, x.len());
        let (Some(y), Some(z)) = (y.get(..len), z.get(..len)) else {
            return;
        };
        let (Some(red), Some(green), Some(blue)) = (red.get_mut(..len), green.get_mut(..len), blue.get_mut(..len))
        else {
            return;
        };
        let [r, g, b] = one.unwrap_or_default();
        let one = [one.map(|_| r as u16), one.map(|_| g as u16), one.map(|_| b as u16)];
        let alone = Spread::of(self.lights.first().unwrap_or(&Light::NONE));
        let away_from_viewer = H::direction(self.away_from_viewer);
        each!(H, x.len(), |at, WHOLE| {
            let gradient = [
                H::load::<WHOLE>(x, at),
                H::load::<WHOLE>(y, at),
                H::load::<WHOLE>(z, at),
            ];
            let normal = Normal::of(gradient);
            let viewer = if self.is::<KIND>(REFLECTION) {
                normal.towards(away_from_viewer)
            } else {
                H::splat(0)
            };
            let mut sums = Sums::of(self.ambient);
            if KIND & ALONE != 0 {
                self.add::<H, KIND>(&mut sums, &normal, viewer, &alone);
            } else {
                for light in &self.lights {
                    self.add::<H, KIND>(&mut sums, &normal, viewer, &Spread::of(light));
                }
            }
            let sums = if self.is::<KIND>(GREY) { sums.grey() } else { sums };
            let [one_red, one_green, one_blue] = one;
            sums.red.shade::<WHOLE>(one_red, red, at);
            sums.green.shade::<WHOLE>(one_green, green, at);
            sums.blue.shade::<WHOLE>(one_blue, blue, at);
        });
    }

    /// Adds a light.
    #[inline(always)]
    fn add<H: Halves, const KIND: u32>(&self, sums: &mut Sums<H>, normal: &Normal<H>, viewer: H, light: &Spread<H>) {
        let x = normal.towards(light.away);
        let mut y = if self.is::<KIND>(REFLECTION) {
            reflected(x, viewer, light)
        } else {
            x.nonzero_then(normal.towards(light.away_from_half))
        };
        for _ in 0..self.exponent_log2 {
            y = y.product_high(y);
        }
        sums.add(x, y, light, self.is::<KIND>(GREY));
    }
}

/// Kinds of light: a highlight by reflection, not by a half vector.
const REFLECTION: u32 = 1;
/// Light of no colour.
const GREY: u32 = 2;
/// One light.
const ALONE: u32 = 4;
/// A kind that is asked for.
const ASKED: u32 = 8;

/// Red, green and blue in all lanes.
#[inline(always)]
fn all<H: Halves>([red, green, blue]: [u16; 3]) -> [H; 3] {
    [H::splat(red), H::splat(green), H::splat(blue)]
}

/// A light in all lanes, made before a loop over samples.
struct Spread<H: Halves> {
    away: H::Direction,
    away_from_half: H::Direction,
    along: H,
    against: H,
    diffuse: [H; 3],
    specular: [H; 3],
}

impl<H: Halves> Spread<H> {
    #[inline(always)]
    fn of(light: &Light) -> Self {
        Self {
            away: H::direction(light.away),
            away_from_half: H::direction(light.away_from_half),
            along: H::splat(light.along),
            against: H::splat(light.against),
            diffuse: all(light.diffuse),
            specular: all(light.specular),
        }
    }
}

/// What cosines are made of.
#[derive(Clone, Copy)]
struct Normal<H: Halves> {
    gradient: [H; 3],
    k: H::Shifts,
    r: H,
}

impl<H: Halves> Normal<H> {
    #[inline(always)]
    fn of(gradient: [H; 3]) -> Self {
        let (k, h) = H::normalised(gradient);
        Self {
            gradient,
            k,
            r: root(h),
        }
    }

    /// The cosine with a vector.
    #[inline(always)]
    fn towards(&self, vector: H::Direction) -> H {
        cosine(H::facing(self.gradient, vector, self.k), self.r)
    }
}

/// Light of one channel: a factor of the colour, and what is added.
#[derive(Clone, Copy)]
struct Sum<H> {
    m: H,
    e: H,
}

impl<H: Halves> Sum<H> {
    #[inline(always)]
    fn of(ambient: u16) -> Self {
        Self {
            m: H::splat(ambient),
            e: H::splat(0),
        }
    }

    #[inline(always)]
    fn add(&mut self, x: H, y: H, diffuse: H, specular: H) {
        self.m = self.m.plus_saturating(x.product_high(diffuse));
        self.e = self.e.plus_saturating(y.product_high(specular));
    }

    /// Shades colours of a row, or one.
    #[inline(always)]
    fn shade<const WHOLE: bool>(self, one: Option<u16>, row: &mut [u16], at: usize) {
        let colour = match one {
            Some(one) => H::splat(one),
            None => H::load::<WHOLE>(row, at),
        };
        colour
            .product_high(self.m)
            .plus_saturating(self.e)
            .store::<WHOLE>(row, at);
    }
}

/// Light of all three.
#[derive(Clone, Copy)]
struct Sums<H> {
    red: Sum<H>,
    green: Sum<H>,
    blue: Sum<H>,
}

impl<H: Halves> Sums<H> {
    #[inline(always)]
    fn of([red, green, blue]: [u16; 3]) -> Self {
        Self {
            red: Sum::of(red),
            green: Sum::of(green),
            blue: Sum::of(blue),
        }
    }

    /// Red alone, where it serves all.
    #[inline(always)]
    fn add(&mut self, x: H, y: H, light: &Spread<H>, grey: bool) {
        let ([dr, dg, db], [sr, sg, sb]) = (light.diffuse, light.specular);
        self.red.add(x, y, dr, sr);
        if !grey {
            self.green.add(x, y, dg, sg);
            self.blue.add(x, y, db, sb);
        }
    }

    #[inline(always)]
    fn grey(self) -> Self {
        let Self { red, .. } = self;
        Self {
            red,
            green: red,
            blue: red,
        }
    }
}

/// R.L of the cosines N.L and N.V, 0 where one of them is.
#[inline(always)]
fn reflected<H: Halves>(x: H, viewer: H, light: &Spread<H>) -> H {
    let (high, low) = (x.product_high(viewer), x.product_low(viewer));
    let t = high.minus_saturating(light.along);
    let y = t
        .plus_saturating(t)
        .plus_saturating(light.against)
        .plus_saturating(low.shr(15));
    x.nonzero_then(viewer.nonzero_then(y))
}
