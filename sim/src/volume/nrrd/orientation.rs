//! Spacing from `spacings` or `space directions`.

use super::header::Header;
use super::{refuse, three};
use crate::volume::error::Problem;

/// A direction counts as along an axis if its other components are below this part of its length (0.006 degrees).
const ALIGNMENT: f64 = 1e-4;

/// What two statements of the same spacing may differ by, as a part of it.
const AGREEMENT: f64 = 1e-3;

/// The distance between voxels along the file's three axes, 1 if the header states none, and notes for the user.
/// The numbers may still be no lengths.
pub(super) fn spacing(header: &Header) -> Result<([f64; 3], Vec<String>), Problem> {
    let stated = header.get("spacings").map(spacings).transpose()?;
    let measured = header.get("space directions").map(directions).transpose()?;
    match (stated, measured) {
        (None, None) => Ok(([1.0; 3], vec!["the file states no spacing: 1 is assumed".into()])),
        (Some(stated), None) => Ok((stated, Vec::new())),
        (None, Some(measured)) => Ok(measured),
        (Some(stated), Some(measured)) => {
            let agree = (0..3).all(|i| (stated[i] - measured.0[i]).abs() <= AGREEMENT * measured.0[i]);
            let text = header.get("spacings").unwrap_or_default();
            let disagree = || refuse("spacings", text, "the lengths of `space directions`, or no such field");
            if agree { Ok(measured) } else { Err(disagree()) }
        }
    }
}

/// Three numbers.
fn spacings(text: &str) -> Result<[f64; 3], Problem> {
    let numbers = three(text, |word| word.parse::<f64>().ok());
    numbers.ok_or_else(|| refuse("spacings", text, "three numbers above 0"))
}

/// The lengths of three vectors, each along another axis of space.
fn directions(text: &str) -> Result<([f64; 3], Vec<String>), Problem> {
    let expected = "three vectors `(x,y,z)`, each along another axis of space (oblique volumes are not read yet)";
    let refuse = || refuse("space directions", text, expected);
    let vectors = vectors(text).ok_or_else(refuse)?;
    let mut axes = [0; 3];
    let mut lengths = [0.0; 3];
    let mut reversed = 0;
    for ((vector, axis), length) in vectors.iter().zip(&mut axes).zip(&mut lengths) {
        *length = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
        let along: Vec<usize> = (0..3).filter(|&i| vector[i].abs() > ALIGNMENT * *length).collect();
        let [only] = along[..] else {
            return Err(refuse());
        };
        *axis = only;
        reversed += usize::from(vector[only] < 0.0);
    }
    if [0, 1, 2].iter().any(|axis| !axes.contains(axis)) {
        return Err(refuse());
    }
    let mut notes = Vec::new();
    if axes != [0, 1, 2] {
        let [x, y, z] = axes.map(|axis| ["x", "y", "z"][axis]);
        notes.push(format!(
            "the file's axes run along {x}, {y}, {z} of its space: shown in the file's order"
        ));
    }
    if reversed > 0 {
        notes.push(format!(
            "{reversed} of the file's axes run against its space: shown in the file's order"
        ));
    }
    Ok((lengths, notes))
}

/// Three parenthesised vectors of three finite numbers, with spaces anywhere between.
fn vectors(text: &str) -> Option<[[f64; 3]; 3]> {
    let mut vectors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (inside, after) = rest.strip_prefix('(')?.split_once(')')?;
        let words: Vec<&str> = inside.split(',').collect();
        let [x, y, z] = words[..] else { return None };
        let number = |word: &str| word.trim().parse::<f64>().ok().filter(|c| c.is_finite());
        vectors.push([number(x)?, number(y)?, number(z)?]);
        rest = after.trim_start();
    }
    vectors.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(lines: &str) -> Result<([f64; 3], Vec<String>), Problem> {
        let text = format!("NRRD0005\n{lines}\n");
        spacing(&Header::read(&mut text.as_bytes()).unwrap())
    }

    #[test]
    fn lengths_of_aligned_directions_are_the_spacing() {
        let (lengths, notes) = read("space directions: (0.5,0,0) ( 0, -2 ,1e-17)(0,0,3)").unwrap();
        assert_eq!(lengths, [0.5, 2.0, 3.0]);
        assert_eq!(notes.len(), 1);
        let (lengths, notes) = read("space directions: (0,0.5,0) (0,0,2) (3,0,0)").unwrap();
        assert_eq!(lengths, [0.5, 2.0, 3.0]);
        assert!(notes[0].contains("along y, z, x"), "{notes:?}");
    }

    #[test]
    fn other_directions_are_refused() {
        for bad in [
            "(1,0,0) (0,1,0.001) (0,0,1)",
            "(1,0,0) (1,0,0) (0,0,1)",
            "(0,0,0) (0,1,0) (0,0,1)",
            "(1,0,0) (0,1,0)",
            "(1,0) (0,1) (1,1)",
            "none (0,1,0) (0,0,1)",
            "(1,0,0) (0,1,0) (0,0,nan)",
            "(1e300,1e300,0) (0,1,0) (0,0,1)",
            "(1,0,0) (0,1,0) (0,0,1",
        ] {
            let error = read(&format!("space directions: {bad}")).unwrap_err().to_string();
            assert!(
                error.contains("`space directions`") && error.contains("oblique"),
                "{error}"
            );
        }
    }

    #[test]
    fn two_statements_have_to_agree() {
        let directions = "space directions: (1,0,0) (0,1,0) (0,0,2)";
        assert_eq!(
            read(&format!("{directions}\nspacings: 1 1 2")).unwrap().0,
            [1.0, 1.0, 2.0]
        );
        assert!(read(&format!("{directions}\nspacings: 1 1 1")).is_err());
        assert!(read(&format!("{directions}\nspacings: 1 1 nan")).is_err());
    }

    #[test]
    fn no_statement_is_one_and_is_told() {
        let (spacing, notes) = read("type: short").unwrap();
        assert_eq!((spacing, notes.len()), ([1.0; 3], 1));
        assert!(read("spacings: 1 1").is_err());
        assert!(read("spacings: 1 1 x").is_err());
    }
}
