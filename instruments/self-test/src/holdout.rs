//! The share of the gap that a corrected lens closes on the held-out places of a case.

use seidel_core::{Error, ImagePoint, LensProfile, Observation, ObservationSet, Predictor, Result};
use seidel_optics::predict::predict_set;

/// Step of the finite differences of a shift, px, and the number of Gauss-Newton steps.
const STEP_PX: f64 = 0.1;
const STEPS: usize = 2;

/// The positions that the diagnosed set states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Positions {
    /// Ideal positions: every shift is part of the gap.
    Ideal,
    /// None: a shift common to all channels of an observation is not part of the gap.
    Unknown,
}

/// Returns the share of the gap of `given` on `holdout` that `corrected` closes; 0 without a gap. `holdout` states ideal positions.
///
/// # Errors
/// A set that does not suit the lenses, and a share that is not finite.
pub(crate) fn closed_share(
    given: &LensProfile,
    corrected: &LensProfile,
    holdout: &ObservationSet,
    positions: Positions,
) -> Result<f64> {
    let before = mean_gap(given, holdout, positions)?;
    if before <= 0.0 {
        return Ok(0.0);
    }
    let closed = 1.0 - mean_gap(corrected, holdout, positions)? / before;
    if closed.is_finite() {
        Ok(closed)
    } else {
        Err(Error::new(
            "diagnosis: share truly closed",
            format!("is {closed}"),
            "report this as a bug, with the seed and the count",
        ))
    }
}

/// Returns the mean gap over tiles: |o - p|² / |o|², less the contribution of the stated noise. o is the observed tile, p
/// the predicted one, both of unit sum.
pub(crate) fn mean_gap(
    lens: &LensProfile,
    set: &ObservationSet,
    positions: Positions,
) -> Result<f64> {
    let predictor = Predictor::new(lens)?;
    let predicted = match positions {
        Positions::Ideal => predict_set(&predictor, set, predictor.default_model())?,
        Positions::Unknown => aligned(&predictor, set)?,
    };
    let (mut sum, mut count) = (0.0, 0_usize);
    for (observed, predicted) in set.observations.iter().zip(&predicted.observations) {
        for (channel, tile) in unit_tiles(observed).iter().enumerate() {
            let sigma =
                observed.noise_sigma[channel].unwrap_or(0.0) / observed.light(channel).sum();
            let predicted = predicted.tiles[channel].samples();
            let (mut difference, mut norm) = (0.0, 0.0);
            for (o, p) in tile.iter().zip(predicted) {
                difference += (o - f64::from(*p)).powi(2);
                norm += o * o;
            }
            sum += (difference - tile.len() as f64 * sigma * sigma) / norm;
            count += 1;
        }
    }
    Ok(sum / count.max(1) as f64)
}

/// Returns the light of each channel of `observation`, of unit sum.
fn unit_tiles(observation: &Observation) -> Vec<Vec<f64>> {
    let unit = |channel: usize| {
        let light = observation.light(channel);
        let sum = light.sum();
        light
            .samples()
            .iter()
            .map(|v| f64::from(*v) / sum)
            .collect()
    };
    (0..observation.tiles.len()).map(unit).collect()
}

/// Predicts `set` with each observation shifted, in all channels alike, to where it agrees best with the pixels: from the mean
/// centroid by Gauss-Newton steps.
fn aligned(lens: &Predictor, set: &ObservationSet) -> Result<ObservationSet> {
    let predict = |set: &ObservationSet| predict_set(lens, set, lens.default_model());
    let mut placed = set.clone();
    let first = predict(&placed)?;
    for (observation, predicted) in placed.observations.iter_mut().zip(&first.observations) {
        let [from, to] = [predicted, observation].map(mean_centroid);
        shift(observation, [to[0] - from[0], to[1] - from[1]]);
    }
    for _ in 0..STEPS {
        let moved = |by: [f64; 2]| {
            let mut moved = placed.clone();
            let all = moved.observations.iter_mut();
            all.for_each(|observation| shift(observation, by));
            predict(&moved)
        };
        let (here, right, below) = (
            moved([0.0; 2])?,
            moved([STEP_PX, 0.0])?,
            moved([0.0, STEP_PX])?,
        );
        for (k, observation) in placed.observations.iter_mut().enumerate() {
            let pictures = [&here, &right, &below].map(|set| &set.observations[k]);
            if let Some(step) = least_squares_shift(observation, pictures) {
                shift(observation, step);
            }
        }
    }
    predict(&placed)
}

/// Moves the ideal position of `observation`, px.
fn shift(observation: &mut Observation, by: [f64; 2]) {
    if let Some(ideal) = &mut observation.ideal {
        *ideal = ImagePoint::new(ideal.x_px + by[0], ideal.y_px + by[1]);
    }
}

/// Returns the mean centroid of the tiles of `observation` over channels, px.
fn mean_centroid(observation: &Observation) -> [f64; 2] {
    let tiles = unit_tiles(observation);
    let mut mean = [0.0; 2];
    for (tile, pixels) in tiles.iter().zip(&observation.tiles) {
        for (index, v) in tile.iter().enumerate() {
            let place = [index % pixels.width(), index / pixels.width()];
            mean = [0, 1].map(|axis| mean[axis] + v * place[axis] as f64 / tiles.len() as f64);
        }
    }
    mean
}

/// Returns the shift that brings the prediction `here` closest to `observed`, px; `right` and `below` are predictions a step away.
fn least_squares_shift(
    observed: &Observation,
    [here, right, below]: [&Observation; 3],
) -> Option<[f64; 2]> {
    let (mut xx, mut xy, mut yy, mut x, mut y) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (channel, tile) in unit_tiles(observed).iter().enumerate() {
        let norm: f64 = tile.iter().map(|v| v * v).sum();
        let samples = [here, right, below].map(|set| set.tiles[channel].samples());
        for (k, o) in tile.iter().enumerate() {
            let [p, px, py] = samples.map(|s| f64::from(s[k]));
            let (dx, dy) = ((px - p) / STEP_PX, (py - p) / STEP_PX);
            xx += dx * dx / norm;
            xy += dx * dy / norm;
            yy += dy * dy / norm;
            x += dx * (o - p) / norm;
            y += dy * (o - p) / norm;
        }
    }
    let determinant = xx * yy - xy * xy;
    (determinant > 0.0).then(|| {
        [
            (yy * x - xy * y) / determinant,
            (xx * y - xy * x) / determinant,
        ]
    })
}
