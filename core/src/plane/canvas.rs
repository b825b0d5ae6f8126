//! The canvas: rows of pixels that samples are folded into, with the kernels that read and write pixels.

use core::marker::PhantomData;
use core::ops::Range;

use super::places::Places;
use crate::absorption::Absorption;
use crate::composite::{
    Channel, Colours, Dither, FrontToBack, Order, PixelRow, Recurrence, Weighted, fold_at, fold_row, fold_visible_row,
    fold_weighted_row,
};
use crate::lanes::{Kernel, Lanes, places};
use crate::modulate::modulated;
use crate::rows::part;
use crate::tap::Bits;

/// Pixels of some rows of the image under one plane. Columns and spans are counted from the plane's first column.
pub(super) trait Canvas<W> {
    /// Whether what lies behind is folded first.
    fn back_to_front(&self) -> bool;
    /// Says which part of segments is folded from now on.
    fn begin_part(&mut self, part: u32);
    /// Whether all rays of a row have terminated.
    fn finished(&self, row: u32) -> bool;
    /// The next span of visible samples at or after `from`, in whole vectors: an invisible sample among them changes
    /// nothing.
    fn visible(&self, row: u32, opacities: &[W], from: usize) -> Option<Range<usize>>;
    /// Folds a sample into each pixel of a span.
    fn fold(&mut self, row: u32, span: Range<usize>, colours: &Colours<'_, W>, opacities: &[W]);
    /// Shows red, green, blue and transparency of a span.
    fn look(&self, row: u32, span: Range<usize>, see: &mut dyn FnMut(&[&dyn Bits]));

    /// Multiplies opacities by factors.
    fn weigh(&self, _opacities: &mut [W], _factors: &[W]) {}
}

/// A canvas of a plane's parts, into which blocks are folded, packed side by side.
pub(super) trait Packing<W>: Canvas<W> {
    /// Says which columns have a sample from now on.
    fn begin(&mut self, columns: Range<usize>);
    /// Drops the fresh places under which all rays have terminated; the number of those left.
    fn unfinished(&self, places: &mut Places<'_>, fresh: Range<usize>) -> usize;
    /// Moves vectors with a visible sample to the front, and visible samples side by side; how many there are of both.
    /// Invisible samples get an opacity of 0.
    fn pack(
        &self,
        places: &mut Places<'_>,
        count: usize,
        samples: [&mut [W]; 2],
        opacities: &mut [W],
    ) -> (usize, usize);
    /// Folds packed samples.
    fn fold_packed(&mut self, places: &Places<'_>, count: usize, colours: &Colours<'_, W>, opacities: &[W]);
    /// [`Canvas::fold_packed`] of samples whose opacities are multiplied by factors, which are packed as colours are.
    fn fold_weighed(
        &mut self,
        places: &Places<'_>,
        count: usize,
        colours: &Colours<'_, W>,
        opacities: &[W],
        factors: &[W],
    );
}

/// Rows of an image whose channels lie in runs.
pub(super) struct Image<'a, R: Recurrence, O, V> {
    data: &'a mut [R::Channel],
    /// Number of the first row.
    first: u32,
    /// Pixels of a row.
    width: usize,
    columns: Range<usize>,
    /// Number of the plane.
    plane: u32,
    dither: Dither,
    recurrence: R,
    floor: R::Channel,
    kinds: PhantomData<(O, V)>,
}

impl<'a, R: Recurrence, O: Order, V: Lanes> Image<'a, R, O, V> {
    #[inline(always)]
    pub(super) fn new(
        (first, data): (u32, &'a mut [R::Channel]),
        width: usize,
        columns: Range<usize>,
        plane: u32,
        (recurrence, floor): (R, R::Channel),
    ) -> Self {
        Self {
            data,
            first,
            width,
            columns,
            plane,
            dither: Dither::of_plane(plane),
            recurrence,
            floor,
            kinds: PhantomData,
        }
    }

    /// Where the elements of a row begin.
    #[inline(always)]
    fn start(&self, row: u32) -> usize {
        4 * self.width * row.saturating_sub(self.first) as usize
    }

    /// The columns of one of a row's four runs.
    #[inline(always)]
    fn run(&self, row: u32, channel: usize) -> &[R::Channel] {
        let start = self.start(row) + channel * self.width;
        let columns = start + self.columns.start..start + self.columns.end;
        self.data.get(columns).unwrap_or(&[])
    }

    /// Some columns of the image's pixels in the row that begins at an element.
    #[inline(always)]
    fn pixels(&mut self, start: usize, columns: Range<usize>) -> PixelRow<'_, R::Channel> {
        let row = self.data.get_mut(start..start + 4 * self.width).unwrap_or(&mut []);
        PixelRow::of_runs(row, self.width, columns)
    }

