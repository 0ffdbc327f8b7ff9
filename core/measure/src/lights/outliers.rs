//! Lights whose shape departs from a smooth field through all of them: blends, motion, dust.

use super::MeasuredLight;
use crate::photograph::Photograph;
use crate::rejection::{LeftOut, Reason};
use crate::smooth_field::departures;

/// Departure from which on a light is left out, standard deviations.
const MAX_SIGMAS: f64 = 7.0;

/// Removes the outliers among `lights` and adds them to `left_out`, but for the numbers `keep`.
pub(crate) fn reject(
    photo: &Photograph,
    lights: &mut Vec<MeasuredLight>,
    keep: &[usize],
    left_out: &mut Vec<LeftOut>,
) {
    let half = photo.width as f64 / 2.0;
    let places: Vec<[f64; 2]> = (lights.iter())
        .map(|light| {
            let [x, y] = light.place();
            [x / half - 1.0, (y - photo.height as f64 / 2.0) / half]
        })
        .collect();
    let mut worst = vec![0.0_f64; lights.len()];
    for moment in 0..7 {
        let of = |light: &MeasuredLight| {
            let profile = light.profiles[light.reference].as_ref()?;
            Some((profile.shape()[moment], profile.shape_sigma[moment]))
        };
        let Some(pairs) = lights.iter().map(of).collect::<Option<Vec<_>>>() else {
            return;
        };
        let (values, sigmas): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let Some(found) = departures(&places, &values, &sigmas) else {
            return;
        };
        for (k, residual) in found.residuals.iter().enumerate() {
            worst[k] = worst[k].max(residual.abs() / found.scatter.hypot(sigmas[k]));
        }
    }
    for index in (0..lights.len()).rev() {
        if worst[index] <= MAX_SIGMAS || keep.contains(&lights[index].number) {
            continue;
        }
        let light = lights.remove(index);
        let [x, y] = light.place();
        left_out.push(LeftOut {
            photograph: light.photograph,
            number: Some(light.number),
            x,
            y,
            why: Reason::UnlikeNeighbours,
            value: worst[index],
            limit: MAX_SIGMAS,
        });
    }
}
