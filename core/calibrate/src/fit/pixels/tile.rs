//! One tile of a pixel fit: how its misfit changes with the free numbers.
//!
//! What a tile can tell is how its own pupil should change: its wavefront in a few directions, its
//! stops, its blur. These directions are few however many numbers the lens has, so the derivatives are
//! drawn along them and turned into those by the lens's numbers afterwards. Light and centre of every
//! tile are free and solved for on the way.

use nalgebra::{DMatrix, DVector};

use super::change::{Change, STOP_NUMBERS};
use super::layout::Layout;
use super::metric::Metric;
use seidel_optics::field::FieldPoint;
use seidel_optics::lens::{LocalPupil, MAX_STOPS, Stop, TERMS, Wavefront};
use seidel_optics::psf::pupil::{Detail, PsfImage, PupilDerivative, TileGrid, Workspace, draw};

/// Numbers that every tile has for itself: light, and centre along x and y.
const OWN: usize = 3;

/// A tile as a pixel fit sees it.
#[derive(Debug, Clone)]
pub(super) struct FitTile {
    /// Which of the measured tiles it is.
    pub(super) measured: usize,
    /// Index of the channel.
    pub(super) channel: usize,
    /// Field position from the axis that the fit began with.
    pub(super) at: FieldPoint,
    /// Vergence, 1/m.
    pub(super) vergence: f64,
    /// Columns and rows.
    pub(super) size: (usize, usize),
    /// Light of each pixel, zero where `counts` says no.
    pub(super) light: Vec<f64>,
    /// Which pixels take part; all where `None`.
    pub(super) counts: Option<Vec<bool>>,
    /// Standard deviation of a pixel's noise; zero where not known.
    pub(super) sigma: f64,
}

/// What a fit chooses for one tile alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Own {
    /// Total light, in the tile's units.
    pub(super) light: f64,
    /// Centroid in tile coordinates.
    pub(super) centroid: [f64; 2],
}

/// A tile's misfit near the present numbers.
#[derive(Debug, Clone)]
pub(super) struct TileSystem {
    /// Misfit: chi squared per degree of freedom where the noise decides, the square of the residual
    /// over that of the light where the picture does.
    pub(super) misfit: f64,
    /// Degrees of freedom.
    pub(super) freedom: f64,
    /// Normal matrix and right-hand side of the free numbers that `slots` lists, own ones eliminated.
    pub(super) normal: DMatrix<f64>,
    pub(super) right: DVector<f64>,
    pub(super) slots: Vec<usize>,
    /// How the own numbers follow.
    follow: Follow,
}

#[derive(Debug, Clone)]
struct Follow {
    inverse: DMatrix<f64>,
    across: DMatrix<f64>,
    right: DVector<f64>,
}

impl TileSystem {
    /// The change of the own numbers that goes with a change `delta` of all free numbers.
    pub(super) fn own_step(&self, delta: &DVector<f64>) -> [f64; 3] {
        let mine = DVector::from_iterator(self.slots.len(), self.slots.iter().map(|&s| delta[s]));
        let step = &self.follow.inverse * (&self.follow.right - &self.follow.across * mine);
        [step[0], step[1], step[2]]
    }
}

/// A few directions whose combinations make all the changes of a tile.
struct Directions {
    waves: Vec<[f64; TERMS]>,
    stops: Vec<[f64; STOP_NUMBERS]>,
}

impl Directions {
    fn of(changes: &[Change]) -> Self {
        let mut directions = Self {
            waves: Vec::new(),
            stops: Vec::new(),
        };
        for change in changes {
            extend(&mut directions.waves, *change.wavefront.coefficients());
            extend(&mut directions.stops, change.stops);
        }
        directions
    }

    /// The tangents to draw along: tilts first, what moves stops last.
    fn tangents(&self) -> Vec<PupilDerivative> {
        let tilts = [Wavefront::tilt(1.0, 0.0), Wavefront::tilt(0.0, 1.0)];
        let waves = self
            .waves
            .iter()
            .map(|c| Wavefront::from_coefficients(*c))
            .map(centred);
        let mut tangents: Vec<PupilDerivative> = tilts
            .into_iter()
            .chain(waves)
            .map(PupilDerivative::from_wavefront)
            .collect();
        for numbers in &self.stops {
            let mut tangent = PupilDerivative::from_wavefront(Wavefront::default());
            for (k, rates) in numbers.chunks_exact(3).enumerate().take(MAX_STOPS - 1) {
                tangent.stops[k + 1] = Stop {
                    centre: [rates[0], rates[1]],
                    radius: rates[2],
                };
            }
            tangents.push(tangent);
        }
        tangents
    }

