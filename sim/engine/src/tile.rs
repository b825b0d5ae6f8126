//! Tiles: what of a base plane one thread folds.

/// Rows of the base plane that one thread takes through all slices at a time.
pub const TILE_ROWS: usize = 32;

/// Some rows of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Number of the phase.
    pub phase: u32,
    /// First row.
    pub first: u32,
    /// Number of rows.
    pub rows: u32,
}
