//! The place of a chart in a photograph: candidates by finder marks or by texture, tried in all eight positions.

use seidel_optics::error::{Error, ErrorKind, Result};

use super::ChartSettings;
use super::alignment::{Aligned, align_homography, align_polynomial, align_roughly};
use super::coarse::{Coarse, Plane};
use super::map::ChartMap;
use super::marks::{Mark, find_marks};
use super::picture::ChartPicture;
use super::quadrilateral::{TexturedRegion, textured_regions};
use crate::photograph::Photograph;

/// Correlation from which on a chart is recognised.
const MIN_CORRELATION: f64 = 0.25;
/// Excess over the correlation of the next best position that decides between them. Marks and borders correlate in all.
const MIN_EXCESS: f64 = 0.1;
/// Share of clipped pixels from which on a photograph cannot be measured.
const MAX_CLIPPED: f64 = 0.3;
/// Largest number of marks of which four are chosen.
const MAX_MARKS: usize = 12;
/// Positions that are registered at finer scales.
const FINER_POSES: usize = 2;
/// Largest side of the binned photograph that is registered, px.
const REGISTRATION_SIDE: usize = 640;
/// Largest side of the pictures that are searched for marks, px.
const MARKS_SIDE: usize = 2400;

/// Returns the map of the chart in `photo`, within a pixel or two.
///
/// # Errors
/// No chart, another chart, several charts, a mirrored or turned one, and a clipped photograph.
pub(crate) fn find(
    photo: &Photograph,
    chart: &ChartPicture,
    settings: &ChartSettings,
) -> Result<Aligned> {
    let coarse = Coarse::of(photo, photo.reference_channel(), REGISTRATION_SIDE);
    if coarse.clipped > MAX_CLIPPED {
        return Err(refusal(
            photo,
            format!(
                "is clipped in {:.0} % of its pixels",
                100.0 * coarse.clipped
            ),
            "expose less: the white of the chart at half to two thirds of clipping",
        ));
    }
    let size = [photo.width, photo.height];
    let [width, height] = chart.size().map(|v| v as f64);
    let of_chart = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    if settings.same_view {
        let map = ChartMap::of_corners(of_chart, of_chart, size)?;
        let mut aligned = align_roughly(&coarse, chart, map);
        if aligned.correlation < MIN_CORRELATION {
            return Err(other_scene(photo, aligned.correlation));
        }
        align_polynomial(&coarse, chart, &mut aligned);
        return Ok(aligned);
    }
    if let Some(corners) = settings.corners {
        let map = ChartMap::of_corners(corners, of_chart, size)?;
        let mut aligned = align_roughly(&coarse, chart, map);
        align_homography(&coarse, chart, &mut aligned);
        if aligned.correlation < MIN_CORRELATION {
            return Err(not_at_corners(photo, aligned.correlation));
        }
        align_polynomial(&coarse, chart, &mut aligned);
        return Ok(aligned);
    }
    let (candidates, found) = candidates(photo, chart, &coarse, of_chart)?;
    let mut best: Vec<(Pose, Aligned)> = Vec::new();
    for (photo_corners, chart_corners) in candidates {
        for pose in Pose::ALL {
            let corners = pose.order(photo_corners);
            let Ok(map) = ChartMap::of_corners(corners, chart_corners, size) else {
                continue;
            };
            best.push((pose, align_roughly(&coarse, chart, map)));
        }
    }
    let order = |best: &mut Vec<(Pose, Aligned)>| {
        best.sort_by(|a, b| b.1.correlation.total_cmp(&a.1.correlation));
    };
    order(&mut best);
    best.truncate(FINER_POSES);
    for (_, aligned) in &mut best {
        align_homography(&coarse, chart, aligned);
    }
    order(&mut best);
    let Some((pose, aligned)) = best.first() else {
        return Err(no_chart(photo));
    };
    let next = best.get(1).map_or(0.0, |b| b.1.correlation.max(0.0));
    if aligned.correlation < MIN_CORRELATION || aligned.correlation < next + MIN_EXCESS {
        return Err(refusal(
            photo,
            format!(
                "shows another picture than the chart: they correlate by {:.2} at best",
                aligned.correlation
            ),
            "give the picture that was printed, or the four corners of the chart",
        ));
    }
    if found > 1 {
        return Err(refusal(
            photo,
            format!("shows {found} charts"),
            "cover the others, or give the four corners of one",
        ));
    }
    pose.check(photo, aligned, of_chart)?;
    let mut aligned = aligned.clone();
    align_polynomial(&coarse, chart, &mut aligned);
    Ok(aligned)
}

/// Corners in the photograph and in the chart.
type Candidate = ([[f64; 2]; 4], [[f64; 2]; 4]);

/// Returns quadrilaterals that may be the chart, and the number of charts seen.
fn candidates(
    photo: &Photograph,
    chart: &ChartPicture,
    coarse: &Coarse,
    of_chart: [[f64; 2]; 4],
) -> Result<(Vec<Candidate>, usize)> {
    if let Some(marks) = marks_of_chart(chart) {
        let fine = Coarse::of(photo, photo.reference_channel(), MARKS_SIDE);
        let mut seen = find_marks(&fine.plane);
        seen.truncate(MAX_MARKS);
        if let Some(four) = four_alike(&seen) {
            let at = |m: &Mark| [0, 1].map(|k| fine.grid.origin[k] + m.centre[k] * fine.grid.step);
            let corners = ordered(four.map(|m| at(&m)));
            return Ok((vec![(corners, marks)], seen.len() / 4));
        }
    }
    let regions = textured_regions(coarse);
    if regions.is_empty() {
        return Err(no_chart(photo));
    }
    let count = regions.len();
    let candidates = regions
        .iter()
        .map(|r: &TexturedRegion| (r.corners, of_chart));
    Ok((candidates.collect(), count))
}

