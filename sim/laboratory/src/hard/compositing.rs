//! Rays of fog: thin over many samples, in every width and rounding; periodic against the dither; long and empty before
//! a wall.

use slicecast::composite::{Channel, Dither, Dithered, Pixel, Recurrence, settle};
use slicecast::format::Opacity;
use slicecast::precision::{Compact, Paper, Precision, Wide};

use super::{Case, Size};
use crate::channels::{Binary, Byte, Long, Packed, Short};
use crate::pixels::{Carrying, Described, Product, Scaled, Telescoping};

/// A ray: opacity (1.31) of plane k; all samples are white.
type Fog<'a> = &'a dyn Fn(u32) -> u32;

/// Accumulated opacity, percent, by the recurrence's own definition.
fn blocked<R: Described>(samples: u32, fog: Fog<'_>) -> f64 {
    100.0 - 100.0 * value::<R>(ray::<R>(samples, fog).transparency)
}

fn value<R: Described>(channel: R::Channel) -> f64 {
    f64::from(channel.bits() & R::SHOWN) / f64::from(R::Channel::ONE.bits())
}

fn ray<R: Recurrence>(samples: u32, fog: Fog<'_>) -> Pixel<R::Channel> {
    let white = [1u32 << R::COLOUR_BITS; 3];
    (0..samples).fold(Pixel::clear(), |pixel, k| {
        let mut out = R::over(pixel, white, Opacity::from_bits(fog(k)), Dither::of_plane(k));
        out.transparency = settle(out.transparency, R::FLOOR);
        out
    })
}

/// What is blocked in the end, in f64.
fn exact(samples: u32, fog: Fog<'_>) -> f64 {
    let left: f64 = (0..samples).map(|k| (-f64::from(fog(k)) / 2147483648.0).ln_1p()).sum();
    -100.0 * left.exp_m1()
}

/// The schemes of one width.
fn schemes<C: Binary>(case: &mut Case, samples: u32, fog: Fog<'_>)
where
    Dithered<C>: Recurrence<Channel = C>,
{
    plain_schemes::<C>(case, samples, fog);
    let percent = |bits: u32| 100.0 * (1.0 - f64::from(bits) / f64::from(C::ONE.bits()));
    let dithered = ray::<Dithered<C>>(samples, fog).transparency;
    case.outcome(format!("1.{} dithered", C::FRACTION), percent(dithered.bits()), None);
}

/// Those without a dither.
fn plain_schemes<C: Binary>(case: &mut Case, samples: u32, fog: Fog<'_>) {
    let f = C::FRACTION;
    let name = |scheme: &str| format!("1.{f} {scheme}");
    case.outcome(name("truncated"), blocked::<Product<C, false, 15>>(samples, fog), None);
    case.outcome(name("rounded"), blocked::<Product<C, true, 15>>(samples, fog), None);
    case.outcome(
        name("telescoping"),
        blocked::<Telescoping<C, false, 15>>(samples, fog),
        None,
    );
}

/// Half a step of 1/255 in percent: what an 8-bit picture can show.
const HALF_STEP: f64 = 50.0 / 255.0;

/// White fog of 2^-bits a sample.
fn thin_fog(bits: u32, samples: u32) -> Case {
    let fog = |_: u32| 1u32 << (31 - bits);
    let theory = format!("1 - (1 - 2^-{bits})^{samples}");
    let name = format!("2^-{bits} x {samples}");
    let mut case = Case::new("thin fog", name, "opacity, %", exact(samples, &fog), theory);
    case.outcome("paper", blocked::<<Paper as Precision>::Pixel>(samples, &fog), None);
    // The dither's errors are bounded by measurement only: 0.61 of a step of 1/255 over 8192 samples in 1.15 (study),
    // half of that on the scale of 65535, here allowed for the longest rays as well.
    case.outcome(
        "compact",
        blocked::<<Compact as Precision>::Pixel>(samples, &fog),
        Some(0.61 * HALF_STEP),
    );
    // N floors of 2^-31, and the floor of 2^-20.
    let wide = 100.0 * (f64::from(samples) * 2f64.powi(-31) + 2f64.powi(-20));
    case.outcome("wide", blocked::<<Wide as Precision>::Pixel>(samples, &fog), Some(wide));
    match bits {
        8 => schemes::<Short<8>>(&mut case, samples, &fog),
        10 => schemes::<Short<10>>(&mut case, samples, &fog),
        12 => schemes::<Short<12>>(&mut case, samples, &fog),
        14 => schemes::<Short<14>>(&mut case, samples, &fog),
        15 => schemes::<Short<15>>(&mut case, samples, &fog),
        _ => {
            schemes::<Long<16>>(&mut case, samples, &fog);
            // The plane dither's products with a colour have 32 bits, too few for these.
            plain_schemes::<Packed<23>>(&mut case, samples, &fog);
            plain_schemes::<u32>(&mut case, samples, &fog);
        }
    }
    let carry = match bits {
        8 => Some(blocked::<Carrying<8>>(samples, &fog)),
        10 => Some(blocked::<Carrying<10>>(samples, &fog)),
        12 => Some(blocked::<Carrying<12>>(samples, &fog)),
        14 => Some(blocked::<Carrying<14>>(samples, &fog)),
        15 => Some(blocked::<Carrying<15>>(samples, &fog)),
        _ => None,
    };
    if let Some(carry) = carry {
        // A rest of 16 bits: what is left of an error is one unit of the value.
        case.outcome(
            format!("1.{bits} residual carry"),
            carry,
            Some(100.0 * 2f64.powi(1 - bits as i32)),
        );
    }
    case.outcome(
        "[0, 255] after Blinn",
        blocked::<Scaled<Byte, true>>(samples, &fog),
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
    let truncated = until(&|n| ray::<Product<Short<7>, false, 15>>(n, &fog).transparency.bits() == 0);
    let rounded = until(&|n| ray::<Product<Short<7>, true, 15>>(n, &fog).transparency.bits() == 0);
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
    case.outcome(
        "paper",
        worst(&|fog| blocked::<<Paper as Precision>::Pixel>(samples, fog)),
        None,
    );
    case.outcome(
        "compact",
        worst(&|fog| blocked::<<Compact as Precision>::Pixel>(samples, fog)),
        Some(0.42),
    );
    case.outcome(
        "wide",
        worst(&|fog| blocked::<<Wide as Precision>::Pixel>(samples, fog)),
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
    let paper = ray::<<Paper as Precision>::Pixel>(32769, &wall);
    let compact = ray::<<Compact as Precision>::Pixel>(32769, &wall);
    let wide = ray::<<Wide as Precision>::Pixel>(32769, &wall);
    case.outcome(
        "paper",
        colour(value::<<Paper as Precision>::Pixel>(paper.colour[0])),
        Some(0.0),
    );
    case.outcome(
        "compact",
        colour(value::<<Compact as Precision>::Pixel>(compact.colour[0])),
        Some(0.0),
    );
    case.outcome(
        "wide",
        colour(value::<<Wide as Precision>::Pixel>(wide.colour[0])),
        Some(0.0),
    );
    let shifted = ray::<Scaled<Byte, false>>(32769, &wall);
    case.outcome(
        "[0, 255], one shift",
        colour(value::<Scaled<Byte, false>>(shifted.colour[0])),
        None,
    );
    let blinn = ray::<Scaled<Byte, true>>(32769, &wall);
    case.outcome(
        "[0, 255] after Blinn",
        colour(value::<Scaled<Byte, true>>(blinn.colour[0])),
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
