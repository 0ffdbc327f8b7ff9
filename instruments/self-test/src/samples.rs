//! A self-test as test data: right and wrong cases of every kind, and one that failed.

use std::collections::BTreeMap;

use seidel_trial::{Answer, Kind, Outcome, Recipe, Selection, Setting, Simulator};

use crate::results::{AdvisedResult, CaseResult, FAILED, SelfTest, WithheldResult};

fn strings(ids: &[&str]) -> Vec<String> {
    ids.iter().map(|&id| id.to_owned()).collect()
}

fn case(
    kind: &str,
    truth: &[&str],
    verdict: &str,
    added: &[&str],
    ranked: &[(&str, f64)],
) -> CaseResult {
    let unknown = kind == "unknown";
    CaseResult {
        index: 0,
        recipe: Recipe::new(Kind::None, Simulator::ThirdOrder, 1, None),
        outcome: Outcome {
            answer: Answer {
                kind: kind.to_owned(),
                effects: if unknown { vec![] } else { strings(truth) },
                unknown: unknown.then(|| truth[0].to_owned()),
                parameters: BTreeMap::new(),
                gap: if kind == "none" { 0.0 } else { 0.12 },
            },
            setting: Setting {
                simulator: Simulator::ThirdOrder.id().to_owned(),
                distances: 2,
            },
            verdict: verdict.to_owned(),
            added: strings(added),
            ranked: ranked.iter().map(|(c, p)| ((*c).to_owned(), *p)).collect(),
            equivalents: Vec::new(),
            claimed_closed: if added.is_empty() { 0.0 } else { 0.95 },
            true_closed: if added.is_empty() { 0.0 } else { 0.91 },
            seconds: 12.5,
            cpu_seconds: Some(20.0),
        },
        own_gap: Some(0.0004),
        detection_limit: Some(0.002),
        error: None,
        withheld: None,
        advised: None,
        fit_cpu_seconds: Some(4.0),
    }
}

fn withheld(verdict: &str, added: &[&str]) -> Option<WithheldResult> {
    Some(WithheldResult {
        verdict: verdict.to_owned(),
        added: strings(added),
        seconds: 9.0,
        error: None,
    })
}

fn advised(capture: &'static str, settled: Option<bool>) -> Option<AdvisedResult> {
    Some(AdvisedResult {
        capture,
        verdict: settled.map(|_| "explained".to_owned()),
        added: Vec::new(),
        settled,
    })
}

/// Returns twelve cases, of which the second, fourth, sixth, eighth, ninth and last are wrong.
pub(crate) fn self_test() -> SelfTest {
    let first = [
        ("vignetting", 0.94),
        ("higher_order", 0.03),
        ("unknown", 0.02),
        ("tone_curve", 0.01),
    ];
    let mut cases = vec![
        case(
            "single",
            &["vignetting"],
            "explained",
            &["vignetting"],
            &first,
        ),
        case(
            "single",
            &["higher_order"],
            "explained",
            &["vignetting"],
            &first,
        ),
        case(
            "pair",
            &["motion", "decentre"],
            "explained",
            &["decentre", "motion"],
            &[("motion", 0.5), ("decentre", 0.4)],
        ),
        case(
            "pair",
            &["motion", "vignetting"],
            "explained",
            &["vignetting"],
            &first,
        ),
        case(
            "none",
            &[],
            "no_gap",
            &[],
            &[("unknown", 0.4), ("motion", 0.3)],
        ),
        case(
            "none",
            &[],
            "explained",
            &["apodisation"],
            &[("apodisation", 0.7)],
        ),
        case(
            "unknown",
            &["ghost"],
            "unexplained",
            &[],
            &[("unknown", 0.99)],
        ),
        case(
            "unknown",
            &["trefoil"],
            "explained",
            &["decentre"],
            &[("decentre", 0.8)],
        ),
        case("single", &["sensor_tilt"], FAILED, &[], &[]),
        case(
            "triple",
            &["motion", "decentre", "vignetting"],
            "unexplained",
            &["motion", "decentre"],
            &[("motion", 0.5), ("decentre", 0.4)],
        ),
        case("too_simple", &[], "model_too_simple", &[], &first),
        case(
            "too_simple",
            &[],
            "no_gap",
            &[],
            &[("unknown", 0.4), ("motion", 0.3)],
        ),
    ];
    for (index, case) in cases.iter_mut().enumerate() {
        case.index = index;
    }
    cases[8].error = Some("tile: <no light>".to_owned());
    cases[0].withheld = withheld("unexplained", &["higher_order"]);
    cases[1].withheld = withheld("explained", &["vignetting"]);
    cases[3].advised = advised("more_places", Some(true));
    cases[5].advised = advised("second_distance", Some(false));
    cases[7].advised = advised("two_stops_down", None);
    cases[8].withheld = Some(WithheldResult {
        verdict: FAILED.to_owned(),
        added: Vec::new(),
        seconds: 0.0,
        error: Some("the lens could not be fitted".to_owned()),
    });
    SelfTest {
        selection: Selection {
            count: cases.len(),
            seed: 7,
            only: None,
            size: None,
        },
        cases,
        withhold: true,
    }
}
