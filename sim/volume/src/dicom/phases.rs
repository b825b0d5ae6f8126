//! Series that hold their slices several times over: times, echoes, acquisitions.
//!
//! Slices lie at one place if they are a hundredth of a millimetre apart, and less than a tenth of the distance between
//! slices. If some place holds several, the phases are told apart by the first field whose values split the slices into
//! as many groups without two slices at one place; if no field does, by the order of the instance numbers at each place.

use std::collections::BTreeMap;

use super::names::{file_name, list};
use super::slice::{PHASE_FIELDS, Slice};
use super::stack::normal_of;
use super::{Found, NAME};
use crate::error::Problem;
use crate::text::shorten;

/// How far apart slices of one place may lie, mm: positions rounded to hundredths, either way.
const SAME_PLACE: f64 = 0.0105;

/// The same as a part of the distance between slices.
const SAME_PART: f64 = 0.1;

/// One phase: what tells it apart, and its slices by their index.
struct Phase {
    value: String,
    slices: Vec<usize>,
}

/// Takes the slices of the wanted phase, from 1, out of all. Without a wish, there may be only one.
pub(super) fn choose(
    slices: Vec<Found>,
    wanted: Option<usize>,
    notes: &mut Vec<String>,
) -> Result<Vec<Found>, Problem> {
    let fail = |fault| Err(Problem::format(NAME, fault));
    let places = Places::of(&slices);
    if places.most() <= 1 {
        return match wanted {
            None | Some(1) => Ok(slices),
            Some(phase) => fail(format!("has no phase {phase}: there is one slice at each position")),
        };
    }
    let Some((field, phases)) = places.by_field(&slices).or_else(|| places.by_instance(&slices)) else {
        return fail(places.shared(&slices));
    };
    let count = phases.len();
    let values = list(phases.iter().map(|phase| shorten(&phase.value)));
    let sizes = phases.iter().map(|phase| phase.slices.len());
    let (fewest, most) = (sizes.clone().min().unwrap_or(0), sizes.max().unwrap_or(0));
    let size = match fewest == most {
        true => format!("{most}"),
        false => format!("{fewest} to {most}"),
    };
    let known = format!("{count} phases of {size} slices at the same positions (by {field}: {values})");
    let Some(phase) = wanted else {
        return fail(format!("holds {known}, expected one: `--phase N` chooses it"));
    };
    let Some(chosen) = phase.checked_sub(1).and_then(|at| phases.get(at)) else {
        return fail(format!("has no phase {phase}, expected 1 to {count}: it holds {known}"));
    };
    notes.push(format!(
        "shown is phase {phase} ({field} {}) of {known}",
        shorten(&chosen.value)
    ));
    let mut all: Vec<Option<Found>> = slices.into_iter().map(Some).collect();
    Ok(chosen.slices.iter().filter_map(|&i| all[i].take()).collect())
}

/// The slices at each place along their normal.
struct Places {
    /// Indices of slices, a list for each place.
    at: Vec<Vec<usize>>,
    /// Where each slice lies, mm.
    distances: Vec<f64>,
}

impl Places {
    /// No places at all if a slice does not say where it lies.
    fn of(slices: &[Found]) -> Self {
        let normal = slices.first().and_then(|found| normal_of(&found.slice));
        let along = |found: &Found| {
            let (position, normal) = (found.slice.position?, normal?);
            Some((0..3).map(|i| position[i] * normal[i]).sum::<f64>())
        };
        let Some(distances) = slices.iter().map(along).collect::<Option<Vec<_>>>() else {
            return Self {
                at: Vec::new(),
                distances: Vec::new(),
            };
        };
        let mut order: Vec<usize> = (0..slices.len()).collect();
        order.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        let steps: Vec<f64> = order
            .windows(2)
            .map(|pair| distances[pair[1]] - distances[pair[0]])
            .collect();
        let (span, apart) = (
            steps.iter().sum::<f64>(),
            steps.iter().filter(|&&step| step > 1e-6).count(),
        );
        let near = match apart {
            0 => SAME_PLACE,
            apart => SAME_PLACE.min(SAME_PART * span / apart as f64),
        };
        let mut at: Vec<Vec<usize>> = Vec::new();
        for i in order {
            match at.last_mut() {
                Some(place) if distances[i] - distances[place[0]] <= near => place.push(i),
                _ => at.push(vec![i]),
            }
        }
        Self { at, distances }
    }

    /// The largest number of slices at one place.
    fn most(&self) -> usize {
        self.at.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Phases by the value of a field.
    fn by_field(&self, slices: &[Found]) -> Option<(&'static str, Vec<Phase>)> {
        let mut place_of = vec![0; slices.len()];
        for (place, at) in self.at.iter().enumerate() {
            at.iter().for_each(|&i| place_of[i] = place);
        }
        let split = |field: usize| {
            let mut groups = BTreeMap::<&str, Vec<usize>>::new();
            for (i, found) in slices.iter().enumerate() {
                groups.entry(value(&found.slice, field)?).or_default().push(i);
            }
            let alone = |group: &Vec<usize>| {
                let mut places: Vec<usize> = group.iter().map(|&i| place_of[i]).collect();
                places.sort_unstable();
                places.windows(2).all(|pair| pair[0] != pair[1])
            };
            if groups.len() != self.most() || !groups.values().all(alone) {
                return None;
            }
            let mut phases: Vec<Phase> = groups
                .into_iter()
                .map(|(value, slices)| Phase {
                    value: value.into(),
                    slices,
                })
                .collect();
            // Numbers in their order; the rest stays in that of its letters.
            phases.sort_by(|a, b| match (a.value.parse::<f64>(), b.value.parse::<f64>()) {
                (Ok(a), Ok(b)) => a.total_cmp(&b),
                _ => a.value.cmp(&b.value),
            });
            Some((PHASE_FIELDS[field].0, phases))
        };
        (0..PHASE_FIELDS.len()).find_map(split)
    }

    /// Phases by the order of the instance numbers at each place.
    fn by_instance(&self, slices: &[Found]) -> Option<(&'static str, Vec<Phase>)> {
        let mut phases: Vec<Phase> = (1..=self.most())
            .map(|rank| Phase {
                value: rank.to_string(),
                slices: Vec::new(),
            })
            .collect();
        for place in &self.at {
            let numbers = place.iter().map(|&i| Some((slices[i].slice.instance?, i)));
            let mut numbers = numbers.collect::<Option<Vec<_>>>()?;
            numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
            let distinct = numbers.windows(2).all(|pair| pair[0].0 < pair[1].0);
            if !distinct || numbers.len() != phases.len() {
                return None;
            }
            for (phase, (_, i)) in phases.iter_mut().zip(numbers) {
                phase.slices.push(i);
            }
        }
        Some(("order of instance numbers", phases))
    }

    /// What is wrong with slices that share a place and are no phases.
    fn shared(&self, slices: &[Found]) -> String {
        let shown = self
            .at
            .iter()
            .find(|place| place.len() > 1)
            .into_iter()
            .flatten()
            .take(2);
        let shown = shown.map(|&i| format!("{} at {:.3} mm", file_name(&slices[i].path), self.distances[i]));
        format!(
            "slices share a position ({}), expected one each: several acquisitions or times are mixed, and nothing tells \
             them apart",
            shown.collect::<Vec<_>>().join(" and ")
        )
    }
}

/// The value of a phase field; `None` if the slice has none.
fn value(slice: &Slice, field: usize) -> Option<&str> {
    Some(slice.phase[field].as_str()).filter(|value| !value.is_empty())
}
