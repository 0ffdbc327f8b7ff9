//! Runs a self-test: draws the sealed cases one by one, diagnoses each blind, then opens its answer.

use std::collections::BTreeSet;
use std::time::Instant;

use seidel_calibrate::diagnose::diagnose;
use seidel_calibrate::fit::fit_pupil;
use seidel_core::diagnosis::Capture as NextCapture;
use seidel_core::fitting::{PupilModel, PupilSettings};
use seidel_core::{
    Diagnosis, DiagnosisSettings, Error, LensProfile, ObservationSet, Progress, Result, Verdict,
};
use seidel_optics::effects;
use seidel_trial::{
    Answer, Case, FitModel, FurtherCapture, KindClass, Outcome, Recipe, Selection, Setting, draw,
    draw_further, recipes,
};

use crate::holdout::{Positions, closed_share};
use crate::processor_time::processor_seconds;
use crate::results::{AdvisedResult, CaseResult, FAILED, SelfTest, WithheldResult};

/// Settings of a self-test.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// The cases to draw.
    pub(crate) selection: Selection,
    /// Index of the only case of the selection to run; all if `None`.
    pub(crate) only_case: Option<usize>,
    /// Identifiers of the effects that the diagnosis tries; all if empty.
    pub(crate) library: Vec<String>,
    /// Whether cases with a single effect are diagnosed again without that effect in the library.
    pub(crate) withhold: bool,
}

/// The observer of a running self-test.
pub(crate) struct Observer<'a> {
    /// Receives the share done, 0 to 1; a case that it cancels counts as failed.
    pub(crate) progress: &'a Progress<'a>,
    /// Receives each result when its case is finished.
    pub(crate) finished: &'a mut dyn FnMut(&CaseResult),
}

/// Draws and diagnoses the cases in sequence.
///
/// # Panics
/// Sets without places, and tiles smaller than 25 pixels.
pub(crate) fn run(plan: &Plan, observer: &mut Observer) -> SelfTest {
    let recipes: Vec<(usize, Recipe)> = recipes(&plan.selection)
        .into_iter()
        .enumerate()
        .filter(|(index, _)| plan.only_case.is_none_or(|only| only == *index))
        .collect();
    let count = recipes.len() as f64;
    let mut cases = Vec::with_capacity(recipes.len());
    for (done, (index, recipe)) in recipes.iter().enumerate() {
        let all = observer.progress;
        let progress = |share: f64| all((done as f64 + share) / count);
        progress(0.0);
        let result = run_case(*index, recipe, plan, &progress);
        (observer.finished)(&result);
        cases.push(result);
    }
    SelfTest {
        selection: plan.selection,
        cases,
        withhold: plan.withhold,
    }
}

/// The time that a fit and a diagnosis took.
#[derive(Debug, Clone, Copy)]
struct TimeTaken {
    seconds: f64,
    cpu_seconds: Option<f64>,
}

/// A running clock.
struct Stopwatch {
    start: Instant,
    cpu_start: Option<f64>,
}

impl Stopwatch {
    fn start() -> Self {
        Self {
            start: Instant::now(),
            cpu_start: processor_seconds(),
        }
    }

    fn read(&self) -> TimeTaken {
        let cpu_seconds = processor_seconds()
            .zip(self.cpu_start)
            .map(|(now, start)| now - start);
        TimeTaken {
            seconds: self.start.elapsed().as_secs_f64(),
            cpu_seconds,
        }
    }
}

/// Draws a case, diagnoses it from the sets that a user would have, then opens its answer.
fn run_case(index: usize, recipe: &Recipe, plan: &Plan, progress: &Progress) -> CaseResult {
    let Case {
        design,
        real,
        holdout,
        answer,
    } = draw(recipe);
    let stopwatch = Stopwatch::start();
    let passes = if plan.withhold { 2.0 } else { 1.0 };
    let first = |share: f64| progress(share / passes);
    let blind = fit_and_diagnose(&design, &real, recipe.model, &plan.library, &first);
    let time = stopwatch.read();
    let fit_cpu_seconds = blind.as_ref().ok().and_then(|blind| blind.fit_cpu_seconds);
    let withheld = (plan.withhold && answer.kind == "single").then(|| {
        let second = |share: f64| progress((1.0 + share) / passes);
        let library = library_without(&plan.library, &answer.effects);
        diagnose_withheld(&library, &real, blind.as_ref(), &second)
    });
    let advised = (blind.as_ref().ok())
        .filter(|blind| blind.diagnosis.verdict == Verdict::Ambiguous)
        .map(|blind| diagnose_advised(recipe, blind.diagnosis.next_capture_id, &answer, plan));
    let positions = if recipe.conditions.ideal_positions {
        Positions::Ideal
    } else {
        Positions::Unknown
    };
    let scored = blind.and_then(|blind| {
        let corrected = &blind.diagnosis.corrected;
        let closed = closed_share(&blind.lens, corrected, &holdout, positions)?;
        Ok((closed, blind))
    });
    let own_gap = scored
        .as_ref()
        .ok()
        .map(|(_, blind)| blind.diagnosis.model.own_gap);
    let limit = scored
        .as_ref()
        .ok()
        .map(|(_, blind)| blind.diagnosis.detection_limit);
    let (outcome, error) = match scored {
        Ok((closed, blind)) => {
            let outcome = outcome(recipe, answer, &blind.diagnosis, closed, time);
            (outcome, None)
        }
        Err(error) => (failed(recipe, answer, time), Some(error.to_string())),
    };
    CaseResult {
        index,
        recipe: *recipe,
        outcome,
        own_gap,
        detection_limit: limit,
        error,
        withheld,
        advised,
        fit_cpu_seconds,
    }
}

