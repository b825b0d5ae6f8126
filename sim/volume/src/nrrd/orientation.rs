//! Spacing and axes from `spacings`, `space directions` and `space`, in the units that `units` or `space units` state.

use super::header::Header;
use super::{refuse, three};
use crate::axes::Directions;
use crate::error::Problem;
use crate::length::millimetres;
use crate::text::shorten;

/// What two statements of the same spacing may differ by, as a part of it.
const AGREEMENT: f64 = 1e-3;

/// Spacing, directions if any are stated, and notes for the user.
type Stated = ([f64; 3], Option<Directions>, Vec<String>);

/// The distance between voxels along the file's three axes (1 if the header states none; it may still be no length),
/// the axes' directions, and notes for the user.
pub(super) fn read(header: &Header) -> Result<Stated, Problem> {
    let stated = header.get("spacings").map(spacings).transpose()?;
    let mut notes = Vec::new();
    let Some(text) = header.get("space directions") else {
        let Some(stated) = stated else {
            return Ok(([1.0; 3], None, vec!["the file states no spacing: 1 is assumed".into()]));
        };
        let factors = factors(header, "units", &mut notes)?;
        return Ok(([0, 1, 2].map(|i| stated[i] * factors[i]), None, notes));
    };
    let expected = "three vectors `(x,y,z)` of finite numbers";
    let vectors = vectors(text).ok_or_else(|| refuse("space directions", text, expected))?;
    // The units are those of the space's axes, not of the file's.
    let factors = factors(header, "space units", &mut notes)?;
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let measured = vectors.map(length);
    if let Some(stated) = stated {
        let agree = (0..3).all(|i| (stated[i] - measured[i]).abs() <= AGREEMENT * measured[i]);
        if !agree {
            let text = header.get("spacings").unwrap_or_default();
            let expected = "the lengths of `space directions`, or no such field";
            return Err(refuse("spacings", text, expected));
        }
    }
    let vectors = vectors.map(|v| [0, 1, 2].map(|axis| v[axis] * factors[axis]));
    Ok((vectors.map(length), Some(in_space(header, vectors)?), notes))
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

/// Millimetres per unit along each of three axes; 1 where no unit of length is stated.
fn factors(header: &Header, field: &'static str, notes: &mut Vec<String>) -> Result<[f64; 3], Problem> {
    let Some(text) = header.get(field) else {
        return Ok([1.0; 3]);
    };
    let expected = "three quoted names of units";
    let names: [String; 3] = quoted(text)
        .and_then(|names| names.try_into().ok())
        .ok_or_else(|| refuse(field, text, expected))?;
    let factors = names.each_ref().map(|name| millimetres(name));
    if factors != [Some(1.0); 3] {
        let shown = shorten(&names.join(", "));
        notes.push(match factors {
            [Some(_), Some(_), Some(_)] => format!("{field} {shown} are brought to millimetres"),
            _ => format!("{field} {shown}: what is no unit of length is taken as mm"),
        });
    }
    Ok(factors.map(|factor| factor.unwrap_or(1.0)))
}

/// Words in double quotes; words without quotes count too, since some programs leave them out.
fn quoted(text: &str) -> Option<Vec<String>> {
    let mut words = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (word, after) = match rest.strip_prefix('"') {
            Some(rest) => rest.split_once('"')?,
            None => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
        };
        words.push(word.to_owned());
        rest = after.trim_start();
    }
    Some(words)
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
    fn units_become_millimetres() {
        let directions = "space: LPS\nspace directions: (0.0014,0,0) (0,0.0014,0) (0,0,0.0028)";
        let (spacing, _, notes) = read_lines(&format!("{directions}\nspace units: \"m\" \"m\" \"m\"")).unwrap();
        assert_eq!(spacing, [1.4, 1.4, 2.8]);
        assert!(notes[0].contains("brought to millimetres"), "{notes:?}");
        // The unit belongs to the axis of space: here the file's first axis runs along the third, which is in metres.
        let turned = "space: LPS\nspace directions: (0,0,0.003) (1,0,0) (0,20,0)";
        let (spacing, axes, _) = read_lines(&format!("{turned}\nspace units: \"mm\" \"um\" \"m\"")).unwrap();
        assert_eq!(spacing, [3.0, 1.0, 0.02]);
        let vectors = [[0.0, 0.0, 3.0], [1.0, 0.0, 0.0], [0.0, 0.02, 0.0]];
        assert_eq!(axes, Some(Directions::Patient(vectors)));
        let (spacing, _, notes) = read_lines("spacings: 1 2 3\nunits: \"mm\" cm \"\u{b5}m\"").unwrap();
        assert_eq!((spacing, notes.len()), ([1.0, 20.0, 0.003], 1));
        let (spacing, _, notes) = read_lines("spacings: 1 2 3\nunits: \"mm\" \"mm\" \"mm\"").unwrap();
        assert_eq!((spacing, notes.len()), ([1.0, 2.0, 3.0], 0));
        let (spacing, _, notes) = read_lines("spacings: 1 2 3\nunits: \"\" \"mm\" \"furlong\"").unwrap();
        assert_eq!(spacing, [1.0, 2.0, 3.0]);
        assert!(notes[0].contains("taken as mm"), "{notes:?}");
        assert!(read_lines("spacings: 1 2 3\nunits: \"mm\" \"mm\"").is_err());
        assert!(read_lines("spacings: 1 2 3\nunits: \"mm\" \"mm\" \"mm").is_err());
    }

    #[test]
    fn no_statement_is_one_and_is_told() {
        let (spacing, axes, notes) = read_lines("type: short").unwrap();
        assert_eq!((spacing, axes, notes.len()), ([1.0; 3], None, 1));
        assert!(read_lines("spacings: 1 1").is_err());
        assert!(read_lines("spacings: 1 1 x").is_err());
    }
}
