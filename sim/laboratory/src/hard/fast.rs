//! 16-bit lanes where 16 bits are fewest: the largest differences there are, weak ones, and an opacity that climbs at once.

use super::scenes::{compared, lit, scene, volume};
use super::{Case, Size};
use crate::segments::cases::marschner_lobb;
use slicecast_engine::error::RenderError;
use slicecast_scene::{Borders, PrecisionName, Sampling, Scene, View};
use slicecast_volume::Volume;

/// Those that are compared.
const PRECISIONS: [PrecisionName; 2] = [PrecisionName::Fast, PrecisionName::Compact];

/// 0 or 4095, without an order.
fn noise(side: usize, border: usize) -> Volume {
    volume([side; 3], [1.0; 3], |at| {
        let within = at.iter().all(|&c| (border..side - border).contains(&c));
        let [x, y, z] = at.map(|c| c as u32);
        let bits = (x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b) ^ z.wrapping_mul(0xc2b2_ae35))
            .wrapping_mul(0x27d4_eb2f);
        if within && bits >> 31 != 0 { 4095.0 } else { 0.0 }
    })
}

/// A ball of 4095, cut by the faces of the volume.
fn cut_ball(side: usize) -> Volume {
    let middle = (side as f64 - 1.0) / 2.0;
    volume([side; 3], [1.0; 3], |at| {
        let square: f64 = at.iter().map(|&c| (c as f64 - middle).powi(2)).sum();
        if square.sqrt() < 1.15 * middle { 4095.0 } else { 0.0 }
    })
}

/// The largest error of each precision on volumes of 0 and 4095, whose one-sided differences have 17 bits at the faces.
fn largest_differences(side: usize) -> Result<Vec<Case>, RenderError> {
    let ramp = scene(&[(0.0, 0.0), (4095.0, 0.5)]);
    let lit = Scene {
        lighting: lit(0.3, 5),
        ..ramp
    };
    let volumes = [
        ("noise of 0 and 4095, empty at the faces", noise(side, 2)),
        ("noise of 0 and 4095 up to the faces", noise(side, 0)),
        ("ball of 4095 that the faces cut", cut_ball(side)),
    ];
    let of_volume = |(name, volume): (&str, Volume)| {
        let mut case = Case::new(
            "fast",
            name,
            "largest error, steps of 1/255",
            0.0,
            "the same rays in f64, whole and exact borders",
        );
        for precision in PRECISIONS {
            let mut worst: f64 = 0.0;
            for borders in [Borders::Whole, Borders::Cells, Borders::Nodes] {
                let scene = Scene {
                    precision,
                    borders,
                    ..lit.clone()
                };
                worst = worst.max(compared(&scene, &volume, precision)?.image.max_lsb8);
            }
            case.outcome(precision.name(), worst, Some(1.0));
        }
        case.note = Some("limit: a step; a gradient that saturated would be off by tens".into());
        Ok(case)
    };
    volumes.into_iter().map(of_volume).collect()
}

/// What is stated not to be done well: differences of a few codes, and an opacity that climbs within seven.
fn too_weak(side: usize) -> Result<Case, RenderError> {
    let middle = (side as f64 - 1.0) / 2.0;
    let waves = volume([side; 3], [1.0; 3], |[x, y, z]| {
        let (x, y, z) = (x as f64 - middle, y as f64 - middle, z as f64 - middle);
        2000.0 + 100.0 * ((x * x + y * y).sqrt() * 0.7).cos() + 20.0 * (0.2 * z).sin()
    });
    let steep = Scene {
        lighting: lit(0.3, 5),
        ..scene(&[(1996.0, 0.0), (2003.0, 0.9)])
    };
    let mut case = Case::new(
        "fast",
        "waves of 256 codes under a ramp of seven",
        "largest error, steps of 1/255",
        0.0,
        "the same rays in f64; `fast` mixes roots of opacities in eighths of a code",
    );
    for precision in PRECISIONS {
        let scene = Scene {
            precision,
            ..steep.clone()
        };
        case.outcome(
            precision.name(),
            compared(&scene, &waves, precision)?.image.max_lsb8,
            None,
        );
    }
    case.note = Some("no limit: the contract says that this is outside of what `fast` does well".into());
    Ok(case)
}

/// Marschner and Lobb's signal as a lit surface, seen obliquely: a highlight of exponent 32, a ramp of 700 codes, so many planes per voxel.
pub fn signal(side: usize, planes_per_voxel: u32) -> (Volume, Scene) {
    let middle = (side as f64 - 1.0) / 2.0;
    let volume = volume([side; 3], [1.0; 3], |at| {
        marschner_lobb(at.map(|c| (c as f64 - middle) / middle))
    });
    let scene = Scene {
        view: View {
            azimuth: 30.0,
            elevation: 20.0,
            ..View::default()
        },
        sampling: Sampling {
            planes_per_voxel,
            rays_per_voxel: 4,
        },
        lighting: lit(0.3, 5),
        ..scene(&[(1700.0, 0.0), (2400.0, 0.9)])
    };
    (volume, scene)
}

/// The share of bytes of that signal that differ, in every precision but the paper's, whose aim it is not.
fn signal_bytes(side: usize) -> Result<Case, RenderError> {
    let (volume, scene) = signal(side, 2);
    let mut case = Case::new(
        "fast",
        "Marschner and Lobb's signal, lit",
        "bytes that differ, percent",
        0.0,
        "the same rays in f64",
    );
    for (precision, limit) in [
        (PrecisionName::Fast, 1.5),
        (PrecisionName::Compact, 0.7),
        (PrecisionName::Wide, 0.1),
    ] {
        let equal = compared(&scene, &volume, precision)?.image.equal_percent;
        case.outcome(precision.name(), 100.0 - equal, Some(limit));
    }
    case.note = Some("limits: the aims of each, 98.5, 99.3 and 99.9 % of equal bytes".into());
    Ok(case)
}

/// All cases.
///
/// # Errors
/// [`RenderError`] if the machine cannot run one.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let side = match size {
        Size::Full => 48,
        Size::Reduced => 16,
    };
    let mut cases = largest_differences(side)?;
    cases.push(too_weak(side)?);
    cases.push(signal_bytes(41)?);
    Ok(cases)
}
