//! The page, part by part.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Contents, machine, picture, plots};
use crate::ensemble::spread;
use crate::hard::Case;
use crate::pareto::{Place, places};
use crate::rows::Row;
use slicecast_compare::image::{ImageFigures, heat_map, model_picture};
use slicecast_engine::image::Rgb;

/// The difference that is white in a heat map, steps of 1/255: the next of 1, 2, 5, 10 ... above the largest, so that even
/// a good picture's errors can be seen.
fn heat_full(largest: f64) -> f64 {
    let decade = 10f64.powf(largest.max(1e-9).log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * decade);
    steps.into_iter().find(|step| *step >= largest).unwrap_or(10.0 * decade)
}

/// A number of things.
fn count(number: impl Into<u64>, thing: &str) -> String {
    match number.into() {
        1 => format!("1 {thing}"),
        number => format!("{number} {thing}s"),
    }
}

/// The page.
///
/// # Errors
/// A message if a picture or a plot cannot be made.
pub fn page(contents: &Contents<'_>) -> Result<String, String> {
    let title = format!("slicecast: {}, {}", name(contents), contents.scene_name);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("page.css"))) }
            }
            body {
                a.skip href="#main" { "To the contents" }
                header {
                    h1 { "Precision report" }
                    p.soft { "slicecast " (env!("CARGO_PKG_VERSION")) }
                }
                main id="main" {
                    (inputs(contents))
                    (pictures(contents)?)
                    (errors(contents))
                    (stages(contents)?)
                    (sweep(&contents.rows)?)
                    (hard(&contents.cases))
                }
                script { (PreEscaped(include_str!("page.js"))) }
            }
        }
    };
    Ok(page.into_string())
}

/// The volume's file, without the folders that it lay in.
fn name<'a>(contents: &'a Contents<'_>) -> std::borrow::Cow<'a, str> {
    let path = std::path::Path::new(&contents.prepared.volume.name);
    path.file_name().map_or("".into(), |name| name.to_string_lossy())
}

/// What was rendered, and on what.
fn inputs(contents: &Contents<'_>) -> Markup {
    let (volume, scene) = (contents.prepared.volume, contents.prepared.scene);
    let [nx, ny, nz] = volume.dims;
    let [sx, sy, sz] = volume.spacing;
    let plan = &contents.prepared.setup.plan;
    let [width, height] = plan.base();
    html! {
        section {
            h2 { "Inputs" }
            dl {
                dt { "volume" } dd { (name(contents)) ": " (nx) " x " (ny) " x " (nz) " voxels, spacing " (sx) " x " (sy) " x " (sz) }
                dt { "codes" } dd { (contents.mapping) }
                dt { "scene" }
                dd {
                    (contents.scene_name) ": azimuth " (scene.view.azimuth) "°, elevation " (scene.view.elevation) "°, "
                    (count(scene.sampling.planes_per_voxel, "plane")) " and " (count(scene.sampling.rays_per_voxel, "ray")) " a voxel, "
                    @match &scene.lighting {
                        Some(lighting) => { (count(lighting.lights.len() as u64, "light")) ", exponent " (1u32 << lighting.exponent_log2) }
                        None => { "unlit" }
                    }
                }
                dt { "base plane" } dd { (width) " x " (height) " pixels, " (count(plan.phases(), "phase")) ", " (count(plan.planes(), "plane")) }
                dt { "machine" } dd { (machine::describe()) }
            }
        }
    }
}

