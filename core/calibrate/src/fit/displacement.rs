//! Centroid displacement: magnification and distortion per channel, whose differences are lateral colour.

use crate::least_squares;
use crate::measure::MeasuredTile;
use seidel_optics::field::Frame;
use seidel_optics::profile::RadialDisplacement;

/// Fits centroid - ideal = X (magnification + distortion |X|²) by linear least squares.
///
/// Uses the tiles with a known ideal position; returns `None` for fewer than three. To third order the law is
/// complete: coma and magnification give the first term, distortion the second (docs/background/model.md
/// section 3).
pub fn fit_displacement(frame: &Frame, tiles: &[&MeasuredTile]) -> Option<RadialDisplacement> {
    let (mut rows, mut targets) = (Vec::new(), Vec::new());
    let mut count = 0;
    for tile in tiles {
        let Some(ideal) = tile.ideal else { continue };
        count += 1;
        let x = frame.field_point(ideal);
        let centroid = frame.field_point(tile.centroid);
        let r2 = x.x * x.x + x.y * x.y;
        rows.push(vec![x.x, x.x * r2]);
        targets.push(centroid.x - x.x);
        rows.push(vec![x.y, x.y * r2]);
        targets.push(centroid.y - x.y);
    }
    if count < 3 {
        return None;
    }
    let fit = least_squares::solve(&rows, &targets, &vec![1.0; rows.len()]).ok()?;
    Some(RadialDisplacement {
        magnification: fit.values[0],
        distortion: fit.values[1],
        magnification_sigma: fit.sigma[0],
        distortion_sigma: fit.sigma[1],
    })
}