    fn count(&self) -> usize {
        self.waves.len() + self.stops.len() + 1
    }

    /// How much of each direction, and of blur, one unit of each change holds.
    fn shares(&self, changes: &[Change]) -> DMatrix<f64> {
        DMatrix::from_fn(self.count(), changes.len(), |row, column| {
            let change = &changes[column];
            if row < self.waves.len() {
                dot(change.wavefront.coefficients(), &self.waves[row])
            } else if row + 1 < self.count() {
                dot(&change.stops, &self.stops[row - self.waves.len()])
            } else {
                change.blur
            }
        })
    }
}

/// The wavefront less the tilt that would move an unclipped pupil's centroid: a tile's centroid is its
/// own number.
fn centred(wavefront: Wavefront) -> Wavefront {
    let [x, y] = wavefront.mean_slope();
    wavefront.add_scaled(-1.0, &Wavefront::tilt(x, y))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds the part of `vector` that the orthonormal `basis` does not hold yet.
fn extend<const N: usize>(basis: &mut Vec<[f64; N]>, vector: [f64; N]) {
    let size = dot(&vector, &vector).sqrt();
    if size == 0.0 {
        return;
    }
    let mut rest = vector;
    // Twice, for the sake of rounding.
    for _ in 0..2 {
        for b in basis.iter() {
            let share = dot(&rest, b);
            for (r, b) in rest.iter_mut().zip(b) {
                *r -= share * b;
            }
        }
    }
    let left = dot(&rest, &rest).sqrt();
    if left > 1e-6 * size {
        basis.push(rest.map(|r| r / left));
    }
}

/// How tiles are held against the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comparison {
    pub(super) metric: Metric,
    pub(super) detail: Detail,
    /// Share of the usual misfit below which a tile's counts in proportion, above by its logarithm.
    pub(super) tolerance: f64,
}

/// Buffers for one thread.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    space: Workspace,
    drawn: PsfImage,
    rows: Vec<f64>,
    weighed: Vec<f64>,
}

impl FitTile {
    /// The tile's pixels relative to the chief ray if the PSF's centroid lies at `centroid` in the tile.
    fn grid(&self, pupil: &LocalPupil, centroid: [f64; 2]) -> TileGrid {
        let off = pupil.centroid();
        TileGrid {
            corner_px: [off[0] - centroid[0], off[1] - centroid[1]],
            width: self.size.0,
            height: self.size.1,
        }
    }

    /// Weight of a residual sample: one over the noise, or over the light's own size.
    fn unit(&self, comparison: Comparison, buffers: &mut Buffers) -> f64 {
        if comparison.metric == Metric::Pixels && self.sigma > 0.0 {
            return 1.0 / self.sigma;
        }
        let Buffers { weighed, .. } = buffers;
        comparison.metric.weigh(&self.light, 1, self.size, weighed);
        1.0 / dot(weighed, weighed).sqrt()
    }

    fn pixels(&self) -> usize {
        let all = self.light.len();
        self.counts
            .as_ref()
            .map_or(all, |c| c.iter().filter(|&&c| c).count())
    }

    /// The misfit with these numbers, the light being the best.
    pub(super) fn misfit(
        &self,
        pupil: &LocalPupil,
        own: &Own,
        comparison: Comparison,
        buffers: &mut Buffers,
    ) -> f64 {
        let unit = self.unit(comparison, buffers);
        let grid = self.grid(pupil, own.centroid);
        let Buffers {
            space,
            drawn,
            rows,
            weighed,
        } = buffers;
        draw(pupil, &grid, &[], comparison.detail, space, drawn);
        rows.clear();
        for (k, &model) in drawn.light.iter().enumerate() {
            let counts = self.counts.as_ref().is_none_or(|c| c[k]);
            let residual = if counts {
                self.light[k] - own.light * model
            } else {
                0.0
            };
            rows.push(residual);
        }
        comparison.metric.weigh(rows, 1, self.size, weighed);
        let square = dot(weighed, weighed) * unit * unit;
        square / self.scale(comparison)
    }

