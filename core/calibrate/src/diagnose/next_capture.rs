//! Recommendation of the next capture.

use super::diagnosis::{Cause, Verdict};
use super::model_share::ModelShare;

/// A change of the capture, and the response of each effect.
struct Intervention {
    /// Instruction to the photographer.
    act: &'static str,
    /// Affected effects, each with its response.
    changes: &'static [(&'static str, &'static str)],
}

/// Cheapest first.
static INTERVENTIONS: [Intervention; 7] = [
    Intervention {
        act: "repeat one corner PSF two stops down",
        changes: &[
            ("diffraction", "diffraction grows"),
            ("defocus_offset", "defocus shrinks with the pupil"),
            ("depth_scale", "defocus shrinks with the pupil"),
            ("sensor_tilt", "defocus shrinks with the pupil"),
            (
                "axial_colour",
                "the difference in focus shrinks with the pupil",
            ),
            ("decentre", "coma shrinks with the square of the pupil"),
            ("higher_order", "fifth order vanishes first"),
            ("vignetting", "the cat's eye becomes round"),
            ("aperture_polygon", "the polygon shows in full"),
            ("apodisation", "the edge of the disc hardens"),
            ("anamorphic", "blur shrinks with the pupil"),
        ],
    },
    Intervention {
        act: "refocus to put the same points as far on the other side of focus",
        changes: &[
            (
                "defocus_offset",
                "the offset keeps its sign while the blur flips",
            ),
            ("sensor_tilt", "the side that is in focus changes"),
            ("axial_colour", "the colour order of the discs flips"),
            ("aperture_polygon", "the polygon turns upside down"),
            ("vignetting", "the cat's eye turns over"),
            ("decentre", "coma stays as it is while discs flip"),
            ("anamorphic", "the long axis of the discs changes"),
            ("higher_order", "bright rims turn into soft ones"),
            ("apodisation", "soft edges stay soft"),
        ],
    },
    Intervention {
        act: "add PSFs at a second, much nearer distance",
        changes: &[
            ("depth_scale", "a wrong distance grows in dioptres"),
            ("defocus_offset", "an offset stays the same"),
        ],
    },
    Intervention {
        act: "turn the camera by 90 degrees about its axis, the target staying",
        changes: &[
            ("motion", "the streak turns against the frame"),
            ("pixel_footprint", "it stays with the sensor's axes"),
        ],
    },
    Intervention {
        act: "repeat with a quarter of the exposure time",
        changes: &[
            ("motion", "the streak shortens"),
            ("tone_curve", "darker cores are compressed less"),
        ],
    },
    Intervention {
        act: "repeat one PSF at a quarter and at four times the light",
        changes: &[("tone_curve", "the shape changes with the light")],
    },
    Intervention {
        act: "photograph one lamp on a wide dark search with long and short exposures",
        changes: &[("veiling_glare", "its halo goes on far beyond the tile")],
    },
];

/// Returns the capture that best distinguishes the remaining causes.
pub(super) fn next(
    verdict: Verdict,
    causes: &[Cause],
    equivalents: &[Vec<&'static str>],
    model: &ModelShare,
) -> String {
    match verdict {
        Verdict::ModelTooSimple if model.freedom.is_empty() => "none: no capture mends a model that is too simple; look at the residuals of the lens's own set with `seidel eval --shapes`, and fit it again with PSFs at more places".to_owned(),
        Verdict::ModelTooSimple => "none needed yet: fit the lens again with `seidel fit --model extended`, then diagnose these observations with it".to_owned(),
        Verdict::NoGap => "none needed: the lens explains these observations; PSFs at another distance or f-number would test it further".to_owned(),
        Verdict::Unexplained => "repeat three PSFs (middle, edge, corner) two stops down and, apart from that, with the camera turned by 90 degrees: what stays with the sensor is not the lens, what shrinks is in its pupil".to_owned(),
        Verdict::Ambiguous | Verdict::Explained => {
            // The effects that are not distinguished come first, then the likeliest others.
            let class = equivalents.iter().flatten().copied();
            let mut known: Vec<&str> = Vec::new();
            for id in class.chain(causes.iter().map(|c| c.effect)) {
                if id != "unknown" && !known.contains(&id) {
                    known.push(id);
                }
            }
            match known[..] {
                [one, other, ..] => between(one, other),
                _ => "repeat one corner PSF two stops down".to_owned(),
            }
        }
    }
}

/// Returns the first intervention with different responses of two effects.
fn between(one: &str, other: &str) -> String {
    let answer = |i: &Intervention, id: &str| {
        let own = i.changes.iter().find(|(e, _)| *e == id);
        own.map(|(_, how)| *how)
    };
    for intervention in &INTERVENTIONS {
        match (answer(intervention, one), answer(intervention, other)) {
            (Some(a), Some(b)) if a != b => {
                return format!("{}: for {one} {a}, for {other} {b}", intervention.act);
            }
            (Some(a), None) => {
                return format!(
                    "{}: for {one} {a}, {other} stays as it is",
                    intervention.act
                );
            }
            (None, Some(b)) => {
                return format!(
                    "{}: for {other} {b}, {one} stays as it is",
                    intervention.act
                );
            }
            _ => {}
        }
    }
    format!("add PSFs towards the corners, where {one} and {other} differ most")
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::effects;

    #[test]
    fn every_pair_of_effects_gets_a_capture_that_names_both() {
        for one in effects::causes() {
            for other in effects::causes() {
                if one.id() != other.id() {
                    let text = between(one.id(), other.id());
                    assert!(
                        text.contains(one.id()) && text.contains(other.id()),
                        "{text}"
                    );
                }
            }
        }
        for intervention in &INTERVENTIONS {
            for (id, _) in intervention.changes {
                assert!(effects::by_id(id).is_ok(), "{id}");
            }
        }
    }
}
