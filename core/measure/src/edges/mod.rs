//! Straight edges of photographs: the steps from raw pixels to profiles.
//!
//! 1. Segments are found in a smoothed image of all channels (`segments`); it decides where edges are, nothing else.
//! 2. A step along a line is fitted to the raw pixels of the reference channel, which gives the width of the blur. It says how
//!    far corners and other edges must be away (`strips`).
//! 3. The line is fitted again in every channel (`line_fit`); residuals beside the edges give the noise (`noise`).
//! 4. Pixels are binned by their distance from the line, and a fit of the profile gives its moments (`profile`).

mod damped_steps;
mod line_fit;
mod noise;
mod profile;
mod segments;
mod sharpening;
mod strips;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use seidel_optics::camera::Camera;
use seidel_optics::edges::{Edge, EdgeSet};
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;

use crate::calibration::{Calibration, check_alike};
use crate::checks::two_lenses::{self, Width};
use crate::checks::{Concern, Severity, noise_correlation};
use crate::photograph::{Photograph, SampleErrors};
use crate::rejection::{LeftOut, Reason};
use line_fit::{EdgePixel, LineFit};
use noise::{Plateau, Side};
use profile::{EdgeNoise, Profile};
use segments::{DetectionImage, Segment};
use seidel_optics::numeric::{quantile, scatter};
use strips::Strip;

/// Settings of [`measure_edges`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeSettings {
    /// Step over the noise of a pixel that an edge needs.
    pub min_contrast: f64,
    /// Length between the corners that an edge needs, px.
    pub min_length_px: f64,
}

impl Default for EdgeSettings {
    fn default() -> Self {
        Self {
            min_contrast: 10.0,
            min_length_px: 8.0,
        }
    }
}

/// The edges of one or more photographs.
#[derive(Debug, Clone)]
pub struct MeasuredEdges {
    /// The photographs, after dark and flat frames.
    pub photographs: Vec<Photograph>,
    /// Edges that were kept, by photograph, edge and channel.
    pub set: EdgeSet,
    /// Edges that were left out.
    pub left_out: Vec<LeftOut>,
    /// Counts per electron: stated by a file, or else from the noise beside the edges; `None` if neither says.
    pub gain: Option<f64>,
    /// Faults of the photographs.
    pub concerns: Vec<Concern>,
    /// Limits of the result.
    pub warnings: Vec<String>,
}

/// Standard deviation of the first smoothing for the detection, px: it removes the pattern of a mosaic.
const FIRST_SMOOTHING_PX: f64 = 1.4;
/// Smoothing over the width of the edges. Wider edges need more, as their gradients are low.
const SMOOTHING_OVER_WIDTH: f64 = 0.5;
/// Share of the brightness of a channel that is its white, for the detection.
const WHITE_QUANTILE: f64 = 0.9;
/// Samples from which it is taken.
const QUANTILE_SAMPLES: usize = 200_000;
/// Least gradient of an edge over white, per px: below it is shading.
const LEAST_GRADIENT: f64 = 5e-4;
/// Share of clipped pixels beside an edge that are taken for defects.
const MAX_CLIPPED: f64 = 0.01;
/// Largest turn of the normal along an edge, rad.
const MAX_TURN: f64 = 0.12;
/// Overshoot over the step, and over its noise, from which on a photograph is sharpened.
const MAX_OVERSHOOT: f64 = 0.03;
const OVERSHOOT_SIGMAS: f64 = 5.0;
/// Share of sharpened edges from which on none of the photograph is kept.
const MAX_SHARPENED: f64 = 0.25;
/// Least standard deviation of the blur with the pixel's area, px, and largest gap between sampled distances over it.
const LEAST_SIGMA_PX: f64 = 0.45;
const MAX_GAP: f64 = 1.0;
/// Errors of the variance and of the third moment by the truncated series of the profile and by light from corners, over the
/// variance and its power 3/2: for a symmetric blur, and what a skewness of one adds. Estimated from two simulated charts, where
/// noise left so much unexplained.
const MODEL_ERROR: [f64; 2] = [0.04, 0.08];
const SKEW_ERROR: [f64; 2] = [0.05, 0.2];
/// Misfit of a profile: chi squared per degree of freedom and scatter over the step, of which both must be exceeded.
const MAX_CHI2: f64 = 12.0;
const MAX_MISFIT: f64 = 0.02;

