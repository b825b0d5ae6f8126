//! Which vectors find which mistake: the directed sets, computed once more by the second model.

use std::fmt::Write;

use slicecast_vectors::directed;
use slicecast_vectors::set::Set;

use crate::second::{Mistake, Numbers, Second, Width};

/// The inputs of one vector, by name.
pub struct Inputs<'a> {
    set: &'a Set,
    row: &'a [i64],
}

impl<'a> Inputs<'a> {
    /// Those of a vector of a set.
    pub fn of(set: &'a Set, index: usize) -> Self {
        Self {
            set,
            row: set.inputs.row(index),
        }
    }
}

impl Numbers for Inputs<'_> {
    fn find(&self, name: &str) -> Option<i128> {
        let at = self.set.inputs.fields.iter().position(|field| field.name == name)?;
        Some(self.row[at].into())
    }
}

/// The precisions whose second model a set asks: its own, or, where all have one arithmetic, any.
fn width(set: &Set) -> Width {
    // Paper has one mistake more in what all share: whether a sample exists.
    set.precision.and_then(Width::of_name).unwrap_or(Width::Paper)
}

/// The vectors of a set on which the second model, with a mistake or without, gives other numbers.
pub fn departures(set: &Set, mistake: Option<Mistake>) -> Vec<usize> {
    let second = Second::new(width(set), mistake);
    let departs = |index: &usize| {
        let outputs = second.outputs(set.stage, &Inputs::of(set, *index));
        !outputs
            .into_iter()
            .eq(set.outputs.row(*index).iter().copied().map(i128::from))
    };
    (0..set.len()).filter(departs).collect()
}

/// A mistake, and the vectors that find it.
pub struct Found {
    /// The mistake.
    pub mistake: Mistake,
    /// How many vectors, in how many sets.
    pub vectors: usize,
    /// The same.
    pub sets: usize,
    /// The first: name of its set and number.
    pub first: Option<(String, usize)>,
}

/// Every mistake against every directed set.
pub fn mutations() -> Vec<Found> {
    let sets = directed::sets();
    let one = |mistake: &Mistake| {
        let mut found = Found {
            mistake: *mistake,
            vectors: 0,
            sets: 0,
            first: None,
        };
        for set in &sets {
            let departures = departures(set, Some(*mistake));
            if let Some(first) = departures.first() {
                found.vectors += departures.len();
                found.sets += 1;
                found.first.get_or_insert((set.name.clone(), *first));
            }
        }
        found
    };
    Mistake::ALL.iter().map(one).collect()
}

/// The table of mutations, as the documentation has it.
pub fn table(found: &[Found]) -> String {
    let mut text = String::from("| stage | mistake | vectors | first |\n|---|---|---|---|\n");
    for Found {
        mistake,
        vectors,
        first,
        ..
    } in found
    {
        let first = first
            .as_ref()
            .map_or("none".into(), |(set, index)| format!("`{set}` {index}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {vectors} | {first} |",
            mistake.stage(),
            mistake.words()
        );
    }
    text
}
