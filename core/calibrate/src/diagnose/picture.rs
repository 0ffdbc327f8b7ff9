//! What a hypothesis predicts for a tile.

use super::hypothesis::Hypothesis;
use super::seen::Seen;
use seidel_optics::psf::pupil::{Detail, PsfImage, TileGrid, Workspace, draw};

/// Buffers of predictions, one a thread.
#[derive(Default)]
pub(super) struct Easel {
    space: Workspace,
    drawn: PsfImage,
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
            &TileGrid {
                corner_px: [corner.0, corner.1],
                width: seen.size.0,
                height: seen.size.1,
            },
            &[],
            detail,
            &mut self.space,
            &mut self.drawn,
        );
        out.clear();
        out.extend_from_slice(&self.drawn.light);
        for (index, value) in out.iter_mut().enumerate() {
            if seen.counts.get(index) == Some(&false) {
                *value = 0.0;
            }
        }
        let tone = pupil.sensor.tone;
        if !tone.is_linear()
            && let Some(exposure) = tone.exposure(out, seen.exposure)
        {
            out.iter_mut().for_each(|v| *v = tone.apply(exposure * *v));
        }
        let sum: f64 = out.iter().sum();
        if sum > 0.0 {
            out.iter_mut().for_each(|v| *v /= sum);
        }
    }
}

/// Half the difference between the pixels (`dx`, `dy`) ahead and behind: the derivative of a picture of
/// `size` along that step; at the rim the picture goes on as it ends.
pub(super) fn slope(
    picture: &[f64],
    (width, height): (usize, usize),
    (dx, dy): (i64, i64),
) -> Vec<f64> {
    let at = |x: i64, y: i64| {
        let (x, y) = (x.clamp(0, width as i64 - 1), y.clamp(0, height as i64 - 1));
        picture[y as usize * width + x as usize]
    };
    let cells = (0..height as i64).flat_map(|y| (0..width as i64).map(move |x| (x, y)));
    cells
        .map(|(x, y)| (at(x + dx, y + dy) - at(x - dx, y - dy)) / 2.0)
        .collect()
}