/// Measures the straight edges of `photographs`, of one camera.
///
/// # Errors
/// Photographs that differ in size or mosaic; no edge found; no edge kept, with the counts of the reasons.
pub fn measure_edges(
    mut photographs: Vec<Photograph>,
    calibration: &Calibration,
    settings: &EdgeSettings,
) -> Result<MeasuredEdges> {
    let Some(first) = photographs.first() else {
        return Err(Error::new("photographs", "none given", "give at least one"));
    };
    for photo in &photographs {
        photo.check()?;
        check_alike(first, photo)?;
    }
    let size = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
    let frame = Frame::new(size(first.width), size(first.height), None)?;
    let channels = first.channels.clone();
    for photo in &mut photographs {
        calibration.apply(photo)?;
    }
    let (mut edges, mut left_out, mut gain) = (Vec::new(), Vec::new(), None);
    let mut concerns = Vec::new();
    for (index, photo) in photographs.iter_mut().enumerate() {
        let scene = Scene {
            index,
            photo,
            settings,
        };
        let found = scene.measure()?;
        photo.errors.variance_px2 = found.variance_error_px2;
        concerns.extend(found.concern);
        edges.extend(found.edges);
        left_out.extend(found.left_out);
        gain = gain.or(found.gain);
    }
    left_out.sort_by(|a, b| {
        (a.photograph, a.why)
            .cmp(&(b.photograph, b.why))
            .then(a.y.total_cmp(&b.y))
            .then(a.x.total_cmp(&b.x))
    });
    if edges.is_empty() {
        return Err(none_kept(&left_out));
    }
    let mut measured = MeasuredEdges {
        set: EdgeSet {
            frame,
            channels,
            pixel_pitch_um: None,
            camera: Camera::default(),
            edges,
        },
        photographs,
        left_out,
        gain,
        concerns,
        warnings: Vec::new(),
    };
    measured.concerns.extend(measured.two_lenses());
    measured.add_warnings();
    Ok(measured)
}

/// One photograph.
struct Scene<'a> {
    index: usize,
    photo: &'a Photograph,
    settings: &'a EdgeSettings,
}

/// The edges of one photograph.
struct Found {
    edges: Vec<Edge>,
    left_out: Vec<LeftOut>,
    gain: Option<f64>,
    /// Processing of the photograph that its noise shows.
    concern: Option<Concern>,
    /// Error of the variance of its edges, px².
    variance_error_px2: f64,
}

/// An edge in one channel before its noise is known.
struct FittedLine {
    strip: usize,
    channel: usize,
    pixels: Vec<EdgePixel>,
    line: LineFit,
}

