//! Viewing direction to slice frame: which axis the slices are perpendicular to, and which way they are read.
//!
//! Source: the shear of Cube-4 and VolumePro (Pfister et al. 1999, section 3). The **major axis** is the one along
//! which the viewing direction, in voxel units, is largest; it becomes k, reversed if need be so that k grows away
//! from the eye. The other two axes, in their own order, become i and j and are never reversed:
//!
//! | major axis | i | j | k |
//! |---|---|---|---|
//! | x | y | z | x |
//! | y | x | z | y |
//! | z | x | y | z |
//!
//! Ties (45-degree views) go to z before y before x: the order in which volumes are stored.
//!
//! Rounding: the slopes are kept as the exact ratio of two direction components; `plan` rounds once, to 32.32.
//! State: none. Floating point appears only in `View::from_angles` (feature `angles`), which a device may use to set up a
//! view.

#[cfg(feature = "angles")]
use micromath::F32Ext;

use crate::format::{Direction, Step};

/// One of the volume's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Axis {
    /// The first axis (fastest in memory).
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

/// A parallel view, reduced to the slice frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    major: Axis,
    reversed: bool,
    /// i and j components of the direction, s5.58 bits.
    lateral: [i64; 2],
    /// k component, 0 < axial <= 2^58.
    axial: u64,
}

/// Why a direction is not a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ViewError {
    /// All three components are zero.
    NoDirection,
    /// A component is beyond -1 to 1.
    TooLong {
        /// The component's bits, s5.58.
        bits: i64,
    },
    /// An angle is no number from -[`ANGLE_MAX`] to [`ANGLE_MAX`].
    Angle,
    /// A voxel spacing is no length: zero, negative, infinite, not a number, or below the least normal `f32`.
    Spacing {
        /// The axis that it belongs to.
        axis: Axis,
    },
}

/// The largest angle of `View::from_angles`, radians: 163 turns. At larger ones the steps between two `f32` are a part
/// of its error.
pub const ANGLE_MAX: f32 = 1024.0;

impl core::fmt::Display for ViewError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoDirection => f.write_str("the viewing direction is zero"),
            Self::TooLong { bits } => write!(
                f,
                "a component of the viewing direction is beyond -1 to 1 (bits {bits} of s5.58)"
            ),
            Self::Angle => f.write_str("a viewing angle is no number from -1024 to 1024 radians"),
            Self::Spacing { axis } => write!(
                f,
                "the voxel spacing along {axis:?} is no length; accepted: 2^-126 and more"
            ),
        }
    }
}

impl core::error::Error for ViewError {}

impl View {
    /// The view along a direction (from the eye into the scene) in voxel units: each world component divided by the
    /// voxel spacing of its axis, then scaled so that no component is beyond -1 to 1. Its length does not matter.
    ///
    /// # Errors
    /// [`ViewError`] if the direction is zero or too long; nothing is clamped.
    pub const fn new(direction: [Direction; 3]) -> Result<Self, ViewError> {
        let [x, y, z] = direction;
        let (x, y, z) = (x.to_bits(), y.to_bits(), z.to_bits());
        let (ax, ay, az) = (x.unsigned_abs(), y.unsigned_abs(), z.unsigned_abs());
        let one = Direction::ONE.to_bits().unsigned_abs();
        if ax > one || ay > one || az > one {
            let bits = if ax > one {
                x
            } else if ay > one {
                y
            } else {
                z
            };
            return Err(ViewError::TooLong { bits });
        }
        let (major, k, lateral) = if az >= ay && az >= ax {
            (Axis::Z, z, [x, y])
        } else if ay >= ax {
            (Axis::Y, y, [x, z])
        } else {
            (Axis::X, x, [y, z])
        };
        if k == 0 {
            return Err(ViewError::NoDirection);
        }
        Ok(Self {
            major,
            reversed: k < 0,
            lateral,
            axial: k.unsigned_abs(),
        })
    }

    /// The view along its major axis.
    #[must_use]
    pub const fn straight(self) -> Self {
        Self {
            lateral: [0; 2],
            ..self
        }
    }

