//! Diagnosis of the gap between a simulated and a real lens: every effect alone is identified, nothing is found where
//! nothing is missing, and the open cases of other simulators are solved.

use std::fs;
use std::path::Path;

use seidel_calibrate::diagnose::diagnose;
use seidel_calibrate::fit::fit_pupil;
use seidel_core::fitting::{PupilModel, PupilSettings};
use seidel_core::profile::Provenance;
use seidel_core::{
    Diagnosis, DiagnosisSettings, LensProfile, ObservationSet, Predictor, Verdict, no_progress,
};
use seidel_image_io::observation_set;
use seidel_optics::effects;
use seidel_optics::predict::predict_set;
use seidel_trial::{Conditions, Kind, Recipe, Simulator, Size};
use serde_json::Value;

use crate::support::{real_data, succeeds};

/// Small enough for all effects to take a minute or two.
const SIZE: Size = Size {
    design: 16,
    real: 10,
    holdout: 2,
    tile: 25,
};

/// Diagnoses with the effects of `library`, all where it is empty.
fn diagnosed(lens: &LensProfile, real: &ObservationSet, library: &[&str]) -> Diagnosis {
    let settings = DiagnosisSettings {
        pairs: false,
        library: library.iter().map(|id| (*id).to_owned()).collect(),
        ..DiagnosisSettings::default()
    };
    diagnose(lens, real, &settings, &no_progress).expect("a sound set")
}

/// Returns the recipe of a case of `kind` under conditions that show every effect.
fn recipe(kind: Kind, seed: u64) -> Recipe {
    recipe_of_size(SIZE, kind, seed)
}

fn recipe_of_size(size: Size, kind: Kind, seed: u64) -> Recipe {
    let drawn = Recipe::new(kind, Simulator::ThirdOrder, seed, Some(size));
    Recipe {
        conditions: Conditions {
            distances: 2,
            snr: 200.0,
            noise_stated: true,
            ideal_positions: true,
            strength: 0.7,
            ..drawn.conditions
        },
        ..drawn
    }
}

/// Settings of the fits of lenses to their designs, which have no effects of higher order.
fn reduced() -> PupilSettings {
    PupilSettings {
        model: PupilModel::Reduced,
        ..PupilSettings::default()
    }
}

/// Fits a case of `kind` and diagnoses it with `library`, without its answer.
fn blind(kind: Kind, seed: u64, library: &[&str]) -> Diagnosis {
    let case = seidel_trial::draw(&recipe(kind, seed));
    let fit = fit_pupil(&[case.design], &reduced(), &no_progress).expect("a sound design");
    diagnosed(&fit.lens, &case.real, library)
}

/// Lenses fitted to designs. Cases of one seed have the same design, whose fit takes longer than the diagnosis.
#[derive(Default)]
struct Fits(Vec<(ObservationSet, LensProfile)>);

impl Fits {
    fn lens(&mut self, design: ObservationSet) -> LensProfile {
        if let Some((_, lens)) = self.0.iter().find(|(known, _)| *known == design) {
            return lens.clone();
        }
        let fit = fit_pupil(std::slice::from_ref(&design), &reduced(), &no_progress);
        let lens = fit.expect("a sound design").lens;
        self.0.push((design, lens.clone()));
        lens
    }
}

#[test]
fn every_effect_alone_is_identified() {
    let mut fits = Fits::default();
    let ids: Vec<&str> = effects::causes().map(|effect| effect.id()).collect();
    // Each with the half of the effects that follow it in a circle, so that every two meet, where the one or the other is planted.
    let library = |index: usize| -> Vec<&str> {
        let circle = ids.iter().cycle().skip(index);
        circle.take(ids.len() / 2 + 1).copied().collect()
    };
    let missed: Vec<String> = effects::causes()
        .enumerate()
        .filter_map(|(index, effect)| {
            let kind = Kind::Single(effect.id());
            let size = Size { real: 8, ..SIZE };
            let mut recipe = recipe_of_size(size, kind, 7000 + index as u64 % 3);
            if effect.id() == "focus_error" {
                // At two distances it is an offset and another scale of distances.
                recipe.conditions.distances = 3;
            }
            let case = seidel_trial::draw(&recipe);
            let found = diagnosed(&fits.lens(case.design), &case.real, &library(index));
            let named = found.verdict == Verdict::Explained && found.added == [effect.id()];
            let proved = found.gap.closed > 0.9;
            let report = format!(
                "{}: {} {:?}, closed {:.3}",
                effect.id(),
                found.verdict.id(),
                found.added,
                found.gap.closed
            );
            (!named || !proved).then_some(report)
        })
        .collect();
    assert!(missed.is_empty(), "{}", missed.join("; "));
}

