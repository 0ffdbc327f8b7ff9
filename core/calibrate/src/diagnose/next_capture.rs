//! Recommendation of the next capture.

use super::capture::{Capture, SEPARATING};
use super::diagnosis::{Cause, Verdict};
use super::model_share::ModelShare;
use super::one_distance;
use seidel_optics::effects::{self, Effect};

/// The findings on which the next capture depends.
pub(super) struct Situation<'a> {
    pub(super) verdict: Verdict,
    pub(super) causes: &'a [Cause],
    pub(super) equivalents: &'a [Vec<&'static str>],
    pub(super) model: &'a ModelShare,
    /// Number of object distances of the observations.
    pub(super) distances: usize,
}

/// A recommended capture, with what each cause makes of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct NextCapture {
    pub(super) capture: Capture,
    pub(super) text: String,
}

impl NextCapture {
    fn new(capture: Capture, text: impl Into<String>) -> Self {
        Self {
            capture,
            text: text.into(),
        }
    }
}

/// Returns the capture that best distinguishes the remaining causes.
pub(super) fn next(situation: &Situation) -> NextCapture {
    match situation.verdict {
        Verdict::ModelTooSimple if situation.model.freedom.is_empty() => NextCapture::new(
            Capture::MorePlaces,
            format!(
                "{}, and fit the lens again: its model is too simple, and no richer one was found. Residuals of the lens's own set show what it cannot draw",
                Capture::MorePlaces.instruction()
            ),
        ),
        Verdict::ModelTooSimple => NextCapture::new(
            Capture::None,
            "none needed yet: fit the lens again with the extended model, then diagnose these observations with it",
        ),
        Verdict::NoGap | Verdict::Bookkeeping => NextCapture::new(
            Capture::None,
            "none needed: the lens explains these observations; PSFs at another distance or f-number would test it further",
        ),
        Verdict::Unexplained => unknown(),
        Verdict::Ambiguous => between(&rivals(situation)),
        Verdict::Explained => {
            let next = between(&rivals(situation));
            NextCapture::new(
                next.capture,
                format!("only to confirm the cause, {}", next.text),
            )
        }
    }
}

/// Returns the causes to distinguish: the class of the verdict, or the likeliest cause and its nearest rival.
fn rivals<'a>(situation: &Situation<'a>) -> Vec<&'a str> {
    let class = situation.equivalents.first();
    let mut named: Vec<&str> = class.into_iter().flatten().copied().collect();
    let likeliest = situation.causes.iter().map(|cause| cause.effect);
    // Rivals whatever their probabilities.
    let first = named.first().copied().or(likeliest.clone().next());
    let alike = one_distance::alike().find(|pair| first.is_some_and(|first| pair.contains(&first)));
    if let Some(pair) = alike.filter(|_| situation.distances == 1) {
        return pair.to_vec();
    }
    for id in likeliest.filter(|id| *id != "unknown") {
        if named.len() >= 2 {
            break;
        }
        if !named.contains(&id) {
            named.push(id);
        }
    }
    named
}

/// Returns the capture with the most different responses of the effects `ids`, the cheapest of several.
fn between(ids: &[&str]) -> NextCapture {
    let known = ids.iter().filter_map(|id| effects::by_id(id).ok());
    let rivals: Vec<&dyn Effect> = known.collect();
    if rivals.len() < ids.len().max(2) {
        return unknown();
    }
    let kinds = |capture: &Capture| {
        let responses: Option<Vec<&str>> = rivals.iter().map(|e| capture.response(*e)).collect();
        let mut kinds = responses.unwrap_or_default();
        kinds.sort_unstable();
        kinds.dedup();
        kinds.len()
    };
    let most = SEPARATING.iter().map(kinds).max().unwrap_or(0);
    let best = SEPARATING.iter().find(|capture| kinds(capture) == most);
    let (Some(capture), true) = (best, most > 1) else {
        let titles: Vec<&str> = rivals.iter().map(|e| e.description().title).collect();
        let capture = Capture::MorePlaces;
        return NextCapture::new(
            capture,
            format!(
                "{}, where {} differ most",
                capture.instruction(),
                titles.join(" and ")
            ),
        );
    };
    let responses = rivals.iter().filter_map(|effect| {
        let response = capture.response(*effect)?;
        Some(format!("with {}, {response}", effect.description().title))
    });
    let responses: Vec<String> = responses.collect();
    NextCapture::new(
        *capture,
        format!("{}: {}", capture.instruction(), responses.join("; ")),
    )
}

