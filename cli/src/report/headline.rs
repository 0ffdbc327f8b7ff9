//! The first screen of the page: the verdict, the most probable causes, the gap, and the next capture.

use seidel_core::{Diagnosis, Verdict};

use super::markup::{bar, escape, with_code};
use super::verdict::{lead, verdict};
use super::words::{closed_between, gap, list, place, probability, sentence, title};

/// Number of answers shown on the first screen.
const TOP_ANSWERS: usize = 3;

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

/// An answer to the diagnosis: an effect alone, two or three together, or the unknown cause.
struct Answer {
    ids: Vec<&'static str>,
    probability: f64,
}

/// Returns the most probable answers. The probability of a cause includes its part of that of its pairs; an answer's does not.
fn answers(d: &Diagnosis) -> Vec<Answer> {
    let alone = d.causes.iter().map(|cause| {
        let pairs = d.pairs.iter().filter(|p| p.effects.contains(&cause.effect));
        let shared = pairs.map(|pair| pair.probability / pair.effects.len() as f64);
        let shared: f64 = shared.sum();
        Answer {
            ids: vec![cause.effect],
            probability: (cause.probability - shared).max(0.0),
        }
    });
    let pairs = d.pairs.iter().map(|pair| Answer {
        ids: pair.effects.clone(),
        probability: pair.probability,
    });
    let mut all: Vec<Answer> = alone.chain(pairs).collect();
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    all.truncate(TOP_ANSWERS);
    all
}

fn causes_card(d: &Diagnosis) -> String {
    let heading = match d.verdict_on_effects() {
        Verdict::NoGap => "Most probable causes, if an effect were missing",
        Verdict::ModelTooSimple => "Most probable causes, if the lens had also changed",
        _ => "Most probable causes",
    };
    let nothing = match d.verdict_on_effects() {
        // The gap has a cause: the model.
        Verdict::ModelTooSimple => String::new(),
        _ => format!(
            " Probability that nothing is missing: {}.",
            probability(d.no_gap_probability)
        ),
    };
    let bars: String = answers(d)
        .iter()
        .map(|answer| {
            let added = answer.ids.iter().all(|id| d.added.contains(id));
            let class = if added { "" } else { "other" };
            let titles: Vec<String> = answer.ids.iter().map(|id| title(id).to_owned()).collect();
            bar(
                &escape(&sentence(&list(&titles, "and"))),
                &probability(answer.probability),
                answer.probability,
                class,
            )
        })
        .collect();
    let tried = d.causes.iter().filter(|c| !c.parameters.is_empty()).count();
    let of_two = d.pairs.iter().filter(|pair| pair.effects.len() == 2);
    let of_two = of_two.count();
    let pairs = match of_two {
        0 => String::new(),
        1 => " and 1 pair".to_owned(),
        count => format!(" and {count} pairs"),
    };
    let three = if of_two < d.pairs.len() {
        ", and three effects together,"
    } else {
        ""
    };
    format!(
        "<div class=\"card\"><h3>{heading}</h3>\n{bars}<p class=\"quiet small\">{tried} effects{pairs}{three} were \
         tried.{nothing}</p></div>\n"
    )
}

fn gap_card(d: &Diagnosis) -> String {
    let rows = [
        ("given lens", Some(d.gap.before), ""),
        (
            "corrected lens",
            (!d.added.is_empty()).then_some(d.gap.after),
            "",
        ),
        ("fit error of the lens", Some(d.shares.model), "other"),
        (
            "new since the lens was fitted",
            Some(d.shares.change),
            "other",
        ),
        ("limit of detection", Some(d.detection_limit), "other"),
        ("noise (subtracted)", Some(d.gap.noise_floor), "other"),
    ];
    let rows = rows
        .into_iter()
        .filter_map(|(label, value, class)| Some((label, value?, class)));
    let largest = (rows.clone().map(|row| row.1)).fold(f64::MIN_POSITIVE, f64::max);
    let bars: String = rows
        .filter(|(_, value, _)| *value != 0.0)
        .map(|(label, value, class)| bar(label, &gap(value), value / largest, class))
        .collect();
    let share = if d.added.is_empty() {
        "Nothing was added to the lens.".to_owned()
    } else {
        format!(
            "Closed: {}.",
            closed_between(d.gap.closed, d.gap.closed_ci95)
        )
    };
    format!(
        "<div class=\"card\"><h3>Gap, % of the energy of a PSF</h3>\n{bars}<p>{share}</p>\
         <p class=\"quiet small\">On zones of the field that were held out of the fits.</p></div>\n"
    )
}

fn next_card(d: &Diagnosis) -> String {
    let text = |text: &str| with_code(&sentence(text.trim_end_matches('.')));
    let next = if d.next_capture.is_empty() {
        "Not needed".to_owned()
    } else {
        text(&d.next_capture)
    };
    let residual = if d.residual.is_empty() {
        String::new()
    } else {
        let at = d.places_left.first().map_or(String::new(), |worst| {
            format!(
                " It is largest in {}: {}.",
                escape(&place(worst)),
                gap(worst.excess)
            )
        });
        format!(
            "<h3>Remaining gap: {}</h3><p class=\"small\">{}.{at}</p>",
            gap(d.gap.after),
            text(&d.residual)
        )
    };
    format!(
        "<div class=\"card\"><h3>Next capture</h3><p class=\"next\">{next}.</p>{residual}</div>\n"
    )
}
