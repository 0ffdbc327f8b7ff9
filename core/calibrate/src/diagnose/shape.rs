//! Decomposition of a residual: core and skirt, and orders of image derivatives.

use super::diagnosis::{Order, Shape, TileGap};
use super::hypothesis::Hypothesis;
use super::prediction::{TilePredictor, central_difference};
use super::tiles::TileData;
use seidel_optics::numeric::{dot, median};
use seidel_optics::psf::pupil::Detail;

/// Orders of PSF changes, with their numbers of image derivatives.
const ORDERS: [(&str, usize); 4] = [
    ("position", 2),
    ("size", 1),
    ("ellipticity", 2),
    ("skew", 4),
];

/// Decomposes the residual of `tiles` from `hypothesis` at `theta`.
pub(super) fn shape(tiles: &[&TileData], hypothesis: &Hypothesis, theta: &[f64]) -> Shape {
    let mut predictor = TilePredictor::default();
    let mut picture = Vec::new();
    let (mut core, mut total) = (0.0, 0.0);
    let mut explained = [0.0; ORDERS.len()];
    let mut chi2 = [0.0; ORDERS.len() + 1];
    let mut freedom = [0.0; ORDERS.len() + 1];
    for tile in tiles {
        let values = hypothesis.values(theta, tile.of_lens);
        predictor.predict(hypothesis, &values, *tile, Detail::COARSE, &mut picture);
        let mut residual = tile.residual(&picture);
        let energy = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>() / tile.norm;
        let whole = energy(&residual);
        total += whole - tile.noise;
        core += core_energy(tile, &picture, &residual) / tile.norm
            - tile.noise * core_share(tile, &picture);
        let variance = tile.sigma.powi(2).max(1e-300);
        let mut taken: Vec<Vec<f64>> = Vec::new();
        let derivatives = derivatives(tile, &picture);
        let mut first = 0;
        for (k, (_, count)) in ORDERS.iter().enumerate() {
            for derivative in &derivatives[first..first + count] {
                let mut direction = derivative.clone();
                tile.mask(&mut direction);
                for earlier in &taken {
                    let along = dot(&direction, earlier);
                    direction
                        .iter_mut()
                        .zip(earlier)
                        .for_each(|(d, e)| *d -= along * e);
                }
                let norm = dot(&direction, &direction).sqrt();
                if norm < 1e-12 {
                    continue;
                }
                direction.iter_mut().for_each(|d| *d /= norm);
                let along = dot(&residual, &direction);
                residual
                    .iter_mut()
                    .zip(&direction)
                    .for_each(|(r, d)| *r -= along * d);
                explained[k] += along * along / tile.norm;
                chi2[k] += along * along / variance;
                freedom[k] += 1.0;
                taken.push(direction);
            }
            first += count;
        }
        chi2[ORDERS.len()] += energy(&residual) * tile.norm / variance;
        freedom[ORDERS.len()] += tile.valid_pixels() as f64 - taken.len() as f64;
    }
    let total = total.max(1e-300);
    let significance = |k: usize| {
        let z = (chi2[k] - freedom[k]) / (2.0 * freedom[k]).max(1.0).sqrt();
        z.clamp(-1e6, 1e6)
    };
    let mut orders: Vec<Order> = ORDERS
        .iter()
        .enumerate()
        .map(|(k, (name, _))| Order {
            name,
            share: (explained[k] / total).clamp(0.0, 1.0),
            z: significance(k),
        })
        .collect();
    let named: f64 = orders.iter().map(|o| o.share).sum();
    orders.push(Order {
        name: "finer",
        share: (1.0 - named).clamp(0.0, 1.0),
        z: significance(ORDERS.len()),
    });
    let core = (core / total).clamp(0.0, 1.0);
    Shape {
        core,
        skirt: 1.0 - core,
        orders,
    }
}

/// Returns the squared radius about the centroid that encloses half of the light, and the centroid.
fn core_circle(tile: &TileData, picture: &[f64]) -> (f64, [f64; 2]) {
    let width = tile.size.0;
    let place = |k: usize| [(k % width) as f64, (k / width) as f64];
    let sum: f64 = picture.iter().sum::<f64>().max(1e-300);
    let mut centre = [0.0; 2];
    for (k, v) in picture.iter().enumerate() {
        let p = place(k);
        centre = [centre[0] + v * p[0] / sum, centre[1] + v * p[1] / sum];
    }
    let far = |k: usize| {
        let p = place(k);
        (p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2)
    };
    let mut order: Vec<usize> = (0..picture.len()).collect();
    order.sort_by(|a, b| far(*a).total_cmp(&far(*b)));
    let mut inside = 0.0;
    for k in order {
        inside += picture[k];
        if inside >= sum / 2.0 {
            return (far(k), centre);
        }
    }
    (f64::INFINITY, centre)
}

