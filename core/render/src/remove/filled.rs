//! Holes in a plane, filled smoothly from what is about them.

/// `plane`, `width` samples wide, with the samples that are not `known` replaced: by the mean of what is known near them,
/// near being twice as far on each level of a pyramid until something is. Zero if nothing is known.
pub(super) fn filled(plane: &[f32], width: usize, known: &[bool]) -> Vec<f32> {
    let weights = known.iter().map(|known| f32::from(u8::from(*known)));
    let samples = plane.iter().zip(weights.clone()).map(|(v, w)| v * w);
    let level = Level {
        width,
        height: plane.len() / width.max(1),
        samples: samples.collect(),
        weights: weights.collect(),
    };
    let smooth = level.means();
    let both = plane.iter().zip(known).zip(&smooth);
    both.map(|((sample, known), smooth)| if *known { *sample } else { *smooth })
        .collect()
}

/// Sums of known samples, and how many there are.
struct Level {
    width: usize,
    height: usize,
    samples: Vec<f32>,
    weights: Vec<f32>,
}

impl Level {
    /// The mean at every place: its own as far as it has one, the rest from the level above.
    fn means(&self) -> Vec<f32> {
        let own = |k: usize| {
            let weight = self.weights[k];
            if weight > 0.0 {
                self.samples[k] / weight
            } else {
                0.0
            }
        };
        if self.width <= 1 && self.height <= 1 || self.weights.iter().all(|w| *w > 0.0) {
            return (0..self.samples.len()).map(own).collect();
        }
        let above = self.halved();
        let coarse = above.means();
        let at = |x: usize, y: usize| {
            coarse[y.min(above.height - 1) * above.width + x.min(above.width - 1)]
        };
        let mut out = Vec::with_capacity(self.samples.len());
        for y in 0..self.height {
            for x in 0..self.width {
                let k = y * self.width + x;
                // Between the four nearest places above: a quarter from the farther one along each axis.
                let (near_x, near_y) = (x / 2, y / 2);
                let far_x = if x % 2 == 0 {
                    near_x.saturating_sub(1)
                } else {
                    near_x + 1
                };
                let far_y = if y % 2 == 0 {
                    near_y.saturating_sub(1)
                } else {
                    near_y + 1
                };
                let rows = [(near_y, 0.75), (far_y, 0.25)];
                let from_above: f32 = rows
                    .iter()
                    .map(|(y, share)| share * (0.75 * at(near_x, *y) + 0.25 * at(far_x, *y)))
                    .sum();
                let weight = self.weights[k].min(1.0);
                out.push(weight * own(k) + (1.0 - weight) * from_above);
            }
        }
        out
    }

    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut above = Self {
            width,
            height,
            samples: vec![0.0; width * height],
            weights: vec![0.0; width * height],
        };
        for k in 0..self.samples.len() {
            let to = k / self.width / 2 * width + k % self.width / 2;
            above.samples[to] += self.samples[k];
            above.weights[to] += self.weights[k];
        }
        above
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_filled_smoothly_and_the_rest_is_kept() {
        let slope: Vec<f32> = (0..40 * 30).map(|k| 0.01 * (k % 40) as f32).collect();
        let known: Vec<bool> = (0..40 * 30)
            .map(|k| !((12..20).contains(&(k % 40)) && (8..18).contains(&(k / 40))))
            .collect();
        let found = filled(&slope, 40, &known);
        for k in 0..slope.len() {
            let most = if known[k] { 0.0 } else { 0.06 };
            assert!((found[k] - slope[k]).abs() <= most, "{k}");
        }
    }

    #[test]
    fn nothing_known_is_dark() {
        assert!(
            filled(&[3.0; 12], 4, &[false; 12])
                .iter()
                .all(|v| *v == 0.0)
        );
    }
}
