//! The verdict of a diagnosis as sentences in plain text.

use seidel_core::{Diagnosis, Verdict};

use super::words::{
    between, closed, gap, gap_interval, is_narrow, is_wide, list, percent, place, sentence, title,
};

/// Returns the verdict as one or two sentences; after a mistake in the books, it is on the corrected set.
pub(super) fn verdict(d: &Diagnosis) -> String {
    match &d.bookkeeping {
        None => on_effects(d),
        Some(found) if !found.can_be_corrected => format!("{}.", sentence(&found.words)),
        Some(found) if found.gap_after >= found.gap_before => format!(
            "A mistake in the books of the set: {}. {}",
            found.words,
            on_effects(d)
        ),
        Some(found) => format!(
            "A mistake in the books of the set: {}. With that corrected, the gap falls from {} to {}. {}",
            found.words,
            gap(found.gap_before),
            gap(found.gap_after.max(0.0)),
            on_effects(d)
        ),
    }
}

/// Returns the verdict on the effects that the lens lacks.
fn on_effects(d: &Diagnosis) -> String {
    let added = list(&titles(&d.added), "and");
    let closes = if is_wide(d.gap.closed_ci95) {
        "the observations do not determine how much of the gap closes".to_owned()
    } else {
        format!("{} of the gap closes", closed(d.gap.closed))
    };
    if has_nothing_in_common(d) {
        return format!(
            "The PSFs have little in common with the lens: the gap is {}. Check that the set is of this lens, at these settings.",
            gap(d.gap.before)
        );
    }
    match d.verdict_on_effects() {
        Verdict::NoGap | Verdict::Bookkeeping => {
            // The verdict weights PSFs by their noise, so the plain mean may lie above the limit.
            let side = if d.gap.before <= d.detection_limit {
                "below"
            } else {
                "near"
            };
            format!(
                "No effect is missing: the gap of {} is {side} the detection limit of {}.",
                gap(d.gap.before),
                gap(d.detection_limit)
            )
        }
        Verdict::ModelTooSimple => format!(
            "The model of the lens is too simple: it leaves {} of the set that it was fitted to; {}.",
            gap(d.model.own_gap),
            freedom(d)
        ),
        Verdict::Explained if d.residual.is_empty() => {
            format!("Explained by {added}: with the correction, {closes}.")
        }
        Verdict::Explained => format!(
            "Explained in part by {added}: with the correction, {closes}; {}.",
            remainder(d)
        ),
        Verdict::Ambiguous => {
            let first = rivals(d);
            if added.is_empty() {
                return first;
            }
            let left = if d.residual.is_empty() {
                String::new()
            } else {
                format!("; {}", remainder(d))
            };
            format!("{first} With {added}, {closes}{left}.")
        }
        Verdict::Unexplained if added.is_empty() => format!(
            "There is a gap of {} that no known effect closes.",
            gap(d.gap.before)
        ),
        Verdict::Unexplained => format!(
            "Unexplained: with {added}, {closes}; the remaining {} has no known cause.",
            gap(d.gap.after)
        ),
    }
}

/// Returns whether the gap exceeds the light of the PSFs, and no effects close it.
fn has_nothing_in_common(d: &Diagnosis) -> bool {
    d.gap.before > 1.0 && !matches!(d.verdict_on_effects(), Verdict::Explained)
}

/// Probability from which on an effect of an ambiguous answer is certain: it is in all that are likely.
const CERTAIN: f64 = 0.9;

/// Returns the causes of an ambiguous verdict, without those that every likely answer names.
fn rivals(d: &Diagnosis) -> String {
    let named = d.equivalents.first().unwrap_or(&d.added);
    let (certain, open): (Vec<&str>, Vec<&str>) =
        named.iter().partition(|id| in_answers(d, id) >= CERTAIN);
    if certain.is_empty() || open.len() < 2 {
        let all = list(&titles(named), "or");
        return format!("{}: these observations cannot tell which.", sentence(&all));
    }
    format!(
        "{}, and either {}: these observations cannot tell which of the latter.",
        sentence(&list(&titles(&certain), "and")),
        list(&titles(&open), "or")
    )
}

/// Returns the probability of all answers that name the effect `id`, alone or with others.
pub(super) fn in_answers(d: &Diagnosis, id: &str) -> f64 {
    let own = d.causes.iter().find(|cause| cause.effect == id);
    let own = own.map_or(0.0, |cause| cause.probability);
    // A cause has only its part of the probability of those together.
    let together = d.pairs.iter().filter(|pair| pair.effects.contains(&id));
    let rest = together.map(|pair| pair.probability * (1.0 - 1.0 / pair.effects.len() as f64));
    own + rest.sum::<f64>()
}

