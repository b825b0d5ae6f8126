//! Compositing: folding the samples of a ray into a pixel.
//!
//! Source: paper, section 4.1: equation 4 (front to back) and equation 6 (back to front), on opacity-weighted
//! colour and transparency.

/// An opacity-weighted colour and the transparency behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// C: red, green, blue, already multiplied by opacity; 0 to 1 - T.
    pub colour: [f64; 3],
    /// T: the fraction of light from behind that passes, 0 to 1.
    pub transparency: f64,
}

impl Pixel {
    /// Nothing at all: C = 0, T = 1.
    pub const TRANSPARENT: Self = Self {
        colour: [0.0; 3],
        transparency: 1.0,
    };

    /// A single sample of a colour c and an opacity a: C = c a, T = 1 - a.
    pub fn of_sample(colour: [f64; 3], opacity: f64) -> Self {
        Self {
            colour: colour.map(|c| c * opacity),
            transparency: 1.0 - opacity,
        }
    }

    /// The pixel with a sample *behind* it (paper, equation 4, front to back): `C += T a c`, `T *= 1 - a`.
    pub fn front_to_back(self, colour: [f64; 3], opacity: f64) -> Self {
        let weight = self.transparency * opacity;
        Self {
            colour: [0, 1, 2].map(|i| self.colour[i] + weight * colour[i]),
            transparency: self.transparency * (1.0 - opacity),
        }
    }

    /// The pixel with a sample *in front of* it (paper, equation 6, back to front): `C = C (1 - a) + a c`,
    /// `T *= 1 - a`.
    pub fn back_to_front(self, colour: [f64; 3], opacity: f64) -> Self {
        Self {
            colour: [0, 1, 2].map(|i| self.colour[i] * (1.0 - opacity) + colour[i] * opacity),
            transparency: self.transparency * (1.0 - opacity),
        }
    }

    /// What the viewer sees before a background: `C + T background`.
    pub fn on(self, background: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.colour[i] + self.transparency * background[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::close;

    /// Cases of the numeric study's section 6, K: white fog.
    #[test]
    fn white_fog() {
        for (exponent, samples, colour, transparency) in [
            (8, 1024, 0.981_827_265, 0.018_172_735),
            (10, 1024, 0.632_300_261, 0.367_699_739),
            (14, 1024, 0.060_588_729, 0.939_411_271),
            (16, 1024, 0.015_503_680, 0.984_496_320),
            (12, 4096, 0.632_165_471, 0.367_834_529),
        ] {
            let a = 2.0_f64.powi(-exponent);
            let mut front = Pixel::TRANSPARENT;
            let mut back = Pixel::TRANSPARENT;
            for _ in 0..samples {
                front = front.front_to_back([1.0; 3], a);
                back = back.back_to_front([1.0; 3], a);
            }
            for pixel in [front, back] {
                assert!((pixel.transparency - transparency).abs() < 5.1e-10, "{pixel:?}");
                close(pixel.colour, [colour; 3], 5.1e-10);
                assert!((pixel.colour[0] + pixel.transparency - 1.0).abs() < 1e-12);
            }
        }
        // Fog on odd planes only, 2^-15, 4096 planes.
        let mut pixel = Pixel::TRANSPARENT;
        for k in 0..4096 {
            pixel = pixel.front_to_back([1.0; 3], if k % 2 == 1 { 2.0_f64.powi(-15) } else { 0.0 });
        }
        assert!((pixel.transparency - 0.939_412_167).abs() < 5.1e-10);
    }

    #[test]
    fn opaque_and_transparent_samples() {
        let pixel = Pixel::TRANSPARENT.front_to_back([0.2, 0.4, 0.6], 1.0);
        assert_eq!(pixel, Pixel::of_sample([0.2, 0.4, 0.6], 1.0));
        assert_eq!(pixel.front_to_back([1.0; 3], 1.0), pixel);
        assert_eq!(pixel.front_to_back([1.0; 3], 0.0), pixel);
        assert_eq!(pixel.back_to_front([1.0; 3], 0.0), pixel);
        assert_eq!(pixel.back_to_front([1.0; 3], 1.0), Pixel::of_sample([1.0; 3], 1.0));
    }

    #[test]
    fn two_layers_and_a_background() {
        // Red a quarter before green a half before white: 0.25 red, 0.75 * 0.5 green, the rest white.
        let pixel = Pixel::TRANSPARENT
            .front_to_back([1.0, 0.0, 0.0], 0.25)
            .front_to_back([0.0, 1.0, 0.0], 0.5);
        assert_eq!((pixel.colour, pixel.transparency), ([0.25, 0.375, 0.0], 0.375));
        assert_eq!(pixel.on([1.0; 3]), [0.625, 0.75, 0.375]);
        let swapped = Pixel::TRANSPARENT
            .back_to_front([0.0, 1.0, 0.0], 0.5)
            .back_to_front([1.0, 0.0, 0.0], 0.25);
        assert_eq!(swapped, pixel);
    }
}
