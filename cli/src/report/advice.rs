//! The section with the meaning of each cause, its fitted values, and what to do about it.

use seidel_core::{Diagnosis, Verdict};

use super::markup::{escape, with_code};
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

/// Returns the causes that the verdict names: the added ones, then their rivals, then the unknown cause.
pub(super) fn advice(d: &Diagnosis) -> Vec<Advice> {
    let mut ids: Vec<&'static str> = Vec::new();
    let rivals = d.equivalents.iter().flatten();
    let unknown = (d.verdict_on_effects() == Verdict::Unexplained).then_some("unknown");
    for id in d.added.iter().chain(rivals).copied().chain(unknown) {
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
        action: action(id),
    };
    too_simple
        .into_iter()
        .chain(ids.into_iter().map(of_cause))
        .collect()
}

fn amount(d: &Diagnosis, id: &str) -> String {
    let cause = d.causes.iter().find(|cause| cause.effect == id);
    cause.map_or(String::new(), |cause| sentence(&cause.amount))
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
