//! The traced lenses against published figures and another program, and properties of errors and cases.

mod cases;
mod design;
mod errors;
mod published;

use super::assembly::Assembly;
use super::beam::{Beam, OpenCell};
use super::lens::{Choices, GlassLens};
use super::prescription::Prescription;
use crate::lens::Place;
use crate::mask::Mask;
use seidel_optics::field::Frame;

/// Returns a lens of 50 mm with a frame of 1920 x 1080 pixels of 5 um, focused at 2 m.
fn lens_of(prescription: &'static Prescription, f_number: f64) -> GlassLens {
    let mut lens = GlassLens::new(&Choices {
        prescription,
        frame: Frame::new(1920, 1080, None).expect("the frame is a real one"),
        focal_mm: 50.0,
        f_number,
        pitch_um: 5.0,
        focus_m: 2.0,
        full_field: None,
    });
    lens.camera.depths_m = vec![2.6, 1.6];
    lens
}

/// The image of the middle of a beam: its place and its linear growth with the pupil.
#[derive(Debug, Clone, Copy)]
struct Core {
    /// Landing point of the ray through the middle of the stop, frame px.
    chief: [f64; 2],
    /// Growth of x with the x of the stop, and of y with y, px per stop radius.
    growth: [f64; 2],
}

/// Returns the core of the beam of `channel` from the ideal position at `depth_m`.
fn core(built: &Assembly, channel: usize, ideal: [f64; 2], depth_m: f64) -> Core {
    let object = built.object(ideal, depth_m);
    // Two Newton steps with differences lead the ray through the middle of the stop.
    let step = 0.02 * built.view.pupil_mm;
    let follow = |aim: [f64; 2]| built.follow(channel, object, aim).expect("it passes");
    let mut aim = [0.0; 2];
    for _ in 0..6 {
        let here = follow(aim).stop;
        let by_x = follow([aim[0] + step, aim[1]]).stop[0] - here[0];
        let by_y = follow([aim[0], aim[1] + step]).stop[1] - here[1];
        aim = [
            aim[0] - here[0] * step / by_x,
            aim[1] - here[1] * step / by_y,
        ];
    }
    let growth = std::array::from_fn(|i| {
        let mut moved = [aim; 2];
        moved[0][i] -= step;
        moved[1][i] += step;
        let [low, high] = moved.map(follow);
        (high.at[i] - low.at[i]) / (high.stop[i] - low.stop[i])
    });
    Core {
        chief: follow(aim).at,
        growth,
    }
}

/// The spread of a beam on the sensor.
#[derive(Debug, Clone, Copy)]
struct Spread {
    /// Mean landing point, frame px.
    centroid: [f64; 2],
    /// Root mean square distance from it, px.
    rms_px: f64,
}

/// Returns the spread at `place` through `lens`.
fn spread(lens: &GlassLens, place: &Place) -> Spread {
    let mask = Mask::default();
    let object = lens.design.object(place.ideal, place.depth_m);
    let beam = Beam::new(&lens.design, place.channel, object, &mask).expect("light passes");
    let (mut light, mut sum, mut square) = (0.0, [0.0; 2], 0.0);
    beam.for_each(
        40,
        |OpenCell {
             light: weight, at, ..
         }| {
            let from = [at[0] - place.ideal[0], at[1] - place.ideal[1]];
            light += weight;
            sum[0] += weight * from[0];
            sum[1] += weight * from[1];
            square += weight * (from[0] * from[0] + from[1] * from[1]);
        },
    );
    let mean = sum.map(|s| s / light);
    Spread {
        centroid: [place.ideal[0] + mean[0], place.ideal[1] + mean[1]],
        rms_px: (square / light - mean[0] * mean[0] - mean[1] * mean[1]).sqrt(),
    }
}
