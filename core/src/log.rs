//! `defmt::Format` (feature `defmt`) for what is not derived beside its type: it goes to the log as numbers, and the words stay
//! in the host's program.

use defmt::{Format, Formatter, write};

use crate::plan::Plan;
use crate::plane::ScratchError;

/// Sizes in voxels along i, j, k; the base plane in rays of one phase; the step's raw bits, s31.32.
impl Format for Plan {
    fn format(&self, f: Formatter<'_>) {
        let ([width, height, depth], [columns, rows]) = (self.dims(), self.base());
        let view = self.view();
        let [si, sj, sk] = self.step().map(|step| step.to_bits());
        write!(
            f,
            "{}x{}x{} voxels along i, j, k; k is {}, reversed: {}; base plane {}x{} x {} phases, {} planes; step {}, {}, {} / 2^32",
            width,
            height,
            depth,
            view.major(),
            view.reversed(),
            columns,
            rows,
            self.phases(),
            self.planes(),
            si,
            sj,
            sk,
        );
    }
}

impl Format for ScratchError {
    fn format(&self, f: Formatter<'_>) {
        let Self { needed, given } = self;
        write!(f, "ScratchError {{ needed: {}, given: {} }}", needed, given);
    }
}
