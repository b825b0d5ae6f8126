//! Scratch memory: how many rows each kind of fold needs, how long they are, and their only cut.

use crate::rows::{part_mut, take};

/// Samples of a batch of blocks.
pub(super) const BATCH: usize = 1024;

/// Width of a slice whose rows of scratch memory hold a batch.
pub(super) const BATCH_WIDTH: u32 = BATCH as u32 - 2;

/// What scratch memory is cut for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Samples only.
    Projection,
    /// Samples of four channels.
    Colours,
    /// Gradients of one of them and normals besides.
    LitColours,
    /// Samples of four channels by splines.
    SmoothColours,
    /// Gradients of one of them and normals besides.
    LitSmoothColours,
    /// Samples, opacities and colours.
    Unlit,
    /// Gradients and normals besides.
    Lit,
    /// As [`Rows::Lit`], with magnitudes of gradients.
    Modulated,
    /// As [`Rows::Unlit`], of two planes.
    UnlitSlabs,
    /// As [`Rows::Lit`], of two planes.
    LitSlabs,
    /// As [`Rows::Unlit`], of rays that spread.
    Spread,
    /// As [`Rows::Lit`], of rays that spread.
    LitSpread,
    /// As [`Rows::Unlit`], by splines.
    Splines,
    /// As [`Rows::Lit`], by splines.
    LitSplines,
    /// As [`Rows::Projection`], in words of 16 bits.
    FastProjection,
    /// As [`Rows::Unlit`], in words of 16 bits.
    Fast,
    /// As [`Rows::Lit`], in words of 16 bits.
    LitFast,
}

impl Rows {
    /// Number of rows.
    const fn count(self) -> usize {
        match self {
            Self::Projection => 3,
            Self::Colours => 12,
            Self::LitColours => 24,
            Self::SmoothColours => 20,
            Self::LitSmoothColours => 32,
            Self::Unlit => 7,
            Self::Lit => 16,
            Self::Modulated => 17,
            Self::UnlitSlabs => 10,
            Self::LitSlabs => 27,
            Self::Spread => 12,
            Self::LitSpread => 28,
            Self::Splines => 9,
            Self::LitSplines => 17,
            // Two rows each.
            Self::FastProjection => 2,
            Self::Fast => 4,
            Self::LitFast => 8,
        }
    }

    /// Whether gradients are made.
    const fn lit(self) -> bool {
        matches!(self, Self::Lit | Self::Modulated | Self::LitSlabs | Self::LitSpread)
    }

    /// Whether two planes are sampled.
    const fn slabs(self) -> bool {
        matches!(self, Self::UnlitSlabs | Self::LitSlabs)
    }

    /// Words for slices of this width: each row holds the voxels of a slice's row and one place at each end.
    pub const fn len(self, width: u32) -> usize {
        self.count() * (width as usize + 2)
    }
}

/// Words besides that a fold of blocks stores places in, to go through a batch of segments several times.
const fn spare(kind: Rows, blocks: bool) -> usize {
    if blocks && kind.slabs() { 2 * BATCH } else { 0 }
}

/// Words for a fold of blocks of slices of this width.
pub(super) const fn blocks_len(kind: Rows, width: u32) -> usize {
    let width = if width > BATCH_WIDTH { width } else { BATCH_WIDTH };
    kind.len(width) + spare(kind, true)
}

/// Memory without the words besides, and these.
///
/// # Errors
/// [`ScratchError`] if there is too little for both.
#[inline]
pub(super) fn with_spare(
    memory: &mut [i32],
    kind: Rows,
    width: u32,
    blocks: bool,
) -> Result<(&mut [i32], &mut [i32]), ScratchError> {
    let (spare, given) = (spare(kind, blocks), memory.len());
    let needed = kind.len(width) + spare;
    given
        .checked_sub(spare)
        .filter(|_| given >= needed)
        .and_then(|at| memory.split_at_mut_checked(at))
        .ok_or(ScratchError { needed, given })
}

/// Scratch memory is too short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScratchError {
    /// Words needed.
    pub needed: usize,
    /// Words given.
    pub given: usize,
}

impl core::fmt::Display for ScratchError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { needed, given } = self;
        write!(f, "the scratch memory needs {needed} words, {given} given")
    }
}