/// Fixed point, model, their difference.
fn pictures(contents: &Contents<'_>) -> Result<Markup, String> {
    let Some((name, comparison)) = contents.comparisons.get(contents.shown) else {
        return Ok(html! {});
    };
    let url = |picture: &Rgb| picture::data_url(picture).map_err(|error| error.to_string());
    let background = contents.prepared.scene.image.background;
    let fixed = url(&comparison.frame.picture)?;
    let model = url(&model_picture(&comparison.model_picture, background))?;
    let full = heat_full(comparison.image.max_lsb8);
    let heat = url(&heat_map(&comparison.frame.base, &comparison.model, full))?;
    Ok(html! {
        section {
            h2 { "Pictures" }
            figure {
                div.compare id="fixed-model" {
                    img src=(model) alt="The f64 model's picture.";
                    img src=(fixed) alt=(format!("The picture of {name}."));
                }
                div.slider {
                    label {
                        span.skip { "Border between the f64 model and fixed point, percent from the left" }
                        input type="range" min="0" max="100" value="50" data-compare="fixed-model"
                            aria-label="Border between the f64 model (left) and fixed point (right)";
                    }
                    div.ends { span { "all fixed point" } span { "all f64 model" } }
                }
                figcaption { "Left of the line the f64 model, right of it " (name) ". Drag, or focus the slider and use the arrow keys." }
            }
            div.pictures {
                figure { img src=(fixed) alt=(format!("The picture of {name}.")); figcaption { (name) ", fixed point" } }
                figure { img src=(model) alt="The f64 model's picture."; figcaption { "f64 model" } }
                figure {
                    img src=(heat) alt="Where the two differ.";
                    figcaption {
                        "Difference on the base plane: black none, white " (format!("{}", full as f32)) " of a step of 1/255"
                    }
                }
            }
        }
    })
}

/// A line of image figures.
fn figures(name: &str, f: &ImageFigures) -> Markup {
    html! {
        tr {
            td { (name) }
            td { (f.values) }
            td { (format!("{:.2}", f.equal_percent)) }
            td { (short(f.max_lsb8)) }
            td { (short(f.mean_lsb8)) }
            td { @match f.psnr_db { Some(db) => (format!("{db:.1}")), None => "exact" } }
        }
    }
}

/// Image errors, and their split.
fn errors(contents: &Contents<'_>) -> Markup {
    let head = html! {
        thead { tr { th { "8-bit values" } th { "values" } th { "equal %" } th { "max step" } th { "mean step" } th { "PSNR dB" } } }
    };
    html! {
        section {
            h2 { "Error of the picture" }
            p { "Premultiplied colours of the base plane, in steps of 1/255, against f64 of the same algorithm at the pipeline's positions." }
            div.scroll tabindex="0" role="region" aria-label="Errors by precision" {
                table {
                    (head)
                    tbody {
                        @for (name, comparison) in &contents.comparisons { (figures(name, &comparison.image)) }
                    }
                }
            }
            @if let (Some(split), Some((name, _))) = (&contents.split, contents.comparisons.get(contents.shown)) {
                h3 { "Arithmetic and algorithm" }
                p {
                    "The converged integral has no planes and no steps: what the f64 model differs from it is the error of the "
                    "algorithm, which more planes per voxel reduce and more bits do not."
                }
                div.scroll tabindex="0" role="region" aria-label="Error split in arithmetic and algorithm" {
                    table {
                        (head)
                        tbody {
                            (figures(&format!("arithmetic: {name}, f64"), &split.arithmetic))
                            @if let Some(table) = &split.table { (figures("table: f64 of its codes, f64 as written", table)) }
                            (figures("algorithm: f64, converged", &split.algorithm))
                            (figures(&format!("both: {name}, converged"), &split.both))
                        }
                    }
                }
            }
        }
    }
}