    /// The view from angles in radians, for a device that has no better source: azimuth about +z (0 looks along +y),
    /// elevation above the xy plane, and the voxel spacing along x, y, z. Sine and cosine are `micromath`'s (single
    /// precision, the same bits on every target); expect the direction to be off by up to 0.1 degrees. The host program works
    /// in f64 and has other bits: `slicecast export` writes its direction, for [`View::new`].
    ///
    /// # Errors
    /// [`ViewError::Angle`] or [`ViewError::Spacing`], for the first number that is not usable.
    #[cfg(feature = "angles")]
    #[expect(
        clippy::float_arithmetic,
        reason = "set-up of a view on a device, not part of the pipeline"
    )]
    pub fn from_angles(azimuth: f32, elevation: f32, spacing: [f32; 3]) -> Result<Self, ViewError> {
        check_spacing(spacing)?;
        let (sa, ca) = sine_and_cosine(azimuth)?;
        let (se, ce) = sine_and_cosine(elevation)?;
        let [dx, dy, dz] = spacing;
        let voxels = [-sa * ce / dx, ca * ce / dy, -se / dz];
        let longest = voxels.iter().fold(0.0f32, |m, c| {
            let a = F32Ext::abs(*c);
            if a > m { a } else { m }
        });
        // 2^30 fits an f32 exactly.
        let component = |c: f32| Direction::from_bits(((c / longest * 1_073_741_824.0) as i64) << 28);
        Self::new(voxels.map(component))
    }

    /// The direction that the view was made from.
    pub const fn direction(&self) -> [Direction; 3] {
        let [i, j] = self.lateral;
        let magnitude = self.axial as i64;
        let k = if self.reversed { -magnitude } else { magnitude };
        self.restore([
            Direction::from_bits(i),
            Direction::from_bits(j),
            Direction::from_bits(k),
        ])
    }

    /// The axis that the slices are perpendicular to.
    pub const fn major(&self) -> Axis {
        self.major
    }

    /// Whether slices are read from the far end of the major axis.
    pub const fn reversed(&self) -> bool {
        self.reversed
    }

    /// Reorders a triple from x, y, z to i, j, k (no sign changes): sizes, spacings.
    pub const fn arrange<T: Copy>(&self, xyz: [T; 3]) -> [T; 3] {
        let [x, y, z] = xyz;
        match self.major {
            Axis::X => [y, z, x],
            Axis::Y => [x, z, y],
            Axis::Z => [x, y, z],
        }
    }

    /// Puts a triple in i, j, k back into x, y, z (no sign changes): undoes [`View::arrange`].
    pub const fn restore<T: Copy>(&self, ijk: [T; 3]) -> [T; 3] {
        let [i, j, k] = ijk;
        match self.major {
            Axis::X => [k, i, j],
            Axis::Y => [i, k, j],
            Axis::Z => [i, j, k],
        }
    }

    /// Takes a vector from x, y, z to i, j, k: reordered, and k reversed where the slices are.
    pub fn orient<T: Copy + core::ops::Neg<Output = T>>(&self, xyz: [T; 3]) -> [T; 3] {
        let [i, j, k] = self.arrange(xyz);
        [i, j, if self.reversed { -k } else { k }]
    }

    /// The shear per sample plane along i and j, voxels, s31.32: direction_i / (direction_k * planes_per_voxel),
    /// rounded to nearest, halves away from zero, so that opposite views mirror each other exactly.
    pub const fn shear(&self, planes_per_voxel: u32) -> [Step; 2] {
        let [i, j] = self.lateral;
        [self.along(i, planes_per_voxel), self.along(j, planes_per_voxel)]
    }

    /// [`View::shear`] of a component of the direction.
    const fn along(&self, component: i64, planes_per_voxel: u32) -> Step {
        let bits = ratio(component.unsigned_abs(), self.axial, planes_per_voxel) as i64;
        Step::from_bits(if component < 0 { -bits } else { bits })
    }
}

/// Sine and cosine of an angle in radians.
#[cfg(feature = "angles")]
#[expect(
    clippy::float_arithmetic,
    reason = "set-up of a view on a device, not part of the pipeline"
)]
pub(crate) fn sine_and_cosine(angle: f32) -> Result<(f32, f32), ViewError> {
    // NaN is in no range.
    if (-ANGLE_MAX..=ANGLE_MAX).contains(&angle) {
        Ok((F32Ext::sin(angle), F32Ext::cos(angle)))
    } else {
        Err(ViewError::Angle)
    }
}

/// Refuses spacings that are no lengths.
#[cfg(feature = "angles")]
pub(crate) fn check_spacing(spacing: [f32; 3]) -> Result<(), ViewError> {
    for (axis, length) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(spacing) {
        if !(length.is_normal() && length > 0.0) {
            return Err(ViewError::Spacing { axis });
        }
    }
    Ok(())
}

