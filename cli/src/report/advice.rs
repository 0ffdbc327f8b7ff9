//! The section with the meaning of each cause, its fitted values, and what to do about it.

use seidel_core::diagnosis::Bookkeeping;
use seidel_core::{Diagnosis, Verdict};

use super::markup::{escape, with_code};
use super::verdict::in_answers;
use super::words::{action, list, meaning, sentence, title};

/// A cause with its plain words.
pub(super) struct Advice {
    /// Identifier of the effect; `unknown` or `model_too_simple` for those verdicts.
    pub(super) id: &'static str,
    /// Title, capitalised.
    pub(super) title: String,
    /// Meaning for the lens or the camera.
    pub(super) meaning: String,
    /// Fitted values in the user's units; empty where there are none.
    pub(super) amount: String,
    /// Advice on what to do.
    pub(super) action: String,
}

/// Probability below which an effect that was added to an unexplained gap is not taken for its cause.
const LEAST_PROBABILITY_OF_CAUSE: f64 = 0.5;

/// Returns the mistake in the books, then the causes that the verdict names: the unknown cause, the added ones, then their rivals.
pub(super) fn advice(d: &Diagnosis) -> Vec<Advice> {
    let mut ids: Vec<&'static str> = Vec::new();
    let rivals = d.equivalents.iter().flatten();
    let unknown = (d.verdict_on_effects() == Verdict::Unexplained).then_some("unknown");
    for id in unknown
        .into_iter()
        .chain(d.added.iter().chain(rivals).copied())
    {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    let too_simple = (d.verdict_on_effects() == Verdict::ModelTooSimple).then(|| model_advice(d));
    let of_cause = |id: &'static str| Advice {
        id,
        title: sentence(title(id)),
        meaning: meaning(id).to_owned(),
        amount: amount(d, id),
        action: if is_hardly_the_cause(d, id) {
            "It closes a part of the gap and is hardly its cause: make the next capture before you change anything."
                .to_owned()
        } else {
            action(id)
        },
    };
    let mistake = d.bookkeeping.as_ref().map(mistake_advice);
    mistake
        .into_iter()
        .chain(too_simple)
        .chain(ids.into_iter().map(of_cause))
        .collect()
}

fn amount(d: &Diagnosis, id: &str) -> String {
    let cause = d.causes.iter().find(|cause| cause.effect == id);
    cause.map_or(String::new(), |cause| sentence(&cause.amount))
}

/// Returns whether an effect was added to an unexplained gap, and the answers that name it are improbable.
fn is_hardly_the_cause(d: &Diagnosis, id: &str) -> bool {
    d.verdict_on_effects() == Verdict::Unexplained
        && d.added.contains(&id)
        && in_answers(d, id) < LEAST_PROBABILITY_OF_CAUSE
}

/// Returns the advice for a mistake in the books.
fn mistake_advice(found: &Bookkeeping) -> Advice {
    let place = if found.can_be_corrected {
        ". The corrected set is in the folder corrected-set; all other figures are of it."
    } else {
        "."
    };
    Advice {
        id: found.mistake,
        title: "A mistake in the books".to_owned(),
        meaning: format!("{}.", sentence(&found.words)),
        amount: String::new(),
        action: format!("{}{place}", found.remedy.trim_end_matches('.')),
    }
}

/// Returns the advice for a model that does not describe its own set.
fn model_advice(d: &Diagnosis) -> Advice {
    let missing: Vec<String> = (d.model.freedom.iter())
        .map(|id| title(id).to_owned())
        .collect();
    let action = if missing.is_empty() {
        "Measure PSFs at more places and distances and fit the lens again. `seidel eval --shapes` shows what its \
         model cannot draw."
            .to_owned()
    } else {
        format!(
            "Fit the lens again with `seidel fit --model extended`: the lens has {}. Then diagnose these observations \
             with the new profile.",
            list(&missing, "and")
        )
    };
    Advice {
        id: "model_too_simple",
        title: "A model that is too simple".to_owned(),
        meaning: "The profile does not describe the set that it was fitted to, so a change of the lens cannot be distinguished \
                  from what the model lacks."
            .to_owned(),
        amount: String::new(),
        action,
    }
}

/// Returns the section; empty where the verdict names no cause.
pub(super) fn advice_section(d: &Diagnosis) -> String {
    let rows: String = advice(d).iter().map(row).collect();
    if rows.is_empty() {
        return String::new();
    }
    format!(
        "<section><h2>What it means, and what to do</h2>\n<div class=\"advice\">\n{rows}</div></section>\n"
    )
}

fn row(advice: &Advice) -> String {
    let amount = if advice.amount.is_empty() {
        String::new()
    } else {
        format!("<p class=\"amount\">{}.</p>", escape(&advice.amount))
    };
    format!(
        "<div><h3>{}</h3><span class=\"quiet small\">{}</span></div><div><p>{}</p>{amount}</div>\
         <div><p>{}</p></div>\n",
        escape(&advice.title),
        escape(advice.id),
        escape(&advice.meaning),
        with_code(&advice.action)
    )
}
