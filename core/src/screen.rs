//! Screen: where a picture's pixels lie in the volume, and the warp that this is under a plan.
//!
//! A picture is a plane across the view through the volume's middle, which is the picture's middle. The ray of a picture
//! pixel meets the first slice where the warp says.
//!
//! | value | format | range | unit |
//! |---|---|---|---|
//! | R, D: one picture pixel to the right, down | s31.32 | -1024 to 1024 | voxels along x, y, z |
//! | s: shear per slice, `View::shear(1)` | s31.32 | -1 to 1 | voxels |
//! | warp | s31.32 | | base-plane pixels |
//!
//! With R and D in i, j, k (k reversed where the slices are), n rays per voxel, `size` voxels along i, j, k, and o the origin
//! of the base plane, along u (v alike with j):
//!
//! ```text
//! right_u  = (n ((R_i << 32) - s_i R_k) + 2^31) >> 32                   down_u alike
//! middle   = ((size_i - 1 - 2 o_i) << 32) - s_i (size_k - 1)             twice the middle voxel's ray
//! origin_u = (n middle - (width - 1) right_u - (height - 1) down_u + 1) >> 1
//! ```
//!
//! Rounding: once each, to nearest. Overflow: none in these ranges (products below 2^79, sums below 2^62). Error of a
//! coordinate, of a pixel that lies x and y pixels from the picture's middle and z slices from the first: `(x + y + n z + 1) 2^-33`,
//! of the steps, of the shear and of the origin. State: none.

use crate::format::Step;
use crate::plan::Plan;
use crate::warp::Warp;

/// The longest side of a picture, pixels.
pub const PICTURE_SIDE_MAX: u32 = 16384;

/// The most voxels along an axis from one picture pixel to the next.
pub const PIXEL_MAX: u32 = 1024;

/// A picture's pixels in the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Screen {
    /// Pixels across and down, 1 to [`PICTURE_SIDE_MAX`].
    pub size: [u32; 2],
    /// One picture pixel to the right, in voxels along x, y, z.
    pub right: [Step; 3],
    /// One picture pixel down, in voxels along x, y, z.
    pub down: [Step; 3],
}

/// Why a screen has no warp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ScreenError {
    /// A side of the picture is 0 or above [`PICTURE_SIDE_MAX`].
    Side {
        /// The side given, pixels.
        given: u32,
    },
    /// From one picture pixel to the next there are more than [`PIXEL_MAX`] voxels along an axis.
    Pixel {
        /// The component's bits, s31.32.
        bits: i64,
    },
    /// The length of a picture pixel's side is none: zero, negative, infinite, not a number, or below the least normal `f32`.
    Length,
}

impl core::fmt::Display for ScreenError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Side { given } => write!(
                f,
                "a picture with a side of {given} pixels; accepted: 1 to {PICTURE_SIDE_MAX}"
            ),
            Self::Pixel { bits } => write!(
                f,
                "a picture pixel of {bits}/2^32 voxels; accepted: at most {PIXEL_MAX} along an axis"
            ),
            Self::Length => f.write_str("the side of a picture pixel is no length; accepted: 2^-126 and more"),
        }
    }
}

impl core::error::Error for ScreenError {}

impl Screen {
    /// Where the pixels look at the base plane of a plan.
    ///
    /// # Errors
    /// [`ScreenError`], with the value that is out of range.
    pub const fn warp(&self, plan: &Plan) -> Result<Warp, ScreenError> {
        let [width, height] = self.size;
        if let Some(given) = first_bad_side(width, height) {
            return Err(ScreenError::Side { given });
        }
        let (right, down) = match (oriented(self.right, plan), oriented(self.down, plan)) {
            (Ok(right), Ok(down)) => (right, down),
            (Err(error), _) | (_, Err(error)) => return Err(error),
        };
        let ([ri, rj, rk], [di, dj, dk]) = (right, down);
        let ([si, sj], [oi, oj]) = (plan.view().shear(1), plan.origin());
        let rays = plan.sampling().rays_per_voxel as i64;
        let [ni, nj, nk] = plan.volume();
        let (ru, rv) = (step(ri, rk, si, rays), step(rj, rk, sj, rays));
        let (du, dv) = (step(di, dk, si, rays), step(dj, dk, sj, rays));
        let (across, high) = (width as i64 - 1, height as i64 - 1);
        let u = rays * middle(ni, nk, oi, si) - across * ru - high * du;
        let v = rays * middle(nj, nk, oj, sj) - across * rv - high * dv;
        Ok(Warp {
            origin: [Step::from_bits((u + 1) >> 1), Step::from_bits((v + 1) >> 1)],
            right: [Step::from_bits(ru), Step::from_bits(rv)],
            down: [Step::from_bits(du), Step::from_bits(dv)],
        })
    }

