//! Normal equations of one tile in a pixel fit.
//!
//! A tile constrains the lens only through its local pupil: a few wavefront terms, stops and a blur. So
//! derivatives of the PSF are drawn along an orthonormal basis of these, and the chain rule turns them into
//! derivatives by the lens parameters. Flux and centroid of the tile are eliminated by the Schur complement.

use nalgebra::{DMatrix, DVector};

use super::jacobian::{LIGHT_PARAMETERS, ParameterDerivative, SHADOW_PARAMETERS};
use super::lens_equations::LensEquations;
use super::metric::Metric;
use super::parameters::ParameterLayout;
use crate::least_squares::RegistrationSums;
use seidel_optics::field::FieldPoint;
use seidel_optics::lens::{LocalPupil, Stop, TERMS, Transmission, Wavefront};
use seidel_optics::numeric::dot;
use seidel_optics::psf::pupil::{Detail, PsfImage, PupilDerivative, TileGrid, Workspace, draw};

/// Number of nuisance parameters per tile: flux, and centroid along x and y.
const TILE_PARAMETERS: usize = 3;

/// Largest number of steps, and largest shift from the measured centroid, px, of a registration.
const REGISTRATION_STEPS: usize = 4;
const MAX_SHIFT_PX: f64 = 0.5;

/// Change of the obstruction by which PSFs are compared, pupil radii.
const SHADOW_STEP: f64 = 5e-3;

/// Data of one tile.
#[derive(Debug, Clone)]
pub(super) struct FitTile {
    /// Index of the measured tile.
    pub(super) measured: usize,
    /// Index of the channel.
    pub(super) channel: usize,
    /// Field position relative to the initial axis.
    pub(super) at: FieldPoint,
    /// Vergence, 1/m.
    pub(super) vergence: f64,
    /// Columns and rows.
    pub(super) size: (usize, usize),
    /// Samples, zero where `counts` is false.
    pub(super) light: Vec<f64>,
    /// Pixels that take part; all if `None`.
    pub(super) counts: Option<Vec<bool>>,
    /// Weights of the residuals relative to that of a dark pixel, where noise grows with the signal; all one if `None`.
    pub(super) weights: Option<Vec<f64>>,
    /// Standard deviation of the noise of a dark pixel; zero where unknown.
    pub(super) sigma: f64,
    /// Whether the pixels are those of one colour of a mosaic.
    pub(super) is_mosaic: bool,
    /// Whether the PSF is too narrow for its pixels to tell its centroid.
    pub(super) centroid_unknown: bool,
}

/// Nuisance parameters of one tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TileParameters {
    /// Total flux, in the tile's units.
    pub(super) flux: f64,
    /// Centroid in tile coordinates, px.
    pub(super) centroid: [f64; 2],
}

/// Normal equations of one tile after elimination of its nuisance parameters.
#[derive(Debug, Clone)]
pub(super) struct TileEquations {
    /// The equations of the lens parameters.
    pub(super) lens: LensEquations,
    /// Back-substitution for the nuisance parameters.
    back_substitution: BackSubstitution,
}

#[derive(Debug, Clone)]
struct BackSubstitution {
    inverse: DMatrix<f64>,
    across: DMatrix<f64>,
    right: DVector<f64>,
}

impl TileEquations {
    /// Returns the step of the nuisance parameters for a step `delta` of all lens parameters.
    pub(super) fn tile_step(&self, delta: &DVector<f64>) -> [f64; 3] {
        let mine = DVector::from_iterator(
            self.lens.parameters.len(),
            self.lens.parameters.iter().map(|&s| delta[s]),
        );
        let step = &self.back_substitution.inverse
            * (&self.back_substitution.right - &self.back_substitution.across * mine);
        [step[0], step[1], step[2]]
    }
}

/// Orthonormal basis of the pupil changes that the parameters cause in one tile.
struct TangentBasis {
    waves: Vec<[f64; TERMS]>,
    light: Vec<[f64; LIGHT_PARAMETERS]>,
    shadow: Vec<[f64; SHADOW_PARAMETERS]>,
}

impl TangentBasis {
    fn of(changes: &[ParameterDerivative]) -> Self {
        let mut directions = Self {
            waves: Vec::new(),
            light: Vec::new(),
            shadow: Vec::new(),
        };
        for change in changes {
            extend(&mut directions.waves, *change.wavefront.coefficients());
            extend(&mut directions.light, change.light);
            extend(&mut directions.shadow, change.shadow);
        }
        directions
    }

