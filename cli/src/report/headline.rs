//! The top of the page: the answer in words, odds, the gap, and what to capture next.

use seidel_core::calibrate::diagnose::{Cause, Diagnosis, Verdict};

use super::markup::escape;
use super::words::{
    effect_name, effect_summary, gap, list, odds, percent, percent_range, place, sentence,
};

/// Causes whose odds stand at the top.
const SHOWN: usize = 3;

/// A bar of a share of the track with words before and a number behind.
pub(super) fn bar(words: &str, number: &str, share: f64, class: &str) -> String {
    format!(
        "<div class=\"bar\"><div class=\"words\"><span>{words}</span><span class=\"number\">{number}\
         </span></div>{}</div>\n",
        track(share, class)
    )
}

/// The bar alone.
pub(super) fn track(share: f64, class: &str) -> String {
    let width = 100.0
        * if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
    format!(
        "<div class=\"track\"><div class=\"fill {class}\" style=\"width:{width:.2}%\"></div></div>"
    )
}

/// The answer in a sentence, as plain text.
pub(super) fn verdict(d: &Diagnosis) -> String {
    let closed = format!(
        "{} ({}) of the gap",
        percent(d.gap.closed),
        percent_range(d.gap.closed_ci95)
    );
    let names =
        |ids: &[&'static str]| -> Vec<String> { ids.iter().map(|id| effect_name(id)).collect() };
    let added = names(&d.added);
    let (it, closes) = match added.len() {
        1 => ("it", "closes"),
        2 => ("both", "closes"),
        _ => ("them", "closes"),
    };
    match d.verdict {
        Verdict::NoGap => "The lens explains these observations: nothing is missing.".to_owned(),
        Verdict::Explained => format!(
            "The lens lacks {}: adding {it} {closes} {closed}.",
            list(&added, "and")
        ),
        Verdict::Ambiguous => {
            let twins = d
                .equivalents
                .first()
                .map_or(added.clone(), |ids| names(ids));
            let tried = if added.is_empty() {
                String::new()
            } else {
                format!(": {} {closes} {closed}", list(&added, "and"))
            };
            format!(
                "The lens lacks {}; these observations cannot tell which{tried}.",
                list(&twins, "or")
            )
        }
        Verdict::Unexplained if added.is_empty() => {
            "There is a gap that no known effect closes.".to_owned()
        }
        Verdict::Unexplained => format!(
            "Adding {} {closes} {closed}; the rest has no known cause.",
            list(&added, "and")
        ),
    }
}

/// What follows the answer: what the effect is, and where the gap lies.
fn lead(d: &Diagnosis) -> String {
    let mut parts = Vec::new();
    for id in &d.added {
        let summary = effect_summary(id);
        if !summary.is_empty() {
            let name = sentence(&effect_name(id));
            parts.push(format!("{name} – {summary}."));
        }
    }
    if d.verdict == Verdict::NoGap {
        parts.push(format!(
            "With probability {} the lens and the observations agree to their noise and the lens's own accuracy.",
            odds(d.nothing_missing)
        ));
    } else if let Some(worst) = d.places.first() {
        parts.push(format!(
            "The gap is largest in {}: {} ({:.0} standard errors).",
            place(worst),
            gap(worst.excess),
            worst.z
        ));
    }
    parts.join(" ")
}

/// The whole first screen.
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

fn causes_card(d: &Diagnosis) -> String {
    let title = if d.verdict == Verdict::NoGap {
        "Likeliest causes, if something were missing"
    } else {
        "Likeliest causes"
    };
    let bars: String = d
        .causes
        .iter()
        .take(SHOWN)
        .map(|c| cause_bar(c, &d.added))
        .collect();
    format!(
        "<div class=\"card\"><h3>{title}</h3>\n{bars}<p class=\"quiet small\">{} causes tried, each alone. \
         Chance that nothing is missing: {}.</p></div>\n",
        d.causes.iter().filter(|c| c.effect != "unknown").count(),
        odds(d.nothing_missing)
    )
}

fn cause_bar(cause: &Cause, added: &[&str]) -> String {
    let class = if added.contains(&cause.effect) {
        ""
    } else {
        "other"
    };
    bar(
        &escape(&effect_name(cause.effect)),
        &odds(cause.probability),
        cause.probability,
        class,
    )
}

fn gap_card(d: &Diagnosis) -> String {
    let g = &d.gap;
    let largest = [g.before, g.after, g.noise_floor, g.lens_misfit]
        .into_iter()
        .fold(f64::MIN_POSITIVE, f64::max);
    let rows = [
        ("before: the lens as given", g.before, ""),
        ("after: the corrected lens", g.after, ""),
        ("by the noise alone, taken off", g.noise_floor, "other"),
        ("of the lens on its own data", g.lens_misfit, "other"),
    ];
    let bars: String = rows
        .into_iter()
        // A lens that does not know how well it was fitted says zero.
        .filter(|(_, value, _)| *value != 0.0)
        .map(|(words, value, class)| bar(words, &gap(value), value / largest, class))
        .collect();
    format!(
        "<div class=\"card\"><h3>Gap, in per cent of a PSF's energy</h3>\n{bars}\
         <p class=\"quiet small\">On parts of the field that took no part in fitting.</p></div>\n"
    )
}

fn next_card(d: &Diagnosis) -> String {
    let next = if d.next_capture.is_empty() {
        "Nothing more is needed.".to_owned()
    } else {
        format!("{}.", sentence(d.next_capture.trim_end_matches('.')))
    };
    let left = if d.residual.is_empty() {
        String::new()
    } else {
        format!(
            "<h3>What is left</h3><p class=\"small\">{}.</p>",
            escape(&sentence(d.residual.trim_end_matches('.')))
        )
    };
    format!(
        "<div class=\"card\"><h3>What to capture next</h3><p class=\"next\">{}</p>{left}</div>\n",
        escape(&next)
    )
}