    /// What the square of the residual is divided by for the misfit.
    fn scale(&self, comparison: Comparison) -> f64 {
        if comparison.metric == Metric::Pixels && self.sigma > 0.0 {
            (self.pixels() as f64 - OWN as f64).max(1.0)
        } else {
            1.0
        }
    }

    /// The misfit and how it changes.
    pub(super) fn system(
        &self,
        layout: &Layout,
        theta: &[f64],
        own: &Own,
        comparison: Comparison,
        buffers: &mut Buffers,
    ) -> TileSystem {
        let unit = self.unit(comparison, buffers);
        let pupil = layout.pupil(theta, self.channel, self.at, self.vergence);
        let changes = layout.changes(theta, self.channel, self.at, self.vergence);
        let directions = Directions::of(&changes);
        let tangents = directions.tangents();
        let grid = self.grid(&pupil, own.centroid);
        let Buffers {
            space,
            drawn,
            rows,
            weighed,
        } = buffers;
        draw(&pupil, &grid, &tangents, comparison.detail, space, drawn);
        // A row a pixel: residual, light, centre, directions, blur.
        let stride = PsfImage::stride(tangents.len());
        let width = 1 + OWN + directions.count();
        rows.clear();
        rows.resize(self.light.len() * width, 0.0);
        for (k, row) in rows.chunks_exact_mut(width).enumerate() {
            if self.counts.as_ref().is_some_and(|c| !c[k]) {
                continue;
            }
            row[0] = (self.light[k] - own.light * drawn.light[k]) * unit;
            row[1] = drawn.light[k] * unit;
            let slopes = &drawn.derivatives[k * stride..][..tangents.len()];
            for (value, slope) in row[2..].iter_mut().zip(slopes) {
                *value = slope * own.light * unit;
            }
            row[width - 1] = drawn.blur_derivative[k] * own.light * unit;
        }
        comparison.metric.weigh(rows, width, self.size, weighed);
        let mut sums = vec![0.0; width * width];
        for row in weighed.chunks_exact(width) {
            for (a, sums) in row.iter().zip(sums.chunks_exact_mut(width)) {
                for (sum, b) in sums.iter_mut().zip(row) {
                    *sum += a * b;
                }
            }
        }
        let all = DMatrix::from_row_slice(width, width, &sums);
        self.eliminate(&all, &directions.shares(&changes), &changes, comparison)
    }

    /// Solves the own numbers away and turns directions into free numbers.
    fn eliminate(
        &self,
        all: &DMatrix<f64>,
        shares: &DMatrix<f64>,
        changes: &[Change],
        comparison: Comparison,
    ) -> TileSystem {
        let rest = all.nrows() - 1 - OWN;
        let mut own = all.view((1, 1), (OWN, OWN)).into_owned();
        for k in 0..OWN {
            // A spot within one pixel says nothing of where in it: it stays where it is.
            own[(k, k)] = own[(k, k)] * (1.0 + 1e-9) + 1e-12 * own[(0, 0)].max(1e-300);
        }
        let inverse = if comparison.metric == Metric::Picture {
            // The model is used with its centroid where the light's is: one that fits better when
            // moved is wrong there. Where noise decides, pixels say where the centre is.
            let mut light_alone = DMatrix::zeros(OWN, OWN);
            light_alone[(0, 0)] = 1.0 / own[(0, 0)];
            light_alone
        } else {
            own.clone()
                .try_inverse()
                .unwrap_or_else(|| DMatrix::zeros(OWN, OWN))
        };
        let own_right = all.view((1, 0), (OWN, 1)).column(0).into_owned();
        let across = all.view((1, 1 + OWN), (OWN, rest)) * shares;
        let normal = shares.transpose() * all.view((1 + OWN, 1 + OWN), (rest, rest)) * shares
            - across.transpose() * &inverse * &across;
        let right = shares.transpose() * all.view((1 + OWN, 0), (rest, 1)).column(0)
            - across.transpose() * &inverse * &own_right;
        TileSystem {
            misfit: all[(0, 0)] / self.scale(comparison),
            freedom: self.scale(comparison),
            normal,
            right,
            slots: changes.iter().map(|c| c.slot).collect(),
            follow: Follow {
                inverse,
                across,
                right: own_right,
            },
        }
    }
}
