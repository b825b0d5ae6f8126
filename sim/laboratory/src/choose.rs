//! Which configurations a sweep runs.

use slicecast_scene::Scene;

use super::catalogue::{BASE, Configuration, FAST};
use super::measure;
use super::parameters::Name;
use super::sweep::SweepError;

/// `STAGE.WIDTH=VALUE,VALUE`: the configurations that differ from the base in that stage only and have such a value, as
/// places in `all`. A number that none of them has makes a new one, at the end of `all`. Ranges are written `6..12`: every
/// number from the first to the last.
///
/// # Errors
/// [`SweepError::Vary`], with what is accepted.
pub fn vary(all: &mut Vec<Configuration>, text: &str) -> Result<Vec<usize>, SweepError> {
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
    let mut chosen = Vec::new();
    for value in values.split(',') {
        let refused = |accepted: &str| {
            SweepError::Vary(format!(
                "--vary {text}: {} has no value `{value}`; accepted: {accepted}",
                name.text()
            ))
        };
        let numbers = range(value).ok_or_else(|| refused("ranges from low to high, as 6..12"))?;
        for value in &numbers {
            let with = with_value(all, name, value);
            if with.is_empty() {
                let words = || {
                    let mut words: Vec<_> = varying(all, name).map(|(_, c)| c.parameter(name).to_owned()).collect();
                    words.dedup();
                    words.join(", ")
                };
                let made = match value.parse().map(|bits| Configuration::varied(name, bits)) {
                    Ok(made) => made.map_err(refused)?,
                    Err(_) if Configuration::varied(name, 8).is_ok() => return Err(refused("a number")),
                    Err(_) => return Err(refused(&words())),
                };
                chosen.push(all.len());
                all.push(made);
            }
            chosen.extend(with);
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// The values that a text stands for: itself, or every number of a range. `None` for a range without a number.
fn range(text: &str) -> Option<Vec<String>> {
    let Some((low, high)) = text.split_once("..") else {
        return Some(vec![text.to_owned()]);
    };
    let high = high.strip_prefix('=').unwrap_or(high);
    let numbers = low.parse::<u32>().ok()?..=high.parse().ok()?;
    // No width is above 32; a longer range ends where that is said.
    (!numbers.is_empty()).then(|| numbers.take(34).map(|number| number.to_string()).collect())
}

/// The configurations that are the base but for the stage of a parameter.
fn varying(all: &[Configuration], name: Name) -> impl Iterator<Item = (usize, &Configuration)> {
    all.iter().enumerate().filter(move |(_, c)| varies(all, c, name))
}

/// Those that have a value.
fn with_value(all: &[Configuration], name: Name, value: &str) -> Vec<usize> {
    let having = varying(all, name).filter(|(_, c)| c.parameter(name) == value);
    having.map(|(place, _)| place).collect()
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

/// Of the chosen configurations those that know a scene: 16-bit lanes do not know every one.
pub fn knowing(all: &[Configuration], chosen: &[usize], scene: &Scene) -> Vec<usize> {
    let fast = measure::fast(scene).check().is_ok();
    let known = |index: &&usize| fast || all[**index].name != FAST;
    chosen.iter().filter(known).copied().collect()
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
        let chosen = |text| {
            let mut all = catalogue::all();
            vary(&mut all, text)
                .map(|chosen| names(&all, &chosen))
                .map_err(|e| e.to_string())
        };
        assert_eq!(chosen("weight.bits=6,10").unwrap(), ["weight-6", "weight-10"]);
        assert_eq!(
            chosen("weight.bits=8..=10,16").unwrap(),
            ["compact", "weight-8", "weight-10", "weight-9"]
        );
        assert_eq!(
            chosen("position.bits=6..=8").unwrap(),
            ["position-6", "position-8", "position-7"]
        );
        assert_eq!(chosen("table.lookup=nearest").unwrap().len(), 4);
        assert_eq!(
            chosen("compositing.bits=9,24").unwrap(),
            ["pixel-9-dithered", "pixel-24-telescoping"]
        );
        for (text, part) in [
            ("weight.bits", "expected STAGE.WIDTH=VALUE"),
            ("width.bits=3", "no parameter `width.bits`; accepted: position.bits"),
            ("weight.bits=17", "weight.bits has no value `17`; accepted: 1 to 16"),
            (
                "normal.bits=4..16",
                "normal.bits has no value `4..16`; accepted: 1 to 15",
            ),
            ("weight.bits=", "weight.bits has no value ``; accepted: a number"),
            ("weight.bits=9..6", "accepted: ranges from low to high, as 6..12"),
            ("weight.bits=0..4000000000", "accepted: 1 to 16"),
            (
                "table.lookup=cubic",
                "table.lookup has no value `cubic`; accepted: linear, nearest",
            ),
        ] {
            let message = chosen(text).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }

    /// Every width that is accepted is a configuration of its own, and differs from the base in one stage.
    #[test]
    fn every_width_is_a_configuration() {
        for name in Name::ALL {
            for bits in 0..=40 {
                let Ok(made) = Configuration::varied(name, bits) else {
                    continue;
                };
                let all = catalogue::all();
                assert!(varies(&all, &made, name), "{}", made.name);
                assert_eq!(made.parameter(name), bits.to_string());
            }
        }
    }

    #[test]
    fn scenes_that_16_bit_lanes_do_not_know_leave_them_out() {
        let all = catalogue::all();
        let chosen: Vec<usize> = (0..all.len()).collect();
        let mut scene = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).unwrap();
        assert_eq!(knowing(&all, &chosen, &scene), chosen);
        scene.lookup = Some(slicecast_scene::LookupName::Nearest);
        let left = names(&all, &knowing(&all, &chosen, &scene));
        assert!(left.len() == all.len() - 1 && !left.iter().any(|name| name == FAST));
    }

    #[test]
    fn unlit_scenes_leave_out_what_varies_shading() {
        let all = catalogue::all();
        let chosen: Vec<usize> = (0..all.len()).collect();
        assert_eq!(applicable(&all, &chosen, true), chosen);
        let left = names(&all, &applicable(&all, &chosen, false));
        assert_eq!(left.len(), all.len() - 15);
        for name in ["paper", "compact", "wide", "fast", "weight-6", "deep-23"] {
            assert!(left.iter().any(|l| l == name), "{name}");
        }
        assert!(!left.iter().any(|l| l.starts_with("normal-") || l.starts_with("power-")));
    }
}
