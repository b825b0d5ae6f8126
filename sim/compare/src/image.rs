//! Errors of pictures, in steps of 8-bit output.

use serde::{Deserialize, Serialize};

use slicecast_engine::image::{BaseImage, Rgb};
use slicecast_model::ModelImage;

/// How far a picture is from the model's, over red, green and blue of the pixels that anything contributes to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageFigures {
    /// Values compared.
    pub values: u64,
    /// Largest difference, steps of 1/255.
    pub max_lsb8: f64,
    /// Mean absolute difference, steps of 1/255.
    pub mean_lsb8: f64,
    /// Share of values whose 8-bit roundings are equal, percent.
    pub equal_percent: f64,
    /// Peak signal-to-noise ratio of the unrounded values, dB; `None` if there is no difference.
    pub psnr_db: Option<f64>,
}

impl ImageFigures {
    /// The figures of several images' values, all in one.
    pub fn together(images: &[Self]) -> Self {
        let mut sums = Sums::default();
        for image in images {
            let count = image.values as f64;
            sums.values += image.values;
            sums.max = sums.max.max(image.max_lsb8);
            sums.sum += image.mean_lsb8 * count;
            sums.squares += image
                .psnr_db
                .map_or(0.0, |db| 255.0 * 255.0 * count / 10f64.powf(db / 10.0));
            sums.equal += (image.equal_percent / 100.0 * count).round() as u64;
        }
        match images {
            // To the last bit.
            [image] => *image,
            _ => sums.figures(),
        }
    }
}

#[derive(Default)]
struct Sums {
    values: u64,
    max: f64,
    sum: f64,
    squares: f64,
    equal: u64,
}

impl Sums {
    /// Two values in steps of 1/255.
    fn add(&mut self, fixed: f64, exact: f64) {
        let difference = (fixed - exact).abs();
        self.values += 1;
        self.max = self.max.max(difference);
        self.sum += difference;
        self.squares += difference * difference;
        self.equal += u64::from((fixed + 0.5).floor() == (exact + 0.5).floor());
    }

    fn figures(&self) -> ImageFigures {
        let count = self.values.max(1) as f64;
        ImageFigures {
            values: self.values,
            max_lsb8: self.max,
            mean_lsb8: self.sum / count,
            equal_percent: 100.0 * (self.equal as f64 + f64::from(u8::from(self.values == 0))) / count,
            psnr_db: (self.squares > 0.0).then(|| 10.0 * (255.0 * 255.0 * count / self.squares).log10()),
        }
    }
}

/// Compares base-plane images: premultiplied colour.
pub fn base_figures(fixed: &BaseImage, model: &ModelImage) -> ImageFigures {
    let one = f64::from(fixed.one);
    let mut sums = Sums::default();
    for index in 0..model.t.len() {
        if model.t[index] == 1.0 && f64::from(fixed.planes[3][index]) == one {
            continue;
        }
        for c in 0..3 {
            let value = f64::from(fixed.planes[c][index]) / one * 255.0;
            sums.add(value, model.rgb[c][index] * 255.0);
        }
    }
    sums.figures()
}

/// Compares two models' base-plane images: premultiplied colour.
pub fn model_figures(first: &ModelImage, second: &ModelImage) -> ImageFigures {
    let mut sums = Sums::default();
    for index in 0..second.t.len() {
        if first.t[index] == 1.0 && second.t[index] == 1.0 {
            continue;
        }
        for c in 0..3 {
            sums.add(first.rgb[c][index] * 255.0, second.rgb[c][index] * 255.0);
        }
    }
    sums.figures()
}

/// Compares the viewer's pictures in front of a background, both as 8-bit values. `model` is warped.
pub fn picture_figures(fixed: &Rgb, model: &ModelImage, background: [f64; 3]) -> ImageFigures {
    let mut sums = Sums::default();
    for (index, pixel) in fixed.bytes.chunks_exact(3).enumerate() {
        if model.t[index] == 1.0
            && pixel
                .iter()
                .zip(background)
                .all(|(p, b)| f64::from(*p) == (b * 255.0).round())
        {
            continue;
        }
        for (c, value) in pixel.iter().enumerate() {
            let exact = (model.rgb[c][index] + model.t[index] * background[c]) * 255.0;
            sums.add(f64::from(*value), (exact + 0.5).floor());
        }
    }
    sums.figures()
}

/// The model's picture as 8-bit values.
pub fn model_picture(model: &ModelImage, background: [f64; 3]) -> Rgb {
    let mut bytes = Vec::with_capacity(model.t.len() * 3);
    for index in 0..model.t.len() {
        for (plane, behind) in model.rgb.iter().zip(background) {
            let value = (plane[index] + model.t[index] * behind) * 255.0;
            bytes.push((value + 0.5).floor().clamp(0.0, 255.0) as u8);
        }
    }
    Rgb {
        size: model.size.map(|side| side as u32),
        bytes,
    }
}

/// A heat map of the largest channel difference of two base-plane images: black for none, then dark red to white up
/// to `full` steps of 1/255 and beyond.
pub fn heat_map(fixed: &BaseImage, model: &ModelImage, full: f64) -> Rgb {
    let one = f64::from(fixed.one);
    let mut bytes = Vec::with_capacity(model.t.len() * 3);
    for index in 0..model.t.len() {
        let error = (0..3)
            .map(|c| (f64::from(fixed.planes[c][index]) / one - model.rgb[c][index]).abs() * 255.0)
            .fold(0.0, f64::max);
        let heat = (error / full).min(1.0);
        let ramp = |from: f64| (((heat * 3.0 - from).clamp(0.0, 1.0)) * 255.0).round() as u8;
        bytes.extend([ramp(0.0), ramp(1.0), ramp(2.0)]);
    }
    Rgb {
        size: model.size.map(|side| side as u32),
        bytes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_together_are_their_values_together() {
        let sums = |values: &[(f64, f64)]| {
            let mut sums = Sums::default();
            values.iter().for_each(|(fixed, exact)| sums.add(*fixed, *exact));
            sums.figures()
        };
        let values = [(1.0, 1.25), (7.0, 6.0), (3.5, 3.25), (9.0, 9.0), (100.0, 103.0)];
        let whole = sums(&values);
        let parts = ImageFigures::together(&[sums(&values[..2]), sums(&values[2..4]), sums(&values[4..])]);
        assert_eq!(
            (parts.values, parts.max_lsb8, parts.equal_percent),
            (whole.values, whole.max_lsb8, whole.equal_percent)
        );
        assert!((parts.mean_lsb8 - whole.mean_lsb8).abs() < 1e-12);
        assert!((parts.psnr_db.unwrap() - whole.psnr_db.unwrap()).abs() < 1e-9);
    }
}