    /// The transparencies under the vector at a place; a ray that has terminated is 0.
    #[inline(always)]
    fn left(&self, places: &Places<'_>, (row, column): (usize, usize)) -> V {
        let pixels = places.pixels(column);
        let start = (4 * row + 3) * self.width;
        let run = self.data.get(start..start + pixels.end).unwrap_or(&[]);
        V::load_as(run, pixels.start, Channel::bits)
    }
}

impl<R: Weighted, V: Lanes> Image<'_, R, FrontToBack, V> {
    /// Folds the samples of a span of a row: extinction, and red, green and blue times extinction.
    #[inline(always)]
    pub(super) fn absorb(&mut self, row: u32, span: Range<usize>, samples: [&[i32]; 4], absorption: Absorption) {
        V::enter((Absorb, self, row, span, samples, absorption));
    }
}

struct Absorb;

impl<R: Weighted, V: Lanes> Kernel
    for (
        Absorb,
        &mut Image<'_, R, FrontToBack, V>,
        u32,
        Range<usize>,
        [&[i32]; 4],
        Absorption,
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, image, row, span, samples, absorption) = self;
        let (recurrence, dither, floor) = (image.recurrence, image.dither, image.floor);
        let first = image.columns.start;
        let mut pixels = image.pixels(image.start(row), first + span.start..first + span.end);
        fold_weighted_row::<R, V>(recurrence, &mut pixels, samples, absorption, dither, floor);
    }
}

impl<R: Recurrence, O: Order, V: Lanes> Canvas<i32> for Image<'_, R, O, V> {
    #[inline(always)]
    fn back_to_front(&self) -> bool {
        O::BACK_TO_FRONT
    }

    #[inline(always)]
    fn begin_part(&mut self, part: u32) {
        self.dither = Dither::of_part(self.plane, part);
    }

    #[inline(always)]
    fn finished(&self, row: u32) -> bool {
        !O::BACK_TO_FRONT && V::enter((AllFinished, PhantomData::<V>, self.run(row, 3)))
    }

    #[inline(always)]
    fn visible(&self, row: u32, opacities: &[i32], from: usize) -> Option<Range<usize>> {
        V::enter((Visible, PhantomData::<(O, V)>, opacities, self.run(row, 3), from))
    }

    #[inline(always)]
    fn fold(&mut self, row: u32, span: Range<usize>, colours: &Colours<'_, i32>, opacities: &[i32]) {
        V::enter((Fold, self, row, span, colours, opacities));
    }

    fn look(&self, row: u32, span: Range<usize>, see: &mut dyn FnMut(&[&dyn Bits])) {
        let run = |channel| self.run(row, channel).get(span.clone()).unwrap_or(&[]);
        see(&[&run(0), &run(1), &run(2), &run(3)]);
    }

    #[inline(always)]
    fn weigh(&self, opacities: &mut [i32], factors: &[i32]) {
        V::enter((Weigh, PhantomData::<V>, opacities, factors));
    }
}

impl<R: Recurrence, O: Order, V: Lanes> Packing<i32> for Image<'_, R, O, V> {
    #[inline(always)]
    fn begin(&mut self, columns: Range<usize>) {
        self.columns = columns;
    }

    #[inline(always)]
    fn unfinished(&self, places: &mut Places<'_>, fresh: Range<usize>) -> usize {
        if O::BACK_TO_FRONT {
            return fresh.end;
        }
        V::enter((Unfinished, self, places, fresh))
    }

    #[inline(always)]
    fn pack(
        &self,
        places: &mut Places<'_>,
        count: usize,
        samples: [&mut [i32]; 2],
        opacities: &mut [i32],
    ) -> (usize, usize) {
        V::enter((Pack, self, places, count, samples, opacities))
    }

    #[inline(always)]
    fn fold_packed(&mut self, places: &Places<'_>, count: usize, colours: &Colours<'_, i32>, opacities: &[i32]) {
        V::enter((FoldPacked, self, places, count, colours, opacities));
    }

    #[inline(always)]
    fn fold_weighed(
        &mut self,
        places: &Places<'_>,
        count: usize,
        colours: &Colours<'_, i32>,
        opacities: &[i32],
        factors: &[i32],
    ) {
        V::enter((FoldWeighed, self, (places, count), colours, opacities, factors));
    }
}