/// Returns the centres of the four marks of the chart's picture, from the top left clockwise, if it has them.
fn marks_of_chart(chart: &ChartPicture) -> Option<[[f64; 2]; 4]> {
    let [width, height] = chart.size();
    let skip = width.max(height).div_ceil(MARKS_SIDE);
    let (columns, rows) = (width / skip, height / skip);
    let values = (0..columns * rows)
        .map(|k| f64::from(chart.samples()[k / columns * skip * width + k % columns * skip]));
    let plane = Plane {
        columns,
        rows,
        values: values.collect(),
    };
    let marks = find_marks(&plane);
    let four: [Mark; 4] = marks.get(..4)?.try_into().ok()?;
    let centres = four.map(|m| m.centre.map(|v| (v + 0.5) * skip as f64));
    Some(ordered(centres))
}

/// Returns four marks of about one size that span the largest area.
fn four_alike(marks: &[Mark]) -> Option<[Mark; 4]> {
    let mut best: Option<(f64, [Mark; 4])> = None;
    let n = marks.len();
    for a in 0..n {
        for b in a + 1..n {
            for c in b + 1..n {
                for d in c + 1..n {
                    let four = [marks[a], marks[b], marks[c], marks[d]];
                    let modules = four.map(|m| m.module);
                    let low = modules.into_iter().fold(f64::INFINITY, f64::min);
                    let high = modules.into_iter().fold(0.0, f64::max);
                    if high > 2.0 * low {
                        continue;
                    }
                    let area = area(ordered(four.map(|m| m.centre)));
                    if best.is_none_or(|(largest, _)| area > largest) {
                        best = Some((area, four));
                    }
                }
            }
        }
    }
    best.map(|(_, four)| four)
}

/// Returns the points clockwise as seen, from that nearest to the top left on.
fn ordered(mut points: [[f64; 2]; 4]) -> [[f64; 2]; 4] {
    let centre = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / 4.0);
    let angle = |p: &[f64; 2]| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let first = (0..4).min_by(|a, b| {
        let sum = |k: usize| points[k][0] + points[k][1];
        sum(*a).total_cmp(&sum(*b))
    });
    points.rotate_left(first.unwrap_or(0));
    points
}

fn area(corners: [[f64; 2]; 4]) -> f64 {
    let sum: f64 = (0..4)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
            ax * by - ay * bx
        })
        .sum();
    sum.abs() / 2.0
}

/// A position of the chart in the photograph: turned by quarters, seen from the front or from behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Pose {
    quarters: usize,
    is_mirrored: bool,
}

impl Pose {
    const ALL: [Self; 8] = {
        let mut all = [Self {
            quarters: 0,
            is_mirrored: false,
        }; 8];
        let mut k = 0;
        while k < 8 {
            all[k] = Self {
                quarters: k % 4,
                is_mirrored: k >= 4,
            };
            k += 1;
        }
        all
    };

    /// Returns the photograph corners in the order of the chart's corners.
    fn order(self, mut corners: [[f64; 2]; 4]) -> [[f64; 2]; 4] {
        if self.is_mirrored {
            corners.swap(0, 1);
            corners.swap(2, 3);
        }
        corners.rotate_left(self.quarters);
        corners
    }

    fn check(self, photo: &Photograph, aligned: &Aligned, of_chart: [[f64; 2]; 4]) -> Result<()> {
        if self.is_mirrored {
            return Err(refusal(
                photo,
                "shows the chart mirrored".to_owned(),
                "photograph the printed side, or mirror the picture of the chart",
            ));
        }
        if self.quarters == 0 {
            return Ok(());
        }
        let places: Vec<String> = (of_chart.iter())
            .filter_map(|c| aligned.map.photo_of(*c))
            .map(|[x, y]| format!("{x:.0},{y:.0}"))
            .collect();
        let how = match self.quarters {
            2 => "upside down",
            _ => "turned by a quarter",
        };
        Err(refusal(
            photo,
            format!("shows the chart {how}"),
            &format!(
                "turn the picture of the chart as the photograph shows it, or confirm its four corners: {}",
                places.join(",")
            ),
        ))
    }
}

fn refusal(photo: &Photograph, problem: String, remedy: &str) -> Error {
    Error::new(format!("photograph {}", photo.name), problem, remedy)
}

fn no_chart(photo: &Photograph) -> Error {
    refusal(
        photo,
        "shows no region of fine texture".to_owned(),
        "photograph the chart larger and in focus enough, or give its four corners",
    )
    .with_kind(ErrorKind::InsufficientData)
}

fn other_scene(photo: &Photograph, correlation: f64) -> Error {
    refusal(
        photo,
        format!(
            "shows another scene than the sharp photograph: they correlate by {correlation:.2}"
        ),
        "photograph one scene of fine texture twice from a tripod, and give the sharp photograph first",
    )
}

fn not_at_corners(photo: &Photograph, correlation: f64) -> Error {
    refusal(
        photo,
        format!("does not show the chart at the given corners: they correlate by {correlation:.2}"),
        "give the four corners from the chart's own top left clockwise, within a few pixels, and the picture that was printed",
    )
}
