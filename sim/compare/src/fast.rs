//! The model beside 16-bit lanes: their rows, as the lock-step reads those of other precisions.

use slicecast::locate::{Plane, cell};
use slicecast::plan::Plan;
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits, Tap};

use crate::lockstep::Lockstep;
use slicecast_engine::camera::Setup;
use slicecast_engine::tile::Tile;
use slicecast_model::Model;
use slicecast_scene::Blend;

/// A lock-step with the `fast` precision.
pub struct FastLockstep<'a> {
    /// What is gathered.
    pub lockstep: Lockstep<'a>,
    plan: Plan,
}

impl<'a> FastLockstep<'a> {
    /// A tap for a tile.
    pub fn new(model: &'a Model<'a>, setup: &Setup, blend: Blend, tile: Tile) -> Self {
        Self {
            lockstep: Lockstep::of_fast(model, setup, blend, tile),
            plan: setup.plan,
        }
    }

    /// Whether a component of the sample's gradient is one-sided: then all three are halved (docs/contract/fast.md).
    fn at_face(&self, plane: &Plane, pixel: [u32; 2]) -> bool {
        let steps = [pixel[0] as i32, pixel[1] as i32, 0];
        let places = [plane.x, plane.y, plane.z].map(cell);
        (places.iter().zip(steps).zip(self.plan.dims())).any(|((place, step), voxels)| {
            let (index, mixes) = (place.index + step, place.weight.to_bits() > 1);
            index <= 0 || index >= voxels as i32 - 1 - i32::from(mixes)
        })
    }
}

impl Tap for FastLockstep<'_> {
    fn plane(&mut self, plane: &Plane) {
        self.lockstep.plane(plane);
    }

    fn row(&mut self, stage: Stage, at: Beam<'_>, rows: &[&dyn Bits]) {
        if stage != Stage::Gradient {
            return self.lockstep.row(stage, at, rows);
        }
        let whole = |row: &&dyn Bits| -> Vec<i32> {
            let of = |offset: usize| {
                let component = i32::from(row.bits(offset) as i16);
                component << u32::from(self.at_face(at.plane, [at.column + offset as u32, at.row]))
            };
            (0..row.len()).map(of).collect()
        };
        let rows: Vec<Vec<i32>> = rows.iter().map(whole).collect();
        if let [x, y, z] = &rows[..] {
            self.lockstep.row(stage, at, &[&&x[..], &&y[..], &&z[..]]);
        }
    }
}
