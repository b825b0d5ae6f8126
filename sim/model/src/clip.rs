//! Clip planes in real numbers: how far a place lies behind each face, and what they leave of a stretch of a ray.
//!
//! A face of a plane leaves what has a distance of 0 and more from it. With a falloff F that is longer than a segment's change of
//! distance it fades instead: the optical depth about a place of distance v counts by `1/2 + v / F`, held to 0 and 1.

use super::rays::Geometry;
use slicecast_scene::clip::Clip;
use slicecast_scene::cueing::Cueing;

/// A distance that is linear in the place, along i, j and k.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Linear {
    slope: [f64; 3],
    first: f64,
}

impl Linear {
    /// Of slopes along x, y and z, and the distance of the first voxel.
    fn of(slope: [f64; 3], first: f64, geometry: &Geometry) -> Self {
        let [i, j, k] = geometry.order.map(|axis| slope[axis]);
        let last = (geometry.dims[2] - 1) as f64;
        if geometry.flipped {
            Self {
                slope: [i, j, -k],
                first: first + k * last,
            }
        } else {
            Self {
                slope: [i, j, k],
                first,
            }
        }
    }

    /// By how much it grows along a way.
    fn along(&self, way: [f64; 3]) -> f64 {
        (0..3).map(|axis| self.slope[axis] * way[axis]).sum()
    }

    fn at(&self, place: [f64; 3]) -> f64 {
        self.first + self.along(place)
    }
}

/// What a geometry has along i, j and k, along x, y and z.
fn along_axes<T: Copy + Default>(geometry: &Geometry, values: [T; 3]) -> [T; 3] {
    let mut out = [T::default(); 3];
    for (axis, value) in geometry.order.into_iter().zip(values) {
        out[axis] = value;
    }
    out
}

/// A clip plane along i, j and k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    distance: Linear,
    thickness: Option<f64>,
    falloff: f64,
    outside: bool,
}

/// What is left of a stretch: from where to where, 0 to 1, and which share of its optical depth there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// The share.
    pub fade: f64,
}

impl Left {
    /// All of it.
    pub const WHOLE: Self = Self {
        from: 0.0,
        to: 1.0,
        fade: 1.0,
    };

    fn and(self, other: Self) -> Self {
        Self {
            from: self.from.max(other.from),
            to: self.to.min(other.to),
            fade: self.fade * other.fade,
        }
    }

    /// What is left of another stretch, which lies from one place of this one to another.
    fn of(self, [from, to]: [f64; 2]) -> Self {
        let place = |at: f64| ((at - from) / (to - from)).clamp(0.0, 1.0);
        Self {
            from: place(self.from),
            to: place(self.to),
            fade: self.fade,
        }
    }

    /// The share of the stretch's optical depth that counts.
    pub fn weight(self) -> f64 {
        (self.to - self.from).max(0.0) * self.fade
    }

    /// What values there are at both ends of what is left, the value being linear.
    pub fn ends(self, [front, back]: [f64; 2]) -> [f64; 2] {
        [self.from, self.to].map(|t| front + (back - front) * t)
    }
}

impl ClipPlane {
    /// A scene's plane in a geometry.
    pub fn of(clip: &Clip, geometry: &Geometry) -> Self {
        let plane = clip.in_voxels(along_axes(geometry, geometry.spacing));
        Self {
            distance: Linear::of(plane.slope, plane.distance, geometry),
            thickness: plane.thickness,
            falloff: plane.falloff,
            outside: clip.outside,
        }
    }

    /// The distance of a place.
    pub fn distance(&self, at: [f64; 3]) -> f64 {
        self.distance.at(at)
    }

    /// What it leaves of a segment that begins at a place and goes this way.
    fn left(&self, front: [f64; 3], way: [f64; 3]) -> Left {
        let (front, along) = (self.distance(front), self.distance.along(way));
        let face = |front: f64, along: f64| {
            if self.falloff > along.abs() {
                return Left {
                    fade: (0.5 + (front + along / 2.0) / self.falloff).clamp(0.0, 1.0),
                    ..Left::WHOLE
                };
            }
            let back = front + along;
            let (from, to) = match (front >= 0.0, back >= 0.0) {
                (true, true) => (0.0, 1.0),
                (false, false) => (1.0, 0.0),
                (false, true) => (-front / along, 1.0),
                (true, false) => (0.0, -front / along),
            };
            Left { from, to, fade: 1.0 }
        };
        let near = face(front, along);
        let inside = match self.thickness {
            None => near,
            Some(thickness) => near.and(face(thickness - front, -along)),
        };
        if !self.outside {
            return inside;
        }
        let Left { from, to, fade } = inside;
        if fade == 1.0 && to > from && from == 0.0 {
            Left {
                from: to,
                ..Left::WHOLE
            }
        } else if fade == 1.0 && to > from && to == 1.0 {
            Left {
                to: from,
                ..Left::WHOLE
            }
        } else {
            Left {
                fade: 1.0 - inside.weight(),
                ..Left::WHOLE
            }
        }
    }

