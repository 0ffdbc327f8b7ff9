//! Result of a pixel fit: the profile and the report.

use super::context::{FitContext, FittedLens};
use super::covariance::{Correlation, CovarianceEstimate, PoorlyDetermined};
use super::metric::Metric;
use super::parameters::Quantity;
use super::part_log::PartTrial;
use super::registered_centroids::registered_tiles;
use super::vergence_law::Remainder;
use super::{PupilModel, score};
use crate::fit::axis::AxisEstimate;
use crate::fit::axis_and_support;
use crate::fit::coverage;
use crate::fit::displacement::DisplacementTerms;
use crate::fit::{AxisChoice, PupilSettings};
use crate::measure::{MeasuredTile, Rejection};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::Result;
use seidel_optics::lens::{VergencePoint, VergenceSeries};
use seidel_optics::profile::{
    Adequacy, HeldOut, LensDescription, LensProfile, ProfileEffect, Provenance, PupilChannel,
    Verdict,
};

/// A fitted pupil model and its report.
#[derive(Debug, Clone)]
pub struct PupilFit {
    /// The fitted lens profile, with its held-out score.
    pub lens: LensProfile,
    /// Reports per channel and distance, from infinity inwards.
    pub channels: Vec<ChannelReport>,
    /// Tiles excluded from the fit, with reasons.
    pub rejected: Vec<Rejection>,
    /// Estimated optical axis, for [`AxisChoice::Free`].
    pub axis: Option<AxisEstimate>,
    /// Weighting of the residuals in the final fit.
    pub metric: Metric,
    /// Strongly correlated pairs of parameters, strongest first.
    pub correlations: Vec<Correlation>,
    /// Poorly determined combinations of parameters.
    pub poorly_determined: Vec<PoorlyDetermined>,
    /// Whether the last minimisation converged.
    pub converged: bool,
    /// Parts of the extended model that were tried, each with its gain and its time.
    pub parts_tried: Vec<PartTrial>,
    /// Limits of the result.
    pub warnings: Vec<String>,
    /// The parameters, from which a second fit starts.
    pub(super) fitted: Box<FittedLens>,
}

/// Report on one channel at one distance.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelReport {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Number of tiles fitted.
    pub used: usize,
    /// Number of tiles held out.
    pub held_out: usize,
    /// alpha, beta, gamma, delta and phi, in px and half frame widths.
    pub numbers: [f64; 5],
    /// Standard deviation of the symmetric blur, px.
    pub blur_px: f64,
}

