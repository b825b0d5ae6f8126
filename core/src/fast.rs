//! The stages of the `fast` precision: 16-bit lanes, products of 16 by 16 bits, no division and no root but a polynomial.
//!
//! Each stage is written once over [`Halves`](crate::lanes::Halves); with one lane it is the scalar definition. All numbers,
//! ranges and proofs: `docs/contract/fast.md`.
//!
//! | value | format | range |
//! |---|---|---|
//! | weight w | 0.15, the upper 15 bits of 0.16 | 0 to 32767 |
//! | sample s | 12.3 | 0 to 32760 |
//! | component of a gradient | s12.3, at faces of the volume s13.2 | -32763 to 32763 |
//! | square root q of an opacity | 0.16 | 0 to 65535 |
//! | cosine, power, light, colour | 16 bits, 65535 is 1 | 0 to 65535 |
//! | reciprocal length r | 2^23 / sqrt(h) of h, 16384 to 65535 | 32768 to 65535 |
//! | pixel | 16 bits, 65535 is 1 | 0 to 65535 |
//!
//! State: none.

pub mod fold;
pub mod light;
pub mod project;
pub mod sample;
pub mod table;
#[cfg(test)]
mod tests;

pub use self::light::{FastPhong, Light};
pub use self::project::FastProjection;
pub use self::table::{Colours, RootTable, Roots};