/// Returns the interval of the closed share and the place of the gap, or the parts of a gap below the limit.
pub(super) fn lead(d: &Diagnosis) -> String {
    let mut parts: Vec<String> = Vec::new();
    if d.verdict_on_effects() == Verdict::NoGap {
        parts.push(model_share(d));
    } else {
        if !d.added.is_empty() {
            let interval = d.gap.closed_ci95;
            if is_wide(interval) {
                parts
                    .push("The closed share is uncertain: zones of the field disagree.".to_owned());
            } else if !is_narrow(interval) {
                // A narrow one is in the verdict.
                parts.push(format!("The closed share is {}.", between(interval)));
            }
        }
        if let Some(worst) = d.places.first() {
            let interval = gap_interval(worst).map_or(String::new(), |ends| format!(", {ends}"));
            parts.push(format!(
                "The gap is largest in {}: {}{interval}.",
                place(worst),
                gap(worst.excess),
            ));
        }
    }
    parts.join(" ")
}

/// Returns the share of the model in a gap below the limit, and the largest gap of a single PSF.
fn model_share(d: &Diagnosis) -> String {
    let largest = d.tiles.iter().max_by(|a, b| a.before.total_cmp(&b.before));
    let largest = largest.map_or(String::new(), |tile| {
        format!(
            " The largest gap of one PSF is {}, in channel {}.",
            gap(tile.before),
            tile.channel
        )
    });
    format!(
        "Of the gap, {} is what the lens's own model leaves of the set that it was fitted to.{largest} Residuals in the \
         pictures below are scaled up until they show: model and noise leave them.",
        gap(d.shares.model)
    )
}

/// Returns what a richer model of the same set would close.
fn freedom(d: &Diagnosis) -> String {
    if d.model.freedom.is_empty() {
        return "no richer model was found that describes it".to_owned();
    }
    format!(
        "a model with {} closes {} of that",
        list(&titles(&d.model.freedom), "and"),
        percent(d.model.freedom_closes)
    )
}

/// Returns the size of the remaining gap and its place.
fn remainder(d: &Diagnosis) -> String {
    let at = d.places_left.first();
    let at = at.map_or(String::new(), |worst| {
        format!(", mostly in {}", place(worst))
    });
    format!("{} remains{at}", gap(d.gap.after))
}

fn titles(ids: &[&str]) -> Vec<String> {
    ids.iter().map(|id| title(id).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::diagnosis;
    use seidel_core::diagnosis::{Bookkeeping, Pair};
    use seidel_core::{Frame, ObservationSet};

    #[test]
    fn a_gap_above_the_light_and_a_share_that_is_not_determined_are_no_headline() {
        let mut d = diagnosis(Verdict::Unexplained);
        d.gap.closed_ci95 = [0.0, 1.0];
        let text = verdict(&d);
        assert!(text.contains("do not determine"), "{text}");
        assert!(lead(&d).contains("uncertain"), "{}", lead(&d));
        d.gap.before = 2.17;
        let text = verdict(&d);
        assert!(
            text.contains("set is of this lens") && !text.contains("217"),
            "{text}"
        );
    }

    #[test]
    fn a_mistake_comes_with_what_its_correction_closes_and_another_lens_without() {
        let frame = Frame::new(64, 48, None).expect("a frame");
        let crop = Bookkeeping {
            mistake: "crop",
            words: "positions are those in a crop".to_owned(),
            remedy: "Add (3, 4).".to_owned(),
            gap_before: 0.8,
            gap_after: 0.002,
            can_be_corrected: true,
            verdict: Verdict::NoGap,
            corrected: ObservationSet::new(frame, Vec::new(), Vec::new()),
        };
        let mut d = diagnosis(Verdict::Bookkeeping);
        let mut text_of = |found: &Bookkeeping| {
            d.bookkeeping = Some(found.clone());
            verdict(&d).replace('\u{a0}', " ")
        };
        let text = text_of(&crop);
        assert!(text.starts_with("A mistake in the books of the set: positions are those in a crop. With that corrected, the gap falls from 80 % to 0.20 %. No effect"), "{text}");
        let camera = Bookkeeping {
            gap_after: 0.8,
            ..crop.clone()
        };
        assert!(!text_of(&camera).contains("falls"));
        let other = Bookkeeping {
            words: "this looks like the set of another lens".to_owned(),
            can_be_corrected: false,
            ..camera
        };
        assert_eq!(text_of(&other), "This looks like the set of another lens.");
    }

    #[test]
    fn an_effect_in_every_likely_answer_is_certain() {
        let mut d = diagnosis(Verdict::Ambiguous);
        let pair = |effects: [&'static str; 2], probability| Pair {
            effects: effects.to_vec(),
            probability,
            gap_closed: 0.98,
        };
        d.pairs = vec![
            pair(["decentre", "vignetting"], 0.58),
            pair(["decentre", "diffraction"], 0.4),
        ];
        let mut cause = d.causes[0].clone();
        d.causes = [
            ("decentre", 0.49),
            ("vignetting", 0.29),
            ("diffraction", 0.2),
        ]
        .map(|(effect, probability)| {
            (cause.effect, cause.probability) = (effect, probability);
            cause.clone()
        })
        .to_vec();
        d.equivalents = vec![vec!["decentre", "vignetting", "diffraction"]];
        let text = verdict(&d);
        let start = "A decentred element, and either vignetting or diffraction: these observations cannot tell which of the latter.";
        assert!(text.starts_with(start), "{text}");
        d.pairs[1].probability = 0.1;
        assert!(
            !verdict(&d).contains("either"),
            "not in every likely answer"
        );
    }
}