impl Scene<'_> {
    fn measure(&self) -> Result<Found> {
        let segments = self.segments();
        let mut left_out = Vec::new();
        let strips = strips::of(self, &segments, &mut left_out);
        let channels = 0..self.photo.channels.len();
        let reference = self.photo.reference_channel();
        let pairs: Vec<(usize, usize)> = (0..strips.len())
            .flat_map(|strip| channels.clone().map(move |channel| (strip, channel)))
            .collect();
        let fits: Vec<std::result::Result<FittedLine, LeftOut>> = pairs
            .into_par_iter()
            .map(|(strip, channel)| self.fit_line(&strips[strip], strip, channel))
            .collect();
        let channel_count = self.photo.channels.len();
        let mut lines = Vec::new();
        for (k, fit) in fits.into_iter().enumerate() {
            match fit {
                Ok(line) => lines.push(line),
                Err(why) if k % channel_count == reference => left_out.push(why),
                // The other channels of an edge may still do.
                Err(_) => {}
            }
        }
        let plateaus = self.plateaus(&lines);
        let noises = noise::estimate(self.photo, &plateaus);
        let correlations = channels.filter_map(|channel| noise::correlation(&plateaus, channel));
        let concern = noise_correlation::judge(self.photo, correlations);
        let mut error_px2 = self.photo.errors.variance_px2;
        if let Some(Severity::Widen(_)) = concern.as_ref().map(|c| c.severity) {
            error_px2 = error_px2.max(SampleErrors::DEVELOPED.variance_px2);
        }
        let results: Vec<_> = lines
            .par_iter()
            .map(|line| {
                let noise = noises.of(line.channel);
                self.edge(&strips[line.strip], line, noise, error_px2)
            })
            .collect();
        let mut edges = Vec::new();
        for (line, result) in lines.iter().zip(results) {
            match result {
                Ok(edge) => edges.push(edge),
                Err(why) if line.channel == reference => left_out.push(why),
                Err(_) => {}
            }
        }
        let sharpened = left_out.iter().filter(|l| l.why == Reason::Sharpened);
        let (sharpened, kept) = (
            sharpened.count(),
            edges.iter().filter(|e| e.channel == reference).count(),
        );
        if sharpened as f64 > MAX_SHARPENED * (sharpened + kept) as f64 {
            return Err(Error::new(
                format!("photograph {}", self.photo.name),
                format!(
                    "is sharpened: the levels overshoot beside {sharpened} of {} edges",
                    sharpened + kept
                ),
                "photograph raw, or develop without sharpening",
            )
            .with_kind(ErrorKind::InsufficientData));
        }
        let profiles = edges.iter().filter(|e| e.channel == reference);
        let mean = sharpening::overshoot(profiles.map(|e| e.profile.as_slice()));
        let mut steps: Vec<f64> = (lines.iter())
            .filter(|line| line.channel == reference)
            .map(|line| line.line.step.abs())
            .collect();
        let quantum = self.photo.errors.quantum / quantile(&mut steps, 0.5).max(1e-9);
        if let Some(mean) = mean.filter(|mean| mean.is_sharpened(quantum)) {
            return Err(Error::new(
                format!("photograph {}", self.photo.name),
                format!(
                    "is sharpened: the levels overshoot by {:.2} % of the step in the mean of {kept} edges, with an error of {:.2} %",
                    100.0 * mean.mean,
                    100.0 * mean.sigma
                ),
                "photograph raw, or develop without sharpening",
            )
            .with_kind(ErrorKind::InsufficientData));
        }
        Ok(Found {
            edges,
            left_out,
            gain: noises.gain,
            concern,
            variance_error_px2: error_px2,
        })
    }

    /// Returns the levels beside the edges with the variance of their pixels.
    fn plateaus(&self, lines: &[FittedLine]) -> Vec<Plateau> {
        let pitch = if self.photo.mosaic.is_some() {
            2.0
        } else {
            1.0
        };
        let of = |fitted: &FittedLine, side| {
            noise::plateau(fitted.channel, &fitted.pixels, &fitted.line, side, pitch)
        };
        let both = lines
            .iter()
            .flat_map(|fitted| Side::BOTH.map(|side| of(fitted, side)));
        both.flatten().collect()
    }

    /// Returns the segments of the photograph, from a smoothing that suits their width.
    fn segments(&self) -> Vec<Segment> {
        let light = self.equalised();
        let mut smoothing = FIRST_SMOOTHING_PX;
        loop {
            let noise = light.noise / ((8.0 * std::f64::consts::PI).sqrt() * smoothing.powi(2));
            let image = DetectionImage {
                width: self.photo.width,
                height: self.photo.height,
                samples: segments::smooth(&light.samples, self.photo.width, smoothing),
                smoothing,
                noise: noise.max(LEAST_GRADIENT / 8.0) as f32,
            };
            let found = segments::find(&image);
            let mut widths: Vec<f64> = found.iter().map(|s| s.sigma).collect();
            let wanted = SMOOTHING_OVER_WIDTH * quantile(&mut widths, 0.5);
            if wanted < 1.5 * smoothing {
                return found;
            }
            smoothing = wanted;
        }
    }

    /// Returns all channels relative to their white, pixel by pixel.
    fn equalised(&self) -> Equalised {
        let photo = self.photo;
        let (width, pixels) = (photo.width, photo.width * photo.height);
        let (mut whites, mut noise) = (Vec::new(), 0.0_f64);
        for channel in 0..photo.channels.len() {
            let plane = &photo.planes[photo.plane_of(channel)];
            let stride = (pixels / QUANTILE_SAMPLES).max(1) | 1;
            let covered: Vec<usize> = (0..pixels)
                .step_by(stride)
                .filter(|k| photo.covers(channel, k % width, k / width) && k % width + 2 < width)
                .collect();
            let mut values: Vec<f64> = covered.iter().map(|k| f64::from(plane[*k])).collect();
            let white = quantile(&mut values, WHITE_QUANTILE).max(1e-6);
            // Pixels two columns apart have the same colour.
            let differences: Vec<f64> = (covered.iter())
                .map(|k| f64::from(plane[*k] - plane[k + 2]))
                .collect();
            // Without other noise, the steps of the codes are not edges.
            let rounding = photo.errors.quantum / 12_f64.sqrt();
            let own = (scatter(&differences) / std::f64::consts::SQRT_2).max(rounding);
            noise = noise.max(own / white);
            whites.push(white as f32);
        }
        let mut samples = vec![0.0_f32; pixels];
        let planes = photo.planes.len();
        for plane in 0..planes {
            let pattern = photo.channel_pattern(plane);
            for (k, sample) in samples.iter_mut().enumerate() {
                let (x, y) = (k % width, k / width);
                // The colours that are not measured take the place of their left neighbour's.
                let channel = pattern[2 * (y % 2) + x % 2];
                if let Some(channel) = channel {
                    *sample += photo.planes[plane][k] / whites[channel] / planes as f32;
                } else if x > 0 && pattern[2 * (y % 2) + (x + 1) % 2].is_some() {
                    let channel = pattern[2 * (y % 2) + (x + 1) % 2].unwrap_or(0);
                    *sample += photo.planes[plane][k - 1] / whites[channel] / planes as f32;
                }
            }
        }
        Equalised { samples, noise }
    }

    /// Returns the usable pixels of `channel` in `strip`, and the number of clipped ones.
    fn pixels(&self, strip: &Strip, channel: usize) -> (Vec<EdgePixel>, usize) {
        let photo = self.photo;
        let plane = &photo.planes[photo.plane_of(channel)];
        let [left, top, right, bottom] = strip.bounds();
        let (mut pixels, mut clipped) = (Vec::new(), 0);
        let whole = |v: f64, most: usize| v.max(0.0).min(most as f64) as usize;
        for y in whole(top, photo.height)..whole(bottom + 1.0, photo.height) {
            for x in whole(left, photo.width)..whole(right + 1.0, photo.width) {
                let [s, t] = strip.segment.coordinates(x as f64 + 0.5, y as f64 + 0.5);
                if !strip.holds(s, t) || !photo.covers(channel, x, y) || photo.is_bad(x, y) {
                    continue;
                }
                let value = plane[y * photo.width + x];
                if value >= photo.white {
                    clipped += 1;
                } else {
                    let value = f64::from(value);
                    pixels.push(EdgePixel { s, t, value });
                }
            }
        }
        (pixels, clipped)
    }

    fn fit_line(
        &self,
        strip: &Strip,
        index: usize,
        channel: usize,
    ) -> std::result::Result<FittedLine, LeftOut> {
        let out = |why, value, limit| self.left_out(&strip.segment, why, value, limit);
        let (mut pixels, clipped) = self.pixels(strip, channel);
        let share = clipped as f64 / (pixels.len() + clipped).max(1) as f64;
        if share > MAX_CLIPPED {
            let white = f64::from(self.photo.white);
            return Err(out(Reason::Clipped, white, white));
        }
        let Some(line) = line_fit::fit(&mut pixels, strip.segment.sigma) else {
            return Err(out(Reason::NotAnEdge, 1.0, MAX_MISFIT));
        };
        let contrast = line.step / line.scatter.max(self.photo.errors.quantum / 12_f64.sqrt());
        if contrast < self.settings.min_contrast {
            let limit = self.settings.min_contrast;
            return Err(out(Reason::LowContrast, contrast, limit));
        }
        let turn = 4.0 * line.line[2].abs() * strip.half_length;
        if turn > MAX_TURN {
            return Err(out(Reason::CurvedEdge, turn, MAX_TURN));
        }
        Ok(FittedLine {
            strip: index,
            channel,
            pixels,
            line,
        })
    }

    fn edge(
        &self,
        strip: &Strip,
        fitted: &FittedLine,
        noise: EdgeNoise,
        error_px2: f64,
    ) -> std::result::Result<Edge, LeftOut> {
        let out = |why, value, limit| self.left_out(&strip.segment, why, value, limit);
        let line = &fitted.line;
        let bins = profile::bins(&fitted.pixels, line, noise);
        let found = profile::fit(bins, line.sigma, line.dark / line.step);
        let Some(Profile {
            bins,
            centroid,
            variance,
            third,
            chi2,
            overshoot,
            gap_px,
        }) = found
        else {
            return Err(out(Reason::NotAnEdge, 1.0, MAX_MISFIT));
        };
        let width = (variance[0] + PIXEL_VARIANCE_PX2).sqrt();
        let limit = MAX_OVERSHOOT.max(OVERSHOOT_SIGMAS * overshoot[1]);
        if overshoot[0] > limit {
            return Err(out(Reason::Sharpened, overshoot[0], limit));
        }
        if width < LEAST_SIGMA_PX || gap_px > MAX_GAP * width.max(0.5) {
            return Err(out(Reason::Undersampled, width, LEAST_SIGMA_PX));
        }
        let misfit = line.scatter / line.step;
        if chi2 > MAX_CHI2 && misfit > MAX_MISFIT {
            return Err(out(Reason::NotAnEdge, misfit, MAX_MISFIT));
        }
        let (normal, mid) = strip.place(line, centroid);
        let skewness = (third[0] / width.powi(3)).abs().min(1.0);
        let model_error = [0, 1].map(|k| MODEL_ERROR[k] + SKEW_ERROR[k] * skewness);
        Ok(Edge {
            source: self.photo.name.clone(),
            index: fitted.strip,
            channel: fitted.channel,
            distance: self.photo.distance,
            mid: ImagePoint::new(mid[0], mid[1]),
            normal,
            length_px: 2.0 * strip.half_length,
            levels: [line.dark, line.dark + line.step],
            variance_px2: variance[0],
            variance_sigma: variance[1]
                .hypot(model_error[0] * width.powi(2))
                .hypot(error_px2),
            third_px3: third[0],
            third_sigma: third[1]
                .hypot(model_error[1] * width.powi(3))
                .hypot(error_px2 * width),
            profile: bins,
        })
    }

    fn left_out(&self, segment: &Segment, why: Reason, value: f64, limit: f64) -> LeftOut {
        LeftOut {
            number: None,
            photograph: self.index,
            x: segment.mid[0],
            y: segment.mid[1],
            why,
            value,
            limit,
        }
    }
}

