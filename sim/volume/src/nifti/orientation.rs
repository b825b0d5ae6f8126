//! Where a NIfTI file's axes run to: the sform, else the qform.

use super::header::Header;
use crate::axes::Turn;
use crate::error::Problem;

/// What the sform's spacing and `pixdim` may differ by, as a part of it, without a note.
const AGREEMENT: f64 = 1e-3;

/// Spacing in millimetres, the axes' directions in LPS, and notes.
pub(super) struct Orientation {
    pub spacing: [f64; 3],
    pub directions: Option<[[f64; 3]; 3]>,
    pub notes: Vec<String>,
}

/// Reads the orientation from a header.
pub(super) fn orientation(header: &Header) -> Result<Orientation, Problem> {
    let mut notes = Vec::new();
    let qform = (header.qform_code > 0).then(|| quaternion_axes(header)).flatten();
    if header.sform_code > 0 {
        let axes = columns(header.sform).map(to_lps);
        let spacing = axes.map(|axis| axis.iter().map(|c| c * c).sum::<f64>().sqrt());
        match Turn::upright(axes) {
            Ok(_) => {
                let disagree = |i: usize| (spacing[i] - header.spacing[i]).abs() > AGREEMENT * spacing[i];
                if (0..3).any(disagree) {
                    notes.push(format!(
                        "spacing {spacing:?} comes from the sform; pixdim says {:?}",
                        header.spacing
                    ));
                }
                return Ok(Orientation {
                    spacing,
                    directions: Some(axes),
                    notes,
                });
            }
            // An affine registration may shear; the scanner's own axes are then the better statement.
            Err(error) if qform.is_some() => notes.push(format!("the sform {error}: the qform is used")),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(Orientation {
        spacing: header.spacing,
        directions: qform,
        notes,
    })
}

/// The columns of a matrix of rows.
fn columns(rows: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|column| rows.map(|row| row[column]))
}

/// From RAS to LPS.
fn to_lps([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-x, -y, z]
}

/// The axes of the qform in LPS; `None` if the quaternion is none.
fn quaternion_axes(header: &Header) -> Option<[[f64; 3]; 3]> {
    let [mut b, mut c, mut d] = header.quaternion;
    let square = b * b + c * c + d * d;
    if !square.is_finite() {
        return None;
    }
    let mut a = (1.0 - square).max(0.0).sqrt();
    // Half a turn: rounding may have brought the length above 1.
    if 1.0 - square < 1e-7 {
        let length = square.sqrt();
        (a, b, c, d) = (0.0, b / length, c / length, d / length);
    }
    let rows = [
        [
            a * a + b * b - c * c - d * d,
            2.0 * (b * c - a * d),
            2.0 * (b * d + a * c),
        ],
        [
            2.0 * (b * c + a * d),
            a * a + c * c - b * b - d * d,
            2.0 * (c * d - a * b),
        ],
        [
            2.0 * (b * d - a * c),
            2.0 * (c * d + a * b),
            a * a + d * d - c * c - b * b,
        ],
    ];
    let mut axes = columns(rows);
    if header.handedness < 0.0 {
        axes[2] = axes[2].map(|c| -c);
    }
    Some(axes.map(to_lps))
}
