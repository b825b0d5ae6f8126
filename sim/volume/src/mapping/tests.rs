//! Each rule of the table, rounding, clipping, refusals.

use super::*;
use crate::meaning::Modality;

fn map_auto(values: Values) -> (Volume, MappingReport) {
    map_in(values, Window::Auto, 0).unwrap()
}

fn map_in(values: Values, window: Window, offset: i32) -> Result<(Volume, MappingReport), MappingError> {
    let least_rows = values.len().div_ceil(8192);
    let rows = (least_rows..).find(|rows| values.len().is_multiple_of(*rows)).unwrap();
    let dims = [values.len() / rows, rows, 1];
    let decoded = Decoded::new("test".into(), dims, [1.0; 3], values)
        .unwrap()
        .with_value_offset(offset);
    map(&decoded, window).map(|mapped| (mapped.volume, mapped.report))
}

/// Codes, scale, offset of an automatic mapping that must lose nothing.
fn lossless(values: Values) -> (Vec<u16>, f64, f64) {
    let (volume, report) = map_auto(values);
    assert!(report.lossless, "{report}");
    assert_eq!((report.max_rounding_error, report.bits_lost), (0.0, Some(0.0)));
    assert_eq!((report.clipped_low, report.clipped_high), (0, 0));
    (volume.voxels, volume.mapping.scale, volume.mapping.offset)
}

#[test]
fn integers_that_fit_are_only_shifted() {
    assert_eq!(lossless(Values::U16(vec![0, 4095])), (vec![0, 4095], 1.0, 0.0));
    assert_eq!(lossless(Values::I16(vec![5, 7])), (vec![5, 7], 1.0, 0.0));
    assert_eq!(lossless(Values::I16(vec![-1024, 3071])), (vec![0, 4095], 1.0, -1024.0));
    assert_eq!(lossless(Values::I16(vec![-1, 0])), (vec![1023, 1024], 1.0, -1024.0));
    assert_eq!(lossless(Values::I16(vec![-1025, 3070])), (vec![0, 4095], 1.0, -1025.0));
    assert_eq!(lossless(Values::U16(vec![61440, 65535])), (vec![0, 4095], 1.0, 61440.0));
    assert_eq!(
        lossless(Values::I32(vec![i32::MIN])),
        (vec![0], 1.0, f64::from(i32::MIN))
    );
}

#[test]
fn bytes_fill_the_codes() {
    assert_eq!(
        lossless(Values::U8(vec![0, 1, 255])),
        (vec![0, 16, 4080], 1.0 / 16.0, 0.0)
    );
    assert_eq!(
        lossless(Values::I8(vec![-128, 0, 127])),
        (vec![0, 2048, 4080], 1.0 / 16.0, -128.0)
    );
}

#[test]
fn wide_integers_lose_the_stated_bits() {
    let (volume, report) = map_auto(Values::U16((0..=u16::MAX).collect()));
    assert_eq!((volume.voxels[0], volume.voxels[65535]), (0, 4095));
    assert_eq!(report.bits_lost, Some(4.0));
    assert!(!report.lossless);
    let half_code = 65535.0 / 4095.0 / 2.0;
    assert!(report.max_rounding_error > half_code - 0.51 && report.max_rounding_error <= half_code);
    let text = report.to_string();
    assert!(text.contains("4.0 bits lost") && text.lines().count() == 2, "{text}");
    // One value too many for the codes.
    let (_, report) = map_auto(Values::U16((0..=4096).collect()));
    assert!(!report.lossless && report.bits_lost > Some(0.0) && report.bits_lost < Some(0.001));
}

#[test]
fn floats_fill_the_codes_and_round_half_up() {
    let (volume, report) = map_auto(Values::F64(vec![-1.0, 4094.0, 0.0, 0.5, 0.49, 1.5]));
    assert_eq!(volume.voxels, [0, 4095, 1, 2, 1, 3]);
    assert_eq!((report.bits_lost, report.max_rounding_error), (None, 0.5));
    let (volume, report) = map_auto(Values::F32(vec![2.5; 3]));
    assert_eq!(
        (volume.voxels, volume.mapping.offset, report.lossless),
        (vec![0; 3], 2.5, true)
    );
}

