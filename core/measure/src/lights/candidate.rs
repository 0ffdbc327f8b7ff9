//! One light: reasons to leave it out, its tile, and its profile in every channel.

use rayon::prelude::*;

use super::{Found, LightSettings, MeasuredLight};
use crate::calibration::Calibration;
use crate::detection::Peak;
use crate::photograph::Photograph;
use crate::profile_fit::{self, LightPixel, PixelNoise, Profile, Start};
use crate::rejection::{LeftOut, Reason};

/// Height of another light relative to this one from which on it makes a double.
const DOUBLE_SHARE: f32 = 0.015;
/// Distance of another light, in units of the extent, within which it makes a double.
const DOUBLE_REACH: f64 = 1.5;
/// Share of the extent of a light that must be free of others.
const CORE_SHARE: f64 = 0.9;
/// Share of the radius of a tile that must lie on the frame. A tile cut closer to its light would have it far from its middle.
const LEAST_TILE_SHARE: f64 = 0.6;
/// Share of the light in one pixel above which it is a defect or not resolved.
const MAX_PIXEL_SHARE: f64 = 0.55;
/// Radius of the fitted pixels over the extent of a light. Dark pixels around it hold the wings of the profile down.
const FIT_OVER_EXTENT: f64 = 1.6;
/// Error of a Gauss-Hermite profile relative to the peak, typical of defocused and comatic PSFs.
const PROFILE_ERROR: f64 = 0.01;
/// Excess of a pixel over the profile of its light from which on it is a defect: standard deviations, and a share of the peak
/// that the error of no profile reaches.
const DEFECT_SIGMAS: f64 = 8.0;
const DEFECT_SHARE: f64 = 0.15;
/// Distance from the peak within which a pixel may stand out because the light is sharp there, px.
const CORE_PX: f64 = 2.5;
/// Ratio of a defect to the second largest of its eight neighbours.
const STANDING_OUT: f32 = 1.4;
/// Least variance of a channel relative to that of the reference channel.
const LEAST_CHANNEL_VARIANCE: f64 = 0.35;
/// Flux over its noise that every channel needs, and the sum over the tile over its noise: below, it may not even be positive.
const MIN_CHANNEL_SNR: f64 = 6.0;
const MIN_TILE_SNR: f64 = 3.0;
/// Change of the background over a tile from which on it is taken off, in standard deviations of a pixel: that of an even background
/// is known to about one.
const MIN_SLOPE_SIGMAS: f64 = 1.2;

/// One photograph with the lights found in it.
pub(crate) struct Scene<'a> {
    pub(crate) index: usize,
    pub(crate) photo: &'a Photograph,
    pub(crate) found: &'a Found,
    pub(crate) calibration: &'a Calibration,
    pub(crate) tile_px: usize,
    /// Counts per electron, or an estimate of it.
    pub(crate) gain: f64,
    pub(crate) settings: &'a LightSettings,
    /// Number of every peak among the lights of all photographs.
    pub(crate) numbers: &'a [usize],
}

/// A refusal: the reason, the value and the limit.
pub(super) struct Refusal {
    why: Reason,
    value: f64,
    limit: f64,
}

impl Refusal {
    pub(super) fn new(why: Reason, value: f64, limit: f64) -> Self {
        Self { why, value, limit }
    }
}

/// The pixels of a tile.
pub(super) struct Window {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Window {
    pub(super) fn pixels(&self) -> impl Iterator<Item = (usize, usize)> {
        let (left, top, width) = (self.left, self.top, self.width);
        (0..self.width * self.height).map(move |k| (left + k % width, top + k / width))
    }