/// Light of all channels for the detection.
struct Equalised {
    samples: Vec<f32>,
    /// Standard deviation of the noise of a pixel.
    noise: f64,
}

fn none_kept(left_out: &[LeftOut]) -> Error {
    let counts: Vec<(Reason, usize)> = (Reason::ALL.iter())
        .map(|why| (*why, left_out.iter().filter(|l| l.why == *why).count()))
        .filter(|(_, count)| *count > 0)
        .collect();
    let most = counts.iter().max_by_key(|(_, count)| *count);
    let remedy = match most.map(|(why, _)| why) {
        Some(Reason::Clipped) => "expose less, so that the bright side is below the clipping level",
        Some(Reason::LowContrast) => "light the chart better, or print it blacker",
        Some(Reason::ShortEdge | Reason::Double) => "print a chart of larger squares",
        Some(Reason::Undersampled) => {
            "turn the chart by 5 to 15 degrees; blur below half a pixel cannot be measured"
        }
        _ => "photograph a chart of dark squares or a checkerboard, turned by 5 to 15 degrees",
    };
    let problem = if counts.is_empty() {
        "none found".to_owned()
    } else {
        let each: Vec<String> = counts.iter().map(|(why, n)| format!("{n} {why}")).collect();
        format!("none could be kept ({})", each.join(", "))
    };
    Error::new("edges", problem, remedy).with_kind(ErrorKind::InsufficientData)
}

