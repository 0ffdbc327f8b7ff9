//! Faults of photographs that make a lens wrong, by cause: which are refused, which are remarked on.

use std::path::Path;

use seidel_calibrate::fit::edges::Departures;
use seidel_image_io::FileError;
use seidel_measure::checks::{self, Concern};

use crate::commands::CommandError;

/// The decision where a lens would be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Insistence {
    /// Write no lens.
    Refuse,
    /// Write the lens with remarks (`--force`).
    Force,
}

impl Insistence {
    /// Returns that of the option `--force`.
    pub(super) fn of(force: &ForceArgs) -> Self {
        if force.force {
            Self::Force
        } else {
            Self::Refuse
        }
    }
}

/// The option that overrides refusals.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(super) struct ForceArgs {
    /// Write the lens where a fault of the photographs makes it wrong, too; the faults are then remarks
    #[arg(long)]
    force: bool,
}

/// The effect of a fault on the lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Severity {
    /// The lens is wrong by more than its stated error.
    Wrong,
    /// The lens is less accurate than clean photographs make it.
    Doubtful,
}

/// A fault of photographs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    severity: Severity,
    problem: String,
    remedy: &'static str,
}

/// Chi squared per degree of freedom above which a lens is doubtful, and above which it is wrong. Clean charts have 0.9 to 1.4.
const DOUBTFUL_CHI2: f64 = 2.0;
const WRONG_CHI2: f64 = 8.0;
/// Standard errors by which a departure must differ from nothing.
const SIGMAS: f64 = 5.0;
/// Skewness common to all directions from which on samples are not linear in light.
const WRONG_SKEWNESS: f64 = 0.06;
/// Elongation of the blur all over the frame, over its variance, from which on a lens is doubtful, and wrong. Two clean charts
/// had up to 0.025, a shake of 3 px 0.09, which costs a lens more than 20 dB.
const DOUBTFUL_ELONGATION: f64 = 0.03;
const WRONG_ELONGATION: f64 = 0.06;
/// Angle from an axis of the frame within which an elongation may be a squeeze, degrees, and least ratio of the variances.
const SQUEEZE_DEG: f64 = 10.0;
const SQUEEZE_RATIO: f64 = 1.5;

/// Returns the fault that the misfit of all profiles shows: `chi2` per degree of freedom, and the part of the levels that the lens
/// does not explain, over the step.
pub(super) fn of_misfit(chi2: f64, unexplained: f64) -> Option<Fault> {
    let severity = match chi2 {
        _ if chi2 > WRONG_CHI2 => Severity::Wrong,
        _ if chi2 > DOUBTFUL_CHI2 => Severity::Doubtful,
        _ => return None,
    };
    Some(Fault {
        severity,
        problem: format!(
            "differ from every lens by {:.1} times their noise (chi squared {chi2:.1} per degree of freedom, {:.1} % of the step): the lens does not describe them",
            chi2.sqrt(),
            100.0 * unexplained
        ),
        remedy: "photograph raw, the chart flat and still, with one lens at one focus and aperture; name the log curve of footage by --encoding",
    })
}

/// Returns the faults that `departures` show, with `squeeze` as the pixel aspect that the user states.
pub(super) fn of_departures(departures: &Departures, squeeze: Option<f64>) -> Vec<Fault> {
    let mut faults = Vec::new();
    let skewness = departures.skewness;
    if skewness.value.abs() > WRONG_SKEWNESS.max(SIGMAS * skewness.sigma) {
        let side = if skewness.value > 0.0 {
            "bright"
        } else {
            "dark"
        };
        faults.push(Fault {
            severity: Severity::Wrong,
            problem: format!(
                "are not linear in light: edges of all directions are drawn out towards their {side} side (skewness {:.2} ± {:.2}), which no lens does",
                skewness.value.abs(),
                skewness.sigma
            ),
            remedy: "name the transfer function by --encoding, such as srgb or the log curve of the camera; or photograph raw, and state --black",
        });
    }
    let elongation = departures.elongation_px2;
    let share = elongation.value / departures.variance_px2.max(f64::MIN_POSITIVE);
    if elongation.value > SIGMAS * elongation.sigma && share > DOUBTFUL_ELONGATION {
        let severity = if share > WRONG_ELONGATION {
            Severity::Wrong
        } else {
            Severity::Doubtful
        };
        let axis = departures.direction_deg.rem_euclid(90.0);
        let ratio = (1.0 + share) / (1.0 - share).max(0.01);
        let is_squeeze = axis.min(90.0 - axis) < SQUEEZE_DEG && ratio > SQUEEZE_RATIO;
        if !(is_squeeze && squeeze.is_some()) {
            let cause = if is_squeeze {
                "a squeezed picture".to_owned()
            } else {
                // The variance of a straight path of length l is l²/12; half of it is the elongation.
                format!(
                    "a camera that moved by {:.1} px",
                    (24.0 * elongation.value).sqrt()
                )
            };
            faults.push(Fault {
                severity,
                problem: format!(
                    "are blurred more along {:.0} degrees than across, all over the frame (variance {:.2} ± {:.2} px²), as by {cause}",
                    departures.direction_deg, 2.0 * elongation.value, 2.0 * elongation.sigma
                ),
                remedy: "use a tripod and a self-timer, without stabiliser; give --pixel-aspect for footage of an anamorphic lens",
            });
        }
    }
    faults
}

/// Returns `faults` as remarks.
///
/// # Errors
/// The first fault that makes the lens wrong, unless the user insists. It is one of the photograph at `path`.
pub(super) fn settle(
    faults: &[Fault],
    insistence: Insistence,
    path: &Path,
) -> Result<Vec<String>, CommandError> {
    let wrong = faults.iter().find(|f| f.severity == Severity::Wrong);
    if let (Some(fault), Insistence::Refuse) = (wrong, insistence) {
        let remedy = format!("{}. --force writes the lens all the same", fault.remedy);
        return Err(FileError::new(path, "edges", fault.problem.clone(), remedy).into());
    }
    let remarks = faults
        .iter()
        .map(|f| format!("the edges {}: {}", f.problem, f.remedy));
    Ok(remarks.collect())
}

/// Returns `concerns` about photographs as remarks.
///
/// # Errors
/// The first for which no lens should be measured, unless the user insists.
pub(super) fn settle_concerns(
    concerns: &[Concern],
    insistence: Insistence,
) -> Result<Vec<String>, CommandError> {
    if let (Some(refusal), Insistence::Refuse) = (checks::refusal(concerns), insistence) {
        let mut error = refusal.clone();
        error
            .remedy
            .push_str(". --force writes the lens all the same");
        return Err(error.into());
    }
    Ok(concerns.iter().map(|c| c.error.to_string()).collect())
}

#[cfg(test)]
mod tests;
