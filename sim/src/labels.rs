//! The labels of a volume that holds labels instead of measurements, and a colour for each.
//!
//! A label has the same colour in every volume (a low-discrepancy walk through OKLCh by the label's number), unless it
//! touches a label that looks like it: then the walk goes on until it finds a colour that those around can be told from.

use std::collections::HashSet;

use slicecast_engine::error::RenderError;
use slicecast_engine::source::{AT_A_TIME, Source, each_slice};
use slicecast_scene::TransferFunction;
use slicecast_volume::open::Loaded;
use slicecast_volume::statistics::Statistics;

/// A label.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Label {
    /// The code that its voxels have.
    pub code: u16,
    /// The number that the file has for it.
    pub label: f64,
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// How many voxels have it.
    pub voxels: u64,
}

/// Distance in OKLab from which on colours are told apart at a glance. Tests of just noticeable differences find a tenth.
const APART: f64 = 0.15;

/// Colours that are looked at for a label; then the best of them is taken.
const TRIES: u64 = 256;

/// Codes of a volume.
const CODES: usize = 4096;

/// The labels of a volume, from the least code up, without the background, which is the least.
///
/// # Errors
/// [`RenderError::Read`] if a file that the voxels come from cannot be read.
pub fn labels(loaded: &Loaded, statistics: &Statistics, source: &dyn Source) -> Result<Vec<Label>, RenderError> {
    let mut labels = listed(loaded, statistics, |_| [0; 3]);
    let touching = touching(loaded.volume.dims, source, &labels)?;
    colour(&mut labels, &touching);
    Ok(labels)
}

/// The same labels in the colours that a transfer function has for them.
pub fn shown(loaded: &Loaded, statistics: &Statistics, transfer: &TransferFunction) -> Vec<Label> {
    listed(loaded, statistics, |code| {
        let (colour, _) = transfer.evaluate(loaded.volume.mapping.value(f64::from(code)));
        colour.map(|channel| (channel * 255.0).round() as u8)
    })
}

/// The labels of a volume, coloured by their codes.
fn listed(loaded: &Loaded, statistics: &Statistics, colour: impl Fn(u16) -> [u8; 3]) -> Vec<Label> {
    let occurring = statistics.counts().iter().enumerate().filter(|(_, count)| **count > 0);
    let label = |(code, &voxels): (usize, &u64)| {
        let code = code as u16;
        Label {
            code,
            label: loaded.value(code),
            colour: colour(code),
            voxels,
        }
    };
    occurring.skip(1).map(label).collect()
}

/// Gives every label a colour; `touching` has for each label the places of those before it that it touches.
fn colour(labels: &mut [Label], touching: &[Vec<usize>]) {
    let mut given: Vec<[f64; 3]> = Vec::with_capacity(labels.len());
    let mut taken = HashSet::new();
    for (label, neighbours) in labels.iter_mut().zip(touching) {
        let start = label.label.abs() as u64;
        let apart = |colour: [u8; 3]| {
            let lab = oklab(colour);
            let nearest = neighbours.iter().map(|&place| distance(lab, given[place]));
            nearest.fold(f64::INFINITY, f64::min)
        };
        let mut best = ([0; 3], f64::NEG_INFINITY);
        for step in 0.. {
            // The walk goes on far from the labels that are likely to be near in number.
            let candidate = walk(start + step * CODES as u64);
            if taken.contains(&candidate) {
                continue;
            }
            let distance = apart(candidate);
            if distance > best.1 {
                best = (candidate, distance);
            }
            if distance >= APART || step >= TRIES {
                break;
            }
        }
        label.colour = best.0;
        taken.insert(label.colour);
        given.push(oklab(label.colour));
    }
}

/// For each label the places of those before it that have a voxel beside one of its own.
fn touching(dims: [usize; 3], source: &dyn Source, labels: &[Label]) -> Result<Vec<Vec<usize>>, RenderError> {
    let mut places = [usize::MAX; CODES];
    for (place, label) in labels.iter().enumerate() {
        places[usize::from(label.code)] = place;
    }
    let place = |code: u16| places.get(usize::from(code)).copied().unwrap_or(usize::MAX);
    let mut met = vec![false; labels.len() * labels.len()];
    let mut meet = |a: u16, b: u16| {
        if a != b {
            let (a, b) = (place(a), place(b));
            let (first, second) = (a.min(b), a.max(b));
            if second != usize::MAX {
                met[second * labels.len() + first] = true;
            }
        }
    };
    let [nx, ny, _] = dims;
    let mut before = Vec::with_capacity(nx * ny);
    each_slice(source, dims, AT_A_TIME, &mut |slice| {
        for row in slice.chunks_exact(nx.max(1)) {
            row.windows(2).for_each(|pair| meet(pair[0], pair[1]));
        }
        slice.iter().zip(slice.iter().skip(nx)).for_each(|(a, b)| meet(*a, *b));
        slice.iter().zip(&before).for_each(|(a, b)| meet(*a, *b));
        before.clear();
        before.extend_from_slice(slice);
    })?;
    let before = |row: &[bool]| {
        row.iter()
            .enumerate()
            .filter_map(|(place, met)| met.then_some(place))
            .collect()
    };
    Ok(met.chunks_exact(labels.len().max(1)).map(before).collect())
}

