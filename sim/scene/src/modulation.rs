//! Modulation by the magnitude of the gradient, as the user states it.

/// Points of a function that may be stated.
pub const POINTS: usize = 64;

/// Factors of opacity and of light by the magnitude of the gradient: points of magnitude and factor, linear between them, constant
/// outside; none where nothing is modulated. Magnitudes are differences of values per unit of length, of CT in HU per millimetre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modulation {
    /// Of opacity.
    pub opacity: Vec<[f64; 2]>,
    /// Of diffuse light.
    pub diffuse: Vec<[f64; 2]>,
    /// Of specular light.
    pub specular: Vec<[f64; 2]>,
}

/// What is modulated, and its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Modulated {
    /// The field of [`Modulation`].
    what: What,
    points: Vec<[f64; 2]>,
}

/// A field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Opacity,
    Diffuse,
    Specular,
}

/// What `--modulation` takes.
const EXPECTED: &str = "expected opacity=M:F,M:F,..., diffuse=... or specular=..., of magnitudes and factors";

impl Modulated {
    /// Reads `opacity=0:0,200:1`.
    ///
    /// # Errors
    /// What was wrong and what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?}: {EXPECTED}");
        let (what, points) = text.split_once('=').ok_or_else(wrong)?;
        let what = match what.trim() {
            "opacity" => What::Opacity,
            "diffuse" => What::Diffuse,
            "specular" => What::Specular,
            _ => return Err(wrong()),
        };
        let point = |point: &str| {
            let (magnitude, factor) = point.split_once(':')?;
            Some([magnitude.trim().parse().ok()?, factor.trim().parse().ok()?])
        };
        let points: Option<Vec<[f64; 2]>> = points.split(',').map(point).collect();
        let modulated = Self {
            what,
            points: points.ok_or_else(wrong)?,
        };
        let mut alone = Modulation::default();
        alone.set(modulated.clone());
        alone
            .check()
            .map_err(|(name, value, expected)| format!("{name} is {value}, expected {expected}"))?;
        Ok(modulated)
    }
}

impl Modulation {
    /// Puts new points in the place of a field's.
    pub fn set(&mut self, Modulated { what, points }: Modulated) {
        match what {
            What::Opacity => self.opacity = points,
            What::Diffuse => self.diffuse = points,
            What::Specular => self.specular = points,
        }
    }

    /// Whether light is modulated.
    pub const fn lights(&self) -> bool {
        !self.diffuse.is_empty() || !self.specular.is_empty()
    }

    /// The point that is out of range, what it is and what is expected.
    ///
    /// # Errors
    /// The first such point.
    pub fn check(&self) -> Result<(), (String, String, &'static str)> {
        let fields = [
            ("opacity", &self.opacity),
            ("diffuse", &self.diffuse),
            ("specular", &self.specular),
        ];
        for (name, points) in fields {
            if points.len() > POINTS {
                return Err((name.into(), format!("{} points", points.len()), "at most 64 points"));
            }
            let mut before = None;
            for (i, [magnitude, factor]) in points.iter().enumerate() {
                let wrong = |value: &f64, expected| Err((format!("{name}[{i}]"), value.to_string(), expected));
                if !(magnitude.is_finite() && *magnitude >= 0.0) {
                    return wrong(magnitude, "a magnitude of 0 or more");
                }
                if before.is_some_and(|before| *magnitude <= before) {
                    return wrong(magnitude, "a magnitude above the one before");
                }
                if !(0.0..=1.0).contains(factor) {
                    return wrong(factor, "a factor from 0 to 1");
                }
                before = Some(*magnitude);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modulation_is_read_and_checked() {
        let mut modulation = Modulation::default();
        modulation.set(Modulated::parse("opacity=0:0, 200:1").unwrap());
        modulation.set(Modulated::parse("specular=10:0.5").unwrap());
        let expected = Modulation {
            opacity: vec![[0.0, 0.0], [200.0, 1.0]],
            diffuse: Vec::new(),
            specular: vec![[10.0, 0.5]],
        };
        assert_eq!(modulation, expected);
        for (text, why) in [
            ("", "\"\": expected opacity="),
            ("opacity", "\"opacity\": expected opacity="),
            ("ambient=0:1", "\"ambient=0:1\": expected opacity="),
            ("opacity=", "\"opacity=\": expected opacity="),
            ("opacity=1", "\"opacity=1\": expected opacity="),
            ("diffuse=0:2", "diffuse[0] is 2, expected a factor from 0 to 1"),
            ("diffuse=0:-1", "diffuse[0] is -1, expected a factor"),
            ("diffuse=0:nan", "diffuse[0] is NaN, expected a factor"),
            ("specular=-1:0", "specular[0] is -1, expected a magnitude of 0 or more"),
            ("specular=inf:0", "specular[0] is inf, expected a magnitude"),
            (
                "opacity=5:0,5:1",
                "opacity[1] is 5, expected a magnitude above the one before",
            ),
        ] {
            let error = Modulated::parse(text).unwrap_err();
            assert!(error.starts_with(why), "{text}: {error}");
        }
        let many: Vec<String> = (0..65).map(|m| format!("{m}:1")).collect();
        let error = Modulated::parse(&format!("opacity={}", many.join(","))).unwrap_err();
        assert_eq!(error, "opacity is 65 points, expected at most 64 points");
    }
}
