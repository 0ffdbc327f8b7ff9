//! Remarks on an evaluation.

use super::SparseCurve;
use crate::measure::Rejection;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::observations::ObservationSet;

/// Maximum number of files named in a remark.
const NAMED: usize = 8;

/// Returns one remark per reason for excluded tiles of the evaluated channels and distances.
pub(super) fn left_out(
    set: &ObservationSet,
    rejected: &[Rejection],
    channels: &[(usize, usize)],
    distances: &[ObjectDistance],
) -> Vec<String> {
    let mut by_reason: Vec<(&str, Vec<String>)> = Vec::new();
    for rejection in rejected {
        let chosen = channels
            .iter()
            .any(|&(index, _)| set.channels[index] == rejection.channel)
            && distances.contains(&set.observations[rejection.observation].distance);
        if !chosen {
            continue;
        }
        let name = format!("{} {}", rejection.file, rejection.channel);
        match by_reason.iter_mut().find(|(r, _)| *r == rejection.reason) {
            Some((_, names)) => names.push(name),
            None => by_reason.push((&rejection.reason, vec![name])),
        }
    }
    by_reason
        .into_iter()
        .map(|(reason, names)| {
            let more = match names.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            format!(
                "{} tile(s) left out, {reason}: {}{more}",
                names.len(),
                names[..names.len().min(NAMED)].join(", ")
            )
        })
        .collect()
}

/// Returns a remark on the fits of Figure 13, if any.
pub(super) fn sparse(place: &str, curve: &SparseCurve) -> Option<String> {
    if curve.points.is_empty() || curve.test_tiles == 0 {
        return Some(format!(
            "{place}: too few tiles to train on some and score others"
        ));
    }
    let lost: Vec<String> = curve
        .points
        .iter()
        .filter(|p| p.undetermined > 0)
        .map(|p| format!("{} of {} with {}", p.undetermined, curve.splits, p.training))
        .collect();
    (!lost.is_empty()).then(|| {
        format!(
            "{place}: splits whose training tiles do not determine S1..S10, and which are not scored: {}",
            lost.join(", ")
        )
    })
}
