//! Strips: the parts of segments beside which there is nothing but the edge.

use rayon::prelude::*;

use super::line_fit::{self, LineFit};
use super::segments::Segment;
use super::{MAX_MISFIT, Scene};
use crate::rejection::{LeftOut, Reason};

/// Distance at which the blur of an edge has ended, standard deviations of the channel of widest blur. A disc ends at 2, with
/// its rim blurred further; spherical aberration and coma reach farther.
const REACH_SIGMAS: f64 = 2.8;
/// Distance from a corner, beyond the reach of the blur, px.
const CORNER_PX: f64 = 1.5;
/// Length of each level beside the blur that a profile needs, and the largest that is used, px.
const LEAST_LEVEL_PX: f64 = 2.5;
const MOST_LEVEL_PX: f64 = 6.0;
/// Edges around one whose blur counts for it, as that along the edge shows in those across it.
const NEIGHBOURS: usize = 6;
/// Length of a piece of a long edge: at least so many px, and share of the frame's width.
const PIECE_PX: f64 = 48.0;
const PIECE_SHARE: f64 = 1.0 / 24.0;
/// Distance between points of other edges, px.
const STEP_PX: f64 = 2.0;

/// A straight piece of an edge with its surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strip {
    pub(super) segment: Segment,
    /// Half its length, px.
    pub(super) half_length: f64,
    /// Extent on the dark and on the bright side, px.
    pub(super) extent: [f64; 2],
}

impl Strip {
    /// Returns whether the strip holds a point at `s` along the edge and `t` along its normal.
    pub(super) fn holds(&self, s: f64, t: f64) -> bool {
        s.abs() <= self.half_length && t >= -self.extent[0] && t <= self.extent[1]
    }

    /// Returns the bounds in the frame: left, top, right, bottom, px.
    pub(super) fn bounds(&self) -> [f64; 4] {
        let mut bounds = [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        ];
        for s in [-self.half_length, self.half_length] {
            for t in [-self.extent[0], self.extent[1]] {
                let [x, y] = self.segment.point(s);
                let [nx, ny] = self.segment.normal;
                let (x, y) = (x + t * nx, y + t * ny);
                bounds[0] = bounds[0].min(x);
                bounds[1] = bounds[1].min(y);
                bounds[2] = bounds[2].max(x);
                bounds[3] = bounds[3].max(y);
            }
        }
        bounds
    }

    /// Returns the normal of the fitted line, and the frame position of its middle, `centroid` px beside it.
    pub(super) fn place(&self, line: &LineFit, centroid: f64) -> ([f64; 2], [f64; 2]) {
        let [ux, uy] = self.segment.along();
        let [nx, ny] = self.segment.normal;
        let [c0, c1, _] = line.line;
        let length = c1.hypot(1.0);
        let normal = [(nx - c1 * ux) / length, (ny - c1 * uy) / length];
        let mid = self.segment.mid;
        let mid = [
            mid[0] + c0 * nx + centroid * normal[0],
            mid[1] + c0 * ny + centroid * normal[1],
        ];
        (normal, mid)
    }
}

/// Returns the strips of `segments` that are usable.
pub(super) fn of(scene: &Scene, segments: &[Segment], left_out: &mut Vec<LeftOut>) -> Vec<Strip> {
    let refined: Vec<Result<Segment, LeftOut>> = segments
        .par_iter()
        .map(|segment| refined(scene, segment))
        .collect();
    let mut sound = Vec::new();
    for segment in refined {
        match segment {
            Ok(segment) => sound.push(segment),
            Err(why) => left_out.push(why),
        }
    }
    let reaches: Vec<f64> = (0..sound.len())
        .into_par_iter()
        .map(|index| REACH_SIGMAS * widest_near(&sound, index))
        .collect();
    let found: Vec<Vec<Result<Strip, LeftOut>>> = (0..sound.len())
        .into_par_iter()
        .map(|index| strips_of(scene, &sound, &reaches, index))
        .collect();
    let mut strips = Vec::new();
    for strip in found.into_iter().flatten() {
        match strip {
            Ok(strip) => strips.push(strip),
            Err(why) => left_out.push(why),
        }
    }
    strips
}

