//! Adequacy of a fitted model: the residuals of held-out tiles, and their pattern.
//!
//! Residuals are compared as angular harmonics on rings about the centroid, c_m(r) = sum of the residual times e^{-i m phi},
//! which do not depend on how a PSF lies on the pixel grid. A smooth field of them, interpolated from the fitted tiles,
//! predicts part of the residuals of held-out tiles. What it predicts is no noise: a better model could describe it. Tiles count by
//! weights that fall with their noise: those of faint lights show the errors of their background and sum.

use std::f64::consts::TAU;

use seidel_fourier::Complex;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::FieldPoint;
use seidel_optics::profile::{Adequacy, FieldPattern, FieldZone, ResidualPattern, WorstPlace};

use crate::score::PreparedTile;

/// Largest number of periods about the centroid that is distinguished.
const MAX_PERIODS: usize = 9;
/// Neighbours from which a residual is interpolated.
const NEIGHBOURS: usize = 6;
/// Noise, relative to the power of a tile, at which its weight has fallen to a half.
const NOISE_WEIGHT_KNEE: f64 = 0.01;
/// Share of the energy that a mean over the field must hold to be called its pattern.
const MIN_PATTERN_SHARE: f64 = 0.4;

/// Residual of one tile, relative to the norm of the tile.
#[derive(Debug, Clone)]
pub(super) struct TileResidual {
    at: FieldPoint,
    /// Squared norm.
    pub(super) gap: f64,
    /// Squared norm that noise explains.
    noise: f64,
    /// Harmonics 0..=[`MAX_PERIODS`], ring by ring.
    harmonics: Vec<Complex<f64>>,
}

/// Residuals of one channel at one distance.
pub(super) struct Group {
    pub(super) channel: String,
    pub(super) distance: ObjectDistance,
    pub(super) held_out: Vec<TileResidual>,
    pub(super) fitted: Vec<TileResidual>,
}

impl TileResidual {
    /// Compares `tile` with the predicted `kernel`, both on squares of `side` px.
    pub(super) fn new(tile: &PreparedTile, kernel: &[f64], side: usize) -> Self {
        let compared = tile.compared_with(kernel);
        let power: f64 = compared.iter().map(|v| v * v).sum();
        let norm = power.sqrt();
        let rings = side / 2 + 1;
        let mut harmonics = vec![Complex::new(0.0, 0.0); rings * (MAX_PERIODS + 1)];
        let mut counts = vec![0_u32; rings];
        let mut gap = 0.0;
        for (k, (measured, predicted)) in compared.iter().zip(kernel).enumerate() {
            let residual = (measured - predicted) / norm;
            gap += residual * residual;
            let x = (k % side) as f64 + 0.5 - tile.centroid.0;
            let y = (k / side) as f64 + 0.5 - tile.centroid.1;
            let ring = x.hypot(y).round() as usize;
            if ring >= rings {
                continue;
            }
            counts[ring] += 1;
            let turn = Complex::from_polar(1.0, -y.atan2(x));
            let mut factor = Complex::new(residual, 0.0);
            for sum in &mut harmonics[ring * (MAX_PERIODS + 1)..][..=MAX_PERIODS] {
                *sum += factor;
                factor *= turn;
            }
        }
        for (ring, count) in counts.into_iter().enumerate() {
            let scale = 1.0 / f64::from(count.max(1)).sqrt();
            for value in &mut harmonics[ring * (MAX_PERIODS + 1)..][..=MAX_PERIODS] {
                *value *= scale;
            }
        }
        Self {
            at: tile.field,
            gap,
            noise: tile.noise_power / power,
            harmonics,
        }
    }

    pub(super) fn excess(&self) -> f64 {
        self.gap - self.noise
    }

    fn weight(&self) -> f64 {
        NOISE_WEIGHT_KNEE / (NOISE_WEIGHT_KNEE + self.noise)
    }

    /// Returns the harmonics with `periods` periods, one a ring.
    fn with_periods(&self, periods: usize) -> impl Iterator<Item = Complex<f64>> {
        let rings = self.harmonics.chunks_exact(MAX_PERIODS + 1);
        rings.map(move |ring| ring[periods])
    }

