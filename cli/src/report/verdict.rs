//! The verdict of a diagnosis as sentences in plain text.

use seidel_core::calibrate::diagnose::{Diagnosis, Verdict};

use super::words::{between, closed, gap, gap_interval, list, percent, place, sentence, title};

/// Returns the verdict as one or two sentences.
pub(super) fn verdict(d: &Diagnosis) -> String {
    let added = list(&titles(&d.added), "and");
    let closes = format!("{} of the gap closes", closed(d.gap.closed));
    match d.verdict {
        Verdict::NoGap => {
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
            let rivals = d.equivalents.first().unwrap_or(&d.added);
            let rivals = list(&titles(rivals), "or");
            let first = format!(
                "{}: these observations cannot tell which.",
                sentence(&rivals)
            );
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

/// Returns the interval of the closed share and the place of the gap, or the parts of a gap below the limit.
pub(super) fn lead(d: &Diagnosis) -> String {
    let mut parts: Vec<String> = Vec::new();
    if d.verdict == Verdict::NoGap {
        parts.push(model_share(d));
    } else {
        if !d.added.is_empty() {
            parts.push(format!(
                "The closed share is {}.",
                between(d.gap.closed_ci95)
            ));
        }
        if let Some(worst) = d.places.first() {
            parts.push(format!(
                "The gap is largest in {}: {}, {}.",
                place(worst),
                gap(worst.excess),
                gap_interval(worst)
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
