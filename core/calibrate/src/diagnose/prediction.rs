//! Prediction of a tile under a hypothesis.

use super::hypothesis::Hypothesis;
use super::registration::Registration;
use super::tiles::TileData;
use seidel_optics::lens::{LocalPupil, Transmission, Wavefront};
use seidel_optics::psf::pupil::{
    Detail, OpticalPsf, PsfImage, PupilDerivative, TileGrid, Workspace, draw,
};
use seidel_optics::sensor::{Sensor, Tone};

/// A tile with an offset of its PSF.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedTile<'a> {
    pub(super) tile: &'a TileData,
    /// Offset beyond that by the hypothesis, px.
    pub(super) offset: [f64; 2],
}

impl<'a> From<&'a TileData> for PlacedTile<'a> {
    fn from(tile: &'a TileData) -> Self {
        Self {
            tile,
            offset: [0.0; 2],
        }
    }
}

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
    fn new(hypothesis: &Hypothesis, values: &[Vec<f64>], placed: PlacedTile) -> Self {
        let tile = placed.tile;
        let (pupil, moved) = hypothesis.act(values, tile);
        let [x, y] = match &tile.registration {
            Registration::Ideal => moved,
            Registration::Reference(reference) => {
                let common = hypothesis.reference_shift(values, reference);
                [moved[0] - common[0], moved[1] - common[1]]
            }
            Registration::Centroid => pupil.centroid().map(|c| -c),
        };
        Self {
            pupil,
            shift: [x + placed.offset[0], y + placed.offset[1]],
        }
    }

    fn grid(&self, tile: &TileData) -> TileGrid {
        TileGrid {
            corner_px: [tile.corner.0 - self.shift[0], tile.corner.1 - self.shift[1]],
            width: tile.size.0,
            height: tile.size.1,
        }
    }

    /// Returns the change of the PSF towards `there`, a step `h` of a parameter away.
    fn change(&self, there: &Self, h: f64) -> Change {
        let (a, b) = (&self.pupil, &there.pupil);
        let mut retoned = b.clone();
        retoned.sensor.tone = a.sensor.tone;
        if retoned == *a && self.shift == there.shift {
            return Change::Tone;
        }
        let mut behind_another = b.clone();
        behind_another.sensor = a.sensor;
        if behind_another == *a && self.shift == there.shift {
            return Change::Sensor;
        }
        let alike = a.stops().len() == b.stops().len()
            && a.squeeze == b.squeeze
            && a.sensor.tone == b.sensor.tone
            && a.blur_variances_px2() == b.blur_variances_px2();
        if !(is_of_rays(a) && is_of_rays(b) && alike) {
            return Change::Other;
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
            picture: None,
            square: rate(from.square, to.square),
            fourth: rate(from.fourth, to.fourth),
            centre: [0, 1].map(|axis| rate(from.centre[axis], to.centre[axis])),
        };
        Change::Rays(Box::new(derivative))
    }
}

/// Returns whether the PSF of `pupil` is the light of its rays in pixels, without diffraction and a sensor that blurs.
fn is_of_rays(pupil: &LocalPupil) -> bool {
    !pupil.diffracts() && pupil.sensor.is_ideal()
}

