//! What a hypothesis predicts for a tile.

use super::hypothesis::Hypothesis;
use super::seen::Seen;
use crate::psf::pupil::{Detail, Drawn, Workspace, draw};
use crate::sensor::Tone;

/// Buffers of predictions, one a thread.
#[derive(Default)]
pub(super) struct Easel {
    space: Workspace,
    drawn: Drawn,
}

impl Easel {
    /// The tile that `hypothesis` predicts at `values` for `seen`: unit sum over the pixels that count.
    pub(super) fn predict(
        &mut self,
        hypothesis: &Hypothesis,
        values: &[Vec<f64>],
        seen: &Seen,
        detail: Detail,
        out: &mut Vec<f64>,
    ) {
        let (pupil, moved) = hypothesis.act(values, seen);
        let corner = if seen.placed {
            (seen.corner.0 - moved[0], seen.corner.1 - moved[1])
        } else {
            let centroid = pupil.centroid();
            (seen.corner.0 + centroid[0], seen.corner.1 + centroid[1])
        };
        draw(
            &pupil,
            corner,
            seen.size,
            &[],
            detail,
            &mut self.space,
            &mut self.drawn,
        );
        out.clear();
        out.extend_from_slice(&self.drawn.light);
        if !pupil.sensor.tone.is_linear() {
            expose(out, seen, pupil.sensor.tone);
        }
        for (index, value) in out.iter_mut().enumerate() {
            if seen.counts.get(index) == Some(&false) {
                *value = 0.0;
            }
        }
        let sum: f64 = out.iter().sum();
        if sum > 0.0 {
            out.iter_mut().for_each(|v| *v /= sum);
        }
    }
}

/// Turns the linear tile into pixel values, exposed so that they sum to what was observed.
fn expose(tile: &mut [f64], seen: &Seen, tone: Tone) {
    let counts = |index: usize| seen.counts.get(index) != Some(&false);
    let total = |exposure: f64| -> f64 {
        let toned = tile.iter().enumerate().filter(|(index, _)| counts(*index));
        toned.map(|(_, v)| tone.of(exposure * v)).sum()
    };
    let (mut low, mut high) = (0.0, seen.exposure);
    for _ in 0..60 {
        if total(high) >= seen.exposure {
            break;
        }
        low = high;
        high *= 2.0;
    }
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if total(middle) < seen.exposure {
            low = middle;
        } else {
            high = middle;
        }
    }
    let exposure = (low + high) / 2.0;
    tile.iter_mut().for_each(|v| *v = tone.of(exposure * *v));
}
