//! Runs a self-test: draws the sealed cases one by one, diagnoses each blind, then opens its answer.

use std::time::Instant;

use seidel_core::calibrate::diagnose::{Diagnosis, Settings, diagnose};
use seidel_core::calibrate::fit::{PupilSettings, fit_pupil};
use seidel_core::effects;
use seidel_core::observations::ObservationSet;
use seidel_core::predict::{Predictor, predict_set};
use seidel_core::profile::LensProfile;
use seidel_core::{Error, Progress, Result};
use seidel_trial::{Answer, Case, Outcome, Size, draw, recipes};

use super::results::{CaseResult, FAILED, SelfTest, WithheldResult};

/// Settings of a self-test.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Number of cases.
    pub count: usize,
    /// Seed from which all cases are drawn.
    pub seed: u64,
    /// Number of places of each case, and its tile size.
    pub size: Size,
    /// Identifiers of the effects that the diagnosis tries; all if empty.
    pub library: Vec<String>,
    /// Whether cases with a single effect are diagnosed again without that effect in the library.
    pub withhold: bool,
}

/// Draws and diagnoses the cases in sequence. `progress` receives the share done, 0 to 1; a case that it cancels counts
/// as failed.
///
/// # Panics
/// Sets without places, and tiles smaller than 25 pixels.
pub fn run(plan: &Plan, progress: &Progress) -> SelfTest {
    let cases = recipes(plan.count, plan.seed, plan.size)
        .iter()
        .enumerate()
        .map(|(index, recipe)| {
            let progress = |share: f64| progress((index as f64 + share) / plan.count as f64);
            progress(0.0);
            run_case(draw(recipe), plan, &progress)
        })
        .collect();
    SelfTest {
        seed: plan.seed,
        size: plan.size,
        cases,
        withhold: plan.withhold,
    }
}

/// Diagnoses a case from the sets that a user would have, then opens its answer.
fn run_case(case: Case, plan: &Plan, progress: &Progress) -> CaseResult {
    let start = Instant::now();
    let passes = if plan.withhold { 2.0 } else { 1.0 };
    let first = |share: f64| progress(share / passes);
    let blind = fit_and_diagnose(&case.design, &case.real, &plan.library, &first);
    let seconds = start.elapsed().as_secs_f64();
    let Case {
        real,
        holdout,
        answer,
        ..
    } = case;
    let withheld = (plan.withhold && answer.kind == "single").then(|| {
        let second = |share: f64| progress((1.0 + share) / passes);
        let library = library_without(&plan.library, &answer.effects);
        diagnose_withheld(&library, &real, blind.as_ref(), &second)
    });
    let scored = blind.and_then(|blind| Ok((closed_share(&blind, &holdout)?, blind)));
    let (outcome, error) = match scored {
        Ok((closed, blind)) => (outcome(answer, &blind.diagnosis, closed, seconds), None),
        Err(error) => (failed(answer, seconds), Some(error.to_string())),
    };
    CaseResult {
        outcome,
        error,
        withheld,
    }
}

/// Returns the effects of `library` (all if empty) except those of `withheld`.
fn library_without(library: &[String], withheld: &[String]) -> Vec<String> {
    let known = if library.is_empty() {
        effects::causes().map(|e| e.id().to_owned()).collect()
    } else {
        library.to_vec()
    };
    known
        .into_iter()
        .filter(|id| !withheld.contains(id))
        .collect()
}

/// A diagnosis made without the answer.
struct BlindDiagnosis {
    /// The lens fitted to the design.
    lens: LensProfile,
    diagnosis: Diagnosis,
}

/// Fits a lens to the simulated `design` and diagnoses it against `real`.
fn fit_and_diagnose(
    design: &ObservationSet,
    real: &ObservationSet,
    library: &[String],
    progress: &Progress,
) -> Result<BlindDiagnosis> {
    let lens = fit_pupil(std::slice::from_ref(design), &PupilSettings::default())?.lens;
    let diagnosis = checked_diagnosis(&lens, real, library, progress)?;
    Ok(BlindDiagnosis { lens, diagnosis })
}

