//! The summary that `seidel diagnose` prints, one line per result.

use seidel_core::{Diagnosis, Verdict};

use super::Subject;
use super::advice::advice;
use super::verdict::verdict;
use super::words::{closed_between, gap, percent, title};

/// Returns the lines of the summary.
pub fn summary(d: &Diagnosis, subject: &Subject) -> Vec<String> {
    let added = match d.added.as_slice() {
        [] => "nothing".to_owned(),
        ids => {
            let named = ids.iter().map(|id| format!("{} ({id})", title(id)));
            named.collect::<Vec<_>>().join(", ")
        }
    };
    let mut lines = vec![
        format!("verdict: {}", d.verdict.id()),
        format!("  {}", verdict(d)),
        format!("compared: {}", subject.counts(d)),
        format!("added: {added}"),
    ];
    let after = if d.added.is_empty() {
        String::new()
    } else {
        format!(
            ", {} with it; closed {}",
            gap(d.gap.after),
            closed_between(d.gap.closed, d.gap.closed_ci95)
        )
    };
    lines.push(format!(
        "gap: {} of the energy of a PSF{after}",
        gap(d.gap.before)
    ));
    lines.push(format!(
        "of the gap: {} is fit error, {} is new; detection limit {}, noise {}",
        gap(d.shares.model),
        gap(d.shares.change),
        gap(d.detection_limit),
        gap(d.gap.noise_floor)
    ));
    if d.verdict_on_effects() == Verdict::ModelTooSimple && !d.model.freedom.is_empty() {
        let freedom: Vec<&str> = d.model.freedom.iter().map(|id| title(id)).collect();
        lines.push(format!(
            "a richer model with {} would close {} of the lens's own gap",
            freedom.join(", "),
            percent(d.model.freedom_closes)
        ));
    }
    for advice in advice(d) {
        lines.push(format!("{}: {}", advice.title, advice.meaning));
        if !advice.amount.is_empty() {
            lines.push(format!("  fitted: {}.", advice.amount));
        }
        lines.push(format!("  what to do: {}", advice.action));
    }
    if !d.residual.is_empty() {
        lines.push(format!("left: {}", d.residual));
    }
    lines.push(format!("next capture: {}", d.next_capture));
    // Terminals and searches work on plain spaces.
    lines
        .iter()
        .map(|line| line.replace('\u{a0}', " "))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::{ALL, diagnosis, subject};

    #[test]
    fn every_verdict_is_named_by_identifier_and_sentence() {
        for kind in ALL {
            let d = diagnosis(kind);
            let text = summary(&d, &subject()).join("\n");
            assert!(
                text.starts_with(&format!("verdict: {}\n", kind.id())),
                "{text}"
            );
            let sentence = verdict(&d).replace('\u{a0}', " ");
            assert!(text.contains(&sentence), "{text}");
            assert!(
                text.contains("162 PSFs at 3 distances in 3 channels: 486 tiles"),
                "{text}"
            );
            assert_eq!(
                text.contains("what to do: "),
                kind != Verdict::NoGap,
                "{text}"
            );
            for id in &d.added {
                let named = format!("added: {} ({id})", title(id));
                assert!(text.contains(&named), "{text}");
            }
        }
    }

    #[test]
    fn a_remainder_is_printed_with_its_description() {
        let mut d = diagnosis(Verdict::Explained);
        let text = summary(&d, &subject()).join("\n");
        assert!(
            text.contains("Explained in part") && text.contains("\nleft: "),
            "{text}"
        );
        d.residual.clear();
        d.places_left.clear();
        let text = summary(&d, &subject()).join("\n");
        assert!(
            text.contains("Explained by vignetting") && !text.contains("\nleft: "),
            "{text}"
        );
    }
}
