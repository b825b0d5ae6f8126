//! Volumes of colour and extinction, and pyramids of them.
//!
//! Source: Kraus and Bürger, "Interpolating and Downsampling RGBA Volume Data", 2008 (*the paper*).
//!
//! | file    | what it holds                                                                |
//! | ------- | ---------------------------------------------------------------------------- |
//! | voxel   | the voxel in four bytes, and the codes that it decodes to                    |
//! | volume  | a volume of them                                                             |
//! | read    | volumes from files of colours and opacities, and from scalars                |
//! | write   | volumes to NRRD                                                              |
//! | filter  | filters that halve an axis                                                   |
//! | reduce  | a level from the one below it, in integers                                   |
//! | materials | volumes of shares of materials, and a table of these                       |
//! | opacity | the same by opacities, for comparison                                        |
//! | scalar  | levels of volumes of one value a voxel                                       |
//! | pyramid | level after level                                                            |
//! | figures | the paper's figures, in f64                                                  |
//!
//! Rounding, ranges and errors of each are in its file; docs/pyramids.md has them together, with what was measured.

pub mod figures;
pub mod filter;
pub mod materials;
mod opacity;
pub mod pyramid;
pub mod read;
pub mod reduce;
pub mod scalar;
pub mod volume;
pub mod voxel;
pub mod write;
