//! What the mapping to 12 bits did to the data, for people to read.

use std::fmt;

/// What the mapping to 12 bits did to the data. All values are in the data's own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingReport {
    /// Least and greatest value of the data.
    pub range: [f64; 2],
    /// Values of code 0 and code 4095.
    pub window: [f64; 2],
    /// Codes per data unit.
    pub codes_per_unit: f64,
    /// Voxels below the window, now code 0.
    pub clipped_low: u64,
    /// Voxels above the window, now code 4095.
    pub clipped_high: u64,
    /// Whether what is clipped are outliers (see [`Window::Auto`](super::Window::Auto)).
    pub outliers: bool,
    /// How many labels the codes count, if they do.
    pub labels: Option<usize>,
    /// Whether every data value can be had back from its code (for integers, by rounding).
    pub lossless: bool,
    /// Bits of an integer's resolution that the codes do not keep: log2 of the integers in use per code, at least 0.
    /// `None` for floating-point data, whose resolution is not known.
    pub bits_lost: Option<f64>,
    /// The greatest distance between a data value inside the window and its code's value.
    pub max_rounding_error: f64,
}

impl fmt::Display for MappingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.range;
        let [first, last] = self.window;
        if let Some(count) = self.labels {
            return write!(
                f,
                "{count} labels from {low} to {high} renumbered: codes 0 to {} are the labels in ascending order, without loss",
                count - 1
            );
        }
        write!(
            f,
            "values {low} to {high} mapped to 12 bits: codes 0 to 4095 are {first} to {last}"
        )?;
        if self.lossless {
            return write!(f, ", without loss");
        }
        writeln!(f, ", {:.6} codes a unit", self.codes_per_unit)?;
        match self.bits_lost {
            Some(bits) if bits > 0.0 => write!(f, "{bits:.1} bits lost, ")?,
            _ => {}
        }
        write!(f, "rounding error at most {:.6}, ", self.max_rounding_error)?;
        match (self.clipped_low, self.clipped_high) {
            (0, 0) => write!(f, "nothing clipped"),
            (low, high) => write!(f, "clipped {low} voxels below and {high} above"),
        }?;
        if self.outliers {
            let rule = "outliers, farther beyond the middle 99.98 % of the voxels than twice their range";
            write!(f, " ({rule}; a window shows them)")?;
        }
        Ok(())
    }
}
