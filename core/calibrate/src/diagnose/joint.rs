//! Two or three effects together.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Result;

use super::joint_search::{PARTNERS, Partner};
use super::posterior::contained_in;
use super::search::{Candidate, Draft, HypothesisSearch};
use super::verdict::GapStatistics;

/// Single effects from which pairs are formed; pairs refined on few tiles, and then on more.
const PAIRED_SINGLES: usize = 3;
const COMPLETED_PAIRS: usize = 4;
const REFINED_PAIRS: usize = 2;
/// Ratio of the gaps of a channel at a distance from which on an addition makes them worse.
const WORSE_RATIO: f64 = 1.2;

/// Returns the pairs of effects that are worth trying, best first: each of the best singles with the partners that close
/// most. If the best pair leaves a part of the gap, a third effect is tried with it. Combinations that make one channel at one
/// distance worse than their best single effect are left out.
///
/// # Errors
/// Those of `progress`.
pub(super) fn combinations(
    search: &HypothesisSearch,
    statistics: &GapStatistics,
    singles: &[Candidate],
    progress: impl Fn(f64) -> Result<()>,
) -> Result<Vec<Candidate>> {
    let mut drafts: Vec<Draft> = Vec::new();
    let first = PAIRED_SINGLES.min(singles.len());
    for (i, one) in singles[..first].iter().enumerate() {
        progress(i as f64 / (first + 1) as f64)?;
        let others: Vec<&Candidate> = singles.iter().skip(i + 1).collect();
        for partner in promising(search.ranked_partners(one, &others)) {
            drafts.push(search.joint_draft(one, partner));
        }
    }
    drafts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    drafts.truncate(COMPLETED_PAIRS);
    let completed = drafts.into_iter().map(|draft| search.completed(draft));
    let mut found: Vec<Candidate> = completed.collect();
    let by_gap = |a: &Candidate, b: &Candidate| a.after.total_cmp(&b.after);
    found.sort_by(by_gap);
    let rest = found.split_off(REFINED_PAIRS.min(found.len()));
    let refined = found.into_iter().map(|pair| search.refined(pair));
    let mut found: Vec<Candidate> = refined.chain(rest).collect();
    found.sort_by(by_gap);
    progress(first as f64 / (first + 1) as f64)?;
    if let Some(pair) = found.first()
        && statistics.wants_third(pair.after)
    {
        let ids = pair.hypothesis.ids();
        let others: Vec<&Candidate> = (singles.iter())
            .filter(|s| !ids.contains(&s.hypothesis.ids()[0]))
            .collect();
        let partners = search.ranked_partners(pair, &others).into_iter();
        let triples = partners.take(PARTNERS);
        let triples = triples.map(|partner| search.joint_draft(pair, partner));
        if let Some(best) = triples.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
            found.push(search.refined(search.completed(best)));
            found.sort_by(by_gap);
        }
    }
    let limit = statistics.detection_limit();
    found.retain(|joint| {
        let own =
            (singles.iter()).find(|s| joint.hypothesis.ids().contains(&s.hypothesis.ids()[0]));
        own.is_none_or(|single| !makes_worse(search, single, joint, limit))
    });
    Ok(found)
}

/// Returns the first of `ranked` and those that one of them contains: the simpler effect may do as well, and is likelier then.
fn promising(ranked: Vec<Partner>) -> Vec<Partner> {
    let mut chosen: Vec<Partner> = Vec::new();
    let mut rest = Vec::new();
    for partner in ranked {
        if chosen.len() < PARTNERS {
            chosen.push(partner);
        } else {
            rest.push(partner);
        }
    }
    let simpler: Vec<&str> = (chosen.iter())
        .flat_map(|partner| contained_in(partner.alone.hypothesis.ids()[0]))
        .collect();
    let added = rest.into_iter();
    chosen.extend(added.filter(|p| simpler.contains(&p.alone.hypothesis.ids()[0])));
    chosen
}

/// Mean gaps of one channel at one distance.
struct GroupGaps {
    channel: usize,
    distance: ObjectDistance,
    before: f64,
    after: f64,
    count: f64,
}

/// Returns whether `joint` leaves a larger gap than `single` in a channel at a distance, by more than `limit`.
fn makes_worse(
    search: &HypothesisSearch,
    single: &Candidate,
    joint: &Candidate,
    limit: f64,
) -> bool {
    let (of_single, of_joint) = (search.gaps_left(single), search.gaps_left(joint));
    let mut groups: Vec<GroupGaps> = Vec::new();
    for (tile, (before, after)) in (search.many().iter()).zip(of_single.iter().zip(of_joint)) {
        let same = |g: &GroupGaps| g.channel == tile.of_lens && g.distance == tile.distance;
        let index = groups.iter().position(same).unwrap_or_else(|| {
            groups.push(GroupGaps {
                channel: tile.of_lens,
                distance: tile.distance,
                before: 0.0,
                after: 0.0,
                count: 0.0,
            });
            groups.len() - 1
        });
        let group = &mut groups[index];
        group.before += before - tile.noise;
        group.after += after - tile.noise;
        group.count += 1.0;
    }
    groups.iter().any(|g| {
        let (before, after) = (g.before / g.count, g.after / g.count);
        after > (WORSE_RATIO * before).max(before + limit)
    })
}
