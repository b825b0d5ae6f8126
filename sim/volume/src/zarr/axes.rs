//! Which axes of an array are x, y and z, which is the channel and which the time, and how far apart voxels are.

use super::NAME;
use super::array::Array;
use super::image::{Axis, Told};
use crate::choice::{Choice, one_of};
use crate::error::Problem;
use crate::length::millimetres;
use crate::text::shorten;

/// A volume in an array.
#[derive(Debug, PartialEq)]
pub(super) struct Chosen {
    /// The array's axis of x, y and z; `None`: one voxel.
    pub space: [Option<usize>; 3],
    /// Where the volume lies along every other axis; 0 along its own.
    pub at: Vec<u64>,
    /// Distance between voxels.
    pub spacing: [f64; 3],
    pub stated_window: Option<[f64; 2]>,
    pub notes: Vec<String>,
}

/// What an axis is.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// x, y, z.
    Named(usize),
    /// In space, without one of these names.
    Space,
    Time,
    Channel,
    Other,
}

impl Axis {
    fn kind(&self) -> Kind {
        let is = |kind: &str| self.kind.as_deref() == Some(kind);
        match self.name.to_ascii_lowercase().as_str() {
            "x" => Kind::Named(0),
            "y" => Kind::Named(1),
            "z" => Kind::Named(2),
            _ if is("space") => Kind::Space,
            "t" | "time" => Kind::Time,
            "c" | "channel" => Kind::Channel,
            _ if is("time") => Kind::Time,
            _ if is("channel") => Kind::Channel,
            _ => Kind::Other,
        }
    }
}

/// Chooses the volume of an array.
///
/// # Errors
/// [`Problem`] if axes are left that nothing chooses from, or a channel or time that is not there was asked for.
pub(super) fn choose(array: &Array, told: Told, choice: &Choice) -> Result<Chosen, Problem> {
    let fault = |fault: String| Problem::format(NAME, fault);
    let shape = &array.shape;
    let mut notes = told.notes;
    let axes = match &array.names {
        _ if told.axes.len() == shape.len() => told.axes,
        _ if !told.axes.is_empty() => {
            let (stated, found) = (told.axes.len(), shape.len());
            return Err(fault(format!(
                "states {stated} axes, expected {found}, as its array has"
            )));
        }
        Some(names) => names
            .iter()
            .map(|name| Axis {
                name: name.clone(),
                kind: None,
                unit: None,
            })
            .collect(),
        None => Vec::new(),
    };
    let mut space = [None; 3];
    let mut unnamed = Vec::new();
    let (mut channel, mut time) = (None, None);
    for (index, axis) in axes.iter().enumerate() {
        let place = match axis.kind() {
            Kind::Named(to) => &mut space[to],
            Kind::Channel => &mut channel,
            Kind::Time => &mut time,
            Kind::Space | Kind::Other => {
                unnamed.push(index);
                continue;
            }
        };
        if place.replace(index).is_some() {
            return Err(fault(format!("names two axes `{}`, expected one", shorten(&axis.name))));
        }
    }
    if axes.is_empty() {
        unnamed = (0..shape.len()).collect();
    }
    if space == [None; 3] {
        // Without names they follow one another as z, y, x; others have one entry.
        let mut left = unnamed.clone();
        while left.len() > 3 {
            let single = left.iter().position(|&axis| shape[axis] == 1);
            let single = single.ok_or_else(|| unresolved(shape, &axes))?;
            left.remove(single);
        }
        for (to, axis) in left.iter().rev().enumerate() {
            space[to] = Some(*axis);
        }
        unnamed.retain(|axis| !left.contains(axis));
    }
    if unnamed.iter().any(|&axis| shape[axis] > 1) || space[0].is_none() || space[1].is_none() && space[2].is_some() {
        return Err(unresolved(shape, &axes));
    }
    let mut at = vec![0; shape.len()];
    let count = |axis: Option<usize>| axis.map_or(1, |axis| usize::try_from(shape[axis]).unwrap_or(usize::MAX));
    let mut pick = |what, option: &str, axis: Option<usize>, asked| -> Result<usize, Problem> {
        let index = one_of(what, asked, count(axis))?;
        if let Some(axis) = axis {
            at[axis] = index as u64;
        }
        if count(axis) > 1 {
            notes.push(format!(
                "{what} {} of {}; `{option} N` chooses another",
                index + 1,
                count(axis)
            ));
        }
        Ok(index)
    };
    let shown = pick("channel", "--channel", channel, choice.channel)?;
    pick("time point", "--time", time, choice.time)?;
    let spacing = spacing(&axes, told.scale.as_deref(), space, &mut notes);
    Ok(Chosen {
        space,
        at,
        spacing,
        stated_window: told.windows.get(shown).copied().flatten(),
        notes,
    })
}

/// The fault of axes that are more than a volume has.
fn unresolved(shape: &[u64], axes: &[Axis]) -> Problem {
    let axis = |(index, len): (usize, &u64)| {
        let name = axes.get(index).map_or("unnamed", |axis| axis.name.as_str());
        format!("{} {len}", shorten(name))
    };
    let axes: Vec<String> = shape.iter().enumerate().map(axis).collect();
    Problem::format(
        NAME,
        format!(
            "has the axes {}, expected z, y and x, of which others are told apart by `--channel` and `--time` (axes named c \
             and t) or have one entry",
            axes.join(", ")
        ),
    )
}

/// The distances between voxels, in millimetres where the units are known.
fn spacing(axes: &[Axis], scale: Option<&[f64]>, space: [Option<usize>; 3], notes: &mut Vec<String>) -> [f64; 3] {
    let Some(scale) = scale else {
        notes.push("the file states no spacing: 1 is assumed".into());
        return [1.0; 3];
    };
    let number = |axis: Option<usize>| axis.and_then(|axis| scale.get(axis)).copied();
    let unit = |axis: usize| axes.get(axis).and_then(|axis| millimetres(axis.unit.as_deref()?));
    let numbers = space.map(number);
    let x = numbers[0].unwrap_or(1.0);
    let units: Option<Vec<f64>> = space.into_iter().flatten().map(unit).collect();
    let known = units.is_some();
    let spacing = [0, 1, 2].map(|to| {
        let factor = space[to].or(space[0]).filter(|_| known).and_then(unit).unwrap_or(1.0);
        numbers[to].unwrap_or(x) * factor
    });
    if !known {
        let [x, y, z] = spacing;
        notes.push(format!(
            "the file states no unit of length that is known: only the ratio {x} : {y} : {z} is"
        ));
    }
    spacing
}