pub(super) fn assemble(
    context: &FitContext,
    fit: FittedLens,
    errors: &CovarianceEstimate,
    remainders: &[Remainder],
    mut rejected: Vec<Rejection>,
) -> Result<PupilFit> {
    let first = &context.sets[0];
    let registered = registered_tiles(context, &fit);
    let channels: Vec<PupilChannel> = context
        .channel_names()
        .iter()
        .enumerate()
        .map(|(index, name)| {
            let mut channel = fit
                .layout
                .channel(&fit.theta, &errors.covariance, index, name);
            add_remainders(&mut channel, index, remainders);
            let order = |carried: &ProfileEffect| effects::acting_position(carried.effect);
            channel.effects.sort_by_key(order);
            channel.measured_vergence = context.range;
            channel.wavelength_px = first.wavelength_px(name).unwrap_or(0.0);
            set_displacement(context, &registered, index, &mut channel);
            channel
        })
        .collect();
    let mut lens = LensProfile {
        frame: context.frame,
        pixel_pitch_um: first.pixel_pitch_um,
        camera: first.camera.clone(),
        description: LensDescription::Pupil(channels),
        held_out: None,
        provenance: Provenance {
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
            sources: Vec::new(),
            settings: context.settings.describe(),
            tiles: coverage::by_distance(context.measured),
        },
    };
    if let Some(score) = score::held_out(context, &lens)? {
        lens.held_out = Some(score.held_out);
        rejected.extend(score.outliers);
    }
    let wrong = (lens.adequacy()).is_some_and(|a| a.verdict() != Verdict::Describes);
    let fails_in_one_place = lens.adequacy().is_some_and(Adequacy::fails_in_one_place);
    if wrong && !fails_in_one_place {
        omit_standard_errors(&mut lens);
    }
    let axis = (context.settings.axis == AxisChoice::Free).then(|| {
        let count = fit.theta.len();
        let unit = context.frame.half_width_px();
        let sigma = |k: usize| errors.covariance[(k, k)].max(0.0).sqrt() * unit;
        AxisEstimate {
            axis: context.frame.axis(),
            sigma_px: (sigma(count - 2), sigma(count - 1)),
            converged: fit.converged,
        }
    });
    let mut warnings = Vec::new();
    warnings.extend(coverage::remarks(&context.frame, context.measured));
    warnings.extend(lens.held_out.as_ref().and_then(neighbours_remark));
    if let Some(adequacy) = lens.adequacy().filter(|_| wrong) {
        let errors = if fails_in_one_place {
            "Standard errors assume the model: do not trust them for what that place alone determines"
        } else {
            "Standard errors are not stated, since they assume the model"
        };
        warnings.push(format!("{adequacy}. {errors}"));
    }
    if !fit.converged {
        warnings
            .push("the fit did not converge within the maximum number of iterations".to_owned());
    }
    if lens.held_out.is_none() && !context.settings.use_all {
        warnings
            .push("too few PSFs to hold any out: the accuracy of the lens is unknown".to_owned());
    }
    warnings.extend(poorly_determined_remark(&errors.poorly_determined));
    Ok(PupilFit {
        channels: reports(context, &lens),
        lens,
        rejected,
        axis,
        metric: fit.metric,
        correlations: errors.correlations.clone(),
        poorly_determined: errors.poorly_determined.clone(),
        converged: fit.converged,
        parts_tried: Vec::new(),
        warnings,
        fitted: Box::new(fit),
    })
}

