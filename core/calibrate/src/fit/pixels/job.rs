//! A pixel fit under way: its tiles, and the steps that all models share.

use super::descent::{Patience, Problem, Settled, State};
use super::layout::{Layout, Quantity, Structure};
use super::metric::Metric;
use super::tile::{Comparison, FitTile, Own};
use super::{PupilSettings, Support, no_start};
use crate::fit::starts::{Start, starts};
use crate::measure::MeasuredTile;
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::{VergencePoint, VergenceSeries};
use seidel_optics::moments::support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::psf::pupil::Detail;

/// Tiles of a channel on which starts are tried.
const TRIAL_TILES: usize = 30;
/// Fewer tiles of a channel than this cannot tell how its PSFs change over the field.
const LEAST_TILES: usize = 6;
/// Starts that are tried.
const MOST_STARTS: usize = 6;
/// Variance of the symmetric blur to begin with, px².
const FIRST_BLUR_PX2: f64 = 0.1;
/// Starts that are followed to their end where noise says that they led to a wrong place.
const MOST_TRIES: usize = 6;
/// Tiles of a channel on which that is seen.
const CHECK_TILES: usize = 60;
/// Misfit in units of the noise below which nothing but noise is left.
const NOISE_ALONE: f64 = 1.02;
/// Misfit in units of the noise above which it is the model that falls short, not the data.
const NOISE_DECIDES: f64 = 1.5;

/// Quick, on few tiles; thorough, on all; to the end.
pub(super) const QUICK: Patience = Patience {
    steps: 8,
    fall: 1e-2,
};
pub(super) const THOROUGH: Patience = Patience {
    steps: 20,
    fall: 1e-3,
};

/// Shares of the usual misfit below which a tile counts in proportion: first steps, later ones.
pub(super) const LENIENT: f64 = 2.0;
pub(super) const STRICT: f64 = 0.3;

/// What a fit works on.
pub(super) struct Job<'a> {
    pub(super) sets: &'a [ObservationSet],
    pub(super) settings: &'a PupilSettings,
    pub(super) frame: Frame,
    pub(super) measured: &'a [MeasuredTile],
    /// Tiles that take part.
    pub(super) tiles: Vec<FitTile>,
    /// Which measured tiles are kept aside.
    pub(super) aside: Vec<bool>,
    /// Least and largest vergence, 1/m.
    pub(super) range: (f64, f64),
    /// Vergences at which there are tiles, rising.
    pub(super) vergences: Vec<f64>,
    pub(super) stop_lever_m: f64,
}

/// A lens as far as it is fitted.
#[derive(Clone)]
pub(super) struct Fitted {
    pub(super) layout: Layout,
    pub(super) theta: Vec<f64>,
    pub(super) metric: Metric,
    pub(super) converged: bool,
}

impl Fitted {
    /// How tiles are held against it.
    pub(super) fn comparison(&self, tolerance: f64) -> Comparison {
        Comparison {
            metric: self.metric,
            detail: Detail::FIT,
            tolerance,
        }
    }
}

