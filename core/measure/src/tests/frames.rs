//! Tests of dark and flat frames, and of several photographs.

use super::simulator::{Light, Simulator, grid};
use super::{measured, nearest, reasons_at};
use crate::lights::{LightSettings, measure_lights};
use crate::rejection::Reason;
use crate::{Calibration, Photograph};

/// Returns a photograph of the same lights without noise of its own seed, with one light moved.
fn exposures(moved: usize) -> (Vec<Photograph>, Light) {
    let mut layout = Simulator::new(240, 180, 5);
    let lights = grid(&mut layout, 5, 4);
    let photographs = [0.0, 1.1].map(|motion| {
        let mut simulator = Simulator::new(240, 180, 7 + motion as u64);
        for (k, light) in lights.iter().enumerate() {
            let x = light.x + if k == moved { motion } else { 0.3 * motion };
            simulator.add(Light { x, ..*light });
        }
        simulator.expose(0).0
    });
    (photographs.to_vec(), lights[moved])
}

#[test]
fn a_light_that_moved_between_photographs_is_left_out() {
    let (photographs, moved) = exposures(7);
    let set = measured(photographs);
    let of_second = set.left_out.iter().filter(|l| l.why == Reason::Moved);
    let all: Vec<_> = of_second.collect();
    assert_eq!(all.len(), 1, "{:?}", set.left_out);
    assert!((all[0].x - moved.x).abs() < 3.0 && all[0].photograph == 1);
    assert!((all[0].value - 0.77).abs() < 0.1, "{}", all[0].value);
}

#[test]
fn dark_frames_mark_defects_and_flat_frames_show_dust() {
    let mut simulator = Simulator::new(240, 180, 9);
    let lights = grid(&mut simulator, 5, 4);
    for light in &lights {
        simulator.add(*light);
    }
    let (mut photograph, _) = simulator.expose(0);
    let (mut dark, _) = Simulator::new(240, 180, 10).expose(0);
    let mut flat = dark.clone();
    let dusty = lights[6];
    for index in 0..240 * 180 {
        let (x, y) = ((index % 240) as f64 + 0.5, (index / 240) as f64 + 0.5);
        let shade = if (x - dusty.x).hypot(y - dusty.y) < 2.5 {
            0.6
        } else {
            1.0
        };
        flat.planes[0][index] = (5000.0 * shade) as f32;
        photograph.planes[0][index] *= shade as f32;
    }
    let defect = 240 * 100 + 77;
    dark.planes[0][defect] += 900.0;
    photograph.planes[0][defect] += 900.0;
    flat.planes[0][defect] += 900.0;
    let calibration = Calibration::new(&[dark.clone()], &[flat]).expect("frames");
    let settings = LightSettings::default();
    let set = measure_lights(vec![photograph.clone()], &calibration, &settings).expect("lights");
    assert_eq!(reasons_at(&set, dusty), [Reason::Dust]);
    assert!(set.photographs[0].bad[defect]);
    assert!(nearest(&set, lights[5]).is_some());
    dark.width = 180;
    dark.height = 240;
    let error = Calibration::new(&[dark.clone()], &[photograph]).expect_err("another size");
    assert!(error.to_string().contains("240 x 180"), "{error}");
}
