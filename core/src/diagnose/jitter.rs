//! How well ideal positions are known.
//!
//! Positions of points come from a survey or a detector and are off by some hundredths of a pixel, alike in
//! all channels of an observation and at random from one to the next. That is noise, not a gap: what
//! is left of the best hypothesis says how large it is.

use super::descent::Problem;
use super::picture::Easel;
use super::search::Candidate;
use super::seen::Seen;
use crate::psf::pupil::Detail;

/// Largest uncertainty of positions that is believed, px: more is a gap.
const MOST_PX: f64 = 0.1;

/// Standard deviation along either axis of where points are against where they should be, px, by the
/// median over observations of what `best` leaves.
pub(super) fn jitter_px(best: &Candidate, tiles: &[&Seen]) -> f64 {
    let problem = Problem {
        hypothesis: &best.hypothesis,
        tiles,
        detail: Detail::FIT,
    };
    let mut easel = Easel::default();
    let mut picture = Vec::new();
    // Normal equations of each observation's shift: xx, xy, yy, x, y.
    let mut sums: Vec<(usize, [f64; 5])> = Vec::new();
    for seen in problem.tiles.iter().filter(|t| t.placed) {
        let values = best.hypothesis.values(&best.theta, seen.of_lens);
        easel.predict(
            &best.hypothesis,
            &values,
            seen,
            problem.detail,
            &mut picture,
        );
        let [dx, dy] = gradient(seen, &picture);
        let mut own = [0.0; 5];
        for (k, (o, p)) in seen.light.iter().zip(&picture).enumerate() {
            let r = o - p;
            let terms = [
                dx[k] * dx[k],
                dx[k] * dy[k],
                dy[k] * dy[k],
                dx[k] * r,
                dy[k] * r,
            ];
            own.iter_mut()
                .zip(terms)
                .for_each(|(s, t)| *s += t / seen.norm);
        }
        match sums.last_mut() {
            Some(last) if last.0 == seen.observation => {
                last.1.iter_mut().zip(own).for_each(|(s, t)| *s += t);
            }
            _ => sums.push((seen.observation, own)),
        }
    }
    let mut far: Vec<f64> = sums
        .iter()
        .filter_map(|(_, [xx, xy, yy, x, y])| {
            let determinant = xx * yy - xy * xy;
            (determinant > 0.0).then(|| {
                let (a, b) = (
                    (yy * x - xy * y) / determinant,
                    (xx * y - xy * x) / determinant,
                );
                a.hypot(b)
            })
        })
        .collect();
    if far.is_empty() {
        return 0.0;
    }
    let middle = far.len() / 2;
    let (_, median, _) = far.select_nth_unstable_by(middle, f64::total_cmp);
    // The median of a Rayleigh distribution is 1.1774 standard deviations.
    (*median / 1.1774).min(MOST_PX)
}

/// What an uncertainty of `sigma_px` adds to the gap of `seen`, which looks like `picture`.
pub(super) fn gap_of(seen: &Seen, sigma_px: f64) -> f64 {
    let [dx, dy] = gradient(seen, &seen.light);
    let energy: f64 = dx.iter().chain(&dy).map(|d| d * d).sum();
    // Noise has a gradient too: half the sum of two pixels' variances along either axis.
    let of_noise = seen.noise * seen.norm;
    sigma_px * sigma_px * (energy - of_noise).max(0.0) / seen.norm
}

/// Derivatives of `picture` by x and y, per px.
fn gradient(seen: &Seen, picture: &[f64]) -> [Vec<f64>; 2] {
    let (width, height) = seen.size;
    let at = |x: i64, y: i64| {
        let (x, y) = (x.clamp(0, width as i64 - 1), y.clamp(0, height as i64 - 1));
        picture[y as usize * width + x as usize]
    };
    let cells = || (0..height as i64).flat_map(|y| (0..width as i64).map(move |x| (x, y)));
    [
        cells()
            .map(|(x, y)| (at(x + 1, y) - at(x - 1, y)) / 2.0)
            .collect(),
        cells()
            .map(|(x, y)| (at(x, y + 1) - at(x, y - 1)) / 2.0)
            .collect(),
    ]
}
