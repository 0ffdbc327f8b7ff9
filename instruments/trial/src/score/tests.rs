//! Scores of hand-written outcomes.

use std::collections::BTreeMap;

use super::outcome::Odds;
use super::{Outcome, Setting, scores};
use crate::case::Answer;

fn strings(ids: &[&str]) -> Vec<String> {
    ids.iter().map(|&id| id.to_owned()).collect()
}

fn outcome(kind: &str, truth: &[&str], verdict: &str, ranked: &[(&str, f64)]) -> Outcome {
    Outcome {
        answer: Answer {
            kind: kind.to_owned(),
            effects: strings(truth),
            unknown: (kind == "unknown").then(|| "ghost".to_owned()),
            parameters: BTreeMap::new(),
            gap: if kind == "none" { 0.0 } else { 0.1 },
        },
        setting: Setting {
            simulator: "third_order".to_owned(),
            distances: 2,
        },
        verdict: verdict.to_owned(),
        added: Vec::new(),
        ranked: ranked.iter().map(|(c, p)| ((*c).to_owned(), *p)).collect(),
        equivalents: Vec::new(),
        claimed_closed: 0.9,
        true_closed: 0.8,
        seconds: 2.0,
        cpu_seconds: Some(3.0),
    }
}

#[test]
fn causes_count_by_rank_and_classes_only_where_data_cannot_tell() {
    let ranked = [("motion", 0.6), ("diffraction", 0.3), ("decentre", 0.1)];
    let right = outcome("single", &["motion"], "explained", &ranked);
    let third = outcome("single", &["decentre"], "explained", &ranked);
    let mut by_class = third.clone();
    by_class.verdict = "ambiguous".to_owned();
    by_class.equivalents = vec![strings(&["motion", "decentre"])];
    let mut by_crowd = by_class.clone();
    by_crowd.equivalents = vec![strings(&["motion", "decentre", "distortion", "vignetting"])];
    let denied = outcome("single", &["motion"], "no_gap", &ranked);
    let s = scores(&[right, third, by_class, by_crowd, denied]);
    let rates = &s.rates;
    assert_eq!((rates.single_top1.held, rates.single_top1.of), (1, 5));
    assert_eq!(rates.single_in_class.held, 2);
    assert_eq!(
        (rates.single_top3.held, rates.single_top3.share),
        (4, Some(0.8))
    );
    assert_eq!(s.closed_median.of, 1);
    assert_eq!(s.confusion["decentre"]["motion"], 3);
    assert_eq!(s.confusion["motion"]["none"], 1);
    assert_eq!(s.pair_f1.value, None);
}

#[test]
fn focus_and_distance_are_one_at_one_distance() {
    let ranked = [("depth_scale", 0.5), ("defocus_offset", 0.45)];
    let mut named = outcome("single", &["defocus_offset"], "ambiguous", &ranked);
    named.added = strings(&["depth_scale"]);
    named.equivalents = vec![strings(&["depth_scale", "defocus_offset"])];
    named.setting.distances = 1;
    let mut two_distances = named.clone();
    two_distances.setting.distances = 2;
    let mut certain = named.clone();
    certain.verdict = "explained".to_owned();
    let mut other = named.clone();
    other.equivalents = vec![strings(&["depth_scale", "anamorphic"])];
    // A third member may come first.
    let mut crowded = named.clone();
    crowded.ranked.insert(0, ("anamorphic".to_owned(), 0.5));
    crowded.equivalents[0].push("anamorphic".to_owned());
    let s = scores(&[named.clone(), two_distances, certain, other, crowded]);
    assert_eq!(
        (s.rates.single_top1.held, s.rates.single_exact.held),
        (2, 2)
    );
    assert_eq!(s.breakdown.distances["1"].single_top1.of, 4);
    assert_eq!(s.breakdown.distances["2"].single_top1.held, 0);
    // The printed probability is that of the added effect alone.
    let odds = named.answer_odds().expect("an answer");
    assert_eq!((odds.probability, odds.right), (0.5, false));
}

#[test]
fn pairs_need_both_and_triples_two() {
    let ranked = [("motion", 0.5)];
    let mut both = outcome("pair", &["motion", "decentre"], "explained", &ranked);
    both.added = strings(&["decentre", "motion"]);
    let mut one = both.clone();
    one.added = strings(&["motion"]);
    // One addition cannot count for both.
    one.equivalents = vec![strings(&["motion", "decentre"])];
    let mut three = outcome(
        "triple",
        &["motion", "decentre", "distortion"],
        "explained",
        &ranked,
    );
    three.added = both.added.clone();
    let mut two = three.clone();
    two.added = strings(&["motion"]);
    let mut classed = two.clone();
    classed.verdict = "ambiguous".to_owned();
    classed.equivalents = vec![strings(&["distortion", "anamorphic"])];
    let s = scores(&[both, one, three, two, classed]);
    assert_eq!((s.rates.pair_both.held, s.rates.pair_both.of), (1, 2));
    assert_eq!((s.rates.triple_two.held, s.rates.triple_two.of), (2, 3));
    let f1 = s.pair_f1.value.expect("two pairs");
    assert!((f1 - (1.0 + 2.0 / 3.0) / 2.0).abs() < 1e-12, "{f1}");
    assert_eq!(s.confusion["decentre+motion"]["decentre+motion"], 1);
    let error = s.closed_error.value.expect("all added");
    assert!((error - 0.1).abs() < 1e-12, "{error}");
}

