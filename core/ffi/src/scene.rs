//! Scenes as C structures.

use slicecast::borders::Borders;
use slicecast::crop::Crop;
use slicecast::fast::FastPhong;
use slicecast::format::{Coefficient, Direction, Intensity, Position, Step, Vector};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::precision::Precision;
use slicecast::screen::Screen;
use slicecast::shade::{Highlight, LIGHTS_MAX, Light, Phong};
use slicecast::surface::Surface;
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast::warp::Warp;

use crate::colours::SlicecastMedium;
use crate::error::{
    SLICECAST_BORDERS, SLICECAST_HIGHLIGHT, SLICECAST_INTERPOLATION, SLICECAST_LIGHTS, SLICECAST_VERSION_MISMATCH,
    SlicecastError,
};
use crate::fast::SlicecastFastTable;
use crate::integrals::SlicecastIntegrals;
use crate::surfaces::SlicecastSurface;
use crate::{SLICECAST_VERSION, check, slice};

/// Everything that decides a base-plane image, apart from the voxels.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastScene {
    /// SLICECAST_VERSION.
    pub version: u32,
    /// Voxels along x, y, z, 1 to 8192 each.
    pub dims: [u32; 3],
    /// Viewing direction from the eye into the scene, in voxels along x, y, z, s5.58; no component beyond -1 to 1.
    pub direction: [i64; 3],
    /// Smallest voxel spacing divided by the spacing along x, y, z, 1.15: 32768 for cubic voxels.
    pub spacing: [u16; 3],
    /// Sample planes per voxel along the viewing axis, 1 to 16.
    pub planes_per_voxel: u32,
    /// Rays per voxel along each side of the base plane, 1 to 8.
    pub rays_per_voxel: u32,
    /// 0: the value between voxels is linear between the eight around it; 1: it is that of the nearest voxel, halves up. Labels
    /// are names and have nothing between them: they take 1.
    pub interpolation: u32,
    /// 0: the volume ends at its outermost voxels, and every sample counts as a whole step; 1: it ends half a voxel beyond
    /// them, and a sample counts by the part of its step inside; 2: likewise, but at the outermost voxels.
    pub borders: u32,
    /// The box along x, y, z that is drawn, in voxels from the centre of the first one, s15.16: its low faces. Both faces of an axis
    /// 0: all of it along that axis. A box needs borders 1 or 2; beyond the volume it ends where that does.
    pub crop_low: [i32; 3],
    /// Its high faces.
    pub crop_high: [i32; 3],
    /// The table: 4096 entries, one per voxel value: red in the lowest byte, green, blue, and the square root of the
    /// opacity of one step along a ray in the highest (the high bytes of those that have a plane of low bytes).
    pub entries: *const u32,
    /// 4096 low bytes of the square roots; the paper pipelines do not read it, the others need it.
    pub low_roots: *const u8,
    /// 4096 times three low bytes of the colours: red, green, blue (65535 is 1); the pipelines of 16-bit colours need it, the
    /// others do not read it.
    pub low_colours: *const u8,
    /// Lights and material; unlit pipelines do not read it, the others need it.
    pub lighting: *const SlicecastLighting,
    /// What segments are classified by; the pipelines of segments need it and read no other table, the others do not read it.
    pub integrals: *const SlicecastIntegrals,
    /// Isosurfaces in ascending order of their values; the pipelines of surfaces and of depths need them, the others do not read
    /// them. With surfaces, integrals may be null: surfaces are drawn alone.
    pub surfaces: *const SlicecastSurface,
    /// How many they are.
    pub surface_count: usize,
    /// The scale of extinctions; the pipelines of colours and extinctions need it and read no table, the others do not read it.
    pub medium: SlicecastMedium,
    /// The table of 16-bit lanes; the pipelines named `slicecast_fast_` need it and read no other table, the others do not read it.
    pub fast: *const SlicecastFastTable,
}

impl SlicecastScene {
    /// The surfaces, where they lie; `argument` is the scene's place.
    ///
    /// # Safety
    /// The pointer is null, misaligned, or points to as many surfaces, which stay readable and unchanged.
    pub(crate) unsafe fn surfaces(&self, argument: u32) -> Result<&'static [Surface], SlicecastError> {
        // SAFETY: the caller's promise; both structures are laid out alike (`surfaces.rs`).
        unsafe { slice(self.surfaces.cast::<Surface>(), self.surface_count, argument) }
    }
}

