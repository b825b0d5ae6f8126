//! Projection in 16-bit lanes: one value of the samples of each ray, plane by plane.

use core::marker::PhantomData;
use core::ops::Deref;

use super::source::Short;
use crate::composite::{FrontToBack, Pixel, Unorm16};
use crate::fast::fold::{Offsets, folded};
use crate::fast::project::FastProjection;
use crate::fast::{self, RootTable};
use crate::lanes::{Kernel, Lanes};
use crate::plane::parts::{Columns, Parts, Samples};
use crate::plane::scratch::{self, FastScratch, ScratchError};
use crate::plane::source::Source;
use crate::plane::{At, Kept, Pipeline, Rows};
use crate::precision;
use crate::rows::{part_mut, three};
use crate::shade::Unlit;
use crate::slice::Code12;
use crate::stage::Stage;
use crate::tap::{Beam, Tap};

/// Projection in 16-bit lanes: the largest or smallest sample, or what is made of the sum of all. It looks at no clip planes and no
/// blocks.
#[derive(Clone, Debug)]
pub struct FastProject<R, C, X> {
    table: RootTable<R, C>,
    projection: X,
}

impl<R, C, X: FastProjection> FastProject<R, C, X> {
    /// A pipeline that makes one value of the samples of a ray and classifies it at the end.
    pub const fn new(table: RootTable<R, C>, projection: X) -> Self {
        Self { table, projection }
    }
}

/// The runs of a row.
#[inline(always)]
fn runs<W>(row: &mut [W], width: usize) -> [&mut [W]; 3] {
    let mut runs = row.chunks_mut(width.max(1));
    [(); 3].map(|()| runs.next().unwrap_or(&mut []))
}

impl<R, C, X> Pipeline for FastProject<R, C, X>
where
    R: Deref<Target = fast::Roots> + Sync,
    C: Deref<Target = fast::Colours> + Sync,
    X: FastProjection,
{
    type Precision = precision::Fast;
    type Voxel = Code12;
    type Element = X::Word;
    const CHANNELS: usize = X::WORDS;
    const SLICES: usize = 2;
    const SCRATCH: scratch::Rows = scratch::Rows::FastProjection;
    const BACK_TO_FRONT: bool = false;

    fn precision(&self) -> precision::Fast {
        precision::Fast
    }

    fn empty(&self, _: usize) -> X::Word {
        X::EMPTY
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        rows: Rows<'_, X::Word>,
        scratch: &mut [i32],
        _: Option<&mut Kept<'_>>,
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        let (plan, plane) = (at.plan, &at.plane);
        let [width, _, _] = plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let base_width = plan.base()[0] as usize;
        let Some(count) = rows.data.len().checked_div(X::WORDS * base_width) else {
            return Ok(());
        };
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        while let Some(Samples {
            extent,
            window,
            whole_rows,
        }) = parts.samples::<V>(&at.window)
        {
            let memory = FastScratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
            if extent.columns.is_empty() {
                continue;
            }
            let mut short = Short::<V, Unlit>::new(
                (&extent, &window),
                plan.spacing(),
                (memory.z, memory.samples),
                (memory.derivatives, memory.slope),
            );
            let reading = at.reading.filter(|_| whole_rows);
            for row in extent.met(rows.first, count) {
                let voxel_row = extent.voxel_row(row);
                if let Some(reading) = reading {
                    reading.row(voxel_row);
                }
                short.make(voxel_row);
                let samples = short.slab(voxel_row).back;
                if let Some(tap) = &mut tap {
                    let beam = Beam {
                        plane,
                        row,
                        column: extent.columns.start as u32,
                        part: 0,
                    };
                    tap.row(Stage::Interpolation, beam, &[&samples]);
                }
                let start = X::WORDS * (row - rows.first) as usize * base_width;
                let row_of_words = part_mut(&mut *rows.data, start..start + X::WORDS * base_width);
                let words = three(runs(row_of_words, base_width), |run| {
                    part_mut(run, extent.columns.clone())
                });
                V::enter((Fold, PhantomData::<(X, V)>, words, samples, extent.part.length()));
            }
        }
        Ok(())
    }

    fn pixel(&self, row: &[X::Word], column: usize) -> Pixel<Unorm16> {
        let width = row.len().checked_div(X::WORDS).unwrap_or(0);
        let mut words = [X::EMPTY; 3];
        for (word, run) in words.iter_mut().take(X::WORDS).zip(row.chunks(width.max(1))) {
            *word = run.get(column).copied().unwrap_or(X::EMPTY);
        }
        let clear = Pixel {
            colour: [0; 3],
            transparency: u16::MAX,
        };
        let Pixel { colour, transparency } = match self.projection.shown(words) {
            None => clear,
            Some(sample) => {
                let (colour, root) = (self.table.colour(sample), self.table.root(sample));
                folded::<FrontToBack>(clear, colour, root, Offsets::NEAREST, 0)
            }
        };
        Pixel {
            colour: three(colour, Unorm16),
            transparency: Unorm16(transparency),
        }
    }
}

struct Fold;

impl<X: FastProjection, V: Lanes> Kernel for (Fold, PhantomData<(X, V)>, [&mut [X::Word]; 3], &[u16], u32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, words, samples, share) = self;
        X::fold_row::<V>(words, samples, share);
    }
}
