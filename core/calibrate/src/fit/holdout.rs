//! Held-out validation: the observations excluded from a fit and used to score it.
//!
//! The split is by zones of the field, because neighbouring PSFs are strongly correlated. Every ring and
//! every direction contributes a zone.

use std::f64::consts::TAU;

use seidel_optics::field::{FieldPoint, Frame};

/// Number of rings, and of sectors per ring.
const ZONES: usize = 5;
/// Distinct places below which single places are held out instead of zones.
const MIN_PLACES_FOR_ZONES: usize = 25;
/// Distinct places below which none is held out.
const MIN_PLACES: usize = 10;
/// Target share of the distinct places.
const TARGET_SHARE: f64 = 0.2;
/// Shares accepted without adding or removing zones.
const ACCEPTED_SHARES: std::ops::RangeInclusive<f64> = 0.1..=0.3;
/// Distance below which two places count as one, px.
const MERGE_RADIUS_PX: f64 = 1.0;

/// Returns which of `places` are held out: about a fifth of the distinct places.
///
/// `places` are ideal positions where known, and tile centres otherwise. A place observed at several
/// distances or in several channels is held out in all of them or in none.
///
/// The distinct places form five rings of equal counts by field radius, each of five sectors of 72 degrees.
/// Ring i holds out its sector (2 i) mod 5. Where that selects less than 10 % or more than 30 % of the
/// places, zones are added or removed greedily towards a fifth. Of 10 to 24 places every fifth by radius is
/// held out; of fewer, none.
pub fn held_out_mask(frame: &Frame, places: &[FieldPoint]) -> Vec<bool> {
    let (distinct, index) = distinct(frame, places);
    let count = distinct.len();
    let kept: Vec<bool> = if count < MIN_PLACES {
        vec![false; count]
    } else if count < MIN_PLACES_FOR_ZONES {
        (0..count).map(|rank| rank % 5 == 2).collect()
    } else {
        let zones: Vec<usize> = distinct
            .iter()
            .enumerate()
            .map(|(rank, at)| rank * ZONES / count * ZONES + sector(*at))
            .collect();
        let chosen = choose(&zones);
        zones.iter().map(|&zone| chosen[zone]).collect()
    };
    index.into_iter().map(|k| kept[k]).collect()
}

/// Returns the distinct places by rising field radius, and the index of each of `places` among them.
fn distinct(frame: &Frame, places: &[FieldPoint]) -> (Vec<FieldPoint>, Vec<usize>) {
    let same = MERGE_RADIUS_PX / frame.half_width_px();
    let square = |at: FieldPoint| at.x * at.x + at.y * at.y;
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (places[a], places[b]);
        square(a)
            .total_cmp(&square(b))
            .then(a.x.total_cmp(&b.x))
            .then(a.y.total_cmp(&b.y))
    });
    let mut found: Vec<FieldPoint> = Vec::new();
    let mut index = vec![0; places.len()];
    for k in order {
        let at = places[k];
        // Places are sorted by radius, so only the last few can lie within the merge radius.
        let known = (0..found.len())
            .rev()
            .take_while(|&f| at.radius() - found[f].radius() <= same)
            .find(|&f| (found[f].x - at.x).hypot(found[f].y - at.y) <= same);
        index[k] = known.unwrap_or_else(|| {
            found.push(at);
            found.len() - 1
        });
    }
    (found, index)
}

/// Returns the index of the 72-degree sector of `at`, counted from the x axis.
fn sector(at: FieldPoint) -> usize {
    let turn = at.y.atan2(at.x).rem_euclid(TAU) / TAU;
    ((turn * ZONES as f64) as usize).min(ZONES - 1)
}

