//! `self-test.json`: a self-test for programs, with keys in a fixed order.

use std::collections::BTreeMap;

use seidel_trial::{Conditions, KindClass, Rate, Scores, Size, Strength};
use serde::Serialize;

use crate::aims::{Aim, Bound};
use crate::results::{AdvisedResult, CaseResult, SelfTest, WithheldResult};

const FORMAT: &str = "gap-self-test";
const VERSION: u32 = 2;
/// Causes listed per case.
const TOP_CAUSES: usize = 3;

#[derive(Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    seed: u64,
    count: usize,
    /// The only kind of the cases.
    kind: Option<&'static str>,
    /// Size of all cases, if it was not drawn.
    size: Option<Size>,
    run: usize,
    right: usize,
    failed: usize,
    aims: Vec<AimFile>,
    scores: Scores,
    withheld_unexplained: Option<Rate>,
    advised_settled: Rate,
    cases: Vec<CaseFile<'a>>,
}

#[derive(Serialize)]
struct AimFile {
    key: &'static str,
    value: Option<f64>,
    of: usize,
    at_least: Option<f64>,
    at_most: Option<f64>,
    met: Option<bool>,
}

#[derive(Serialize)]
struct CaseFile<'a> {
    index: usize,
    recipe: String,
    kind: &'a str,
    effects: &'a [String],
    unknown: Option<&'a str>,
    parameters: &'a BTreeMap<String, f64>,
    simulator: &'static str,
    model: &'static str,
    conditions: Conditions,
    gap: f64,
    strength: Option<&'static str>,
    right: bool,
    verdict: &'a str,
    added: &'a [String],
    odds: Option<f64>,
    top: Vec<CauseFile<'a>>,
    equivalents: &'a [Vec<String>],
    own_gap: Option<f64>,
    detection_limit: Option<f64>,
    /// Null where there is no diagnosis.
    claimed_closed: Option<f64>,
    true_closed: Option<f64>,
    seconds: f64,
    cpu_seconds: Option<f64>,
    fit_cpu_seconds: Option<f64>,
    error: Option<&'a str>,
    withheld: Option<&'a WithheldResult>,
    advised: Option<&'a AdvisedResult>,
}

#[derive(Serialize)]
struct CauseFile<'a> {
    effect: &'a str,
    probability: f64,
}

/// Returns the self-test as JSON text with a final newline.
pub(crate) fn json(test: &SelfTest) -> String {
    let file = File {
        format: FORMAT,
        version: VERSION,
        program: concat!("seidel ", env!("CARGO_PKG_VERSION")),
        seed: test.selection.seed,
        count: test.selection.count,
        kind: test.selection.only.map(KindClass::id),
        size: test.selection.size,
        run: test.cases.len(),
        right: test.right(),
        failed: test.failed(),
        aims: test.aims().iter().map(AimFile::new).collect(),
        scores: test.scores(),
        withheld_unexplained: test.withheld_unexplained(),
        advised_settled: test.advised_settled(),
        cases: test.cases.iter().map(CaseFile::new).collect(),
    };
    serde_json::to_string_pretty(&file).expect("a self-test is plain JSON") + "\n"
}

impl AimFile {
    fn new(aim: &Aim) -> Self {
        let (at_least, at_most) = match aim.bound {
            Some(Bound::AtLeast(v)) => (Some(v), None),
            Some(Bound::AtMost(v)) => (None, Some(v)),
            None => (None, None),
        };
        Self {
            key: aim.key,
            value: aim.value(),
            of: aim.of(),
            at_least,
            at_most,
            met: aim.met(),
        }
    }
}

impl<'a> CaseFile<'a> {
    fn new(result: &'a CaseResult) -> Self {
        let o = &result.outcome;
        let diagnosed = result.error.is_none();
        let top = o.ranked.iter().take(TOP_CAUSES);
        Self {
            index: result.index,
            recipe: result.truth(),
            kind: &o.answer.kind,
            effects: &o.answer.effects,
            unknown: o.answer.unknown.as_deref(),
            parameters: &o.answer.parameters,
            simulator: result.recipe.simulator.id(),
            model: result.recipe.model.id(),
            conditions: result.recipe.conditions,
            gap: o.answer.gap,
            strength: Strength::of(o.answer.gap).map(Strength::id),
            right: result.is_right(),
            verdict: &o.verdict,
            added: &o.added,
            odds: o.probability(),
            top: top
                .map(|(effect, probability)| CauseFile {
                    effect,
                    probability: *probability,
                })
                .collect(),
            equivalents: &o.equivalents,
            own_gap: result.own_gap,
            detection_limit: result.detection_limit,
            claimed_closed: diagnosed.then_some(o.claimed_closed),
            true_closed: diagnosed.then_some(o.true_closed),
            seconds: o.seconds,
            cpu_seconds: o.cpu_seconds,
            fit_cpu_seconds: result.fit_cpu_seconds,
            error: result.error.as_deref(),
            withheld: result.withheld.as_ref(),
            advised: result.advised.as_ref(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::self_test;
    use serde_json::Value;

    #[test]
    fn every_case_is_listed_failed_ones_included() {
        let text = json(&self_test());
        let file: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(file["format"], "gap-self-test");
        assert_eq!((&file["version"], &file["seed"]), (&2.into(), &7.into()));
        assert_eq!((&file["count"], &file["right"]), (&12.into(), &6.into()));
        assert_eq!(file["withheld_unexplained"]["of"], 3);
        assert_eq!(file["advised_settled"]["held"], 1);
        assert_eq!(file["aims"][0]["at_least"], 0.95);
        assert_eq!(file["scores"]["single_top1"]["held"], 1);
        let table = &file["scores"]["breakdown"]["simulator"]["third_order"];
        assert_eq!(table["single_top1"]["of"], 3);
        assert!(file["kind"].is_null() && file["size"].is_null());
        let cases = file["cases"].as_array().expect("a list");
        assert_eq!(cases.len(), 12);
        assert_eq!(cases[0]["top"].as_array().map(Vec::len), Some(3));
        assert_eq!(cases[0]["withheld"]["added"][0], "higher_order");
        assert_eq!(cases[6]["recipe"], "unknown: ghost");
        assert_eq!(
            (&cases[0]["strength"], &cases[0]["odds"]),
            (&"strong".into(), &0.94.into())
        );
        assert_eq!(cases[10]["model"], "reduced");
        let failed = &cases[8];
        assert_eq!(
            (&failed["verdict"], &failed["right"]),
            (&"failed".into(), &false.into())
        );
        assert_eq!(failed["error"], "tile: <no light>");
        assert!(failed["true_closed"].is_null());
    }
}
