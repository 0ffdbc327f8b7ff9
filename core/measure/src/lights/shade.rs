//! Pixels of a tile that are darker than the background: dust on the sensor shades it, or a defect does.

use super::candidate::{Refusal, Scene, Window};
use crate::detection::Peak;
use crate::rejection::Reason;

/// Darkness of the mean over a square of pixels from which on it is shaded: standard deviations of that mean, and a share of the
/// height of the light below which shade does no harm.
const DARK_SIGMAS: f64 = 8.0;
const DARK_SHARE: f64 = 0.002;
/// The same standard deviations for developed pictures, the noise of whose neighbours is alike: a mean over 5 x 5 pixels of bilinearly
/// interpolated colours has 2.5 times the noise of as many single ones.
const DEVELOPED_SIGMAS: f64 = 20.0;
/// Half sides of the squares, px: a defect, and dust of small and large contrast.
const HALF_SIDES: [usize; 3] = [0, 1, 2];
/// Margin around dust, whose rim is faint, px.
const MARGIN_PX: usize = 3;
/// Share of the extent of a light that must be free of dust.
const CORE_SHARE: f64 = 0.9;
/// Share of a tile up to which shade is masked.
const MAX_SHARE: f64 = 0.5;
/// Share of a tile from which on no spot is that large.
const DARK_TILE_SHARE: f64 = 0.8;
/// Departure of the mean of a quarter of a tile from the background, outside the light: a share of its height, and standard deviations.
const MAX_DEPARTURE: f64 = 0.02;
const MIN_DEPARTURE_SIGMAS: f64 = 8.0;
/// Distance from a light beyond which only background is left, in units of its extent.
const DARK_REACH: f64 = 1.4;

/// Mean and its standard deviation over some pixels.
struct Mean {
    value: f64,
    sigma: f64,
}

impl Scene<'_> {
    /// Takes shaded pixels out of `mask`. Dust that reaches the light itself, or shades most of the tile, is an error.
    pub(super) fn mask_shade(
        &self,
        peak: &Peak,
        window: &Window,
        mask: &mut [bool],
        reach: f64,
    ) -> Result<(), Refusal> {
        let mut darkest: f64 = 0.0;
        let mut shaded = vec![false; mask.len()];
        let mut in_core = false;
        let sigmas = match self.photo.mosaic {
            Some(_) => DARK_SIGMAS,
            None => DEVELOPED_SIGMAS,
        };
        let least = DARK_SHARE * f64::from(peak.height);
        for (x, y) in window.pixels() {
            for plane in 0..self.found.signal.planes.len() {
                for half in HALF_SIDES {
                    let square = (
                        x.saturating_sub(half)..x + half + 1,
                        y.saturating_sub(half)..y + half + 1,
                    );
                    let pixels = square
                        .1
                        .flat_map(|row| square.0.clone().map(move |column| (column, row)));
                    let Some(mean) = self.mean(plane, pixels) else {
                        continue;
                    };
                    if mean.value > -least.max(sigmas * mean.sigma) {
                        continue;
                    }
                    let margin = if half == 0 { 0 } else { half + MARGIN_PX };
                    for (k, (column, row)) in window.pixels().enumerate() {
                        if column.abs_diff(x).max(row.abs_diff(y)) <= margin {
                            shaded[k] = true;
                        }
                    }
                    if half > 0 {
                        darkest = darkest.min(mean.value);
                        let off = (x as f64 - peak.x as f64).hypot(y as f64 - peak.y as f64);
                        in_core |= off - margin as f64 <= CORE_SHARE * reach;
                    }
                }
            }
        }
        for (mask, shaded) in mask.iter_mut().zip(&shaded) {
            *mask &= !shaded;
        }
        let share = shaded.iter().filter(|s| **s).count() as f64 / shaded.len().max(1) as f64;
        if share > MAX_SHARE && (share > DARK_TILE_SHARE || !in_core) {
            let departure = -darkest / f64::from(peak.height);
            return Err(Refusal::new(Reason::Slope, departure, MAX_DEPARTURE));
        }
        if in_core {
            let level = self.found.backgrounds[self.photo.reference_channel()]
                .level_at(peak.x as f64 + 0.5, peak.y as f64 + 0.5)
                .max(-darkest);
            let transmission = |value: f64| (1.0 + value / level).max(0.0);
            return Err(Refusal::new(
                Reason::Dust,
                transmission(darkest),
                transmission(-least),
            ));
        }
        Ok(())
    }

    /// Refuses a light beside which the background departs from that of its surroundings.
    pub(super) fn check_slope(
        &self,
        peak: &Peak,
        window: &Window,
        mask: &[bool],
        reach: f64,
    ) -> Result<(), Refusal> {
        let height = f64::from(peak.height);
        for plane in 0..self.found.signal.planes.len() {
            for quarter in 0..4 {
                let pixels = window.pixels().zip(mask).filter(|((x, y), used)| {
                    let (dx, dy) = (*x as f64 - peak.x as f64, *y as f64 - peak.y as f64);
                    let side = usize::from(dx > 0.0) + 2 * usize::from(dy > 0.0);
                    **used && side == quarter && dx.hypot(dy) > DARK_REACH * reach
                });
                let Some(mean) = self.mean(plane, pixels.map(|(place, _)| place)) else {
                    continue;
                };
                let departure = mean.value.abs();
                if departure > (MAX_DEPARTURE * height).max(MIN_DEPARTURE_SIGMAS * mean.sigma) {
                    return Err(Refusal::new(
                        Reason::Slope,
                        departure / height,
                        MAX_DEPARTURE,
                    ));
                }
            }
        }
        Ok(())
    }

    /// Returns the mean of light above the background over `pixels` of `plane`; `None` where none is measured.
    fn mean(&self, plane: usize, pixels: impl Iterator<Item = (usize, usize)>) -> Option<Mean> {
        let (width, height) = self.found.signal.size;
        let (values, noise) = (
            &self.found.signal.planes[plane],
            &self.found.signal.noise[plane],
        );
        let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
        for (x, y) in pixels.filter(|(x, y)| *x < width && *y < height) {
            let sigma = f64::from(noise[y * width + x]);
            if sigma.is_finite() {
                sum += f64::from(values[y * width + x]);
                square += sigma * sigma;
                count += 1.0;
            }
        }
        (count > 0.0).then(|| Mean {
            value: sum / count,
            sigma: square.sqrt() / count,
        })
    }
}