    /// Returns the pupil derivatives to draw: tilts first, stops and transmission last. Those of the obstruction are compared instead.
    fn tangents(&self) -> Vec<PupilDerivative> {
        let tilts = [Wavefront::tilt(1.0, 0.0), Wavefront::tilt(0.0, 1.0)];
        let waves = self.waves.iter().map(|c| Wavefront::from_coefficients(*c));
        let mut tangents: Vec<PupilDerivative> = tilts
            .into_iter()
            .chain(waves)
            .map(PupilDerivative::from_wavefront)
            .collect();
        for numbers in &self.light {
            let mut tangent = PupilDerivative::from_wavefront(Wavefront::default());
            let [ref stops @ .., square, fourth, x, y] = *numbers;
            for (k, rates) in stops.chunks_exact(3).enumerate() {
                tangent.stops[k + 1] = Stop {
                    centre: [rates[0], rates[1]],
                    radius: rates[2],
                };
            }
            tangent.transmission = Transmission {
                picture: None,
                square,
                fourth,
                centre: [x, y],
            };
            tangents.push(tangent);
        }
        tangents
    }

    fn count(&self) -> usize {
        self.waves.len() + self.light.len() + self.shadow.len() + 1
    }

    /// Returns the matrix of the chain rule: components of each parameter derivative in the flux, the centroid (x, y), the
    /// basis and the blur.
    fn shares(&self, changes: &[ParameterDerivative]) -> DMatrix<f64> {
        DMatrix::from_fn(
            TILE_PARAMETERS + self.count(),
            changes.len(),
            |row, column| {
                let change = &changes[column];
                let Some(row) = row.checked_sub(TILE_PARAMETERS) else {
                    // The centroid is a parameter of its own, so it stays.
                    return [0.0, -change.centroid[0], -change.centroid[1]][row];
                };
                let (waves, light) = (self.waves.len(), self.waves.len() + self.light.len());
                if row < waves {
                    dot(change.wavefront.coefficients(), &self.waves[row])
                } else if row < light {
                    dot(&change.light, &self.light[row - waves])
                } else if row + 1 < self.count() {
                    dot(&change.shadow, &self.shadow[row - light])
                } else {
                    change.blur
                }
            },
        )
    }
}

/// Returns `pupil` with its obstruction moved along a `direction`.
fn moved_shadow(pupil: &LocalPupil, direction: &[f64; SHADOW_PARAMETERS], by: f64) -> LocalPupil {
    let mut moved = pupil.clone();
    if let Some(disc) = pupil.obstruction() {
        moved.set_obstruction(Stop {
            centre: [0, 1].map(|axis| disc.centre[axis] + by * direction[axis]),
            radius: (disc.radius + by * direction[2]).max(0.0),
        });
    }
    moved
}

/// Extends the orthonormal `basis` by `vector` (Gram-Schmidt).
fn extend<const N: usize>(basis: &mut Vec<[f64; N]>, vector: [f64; N]) {
    let size = dot(&vector, &vector).sqrt();
    if size == 0.0 {
        return;
    }
    let mut rest = vector;
    // A second pass removes rounding errors.
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

/// Settings of the comparison of tiles with the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct MisfitSettings {
    pub(super) metric: Metric,
    pub(super) detail: Detail,
    /// Scale of the robust loss in units of the median misfit.
    pub(super) tolerance: f64,
}

/// The comparison of tiles with the model: its settings, and the working memory of one thread.
#[derive(Debug)]
pub(super) struct Comparison {
    settings: MisfitSettings,
    space: Workspace,
    drawn: PsfImage,
    /// Values of each pixel, and the same under the metric.
    rows: Vec<f64>,
    weighed: Vec<f64>,
}

impl Comparison {
    pub(super) fn new(settings: MisfitSettings) -> Self {
        Self {
            settings,
            space: Workspace::default(),
            drawn: PsfImage::default(),
            rows: Vec::new(),
            weighed: Vec::new(),
        }
    }

    fn draw(&mut self, pupil: &LocalPupil, grid: &TileGrid, derivatives: &[PupilDerivative]) {
        let (detail, space) = (self.settings.detail, &mut self.space);
        draw(pupil, grid, derivatives, detail, space, &mut self.drawn);
    }

