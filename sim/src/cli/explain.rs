//! `slicecast explain`.

use std::path::PathBuf;

use slicecast_compare::explain::{ExplainError, Explanation, Sample, Values, explain, ray_of};
use slicecast_compare::stages::Stage;
use slicecast_engine::frame::Prepared;

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs};
use super::output::{check_free, write_file};
use super::tables::{page_header, paragraph, short};

impl From<ExplainError> for Failure {
    fn from(error: ExplainError) -> Self {
        match error {
            ExplainError::Render(error) => error.into(),
            _ => Self::input(error),
        }
    }
}

/// `X,Y`.
fn pair(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(',').and_then(|(x, y)| {
        let number = |text: &str| text.trim().parse().ok();
        Some([number(x)?, number(y)?])
    });
    parsed.ok_or_else(|| "expected two numbers like 120,64".into())
}

/// Explain a pixel: every sample of its ray, every stage, fixed and f64, and where the final error came from.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast explain --pixel 120,90
  slicecast explain scan.nrrd --scene ct-bone --precision paper --ray 150,80 --csv ray.csv")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// The pixel of the picture; the ray nearest to it is explained.
    #[arg(long, value_name = "X,Y", value_parser = pair, required_unless_present = "ray")]
    pixel: Option<[u32; 2]>,
    /// The ray itself, as a pixel of the base plane.
    #[arg(long, value_name = "U,V", value_parser = pair, conflicts_with = "pixel")]
    ray: Option<[u32; 2]>,
    /// Print every sample, not only those that were folded into the pixel.
    #[arg(long)]
    all: bool,
    /// Write every sample and stage as CSV.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write everything as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// What the columns of stages mean.
const ERRORS: &str = "Errors of stages against the f64 model from the beginning, ulp of the stage's format. place: the \
                      sample's position; T, C: transparency and colour of the pixel so far.";

impl Args {
    /// Explains the pixel.
    pub fn run(self) -> Result<(), Failure> {
        check_free([&self.csv, &self.json].into_iter().flatten(), self.force)?;
        let loaded = self.volume.load()?;
        let scene = self.scene.load_for(&self.volume, &loaded)?;
        let prepared = Prepared::new(&scene, &loaded.volume)?;
        prepared.check_points()?;
        prepared.check_staged()?;
        prepared.check_unmodulated()?;
        let ray = match (self.pixel, self.ray) {
            (Some(pixel), _) => ray_of(&prepared, pixel)?,
            (None, Some(ray)) => ray.map(|c| c as usize),
            (None, None) => return Err(Failure::input("expected --pixel X,Y or --ray U,V")),
        };
        let explanation = explain(&prepared, ray)?;
        self.print(&explanation, scene.precision.name());
        if let Some(path) = &self.csv {
            write_file(path, self.force, &csv(&explanation)?)?;
        }
        if let Some(path) = &self.json {
            let json = serde_json::to_vec_pretty(&explanation).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        Ok(())
    }

    fn print(&self, explanation: &Explanation, precision: &str) {
        let [u, v] = explanation.ray;
        let folded = explanation.samples.iter().filter(|sample| sample.folded).count();
        println!(
            "ray {u},{v} of the base plane, {precision}: {} samples in the volume, {folded} folded\n",
            explanation.samples.len()
        );
        if explanation.samples.is_empty() {
            println!("No sample of this ray lies in the volume: it shows the background.");
            return;
        }
        if folded == 0 && !self.all {
            println!("Nothing on this ray is visible: it shows the background. --all lists its samples.");
            return;
        }
        let shown = || explanation.samples.iter().filter(|sample| self.all || sample.folded);
        let mut table = page_header(&["plane", "sample", "f64", "opacity", "f64"]);
        for sample in shown() {
            let mut cells = vec![sample.plane.to_string()];
            for stage in [Stage::Interpolation, Stage::Opacity] {
                let values = find(sample, stage);
                let number = |value: Option<&f64>| value.map_or("-".into(), |value| format!("{value:.6}"));
                cells.push(number(values.and_then(|values| values.fixed.first())));
                cells.push(number(values.and_then(|values| values.exact.first())));
            }
            table.add_row(cells);
        }
        println!("{table}");
        println!("\nSamples: codes, 0 to 4095; opacities: of one step, 0 to 1.\n");
        let any = |stage: &Stage| explanation.samples.iter().any(|sample| find(sample, *stage).is_some());
        let stages: Vec<Stage> = Stage::ALL.into_iter().filter(any).collect();
        let heads: Vec<&str> = stages.iter().map(|stage| stage.head()).collect();
        let mut table = page_header(&[&["plane"], &heads[..]].concat());
        for sample in shown() {
            let error = |stage: &Stage| find(sample, *stage).map_or("-".into(), |values| short(values.error_ulp));
            let mut cells = vec![sample.plane.to_string()];
            cells.extend(stages.iter().map(error));
            table.add_row(cells);
        }
        println!("{table}");
        println!("\n{}\n", paragraph(ERRORS, ""));
        let mut table = page_header(&["error came from", "red", "green", "blue"]);
        for share in &explanation.shares {
            let mut cells = vec![share.stage.to_owned()];
            cells.extend(share.lsb8.map(|value| format!("{value:+.5}")));
            table.add_row(cells);
        }
        let difference = |c: usize| 255.0 * (explanation.fixed[c] - explanation.exact[c]);
        let mut total = vec!["all together".to_owned()];
        total.extend([0, 1, 2].map(|c| format!("{:+.5}", difference(c))));
        table.add_row(total);
        println!("{table}");
        println!("\nSteps of 1/255: the change of the pixel when this stage's results, too, are the pipeline's.");
        let line = |who: &str, pixel: [f64; 4]| {
            let [r, g, b, t] = pixel;
            println!(
                "{who}: {:.6} {:.6} {:.6}, transparency {t:.6} (steps of 1/255; 1)",
                255.0 * r,
                255.0 * g,
                255.0 * b
            );
        };
        line("pipeline", explanation.fixed);
        line("f64     ", explanation.exact);
    }
}

/// What a sample has of a stage.
fn find(sample: &Sample, stage: Stage) -> Option<&Values> {
    sample.stages.iter().find(|values| values.stage == stage.name())
}

/// A line per sample, stage and component.
fn csv(explanation: &Explanation) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = [
        "plane",
        "folded",
        "stage",
        "component",
        "fixed",
        "f64",
        "stage error ulp",
    ];
    writer.write_record(head).map_err(Failure::machine)?;
    for sample in &explanation.samples {
        for values in &sample.stages {
            for (component, (fixed, exact)) in values.fixed.iter().zip(&values.exact).enumerate() {
                let line = [
                    sample.plane.to_string(),
                    u8::from(sample.folded).to_string(),
                    values.stage.to_owned(),
                    component.to_string(),
                    fixed.to_string(),
                    exact.to_string(),
                    values.error_ulp.to_string(),
                ];
                writer.write_record(line).map_err(Failure::machine)?;
            }
        }
    }
    writer.into_inner().map_err(Failure::machine)
}
