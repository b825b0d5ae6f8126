//! The scene that a command line has chosen for a volume.

use slicecast_scene::Scene;
use slicecast_volume::open::Loaded;
use slicecast_volume::statistics::Statistics;

use crate::labels::{self, Label};
use crate::presets;
use crate::visibility::Circumstances;

/// A scene for a volume, and where it came from.
pub struct Chosen {
    /// The scene with its overrides.
    pub scene: Scene,
    /// Its name, if it is one of the program's.
    pub stock: Option<String>,
    /// The name of the one that fits the volume.
    pub fitting: &'static str,
    /// The volume's histogram.
    pub statistics: Statistics,
}

impl Chosen {
    /// What a picture without anything to see is explained by.
    pub fn circumstances(&self) -> Circumstances<'_> {
        let stock = self.stock.as_deref();
        Circumstances {
            statistics: &self.statistics,
            without_hounsfield: stock.is_some_and(presets::is_for_hounsfield)
                && !presets::is_for_hounsfield(self.fitting),
            fitting: (stock != Some(self.fitting)).then_some(self.fitting),
        }
    }

    /// The labels of the volume, if the scene shows labels.
    pub fn labels(&self, loaded: &Loaded) -> Option<Vec<Label>> {
        (self.stock.as_deref() == Some("labels")).then(|| labels::shown(loaded, &self.statistics, &self.scene.transfer))
    }
}
