//! Rays of fog: thin over many samples, in every width and rounding; periodic against the dither; long and empty before
//! a wall.

use slicecast::composite::{Channel as _, Dither, Pixel, Recurrence, settle};
use slicecast::format::Opacity;
use slicecast::precision::{Compact, Paper, Precision, Wide};

use super::{Case, Size};
use crate::channels::Scale::{self, Binary, Carrying, Full};
use crate::pixels::Arithmetic::{self, Dithered, Product, Telescoping};
use crate::pixels::StudyPixel;

const TRUNCATED: Arithmetic = Product { rounded: false };
const ROUNDED: Arithmetic = Product { rounded: true };

/// A pixel that there is.
fn study(arithmetic: Arithmetic, scale: Scale) -> StudyPixel {
    StudyPixel::new(arithmetic, scale).expect("a format that the arithmetic has")
}

/// A ray: opacity (1.31) of plane k; all samples are white.
type Fog<'a> = &'a dyn Fn(u32) -> u32;

/// Accumulated opacity, percent, by the recurrence's own definition.
fn blocked<R: Recurrence>(r: R, samples: u32, fog: Fog<'_>) -> f64 {
    100.0 - 100.0 * value(r, ray(r, samples, fog).transparency, u32::MAX)
}

/// The same of a study, by the bits that make its picture.
fn shown(pixel: StudyPixel, samples: u32, fog: Fog<'_>) -> f64 {
    let left = ray(pixel, samples, fog).transparency;
    100.0 - 100.0 * value(pixel, left, pixel.scale().shown())
}

fn value<R: Recurrence>(r: R, channel: R::Channel, shown: u32) -> f64 {
    f64::from(channel.bits() & shown) / f64::from(r.one().bits())
}

fn ray<R: Recurrence>(r: R, samples: u32, fog: Fog<'_>) -> Pixel<R::Channel> {
    let white = [1u32 << r.colour_bits(); 3];
    (0..samples).fold(r.clear(), |pixel, k| {
        let mut out = r.over(pixel, white, Opacity::from_bits(fog(k)), Dither::of_plane(k));
        out.transparency = settle(out.transparency, r.floor());
        out
    })
}

/// What is blocked in the end, in f64.
fn exact(samples: u32, fog: Fog<'_>) -> f64 {
    let left: f64 = (0..samples).map(|k| (-f64::from(fog(k)) / 2147483648.0).ln_1p()).sum();
    -100.0 * left.exp_m1()
}

/// The schemes of 1.F that this many fraction bits have room for.
fn schemes(case: &mut Case, bits: u32, samples: u32, fog: Fog<'_>) {
    let schemes = [
        (TRUNCATED, Binary(bits), "truncated"),
        (ROUNDED, Binary(bits), "rounded"),
        (Telescoping { rounded: false }, Binary(bits), "telescoping"),
        (Dithered, Binary(bits), "dithered"),
    ];
    for (arithmetic, scale, name) in schemes {
        if let Some(pixel) = StudyPixel::new(arithmetic, scale) {
            case.outcome(format!("1.{bits} {name}"), shown(pixel, samples, fog), None);
        }
    }
}

/// Half a step of 1/255 in percent: what an 8-bit picture can show.
const HALF_STEP: f64 = 50.0 / 255.0;

/// White fog of 2^-bits per sample.
fn thin_fog(bits: u32, samples: u32) -> Case {
    let fog = |_: u32| 1u32 << (31 - bits);
    let theory = format!("1 - (1 - 2^-{bits})^{samples}");
    let name = format!("2^-{bits} x {samples}");
    let mut case = Case::new("thin fog", name, "opacity, %", exact(samples, &fog), theory);
    case.outcome("paper", blocked(Paper.pixel(), samples, &fog), None);
    // The dither's errors are bounded by measurement only: 0.61 of a step of 1/255 over 8192 samples in 1.15 (study),
    // half of that on the scale of 65535, here allowed for the longest rays as well.
    case.outcome(
        "compact",
        blocked(Compact.pixel(), samples, &fog),
        Some(0.61 * HALF_STEP),
    );
    // N floors of 2^-31, and the floor of 2^-20.
    let wide = 100.0 * (f64::from(samples) * 2f64.powi(-31) + 2f64.powi(-20));
    case.outcome("wide", blocked(Wide.pixel(), samples, &fog), Some(wide));
    schemes(&mut case, bits, samples, &fog);
    if bits == 16 {
        schemes(&mut case, 23, samples, &fog);
        schemes(&mut case, 31, samples, &fog);
    }
    if let Some(carrying) = StudyPixel::new(Telescoping { rounded: false }, Carrying(bits)) {
        // A rest of 16 bits: what is left of an error is one unit of the value.
        case.outcome(
            format!("1.{bits} residual carry"),
            shown(carrying, samples, &fog),
            Some(100.0 * 2f64.powi(1 - bits as i32)),
        );
    }
    case.outcome(
        "[0, 255] after Blinn",
        shown(study(ROUNDED, Full(8)), samples, &fog),
        None,
    );
    if samples == 1024 {
        let (paper, study, note) = match bits {
            8 => (
                "100",
                "98.18 exact, 100 truncated",
                "the paper's figure is truncation in 1.8",
            ),
            10 => (
                "100",
                "63.23 exact, 100 truncated",
                "the paper's figure is truncation in 1.10",
            ),
            12 => (
                "25",
                "22.12 exact, 25 truncated",
                "the paper's figure is truncation in 1.12",
            ),
            14 => (
                "6.25",
                "6.059 exact, 6.25 truncated",
                "the paper's figure is truncation in 1.14",
            ),
            15 => (
                "3.08",
                "3.077 exact, 3.125 truncated",
                "the paper's figure is the exact one, unlike those before it",
            ),
            _ => (
                "1.7",
                "1.550 exact, 1.5625 truncated",
                "the paper's figure does not reproduce: it would take 1114 to 1124 samples",
            ),
        };
        case.paper = Some(paper.into());
        case.study = Some(study.into());
        case.note = Some(note.into());
    }
    case
}

