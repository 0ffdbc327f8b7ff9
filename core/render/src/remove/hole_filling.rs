//! Hole filling by the pull-push method: a pyramid of weighted sums is built upwards, and its means are interpolated
//! downwards into the holes.

/// Replaces the samples of `plane`, `width` samples wide, that are not `known` by a smooth continuation of the known
/// ones. They become zero if no sample is known.
pub(super) fn fill_holes(plane: &[f32], width: usize, known: &[bool]) -> Vec<f32> {
    let weights = known.iter().map(|known| f32::from(u8::from(*known)));
    let samples = plane.iter().zip(weights.clone()).map(|(v, w)| v * w);
    let level = Level {
        width,
        height: plane.len() / width.max(1),
        sums: samples.collect(),
        weights: weights.collect(),
    };
    let smooth = level.means();
    let samples = plane.iter().zip(known).zip(&smooth);
    samples
        .map(|((sample, known), smooth)| if *known { *sample } else { *smooth })
        .collect()
}

/// Interpolates `cells`, `columns` a row and `side` pixels wide, bilinearly between their centres to a plane of `size`.
pub(super) fn interpolate_cells(
    cells: &[f32],
    columns: usize,
    side: usize,
    size: (usize, usize),
) -> Vec<f32> {
    let rows = cells.len() / columns.max(1);
    let along = |at: usize, count: usize| {
        let place = ((at as f32 + 0.5) / side as f32 - 0.5).clamp(0.0, (count - 1) as f32);
        let low = place as usize;
        (low, (low + 1).min(count - 1), place - low as f32)
    };
    let mut out = Vec::with_capacity(size.0 * size.1);
    for y in 0..size.1 {
        let (top, bottom, down) = along(y, rows);
        for x in 0..size.0 {
            let (left, right, across) = along(x, columns);
            let mean = |row: usize| {
                let (a, b) = (cells[row * columns + left], cells[row * columns + right]);
                a + across * (b - a)
            };
            out.push(mean(top) + down * (mean(bottom) - mean(top)));
        }
    }
    out
}

/// A pyramid level.
struct Level {
    width: usize,
    height: usize,
    /// Sum of the known samples in each cell.
    sums: Vec<f32>,
    /// Number of the known samples in each cell.
    weights: Vec<f32>,
}

impl Level {
    /// Returns the mean of each cell; cells without a known sample get theirs from the next coarser level.
    fn means(&self) -> Vec<f32> {
        let own = |k: usize| {
            let weight = self.weights[k];
            if weight > 0.0 {
                self.sums[k] / weight
            } else {
                0.0
            }
        };
        if self.width <= 1 && self.height <= 1 || self.weights.iter().all(|w| *w > 0.0) {
            return (0..self.sums.len()).map(own).collect();
        }
        let coarser = self.halved();
        let means = coarser.means();
        let mean_at = |x: usize, y: usize| {
            means[y.min(coarser.height - 1) * coarser.width + x.min(coarser.width - 1)]
        };
        let mut out = Vec::with_capacity(self.sums.len());
        for y in 0..self.height {
            for x in 0..self.width {
                let k = y * self.width + x;
                // Bilinear between cell centres: 3/4 from the cell above this one, 1/4 from its neighbour.
                let (near_x, far_x) = (x / 2, neighbour(x));
                let rows = [(y / 2, 0.75), (neighbour(y), 0.25)];
                let interpolated: f32 = rows
                    .iter()
                    .map(|(y, share)| {
                        share * (0.75 * mean_at(near_x, *y) + 0.25 * mean_at(far_x, *y))
                    })
                    .sum();
                let weight = self.weights[k].min(1.0);
                out.push(weight * own(k) + (1.0 - weight) * interpolated);
            }
        }
        out
    }

    /// Returns the next coarser level: sums over 2 x 2 cells.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut coarser = Self {
            width,
            height,
            sums: vec![0.0; width * height],
            weights: vec![0.0; width * height],
        };
        for k in 0..self.sums.len() {
            let to = k / self.width / 2 * width + k % self.width / 2;
            coarser.sums[to] += self.sums[k];
            coarser.weights[to] += self.weights[k];
        }
        coarser
    }
}

/// Returns the second nearest cell of the coarser level along one axis.
fn neighbour(at: usize) -> usize {
    if at.is_multiple_of(2) {
        (at / 2).saturating_sub(1)
    } else {
        at / 2 + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_continue_a_ramp_and_known_samples_stay() {
        let ramp: Vec<f32> = (0..40 * 30).map(|k| 0.01 * (k % 40) as f32).collect();
        let known: Vec<bool> = (0..40 * 30)
            .map(|k| !((12..20).contains(&(k % 40)) && (8..18).contains(&(k / 40))))
            .collect();
        let filled = fill_holes(&ramp, 40, &known);
        for k in 0..ramp.len() {
            let most = if known[k] { 0.0 } else { 0.06 };
            assert!((filled[k] - ramp[k]).abs() <= most, "{k}");
        }
    }

    #[test]
    fn a_plane_without_known_samples_becomes_zero() {
        let filled = fill_holes(&[3.0; 12], 4, &[false; 12]);
        assert!(filled.iter().all(|v| *v == 0.0));
    }
}
