//! The discrete gradient D in four directions, its adjoint and its power response.
//!
//! D x has four components at each pixel: differences to the neighbours on the right and below, and to the two diagonal
//! neighbours below, these weighted by 1 / sqrt(2). Differences across the edges of a plane are zero. Total variation
//! is the sum over pixels of |D x|, the Euclidean norm of the four components, so that edges of any orientation cost
//! alike.

use super::vectors::{Gram, short_gram};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A weighted difference between a pixel and a neighbour.
struct Difference {
    /// Columns to the neighbour.
    dx: i32,
    /// Rows to the neighbour.
    dy: usize,
    weight: f32,
}

/// The components of D.
const DIFFERENCES: [Difference; 4] = [
    Difference {
        dx: 1,
        dy: 0,
        weight: 1.0,
    },
    Difference {
        dx: 0,
        dy: 1,
        weight: 1.0,
    },
    Difference {
        dx: 1,
        dy: 1,
        weight: std::f32::consts::FRAC_1_SQRT_2,
    },
    Difference {
        dx: -1,
        dy: 1,
        weight: std::f32::consts::FRAC_1_SQRT_2,
    },
];

/// Fewest rows on which [`sampled_norms`] looks, if the plane has as many.
const SAMPLED_ROWS: usize = 128;

/// Returns |D|² at the frequency (`x`, `y`), cycles a pixel: the eigenvalue of Dᵀ D for that wave.
pub(super) fn power_response(x: f64, y: f64) -> f64 {
    let powers = DIFFERENCES.iter().map(|Difference { dx, dy, weight }| {
        let phase = TAU * (x * f64::from(*dx) + y * *dy as f64);
        f64::from(*weight).powi(2) * (2.0 - 2.0 * phase.cos())
    });
    powers.sum()
}

/// Returns the expected |D n|² of white noise n of unit variance.
pub(super) fn white_noise_power() -> f64 {
    let weights = DIFFERENCES.iter().map(|difference| difference.weight);
    weights.map(|weight| 2.0 * f64::from(weight * weight)).sum()
}

/// A vector with four components at each pixel: D x, or a variable of that shape.
#[derive(Clone)]
pub(super) struct Gradient {
    width: usize,
    components: [Vec<f32>; 4],
}

/// Pixels of a row that have a neighbour on the plane, and those neighbours.
struct Neighbours<'a> {
    /// Column of the first pixel.
    first: usize,
    pixels: &'a [f32],
    neighbours: &'a [f32],
}

fn neighbours(plane: &[f32], width: usize, row: usize, component: usize) -> Neighbours<'_> {
    let Difference { dx, dy, .. } = DIFFERENCES[component];
    let first = (-dx).max(0) as usize;
    let length = width.saturating_sub(dx.unsigned_abs() as usize);
    let neighbour = (row + dy) * width + (first as i32 + dx).max(0) as usize;
    if neighbour + length > plane.len() {
        return Neighbours {
            first,
            pixels: &[],
            neighbours: &[],
        };
    }
    let pixel = row * width + first;
    Neighbours {
        first,
        pixels: &plane[pixel..pixel + length],
        neighbours: &plane[neighbour..neighbour + length],
    }
}

/// The differences of a plane that count: those between pixels of one surface.
#[derive(Clone)]
pub(super) struct Links(Vec<u8>);

impl Links {
    /// Links the pixels of a plane of `count` pixels, `width` pixels wide, with those neighbours for which `is_linked` holds.
    pub(super) fn new(
        count: usize,
        width: usize,
        is_linked: impl Fn(usize, usize) -> bool + Sync,
    ) -> Self {
        let bits = |k: usize| {
            let (x, height) = ((k % width) as i32, count / width);
            let linked = |difference: &Difference| {
                let Difference { dx, dy, .. } = *difference;
                let on_plane = (0..width as i32).contains(&(x + dx)) && k / width + dy < height;
                on_plane && is_linked(k, (k as i32 + dx) as usize + dy * width)
            };
            let components = DIFFERENCES.iter().enumerate();
            components.fold(0, |bits, (component, difference)| {
                bits | u8::from(linked(difference)) << component
            })
        };
        Self((0..count).into_par_iter().map(bits).collect())
    }

    /// Returns these links and those of a plane below.
    pub(super) fn followed_by(mut self, below: Self) -> Self {
        self.0.extend(below.0);
        self
    }

