//! `slicecast hard`.

use std::path::PathBuf;

use comfy_table::CellAlignment;
use slicecast_laboratory::hard::{Case, Size, run};

use super::Failure;
use super::output::{check_free, write_file};
use super::progress::with_bar;
use super::tables::{page_header, paragraph, short};

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
    /// Does it.
    pub fn run(self) -> Result<(), Failure> {
        check_free(&self.json, self.force)?;
        let cases = with_bar("hard cases", |progress| run(Size::Full, progress))?;
        print(&cases, self.all);
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

fn print(cases: &[Case], all: bool) {
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
    println!("{table}\n");
    for case in cases {
        for (whose, says) in [("Squeeze", &case.paper), ("study", &case.study)] {
            if let Some(says) = says {
                let line = format!("{}: {}; {whose}: {says}", case.group, case.name);
                println!("{}", paragraph(&line, "  "));
            }
        }
    }
    println!();
    let shown = |case: &&Case| all || !case.outcomes.iter().any(|o| NAMED.contains(&o.who.as_str()));
    for case in cases.iter().filter(shown) {
        let heading = format!(
            "{}: {}; {}; theory: {} ({})",
            case.group,
            case.name,
            case.quantity,
            short(case.expected),
            case.theory
        );
        println!("{}", paragraph(&heading, "    "));
        for outcome in &case.outcomes {
            let limit = outcome
                .allowed
                .map_or(String::new(), |a| format!("   within {}", short(a)));
            println!("  {:<40} {:>12}{limit}", outcome.who, short(outcome.value));
        }
        if let Some(note) = &case.note {
            println!("{}", paragraph(&format!("  note: {note}"), "    "));
        }
    }
    for case in cases {
        for outcome in case.failures() {
            let line = format!(
                "FAILS: {}: {}: {}: {} instead of {} within {}",
                case.group,
                case.name,
                outcome.who,
                outcome.value,
                case.expected,
                outcome.allowed.unwrap_or(f64::NAN)
            );
            println!("{}", paragraph(&line, "  "));
        }
    }
}