/// Diagnoses `lens` against `real` and rejects scores that are not finite.
fn checked_diagnosis(
    lens: &LensProfile,
    real: &ObservationSet,
    library: &[String],
    progress: &Progress,
) -> Result<Diagnosis> {
    let settings = Settings {
        library: library.to_vec(),
        ..Settings::default()
    };
    let diagnosis = diagnose(lens, real, &settings, progress)?;
    let causes = diagnosis.causes.iter().map(|c| (c.probability, c.effect));
    for (number, name) in causes.chain([(diagnosis.gap.closed, "gap closed")]) {
        if !number.is_finite() {
            return Err(not_finite(name, number));
        }
    }
    Ok(diagnosis)
}

/// Diagnoses the fitted lens of `blind` with a `library` that lacks the true effect.
fn diagnose_withheld(
    library: &[String],
    real: &ObservationSet,
    blind: std::result::Result<&BlindDiagnosis, &Error>,
    progress: &Progress,
) -> WithheldResult {
    let start = Instant::now();
    let diagnosis = match blind {
        Ok(blind) => checked_diagnosis(&blind.lens, real, library, progress),
        Err(error) => Err(error.clone()),
    };
    let seconds = start.elapsed().as_secs_f64();
    match diagnosis {
        Ok(diagnosis) => WithheldResult {
            verdict: diagnosis.verdict.id().to_owned(),
            added: owned(&diagnosis.added),
            seconds,
            error: None,
        },
        Err(error) => WithheldResult {
            verdict: FAILED.to_owned(),
            added: Vec::new(),
            seconds,
            error: Some(error.to_string()),
        },
    }
}

/// Returns the share of the gap on `holdout` that the corrected lens closes; 0 without a gap.
fn closed_share(blind: &BlindDiagnosis, holdout: &ObservationSet) -> Result<f64> {
    let before = mean_gap(&blind.lens, holdout)?;
    if before <= 0.0 {
        return Ok(0.0);
    }
    let closed = 1.0 - mean_gap(&blind.diagnosis.corrected, holdout)? / before;
    if closed.is_finite() {
        Ok(closed)
    } else {
        Err(not_finite("share truly closed", closed))
    }
}

/// Returns the mean gap over tiles: |o - p|² / |o|², less the contribution of the stated noise. o is the observed tile, p
/// the predicted one, both of unit sum.
fn mean_gap(lens: &LensProfile, set: &ObservationSet) -> Result<f64> {
    let predictor = Predictor::new(lens)?;
    let predicted = predict_set(&predictor, set, predictor.default_model())?;
    let (mut sum, mut count) = (0.0, 0_usize);
    for (observed, predicted) in set.observations.iter().zip(&predicted.observations) {
        for (channel, p) in predicted.tiles.iter().enumerate() {
            let o = observed.light(channel);
            let light = o.sum();
            let sigma = observed.noise_sigma[channel].unwrap_or(0.0) / light;
            let (mut difference, mut norm) = (0.0, 0.0);
            for (o, p) in o.samples().iter().zip(p.samples()) {
                let o = f64::from(*o) / light;
                difference += (o - f64::from(*p)).powi(2);
                norm += o * o;
            }
            sum += (difference - o.samples().len() as f64 * sigma * sigma) / norm;
            count += 1;
        }
    }
    Ok(sum / count.max(1) as f64)
}

/// Returns the outcome of a case from its diagnosis.
fn outcome(answer: Answer, diagnosis: &Diagnosis, true_closed: f64, seconds: f64) -> Outcome {
    let causes = diagnosis.causes.iter();
    let ranked = causes.map(|c| (c.effect.to_owned(), c.probability));
    Outcome {
        answer,
        verdict: diagnosis.verdict.id().to_owned(),
        added: owned(&diagnosis.added),
        ranked: ranked.collect(),
        equivalents: diagnosis.equivalents.iter().map(|e| owned(e)).collect(),
        claimed_closed: diagnosis.gap.closed,
        true_closed,
        seconds,
    }
}

/// Returns the outcome of a case that could not be fitted or diagnosed.
fn failed(answer: Answer, seconds: f64) -> Outcome {
    Outcome {
        answer,
        verdict: FAILED.to_owned(),
        added: Vec::new(),
        ranked: Vec::new(),
        equivalents: Vec::new(),
        claimed_closed: 0.0,
        true_closed: 0.0,
        seconds,
    }
}

fn owned(ids: &[&'static str]) -> Vec<String> {
    ids.iter().map(|&id| id.to_owned()).collect()
}

fn not_finite(name: &str, number: f64) -> Error {
    Error::new(
        format!("diagnosis: {name}"),
        format!("is {number}"),
        "report this as a bug, with the seed and the count",
    )
}