    /// The screen of a camera given by angles, as [`View::from_angles`](crate::view::View::from_angles) takes them, for the view of the same angles. `roll` turns the
    /// picture clockwise; `pixel` is the length of a picture pixel's side in the unit of the spacing. In single precision:
    /// the same bits on every target, others than the host program's.
    ///
    /// # Errors
    /// The first number that is not usable: [`ViewError::Angle`](crate::view::ViewError::Angle), [`ViewError::Spacing`](crate::view::ViewError::Spacing), [`ScreenError::Length`].
    #[cfg(feature = "angles")]
    #[expect(
        clippy::float_arithmetic,
        reason = "set-up of a view on a device, not part of the pipeline"
    )]
    pub fn from_angles(
        [azimuth, elevation, roll]: [f32; 3],
        spacing: [f32; 3],
        size: [u32; 2],
        pixel: f32,
    ) -> Result<Self, crate::Error> {
        use crate::view::{check_spacing, sine_and_cosine};

        check_spacing(spacing)?;
        if !(pixel.is_normal() && pixel > 0.0) {
            return Err(ScreenError::Length.into());
        }
        let (sa, ca) = sine_and_cosine(azimuth)?;
        let (se, ce) = sine_and_cosine(elevation)?;
        let (sr, cr) = sine_and_cosine(roll)?;
        let (level, up) = ([ca, sa, 0.0], [-sa * se, ca * se, ce]);
        let voxels = |along: f32, upwards: f32| {
            let mut out = [Step::ZERO; 3];
            for (((out, l), u), spacing) in out.iter_mut().zip(level).zip(up).zip(spacing) {
                // 2^32 fits an f32 exactly; beyond an i64 the conversion saturates, far above what a warp takes.
                *out = Step::from_bits(((along * l + upwards * u) * pixel / spacing * 4_294_967_296.0) as i64);
            }
            out
        };
        Ok(Self {
            size,
            right: voxels(cr, sr),
            down: voxels(sr, -cr),
        })
    }
}

/// The side that is no side of a picture.
const fn first_bad_side(width: u32, height: u32) -> Option<u32> {
    if width == 0 || width > PICTURE_SIDE_MAX {
        Some(width)
    } else if height == 0 || height > PICTURE_SIDE_MAX {
        Some(height)
    } else {
        None
    }
}

/// Bits of a vector in i, j, k.
const fn oriented(vector: [Step; 3], plan: &Plan) -> Result<[i64; 3], ScreenError> {
    let [i, j, k] = plan.view().arrange(vector);
    let (i, j, k) = (i.to_bits(), j.to_bits(), k.to_bits());
    let most = (PIXEL_MAX as u64) << 32;
    let long = if i.unsigned_abs() > most {
        i
    } else if j.unsigned_abs() > most {
        j
    } else {
        k
    };
    if long.unsigned_abs() > most {
        return Err(ScreenError::Pixel { bits: long });
    }
    Ok([i, j, if plan.view().reversed() { -k } else { k }])
}

/// A step on the base plane.
const fn step(lateral: i64, axial: i64, shear: Step, rays: i64) -> i64 {
    let exact = ((lateral as i128) << 32) - shear.to_bits() as i128 * axial as i128;
    ((rays as i128 * exact + (1 << 31)) >> 32) as i64
}