/// A lens that was fitted at one distance has no law by which wrong distances could act.
#[test]
fn at_one_distance_wrong_distances_are_named_beside_a_focus_offset() {
    let recipe = |kind| {
        let two = recipe(kind, 7300);
        Recipe {
            conditions: Conditions {
                distances: 1,
                ..two.conditions
            },
            ..two
        }
    };
    let found = |kind| {
        let case = seidel_trial::draw(&recipe(kind));
        let fit = fit_pupil(&[case.design], &reduced(), &no_progress);
        let lens = fit.expect("a sound design").lens;
        let library = ["defocus_offset", "depth_scale", "sensor_tilt"];
        diagnosed(&lens, &case.real, &library)
    };
    let either = found(Kind::Single("depth_scale"));
    assert_eq!(either.verdict, Verdict::Ambiguous, "{:?}", either.added);
    assert_eq!(either.added, ["defocus_offset"], "the one that acts");
    assert!(either.gap.closed > 0.9, "{:?}", either.gap);
    let mut class = either.equivalents[0].clone();
    class.sort_unstable();
    assert_eq!(class, ["defocus_offset", "depth_scale"]);
    // The size of the image tells.
    let focus = found(Kind::Single("defocus_offset"));
    assert_eq!(focus.verdict, Verdict::Explained, "{:?}", focus.causes);
    assert_eq!(focus.added, ["defocus_offset"]);
}

#[test]
fn nothing_is_found_where_nothing_is_missing() {
    let found = blind(
        Kind::None,
        7100,
        &["defocus_offset", "motion", "decentre", "vignetting"],
    );
    assert_eq!(found.verdict, Verdict::NoGap);
    assert!(found.added.is_empty() && found.no_gap_probability > 0.9);
}

#[test]
fn a_model_that_is_too_simple_is_to_blame() {
    let case = seidel_trial::draw(&recipe(Kind::Single("decentre"), 7003));
    // The lens is fitted to its decentred copy itself, by a symmetric model.
    let fit = fit_pupil(std::slice::from_ref(&case.real), &reduced(), &no_progress);
    let lens = fit.expect("a sound set").lens;
    // A lens that kept nothing aside does not know its own gap. (One that does is a case of the self-test.)
    let all = LensProfile {
        held_out: None,
        provenance: Provenance {
            settings: Provenance::NONE_HELD_OUT.to_owned(),
            ..lens.provenance.clone()
        },
        ..lens
    };
    let settings = DiagnosisSettings::default();
    let error = diagnose(&all, &case.real, &settings, &no_progress).expect_err("no own gap");
    assert!(error.to_string().contains("give the set"), "{error}");
    let settings = DiagnosisSettings {
        library: vec!["defocus_offset".to_owned(), "motion".to_owned()],
        pairs: false,
        design: Some(case.real.clone()),
        ..settings
    };
    let found = diagnose(&all, &case.real, &settings, &no_progress).expect("a sound set");
    assert_eq!(found.verdict, Verdict::ModelTooSimple, "{:?}", found.model);
    assert!(found.added.is_empty() && found.model.own_gap > 0.005);
    assert!(
        found.model.freedom.contains(&"decentre"),
        "{:?}",
        found.model
    );
    assert!(found.shares.model > 2.0 * found.shares.change);
}

#[test]
fn a_cause_outside_the_library_is_unexplained() {
    let found = blind(
        Kind::Unknown("central_obstruction"),
        7200,
        &["apodisation", "tone_curve", "vignetting", "defocus_offset"],
    );
    assert_eq!(found.verdict, Verdict::Unexplained, "{:?}", found.added);
    assert!(!found.residual.is_empty());
    assert_eq!(found.causes[0].effect, "unknown");
}