    /// Returns the derivative of each pixel's light along a change of the obstruction, by central differences: the mesh has no derivative
    /// of its inner ring.
    fn change_by_shadow(
        &mut self,
        pupil: &LocalPupil,
        grid: &TileGrid,
        direction: &[f64; SHADOW_PARAMETERS],
    ) -> Vec<f64> {
        let mut moved = |by: f64| {
            self.draw(&moved_shadow(pupil, direction, by), grid, &[]);
            self.drawn.light.clone()
        };
        let (low, high) = (moved(-SHADOW_STEP), moved(SHADOW_STEP));
        let pairs = low.iter().zip(&high);
        pairs.map(|(a, b)| (b - a) / (2.0 * SHADOW_STEP)).collect()
    }

    /// Applies the metric to the rows, of `depth` values for each pixel of a tile of `size`.
    fn weigh(&mut self, depth: usize, size: (usize, usize)) -> &[f64] {
        let metric = self.settings.metric;
        metric.apply(&self.rows, depth, size.0, size.1, &mut self.weighed);
        &self.weighed
    }
}

impl FitTile {
    /// Returns the tile's pixel grid relative to the chief ray for a PSF centroid at `centroid` in the tile.
    fn grid(&self, pupil: &LocalPupil, centroid: [f64; 2]) -> TileGrid {
        let off = pupil.centroid();
        TileGrid {
            corner_px: [off[0] - centroid[0], off[1] - centroid[1]],
            width: self.size.0,
            height: self.size.1,
        }
    }

    /// Returns the weight of residual samples: 1 / noise, or 1 / norm of the signal.
    fn unit(&self, comparison: &mut Comparison) -> f64 {
        if comparison.settings.metric == Metric::Pixels && self.sigma > 0.0 {
            return 1.0 / self.sigma;
        }
        comparison.rows.clone_from(&self.light);
        let weighed = comparison.weigh(1, self.size);
        1.0 / dot(weighed, weighed).sqrt()
    }

    /// Returns the weight of pixel `k`: zero where it does not count.
    fn weight(&self, k: usize) -> f64 {
        if self.counts.as_ref().is_some_and(|c| !c[k]) {
            return 0.0;
        }
        self.weights.as_ref().map_or(1.0, |w| w[k])
    }

    /// Returns the share of the lit pixels that count: that of the channel's colour in a mosaic.
    pub(super) fn counted_share(&self) -> f64 {
        if !self.is_mosaic {
            return 1.0;
        }
        let (Some(counts), width) = (&self.counts, self.size.0) else {
            return 1.0;
        };
        // The pixels of a colour repeat every second column and row.
        let phases = (0..4).filter(|phase| {
            (counts.iter().enumerate())
                .any(|(k, c)| *c && [k % width % 2, k / width % 2] == [phase % 2, phase / 2])
        });
        phases.count().max(1) as f64 / 4.0
    }

    fn pixels(&self) -> usize {
        let all = self.light.len();
        self.counts
            .as_ref()
            .map_or(all, |c| c.iter().filter(|&&c| c).count())
    }

    /// Returns the misfit for a pupil and nuisance parameters: chi squared per degree of freedom for [`Metric::Pixels`] with
    /// known noise; otherwise squared residual over squared signal.
    pub(super) fn misfit(
        &self,
        pupil: &LocalPupil,
        own: &TileParameters,
        comparison: &mut Comparison,
    ) -> f64 {
        let unit = self.unit(comparison);
        let grid = self.grid(pupil, own.centroid);
        comparison.draw(pupil, &grid, &[]);
        comparison.rows.clear();
        for (k, &model) in comparison.drawn.light.iter().enumerate() {
            let weight = self.weight(k);
            let residual = if weight > 0.0 {
                (self.light[k] - own.flux * model) * weight
            } else {
                0.0
            };
            comparison.rows.push(residual);
        }
        let weighed = comparison.weigh(1, self.size);
        let square = dot(weighed, weighed) * unit * unit;
        square / self.freedom(comparison.settings)
    }

    /// Returns `own` with the centroid where `pupil` fits the pixels best, if they do not tell it themselves.
    pub(super) fn registered(
        &self,
        pupil: &LocalPupil,
        own: TileParameters,
        comparison: &mut Comparison,
    ) -> TileParameters {
        if self.centroid_unknown {
            self.best_registration(pupil, own, comparison)
        } else {
            own
        }
    }