    /// Returns the frame position of its middle.
    fn middle(&self) -> [f64; 2] {
        [
            self.left as f64 + self.width as f64 / 2.0,
            self.top as f64 + self.height as f64 / 2.0,
        ]
    }
}

impl Scene<'_> {
    /// Measures every light, in the order of the frame. Adds those left out to `left_out`.
    pub(crate) fn measure(&self, left_out: &mut Vec<LeftOut>) -> Vec<MeasuredLight> {
        let results: Vec<Result<MeasuredLight, Refusal>> = (self.found.peaks.par_iter())
            .zip(self.numbers)
            .map(|(peak, number)| self.one(peak, *number))
            .collect();
        let mut lights = Vec::new();
        let found = self.found.peaks.iter().zip(self.numbers);
        for (result, (peak, number)) in results.into_iter().zip(found) {
            match result {
                Ok(light) => lights.push(light),
                Err(refusal) => left_out.push(LeftOut {
                    photograph: self.index,
                    number: Some(*number),
                    x: peak.x as f64 + 0.5,
                    y: peak.y as f64 + 0.5,
                    why: refusal.why,
                    value: refusal.value,
                    limit: refusal.limit,
                }),
            }
        }
        lights.sort_by(|a, b| {
            let (a, b) = (a.place(), b.place());
            a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))
        });
        lights
    }

    fn one(&self, peak: &Peak, number: usize) -> Result<MeasuredLight, Refusal> {
        let reach = self.found.extent_px.max(2.0);
        if self.settings.leave_out.contains(&number) {
            let number = number as f64;
            return Err(Refusal::new(Reason::Asked, number, number));
        }
        let is_kept = self.settings.keep.contains(&number);
        let unless_kept = |checked: Result<(), Refusal>| if is_kept { Ok(()) } else { checked };
        unless_kept(self.check_border(peak, reach))?;
        unless_kept(self.check_clipping(peak, reach))?;
        unless_kept(self.check_double(peak, reach))?;
        unless_kept(self.check_single_pixel(peak))?;
        unless_kept(self.check_dust(peak, reach))?;
        let window = self.window(peak);
        let mut mask = self.mask(peak, &window, reach);
        unless_kept(self.mask_shade(peak, &window, &mut mask, reach))?;
        unless_kept(self.check_slope(peak, &window, &mask, reach))?;
        let count = self.photo.channels.len();
        let (x, y) = (peak.x as f64 + 0.5, peak.y as f64 + 0.5);
        let at = |k: usize| &self.found.backgrounds[k];
        let [across, down] = window.middle();
        let background = (0..count).map(|c| at(c).level_at(across, down)).collect();
        let slope = (0..count).map(|c| self.slope(c, &window)).collect();
        let noise_sigma: Vec<f64> = (0..count).map(|c| at(c).sigma_at(x, y)).collect();
        let reference = self.photo.reference_channel();
        // The extent is where a Gaussian, smoothed a little, falls to one fiftieth.
        let mut start = Start {
            centre: [x, y],
            variance_px2: (reach / 3.0).powi(2).max(0.5),
            least_variance_px2: 0.0,
        };
        let mut profiles: Vec<Option<Profile>> = vec![None; count];
        let others = (0..count).filter(|c| *c != reference);
        for channel in std::iter::once(reference).chain(others) {
            let noise = PixelNoise {
                sigma: noise_sigma[channel],
                gain: self.gain,
                model_error: PROFILE_ERROR.hypot(self.photo.errors.relative),
            };
            let fitted = self
                .fit_channel(channel, peak, &window, &mut mask, noise, start)
                .or_else(|| {
                    let pixels = self.fit_pixels(channel, peak, &window, &mask);
                    profile_fit::fit_flux(&pixels, noise, profiles[reference].as_ref()?)
                });
            if let Some(profile) = &fitted
                && channel == reference
            {
                let [xx, _, yy] = profile.covariance;
                start = Start {
                    centre: profile.centroid,
                    variance_px2: (xx + yy) / 2.0,
                    least_variance_px2: LEAST_CHANNEL_VARIANCE * (xx + yy) / 2.0,
                };
            }
            profiles[channel] = fitted;
        }
        let least = self.settings.min_snr;
        let snr = profiles[reference]
            .as_ref()
            .map_or(0.0, |p| self.dark_snr(p, noise_sigma[reference]));
        if snr < least && !is_kept {
            return Err(Refusal::new(Reason::Faint, snr, least));
        }
        let of_channel = |channel: usize, mask: &[bool]| {
            let profile = profiles[channel].as_ref();
            let of_profile = profile.map_or(0.0, |p| self.dark_snr(p, noise_sigma[channel]));
            let of_tile = self.tile_snr(channel, &window, mask, noise_sigma[channel]);
            of_profile.min(of_tile * MIN_CHANNEL_SNR / MIN_TILE_SNR)
        };
        let faintest_by = |mask: &[bool]| {
            let each = (0..count).map(|channel| of_channel(channel, mask));
            each.fold(f64::INFINITY, f64::min)
        };
        let mut faintest = faintest_by(&mask);
        if faintest < MIN_CHANNEL_SNR {
            // The dark margin of a tile adds noise to the sum of a faint light, and nothing else.
            for ((x, y), used) in window.pixels().zip(&mut mask) {
                let off = (x as f64 - peak.x as f64).hypot(y as f64 - peak.y as f64);
                *used &= off <= reach;
            }
            faintest = faintest_by(&mask);
        }
        if faintest < MIN_CHANNEL_SNR && !is_kept {
            return Err(Refusal::new(Reason::Faint, faintest, MIN_CHANNEL_SNR));
        }
        Ok(MeasuredLight {
            photograph: self.index,
            number,
            corner: (window.left, window.top),
            size: (window.width, window.height),
            mask: mask.contains(&false).then_some(mask),
            background,
            slope,
            noise_sigma,
            profiles,
            reference,
        })
    }

    /// Returns the slope of the background of `channel` across `window`, counts per pixel along x and y. Zero where the change over the
    /// tile is below [`MIN_SLOPE_SIGMAS`].
    fn slope(&self, channel: usize, window: &Window) -> [f64; 2] {
        let background = &self.found.backgrounds[channel];
        let [x, y] = window.middle();
        let (across, down) = (window.width as f64 / 2.0, window.height as f64 / 2.0);
        let level = |x: f64, y: f64| background.level_at(x, y);
        let change = [
            level(x + across, y) - level(x - across, y),
            level(x, y + down) - level(x, y - down),
        ];
        if change[0].hypot(change[1]) < MIN_SLOPE_SIGMAS * background.sigma_at(x, y) {
            return [0.0; 2];
        }
        [change[0] / (2.0 * across), change[1] / (2.0 * down)]
    }

    /// Fits the profile of one channel. Defects beside the core of a light do not stand out from their neighbours, but from its
    /// profile: they are masked, and the fit repeated.
    fn fit_channel(
        &self,
        channel: usize,
        peak: &Peak,
        window: &Window,
        mask: &mut [bool],
        noise: PixelNoise,
        start: Start,
    ) -> Option<Profile> {
        let mut pixels = self.fit_pixels(channel, peak, window, mask);
        let mut profile = profile_fit::fit(&pixels, noise, start)?;
        let mut defects = defects(&pixels, &profile, noise);
        defects.retain(|d| {
            let off = (d.x - 0.5 - peak.x as f64).hypot(d.y - 0.5 - peak.y as f64);
            off > CORE_PX && self.stands_out(channel, d.x as usize, d.y as usize)
        });
        if !defects.is_empty() {
            for defect in defects {
                let (column, row) = (defect.x as usize, defect.y as usize);
                mask[(row - window.top) * window.width + column - window.left] = false;
            }
            pixels = self.fit_pixels(channel, peak, window, mask);
            profile = profile_fit::fit(&pixels, noise, start)?;
        }
        profile.refine_centroid(&pixels, noise, self.photo.share_of(channel));
        profile.centroid_sigma = profile.centroid_sigma.hypot(self.photo.errors.centroid_px);
        Some(profile)
    }

    /// Returns whether a pixel is much brighter than its neighbours of all colours, as no light is away from its peak.
    fn stands_out(&self, channel: usize, x: usize, y: usize) -> bool {
        let plane = &self.found.signal.planes[self.photo.plane_of(channel)];
        let (width, height) = (self.photo.width, self.photo.height);
        let mut near: Vec<f32> = Vec::with_capacity(9);
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for column in x.saturating_sub(1)..(x + 2).min(width) {
                if (column, row) != (x, y) {
                    near.push(plane[row * width + column]);
                }
            }
        }
        near.sort_by(|a, b| b.total_cmp(a));
        plane[y * width + x] > STANDING_OUT * near[1].max(0.0)
    }

    /// Returns flux over the noise of the pixels that hold it, without the error of the profile.
    fn dark_snr(&self, profile: &Profile, sigma: f64) -> f64 {
        let [xx, xy, yy] = profile.covariance;
        // Effective area of a Gaussian, px: 4 pi times the root of the determinant.
        let area = 4.0 * std::f64::consts::PI * (xx * yy - xy * xy).max(0.01).sqrt();
        let photons = self.gain * profile.flux;
        profile.flux
            / (area * sigma * sigma + photons)
                .sqrt()
                .max(f64::MIN_POSITIVE)
    }

    /// Returns the sum over the tile in `channel` over its noise: small where a wrong background outweighs a faint light.
    fn tile_snr(&self, channel: usize, window: &Window, mask: &[bool], sigma: f64) -> f64 {
        let plane = &self.photo.planes[self.photo.plane_of(channel)];
        let background = &self.found.backgrounds[channel];
        let [across, down] = window.middle();
        let level = background.level_at(across, down);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for ((x, y), used) in window.pixels().zip(mask) {
            if *used && self.photo.covers(channel, x, y) {
                sum += f64::from(plane[y * self.photo.width + x]) - level;
                count += 1.0;
            }
        }
        sum / (sigma * count.sqrt()).max(f64::MIN_POSITIVE)
    }

    fn check_border(&self, peak: &Peak, reach: f64) -> Result<(), Refusal> {
        let (width, height) = (self.photo.width, self.photo.height);
        let reach = reach.max(LEAST_TILE_SHARE * (self.tile_px / 2) as f64);
        let nearest = peak
            .x
            .min(peak.y)
            .min(width - 1 - peak.x)
            .min(height - 1 - peak.y);
        if (nearest as f64) < reach {
            return Err(Refusal::new(Reason::Border, nearest as f64, reach));
        }
        Ok(())
    }

    fn check_clipping(&self, peak: &Peak, reach: f64) -> Result<(), Refusal> {
        let clipped =
            |(x, y): &(usize, usize)| self.photo.is_clipped(*x, *y) && !self.is_hot(*x, *y);
        if self.around(peak, reach).any(|p| clipped(&p)) {
            let white = f64::from(self.photo.white);
            let samples = self.around(peak, reach).flat_map(|(x, y)| {
                let planes = self.photo.planes.iter();
                planes.map(move |plane| plane[y * self.photo.width + x])
            });
            let largest = samples.fold(0.0_f32, f32::max);
            return Err(Refusal::new(Reason::Clipped, f64::from(largest), white));
        }
        Ok(())
    }

    fn check_double(&self, peak: &Peak, reach: f64) -> Result<(), Refusal> {
        let nearest = self
            .others(peak)
            .filter(|other| other.height > DOUBLE_SHARE * peak.height)
            .map(|other| {
                // The light itself must lie outside the pixels that a brighter one spoils.
                let spoilt = masked_radius(peak, other, reach) + CORE_SHARE * reach;
                (distance(peak, other), spoilt.max(DOUBLE_REACH * reach))
            })
            .filter(|(distance, limit)| distance < limit)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match nearest {
            Some((distance, limit)) => Err(Refusal::new(Reason::Double, distance, limit)),
            None => Ok(()),
        }
    }

    fn check_single_pixel(&self, peak: &Peak) -> Result<(), Refusal> {
        for plane in &self.found.signal.planes {
            let values = self
                .around(peak, 3.0)
                .map(|(x, y)| f64::from(plane[y * self.photo.width + x].max(0.0)));
            let (sum, largest) = values.fold((0.0, 0.0_f64), |(s, m), v| (s + v, m.max(v)));
            if largest > MAX_PIXEL_SHARE * sum {
                return Err(Refusal::new(
                    Reason::HotPixel,
                    largest / sum,
                    MAX_PIXEL_SHARE,
                ));
            }
        }
        Ok(())
    }

    fn check_dust(&self, peak: &Peak, reach: f64) -> Result<(), Refusal> {
        let darkest = self
            .around(peak, 0.6 * reach)
            .filter_map(|(x, y)| self.calibration.dust_at(y * self.photo.width + x))
            .fold(f64::INFINITY, f64::min);
        if darkest.is_finite() {
            return Err(Refusal::new(Reason::Dust, darkest, 0.92));
        }
        Ok(())
    }

    fn others(&self, peak: &Peak) -> impl Iterator<Item = &Peak> {
        let at = (peak.x, peak.y);
        self.found.peaks.iter().filter(move |p| (p.x, p.y) != at)
    }

    fn is_hot(&self, x: usize, y: usize) -> bool {
        let index = y * self.photo.width + x;
        self.found.signal.hot.iter().any(|hot| hot[index])
    }

    /// Returns the pixels within `radius` of `peak`.
    fn around(&self, peak: &Peak, radius: f64) -> impl Iterator<Item = (usize, usize)> {
        let reach = radius.ceil() as usize;
        let (cx, cy) = (peak.x, peak.y);
        let columns = cx.saturating_sub(reach)..(cx + reach + 1).min(self.photo.width);
        let rows = cy.saturating_sub(reach)..(cy + reach + 1).min(self.photo.height);
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
            .filter(move |(x, y)| (*x as f64 - cx as f64).hypot(*y as f64 - cy as f64) <= radius)
    }

    /// Returns the tile of `peak`, cut at the borders of the frame.
    fn window(&self, peak: &Peak) -> Window {
        let half = self.tile_px / 2;
        let (left, top) = (peak.x.saturating_sub(half), peak.y.saturating_sub(half));
        let right = (peak.x + self.tile_px - half).min(self.photo.width);
        let bottom = (peak.y + self.tile_px - half).min(self.photo.height);
        Window {
            left,
            top,
            width: right - left,
            height: bottom - top,
        }
    }

    /// Returns which pixels of `window` to use: not hot, bad or clipped, and not near another light.
    fn mask(&self, peak: &Peak, window: &Window, reach: f64) -> Vec<bool> {
        let near: Vec<(&Peak, f64)> = self
            .others(peak)
            .filter(|other| other.height > DOUBLE_SHARE * peak.height)
            .map(|other| (other, masked_radius(peak, other, reach)))
            .filter(|(other, radius)| distance(peak, other) < radius + self.tile_px as f64)
            .collect();
        window
            .pixels()
            .map(|(x, y)| {
                let sound =
                    !self.is_hot(x, y) && !self.photo.is_bad(x, y) && !self.photo.is_clipped(x, y);
                sound
                    && near.iter().all(|(other, radius)| {
                        let (dx, dy) = (x as f64 - other.x as f64, y as f64 - other.y as f64);
                        dx.hypot(dy) > *radius
                    })
            })
            .collect()
    }

    fn fit_pixels(
        &self,
        channel: usize,
        peak: &Peak,
        window: &Window,
        mask: &[bool],
    ) -> Vec<LightPixel> {
        let radius = FIT_OVER_EXTENT * self.found.extent_px.max(2.0) + 1.0;
        let plane = &self.photo.planes[self.photo.plane_of(channel)];
        let background = &self.found.backgrounds[channel];
        window
            .pixels()
            .zip(mask)
            .filter(|((x, y), used)| {
                let (dx, dy) = (*x as f64 - peak.x as f64, *y as f64 - peak.y as f64);
                **used && self.photo.covers(channel, *x, *y) && dx.hypot(dy) <= radius
            })
            .map(|((x, y), _)| {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                LightPixel {
                    x: px,
                    y: py,
                    value: f64::from(plane[y * self.photo.width + x]) - background.level_at(px, py),
                }
            })
            .collect()
    }
}

/// Returns the pixels far brighter than `profile`.
fn defects(pixels: &[LightPixel], profile: &Profile, noise: PixelNoise) -> Vec<LightPixel> {
    let peak = profile.model.iter().copied().fold(0.0, f64::max);
    let pairs = pixels.iter().zip(&profile.model);
    pairs
        .filter(|(pixel, model)| {
            let dark = noise.sigma * noise.sigma + noise.gain * model.max(0.0);
            let limit = (DEFECT_SIGMAS * dark.sqrt()).max(DEFECT_SHARE * peak);
            pixel.value - *model > limit
        })
        .map(|(pixel, _)| *pixel)
        .collect()
}

/// Returns the radius around `other` within which its light spoils pixels of `peak`, px: the wings of a brighter light reach
/// farther.
fn masked_radius(peak: &Peak, other: &Peak, reach: f64) -> f64 {
    let brightness = f64::from((other.height / peak.height).max(1e-3));
    reach * (1.2 + 0.2 * brightness.ln()).clamp(0.6, 2.0)
}

fn distance(a: &Peak, b: &Peak) -> f64 {
    (a.x as f64 - b.x as f64).hypot(a.y as f64 - b.y as f64)
}
