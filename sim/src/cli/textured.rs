//! Pipelines of 8 bits by their names.

use clap::ValueEnum;
use slicecast_laboratory::texture::arithmetic::Product;
use slicecast_laboratory::texture::{Order, Texture8};

use super::Failure;

/// What texture hardware of 8 bits computes: classified after its filter, with normals as the filter has them (post) or brought to
/// their length again (normalised), or before, with colours as they are (pre) or times opacity (weighted); products to nearest after
/// Blinn, or by one shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Texture8Arg {
    Post,
    PostShift,
    Normalised,
    NormalisedShift,
    Pre,
    PreShift,
    Weighted,
    WeightedShift,
}

impl From<Texture8Arg> for Texture8 {
    fn from(arg: Texture8Arg) -> Self {
        match arg {
            Texture8Arg::Post => Self::of(Order::After, Product::Blinn),
            Texture8Arg::PostShift => Self::of(Order::After, Product::Shift),
            Texture8Arg::Normalised => Self::of(Order::Normalised, Product::Blinn),
            Texture8Arg::NormalisedShift => Self::of(Order::Normalised, Product::Shift),
            Texture8Arg::Pre => Self::of(Order::Before, Product::Blinn),
            Texture8Arg::PreShift => Self::of(Order::Before, Product::Shift),
            Texture8Arg::Weighted => Self::of(Order::Weighted, Product::Blinn),
            Texture8Arg::WeightedShift => Self::of(Order::Weighted, Product::Shift),
        }
    }
}

/// For a volume of colours, which they do not know.
pub fn check_none(asked: bool) -> Result<(), Failure> {
    if asked {
        return Err(Failure::input(
            "--texture8: pipelines of 8 bits are of volumes of one value a voxel, expected no volume of colours and no --level",
        ));
    }
    Ok(())
}