/// Whether no ray of whole rows of this width goes on.
#[inline(always)]
pub(super) fn rows_finished<C: Channel, V: Lanes>(width: usize, data: &[C]) -> bool {
    for row in data.chunks_exact((4 * width).max(1)) {
        if !V::enter((AllFinished, PhantomData::<V>, part(row, 3 * width..4 * width))) {
            return false;
        }
    }
    true
}

/// [`all_finished`].
pub(super) struct AllFinished;

impl<C: Channel, V: Lanes> Kernel for (AllFinished, PhantomData<V>, &[C]) {
    type Output = bool;
    const BRIEF: bool = true;

    #[inline(always)]
    fn run(self) -> bool {
        let (_, _, transparencies) = self;
        all_finished::<_, V>(transparencies)
    }
}

struct Visible;

impl<C: Channel, O: Order, V: Lanes> Kernel for (Visible, PhantomData<(O, V)>, &[i32], &[C], usize) {
    type Output = Option<Range<usize>>;
    const BRIEF: bool = true;

    #[inline(always)]
    fn run(self) -> Option<Range<usize>> {
        let (_, _, opacities, transparencies, from) = self;
        visible_span::<O, _, V>(opacities, transparencies, from)
    }
}

struct Fold;

impl<R: Recurrence, O: Order, V: Lanes> Kernel
    for (
        Fold,
        &mut Image<'_, R, O, V>,
        u32,
        Range<usize>,
        &Colours<'_, i32>,
        &[i32],
    )
{
    type Output = ();
    const BRIEF: bool = true;

    #[inline(always)]
    fn run(self) {
        let (_, image, row, span, colours, opacities) = self;
        let (recurrence, dither, floor) = (image.recurrence, image.dither, image.floor);
        let columns = image.columns.start + span.start..image.columns.start + span.end;
        let mut pixels = image.pixels(image.start(row), columns);
        match colours.one {
            Some(colour) => fold_visible_row::<R, O, V>(recurrence, &mut pixels, colour, opacities, dither, floor),
            None => fold_row::<R, O, V>(recurrence, &mut pixels, colours.rows(), opacities, dither, floor),
        }
    }
}

struct Unfinished;

impl<R: Recurrence, O: Order, V: Lanes> Kernel for (Unfinished, &Image<'_, R, O, V>, &mut Places<'_>, Range<usize>) {
    type Output = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let (_, image, places, fresh) = self;
        let mut kept = fresh.start;
        for number in fresh {
            let place = places.get(number);
            // Branch-free, because the outcome is unpredictable.
            places.set(kept, place);
            kept += usize::from(!image.left(places, place).all_zero());
        }
        kept
    }
}

struct Pack;

impl<R: Recurrence, O: Order, V: Lanes> Kernel
    for (
        Pack,
        &Image<'_, R, O, V>,
        &mut Places<'_>,
        usize,
        [&mut [i32]; 2],
        &mut [i32],
    )
{
    type Output = (usize, usize);

    #[inline(always)]
    fn run(self) -> (usize, usize) {
        let (_, image, places, count, [front, samples], opacities) = self;
        let (slabs, mut kept, mut packed) = (!front.is_empty(), 0, 0);
        for number in 0..count {
            let place = places.get(number);
            let at = number * V::COUNT;
            let opacity = if O::BACK_TO_FRONT {
                // Lanes beyond the block see nothing.
                V::load(part(opacities, at..at + places.pixels(place.1).len()), 0)
            } else {
                image.left(places, place).nonzero_then(V::load(opacities, at))
            };
            V::load(samples, at).packed(opacity).store(samples, packed);
            if slabs {
                V::load(front, at).packed(opacity).store(front, packed);
            }
            packed += opacity.count();
            opacity.store(opacities, kept * V::COUNT);
            places.set(kept, place);
            kept += usize::from(!opacity.all_zero());
        }
        (kept, packed)
    }
}