impl MeasuredEdges {
    /// Returns the concerns about photographs at one distance whose edges differ in width.
    fn two_lenses(&self) -> Vec<Concern> {
        let reference = self.photographs[0].reference_channel();
        let of = |photo: &Photograph| {
            let edges = self.set.edges.iter();
            let own = edges.filter(|e| e.source == photo.name && e.channel == reference);
            own.map(|e| Width {
                at: [e.mid.x_px, e.mid.y_px],
                normal: e.normal,
                variance_px2: e.variance_px2 + PIXEL_VARIANCE_PX2,
            })
            .collect()
        };
        let widths: Vec<Vec<Width>> = self.photographs.iter().map(of).collect();
        two_lenses::check_all(&self.photographs, &widths, "edges")
    }

    fn add_warnings(&mut self) {
        let reference = self.photographs[0].reference_channel();
        let of_reference = self.set.edges.iter().filter(|e| e.channel == reference);
        // Twice the angle of the normal, so that opposite edges count as one orientation.
        let turns = of_reference.map(|e| 2.0 * e.normal[1].atan2(e.normal[0]));
        let (mut sums, mut count) = ([0.0; 4], 0.0);
        for turn in turns {
            let (sin, cos) = turn.sin_cos();
            sums[0] += cos;
            sums[1] += sin;
            sums[2] += cos * cos;
            sums[3] += sin * sin;
            count += 1.0;
        }
        let clipped = self.left_out.iter().filter(|l| l.why == Reason::Clipped);
        let clipped = clipped.count() as f64;
        if clipped > NOTABLE_CLIPPED * (clipped + count) {
            self.warnings.push(format!(
                "{clipped} of {} edges clip: part of the frame is overexposed, and the lens is extrapolated there. Expose less.",
                clipped + count
            ));
        }
        let mean = (sums[0] * sums[0] + sums[1] * sums[1]).sqrt() / f64::max(count, 1.0);
        if mean > ONE_ORIENTATION {
            self.warnings.push(
                "nearly all edges have one orientation: they do not determine the blur along the edges. Photograph edges of two orientations or more."
                    .to_owned(),
            );
        }
    }
}

/// Share of clipped edges from which on they are remarked on.
const NOTABLE_CLIPPED: f64 = 0.2;
/// Length of the mean of the doubled normals above which there is only one orientation.
const ONE_ORIENTATION: f64 = 0.9;
