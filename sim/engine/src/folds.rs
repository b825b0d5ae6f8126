//! Pipelines as objects: what tiles, streams and pictures ask of them, whatever their types.
//!
//! A pipeline's own code is compiled for every lanes; what goes round it is compiled once for the voxels and the elements of an
//! image. A call is a plane of a tile, a row of a picture's copy or a slice of a stream: some hundred nanoseconds of work at least.

use slicecast::classify::Support;
use slicecast::composite::{Channel as _, Pixel, Recurrence as _};
use slicecast::lanes::Lanes;
use slicecast::plan::Plan;
use slicecast::plane::{At, ChannelOf, Kept, Pictured, Pipeline, Rows, ScratchError, Shape, clear};
use slicecast::precision::Precision as _;
use slicecast::slice::Voxel;
use slicecast::tap::Tap;

use crate::image::Rgb;
use crate::picture::{Base, Pixels, Shown, channels};
use crate::simd::{OverLanes, Simd, with_lanes};

/// A pipeline without its type.
pub trait Folds: Send + Sync {
    /// What its slices are made of.
    type Voxel: Voxel;
    /// What its images are made of.
    type Element: Copy + Default + Send + Sync + 'static;

    /// How its images, planes and memory are laid out.
    fn shape(&self) -> Shape;
    /// [`Pipeline::support`].
    fn support(&self) -> Option<Support>;
    /// [`clear`].
    fn clear(&self, plan: &Plan, data: &mut [Self::Element]);
    /// Name and 1.0 of the channels of its pixels.
    fn format(&self) -> (&'static str, u32);
    /// Red, green, blue and transparency in a column of a finished row, raw bits.
    fn pixel(&self, row: &[Self::Element], column: usize) -> [u32; 4];

    /// [`Pipeline::fold`] with these vectors; under a tap by the scalar definitions.
    ///
    /// # Errors
    /// As [`Pipeline::fold`].
    fn fold(&self, simd: Simd, fold: Fold<'_, '_, Self::Voxel, Self::Element>) -> Result<(), ScratchError>;
    /// [`Pipeline::finished`] with these vectors.
    fn finished(&self, simd: Simd, plan: &Plan, data: &[Self::Element]) -> bool;
}

/// One whose pixels make pictures.
pub trait Frames: Folds {
    /// The picture of an image.
    fn picture(&self, shown: &Shown<'_>, plan: &Plan, image: &[Self::Element]) -> Rgb;
}

/// A plane that is folded into some rows.
pub struct Fold<'f, 'k, X, E> {
    /// The plane.
    pub at: &'f At<'f, X>,
    /// The rows.
    pub rows: Rows<'f, E>,
    /// Memory for rows under way.
    pub scratch: &'f mut [i32],
    /// Samples of the plane before.
    pub kept: Option<&'f mut Kept<'k>>,
    /// What looks on.
    pub tap: Option<&'f mut dyn Tap>,
}

impl<L: Pipeline + Send> Folds for L {
    type Voxel = L::Voxel;
    type Element = L::Element;

    fn shape(&self) -> Shape {
        L::SHAPE
    }

    fn support(&self) -> Option<Support> {
        Pipeline::support(self)
    }

    fn clear(&self, plan: &Plan, data: &mut [Self::Element]) {
        clear(self, plan, data);
    }

    fn format(&self) -> (&'static str, u32) {
        let pixel = self.precision().pixel();
        (pixel.format(), pixel.one().bits())
    }

    fn pixel(&self, row: &[Self::Element], column: usize) -> [u32; 4] {
        let Pixel {
            colour: [r, g, b],
            transparency,
        } = Pipeline::pixel(self, row, column);
        [r.bits(), g.bits(), b.bits(), transparency.bits()]
    }

    fn fold(&self, simd: Simd, fold: Fold<'_, '_, Self::Voxel, Self::Element>) -> Result<(), ScratchError> {
        let simd = if fold.tap.is_some() { Simd::Scalar } else { simd };
        with_lanes(simd, Folding(self, fold))
    }

    fn finished(&self, simd: Simd, plan: &Plan, data: &[Self::Element]) -> bool {
        with_lanes(simd, Finished(self, plan, data))
    }
}

impl<L: Pictured + Send> Frames for L {
    fn picture(&self, shown: &Shown<'_>, plan: &Plan, image: &[Self::Element]) -> Rgb {
        let pixels: &dyn Pixels<Self::Element, ChannelOf<L::Precision>> = self;
        shown.picture(&Base::of(L::SHAPE, plan, pixels, image))
    }
}

impl<L: Pictured> Pixels<L::Element, ChannelOf<L::Precision>> for L {
    fn pixels(&self, row: &[L::Element], column: usize, out: &mut [[ChannelOf<L::Precision>; 4]]) -> u32 {
        let width = row.len() / L::CHANNELS;
        // A pipeline with fewer channels does not look at the others.
        let len = out.len();
        let run = |channel| {
            let start = channel % L::CHANNELS * width + column;
            &row[start..start + len]
        };
        let [first, second, third, fourth] = [run(0), run(1), run(2), run(3)];
        let clear = channels(Pixel::<ChannelOf<L::Precision>>::clear());
        let mut seen = 0;
        for ((((out, a), b), c), d) in out.iter_mut().zip(first).zip(second).zip(third).zip(fourth) {
            // As a row of one pixel, in which the compiler knows every place.
            *out = channels(Pipeline::pixel(self, &[*a, *b, *c, *d][..L::CHANNELS], 0));
            for (channel, clear) in out.iter().zip(clear) {
                seen |= channel.bits() ^ clear.bits();
            }
        }
        seen
    }
}

/// A pipeline's fold, with lanes still to be chosen.
struct Folding<'l, 'f, 'k, L: Pipeline>(&'l L, Fold<'f, 'k, L::Voxel, L::Element>);

impl<L: Pipeline> OverLanes for Folding<'_, '_, '_, L> {
    type Output = Result<(), ScratchError>;

    fn run<V: Lanes>(self) -> Self::Output {
        let Self(
            pipeline,
            Fold {
                at,
                rows,
                scratch,
                kept,
                tap,
            },
        ) = self;
        if V::COUNT == 1 && !V::SMALL {
            pipeline.fold_native(at, rows, scratch, kept, tap)
        } else {
            // Observers are shown one lane, and vectors have no code for them.
            pipeline.fold::<V>(at, rows, scratch, kept, None)
        }
    }
}

/// The question whether rows are finished, with lanes still to be chosen.
struct Finished<'a, L: Pipeline>(&'a L, &'a Plan, &'a [L::Element]);

impl<L: Pipeline> OverLanes for Finished<'_, L> {
    type Output = bool;

    fn run<V: Lanes>(self) -> bool {
        self.0.finished::<V>(self.1, self.2)
    }
}
