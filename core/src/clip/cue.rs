//! Depth cueing: colours that turn into another with the distance from a plane, after shading.

use core::marker::PhantomData;

use super::remainder::{Ramp, product};
use crate::borders::WHOLE;
use crate::format::{Distance, Intensity, Vector};
use crate::lanes::{Kernel, Lanes, Wide as _, places};

/// Depth cueing: a depth that is linear in the place, from where colours begin to turn to where they have turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cue {
    /// By how many lengths the depth grows per voxel along x, y and z, none beyond -1 to 1.
    pub slope: [Vector; 3],
    /// The depth of the centre of the volume's first voxel; at 0 and above it colours are their own.
    pub distance: Distance,
    /// The depth at which they have turned as far as they do, above 0.
    pub depth: Distance,
    /// How far that is, 0.16: 65536 is all.
    pub most: u32,
    /// What they turn into.
    pub colour: [Intensity; 3],
}

/// Depth cueing in the slice frame of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CuePlane {
    /// Slopes along i, j and k, 2^-30 length per voxel.
    pub slope: [i64; 3],
    /// The depth of the slice frame's first voxel, 2^-30 length.
    pub distance: i64,
    ramp: Ramp,
    most: u32,
    colour: [Intensity; 3],
}

impl CuePlane {
    pub(super) fn of(cue: &Cue, (slope, distance): ([i64; 3], i64)) -> Self {
        Self {
            slope,
            distance,
            ramp: Ramp::of(cue.depth.to_bits()),
            most: cue.most,
            colour: cue.colour,
        }
    }

    /// How far colours have turned about a segment, given the depths of both ends, 0.16. This function is the definition.
    pub fn share(&self, [front, back]: [i64; 2]) -> u32 {
        product(self.ramp.share(front + back), self.most)
    }

    /// What colours of so many bits after 1.0 turn into.
    pub(super) fn target(&self, bits: u32) -> [u32; 3] {
        self.colour.map(|colour| scaled(colour, bits) as u32)
    }

    /// A colour of so many bits after 1.0, turned by a share, to nearest. This function is the definition.
    pub fn turned(&self, colour: [u32; 3], bits: u32, share: u32) -> [u32; 3] {
        let mut out = colour;
        for (own, other) in out.iter_mut().zip(self.colour) {
            *own = toward(*own, scaled(other, bits), share);
        }
        out
    }

    /// Red, green and blue times extinction, none above it, turned by a share, to nearest. This function is the definition.
    pub fn turned_weighted(&self, colour: [u32; 3], extinction: u32, share: u32) -> [u32; 3] {
        let mut out = colour;
        for (own, other) in out.iter_mut().zip(self.colour) {
            let other = (i64::from(extinction) * i64::from(other.to_bits()) + (1 << 14)) >> 15;
            *own = toward(*own, other, share);
        }
        out
    }
}

/// A number brought so far towards another, 0.16, to nearest.
fn toward(own: u32, other: i64, share: u32) -> u32 {
    let own = i64::from(own);
    (own + (((other - own) * i64::from(share) + (1 << 15)) >> 16)) as u32
}

/// Turns a channel of colours, of some bits after 1.0, into another by shares: the definition ([`CuePlane::turned`]), in lanes.
pub(super) fn turn_by<V: Lanes>(colours: &mut [i32], other: u32, shares: &[i32]) {
    V::enter((Turn, PhantomData::<V>, colours, other, shares));
}

struct Turn;

impl<V: Lanes> Kernel for (Turn, PhantomData<V>, &mut [i32], u32, &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, colours, other, shares) = self;
        let (other, whole) = (V::splat(other as i32), V::splat(WHOLE as i32));
        for at in places::<V>(colours.len()) {
            let (own, share) = (V::load(colours, at), V::load(shares, at));
            // Below 2^48: both shares add up to 2^16.
            let sum = own.product(whole - share) + other.product(share) + V::Wide::splat(1 << 15);
            sum.shr_narrow(16).store(colours, at);
        }
    }
}

/// An intensity, 1.15, with so many bits after 1.0, to nearest.
fn scaled(intensity: Intensity, bits: u32) -> i64 {
    let intensity = i64::from(intensity.to_bits());
    match bits.checked_sub(15) {
        Some(more) => intensity << more,
        None => (intensity + (1 << (14 - bits))) >> (15 - bits),
    }
}
