//! Volumes of one slice, made thick enough to be seen.
//!
//! Between the first and the last voxel of an axis of one voxel there is no length that a ray could cross. Cells have one.

use slicecast_scene::Borders;
use slicecast_volume::Volume;

/// Doubles every slice that stands alone, one spacing apart, where the volume ends at its outermost voxels; gives what is to
/// be said about it.
pub fn thicken(volume: &mut Volume, borders: Borders) -> Option<String> {
    if borders == Borders::Cells {
        return None;
    }
    let single: Vec<usize> = (0..3).filter(|&axis| volume.dims[axis] == 1).collect();
    for &axis in &single {
        let [nx, ny, _] = volume.dims;
        let run = [1, nx, nx * ny][axis];
        volume.voxels = volume
            .voxels
            .chunks(run)
            .flat_map(|run| [run, run])
            .flatten()
            .copied()
            .collect();
        volume.dims[axis] = 2;
    }
    let names: Vec<&str> = single.iter().map(|&axis| ["x", "y", "z"][axis]).collect();
    (!names.is_empty()).then(|| {
        format!(
            "one slice along {} has no thickness: it is drawn twice, one spacing apart",
            names.join(" and ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_volume::Mapping;

    fn thick_with(dims: [usize; 3], borders: Borders) -> (Vec<u16>, [usize; 3], Option<String>) {
        let mut volume = Volume {
            name: "t".into(),
            dims,
            spacing: [1.0; 3],
            voxels: (0..dims.iter().product::<usize>() as u16).collect(),
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        };
        let note = thicken(&mut volume, borders);
        (volume.voxels, volume.dims, note)
    }

    fn thick(dims: [usize; 3]) -> (Vec<u16>, [usize; 3], Option<String>) {
        let whole = thick_with(dims, Borders::Whole);
        assert_eq!(whole, thick_with(dims, Borders::Nodes));
        whole
    }

    #[test]
    fn a_cell_has_a_thickness() {
        assert_eq!(
            thick_with([2, 2, 1], Borders::Cells),
            ((0..4).collect(), [2, 2, 1], None)
        );
    }

    #[test]
    fn slices_that_stand_alone_are_drawn_twice() {
        assert_eq!(thick([2; 3]), ((0..8).collect(), [2; 3], None));
        let (voxels, dims, note) = thick([2, 2, 1]);
        assert_eq!((voxels, dims), (vec![0, 1, 2, 3, 0, 1, 2, 3], [2; 3]));
        assert!(note.unwrap().starts_with("one slice along z"));
        assert_eq!(thick([1, 2, 2]).0, [0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!(thick([2, 1, 2]).0, [0, 1, 0, 1, 2, 3, 2, 3]);
        assert_eq!(thick([1; 3]).0, [0; 8]);
    }
}
