//! The quadrilateral of a chart in a photograph: the region of strong fine texture.

use super::coarse::{Coarse, Plane};

/// Standard deviations of the filters that measure texture, px of the binned photograph.
const FINE_PX: f64 = 1.0;
const WINDOW_PX: f64 = 2.5;
/// Texture over that of the strongest tenth of the frame, from which on there is a chart.
const TEXTURE_SHARE: f64 = 0.3;
/// Least area of a chart, as a share of the frame.
const MIN_AREA: f64 = 0.02;
/// Area of a second region over that of the first from which on it counts as another chart.
const SECOND_AREA: f64 = 0.4;
/// Share of the points on each side that are its boundary, not its corners.
const SIDE_SHARE: std::ops::Range<f64> = 0.08..0.92;
/// Distance to a side, over its length, up to which a boundary point belongs to it.
const SIDE_REACH: f64 = 0.06;

/// A region of texture.
#[derive(Debug, Clone)]
pub(crate) struct TexturedRegion {
    /// Corners in photograph pixels, in the order of a turn, y down: clockwise as seen.
    pub(crate) corners: [[f64; 2]; 4],
}

/// Returns the textured regions of a photograph that may be charts, the largest first.
pub(crate) fn textured_regions(coarse: &Coarse) -> Vec<TexturedRegion> {
    let mask = texture_mask(&coarse.plane);
    let components = components(&mask, coarse.plane.columns);
    let frame = mask.len() as f64;
    let largest = components.first().map_or(0, Vec::len) as f64;
    let wanted = |c: &&Vec<usize>| {
        let area = c.len() as f64;
        area >= MIN_AREA * frame && area >= SECOND_AREA * largest
    };
    components
        .iter()
        .filter(wanted)
        .filter_map(|component| {
            let corners = quadrilateral(component, coarse.plane.columns)?;
            let photo = corners
                .map(|[x, y]| [0, 1].map(|k| coarse.grid.origin[k] + [x, y][k] * coarse.grid.step));
            Some(TexturedRegion { corners: photo })
        })
        .collect()
}

/// Returns where the local standard deviation, relative to the local mean, is high.
fn texture_mask(plane: &Plane) -> Vec<bool> {
    let mean = plane.blurred(WINDOW_PX);
    let smooth = plane.blurred(FINE_PX);
    let detail = Plane {
        values: (smooth.values.iter().zip(&mean.values))
            .map(|(v, m)| ((v - m) / m.max(1.0)).powi(2))
            .collect(),
        ..*plane
    };
    let texture = detail.blurred(WINDOW_PX);
    let mut sorted = texture.values.clone();
    let strong = seidel_optics::numeric::quantile(&mut sorted, 0.9);
    let limit = TEXTURE_SHARE * strong;
    texture.values.iter().map(|v| *v > limit).collect()
}

/// Returns the connected components of `mask` as lists of indices, the largest first.
fn components(mask: &[bool], columns: usize) -> Vec<Vec<usize>> {
    let mut seen = vec![false; mask.len()];
    let mut found = Vec::new();
    for start in 0..mask.len() {
        if !mask[start] || seen[start] {
            continue;
        }
        let mut component = Vec::new();
        let mut open = vec![start];
        seen[start] = true;
        while let Some(index) = open.pop() {
            component.push(index);
            let (x, y) = (index % columns, index / columns);
            let near = [
                (x > 0).then(|| index - 1),
                (x + 1 < columns).then(|| index + 1),
                (y > 0).then(|| index - columns),
                (index + columns < mask.len()).then(|| index + columns),
            ];
            for next in near.into_iter().flatten() {
                if mask[next] && !seen[next] {
                    seen[next] = true;
                    open.push(next);
                }
            }
        }
        found.push(component);
    }
    found.sort_by_key(|c| std::cmp::Reverse(c.len()));
    found
}

/// Returns the quadrilateral around a component: corners by the smallest rectangle about its convex hull, then straight lines
/// through its boundary.
fn quadrilateral(component: &[usize], columns: usize) -> Option<[[f64; 2]; 4]> {
    let boundary = boundary(component, columns);
    let hull = convex_hull(&boundary);
    if hull.len() < 4 {
        return None;
    }
    let mut corners = extreme_corners(&hull);
    for _ in 0..3 {
        let lines: Vec<[f64; 3]> = (0..4)
            .map(|k| line_through(&boundary, corners[k], corners[(k + 1) % 4]))
            .collect::<Option<_>>()?;
        for k in 0..4 {
            corners[k] = intersection(lines[(k + 3) % 4], lines[k])?;
        }
    }
    Some(corners)
}

