//! The scenes in flash, written by `host-tests/run-firmware` from the built-in CT volume.

use slicecast_firmware_shared::scene::{Lighting, SceneData};

include!(env!("SLICECAST_SCENES"));
