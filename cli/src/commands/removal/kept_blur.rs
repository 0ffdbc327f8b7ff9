//! The note on the parts of a picture that keep their blur.

use seidel_core::{KeptBlurReason, RemovedPlate};

/// Share of the picture below which a reason is not named.
const LEAST_SHARE: f64 = 5e-5;

/// Returns the share of the picture that keeps its blur for each reason, in the mean of the colours; `None` if there is none.
pub(super) fn note(removed: &RemovedPlate) -> Option<String> {
    let colours = removed.colours();
    let parts: Vec<(f64, &str)> = (KeptBlurReason::ALL.iter())
        .map(|reason| {
            let shares = colours.iter().map(|plane| plane.kept.share_of(*reason));
            let mean = shares.sum::<f64>() / colours.len().max(1) as f64;
            (mean, words(*reason))
        })
        .filter(|(share, _)| *share >= LEAST_SHARE)
        .collect();
    let total: f64 = parts.iter().map(|(share, _)| share).sum();
    let parts: Vec<String> = (parts.iter())
        .map(|(share, words)| format!("{words} {:.2} %", 100.0 * share))
        .collect();
    (!parts.is_empty()).then(|| {
        format!(
            "{:.2} % of the picture keeps its blur: {}",
            100.0 * total,
            parts.join(", ")
        )
    })
}

fn words(reason: KeptBlurReason) -> &'static str {
    match reason {
        KeptBlurReason::Clipped => "clipped samples",
        KeptBlurReason::UnexplainedLight => "lights that the lens does not explain",
        KeptBlurReason::Highlight => "highlights",
        KeptBlurReason::NearLight => "pixels that get light of these",
        KeptBlurReason::UnexplainedPicture => "parts that the lens and the depth do not explain",
    }
}