/// Returns one remark on all combinations of parameters that the data hardly determine; `None` for none.
fn poorly_determined_remark(combinations: &[PoorlyDetermined]) -> Option<String> {
    let largest = combinations
        .iter()
        .map(|c| c.inflation)
        .max_by(f64::total_cmp)?;
    let mut names: Vec<&str> = Vec::new();
    for name in combinations.iter().flat_map(|c| &c.names) {
        // Without its channel.
        let name = name.split(" (").next().unwrap_or(name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let count = match combinations.len() {
        1 => "one combination".to_owned(),
        count => format!("{count} combinations"),
    };
    Some(format!(
        "these data hardly determine {count} of {}: standard errors are up to {largest:.0} times those of uncorrelated parameters. The PSFs do not depend on them much",
        names.join(", ")
    ))
}

/// Gain of neighbours over the model from which on it is reported, dB.
const MIN_NEIGHBOURS_GAIN_DB: f64 = 0.5;

/// Returns a remark where the nearest fitted tiles predict held-out ones better than the model does.
fn neighbours_remark(held_out: &HeldOut) -> Option<String> {
    let neighbours = held_out.neighbours_snr_db?;
    (neighbours > held_out.snr_db + MIN_NEIGHBOURS_GAIN_DB).then(|| {
        format!(
            "the nearest PSFs of the set predict held-out ones better than the lens does: {neighbours:.1} dB against {:.1} dB",
            held_out.snr_db
        )
    })
}

/// Sets the standard errors to zero, which means unknown: they assume a model that describes the lens.
fn omit_standard_errors(lens: &mut LensProfile) {
    let LensDescription::Pupil(channels) = &mut lens.description else {
        return;
    };
    for channel in channels {
        for series in channel.series_mut() {
            series.sigma.fill(0.0);
        }
    }
}

/// Adds the residual corrections to the channel's series.
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

/// Sets magnification and distortion of a channel as lines in vergence, and the further shifts of chief rays of a decentred lens or
/// one with two planes of symmetry.
fn set_displacement(
    context: &FitContext,
    registered: &[MeasuredTile],
    index: usize,
    channel: &mut PupilChannel,
) {
    let at = |id: &str| channel.effects.iter().position(|e| e.effect.id() == id);
    let (terms, further) = if let Some(decentre) = at(effects::Decentre.id()) {
        let targets = effects::Decentre::CHIEF_RAY_TERMS.to_vec();
        (DisplacementTerms::Decentred, Some((decentre, targets)))
    } else if let Some(planes) = at(effects::DoublePlane.id()) {
        let count = channel.effects[planes].values.len();
        let targets = (effects::DoublePlane::WAVEFRONT_TERMS..count).collect();
        (DisplacementTerms::TwoPlanes, Some((planes, targets)))
    } else {
        (DisplacementTerms::Radial, None)
    };
    let mut lines = displacement_lines(context, registered, index, terms).into_iter();
    let zero = || VergenceSeries::constant(0.0);
    channel.magnification = lines.next().unwrap_or_else(zero);
    channel.distortion = lines.next().unwrap_or_else(zero);
    if let Some((effect, targets)) = further {
        let values = &mut channel.effects[effect].values;
        let unit = context.frame.half_width_px();
        for (target, line) in targets.into_iter().zip(lines) {
            values[target] = line.scaled(unit);
        }
    }
}

/// Fits the `terms` of a channel's displacement as lines in vergence; none without ideal positions.
fn displacement_lines(
    context: &FitContext,
    registered: &[MeasuredTile],
    channel: usize,
    terms: DisplacementTerms,
) -> Vec<VergenceSeries> {
    let points: Vec<_> = context
        .vergences
        .iter()
        .filter_map(|&v| {
            let tiles: Vec<&MeasuredTile> = registered
                .iter()
                .zip(&context.held_out)
                .filter(|(m, held_out)| !**held_out && m.channel == channel)
                .filter(|(m, _)| m.distance.vergence_per_m().unwrap_or(0.0) == v)
                .map(|(m, _)| m)
                .collect();
            Some((v, terms.fit(&context.frame, &tiles)?))
        })
        .collect();
    if points.is_empty() {
        return Vec::new();
    }
    let line = |term: usize| {
        let measured = points.iter().map(|(v, found)| VergencePoint {
            vergence_per_m: *v,
            value: found.values[term],
            sigma: found.sigma[term],
        });
        let measured: Vec<_> = measured.collect();
        let mut line = VergenceSeries::fit_line(&measured);
        if points.len() > 2 && !context.settings.law_only {
            // Residual corrections of a pixel or two from these lines are kept.
            let left = measured
                .iter()
                .map(|p| (p.vergence_per_m, p.value - line.at(p.vergence_per_m)));
            line.remainders = left.collect();
            line.remainders.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        line
    };
    (0..terms.count()).map(line).collect()
}

fn reports(context: &FitContext, lens: &LensProfile) -> Vec<ChannelReport> {
    let mut reports = Vec::new();
    for (index, channel) in lens.pupil_channels().iter().enumerate() {
        let mut distances: Vec<ObjectDistance> = Vec::new();
        for tile in context.measured {
            if !distances.contains(&tile.distance) {
                distances.push(tile.distance);
            }
        }
        let vergence = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(0.0);
        distances.sort_by(|a, b| vergence(a).total_cmp(&vergence(b)));
        for distance in distances {
            let v = vergence(&distance);
            let count = |wanted: bool| {
                let pairs = context.measured.iter().zip(&context.held_out);
                pairs
                    .filter(|(m, held_out)| {
                        m.channel == index && m.distance == distance && **held_out == wanted
                    })
                    .count()
            };
            let n = channel.numbers(v);
            reports.push(ChannelReport {
                channel: channel.name.clone(),
                distance,
                used: count(false),
                held_out: count(true),
                numbers: [n.alpha, n.beta, n.gamma, n.delta, n.phi],
                blur_px: channel.blur_variance_px2.at(v).max(0.0).sqrt(),
            });
        }
    }
    reports
}

impl PupilSettings {
    fn describe(&self) -> String {
        let model = match self.model {
            PupilModel::Reduced => "reduced",
            PupilModel::Auto => "extended where needed",
            PupilModel::Extended => "extended",
        };
        let mut words = format!("{model}, {}", axis_and_support(self.axis, self.support));
        if self.law_only {
            words.push_str(", law only");
        }
        if self.use_all {
            words.push_str(", ");
            words.push_str(Provenance::NONE_HELD_OUT);
        }
        words
    }
}