#[test]
fn ranges_that_cannot_be_divided_are_refused() {
    let wide = map_in(Values::F64(vec![f64::MIN, f64::MAX]), Window::Auto, 0);
    assert_eq!(
        wide.unwrap_err(),
        MappingError::Range {
            low: f64::MIN,
            high: f64::MAX
        }
    );
    assert!(map_in(Values::F64(vec![0.0, f64::MIN_POSITIVE]), Window::Auto, 0).is_err());
    assert!(map_in(Values::F64(vec![1e12, -1e12, 0.5]), Window::Auto, 0).is_ok());
    // Long integers are whole, and still beyond what a scene can speak of.
    let wide = map_in(Values::F64(vec![0.0, 18_446_744_073_709_551_615.0]), Window::Auto, 0).unwrap_err();
    assert_eq!(
        wide.to_string(),
        "values from 0 to 18446744073709552000 cannot be divided into 4096 codes, expected a range of at least 1e-290 \
         within -1e12 to 1e12"
    );
    let same = map_in(Values::F64(vec![2e12; 2]), Window::Auto, 0);
    assert!(matches!(same, Err(MappingError::Range { .. })));
    for (low, high) in [
        (0.0, 0.0),
        (1.0, 0.0),
        (f64::NAN, 1.0),
        (0.0, f64::INFINITY),
        (f64::MIN, f64::MAX),
        (0.0, 2e12),
    ] {
        let result = map_in(Values::U8(vec![0]), Window::Range { low, high }, 0);
        assert!(matches!(result, Err(MappingError::Window { .. })), "{low} {high}");
    }
}

#[test]
fn a_stated_window_clips_and_counts() {
    let window = Window::Range {
        low: 0.0,
        high: 4095.0 / 16.0,
    };
    let (volume, report) = map_in(Values::I16(vec![-5, -1, 0, 255, 256, 300, 301]), window, 0).unwrap();
    assert_eq!(volume.voxels, [0, 0, 0, 4080, 4095, 4095, 4095]);
    assert_eq!(
        (report.clipped_low, report.clipped_high, report.lossless),
        (2, 3, false)
    );
    assert!(report.to_string().contains("clipped 2 voxels below and 3 above"));
    let window = Window::Range {
        low: -1000.0,
        high: 3095.0,
    };
    let (volume, report) = map_in(Values::U16(vec![23, 24, 1024, 4119]), window, -1024).unwrap();
    assert_eq!(volume.voxels, [0, 0, 1000, 4095]);
    assert_eq!((report.clipped_low, report.range), (1, [-1001.0, 3095.0]));
}

#[test]
fn a_value_offset_changes_the_unit_and_no_code() {
    let (volume, report) = map_in(Values::U16(vec![0, 1024, 3926]), Window::Auto, -1024).unwrap();
    assert_eq!(volume.voxels, [0, 1024, 3926]);
    assert_eq!((volume.mapping.scale, volume.mapping.offset), (1.0, -1024.0));
    assert_eq!((report.range, report.window), ([-1024.0, 2902.0], [-1024.0, 3071.0]));
}

/// A head of 40 x 44 x 32 in noise, 0 to 611, and `hot` in one voxel.
fn head(hot: Option<f64>) -> Vec<f64> {
    let mut state = 1_u32;
    let mut values: Vec<f64> = (0..40 * 44 * 32)
        .map(|index| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let inside = index % 44 > 10 && index % 44 < 35;
            f64::from(state >> 24) + if inside { 356.0 } else { 0.0 }
        })
        .collect();
    if let Some(hot) = hot {
        values[20_000] = hot;
    }
    values
}

