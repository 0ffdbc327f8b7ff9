//! `self-test.json`: a self-test for programs, with keys in a fixed order.

use seidel_trial::{Rate, Scores, Size};
use serde::Serialize;

use super::aims::{Aim, Bound};
use super::results::{CaseResult, SelfTest, WithheldResult};

const FORMAT: &str = "gap-self-test";
const VERSION: u32 = 1;
/// Causes listed per case.
const TOP_CAUSES: usize = 3;

#[derive(Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    seed: u64,
    count: usize,
    size: Size,
    right: usize,
    failed: usize,
    aims: Vec<AimFile>,
    scores: Scores,
    withheld_unexplained: Option<Rate>,
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
    gap: f64,
    right: bool,
    verdict: &'a str,
    added: &'a [String],
    top: Vec<CauseFile<'a>>,
    /// Null where there is no diagnosis.
    claimed_closed: Option<f64>,
    true_closed: Option<f64>,
    seconds: f64,
    error: Option<&'a str>,
    withheld: Option<&'a WithheldResult>,
}

#[derive(Serialize)]
struct CauseFile<'a> {
    effect: &'a str,
    probability: f64,
}

/// Returns the self-test as JSON text with a final newline.
pub(super) fn json(test: &SelfTest) -> String {
    let file = File {
        format: FORMAT,
        version: VERSION,
        program: concat!("seidel ", env!("CARGO_PKG_VERSION")),
        seed: test.seed,
        count: test.cases.len(),
        size: test.size,
        right: test.right(),
        failed: test.failed(),
        aims: test.aims().iter().map(AimFile::new).collect(),
        scores: test.scores(),
        withheld_unexplained: test.withheld_unexplained(),
        cases: (0..)
            .zip(&test.cases)
            .map(|(index, result)| CaseFile::new(index, result))
            .collect(),
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
    fn new(index: usize, result: &'a CaseResult) -> Self {
        let o = &result.outcome;
        let diagnosed = result.error.is_none();
        let top = o.ranked.iter().take(TOP_CAUSES);
        Self {
            index,
            recipe: result.truth(),
            kind: &o.answer.kind,
            effects: &o.answer.effects,
            unknown: o.answer.unknown.as_deref(),
            gap: o.answer.gap,
            right: result.is_right(),
            verdict: &o.verdict,
            added: &o.added,
            top: top
                .map(|(effect, probability)| CauseFile {
                    effect,
                    probability: *probability,
                })
                .collect(),
            claimed_closed: diagnosed.then_some(o.claimed_closed),
            true_closed: diagnosed.then_some(o.true_closed),
            seconds: o.seconds,
            error: result.error.as_deref(),
            withheld: result.withheld.as_ref(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::self_test;
    use super::*;
    use serde_json::Value;

    #[test]
    fn every_case_is_listed_failed_ones_included() {
        let text = json(&self_test());
        let file: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(file["format"], "gap-self-test");
        assert_eq!((&file["version"], &file["seed"]), (&1.into(), &7.into()));
        assert_eq!((&file["count"], &file["right"]), (&9.into(), &4.into()));
        assert_eq!(file["withheld_unexplained"]["of"], 3);
        assert_eq!(file["aims"][0]["at_least"], 0.9);
        assert_eq!(file["scores"]["single_top1"]["held"], 1);
        let cases = file["cases"].as_array().expect("a list");
        assert_eq!(cases.len(), 9);
        assert_eq!(cases[0]["top"].as_array().map(Vec::len), Some(3));
        assert_eq!(cases[0]["withheld"]["added"][0], "higher_order");
        assert_eq!(cases[6]["recipe"], "unknown: ghost");
        let failed = &cases[8];
        assert_eq!(
            (&failed["verdict"], &failed["right"]),
            (&"failed".into(), &false.into())
        );
        assert_eq!(failed["error"], "tile: <no light>");
        assert!(failed["true_closed"].is_null());
    }
}