    /// Returns `own` with the flux at which `pupil` fits the pixels of a mosaic best. The sum of other tiles is their flux.
    fn with_best_flux(
        &self,
        pupil: &LocalPupil,
        own: TileParameters,
        comparison: &mut Comparison,
    ) -> TileParameters {
        if !self.is_mosaic {
            return own;
        }
        let grid = self.grid(pupil, own.centroid);
        comparison.draw(pupil, &grid, &[]);
        let (mut product, mut power) = (0.0, 0.0);
        for (k, &model) in comparison.drawn.light.iter().enumerate() {
            let weight = self.weight(k).powi(2);
            product += weight * self.light[k] * model;
            power += weight * model * model;
        }
        let flux = product / power;
        TileParameters {
            flux: if flux.is_finite() && flux > 0.0 {
                flux
            } else {
                own.flux
            },
            ..own
        }
    }

    /// Returns `own` with the centroid where `pupil` fits the pixels best.
    pub(super) fn best_registration(
        &self,
        pupil: &LocalPupil,
        own: TileParameters,
        comparison: &mut Comparison,
    ) -> TileParameters {
        let own = self.with_best_flux(pupil, own, comparison);
        let mut best = (self.misfit(pupil, &own, comparison), own);
        for _ in 0..REGISTRATION_STEPS {
            let Some(step) = self.centroid_step(pupil, &best.1, comparison) else {
                break;
            };
            let mut moved = best.1;
            for ((to, by), start) in moved.centroid.iter_mut().zip(step).zip(own.centroid) {
                *to = (*to + by).clamp(start - MAX_SHIFT_PX, start + MAX_SHIFT_PX);
            }
            let moved = self.with_best_flux(pupil, moved, comparison);
            let misfit = self.misfit(pupil, &moved, comparison);
            if misfit >= best.0 {
                break;
            }
            best = (misfit, moved);
        }
        best.1
    }

    /// Returns the Gauss-Newton step of the centroid; `None` where the pixels do not determine it.
    fn centroid_step(
        &self,
        pupil: &LocalPupil,
        own: &TileParameters,
        comparison: &mut Comparison,
    ) -> Option<[f64; 2]> {
        let tilts = [Wavefront::tilt(1.0, 0.0), Wavefront::tilt(0.0, 1.0)];
        let tilts = tilts.map(PupilDerivative::from_wavefront);
        let grid = self.grid(pupil, own.centroid);
        comparison.draw(pupil, &grid, &tilts);
        let Comparison { drawn, rows, .. } = &mut *comparison;
        let stride = PsfImage::stride(tilts.len());
        rows.clear();
        for (k, light) in drawn.light.iter().enumerate() {
            let weight = self.weight(k);
            let slopes = &drawn.derivatives[k * stride..][..2];
            let row = [self.light[k] - own.flux * light, slopes[0], slopes[1]];
            rows.extend(row.map(|v| if weight > 0.0 { v * weight } else { 0.0 }));
        }
        let depth = 1 + tilts.len();
        let mut sums = RegistrationSums::default();
        for row in comparison.weigh(depth, self.size).chunks_exact(depth) {
            sums.add(row[0], [row[1] * own.flux, row[2] * own.flux]);
        }
        sums.step()
    }

    /// Returns the part of `misfit` beyond noise as a share of the energy of the tile.
    pub(super) fn energy_error(&self, misfit: f64, settings: MisfitSettings) -> f64 {
        if settings.metric != Metric::Pixels || self.sigma <= 0.0 {
            return misfit;
        }
        let noise = self.sigma * self.sigma * self.freedom(settings);
        (misfit - 1.0).max(0.0) * noise / dot(&self.light, &self.light)
    }

    /// Returns the degrees of freedom, which divide the squared residual; one where the noise is unknown.
    pub(super) fn freedom(&self, misfit_settings: MisfitSettings) -> f64 {
        if misfit_settings.metric == Metric::Pixels && self.sigma > 0.0 {
            (self.pixels() as f64 - TILE_PARAMETERS as f64).max(1.0)
        } else {
            1.0
        }
    }

