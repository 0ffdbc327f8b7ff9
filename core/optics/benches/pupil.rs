//! Times the PSF model `pupil` on one core: `cargo bench -p seidel-optics --bench pupil`.
//!
//! Draws a 65 px tile with and without derivatives. The baseline in the same run is a histogram of 60000 rays a tile,
//! without derivatives and with its noise.

use std::hint::black_box;
use std::time::Instant;

use seidel_optics::field::FieldPoint;
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};
use seidel_optics::psf::pupil::{
    Detail, OpticalPsf, PsfImage, PupilDerivative, TileGrid, Workspace, draw,
};
use seidel_optics::sensor::{Halo, Sensor};

const SIDE: usize = 65;
const RAYS: usize = 60_000;
const ROUNDS: usize = 200;

/// Returns the milliseconds per call, best of five runs.
fn milliseconds(mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..ROUNDS / 5 {
            work();
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e3 / (ROUNDS / 5) as f64);
    }
    best
}

fn row(what: &str, baseline: f64, work: impl FnMut()) {
    let time = milliseconds(work);
    println!(
        "{what:38} {time:6.2} ms  {:5.2} of the baseline",
        time / baseline
    );
}

fn count_rays(pupil: &LocalPupil, bins: &mut [f64]) {
    bins.fill(0.0);
    // A Fermat spiral: equal area per ray.
    let golden = std::f64::consts::TAU * 0.381_966_011_250_105;
    for k in 0..RAYS {
        let r = ((k as f64 + 0.5) / RAYS as f64).sqrt();
        let (sin, cos) = (golden * k as f64).sin_cos();
        let p = pupil.wavefront.slope([r * cos, r * sin]);
        let half = SIDE as f64 / 2.0;
        let (x, y) = ((p[0] + half).floor(), (p[1] + half).floor());
        if x >= 0.0 && y >= 0.0 && x < SIDE as f64 && y < SIDE as f64 {
            bins[y as usize * SIDE + x as usize] += 1.0 / RAYS as f64;
        }
    }
}

/// A square tile about the chief ray.
fn centred(side: usize) -> TileGrid {
    TileGrid {
        corner_px: [-(side as f64) / 2.0; 2],
        width: side,
        height: side,
    }
}

fn main() {
    let numbers = ReducedNumbers {
        alpha: 22.0,
        beta: 2.5,
        gamma: -2.6,
        delta: 1.4,
        phi: -0.5,
    };
    let at = FieldPoint::new(0.7, 0.4);
    let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.1);
    let mut derivatives = vec![
        PupilDerivative::from_wavefront(Wavefront::tilt(1.0, 0.0)),
        PupilDerivative::from_wavefront(Wavefront::tilt(0.0, 1.0)),
    ];
    for (round, along) in [
        (1, 0),
        (2, 0),
        (0, 2),
        (1, 1),
        (3, 0),
        (2, 1),
        (1, 2),
        (0, 3),
    ] {
        let mut wavefront = Wavefront::default();
        wavefront.add(round, along, at.meridian(), 1.0);
        derivatives.push(PupilDerivative::from_wavefront(wavefront));
    }
    let (mut space, mut drawn) = (Workspace::default(), PsfImage::default());
    let mut bins = vec![0.0; SIDE * SIDE];
    let baseline = milliseconds(|| count_rays(black_box(&pupil), &mut bins));
    println!("one {SIDE} px tile, one core; baseline: {RAYS} rays counted, {baseline:.2} ms");
    for (what, count, detail) in [
        ("light alone, full detail", 0, Detail::FULL),
        ("light alone, as for plates", 0, Detail::RENDER),
        ("6 derivatives and blur, as in fits", 6, Detail::FIT),
        ("10 derivatives and blur, as in fits", 10, Detail::FIT),
    ] {
        row(what, baseline, || {
            draw(
                black_box(&pupil),
                &centred(SIDE),
                &derivatives[..count],
                detail,
                &mut space,
                &mut drawn,
            );
        });
    }
    for (what, q, alpha, side) in [
        ("waves, q 1 px, 33 px tile", 1.0, 11.0, 33),
        ("waves, q 3 px, 33 px tile", 3.0, 11.0, 33),
        ("waves, q 0.3 px, 33 px tile", 0.3, 11.0, 33),
        ("waves, q 1 px, 65 px tile", 1.0, 22.0, 65),
        ("waves, q 0.05 px (most samples)", 0.05, 22.0, 65),
    ] {
        let numbers = ReducedNumbers { alpha, ..numbers };
        let mut pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.1);
        pupil.wave_px = q;
        row(what, baseline, || {
            let pupil = black_box(&pupil);
            let detail = Detail::FIT;
            draw(pupil, &centred(side), &[], detail, &mut space, &mut drawn);
        });
    }
    let numbers = ReducedNumbers {
        alpha: 11.0,
        ..numbers
    };
    let plain = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.1);
    let mut wavy = plain.clone();
    wavy.wave_px = 2.0;
    let blurring = Sensor {
        streak_px: [1.0, 0.5],
        box_px: [0.5, 0.5],
        copies_px: [0.6, 0.6],
        ..Sensor::default()
    };
    let scattering = Sensor {
        halo: Halo {
            share: 0.1,
            ..Halo::default()
        },
        ..blurring
    };
    for (what, pupil) in [("rays", &plain), ("waves", &wavy)] {
        let mut picture =
            || OpticalPsf::draw(pupil, &centred(33), &scattering, Detail::FIT, &mut space);
        let kept = picture();
        row(&format!("picture of {what}, 33 px"), baseline, || {
            black_box(picture());
        });
        for (how, sensor) in [
            ("ideal", Sensor::default()),
            ("blurring", blurring),
            ("and halo", scattering),
        ] {
            row(&format!("  through a sensor, {how}"), baseline, || {
                black_box(kept.through(black_box(&sensor)));
            });
        }
    }
}