    /// Returns the energy with `periods` periods.
    fn energy(&self, periods: usize) -> f64 {
        let sum: f64 = self.with_periods(periods).map(|c| c.norm_sqr()).sum();
        sum * multiplicity(periods)
    }
}

/// The number of times that a harmonic occurs among positive and negative ones.
fn multiplicity(periods: usize) -> f64 {
    if periods == 0 { 1.0 } else { 2.0 }
}

/// Returns how well the model describes the lens of `groups`, in a frame whose corner has that radius.
pub(super) fn of(groups: &[Group], corner_radius: f64) -> Adequacy {
    let all: Vec<&TileResidual> = groups.iter().flat_map(|g| &g.held_out).collect();
    let excess_gap = weighted_mean(all.iter().copied(), TileResidual::excess).max(0.0);
    Adequacy {
        noise_gap: weighted_mean(all.iter().copied(), |r| r.noise),
        excess_gap,
        systematic_gap: systematic_gap(groups).min(excess_gap),
        worst: worst_place(groups, corner_radius),
        pattern: pattern(groups),
    }
}

/// Returns the mean of `value` by the weights of `tiles`; zero without any.
fn weighted_mean<'a>(
    tiles: impl Iterator<Item = &'a TileResidual>,
    value: impl Fn(&TileResidual) -> f64,
) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for tile in tiles {
        sum += tile.weight() * value(tile);
        weights += tile.weight();
    }
    sum / f64::max(weights, f64::MIN_POSITIVE)
}

/// Returns the mean gap that residuals interpolated from fitted tiles remove from held-out ones.
fn systematic_gap(groups: &[Group]) -> f64 {
    let (mut product, mut power, mut weights) = (0.0, 0.0, 0.0);
    for group in groups {
        for residual in &group.held_out {
            weights += residual.weight();
            let expected = interpolated(residual.at, &group.fitted);
            for (k, (own, expected)) in residual.harmonics.iter().zip(&expected).enumerate() {
                let times = residual.weight() * multiplicity(k % (MAX_PERIODS + 1));
                product += times * (own.conj() * expected).re;
                power += times * expected.norm_sqr();
            }
        }
    }
    if power == 0.0 || product <= 0.0 {
        return 0.0;
    }
    // The interpolated field, scaled by least squares.
    product * product / power / weights
}

/// Returns the harmonics at `at`, interpolated from the nearest of `fitted`, with weights that fall with distance and noise.
fn interpolated(at: FieldPoint, fitted: &[TileResidual]) -> Vec<Complex<f64>> {
    let mut near: Vec<(f64, &TileResidual)> = fitted
        .iter()
        .map(|r| ((r.at.x - at.x).hypot(r.at.y - at.y), r))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(NEIGHBOURS);
    let Some((farthest, first)) = near.last() else {
        return Vec::new();
    };
    let reach = farthest.max(1e-9);
    let mut sum = vec![Complex::new(0.0, 0.0); first.harmonics.len()];
    let mut weights = 0.0;
    for (distance, residual) in near {
        let weight = residual.weight() * (-2.0 * (distance / reach).powi(2)).exp();
        weights += weight;
        for (sum, value) in sum.iter_mut().zip(&residual.harmonics) {
            *sum += value * weight;
        }
    }
    sum.iter_mut().for_each(|v| *v /= weights);
    sum
}

fn worst_place(groups: &[Group], corner_radius: f64) -> WorstPlace {
    let zone_of = |r: &TileResidual| FieldZone::at_radius(r.at.radius() / corner_radius);
    let mut worst: Option<(f64, &Group, FieldZone)> = None;
    for group in groups {
        for zone in FieldZone::ALL {
            let within = || group.held_out.iter().filter(|r| zone_of(r) == zone);
            let mean = weighted_mean(within(), TileResidual::excess);
            if within().next().is_some() && worst.is_none_or(|(most, ..)| mean > most) {
                worst = Some((mean, group, zone));
            }
        }
    }
    let (excess_gap, group, zone) = worst.expect("there are held-out tiles");
    let is_there = |g: &Group, r: &TileResidual| {
        (&g.channel, g.distance, zone_of(r)) == (&group.channel, group.distance, zone)
    };
    let elsewhere: Vec<&TileResidual> = groups
        .iter()
        .flat_map(|g| g.held_out.iter().filter(move |r| !is_there(g, r)))
        .collect();
    WorstPlace {
        channel: group.channel.clone(),
        distance: group.distance,
        zone,
        excess_gap,
        elsewhere_gap: (!elsewhere.is_empty())
            .then(|| weighted_mean(elsewhere.into_iter(), TileResidual::excess).max(0.0)),
    }
}