#[test]
fn exact_answers_add_nothing_else() {
    let ranked = [("motion", 0.9)];
    let mut right = outcome("single", &["motion"], "explained", &ranked);
    right.added = strings(&["motion"]);
    let mut more = right.clone();
    more.added = strings(&["motion", "decentre"]);
    let s = scores(&[right, more]);
    assert_eq!(
        (s.rates.single_exact.held, s.rates.single_top1.held),
        (1, 2)
    );
}

#[test]
fn odds_are_those_of_the_answer() {
    let ranked = [("motion", 0.5), ("decentre", 0.45), ("unknown", 0.05)];
    let mut both = outcome("pair", &["motion", "decentre"], "explained", &ranked);
    both.added = strings(&["decentre", "motion"]);
    let mut too_many = both.clone();
    too_many.answer = outcome("single", &["motion"], "", &[]).answer;
    let mut given_up = both.clone();
    given_up.verdict = "unexplained".to_owned();
    let odds: Vec<Odds> = [&both, &too_many, &given_up]
        .map(|o| o.answer_odds().expect("an answer"))
        .into();
    let expected = [(0.95, true), (0.95, false), (0.05, false)];
    for (odds, (probability, right)) in odds.iter().zip(expected) {
        assert_eq!((odds.probability, odds.right), (probability, right));
    }
    for verdict in ["no_gap", "model_too_simple"] {
        let silent = outcome("pair", &["motion"], verdict, &ranked);
        assert_eq!(silent.answer_odds(), None);
    }
    let s = scores(&[both]);
    let [answer, first] = [s.calibration_error, s.calibration_error_first].map(|m| m.value);
    assert!((answer.expect("one") - 0.05).abs() < 1e-12);
    assert!((first.expect("one") - 0.5).abs() < 1e-12);
}

#[test]
fn alarms_unknowns_and_poor_models_are_counted() {
    let quiet = outcome("none", &[], "no_gap", &[("motion", 0.99)]);
    let alarm = outcome("none", &[], "explained", &[("motion", 0.99)]);
    let honest = outcome("unknown", &[], "unexplained", &[("unknown", 1.0)]);
    let mut fooled = outcome("unknown", &[], "explained", &[("motion", 0.7)]);
    fooled.added = strings(&["motion"]);
    let doubted = outcome("too_simple", &[], "model_too_simple", &[("motion", 0.9)]);
    let certified = outcome("too_simple", &[], "no_gap", &[("motion", 0.9)]);
    let s = scores(&[quiet, alarm, honest, fooled, doubted, certified]);
    let rates = &s.rates;
    assert_eq!((rates.false_alarms.held, rates.false_alarms.of), (1, 2));
    assert_eq!(
        (rates.unknown_unexplained.held, rates.unknown_first.held),
        (1, 1)
    );
    assert_eq!(
        (rates.too_simple_found.held, rates.too_simple_found.of),
        (1, 2)
    );
    // One is right at 1, the other wrong at 0.7; cases without a gap do not count.
    let error = s.calibration_error.value.expect("two outcomes");
    assert!((error - 0.35).abs() < 1e-12, "{error}");
    assert_eq!(s.calibration_error.of, 2);
    assert_eq!((s.calibration[14].count, s.calibration[10].count), (1, 1));
    assert_eq!(s.confusion["unknown"]["unknown"], 1);
    assert_eq!(s.confusion["too_simple"]["too_simple"], 1);
    assert_eq!(s.seconds_median.value, Some(2.0));
}

#[test]
fn rates_are_broken_down_by_conditions() {
    let ranked = [("motion", 0.9)];
    let right = outcome("single", &["motion"], "explained", &ranked);
    let mut weak = right.clone();
    weak.answer.gap = 0.01;
    weak.verdict = "no_gap".to_owned();
    weak.cpu_seconds = Some(13.0);
    let quiet = outcome("none", &[], "no_gap", &[]);
    let s = scores(&[right, weak, quiet]);
    let b = &s.breakdown;
    assert_eq!(b.simulator["third_order"].single_top1.of, 2);
    assert_eq!(b.strength["weak"].single_top1.held, 0);
    assert_eq!(b.strength["strong"].single_top1.held, 1);
    assert_eq!(b.strength.len(), 2);
    let p90 = s.cpu_seconds_p90.value.expect("three times");
    assert!((p90 - 11.0).abs() < 1e-9, "{p90}");
    assert_eq!(s.cpu_seconds_median.value, Some(3.0));
}

#[test]
fn no_outcomes_give_no_figures() {
    let s = scores(&[]);
    assert_eq!(s.rates.single_top1.share, None);
    assert_eq!(s.calibration_error.value, None);
    assert_eq!(s.seconds_longest.value, None);
    // A failed diagnosis names nothing and is never right.
    let failed = scores(&[outcome("unknown", &[], "failed", &[])]);
    assert_eq!(failed.confusion["unknown"]["failed"], 1);
    assert_eq!(failed.rates.unknown_unexplained.held, 0);
    let text = serde_json::to_string(&s).expect("plain values");
    assert!(text.contains("confusion") && text.contains("\"single_top1\""));
}
