//! The first screen of the page: the verdict, the most probable causes, the gap, and the next capture.

use seidel_core::calibrate::diagnose::{Diagnosis, Verdict};

use super::markup::{bar, escape};
use super::words::{
    effect_name, effect_summary, gap, list, percent, percent_range, place, probability, sentence,
};

/// Number of causes shown on the first screen.
const TOP_CAUSES: usize = 3;

/// Returns the first screen.
pub(super) fn headline(d: &Diagnosis) -> String {
    format!(
        "<h1>{}</h1>\n<p class=\"lead\">{}</p>\n<div class=\"cards\">\n{}{}{}</div>\n",
        escape(&verdict(d)),
        escape(&lead(d)),
        causes_card(d),
        gap_card(d),
        next_card(d)
    )
}

/// Returns the verdict as a sentence in plain text.
fn verdict(d: &Diagnosis) -> String {
    let names = |ids: &[&str]| ids.iter().map(|id| effect_name(id)).collect::<Vec<_>>();
    let added = names(&d.added);
    let closes = format!(
        "closes {} ({}) of the gap",
        percent(d.gap.closed),
        percent_range(d.gap.closed_ci95)
    );
    match d.verdict {
        Verdict::NoGap => "The lens explains these observations: no effect is missing.".to_owned(),
        Verdict::ModelTooSimple => {
            let freedom = names(&d.model.freedom);
            let cure = if freedom.is_empty() {
                "no richer model was found that describes it".to_owned()
            } else {
                format!(
                    "a model with {} closes {} of that",
                    list(&freedom, "and"),
                    percent(d.model.freedom_closes)
                )
            };
            format!(
                "The model of the lens is too simple: it leaves {} of the set that it was fitted to; {cure}.",
                gap(d.model.own_gap)
            )
        }
        Verdict::Explained => {
            let them = match added.len() {
                1 => "it",
                2 => "both",
                _ => "them",
            };
            let added = list(&added, "and");
            format!("The lens lacks {added}: adding {them} {closes}.")
        }
        Verdict::Ambiguous => {
            let equivalent = d
                .equivalents
                .first()
                .map_or(added.clone(), |ids| names(ids));
            let tried = if added.is_empty() {
                String::new()
            } else {
                format!(": adding {} {closes}", list(&added, "and"))
            };
            format!(
                "The lens lacks {}; these observations cannot distinguish them{tried}.",
                list(&equivalent, "or")
            )
        }
        Verdict::Unexplained if added.is_empty() => {
            "There is a gap that no known effect closes.".to_owned()
        }
        Verdict::Unexplained => format!(
            "Adding {} {closes}; the remainder has no known cause.",
            list(&added, "and")
        ),
    }
}

/// Returns a description of the added effects and of the place where the gap is largest.
fn lead(d: &Diagnosis) -> String {
    let added = d.added.iter().filter(|id| !effect_summary(id).is_empty());
    let mut parts: Vec<String> = added
        .map(|id| format!("{}: {}.", sentence(&effect_name(id)), effect_summary(id)))
        .collect();
    if d.verdict == Verdict::NoGap {
        parts.push(format!(
            "The gap, {}, is below what could be seen here: {}.",
            gap(d.gap.before.max(0.0)),
            gap(d.detection_limit)
        ));
    } else if let Some(worst) = d.places.first() {
        parts.push(format!(
            "The gap is largest in {}: {}, {:.0} times its uncertainty.",
            place(worst),
            gap(worst.excess),
            worst.z
        ));
    }
    parts.join(" ")
}

fn causes_card(d: &Diagnosis) -> String {
    let title = match d.verdict {
        Verdict::NoGap => "Most probable causes, if an effect were missing",
        Verdict::ModelTooSimple => "Most probable causes, if the lens had also changed",
        _ => "Most probable causes",
    };
    let nothing = match d.verdict {
        // The gap has a cause: the model.
        Verdict::ModelTooSimple => String::new(),
        _ => format!(
            " Probability that nothing is missing: {}.",
            probability(d.no_gap_probability)
        ),
    };
    let bars: String = d
        .causes
        .iter()
        .take(TOP_CAUSES)
        .map(|cause| {
            let added = d.added.contains(&cause.effect);
            let class = if added { "" } else { "other" };
            let name = escape(&effect_name(cause.effect));
            bar(
                &name,
                &probability(cause.probability),
                cause.probability,
                class,
            )
        })
        .collect();
    format!(
        "<div class=\"card\"><h3>{title}</h3>\n{bars}<p class=\"quiet small\">{} effects tried one at a time.{nothing}</p></div>\n",
        d.causes.iter().filter(|c| c.effect != "unknown").count(),
    )
}

fn gap_card(d: &Diagnosis) -> String {
    let rows = [
        ("given lens", d.gap.before, ""),
        ("corrected lens", d.gap.after, ""),
        ("noise floor (subtracted)", d.gap.noise_floor, "other"),
        ("by the lens's own model", d.shares.model, "other"),
        ("by a change since its own set", d.shares.change, "other"),
        ("limit of detection", d.detection_limit, "other"),
    ];
    let largest = rows
        .iter()
        .map(|row| row.1)
        .fold(f64::MIN_POSITIVE, f64::max);
    let bars: String = rows
        .into_iter()
        .filter(|(_, value, _)| *value != 0.0)
        .map(|(label, value, class)| bar(label, &gap(value), value / largest, class))
        .collect();
    format!(
        "<div class=\"card\"><h3>Gap, % of the energy of a PSF</h3>\n{bars}\
         <p class=\"quiet small\">On zones of the field that were held out of the fits.</p></div>\n"
    )
}

fn next_card(d: &Diagnosis) -> String {
    let text = |text: &str| escape(&sentence(text.trim_end_matches('.')));
    let next = if d.next_capture.is_empty() {
        "Not needed".to_owned()
    } else {
        text(&d.next_capture)
    };
    let residual = if d.residual.is_empty() {
        String::new()
    } else {
        let residual = text(&d.residual);
        format!("<h3>Remaining residual</h3><p class=\"small\">{residual}.</p>")
    };
    format!(
        "<div class=\"card\"><h3>Next capture</h3><p class=\"next\">{next}.</p>{residual}</div>\n"
    )
}
