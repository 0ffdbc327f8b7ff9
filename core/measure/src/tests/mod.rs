//! Tests on photographs that a small simulator draws.

mod faults;
mod frames;
mod left_out;
mod simulator;

use seidel_optics::error::ErrorKind;

use crate::lights::{LightSet, LightSettings, measure_lights};
use crate::rejection::Reason;
use crate::{Calibration, Photograph};
use simulator::{GAIN, Light, READ_NOISE, Simulator, grid};

fn measured(photographs: Vec<Photograph>) -> LightSet {
    measure_lights(
        photographs,
        &Calibration::default(),
        &LightSettings::default(),
    )
    .expect("lights")
}

fn reasons_at(set: &LightSet, light: Light) -> Vec<Reason> {
    let near = set.left_out.iter();
    near.filter(|l| (l.x - light.x).hypot(l.y - light.y) < 4.0)
        .map(|l| l.why)
        .collect()
}

fn nearest(set: &LightSet, light: Light) -> Option<usize> {
    (0..set.lights.len()).find(|k| {
        let [x, y] = set.lights[*k].place();
        (x - light.x).hypot(y - light.y) < 2.0
    })
}

#[test]
fn good_lights_are_kept_with_honest_errors_and_bad_ones_are_left_out_with_their_reason() {
    let mut simulator = Simulator::new(400, 300, 11);
    let good = grid(&mut simulator, 8, 6);
    for light in &good {
        simulator.add(*light);
    }
    // Between the lights of the grid.
    let at = |x: f64, y: f64, peak: f64| Light { x, y, peak };
    let clipped = at(101.3, 99.6, 3.0);
    let double = [at(201.0, 100.4, 0.3), at(207.5, 102.0, 0.2)];
    let faint = at(301.2, 100.0, 0.0015);
    let border = at(251.0, 2.2, 0.4);
    for light in [clipped, double[0], double[1], faint, border] {
        simulator.add(light);
    }
    let (photograph, defects) = simulator.expose(60);
    let set = measured(vec![photograph]);

    let found: Vec<(usize, Light)> = (good.iter())
        .filter_map(|light| Some((nearest(&set, *light)?, *light)))
        .collect();
    assert!(
        found.len() >= 46,
        "{} of 48: {:?}",
        found.len(),
        set.left_out
    );
    assert_eq!(set.lights.len(), found.len(), "no false light is kept");
    assert!(reasons_at(&set, clipped).contains(&Reason::Clipped));
    assert!(reasons_at(&set, double[0]).contains(&Reason::Double));
    assert!(reasons_at(&set, faint).contains(&Reason::Faint));
    assert!(reasons_at(&set, border).contains(&Reason::Border));
    let (mut covered, mut all) = (0, 0);
    for (index, light) in &found {
        for profile in set.lights[*index].profiles.iter().flatten() {
            for (got, want) in profile.centroid.iter().zip([light.x, light.y]) {
                let limit = 0.25_f64.max(4.0 * profile.centroid_sigma);
                assert!((got - want).abs() < limit, "{light:?} {profile:?}");
                all += 1;
                covered += usize::from((got - want).abs() < 1.96 * profile.centroid_sigma);
            }
        }
    }
    let share = covered as f64 / f64::from(all);
    assert!((0.88..=0.995).contains(&share), "{share}");
    // Hot pixels within a tile are left out of it, and not the light with them.
    let (mut hidden, mut within) = (0, 0);
    for defect in defects {
        let (x, y) = (defect % 400, defect / 400);
        for light in &set.lights {
            let (left, top) = light.corner;
            let (width, height) = light.size;
            if (left..left + width).contains(&x) && (top..top + height).contains(&y) {
                within += 1;
                let mask = light.mask.as_ref().expect("a mask where there is a defect");
                hidden += usize::from(!mask[(y - top) * width + x - left]);
            }
        }
    }
    assert!(
        within >= 10 && hidden * 10 >= within * 8,
        "{hidden} of {within}"
    );
    let sigma = set.lights[0].noise_sigma[1];
    let expected = GAIN * (READ_NOISE * READ_NOISE + 20.0).sqrt();
    assert!((sigma / expected - 1.0).abs() < 0.05, "{sigma} {expected}");
}

#[test]
fn tiles_are_the_pixels_of_the_photograph() {
    let mut simulator = Simulator::new(120, 90, 3);
    for light in grid(&mut simulator, 3, 2) {
        simulator.add(light);
    }
    let (photograph, _) = simulator.expose(0);
    let plane = photograph.planes[0].clone();
    let set = measured(vec![photograph]);
    let observations = set.observations(None).expect("a set");
    assert!(
        observations.faults().is_empty(),
        "{:?}",
        observations.faults()
    );
    for observation in &observations.observations {
        let (left, top) = observation.frame_corner().expect("on the grid");
        let tile = &observation.tiles[2];
        for (k, sample) in tile.samples().iter().enumerate() {
            let pixel = (top + k / tile.width()) * 120 + left + k % tile.width();
            assert_eq!(*sample, plane[pixel]);
        }
        let counted = observations.counted(observation, 0).expect("a mosaic");
        let share = counted.iter().filter(|c| **c).count() as f64 / counted.len() as f64;
        assert!((0.2..0.3).contains(&share), "{share}");
    }
}

#[test]
fn photographs_without_usable_lights_are_refused_with_the_reason() {
    let fails = |simulator: &mut Simulator| {
        let (photograph, _) = simulator.expose(0);
        let settings = LightSettings::default();
        measure_lights(vec![photograph], &Calibration::default(), &settings).expect_err("no light")
    };
    let error = fails(&mut Simulator::new(100, 80, 1));
    assert!(
        error.to_string().contains("no light above its noise"),
        "{error}"
    );
    assert_eq!(error.kind(), ErrorKind::InsufficientData);
    let mut bright = Simulator::new(100, 80, 1);
    bright.add(Light {
        x: 50.0,
        y: 40.0,
        peak: 4.0,
    });
    let error = fails(&mut bright);
    assert!(error.to_string().contains("1 clipped") && error.to_string().contains("expose less"));
    let mut simulator = Simulator::new(100, 80, 1);
    let (first, _) = simulator.expose(0);
    let (second, _) = Simulator::new(80, 80, 1).expose(0);
    let settings = LightSettings::default();
    let error = measure_lights(vec![first, second], &Calibration::default(), &settings)
        .expect_err("sizes differ");
    assert!(error.to_string().contains("80 x 80"), "{error}");
}
