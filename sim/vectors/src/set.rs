//! A set: vectors of one stage, all with the same inputs and outputs.

use serde::Serialize;

/// A number of a vector.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Bits that hold its range; a sign is counted.
    pub bits: u32,
    /// Whether it has a sign (two's complement).
    pub signed: bool,
    /// What one unit of the integer stands for.
    pub unit: &'static str,
}

impl Field {
    /// Whether a value has no more bits than the field.
    pub fn holds(&self, value: i64) -> bool {
        let value = i128::from(value);
        if self.signed {
            let half = 1 << (self.bits - 1);
            (-half..half).contains(&value)
        } else {
            (0..1 << self.bits).contains(&value)
        }
    }
}

/// A number without a sign.
pub fn u(name: impl Into<String>, bits: u32, unit: &'static str) -> Field {
    Field {
        name: name.into(),
        bits,
        signed: false,
        unit,
    }
}

/// A number with a sign, which `bits` counts.
pub fn s(name: impl Into<String>, bits: u32, unit: &'static str) -> Field {
    Field {
        signed: true,
        ..u(name, bits, unit)
    }
}

/// Three fields that differ in their endings.
fn three(of: &Field, endings: [&str; 3]) -> [Field; 3] {
    endings.map(|ending| Field {
        name: format!("{}_{ending}", of.name),
        ..of.clone()
    })
}

/// A vector's components along i, j, k.
pub fn ijk(of: &Field) -> [Field; 3] {
    three(of, ["i", "j", "k"])
}

/// A vector's components along the volume's x, y, z.
pub fn xyz(of: &Field) -> [Field; 3] {
    three(of, ["x", "y", "z"])
}

/// A colour's channels.
pub fn rgb(of: &Field) -> [Field; 3] {
    three(of, ["red", "green", "blue"])
}

/// One half of a set: its fields, and a value of each for every vector.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Side {
    /// The fields, in the order of a line of the file.
    pub fields: Vec<Field>,
    /// The values, vector after vector.
    pub values: Vec<i64>,
}

impl Side {
    /// No vectors yet.
    pub fn new(fields: Vec<Field>) -> Self {
        Self {
            fields,
            values: Vec::new(),
        }
    }

    /// The values of a vector.
    pub fn row(&self, index: usize) -> &[i64] {
        let width = self.fields.len();
        &self.values[index * width..(index + 1) * width]
    }

    /// Adds a vector's values.
    ///
    /// # Panics
    /// If they are not as many as the fields, or one does not fit its field.
    fn push(&mut self, values: &[i64]) {
        assert_eq!(values.len(), self.fields.len(), "{:?}", self.fields);
        for (field, value) in self.fields.iter().zip(values) {
            assert!(field.holds(*value), "{field:?}: {value}");
        }
        self.values.extend(values);
    }
}

/// Vectors of one stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Set {
    /// The set's name; its files begin with it.
    pub name: String,
    /// The stage, or the part of one, that it is about.
    pub stage: &'static str,
    /// The precision; `None` where all have the same arithmetic.
    pub precision: Option<&'static str>,
    /// What the stage does, in one line.
    pub about: &'static str,
    /// How many of the first input fields say where a value lies: plane, phase, row, column. 0 in a directed set.
    pub place: usize,
    /// What goes in.
    pub inputs: Side,
    /// What comes out. Without fields the set is a memory's contents.
    pub outputs: Side,
}

impl Set {
    /// A set without vectors. `precision` becomes the folder of its files.
    pub fn new(
        precision: Option<&'static str>,
        stage: &'static str,
        about: &'static str,
        inputs: Vec<Field>,
        outputs: Vec<Field>,
    ) -> Self {
        Self {
            name: format!("{}/{stage}", precision.unwrap_or("all")),
            stage,
            precision,
            about,
            place: 0,
            inputs: Side::new(inputs),
            outputs: Side::new(outputs),
        }
    }

    /// Adds a vector.
    ///
    /// # Panics
    /// If a value does not fit its field: the set would state a width that its values do not keep.
    pub fn push(&mut self, inputs: &[i64], outputs: &[i64]) {
        self.inputs.push(inputs);
        self.outputs.push(outputs);
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.inputs
            .values
            .len()
            .checked_div(self.inputs.fields.len())
            .unwrap_or(0)
    }

    /// Whether there is no vector.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