/// Twice the place where the ray through the volume's middle begins, in voxels from the base plane's origin.
const fn middle(side: u32, depth: u32, origin: i32, shear: Step) -> i64 {
    ((side as i64 - 1 - 2 * origin as i64) << 32) - shear.to_bits() * (depth as i64 - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Direction;
    use crate::plan::{Sampling, Spacing};
    use crate::view::View;
    use proptest::prelude::*;

    fn plan(direction: [f64; 3], dims: [u32; 3], rays: u32) -> Plan {
        let view = View::new(direction.map(|c| Direction::from_bits((c * (1u64 << 58) as f64) as i64))).unwrap();
        let sampling = Sampling {
            planes_per_voxel: 2,
            rays_per_voxel: rays,
        };
        Plan::whole(view, dims, Spacing::CUBIC, sampling).unwrap()
    }

    #[test]
    fn a_screen_along_an_axis_shows_the_slice() {
        let p = plan([0.0, 0.0, 1.0], [5, 7, 3], 1);
        let screen = Screen {
            size: [5, 7],
            right: [Step::ONE, Step::ZERO, Step::ZERO],
            down: [Step::ZERO, Step::ONE, Step::ZERO],
        };
        let warp = screen.warp(&p).unwrap();
        assert_eq!(
            (warp.origin, warp.right, warp.down),
            ([Step::ZERO; 2], [Step::ONE, Step::ZERO], [Step::ZERO, Step::ONE])
        );
    }

    #[test]
    fn limits_are_named() {
        let p = plan([0.0, 0.0, 1.0], [5, 7, 3], 1);
        let most = Step::from_num(PIXEL_MAX);
        let screen = Screen {
            size: [PICTURE_SIDE_MAX; 2],
            right: [most, -most, most],
            down: [-most, most, -most],
        };
        assert!(screen.warp(&p).is_ok());
        for (size, given) in [([0, 1], 0), ([1, 0], 0), ([16385, 1], 16385), ([1, 16385], 16385)] {
            assert_eq!(Screen { size, ..screen }.warp(&p), Err(ScreenError::Side { given }));
        }
        let bits = -(1 << 42) - 1;
        let down = [Step::ZERO, Step::ZERO, Step::from_bits(bits)];
        assert_eq!(Screen { down, ..screen }.warp(&p), Err(ScreenError::Pixel { bits }));
    }

    proptest! {
        /// The definition in f64: the point of the picture's plane, along the ray to the first slice.
        #[test]
        fn rays_meet_the_first_slice_where_the_warp_says(
            direction in prop::array::uniform3(-1.0f64..1.0),
            right in prop::array::uniform3(-2.0f64..2.0),
            down in prop::array::uniform3(-2.0f64..2.0),
            dims in prop::array::uniform3(1u32..300),
            rays in 1u32..=8,
            size in prop::array::uniform2(1u32..600),
            share in prop::array::uniform2(0.0f64..1.0),
        ) {
            prop_assume!(direction.iter().any(|c| c.abs() > 0.01));
            let p = plan(direction, dims, rays);
            let screen = Screen { size, right: right.map(Step::from_num), down: down.map(Step::from_num) };
            let warp = screen.warp(&p).unwrap();
            let at = [0, 1].map(|a| (f64::from(size[a] - 1) * share[a]).floor());
            let exact = warp.exact(at[0] as u32, at[1] as u32).map(|c| c as f64 / 4294967296.0);

            let [x, y] = [0, 1].map(|a| at[a] - f64::from(size[a] - 1) / 2.0);
            let [right, down] = [screen.right, screen.down].map(|v| p.view().orient(v.map(Step::to_num::<f64>)));
            let d = p.view().orient(direction);
            let dims = p.dims().map(f64::from);
            let point = [0, 1, 2].map(|a| (dims[a] - 1.0) / 2.0 + x * right[a] + y * down[a]);
            for a in 0..2 {
                let expected = (point[a] - point[2] * d[a] / d[2] - f64::from(p.origin()[a])) * f64::from(rays);
                // The last is what f64 loses.
                let bound = (x.abs() + y.abs() + f64::from(rays) * point[2].abs() + 1.0) / 8589934592.0 + 1e-11;
                prop_assert!((exact[a] - expected).abs() <= bound, "{a}: {} {expected} {bound}", exact[a]);
            }
        }
    }

    #[cfg(feature = "angles")]
    #[test]
    fn angles_place_the_picture_upright() {
        let eighth = core::f32::consts::FRAC_PI_4;
        let upright = Screen::from_angles([0.0; 3], [1.0, 1.0, 2.0], [64, 64], 0.5).unwrap();
        let near = |v: [Step; 3], expected: [f64; 3]| {
            for (c, e) in v.into_iter().zip(expected) {
                assert!((c.to_num::<f64>() - e).abs() < 0.002, "{v:?} {expected:?}");
            }
        };
        near(upright.right, [0.5, 0.0, 0.0]);
        near(upright.down, [0.0, 0.0, -0.25]);
        let turned = Screen::from_angles([eighth, 0.0, 2.0 * eighth], [1.0; 3], [64, 64], 1.0).unwrap();
        // A quarter turn clockwise: what was to the right is down.
        near(
            turned.down,
            [core::f64::consts::FRAC_1_SQRT_2, core::f64::consts::FRAC_1_SQRT_2, 0.0],
        );
        near(turned.right, [0.0, 0.0, 1.0]);
        let refused = |angles, spacing, pixel| Screen::from_angles(angles, spacing, [1, 1], pixel).unwrap_err();
        use crate::view::{Axis, ViewError};
        assert_eq!(refused([0.0, 0.0, f32::NAN], [1.0; 3], 1.0), ViewError::Angle.into());
        assert_eq!(
            refused([0.0; 3], [1.0, 0.0, 1.0], 1.0),
            ViewError::Spacing { axis: Axis::Y }.into()
        );
        for pixel in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(refused([0.0; 3], [1.0; 3], pixel), ScreenError::Length.into());
        }
    }
}