struct FoldPacked;

impl<R: Recurrence, O: Order, V: Lanes> Kernel
    for (
        FoldPacked,
        &mut Image<'_, R, O, V>,
        &Places<'_>,
        usize,
        &Colours<'_, i32>,
        &[i32],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, image, places, count, colours, opacities) = self;
        image.fold_places(places, count, colours, opacities, None);
    }
}

struct FoldWeighed;

impl<R: Recurrence, O: Order, V: Lanes> Kernel
    for (
        FoldWeighed,
        &mut Image<'_, R, O, V>,
        (&Places<'_>, usize),
        &Colours<'_, i32>,
        &[i32],
        &[i32],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, image, (places, count), colours, opacities, factors) = self;
        image.fold_places(places, count, colours, opacities, Some(factors));
    }
}

impl<R: Recurrence, O: Order, V: Lanes> Image<'_, R, O, V> {
    /// Folds packed samples, perhaps with factors: known where it is called, so that neither way decides at each sample.
    #[inline(always)]
    fn fold_places(
        &mut self,
        places: &Places<'_>,
        count: usize,
        colours: &Colours<'_, i32>,
        opacities: &[i32],
        factors: Option<&[i32]>,
    ) {
        let (recurrence, dither, width) = (self.recurrence, self.dither, self.width);
        let floor = V::splat(self.floor.bits() as i32);
        let [red, green, blue] = colours.rows();
        let mut at = 0;
        for number in 0..count {
            let (row, column) = places.get(number);
            let opacity = V::load(opacities, number * V::COUNT);
            let colour = [
                V::load(red, at).spread(opacity),
                V::load(green, at).spread(opacity),
                V::load(blue, at).spread(opacity),
            ];
            // A factor may be 0 where the table's opacity, by which samples are packed, is not.
            let folded = match factors {
                Some(factors) => modulated(opacity, V::load(factors, at).spread(opacity)),
                None => opacity,
            };
            at += opacity.count();
            let mut pixels = self.pixels(4 * row * width, places.pixels(column));
            fold_at::<R, O, V>(recurrence, &mut pixels, 0, (colour, folded), dither, floor);
        }
    }
}

struct Weigh;

impl<V: Lanes> Kernel for (Weigh, PhantomData<V>, &mut [i32], &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, opacities, factors) = self;
        for at in places::<V>(opacities.len()) {
            modulated(V::load(opacities, at), V::load(factors, at)).store(opacities, at);
        }
    }
}

/// Whether any of the `V::COUNT` samples at `at` is visible.
#[inline(always)]
fn any_visible<O: Order, C: Channel, V: Lanes>(opacities: &[i32], transparencies: &[C], at: usize) -> bool {
    let opacity = V::load(opacities, at);
    let visible = if O::BACK_TO_FRONT {
        opacity
    } else {
        V::load_as(transparencies, at, C::bits).nonzero_then(opacity)
    };
    !visible.all_zero()
}

#[inline(always)]
fn visible_span<O: Order, C: Channel, V: Lanes>(
    opacities: &[i32],
    transparencies: &[C],
    from: usize,
) -> Option<Range<usize>> {
    let transparencies = transparencies.get(..opacities.len())?;
    let mut start = from;
    while start < opacities.len() && !any_visible::<O, C, V>(opacities, transparencies, start) {
        start += V::COUNT;
    }
    let mut end = start;
    while end < opacities.len() && any_visible::<O, C, V>(opacities, transparencies, end) {
        end += V::COUNT;
    }
    (start < end).then_some(start..end.min(opacities.len()))
}

/// Whether all rays of a row have terminated.
#[inline(always)]
fn all_finished<C: Channel, V: Lanes>(transparencies: &[C]) -> bool {
    for at in (0..transparencies.len()).step_by(V::COUNT) {
        if !V::load_as(transparencies, at, C::bits).all_zero() {
            return false;
        }
    }
    true
}