/// Returns the first and last place of every row and column of a component, on the border of its pixels.
fn boundary(component: &[usize], columns: usize) -> Vec<[f64; 2]> {
    let mut by_row = std::collections::BTreeMap::<usize, [usize; 2]>::new();
    let mut by_column = std::collections::BTreeMap::<usize, [usize; 2]>::new();
    for index in component {
        let (x, y) = (index % columns, index / columns);
        let row = by_row.entry(y).or_insert([x, x]);
        *row = [row[0].min(x), row[1].max(x)];
        let column = by_column.entry(x).or_insert([y, y]);
        *column = [column[0].min(y), column[1].max(y)];
    }
    let mut points = Vec::new();
    for (y, [left, right]) in by_row {
        points.push([left as f64 - 0.5, y as f64]);
        points.push([right as f64 + 0.5, y as f64]);
    }
    for (x, [top, bottom]) in by_column {
        points.push([x as f64, top as f64 - 0.5]);
        points.push([x as f64, bottom as f64 + 0.5]);
    }
    points
}

/// Returns the convex hull by Andrew's monotone chain.
fn convex_hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while chain.len() >= 2
                && cross(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    hull
}

/// Returns the points of the hull that are extreme along the diagonals of its smallest rectangle, from that nearest to the
/// top left on, clockwise as seen.
fn extreme_corners(hull: &[[f64; 2]]) -> [[f64; 2]; 4] {
    let extent = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let range = |f: &dyn Fn(&[f64; 2]) -> f64| {
            let low = hull.iter().map(f).fold(f64::INFINITY, f64::min);
            hull.iter().map(f).fold(f64::NEG_INFINITY, f64::max) - low
        };
        [
            range(&|p| p[0] * cos + p[1] * sin),
            range(&|p| p[1] * cos - p[0] * sin),
        ]
    };
    let area = |angle: f64| extent(angle).iter().product::<f64>();
    let angles = hull.iter().zip(hull.iter().cycle().skip(1)).map(|(a, b)| {
        // Rectangles repeat by quarter turns; the nearest to no turn keeps the top left there.
        let angle = (b[1] - a[1]).atan2(b[0] - a[0]);
        let quarter = std::f64::consts::FRAC_PI_2;
        angle - (angle / quarter).round() * quarter
    });
    let best = angles
        .min_by(|a, b| area(*a).total_cmp(&area(*b)))
        .unwrap_or(0.0);
    let (sin, cos) = best.sin_cos();
    let [width, height] = extent(best);
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[u, v]| {
        // Along the rectangle's own diagonal: a corner is extreme there whatever the aspect.
        let along = |p: &[f64; 2]| {
            u * (p[0] * cos + p[1] * sin) / width + v * (p[1] * cos - p[0] * sin) / height
        };
        let best = hull.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
        best.copied().unwrap_or([0.0; 2])
    })
}

/// Returns the line (a, b, c) with a x + b y = c, a² + b² = 1, through the boundary points near the side from `from` to `to`:
/// total least squares, reweighted against outliers.
fn line_through(boundary: &[[f64; 2]], from: [f64; 2], to: [f64; 2]) -> Option<[f64; 3]> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length < 8.0 {
        return None;
    }
    let mut line = [-dy / length, dx / length, 0.0];
    line[2] = line[0] * from[0] + line[1] * from[1];
    let mut reach = SIDE_REACH * length;
    for _ in 0..4 {
        let near: Vec<[f64; 2]> = (boundary.iter().copied())
            .filter(|p| {
                let along = ((p[0] - from[0]) * dx + (p[1] - from[1]) * dy) / (length * length);
                let off = line[0] * p[0] + line[1] * p[1] - line[2];
                SIDE_SHARE.contains(&along) && off.abs() <= reach
            })
            .collect();
        let count = near.len() as f64;
        if near.len() < 6 {
            return None;
        }
        let mean = [0, 1].map(|k| near.iter().map(|p| p[k]).sum::<f64>() / count);
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for p in &near {
            let (u, v) = (p[0] - mean[0], p[1] - mean[1]);
            xx += u * u;
            xy += u * v;
            yy += v * v;
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let normal = [-angle.sin(), angle.cos()];
        line = [
            normal[0],
            normal[1],
            normal[0] * mean[0] + normal[1] * mean[1],
        ];
        let mut off: Vec<f64> = (near.iter())
            .map(|p| (line[0] * p[0] + line[1] * p[1] - line[2]).abs())
            .collect();
        reach = (3.0 * 1.4826 * seidel_optics::numeric::median(&mut off)).max(1.0);
    }
    Some(line)
}

fn intersection(a: [f64; 3], b: [f64; 3]) -> Option<[f64; 2]> {
    let determinant = a[0] * b[1] - a[1] * b[0];
    (determinant.abs() > 1e-6).then(|| {
        [
            (a[2] * b[1] - a[1] * b[2]) / determinant,
            (a[0] * b[2] - a[2] * b[0]) / determinant,
        ]
    })
}
