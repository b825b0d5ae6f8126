//! Depth cueing as the user states it: colours that turn into another with the distance from the viewer.

/// Depth cueing. Places are shares of the way through the volume along the view: 0 is where the viewer meets its nearest corner, 1
/// its farthest, both centres of voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cueing {
    /// Where colours begin to turn.
    pub from: f64,
    /// Where they have turned as far as they do.
    pub to: f64,
    /// How far that is: 1 is all.
    pub strength: f64,
    /// What they turn into.
    pub colour: [f64; 3],
}

impl Default for Cueing {
    fn default() -> Self {
        Self {
            from: 0.0,
            to: 1.0,
            strength: 0.7,
            colour: [0.0; 3],
        }
    }
}

/// Depth cueing on a volume: depths in lengths, each as long as the volume's largest spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CueingInVoxels {
    /// By how much the depth grows per voxel along x, y and z.
    pub slope: [f64; 3],
    /// The depth of the first voxel's centre; at 0 colours begin to turn.
    pub distance: f64,
    /// The depth at which they have turned.
    pub depth: f64,
    /// How far, a whole number of 2^-16.
    pub strength: f64,
}

/// What `--depth-cueing` takes.
const EXPECTED: &str = "expected STRENGTH or STRENGTH,FROM,TO, each from 0 to 1, FROM below TO";

impl Cueing {
    /// Reads `strength` or `strength,from,to`.
    ///
    /// # Errors
    /// What was wrong and what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let number = |part: &str| part.trim().parse::<f64>().map_err(|_| format!("{part:?}: {EXPECTED}"));
        let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
        let default = Self::default();
        let cueing = match *numbers {
            [strength] => Self { strength, ..default },
            [strength, from, to] => Self {
                from,
                to,
                strength,
                ..default
            },
            _ => return Err(format!("{text:?}: {EXPECTED}")),
        };
        cueing
            .check()
            .map_err(|(name, value, expected)| format!("{name} is {value}, expected {expected}"))?;
        Ok(cueing)
    }

    /// The field that is out of range, what it is and what is expected.
    ///
    /// # Errors
    /// The first such field.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        let share = 0.0..=1.0;
        if !share.contains(&self.strength) {
            Err(("strength", self.strength, "0 to 1"))
        } else if !share.contains(&self.from) {
            Err(("from", self.from, "0 to 1"))
        } else if !(share.contains(&self.to) && self.from < self.to) {
            Err(("to", self.to, "above `from`, at most 1"))
        } else {
            Ok(())
        }
    }

    /// The depths of a volume along a view, whose direction from the eye has length 1.
    pub fn in_voxels(&self, forward: [f64; 3], dims: [usize; 3], spacing: [f64; 3]) -> CueingInVoxels {
        let length = spacing.into_iter().fold(0.0, f64::max);
        let slope = [0, 1, 2].map(|axis| forward[axis] * spacing[axis] / length);
        let way = |axis: usize| slope[axis] * (dims[axis] - 1) as f64;
        let near: f64 = (0..3).map(|axis| way(axis).min(0.0)).sum();
        // Of one voxel, or a slice across the view, the way is as long as a voxel.
        let all = (0..3).map(|axis| way(axis).abs()).sum::<f64>().max(1.0);
        let rounded = |x: f64, parts: f64| (x * parts).round() / parts;
        const PARTS: f64 = 1_073_741_824.0;
        CueingInVoxels {
            slope: slope.map(|slope| rounded(slope, PARTS)),
            distance: rounded(-near - self.from * all, PARTS),
            depth: rounded((self.to - self.from) * all, PARTS),
            strength: rounded(self.strength, 65536.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cueing_is_read_and_checked() {
        let cueing = Cueing::parse("0.5").unwrap();
        assert_eq!((cueing.strength, cueing.from, cueing.to), (0.5, 0.0, 1.0));
        let cueing = Cueing::parse("1, 0.25,0.75").unwrap();
        assert_eq!((cueing.strength, cueing.from, cueing.to), (1.0, 0.25, 0.75));
        for (text, why) in [
            ("", "\"\": expected STRENGTH"),
            ("0.5,0.1", "\"0.5,0.1\": expected"),
            ("2", "strength is 2, expected 0 to 1"),
            ("1,0.5,0.5", "to is 0.5, expected above `from`"),
            ("1,-1,0.5", "from is -1, expected 0 to 1"),
            ("nan", "strength is NaN"),
        ] {
            let error = Cueing::parse(text).unwrap_err();
            assert!(error.starts_with(why), "{text}: {error}");
        }
    }

    /// From the nearest corner of the voxels to the farthest, whatever their spacing.
    #[test]
    fn depths_span_the_volume() {
        let cueing = Cueing {
            from: 0.25,
            to: 0.75,
            ..Cueing::default()
        };
        let cue = cueing.in_voxels([0.6, 0.0, -0.8], [11, 5, 6], [1.0, 1.0, 2.0]);
        let depth = |at: [f64; 3]| cue.distance + (0..3).map(|axis| cue.slope[axis] * at[axis]).sum::<f64>();
        // 10 · 0.6 + 5 · 2 · 0.8 = 14 mm, in lengths of 2 mm; a quarter of it before 0.
        assert!((depth([0.0, 0.0, 5.0]) + 1.75).abs() < 1e-6);
        assert!((depth([10.0, 4.0, 0.0]) - 5.25).abs() < 1e-6);
        assert!((cue.depth - 3.5).abs() < 1e-6);
    }
}