/// Mean over tiles of |o - p|² / |o|², unit sums, less noise.
fn gap(observed: &ObservationSet, lens: &LensProfile) -> f64 {
    let lens = Predictor::new(lens).expect("a sound lens");
    let predicted = predict_set(&lens, observed, lens.default_model()).expect("its own frame");
    let pairs = observed.observations.iter().zip(&predicted.observations);
    let gaps: Vec<f64> = pairs
        .flat_map(|(o, p)| {
            (0..o.tiles.len()).map(move |channel| {
                let light = o.light(channel);
                let sum = light.sum();
                let unit = light.samples().iter().map(|v| f64::from(*v) / sum);
                let norm: f64 = unit.clone().map(|v| v * v).sum();
                let tile = p.tiles[channel].samples();
                let apart: f64 = unit
                    .zip(tile)
                    .map(|(o, p)| (o - f64::from(*p)).powi(2))
                    .sum();
                let sigma = o.noise_sigma[channel].unwrap_or(0.0) / sum;
                (apart - tile.len() as f64 * sigma * sigma) / norm
            })
        })
        .collect();
    gaps.iter().sum::<f64>() / gaps.len() as f64
}

#[test]
fn open_cases_of_other_simulators_are_right() {
    let Some(cases) = real_data("gap") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let mut names: Vec<_> = fs::read_dir(&cases)
        .expect("the cases' folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.join("truth.json").is_file())
        .collect();
    names.sort();
    assert!(!names.is_empty(), "no case in {}", cases.display());
    for case in names {
        check(folder.path(), &case);
    }
}

/// Copies every second observation of the set at `from` to `to`: enough for these cases, in half the time.
fn halve(from: &Path, to: &Path) {
    let read = observation_set::read(from, Default::default()).expect("a sound set");
    let mut set = read.set;
    let all = std::mem::take(&mut set.observations);
    set.observations = all.into_iter().step_by(2).collect();
    observation_set::write(&set, to).expect("writable");
}

fn check(folder: &Path, case: &Path) {
    let name = case.file_name().expect("a name").to_string_lossy();
    for set in ["design", "real"] {
        halve(&case.join(set), &folder.join(format!("{name}-{set}")));
    }
    succeeds(folder, &format!("fit @{name}-design -o @{name}.json"));
    let like = "defocus_offset,decentre,motion,vignetting,sensor_tilt,pixel_footprint,higher_order";
    let line =
        format!("diagnose --lens @{name}.json @{name}-real --only {like} --no-pairs --out @{name}");
    succeeds(folder, &line);
    let read = |path: &Path| fs::read_to_string(path).expect("written");
    let report: Value = serde_json::from_str(&read(&folder.join(&*name).join("report.json")))
        .expect("a JSON report");
    // Values that could not be computed are NaN in the file, which is not valid JSON.
    let answer = read(&case.join("truth.json")).replace("NaN", "null");
    let truth: Value = serde_json::from_str(&answer).expect("an answer");
    if truth["class"] == "none" {
        assert_eq!(report["verdict"], "no_gap", "{name}");
        return;
    }
    assert_eq!(report["verdict"], "explained", "{name}");
    assert_eq!(report["added"], truth["effects"], "{name}");
    // The claimed gap, on points held out from the diagnosis.
    let lens = |path: &Path| LensProfile::from_json(&read(path)).expect("a profile");
    let holdout = observation_set::read(&case.join("holdout"), Default::default())
        .expect("a sound set")
        .set;
    let before = gap(&holdout, &lens(&folder.join(format!("{name}.json"))));
    let after = gap(&holdout, &lens(&folder.join(&*name).join("corrected.json")));
    let (closed, claimed) = (1.0 - after / before, &report["gap"]["closed"]);
    assert!(closed > 0.98, "{name}: {closed}");
    let claimed = claimed.as_f64().expect("a number");
    assert!(
        (claimed - closed).abs() < 0.05,
        "{name}: {claimed} {closed}"
    );
}
