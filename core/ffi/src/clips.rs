//! Clip planes as C structures.

use core::mem::MaybeUninit;

use slicecast::clip::{CLIPS_MAX, Clip, ClipError, Clips, Cue, DISTANCE_MAX};
use slicecast::format::{Distance, Intensity, Vector};

use crate::error::{SLICECAST_CLIP, SLICECAST_CLIP_COUNT, SLICECAST_CUE, SlicecastError};
use crate::instance::Handle;

/// Words of a `SlicecastClips`.
pub const SLICECAST_CLIPS_WORDS: usize = 72;

/// A clip plane: what lies on the side of its normal is drawn, or a slab there. docs/contract/clip.md
///
/// Lengths are of the caller's choice (a voxel, or the largest spacing between voxels), the same for all numbers of a plane.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastClip {
    /// By how many lengths the distance from the plane grows per voxel along x, y, z, s1.30, none beyond -1 to 1: the normal.
    pub slope: [i32; 3],
    /// 1: what lies between the faces, or on the side of the normal, is cut away, and everything else drawn; else 0.
    pub outside: u32,
    /// The distance of the centre of the first voxel, lengths, s33.30, within 65536.
    pub distance: i64,
    /// How far behind the plane what is drawn ends again, lengths, s33.30; 0: it does not end.
    pub thickness: i64,
    /// The width of the ramp on which what is drawn fades, half of it on each side of a face, lengths, s33.30; 0: it is cut.
    pub falloff: i64,
}

/// Depth cueing: colours, after shading, turn into another with depth. docs/contract/clip.md
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastCue {
    /// By how many lengths the depth grows per voxel along x, y, z, s1.30, none beyond -1 to 1.
    pub slope: [i32; 3],
    /// How far colours turn, 0.16: 0 to 65536, which is all.
    pub most: u32,
    /// The depth of the centre of the first voxel, lengths, s33.30, within 65536; up to 0 colours are their own.
    pub distance: i64,
    /// The depth at which they have turned, lengths, s33.30, above 0.
    pub depth: i64,
    /// What they turn into: red, green, blue, 1.15.
    pub colour: [u16; 3],
}

/// Memory for the clip planes and the depth cueing of a stream. Opaque; it need not be initialised.
#[repr(C)]
pub struct SlicecastClips {
    words: [MaybeUninit<u64>; SLICECAST_CLIPS_WORDS],
}

const _: () = assert!(size_of::<Clips>() <= size_of::<SlicecastClips>() && align_of::<Clips>() <= align_of::<u64>());

impl SlicecastClip {
    fn clip(&self) -> Clip {
        Clip {
            slope: self.slope.map(Vector::from_bits),
            distance: Distance::from_bits(self.distance),
            thickness: (self.thickness != 0).then(|| Distance::from_bits(self.thickness)),
            falloff: Distance::from_bits(self.falloff),
            outside: self.outside != 0,
        }
    }
}

impl SlicecastCue {
    fn cue(&self) -> Cue {
        Cue {
            slope: self.slope.map(Vector::from_bits),
            distance: Distance::from_bits(self.distance),
            depth: Distance::from_bits(self.depth),
            most: self.most,
            colour: self.colour.map(Intensity::from_bits),
        }
    }
}

impl SlicecastClips {
    /// Makes planes and depth cueing of a stream here and gives them to it.
    pub(crate) fn give(
        &'static mut self,
        planes: &[SlicecastClip],
        cue: Option<&SlicecastCue>,
        stream: Handle,
    ) -> Result<(), SlicecastError> {
        const NONE: Clip = Clip {
            slope: [Vector::ZERO; 3],
            distance: Distance::ZERO,
            thickness: None,
            falloff: Distance::ZERO,
            outside: false,
        };
        let mut clips = [NONE; CLIPS_MAX];
        let Some(clips) = clips.get_mut(..planes.len()) else {
            return Err(ClipError::TooMany { given: planes.len() }.into());
        };
        for (clip, plane) in clips.iter_mut().zip(planes) {
            *clip = plane.clip();
        }
        let mut clips = Clips::new(stream.plan(), clips)?;
        if let Some(cue) = cue {
            clips = clips.with_cue(stream.plan(), &cue.cue())?;
        }
        let place: *mut Clips = self.words.as_mut_ptr().cast();
        // SAFETY: large enough and aligned (above), and this call's alone; what is written has no destructor.
        let clips: &'static Clips = unsafe {
            place.write(clips);
            &*place
        };
        stream.clip(clips.clipper())
    }
}

impl From<ClipError> for SlicecastError {
    fn from(error: ClipError) -> Self {
        let plane = |number: usize, needed: i64| Self {
            row: number as u32,
            ..Self::numbers(SLICECAST_CLIP, needed, 0)
        };
        match error {
            ClipError::TooMany { given } => Self::numbers(SLICECAST_CLIP_COUNT, CLIPS_MAX as i64, given as i64),
            ClipError::Cue => Self::numbers(SLICECAST_CUE, 0, 0),
            ClipError::NoNormal { number } => plane(number, 1),
            ClipError::Slope { number } => plane(number, 1 << 30),
            ClipError::Length { number } => plane(number, DISTANCE_MAX.to_bits()),
        }
    }
}
