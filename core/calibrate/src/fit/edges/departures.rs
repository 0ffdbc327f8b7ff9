//! Departures of edges from what any lens of rotational symmetry makes: signs of photographs that show more than a lens.
//!
//! A lens of rotational symmetry has the variances and third moments of `edge_moments::rows`. Two terms beyond them have causes of
//! their own. A variance `B cos 2t + C sin 2t` along normals of angle t that is the same all over the frame is that of a moving
//! camera, or of an image squeezed along one axis. A third moment that does not change its sign when the normal is reversed is none
//! of a point-spread function: bright and dark sides were treated unequally, as by a transfer function that was not undone.

use super::edge_moments::{moment, rows};
use crate::least_squares;
use seidel_optics::edges::Edge;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::numeric::{dot, median};

/// A term with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// The value.
    pub value: f64,
    /// Its standard error from the scatter of the edges.
    pub sigma: f64,
}

/// Departures of edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departures {
    /// Half the difference of the variances along and across the direction of the longer blur, the same all over the frame, px².
    pub elongation_px2: Term,
    /// Direction of the longer blur, degrees from the x axis towards y, 0 to 180; the nearer of the normals of edges that have only
    /// two orientations.
    pub direction_deg: f64,
    /// Mean variance of the edges, px².
    pub variance_px2: f64,
    /// Skewness from dark to bright that is the same for opposite edges.
    pub skewness: Term,
}

/// Iterations of reweighting, and the residual over the expected one from which on an edge loses weight.
const ITERATIONS: usize = 6;
const TOLERANCE: f64 = 3.0;
/// Terms of a lens.
const OF_LENS: usize = 5;

impl Departures {
    /// Estimates the departures of `groups`, each of one channel at one distance, for an axis as `frame` has it: the weighted mean of
    /// all that determine them. `None` where none does, as with a single orientation.
    pub fn of(frame: &Frame, groups: &[Vec<&Edge>]) -> Option<Self> {
        let basis = basis(groups.iter().flatten());
        let directed = |at: FieldPoint, normal: [f64; 2]| directed(&basis, at, normal);
        let mut sums = vec![Sum::default(); basis.len() + 1];
        let (mut variances, mut count) = (0.0, 0.0);
        for edges in groups {
            let Some(second) = with_terms(frame, edges, 0, &directed) else {
                continue;
            };
            let Some(third) = with_terms(frame, edges, 1, &|_, _| vec![1.0]) else {
                continue;
            };
            let mut own: Vec<f64> = edges.iter().map(|e| e.variance_px2).collect();
            variances += own.iter().sum::<f64>();
            count += own.len() as f64;
            let width = (median(&mut own).max(0.0) + PIXEL_VARIANCE_PX2).sqrt();
            let skewness = Term {
                value: third[0].value / width.powi(3),
                sigma: third[0].sigma / width.powi(3),
            };
            let own = second.into_iter().take(basis.len()).chain([skewness]);
            for (sum, term) in sums.iter_mut().zip(own) {
                sum.add(term);
            }
        }
        let means: Vec<Term> = sums.into_iter().map(Sum::mean).collect();
        let (skewness, along) = means.split_last()?;
        let part = |k: usize| {
            let pairs = along.iter().zip(&basis);
            pairs.map(|(term, axis)| term.value * axis[k]).sum::<f64>()
        };
        let (cosine, sine) = (part(0), part(1));
        (count > 0.0).then(|| Self {
            elongation_px2: Term {
                value: cosine.hypot(sine),
                sigma: along.iter().map(|t| t.sigma).fold(0.0, f64::max),
            },
            direction_deg: (0.5 * sine.atan2(cosine)).to_degrees().rem_euclid(180.0),
            variance_px2: variances / count,
            skewness: *skewness,
        })
    }
}

/// Sums of a weighted mean.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    value: f64,
    weight: f64,
}

impl Sum {
    fn add(&mut self, term: Term) {
        let weight = term.sigma.max(f64::MIN_POSITIVE).powi(-2);
        self.value += weight * term.value;
        self.weight += weight;
    }