#[test]
fn a_hot_voxel_does_not_decide_the_mapping() {
    let (plain, _) = map_auto(Values::I16(head(None).iter().map(|&v| v as i16).collect()));
    let (hot, report) = map_auto(Values::I16(head(Some(32767.0)).iter().map(|&v| v as i16).collect()));
    let differing = plain.voxels.iter().zip(&hot.voxels).filter(|(a, b)| a != b).count();
    assert_eq!((differing, hot.voxels[20_000], hot.mapping), (1, 4095, plain.mapping));
    assert_eq!((report.clipped_low, report.clipped_high, report.outliers), (0, 1, true));
    assert_eq!((report.range, report.window), ([0.0, 32767.0], [0.0, 4095.0]));
    assert!(
        report
            .to_string()
            .contains("clipped 0 voxels below and 1 above (outliers, "),
        "{report}"
    );
    // Floats with a fraction, at either end.
    let third = |values: Vec<f64>| Values::F32(values.iter().map(|&v| (v / 3.0) as f32).collect());
    let (plain, plain_report) = map_auto(third(head(None)));
    for (value, counts) in [(1e6, (0, 1)), (-1e6, (1, 0))] {
        let (hot, report) = map_auto(third(head(Some(value))));
        assert_eq!((report.clipped_low, report.clipped_high), counts);
        assert_eq!((hot.mapping, report.window), (plain.mapping, plain_report.window));
    }
}

#[test]
fn a_thin_tail_of_signal_is_kept() {
    // Vessels: 0.1 % of the voxels, up to five times as bright as the rest; and a single voxel at twice the range.
    let mut values: Vec<f32> = head(None).iter().map(|&v| v as f32 + 0.5).collect();
    for index in 0..56 {
        values[index * 1000] = 611.0 + 44.25 * index as f32;
    }
    let (volume, report) = map_auto(Values::F32(values.clone()));
    assert_eq!(
        (report.clipped_low, report.clipped_high, report.outliers),
        (0, 0, false),
        "{report}"
    );
    assert_eq!(volume.voxels[55_000], 4095);
    let mut single: Vec<f32> = head(None).iter().map(|&v| v as f32 + 0.5).collect();
    single[9] = 1800.0;
    assert_eq!(map_auto(Values::F32(single)).1.clipped_high, 0);
    // In a few voxels none is an exception.
    assert_eq!(
        map_auto(Values::F32([vec![0.5; 500], vec![0.0; 498], vec![1e6]].concat()))
            .1
            .clipped_high,
        0
    );
    // Points in an empty volume are the data, however few.
    let mut points = vec![0.25_f32; 50_000];
    points[7] = 1e6;
    assert_eq!(map_auto(Values::F32(points)).1.clipped_high, 0);
}

#[test]
fn whole_floats_are_integers() {
    assert_eq!(lossless(Values::F32(vec![24.0, 2424.0])), (vec![24, 2424], 1.0, 0.0));
    assert_eq!(
        lossless(Values::F64(vec![-1000.0, 1400.0])),
        (vec![24, 2424], 1.0, -1024.0)
    );
}

/// Blocks of labels in a background of zeros: runs of 4 along x.
fn blocks(labels: &[f64]) -> Vec<f64> {
    let runs = labels.iter().flat_map(|&label| [0.0, 0.0, label, label, label, label]);
    runs.collect()
}

fn mapped(values: Values, width: usize) -> Mapped {
    mapped_by(values, width, Window::Auto)
}

fn mapped_by(values: Values, width: usize, window: Window) -> Mapped {
    let dims = [width, values.len() / width, 1];
    map(&Decoded::new("t".into(), dims, [1.0; 3], values).unwrap(), window).unwrap()
}

#[test]
fn labels_above_the_codes_are_renumbered() {
    let names: Vec<f64> = (0..98).map(|i| 11_000.0 + 7.0 * f64::from(i)).collect();
    let stored = blocks(&names);
    for values in [
        Values::I32(stored.iter().map(|&v| v as i32).collect()),
        Values::U16(stored.iter().map(|&v| v as u16).collect()),
        Values::F32(stored.iter().map(|&v| v as f32).collect()),
        Values::F64(stored.clone()),
    ] {
        let mapped = mapped(values, 12);
        let labels = mapped.labels.unwrap();
        assert!(labels.renumbered());
        assert_eq!(mapped.report.labels, Some(99));
        let text = mapped.report.to_string();
        assert_eq!(
            text,
            "99 labels from 0 to 11679 renumbered: codes 0 to 98 are the labels in ascending order, without loss"
        );
        for (voxel, &label) in mapped.volume.voxels.iter().zip(&stored) {
            assert_eq!(labels.of(*voxel), Some(label));
        }
        assert_eq!(
            labels.entries()[1],
            Label {
                code: 1,
                value: 11_000.0,
                voxels: 4
            }
        );
        assert_eq!(
            (labels.code_of(11_679.0), labels.code_of(5.0), labels.of(99)),
            (Some(98), None, None)
        );
    }
}

