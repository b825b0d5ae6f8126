//! Images and the warp: from the base plane to the viewer's image.
//!
//! Source: design.md, section 2 (shear-warp: the base-plane image is an affine picture of the viewer's).

use super::composite::Pixel;
use super::interpolate::linear;
use rayon::prelude::*;

/// A picture of opacity-weighted colour and transparency, row by row from (0, 0).
#[derive(Clone, Debug, PartialEq)]
pub struct ModelImage {
    /// Pixels along u and v.
    pub size: [usize; 2],
    /// Red, green and blue plane, opacity-weighted, 0 to 1: `rgb[c][v * size[0] + u]`.
    pub rgb: [Vec<f64>; 3],
    /// Transparency plane, 0 to 1.
    pub t: Vec<f64>,
}

impl ModelImage {
    /// Computes every pixel from its coordinates (u, v), rows in parallel.
    pub fn from_fn(size: [usize; 2], pixel: impl Fn(usize, usize) -> Pixel + Sync) -> Self {
        let row = |v| (0..size[0]).map(|u| pixel(u, v)).collect::<Vec<_>>();
        let pixels: Vec<Pixel> = (0..size[1]).into_par_iter().flat_map_iter(row).collect();
        Self {
            size,
            rgb: [0, 1, 2].map(|c| pixels.iter().map(|p| p.colour[c]).collect()),
            t: pixels.iter().map(|p| p.transparency).collect(),
        }
    }

    /// The pixel (u, v); outside the picture everything is transparent.
    pub fn pixel(&self, u: i64, v: i64) -> Pixel {
        let inside = |c: i64, n: usize| usize::try_from(c).ok().filter(|&c| c < n);
        match (inside(u, self.size[0]), inside(v, self.size[1])) {
            (Some(u), Some(v)) => {
                let at = v * self.size[0] + u;
                Pixel {
                    colour: [0, 1, 2].map(|c| self.rgb[c][at]),
                    transparency: self.t[at],
                }
            }
            _ => Pixel::TRANSPARENT,
        }
    }

    /// The picture at real coordinates: bilinear between the four pixels around (u, v), in opacity-weighted colour
    /// and transparency. The picture is surrounded by transparent pixels, so that its edge fades over one pixel.
    pub fn bilinear(&self, u: f64, v: f64) -> Pixel {
        let reaches = |c: f64, n: usize| c > -1.0 && c < n as f64;
        if !(reaches(u, self.size[0]) && reaches(v, self.size[1])) {
            return Pixel::TRANSPARENT;
        }
        let (u0, v0) = (u.floor(), v.floor());
        let (wu, wv) = (u - u0, v - v0);
        let at = |du: i64, dv: i64| self.pixel(u0 as i64 + du, v0 as i64 + dv);
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        let mix = |f: &dyn Fn(Pixel) -> f64| linear(linear(f(a), f(b), wu), linear(f(c), f(d), wu), wv);
        Pixel {
            colour: [0, 1, 2].map(|i| mix(&|p: Pixel| p.colour[i])),
            transparency: mix(&|p: Pixel| p.transparency),
        }
    }

    /// The viewer's image: pixel (X, Y) shows the picture at `map(X, Y)`, interpolated as [`ModelImage::bilinear`].
    pub fn warp(&self, size: [usize; 2], map: Affine) -> Self {
        Self::from_fn(size, |x, y| {
            let [u, v] = map.at(x as f64, y as f64);
            self.bilinear(u, v)
        })
    }
}

/// An affine map from pixels (X, Y) of the viewer's image to pixels (u, v) of the base plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// `u = u[0] + u[1] X + u[2] Y`.
    pub u: [f64; 3],
    /// `v = v[0] + v[1] X + v[2] Y`.
    pub v: [f64; 3],
}

impl Affine {
    /// u = X, v = Y.
    pub const IDENTITY: Self = Self {
        u: [0.0, 1.0, 0.0],
        v: [0.0, 0.0, 1.0],
    };

    /// The base-plane coordinate (u, v) of the point (X, Y).
    pub fn at(&self, x: f64, y: f64) -> [f64; 2] {
        [self.u, self.v].map(|[a0, a1, a2]| a0 + a1 * x + a2 * y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> ModelImage {
        ModelImage::from_fn([5, 3], |u, v| Pixel {
            colour: [u as f64 / 8.0, v as f64 / 8.0, (u * v) as f64 / 16.0],
            transparency: 1.0 - (u + v) as f64 / 16.0,
        })
    }

    #[test]
    fn the_identity_changes_nothing() {
        assert_eq!(picture().warp([5, 3], Affine::IDENTITY), picture());
    }

    #[test]
    fn whole_shifts_and_turns_move_pixels() {
        let shift = Affine {
            u: [-2.0, 1.0, 0.0],
            v: [1.0, 0.0, 1.0],
        };
        let turn = Affine {
            u: [4.0, 0.0, -1.0],
            v: [0.0, 1.0, 0.0],
        };
        let (shifted, turned) = (picture().warp([9, 9], shift), picture().warp([3, 5], turn));
        for x in 0..9 {
            for y in 0..9 {
                assert_eq!(shifted.pixel(x, y), picture().pixel(x - 2, y + 1));
            }
        }
        for x in 0..3 {
            for y in 0..5 {
                assert_eq!(turned.pixel(x, y), picture().pixel(4 - y, x));
            }
        }
    }

    /// u, v and u v are bilinear, so their interpolants are exact.
    #[test]
    fn between_pixels() {
        let p = picture().bilinear(2.25, 1.5);
        assert_eq!(p.colour, [2.25 / 8.0, 1.5 / 8.0, 2.25 * 1.5 / 16.0]);
        assert_eq!(p.transparency, 1.0 - 3.75 / 16.0);
    }

    #[test]
    fn the_edge_fades_over_one_pixel() {
        let solid = ModelImage::from_fn([2, 2], |_, _| Pixel::of_sample([1.0, 0.5, 0.0], 1.0));
        assert_eq!(solid.bilinear(-0.25, 0.5), Pixel::of_sample([1.0, 0.5, 0.0], 0.75));
        assert_eq!(solid.bilinear(1.75, 1.5), Pixel::of_sample([1.0, 0.5, 0.0], 0.125));
        for (u, v) in [
            (-1.0, 0.0),
            (2.0, 0.0),
            (0.0, 2.0),
            (0.0, -1.0),
            (1e300, 0.0),
            (f64::NAN, 0.0),
        ] {
            assert_eq!(solid.bilinear(u, v), Pixel::TRANSPARENT);
        }
    }
}