/// Returns which zones are held out; `zones` are those of the distinct places.
fn choose(zones: &[usize]) -> Vec<bool> {
    let mut sizes = [0_usize; ZONES * ZONES];
    for &zone in zones {
        sizes[zone] += 1;
    }
    let mut chosen: Vec<bool> = (0..ZONES * ZONES)
        .map(|zone| zone % ZONES == zone / ZONES * 2 % ZONES)
        .collect();
    let share = |chosen: &[bool]| {
        let kept: usize = (0..chosen.len())
            .filter(|&z| chosen[z])
            .map(|z| sizes[z])
            .sum();
        kept as f64 / zones.len() as f64
    };
    if ACCEPTED_SHARES.contains(&share(&chosen)) {
        return chosen;
    }
    loop {
        let off = (share(&chosen) - TARGET_SHARE).abs();
        let best = (0..chosen.len())
            .map(|zone| {
                let mut other = chosen.clone();
                other[zone] = !other[zone];
                ((share(&other) - TARGET_SHARE).abs(), zone)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((less, zone)) if less < off - 1e-12 => chosen[zone] = !chosen[zone],
            _ => return chosen,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        Frame::new(2000, 1400, None).expect("valid")
    }

    fn grid(columns: usize, rows: usize) -> Vec<FieldPoint> {
        (0..columns * rows)
            .map(|k| {
                let along = |k: usize, count: usize| 2.0 * (k as f64 + 0.5) / count as f64 - 1.0;
                FieldPoint::new(along(k % columns, columns), 0.7 * along(k / columns, rows))
            })
            .collect()
    }

    fn share(kept: &[bool]) -> f64 {
        kept.iter().filter(|k| **k).count() as f64 / kept.len() as f64
    }

    #[test]
    fn a_fifth_of_a_grid_is_held_out_in_every_ring_and_direction() {
        let places = grid(14, 10);
        let kept = held_out_mask(&frame(), &places);
        assert!(ACCEPTED_SHARES.contains(&share(&kept)), "{}", share(&kept));
        let (mut by_radius, _) = distinct(&frame(), &places);
        let mut sectors = [false; ZONES];
        for ring in by_radius.chunks_mut(places.len() / ZONES) {
            let of_ring: Vec<&FieldPoint> = ring
                .iter()
                .filter(|at| kept[places.iter().position(|p| p == *at).expect("known")])
                .collect();
            // The held-out places of a ring are exactly one sector.
            let first = sector(**of_ring.first().expect("every ring gives some"));
            assert!(of_ring.iter().all(|at| sector(**at) == first));
            let all = ring.iter().filter(|at| sector(**at) == first).count();
            assert_eq!(of_ring.len(), all);
            sectors[first] = true;
        }
        assert_eq!(sectors, [true; ZONES]);
    }

    #[test]
    fn repeated_places_share_one_decision() {
        let once = grid(8, 6);
        let nearly = once.iter().map(|p| FieldPoint::new(p.x + 2e-4, p.y - 2e-4));
        let twice: Vec<FieldPoint> = once.iter().copied().chain(nearly).collect();
        let kept = held_out_mask(&frame(), &twice);
        assert_eq!(kept[..48], kept[48..]);
        assert!(ACCEPTED_SHARES.contains(&share(&kept)));
    }

    #[test]
    fn uneven_sets_still_hold_out_about_a_fifth() {
        // One quadrant of the field, one line, and one corner.
        let quarter: Vec<FieldPoint> = grid(16, 16)
            .into_iter()
            .filter(|p| p.x > 0.0 && p.y > 0.0)
            .collect();
        let line: Vec<FieldPoint> = (0..40)
            .map(|k| FieldPoint::new(-0.02 * f64::from(k), 0.0))
            .collect();
        let corner: Vec<FieldPoint> = grid(30, 30)
            .into_iter()
            .filter(|p| p.x < -0.7 && p.y < -0.4)
            .collect();
        for places in [quarter, line, corner] {
            let kept = held_out_mask(&frame(), &places);
            assert!(
                ACCEPTED_SHARES.contains(&share(&kept)),
                "{} of {}",
                share(&kept),
                places.len()
            );
        }
    }

    #[test]
    fn few_places_give_single_ones_and_very_few_none() {
        let kept = held_out_mask(&frame(), &grid(5, 4));
        assert_eq!(kept.iter().filter(|k| **k).count(), 4);
        assert_eq!(held_out_mask(&frame(), &grid(3, 3)), vec![false; 9]);
        assert_eq!(held_out_mask(&frame(), &[]), Vec::<bool>::new());
    }
}
