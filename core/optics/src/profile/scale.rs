//! The units of a lens in which amounts of effects are stated.

use super::LensProfile;
use crate::effects::LensScale;

impl LensProfile {
    /// Returns the units of the lens and its camera, means over the channels.
    pub fn scale(&self) -> LensScale {
        let channels = self.pupil_channels();
        let mean = |values: Vec<f64>| {
            let count = values.len();
            (count > 0 && count == channels.len())
                .then(|| values.iter().sum::<f64>() / count as f64)
        };
        let slopes = channels.iter().filter_map(|channel| {
            let (low, high) = channel.measured_vergence;
            let slope = channel.alpha.slope((low + high) / 2.0);
            (slope != 0.0).then_some(slope)
        });
        let focus = channels.iter().filter_map(|c| c.focus_vergence_per_m());
        let fitted = mean(focus.collect());
        let camera = &self.camera;
        let focus_per_m = fitted.or_else(|| camera.focus_distance.vergence_per_m());
        let nearer =
            1.0 - camera.focal_length_mm.unwrap_or(0.0) * 1e-3 * focus_per_m.unwrap_or(0.0);
        LensScale {
            half_width_px: self.frame.half_width_px(),
            pitch_um: self.pixel_pitch_um,
            f_number: camera.f_number,
            cone: camera.f_number.filter(|_| nearer > 0.0).map(|n| n / nearer),
            slope_px_m: mean(slopes.collect()),
            focus_per_m,
        }
    }
}
