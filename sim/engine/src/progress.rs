//! What looks on while a frame is folded.

use slicecast::tap::Tap;

use crate::tile::Tile;

/// What is told how many steps of how many are done.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// Lends a tap of the tile's own to a fold.
pub type LendTap<'a> = &'a (dyn Fn(Tile, &mut dyn FnMut(&mut dyn Tap)) + Sync);
