//! Prediction of a tile under a hypothesis.

use super::hypothesis::Hypothesis;
use super::registration::Registration;
use super::tiles::TileData;
use seidel_optics::lens::{LocalPupil, Transmission, Wavefront};
use seidel_optics::psf::pupil::{Detail, PsfImage, PupilDerivative, TileGrid, Workspace, draw};

/// Predicts tiles; holds the working memory of one thread.
#[derive(Default)]
pub(super) struct TilePredictor {
    space: Workspace,
    drawn: PsfImage,
}

/// The pupil of a tile under a hypothesis, and its place.
struct PlacedPupil {
    pupil: LocalPupil,
    /// Shift of the chief ray against that of the given lens, px.
    shift: [f64; 2],
}

impl PlacedPupil {
    fn new(hypothesis: &Hypothesis, values: &[Vec<f64>], tile: &TileData) -> Self {
        let (pupil, moved) = hypothesis.act(values, tile);
        let shift = match &tile.registration {
            Registration::Ideal => moved,
            Registration::Reference(reference) => {
                let common = hypothesis.reference_shift(values, reference);
                [moved[0] - common[0], moved[1] - common[1]]
            }
            Registration::Centroid => pupil.centroid().map(|c| -c),
        };
        Self { pupil, shift }
    }

    fn grid(&self, tile: &TileData) -> TileGrid {
        TileGrid {
            corner_px: [tile.corner.0 - self.shift[0], tile.corner.1 - self.shift[1]],
            width: tile.size.0,
            height: tile.size.1,
        }
    }

    /// Returns the derivative of the PSF towards `there`, a step `h` of a parameter away; `None` if it is not one of rays on an
    /// ideal sensor.
    fn derivative(&self, there: &Self, h: f64) -> Option<PupilDerivative> {
        let (a, b) = (&self.pupil, &there.pupil);
        let of_rays =
            |p: &LocalPupil| !p.diffracts() && p.sensor.is_ideal() && p.sensor.tone.is_linear();
        let alike = a.stops().len() == b.stops().len()
            && a.squeeze == b.squeeze
            && a.blur_variances_px2() == b.blur_variances_px2();
        if !(of_rays(a) && of_rays(b) && alike) {
            return None;
        }
        let rate = |from: f64, to: f64| (to - from) / h;
        let move_by =
            [0, 1].map(|axis| rate(self.shift[axis], there.shift[axis]) / a.squeeze[axis]);
        let change = b.wavefront.add_scaled(-1.0, &a.wavefront);
        let tilt = Wavefront::tilt(move_by[0], move_by[1]);
        let wavefront = tilt.add_scaled(1.0 / h, &change);
        let mut derivative = PupilDerivative::from_wavefront(wavefront);
        for ((to, from), rates) in (b.stops().iter().zip(a.stops())).zip(&mut derivative.stops) {
            rates.centre = [0, 1].map(|axis| rate(from.centre[axis], to.centre[axis]));
            rates.radius = rate(from.radius, to.radius);
        }
        let (from, to) = (&a.transmission, &b.transmission);
        derivative.transmission = Transmission {
            square: rate(from.square, to.square),
            fourth: rate(from.fourth, to.fourth),
            centre: [0, 1].map(|axis| rate(from.centre[axis], to.centre[axis])),
        };
        Some(derivative)
    }
}

/// Values of the effects after a step of one free parameter.
pub(super) struct ParameterStep<'a> {
    /// Size of the step.
    pub(super) size: f64,
    /// Values of every effect.
    pub(super) values: &'a [Vec<f64>],
}

/// A predicted tile with its derivatives by parameters.
pub(super) struct Linearisation {
    pub(super) picture: Vec<f64>,
    /// One image for each step.
    pub(super) rates: Vec<Vec<f64>>,
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
        let placed = PlacedPupil::new(hypothesis, values, tile);
        self.draw(&placed, &[], tile, detail);
        self.finish(&placed, tile, out);
    }

    /// Predicts `tile` with its derivatives by the parameters of `steps`: those of the rays where they exist, one-sided
    /// differences otherwise.
    pub(super) fn linearise(
        &mut self,
        hypothesis: &Hypothesis,
        values: &[Vec<f64>],
        steps: &[ParameterStep],
        tile: &TileData,
        detail: Detail,
    ) -> Linearisation {
        let here = PlacedPupil::new(hypothesis, values, tile);
        let there: Vec<PlacedPupil> = (steps.iter())
            .map(|step| PlacedPupil::new(hypothesis, step.values, tile))
            .collect();
        let mut of_rays: Vec<(usize, PupilDerivative)> = (there.iter().enumerate())
            .filter_map(|(k, there)| Some((k, here.derivative(there, steps[k].size)?)))
            .collect();
        // The drawing takes derivatives that change the light last.
        of_rays.sort_by_key(|(_, derivative)| derivative.changes_light());
        let derivatives: Vec<PupilDerivative> = of_rays.iter().map(|(_, d)| *d).collect();
        self.draw(&here, &derivatives, tile, detail);
        let mut rates = vec![Vec::new(); steps.len()];
        let stride = PsfImage::stride(derivatives.len());
        for (column, (k, _)) in of_rays.iter().enumerate() {
            let pixels = 0..self.drawn.light.len();
            let rate = pixels.map(|pixel| self.drawn.derivatives[pixel * stride + column]);
            rates[*k] = self.finish_rate(rate.collect(), tile);
        }
        let mut picture = Vec::new();
        self.finish(&here, tile, &mut picture);
        for (k, there) in there.iter().enumerate() {
            if of_rays.iter().any(|(own, _)| *own == k) {
                continue;
            }
            self.draw(there, &[], tile, detail);
            let mut moved = Vec::new();
            self.finish(there, tile, &mut moved);
            for (there, here) in moved.iter_mut().zip(&picture) {
                *there = (*there - here) / steps[k].size;
            }
            rates[k] = moved;
        }
        Linearisation { picture, rates }
    }

    fn draw(
        &mut self,
        placed: &PlacedPupil,
        derivatives: &[PupilDerivative],
        tile: &TileData,
        detail: Detail,
    ) {
        let (space, drawn) = (&mut self.space, &mut self.drawn);
        draw(
            &placed.pupil,
            &placed.grid(tile),
            derivatives,
            detail,
            space,
            drawn,
        );
    }

    /// Sets `out` to the drawn tile as the sensor and the estimator of the tile give it.
    fn finish(&self, placed: &PlacedPupil, tile: &TileData, out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(&self.drawn.light);
        mask(tile, out);
        let tone = placed.pupil.sensor.tone;
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

    /// Returns the derivative of the finished tile from `rate`, that of the drawn one.
    fn finish_rate(&self, mut rate: Vec<f64>, tile: &TileData) -> Vec<f64> {
        let mut light = self.drawn.light.clone();
        mask(tile, &mut light);
        mask(tile, &mut rate);
        let sum: f64 = light.iter().sum();
        if sum <= 0.0 {
            return vec![0.0; rate.len()];
        }
        let growth = rate.iter().sum::<f64>() / sum;
        for (rate, light) in rate.iter_mut().zip(&light) {
            *rate = (*rate - growth * light) / sum;
        }
        if let Some(response) = &tile.response {
            response.apply_to_change(&mut rate);
        }
        rate
    }
}

/// Sets pixels that do not take part to zero.
fn mask(tile: &TileData, pixels: &mut [f64]) {
    for (index, value) in pixels.iter_mut().enumerate() {
        if tile.counts.get(index) == Some(&false) {
            *value = 0.0;
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