/// Squeeze, section 4.1.2.2: 1.7 and fog of 1/128 "reaching full opacity after 63 samples".
fn one_part_in_128() -> Case {
    let until = |opaque: &dyn Fn(u32) -> bool| (1..=4096).find(|n| opaque(*n)).map_or(f64::INFINITY, f64::from);
    let fog = |_: u32| 1u32 << 24;
    let mut case = Case::new(
        "thin fog",
        "2^-7 in 1.7 until opaque",
        "samples",
        128.0,
        "truncated, T loses one of its 128 units a sample; exactly, T is 2^-7 after 619 samples and never 0",
    );
    let truncated = until(&|n| ray(study(TRUNCATED, Binary(7)), n, &fog).transparency.bits() == 0);
    let rounded = until(&|n| ray(study(ROUNDED, Binary(7)), n, &fog).transparency.bits() == 0);
    case.outcome("1.7 truncated", truncated, Some(0.0));
    case.outcome("1.7 rounded (stops at T = 1/2)", rounded, None);
    case.paper = Some("63".into());
    case.study = Some("128 truncated, never rounded".into());
    case.note = Some("the paper's figure does not reproduce".into());
    case
}

/// Fog on every p-th plane only, against a dither that depends on the plane.
fn periodic(size: Size) -> Case {
    let (periods, samples) = match size {
        Size::Full => (2..=128u32, 8192),
        Size::Reduced => (2..=16, 2048),
    };
    let mut case = Case::new(
        "periodic fog",
        format!(
            "every p-th plane of {samples}, p = {} to {}",
            periods.start(),
            periods.end()
        ),
        "worst error of T, steps of 1/255",
        0.0,
        "the product of the planes that are there",
    );
    let worst = |blocked: &dyn Fn(Fog<'_>) -> f64| {
        periods
            .clone()
            .flat_map(|p| [(p, 1u32 << 16), (p, 3 << 17), (p, 1 << 20)])
            .map(|(p, opacity)| {
                let fog = move |k: u32| if k.is_multiple_of(p) { opacity } else { 0 };
                (blocked(&fog) - exact(samples, &fog)).abs() * 2.55
            })
            .fold(0.0, f64::max)
    };
    case.outcome("paper", worst(&|fog| blocked(Paper.pixel(), samples, fog)), None);
    case.outcome(
        "compact",
        worst(&|fog| blocked(Compact.pixel(), samples, fog)),
        Some(0.42),
    );
    case.outcome(
        "wide",
        worst(&|fog| blocked(Wide.pixel(), samples, fog)),
        Some(255.0 * (f64::from(samples) * 2f64.powi(-31) + 2f64.powi(-20))),
    );
    case.study = Some("0.42 in 1.15, p = 2 to 128".into());
    case.note = Some("compact's limit is the study's figure for 1.15; 65535 as 1.0 should halve it".into());
    case
}

/// Nothing at all for a long way, then a wall.
fn empty_before_a_wall() -> Case {
    let mut case = Case::new(
        "transparent run",
        "32768 clear samples, then an opaque white one",
        "colour, steps of 1/255",
        255.0,
        "clear samples change nothing, so all light is the wall's",
    );
    let wall = |k: u32| if k == 32768 { 1 << 31 } else { 0 };
    let colour = |value: f64| 255.0 * value;
    let paper = ray(Paper.pixel(), 32769, &wall);
    let compact = ray(Compact.pixel(), 32769, &wall);
    let wide = ray(Wide.pixel(), 32769, &wall);
    case.outcome(
        "paper",
        colour(value(Paper.pixel(), paper.colour[0], u32::MAX)),
        Some(0.0),
    );
    case.outcome(
        "compact",
        colour(value(Compact.pixel(), compact.colour[0], u32::MAX)),
        Some(0.0),
    );
    case.outcome("wide", colour(value(Wide.pixel(), wide.colour[0], u32::MAX)), Some(0.0));
    let shifted = ray(study(TRUNCATED, Full(8)), 32769, &wall);
    case.outcome(
        "[0, 255], one shift",
        colour(value(study(TRUNCATED, Full(8)), shifted.colour[0], u32::MAX)),
        None,
    );
    let blinn = ray(study(ROUNDED, Full(8)), 32769, &wall);
    case.outcome(
        "[0, 255] after Blinn",
        colour(value(study(ROUNDED, Full(8)), blinn.colour[0], u32::MAX)),
        Some(0.0),
    );
    case.paper = Some("[0, 255] with one shift is opaque after 255 clear samples (section 3)".into());
    case.note = Some("the paper's figure reproduces".into());
    case
}

/// All of them.
pub fn cases(size: Size) -> Vec<Case> {
    let lengths: &[u32] = match size {
        Size::Full => &[256, 1024, 4096, 32768],
        Size::Reduced => &[256, 1024],
    };
    let mut cases = Vec::new();
    for samples in lengths {
        cases.extend([8, 10, 12, 14, 15, 16].map(|bits| thin_fog(bits, *samples)));
    }
    cases.extend([one_part_in_128(), periodic(size), empty_before_a_wall()]);
    cases
}
