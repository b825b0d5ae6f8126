//! Pixels of 16 bits, into which samples are folded by the roots of their opacities.

use core::marker::PhantomData;
use core::ops::Range;

use crate::composite::{Colours, Order, PixelRow};
use crate::fast::fold::{Given, Offsets, fold_row};
use crate::lanes::{Halves, Kernel, Lanes};
use crate::plane::canvas::{AllFinished, Canvas};
use crate::rows::{part, part_mut};
use crate::tap::Bits;

/// Rows of an image whose channels lie in runs.
pub(super) struct Pixels<'a, O, V> {
    data: &'a mut [u16],
    /// Number of the first row.
    first: u32,
    /// Pixels of a row.
    width: usize,
    columns: Range<usize>,
    pub(super) offsets: Offsets,
    pub(super) floor: u16,
    kinds: PhantomData<(O, V)>,
}

impl<'a, O: Order, V: Lanes> Pixels<'a, O, V> {
    #[inline(always)]
    pub(super) const fn new(
        (first, data): (u32, &'a mut [u16]),
        width: usize,
        columns: Range<usize>,
        plane: u32,
        floor: u16,
    ) -> Self {
        Self {
            data,
            first,
            width,
            columns,
            offsets: Offsets::of_plane(plane),
            floor,
            kinds: PhantomData,
        }
    }

    /// Where the elements of a row begin.
    #[inline(always)]
    fn start(&self, row: u32) -> usize {
        4 * self.width * row.saturating_sub(self.first) as usize
    }

    /// What is left of the light in some columns of a row.
    #[inline(always)]
    pub(super) fn left(&self, row: u32, columns: Range<usize>) -> &[u16] {
        let start = self.start(row) + 3 * self.width + self.columns.start;
        part(self.data, start + columns.start..start + columns.end)
    }

    /// The pixels of some columns of a row.
    #[inline(always)]
    pub(super) fn pixel_row(&mut self, row: u32, columns: Range<usize>) -> PixelRow<'_, u16> {
        let (start, width, first) = (self.start(row), self.width, self.columns.start);
        let data = part_mut(self.data, start..start + 4 * width);
        PixelRow::of_runs(data, width, first + columns.start..first + columns.end)
    }

    /// The columns of one of a row's four runs.
    #[inline(always)]
    fn run(&self, row: u32, channel: usize) -> &[u16] {
        let start = self.start(row) + channel * self.width;
        part(self.data, start + self.columns.start..start + self.columns.end)
    }
}

impl<O: Order, V: Lanes> Canvas<u16> for Pixels<'_, O, V> {
    #[inline(always)]
    fn back_to_front(&self) -> bool {
        O::BACK_TO_FRONT
    }

    #[inline(always)]
    fn begin_part(&mut self, _: u32) {}

    #[inline(always)]
    fn finished(&self, row: u32) -> bool {
        !O::BACK_TO_FRONT && V::enter((AllFinished, PhantomData::<V>, self.run(row, 3)))
    }

    #[inline(always)]
    fn visible(&self, row: u32, roots: &[u16], from: usize) -> Option<Range<usize>> {
        V::enter((Visible, PhantomData::<(O, V)>, roots, self.run(row, 3), from))
    }

    #[inline(always)]
    fn fold(&mut self, row: u32, span: Range<usize>, colours: &Colours<'_, u16>, roots: &[u16]) {
        V::enter((Fold, self, row, span, colours, roots));
    }

    fn look(&self, row: u32, span: Range<usize>, see: &mut dyn FnMut(&[&dyn Bits])) {
        let run = |channel| part(self.run(row, channel), span.clone());
        see(&[&run(0), &run(1), &run(2), &run(3)]);
    }
}

struct Fold;

impl<O: Order, V: Lanes> Kernel
    for (
        Fold,
        &mut Pixels<'_, O, V>,
        u32,
        Range<usize>,
        &Colours<'_, u16>,
        &[u16],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, pixels, row, span, colours, roots) = self;
        let (start, width) = (pixels.start(row), pixels.width);
        let columns = pixels.columns.start + span.start..pixels.columns.start + span.end;
        let data = pixels.data.get_mut(start..start + 4 * width).unwrap_or(&mut []);
        let mut row = PixelRow::of_runs(data, width, columns);
        let given = match colours.one {
            Some(colour) => Given::One(colour.map(|c| c as u16)),
            None => Given::Rows(colours.rows()),
        };
        fold_row::<O, V::Halves>(&mut row, given, roots, pixels.offsets, pixels.floor);
    }
}

struct Visible;

impl<O: Order, V: Lanes> Kernel for (Visible, PhantomData<(O, V)>, &[u16], &[u16], usize) {
    type Output = Option<Range<usize>>;

    #[inline(always)]
    fn run(self) -> Option<Range<usize>> {
        let (_, _, roots, transparencies, from) = self;
        let step = V::Halves::COUNT;
        let mut start = from;
        while start < roots.len() && !any_visible::<O, V::Halves>(roots, transparencies, start) {
            start += step;
        }
        let mut end = start;
        while end < roots.len() && any_visible::<O, V::Halves>(roots, transparencies, end) {
            end += step;
        }
        (start < end).then_some(start..end.min(roots.len()))
    }
}

/// Whether any of the samples at `at` is visible.
#[inline(always)]
fn any_visible<O: Order, H: Halves>(roots: &[u16], transparencies: &[u16], at: usize) -> bool {
    let roots = H::load::<false>(roots, at);
    if O::BACK_TO_FRONT {
        !roots.all_zero()
    } else {
        !H::load::<false>(transparencies, at).nonzero_then(roots).all_zero()
    }
}
