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

/// What a self-test is to do.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Cases to draw.
    pub count: usize,
    /// All of them follow from it.
    pub seed: u64,
    /// How large they are.
    pub size: Size,
    /// Effects that the diagnosis tries, by identifier; all if empty.
    pub library: Vec<String>,
    /// Whether cases with one effect are diagnosed once more without that effect in the library.
    pub withhold: bool,
}

/// Draws, diagnoses and opens the cases, one after the other; `told` hears the share done.
///
/// # Panics
/// Sets without places, and tiles smaller than 25 pixels.
pub fn run(plan: &Plan, told: &(dyn Fn(f64) + Sync)) -> SelfTest {
    let cases = recipes(plan.count, plan.seed, plan.size)
        .iter()
        .enumerate()
        .map(|(index, recipe)| {
            let told = |share: f64| told((index as f64 + share) / plan.count as f64);
            told(0.0);
            tested(draw(recipe), plan, &told)
        })
        .collect();
    SelfTest {
        seed: plan.seed,
        size: plan.size,
        cases,
        withhold: plan.withhold,
    }
}

/// Diagnoses a case with nothing but what a user has, and opens its answer after.
fn tested(case: Case, plan: &Plan, told: &(dyn Fn(f64) + Sync)) -> Tested {
    let begun = Instant::now();
    let passes = if plan.withhold { 2.0 } else { 1.0 };
    let first = |share: f64| told(share / passes);
    let said = blind(&case.design, &case.real, &plan.library, &first);
    let seconds = begun.elapsed().as_secs_f64();
    let Case {
        real,
        holdout,
        answer,
        ..
    } = case;
    let withheld = (plan.withhold && answer.kind == "single").then(|| {
        let second = |share: f64| told((1.0 + share) / passes);
        let library = others(&plan.library, &answer.effects);
        without(&library, &real, said.as_ref(), &second)
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

/// The effects of `library`, all if empty, but for those of `missing`.
fn others(library: &[String], missing: &[String]) -> Vec<String> {
    let known = if library.is_empty() {
        effects::ALL.iter().map(|e| e.id().to_owned()).collect()
    } else {
        library.to_vec()
    };
    known
        .into_iter()
        .filter(|id| !missing.contains(id))
        .collect()
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
    library: &[String],
    told: &(dyn Fn(f64) + Sync),
) -> Result<Blind> {
    let lens = fit_pupil(std::slice::from_ref(design), &PupilSettings::default())?.lens;
    let found = diagnosed(&lens, real, library, told)?;
    Ok(Blind { lens, found })
}

fn diagnosed(
    lens: &LensProfile,
    real: &ObservationSet,
    library: &[String],
    told: &(dyn Fn(f64) + Sync),
) -> Result<Diagnosis> {
    let settings = Settings {
        library: library.to_vec(),
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

/// What is said with a library that lacks what is true.
fn without(
    library: &[String],
    real: &ObservationSet,
    said: std::result::Result<&Blind, &Error>,
    told: &(dyn Fn(f64) + Sync),
) -> Withheld {
    let begun = Instant::now();
    let found = match said {
        Ok(said) => diagnosed(&said.lens, real, library, told).map_err(|e| e.to_string()),
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
