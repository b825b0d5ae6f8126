//! The `slicecast` program.
fn main() {}
