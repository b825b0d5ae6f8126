//! Pictures that show nothing: found, and explained.

use crate::projection;
use slicecast::format::Opacity;
use slicecast_engine::fineness::{self, Finest};
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::{BaseImage, Frame, Rgb};
use slicecast_scene::{Blend, Borders, Classification, PrecisionName};
use slicecast_volume::statistics::Statistics;

/// Steps of 1/255 that a pixel has to differ from the background by to be seen.
const SEEN: u8 = 8;

/// The least share of the volume's place in the picture that has to be seen.
const SHARE_MIN: f64 = 0.01;

/// What is known of a picture beside its scene and volume.
pub struct Circumstances<'a> {
    /// The volume's histogram.
    pub statistics: &'a Statistics,
    /// Whether the scene speaks of Hounsfield units and the volume's values are not known to be such.
    pub without_hounsfield: bool,
    /// The stock scene that fits the volume, unless it is the scene of the picture.
    pub fitting: Option<&'a str>,
}

/// Why nothing, or nearly nothing, of a picture is seen, or nothing but what lies around, and what to do; `None` if
/// something is.
pub fn warning(prepared: &Prepared<'_>, frame: &Frame, known: &Circumstances<'_>) -> Option<String> {
    let background = prepared.scene.image.background;
    let [origin, right, down] = prepared.setup.picture.affine;
    let place = |x: usize, y: usize| [0, 1].map(|axis| origin[axis] + x as f64 * right[axis] + y as f64 * down[axis]);
    let share = share(&frame.picture, background, |x, y| {
        let [u, v] = place(x, y);
        let [width, height] = frame.base.size.map(|side| side as f64);
        (0.0..width).contains(&u) && (0.0..height).contains(&v)
    });
    if share >= SHARE_MIN {
        return surrounded(prepared, known.statistics).or_else(|| beyond_fast(prepared, known.statistics));
    }
    let amount = if share == 0.0 { "nothing" } else { "nearly nothing" };
    let (reason, advice) = reason(prepared, &frame.base, known);
    Some(format!("the picture shows {amount}: {reason}; {advice}"))
}

/// The climb of an opacity from one code to the next, per step, that 16-bit lanes still follow.
const STEEPEST: f64 = 0.1;

/// The fewest codes of a lit volume of which samples of 12.3 still have the directions of gradients.
const FEWEST_CODES: usize = 256;

/// That a scene is outside of what `fast` does well (docs/contract/fast.md).
fn beyond_fast(prepared: &Prepared<'_>, statistics: &Statistics) -> Option<String> {
    if prepared.scene.precision != PrecisionName::Fast {
        return None;
    }
    let value = |code: usize| rounded(prepared.volume.mapping.value(code as f64), 5);
    let opacity = |code: usize| f64::from(prepared.table.opacity(code).to_bits()) / f64::from(Opacity::ONE.to_bits());
    let [first, last] = statistics.range();
    let climb = |code: &usize| (opacity(code + 1) - opacity(*code)).abs();
    let steepest = (first..last).max_by(|a, b| climb(a).total_cmp(&climb(b)));
    if let Some(code) = steepest.filter(|code| climb(code) > STEEPEST) {
        return Some(format!(
            "precision \"fast\" mixes roots of opacities, and the opacity of a step climbs by {:.2} from {} to {}, one code further, \
             where more than {STEEPEST} shows; `--precision compact` mixes opacities, more --planes make steps less opaque",
            climb(&code),
            value(code),
            value(code + 1)
        ));
    }
    let codes = last - first + 1;
    (prepared.setup.material.is_some() && codes < FEWEST_CODES).then(|| {
        format!(
            "precision \"fast\" has samples of an eighth of a code, and the volume has {codes} codes, too few for the directions of its \
             gradients; `--window` spreads its values over 4096, `--precision compact` has finer samples"
        )
    })
}

