//! The whole model against closed-form answers, written without the model's code.

mod fields;
mod fog;
mod symmetry;
