//! 16-bit lanes where 16 bits are fewest: the largest differences there are, weak ones, and an opacity that climbs at once.

use super::scenes::{compared, lit, scene, volume};
use super::{Case, Size};
use slicecast_engine::error::RenderError;
use slicecast_scene::{Borders, PrecisionName, Scene};
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
    Ok(cases)
}
