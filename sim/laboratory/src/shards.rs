//! Parts of a sweep: what each machine of an array job runs, and one table of all their rows.

use super::rows::Row;
use super::sweep::SweepError;

/// The configurations of shard `number` (from 1) of `count`.
pub fn shard(chosen: &[usize], number: usize, count: usize) -> Vec<usize> {
    let own = |(place, _): &(usize, &usize)| place % count == number - 1;
    chosen.iter().enumerate().filter(own).map(|(_, index)| *index).collect()
}

/// What differs between two inputs, by their keys; `None` if they are the same.
pub fn difference(one: &str, other: &str) -> Option<&'static str> {
    let volume = |key: &str| key.split('-').next().map(str::to_owned);
    if one == other {
        None
    } else if volume(one) != volume(other) {
        Some("another volume")
    } else {
        Some("another scene, window or version of the program")
    }
}

/// Puts the rows of shards together, in the order of the catalogue.
///
/// # Errors
/// [`SweepError::Merge`] if they are of different inputs or numbers of views, or a configuration is there twice with
/// different errors.
pub fn merge(rows: Vec<Row>) -> Result<Vec<Row>, SweepError> {
    let mut merged: Vec<Row> = Vec::new();
    for row in rows {
        if let Some(first) = merged.first() {
            let problem = |problem: &str| {
                let (own, other) = (&row.name, &first.name);
                Err(SweepError::Merge(format!(
                    "`{own}` is of {problem} than `{other}`, expected rows of one sweep"
                )))
            };
            if let Some(what) = difference(&first.key, &row.key) {
                return problem(what);
            }
            if first.views.len() != row.views.len() {
                return problem("another number of views");
            }
        }
        match merged.iter().find(|known| known.name == row.name) {
            None => merged.push(row),
            // The same configuration run twice: the first stands.
            Some(known) if known.image == row.image && known.stages == row.stages => {}
            Some(_) => {
                return Err(SweepError::Merge(format!(
                    "`{}` is there twice with different errors, expected each configuration once",
                    row.name
                )));
            }
        }
    }
    merged.sort_by_key(|row| row.index);
    Ok(merged)
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::row;
    use super::*;

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
        let other = |key: &str| Row {
            key: key.into(),
            ..row("b", 1, 1.0, 1.0)
        };
        let refused = |key| merge(vec![other("1-2"), other(key)]).unwrap_err().to_string();
        assert!(refused("3-2").contains("another volume"));
        assert!(refused("1-3").contains("another scene"));
        let mut other = row("b", 1, 1.0, 1.0);
        other.views.push(other.image);
        assert!(merge(vec![row("a", 0, 1.0, 1.0), other]).is_err());
    }
}
