//! The stage boundaries of the pipeline: one list, which observers, recordings and reports iterate over.

/// A boundary behind a stage, in the order in which a sample passes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// [`locate`](crate::locate): x, y, z of a plane, s15.16. Seen by [`Tap::plane`](crate::tap::Tap::plane).
    Location,
    /// [`interpolate`](crate::interpolate): the samples of a row.
    Interpolation,
    /// [`classify`](crate::classify): the opacities of the same row, 1.31.
    Opacity,
    /// [`classify`](crate::classify): red, green, blue of a visible span, 1.15 or 1.31.
    Colour,
    /// [`gradient`](crate::gradient): three components of a visible span of a lit scene, after the spacing factors.
    Gradient,
    /// [`normalise`](crate::normalise): three block-normalised components and the reciprocal length.
    Normal,
    /// [`shade`](crate::shade): red, green, blue in the format of the colour; under [`modulate`](crate::modulate) the opacity besides.
    Shading,
    /// [`composite`](crate::composite): red, green, blue, transparency before the samples of the span.
    Before,
    /// [`composite`](crate::composite): the same pixels after them.
    After,
}

impl Stage {
    /// All boundaries, in order.
    pub const ALL: [Self; 9] = [
        Self::Location,
        Self::Interpolation,
        Self::Opacity,
        Self::Colour,
        Self::Gradient,
        Self::Normal,
        Self::Shading,
        Self::Before,
        Self::After,
    ];

    /// The name in manifests, messages and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Location => "location",
            Self::Interpolation => "interpolation",
            Self::Opacity => "opacity",
            Self::Colour => "colour",
            Self::Gradient => "gradient",
            Self::Normal => "normal",
            Self::Shading => "shading",
            Self::Before => "before",
            Self::After => "compositing",
        }
    }
}
