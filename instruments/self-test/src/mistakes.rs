//! A sealed run of mistakes in keeping books: each case is compared with its lens as drawn, and with a planted mistake.

use std::fmt;

use seidel_calibrate::diagnose::{FoundMistake, find_mistake};
use seidel_core::{LensProfile, ObservationSet, Result, Verdict, no_progress};
use seidel_trial::{Kind, Mistake, Rate, Recipe, Selection, draw, recipes};

use crate::holdout::{Positions, mean_gap};
use crate::runner::{checked_diagnosis, fit};

/// Least growth of the gap by a mistake that can be seen.
const MIN_GROWTH: f64 = 0.01;
/// Added to the seed of a case for that of another lens.
const OTHER_SEED: u64 = 0x5EED;

/// The depth of the examination of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Depth {
    /// By predictions alone, without effects: seconds a case
    Predictions,
    /// By a whole diagnosis where predictions do not settle it
    Diagnosis,
}

/// The mistake found in a set.
#[derive(Debug, Clone, PartialEq)]
enum Finding {
    Named(&'static str, String),
    /// Predictions suspect it, and no diagnosis was made.
    Suspected(&'static str),
    Nothing,
    Failed(String),
}

/// The result of a case.
#[derive(Debug)]
pub(crate) struct BooksResult {
    index: usize,
    recipe: Recipe,
    mistake: Mistake,
    /// The planted mistake with its amount.
    words: String,
    /// Whether it changes tiles or statements by more than noise.
    is_visible: bool,
    planted: Finding,
    /// Finding in the set without the mistake.
    clean: Finding,
}

/// Runs the cases of `selection`, of which mistakes take turns; `only` is the index of the only one to run.
pub(crate) fn run(
    selection: &Selection,
    only: Option<usize>,
    depth: Depth,
    mut finished: impl FnMut(&BooksResult),
) -> Vec<BooksResult> {
    let cases = recipes(selection).into_iter().enumerate();
    let cases = cases.filter(|(index, _)| only.is_none_or(|only| only == *index));
    let run = cases.map(|(index, recipe)| {
        // An odd step, so that both simulators get every mistake.
        let mistake = Mistake::ALL[index % Mistake::ALL.len()];
        let result = run_case(index, mistake.made_visible(recipe), mistake, depth);
        finished(&result);
        result
    });
    run.collect()
}

fn run_case(index: usize, recipe: Recipe, mistake: Mistake, depth: Depth) -> BooksResult {
    let case = draw(&recipe);
    let other = match mistake {
        Mistake::AnotherLens => {
            let seed = recipe.seed.wrapping_add(OTHER_SEED);
            let other = Recipe {
                kind: Kind::None,
                seed,
                ..recipe
            };
            draw(&other).real
        }
        _ => case.real.clone(),
    };
    let planted = mistake.plant(&recipe, &case.real, &other);
    let positions = match recipe.conditions.ideal_positions {
        true => Positions::Ideal,
        false => Positions::Unknown,
    };
    let mut result = BooksResult {
        index,
        recipe,
        mistake,
        words: planted.words,
        is_visible: true,
        planted: Finding::Nothing,
        clean: Finding::Nothing,
    };
    match fit(&case.design, recipe.model, &no_progress) {
        Ok(lens) => {
            let gap = |set: &ObservationSet| mean_gap(&lens, set, positions).ok();
            let is_stated_only = matches!(mistake, Mistake::Camera | Mistake::NoiseScale);
            // A change that leads out of the range of the lens is seen.
            result.is_visible = is_stated_only
                || gap(&planted.set)
                    .zip(gap(&case.real))
                    .is_none_or(|(with, without)| with - without > MIN_GROWTH);
            result.planted = found(&lens, &planted.set, depth, Expected::Mistake);
            result.clean = found(&lens, &case.real, depth, Expected::Nothing);
        }
        Err(error) => {
            result.planted = Finding::Failed(error.to_string());
            result.clean = Finding::Failed(error.to_string());
        }
    }
    result
}

/// The content of a set, which decides whether a diagnosis is worth its time where predictions find nothing.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Expected {
    Mistake,
    Nothing,
}

fn found(lens: &LensProfile, set: &ObservationSet, depth: Depth, expected: Expected) -> Finding {
    let diagnosed = || -> Result<Finding> {
        let diagnosis = checked_diagnosis(lens, set, &[], &no_progress)?;
        let named = diagnosis.bookkeeping;
        let named = named.filter(|_| diagnosis.verdict == Verdict::Bookkeeping);
        Ok(named.map_or(Finding::Nothing, |found| {
            Finding::Named(found.mistake, found.words)
        }))
    };
    let predicted = find_mistake(lens, set);
    let finding = match (predicted, depth) {
        (Err(error), _) => Err(error),
        (Ok(Some(FoundMistake::Sure(found))), _) => Ok(Finding::Named(found.mistake, found.words)),
        (Ok(Some(FoundMistake::Suspected(found))), Depth::Predictions) => {
            Ok(Finding::Suspected(found.mistake))
        }
        (Ok(None), Depth::Predictions) => Ok(Finding::Nothing),
        (Ok(None), Depth::Diagnosis) if expected == Expected::Nothing => Ok(Finding::Nothing),
        (Ok(_), Depth::Diagnosis) => diagnosed(),
    };
    finding.unwrap_or_else(|error| Finding::Failed(error.to_string()))
}

impl BooksResult {
    fn is_named(&self) -> bool {
        matches!(&self.planted, Finding::Named(id, _) if self.mistake.is_named(id))
    }

