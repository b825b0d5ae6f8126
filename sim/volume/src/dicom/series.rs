//! From the slices of a folder to those of one series and one phase.

use std::collections::HashMap;
use std::path::Path;

use super::names::{file_name, list};
use super::{Found, NAME, phases};
use crate::choice::{Choice, Series};
use crate::error::Problem;
use crate::text::shorten;

/// Which of several series.
pub(super) enum Wanted<'a> {
    /// The one with the most slices.
    Largest,
    /// The one whose number or UID this is.
    Named(&'a str),
    /// The one that the file belongs to.
    With(&'a Path),
}

impl<'a> Wanted<'a> {
    /// The series that the user chose.
    pub fn of(choice: &'a Choice) -> Self {
        match &choice.series {
            Series::Largest => Self::Largest,
            Series::Named(name) => Self::Named(name),
        }
    }

    fn holds(&self, group: &[Found]) -> bool {
        match self {
            Self::Largest => true,
            Self::Named(name) => group.first().is_some_and(|Found { slice, .. }| {
                [&slice.series_uid, &slice.series_number].iter().any(|own| own == name)
            }),
            Self::With(path) => group.iter().any(|found| found.path == *path),
        }
    }
}

/// Takes the slices of the wanted series and phase out of all, with notes on the others.
pub(super) fn choose(
    slices: Vec<Found>,
    wanted: &Wanted<'_>,
    choice: &Choice,
) -> Result<(Vec<Found>, Vec<String>), Problem> {
    let mut groups: Vec<Vec<Found>> = Vec::new();
    for found in slices {
        let kin = |group: &&mut Vec<Found>| group.first().is_some_and(|first| first.slice.is_kin(&found.slice));
        match groups.iter_mut().find(kin) {
            Some(group) => group.push(found),
            None => groups.push(vec![found]),
        }
    }
    let all = groups
        .iter()
        .map(|group| describe(group))
        .collect::<Vec<_>>()
        .join("; ");
    // The first of several largest ones.
    let held = (0..groups.len()).rev().filter(|&i| wanted.holds(&groups[i]));
    let Some(chosen) = held.max_by_key(|&i| groups[i].len()) else {
        return Err(match wanted {
            Wanted::Named(name) if !all.is_empty() => {
                let fault = format!("has no series `{}`, expected one of: {all}", shorten(name));
                Problem::format(NAME, fault)
            }
            _ => Problem::NoImages,
        });
    };
    let mut notes = Vec::new();
    let several = groups.len() > 1;
    let slices = groups.swap_remove(chosen);
    if several {
        let shown = describe(&slices);
        notes.push(format!("several series: shown is {shown}, of {all}"));
    }
    let slices = without_copies(slices, &mut notes);
    let slices = phases::choose(slices, choice.phase, &mut notes)?;
    Ok((slices, notes))
}

/// Leaves out files that are copies of others.
fn without_copies(slices: Vec<Found>, notes: &mut Vec<String>) -> Vec<Found> {
    let (mut kept, mut copies) = (Vec::<Found>::new(), Vec::new());
    let mut places = HashMap::<_, Vec<usize>>::new();
    for found in slices {
        let position = found.slice.position.map(|p| p.map(f64::to_bits));
        let key = (found.slice.object_uid.clone(), found.slice.frame, position);
        let others = places.entry(key).or_default();
        if others.iter().any(|&i| kept[i].slice.is_copy(&found.slice)) {
            copies.push(file_name(&found.path));
        } else {
            others.push(kept.len());
            kept.push(found);
        }
    }
    if !copies.is_empty() {
        notes.push(format!(
            "passed over as copies of other slices: {}",
            list(copies.into_iter())
        ));
    }
    kept
}

/// A series in words.
fn describe(group: &[Found]) -> String {
    let Some(slice) = group.first().map(|found| &found.slice) else {
        return String::new();
    };
    let number = if slice.series_number.is_empty() {
        "without number"
    } else {
        &slice.series_number
    };
    let part = |name: &str, value: &str| match value {
        "" => None,
        value => Some(format!("{name}{}", shorten(value))),
    };
    let size = format!("of {} x {}", slice.columns, slice.rows);
    let count = match group {
        [one] => format!("1 slice {size}: {}", file_name(&one.path)),
        _ => format!("{} slices {size}", group.len()),
    };
    let parts = [
        part("", &slice.description),
        part("echo ", &slice.echo),
        part("stack ", &slice.stack),
        Some(count),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!("series {} ({})", shorten(number), parts.join(", "))
}