fn core_energy(tile: &TileData, picture: &[f64], residual: &[f64]) -> f64 {
    let (limit, centre) = core_circle(tile, picture);
    let width = tile.size.0;
    let inside = residual.iter().enumerate().filter(|(k, _)| {
        let (x, y) = ((k % width) as f64, (k / width) as f64);
        (x - centre[0]).powi(2) + (y - centre[1]).powi(2) <= limit
    });
    inside.map(|(_, r)| r * r).sum()
}

/// Returns the share of the tile's pixels within the core.
fn core_share(tile: &TileData, picture: &[f64]) -> f64 {
    let (limit, _) = core_circle(tile, picture);
    (std::f64::consts::PI * limit / tile.light.len() as f64).min(1.0)
}

/// Returns image derivatives by order: two first; Laplacian; the other two second; four third.
fn derivatives(tile: &TileData, picture: &[f64]) -> Vec<Vec<f64>> {
    let by = |f: &[f64], dx, dy| central_difference(f, tile.size, (dx, dy));
    let (x, y) = (by(picture, 1, 0), by(picture, 0, 1));
    let (xx, xy, yy) = (by(&x, 1, 0), by(&x, 0, 1), by(&y, 0, 1));
    let sum = |a: &[f64], b: &[f64], f: f64| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| a + f * b).collect()
    };
    let thirds = [by(&xx, 1, 0), by(&xx, 0, 1), by(&yy, 1, 0), by(&yy, 0, 1)];
    let mut all = vec![x, y, sum(&xx, &yy, 1.0), sum(&xx, &yy, -1.0), xy];
    all.extend(thirds);
    all
}

/// Describes the remaining residual in words.
pub(super) fn describe(shape: &Shape, tiles: &[&TileData], gaps: &[TileGap]) -> String {
    let mut orders: Vec<&Order> = shape.orders.iter().collect();
    orders.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mean = |wanted: &dyn Fn(usize) -> bool| {
        let own: Vec<f64> = (0..gaps.len())
            .filter(|k| wanted(*k))
            .map(|k| gaps[k].after)
            .collect();
        own.iter().sum::<f64>() / own.len().max(1) as f64
    };
    let mut radii: Vec<f64> = tiles.iter().map(|t| t.point.at.radius()).collect();
    let middle = median(&mut radii);
    let (inner, outer) = (
        mean(&|k| tiles[k].point.at.radius() < middle),
        mean(&|k| tiles[k].point.at.radius() >= middle),
    );
    let field = if outer > 1.5 * inner {
        "grows towards the edge of the field"
    } else if inner > 1.5 * outer {
        "is strongest in the middle of the field"
    } else {
        "is alike over the field"
    };
    let channels: std::collections::BTreeSet<&str> =
        gaps.iter().map(|g| g.channel.as_str()).collect();
    let by_channel: Vec<(f64, &str)> = channels
        .iter()
        .map(|name| (mean(&|k| gaps[k].channel == *name), *name))
        .collect();
    let most = by_channel.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let least = by_channel.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let colour = match (most, least) {
        (Some(most), Some(least)) if most.0 > 1.7 * least.0 => {
            format!("strongest in channel {}", most.1)
        }
        _ => "alike in every channel".to_owned(),
    };
    let colour = if channels.len() > 1 {
        format!(" and is {colour}")
    } else {
        String::new()
    };
    format!(
        "The remaining residual lies {:.0} % in the cores of the PSFs and {:.0} % in their skirts. {:.0} % of it is {}, {:.0} % {}. It {field}{colour}.",
        100.0 * shape.core,
        100.0 * shape.skirt,
        100.0 * orders[0].share,
        words(orders[0].name),
        100.0 * orders[1].share,
        words(orders[1].name),
    )
}

/// Describes a kind of change.
fn words(order: &str) -> &str {
    match order {
        "position" => "a shift",
        "size" => "a change of size",
        "ellipticity" => "elongation",
        "skew" => "asymmetry",
        "finer" => "finer detail, such as rings and edges",
        other => other,
    }
}
