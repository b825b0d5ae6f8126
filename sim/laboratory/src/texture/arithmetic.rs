//! Arithmetic on [0, 255], where 255 is 1: products, the filter of texels, light, and blending into a frame buffer.

/// A texel, a table's entry or a pixel: four channels of 8 bits.
pub type Bytes = [u8; 4];

/// How the product of two numbers of 8 bits becomes one of 8 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// `t = a b + 128; (t + (t >> 8)) >> 8`: a b / 255 to nearest (Squeeze, equation 1, after Blinn).
    Blinn,
    /// `a b >> 8`: 255 times 255 is 254.
    Shift,
}

impl Product {
    /// The product.
    pub const fn of(self, a: u8, b: u8) -> u8 {
        let product = a as u32 * b as u32;
        let byte = match self {
            Self::Blinn => {
                let t = product + 128;
                (t + (t >> 8)) >> 8
            }
            Self::Shift => product >> 8,
        };
        byte as u8
    }
}

/// Texels around a place, by weights of 8 bits along each axis: the weighted sum is exact (24 fraction bits, below 2^32), and rounded
/// once, half up. Texels are in the order of i, then j, then k.
pub fn filtered(texels: [Bytes; 8], [x, y, z]: [u32; 3]) -> Bytes {
    let mut sums = [1u32 << 23; 4];
    for (corner, texel) in texels.into_iter().enumerate() {
        let along = |bit: usize, w: u32| if corner >> bit & 1 == 1 { w } else { 256 - w };
        let weight = along(0, x) * along(1, y) * along(2, z);
        for (sum, channel) in sums.iter_mut().zip(texel) {
            *sum += weight * u32::from(channel);
        }
    }
    sums.map(|sum| (sum >> 24) as u8)
}

/// A component of a unit vector, -1 to 1, as a byte about 128: `128 + round(127 c)`, of which 0 is held exactly.
pub fn component(c: f64) -> u8 {
    (128.0 + (127.0 * c).round()) as u8
}

/// What a cube map of normals holds: the direction of a vector at its full length, each component to nearest; no vector stays none.
pub fn normalised(vector: [u8; 3]) -> [u8; 3] {
    let vector = vector.map(|c| i32::from(c) - 128);
    let square: i32 = vector.iter().map(|c| c * c).sum();
    // 256 times the length.
    let length = i64::from((square as u32 * 65536).isqrt()).max(1);
    vector.map(|c| {
        let magnitude = (i64::from(c.abs()) * 127 * 256 + length / 2) / length;
        (128 + i64::from(c.signum()) * magnitude) as u8
    })
}

/// A light: its direction by components as bytes, and its diffuse coefficient in each channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Light {
    /// [`component`]s of the unit vector towards it.
    pub direction: [u8; 3],
    /// Diffuse coefficient times the light's colour.
    pub diffuse: [u8; 3],
}

impl Light {
    /// The scalar product with a normal, at least 0, to nearest. A normal between voxels is shorter than 1, and stays so.
    pub fn on(&self, normal: [u8; 3]) -> u8 {
        let terms = self.direction.into_iter().zip(normal);
        let sum: i32 = terms.map(|(l, n)| (i32::from(l) - 128) * (i32::from(n) - 128)).sum();
        // Of 127^2; at most three times 127 * 128.
        ((255 * sum.max(0) + 127 * 127 / 2) / (127 * 127)).min(255) as u8
    }
}

/// Ambient and diffuse light; there is no specular light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lights {
    /// Ambient coefficient.
    pub ambient: u8,
    /// The lights.
    pub lights: Vec<Light>,
}

impl Lights {
    /// A colour under the lights: their sum is held to 255.
    pub fn shade(&self, product: Product, normal: [u8; 3], colour: [u8; 3]) -> [u8; 3] {
        let mut sums = [self.ambient; 3];
        for light in &self.lights {
            let cosine = light.on(normal);
            for (sum, diffuse) in sums.iter_mut().zip(light.diffuse) {
                *sum = sum.saturating_add(product.of(diffuse, cosine));
            }
        }
        [0, 1, 2].map(|c| product.of(colour[c], sums[c]))
    }
}

/// A pixel of the frame buffer, red, green, blue and transparency, with a sample of a weighted colour and an opacity behind it
/// (Squeeze, equation 4).
pub fn over(product: Product, [r, g, b, t]: Bytes, [red, green, blue, alpha]: Bytes) -> Bytes {
    let behind = |sum: u8, colour| sum.saturating_add(product.of(colour, t));
    [
        behind(r, red),
        behind(g, green),
        behind(b, blue),
        product.of(t, 255 - alpha),
    ]
}

