//! The cases of a self-test, one after the other: drawn, diagnosed blind, and only then opened.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use seidel_core::diagnose::{Diagnosis, Progress, Settings, diagnose};
use seidel_core::effects;
use seidel_core::fit::{PupilSettings, fit_pupil};
use seidel_core::observations::ObservationSet;
use seidel_core::predict::{Predictor, predict_like};
use seidel_core::profile::LensProfile;
use seidel_core::trial::{Answer, Case, Outcome, Size, draw, recipes};
use seidel_core::{Error, Result};

use crate::report::self_test::{FAILED, SelfTest, Tested, Withheld};

/// Draws, diagnoses and opens `count` cases, one after the other; `told` hears the share done.
///
/// # Panics
/// Sets without places, and tiles smaller than 25 pixels.
pub fn run(
    (count, size): (usize, Size),
    seed: u64,
    withhold: bool,
    told: &(dyn Fn(f64) + Sync),
) -> SelfTest {
    let cases = recipes(count, seed, size)
        .iter()
        .enumerate()
        .map(|(index, recipe)| {
            let told = |share: f64| told((index as f64 + share) / count as f64);
            told(0.0);
            tested(draw(recipe), withhold, &told)
        })
        .collect();
    SelfTest {
        seed,
        size,
        cases,
        withhold,
    }
}

/// Diagnoses a case with nothing but what a user has, and opens its answer after.
fn tested(case: Case, withhold: bool, told: &(dyn Fn(f64) + Sync)) -> Tested {
    let begun = Instant::now();
    let first = |share| told(if withhold { share / 2.0 } else { share });
    let said = blind(&case.design, &case.real, &first);
    let seconds = begun.elapsed().as_secs_f64();
    let Case {
        real,
        holdout,
        answer,
        ..
    } = case;
    let withheld = (withhold && answer.kind == "single").then(|| {
        let second = |share| told((1.0 + share) / 2.0);
        without(&answer.effects, &real, said.as_ref(), &second)
    });
    let judged = said.and_then(|said| Ok((closed(&said, &holdout)?, said)));
    let (outcome, failure) = match judged {
        Ok((true_closed, said)) => (outcome(answer, &said.found, true_closed, seconds), None),
        Err(problem) => (failed(answer, seconds), Some(problem.to_string())),
    };
    Tested {
        outcome,
        failure,
        withheld,
    }
}

/// What is said of a case by who has not seen its answer.
struct Blind {
    /// The lens fitted to the design.
    lens: LensProfile,
    found: Diagnosis,
}

/// Fits a lens to what was simulated and holds what was seen against it.
fn blind(
    design: &ObservationSet,
    real: &ObservationSet,
    told: &(dyn Fn(f64) + Sync),
) -> Result<Blind> {
    let lens = fit_pupil(std::slice::from_ref(design), &PupilSettings::default())?.lens;
    let found = diagnosed(&lens, real, Vec::new(), told)?;
    Ok(Blind { lens, found })
}

fn diagnosed(
    lens: &LensProfile,
    real: &ObservationSet,
    library: Vec<String>,
    told: &(dyn Fn(f64) + Sync),
) -> Result<Diagnosis> {
    let settings = Settings {
        library,
        ..Settings::default()
    };
    let progress = Progress {
        report: told,
        stop: &AtomicBool::new(false),
    };
    let found = diagnose(lens, real, &settings, &progress)?;
    let odds = found.causes.iter().map(|c| (c.probability, c.effect));
    for (number, what) in odds.chain([(found.gap.closed, "gap closed")]) {
        if !number.is_finite() {
            return Err(not_finite(what, number));
        }
    }
    Ok(found)
}

/// What is said when the library has all effects but `missing`.
fn without(
    missing: &[String],
    real: &ObservationSet,
    said: std::result::Result<&Blind, &Error>,
    told: &(dyn Fn(f64) + Sync),
) -> Withheld {
    let begun = Instant::now();
    let known = effects::ALL.iter().map(|effect| effect.id().to_owned());
    let others = known.filter(|id| !missing.contains(id)).collect();
    let found = match said {
        Ok(said) => diagnosed(&said.lens, real, others, told).map_err(|e| e.to_string()),
        Err(problem) => Err(problem.to_string()),
    };
    let seconds = begun.elapsed().as_secs_f64();
    match found {
        Ok(found) => Withheld {
            verdict: found.verdict.id().to_owned(),
            added: owned(&found.added),
            failure: None,
            seconds,
        },
        Err(problem) => Withheld {
            verdict: FAILED.to_owned(),
            added: Vec::new(),
            failure: Some(problem),
            seconds,
        },
    }
}

/// Share of the gap on `holdout` that the corrected lens closes; 0 where the given one leaves none.
fn closed(said: &Blind, holdout: &ObservationSet) -> Result<f64> {
    let before = gap(&said.lens, holdout)?;
    if before <= 0.0 {
        return Ok(0.0);
    }
    let closed = 1.0 - gap(&said.found.corrected, holdout)? / before;
    if closed.is_finite() {
        Ok(closed)
    } else {
        Err(not_finite("share truly closed", closed))
    }
}

/// Mean over tiles of |o - p|² / |o|², o observed and p predicted with unit sums, less what stated noise gives.
fn gap(lens: &LensProfile, set: &ObservationSet) -> Result<f64> {
    let predictor = Predictor::new(lens)?;
    let predicted = predict_like(&predictor, set, predictor.default_model())?;
    let (mut sum, mut count) = (0.0, 0_usize);
    for (seen, drawn) in set.observations.iter().zip(&predicted.observations) {
        for (channel, p) in drawn.tiles.iter().enumerate() {
            let o = seen.light(channel);
            let light = o.sum();
            let sigma = seen.noise_sigma[channel].unwrap_or(0.0) / light;
            let unit = o.samples().iter().map(|v| f64::from(*v) / light);
            let (apart, norm) = unit
                .zip(p.samples())
                .fold((0.0, 0.0), |(apart, norm), (o, p)| {
                    (apart + (o - f64::from(*p)).powi(2), norm + o * o)
                });
            sum += (apart - o.samples().len() as f64 * sigma * sigma) / norm;
            count += 1;
        }
    }
    Ok(sum / count.max(1) as f64)
}

fn outcome(answer: Answer, found: &Diagnosis, true_closed: f64, seconds: f64) -> Outcome {
    let causes = found.causes.iter();
    Outcome {
        answer,
        verdict: found.verdict.id().to_owned(),
        added: owned(&found.added),
        ranked: causes
            .map(|c| (c.effect.to_owned(), c.probability))
            .collect(),
        equivalents: found.equivalents.iter().map(|ids| owned(ids)).collect(),
        claimed_closed: found.gap.closed,
        true_closed,
        seconds,
    }
}

/// The outcome of a case of which nothing could be said.
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

fn not_finite(what: &str, number: f64) -> Error {
    Error::new(
        format!("diagnosis: {what}"),
        format!("is {number}"),
        "report this as a fault, with the seed and the count",
    )
}