/// `numerator / (denominator * times)` with 32 fraction bits, to nearest, by long division.
///
/// Range: numerator <= denominator <= 2^58, times <= 16, so that a doubled remainder stays below 2^64.
// Once in a program: copies at its callers took 1.7 KB of flash on Cortex-M4, and none is in a loop over pixels.
#[inline(never)]
pub(crate) const fn ratio(numerator: u64, denominator: u64, times: u32) -> u64 {
    let divisor = denominator * times as u64;
    let mut remainder = numerator;
    let mut quotient: u64 = 0;
    let mut bit = 0;
    // One integer bit, 32 fraction bits and one more to round by.
    while bit < 34 {
        // Most phases start at 0 or a half.
        if remainder == 0 {
            quotient <<= 34 - bit;
            break;
        }
        quotient <<= 1;
        if remainder >= divisor {
            remainder -= divisor;
            quotient |= 1;
        }
        remainder <<= 1;
        bit += 1;
    }
    (quotient + 1) >> 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(v: [f64; 3]) -> [Direction; 3] {
        v.map(|c| Direction::from_bits((c * (1u64 << 58) as f64) as i64))
    }

    #[test]
    fn ties_go_to_z_then_y() {
        let major = |v| View::new(direction(v)).unwrap().major();
        assert_eq!(major([0.5, 0.5, 0.5]), Axis::Z);
        assert_eq!(major([0.5, -0.5, 0.25]), Axis::Y);
        assert_eq!(major([-0.5, 0.25, 0.25]), Axis::X);
        assert_eq!(major([0.5, 0.5, -0.5]), Axis::Z);
    }

    #[test]
    fn shear_is_the_nearest_32_32_ratio() {
        for (v, r) in [
            ([0.3, -0.2, 0.9], 1),
            ([1.0, 1.0, 1.0], 16),
            ([0.1, 0.7, -0.7001], 3),
            ([1e-12, -0.999, 1.0], 7),
        ] {
            let view = View::new(direction(v)).unwrap();
            let [si, sj] = view.shear(r);
            for (s, c) in [(si, v[0]), (sj, v[1])] {
                let exact = c / v[2].abs() / f64::from(r) * 4294967296.0;
                assert!((s.to_bits() as f64 - exact).abs() <= 0.5 + 1e-6, "{v:?} {r}");
            }
        }
    }

    #[test]
    fn views_keep_their_direction() {
        for v in [
            [0.3, -0.2, 0.9],
            [0.3, -0.2, -0.9],
            [-1.0, 0.5, 0.25],
            [1.0, 0.5, 0.25],
            [0.1, 0.7, -0.6],
            [0.1, -0.7, -0.6],
        ] {
            assert_eq!(View::new(direction(v)).unwrap().direction(), direction(v));
        }
    }

    #[test]
    fn opposite_views_mirror() {
        let a = View::new(direction([0.3, -0.2, 0.9])).unwrap();
        let b = View::new(direction([-0.3, 0.2, -0.9])).unwrap();
        assert_eq!(a.shear(3)[0], -b.shear(3)[0]);
        assert_eq!(a.shear(3)[1], -b.shear(3)[1]);
        assert!(!a.reversed() && b.reversed());
    }

    #[test]
    fn bad_directions_are_named() {
        assert_eq!(View::new([Direction::ZERO; 3]), Err(ViewError::NoDirection));
        let long = Direction::from_bits((1 << 58) + 1);
        assert_eq!(
            View::new([Direction::ZERO, long, Direction::ZERO]),
            Err(ViewError::TooLong { bits: (1 << 58) + 1 })
        );
    }

    #[cfg(feature = "angles")]
    #[test]
    fn angles_and_spacings_that_are_none_are_refused() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1025.0, -1025.0] {
            assert_eq!(View::from_angles(bad, 0.0, [1.0; 3]), Err(ViewError::Angle), "{bad}");
            assert_eq!(View::from_angles(0.0, bad, [1.0; 3]), Err(ViewError::Angle), "{bad}");
        }
        for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0, -0.0, 1e-40] {
            for (place, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
                let mut spacing = [1.0; 3];
                spacing[place] = bad;
                let refused = Err(ViewError::Spacing { axis });
                assert_eq!(View::from_angles(0.5, 0.2, spacing), refused, "{bad}");
            }
        }
        // The extremes that are lengths have a view, whatever the others are.
        for length in [f32::MIN_POSITIVE, f32::MAX] {
            for place in 0..3 {
                let mut spacing = [1.0; 3];
                spacing[place] = length;
                assert!(View::from_angles(0.5, 0.2, spacing).is_ok(), "{spacing:?}");
            }
            assert!(View::from_angles(0.5, 0.2, [length; 3]).is_ok(), "{length}");
        }
    }

    #[cfg(feature = "angles")]
    #[test]
    fn angles_agree_with_f64_to_a_tenth_of_a_degree() {
        // The last are near the largest angle that is accepted.
        for a in (-180..180).step_by(7).chain((58_300..58_660).step_by(7)) {
            for e in (-80..=80).step_by(20) {
                let (a, e) = ((f64::from(a).to_radians() as f32), (f64::from(e).to_radians() as f32));
                let (a, e) = (f64::from(a), f64::from(e));
                let exact = [-a.sin() * e.cos(), a.cos() * e.cos(), -e.sin()];
                let view = View::from_angles(a as f32, e as f32, [1.0; 3]).unwrap();
                let [si, sj] = view.shear(1).map(|s| s.to_bits() as f64 / 4294967296.0);
                let [i, j, k] = view.orient(exact);
                let dot = (si * i + sj * j + k) / (si * si + sj * sj + 1.0).sqrt();
                assert!(dot > 0.1f64.to_radians().cos(), "{a} {e} {dot}");
            }
        }
    }
}
