//! The f64 model: what the picture would be if numbers were real.
//!
//! Written ray by ray from the equations of Bitter, Neophytou, Mueller and Kaufman, "Squeeze: Numerical-Precision-
//! Optimized Volume Rendering", 2004 (*the paper*), and from the project's conventions, independently of the
//! pipeline that it judges: no code, table or number format of the core is used here. Every stage is a pure function
//! that can also be called on the pipeline's own (dequantised) inputs, which gives that stage's local error; the
//! whole model gives the error carried from the beginning.
//!
//! | file        | stage                                                      | paper           |
//! | rays        | major axis, shear, lattice of rays, sample positions       | section 4.6     |
//! | grid        | voxels in the frame (i, j, k), differences of neighbours   | section 4.3     |
//! | interpolate | value at a position                                        | equations 13-14 |
//! | gradient    | gradient at a position, normal                             | section 4.3     |
//! | spline      | value and slopes by quadratic B-splines, in place of both  | de Boor         |
//! | classify    | colour and opacity of a value, correction for the step     | equation 7      |
//! | segment     | colour and opacity between two samples                     | Engel et al., 5, 6 |
//! | clip        | what clip planes leave of a segment, and of a place          | Pfister et al. 1999 |
//! | parts       | segments cut at isosurfaces and into pieces                | Engel et al., section 5 |
//! | shade       | Phong                                                      | equation 10     |
//! | composite   | samples into pixels                                        | equations 4, 6  |
//! | warp        | base plane into the viewer's image                         |                 |
//! | render      | one ray, all rays                                          |                 |
//! | perspective | the same of rays from an eye                               | equation 7      |
//! | splat       | voxels into sheets of the image, in place of rays            | section 4.6     |
//! | absorb      | rays through volumes of colour and extinction | Kraus and Bürger, section 3.4 |
//! | levels      | rays through boxes of several levels | LaMar, section 4 |
//! | pyramid     | volumes of half the voxels                                 | Kraus and Bürger, section 4 |
//! | integral    | one ray without planes and steps: the converged picture    | equation 7      |
//!
//! Two things are left out on purpose, because they are the pipeline's approximations and should show up as its
//! error: tables (the transfer function is evaluated at the sample itself) and early termination.

mod absorb;
pub mod classify;
pub mod clip;
pub mod composite;
pub mod gradient;
pub mod grid;
mod integral;
pub mod interpolate;
mod levels;
mod modulation;
mod parts;
pub mod perspective;
pub mod pyramid;
pub mod rays;
mod render;
mod segment;
pub mod shade;
pub mod splat;
pub mod spline;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod vector;
pub mod warp;

pub use absorb::{Absorbing, Interpolated};
pub use classify::Classified;
pub use clip::Left;
pub use composite::Pixel;
pub use levels::{BoxOfLevel, Levels};
pub use modulation::Weights;
pub use parts::{Crossing, Part};
pub use rays::{Geometry, Lattice};
pub use render::{Model, ModelSample, Place, Positions, Segments, between};
pub use shade::Lights;
pub use warp::{Affine, ModelImage};
