//! Lights that are left out, or kept, one by one: dust without a flat frame, sloping backgrounds, and the user's own choice.

use super::simulator::{Light, Simulator, grid};
use super::{nearest, reasons_at};
use crate::lights::{LightSet, LightSettings, measure_lights};
use crate::rejection::Reason;
use crate::{Calibration, Photograph};

const WIDTH: usize = 240;

/// Returns a photograph of 20 lights, and the lights.
fn lights(seed: u64) -> (Photograph, Vec<Light>) {
    let mut simulator = Simulator::new(WIDTH, 180, seed);
    let lights = grid(&mut simulator, 5, 4);
    for light in &lights {
        simulator.add(*light);
    }
    (simulator.expose(0).0, lights)
}

/// Adds `level` counts and darkens a disc by 30 %.
fn dusty(photograph: &mut Photograph, level: f32, [x, y]: [f64; 2], radius: f64) {
    for (index, value) in photograph.planes[0].iter_mut().enumerate() {
        let (column, row) = ((index % WIDTH) as f64 + 0.5, (index / WIDTH) as f64 + 0.5);
        *value += level;
        if (column - x).hypot(row - y) < radius {
            *value *= 0.7;
        }
    }
}

fn measured(photograph: &Photograph, settings: &LightSettings) -> LightSet {
    measure_lights(vec![photograph.clone()], &Calibration::default(), settings).expect("lights")
}

fn is_sound(set: &LightSet) -> bool {
    set.observations(None).expect("a set").faults().is_empty()
}

#[test]
fn dust_beside_a_light_is_masked_and_dust_on_it_leaves_it_out() {
    let (mut photograph, all) = lights(21);
    let light = all[7];
    dusty(&mut photograph, 600.0, [light.x + 23.0, light.y], 8.0);
    let set = measured(&photograph, &LightSettings::default());
    assert!(is_sound(&set));
    assert_eq!(reasons_at(&set, light), []);
    let kept = &set.lights[nearest(&set, light).expect("kept")];
    let mask = kept.mask.as_ref().expect("a mask over the dust");
    let row = light.y as usize - kept.corner.1;
    // The last pixel of the row through the light.
    assert!(!mask[(row + 1) * kept.size.0 - 1] && mask[row * kept.size.0]);

    let (mut photograph, _) = lights(21);
    dusty(&mut photograph, 600.0, [light.x + 7.0, light.y], 6.0);
    let set = measured(&photograph, &LightSettings::default());
    assert!(is_sound(&set));
    assert_eq!(reasons_at(&set, light), [Reason::Dust]);
    assert!(set.lights.len() >= 17, "{:?}", set.left_out);
}

#[test]
fn a_sloping_background_is_taken_off_the_tiles() {
    let (mut photograph, lights) = lights(23);
    for (index, value) in photograph.planes[0].iter_mut().enumerate() {
        *value += 3.0 * (index % WIDTH) as f32;
    }
    let set = measured(&photograph, &LightSettings::default());
    assert!(
        is_sound(&set) && set.lights.len() >= 18,
        "{:?}",
        set.left_out
    );
    let observations = set.observations(None).expect("a set");
    let kept = nearest(&set, lights[6]).expect("kept");
    let observation = &observations.observations[kept];
    let tile = observation.light(1);
    // The outermost columns, which hold background alone.
    let column = |x: usize| {
        let pixels = (0..tile.height()).map(|y| f64::from(tile.samples()[y * tile.width() + x]));
        pixels.sum::<f64>() / tile.height() as f64
    };
    let (left, right) = (column(0), column(tile.width() - 1));
    assert!((left - right).abs() < 4.0, "{left} {right}");
}

#[test]
fn numbers_choose_lights_whatever_the_checks_say() {
    let (photograph, lights) = lights(25);
    let set = measured(&photograph, &LightSettings::default());
    let number_at = |light: Light| set.lights[nearest(&set, light).expect("kept")].number;
    let (first, second) = (number_at(lights[3]), number_at(lights[11]));
    let settings = LightSettings {
        leave_out: vec![first],
        min_snr: 1e6,
        keep: vec![second],
        ..LightSettings::default()
    };
    let chosen = measured(&photograph, &settings);
    let numbers: Vec<usize> = chosen.lights.iter().map(|light| light.number).collect();
    assert_eq!(numbers, [second]);
    assert_eq!(reasons_at(&chosen, lights[3]), [Reason::Asked]);
    let file = &chosen.observations(None).expect("a set").observations[0].file;
    assert_eq!(*file, format!("psf/{second:04}.tif"));
    let settings = LightSettings {
        keep: vec![20_000],
        ..LightSettings::default()
    };
    let error = measure_lights(vec![photograph], &Calibration::default(), &settings);
    let text = error.expect_err("no such light").to_string();
    assert!(text.contains("light 20000"), "{text}");
}

/// A pixel far below the background is a defect, which is masked. One that no check finds leaves its light out, not the set.
#[test]
fn a_dark_pixel_costs_no_set() {
    let (mut photograph, lights) = lights(27);
    let light = lights[8];
    let at = |dx: usize| (light.y as usize) * WIDTH + light.x as usize + dx;
    photograph.planes[0][at(14)] = -900.0;
    let set = measured(&photograph, &LightSettings::default());
    assert!(is_sound(&set) && nearest(&set, light).is_some());
    let settings = LightSettings {
        keep: vec![set.lights[nearest(&set, light).expect("kept")].number],
        ..LightSettings::default()
    };
    for dx in 9..14 {
        photograph.planes[0][at(dx)] = -900.0;
    }
    let set = measured(&photograph, &settings);
    assert!(is_sound(&set));
}