    fn is_named_wrongly(&self) -> bool {
        matches!(&self.planted, Finding::Named(id, _) if !self.mistake.is_named(id))
    }

    fn is_false(&self) -> bool {
        matches!(self.clean, Finding::Named(..))
    }

    /// Returns the result on one line.
    pub(crate) fn line(&self) -> String {
        let causes = self.recipe.kind.causes();
        let beside = match causes[..] {
            [] => self.recipe.kind.class().id().to_owned(),
            _ => causes.join(" and "),
        };
        let state = match &self.planted {
            _ if self.is_named() => "named",
            _ if !self.is_visible => "not visible",
            Finding::Named(..) => "WRONG",
            Finding::Suspected(_) => "suspected",
            Finding::Nothing | Finding::Failed(_) => "MISSED",
        };
        let clean = match &self.clean {
            Finding::Nothing => String::new(),
            finding => format!("; without it: FALSE, {finding}"),
        };
        let c = &self.recipe.conditions;
        format!(
            "case {}: {state}; {} ({}) beside {beside} -> {}{clean}; {}, {} x {} tiles of {} px, SNR {:.0}, strength {:.2}{}",
            self.index,
            self.mistake.id(),
            self.words,
            self.planted,
            self.recipe.simulator.id(),
            c.distances,
            c.size.real,
            c.size.tile,
            c.snr,
            c.strength,
            match c.ideal_positions {
                true => "",
                false => ", no ideal positions",
            }
        )
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(id, words) => write!(f, "{id}: {words}"),
            Self::Suspected(id) => write!(f, "suspected {id}"),
            Self::Nothing => f.write_str("nothing"),
            Self::Failed(error) => write!(f, "failed: {error}"),
        }
    }
}

/// Returns the figures of `results`, one a line.
pub(crate) fn summary(results: &[BooksResult]) -> Vec<String> {
    let visible: Vec<&BooksResult> = results.iter().filter(|r| r.is_visible).collect();
    let share = |name: &str, held: usize, of: usize| {
        let rate = Rate::new(held, of);
        format!("{name}: {} of {}", rate.held, rate.of)
    };
    let count = |test: fn(&BooksResult) -> bool| visible.iter().filter(|r| test(r)).count();
    let mut lines = vec![
        share(
            "planted mistakes that can be seen: named",
            count(BooksResult::is_named),
            visible.len(),
        ),
        share(
            "another mistake named",
            count(BooksResult::is_named_wrongly),
            visible.len(),
        ),
        share(
            "nothing planted: a mistake named",
            results.iter().filter(|r| r.is_false()).count(),
            results.len(),
        ),
    ];
    for mistake in Mistake::ALL {
        let own: Vec<&&BooksResult> = visible.iter().filter(|r| r.mistake == mistake).collect();
        if !own.is_empty() {
            let named = own.iter().filter(|r| r.is_named()).count();
            lines.push(share(mistake.id(), named, own.len()));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use seidel_trial::Simulator;

    use super::*;

    fn result(mistake: Mistake, planted: Finding) -> BooksResult {
        BooksResult {
            index: 3,
            recipe: Recipe::new(Kind::Single("decentre"), Simulator::Glass, 1, None),
            mistake,
            words: "(4, 2) px".to_owned(),
            is_visible: true,
            planted,
            clean: Finding::Nothing,
        }
    }

    #[test]
    fn named_wrong_and_false_ones_are_counted_and_invisible_ones_are_not() {
        let named = |id| Finding::Named(id, "words".to_owned());
        let hidden = BooksResult {
            is_visible: false,
            clean: named("crop"),
            ..result(Mistake::Channels, Finding::Nothing)
        };
        let results = [
            result(Mistake::Offset, named("offset")),
            result(Mistake::Tiles, named("positions")),
            result(Mistake::Encoding, named("black_level")),
            result(Mistake::Crop, Finding::Suspected("crop")),
            hidden,
        ];
        let lines = summary(&results);
        assert_eq!(lines[0], "planted mistakes that can be seen: named: 2 of 4");
        assert_eq!(lines[1], "another mistake named: 1 of 4");
        assert_eq!(lines[2], "nothing planted: a mistake named: 1 of 5");
        assert!(lines.contains(&"offset: 1 of 1".to_owned()), "{lines:?}");
        let texts = results.each_ref().map(BooksResult::line);
        assert!(
            texts[0].starts_with("case 3: named; offset ((4, 2) px) beside decentre -> offset")
        );
        assert!(texts[2].starts_with("case 3: WRONG"), "{}", texts[2]);
        assert!(texts[3].starts_with("case 3: suspected"), "{}", texts[3]);
        assert!(texts[4].contains("without it: FALSE, crop"), "{}", texts[4]);
    }
}
