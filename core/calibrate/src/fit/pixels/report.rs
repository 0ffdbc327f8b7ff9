//! A finished pixel fit: the lens, and how the fit went.

use super::errors::{Correlation, Errors, Unclear};
use super::job::{Fitted, Job};
use super::law::Remainder;
use super::layout::Quantity;
use super::metric::Metric;
use super::{Extension, displacement, score};
use crate::fit::{AxisChoice, PupilSettings};
use crate::measure::{MeasuredTile, Rejection};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Result;
use seidel_optics::field::ImagePoint;
use seidel_optics::lens::VergenceSeries;
use seidel_optics::profile::{
    LensDescription, LensProfile, Provenance, PupilChannel, RadialDisplacement,
};

/// A fitted lens and how the fit went.
#[derive(Debug, Clone)]
pub struct PupilFit {
    /// The lens, with what it scored on the PSFs kept aside.
    pub lens: LensProfile,
    /// One report a channel and distance, in the order of channels, from infinity inwards.
    pub channels: Vec<ChannelReport>,
    /// Tiles that took no part, and why.
    pub rejected: Vec<Rejection>,
    /// Where the optical axis was found, and its standard errors in px, where it was free.
    pub axis: Option<(ImagePoint, (f64, f64))>,
    /// Whether pixels counted alike or by what a picture shows.
    pub metric: Metric,
    /// Pairs of numbers that trade off against each other, strongest first.
    pub correlations: Vec<Correlation>,
    /// Combinations of numbers that the data hardly fix.
    pub unclear: Vec<Unclear>,
    /// Whether the last descent came to rest.
    pub converged: bool,
    /// What a user should know about the result.
    pub remarks: Vec<String>,
}

/// The tiles of one channel at one distance.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelReport {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Tiles that took part.
    pub used: usize,
    /// Tiles kept aside.
    pub aside: usize,
    /// alpha, beta, gamma, delta and phi there, px and half frame widths.
    pub numbers: [f64; 5],
    /// Standard deviation of the symmetric blur, px.
    pub blur_px: f64,
}

pub(super) fn assemble(
    job: &Job,
    fit: Fitted,
    errors: &Errors,
    remainders: &[Remainder],
    rejected: Vec<Rejection>,
) -> Result<PupilFit> {
    let first = &job.sets[0];
    let channels: Vec<PupilChannel> = job
        .channel_names()
        .iter()
        .enumerate()
        .map(|(index, name)| {
            let mut channel = fit
                .layout
                .channel(&fit.theta, &errors.covariance, index, name);
            add_remainders(&mut channel, index, remainders);
            channel.measured_vergence = job.range;
            channel.wavelength_px = first.wavelength_px(name).unwrap_or(0.0);
            [channel.magnification, channel.distortion] = landing(job, index);
            channel
        })
        .collect();
    let mut lens = LensProfile {
        frame: job.frame,
        pixel_pitch_um: first.pixel_pitch_um,
        camera: first.camera.clone(),
        description: LensDescription::Pupil(channels),
        held_out: None,
        provenance: Provenance {
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
            sources: Vec::new(),
            settings: job.settings.describe(),
        },
    };
    lens.held_out = score::held_out(job, &lens)?;
    let axis = (job.settings.axis == AxisChoice::Free).then(|| {
        let count = fit.theta.len();
        let unit = job.frame.half_width_px();
        let sigma = |k: usize| errors.covariance[(k, k)].max(0.0).sqrt() * unit;
        (job.frame.axis(), (sigma(count - 2), sigma(count - 1)))
    });
    let mut remarks = Vec::new();
    if !fit.converged {
        remarks.push("the fit was still improving when it was stopped".to_owned());
    }
    if lens.held_out.is_none() && !job.settings.use_all {
        remarks
            .push("too few PSFs to keep any aside: nothing says how good the lens is".to_owned());
    }
    for unclear in &errors.unclear {
        remarks.push(format!(
            "these data hardly tell apart {}: together they are {:.0} times less well fixed than each would be alone",
            unclear.names.join(", "),
            unclear.times
        ));
    }
    Ok(PupilFit {
        channels: reports(job, &lens),
        lens,
        rejected,
        axis,
        metric: fit.metric,
        correlations: errors.correlations.clone(),
        unclear: errors.unclear.clone(),
        converged: fit.converged,
        remarks,
    })
}

