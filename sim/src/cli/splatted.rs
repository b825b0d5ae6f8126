//! Layouts of records by their names.

use clap::ValueEnum;
use slicecast::splat::Layout;

use super::Failure;

/// What a voxel's record of 64 bits holds: x and y 11.11, u 8 and all 12 bits of the value (fine), or Squeeze's x and y 11.13, u 8 and 8 bits
/// of the value (paper).
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SplatArg {
    Fine,
    Paper,
}

impl From<SplatArg> for Layout {
    fn from(arg: SplatArg) -> Self {
        match arg {
            SplatArg::Fine => Self::FINE,
            SplatArg::Paper => Self::PAPER,
        }
    }
}

/// For a volume of colours, which splatting does not know.
pub fn check_none(asked: bool, what: &str) -> Result<(), Failure> {
    if asked {
        return Err(Failure::input(format!(
            "--splat: voxels of one value are splatted, expected no {what}"
        )));
    }
    Ok(())
}