/// Returns `segment` on the line fitted to the reference channel, with the width of its blur in the channel where it is widest.
fn refined(scene: &Scene, segment: &Segment) -> Result<Segment, LeftOut> {
    let out = |why, value, limit| Err(scene.left_out(segment, why, value, limit));
    let extent = 2.2 * segment.sigma + 2.0;
    let strip = Strip {
        segment: *segment,
        half_length: (segment.length / 2.0 - segment.sigma - 1.0).max(4.0),
        extent: [extent; 2],
    };
    let (mut pixels, clipped) = scene.pixels(&strip, scene.photo.reference_channel());
    if clipped > pixels.len() / 4 {
        let white = f64::from(scene.photo.white);
        return out(Reason::Clipped, white, white);
    }
    if pixels.len() < line_fit::MIN_PIXELS {
        let limit = scene.settings.min_length_px;
        return out(Reason::ShortEdge, segment.length, limit);
    }
    let Some(line) = line_fit::fit(&mut pixels, segment.sigma) else {
        return out(Reason::NotAnEdge, 1.0, MAX_MISFIT);
    };
    if line.step <= 0.0 || line.line[0].abs() > extent || line.sigma > extent {
        // Not a step at this place, however well the line fits.
        return out(Reason::NotAnEdge, 1.0, MAX_MISFIT);
    }
    let others = (0..scene.photo.channels.len()).filter_map(|channel| {
        let (mut pixels, _) = scene.pixels(&strip, channel);
        line_fit::fit(&mut pixels, line.sigma)
    });
    // A channel in which the fit failed would be far wider.
    let widths = others
        .map(|fit| fit.sigma)
        .filter(|s| *s < 2.0 * line.sigma);
    let (normal, mid) = strip.place(&line, 0.0);
    Ok(Segment {
        mid,
        normal,
        length: segment.length,
        sigma: widths.fold(line.sigma, f64::max),
    })
}

/// Returns the largest width among segment `index` and its neighbours.
fn widest_near(segments: &[Segment], index: usize) -> f64 {
    let here = segments[index].mid;
    let mut near: Vec<(f64, f64)> = (segments.iter())
        .map(|s| ((s.mid[0] - here[0]).hypot(s.mid[1] - here[1]), s.sigma))
        .collect();
    let count = NEIGHBOURS.min(near.len() - 1);
    near.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0));
    let mut widths: Vec<f64> = near[..=count].iter().map(|n| n.1).collect();
    // The second widest, so that a single bad neighbour does not count.
    widths.sort_by(|a, b| b.total_cmp(a));
    widths
        .get(1)
        .copied()
        .unwrap_or(widths[0])
        .max(segments[index].sigma)
}

fn strips_of(
    scene: &Scene,
    segments: &[Segment],
    reaches: &[f64],
    index: usize,
) -> Vec<Result<Strip, LeftOut>> {
    let segment = &segments[index];
    let used = segment.length - 2.0 * (reaches[index] + CORNER_PX);
    let least = scene.settings.min_length_px;
    if used < least {
        return vec![Err(scene.left_out(
            segment,
            Reason::ShortEdge,
            used.max(0.0),
            least,
        ))];
    }
    let piece = PIECE_PX.max(PIECE_SHARE * scene.photo.width as f64);
    let pieces = (used / piece).ceil().max(1.0);
    (0..pieces as usize)
        .map(|k| {
            let length = used / pieces;
            let middle = -used / 2.0 + (k as f64 + 0.5) * length;
            let part = Segment {
                mid: segment.point(middle),
                ..*segment
            };
            strip(scene, segments, reaches, index, part, length / 2.0)
        })
        .collect()
}

/// Returns the strip of a piece of segment `index`, as wide as the border and other edges leave it.
fn strip(
    scene: &Scene,
    segments: &[Segment],
    reaches: &[f64],
    index: usize,
    part: Segment,
    half_length: f64,
) -> Result<Strip, LeftOut> {
    let (least, most) = (
        reaches[index] + LEAST_LEVEL_PX,
        reaches[index] + MOST_LEVEL_PX,
    );
    let mut extent = [most; 2];
    for (other, segment) in segments.iter().enumerate() {
        let far = half_length + segment.length / 2.0 + most + reaches[other];
        let (dx, dy) = (segment.mid[0] - part.mid[0], segment.mid[1] - part.mid[1]);
        if other == index || dx.hypot(dy) > far {
            continue;
        }
        let count = (segment.length / STEP_PX).ceil().max(1.0);
        for k in 0..=count as usize {
            let along = (k as f64 / count - 0.5) * segment.length;
            let [x, y] = segment.point(along);
            let [s, t] = part.coordinates(x, y);
            if s.abs() < half_length {
                let side = &mut extent[usize::from(t > 0.0)];
                *side = side.min(t.abs() - reaches[other]);
            }
        }
    }
    let narrow = extent[0].min(extent[1]);
    if narrow < least {
        return Err(scene.left_out(&part, Reason::Double, narrow.max(0.0), least));
    }
    let mut strip = Strip {
        segment: part,
        half_length,
        extent,
    };
    // The border may cut the levels, not the blur.
    let outside = |strip: &Strip| {
        let [left, top, right, bottom] = strip.bounds();
        let (width, height) = (scene.photo.width as f64, scene.photo.height as f64);
        (-left).max(-top).max(right - width).max(bottom - height)
    };
    if outside(&strip) > 0.0 {
        strip.extent = [least; 2];
    }
    if outside(&strip) > 0.0 {
        let [left, top, right, bottom] = strip.bounds();
        let (width, height) = (scene.photo.width as f64, scene.photo.height as f64);
        let distance = left.min(top).min(width - right).min(height - bottom);
        return Err(scene.left_out(&part, Reason::Border, distance, 0.0));
    }
    Ok(strip)
}
