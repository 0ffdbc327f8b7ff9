//! `self-test.json`: a self-test for programs, its keys in a fixed order.

use seidel_core::trial::{Rate, Scores};
use serde::Serialize;

use super::{Aim, Bound, SelfTest, TOLD, Tested, Withheld};

const FORMAT: &str = "gap-self-test";
const VERSION: u32 = 1;

#[derive(Serialize)]
struct File {
    format: &'static str,
    version: u32,
    program: &'static str,
    seed: u64,
    count: usize,
    size: SizeFile,
    right: usize,
    failed: usize,
    aims: Vec<AimFile>,
    scores: Scores,
    withheld_unexplained: Option<Rate>,
    cases: Vec<CaseFile>,
}

#[derive(Serialize)]
struct SizeFile {
    design: usize,
    real: usize,
    holdout: usize,
    tile: usize,
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
struct CaseFile {
    index: usize,
    recipe: String,
    kind: String,
    effects: Vec<String>,
    unknown: Option<String>,
    gap: f64,
    right: bool,
    verdict: String,
    added: Vec<String>,
    top: Vec<CauseFile>,
    /// Null where nothing could be said.
    claimed_closed: Option<f64>,
    true_closed: Option<f64>,
    seconds: f64,
    error: Option<String>,
    withheld: Option<WithheldFile>,
}

#[derive(Serialize)]
struct CauseFile {
    effect: String,
    probability: f64,
}

#[derive(Serialize)]
struct WithheldFile {
    verdict: String,
    added: Vec<String>,
    seconds: f64,
    error: Option<String>,
}

/// The self-test as JSON text with a final newline.
pub fn json(test: &SelfTest) -> String {
    let file = File {
        format: FORMAT,
        version: VERSION,
        program: concat!("seidel ", env!("CARGO_PKG_VERSION")),
        seed: test.seed,
        count: test.cases.len(),
        size: SizeFile {
            design: test.size.design,
            real: test.size.real,
            holdout: test.size.holdout,
            tile: test.size.tile,
        },
        right: test.right(),
        failed: test.failed(),
        aims: test.aims().iter().map(aim).collect(),
        scores: test.scores(),
        withheld_unexplained: test.withheld_unexplained(),
        cases: test.cases.iter().enumerate().map(case).collect(),
    };
    serde_json::to_string_pretty(&file).expect("a self-test is plain JSON") + "\n"
}

fn aim(aim: &Aim) -> AimFile {
    let (at_least, at_most) = match aim.bound {
        Some(Bound::AtLeast(v)) => (Some(v), None),
        Some(Bound::AtMost(v)) => (None, Some(v)),
        None => (None, None),
    };
    AimFile {
        key: aim.key,
        value: aim.value(),
        of: aim.of(),
        at_least,
        at_most,
        met: aim.met(),
    }
}

fn case((index, tested): (usize, &Tested)) -> CaseFile {
    let o = &tested.outcome;
    let said = tested.failure.is_none();
    CaseFile {
        index,
        recipe: tested.truth(),
        kind: o.answer.kind.clone(),
        effects: o.answer.effects.clone(),
        unknown: o.answer.unknown.clone(),
        gap: o.answer.gap,
        right: tested.is_right(),
        verdict: o.verdict.clone(),
        added: o.added.clone(),
        top: o.ranked.iter().take(TOLD).map(cause).collect(),
        claimed_closed: said.then_some(o.claimed_closed),
        true_closed: said.then_some(o.true_closed),
        seconds: o.seconds,
        error: tested.failure.clone(),
        withheld: tested.withheld.as_ref().map(withheld),
    }
}

fn cause((effect, probability): &(String, f64)) -> CauseFile {
    CauseFile {
        effect: effect.clone(),
        probability: *probability,
    }
}

fn withheld(w: &Withheld) -> WithheldFile {
    WithheldFile {
        verdict: w.verdict.clone(),
        added: w.added.clone(),
        seconds: w.seconds,
        error: w.failure.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::made::self_test;
    use super::*;
    use serde_json::Value;

    #[test]
    fn every_case_stands_in_it_the_failed_ones_too() {
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
