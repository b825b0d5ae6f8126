//! The figures of the paper, remade: sampling and filtering by extinctions beside the same by opacities.
//!
//! | file    | the paper's                                                        |
//! | ------- | ------------------------------------------------------------------ |
//! | rays    | figures 1 and 4: a ray through one layer; 5 and 6: a wall          |
//! | points  | figure 7: an opaque voxel from all sides                           |
//! | filters | section 4.2: how far a pyramid is from a convolution               |
//! | layers  | figures 2 and 3, section 4.1: what levels keep of sheets and points |

pub mod filters;
pub mod layers;
pub mod points;
pub mod rays;