    fn mean(self) -> Term {
        Term {
            value: self.value / self.weight,
            sigma: self.weight.sqrt().recip(),
        }
    }
}

/// Share of the largest below which the smaller spread of orientations counts as none.
const MIN_SPREAD: f64 = 0.02;

/// Returns the directions, at twice the angle of normals, in which the edges determine an elongation: two, or one for edges of two
/// orientations at right angles, as those of a checkerboard.
fn basis<'e>(edges: impl Iterator<Item = &'e &'e Edge>) -> Vec<[f64; 2]> {
    let mut tensor = [0.0; 3];
    for edge in edges {
        let [c, s] = doubled(edge.normal);
        tensor = [tensor[0] + c * c, tensor[1] + c * s, tensor[2] + s * s];
    }
    let [cc, cs, ss] = tensor;
    let (sin, cos) = (0.5 * (2.0 * cs).atan2(cc - ss)).sin_cos();
    let (half, turned) = ((cc + ss) / 2.0, ((cc - ss) / 2.0).hypot(cs));
    let mut basis = vec![[cos, sin]];
    if half - turned > MIN_SPREAD * (half + turned) {
        basis.push([-sin, cos]);
    }
    basis
}

/// Returns the unit vector at twice the angle of `normal`.
fn doubled([x, y]: [f64; 2]) -> [f64; 2] {
    [x * x - y * y, 2.0 * x * y]
}

/// Returns the terms of an elongation along `basis`, and two of fifth order in the field: a frame is wider than high, so that without
/// them astigmatism of high order looks like an elongation along it.
fn directed(basis: &[[f64; 2]], at: FieldPoint, normal: [f64; 2]) -> Vec<f64> {
    let r2 = at.x * at.x + at.y * at.y;
    let along = at.x * normal[0] + at.y * normal[1];
    let twice = doubled(normal);
    let mut terms: Vec<f64> = basis.iter().map(|axis| dot(axis, &twice)).collect();
    terms.extend([r2 * r2 * along * along, r2.powi(3)]);
    terms
}

/// Fits moment `which` of the edges by the terms of a lens and `more`, robustly, and returns the terms of `more`.
fn with_terms(
    frame: &Frame,
    edges: &[&Edge],
    which: usize,
    more: &dyn Fn(FieldPoint, [f64; 2]) -> Vec<f64>,
) -> Option<Vec<Term>> {
    let rows: Vec<Vec<f64>> = (edges.iter())
        .map(|e| {
            let at = frame.field_point(e.mid);
            let mut row = rows(at, e.normal)[which].to_vec();
            row.extend(more(at, e.normal));
            row
        })
        .collect();
    let (targets, sigmas): (Vec<f64>, Vec<f64>) = edges.iter().map(|e| moment(e, which)).unzip();
    let floor = 0.5 * median(&mut sigmas.clone());
    let weights: Vec<f64> = sigmas.iter().map(|s| 1.0 / s.max(floor)).collect();
    let mut found = least_squares::solve(&rows, &targets, &weights).ok()?;
    for _ in 0..ITERATIONS {
        let residual = |k: usize| (targets[k] - dot(&rows[k], &found.values)).abs() * weights[k];
        let scaled: Vec<f64> = (0..rows.len()).map(residual).collect();
        let scatter = (1.4826 * median(&mut scaled.clone())).max(1e-9);
        let robust: Vec<f64> = (weights.iter().zip(&scaled))
            .map(|(w, r)| w / (1.0 + (r / (TOLERANCE * scatter)).powi(2)).sqrt())
            .collect();
        found = least_squares::solve(&rows, &targets, &robust).ok()?;
    }
    let pairs = found.values.iter().zip(&found.sigma).skip(OF_LENS);
    let terms: Vec<Term> = pairs
        .map(|(value, sigma)| Term {
            value: *value,
            sigma: *sigma,
        })
        .collect();
    let is_sound = terms
        .iter()
        .all(|t| t.value.is_finite() && t.sigma.is_finite());
    is_sound.then_some(terms)
}