/// The same with the sample in front (equation 6).
pub fn under(product: Product, [r, g, b, t]: Bytes, [red, green, blue, alpha]: Bytes) -> Bytes {
    let rest = 255 - alpha;
    let front = |sum, colour: u8| product.of(sum, rest).saturating_add(colour);
    [front(r, red), front(g, green), front(b, blue), product.of(t, rest)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blinns_product_is_the_nearest_and_the_shift_is_not() {
        let mut short = 0;
        for (a, b) in (0..=255u8).flat_map(|a| (0..=255u8).map(move |b| (a, b))) {
            let exact = f64::from(a) * f64::from(b) / 255.0;
            assert_eq!(f64::from(Product::Blinn.of(a, b)), (exact + 0.5).floor(), "{a} {b}");
            let shifted = f64::from(Product::Shift.of(a, b));
            assert!(shifted <= exact && exact - shifted < 2.0, "{a} {b}");
            short += u32::from(shifted + 0.5 < exact);
        }
        assert!(short > 30_000, "{short}");
        assert_eq!((Product::Blinn.of(255, 255), Product::Shift.of(255, 255)), (255, 254));
    }

    /// Squeeze, section 3.
    #[test]
    fn clear_samples_become_opaque_by_the_shift_alone() {
        let clear = |product, order: fn(Product, Bytes, Bytes) -> Bytes| {
            (0..255).fold([0, 0, 0, 255], |pixel, _| order(product, pixel, [0; 4]))
        };
        for order in [over, under] {
            assert_eq!(clear(Product::Blinn, order), [0, 0, 0, 255]);
            assert_eq!(clear(Product::Shift, order), [0, 0, 0, 0]);
        }
        let one_less = (0..254).fold([0, 0, 0, 255], |pixel, _| over(Product::Shift, pixel, [0; 4]));
        assert_eq!(one_less, [0, 0, 0, 1]);
    }

    #[test]
    fn the_filter_is_the_nearest_of_the_exact_mixture() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 24
        };
        for _ in 0..20_000 {
            let texels = [(); 8].map(|()| [(); 4].map(|()| random() as u8));
            let weights = [(); 3].map(|()| random());
            let found = filtered(texels, weights);
            for c in 0..4 {
                let [x, y, z] = weights.map(|w| f64::from(w) / 256.0);
                let mix = |a: f64, b: f64, w: f64| a + (b - a) * w;
                let [a, b, d, e, f, g, h, i] = texels.map(|texel| f64::from(texel[c]));
                let front = mix(mix(a, b, x), mix(d, e, x), y);
                let back = mix(mix(f, g, x), mix(h, i, x), y);
                let exact = mix(front, back, z);
                assert_eq!(f64::from(found[c]), (exact + 0.5).floor(), "{texels:?} {weights:?}");
            }
        }
    }

    #[test]
    fn directions_come_back_at_full_length() {
        assert_eq!(normalised([128; 3]), [128; 3]);
        for n in [[0.6, 0.0, -0.8], [0.48, -0.6, 0.64], [-1.0, 0.0, 0.0], [0.0, 0.8, 0.6]] {
            for length in [0.3, 0.55, 1.0] {
                let short = n.map(|c| component(length * c));
                for (found, c) in normalised(short).into_iter().zip(n) {
                    // Half a unit of each component, over the length, and half of the result's.
                    assert!(
                        (f64::from(found) - 128.0 - 127.0 * c).abs() <= 0.5 + 0.9 / length,
                        "{n:?} {length}"
                    );
                }
            }
        }
    }

    #[test]
    fn light_falls_on_one_side() {
        let light = Light {
            direction: [0.6, 0.0, 0.8].map(component),
            diffuse: [255, 128, 0],
        };
        let on = |n: [f64; 3]| light.on(n.map(component));
        assert_eq!(on([0.0; 3]), 0);
        assert_eq!(on([-0.6, 0.0, -0.8]), 0);
        assert_eq!(on([0.0, 1.0, 0.0]), 0);
        assert!((254..=255).contains(&on([0.6, 0.0, 0.8])));
        let lights = Lights {
            ambient: 51,
            lights: vec![light],
        };
        let lit = |n: [f64; 3]| lights.shade(Product::Blinn, n.map(component), [255; 3]);
        assert_eq!(lit([0.0; 3]), [51; 3]);
        let [red, green, blue] = lit([0.6, 0.0, 0.8]);
        assert_eq!((red, blue), (255, 51));
        assert!((178..=179).contains(&green));
    }
}
