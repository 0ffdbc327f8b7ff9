//! Centroids of narrow PSFs, placed where the fitted lens agrees best with the pixels.

use rayon::prelude::*;

use super::context::{FitContext, FittedLens, STRICT_TOLERANCE};
use super::tile_equations::{Comparison, FitTile};
use crate::measure::{MeasuredTile, set_origins};

/// Variance of a PSF along x or y, px², below which its centroid by pixels is off by more than a hundredth of a pixel.
const NARROW_VARIANCE_PX2: f64 = 4.0;

/// Returns the measured tiles of `context`. The centroids of narrow ones that were fitted are those at which `fit` agrees
/// best with their pixels.
pub(super) fn registered_tiles(context: &FitContext, fit: &FittedLens) -> Vec<MeasuredTile> {
    let mut measured = context.measured.to_vec();
    let narrow: Vec<&FitTile> = (context.tiles.iter())
        .filter(|tile| {
            let optical = &measured[tile.measured].optical;
            optical.mu20.min(optical.mu02) < NARROW_VARIANCE_PX2
        })
        .collect();
    let settings = fit.misfit_settings(STRICT_TOLERANCE);
    let placed: Vec<[f64; 2]> = narrow
        .par_iter()
        .zip(context.tile_parameters(&narrow))
        .map_init(
            || Comparison::new(settings),
            |comparison, (tile, own)| {
                let pupil = fit
                    .layout
                    .pupil(&fit.theta, tile.channel, tile.at, tile.vergence);
                let own = tile.best_registration(&pupil, own, comparison);
                own.centroid
            },
        )
        .collect();
    for (tile, [x, y]) in narrow.into_iter().zip(placed) {
        let m = &mut measured[tile.measured];
        m.centroid = context.sets[m.set].observations[m.observation].frame_point(x, y);
        m.is_registered = true;
    }
    if measured.iter().all(|m| m.ideal.is_none()) {
        set_origins(context.sets, &mut measured);
    }
    measured
}