/// Returns the capture that tells lens, sensor and surroundings apart.
fn unknown() -> NextCapture {
    let capture = Capture::StoppedDownAndTurned;
    NextCapture::new(
        capture,
        format!(
            "{}: what shrinks with the stop lies in the pupil of the lens, what turns with the camera in lens or sensor, and what stays upright in the scene or the support",
            capture.instruction()
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::OwnGapSource;
    use crate::diagnose::cause_words;

    const MODEL: ModelShare = ModelShare {
        own_gap: 0.001,
        measured_on: OwnGapSource::HeldOut,
        freedom: Vec::new(),
        freedom_closes: 0.0,
    };

    fn cause(effect: &'static str, probability: f64) -> Cause {
        Cause {
            effect,
            probability,
            gap_closed: 0.9,
            gap_closed_ci95: [0.8, 0.95],
            amount: String::new(),
            parameters: Vec::new(),
        }
    }

    fn advised(verdict: Verdict, ids: &[&'static str], distances: usize) -> NextCapture {
        let causes: Vec<Cause> = ids.iter().map(|id| cause(id, 0.5)).collect();
        let class = match verdict {
            Verdict::Ambiguous => vec![ids.to_vec()],
            _ => Vec::new(),
        };
        next(&Situation {
            verdict,
            causes: &causes,
            equivalents: &class,
            model: &MODEL,
            distances,
        })
    }

    #[test]
    fn every_pair_of_effects_gets_a_capture_that_names_both_by_title() {
        for one in effects::causes().map(Effect::id) {
            for other in effects::causes().map(Effect::id).filter(|id| *id != one) {
                let text = between(&[one, other]).text;
                for id in [one, other] {
                    assert!(text.contains(cause_words(id).title), "{text}");
                    assert!(!id.contains('_') || !text.contains(id), "{text}");
                }
            }
        }
    }

    #[test]
    fn known_ambiguities_get_the_capture_that_settles_them() {
        for (ids, distances, capture) in [
            (
                ["defocus_offset", "depth_scale"],
                1,
                Capture::SecondDistance,
            ),
            (
                ["defocus_offset", "depth_scale"],
                4,
                Capture::SecondDistance,
            ),
            (["motion", "decentre"], 3, Capture::ShorterExposure),
            (["motion", "pixel_footprint"], 3, Capture::ShorterExposure),
            (
                ["pupil_scale", "aperture_polygon"],
                3,
                Capture::FarOutOfFocus,
            ),
            (["pupil_scale", "vignetting"], 3, Capture::FarOutOfFocus),
            (
                ["pupil_scale", "defocus_offset"],
                3,
                Capture::OtherSideOfFocus,
            ),
            (["diffraction", "pixel_footprint"], 3, Capture::TwoStopsDown),
            (["sensor_tilt", "decentre"], 3, Capture::TwoStopsDown),
            (
                ["veiling_glare", "pixel_footprint"],
                3,
                Capture::DarkSurround,
            ),
            (["distortion", "lateral_colour"], 3, Capture::MorePlaces),
            (["vignetting", "unknown"], 3, Capture::StoppedDownAndTurned),
        ] {
            for order in [[ids[0], ids[1]], [ids[1], ids[0]]] {
                let next = advised(Verdict::Ambiguous, &order, distances);
                assert_eq!(next.capture, capture, "{order:?}: {}", next.text);
            }
        }
    }

    #[test]
    fn at_one_distance_a_focus_offset_is_confirmed_by_a_second_one() {
        let ids = ["defocus_offset", "sensor_tilt", "depth_scale"];
        let next = advised(Verdict::Explained, &ids, 1);
        assert_eq!(next.capture, Capture::SecondDistance);
        assert!(next.text.starts_with("only to confirm"), "{}", next.text);
        let next = advised(Verdict::Explained, &ids, 3);
        assert_eq!(next.capture, Capture::OtherSideOfFocus);
        assert!(
            next.text.contains(cause_words("sensor_tilt").title),
            "{}",
            next.text
        );
    }

    #[test]
    fn three_rivals_get_the_capture_that_separates_most_of_them() {
        let ids = ["vignetting", "higher_order", "aperture_polygon"];
        let next = advised(Verdict::Ambiguous, &ids, 3);
        assert_eq!(next.capture, Capture::FarOutOfFocus);
        assert!(
            ids.iter()
                .all(|id| next.text.contains(cause_words(id).title)),
            "{}",
            next.text
        );
    }

    #[test]
    fn a_lens_without_a_gap_or_with_a_richer_model_needs_no_capture() {
        assert_eq!(advised(Verdict::NoGap, &[], 3).capture, Capture::None);
        let poor = advised(Verdict::ModelTooSimple, &[], 3);
        assert_eq!(poor.capture, Capture::MorePlaces);
        let model = ModelShare {
            freedom: vec!["vignetting"],
            ..MODEL
        };
        let rich = next(&Situation {
            verdict: Verdict::ModelTooSimple,
            causes: &[],
            equivalents: &[],
            model: &model,
            distances: 3,
        });
        assert_eq!(rich.capture, Capture::None);
    }
}