    /// Returns the normal equations at `theta`.
    pub(super) fn system(
        &self,
        layout: &ParameterLayout,
        theta: &[f64],
        own: &TileParameters,
        comparison: &mut Comparison,
    ) -> TileEquations {
        let unit = self.unit(comparison);
        let pupil = layout.pupil(theta, self.channel, self.at, self.vergence);
        let changes = layout.changes(theta, self.channel, self.at, self.vergence);
        let directions = TangentBasis::of(&changes);
        let tangents = directions.tangents();
        let grid = self.grid(&pupil, own.centroid);
        let shadows = directions.shadow.iter();
        let of_shadow: Vec<Vec<f64>> = shadows
            .map(|direction| comparison.change_by_shadow(&pupil, &grid, direction))
            .collect();
        comparison.draw(&pupil, &grid, &tangents);
        let Comparison { drawn, rows, .. } = &mut *comparison;
        // One row per pixel: residual, flux, centroid, basis directions, blur.
        let stride = PsfImage::stride(tangents.len());
        let width = 1 + TILE_PARAMETERS + directions.count();
        rows.clear();
        rows.resize(self.light.len() * width, 0.0);
        for (k, row) in rows.chunks_exact_mut(width).enumerate() {
            let unit = unit * self.weight(k);
            if unit == 0.0 {
                continue;
            }
            row[0] = (self.light[k] - own.flux * drawn.light[k]) * unit;
            row[1] = drawn.light[k] * unit;
            let slopes = &drawn.derivatives[k * stride..][..tangents.len()];
            for (value, slope) in row[2..].iter_mut().zip(slopes) {
                *value = slope * own.flux * unit;
            }
            for (value, slopes) in row[2 + tangents.len()..].iter_mut().zip(&of_shadow) {
                *value = slopes[k] * own.flux * unit;
            }
            row[width - 1] = drawn.blur_derivative[k] * own.flux * unit;
        }
        let mut sums = vec![0.0; width * width];
        for row in comparison.weigh(width, self.size).chunks_exact(width) {
            for (a, sums) in row.iter().zip(sums.chunks_exact_mut(width)) {
                for (sum, b) in sums.iter_mut().zip(row) {
                    *sum += a * b;
                }
            }
        }
        let all = DMatrix::from_row_slice(width, width, &sums);
        self.eliminate_tile_parameters(
            &all,
            &directions.shares(&changes),
            &changes,
            comparison.settings,
        )
    }

    /// Eliminates the nuisance parameters by the Schur complement and applies the chain rule.
    fn eliminate_tile_parameters(
        &self,
        all: &DMatrix<f64>,
        shares: &DMatrix<f64>,
        changes: &[ParameterDerivative],
        misfit_settings: MisfitSettings,
    ) -> TileEquations {
        let rest = all.nrows() - 1;
        let mut own = all
            .view((1, 1), (TILE_PARAMETERS, TILE_PARAMETERS))
            .into_owned();
        for k in 0..TILE_PARAMETERS {
            // A spot within one pixel does not determine its centroid; the floor keeps it in place.
            own[(k, k)] = own[(k, k)] * (1.0 + 1e-9) + 1e-12 * own[(0, 0)].max(1e-300);
        }
        let as_measured =
            misfit_settings.metric == Metric::NaturalSpectrum && !self.centroid_unknown;
        let inverse = if as_measured {
            // A lens is used with centroids aligned, so the centroid must not compensate for model error. It is
            // estimated from pixels only where noise dominates, or where they do not tell it.
            let mut light_alone = DMatrix::zeros(TILE_PARAMETERS, TILE_PARAMETERS);
            light_alone[(0, 0)] = 1.0 / own[(0, 0)];
            light_alone
        } else {
            own.clone()
                .try_inverse()
                .unwrap_or_else(|| DMatrix::zeros(TILE_PARAMETERS, TILE_PARAMETERS))
        };
        let own_right = all
            .view((1, 0), (TILE_PARAMETERS, 1))
            .column(0)
            .into_owned();
        let across = all.view((1, 1), (TILE_PARAMETERS, rest)) * shares;
        let normal = shares.transpose() * all.view((1, 1), (rest, rest)) * shares
            - across.transpose() * &inverse * &across;
        let right = shares.transpose() * all.view((1, 0), (rest, 1)).column(0)
            - across.transpose() * &inverse * &own_right;
        TileEquations {
            lens: LensEquations {
                normal,
                right,
                parameters: changes.iter().map(|c| c.slot).collect(),
            },
            back_substitution: BackSubstitution {
                inverse,
                across,
                right: own_right,
            },
        }
    }
}