    fn cut(&self, row: usize, width: usize, component: usize, differences: &mut [f32]) {
        let bits = &self.0[row * width..];
        for (difference, bits) in differences.iter_mut().zip(bits) {
            *difference *= f32::from(bits >> component & 1);
        }
    }
}

/// A plane and its links; without links all neighbours are linked.
#[derive(Clone, Copy)]
pub(super) struct LinkedPlane<'a> {
    pub(super) samples: &'a [f32],
    pub(super) width: usize,
    pub(super) links: Option<&'a Links>,
}

impl<'a> LinkedPlane<'a> {
    /// A plane of one surface, whose neighbours are all linked.
    pub(super) fn plain(samples: &'a [f32], width: usize) -> Self {
        Self {
            samples,
            width,
            links: None,
        }
    }
}

/// Writes one component of D `plane` on a row to `out`.
fn difference_row(plane: LinkedPlane, row: usize, component: usize, out: &mut [f32]) {
    let LinkedPlane { samples, width, .. } = plane;
    let weight = DIFFERENCES[component].weight;
    let near = neighbours(samples, width, row, component);
    out.fill(0.0);
    let pairs = near.pixels.iter().zip(near.neighbours);
    for (out, (a, b)) in out[near.first.min(width)..].iter_mut().zip(pairs) {
        *out = weight * (b - a);
    }
    if let Some(links) = plane.links {
        links.cut(row, width, component, out);
    }
}

/// Returns the Gram matrix of D `a` and D `b`, planes with the same links.
pub(super) fn gradient_gram(a: LinkedPlane, b: LinkedPlane) -> Gram {
    let width = a.width;
    let rows: Vec<Gram> = (0..a.samples.len() / width.max(1))
        .into_par_iter()
        .map_init(
            || (vec![0.0; width], vec![0.0; width]),
            |(row_a, row_b), row| {
                let components = (0..DIFFERENCES.len()).map(|component| {
                    difference_row(a, row, component, row_a);
                    difference_row(b, row, component, row_b);
                    short_gram(row_a, row_b)
                });
                Gram::total(components)
            },
        )
        .collect();
    Gram::total(rows.into_iter())
}

/// Returns |D `plane`| on evenly spaced rows, 128 to 255 of them or all: enough for statistics.
pub(super) fn sampled_norms(plane: LinkedPlane) -> Vec<f32> {
    let height = plane.samples.len() / plane.width.max(1);
    norms_on_rows(plane, (height / SAMPLED_ROWS).max(1))
}

/// Returns |D `plane`| of each pixel, row-major.
pub(super) fn norms(plane: LinkedPlane) -> Vec<f32> {
    norms_on_rows(plane, 1)
}

fn norms_on_rows(plane: LinkedPlane, step: usize) -> Vec<f32> {
    let width = plane.width;
    let height = plane.samples.len() / width.max(1);
    let rows: Vec<Vec<f32>> = (0..height)
        .into_par_iter()
        .step_by(step)
        .map_init(
            || [(); 4].map(|()| vec![0.0; width]),
            |components, row| {
                for (component, out) in components.iter_mut().enumerate() {
                    difference_row(plane, row, component, out);
                }
                (0..width).map(|k| norm(components, k)).collect()
            },
        )
        .collect();
    rows.concat()
}

fn norm(components: &[Vec<f32>; 4], k: usize) -> f32 {
    let [a, b, c, d] = [
        components[0][k],
        components[1][k],
        components[2][k],
        components[3][k],
    ];
    (a * a + b * b + c * c + d * d).sqrt()
}

impl Gradient {
    /// Returns zeros for a plane of `count` pixels.
    pub(super) fn zeros(count: usize, width: usize) -> Self {
        Self {
            width,
            components: [(); 4].map(|()| vec![0.0; count]),
        }
    }

