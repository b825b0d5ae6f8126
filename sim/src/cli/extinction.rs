//! `slicecast extinction`.

use serde::Serialize;
use slicecast_pyramid::figures::filters::{self, Best, OfLevels, Pair};
use slicecast_pyramid::figures::layers::{self, Kept, Thin};
use slicecast_pyramid::figures::points::{self, Point, Points};
use slicecast_pyramid::figures::rays::{self, Layer, Wall};

use super::Failure;
use super::output::JsonArgs;
use super::tables::header;

/// Remake the figures of Kraus and Bürger: sampling and filtering by extinctions, beside the same by opacities.
///
/// Rays through a layer (figures 1 and 4), a wall (5 and 6), a scattered voxel (7), what levels of a pyramid keep (2 and 3, section 4.1), and how far
/// a filter is from a convolution (section 4.2).
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast extinction
  slicecast extinction --json extinction.json")]
pub struct Args {
    #[command(flatten)]
    json: JsonArgs,
}

/// All of them.
#[derive(Serialize)]
struct All {
    layers: Vec<Layer>,
    walls: Vec<Wall>,
    points: Vec<Points>,
    kept: Vec<Kept>,
    thin: Vec<Thin>,
    filters: Vec<filters::Figures>,
    by_levels: Vec<OfLevels>,
    best: Vec<Best>,
}

impl Args {
    /// Prints the figures.
    pub fn run(self) -> Result<(), Failure> {
        self.json.check_free()?;
        let all = All {
            layers: rays::layers(),
            walls: rays::walls(),
            points: points::points(),
            kept: layers::figures(),
            thin: layers::thin(),
            filters: filters::figures(),
            by_levels: filters::by_levels(),
            best: filters::best(),
        };
        print_layers(&all.layers);
        print_walls(&all.walls);
        print_points(&all.points);
        print_kept(&all.kept);
        print_thin(&all.thin);
        print_filters(&all.filters);
        print_by_levels(&all.by_levels);
        print_best(&all.best);
        self.json.write(&all)
    }
}

fn print_layers(layers: &[Layer]) {
    println!("Figures 1 and 4: opacity of a ray across a layer, least to largest over all phases, by step d\n");
    let heads = layers.iter().flat_map(|layer| {
        let of = |way| format!("tau {} {way}", layer.tau_max);
        [of("opacity"), of("extinction")]
    });
    let heads: Vec<String> = std::iter::once("d".into()).chain(heads).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = header(&heads);
    for (n, cut) in layers.first().map_or(&[][..], |layer| &layer.cuts).iter().enumerate() {
        let cells = layers.iter().filter_map(|layer| layer.cuts.get(n)).flat_map(|cut| {
            [&cut.opacity, &cut.extinction].map(|spread| format!("{:.3} {:.3}", spread.least, spread.most))
        });
        table.add_row(std::iter::once(format!("{:.1}", cut.d)).chain(cells));
    }
    println!("{table}\n\nErrors over all phases: the largest, and the mean deviation\n");
    let mut table = header(&["tau", "exact", "d", "opacity", "extinction"]);
    for layer in layers {
        for errors in &layer.errors {
            let pair = |[most, mean]: [f64; 2]| format!("{most:.4} {mean:+.4}");
            table.add_row([
                layer.tau_max.to_string(),
                format!("{:.4}", layer.exact),
                format!("{} to {}", errors.steps[0], errors.steps[1]),
                pair(errors.opacity),
                pair(errors.extinction),
            ]);
        }
    }
    println!("{table}");
}

fn print_walls(walls: &[Wall]) {
    println!("\nFigures 5 and 6: the first step d at which a wall's opacity varies by more than a ripple\n");
    let mut table = header(&["tau", "ripple", "opacity", "extinction"]);
    for wall in walls {
        let step = |d: Option<f64>| d.map_or_else(|| "above 3".into(), |d| format!("{d:.2}"));
        table.add_row([
            wall.tau_max.to_string(),
            format!("{:.4}", wall.ripple),
            step(wall.opacity),
            step(wall.extinction),
        ]);
    }
    println!("{table}");
}

fn print_points(all: &[Points]) {
    println!(
        "\nFigure 7: an opaque voxel from 120 directions at d = 1: how its brightest pixel varies, its light, its shape\n"
    );
    let mut table = header(&["tau", "", "opacity", "extinction", "exact"]);
    type Share = fn(&Point) -> f64;
    let rows: [(&str, Share); 3] = [
        ("variation of the brightest pixel", |point| point.variation),
        ("light, of what is exact", |point| point.light),
        ("diagonal over side, at half", |point| point.roundness),
    ];
    for points in all {
        for (what, value) in rows {
            let cells =
                [&points.opacity, &points.extinction, &points.exact].map(|point| format!("{:.4}", value(point)));
            table.add_row([points.tau_max.to_string(), what.to_owned()].into_iter().chain(cells));
        }
    }
    println!("{table}");
}

fn print_kept(kept: &[Kept]) {
    println!("\nFigures 2 and 3, section 4.1: mean opacity along z, from the finest level on\n");
    let mut table = header(&["volume", "filter", "by extinction", "by opacity"]);
    for kept in kept {
        let list = |values: &[f64]| values.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(" ");
        let (what, filter) = (kept.what.to_owned(), kept.filter.name().to_owned());
        table.add_row([what, filter, list(&kept.extinction), list(&kept.opacity)]);
    }
    println!("{table}");
}

fn print_thin(thin: &[Thin]) {
    println!("\nMean code of thin matter, codes 0 to 5, from the finest level on\n");
    let mut table = header(&["filter", "carried", "rounded"]);
    for thin in thin {
        let list = |values: &[f64]| values.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(" ");
        table.add_row([thin.filter.name().to_owned(), list(&thin.carried), list(&thin.rounded)]);
    }
    println!("{table}");
}

fn pair([eps, eps0]: Pair) -> String {
    format!("{eps:.4} {eps0:.4}")
}

fn print_filters(all: &[filters::Figures]) {
    println!("\nSection 4.2: eps and eps0, how far sampling a pyramid is from a convolution\n");
    let mut table = header(&["sampling", "weights", "along a line", "in a picture", "the paper"]);
    for figures in all {
        let weights: Vec<String> = figures.weights.iter().map(f64::to_string).collect();
        table.add_row([
            figures.kernel.name().to_owned(),
            format!("({})/{}", weights.join(","), figures.weights.iter().sum::<f64>()),
            pair(figures.line),
            pair(figures.picture),
            figures
                .paper
                .map_or_else(|| "-".into(), |[eps, eps0]| format!("{eps} {eps0}")),
        ]);
    }
    println!("{table}");
}

fn print_by_levels(all: &[OfLevels]) {
    println!("\n(13,19,19,13)/64 under a quadratic B-spline, by levels\n");
    let mut table = header(&["levels", "along a line", "in a picture"]);
    for of in all {
        table.add_row([of.levels.to_string(), pair(of.line), pair(of.picture)]);
    }
    println!("{table}");
}

fn print_best(all: &[Best]) {
    println!("\nThe filter (a, 1/2 - a, 1/2 - a, a) with the smallest error\n");
    let mut table = header(&["sampling", "smallest", "of", "a", "eps, eps0"]);
    for best in all {
        table.add_row([
            best.kernel.name().to_owned(),
            best.of.to_owned(),
            if best.picture { "a picture" } else { "a line" }.to_owned(),
            format!("{:.3}", best.a),
            pair(best.errors),
        ]);
    }
    println!("{table}");
}
