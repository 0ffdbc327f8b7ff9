//! The self-test of the diagnosis: small cases are diagnosed correctly, and all of them are reported.

use std::fs;

use clap::Parser as _;
use seidel::{Console, ProgressOutput};
use seidel_trial::{KindClass, Selection, Size};
use serde_json::Value;

use crate::SelfTestArgs;
use crate::results::SelfTest;
use crate::runner::{self, Observer, Plan};

/// Fewer places than the command's cases have, to save time.
const SMALL: Size = Size {
    design: 16,
    real: 10,
    holdout: 4,
    tile: 25,
};

/// The effects of the cases and their look-alikes; the whole library would take minutes.
const LIBRARY: [&str; 8] = [
    "veiling_glare",
    "sensor_tilt",
    "decentre",
    "pixel_footprint",
    "motion",
    "defocus_offset",
    "tone_curve",
    "anamorphic",
];

/// Returns a plan of small cases.
fn plan(count: usize, seed: u64, only: Option<KindClass>) -> Plan {
    Plan {
        selection: Selection {
            count,
            seed,
            only,
            size: Some(SMALL),
        },
        only_case: None,
        library: LIBRARY.map(str::to_owned).to_vec(),
        withhold: false,
    }
}

/// Runs `plan` and checks that the observer gets every case.
fn run(plan: &Plan) -> SelfTest {
    let mut finished = Vec::new();
    let mut observer = Observer {
        progress: &seidel_core::no_progress,
        finished: &mut |result| finished.push(result.index),
    };
    let test = runner::run(plan, &mut observer);
    let run: Vec<usize> = test.cases.iter().map(|c| c.index).collect();
    assert_eq!(finished, run);
    test
}

/// Without ideal positions, lateral colour was neither placed well enough to be found, nor seen on the held-out places.
#[test]
fn what_closes_without_ideal_positions_closes_on_held_out_places() {
    let selection = Selection {
        count: 30,
        seed: 9602,
        only: Some(KindClass::Single),
        size: None,
    };
    let library = ["lateral_colour", "axial_colour", "defocus_offset"];
    let test = run(&Plan {
        selection,
        only_case: Some(6),
        library: library.map(str::to_owned).to_vec(),
        withhold: false,
    });
    let case = &test.cases[0];
    assert!(!case.recipe.conditions.ideal_positions);
    let found = &case.outcome;
    assert_eq!(found.answer.effects, ["lateral_colour"]);
    assert_eq!(found.verdict, "explained", "{found:?}");
    assert_eq!(found.added, found.answer.effects);
    assert!(found.true_closed > 0.9, "{found:?}");
    assert!(
        (found.claimed_closed - found.true_closed).abs() < 0.05,
        "{found:?}"
    );
}

/// Checks that `keys` are numbers; a value that is not finite is written as null.
fn numbers(of: &Value, keys: &[&str]) {
    for key in keys {
        assert!(of[key].is_number(), "{key} of {of}");
    }
}

#[test]
fn self_test() {
    let test = run(&plan(6, 60815, None));
    assert_eq!(test.cases.len(), 6);
    // One effect four times, two effects, an unknown cause.
    let outcomes: Vec<String> = test
        .cases
        .iter()
        .map(|c| format!("{}: {:?}", c.truth(), c.outcome))
        .collect();
    assert!(test.right() >= 5, "{}", outcomes.join("\n"));
    assert_eq!(test.failed(), 0, "{}", outcomes.join("\n"));

    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    crate::write(&out, &test).expect("writable");
    assert_eq!(fs::read_dir(&out).expect("a folder").count(), 1);
    let text = fs::read_to_string(out.join("self-test.json")).expect("there");
    assert!(!text.contains("NaN"), "{text}");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(report["format"], "gap-self-test");
    numbers(
        &report,
        &["version", "seed", "count", "run", "right", "failed"],
    );
    numbers(&report["size"], &["design", "real", "holdout", "tile"]);
    for key in ["single_top1", "pair_both", "unknown_unexplained"] {
        numbers(&report["scores"][key], &["held", "of", "share"]);
    }
    for key in [
        "closed_median",
        "closed_error",
        "calibration_error",
        "calibration_error_first",
    ] {
        numbers(&report["scores"][key], &["value", "of"]);
    }
    numbers(&report["advised_settled"], &["held", "of"]);
    assert_eq!(report["aims"].as_array().map(Vec::len), Some(16));
    let cases = report["cases"].as_array().expect("a list");
    assert_eq!(cases.len(), 6);
    for case in cases {
        numbers(
            case,
            &["index", "gap", "claimed_closed", "true_closed", "seconds"],
        );
        assert!(case["recipe"].is_string() && case["verdict"].is_string());
        assert!(case["right"].is_boolean() && case["error"].is_null());
        let top = case["top"].as_array().expect("a list");
        assert_eq!(top.len(), 3);
        top.iter()
            .for_each(|cause| numbers(cause, &["probability"]));
    }
}

#[test]
fn kinds_and_cases_can_be_selected() {
    let mut plan = plan(3, 7, Some(KindClass::TooSimple));
    plan.only_case = Some(1);
    // The model is to blame before any effect is.
    plan.library.truncate(2);
    let test = run(&plan);
    let [result] = &test.cases[..] else {
        panic!("one case was asked for, {} were run", test.cases.len());
    };
    assert_eq!(result.index, 1);
    assert_eq!(
        result.outcome.verdict,
        "model_too_simple",
        "{}",
        result.line()
    );
    assert!(result.is_right(), "{}", result.line());
}

/// Returns the options of a command line without the program's name.
fn args(line: &str) -> Result<SelfTestArgs, clap::Error> {
    SelfTestArgs::try_parse_from(
        ["seidel-self-test"]
            .into_iter()
            .chain(line.split_whitespace()),
    )
}

#[test]
fn invalid_command_lines_are_rejected() {
    for line in [
        "",
        "0",
        "many",
        "--seed 3",
        "3 --kind several",
        "3 --threads 1025",
    ] {
        assert!(args(line).is_err(), "{line}");
    }
    let beyond = args("3 --only-case 3").expect("valid").plan();
    assert_eq!(beyond.expect_err("there is none").exit_code(), 2);
}

#[test]
fn folders_with_other_files_are_refused_before_the_work() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("notes.txt"), "mine").expect("writable");
    let args = args(&format!("1 --out {}", folder.path().display())).expect("valid");
    let plan = args.plan().expect("valid");
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let mut console = Console {
        stdout: &mut stdout,
        stderr: &mut stderr,
        progress: ProgressOutput::hidden(),
    };
    let error = crate::run(&args, &plan, &mut console).expect_err("refused");
    assert!(error.to_string().contains("notes.txt"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
}
