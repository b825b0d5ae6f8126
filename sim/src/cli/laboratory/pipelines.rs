//! Pipelines of 8 bits by their names, and the table of what they show.

use clap::ValueEnum;
use comfy_table::Table;
use slicecast_laboratory::texture::arithmetic::Product;
use slicecast_laboratory::texture::{Line, Order, Texture8};

use crate::cli::tables::{header, short};

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

/// Pictures against f64 of their samples, and against the converged integral.
pub fn table(lines: &[Line]) -> Table {
    let mut table = header(&[
        "base plane, steps of 1/255",
        "to f64: equal %",
        "max",
        "mean",
        "to integral: equal %",
        "max",
        "mean",
        "within 8 steps %",
    ]);
    for line in lines {
        let figures = [line.samples, line.converged]
            .map(|f| [format!("{:.2}", f.equal_percent), short(f.max_lsb8), short(f.mean_lsb8)]);
        let within = format!("{:.2}", line.within);
        table.add_row(
            [line.who.clone()]
                .into_iter()
                .chain(figures.into_iter().flatten())
                .chain([within]),
        );
    }
    table
}
