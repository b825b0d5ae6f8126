//! A scene on a volume as integers: all that a device or a test bench needs to render it to the same bits.
//!
//! [`Numbers`] holds what the engine hands to the pipeline, [`quantity`] lists it with names, widths and units. The list
//! becomes JSON or files for `$readmemh`; for Rust and C the numbers become calls of the library.
//! [`table::table`] is the one way of writing a table of points as text, [`integrals::integrals`] of one of integrals.

mod c;
mod hex;
pub mod integrals;
mod json;
mod numbers;
pub mod quantity;
mod rust;
pub mod table;

use slicecast::slice::SliceError;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::{Turned, packed};

pub use numbers::{Numbers, Shading};

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A module without std.
    Rust,
    /// A header to use with `slicecast.h`.
    C,
    /// All integers with names, widths and units.
    Json,
    /// A file for `$readmemh` per quantity, and a manifest.
    Hex,
}

/// Why a scene is not exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The scene does not fit the pipeline.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The volume is not one.
    #[error("the volume: {0}")]
    Volume(#[from] SliceError),
    /// The C interface has no such pipeline.
    #[error("--format c: the C interface has no pipeline {given}; accepted: {accepted}")]
    NoPipeline {
        /// What the scene asks for.
        given: String,
        /// What there is.
        accepted: &'static str,
    },
    /// The name is no name of a file and of a variable.
    #[error("--name {name}: expected letters, digits and _, not beginning with a digit, and not slicecast")]
    Name {
        /// The name given.
        name: String,
    },
}

/// The files of an exported scene, by name. `name` begins their names (but for those of [`Format::Hex`]); with `voxels` they hold the volume too, slice after
/// slice in the order in which a view front to back meets them.
///
/// # Errors
/// [`ExportError`]; there is nothing to write then.
pub fn files(
    prepared: &Prepared<'_>,
    format: Format,
    name: &str,
    voxels: bool,
) -> Result<Vec<(String, String)>, ExportError> {
    let first = name.chars().next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    let rest = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !first || !rest || name.eq_ignore_ascii_case("slicecast") {
        return Err(ExportError::Name { name: name.to_owned() });
    }
    prepared.check_unclipped()?;
    let numbers = Numbers::of(prepared)?;
    let voxels = if voxels { Some(slices(prepared)?) } else { None };
    let voxels = voxels.as_deref();
    match format {
        Format::Rust => Ok(rust::files(&numbers, name, voxels)),
        Format::C => c::files(&numbers, name, voxels),
        Format::Json => Ok(json::files(&numbers, name, voxels)),
        Format::Hex => Ok(hex::files(&numbers, voxels)),
    }
}

/// The voxels of all slices, nearest first.
fn slices(prepared: &Prepared<'_>) -> Result<Vec<u16>, SliceError> {
    let mut turned = Turned::new(prepared.volume, &prepared.setup.plan);
    Ok(turned.slices()?.iter().flat_map(packed).collect())
}