/// The change of a PSF with a parameter.
enum Change {
    /// Rays move, of a pupil before a sensor that does not blur.
    Rays(Box<PupilDerivative>),
    /// Only the tone curve changes.
    Tone,
    /// The same light falls on another sensor.
    Sensor,
    /// Everything may change.
    Other,
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
    /// Predicts the tile `at` its offset for effects at `values`, with unit sum over the valid pixels, and all others too.
    pub(super) fn predict<'a>(
        &mut self,
        hypothesis: &Hypothesis,
        values: &[Vec<f64>],
        at: impl Into<PlacedTile<'a>>,
        detail: Detail,
        out: &mut Vec<f64>,
    ) {
        let at = at.into();
        let tile = at.tile;
        let placed = PlacedPupil::new(hypothesis, values, at);
        self.draw(&placed, &[], tile, detail);
        *out = Recording::new(&self.drawn.light, placed.pupil.sensor.tone, tile).picture(tile);
    }

    /// Predicts the tile `at` its offset with its derivatives by the parameters of `steps`: those of the rays where they exist, one-sided
    /// differences otherwise.
    pub(super) fn linearise(
        &mut self,
        hypothesis: &Hypothesis,
        values: &[Vec<f64>],
        steps: &[ParameterStep],
        at: PlacedTile,
        detail: Detail,
    ) -> Linearisation {
        let tile = at.tile;
        let here = PlacedPupil::new(hypothesis, values, at);
        let there: Vec<PlacedPupil> = (steps.iter())
            .map(|step| PlacedPupil::new(hypothesis, step.values, at))
            .collect();
        let changes: Vec<Change> = (there.iter().zip(steps))
            .map(|(there, step)| here.change(there, step.size))
            .collect();
        let mut of_rays: Vec<(usize, PupilDerivative)> = (changes.iter().enumerate())
            .filter_map(|(k, change)| match change {
                Change::Rays(derivative) => Some((k, (**derivative).clone())),
                Change::Tone | Change::Sensor | Change::Other => None,
            })
            .collect();
        // The drawing takes derivatives that change the light last.
        of_rays.sort_by_key(|(_, derivative)| derivative.changes_light());
        let derivatives: Vec<PupilDerivative> = of_rays.iter().map(|(_, d)| d.clone()).collect();
        let sensors = (changes.iter().zip(&there))
            .filter(|(change, _)| matches!(change, Change::Sensor))
            .map(|(_, there)| there.pupil.sensor);
        let widest = sensors.reduce(|a, b| a.widest(&b));
        let before_sensor = widest.map(|widest| {
            let widest = widest.widest(&here.pupil.sensor);
            let (grid, space) = (here.grid(tile), &mut self.space);
            OpticalPsf::draw(&here.pupil, &grid, &widest, detail, space)
        });
        let light = match &before_sensor {
            Some(psf) if !is_of_rays(&here.pupil) => psf.through(&here.pupil.sensor),
            _ => {
                self.draw(&here, &derivatives, tile, detail);
                self.drawn.light.clone()
            }
        };
        let mut rates = vec![Vec::new(); steps.len()];
        let stride = PsfImage::stride(derivatives.len());
        let recording = Recording::new(&light, here.pupil.sensor.tone, tile);
        for (column, (k, _)) in of_rays.iter().enumerate() {
            let pixels = 0..light.len();
            let rate = pixels.map(|pixel| self.drawn.derivatives[pixel * stride + column]);
            rates[*k] = recording.rate(rate.collect(), tile);
        }
        let picture = recording.picture(tile);
        let difference = |there: Recording, picture: &[f64], size: f64| {
            let mut moved = there.picture(tile);
            for (there, here) in moved.iter_mut().zip(picture) {
                *there = (*there - here) / size;
            }
            tile.mask(&mut moved);
            moved
        };
        for (k, change) in changes.iter().enumerate() {
            if matches!(change, Change::Tone) {
                let tone = there[k].pupil.sensor.tone;
                let moved = Recording::new(&light, tone, tile);
                rates[k] = difference(moved, &picture, steps[k].size);
            }
        }
        if let Some(psf) = before_sensor {
            let recorded = |sensor: &Sensor| {
                let light = psf.through(sensor);
                Recording::new(&light, sensor.tone, tile)
            };
            let unmoved = recorded(&here.pupil.sensor).picture(tile);
            for (k, change) in changes.iter().enumerate() {
                if matches!(change, Change::Sensor) {
                    let moved = recorded(&there[k].pupil.sensor);
                    rates[k] = difference(moved, &unmoved, steps[k].size);
                }
            }
        }
        for (k, change) in changes.iter().enumerate() {
            if matches!(change, Change::Other) {
                self.draw(&there[k], &[], tile, detail);
                let tone = there[k].pupil.sensor.tone;
                let moved = Recording::new(&self.drawn.light, tone, tile);
                rates[k] = difference(moved, &picture, steps[k].size);
            }
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
}

/// The light of a tile with the tone curve that records it.
struct Recording {
    light: Vec<f64>,
    tone: Tone,
    /// Sum of the pixel values over the valid pixels.
    sum: f64,
    /// Factor on the light before the tone curve; `None` if pixel values are the light.
    exposure: Option<f64>,
}

impl Recording {
    fn new(light: &[f64], tone: Tone, tile: &TileData) -> Self {
        let mut valid = light.to_vec();
        tile.mask(&mut valid);
        let exposure = if tone.is_linear() {
            None
        } else {
            tone.exposure(&valid, tile.exposure)
        };
        let mut recording = Self {
            light: light.to_vec(),
            tone,
            sum: 0.0,
            exposure,
        };
        recording.sum = recording.sum_of_valid(&recording.values(), tile);
        recording
    }

    fn sum_of_valid(&self, values: &[f64], tile: &TileData) -> f64 {
        if tile.counts.is_empty() {
            return values.iter().sum();
        }
        let valid = values.iter().zip(&tile.counts).filter(|(_, c)| **c);
        valid.map(|(v, _)| v).sum()
    }

    /// Returns the pixel values, before the estimator.
    fn values(&self) -> Vec<f64> {
        match self.exposure {
            Some(exposure) => {
                let values = self.light.iter().map(|l| self.tone.apply(exposure * l));
                values.collect()
            }
            None => self.light.clone(),
        }
    }

    /// Returns the picture that the estimator of `tile` gives, of unit sum over the valid pixels; as it is without light.
    fn picture(&self, tile: &TileData) -> Vec<f64> {
        let mut picture = self.values();
        if self.sum > 0.0 {
            picture.iter_mut().for_each(|v| *v /= self.sum);
            if let Some(response) = &tile.response {
                response.apply(&mut picture);
            }
        }
        picture
    }

    /// Returns the derivative of the picture at valid pixels from `rate`, that of the light; zero at the others.
    fn rate(&self, mut rate: Vec<f64>, tile: &TileData) -> Vec<f64> {
        tile.mask(&mut rate);
        let sum = self.sum;
        if sum <= 0.0 {
            return vec![0.0; rate.len()];
        }
        // Change of each value by light, and value by exposure: the sum of values stays.
        let mut slopes: Vec<[f64; 2]> = match self.exposure {
            Some(exposure) => {
                let slope = |l: &f64| {
                    let slope = self.tone.slope(exposure * l);
                    [slope * exposure, slope * l]
                };
                self.light.iter().map(slope).collect()
            }
            None => self.light.iter().map(|l| [1.0, *l]).collect(),
        };
        for (slope, counts) in slopes.iter_mut().zip(&tile.counts) {
            if !counts {
                *slope = [0.0; 2];
            }
        }
        let by_exposure: f64 = slopes.iter().map(|[_, s]| s).sum();
        let by_light: f64 = rate.iter().zip(&slopes).map(|(r, [s, _])| r * s).sum();
        let growth = if by_exposure > 0.0 {
            by_light / by_exposure
        } else {
            0.0
        };
        for (rate, [by_light, by_exposure]) in rate.iter_mut().zip(&slopes) {
            *rate = (*rate * by_light - growth * by_exposure) / sum;
        }
        if let Some(response) = &tile.response {
            response.apply_to_change(&mut rate);
        }
        rate
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