#[test]
fn labels_that_fit_keep_their_codes() {
    let names: Vec<f64> = (1..=98).map(|i| 20.0 * f64::from(i)).collect();
    let stored = blocks(&names);
    let floats = mapped(Values::F32(stored.iter().map(|&v| v as f32).collect()), 12);
    let labels = floats.labels.unwrap();
    assert!(!labels.renumbered() && floats.report.labels.is_none());
    assert_eq!((labels.entries().len(), labels.of(1960)), (99, Some(1960.0)));
    assert_eq!(floats.volume.voxels[3], 20);
    let bytes = mapped(Values::U8(blocks(&[3.0, 7.0]).iter().map(|&v| v as u8).collect()), 12);
    let labels = bytes.labels.unwrap();
    let codes: Vec<(u16, f64)> = labels.entries().iter().map(|label| (label.code, label.value)).collect();
    assert_eq!(codes, [(0, 0.0), (48, 3.0), (112, 7.0)]);
}

/// A window that gives each label a code of its own leaves labels what they are; another one says what it has done.
#[test]
fn labels_under_a_window() {
    let stored = || Values::U16(blocks(&[3.0, 7.0, 5000.0]).iter().map(|&v| v as u16).collect());
    let window = |low, high| mapped_by(stored(), 18, Window::Range { low, high });
    let apart = window(0.0, 8190.0);
    let labels = apart.labels.unwrap();
    let codes: Vec<(u16, f64)> = labels.entries().iter().map(|label| (label.code, label.value)).collect();
    assert_eq!(codes, [(0, 0.0), (2, 3.0), (4, 7.0), (2500, 5000.0)]);
    assert!(!labels.renumbered() && apart.note.is_none());
    assert_eq!(apart.volume.voxels[3], 2);
    // Clipped, merged, without their background.
    for (low, high) in [(0.0, 4095.0), (0.0, 1e6), (1.0, 8191.0)] {
        let other = window(low, high);
        assert!(other.labels.is_none());
        let note = other.note.unwrap();
        assert!(note.contains(&format!("the window {low} to {high} does not")), "{note}");
    }
    let image = mapped_by(
        Values::U16((0..144).collect()),
        12,
        Window::Range { low: 0.0, high: 99.0 },
    );
    assert!(image.labels.is_none() && image.note.is_none());
}

#[test]
fn images_are_no_label_maps() {
    let noise: Vec<f64> = head(None)
        .iter()
        .map(|&v| if v < 200.0 { 0.0 } else { 13.0 * v })
        .collect();
    assert!(
        mapped(Values::U16(noise.iter().map(|&v| v as u16).collect()), 40)
            .labels
            .is_none()
    );
    assert!(
        mapped(Values::F32(noise.iter().map(|&v| v as f32).collect()), 40)
            .labels
            .is_none()
    );
    // Nothing is 0; one value only; a fraction; a modality that measures.
    let names = blocks(&[1.0, 2.0]);
    assert!(
        mapped(Values::I16(names.iter().map(|&v| v as i16 + 1).collect()), 12)
            .labels
            .is_none()
    );
    assert!(mapped(Values::I16(vec![0; 12]), 12).labels.is_none());
    assert!(
        mapped(Values::F32(names.iter().map(|&v| v as f32 / 2.0).collect()), 12)
            .labels
            .is_none()
    );
    let decoded = Decoded::new("t".into(), [12, 1, 1], [1.0; 3], Values::F64(names)).unwrap();
    assert!(map(&decoded, Window::Auto).unwrap().labels.is_some());
    let mr = decoded.with_modality(Some(Modality::Mr));
    assert!(map(&mr, Window::Auto).unwrap().labels.is_none());
}
