//! The integers of a scene, as the engine hands them to the pipeline.

use slicecast::composite::{Channel as _, Recurrence as _};
use slicecast::crop::Crop;
use slicecast::format::{Intensity, Position};
use slicecast::plan::Plan;
use slicecast::precision::Precision;
use slicecast::project::Sum;
use slicecast::shade::{Highlight, KeptLight, keep, keep_vector};
use slicecast::stream::Needs;
use slicecast::view::Axis;
use slicecast_engine::camera::{Material, Picture, crop};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::background;
use slicecast_engine::table::Table;
use slicecast_engine::with_precision;
use slicecast_scene::{AlphaCodeName, Blend, LookupName, PrecisionName};
use slicecast_volume::{Mapping, Volume};

/// A scene on a volume as the pipeline has it.
#[derive(Clone, Debug)]
pub struct Numbers<'a> {
    prepared: &'a Prepared<'a>,
    /// The geometry.
    pub plan: Plan,
    /// Number formats.
    pub precision: PrecisionName,
    /// How samples combine.
    pub blend: Blend,
    /// Step and shift of an additive projection.
    pub additive: Option<[u32; 2]>,
    /// Transparency below this becomes 0, in the pixel's own format; of compositing.
    pub floor: u32,
    /// Rays end below 2^-n, besides.
    pub early_termination: Option<u32>,
    /// Lights and material; of lit compositing.
    pub shading: Option<Shading<'a>>,
    /// The table.
    pub table: &'a Table,
    /// The viewer's picture.
    pub picture: Picture,
    /// Behind it, 1.15.
    pub background: [Intensity; 3],
    /// Memory of a stream.
    pub needs: Needs,
    /// The box that the volume is cropped to.
    pub crop: Option<Crop>,
}

/// Lights and material.
#[derive(Clone, Debug)]
pub struct Shading<'a> {
    /// Before a precision takes what it keeps: s1.30 and 1.31.
    pub material: &'a Material,
    /// Fraction bits of the kept vectors: 15 or 30.
    pub vector_bits: u32,
    /// Fraction bits of the kept coefficients: 15 or 31.
    pub coefficient_bits: u32,
    /// What the precision keeps: these the pipeline multiplies by.
    pub ambient: [u32; 3],
    /// The lights, likewise.
    pub lights: Vec<KeptLight>,
    /// The viewer, likewise.
    pub viewer: [i32; 3],
}

impl<'a> Shading<'a> {
    fn of<P: Precision>(p: P, material: &'a Material) -> Self {
        let shading = p.formats().shading;
        Self {
            material,
            vector_bits: shading.vector_bits(),
            coefficient_bits: shading.coefficient_bits(),
            ambient: material.ambient.map(|c| keep(p, c)),
            lights: material.lights.iter().map(|light| KeptLight::of(p, light)).collect(),
            viewer: keep_vector(p, material.viewer),
        }
    }

    /// Whether the highlight takes the half vector.
    pub fn is_half_vector(&self) -> bool {
        self.material.highlight == Highlight::HalfVector
    }
}

impl<'a> Numbers<'a> {
    /// The numbers of a scene.
    ///
    /// # Errors
    /// [`RenderError`] if segments are classified, or the scene's material has been changed to one that the pipeline does not
    /// take.
    pub fn of(prepared: &'a Prepared<'a>) -> Result<Self, RenderError> {
        prepared.check_points()?;
        prepared.check_staged()?;
        let (scene, setup) = (prepared.scene, &prepared.setup);
        let early_termination = match scene.blend {
            Blend::FrontToBack => scene.early_termination,
            _ => None,
        };
        let additive = match setup.additive {
            Sum::Additive { step, shift } if scene.blend == Blend::Additive => Some([step, shift]),
            _ => None,
        };
        let composited = scene.blend.is_composited();
        let material = setup.material.as_ref().filter(|_| composited);
        let (floor, shading) = with_precision!(scene.precision, p => {
            let (one, own) = (p.pixel().one().bits(), p.pixel().floor().bits());
            let asked = early_termination.and_then(|bits| one.checked_shr(bits)).unwrap_or(0);
            (own.max(asked), material.map(|material| Shading::of(p, material)))
        });
        Ok(Self {
            prepared,
            plan: setup.plan,
            precision: scene.precision,
            blend: scene.blend,
            additive,
            floor,
            early_termination,
            shading,
            table: &prepared.table,
            picture: setup.picture,
            background: background(scene.image.background),
            needs: prepared.rendering()?.needs(),
            crop: crop(scene, prepared.volume.spacing),
        })
    }