/// That a minimum shows the background alone, since nearly every ray crosses it.
fn surrounded(prepared: &Prepared<'_>, statistics: &Statistics) -> Option<String> {
    if prepared.scene.blend != Blend::Minimum {
        return None;
    }
    let first = statistics.split(0);
    let crossing = projection::in_background(prepared.volume, first)?;
    Some(format!(
        "the picture shows the background: {:.0} % of the rays cross it (values below {}), and it is the smallest value of \
         each; `--blend minimum` is for a volume cut to the inside of a body, as a piece of a lung, `--blend maximum` shows \
         what is bright",
        100.0 * crossing,
        rounded(prepared.volume.mapping.value(first as f64), 5)
    ))
}

/// The share of the pixels within a place that can be told from the background.
fn share(picture: &Rgb, background: [f64; 3], within: impl Fn(usize, usize) -> bool) -> f64 {
    let background = background.map(|channel| (channel * 255.0).round() as u8);
    let width = picture.size[0].max(1) as usize;
    let (mut seen, mut all) = (0_u64, 0_u64);
    for (index, pixel) in picture.bytes.chunks_exact(3).enumerate() {
        if within(index % width, index / width) {
            all += 1;
            let differs = |(channel, behind): (&u8, u8)| channel.abs_diff(behind) > SEEN;
            seen += u64::from(pixel.iter().zip(background).any(differs));
        }
    }
    seen as f64 / all.max(1) as f64
}

/// The reason and the advice, the more certain ones first.
fn reason(prepared: &Prepared<'_>, base: &BaseImage, known: &Circumstances<'_>) -> (String, String) {
    let (scene, volume) = (prepared.scene, prepared.volume);
    let statistics = known.statistics;
    let value = |code: usize| rounded(volume.mapping.value(code as f64), 5);
    let visible = |code: &usize| prepared.table.opacity(*code) > Opacity::ZERO;
    let fitting = known.fitting.map_or_else(
        || "`--scene fog` shows everything above the background".into(),
        |name| format!("`--scene {name}` fits the values"),
    );
    let codes = statistics.counts().len();
    let seen: u64 = (0..codes).filter(visible).map(|code| statistics.counts()[code]).sum();
    let all: u64 = statistics.counts().iter().sum();
    let [first, last] = statistics.range().map(value);

    if scene.borders == Borders::Whole
        && let Some(axis) = (0..3).find(|&axis| volume.dims[axis] == 1)
    {
        return (
            format!("one slice along {} has no thickness", ["x", "y", "z"][axis]),
            "`render` draws it as thick as its spacing".into(),
        );
    }
    if scene.classification == Classification::None
        && let Some(reason) = uncrossed(prepared, [first, last])
    {
        return reason;
    }
    if seen == 0 && prepared.table.underflows > 0 {
        return (too_thin(prepared), unit_distance(prepared));
    }
    if seen == 0 {
        let shown = match ((0..codes).find(visible), (0..codes).rev().find(visible)) {
            (Some(low), Some(high)) => format!(
                "of the values that have a code it shows {} to {}",
                value(low),
                value(high)
            ),
            _ => "it makes every value that has a code transparent".into(),
        };
        let table = if known.without_hounsfield {
            "this scene is for Hounsfield units, which the file does not have"
        } else {
            "the transfer function is for others"
        };
        return (
            format!("no value between {first} and {last} is visible, {table}: {shown}"),
            fitting,
        );
    }
    let one = f64::from(base.one);
    let pixels = base.planes[3].len().max(1) as f64;
    let opacity = |t: &u32| 1.0 - f64::from(*t) / one;
    let thickest = base.planes[3].iter().map(opacity).fold(0.0, f64::max);
    let opaque = base.planes[3]
        .iter()
        .filter(|t| opacity(t) > f64::from(SEEN) / 255.0)
        .count() as f64
        / pixels;
    let coloured = (0..base.planes[3].len())
        .filter(|&pixel| {
            (0..3).any(|c| {
                let behind = scene.image.background[c];
                let seen = f64::from(base.planes[c][pixel]) / one - behind * opacity(&base.planes[3][pixel]);
                seen.abs() > f64::from(SEEN) / 255.0
            })
        })
        .count() as f64
        / pixels;

    if coloured >= SHARE_MIN {
        return (
            format!(
                "what is visible lies outside of the picture at a zoom of {}",
                scene.image.zoom
            ),
            "a smaller `--zoom` shows more".into(),
        );
    }
    if opaque >= SHARE_MIN {
        return (
            "what is opaque has the colour of the background, or no light falls on it".into(),
            "`--background`, `--light` and `--unlit` change that".into(),
        );
    }
    if !scene.blend.is_composited() {
        let kept = match scene.blend {
            Blend::Maximum => "largest",
            Blend::Minimum => "smallest",
            Blend::Average => "mean",
            _ => "summed",
        };
        return (
            format!("the {kept} value of nearly every ray is invisible under this transfer function"),
            "`--scene mip` has a grey ramp over the values that rays keep".into(),
        );
    }
    let cut = match (scene.clips.is_empty(), scene.crop) {
        (false, _) => Some(("the clip planes leave", "a normal the other way shows the other side")),
        (true, Some(_)) => Some(("the crop box leaves", "a larger `--crop` shows more")),
        (true, None) => None,
    };
    if let Some((what, advice)) = cut.filter(|_| thickest == 0.0) {
        return (format!("{what} nothing of what is visible"), advice.into());
    }
    if thickest <= f64::from(SEEN) / 255.0 {
        return (too_thin(prepared), unit_distance(prepared));
    }
    let [low, high] = [0.005, 0.995].map(|share| value(statistics.percentile(share)));
    let few = format!(
        "{seen} of {all} voxels have a visible value; 99 % of the voxels lie between {low} and {high}, all between {first} and {last}"
    );
    // A few outliers stretch the range of the codes.
    if high - low < (last - first) / 8.0 {
        (few, "`--window 0.5,99.5%` leaves the outliers aside".into())
    } else {
        (few, fitting)
    }
}

