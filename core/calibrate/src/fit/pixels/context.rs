//! Data of a pixel fit, and the fitting steps shared by all models.

use std::fmt;

use super::defocus_starts;
use super::metric::Metric;
use super::noise_weights;
use super::parameters::{ModelStructure, Parameter, ParameterLayout, Quantity};
use super::pixel_problem::{PixelPoint, PixelProblem};
use super::tile_equations::{FitTile, MisfitSettings, TileParameters};
use super::{PupilSettings, Support, no_initial_estimate};
use crate::fit::initial::initial_estimates;
use crate::least_squares::{Minimum, Stop};
use crate::measure::MeasuredTile;
use crate::stage::Stage;
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::moments::support::TilePixels;
use seidel_optics::observations::ObservationSet;
use seidel_optics::psf::pupil::Detail;

/// Tiles per channel on which initial estimates are compared.
const TRIAL_TILES: usize = 30;
/// Minimum number of tiles per channel.
const MIN_TILES: usize = 6;
/// Initial estimates compared per channel.
const MAX_ESTIMATES: usize = 6;
/// Initial variance of the symmetric blur, px².
pub(super) const INITIAL_BLUR_PX2: f64 = 0.1;
/// Estimates refined where the noise shows that a fit ended in a local minimum.
const MAX_TRIES: usize = 6;
/// Tiles per channel for that check.
const CHECK_TILES: usize = 60;
/// Shares of the reduced fit's progress at which the trials of estimates and these checks end.
const TRIALS_SHARE: f64 = 0.5;
const CHECKS_SHARE: f64 = 0.7;
/// Chi squared per degree of freedom below which only noise is left.
const NOISE_LIMITED_CHI2: f64 = 1.02;
/// Chi squared per degree of freedom above which model error dominates over noise.
const NOISE_DOMINATED_CHI2: f64 = 1.5;

/// Dark pixels fitted around the light of a mosaic tile, px.
const DARK_MARGIN_PX: usize = 3;

/// Stop criteria on few tiles (quick) and on all tiles (thorough).
pub(super) const QUICK: Stop = Stop::at_decrease(8, 1e-2);
pub(super) const THOROUGH: Stop = Stop::at_decrease(20, 1e-3);

/// Tiles per channel on which a model is fitted that gains more parts.
const BETWEEN_TILES: usize = 150;

/// Stop criteria between the parts of a model, of a fit that is refined once all parts are there.
pub(super) const BETWEEN: Stop = Stop::at_decrease(10, 5e-3);

/// Scale of the robust loss in units of the median misfit: in first iterations, and in the last.
pub(super) const LENIENT_TOLERANCE: f64 = 2.0;
pub(super) const STRICT_TOLERANCE: f64 = 0.3;

/// Data and settings of a pixel fit.
pub(super) struct FitContext<'a> {
    pub(super) sets: &'a [ObservationSet],
    pub(super) settings: &'a PupilSettings,
    pub(super) frame: Frame,
    pub(super) measured: &'a [MeasuredTile],
    /// Tiles fitted.
    pub(super) tiles: Vec<FitTile>,
    /// Whether each measured tile is held out.
    pub(super) held_out: Vec<bool>,
    /// Range of vergences, 1/m.
    pub(super) range: (f64, f64),
    /// Distinct vergences of the tiles, rising, 1/m.
    pub(super) vergences: Vec<f64>,
    pub(super) stop_lever_m: f64,
}

/// A lens at some stage of the fit.
#[derive(Clone)]
pub(super) struct FittedLens {
    pub(super) layout: ParameterLayout,
    pub(super) theta: Vec<f64>,
    pub(super) metric: Metric,
    pub(super) converged: bool,
}

impl fmt::Debug for FittedLens {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = f.debug_struct("FittedLens");
        parts.field("theta", &self.theta).finish_non_exhaustive()
    }
}

impl FittedLens {
    fn new(layout: &ParameterLayout, theta: Vec<f64>, metric: Metric) -> Self {
        Self {
            layout: layout.clone(),
            theta,
            metric,
            converged: false,
        }
    }

    /// Returns whether a parameter of effect number `which` has changed to the end of its range.
    pub(super) fn is_at_end_of_range(&self, which: usize) -> bool {
        let effect = self.layout.structure.effects[which];
        (self.layout.parameters.iter().enumerate()).any(|(k, parameter)| match parameter {
            Parameter::Coefficient {
                quantity: Quantity::Effect(of, number),
                power: 0,
                ..
            } if *of == which => {
                let neutral = effect.parameters()[*number].neutral;
                self.theta[k] != neutral && self.layout.is_at_bound(&self.theta, k)
            }
            _ => false,
        })
    }

