//! What sharp pictures look like: most slopes are none, some are steep.

/// Differences of a plane to the right and downwards, none across the last column and row.
pub(super) struct Slopes {
    pub(super) right: Vec<f32>,
    pub(super) down: Vec<f32>,
}

impl Slopes {
    pub(super) fn of(plane: &[f32], width: usize) -> Self {
        let count = plane.len();
        let right = (0..count).map(|k| match (k + 1) % width {
            0 => 0.0,
            _ => plane[k + 1] - plane[k],
        });
        let down = (0..count).map(|k| match k + width < count {
            true => plane[k + width] - plane[k],
            false => 0.0,
        });
        Self {
            right: right.collect(),
            down: down.collect(),
        }
    }

    /// D^T: what has these inner products with the slopes of planes.
    pub(super) fn gathered(&self, width: usize) -> Vec<f32> {
        let count = self.right.len();
        (0..count)
            .map(|k| {
                let mut sum = 0.0;
                if k % width > 0 {
                    sum += self.right[k - 1];
                }
                if (k + 1) % width > 0 {
                    sum -= self.right[k];
                }
                if k >= width {
                    sum += self.down[k - width];
                }
                if k + width < count {
                    sum -= self.down[k];
                }
                sum
            })
            .collect()
    }

    /// Sum of squares.
    pub(super) fn energy(&self) -> f64 {
        let all = self.right.iter().chain(&self.down);
        all.map(|v| f64::from(*v).powi(2)).sum()
    }

    /// Mean length.
    pub(super) fn mean_length(&self) -> f64 {
        let pairs = self.right.iter().zip(&self.down);
        pairs.map(|(x, y)| f64::from(x.hypot(*y))).sum::<f64>() / self.right.len().max(1) as f64
    }

    /// Each shortened by `by`, down to none.
    pub(super) fn shortened(&self, by: f32, unit: f32, power: f32) -> Self {
        let mut out = Self {
            right: self.right.clone(),
            down: self.down.clone(),
        };
        for (x, y) in out.right.iter_mut().zip(&mut out.down) {
            let length = x.hypot(*y);
            let by = by * (length / unit).max(1e-6).powf(power - 1.0);
            let share = if length > by { 1.0 - by / length } else { 0.0 };
            *x *= share;
            *y *= share;
        }
        out
    }

    pub(super) fn plus(&self, other: &Self, gain: f32) -> Self {
        let sum = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a + gain * b).collect();
        Self {
            right: sum(&self.right, &other.right),
            down: sum(&self.down, &other.down),
        }
    }
}