/// Puts what the law leaves into the channel's series.
fn add_remainders(channel: &mut PupilChannel, index: usize, remainders: &[Remainder]) {
    for r in remainders.iter().filter(|r| r.channel == index) {
        let series = match r.quantity {
            Quantity::Alpha => &mut channel.alpha,
            Quantity::Beta => &mut channel.beta,
            Quantity::Gamma => &mut channel.gamma,
            Quantity::Delta => &mut channel.delta,
            Quantity::Phi => &mut channel.phi,
            Quantity::Blur => &mut channel.blur_variance_px2,
            Quantity::Effect(which, k) => &mut channel.effects[which].values[k],
        };
        series.remainders.push((r.vergence, r.value));
    }
}

/// Magnification and distortion of a channel as lines in vergence.
fn landing(job: &Job, channel: usize) -> [VergenceSeries; 2] {
    let points: Vec<_> = job
        .vergences
        .iter()
        .filter_map(|&v| {
            let tiles: Vec<&MeasuredTile> = job
                .measured
                .iter()
                .zip(&job.aside)
                .filter(|(m, aside)| !**aside && m.channel == channel)
                .filter(|(m, _)| m.distance.vergence_per_m().unwrap_or(0.0) == v)
                .map(|(m, _)| m)
                .collect();
            let found = displacement::fit_displacement(&job.frame, &tiles)?;
            Some((v, found))
        })
        .collect();
    let mut lines = RadialDisplacement::fit_lines(&points);
    if points.len() > 2 && !job.settings.law_only {
        // What real lenses leave of a line, which is at most a pixel or two, is kept.
        let [magnification, distortion] = &lines;
        let left = points.iter().map(|(v, found)| {
            let of_magnification = found.magnification - magnification.at(*v);
            (*v, of_magnification, found.distortion - distortion.at(*v))
        });
        for (v, of_magnification, of_distortion) in left.collect::<Vec<_>>() {
            lines[0].remainders.push((v, of_magnification));
            lines[1].remainders.push((v, of_distortion));
        }
        for line in &mut lines {
            line.remainders.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
    }
    lines
}

fn reports(job: &Job, lens: &LensProfile) -> Vec<ChannelReport> {
    let mut reports = Vec::new();
    for (index, channel) in lens.pupil_channels().iter().enumerate() {
        let mut distances: Vec<ObjectDistance> = Vec::new();
        for tile in job.measured {
            if !distances.contains(&tile.distance) {
                distances.push(tile.distance);
            }
        }
        let vergence = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(0.0);
        distances.sort_by(|a, b| vergence(a).total_cmp(&vergence(b)));
        for distance in distances {
            let v = vergence(&distance);
            let count = |wanted: bool| {
                let pairs = job.measured.iter().zip(&job.aside);
                pairs
                    .filter(|(m, aside)| {
                        m.channel == index && m.distance == distance && **aside == wanted
                    })
                    .count()
            };
            let n = channel.numbers(v);
            reports.push(ChannelReport {
                channel: channel.name.clone(),
                distance,
                used: count(false),
                aside: count(true),
                numbers: [n.alpha, n.beta, n.gamma, n.delta, n.phi],
                blur_px: channel.blur_variance_px2.at(v).max(0.0).sqrt(),
            });
        }
    }
    reports
}

impl PupilSettings {
    fn describe(&self) -> String {
        let model = match self.extension {
            Extension::Never => "reduced",
            Extension::WhereNeeded => "extended where needed",
            Extension::Always => "extended",
        };
        let axis = match self.axis {
            AxisChoice::AsObserved => "axis as observed".to_owned(),
            AxisChoice::At(p) => format!("axis at ({}, {})", p.x_px, p.y_px),
            AxisChoice::Free => "axis free".to_owned(),
        };
        let support = match self.support {
            super::Support::Auto => "pixels above the noise",
            super::Support::AllPixels => "all pixels",
        };
        let mut words = format!("{model}, {axis}, {support}");
        if self.law_only {
            words.push_str(", law only");
        }
        if self.use_all {
            words.push_str(", none kept aside");
        }
        words
    }
}