/// Why surfaces alone show nothing, if it is their values or their opacities.
fn uncrossed(prepared: &Prepared<'_>, [first, last]: [f64; 2]) -> Option<(String, String)> {
    let visible = || prepared.scene.surfaces.iter().filter(|surface| surface.is_visible());
    if visible().next().is_none() {
        return Some((
            "every surface has an opacity of 0 on both sides".into(),
            "`opacity` and `back_opacity` change that".into(),
        ));
    }
    let (low, high) = (first.min(last), first.max(last));
    if visible().any(|surface| low < surface.value && surface.value <= high) {
        return None;
    }
    let values: Vec<_> = visible().map(|surface| surface.value.to_string()).collect();
    Some((
        format!(
            "no ray crosses a surface of value {}: all values lie between {first} and {last}",
            values.join(", ")
        ),
        "`slicecast inspect` shows where they lie".into(),
    ))
}

/// A number of so many digits, for people to read.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1))
        .parse()
        .unwrap_or(value)
}

fn too_thin(prepared: &Prepared<'_>) -> String {
    let volume = prepared.volume;
    let sides = [0, 1, 2].map(|axis| volume.dims[axis] as f64 * volume.spacing[axis]);
    let across = sides.iter().map(|side| side * side).sum::<f64>().sqrt();
    format!(
        "opacities are meant for a length of {}, and the volume is {} from corner to corner",
        prepared.scene.transfer.unit_distance,
        rounded(across, 5)
    )
}

fn unit_distance(prepared: &Prepared<'_>) -> String {
    let shortest = prepared.volume.spacing.iter().copied().fold(f64::INFINITY, f64::min);
    format!("`--unit-distance {}` means them for one voxel", rounded(shortest, 5))
}