    /// Returns the lens without its effect number `which`.
    pub(super) fn without(&self, context: &FitContext, which: usize) -> Self {
        let is_removed =
            |quantity: &Quantity| matches!(quantity, Quantity::Effect(of, _) if *of == which);
        let mut structure = self.layout.structure.clone();
        structure.effects.remove(which);
        (structure.polynomials).retain(|freedom| !is_removed(&freedom.quantity));
        for freedom in &mut structure.polynomials {
            if let Quantity::Effect(of, _) = &mut freedom.quantity
                && *of > which
            {
                *of -= 1;
            }
        }
        let parameters = self.layout.parameters.iter().zip(&self.theta);
        let kept = parameters.filter(|(parameter, _)| {
            !matches!(parameter, Parameter::Coefficient { quantity, .. } if is_removed(quantity))
        });
        Self {
            layout: context.layout(structure),
            theta: kept.map(|(_, value)| *value).collect(),
            metric: self.metric,
            converged: false,
        }
    }

    /// Returns how tiles are compared with this lens.
    pub(super) fn misfit_settings(&self, tolerance: f64) -> MisfitSettings {
        MisfitSettings {
            metric: self.metric,
            detail: Detail::FIT,
            tolerance,
        }
    }
}

impl<'a> FitContext<'a> {
    pub(super) fn new(
        sets: &'a [ObservationSet],
        settings: &'a PupilSettings,
        frame: Frame,
        measured: &'a [MeasuredTile],
        held_out: Vec<bool>,
    ) -> Self {
        let tiles: Vec<FitTile> = measured
            .iter()
            .enumerate()
            .filter(|(k, _)| !held_out[*k])
            .map(|(k, m)| fit_tile(sets, &frame, m, k, settings.support))
            .collect();
        let mut vergences: Vec<f64> = tiles.iter().map(|t| t.vergence).collect();
        vergences.sort_by(f64::total_cmp);
        vergences.dedup();
        let range = (
            vergences.first().copied().unwrap_or(0.0),
            vergences.last().copied().unwrap_or(0.0),
        );
        Self {
            sets,
            settings,
            frame,
            measured,
            tiles,
            held_out,
            range,
            vergences,
            stop_lever_m: stop_lever_m(&sets[0]).unwrap_or(0.0),
        }
    }

    pub(super) fn channel_names(&self) -> &[String] {
        &self.sets[0].channels
    }

    pub(super) fn layout(&self, structure: ModelStructure) -> ParameterLayout {
        let channels = self.channel_names().len();
        ParameterLayout::new(structure, channels, self.range, self.stop_lever_m)
    }

    /// Returns the flux and centroid of every tile as measured.
    pub(super) fn tile_parameters(&self, tiles: &[&FitTile]) -> Vec<TileParameters> {
        tiles
            .iter()
            .map(|tile| {
                let m = &self.measured[tile.measured];
                let (x, y) = self.sets[m.set].observations[m.observation].tile_point(m.centroid);
                TileParameters {
                    flux: tile.light.iter().sum::<f64>() / tile.counted_share(),
                    centroid: [x, y],
                }
            })
            .collect()
    }

    /// Minimises the misfit of `tiles` from `theta`.
    pub(super) fn descend(
        &self,
        layout: &ParameterLayout,
        tiles: &[&FitTile],
        theta: &[f64],
        misfit_settings: MisfitSettings,
        stop: Stop,
    ) -> Minimum<PixelPoint> {
        let problem = PixelProblem {
            layout,
            tiles,
            settings: misfit_settings,
        };
        let start = problem.at(theta.to_vec(), self.tile_parameters(tiles));
        problem.minimise(start, stop)
    }

    /// Returns the layout of the reduced model.
    pub(super) fn reduced_layout(&self) -> ParameterLayout {
        let depths = usize::from(self.vergences.len() > 1);
        self.layout(ModelStructure::reduced(depths))
    }

    pub(super) fn all(&self) -> Vec<&FitTile> {
        self.tiles.iter().collect()
    }

