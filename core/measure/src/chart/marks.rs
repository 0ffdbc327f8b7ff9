//! Finder marks: concentric squares whose widths along any line through the centre are 1 : 1 : 3 : 1 : 1.

use super::coarse::Plane;

/// Share of the local range that separates dark from bright.
const MIN_CONTRAST: f64 = 0.25;
/// Departure of a ring's width from the module, in modules.
const WIDTH_TOLERANCE: f64 = 0.55;
/// Least module, px of the plane.
const MIN_MODULE_PX: f64 = 1.2;
/// Rows in which a mark must show, over its middle part of three modules.
const MIN_ROWS_SHARE: f64 = 0.5;

/// A mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mark {
    /// Centre, as coordinates of the plane whose pixel centres are whole numbers.
    pub(crate) centre: [f64; 2],
    /// Width of a ring, px of the plane.
    pub(crate) module: f64,
}

/// Returns the marks of a plane, from those seen in most rows on.
pub(crate) fn find_marks(plane: &Plane) -> Vec<Mark> {
    let dark = threshold(plane);
    let mut clusters: Vec<(Mark, usize)> = Vec::new();
    for row in 0..plane.rows {
        let line = |k: usize| dark[row * plane.columns + k];
        for (x, module) in patterns(plane.columns, line) {
            let column = (x.round() as usize).min(plane.columns - 1);
            let down = |k: usize| dark[k * plane.columns + column];
            let across = patterns(plane.rows, down);
            let matching = across.into_iter().find(|(y, other)| {
                (y - row as f64).abs() < 2.0 * module && (other / module - 1.0).abs() < 0.5
            });
            let Some((y, other)) = matching else {
                continue;
            };
            let mark = Mark {
                centre: [x, y],
                module: (module + other) / 2.0,
            };
            let same = clusters.iter_mut().find(|(m, _)| {
                let apart = (m.centre[0] - x).hypot(m.centre[1] - y);
                apart < 2.0 * m.module
            });
            match same {
                Some((mean, count)) => {
                    let n = *count as f64;
                    for k in 0..2 {
                        mean.centre[k] = (mean.centre[k] * n + mark.centre[k]) / (n + 1.0);
                    }
                    mean.module = (mean.module * n + mark.module) / (n + 1.0);
                    *count += 1;
                }
                None => clusters.push((mark, 1)),
            }
        }
    }
    clusters.retain(|(m, count)| {
        m.module >= MIN_MODULE_PX && *count as f64 >= (MIN_ROWS_SHARE * 3.0 * m.module).max(2.0)
    });
    clusters.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    clusters.into_iter().map(|(mark, _)| mark).collect()
}

/// Returns the centres and modules of dark-bright-dark-bright-dark runs of the widths of a mark.
fn patterns(length: usize, is_dark: impl Fn(usize) -> bool) -> Vec<(f64, f64)> {
    let mut starts = vec![0];
    starts.extend((1..length).filter(|k| is_dark(*k) != is_dark(*k - 1)));
    starts.push(length);
    let mut found = Vec::new();
    for window in starts.windows(6) {
        // The outer runs must end within the line.
        if !is_dark(window[0]) || window[0] == 0 || window[5] == length {
            continue;
        }
        let widths: Vec<f64> = window.windows(2).map(|w| (w[1] - w[0]) as f64).collect();
        let module = widths.iter().sum::<f64>() / 7.0;
        let fits = widths
            .iter()
            .zip([1.0, 1.0, 3.0, 1.0, 1.0])
            .all(|(w, wanted)| (w / module - wanted).abs() <= WIDTH_TOLERANCE * wanted.max(1.0));
        if fits {
            let middle = (window[2] + window[3]) as f64 / 2.0 - 0.5;
            found.push((middle, module));
        }
    }
    found
}

/// Returns where the plane is darker than the middle of its local range.
fn threshold(plane: &Plane) -> Vec<bool> {
    let window = (plane.columns.max(plane.rows) / 24).max(8);
    let (low, high) = (
        extremes(plane, window, f64::min),
        extremes(plane, window, f64::max),
    );
    let typical = high.iter().copied().fold(0.0, f64::max);
    (plane.values.iter().zip(low.iter().zip(&high)))
        .map(|(v, (low, high))| high - low > MIN_CONTRAST * typical && *v < (low + high) / 2.0)
        .collect()
}

/// Returns the extreme value within `window` px along both axes.
fn extremes(plane: &Plane, window: usize, pick: fn(f64, f64) -> f64) -> Vec<f64> {
    let pass = |values: &[f64], length: usize, stride: usize, start: usize, out: &mut [f64]| {
        for at in 0..length {
            let near = at.saturating_sub(window)..(at + window + 1).min(length);
            let values = near.map(|k| values[start + k * stride]);
            out[start + at * stride] = values.reduce(pick).unwrap_or(0.0);
        }
    };
    let mut along = vec![0.0; plane.values.len()];
    for row in 0..plane.rows {
        pass(
            &plane.values,
            plane.columns,
            1,
            row * plane.columns,
            &mut along,
        );
    }
    let mut both = vec![0.0; plane.values.len()];
    for column in 0..plane.columns {
        pass(&along, plane.rows, plane.columns, column, &mut both);
    }
    both
}
