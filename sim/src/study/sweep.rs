//! All configurations on one scene: errors once, speeds in turns.
//!
//! Configurations are taken in batches. The errors of a batch are gathered first; then its frames are rendered in
//! turns, round after round, each after a frame of the base configuration, and the fastest of each counts. A speed is
//! also related to that of the base's frames beside it, so that rows of several runs and machines can stand in one
//! table.

use std::time::Duration;

use super::catalogue::{BASE, Configuration};
use super::measure::{Bench, Measured, samples};
use super::parameters::Name;
use super::pareto::{Point, front};
use super::rows::{Row, StageRow};
use crate::compare::{ModelPositions, model};
use crate::engine::{Prepared, RenderError, on_threads};
use crate::oriented::with_slices;
use crate::scene::Blend;

/// Configurations whose frames take turns.
pub const BATCH: usize = 8;

/// Why a sweep cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A parameter that does not exist, or a value that no configuration has.
    #[error("{0}")]
    Vary(String),
    /// The scene cannot be rendered.
    #[error("{0}")]
    Render(#[from] RenderError),
    /// A blend that configurations do not have.
    #[error("a sweep composites front to back; the scene's blend is another one")]
    Blend,
    /// Shards that do not belong together.
    #[error("{0}")]
    Merge(String),
}

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

/// What identifies the inputs of a row: the volume, the scene and the program's version.
pub fn key(prepared: &Prepared<'_>) -> String {
    let mut voxels = crc32fast::Hasher::new();
    for voxel in &prepared.volume.voxels {
        voxels.update(&voxel.to_le_bytes());
    }
    let volume = &prepared.volume;
    let shape = format!("{:?} {:?} {:?}", volume.dims, volume.spacing, volume.mapping);
    // The precision, table and look-up of the scene are the configuration's affair.
    let scene = crate::scene::Scene {
        precision: crate::scene::PrecisionName::Compact,
        table: None,
        lookup: None,
        ..prepared.scene.clone()
    };
    let words = format!("{} {shape} {scene:?}", env!("CARGO_PKG_VERSION"));
    format!("{:08x}-{:08x}", voxels.finalize(), crc32fast::hash(words.as_bytes()))
}

/// How a sweep is measured.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Frames of each configuration; the fastest counts.
    pub rounds: u32,
    /// Threads that render the frames that are timed.
    pub timing_threads: usize,
}

/// Runs configurations and hands over the rows of each finished batch. `progress` is told how many steps of how many
/// are done.
///
/// # Errors
/// [`SweepError`], or what `finished` returns.
pub fn run<E: From<SweepError>>(
    prepared: &Prepared<'_>,
    all: &[Configuration],
    chosen: &[usize],
    options: Options,
    progress: &(dyn Fn(usize, usize) + Sync),
    mut finished: impl FnMut(&[Row]) -> Result<(), E>,
) -> Result<(), E> {
    if prepared.scene.blend != Blend::FrontToBack {
        return Err(SweepError::Blend.into());
    }
    let base = all.iter().find(|c| c.name == BASE);
    let base = base.ok_or(SweepError::Vary(format!("no configuration `{BASE}`")))?;
    let model = model(prepared, ModelPositions::Pipeline);
    let key = key(prepared);
    let samples = samples(&prepared.setup.plan) as f64;
    // A comparison takes about as long as all rounds of a configuration, which is as good as an estimate needs.
    let total = 2 * chosen.len();
    let mut done = 0;
    let view = prepared.setup.plan.view();
    for batch in chosen.chunks(BATCH) {
        let benches: Vec<_> = batch
            .iter()
            .map(|index| (*index, stepped(prepared, &all[*index])))
            .collect();
        let mut rows = Vec::new();
        for (index, stepped) in &benches {
            let comparison = with_slices(prepared.volume, view, |slices| {
                let bench = Bench {
                    prepared: stepped,
                    model: &model,
                    slices,
                };
                all[*index].runner.compare(bench)
            });
            let comparison = comparison.map_err(|error| SweepError::Render(error.into()));
            let comparison = comparison?.map_err(SweepError::Render)?;
            rows.push(row(&key, *index, &all[*index], &comparison));
            done += 1;
            progress(done, total);
        }
        let mut steps = |share: usize| progress(done + share * batch.len() / options.rounds.max(1) as usize, total);
        let pairs: Vec<_> = benches.iter().map(|(index, stepped)| (&all[*index], stepped)).collect();
        let times = timed((base, prepared), &pairs, &model, options, &mut steps).map_err(SweepError::Render)?;
        done += batch.len();
        for (row, [own, base]) in rows.iter_mut().zip(times) {
            row.samples_per_second = samples / own.as_secs_f64();
            row.relative_speed = base.as_secs_f64() / own.as_secs_f64();
            row.rounds = options.rounds;
            row.threads = options.timing_threads;
        }
        finished(&rows)?;
    }
    Ok(())
}