    /// Fits the five reduced numbers and a blur per channel, starting from moments. Also returns the estimates compared, best
    /// first, in the same layout.
    ///
    /// Tries several initial estimates on few tiles. Where the noise is known, it stops at the first fit
    /// whose chi squared is consistent with noise.
    ///
    /// # Errors
    /// A channel without an initial estimate, and cancellation in `stage`.
    pub(super) fn fit_reduced(&self, stage: Stage) -> Result<(FittedLens, Vec<Vec<f64>>)> {
        let layout = self.reduced_layout();
        let mut theta = vec![0.0; layout.parameters.len()];
        layout.set_constant_in_all(&mut theta, Quantity::Blur, INITIAL_BLUR_PX2);
        let misfit_settings = MisfitSettings {
            metric: Metric::NaturalSpectrum,
            detail: Detail::COARSE,
            tolerance: LENIENT_TOLERANCE,
        };
        let mut tries = vec![theta.clone(); MAX_TRIES];
        for (channel, name) in self.channel_names().iter().enumerate() {
            let measured: Vec<&MeasuredTile> = self
                .measured
                .iter()
                .zip(&self.held_out)
                .filter(|(m, held_out)| m.channel == channel && !**held_out)
                .map(|(m, _)| m)
                .collect();
            let mine: Vec<&FitTile> = self.tiles.iter().filter(|t| t.channel == channel).collect();
            if mine.len() < MIN_TILES {
                return Err(no_initial_estimate(name));
            }
            let few = subsample(&mine, TRIAL_TILES);
            let mut ranked: Vec<(f64, Vec<f64>)> = Vec::new();
            let mut estimates = initial_estimates(&self.frame, &measured, MAX_ESTIMATES);
            estimates.extend(defocus_starts::by_crossing(&measured));
            estimates.extend(defocus_starts::of_camera(&self.sets[0]));
            let trials = stage.part(0.0, TRIALS_SHARE);
            let trials = trials.part_of(channel, self.channel_names().len());
            let count = estimates.len();
            for (k, start) in estimates.into_iter().enumerate() {
                trials.part_of(k, count).reach(0.0)?;
                let mut trial = theta.clone();
                layout.set_initial(&mut trial, channel, &start);
                let minimum = self.descend(&layout, &few, &trial, misfit_settings, QUICK);
                let size = minimum.point.mean_log_misfit();
                if size.is_finite() {
                    ranked.push((size, minimum.point.theta));
                }
            }
            ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
            ranked.truncate(MAX_TRIES);
            if ranked.is_empty() {
                return Err(no_initial_estimate(name));
            }
            for (rank, trial) in tries.iter_mut().enumerate() {
                let (_, found) = &ranked[rank.min(ranked.len() - 1)];
                layout.copy_channel(trial, found, channel);
            }
        }
        for trial in &mut tries {
            layout.normalise_signs(trial);
        }
        let noisy = self.tiles.iter().all(|t| t.sigma > 0.0);
        let pixels = MisfitSettings {
            metric: Metric::Pixels,
            detail: Detail::FIT,
            tolerance: LENIENT_TOLERANCE,
        };
        let mut best: Option<PixelPoint> = None;
        // Known noise tells a global from a local minimum.
        let few = subsample(&self.all(), CHECK_TILES * self.channel_names().len());
        let checks = stage.part(TRIALS_SHARE, CHECKS_SHARE);
        for (k, trial) in tries
            .iter()
            .enumerate()
            .take(if noisy { MAX_TRIES } else { 0 })
        {
            checks.part_of(k, MAX_TRIES).reach(0.0)?;
            let found = self.descend(&layout, &few, trial, pixels, THOROUGH).point;
            let misfit = found.mean_log_misfit();
            if best.as_ref().is_none_or(|b| misfit < b.mean_log_misfit()) {
                best = Some(found);
            }
            if misfit < NOISE_LIMITED_CHI2.ln() {
                break;
            }
        }
        stage.reach(CHECKS_SHARE)?;
        tries.dedup();
        let Some(best) = best else {
            let fit = self.refine(&layout, tries[0].clone(), Metric::NaturalSpectrum);
            return Ok((fit, tries));
        };
        let best = self.descend(&layout, &self.all(), &best.theta, pixels, THOROUGH);
        // Correlations between neighbours, on which the other metric rests, are not there in a mosaic.
        let is_mosaic = self.tiles.iter().any(|t| t.is_mosaic);
        let noise_decides = is_mosaic || best.point.mean_log_misfit() < NOISE_DOMINATED_CHI2.ln();
        let mut theta = best.point.theta;
        layout.normalise_signs(&mut theta);
        if noise_decides {
            let fit = FittedLens {
                layout,
                metric: Metric::Pixels,
                converged: best.converged,
                theta,
            };
            return Ok((fit, tries));
        }
        let fit = self.refine(&layout, theta, Metric::NaturalSpectrum);
        Ok((fit, tries))
    }

    /// Minimises over all tiles, first with a lenient and then with a strict robust loss.
    pub(super) fn refine(
        &self,
        layout: &ParameterLayout,
        theta: Vec<f64>,
        metric: Metric,
    ) -> FittedLens {
        let start = FittedLens::new(layout, theta, metric);
        let fit = self.refine_with(start, LENIENT_TOLERANCE, THOROUGH);
        if metric == Metric::NaturalSpectrum {
            self.refine_strictly(fit)
        } else {
            // Where noise decides, the loss has its own scale.
            fit
        }
    }

