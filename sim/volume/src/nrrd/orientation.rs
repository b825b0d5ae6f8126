//! Spacing and axes from `spacings`, `space directions` and `space`.

use super::header::Header;
use super::{refuse, three};
use crate::error::Problem;

/// What two statements of the same spacing may differ by, as a part of it.
const AGREEMENT: f64 = 1e-3;

/// Where the file's axes run to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Directions {
    /// In the patient (LPS).
    Patient([[f64; 3]; 3]),
    /// In another space.
    Space([[f64; 3]; 3]),
}

/// Spacing, directions if any are stated, and notes for the user.
type Stated = ([f64; 3], Option<Directions>, Vec<String>);

/// The distance between voxels along the file's three axes (1 if the header states none; it may still be no length),
/// the axes' directions, and notes for the user.
pub(super) fn read(header: &Header) -> Result<Stated, Problem> {
    let stated = header.get("spacings").map(spacings).transpose()?;
    let Some(text) = header.get("space directions") else {
        return Ok(match stated {
            Some(stated) => (stated, None, Vec::new()),
            None => ([1.0; 3], None, vec!["the file states no spacing: 1 is assumed".into()]),
        });
    };
    let expected = "three vectors `(x,y,z)` of finite numbers";
    let vectors = vectors(text).ok_or_else(|| refuse("space directions", text, expected))?;
    let measured = vectors.map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt());
    if let Some(stated) = stated {
        let agree = (0..3).all(|i| (stated[i] - measured[i]).abs() <= AGREEMENT * measured[i]);
        if !agree {
            let text = header.get("spacings").unwrap_or_default();
            let expected = "the lengths of `space directions`, or no such field";
            return Err(refuse("spacings", text, expected));
        }
    }
    Ok((measured, Some(in_space(header, vectors)?), Vec::new()))
}

/// The vectors in LPS if the file's space is a patient's.
fn in_space(header: &Header, vectors: [[f64; 3]; 3]) -> Result<Directions, Problem> {
    let signed = |[x, y, z]: [f64; 3]| Directions::Patient(vectors.map(|v| [v[0] * x, v[1] * y, v[2] * z]));
    let Some(space) = header.get("space") else {
        return Ok(Directions::Space(vectors));
    };
    Ok(match space.to_ascii_lowercase().as_str() {
        "left-posterior-superior" | "lps" => signed([1.0, 1.0, 1.0]),
        "right-anterior-superior" | "ras" => signed([-1.0, -1.0, 1.0]),
        "left-anterior-superior" | "las" => signed([1.0, -1.0, 1.0]),
        "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => Directions::Space(vectors),
        _ => {
            let expected = "a space of three dimensions, such as `left-posterior-superior`";
            return Err(refuse("space", space, expected));
        }
    })
}

/// Three numbers.
fn spacings(text: &str) -> Result<[f64; 3], Problem> {
    let numbers = three(text, |word| word.parse::<f64>().ok());
    numbers.ok_or_else(|| refuse("spacings", text, "three numbers above 0"))
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

    fn read_lines(lines: &str) -> Result<Stated, Problem> {
        let text = format!("NRRD0005\n{lines}\n");
        read(&Header::read(&mut text.as_bytes()).unwrap())
    }

    #[test]
    fn lengths_of_directions_are_the_spacing() {
        let (lengths, axes, _) = read_lines("space directions: (0.5,0,0) ( 0, -2 ,0)(0,3,4)").unwrap();
        assert_eq!(lengths, [0.5, 2.0, 5.0]);
        let vectors = [[0.5, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 3.0, 4.0]];
        assert_eq!(axes, Some(Directions::Space(vectors)));
    }

    #[test]
    fn patient_spaces_become_lps() {
        let lines = "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace: ";
        for (space, signs) in [
            ("LPS", [1.0, 1.0, 1.0]),
            ("right-anterior-superior", [-1.0, -1.0, 1.0]),
            ("LAS", [1.0, -1.0, 1.0]),
        ] {
            let (_, axes, _) = read_lines(&format!("{lines}{space}")).unwrap();
            let Some(Directions::Patient(vectors)) = axes else {
                panic!("{space}")
            };
            assert_eq!([0, 1, 2].map(|i| vectors[i][i]), signs, "{space}");
        }
        assert!(matches!(
            read_lines(&format!("{lines}scanner-xyz")).unwrap().1,
            Some(Directions::Space(_))
        ));
        let error = read_lines(&format!("{lines}LPST")).unwrap_err().to_string();
        assert!(error.contains("field `space` is `LPST`"), "{error}");
    }

    #[test]
    fn other_directions_are_refused() {
        for bad in [
            "(1,0,0) (0,1,0)",
            "(1,0) (0,1) (1,1)",
            "none (0,1,0) (0,0,1)",
            "(1,0,0) (0,1,0) (0,0,nan)",
            "(1,0,0) (0,1,0) (0,0,1",
        ] {
            let error = read_lines(&format!("space directions: {bad}")).unwrap_err().to_string();
            assert!(error.contains("`space directions`"), "{error}");
        }
    }

    #[test]
    fn two_statements_have_to_agree() {
        let directions = "space directions: (1,0,0) (0,1,0) (0,0,2)";
        assert_eq!(
            read_lines(&format!("{directions}\nspacings: 1 1 2")).unwrap().0,
            [1.0, 1.0, 2.0]
        );
        assert!(read_lines(&format!("{directions}\nspacings: 1 1 1")).is_err());
        assert!(read_lines(&format!("{directions}\nspacings: 1 1 nan")).is_err());
    }

    #[test]
    fn no_statement_is_one_and_is_told() {
        let (spacing, axes, notes) = read_lines("type: short").unwrap();
        assert_eq!((spacing, axes, notes.len()), ([1.0; 3], None, 1));
        assert!(read_lines("spacings: 1 1").is_err());
        assert!(read_lines("spacings: 1 1 x").is_err());
    }
}
