//! Values in chunks.

use std::fmt::Debug;
use std::path::Path;

use super::error::ReadError;
use super::payload::Layout;
use super::values::Values;

/// An array in chunks, each read as a whole.
pub(super) trait Chunked: Debug + Send + Sync {
    /// The folder that is at fault where values are.
    fn folder(&self) -> &Path;
    /// Values of a chunk along x, y and z.
    fn side(&self) -> [u64; 3];
    /// Chunks along x, y and z.
    fn counts(&self) -> [u64; 3];
    /// Bytes that reading a chunk takes beside its values.
    fn reading_bytes(&self) -> u64;
    /// Some values of a chunk, as bytes in the array's order.
    ///
    /// # Errors
    /// [`ReadError`] if the chunk cannot be read.
    fn read(&self, chunk: [u64; 3], first: [u64; 3], dims: [u64; 3]) -> Result<Vec<u8>, ReadError>;
    /// All values.
    ///
    /// # Errors
    /// As [`Chunked::read`].
    fn values(&self, layout: &Layout) -> Result<Values, ReadError>;
}