/// Returns the periods of most energy, and how their harmonics change over the field.
fn pattern(groups: &[Group]) -> ResidualPattern {
    let tiles = || {
        groups
            .iter()
            .flat_map(|g| g.held_out.iter().chain(&g.fitted))
    };
    let energy = |periods: usize| {
        let each = tiles().map(|r| r.weight() * r.energy(periods));
        each.sum::<f64>()
    };
    let energies: Vec<f64> = (0..=MAX_PERIODS).map(energy).collect();
    let total: f64 = energies.iter().sum();
    let (periods, most) = (energies.iter().copied().enumerate())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .expect("there are harmonics");
    // A pattern of m periods that turns with the meridian by theta has the phase e^{-i m theta}.
    let share_of_mean = |turns: bool| {
        let kept: f64 = groups.iter().map(|g| mean_energy(g, periods, turns)).sum();
        kept / most.max(f64::MIN_POSITIVE)
    };
    let (constant, meridional) = (share_of_mean(false), share_of_mean(true));
    let field = if constant.max(meridional) < MIN_PATTERN_SHARE {
        FieldPattern::Varying
    } else if constant >= meridional {
        FieldPattern::Constant
    } else {
        FieldPattern::Meridional
    };
    ResidualPattern {
        periods,
        share: most / total.max(f64::MIN_POSITIVE),
        field,
    }
}

/// Returns the energy that the mean of the harmonics over the field holds, for all tiles of `group`.
fn mean_energy(group: &Group, periods: usize, turns: bool) -> f64 {
    let tiles = || group.held_out.iter().chain(&group.fitted);
    let weights: f64 = tiles().map(TileResidual::weight).sum();
    let rings = group.held_out[0].harmonics.len() / (MAX_PERIODS + 1);
    let mut mean = vec![Complex::new(0.0, 0.0); rings];
    for residual in tiles() {
        let angle = residual.at.y.atan2(residual.at.x).rem_euclid(TAU);
        let turned = if turns { periods as f64 * angle } else { 0.0 };
        let phase = Complex::from_polar(residual.weight() / weights, turned);
        for (sum, value) in mean.iter_mut().zip(residual.with_periods(periods)) {
            *sum += value * phase;
        }
    }
    weights * mean.iter().map(|c| c.norm_sqr()).sum::<f64>() * multiplicity(periods)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn residual(x: f64, gap: f64) -> TileResidual {
        TileResidual {
            at: FieldPoint { x, y: 0.0 },
            gap,
            noise: 0.0,
            harmonics: vec![Complex::new(0.0, 0.0); MAX_PERIODS + 1],
        }
    }

    /// Returns three tiles from the axis to the corner at two distances; the last has a gap of its own.
    fn groups(corner_gap: f64) -> [Group; 2] {
        let group = |metres, gaps: [f64; 3]| Group {
            channel: "G".into(),
            distance: ObjectDistance::Metres(metres),
            held_out: (0..3).map(|k| residual(0.4 * k as f64, gaps[k])).collect(),
            fitted: Vec::new(),
        };
        [group(1.0, [1e-3; 3]), group(2.0, [1e-3, 1e-3, corner_gap])]
    }

    #[test]
    fn a_model_that_fails_in_one_zone_is_right_elsewhere() {
        let one = of(&groups(0.1), 1.0);
        assert!(one.fails_in_one_place());
        assert_eq!(one.worst.zone, FieldZone::Edge);
        assert_eq!(one.worst.distance, ObjectDistance::Metres(2.0));
        assert!((one.worst.elsewhere_gap.expect("other tiles") - 1e-3).abs() < 1e-9);
        let mut all = groups(0.1);
        all[0].held_out[0].gap = 0.1;
        assert!(!of(&all, 1.0).fails_in_one_place());
        assert!(!of(&groups(1e-3), 1.0).fails_in_one_place());
    }
}
