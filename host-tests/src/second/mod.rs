//! A second model of the pipeline, in whole numbers: written from the pages in `docs/contract/` alone, as somebody would
//! who has them and not the sources. It calls nothing of core and uses none of its types; every number is an `i128`, which
//! nothing here overflows, and every rounding is written as the pages write it.
//!
//! It also makes mistakes, one at a time and on purpose ([`Mistake`]): vectors that find them all are vectors that a device
//! can be trusted by.

mod borders;
mod classification;
mod compositing;
mod gradient;
mod interpolation;
mod location;
mod mistakes;
mod normalisation;
mod picture;
mod projection;
mod shading;

pub use borders::Rays;
pub use mistakes::Mistake;

/// The widths of a precision, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// `paper`.
    Paper,
    /// `compact`.
    Compact,
    /// `wide`.
    Wide,
}

impl Width {
    /// The precision of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        match name {
            "paper" => Some(Self::Paper),
            "compact" => Some(Self::Compact),
            "wide" => Some(Self::Wide),
            _ => None,
        }
    }

    /// Fraction bits of a sample.
    pub fn sample_bits(self) -> u32 {
        if self == Self::Wide { 15 } else { 12 }
    }

    /// 1.0 of a channel.
    pub fn one(self) -> i128 {
        match self {
            Self::Paper => 1 << 15,
            Self::Compact => 65535,
            Self::Wide => 1 << 31,
        }
    }
}

/// Numbers by name.
pub trait Numbers {
    /// The number of this name, if there is one.
    fn find(&self, name: &str) -> Option<i128>;

    /// The number of this name.
    ///
    /// # Panics
    /// If there is none: the vectors are not those of the stage.
    fn get(&self, name: &str) -> i128 {
        self.find(name).unwrap_or_else(|| panic!("no number is called {name}"))
    }

    /// Three numbers.
    fn three(&self, name: &str, endings: [&str; 3]) -> [i128; 3] {
        endings.map(|ending| self.get(&format!("{name}_{ending}")))
    }

    /// A vector along i, j, k.
    fn ijk(&self, name: &str) -> [i128; 3] {
        self.three(name, ["i", "j", "k"])
    }

    /// Three channels.
    fn rgb(&self, name: &str) -> [i128; 3] {
        self.three(name, ["red", "green", "blue"])
    }

    /// The channels of a pixel.
    fn pixel(&self, name: &str) -> [i128; 4] {
        let [red, green, blue] = self.rgb(name);
        [red, green, blue, self.get(&format!("{name}_t"))]
    }
}

/// The second model.
#[derive(Clone, Copy, Debug)]
pub struct Second {
    width: Width,
    mistake: Option<Mistake>,
}

impl Second {
    /// The model of a precision; with a mistake or without.
    pub fn new(width: Width, mistake: Option<Mistake>) -> Self {
        Self { width, mistake }
    }

    fn makes(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    /// What a stage makes of its inputs.
    ///
    /// # Panics
    /// If it has no such stage, or an input is missing.
    pub fn outputs(&self, stage: &str, inputs: &dyn Numbers) -> Vec<i128> {
        match stage {
            "plan" => self.plan(inputs),
            "start" => self.start(inputs),
            "location" => self.location(inputs),
            "borders" => self.borders(inputs),
            "fraction" => vec![self.of_fraction(inputs.get("opacity"), inputs.get("fraction"))],
            "dither" => self.dither(inputs.get("plane")).to_vec(),
            "interpolation" => vec![self.interpolation(inputs)],
            "classification" => self.classification(inputs),
            "gradient" => self.gradient(inputs).to_vec(),
            "normalisation" => self.normalisation(inputs.ijk("gradient")).to_vec(),
            "export" => self.export(inputs.ijk("g"), inputs.get("r")).to_vec(),
            "vector" => self.vector(inputs.ijk("vector")).to_vec(),
            "coefficient" => vec![self.coefficient(inputs.get("coefficient"))],
            "cosine" => vec![self.cosine(inputs.ijk("g"), inputs.get("r"), inputs.ijk("vector"))],
            "reflection" => {
                let cosines = [inputs.get("cosine_nv"), inputs.get("cosine_nl")];
                vec![self.reflection(cosines, inputs.ijk("viewer"), inputs.ijk("light"))]
            }
            "power" => vec![self.power(inputs.get("cosine"), inputs.get("exponent_log2"))],
            "shading" => self.shading(inputs).to_vec(),
            "compositing" => self.front_to_back(inputs).to_vec(),
            "compositing-back" => self.back_to_front(inputs).to_vec(),
            "projection" => vec![self.projection(inputs)],
            "resolution" => self.resolution(inputs).to_vec(),
            "coordinate" => self.coordinate(inputs).to_vec(),
            "mixture" => vec![self.mixture(inputs)],
            "background" => vec![self.background(inputs)],
            "output" => vec![self.byte(inputs.get("channel"))],
            _ => panic!("the second model has no stage {stage}"),
        }
    }
}

/// `value >> bits` of a value whose fraction is lost towards zero: a mistake of many.
fn towards_zero(value: i128, bits: u32) -> i128 {
    if value < 0 { -(-value >> bits) } else { value >> bits }
}
