//! Each rule of the table, rounding, clipping, refusals.

use super::*;

fn map_auto(values: Values) -> (Volume, MappingReport) {
    map_in(values, Window::Auto, 0).unwrap()
}

fn map_in(values: Values, window: Window, offset: i32) -> Result<(Volume, MappingReport), MappingError> {
    let rows = values.len().div_ceil(8192);
    let dims = [values.len() / rows, rows, 1];
    let decoded = Decoded::new("test".into(), dims, [1.0; 3], values)
        .unwrap()
        .with_value_offset(offset);
    map(&decoded, window)
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
    assert!(map_in(Values::F64(vec![1e299, -1e299]), Window::Auto, 0).is_ok());
    for (low, high) in [
        (0.0, 0.0),
        (1.0, 0.0),
        (f64::NAN, 1.0),
        (0.0, f64::INFINITY),
        (f64::MIN, f64::MAX),
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
