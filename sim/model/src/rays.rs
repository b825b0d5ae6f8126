//! Where the rays run: major axis, shear, base plane, sample positions.
//!
//! Source: the project's conventions (design.md, section 2); the paper's section 4.6 for the sample's location along
//! a ray, here evaluated in one multiplication instead of by repeated addition.
//!
//! | value      | unit                                                                    |
//! | position   | voxels along i, j, k; 0 is the centre of the first voxel                |
//! | shear      | voxels along i (j) per voxel along k                                    |
//! | spacing    | the volume's unit of length per voxel                                   |
//!
//! The *frame* (i, j, k): k is the major axis of the view, flipped if need be so that it grows away from the eye;
//! i and j are the two other axes of the volume in increasing order, never flipped. It may be left-handed, so only
//! scalar products may be taken in it.

use slicecast_scene::{Borders, Sampling};

/// Half a unit of a 16.16 number: exact positions this far outside a face count as on it, because a position rounded
/// to 16.16 would have been.
const FACE_TOLERANCE: f64 = 1.0 / 131_072.0;

/// Slack of the natural lattice's ceilings, voxels: products that should be integers stay integers.
const CEIL_TOLERANCE: f64 = 1e-9;

/// A view of a volume, resolved into the frame (i, j, k).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// The volume's axis (0 = x, 1 = y, 2 = z) behind i, j and k; `order[2]` is the major axis.
    pub order: [usize; 3],
    /// Whether k runs against its axis of the volume.
    pub flipped: bool,
    /// Voxels that a ray moves along i and j per voxel along k, each within -1 to 1.
    pub shear: [f64; 2],
    /// Voxels along i, j and k: the paper's and design's W, H, D.
    pub dims: [usize; 3],
    /// Distance between voxels along i, j and k, in the volume's unit.
    pub spacing: [f64; 3],
    /// Sample planes per voxel along k.
    pub planes_per_voxel: usize,
    /// Rays per voxel along i and along j.
    pub rays_per_voxel: usize,
    /// Where the volume ends.
    pub borders: Borders,
    /// The box of the volume that counts, low and high face along i, j and k, voxels: all of it, or what a crop box leaves.
    pub faces: [[f64; 2]; 3],
    /// Whether the front or the back face may cut segments: a crop box's do, the volume's lie where segments end.
    pub cropped: bool,
}

/// The base plane's pixels: which rays exist.
///
/// Pixel (u, v) meets the plane k = 0 at voxel `origin + (u, v) / rays_per_voxel`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Voxel coordinate (i, j) of pixel (0, 0).
    pub origin: [i64; 2],
    /// Pixels along i and j, at full resolution (all phases).
    pub size: [usize; 2],
}

impl Geometry {
    /// Resolves a viewing direction.
    ///
    /// `forward`: from the eye into the scene, in world lengths along x, y, z (its magnitude does not matter);
    /// `dims`, `spacing`: the volume's, along x, y, z. In voxel units the direction is `v_a = forward_a / spacing_a`;
    /// the major axis has the largest |v_a|, ties going to z before y before x by exact comparison; shear =
    /// `(v_i, v_j) / |v_m|`.
    ///
    /// # Panics
    /// If the direction is zero or not finite, a dimension is zero, or a sampling rate is zero.
    pub fn new(forward: [f64; 3], dims: [usize; 3], spacing: [f64; 3], sampling: Sampling) -> Self {
        let v = [0, 1, 2].map(|a| forward[a] / spacing[a]);
        let mut major = 2;
        for axis in [1, 0] {
            if v[axis].abs() > v[major].abs() {
                major = axis;
            }
        }
        let speed = v[major].abs();
        assert!(speed > 0.0 && speed.is_finite(), "no viewing direction: {forward:?}");
        assert!(dims.iter().all(|&d| d > 0), "an empty volume: {dims:?}");
        assert!(
            sampling.planes_per_voxel > 0 && sampling.rays_per_voxel > 0,
            "a sampling rate is zero: {sampling:?}"
        );
        let order = match major {
            0 => [1, 2, 0],
            1 => [0, 2, 1],
            _ => [0, 1, 2],
        };
        Self {
            order,
            flipped: v[major] < 0.0,
            shear: [v[order[0]] / speed, v[order[1]] / speed],
            dims: order.map(|a| dims[a]),
            spacing: order.map(|a| spacing[a]),
            planes_per_voxel: sampling.planes_per_voxel as usize,
            rays_per_voxel: sampling.rays_per_voxel as usize,
            borders: Borders::Whole,
            faces: order.map(|a| [0.0, (dims[a] - 1) as f64]),
            cropped: false,
        }
    }