    /// The share of the optical depth at a place that counts, without segments: a hard face leaves all or nothing.
    pub fn share(&self, at: [f64; 3]) -> f64 {
        let face = |distance: f64| match self.falloff {
            0.0 => f64::from(distance >= 0.0),
            falloff => (0.5 + distance / falloff).clamp(0.0, 1.0),
        };
        let distance = self.distance(at);
        let inside = face(distance) * self.thickness.map_or(1.0, |thickness| face(thickness - distance));
        if self.outside { 1.0 - inside } else { inside }
    }

    /// The distances at which its share may have a corner or a jump.
    pub fn corners(&self) -> Vec<f64> {
        let faces = [Some(0.0), self.thickness];
        let half = self.falloff / 2.0;
        faces
            .into_iter()
            .flatten()
            .flat_map(|face| [face - half, face + half])
            .collect()
    }
}

/// Depth cueing along i, j and k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuePlane {
    place: Linear,
    depth: f64,
    strength: f64,
    colour: [f64; 3],
}

impl CuePlane {
    /// A scene's depth cueing in a geometry, along a view of this direction.
    pub fn of(cue: &Cueing, forward: [f64; 3], geometry: &Geometry) -> Self {
        let (dims, spacing) = (
            along_axes(geometry, geometry.dims),
            along_axes(geometry, geometry.spacing),
        );
        let plane = cue.in_voxels(forward, dims, spacing);
        Self {
            place: Linear::of(plane.slope, plane.distance, geometry),
            depth: plane.depth,
            strength: plane.strength,
            colour: cue.colour,
        }
    }

    /// How far colours have turned at a place.
    pub fn turned(&self, at: [f64; 3]) -> f64 {
        (self.place.at(at) / self.depth).clamp(0.0, 1.0) * self.strength
    }

    /// A colour that has turned so far.
    pub fn colour(&self, colour: [f64; 3], turned: f64) -> [f64; 3] {
        [0, 1, 2].map(|c| colour[c] + (self.colour[c] - colour[c]) * turned)
    }
}

/// What planes leave of a part of the segment that begins at a place and goes this way.
pub fn left(planes: &[ClipPlane], front: [f64; 3], way: [f64; 3], part: [f64; 2]) -> Left {
    let all = planes.iter().map(|plane| plane.left(front, way));
    all.fold(Left::WHOLE, Left::and).of(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONG_Z: ClipPlane = ClipPlane {
        distance: Linear {
            slope: [0.0, 0.0, 1.0],
            first: -2.0,
        },
        thickness: None,
        falloff: 0.0,
        outside: false,
    };

    #[test]
    fn what_is_left_of_a_ray_is_as_long_as_it_is() {
        let way = [0.3, -0.2, 0.5];
        let steep = ClipPlane {
            distance: Linear {
                slope: [0.6, 0.0, 0.8],
                first: -3.05,
            },
            ..ALONG_Z
        };
        let slab = ClipPlane {
            thickness: Some(0.2),
            ..steep
        };
        let length = |planes: &[ClipPlane]| {
            let at = |n: i32| [0, 1, 2].map(|axis| f64::from(n) * way[axis]);
            (0..20)
                .map(|n| left(planes, at(n), way, [0.0, 1.0]).weight())
                .sum::<f64>()
        };
        // From z = 2 on to z = 10; behind 3.05 / 0.58 of 20 segments; as thick as 0.2 / 0.58.
        assert!((length(&[ALONG_Z]) - 16.0).abs() < 1e-12);
        assert!((length(&[steep]) - (20.0 - 3.05 / 0.58)).abs() < 1e-12);
        assert!((length(&[slab]) - 0.2 / 0.58).abs() < 1e-12);
        let outside = ClipPlane { outside: true, ..slab };
        assert!((length(&[outside]) - (20.0 - 0.2 / 0.58)).abs() < 1e-12);
        let soft = ClipPlane {
            falloff: 4.0,
            ..ALONG_Z
        };
        assert!((length(&[soft]) - 16.0).abs() < 1e-12);
        assert_eq!(soft.share([0.0, 0.0, 3.0]), 0.75);
        assert_eq!(soft.corners(), [-2.0, 2.0]);
    }
}