    /// Minimises with a lenient robust loss, over few tiles where there are many: for models that gain more parts.
    pub(super) fn refine_between(
        &self,
        layout: &ParameterLayout,
        theta: Vec<f64>,
        metric: Metric,
    ) -> FittedLens {
        let mut fit = FittedLens::new(layout, theta, metric);
        let few = subsample(&self.all(), BETWEEN_TILES * self.channel_names().len());
        let settings = MisfitSettings {
            detail: Detail::COARSE,
            ..fit.misfit_settings(LENIENT_TOLERANCE)
        };
        let minimum = self.descend(layout, &few, &fit.theta, settings, BETWEEN);
        (fit.theta, fit.converged) = (minimum.point.theta, minimum.converged);
        fit
    }

    /// Minimises over all tiles with a strict robust loss.
    pub(super) fn refine_strictly(&self, fit: FittedLens) -> FittedLens {
        self.refine_with(fit, STRICT_TOLERANCE, THOROUGH)
    }

    fn refine_with(&self, mut fit: FittedLens, tolerance: f64, stop: Stop) -> FittedLens {
        let settings = fit.misfit_settings(tolerance);
        let minimum = self.descend(&fit.layout, &self.all(), &fit.theta, settings, stop);
        fit.theta = minimum.point.theta;
        fit.converged = minimum.converged;
        fit
    }

    /// Refines with the optical axis as two further parameters.
    pub(super) fn free_axis(&self, fit: FittedLens) -> FittedLens {
        let mut structure = fit.layout.structure.clone();
        structure.axis = true;
        let layout = self.layout(structure);
        let theta = layout.transfer(&fit.layout, &fit.theta);
        self.refine(&layout, theta, fit.metric)
    }

    /// Moves the frame's axis to the fitted position and resets the fitted offset to zero.
    pub(super) fn move_frame_to_axis(&mut self, fit: &mut FittedLens) -> Result<()> {
        let [x, y] = fit.layout.axis(&fit.theta);
        self.frame = self
            .frame
            .with_axis(self.frame.image_point(FieldPoint::new(x, y)))?;
        let count = fit.theta.len();
        fit.theta[count - 2..].fill(0.0);
        for tile in &mut self.tiles {
            tile.at = self.measured[tile.measured].field_point(&self.frame);
        }
        Ok(())
    }
}

/// Returns about `count` of `tiles`, evenly spaced in the list.
pub(super) fn subsample<'t>(tiles: &[&'t FitTile], count: usize) -> Vec<&'t FitTile> {
    let step = (tiles.len() as f64 / count as f64).max(1.0);
    (0..)
        .map(|k| (k as f64 * step) as usize)
        .take_while(|k| *k < tiles.len())
        .map(|k| tiles[k])
        .collect()
}

fn fit_tile(
    sets: &[ObservationSet],
    frame: &Frame,
    measured: &MeasuredTile,
    index: usize,
    support: Support,
) -> FitTile {
    let observation = &sets[measured.set].observations[measured.observation];
    let light = observation.light(measured.channel);
    let sigma = observation.noise_sigma[measured.channel];
    let counted = sets[measured.set].counted(observation, measured.channel);
    let pixels = TilePixels {
        tile: &light,
        counted: counted.as_deref(),
        noise_sigma: sigma,
    };
    // The pixels around the light of a mosaic tile are few, and say that no light falls there.
    let margin = if measured.is_mosaic {
        DARK_MARGIN_PX
    } else {
        0
    };
    let counts = pixels.mask_with_margin(support, margin);
    let samples = light.samples().iter().enumerate().map(|(k, v)| {
        let counted = counts.as_ref().is_none_or(|c| c[k]);
        if counted { f64::from(*v) } else { 0.0 }
    });
    let samples: Vec<f64> = samples.collect();
    let size = (light.width(), light.height());
    let weights = match (observation.gain, sigma) {
        (Some(gain), Some(sigma)) if sigma > 0.0 => {
            let expected = noise_weights::smoothed(&samples, counts.as_deref(), size);
            Some(noise_weights::relative(&expected, sigma, gain))
        }
        _ => None,
    };
    FitTile {
        measured: index,
        channel: measured.channel,
        at: measured.field_point(frame),
        vergence: measured.distance.vergence_per_m().unwrap_or(0.0),
        size,
        light: samples,
        counts,
        weights,
        sigma: sigma.unwrap_or(0.0),
        is_mosaic: measured.is_mosaic,
        centroid_unknown: measured.centroid_is_unknown(),
    }
}

/// Returns [`seidel_optics::effects::ScenePoint::stop_lever_m`] for a thin lens with the pupil in its plane.
fn stop_lever_m(set: &ObservationSet) -> Option<f64> {
    let f_m = set.camera.focal_length_mm? * 1e-3;
    let radius_m = f_m / (2.0 * set.camera.f_number?);
    let half_width_m = set.frame.half_width_px() * set.pixel_pitch_um? * 1e-6;
    Some(radius_m * f_m / half_width_m)
}
