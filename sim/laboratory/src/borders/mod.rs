//! The figures and the table of LaMar, Interactive Border Sampling, remade by the engine: whole steps beside exact borders.

pub mod cost;
pub mod figures;
pub mod plot;
pub(crate) mod rays;
pub mod seams;