/// The scene with a configuration's step.
fn stepped<'a>(prepared: &Prepared<'a>, configuration: &Configuration) -> Prepared<'a> {
    let mut stepped = prepared.clone();
    stepped.setup.plan = stepped.setup.plan.with_step_bits(configuration.step_bits);
    stepped
}

/// The fastest frame of each configuration and of the base, in turns: each frame of a configuration follows one of the
/// base.
fn timed(
    base: (&Configuration, &Prepared<'_>),
    batch: &[(&Configuration, &Prepared<'_>)],
    model: &crate::model::Model<'_>,
    options: Options,
    steps: &mut (dyn FnMut(usize) + Send),
) -> Result<Vec<[Duration; 2]>, RenderError> {
    on_threads(Some(options.timing_threads), || {
        let prepared = base.1;
        with_slices(prepared.volume, prepared.setup.plan.view(), |slices| {
            let mut fastest = vec![[Duration::MAX; 2]; batch.len()];
            for round in 0..options.rounds {
                for (slots, own) in fastest.iter_mut().zip(batch) {
                    for (slot, (configuration, prepared)) in slots.iter_mut().zip([*own, base]) {
                        let bench = Bench {
                            prepared,
                            model,
                            slices,
                        };
                        *slot = (*slot).min(configuration.runner.time(bench)?);
                    }
                }
                steps(round as usize + 1);
            }
            Ok(fastest)
        })
        .map_err(RenderError::from)?
    })?
}

/// The row of a comparison; the speed is still to come.
fn row(key: &str, index: usize, configuration: &Configuration, comparison: &Measured) -> Row {
    let stages = comparison.stages.iter().map(|stage| StageRow {
        name: stage.name.to_owned(),
        format: stage.format.clone(),
        local_max_ulp: stage.local.max_ulp,
        local_mean_ulp: stage.local.mean_ulp,
        local_bits: stage.local.bits,
        carried_max_ulp: stage.carried.max_ulp,
        carried_mean_ulp: stage.carried.mean_ulp,
    });
    Row {
        key: key.to_owned(),
        index,
        name: configuration.name.clone(),
        parameters: configuration.parameters.clone(),
        pixel_bytes: configuration.pixel_bytes,
        table_bytes: configuration.table_bytes,
        image: comparison.image,
        stages: stages.collect(),
        samples_per_second: 0.0,
        relative_speed: 0.0,
        rounds: 0,
        threads: 0,
    }
}

/// For each row, whether it is on the front of relative speed against mean error.
pub fn on_front(rows: &[Row]) -> Vec<bool> {
    let points: Vec<_> = rows
        .iter()
        .map(|row| Point {
            speed: row.relative_speed,
            error: row.image.mean_lsb8,
        })
        .collect();
    front(&points)
}

/// Puts the rows of shards together, in the order of the catalogue.
///
/// # Errors
/// [`SweepError::Merge`] if they are of different inputs, or a configuration is there twice with different errors.
pub fn merge(rows: Vec<Row>) -> Result<Vec<Row>, SweepError> {
    let mut merged: Vec<Row> = Vec::new();
    for row in rows {
        if let Some(first) = merged.first()
            && first.key != row.key
        {
            return Err(SweepError::Merge(format!(
                "rows of different inputs: `{}` of {} and `{}` of {}",
                first.name, first.key, row.name, row.key
            )));
        }
        match merged.iter().find(|known| known.name == row.name) {
            None => merged.push(row),
            // The same configuration run twice: the first stands.
            Some(known) if known.image == row.image && known.stages == row.stages => {}
            Some(_) => {
                return Err(SweepError::Merge(format!(
                    "`{}` is there twice with different errors",
                    row.name
                )));
            }
        }
    }
    merged.sort_by_key(|row| row.index);
    Ok(merged)
}

/// The configurations of shard `number` (from 1) of `count`.
pub fn shard(chosen: &[usize], number: usize, count: usize) -> Vec<usize> {
    let own = |(place, _): &(usize, &usize)| place % count == number - 1;
    chosen.iter().enumerate().filter(own).map(|(_, index)| *index).collect()
}

#[cfg(test)]
mod tests {
    use super::super::catalogue;
    use super::super::rows::tests::row;
    use super::*;
    use crate::scene;
    use crate::volume::mapping::Window;
    use crate::volume::open::load;

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

    #[test]
    fn shards_make_the_whole() {
        let chosen: Vec<usize> = (0..13).collect();
        let mut all: Vec<usize> = (1..=4).flat_map(|number| shard(&chosen, number, 4)).collect();
        all.sort_unstable();
        assert_eq!(all, chosen);
        assert_eq!(shard(&chosen, 2, 4), [1, 5, 9]);
    }

    #[test]
    fn merged_rows_agree_or_are_refused() {
        let merged = merge(vec![
            row("b", 1, 2.0, 1.0),
            row("a", 0, 1.0, 1.0),
            row("b", 1, 2.0, 3.0),
        ])
        .unwrap();
        assert_eq!(merged, [row("a", 0, 1.0, 1.0), row("b", 1, 2.0, 1.0)]);
        assert!(merge(vec![row("a", 0, 1.0, 1.0), row("a", 0, 1.5, 1.0)]).is_err());
        let mut other = row("b", 1, 1.0, 1.0);
        other.key = "other".into();
        assert!(merge(vec![row("a", 0, 1.0, 1.0), other]).is_err());
        assert_eq!(on_front(&merged), [true, false]);
    }

    /// Two shards give the errors of the whole, and the named precisions are those of `compare`.
    #[test]
    fn errors_do_not_depend_on_the_shard() {
        let volume = load(None, Window::Auto).unwrap().volume;
        let mut scene = scene::file::built_in(scene::file::DEFAULT).unwrap();
        scene.sampling.planes_per_voxel = 1;
        scene.sampling.rays_per_voxel = 1;
        let prepared = Prepared::new(&scene, &volume).unwrap();
        let all = catalogue::all();
        let named = |name: &str| all.iter().position(|c| c.name == name).unwrap();
        let chosen = [named("compact"), named("position-8"), named("pixel-8-truncated")];
        let options = Options {
            rounds: 1,
            timing_threads: 1,
        };
        let swept = |chosen: &[usize]| {
            let mut rows = Vec::new();
            run::<SweepError>(&prepared, &all, chosen, options, &|_, _| (), |batch| {
                rows.extend_from_slice(batch);
                Ok(())
            })
            .unwrap();
            rows
        };
        let whole = merge(swept(&chosen)).unwrap();
        let parts: Vec<Row> = (1..=2).flat_map(|number| swept(&shard(&chosen, number, 2))).collect();
        let errors = |rows: &[Row]| -> Vec<_> {
            rows.iter()
                .map(|r| (r.name.clone(), r.image, r.stages.clone()))
                .collect()
        };
        assert_eq!(errors(&merge(parts).unwrap()), errors(&whole));
        let compared = crate::compare::compare(&prepared, ModelPositions::Pipeline, &|_, _| ()).unwrap();
        assert_eq!(whole[0].image, compared.image);
        // Short steps and eight bits of pixel are far worse.
        assert!(whole[1].image.mean_lsb8 > 10.0 * whole[0].image.mean_lsb8);
        assert!(whole[2].image.mean_lsb8 > 10.0 * whole[0].image.mean_lsb8);
        assert!(
            whole
                .iter()
                .all(|row| row.samples_per_second > 0.0 && row.relative_speed > 0.0)
        );
    }
}