    /// The same view of a volume that ends elsewhere.
    pub fn with_borders(self, borders: Borders) -> Self {
        let ended = Self { borders, ..self };
        let beyond = ended.beyond();
        Self {
            faces: self.dims.map(|side| [-beyond, (side - 1) as f64 + beyond]),
            ..ended
        }
    }

    /// The same view of what a box leaves of the volume: its faces along x, y and z, voxels from the first one's centre.
    pub fn with_crop(self, faces: [[f64; 2]; 3]) -> Self {
        let last = (self.dims[2] - 1) as f64;
        let mut arranged = self.order.map(|a| faces[a]);
        if self.flipped {
            let [low, high] = arranged[2];
            arranged[2] = [last - high, last - low];
        }
        Self {
            faces: [0, 1, 2].map(|a| {
                let ([low, high], [from, to]) = (self.faces[a], arranged[a]);
                [low.max(from), high.min(to)]
            }),
            cropped: true,
            ..self
        }
    }

    /// The major axis of the volume: 0 = x, 1 = y, 2 = z.
    pub fn major(&self) -> usize {
        self.order[2]
    }

    /// Number of sample planes: `(D - 1) * planes_per_voxel + 1`, or one per segment of the box.
    pub fn planes(&self) -> usize {
        let slabs = |slices| slices * self.planes_per_voxel;
        match self.borders {
            Borders::Whole => slabs(self.dims[2] - 1) + 1,
            Borders::Cells => slabs(self.dims[2]),
            Borders::Nodes => slabs(self.dims[2] - 1),
        }
    }

    /// Planes before the first slice at which segments between samples end: as many as reach the box's front face.
    fn ends_before(&self) -> usize {
        (self.beyond() * self.planes_per_voxel as f64).ceil() as usize
    }

    /// Planes at which segments between samples end: those in slices, those between, and as many beyond both faces as reach
    /// the box's.
    pub fn ends(&self) -> usize {
        (self.dims[2] - 1) * self.planes_per_voxel + 1 + 2 * self.ends_before()
    }

    /// How far the box reaches beyond the outermost voxels, voxels.
    pub(super) fn beyond(&self) -> f64 {
        if self.borders == Borders::Cells { 0.5 } else { 0.0 }
    }

    /// World length of a ray between two sample planes, in the volume's unit:
    /// `sqrt((s_i sp_i)^2 + (s_j sp_j)^2 + sp_k^2) / planes_per_voxel`.
    pub fn step_length(&self) -> f64 {
        let [si, sj] = self.shear;
        let [pi, pj, pk] = self.spacing;
        ((si * pi).powi(2) + (sj * pj).powi(2) + pk * pk).sqrt() / self.planes_per_voxel as f64
    }

    /// World length of the diagonal of the volume's cells: no ray in it is longer.
    pub fn diagonal(&self) -> f64 {
        let side = |a: usize| (self.dims[a] as f64 * self.spacing[a]).powi(2);
        (side(0) + side(1) + side(2)).sqrt()
    }

    /// A world vector (x, y, z) in the frame: permuted, its major component negated if k is flipped.
    pub fn to_frame(&self, world: [f64; 3]) -> [f64; 3] {
        let [i, j, k] = self.order.map(|a| world[a]);
        [i, j, if self.flipped { -k } else { k }]
    }

