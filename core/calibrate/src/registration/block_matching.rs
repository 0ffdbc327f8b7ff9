//! Blocks of one picture found in another by normalised cross-correlation.

use rayon::prelude::*;
use seidel_optics::field::ImagePoint;

use super::picture::Picture;
use super::similarity::PointPair;
use seidel_optics::numeric::dot;

/// Side of a block, px.
const BLOCK: usize = 64;
/// Blocks along the longer and the shorter side.
const BLOCKS: (usize, usize) = (8, 5);
/// Correlation from which a block of smoothed pictures counts as found. Blocks of noise stay below 0.4.
const LEAST_CORRELATION: f64 = 0.45;

/// Finds blocks of `from` in `to`, within `reach` px of `shift` along both axes.
pub(super) fn matches(
    from: &Picture,
    to: &Picture,
    shift: [isize; 2],
    reach: usize,
) -> Vec<PointPair> {
    let margin = reach as isize;
    // The part of `from` whose blocks lie inside `to` at every shift tried.
    let room = |own: usize, other: usize, shift: isize| {
        let first = (margin - shift).max(0);
        let last = (own as isize).min(other as isize - margin - shift) - BLOCK as isize;
        (first, last)
    };
    let (left, right) = room(from.width, to.width, shift[0]);
    let (top, bottom) = room(from.height, to.height, shift[1]);
    if right < left || bottom < top {
        return Vec::new();
    }
    let along = |first: isize, last: isize, count: usize| {
        (0..count as isize).map(move |k| first + (last - first) * k / (count as isize - 1).max(1))
    };
    let places: Vec<(isize, isize)> = along(top, bottom, BLOCKS.1)
        .flat_map(|y| along(left, right, BLOCKS.0).map(move |x| (x, y)))
        .collect();
    places
        .par_iter()
        .filter_map(|&(x, y)| match_block(from, to, (x, y), shift, reach))
        .collect()
}

fn match_block(
    from: &Picture,
    to: &Picture,
    place: (isize, isize),
    shift: [isize; 2],
    reach: usize,
) -> Option<PointPair> {
    let side = 2 * reach + 1;
    let block = cut(from, place)?;
    let scores: Vec<f64> = (0..side * side)
        .map(|k| {
            let (dx, dy) = ((k % side) as isize, (k / side) as isize);
            let reach = reach as isize;
            let at = (
                place.0 + shift[0] + dx - reach,
                place.1 + shift[1] + dy - reach,
            );
            cut(to, at).map_or(-1.0, |other| dot(&block, &other))
        })
        .collect();
    let best = (0..scores.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b]))?;
    let (x, y) = (best % side, best / side);
    let is_inside = (1..side - 1).contains(&x) && (1..side - 1).contains(&y);
    if scores[best] < LEAST_CORRELATION || !is_inside {
        return None;
    }
    let offset = |best: usize, at: usize, step: usize, shift: isize| {
        (at as isize + shift - reach as isize) as f64
            + vertex(scores[best - step], scores[best], scores[best + step])
    };
    let half = BLOCK as f64 / 2.0;
    let centre = ImagePoint::new(place.0 as f64 + half, place.1 as f64 + half);
    Some(PointPair {
        from: centre,
        to: ImagePoint::new(
            centre.x_px + offset(best, x, 1, shift[0]),
            centre.y_px + offset(best, y, side, shift[1]),
        ),
    })
}

/// Returns the vertex of the parabola through three equidistant values, from the middle one.
fn vertex(before: f64, middle: f64, after: f64) -> f64 {
    let bend = before - 2.0 * middle + after;
    if bend < 0.0 {
        ((before - after) / (2.0 * bend)).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// Returns the block at `place`, less its mean and of unit norm; `None` where it is even or has unknown samples.
fn cut(picture: &Picture, place: (isize, isize)) -> Option<Vec<f64>> {
    let (left, top) = (
        usize::try_from(place.0).ok()?,
        usize::try_from(place.1).ok()?,
    );
    if left + BLOCK > picture.width || top + BLOCK > picture.height {
        return None;
    }
    let mut block: Vec<f64> = (top..top + BLOCK)
        .flat_map(|row| &picture.samples[row * picture.width + left..][..BLOCK])
        .map(|v| f64::from(*v))
        .collect();
    let mean = block.iter().sum::<f64>() / block.len() as f64;
    block.iter_mut().for_each(|v| *v -= mean);
    let norm = dot(&block, &block).sqrt();
    if !norm.is_finite() || norm <= 0.0 {
        return None;
    }
    block.iter_mut().for_each(|v| *v /= norm);
    Some(block)
}
