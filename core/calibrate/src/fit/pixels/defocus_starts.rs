//! Estimates of defocus from which pixel fits start, where moments alone do not tell the side of focus: by each place where
//! focus may lie among the distances, and from the data of the camera.

use crate::fit::initial::InitialEstimate;
use crate::measure::MeasuredTile;
use seidel_optics::lens::{VergencePoint, VergenceSeries};
use seidel_optics::numeric::median;
use seidel_optics::observations::ObservationSet;

/// Returns pure defocus, `alpha[0] + alpha[1] v` at vergence v.
pub(super) fn defocus_alone(alpha: [f64; 2]) -> InitialEstimate {
    InitialEstimate {
        alpha,
        beta: 0.0,
        gamma: 0.0,
        delta: 0.0,
        phi: 0.0,
        misfit: f64::INFINITY,
    }
}

/// Returns the radius of the uniform disc with the variance of `tile`, px.
pub(super) fn disc_radius(tile: &MeasuredTile) -> f64 {
    // A uniform disc of radius r has a trace of r²/2.
    (2.0 * tile.optical.trace().max(0.0)).sqrt()
}

/// Returns the defocus of a thin lens with the focal length, f-number and focus distance of `set`, if it has them all.
///
/// A point at vergence v is drawn as a disc of radius `R s (v - v0)`, where R is the radius of the pupil, s the distance from
/// the pupil to the sensor and v0 the vergence in focus.
pub(super) fn of_camera(set: &ObservationSet) -> Option<InitialEstimate> {
    let focal_m = set.camera.focal_length_mm? * 1e-3;
    let focus = set.camera.focus_distance.vergence_per_m()?;
    let pitch_m = set.pixel_pitch_um? * 1e-6;
    let radius_m = focal_m / (2.0 * set.camera.f_number?);
    let image_m = focal_m / (1.0 - focal_m * focus);
    let slope = radius_m * image_m / pitch_m;
    let is_sound = slope.is_finite() && slope > 0.0;
    is_sound.then(|| defocus_alone([-slope * focus, slope]))
}

/// Returns estimates of pure defocus that cross focus before, between or beyond the distances of `tiles`.
/// They cover solutions that noisy moments miss.
pub(super) fn by_crossing(tiles: &[&MeasuredTile]) -> Vec<InitialEstimate> {
    let mut radii: Vec<(f64, Vec<f64>)> = Vec::new();
    for tile in tiles {
        let Some(v) = tile.distance.vergence_per_m() else {
            return Vec::new();
        };
        let radius = disc_radius(tile);
        match radii.iter_mut().find(|(at, _)| *at == v) {
            Some((_, all)) => all.push(radius),
            None => radii.push((v, vec![radius])),
        }
    }
    radii.sort_by(|a, b| a.0.total_cmp(&b.0));
    if radii.len() < 2 {
        return Vec::new();
    }
    (0..=radii.len())
        .map(|crossing| {
            let signed = radii.iter_mut().enumerate().map(|(k, (v, all))| {
                let median = median(all);
                VergencePoint {
                    vergence_per_m: *v,
                    value: if k < crossing { -median } else { median },
                    sigma: 0.0,
                }
            });
            let line = VergenceSeries::fit_line(&signed.collect::<Vec<_>>());
            defocus_alone([line.coefficients[0], line.coefficients[1]])
        })
        .collect()
}
