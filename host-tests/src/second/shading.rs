//! docs/contract/shading.md

use super::{Mistake, Numbers, Second, Width};

impl Second {
    /// A light, half or viewer vector with the bits that are kept.
    pub fn vector(&self, v: [i128; 3]) -> [i128; 3] {
        if self.width == Width::Wide {
            return v;
        }
        let n = v.map(|c| (c + (1 << 14)) >> 15);
        if self.makes(Mistake::VectorPlain) {
            return n;
        }
        let mut best: Option<([i128; 2], [i128; 3])> = None;
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let m = [n[0] + x, n[1] + y, n[2] + z];
                    if m.iter().any(|c| c.abs() > 1 << 15) {
                        continue;
                    }
                    let square: i128 = m.iter().map(|c| c * c).sum();
                    let away: i128 = m.iter().zip(v).map(|(m, v)| ((m << 15) - v).pow(2)).sum();
                    let away = if self.makes(Mistake::VectorByLengthAlone) {
                        0
                    } else {
                        away
                    };
                    let cost = [(square - (1 << 30)).abs(), away];
                    let better = best.is_none_or(|(least, _)| {
                        cost < least || (cost == least && self.makes(Mistake::VectorTieToLast))
                    });
                    if better {
                        best = Some((cost, m));
                    }
                }
            }
        }
        best.map_or(n, |(_, m)| m)
    }

    /// A coefficient with the bits that are kept.
    pub fn coefficient(&self, k: i128) -> i128 {
        if self.width == Width::Wide {
            return k;
        }
        let half = if self.makes(Mistake::CoefficientTruncated) {
            0
        } else {
            1 << 15
        };
        (k + half) >> 16
    }

    /// N . L from 0 to 1: 1.31, in `Paper` 16 fraction bits.
    fn facing(&self, g: [i128; 3], r: i128, v: [i128; 3]) -> i128 {
        let sign = if self.makes(Mistake::NormalTowards) { 1 } else { -1 };
        let dot: i128 = g.iter().zip(v).map(|(g, v)| sign * g * v).sum();
        let held = |x: i128| {
            if self.makes(Mistake::CosineUnheld) {
                x
            } else {
                x.min(1 << 31)
            }
        };
        match self.width {
            Width::Compact => {
                let half = if self.makes(Mistake::CosineTruncated) {
                    0
                } else {
                    1 << 18
                };
                held((dot.max(0) * r + half) >> 19)
            }
            Width::Wide => {
                let first = if self.makes(Mistake::CosineFirstShift) {
                    0
                } else {
                    1 << 8
                };
                let half = if self.makes(Mistake::CosineTruncated) {
                    0
                } else {
                    1 << 24
                };
                held((((dot.max(0) + first) >> 9) * r + half) >> 25)
            }
            Width::Paper => {
                let normal = g.map(|c| {
                    if self.makes(Mistake::NormalFloor) {
                        (sign * c * r) >> 23
                    } else {
                        sign * c.signum() * ((c.abs() * r) >> 23)
                    }
                });
                let products = normal.iter().zip(v).map(|(n, v)| n * v);
                let sum = if self.makes(Mistake::ProductsSummedFirst) {
                    products.sum::<i128>() >> 11
                } else {
                    products.map(|product| product >> 11).sum()
                };
                if self.makes(Mistake::CosineUnheld) {
                    sum.max(0)
                } else {
                    sum.clamp(0, 1 << 16)
                }
            }
        }
    }

    /// The same as a cosine of 1.31 bits, whatever the stage keeps.
    pub(super) fn cosine(&self, g: [i128; 3], r: i128, v: [i128; 3]) -> i128 {
        self.outside(self.facing(g, r, v))
    }

    /// From the bits inside the stage to 1.31.
    fn outside(&self, x: i128) -> i128 {
        if self.width == Width::Paper { x << 15 } else { x }
    }

    fn inside(&self, x: i128) -> i128 {
        if self.width == Width::Paper { x >> 15 } else { x }
    }

    pub(super) fn reflection(&self, cosines: [i128; 2], viewer: [i128; 3], light: [i128; 3]) -> i128 {
        self.outside(self.reflected(cosines.map(|x| self.inside(x)), viewer, light))
    }

    /// R . L from 0 to 1.
    fn reflected(&self, [nv, nl]: [i128; 2], viewer: [i128; 3], light: [i128; 3]) -> i128 {
        if (nv == 0 || nl == 0) && !self.makes(Mistake::ReflectionUnguarded) {
            return 0;
        }
        let dot: i128 = viewer.iter().zip(light).map(|(v, l)| v * l).sum();
        let half = if self.makes(Mistake::ReflectionTruncated) {
            0
        } else {
            1 << 29
        };
        let rounded = self.makes(Mistake::ViewerLightRounded);
        let (sum, one) = match self.width {
            Width::Compact => (((nv * nl + half) >> 30) - 2 * dot, 1 << 31),
            Width::Wide => {
                let along = if rounded { (dot + (1 << 28)) >> 29 } else { dot >> 29 };
                (((nv * nl + half) >> 30) - along, 1 << 31)
            }
            Width::Paper => {
                let along = if rounded { (dot + (1 << 13)) >> 14 } else { dot >> 14 };
                (((nv * nl) >> 15) - along, 1 << 16)
            }
        };
        if self.makes(Mistake::ReflectionUnheld) {
            sum.max(0)
        } else {
            sum.clamp(0, one)
        }
    }

    pub(super) fn power(&self, x: i128, n: i128) -> i128 {
        self.outside(self.raised(self.inside(x), n))
    }

    fn raised(&self, x: i128, n: i128) -> i128 {
        let mut x = x;
        let of_16_bits = self.makes(Mistake::PowerOf16Bits) && self.width != Width::Paper;
        if of_16_bits {
            x >>= 15;
        }
        for _ in 0..n {
            x = match self.width {
                Width::Paper => (x * x) >> 16,
                _ if of_16_bits => (x * x) >> 16,
                _ if self.makes(Mistake::PowerTruncated) => (x * x) >> 31,
                _ => (x * x + (1 << 30)) >> 31,
            };
        }
        if of_16_bits { x << 15 } else { x }
    }

    pub(super) fn shading(&self, inputs: &dyn Numbers) -> [i128; 3] {
        let (g, r, colour) = (inputs.ijk("g"), inputs.get("r"), inputs.rgb("colour"));
        let viewer = self.vector(inputs.ijk("viewer"));
        let half_vector = inputs.get("highlight") == 1;
        let nv = self.facing(g, r, viewer);
        let lights: Vec<_> = (0..inputs.get("lights"))
            .map(|light| {
                let direction = self.vector(inputs.ijk(&format!("light{light}_direction")));
                let x = self.facing(g, r, direction);
                let base = if half_vector {
                    let cosine = self.facing(g, r, self.vector(inputs.ijk(&format!("light{light}_half"))));
                    if x == 0 && !self.makes(Mistake::HighlightInShadow) {
                        0
                    } else {
                        cosine
                    }
                } else {
                    self.reflected([nv, x], viewer, direction)
                };
                let y = self.raised(base, inputs.get("exponent_log2"));
                let coefficients = ["diffuse", "specular"]
                    .map(|name| inputs.rgb(&format!("light{light}_{name}")).map(|k| self.coefficient(k)));
                ([x, y], coefficients)
            })
            .collect();
        let ambient = inputs.rgb("ambient").map(|k| self.coefficient(k));
        [0, 1, 2].map(|channel| {
            let parts: Vec<_> = lights
                .iter()
                .map(|(cosines, coefficients)| (*cosines, [coefficients[0][channel], coefficients[1][channel]]))
                .collect();
            self.lit(colour[channel], ambient[channel], &parts)
        })
    }

    /// The colour of a channel. Each light: cosine and power, diffuse and specular coefficient.
    fn lit(&self, o: i128, ambient: i128, lights: &[([i128; 2], [i128; 2])]) -> i128 {
        let sum = |part: usize, product: &dyn Fn(i128, i128) -> i128| -> i128 {
            lights
                .iter()
                .map(|(cosines, coefficients)| product(coefficients[part], cosines[part]))
                .sum()
        };
        let wraps = |sum: i128| {
            if self.makes(Mistake::SumWraps) {
                sum & 0xffff_ffff
            } else {
                sum
            }
        };
        let hold = |sum: i128, one: i128| {
            if self.makes(Mistake::DiffuseUnheld) {
                sum
            } else {
                sum.min(one)
            }
        };
        let last = |sum: i128, one: i128| {
            if self.makes(Mistake::ColourUnheld) {
                sum
            } else {
                sum.min(one)
            }
        };
        let rounded = self.makes(Mistake::ProductsRounded);
        match self.width {
            Width::Compact => {
                let half = if self.makes(Mistake::CosineCut) { 0 } else { 1 << 14 };
                let product = |k: i128, x: i128| k * ((x + half) >> 15);
                let (diffuse, specular) = (wraps((ambient << 16) + sum(0, &product)), wraps(sum(1, &product)));
                let half = if self.makes(Mistake::DiffuseTruncated) {
                    0
                } else {
                    1 << 14
                };
                let m = hold((diffuse + half) >> 15, 1 << 16);
                let specular = if self.makes(Mistake::HighlightColoured) {
                    (o * specular) >> 15
                } else {
                    specular
                };
                let half = if self.makes(Mistake::ColourTruncatedLast) {
                    0
                } else {
                    1 << 15
                };
                last((o * m + specular + half) >> 16, 1 << 15)
            }
            Width::Wide => {
                let product = |k: i128, x: i128| (k * x + if rounded { 1 << 30 } else { 0 }) >> 31;
                let diffuse = hold(wraps(ambient + sum(0, &product)), 1 << 31);
                let specular = wraps(sum(1, &product)).min(1 << 31);
                let specular = if self.makes(Mistake::HighlightColoured) {
                    (o * specular) >> 31
                } else {
                    specular
                };
                let half = if self.makes(Mistake::ColourTruncatedLast) {
                    0
                } else {
                    1 << 30
                };
                last((o * diffuse + (specular << 31) + half) >> 31, 1 << 31)
            }
            Width::Paper => {
                let product = |k: i128, x: i128| (k * x + if rounded { 1 << 14 } else { 0 }) >> 15;
                let diffuse = hold(2 * ambient + sum(0, &product), 1 << 16);
                let specular = sum(1, &product);
                let specular = if self.makes(Mistake::HighlightColoured) {
                    (o * specular) >> 15
                } else {
                    specular
                };
                let product = (o * diffuse) >> 15;
                let sum = if self.makes(Mistake::HalvedApart) {
                    (product >> 1) + (specular >> 1)
                } else {
                    (product + specular) >> 1
                };
                last(sum, 1 << 15)
            }
        }
    }
}
