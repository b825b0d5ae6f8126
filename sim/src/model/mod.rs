//! The f64 model.