/// Errors stage by stage.
fn stages(contents: &Contents<'_>) -> Result<Markup, String> {
    let reports: Vec<_> = contents
        .comparisons
        .iter()
        .map(|(name, c)| (*name, c.stages.as_slice()))
        .collect();
    let plot = plots::stages(&reports, "Right bits of every stage by precision").map_err(|error| error.to_string())?;
    Ok(html! {
        section {
            h2 { "Error of every stage" }
            p {
                "Each stage on its own, already rounded inputs, against f64. The stroke across the bars is what Squeeze requires (its "
                "section 5). Carried: against f64 from the beginning. An ulp is one of the stage's own format."
            }
            ul.key {
                @for (place, (name, _)) in contents.comparisons.iter().enumerate() {
                    li { i style=(format!("--c: var(--series-{})", place + 1)) {} (name) }
                }
            }
            (PreEscaped(plot))
            div.scroll tabindex="0" role="region" aria-label="Errors of every stage" {
                table {
                    thead {
                        tr {
                            th { "stage" } th { "Squeeze, bits" }
                            @for (name, _) in &contents.comparisons { th { (name) ", bits" } th { "max ulp" } th { "carried ulp" } }
                        }
                    }
                    tbody {
                        @for stage in contents.comparisons.first().map_or(&[][..], |(_, c)| &c.stages) {
                            tr {
                                td { (stage.name) }
                                td { @match stage.required_bits { Some(bits) => (bits), None => "-" } }
                                @for (_, comparison) in &contents.comparisons {
                                    @if let Some(own) = comparison.stages.iter().find(|own| own.name == stage.name) {
                                        td.fails[own.meets_required == Some(false)] {
                                            @match own.local.bits { Some(bits) => (format!("{bits:.1}")), None => "exact" }
                                        }
                                        td { (short(own.local.max_ulp)) }
                                        td { (short(own.carried.max_ulp)) }
                                    } @else { td { "-" } td { "-" } td { "-" } }
                                }
                            }
                        }
                    }
                }
            }
        }
    })
}

/// Speed against error.
fn sweep(rows: &[Row]) -> Result<Markup, String> {
    if rows.is_empty() {
        return Ok(html! {});
    }
    let plot = plots::front(rows, "Speed against error of every configuration").map_err(|error| error.to_string())?;
    let marked = places(rows);
    let mut lanes: Vec<&str> = rows.iter().map(|row| row.lanes.as_str()).collect();
    lanes.dedup();
    let most = |of: fn(&Row) -> usize| rows.iter().map(of).max().unwrap_or(1) as u64;
    let views = count(most(|row| row.views.len()), "view");
    let threads = count(most(|row| row.threads), "thread");
    Ok(html! {
        section {
            h2 { "Speed against error" }
            p {
                "One point a configuration. On the line, and with a dot in the table: nothing is at least as fast and at least as exact in "
                "the mean, and clearly better in one of the two. Speeds that differ by no more than they scatter (±, at least "
                "1 %) are one speed; ~ would be on the line if they were exact. Errors are of " (views) ". Frames were timed on "
                (threads) " with " (lanes.join(", ")) ", each in turn with one of compact; speed is the median of their ratios. "
                "Tables have colours of 8 bits here, those of compact and wide too; above, these two have colours of 16 bits where "
                "the scene's change with the value."
            }
            (PreEscaped(plot))
            div.scroll tabindex="0" role="region" aria-label="All configurations" {
                table {
                    thead {
                        tr {
                            th { "configuration" } th { "bytes per pixel" } th { "table" } th { "equal %" } th { "max step" }
                            th { "mean step" } th { "spread of views" } th { "PSNR dB" } th { "Msamples/s" } th { "speed" } th { "± %" }
                        }
                    }
                    tbody {
                        @for (row, place) in rows.iter().zip(marked) {
                            tr.front[place == Place::Front] {
                                td { (row.name) @if place == Place::WithinSpread { " " (place.sign()) } }
                                td { (row.pixel_bytes) }
                                td { (row.table_bytes) }
                                td { (format!("{:.2}", row.image.equal_percent)) }
                                td { (short(row.image.max_lsb8)) }
                                td { (short(row.image.mean_lsb8)) }
                                td { (spread(&row.errors()).map_or("-".into(), short)) }
                                td { @match row.image.psnr_db { Some(db) => (format!("{db:.1}")), None => "exact" } }
                                td { (format!("{:.1}", row.samples_per_second / 1e6)) }
                                td { (format!("{:.2}", row.relative_speed)) }
                                td { @match row.speed_spread { Some(share) => (format!("{:.1}", 100.0 * share)), None => "-" } }
                            }
                        }
                    }
                }
            }
        }
    })
}

