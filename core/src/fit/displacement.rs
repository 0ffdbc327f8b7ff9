//! Where PSFs land: centroid against ideal position, which per channel is lateral colour.

use super::linear;
use super::measure::MeasuredTile;
use crate::field::Frame;
use crate::lens::VergenceSeries;
use crate::profile::Displacement;

/// Least squares of centroid - ideal = X (magnification + distortion |X|²) over the tiles that know
/// their ideal position; `None` where fewer than three do. To third order this is the whole law:
/// coma and a change of magnification give the first term, distortion the second (docs/background/model.md section 3).
pub fn fit_displacement(frame: &Frame, tiles: &[&MeasuredTile]) -> Option<Displacement> {
    let (mut rows, mut targets) = (Vec::new(), Vec::new());
    let mut count = 0;
    for tile in tiles {
        let Some(ideal) = tile.ideal else { continue };
        count += 1;
        let x = frame.field_point(ideal);
        let seen = frame.field_point(tile.centroid);
        let r2 = x.x * x.x + x.y * x.y;
        rows.push(vec![x.x, x.x * r2]);
        targets.push(seen.x - x.x);
        rows.push(vec![x.y, x.y * r2]);
        targets.push(seen.y - x.y);
    }
    if count < 3 {
        return None;
    }
    let fit = linear::solve(&rows, &targets, &vec![1.0; rows.len()]).ok()?;
    Some(Displacement {
        magnification: fit.values[0],
        distortion: fit.values[1],
        magnification_sigma: fit.sigma[0],
        distortion_sigma: fit.sigma[1],
    })
}

/// Magnification and distortion as least-squares lines in vergence through what was measured at some
/// vergences (1/m): to third order distortion is linear in it (docs/background/model.md section 5). One makes them
/// constant, none zero.
pub fn lines(measured: &[(f64, Displacement)]) -> [VergenceSeries; 2] {
    let of = |value: fn(&Displacement) -> (f64, f64)| {
        line(
            &measured
                .iter()
                .map(|(v, d)| (*v, value(d)))
                .collect::<Vec<_>>(),
        )
    };
    [
        of(|d| (d.magnification, d.magnification_sigma)),
        of(|d| (d.distortion, d.distortion_sigma)),
    ]
}

/// The least-squares line in vergence through points (vergence, (value, its standard error)); a
/// constant through one, zero through none.
pub fn line(points: &[(f64, (f64, f64))]) -> VergenceSeries {
    if points.is_empty() {
        return VergenceSeries::constant(0.0);
    }
    let count = points.len() as f64;
    let mean_v = points.iter().map(|p| p.0).sum::<f64>() / count;
    let mean = points.iter().map(|p| p.1.0).sum::<f64>() / count;
    let spread: f64 = points.iter().map(|p| (p.0 - mean_v).powi(2)).sum();
    let mean_sigma = points.iter().map(|p| p.1.1.powi(2)).sum::<f64>().sqrt() / count;
    if spread == 0.0 {
        return VergenceSeries {
            sigma: vec![mean_sigma],
            ..VergenceSeries::constant(mean)
        };
    }
    let lever = |p: &(f64, (f64, f64))| (p.0 - mean_v) / spread;
    let slope: f64 = points.iter().map(|p| lever(p) * (p.1.0 - mean)).sum();
    let slope_sigma = points
        .iter()
        .map(|p| (lever(p) * p.1.1).powi(2))
        .sum::<f64>()
        .sqrt();
    VergenceSeries {
        sigma: vec![mean_sigma.hypot(slope_sigma * mean_v), slope_sigma],
        ..VergenceSeries::new(vec![mean - slope * mean_v, slope])
    }
}
