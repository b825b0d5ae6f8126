//! Segments that are cut: at isosurfaces and into pieces.
//!
//! Between its two samples the field is linear, s(t) = s_f + t (s_b - s_f). A surface of value v is met where s(t) = v; a sample
//! that is v lies inside. In front of it, behind it and between two of them lies volume: the segment's between two of its values,
//! over that share of its length. Pieces are parts of equal share.
//!
//! Source: Engel, Kraus, Ertl 2001, section 5, for one surface; the order of several and the volume between them are the
//! project's (docs/contract/surfaces.md).

use slicecast_scene::{Face, Scene};
use slicecast_volume::Mapping;

use super::classify::Classified;

/// A surface on the volume's codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isosurface {
    /// Its value, code units.
    pub code: f64,
    /// Seen where codes rise along the ray.
    pub rising: Face,
    /// Seen where they fall.
    pub falling: Face,
}

/// The visible surfaces of a scene, ascending.
pub fn surfaces(scene: &Scene, mapping: &Mapping) -> Vec<Isosurface> {
    let mut surfaces: Vec<_> = (scene.surfaces.iter())
        .filter(|surface| surface.front.opacity + surface.back.opacity > 0.0)
        .map(|surface| {
            // Codes that fall where values rise show the other side.
            let turned = mapping.scale < 0.0;
            Isosurface {
                code: (surface.value - mapping.offset) / mapping.scale,
                rising: if turned { surface.back } else { surface.front },
                falling: if turned { surface.front } else { surface.back },
            }
        })
        .collect();
    surfaces.sort_by(|a, b| a.code.total_cmp(&b.code));
    surfaces
}

/// A surface that a segment meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where, 0 at the front sample, 1 at the back one.
    pub t: f64,
    /// Whether codes fall there.
    pub falling: bool,
    /// What is seen.
    pub face: Face,
}

/// The crossings of a segment, in their order.
pub fn crossings(surfaces: &[Isosurface], [front, back]: [f64; 2]) -> Vec<Crossing> {
    let met = |surface: &&Isosurface| (front >= surface.code) != (back >= surface.code);
    let falling = back < front;
    let crossing = |surface: &Isosurface| Crossing {
        t: ((surface.code - front) / (back - front)).clamp(0.0, 1.0),
        falling,
        face: if falling { surface.falling } else { surface.rising },
    };
    let mut crossings: Vec<_> = surfaces.iter().filter(met).map(crossing).collect();
    if falling {
        crossings.reverse();
    }
    crossings
}

/// A part of a segment, in the order along the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its number: even ones are of the volume, odd ones crossings.
    pub number: u32,
    /// Colour and opacity.
    pub classified: Classified,
    /// The surface that it is of.
    pub crossing: Option<Crossing>,
}

/// The parts of a segment between crossings, and these. `volume` gives what lies between two places of the segment.
pub fn cut(crossings: &[Crossing], volume: &dyn Fn([f64; 2]) -> Classified) -> Vec<Part> {
    let mut parts = Vec::with_capacity(2 * crossings.len() + 1);
    let mut from = 0.0;
    for crossing in crossings {
        parts.push((volume([from, crossing.t]), None));
        let Face { colour, opacity } = crossing.face;
        parts.push((Classified { colour, opacity }, Some(*crossing)));
        from = crossing.t;
    }
    parts.push((volume([from, 1.0]), None));
    let numbered = (0..).zip(parts);
    numbered
        .map(|(number, (classified, crossing))| Part {
            number,
            classified,
            crossing,
        })
        .collect()
}

/// Pieces of equal share.
pub fn pieces(count: u32, volume: &dyn Fn([f64; 2]) -> Classified) -> Vec<Part> {
    let place = |piece: u32| f64::from(piece) / f64::from(count);
    let piece = |number: u32| Part {
        number: 2 * number,
        classified: volume([place(number), place(number + 1)]),
        crossing: None,
    };
    (0..count).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(code: f64) -> Isosurface {
        let face = |colour| Face { colour, opacity: 0.5 };
        Isosurface {
            code,
            rising: face([1.0, 0.0, 0.0]),
            falling: face([0.0, 0.0, 1.0]),
        }
    }

    #[test]
    fn crossings_are_in_their_order_and_half_open() {
        let list = [15.0, 17.0, 19.0].map(surface);
        let met = |ends| {
            crossings(&list, ends)
                .iter()
                .map(|c| (c.t, c.falling))
                .collect::<Vec<_>>()
        };
        assert_eq!(met([10.0, 20.0]), [(0.5, false), (0.7, false), (0.9, false)]);
        assert_eq!(met([20.0, 10.0]), [(0.1, true), (0.3, true), (0.5, true)]);
        assert_eq!(met([15.0, 16.0]), []);
        assert_eq!(met([16.0, 15.0]), []);
        assert_eq!(met([14.0, 15.0]), [(1.0, false)]);
        assert_eq!(met([15.0, 14.0]), [(0.0, true)]);
        assert_eq!(met([15.0, 15.0]), []);
        assert_eq!(crossings(&list, [20.0, 10.0])[0].face.colour, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn shares_add_up() {
        let list = [15.0, 17.0].map(surface);
        let share = |[from, to]: [f64; 2]| Classified {
            colour: [0.0; 3],
            opacity: to - from,
        };
        let parts = cut(&crossings(&list, [20.0, 10.0]), &share);
        assert_eq!(
            parts.iter().map(|part| part.number).collect::<Vec<_>>(),
            [0, 1, 2, 3, 4]
        );
        let shares: Vec<_> = parts.iter().step_by(2).map(|part| part.classified.opacity).collect();
        for (share, exact) in shares.into_iter().zip([0.3, 0.2, 0.5]) {
            assert!((share - exact).abs() < 1e-12);
        }
        let numbers: Vec<_> = pieces(4, &share)
            .iter()
            .map(|p| (p.number, p.classified.opacity))
            .collect();
        assert_eq!(numbers, [(0, 0.25), (2, 0.25), (4, 0.25), (6, 0.25)]);
    }
}