/// Lights and material.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastLighting {
    /// Ambient coefficient of red, green, blue, 1.31.
    pub ambient: [u32; 3],
    /// Unit vector towards the eye in the slice frame (i, j along rows and columns of a slice, k away from the eye),
    /// s1.30.
    pub viewer: [i32; 3],
    /// 0: the highlight is a power of R.L (Phong); 1: of N.H (Blinn).
    pub highlight: u32,
    /// log2 of the highlight's exponent, 0 to 8.
    pub exponent_log2: u32,
    /// Number of lights, at most 8.
    pub count: usize,
    /// The lights; not read where there are none.
    pub lights: *const SlicecastLight,
}

/// A directional light.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastLight {
    /// Unit vector towards the light, slice frame, s1.30.
    pub direction: [i32; 3],
    /// Unit vector half way between light and eye, s1.30; read where `highlight` is 1.
    pub half: [i32; 3],
    /// Diffuse coefficient times the light's red, green, blue, 1.31.
    pub diffuse: [u32; 3],
    /// Specular coefficient times the light's red, green, blue, 1.31.
    pub specular: [u32; 3],
}

/// What a stream takes and what its image looks like.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlicecastNeeds {
    /// Bytes of memory for the stream.
    pub bytes: usize,
    /// Alignment of that memory, bytes.
    pub align: usize,
    /// Voxels in a slice, rows one after the other: of those that a cropped scene looks at.
    pub slice_voxels: usize,
    /// Voxels in a row of a slice.
    pub slice_width: u32,
    /// Number of slices.
    pub slices: u32,
    /// The first voxel, row and slice of them, counted in the whole volume.
    pub first: [u32; 3],
    /// Columns of the base-plane image, of one phase.
    pub columns: u32,
    /// Rows of the base-plane image, of one phase; of the whole image, also where a band was asked for.
    pub rows: u32,
    /// Number of phases: rays_per_voxel squared.
    pub phases: u32,
    /// Bytes of an element of the image: 2 or 4.
    pub element_bytes: u32,
    /// Bytes of the image, or of the band asked for.
    pub image_bytes: usize,
}

/// Where the pixels of the viewer's picture look at the base plane: u along i and v along j, in base-plane pixels of all
/// phases, s31.32.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastWarp {
    /// What the centre of the picture's first pixel sees.
    pub origin: [i64; 2],
    /// One picture pixel to the right.
    pub right: [i64; 2],
    /// One picture pixel down.
    pub down: [i64; 2],
}

/// Where the pixels of the viewer's picture lie in the volume: the picture's middle is the volume's.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastScreen {
    /// Pixels across and down, 1 to 16384 each.
    pub size: [u32; 2],
    /// One picture pixel to the right, in voxels along x, y, z, s31.32; no component beyond -1024 to 1024.
    pub right: [i64; 3],
    /// One picture pixel down, likewise.
    pub down: [i64; 3],
}

impl SlicecastScene {
    /// The frame's geometry.
    pub(crate) fn plan(&self) -> Result<Plan, SlicecastError> {
        if self.version != SLICECAST_VERSION {
            let (needed, given) = (SLICECAST_VERSION.into(), self.version.into());
            return Err(SlicecastError::numbers(SLICECAST_VERSION_MISMATCH, needed, given));
        }
        let view = View::new(self.direction.map(Direction::from_bits))?;
        let sampling = Sampling {
            planes_per_voxel: self.planes_per_voxel,
            rays_per_voxel: self.rays_per_voxel,
        };
        let spacing = Spacing(self.spacing.map(Intensity::from_bits));
        let borders = match self.borders {
            0 => Borders::Whole,
            1 => Borders::Cells,
            2 => Borders::Nodes,
            given => return Err(SlicecastError::numbers(SLICECAST_BORDERS, 2, given.into())),
        };
        let mut plan = Plan::with_borders(view, self.dims, spacing, sampling, borders)?;
        let crop = self.crop();
        if crop != Crop::NONE {
            plan = plan.with_crop(crop)?;
        }
        match self.interpolation {
            0 => Ok(plan),
            1 => Ok(plan.with_nearest()),
            given => Err(SlicecastError::numbers(SLICECAST_INTERPOLATION, 1, given.into())),
        }
    }

    /// The box; open along axes of which nothing is said.
    fn crop(&self) -> Crop {
        let mut crop = Crop::NONE;
        let stated = self.crop_low.iter().zip(&self.crop_high);
        let faces = crop.low.iter_mut().zip(&mut crop.high);
        for ((low, high), (low_bits, high_bits)) in faces.zip(stated) {
            if (*low_bits, *high_bits) != (0, 0) {
                (*low, *high) = (Position::from_bits(*low_bits), Position::from_bits(*high_bits));
            }
        }
        crop
    }