    /// Low and high faces of the box along x, y, z, s15.16; both 0 along an axis that it does not cut.
    pub fn crop_bits(&self) -> [[i32; 3]; 2] {
        let crop = self.crop.unwrap_or(Crop::NONE);
        let open = |axis: usize| crop.low[axis] == Position::MIN && crop.high[axis] == Position::MAX;
        [crop.low, crop.high].map(|faces| [0, 1, 2].map(|axis| if open(axis) { 0 } else { faces[axis].to_bits() }))
    }

    /// Whether samples are composited, not projected.
    pub fn is_composited(&self) -> bool {
        self.blend.is_composited()
    }

    /// How samples combine, in words.
    pub fn order(&self) -> &'static str {
        match self.blend {
            Blend::FrontToBack => "front-to-back",
            Blend::BackToFront => "back-to-front",
            Blend::Maximum => "maximum",
            Blend::Minimum => "minimum",
            Blend::Average => "average",
            Blend::Additive => "additive",
        }
    }

    /// `lit`, `unlit` or `projection`.
    pub fn shading_name(&self) -> &'static str {
        match (self.is_composited(), &self.shading) {
            (false, _) => "projection",
            (true, Some(_)) => "lit",
            (true, None) => "unlit",
        }
    }

    /// The table's code and look-up, in words.
    pub fn layout(&self) -> [&'static str; 2] {
        let code = match self.table.code {
            AlphaCodeName::Sqrt8 => "sqrt8",
            AlphaCodeName::Sqrt16 => "sqrt16",
            AlphaCodeName::Colour16 => "colour16",
        };
        let lookup = match self.table.lookup {
            LookupName::Nearest => "nearest",
            LookupName::Linear => "linear",
        };
        [code, lookup]
    }

    /// Where the numbers come from: what the files' headers say, name and words.
    pub fn about(&self) -> Vec<(&'static str, String)> {
        let Self { prepared, plan, .. } = self;
        let view = prepared.scene.view;
        let [code, lookup] = self.layout();
        let sampling = plan.sampling();
        let needs = self.needs.bytes();
        let [slices, ranges, scratch, image] = needs;
        let axis = match plan.view().major() {
            Axis::X => "x",
            Axis::Y => "y",
            Axis::Z => "z",
        };
        let step = if self.is_composited() {
            format!(
                "{:.6} in the unit of the spacing; the table's opacities are those of this step: another view or another number \
                 of planes per voxel needs another table",
                prepared.setup.step_length
            )
        } else {
            "the table's opacities are those of the transfer function, whatever the step".into()
        };
        vec![
            ("program", format!("slicecast {}", env!("CARGO_PKG_VERSION"))),
            ("volume", volume_words(prepared.volume)),
            ("mapping", mapping_words(&prepared.volume.mapping)),
            (
                "view",
                format!(
                    "azimuth {}, elevation {}, roll {} degrees; slices across {axis}{}",
                    view.azimuth,
                    view.elevation,
                    view.roll,
                    if plan.view().reversed() {
                        ", from its far end"
                    } else {
                        ""
                    }
                ),
            ),
            (
                "sampling",
                format!(
                    "{} plane(s) and {} x {} ray(s) per voxel",
                    sampling.planes_per_voxel, sampling.rays_per_voxel, sampling.rays_per_voxel
                ),
            ),
            ("step", step),
            (
                "pipeline",
                format!("{}, {}, {}", self.precision.name(), self.shading_name(), self.order()),
            ),
            (
                "table",
                format!("{code}, {lookup}, {} bytes, which may lie in flash", self.table.bytes()),
            ),
            (
                "memory",
                format!(
                    "{} bytes: slices {slices}, row ranges {ranges}, scratch {scratch}, image {image}",
                    needs.iter().sum::<usize>()
                ),
            ),
        ]
    }
}

/// A volume's name, dimensions and spacing.
pub(crate) fn volume_words(volume: &Volume) -> String {
    let [nx, ny, nz] = volume.dims;
    let [sx, sy, sz] = volume.spacing;
    format!(
        "{}, {nx} x {ny} x {nz} voxels {sx} x {sy} x {sz} apart",
        one_line(&volume.name)
    )
}

/// What codes stand for.
pub(crate) fn mapping_words(mapping: &Mapping) -> String {
    format!(
        "value = code * {} {} {}; codes 0 to 4095 are {} to {}",
        mapping.scale,
        if mapping.offset < 0.0 { '-' } else { '+' },
        mapping.offset.abs(),
        mapping.value(0.0),
        mapping.value(4095.0)
    )
}

/// Text without line breaks or ends of comments.
pub(crate) fn one_line(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.replace("*/", "* /").replace("/*", "/ *")
}
