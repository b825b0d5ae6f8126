//! Shards of a frame: the tiles of the base plane that one machine of several renders. Rays do not read each other, so that the
//! shards of a frame, put together, are the frame to the bit.

use slicecast::plan::Plan;

use crate::tile::TILE_ROWS;
use crate::tile::Tile;

/// One shard of several: every `count`-th tile, because those in the middle of the base plane have more to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    count: u32,
}

impl Shard {
    /// The whole frame.
    pub const ALL: Self = Self { number: 1, count: 1 };

    /// Shard `number`, from 1, of `count`; `None` if there is no such shard.
    pub const fn new(number: u32, count: u32) -> Option<Self> {
        if number == 0 || number > count {
            return None;
        }
        Some(Self { number, count })
    }

    /// Its number, from 1.
    pub const fn number(self) -> u32 {
        self.number
    }

    /// How many shards the frame has.
    pub const fn count(self) -> u32 {
        self.count
    }

    /// Tiles of a frame, those of its phases together: the largest number of shards of which none is empty.
    pub fn most(plan: &Plan) -> u32 {
        plan.base()[1].div_ceil(TILE_ROWS as u32)
    }

    /// Whether a tile of rows of this number belongs to it.
    pub(crate) const fn holds(self, tile: Tile, rows: u32) -> bool {
        tile.first / (if rows == 0 { 1 } else { rows }) % self.count == self.number - 1
    }

    /// The rows of a base-plane image whose phases, `n` along each axis, are interleaved.
    pub fn rows(self, height: usize, n: usize) -> impl Iterator<Item = usize> {
        let (number, count) = (self.number as usize, self.count as usize);
        (0..height).filter(move |row| row / n / TILE_ROWS % count == number - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_one_shard() {
        for (height, n, count) in [(1, 1, 1), (100, 1, 3), (200, 2, 4), (1000, 4, 8)] {
            let mut times = vec![0; height];
            for number in 1..=count {
                let shard = Shard::new(number, count).unwrap();
                shard.rows(height, n).for_each(|row| times[row] += 1);
            }
            assert_eq!(times, vec![1; height]);
        }
        assert_eq!(Shard::new(0, 3), None);
        assert_eq!(Shard::new(4, 3), None);
        assert_eq!(Shard::ALL.rows(5, 2).count(), 5);
    }
}
