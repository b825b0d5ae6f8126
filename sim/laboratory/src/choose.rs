//! Which configurations a sweep runs.

use super::catalogue::{BASE, Configuration};
use super::parameters::Name;
use super::sweep::SweepError;

/// `STAGE.WIDTH=VALUE,VALUE`: the configurations that differ from the base in that stage only and have such a value.
/// Ranges of numbers are written `6..12`.
///
/// # Errors
/// [`SweepError::Vary`], with what is accepted.
pub fn vary(all: &[Configuration], text: &str) -> Result<Vec<usize>, SweepError> {
    let known = || {
        let names: Vec<_> = Name::ALL.iter().map(|name| name.text()).collect();
        names.join(", ")
    };
    let Some((name, values)) = text.split_once('=') else {
        return Err(SweepError::Vary(format!(
            "--vary {text}: expected STAGE.WIDTH=VALUE,VALUE; accepted: {}",
            known()
        )));
    };
    let name = Name::from_text(name)
        .ok_or_else(|| SweepError::Vary(format!("--vary {text}: no parameter `{name}`; accepted: {}", known())))?;
    let candidates: Vec<_> = all.iter().enumerate().filter(|(_, c)| varies(all, c, name)).collect();
    let mut chosen = Vec::new();
    for value in values.split(',') {
        let before = chosen.len();
        chosen.extend(
            candidates
                .iter()
                .filter(|(_, c)| has(c, name, value))
                .map(|(index, _)| *index),
        );
        if chosen.len() == before {
            let mut values: Vec<_> = candidates.iter().map(|(_, c)| c.parameter(name)).collect();
            values.dedup();
            return Err(SweepError::Vary(format!(
                "--vary {text}: no configuration has {} {value}; accepted: {}",
                name.text(),
                values.join(", ")
            )));
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// Whether a configuration is the base, but for the stage of a parameter.
fn varies(all: &[Configuration], configuration: &Configuration, name: Name) -> bool {
    let base = all.iter().find(|c| c.name == BASE);
    base.is_some_and(|base| {
        let others = configuration
            .parameters
            .iter()
            .filter(|(n, _)| n.stage() != name.stage());
        others.into_iter().all(|(n, value)| base.parameter(*n) == value)
    })
}

/// Whether a parameter has a value, or a number within a range.
fn has(configuration: &Configuration, name: Name, value: &str) -> bool {
    let own = configuration.parameter(name);
    let range = value.split_once("..").and_then(|(low, high)| {
        let high = high.strip_prefix('=').unwrap_or(high);
        Some(low.parse::<u32>().ok()?..=high.parse().ok()?)
    });
    match range {
        Some(range) => own.parse::<u32>().is_ok_and(|own| range.contains(&own)),
        None => own == value,
    }
}

/// Without what varies shading alone, where there is none: it would be the base over and over.
pub fn applicable(all: &[Configuration], chosen: &[usize], lit: bool) -> Vec<usize> {
    let base = all.iter().find(|c| c.name == BASE);
    let shading = |name: &Name| ["gradient", "normal", "shading", "power"].contains(&name.stage());
    let idle = |configuration: &Configuration| {
        let mut changes = configuration
            .parameters
            .iter()
            .filter(|(name, value)| base.is_some_and(|base| base.parameter(*name) != value))
            .peekable();
        changes.peek().is_some() && changes.all(|(name, _)| shading(name))
    };
    chosen
        .iter()
        .copied()
        .filter(|index| lit || !idle(&all[*index]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::catalogue;
    use super::*;

    fn names(all: &[Configuration], chosen: &[usize]) -> Vec<String> {
        chosen.iter().map(|index| all[*index].name.clone()).collect()
    }

    #[test]
    fn vary_chooses_one_stage() {
        let all = catalogue::all();
        let chosen = |text| {
            vary(&all, text)
                .map(|chosen| names(&all, &chosen))
                .map_err(|e| e.to_string())
        };
        assert_eq!(chosen("weight.bits=6,10").unwrap(), ["weight-6", "weight-10"]);
        assert_eq!(
            chosen("weight.bits=8..16").unwrap(),
            ["compact", "weight-8", "weight-10", "weight-12"]
        );
        assert_eq!(chosen("position.bits=6..=8").unwrap(), ["position-6", "position-8"]);
        assert_eq!(chosen("table.lookup=nearest").unwrap().len(), 4);
        for (text, part) in [
            ("weight.bits", "expected STAGE.WIDTH=VALUE"),
            ("width.bits=3", "no parameter `width.bits`; accepted: position.bits"),
            (
                "weight.bits=7",
                "no configuration has weight.bits 7; accepted: 16, 6, 8, 10, 12",
            ),
            ("weight.bits=", "no configuration has weight.bits ;"),
        ] {
            let message = chosen(text).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn unlit_scenes_leave_out_what_varies_shading() {
        let all = catalogue::all();
        let chosen: Vec<usize> = (0..all.len()).collect();
        assert_eq!(applicable(&all, &chosen, true), chosen);
        let left = names(&all, &applicable(&all, &chosen, false));
        assert_eq!(left.len(), all.len() - 15);
        for name in ["paper", "compact", "wide", "weight-6", "deep-23"] {
            assert!(left.iter().any(|l| l == name), "{name}");
        }
        assert!(!left.iter().any(|l| l.starts_with("normal-") || l.starts_with("power-")));
    }
}