impl core::error::Error for ScratchError {}

/// A row number that no row has.
pub(super) const NO_ROW: i32 = i32::MIN;

/// Words of a line of the cache.
pub(super) const LINE: usize = 16;

/// Rows of scratch memory by their use; those that a kind of fold does not need are empty.
pub(super) struct Scratch<'s, W> {
    pub(super) source: SourceRows<'s, W>,
    /// Of the plane in front.
    pub(super) front: SourceRows<'s, W>,
    /// Gradients at the plane in front.
    pub(super) front_gradients: [&'s mut [W]; 3],
    pub(super) batch: BatchRows<'s, W>,
}

/// Rows of a source of samples.
pub(super) struct SourceRows<'s, W> {
    /// Voxels interpolated along z, of an even and an odd voxel row.
    pub(super) z: [&'s mut [W]; 2],
    /// The row inside a face, from which the row beyond it is made.
    pub(super) inner: &'s mut [W],
    /// Samples; of three rows where gradients are needed.
    pub(super) samples: [&'s mut [W]; 3],
    /// Derivatives along z, interpolated along z, of an even and an odd voxel row.
    pub(super) derivatives: [&'s mut [W]; 2],
}

/// Rows of a batch on its way through the stages.
pub(super) struct BatchRows<'s, W> {
    pub(super) opacities: &'s mut [W],
    pub(super) colours: [&'s mut [W]; 3],
    pub(super) g: [&'s mut [W]; 3],
    pub(super) r: &'s mut [W],
    pub(super) magnitudes: &'s mut [W],
}

impl<'s, W> Scratch<'s, W> {
    /// Cuts memory into rows for slices of this width. With `aligned`, and where there is enough, rows begin with a line of
    /// the cache, so that vectors are not stored across two.
    ///
    /// # Errors
    /// [`ScratchError`] with the length of [`Rows::len`].
    #[inline]
    pub(super) fn cut(memory: &'s mut [W], kind: Rows, width: u32, aligned: bool) -> Result<Self, ScratchError> {
        let mut rest = Rest::of(memory, kind, width, aligned)?;
        let mut row = |wanted: bool| -> &'s mut [W] { if wanted { rest.row() } else { &mut [] } };
        let (classified, lit, slabs) = (kind != Rows::Projection, kind.lit(), kind.slabs());
        let mut source = |wanted: bool| SourceRows {
            z: [row(wanted), row(wanted)],
            inner: row(wanted && lit),
            samples: [row(wanted), row(wanted && lit), row(wanted && lit)],
            derivatives: [row(wanted && lit), row(wanted && lit)],
        };
        Ok(Self {
            source: source(true),
            front: source(slabs),
            front_gradients: [row(slabs && lit), row(slabs && lit), row(slabs && lit)],
            batch: BatchRows {
                opacities: row(classified),
                colours: [row(classified), row(classified), row(classified)],
                g: [row(lit), row(lit), row(lit)],
                r: row(lit),
                magnitudes: row(kind == Rows::Modulated),
            },
        })
    }
}

/// Rows of a source of samples by splines.
pub(super) struct SmoothRows<'s, W> {
    /// Voxels interpolated along z, of three voxel rows.
    pub(super) z: [&'s mut [W]; 3],
    /// The same interpolated along y.
    pub(super) y: &'s mut [W],
    pub(super) samples: &'s mut [W],
}

/// Rows of gradients by splines.
pub(super) struct SlopeRows<'s, W> {
    /// Slopes along z, of three voxel rows.
    pub(super) z: [&'s mut [W]; 3],
    /// What is made of them along y.
    pub(super) y: &'s mut [W],
}

/// Rows of samples of values by splines.
pub(super) struct SplineScratch<'s, W> {
    pub(super) samples: SmoothRows<'s, W>,
    /// Empty where there are no gradients.
    pub(super) slopes: SlopeRows<'s, W>,
    pub(super) batch: BatchRows<'s, W>,
}

impl<'s, W> SplineScratch<'s, W> {
    /// Cuts memory as [`Scratch::cut`] does.
    ///
    /// # Errors
    /// As [`Scratch::cut`].
    #[inline]
    pub(super) fn cut(memory: &'s mut [W], kind: Rows, width: u32, aligned: bool) -> Result<Self, ScratchError> {
        let mut rest = Rest::of(memory, kind, width, aligned)?;
        let lit = kind == Rows::LitSplines;
        let mut row = |wanted: bool| -> &'s mut [W] { if wanted { rest.row() } else { &mut [] } };
        Ok(Self {
            samples: SmoothRows {
                z: [row(true), row(true), row(true)],
                y: row(true),
                samples: row(true),
            },
            slopes: SlopeRows {
                z: [row(lit), row(lit), row(lit)],
                y: row(lit),
            },
            batch: BatchRows {
                opacities: row(true),
                colours: [row(true), row(true), row(true)],
                g: [row(lit), row(lit), row(lit)],
                r: row(lit),
                magnitudes: &mut [],
            },
        })
    }
}

/// Rows of samples and gradients in words of 16 bits.
pub(super) struct FastScratch<'s> {
    /// Voxels interpolated along z, of an even and an odd voxel row.
    pub(super) z: [&'s mut [u16]; 2],
    /// Samples; of three rows where gradients are needed.
    pub(super) samples: [&'s mut [u16]; 3],
    /// Derivatives along z, interpolated along z, of an even and an odd voxel row.
    pub(super) derivatives: [&'s mut [u16]; 2],
    /// What rises between the two rows of voxels at a face.
    pub(super) slope: &'s mut [u16],
    pub(super) batch: BatchRows<'s, u16>,
}

impl<'s> FastScratch<'s> {
    /// Cuts memory as [`Scratch::cut`] does, each word in two.
    ///
    /// # Errors
    /// As [`Scratch::cut`].
    #[inline]
    pub(super) fn cut(memory: &'s mut [i32], kind: Rows, width: u32, aligned: bool) -> Result<Self, ScratchError> {
        let (needed, given) = (kind.len(width), memory.len());
        let len = width as usize + 2;
        let too_little = ScratchError { needed, given };
        if given < needed {
            return Err(too_little);
        }
        let memory: &mut [u16] = bytemuck::try_cast_slice_mut(memory).map_err(|_| too_little)?;
        let (mut memory, mut stride) = (memory, len);
        if aligned {
            let wide = len.next_multiple_of(2 * LINE);
            let first = memory.as_ptr().align_offset(size_of::<u16>() * 2 * LINE);
            if memory.len() >= first.saturating_add(2 * kind.count() * wide) {
                (memory, stride) = (memory.get_mut(first..).unwrap_or(&mut []), wide);
            }
        }
        let (classified, lit) = (kind != Rows::FastProjection, kind == Rows::LitFast);
        let mut row = |wanted: bool| -> &'s mut [u16] {
            if wanted {
                part_mut(take(&mut memory, stride), 0..len)
            } else {
                &mut []
            }
        };
        Ok(Self {
            z: [row(true), row(true)],
            samples: [row(true), row(lit), row(lit)],
            derivatives: [row(lit), row(lit)],
            slope: row(lit),
            batch: BatchRows {
                opacities: row(classified),
                colours: [row(classified), row(classified), row(classified)],
                g: [row(lit), row(lit), row(lit)],
                r: &mut [],
                magnitudes: &mut [],
            },
        })
    }
}

/// Rows of samples of four channels.
pub(super) struct ColourScratch<'s, W> {
    pub(super) runs: [RunRows<'s, W>; 4],
    /// Of the gradients of extinction; empty where there are none.
    pub(super) slopes: SourceRows<'s, W>,
    pub(super) g: [&'s mut [W]; 3],
    pub(super) r: &'s mut [W],
}

/// Rows of one channel, by the way it is sampled.
pub(super) enum RunRows<'s, W> {
    /// Between two slices.
    Linear(SourceRows<'s, W>),
    /// Between three.
    Smooth(SmoothRows<'s, W>),
}

impl<'s, W> ColourScratch<'s, W> {
    /// Cuts memory as [`Scratch::cut`] does: each channel is an unlit source.
    ///
    /// # Errors
    /// As [`Scratch::cut`].
    #[inline]
    pub(super) fn cut(memory: &'s mut [W], kind: Rows, width: u32, aligned: bool) -> Result<Self, ScratchError> {
        let mut rest = Rest::of(memory, kind, width, aligned)?;
        let lit = matches!(kind, Rows::LitColours | Rows::LitSmoothColours);
        let smooth = matches!(kind, Rows::SmoothColours | Rows::LitSmoothColours);
        let mut run = || {
            if smooth {
                RunRows::Smooth(SmoothRows {
                    z: [rest.row(), rest.row(), rest.row()],
                    y: rest.row(),
                    samples: rest.row(),
                })
            } else {
                RunRows::Linear(SourceRows {
                    z: [rest.row(), rest.row()],
                    inner: &mut [],
                    samples: [rest.row(), &mut [], &mut []],
                    derivatives: [&mut [], &mut []],
                })
            }
        };
        let runs = [run(), run(), run(), run()];
        let mut row = || -> &'s mut [W] { if lit { rest.row() } else { &mut [] } };
        Ok(Self {
            runs,
            slopes: SourceRows {
                z: [row(), row()],
                inner: row(),
                samples: [row(), row(), row()],
                derivatives: [row(), row()],
            },
            g: [row(), row(), row()],
            r: row(),
        })
    }
}

/// Rows of a source of rays that spread.
pub(super) struct SpreadScratch<'s, W> {
    /// Voxels interpolated along z, of two voxel rows, or four where gradients are needed.
    pub(super) z: [&'s mut [W]; 4],
    /// The row inside a face, from which the row beyond it is made.
    pub(super) inner: &'s mut [W],
    /// The voxel rows interpolated along y: about the samples, one voxel before them and one behind.
    pub(super) y: [&'s mut [W]; 3],
    /// Derivatives along z, interpolated along z, of an even and an odd voxel row.
    pub(super) derivatives: [&'s mut [W]; 2],
    /// The same interpolated along y.
    pub(super) derivative: &'s mut [W],
    /// The place of the voxel before each column's sample, the weight of the next, the square of the ray's slope along i, the slope.
    pub(super) cells: &'s mut [W],
    pub(super) weights: &'s mut [W],
    pub(super) squares: &'s mut [W],
    pub(super) slopes: &'s mut [W],
    pub(super) samples: &'s mut [W],
    /// Lengths of steps.
    pub(super) lengths: &'s mut [W],
    /// Unit vectors towards the eye.
    pub(super) towards: [&'s mut [W]; 3],
}

impl<'s, W> SpreadScratch<'s, W> {
    /// Cuts memory as [`Scratch::cut`] does, into rows of the longer length of a slice's rows and the image's; and the rows of a batch.
    ///
    /// # Errors
    /// As [`Scratch::cut`].
    #[inline]
    pub(super) fn cut(
        memory: &'s mut [W],
        kind: Rows,
        longest: u32,
        aligned: bool,
    ) -> Result<(Self, BatchRows<'s, W>), ScratchError> {
        let mut rest = Rest::of(memory, kind, longest, aligned)?;
        let lit = kind.lit();
        let mut row = |wanted: bool| -> &'s mut [W] { if wanted { rest.row() } else { &mut [] } };
        let source = Self {
            z: [row(true), row(true), row(lit), row(lit)],
            inner: row(lit),
            y: [row(true), row(lit), row(lit)],
            derivatives: [row(lit), row(lit)],
            derivative: row(lit),
            cells: row(true),
            weights: row(true),
            squares: row(true),
            slopes: row(lit),
            samples: row(true),
            lengths: row(true),
            towards: [row(lit), row(lit), row(lit)],
        };
        let batch = BatchRows {
            opacities: row(true),
            colours: [row(true), row(true), row(true)],
            g: [row(lit), row(lit), row(lit)],
            r: row(lit),
            magnitudes: &mut [],
        };
        Ok((source, batch))
    }
}

/// Memory from which rows are cut.
struct Rest<'s, W> {
    memory: &'s mut [W],
    len: usize,
    stride: usize,
}

impl<'s, W> Rest<'s, W> {
    #[inline]
    fn of(memory: &'s mut [W], kind: Rows, width: u32, aligned: bool) -> Result<Self, ScratchError> {
        let (needed, given) = (kind.len(width), memory.len());
        if given < needed {
            return Err(ScratchError { needed, given });
        }
        let len = width as usize + 2;
        let (mut memory, mut stride) = (memory, len);
        if aligned {
            let wide = len.next_multiple_of(LINE);
            let first = memory.as_ptr().align_offset(size_of::<W>() * LINE);
            if given >= first.saturating_add(kind.count() * wide) {
                (memory, stride) = (memory.get_mut(first..).unwrap_or(&mut []), wide);
            }
        }
        Ok(Self { memory, len, stride })
    }

    #[inline]
    fn row(&mut self) -> &'s mut [W] {
        part_mut(take(&mut self.memory, self.stride), 0..self.len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn channels_are_cut_as_counted() {
        let kinds = [
            (Rows::Colours, 12),
            (Rows::LitColours, 24),
            (Rows::SmoothColours, 20),
            (Rows::LitSmoothColours, 32),
        ];
        for (kind, wanted) in kinds {
            for width in [1, 2, 15, 64, 65] {
                let needed = kind.len(width);
                for spare in [0, 1, 700] {
                    let mut memory = vec![0i32; needed + spare];
                    let ColourScratch { runs, slopes, g, r } =
                        ColourScratch::cut(&mut memory, kind, width, true).unwrap();
                    let of_source = |rows: &SourceRows<'_, i32>| {
                        let all = rows.z.iter().chain(&rows.samples).chain(&rows.derivatives);
                        all.map(|row| row.len()).chain([rows.inner.len()]).collect::<Vec<_>>()
                    };
                    let of_run = |rows: &RunRows<'_, i32>| match rows {
                        RunRows::Linear(rows) => of_source(rows),
                        RunRows::Smooth(rows) => {
                            let all = rows.z.iter().map(|row| row.len());
                            all.chain([rows.y.len(), rows.samples.len()]).collect()
                        }
                    };
                    let rows = runs.iter().flat_map(of_run).chain(of_source(&slopes));
                    let rows = rows.chain(g.iter().map(|row| row.len())).chain([r.len()]);
                    let made: Vec<usize> = rows.filter(|len| *len > 0).collect();
                    assert!(made.len() == wanted && made.iter().all(|len| *len == width as usize + 2));
                    assert_eq!(wanted * (width as usize + 2), needed);
                }
                let given = needed - 1;
                let refused = ColourScratch::cut(&mut vec![0i32; given], kind, width, true).err();
                assert_eq!(refused, Some(ScratchError { needed, given }));
            }
        }
    }

    /// Two rows of halves to a row of words, of which the last half may be nothing's.
    #[test]
    fn halves_are_cut_as_counted() {
        for (kind, wanted, words) in [(Rows::FastProjection, 3, 2), (Rows::Fast, 7, 4), (Rows::LitFast, 15, 8)] {
            for width in [1, 2, 15, 64, 65] {
                let (needed, len) = (kind.len(width), width as usize + 2);
                assert_eq!(needed, words * len);
                for (spare, aligned) in [(0, true), (1, true), (700, true), (700, false)] {
                    let mut memory = vec![0i32; needed + spare];
                    let cut = FastScratch::cut(&mut memory, kind, width, aligned).unwrap();
                    let batch = &cut.batch;
                    assert!(batch.r.is_empty() && batch.magnitudes.is_empty());
                    let rows = cut.z.iter().chain(&cut.samples).chain(&cut.derivatives);
                    let rows = rows.chain([&cut.slope, &batch.opacities]);
                    let rows = rows.chain(&batch.colours).chain(&batch.g).filter(|row| !row.is_empty());
                    let mut places: Vec<(usize, usize)> = rows.map(|row| (row.as_ptr().addr(), row.len())).collect();
                    assert!(places.len() == wanted && places.iter().all(|(_, row_len)| *row_len == len));
                    places.sort_unstable();
                    assert!(places.windows(2).all(|pair| pair[0].0 + 2 * len <= pair[1].0));
                    let lines = places.iter().all(|(place, _)| place % (4 * LINE) == 0);
                    assert!(lines || !aligned || spare < 700, "{kind:?} {width}");
                }
                let given = needed - 1;
                let refused = FastScratch::cut(&mut vec![0i32; given], kind, width, true).err();
                assert_eq!(refused, Some(ScratchError { needed, given }));
            }
        }
    }

    #[test]
    fn rays_that_spread_are_cut_as_counted() {
        for (kind, wanted) in [(Rows::Spread, 12), (Rows::LitSpread, 28)] {
            for longest in [1, 2, 15, 64, 65] {
                let needed = kind.len(longest);
                for spare in [0, 1, 700] {
                    let mut memory = vec![0i32; needed + spare];
                    let (cut, batch) = SpreadScratch::cut(&mut memory, kind, longest, true).unwrap();
                    let rows = cut.z.iter().chain(&cut.y).chain(&cut.derivatives).chain(&cut.towards);
                    let rows = rows.chain([&cut.inner, &cut.derivative, &cut.cells, &cut.weights, &cut.squares]);
                    let rows = rows.chain([&cut.slopes, &cut.samples, &cut.lengths, &batch.opacities, &batch.r]);
                    let rows = rows.chain(&batch.colours).chain(&batch.g);
                    let made: Vec<usize> = rows.map(|row| row.len()).filter(|len| *len > 0).collect();
                    assert!(made.len() == wanted && made.iter().all(|len| *len == longest as usize + 2));
                    assert_eq!(wanted * (longest as usize + 2), needed);
                }
                let given = needed - 1;
                let refused = SpreadScratch::cut(&mut vec![0i32; given], kind, longest, true).err();
                assert_eq!(refused, Some(ScratchError { needed, given }));
            }
        }
    }

    #[test]
    fn splines_are_cut_as_counted() {
        for kind in [Rows::Splines, Rows::LitSplines] {
            for (width, spare) in [1, 2, 15, 64, 65]
                .into_iter()
                .flat_map(|width| [(width, 0), (width, 700)])
            {
                let needed = kind.len(width);
                let mut memory = vec![0i32; needed + spare];
                let SplineScratch { samples, slopes, batch } =
                    SplineScratch::cut(&mut memory, kind, width, true).unwrap();
                let rows = [&samples.z[..], &slopes.z, &batch.colours, &batch.g]
                    .into_iter()
                    .flatten();
                let rest = [&samples.y, &samples.samples, &slopes.y, &batch.opacities, &batch.r];
                let made: Vec<usize> = rows.chain(rest).map(|row| row.len()).filter(|len| *len > 0).collect();
                assert!(made.iter().all(|len| *len == width as usize + 2));
                assert_eq!(made.len() * (width as usize + 2), needed);
                let given = needed - 1;
                let refused = SplineScratch::cut(&mut vec![0i32; given], kind, width, true).err();
                assert_eq!(refused, Some(ScratchError { needed, given }));
            }
        }
    }

    #[test]
    fn every_length_is_cut_as_counted() {
        for kind in [
            Rows::Projection,
            Rows::Unlit,
            Rows::Lit,
            Rows::Modulated,
            Rows::UnlitSlabs,
            Rows::LitSlabs,
        ] {
            for width in [1, 2, 15, 64, 65] {
                let needed = kind.len(width);
                for spare in [0, 1, 700] {
                    let mut memory = vec![0i32; needed + spare];
                    let Scratch {
                        source,
                        front,
                        front_gradients,
                        batch,
                    } = Scratch::cut(&mut memory, kind, width, true).unwrap();
                    let rows = [
                        source.z.as_slice(),
                        &source.samples,
                        &source.derivatives,
                        &front.z,
                        &front.samples,
                        &front.derivatives,
                        &front_gradients,
                        &batch.colours,
                        &batch.g,
                    ];
                    let rows = rows.into_iter().flatten().map(|row| row.len());
                    let rest = [
                        &source.inner,
                        &front.inner,
                        &batch.opacities,
                        &batch.r,
                        &batch.magnitudes,
                    ];
                    let rest = rest.map(|row| row.len());
                    let mut made = 0;
                    for len in rows.chain(rest).filter(|len| *len > 0) {
                        assert_eq!(len, width as usize + 2);
                        made += 1;
                    }
                    assert_eq!(made * (width as usize + 2), needed);
                }
                let given = needed - 1;
                let refused = Scratch::cut(&mut vec![0i32; given], kind, width, true).err();
                assert_eq!(refused, Some(ScratchError { needed, given }));
            }
        }
    }
}
