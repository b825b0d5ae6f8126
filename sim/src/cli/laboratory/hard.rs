//! `slicecast hard`.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table};
use slicecast_laboratory::hard::{Case, Outcome, Size, run};

use crate::cli::Failure;
use crate::cli::output::{check_free, write_file};
use crate::cli::progress::with_bar;
use crate::cli::tables::{page_header, paragraph, short};

/// Run the hard cases: what theory expects, what each precision gives, and whether it keeps to its limit.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast hard
  slicecast hard --all --json hard.json")]
pub struct Args {
    /// Print every outcome, not only those of the named precisions.
    #[arg(long)]
    all: bool,
    /// Write the cases as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// The precisions that have columns of their own.
const NAMED: [&str; 3] = ["paper", "compact", "wide"];

impl Args {
    /// Runs the hard cases.
    pub fn run(self) -> Result<(), Failure> {
        check_free(&self.json, self.force)?;
        let cases = with_bar("hard cases", |progress| run(Size::Full, progress))?;
        println!("{}", page(&cases, self.all));
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(&cases).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        let broken = cases.iter().filter(|case| !case.holds()).count();
        if broken > 0 {
            return Err(Failure::machine(format!("{broken} cases do not keep to their limits")));
        }
        Ok(())
    }
}

/// The cases as a page: the table, what others say, every outcome that has no column, and what fails.
fn page(cases: &[Case], all: bool) -> String {
    let told = cases.iter().filter_map(|case| {
        let said = [("Squeeze", &case.paper), ("study", &case.study)];
        let said = said.map(|(whose, says)| says.as_ref().map(|says| format!("; {whose}: {says}")));
        let said = said.into_iter().flatten().collect::<String>();
        let line = format!("{}: {}{said}", case.group, case.name);
        (!said.is_empty()).then(|| paragraph(&line, "  "))
    });
    let shown = |case: &&Case| all || !case.outcomes.iter().all(|o| NAMED.contains(&o.who.as_str()));
    let parts = [
        table(cases).to_string(),
        told.collect::<Vec<_>>().join("\n"),
        cases.iter().filter(shown).map(outcomes).collect::<Vec<_>>().join("\n"),
        cases.iter().flat_map(failures).collect::<Vec<_>>().join("\n"),
    ];
    let parts = parts.into_iter().filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("\n\n")
}

fn table(cases: &[Case]) -> Table {
    let mut columns = vec!["case", "figure", "theory"];
    columns.extend(NAMED);
    columns.push("verdict");
    let mut table = page_header(&columns);
    if let Some(figure) = table.column_mut(1) {
        figure.set_cell_alignment(CellAlignment::Left);
    }
    for case in cases {
        let mut cells = vec![
            format!("{}: {}", case.group, case.name),
            case.quantity.to_owned(),
            short(case.expected),
        ];
        for name in NAMED {
            let outcome = case.outcomes.iter().find(|outcome| outcome.who == name);
            cells.push(outcome.map_or("-".into(), |outcome| short(outcome.value)));
        }
        cells.push(if case.holds() { "holds" } else { "FAILS" }.into());
        table.add_row(cells);
    }
    table
}

/// Every outcome of a case.
fn outcomes(case: &Case) -> String {
    let heading = format!(
        "{}: {}; {}; theory: {} ({})",
        case.group,
        case.name,
        case.quantity,
        short(case.expected),
        case.theory
    );
    let mut lines = vec![paragraph(&heading, "    ")];
    for outcome in &case.outcomes {
        let limit = outcome
            .allowed
            .map_or(String::new(), |a| format!("   within {}", short(a)));
        lines.push(format!("  {:<40} {:>12}{limit}", outcome.who, short(outcome.value)));
    }
    if let Some(note) = &case.note {
        lines.push(paragraph(&format!("  note: {note}"), "    "));
    }
    lines.join("\n")
}

/// What does not keep to its limits.
fn failures(case: &Case) -> Vec<String> {
    let line = |outcome: &Outcome| {
        let line = format!(
            "FAILS: {}: {}: {}: {} instead of {} within {}",
            case.group,
            case.name,
            outcome.who,
            outcome.value,
            case.expected,
            outcome.allowed.unwrap_or(f64::NAN)
        );
        paragraph(&line, "  ")
    };
    case.failures().into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_fits_the_page() {
        let cases = run(Size::Reduced, &|_, _| ()).unwrap();
        for all in [false, true] {
            let page = page(&cases, all);
            for line in page.lines() {
                assert!(line.chars().count() <= 100, "{line}");
            }
            // What has no column of its own is still told.
            for case in &cases {
                assert!(page.contains(case.group), "{}", case.group);
                let said = case.paper.as_deref().and_then(|says| says.split(' ').next());
                assert!(said.is_none_or(|word| page.contains(word)), "{}", case.name);
            }
        }
    }
}