    /// The smallest lattice of whole voxels that holds every ray meeting the volume.
    ///
    /// Of cells: the whole voxels around all places of k = 0 whose rays meet the box.
    ///
    /// Along i: origin `-ceil((D - 1) s)` if s > 0, else 0; `W + ceil((D - 1) |s|)` voxel columns of
    /// `rays_per_voxel` pixels each. Along j alike. The ceilings forgive 1e-9.
    pub fn natural_lattice(&self) -> Lattice {
        if self.borders == Borders::Cells || self.cropped {
            // From its front face to its back face a ray moves so far, of cells half a voxel of it before k = 0.
            let places = [0, 1].map(|a| {
                let (s, [low, high]) = (self.shear[a], self.faces[a]);
                let [front, back] = self.faces[2].map(|k| k * s);
                [low - front.max(back), high - front.min(back)]
            });
            let bounds = places.map(|[low, high]| [(low + CEIL_TOLERANCE).floor(), (high - CEIL_TOLERANCE).ceil()]);
            return Lattice {
                origin: bounds.map(|[low, _]| low as i64),
                size: bounds.map(|[low, high]| self.rays_per_voxel * ((high - low) as usize + 1)),
            };
        }
        let margin = |s: f64| ((self.dims[2] - 1) as f64 * s.abs() - CEIL_TOLERANCE).ceil().max(0.0) as usize;
        let origin = self.shear.map(|s| if s > 0.0 { -(margin(s) as i64) } else { 0 });
        let size = [0, 1].map(|a| self.rays_per_voxel * (self.dims[a] + margin(self.shear[a])));
        Lattice { origin, size }
    }

    /// Where the ray of pixel (u, v) meets a sample plane, unrounded and whether inside the volume or not:
    /// `z = plane / r`, `x = o_i + u / n + z s_i`, `y = o_j + v / n + z s_j`; with exact borders z is the middle of the
    /// segment. Voxels.
    pub fn position(&self, lattice: Lattice, plane: usize, u: usize, v: usize) -> [f64; 3] {
        let middle = if self.borders == Borders::Whole { 0.0 } else { 0.5 };
        let z = (plane as f64 + middle) / self.planes_per_voxel as f64 - self.beyond();
        let along = |axis: usize, pixel: usize| {
            lattice.origin[axis] as f64 + pixel as f64 / self.rays_per_voxel as f64 + z * self.shear[axis]
        };
        [along(0, u), along(1, v), z]
    }

    /// Where the ray of pixel (u, v) lies at a place among the planes at which segments end: their number, or between two.
    pub fn place(&self, lattice: Lattice, place: f64, u: usize, v: usize) -> [f64; 3] {
        let z = (place - self.ends_before() as f64) / self.planes_per_voxel as f64;
        let along = |axis: usize, pixel: usize| {
            lattice.origin[axis] as f64 + pixel as f64 / self.rays_per_voxel as f64 + z * self.shear[axis]
        };
        [along(0, u), along(1, v), z]
    }

    /// What of a ray's segment lies in the box, 0 to 1, from where its middle lies: between the entries into its pairs of
    /// faces and the exits from them; the volume's front and back face cut none. With [`Borders::Whole`] everything is inside.
    pub fn fraction(&self, middle: [f64; 3]) -> f64 {
        let [from, to] = self.part(middle);
        (to - from).max(0.0)
    }

    /// From where to where the segment behind a plane at which segments end lies in the box, 0 to 1, front and back face
    /// included; `None` if nothing of it does.
    pub fn cut(&self, lattice: Lattice, plane: usize, u: usize, v: usize) -> Option<[f64; 2]> {
        let front = self.place(lattice, plane as f64, u, v);
        let [from, to] = self.clipped(&front, [0.0, 1.0]);
        (from < to).then_some([from, to])
    }

    /// What of a stretch of a ray, in segments from some place of it, lies between the pairs of faces of the first axes.
    fn clipped(&self, place: &[f64], [mut from, mut to]: [f64; 2]) -> [f64; 2] {
        let [si, sj] = self.shear;
        for ((at, shear), [low, high]) in place.iter().zip([si, sj, 1.0]).zip(self.faces) {
            let step = shear / self.planes_per_voxel as f64;
            if step == 0.0 {
                if !(low..=high).contains(at) {
                    return [0.0; 2];
                }
                continue;
            }
            let [a, b] = [low, high].map(|face| (face - at) / step);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        [from, to]
    }

    /// Where the segment about a sample begins, whose middle is given.
    pub fn front(&self, middle: [f64; 3]) -> [f64; 3] {
        let way = self.way();
        [0, 1, 2].map(|axis| middle[axis] - way[axis] / 2.0)
    }

    /// The way of a ray along a segment, voxels along i, j and k.
    pub fn way(&self) -> [f64; 3] {
        let [si, sj] = self.shear;
        [si, sj, 1.0].map(|way| way / self.planes_per_voxel as f64)
    }

    /// The part of a ray's segment that lies in the box, 0 to 1, from where its middle lies: what [`Geometry::fraction`]
    /// measures.
    pub fn part(&self, middle: [f64; 3]) -> [f64; 2] {
        if self.borders == Borders::Whole {
            return [0.0, 1.0];
        }
        let axes = if self.cropped { 3 } else { 2 };
        self.clipped(&middle[..axes], [-0.5, 0.5]).map(|place| place + 0.5)
    }

    /// A position held to the voxels.
    pub fn held(&self, position: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|a| position[a].clamp(0.0, (self.dims[a] - 1) as f64))
    }