/// Says that a transfer function is finer than the field, and what is done about it; what `auto` has chosen in any case.
pub fn fineness(prepared: &Prepared<'_>) -> Option<String> {
    let (scene, segments) = (prepared.scene, prepared.segments.is_some());
    match scene.classification {
        Classification::Integral | Classification::None => return None,
        Classification::Auto if !scene.surfaces.is_empty() => {
            return Some("classification: integral; surfaces cut segments".into());
        }
        Classification::Auto | Classification::Point => {}
    }
    let finest = match scene.classification {
        Classification::Auto => prepared.finest,
        // Not worth so many small reads of a volume on disk.
        _ if prepared.volume.voxels.is_empty() => None,
        _ => fineness::of(scene, prepared.volume, prepared.volume).ok().flatten(),
    };
    let facts = |Finest {
                     codes,
                     width,
                     difference,
                 }: Finest| {
        let [low, high] = codes.map(|code| prepared.volume.mapping.value(f64::from(code)));
        let codes = if width == 1.0 { "code" } else { "codes" };
        let difference = rounded(difference, 3);
        format!(
            "at {low} to {high} the transfer function has a peak {width} {codes} wide, and neighbouring samples differ by {difference}"
        )
    };
    match (scene.classification, finest) {
        (Classification::Auto, None) => Some("classification: point; the transfer function has no narrow peak".into()),
        (Classification::Auto, Some(finest)) => {
            let chosen = if segments { "integral" } else { "point" };
            Some(format!("classification: {chosen}; {}", facts(finest)))
        }
        (_, Some(finest)) if finest.is_missed() => {
            let facts = facts(finest);
            Some(format!(
                "{facts}: some is stepped over; --classification integral sees all of it"
            ))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_engine::frame::Layer;
    use slicecast_scene::clip::Clip;
    use slicecast_scene::crop::Crop;
    use slicecast_scene::file::built_in;
    use slicecast_scene::{Image, Scene};
    use slicecast_volume::{Mapping, Volume};

    /// A ball of 200 HU in air.
    fn ball() -> Volume {
        let voxel = |index: usize| {
            let place = [index % 24, index / 24 % 24, index / 576].map(|c| c as f64 - 11.5);
            let radius = place.iter().map(|c| c * c).sum::<f64>().sqrt();
            if radius < 9.0 { 1224 } else { 24 }
        };
        Volume {
            name: "ball".into(),
            dims: [24; 3],
            spacing: [1.0; 3],
            voxels: (0..24 * 24 * 24).map(voxel).collect(),
            mapping: Mapping {
                scale: 1.0,
                offset: -1024.0,
            },
        }
    }

    fn scene() -> Scene {
        built_in("ct-soft-tissue").unwrap()
    }

    fn said(scene: &Scene, volume: &Volume) -> Option<String> {
        said_where(scene, volume, Some("mr"))
    }

    fn said_where(scene: &Scene, volume: &Volume, fitting: Option<&str>) -> Option<String> {
        let statistics = Statistics::of(volume);
        let prepared = Prepared::new(scene, volume).unwrap();
        let frame = prepared.render(Layer::Tiles(8), &|_, _| {}).unwrap();
        let known = Circumstances {
            statistics: &statistics,
            without_hounsfield: false,
            fitting,
        };
        warning(&prepared, &frame, &known)
    }

    fn says(scene: &Scene, volume: &Volume, parts: &[&str]) {
        let text = said(scene, volume).unwrap_or_default();
        for part in parts {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn what_is_seen_needs_no_word() {
        assert_eq!(said(&scene(), &ball()), None);
        // Nor a small picture of the same.
        let mut small = scene();
        small.image.zoom = 0.05;
        small.image.size = Some([600, 600]);
        assert_eq!(said(&small, &ball()), None);
    }

    #[test]
    fn values_that_the_table_hides() {
        let bone = built_in("ct-bone").unwrap();
        let mut volume = ball();
        volume.voxels.iter_mut().for_each(|code| *code = (*code).min(1100));
        says(
            &bone,
            &volume,
            &[
                "shows nothing: no value between -1000 and 76 is visible",
                "`--scene mr` fits the values",
            ],
        );
        // The scene that fits is no advice to its own picture.
        let text = said_where(&bone, &volume, None).unwrap();
        assert!(
            text.ends_with("; `--scene fog` shows everything above the background"),
            "{text}"
        );
    }

    #[test]
    fn opacities_for_another_length() {
        let mut volume = ball();
        volume.spacing = [1e-3; 3];
        let parts = ["opacities are meant for a length of 1,", "`--unit-distance 0.001`"];
        says(&scene(), &volume, &parts);
        volume.spacing = [1e-9; 3];
        says(&scene(), &volume, &["`--unit-distance 0.000000001`"]);
    }

    #[test]
    fn everything_cut_away() {
        let mut scene = scene();
        scene.clips = vec![Clip::new([99.0, 0.0, 0.0], [1.0, 0.0, 0.0])];
        says(
            &scene,
            &ball(),
            &[
                "the clip planes leave nothing of what is visible",
                "a normal the other way",
            ],
        );
        scene.clips.clear();
        scene.crop = Some(Crop::parse(":2,:2,:2").unwrap());
        says(
            &scene,
            &ball(),
            &["the crop box leaves nothing of what is visible", "a larger `--crop`"],
        );
    }

    #[test]
    fn one_slice_has_no_thickness() {
        let mut scene = scene();
        scene.borders = Borders::Whole;
        let mut volume = ball();
        volume.voxels.drain(..24 * 24 * 11);
        volume.voxels.truncate(24 * 24);
        volume.dims[2] = 1;
        says(&scene, &volume, &["one slice along z has no thickness"]);
    }

    #[test]
    fn colours_of_the_background() {
        let mut scene = scene();
        scene.lighting = None;
        scene.image = Image {
            background: [0.5; 3],
            ..Image::default()
        };
        scene
            .transfer
            .points
            .iter_mut()
            .for_each(|point| point.colour = [0.5; 3]);
        says(&scene, &ball(), &["has the colour of the background", "`--background`"]);
    }

    #[test]
    fn rays_that_keep_invisible_values() {
        let mut scene = scene();
        scene.blend = Blend::Minimum;
        says(
            &scene,
            &ball(),
            &["the smallest value of nearly every ray is invisible"],
        );
    }

    /// A grey picture of the air around the ball is not empty, and shows nothing of the ball.
    #[test]
    fn smallest_values_of_rays_through_air() {
        let mut scene = scene();
        scene.blend = Blend::Minimum;
        scene.transfer = crate::projection::ramp(&ball(), &ball(), Blend::Minimum).unwrap();
        scene.lighting = None;
        says(
            &scene,
            &ball(),
            &["shows the background: 100 % of the rays cross it", "(values below "],
        );
        scene.blend = Blend::Maximum;
        scene.transfer = crate::projection::ramp(&ball(), &ball(), Blend::Maximum).unwrap();
        assert_eq!(said(&scene, &ball()), None);
    }

    #[test]
    fn outliers_stretch_the_range() {
        let mut volume = ball();
        // A range of a million with one voxel at its end.
        volume.voxels.iter_mut().for_each(|code| *code /= 1000);
        volume.voxels[7000] = 4095;
        volume.mapping = Mapping {
            scale: 1.0,
            offset: 0.0,
        };
        let parts = ["nearly nothing: 1 of 13824 voxels", "`--window 0.5,99.5%`"];
        says(&built_in("ct-bone").unwrap(), &volume, &parts);
    }

    #[test]
    fn a_zoom_into_the_hollow() {
        let mut volume = ball();
        let inside = |index: usize| {
            let place = [index % 24, index / 24 % 24, index / 576].map(|c| c as f64 - 11.5);
            // Nothing but the eight corners.
            place.iter().all(|c| c.abs() > 8.0)
        };
        for (index, code) in volume.voxels.iter_mut().enumerate() {
            *code = if inside(index) { 1224 } else { 24 };
        }
        let mut scene = scene();
        assert_eq!(said(&scene, &volume), None);
        scene.image.zoom = 8.0;
        says(&scene, &volume, &["outside of the picture at a zoom of 8", "`--zoom`"]);
    }
}