/// The hard cases.
fn hard(cases: &[Case]) -> Markup {
    if cases.is_empty() {
        return html! {};
    }
    html! {
        section {
            h2 { "Hard cases" }
            p {
                "What theory expects and what each precision gives. A verdict needs a limit; figures without one are there to be "
                "compared. Smaller volumes and fewer views than those of " code { "slicecast hard" } ", which takes longer."
            }
            div.scroll tabindex="0" role="region" aria-label="Hard cases" {
                table {
                    thead {
                        tr {
                            th { "case" } th.text { "figure" } th { "theory" } th { "paper" } th { "compact" } th { "wide" }
                            th.text { "verdict" } th.others { "others" } th.text { "Squeeze; study; note" }
                        }
                    }
                    tbody { @for case in cases { (hard_row(case)) } }
                }
            }
        }
    }
}

fn hard_row(case: &Case) -> Markup {
    let named = ["paper", "compact", "wide"];
    let remarks: Vec<&str> = [&case.paper, &case.study, &case.note]
        .into_iter()
        .filter_map(|text| text.as_deref())
        .collect();
    html! {
        tr {
            td { (case.group) ": " (case.name) }
            td.text { (case.quantity) }
            td { (short(case.expected)) }
            @for name in named {
                td { @match case.outcomes.iter().find(|o| o.who == name) { Some(o) => (short(o.value)), None => "-" } }
            }
            td.text.fails[!case.holds()] { @if case.holds() { "holds" } @else { "fails" } }
            td.others {
                @for outcome in case.outcomes.iter().filter(|o| !named.contains(&o.who.as_str())) {
                    (outcome.who) ": " (short(outcome.value)) br;
                }
            }
            td.text { (remarks.join("; ")) }
        }
    }
}

/// A figure in few characters.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !v.is_finite() => "never".into(),
        v if v < 0.001 => format!("{value:.1e}"),
        v if v < 10.0 => format!("{value:.3}"),
        v if v < 1000.0 => format!("{value:.1}"),
        v if v < 1e6 => format!("{value:.0}"),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn heat_maps_are_scaled_to_their_errors() {
        for (largest, full) in [(0.032, 0.05), (0.05, 0.05), (2.2, 5.0), (7.0, 10.0), (0.0, 1e-9)] {
            let found = super::heat_full(largest);
            assert!((found / full - 1.0).abs() < 1e-9, "{largest}: {found}");
        }
    }

    use super::*;
    use crate::rows::tests::row;
    use slicecast_compare::{ModelPositions, compare, split};
    use slicecast_engine::frame::Prepared;
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;

    /// The page is whole, holds what it says, and asks for nothing from outside.
    #[test]
    fn the_page_stands_alone() {
        let mut volume = load(None, Window::Auto).unwrap().volume;
        volume.name = "<head> & shoulders".into();
        let mut scene = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).unwrap();
        scene.sampling.planes_per_voxel = 1;
        scene.sampling.rays_per_voxel = 1;
        let prepared = Prepared::new(&scene, &volume).unwrap();
        let comparison = compare(&prepared, ModelPositions::Pipeline, &|_, _| ()).unwrap();
        let split = split(&prepared, &comparison, &|_, _| ()).unwrap();
        let contents = Contents {
            prepared: &prepared,
            scene_name: "headsq",
            mapping: "as they are".into(),
            comparisons: vec![("compact", comparison)],
            shown: 0,
            split: Some(split),
            rows: vec![row("compact", 1, 0.005, 1.0), row("paper", 0, 0.2, 1.5)],
            cases: crate::hard::location::cases(crate::hard::Size::Reduced),
        };
        let page = page(&contents).unwrap();
        assert!(page.contains("&lt;head&gt; &amp; shoulders") && !page.contains("<head> & shoulders"));
        assert_eq!(page.matches("data:image/png;base64,").count(), 5);
        assert_eq!(page.matches("<svg ").count(), 2);
        for part in [
            "Error of every stage",
            "Speed against error",
            "Hard cases",
            "converged",
            "drift: 2048 slices",
        ] {
            assert!(page.contains(part), "{part}");
        }
        // No address of another place: the only one is the name space of SVG.
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!outside.contains("http://") && !outside.contains("https://") && !outside.contains("url("));
    }
}