impl<'a> Job<'a> {
    pub(super) fn new(
        sets: &'a [ObservationSet],
        settings: &'a PupilSettings,
        frame: Frame,
        measured: &'a [MeasuredTile],
        aside: Vec<bool>,
    ) -> Self {
        let tiles: Vec<FitTile> = measured
            .iter()
            .enumerate()
            .filter(|(k, _)| !aside[*k])
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
            aside,
            range,
            vergences,
            stop_lever_m: stop_lever_m(&sets[0]).unwrap_or(0.0),
        }
    }

    pub(super) fn channel_names(&self) -> &[String] {
        &self.sets[0].channels
    }

    pub(super) fn layout(&self, structure: Structure) -> Layout {
        let channels = self.channel_names().len();
        Layout::new(structure, channels, self.range, self.stop_lever_m)
    }

    /// A problem's start: the lens as given, every tile's light and centroid as measured.
    pub(super) fn state(&self, tiles: &[&FitTile], theta: &[f64]) -> State {
        let own = tiles
            .iter()
            .map(|tile| {
                let m = &self.measured[tile.measured];
                let (x, y) = self.sets[m.set].observations[m.observation].tile_point(m.centroid);
                Own {
                    light: tile.light.iter().sum(),
                    centroid: [x, y],
                }
            })
            .collect();
        State {
            theta: theta.to_vec(),
            own,
        }
    }

    /// Descends on `tiles` from `theta`.
    pub(super) fn descend(
        &self,
        layout: &Layout,
        tiles: &[&FitTile],
        theta: &[f64],
        comparison: Comparison,
        patience: Patience,
    ) -> Settled {
        let problem = Problem {
            layout,
            tiles,
            comparison,
        };
        problem.descend(self.state(tiles, theta), patience)
    }

    pub(super) fn all(&self) -> Vec<&FitTile> {
        self.tiles.iter().collect()
    }

    /// Five numbers and a blur a channel, from moments to pixels.
    pub(super) fn begin(&self) -> Result<Fitted> {
        let depths = usize::from(self.vergences.len() > 1);
        let layout = self.layout(Structure::reduced(depths));
        let mut theta = vec![0.0; layout.slots.len()];
        layout.set(&mut theta, Quantity::Blur, FIRST_BLUR_PX2);
        let comparison = Comparison {
            metric: Metric::Picture,
            detail: Detail::COARSE,
            tolerance: LENIENT,
        };
        let mut tries = vec![theta.clone(); MOST_TRIES];
        for (channel, name) in self.channel_names().iter().enumerate() {
            let measured: Vec<&MeasuredTile> = self
                .measured
                .iter()
                .zip(&self.aside)
                .filter(|(m, aside)| m.channel == channel && !**aside)
                .map(|(m, _)| m)
                .collect();
            let mine: Vec<&FitTile> = self.tiles.iter().filter(|t| t.channel == channel).collect();
            if mine.len() < LEAST_TILES {
                return Err(no_start(name));
            }
            let few = spread(&mine, TRIAL_TILES);
            let mut ranked: Vec<(f64, Vec<f64>)> = Vec::new();
            let mut begin = starts(&self.frame, &measured, MOST_STARTS);
            begin.extend(crossings(&measured));
            for start in begin {
                let mut trial = theta.clone();
                layout.start(&mut trial, channel, &start);
                let settled = self.descend(&layout, &few, &trial, comparison, QUICK);
                let size = settled.typical();
                if size.is_finite() {
                    ranked.push((size, settled.state.theta));
                }
            }
            ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
            ranked.truncate(MOST_TRIES);
            if ranked.is_empty() {
                return Err(no_start(name));
            }
            for (rank, trial) in tries.iter_mut().enumerate() {
                let (_, found) = &ranked[rank.min(ranked.len() - 1)];
                layout.copy_channel(trial, found, channel);
            }
        }
        for trial in &mut tries {
            layout.right_way_round(trial);
        }
        let noisy = self.tiles.iter().all(|t| t.sigma > 0.0);
        let pixels = Comparison {
            metric: Metric::Pixels,
            detail: Detail::FIT,
            tolerance: LENIENT,
        };
        let mut best: Option<Settled> = None;
        // Where the noise is known it is also known whether a start led to the right place.
        let few = spread(&self.all(), CHECK_TILES * self.channel_names().len());
        for trial in tries.iter().take(if noisy { MOST_TRIES } else { 0 }) {
            let settled = self.descend(&layout, &few, trial, pixels, THOROUGH);
            let right = settled.typical() < NOISE_ALONE.ln();
            if best
                .as_ref()
                .is_none_or(|b| settled.typical() < b.typical())
            {
                best = Some(settled);
            }
            if right {
                break;
            }
        }
        let Some(best) = best else {
            return Ok(self.refine(&layout, tries.swap_remove(0), Metric::Picture));
        };
        let best = self.descend(&layout, &self.all(), &best.state.theta, pixels, THOROUGH);
        let noise_decides = best.typical() < NOISE_DECIDES.ln();
        let mut theta = best.state.theta;
        layout.right_way_round(&mut theta);
        if noise_decides {
            return Ok(Fitted {
                layout,
                metric: Metric::Pixels,
                converged: best.converged,
                theta,
            });
        }
        Ok(self.refine(&layout, theta, Metric::Picture))
    }

    /// Descends on all tiles, leniently and then strictly.
    pub(super) fn refine(&self, layout: &Layout, theta: Vec<f64>, metric: Metric) -> Fitted {
        let all = self.all();
        let mut fitted = Fitted {
            layout: layout.clone(),
            theta,
            metric,
            converged: false,
        };
        let descend = |fitted: &mut Fitted, tolerance: f64| {
            let comparison = fitted.comparison(tolerance);
            let settled = self.descend(layout, &all, &fitted.theta, comparison, THOROUGH);
            fitted.theta.clone_from(&settled.state.theta);
            fitted.converged = settled.converged;
        };
        descend(&mut fitted, LENIENT);
        if metric == Metric::Picture {
            descend(&mut fitted, STRICT);
        }
        fitted
    }

    /// Refines with the optical axis free as well.
    pub(super) fn free_axis(&self, fit: Fitted) -> Fitted {
        let mut structure = fit.layout.structure.clone();
        structure.axis = true;
        let layout = self.layout(structure);
        let theta = layout.carry(&fit.layout, &fit.theta);
        self.refine(&layout, theta, fit.metric)
    }

    /// Moves the frame's axis to where the fit found it; the fit's own offset becomes zero.
    pub(super) fn settle_axis(&mut self, fit: &mut Fitted) -> Result<()> {
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

/// Starts of defocus alone that passes through focus before, between and beyond the distances of
/// `tiles`: what moments drowned in noise may have missed.
fn crossings(tiles: &[&MeasuredTile]) -> Vec<Start> {
    let mut radii: Vec<(f64, Vec<f64>)> = Vec::new();
    for tile in tiles {
        let Some(v) = tile.distance.vergence_per_m() else {
            return Vec::new();
        };
        // An even disc of radius r has a trace of r²/2.
        let radius = (2.0 * tile.optical.trace().max(0.0)).sqrt();
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
                all.sort_by(f64::total_cmp);
                let median = all[all.len() / 2];
                VergencePoint {
                    vergence_per_m: *v,
                    value: if k < crossing { -median } else { median },
                    sigma: 0.0,
                }
            });
            let line = VergenceSeries::fit_line(&signed.collect::<Vec<_>>());
            Start {
                alpha: [line.coefficients[0], line.coefficients[1]],
                beta: 0.0,
                gamma: 0.0,
                delta: 0.0,
                phi: 0.0,
                misfit: f64::INFINITY,
            }
        })
        .collect()
}

/// About `count` of `tiles`, spread over them.
pub(super) fn spread<'t>(tiles: &[&'t FitTile], count: usize) -> Vec<&'t FitTile> {
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
    let counts = support::mask(&light, sigma, support);
    let samples = light.samples().iter().enumerate().map(|(k, v)| {
        let counted = counts.as_ref().is_none_or(|c| c[k]);
        if counted { f64::from(*v) } else { 0.0 }
    });
    FitTile {
        measured: index,
        channel: measured.channel,
        at: measured.field_point(frame),
        vergence: measured.distance.vergence_per_m().unwrap_or(0.0),
        size: (light.width(), light.height()),
        light: samples.collect(),
        counts,
        sigma: sigma.unwrap_or(0.0),
    }
}

/// See [`seidel_optics::effects::ScenePoint::stop_lever_m`]; the pupil is taken to lie in a thin lens.
fn stop_lever_m(set: &ObservationSet) -> Option<f64> {
    let f_m = set.camera.focal_length_mm? * 1e-3;
    let radius_m = f_m / (2.0 * set.camera.f_number?);
    let half_width_m = set.frame.half_width_px() * set.pixel_pitch_um? * 1e-6;
    Some(radius_m * f_m / half_width_m)
}