/// A colour of the walk: hue, lightness and chroma by the additive recurrence of the third root of the plastic numbers
/// (Roberts 2018), whose steps are as far apart as three dimensions allow.
fn walk(step: u64) -> [u8; 3] {
    let turn = |share: f64| (0.5 + share * step as f64).fract();
    let hue = turn(0.819_172_513_396_164_4) * std::f64::consts::TAU;
    let lightness = 0.50 + 0.42 * turn(0.671_043_606_703_789_2);
    let chroma = 0.08 + 0.12 * turn(0.549_700_477_901_970_3);
    from_oklab([lightness, chroma * hue.cos(), chroma * hue.sin()])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn product(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// OKLab (Ottosson 2020) of an sRGB colour.
fn oklab(colour: [u8; 3]) -> [f64; 3] {
    let linear = colour.map(|c| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    });
    let cones = product(
        [
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ],
        linear,
    );
    product(
        [
            [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
            [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
        ],
        cones.map(f64::cbrt),
    )
}

/// The sRGB colour of OKLab coordinates; what sRGB does not have is cut off.
fn from_oklab(lab: [f64; 3]) -> [u8; 3] {
    let cones = product(
        [
            [1.0, 0.396_337_777_4, 0.215_803_757_3],
            [1.0, -0.105_561_345_8, -0.063_854_172_8],
            [1.0, -0.089_484_177_5, -1.291_485_548_0],
        ],
        lab,
    );
    let linear = product(
        [
            [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
            [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
            [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0],
        ],
        cones.map(|c| c * c * c),
    );
    linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_volume::decoded::Decoded;
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::prepare;
    use slicecast_volume::values::Values;

    fn loaded(dims: [usize; 3], values: Vec<u16>) -> Loaded {
        let decoded = Decoded::new("t".into(), dims, [1.0; 3], Values::U16(values)).unwrap();
        prepare(&decoded, Window::Auto).unwrap()
    }

    fn labelled(loaded: &Loaded) -> Vec<Label> {
        labels(loaded, &Statistics::of(&loaded.volume), &loaded.volume).unwrap()
    }

    #[test]
    fn colours_go_there_and_back() {
        for colour in [[0; 3], [255; 3], [255, 0, 0], [3, 100, 200], [77, 255, 1]] {
            assert_eq!(from_oklab(oklab(colour)), colour);
        }
        // Published by Ottosson: white is (1, 0, 0).
        assert!(distance(oklab([255; 3]), [1.0, 0.0, 0.0]) < 1e-6);
    }

    /// Every code of 12 bits as a label in a cube where all touch others; the background is the least.
    #[test]
    fn four_thousand_labels_are_told_from_those_they_touch() {
        let loaded = loaded([16; 3], (0..4096).map(|i| (i * 1721 % 4096) as u16).collect());
        let labels = labelled(&loaded);
        assert_eq!((labels.len(), labels[0].code, labels[0].label), (4095, 1, 1.0));
        let colours: HashSet<[u8; 3]> = labels.iter().map(|label| label.colour).collect();
        assert_eq!(colours.len(), 4095);
        let mut least = f64::INFINITY;
        for (label, touched) in labels
            .iter()
            .zip(touching(loaded.volume.dims, &loaded.volume, &labels).unwrap())
        {
            for place in touched {
                least = least.min(distance(oklab(label.colour), oklab(labels[place].colour)));
            }
        }
        assert!(least >= APART, "{least}");
    }

    #[test]
    fn a_label_has_the_same_colour_in_other_volumes() {
        let alone = loaded([3, 1, 1], vec![0, 4, 0]);
        let among = loaded([7, 1, 1], vec![0, 1, 2, 0, 4, 0, 5]);
        let renumbered = loaded([7, 1, 1], vec![0, 1, 2, 0, 4, 0, 50_000]);
        let found = |loaded: &Loaded| {
            let labels = labelled(loaded);
            labels.iter().find(|label| label.label == 4.0).map(|label| label.colour)
        };
        assert!(found(&alone).is_some());
        assert_eq!(found(&alone), found(&among));
        assert_eq!(found(&alone), found(&renumbered));
    }

    #[test]
    fn labels_that_codes_count_keep_their_numbers_and_show_their_colours() {
        let loaded = loaded([6, 1, 1], vec![0, 0, 0, 7, 5000, 60_000]);
        let statistics = Statistics::of(&loaded.volume);
        let labels = labels(&loaded, &statistics, &loaded.volume).unwrap();
        let named: Vec<(u16, f64)> = labels.iter().map(|label| (label.code, label.label)).collect();
        assert_eq!(named, [(1, 7.0), (2, 5000.0), (3, 60_000.0)]);
        let scene = crate::presets::scene("labels", &loaded, &statistics, &loaded.volume).unwrap();
        assert_eq!(shown(&loaded, &statistics, &scene.transfer), labels);
    }

    #[test]
    fn voxels_touch_along_all_three_axes() {
        let loaded = loaded([2, 2, 2], vec![1, 2, 3, 0, 5, 0, 0, 0]);
        let touched = touching([2; 3], &loaded.volume, &labelled(&loaded)).unwrap();
        assert_eq!(touched, [vec![], vec![0], vec![0], vec![0]]);
        assert!(touching([2; 3], &loaded.volume, &[]).unwrap().is_empty());
    }

    #[test]
    fn labels_that_follow_each_other_differ() {
        for step in 0..4096 {
            let distance = distance(oklab(walk(step)), oklab(walk(step + 1)));
            assert!(distance > 0.1, "{step}: {distance}");
        }
    }
}