    /// The position itself if it lies in the volume (faces included), else `None`. For positions that are already
    /// rounded to the pipeline's format.
    pub fn inside(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let within = |a: usize| (0.0..=(self.dims[a] - 1) as f64).contains(&position[a]);
        (within(0) && within(1) && within(2)).then_some(position)
    }

    /// As [`Geometry::inside`], for unrounded positions: up to 2^-17 voxel outside a face still belongs to it and is
    /// moved onto it.
    pub fn inside_tolerant(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let mut clamped = position;
        for (c, &dim) in clamped.iter_mut().zip(&self.dims) {
            let last = (dim - 1) as f64;
            if !(-FACE_TOLERANCE..=last + FACE_TOLERANCE).contains(c) {
                return None;
            }
            *c = c.clamp(0.0, last);
        }
        Some(clamped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONCE: Sampling = Sampling {
        planes_per_voxel: 1,
        rays_per_voxel: 1,
    };

    fn cube(forward: [f64; 3]) -> Geometry {
        Geometry::new(forward, [4, 5, 6], [1.0; 3], ONCE)
    }

    #[test]
    fn order_of_axes_and_flips() {
        assert_eq!(cube([0.1, 0.2, 0.9]).order, [0, 1, 2]);
        assert_eq!(cube([0.1, -0.9, 0.2]).order, [0, 2, 1]);
        assert_eq!(cube([0.9, 0.1, 0.2]).order, [1, 2, 0]);
        assert!(!cube([0.1, 0.2, 0.9]).flipped);
        assert!(cube([0.1, -0.9, 0.2]).flipped);
        assert_eq!(cube([0.1, -0.9, 0.2]).dims, [4, 6, 5]);
        assert_eq!(cube([-0.9, 0.1, 0.2]).dims, [5, 6, 4]);
        assert_eq!(cube([-2.0, 1.0, -0.5]).shear, [0.5, -0.25]);
        assert_eq!(cube([-2.0, 1.0, -0.5]).to_frame([1.0, 2.0, 3.0]), [2.0, 3.0, -1.0]);
    }

    #[test]
    fn ties_go_to_z_then_y() {
        for sign in [1.0, -1.0] {
            assert_eq!(cube([1.0, 1.0, sign]).major(), 2);
            assert_eq!(cube([1.0, 0.0, sign]).major(), 2);
            assert_eq!(cube([0.0, sign, 1.0]).major(), 2);
            assert_eq!(cube([sign, 1.0, 0.0]).major(), 1);
            assert_eq!(cube([sign, 1.0, 0.0]).shear, [sign, 0.0]);
        }
        // The smallest difference decides.
        assert_eq!(cube([1.0_f64.next_up(), 1.0, 1.0]).major(), 0);
    }

    #[test]
    fn the_major_axis_is_chosen_in_voxel_units() {
        // 45 degrees in the world, but z voxels are half as long: twice as many are crossed.
        let g = Geometry::new([1.0, 0.0, 1.0], [4, 5, 6], [1.0, 1.0, 0.5], ONCE);
        assert_eq!((g.major(), g.shear), (2, [0.5, 0.0]));
        let g = Geometry::new([1.0, 0.0, 1.0], [4, 5, 6], [0.5, 1.0, 1.0], ONCE);
        assert_eq!((g.major(), g.shear), (0, [0.0, 0.5]));
    }

    #[test]
    fn step_length_is_the_path_over_one_plane() {
        // A unit vector f crosses one voxel of the major axis after spacing / |f|.
        let f = [0.48, -0.6, 0.64];
        for spacing in [[1.0, 1.0, 1.0], [0.7, 1.1, 0.4], [0.3, 1.1, 0.9]] {
            let sampling = Sampling {
                planes_per_voxel: 3,
                rays_per_voxel: 1,
            };
            let g = Geometry::new(f, [4, 5, 6], spacing, sampling);
            let m = g.major();
            let expected = spacing[m] / f[m].abs() / 3.0;
            assert!((g.step_length() - expected).abs() < 1e-15, "{spacing:?}");
        }
    }

    #[test]
    fn natural_lattice_holds_every_ray_and_no_spare_column() {
        // D = 6: 5 * 0.25 = 1.25 and 5 * -0.4 = -2 exactly.
        let g = cube([0.25, -0.4, 1.0]);
        let expected = Lattice {
            origin: [-2, 0],
            size: [4 + 2, 5 + 2],
        };
        assert_eq!(g.natural_lattice(), expected);
        let g = Geometry {
            rays_per_voxel: 3,
            ..cube([0.25, -0.4, 1.0])
        };
        assert_eq!(g.natural_lattice().size, [18, 21]);
        assert_eq!(g.natural_lattice().origin, [-2, 0]);
        // Axis-aligned: the volume's own face.
        assert_eq!(cube([0.0, 0.0, 1.0]).natural_lattice().size, [4, 5]);
    }

    #[test]
    fn positions_follow_the_shear_and_the_phase() {
        let sampling = Sampling {
            planes_per_voxel: 4,
            rays_per_voxel: 2,
        };
        let g = Geometry::new([0.25, -0.5, 1.0], [4, 5, 6], [1.0; 3], sampling);
        let lattice = Lattice {
            origin: [-3, 2],
            size: [99, 99],
        };
        assert_eq!(g.planes(), 21);
        assert_eq!(
            g.position(lattice, 6, 5, 3),
            [-3.0 + 2.5 + 0.375, 2.0 + 1.5 - 0.75, 1.5]
        );
    }

    /// Ends lie in every slice, and what the box leaves of a ray's segments is the ray from its entry to its exit.
    #[test]
    fn cut_segments_are_the_ray_in_the_box() {
        for (borders, before) in [(Borders::Cells, [1, 1, 2, 2]), (Borders::Nodes, [0; 4])] {
            for (planes_per_voxel, before) in (1..).zip(before) {
                let g = Geometry {
                    planes_per_voxel,
                    rays_per_voxel: 2,
                    ..cube([0.25, -0.4, 1.0]).with_borders(borders)
                };
                assert_eq!(g.ends(), 5 * planes_per_voxel + 1 + 2 * before);
                let lattice = g.natural_lattice();
                let [width, height] = lattice.size;
                let mut longest: f64 = 0.0;
                for (u, v) in (0..width).flat_map(|u| (0..height).map(move |v| (u, v))) {
                    let pieces = (0..g.ends() - 1).filter_map(|plane| g.cut(lattice, plane, u, v));
                    let sum: f64 = pieces.map(|[from, to]| to - from).sum();
                    let first = g.place(lattice, 0.0, u, v);
                    let [from, to] = g.clipped(&first, [0.0, (g.ends() - 1) as f64]);
                    assert!((sum - (to - from).max(0.0)).abs() < 1e-9, "{borders:?} {u} {v}: {sum}");
                    longest = longest.max(sum);
                }
                let slices = if borders == Borders::Cells { 6 } else { 5 };
                assert!((longest - (slices * planes_per_voxel) as f64).abs() < 1e-9, "{longest}");
                assert_eq!(g.place(lattice, before as f64, 0, 0)[2], 0.0);
            }
        }
    }

    #[test]
    fn faces_belong_to_the_volume() {
        let g = cube([0.0, 0.0, 1.0]);
        let half = FACE_TOLERANCE;
        assert_eq!(g.inside([0.0, 4.0, 5.0]), Some([0.0, 4.0, 5.0]));
        assert_eq!(g.inside([-1e-12, 4.0, 5.0]), None);
        assert_eq!(g.inside_tolerant([-half, 4.0 + half, 5.0]), Some([0.0, 4.0, 5.0]));
        assert_eq!(g.inside_tolerant([-half * 1.001, 0.0, 0.0]), None);
        assert_eq!(g.inside_tolerant([3.0 + half * 1.001, 0.0, 0.0]), None);
    }
}