/// Takes the advised `capture` of a case and diagnoses it again.
fn diagnose_advised(
    recipe: &Recipe,
    capture: NextCapture,
    answer: &Answer,
    plan: &Plan,
) -> AdvisedResult {
    let sets = further_capture(capture).and_then(|further| draw_further(recipe, further));
    let diagnosed = sets.map(|sets| {
        let nothing = |_| true;
        fit_and_diagnose(
            &sets.design,
            &sets.real,
            recipe.model,
            &plan.library,
            &nothing,
        )
    });
    let mut result = AdvisedResult {
        capture: capture.id(),
        verdict: None,
        added: Vec::new(),
        settled: None,
    };
    match diagnosed {
        None => {}
        Some(Err(_)) => {
            result.verdict = Some(FAILED.to_owned());
            result.settled = Some(false);
        }
        Some(Ok(blind)) => {
            let diagnosis = &blind.diagnosis;
            result.verdict = Some(diagnosis.verdict.id().to_owned());
            result.added = owned(&diagnosis.added);
            let as_a_set = |ids: &[String]| ids.iter().cloned().collect::<BTreeSet<String>>();
            result.settled = Some(match diagnosis.verdict {
                Verdict::Explained => {
                    answer.unknown.is_none() && as_a_set(&result.added) == as_a_set(&answer.effects)
                }
                Verdict::Unexplained => answer.unknown.is_some(),
                Verdict::NoGap => answer.kind == KindClass::None.id(),
                Verdict::ModelTooSimple => answer.kind == KindClass::TooSimple.id(),
                Verdict::Ambiguous | Verdict::Bookkeeping => false,
            });
        }
    }
    result
}

/// Returns the simulated capture that follows the advice; `None` for those that are not simulated: another exposure time, another
/// f-number, and discs of another size.
fn further_capture(capture: NextCapture) -> Option<FurtherCapture> {
    match capture {
        NextCapture::MorePlaces => Some(FurtherCapture::MorePlaces),
        NextCapture::OtherSideOfFocus | NextCapture::SecondDistance => {
            Some(FurtherCapture::OtherSideOfFocus)
        }
        NextCapture::DarkSurround => Some(FurtherCapture::DarkSurround),
        NextCapture::None
        | NextCapture::ShorterExposure
        | NextCapture::FarOutOfFocus
        | NextCapture::TwoStopsDown
        | NextCapture::StoppedDownAndTurned => None,
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
    /// Processor time of the fit, seconds, where it can be measured.
    fit_cpu_seconds: Option<f64>,
}

/// Share of the progress of a diagnosis taken by the fit of its lens.
const FIT_SHARE: f64 = 0.3;

/// Fits a lens of the given `model` to the simulated `design` and diagnoses it against `real`.
fn fit_and_diagnose(
    design: &ObservationSet,
    real: &ObservationSet,
    model: FitModel,
    library: &[String],
    progress: &Progress,
) -> Result<BlindDiagnosis> {
    let fitting = |share: f64| progress(FIT_SHARE * share);
    let stopwatch = Stopwatch::start();
    let lens = fit(design, model, &fitting)?;
    let fit_cpu_seconds = stopwatch.read().cpu_seconds;
    let diagnosing = |share: f64| progress(FIT_SHARE + (1.0 - FIT_SHARE) * share);
    let diagnosis = checked_diagnosis(&lens, real, library, &diagnosing)?;
    Ok(BlindDiagnosis {
        lens,
        diagnosis,
        fit_cpu_seconds,
    })
}

/// Fits a lens of the given `model` to `design`.
pub(crate) fn fit(
    design: &ObservationSet,
    model: FitModel,
    progress: &Progress,
) -> Result<LensProfile> {
    let settings = PupilSettings {
        model: match model {
            FitModel::Reduced => PupilModel::Reduced,
            FitModel::Extended => PupilModel::Extended,
        },
        ..PupilSettings::default()
    };
    Ok(fit_pupil(std::slice::from_ref(design), &settings, progress)?.lens)
}

/// Diagnoses `lens` against `real` and rejects scores that are not finite.
pub(crate) fn checked_diagnosis(
    lens: &LensProfile,
    real: &ObservationSet,
    library: &[String],
    progress: &Progress,
) -> Result<Diagnosis> {
    let settings = DiagnosisSettings {
        library: library.to_vec(),
        ..DiagnosisSettings::default()
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

/// Returns the outcome of a case from its diagnosis.
fn outcome(
    recipe: &Recipe,
    answer: Answer,
    diagnosis: &Diagnosis,
    true_closed: f64,
    time: TimeTaken,
) -> Outcome {
    let causes = diagnosis.causes.iter();
    let ranked = causes.map(|c| (c.effect.to_owned(), c.probability));
    Outcome {
        verdict: diagnosis.verdict.id().to_owned(),
        added: owned(&diagnosis.added),
        ranked: ranked.collect(),
        equivalents: diagnosis.equivalents.iter().map(|e| owned(e)).collect(),
        claimed_closed: diagnosis.gap.closed,
        true_closed,
        ..failed(recipe, answer, time)
    }
}

/// Returns the outcome of a case that could not be fitted or diagnosed.
fn failed(recipe: &Recipe, answer: Answer, time: TimeTaken) -> Outcome {
    Outcome {
        answer,
        setting: Setting {
            simulator: recipe.simulator.id().to_owned(),
            distances: recipe.conditions.distances,
        },
        verdict: FAILED.to_owned(),
        added: Vec::new(),
        ranked: Vec::new(),
        equivalents: Vec::new(),
        claimed_closed: 0.0,
        true_closed: 0.0,
        seconds: time.seconds,
        cpu_seconds: time.cpu_seconds,
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
