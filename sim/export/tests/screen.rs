//! The warp of a view in integers, as devices make it, beside the host's, which is made in f64: how far they are apart.

use slicecast::format::Step;
use slicecast::screen::Screen;
use slicecast_engine::camera::{extent, fitting_pixel, set_up};
use slicecast_scene::file::built_in;
use slicecast_volume::{Mapping, Volume};

#[test]
fn warps_of_devices_are_the_hosts_but_for_low_bits() {
    let volume = Volume {
        name: "t".into(),
        dims: [64, 64, 93],
        spacing: [3.2, 3.2, 1.5],
        voxels: Vec::new(),
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    };
    let mut scene = built_in("headsq").unwrap();
    let size = [720, 480];
    scene.image.size = Some(size);
    for azimuth in (-180..180).step_by(37) {
        for elevation in (-90..=90).step_by(30) {
            scene.view = slicecast_scene::View {
                azimuth: azimuth.into(),
                elevation: elevation.into(),
                roll: f64::from(azimuth) / 3.0,
            };
            let setup = set_up(&scene, &volume).unwrap();
            let pixel = fitting_pixel(extent(&scene, volume.dims, volume.spacing), size);
            let voxels = |axis: [f64; 3], sign: f64| {
                let exact = [0, 1, 2].map(|a| sign * axis[a] * pixel / volume.spacing[a]);
                exact.map(|c| Step::from_bits((c * 4_294_967_296.0).round() as i64))
            };
            let axes = scene.view.axes();
            let screen = Screen {
                size,
                right: voxels(axes.right, 1.0),
                down: voxels(axes.up, -1.0),
            };
            let (device, host) = (screen.warp(&setup.plan).unwrap(), setup.picture.warp);
            let rays = i64::from(setup.plan.sampling().rays_per_voxel);
            for [x, y] in [[0, 0], [719, 0], [0, 479], [719, 479]] {
                let apart = [0, 1].map(|a| (device.exact(x, y)[a] - host.exact(x, y)[a]).abs());
                // In units of 2^-33: the bounds of both (docs/contract/warp.md), and n for each of R's and D's own roundings.
                let (from_middle, from_corner) = (360 + 240, i64::from(x + y));
                let bound = from_middle * (1 + 2 * rays) + rays * 93 + from_corner + 2;
                assert!(
                    apart.iter().all(|c| 2 * c <= bound),
                    "{:?} {x} {y}: {apart:?} {bound}",
                    scene.view
                );
            }
        }
    }
}