    /// The table's entries.
    ///
    /// # Safety
    /// `entries` is null, misaligned, or points to 4096 values that stay readable and unchanged.
    pub(crate) unsafe fn entries(&self) -> Result<&'static [u32; ENTRIES], SlicecastError> {
        check(self.entries, 2)?;
        // SAFETY: not null, aligned; the caller's promise.
        Ok(unsafe { &*self.entries.cast() })
    }

    /// The table's low bytes.
    ///
    /// # Safety
    /// As for [`Self::entries`].
    pub(crate) unsafe fn low_roots(&self) -> Result<&'static [u8; ENTRIES], SlicecastError> {
        check(self.low_roots, 2)?;
        // SAFETY: not null; the caller's promise.
        Ok(unsafe { &*self.low_roots.cast() })
    }

    /// The table's low bytes of colours.
    ///
    /// # Safety
    /// As for [`Self::entries`].
    pub(crate) unsafe fn low_colours(&self) -> Result<&'static [[u8; 3]; ENTRIES], SlicecastError> {
        check(self.low_colours, 2)?;
        // SAFETY: not null; the caller's promise.
        Ok(unsafe { &*self.low_colours.cast() })
    }
}

impl SlicecastLighting {
    /// The shader of these lights.
    ///
    /// # Safety
    /// The lights are null, misaligned or readable.
    pub(crate) unsafe fn phong<P: Precision>(&self, precision: P) -> Result<Phong<P>, SlicecastError> {
        // SAFETY: the caller's promise.
        let (highlight, lights) = unsafe { self.given()? };
        Ok(Phong::new(
            precision,
            self.ambient.map(Coefficient::from_bits),
            lights.get(..self.count).unwrap_or(&[]),
            self.viewer.map(Vector::from_bits),
            highlight,
            self.exponent_log2,
        )?)
    }

    /// The shader of these lights in 16-bit lanes.
    ///
    /// # Safety
    /// The lights are null, misaligned or readable.
    pub(crate) unsafe fn fast(&self) -> Result<FastPhong, SlicecastError> {
        // SAFETY: the caller's promise.
        let (highlight, lights) = unsafe { self.given()? };
        Ok(FastPhong::new(
            self.ambient.map(Coefficient::from_bits),
            lights.get(..self.count).unwrap_or(&[]),
            self.viewer.map(Vector::from_bits),
            highlight,
            self.exponent_log2,
        )?)
    }

    /// The form of the highlight, and the lights: the first of as many as can be.
    ///
    /// # Safety
    /// The lights are null, misaligned or readable.
    #[inline(always)]
    unsafe fn given(&self) -> Result<(Highlight, [Light; LIGHTS_MAX]), SlicecastError> {
        let highlight = match self.highlight {
            0 => Highlight::Reflection,
            1 => Highlight::HalfVector,
            given => return Err(SlicecastError::numbers(SLICECAST_HIGHLIGHT, 1, given.into())),
        };
        let given: &[SlicecastLight] = if self.count == 0 {
            &[]
        } else if self.count > LIGHTS_MAX {
            let (needed, given) = (LIGHTS_MAX as i64, self.count as i64);
            return Err(SlicecastError::numbers(SLICECAST_LIGHTS, needed, given));
        } else {
            // SAFETY: the caller's promise.
            unsafe { slice(self.lights, self.count, 2)? }
        };
        let mut lights = [Light {
            direction: [Vector::ZERO; 3],
            half: [Vector::ZERO; 3],
            diffuse: [Coefficient::ZERO; 3],
            specular: [Coefficient::ZERO; 3],
        }; LIGHTS_MAX];
        for (light, given) in lights.iter_mut().zip(given) {
            *light = Light {
                direction: given.direction.map(Vector::from_bits),
                half: given.half.map(Vector::from_bits),
                diffuse: given.diffuse.map(Coefficient::from_bits),
                specular: given.specular.map(Coefficient::from_bits),
            };
        }
        Ok((highlight, lights))
    }
}

impl SlicecastScreen {
    /// Where its pixels look at the base plane of a scene.
    pub(crate) fn warp(&self, scene: &SlicecastScene) -> Result<SlicecastWarp, SlicecastError> {
        let screen = Screen {
            size: self.size,
            right: self.right.map(Step::from_bits),
            down: self.down.map(Step::from_bits),
        };
        let Warp { origin, right, down } = screen.warp(&scene.plan()?)?;
        Ok(SlicecastWarp {
            origin: origin.map(Step::to_bits),
            right: right.map(Step::to_bits),
            down: down.map(Step::to_bits),
        })
    }
}

impl SlicecastWarp {
    pub(crate) fn warp(&self) -> Warp {
        Warp {
            origin: self.origin.map(Step::from_bits),
            right: self.right.map(Step::from_bits),
            down: self.down.map(Step::from_bits),
        }
    }
}
