//! Prediction of a tile under a hypothesis.

use super::hypothesis::Hypothesis;
use super::registration::Registration;
use super::tiles::TileData;
use seidel_optics::psf::pupil::{Detail, PsfImage, TileGrid, Workspace, draw};

/// Predicts tiles; holds the working memory of one thread.
#[derive(Default)]
pub(super) struct TilePredictor {
    space: Workspace,
    drawn: PsfImage,
}

impl TilePredictor {
    /// Predicts `tile` for effects at `values`, with unit sum over the valid pixels.
    pub(super) fn predict(
        &mut self,
        hypothesis: &Hypothesis,
        values: &[Vec<f64>],
        tile: &TileData,
        detail: Detail,
        out: &mut Vec<f64>,
    ) {
        let (pupil, moved) = hypothesis.act(values, tile);
        let shift = match &tile.registration {
            Registration::Ideal => moved,
            Registration::Reference(reference) => {
                let common = hypothesis.reference_shift(values, reference);
                [moved[0] - common[0], moved[1] - common[1]]
            }
            Registration::Centroid => pupil.centroid().map(|c| -c),
        };
        let corner = (tile.corner.0 - shift[0], tile.corner.1 - shift[1]);
        draw(
            &pupil,
            &TileGrid {
                corner_px: [corner.0, corner.1],
                width: tile.size.0,
                height: tile.size.1,
            },
            &[],
            detail,
            &mut self.space,
            &mut self.drawn,
        );
        out.clear();
        out.extend_from_slice(&self.drawn.light);
        for (index, value) in out.iter_mut().enumerate() {
            if tile.counts.get(index) == Some(&false) {
                *value = 0.0;
            }
        }
        let tone = pupil.sensor.tone;
        if !tone.is_linear()
            && let Some(exposure) = tone.exposure(out, tile.exposure)
        {
            out.iter_mut().for_each(|v| *v = tone.apply(exposure * *v));
        }
        let sum: f64 = out.iter().sum();
        if sum > 0.0 {
            out.iter_mut().for_each(|v| *v /= sum);
            if let Some(response) = &tile.response {
                response.apply(out);
            }
        }
    }
}

/// Returns the central difference of an image of `size` along `step`, with replicated edges.
pub(super) fn central_difference(
    picture: &[f64],
    size: (usize, usize),
    step: (i64, i64),
) -> Vec<f64> {
    let ((width, height), (dx, dy)) = (size, step);
    let at = |x: i64, y: i64| {
        let (x, y) = (x.clamp(0, width as i64 - 1), y.clamp(0, height as i64 - 1));
        picture[y as usize * width + x as usize]
    };
    let cells = (0..height as i64).flat_map(|y| (0..width as i64).map(move |x| (x, y)));
    cells
        .map(|(x, y)| (at(x + dx, y + dy) - at(x - dx, y - dy)) / 2.0)
        .collect()
}
