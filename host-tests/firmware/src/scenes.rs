//! The scenes in flash, written by `host-tests/run-firmware` from the built-in CT volume.

use slicecast::integral::Colours;
use slicecast_firmware_shared::scene::{IntegralData, Lighting, SceneData};

include!(env!("SLICECAST_SCENES"));
