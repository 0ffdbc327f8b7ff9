//! Offsets of windows: how far the plate's content lies from where the lens is expected to put it.

use nalgebra::{SMatrix, SVector};

use super::PairImage;
use super::estimate::Plans;
use super::lens_view::{Drawing, LensView};
use super::patch::{Patch, Window};
use seidel_optics::field::ImagePoint;

/// Gauss-Newton iterations.
const ITERATIONS: usize = 3;
/// Half the step of the differences, px.
const HALF_STEP_PX: f64 = 0.2;
/// Correlation of the plate with the expected one from which a window counts.
const LEAST_CORRELATION: f64 = 0.3;

/// The measured offset of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WindowOffset {
    /// The centre of the window's texture in the sharp picture.
    pub(super) at: ImagePoint,
    /// Observed minus expected position (x, y), px.
    pub(super) offset_px: [f64; 2],
}

/// Measures the offset of `window` in `channel`; `None` where plate and expected plate do not correlate.
///
/// The peak of the cross-correlation gives whole pixels, and Gauss-Newton steps on PSFs drawn at the offset found the rest.
pub(super) fn measure(
    view: &LensView<'_>,
    plans: &Plans,
    pictures: [&PairImage<'_>; 2],
    channel: usize,
    window: Window,
    clip: Option<f32>,
) -> Option<WindowOffset> {
    let [sharp, plate] = pictures;
    let (at, mut drawing) = (window.centre, Drawing::default());
    let first = view.window_offset(window);
    let patch = Patch::cut(sharp, plate, channel, window, first, clip);
    let scene = Scene::new(plans, &patch);
    let offset = first.map(|v| v as f64);
    let tile = view.tile(channel, at, offset, plans.side, &mut drawing);
    let (lag, correlation) = correlation_peak(plans, &patch, &scene.blurred(&tile))?;
    if correlation < LEAST_CORRELATION {
        return None;
    }
    let there = [first[0] + lag[0], first[1] + lag[1]];
    let patch = Patch::cut(sharp, plate, channel, window, there, clip);
    let scene = Scene::new(plans, &patch);
    let mut found = lag.map(|v| v as f64);
    for _ in 0..ITERATIONS {
        let mut drawn = |dx: f64, dy: f64| {
            // A PSF moved to the right lies in a tile whose middle moved to the left.
            let offset = [
                there[0] as f64 - found[0] - dx,
                there[1] as f64 - found[1] - dy,
            ];
            view.tile(channel, at, offset, plans.side, &mut drawing)
        };
        let h = HALF_STEP_PX;
        let tile = drawn(0.0, 0.0);
        let difference = |more: Vec<f64>, less: Vec<f64>| -> Vec<f64> {
            let pairs = more.iter().zip(&less);
            pairs.map(|(m, l)| (m - l) / (2.0 * h)).collect()
        };
        let along_x = difference(drawn(h, 0.0), drawn(-h, 0.0));
        let along_y = difference(drawn(0.0, h), drawn(0.0, -h));
        let pictures = [tile, along_x, along_y].map(|tile| scene.blurred(&tile));
        let step = shift_step(&patch, &pictures, plans.window.stride)?;
        found = [
            found[0] + step[0].clamp(-1.0, 1.0),
            found[1] + step[1].clamp(-1.0, 1.0),
        ];
    }
    Some(WindowOffset {
        at,
        offset_px: found,
    })
}

/// The sharp patch, transformed.
struct Scene<'a> {
    plans: &'a Plans,
    spectrum: Vec<seidel_fourier::Complex<f64>>,
}

impl<'a> Scene<'a> {
    fn new(plans: &'a Plans, patch: &Patch) -> Self {
        let helix = &plans.window;
        Self {
            plans,
            spectrum: helix.spectrum(helix.laid_out(&patch.sharp, helix.stride)),
        }
    }

    /// Convolves the sharp patch with `tile`.
    fn blurred(&self, tile: &[f64]) -> Vec<f64> {
        let helix = &self.plans.window;
        let mut spectrum = helix.spectrum(helix.laid_out(tile, self.plans.side));
        for (s, i) in spectrum.iter_mut().zip(&self.spectrum) {
            *s *= i;
        }
        helix.values(spectrum)
    }
}

/// Returns the lag (x, y) of the largest correlation of the plate with `expected`, and that correlation.
fn correlation_peak(plans: &Plans, patch: &Patch, expected: &[f64]) -> Option<([isize; 2], f64)> {
    let helix = &plans.window;
    let (mean, light) = (patch.plate_mean(|v| v), patch.pixels());
    let predicted = patch.weighted(|k| expected[k]) / light.max(f64::MIN_POSITIVE);
    let mut plate = vec![0.0; helix.length];
    let mut centred = vec![0.0; helix.length];
    for (k, weight) in patch.weight.iter().enumerate() {
        plate[k] = weight * (patch.plate[k] - mean);
        centred[k] = expected[k] - predicted;
    }
    let own = patch.weighted(|k| (patch.plate[k] - mean).powi(2));
    let other = patch.weighted(|k| centred[k].powi(2));
    let mut cross = helix.spectrum(plate);
    for (c, e) in cross.iter_mut().zip(helix.spectrum(centred)) {
        *c *= e.conj();
    }
    let surface = helix.values(cross);
    let reach = plans.side as isize / 2 - 1;
    let lags = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    let best = lags
        .map(|lag| (lag, surface[helix.lag(lag[1], lag[0])]))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let size = (own * other).sqrt();
    (size > 0.0).then(|| (best.0, best.1 / size))
}

/// Returns the Gauss-Newton step of the shift, with the exposure a free plane over the window. `pictures` are the expected
/// plate and its derivatives along x and y.
fn shift_step(patch: &Patch, pictures: &[Vec<f64>; 3], stride: usize) -> Option<[f64; 2]> {
    let middle = stride as f64 / 2.0;
    let mut matrix = SMatrix::<f64, 5, 5>::zeros();
    let mut right = SVector::<f64, 5>::zeros();
    let [plate, along_x, along_y] = pictures;
    for (k, weight) in patch.weight.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        let (x, y) = (
            (k % stride) as f64 / middle - 1.0,
            (k / stride) as f64 / middle - 1.0,
        );
        let light = plate[k];
        let row = SVector::from([light, x * light, y * light, along_x[k], along_y[k]]);
        matrix += *weight * row * row.transpose();
        right += *weight * patch.plate[k] * row;
    }
    let solved = matrix.lu().solve(&right)?;
    let step = [solved[3] / solved[0], solved[4] / solved[0]];
    step.iter().all(|s| s.is_finite()).then_some(step)
}
