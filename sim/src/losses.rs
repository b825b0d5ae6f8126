//! What compiling a transfer function to a table lost.

use slicecast_engine::table::{Correction, Table};
use slicecast_scene::TransferFunction;
use slicecast_volume::Mapping;

/// What compiling a transfer function to a table lost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Entries with an opacity above 0.
    pub visible: usize,
    /// Visible entries that the table makes invisible.
    pub underflows: usize,
    /// Visible entries whose opacity is off by more than the share asked about, underflows included.
    pub coarse: usize,
    /// The greatest relative error of an opacity, 1 for an underflow; more where an entry makes up for its neighbours'
    /// underflow.
    pub worst: f64,
    /// The data value where it is.
    pub worst_value: f64,
}

/// Compares a table with the function that it was compiled from; `share` is the relative error of an opacity from which
/// on an entry counts as coarse.
pub fn losses(
    table: &Table,
    transfer: &TransferFunction,
    mapping: &Mapping,
    correction: Correction,
    share: f64,
) -> Losses {
    let mut losses = Losses::default();
    for index in 0..table.entries.len() {
        let value = mapping.value(index as f64);
        let exact = correction.apply(transfer.evaluate(value).1, transfer.unit_distance);
        if exact <= 0.0 {
            continue;
        }
        losses.visible += 1;
        let decoded = f64::from(table.opacity(index).to_bits()) / f64::from(1_u32 << 31);
        let error = (decoded - exact).abs() / exact;
        losses.underflows += usize::from(decoded == 0.0);
        losses.coarse += usize::from(error > share);
        if error > losses.worst {
            (losses.worst, losses.worst_value) = (error, value);
        }
    }
    losses
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_scene::{AlphaCodeName, LookupName, Point};

    const MAPPING: Mapping = Mapping {
        scale: 1.0,
        offset: -1024.0,
    };

    fn fog(opacity: f64) -> TransferFunction {
        let point = |value, opacity| Point {
            value,
            colour: [1.0, 0.5, 0.0],
            opacity,
        };
        TransferFunction {
            unit_distance: 1.0,
            points: vec![point(0.0, 0.0), point(0.0, opacity)],
        }
    }

    fn compiled(opacity: f64, code: AlphaCodeName) -> (Table, Losses) {
        let table = Table::compile(&fog(opacity), &MAPPING, Correction::None, code, LookupName::Nearest);
        let losses = losses(&table, &fog(opacity), &MAPPING, Correction::None, 0.05);
        (table, losses)
    }

    #[test]
    fn underflow_and_coarse_steps_are_counted() {
        // (1/255 / 2)^2 is the least opacity that an 8-bit root shows.
        let (_, lost) = compiled(3e-6, AlphaCodeName::Sqrt8);
        // Errors are passed on from entry to entry: some show the least opacity in the others' place.
        assert_eq!(lost.visible, 3072);
        assert!(
            lost.underflows > 1500 && lost.coarse == 3072 && lost.worst >= 1.0,
            "{lost:?}"
        );
        let (_, kept) = compiled(3e-6, AlphaCodeName::Sqrt16);
        assert_eq!((kept.underflows, kept.coarse), (0, 0));
        let (_, fine) = compiled(0.5, AlphaCodeName::Sqrt8);
        assert!(fine.worst < 0.01 && fine.coarse == 0, "{fine:?}");
    }
}
