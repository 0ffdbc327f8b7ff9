//! The distance of a traced lens from every third-order lens.

use super::beam::{Beam, OpenCell};
use super::lens::GlassLens;
use super::tiles::CELLS_COARSE;
use crate::expose::{difference, tile_of};
use crate::mask::Mask;
use crate::pencil::Pencil;
use crate::rays;
use crate::sensor::{FineGrid, Sensor};
use seidel_optics::field::FieldPoint;

/// Field radii at which lenses are compared, half frame widths.
const FIELDS: [f64; 6] = [0.0, 0.3, 0.55, 0.75, 0.95, 1.12];
/// Cells across a beam for the fit.
const FIT_CELLS: usize = 24;
/// Number of third-order coefficients of a channel and distance: defocus, field curvature, astigmatism, spherical
/// aberration, coma.
const TERMS: usize = 5;
/// Range of the gap to the nearest third-order lens of designs that are too rich for one. The fit of a lens to pixels comes
/// closer than this fit to rays, and its own gap must stay above 0.005.
const TOO_RICH: [f64; 2] = [0.05, 0.5];

/// Returns the third-order pencil at field radius `h` along x with the given coefficients.
fn pencil(h: f64, coefficients: [f64; TERMS]) -> Pencil {
    let [defocus, curvature, astigmatism, spherical, coma] = coefficients;
    let mut pencil = Pencil::sharp([h, 0.0], [0.0; 2]);
    pencil.defocus(defocus + curvature * h * h);
    pencil.linear[0] += astigmatism * h * h;
    pencil.spherical = spherical;
    pencil.coma = [coma * h, 0.0];
    pencil
}

/// The light of a beam relative to its mean.
struct CentredBeam {
    h: f64,
    cells: Vec<OpenCell>,
    light: f64,
}

impl CentredBeam {
    fn new(h: f64, beam: &Beam) -> Self {
        let mut cells = Vec::new();
        beam.for_each(FIT_CELLS, |cell| cells.push(cell));
        let light = cells.iter().map(|c| c.light).sum();
        Self { h, cells, light }
    }

    /// Returns `values` of all cells less their mean, weighted by light.
    fn centred(&self, values: impl Fn(&OpenCell) -> [f64; 2]) -> Vec<[f64; 2]> {
        let values: Vec<[f64; 2]> = self.cells.iter().map(values).collect();
        let mean: [f64; 2] = std::array::from_fn(|i| {
            let weighted = values.iter().zip(&self.cells).map(|(v, c)| c.light * v[i]);
            weighted.sum::<f64>() / self.light
        });
        values
            .into_iter()
            .map(|v| [v[0] - mean[0], v[1] - mean[1]])
            .collect()
    }
}

/// Solves the normal equations of a positive definite matrix by elimination; a term without influence is 0.
fn solve(mut matrix: [[f64; TERMS]; TERMS], mut right: [f64; TERMS]) -> [f64; TERMS] {
    for k in 0..TERMS {
        let pivot = matrix[k];
        if pivot[k] < 1e-12 {
            continue;
        }
        for row in k + 1..TERMS {
            let factor = matrix[row][k] / pivot[k];
            for (entry, above) in matrix[row].iter_mut().zip(pivot) {
                *entry -= factor * above;
            }
            right[row] -= factor * right[k];
        }
    }
    let mut solution = [0.0; TERMS];
    for k in (0..TERMS).rev() {
        let known: f64 = (k + 1..TERMS).map(|i| matrix[k][i] * solution[i]).sum();
        if matrix[k][k] >= 1e-12 {
            solution[k] = (right[k] - known) / matrix[k][k];
        }
    }
    solution
}

/// Returns the coefficients of the third-order lens nearest to the rays of `beams`, by least squares.
fn fit(beams: &[CentredBeam]) -> [f64; TERMS] {
    let mut matrix = [[0.0; TERMS]; TERMS];
    let mut right = [0.0; TERMS];
    for beam in beams {
        let target = beam.centred(|cell| cell.at);
        let terms: [Vec<[f64; 2]>; TERMS] = std::array::from_fn(|term| {
            let unit = std::array::from_fn(|i| f64::from(u8::from(i == term)));
            let pencil = pencil(beam.h, unit);
            beam.centred(|cell| pencil.slope(cell.stop))
        });
        let product = |a: &[[f64; 2]], b: &[[f64; 2]]| -> f64 {
            let pairs = a.iter().zip(b).zip(&beam.cells);
            pairs
                .map(|((a, b), cell)| cell.light * (a[0] * b[0] + a[1] * b[1]))
                .sum::<f64>()
                / beam.light
        };
        for i in 0..TERMS {
            for k in 0..TERMS {
                matrix[i][k] += product(&terms[i], &terms[k]);
            }
            right[i] += product(&terms[i], &target);
        }
    }
    solve(matrix, right)
}

impl GlassLens {
    /// Returns whether the design is clearly beyond the third-order model, but not so far that a fit is meaningless.
    pub(super) fn is_too_rich(&self, tile: usize) -> bool {
        let [least, most] = TOO_RICH;
        (self.third_order_gap(tile)).is_some_and(|gap| (least..=most).contains(&gap))
    }

    /// Returns the mean over channels, fields and the extreme distances of |o - p|² / |o|². o is a tile of the design and p
    /// that of the third-order lens with a full round stop nearest to its rays, with the same centroid. `None` if no light
    /// passes.
    pub(super) fn third_order_gap(&self, tile: usize) -> Option<f64> {
        let mask = Mask::default();
        let sensor = Sensor::default();
        let depths = &self.camera.depths_m;
        let extremes = &[depths[0], depths[depths.len() - 1]];
        let (mut sum, mut count) = (0.0, 0.0);
        for &depth_m in &extremes[..depths.len().min(2)] {
            for channel in 0..crate::lens::CHANNELS.len() {
                let beams: Vec<Beam> = FIELDS
                    .iter()
                    .map(|&h| {
                        let at = self.camera.frame.image_point(FieldPoint::new(h, 0.0));
                        let object = self.design.object([at.x_px, at.y_px], depth_m);
                        Beam::new(&self.design, channel, object, &mask)
                    })
                    .collect::<Option<_>>()?;
                let centred: Vec<CentredBeam> = FIELDS
                    .iter()
                    .zip(&beams)
                    .map(|(&h, beam)| CentredBeam::new(h, beam))
                    .collect();
                let coefficients = fit(&centred);
                for (&h, beam) in FIELDS.iter().zip(&beams) {
                    let centroid = beam.centroid();
                    let centre = centroid.map(|c| c.floor() + 0.5);
                    let mut fine = FineGrid::new(tile, &sensor);
                    rays::trace(beam, centre, CELLS_COARSE, &mut fine);
                    let traced = sensor.integrate(&fine, tile);
                    let mut near = pencil(h, coefficients);
                    let own = near.centroid();
                    near.chief = [centroid[0] - own[0], centroid[1] - own[1]];
                    let drawn = tile_of(&near, centre, tile, CELLS_COARSE);
                    sum += difference(&traced, &drawn);
                    count += 1.0;
                }
            }
        }
        Some(sum / count)
    }
}
