//! Parts of field, channel and depth in which the gap lies.

use super::diagnosis::{Place, Zone as FieldZone};
use super::tiles::TileData;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::profile::PupilChannel;

/// Rings by distance from the axis, and sectors about it.
const RINGS: usize = 3;
const SECTORS: usize = 4;

/// Channel, ring and sector; distance; gaps of the tiles there.
type Zone = ((usize, usize, usize), ObjectDistance, Vec<f64>);

/// The parts of the field with their gaps, largest first: those whose gap stands out of its scatter and of
/// what the lens leaves anyway.
pub(super) fn places(
    tiles: &[&TileData],
    gaps: &[f64],
    channels: &[PupilChannel],
    misfit: f64,
) -> Vec<Place> {
    let farthest = tiles
        .iter()
        .map(|t| t.point.at.radius())
        .fold(1e-9, f64::max);
    let mut zones: Vec<Zone> = Vec::new();
    for (tile, gap) in tiles.iter().zip(gaps) {
        let at = tile.point.at;
        let ring = ((at.radius() / farthest * RINGS as f64) as usize).min(RINGS - 1);
        let turn = at.y.atan2(at.x) / std::f64::consts::TAU;
        let sector = ((turn.rem_euclid(1.0) * SECTORS as f64) as usize).min(SECTORS - 1);
        let key = (tile.of_lens, ring, sector);
        let excess = gap - tile.noise - misfit;
        match zones
            .iter_mut()
            .find(|z| z.0 == key && z.1 == tile.distance)
        {
            Some(zone) => zone.2.push(excess),
            None => zones.push((key, tile.distance, vec![excess])),
        }
    }
    let mut places: Vec<Place> = zones
        .into_iter()
        .map(|((channel, ring, sector), distance, excess)| {
            let n = excess.len() as f64;
            let mean = excess.iter().sum::<f64>() / n;
            let spread: f64 = excess.iter().map(|e| (e - mean).powi(2)).sum();
            // With few tiles the scatter is not known better than the gap itself.
            let sigma = ((spread + mean * mean) / n).sqrt() / n.sqrt();
            Place {
                channel: channels[channel].name.clone(),
                distance,
                zone: FieldZone {
                    radius: [ring, ring + 1].map(|k| k as f64 / RINGS as f64),
                    angle_deg: [sector, sector + 1].map(|k| 360.0 * k as f64 / SECTORS as f64),
                },
                tiles: excess.len(),
                excess: mean,
                z: mean / (sigma + misfit.max(1e-6) / n.sqrt()),
            }
        })
        .filter(|place| place.excess > 0.0 && place.z > LEAST_Z)
        .collect();
    places.sort_by(|a, b| b.excess.total_cmp(&a.excess));
    places
}

/// Standard errors from which on a place is named.
const LEAST_Z: f64 = 1.0;
