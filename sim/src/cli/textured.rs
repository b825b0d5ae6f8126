//! Where pipelines of 8 bits have a place.

use super::Failure;

/// For a volume of colours, which they do not know.
pub fn check_none(asked: bool) -> Result<(), Failure> {
    if asked {
        return Err(Failure::input(
            "--texture8: pipelines of 8 bits are of volumes of one value a voxel, expected no volume of colours and no --level",
        ));
    }
    Ok(())
}