    /// Updates the split variable z and the scaled multiplier u of ADMM, which is `self`, for the image x `plane`.
    ///
    /// With v = D x + u, z is v shortened by `threshold` (soft thresholding of its norm at each pixel), and the new u
    /// is v - z. Returns z - u - D x with the new u, the residual that pulls the next image.
    pub(super) fn update_multiplier(&mut self, plane: LinkedPlane, threshold: f32) -> Self {
        let width = self.width;
        let mut pull = Self::zeros(plane.samples.len(), width);
        let [u0, u1, u2, u3] = (self.components)
            .each_mut()
            .map(|component| component.par_chunks_mut(width));
        let [p0, p1, p2, p3] = (pull.components)
            .each_mut()
            .map(|component| component.par_chunks_mut(width));
        let multipliers = u0.zip(u1).zip(u2).zip(u3);
        let pulls = p0.zip(p1).zip(p2).zip(p3);
        multipliers.zip(pulls).enumerate().for_each(
            |(row, ((((u0, u1), u2), u3), (((p0, p1), p2), p3)))| {
                let (u, mut p) = ([u0, u1, u2, u3], [p0, p1, p2, p3]);
                for (component, out) in p.iter_mut().enumerate() {
                    difference_row(plane, row, component, out);
                }
                for k in 0..width {
                    let gradient = [p[0][k], p[1][k], p[2][k], p[3][k]];
                    let multiplier = [u[0][k], u[1][k], u[2][k], u[3][k]];
                    let mut square = 0.0;
                    for c in 0..4 {
                        square += (gradient[c] + multiplier[c]) * (gradient[c] + multiplier[c]);
                    }
                    // The share of v that the threshold removes: u = share * v and z = v - u.
                    let share = threshold / square.sqrt().max(threshold);
                    for c in 0..4 {
                        let v = gradient[c] + multiplier[c];
                        let next = share * v;
                        u[c][k] = next;
                        p[c][k] = v - 2.0 * next - gradient[c];
                    }
                }
            },
        );
        pull
    }

    /// Returns Dᵀ applied to this vector.
    pub(super) fn adjoint(&self) -> Vec<f32> {
        let width = self.width;
        let mut sum = vec![0.0; self.components[0].len()];
        let rows = sum.par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(row, out)| {
            for (component, Difference { dx, dy, weight }) in
                self.components.iter().zip(&DIFFERENCES)
            {
                for (out, difference) in out.iter_mut().zip(&component[row * width..]) {
                    *out -= weight * difference;
                }
                if row < *dy {
                    continue;
                }
                // Differences of the pixels whose neighbour lies on this row.
                let above = &component[(row - dy) * width..][..width];
                let (to, from) = match *dx {
                    ..0 => (&mut out[..width - 1], &above[1..]),
                    0 => (&mut *out, above),
                    1.. => (&mut out[1..], &above[..width - 1]),
                };
                for (out, difference) in to.iter_mut().zip(from) {
                    *out += weight * difference;
                }
            }
        });
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{HEIGHT, NormalDeviates, WIDTH};
    use super::super::vectors;
    use super::*;

    fn gradient(plane: &[f32]) -> Gradient {
        let mut gradient = Gradient::zeros(plane.len(), WIDTH);
        for (component, out) in gradient.components.iter_mut().enumerate() {
            for (row, out) in out.chunks_exact_mut(WIDTH).enumerate() {
                difference_row(LinkedPlane::plain(plane, WIDTH), row, component, out);
            }
        }
        gradient
    }

    fn dot(a: &Gradient, b: &Gradient) -> f64 {
        let components = a.components.iter().zip(&b.components);
        components.map(|(a, b)| vectors::dot(a, b)).sum()
    }

    #[test]
    fn adjoint_matches_inner_products() {
        let mut deviates = NormalDeviates(3);
        let x = deviates.plane(WIDTH * HEIGHT);
        let y = deviates.plane(WIDTH * HEIGHT);
        let (gradient_x, gradient_y) = (gradient(&x), gradient(&y));
        let pairs = x.iter().zip(gradient_y.adjoint());
        let back: f64 = pairs.map(|(a, b)| f64::from(*a) * f64::from(b)).sum();
        let scale = (dot(&gradient_x, &gradient_x) * dot(&gradient_y, &gradient_y)).sqrt();
        assert!((dot(&gradient_x, &gradient_y) - back).abs() < 1e-6 * scale);
    }

    /// A wave is an eigenvector of Dᵀ D away from the edges.
    #[test]
    fn power_response_is_the_eigenvalue_of_a_wave() {
        let (u, v) = (0.11, 0.23);
        let phase = |k: usize| TAU * (u * (k % WIDTH) as f64 + v * (k / WIDTH) as f64);
        let wave: Vec<f32> = (0..WIDTH * HEIGHT).map(|k| phase(k).cos() as f32).collect();
        let found = gradient(&wave).adjoint();
        let at = 70 * WIDTH + 80;
        for k in at..at + 9 {
            let wanted = power_response(u, v) * f64::from(wave[k]);
            assert!((f64::from(found[k]) - wanted).abs() < 1e-4, "{k}");
        }
    }
}
