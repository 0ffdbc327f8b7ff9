//! Final fit of the selected effects, with cross-validated figures.

use super::cause_words::cause_words;
use super::diagnosis::{Cause, Diagnosis, Example, Gap, Pair, Shares, TileGap};
use super::explainable;
use super::gap_problem::{GapProblem, damped_update};
use super::hypothesis::Hypothesis;
use super::jitter;
use super::model_share::ModelShare;
use super::next_capture::{self, Situation};
use super::one_distance;
use super::places;
use super::prediction::TilePredictor;
use super::search::{Candidate, HypothesisSearch, LEFT_OUT_DAMPING, standard_errors};
use super::shape;
use super::tiles::{FOLDS, TileData, TileSet};
use super::verdict::{Decision, GapStatistics};
use seidel_optics::effects::{Effect, Fitted, FittedValue};
use seidel_optics::error::Result;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensDescription, LensProfile, PupilChannel};
use seidel_optics::psf::pupil::Detail;
use seidel_optics::tile::Tile;

/// Results of the search.
pub(super) struct Findings<'a> {
    pub(super) lens: &'a LensProfile,
    pub(super) channels: &'a [PupilChannel],
    pub(super) set: &'a ObservationSet,
    pub(super) tiles: &'a TileSet,
    pub(super) search: &'a HypothesisSearch<'a>,
    pub(super) statistics: &'a GapStatistics,
    pub(super) singles: &'a [Candidate],
    pub(super) joint: &'a [Candidate],
    pub(super) decision: &'a Decision,
    pub(super) model: ModelShare,
    /// Effects that this lens and set cannot show.
    pub(super) left: &'a [&'static dyn Effect],
}

/// The selected hypothesis fitted to all tiles.
struct Final {
    hypothesis: Hypothesis,
    theta: Vec<f64>,
    sigma: Vec<f64>,
    /// Gap of every tile by the fit without its fold.
    after: Vec<f64>,
}

pub(super) fn diagnosis(found: Findings) -> Result<Diagnosis> {
    let tiles: Vec<&TileData> = found.tiles.tiles.iter().collect();
    let nothing = found.search.nothing();
    let before = GapProblem::new(&nothing, &tiles, Detail::FULL).gaps(&[]);
    let last = finish(&found, &tiles, &before);
    let gap = summary(&tiles, &before, &last.after);
    let corrected = LensProfile {
        description: LensDescription::Pupil(last.hypothesis.added_to(
            found.channels,
            &last.theta,
            &last.sigma,
        )),
        held_out: None,
        ..found.lens.clone()
    };
    let shown = if last.hypothesis.parts.is_empty() {
        (&nothing, &[][..])
    } else {
        (&last.hypothesis, &last.theta[..])
    };
    let decision = found.decision;
    let causes = causes(&found, &last);
    let tile_gaps: Vec<TileGap> = tiles
        .iter()
        .zip(before.iter().zip(&last.after))
        .map(|(tile, (before, after))| TileGap {
            observation: tile.observation,
            channel: found.channels[tile.of_lens].name.clone(),
            distance: tile.distance,
            at: tile.centre,
            before: before - tile.noise,
            after: after - tile.noise,
            noise: tile.noise,
        })
        .collect();
    // Without ideal positions, each lens is shown where it agrees best with the pixels.
    let placed = |hypothesis: &Hypothesis, theta: &[f64]| {
        let mut placed = found.tiles.tiles.clone();
        jitter::place_by_pixels(hypothesis, theta, &mut placed);
        placed
    };
    let (of_given, of_shown) = (placed(&nothing, &[]), placed(shown.0, shown.1));
    let given: Vec<&TileData> = of_given.iter().collect();
    let placed: Vec<&TileData> = of_shown.iter().collect();
    let left_shape = shape::shape(&placed, shown.0, shown.1);
    let limit = found.statistics.detection_limit();
    let (residual, places_left) = if gap.after > limit {
        let places = places::places(&tiles, &last.after, found.channels, found.statistics.misfit);
        (shape::describe(&left_shape, &tiles, &tile_gaps), places)
    } else {
        (String::new(), Vec::new())
    };
    let next = next_capture::next(&Situation {
        verdict: decision.verdict,
        causes: &causes,
        equivalents: &decision.equivalents,
        model: &found.model,
        distances: found.set.distances().len(),
    });
    Ok(Diagnosis {
        verdict: decision.verdict,
        bookkeeping: None,
        added: decision
            .added
            .as_ref()
            .map(|c| strongest_first(&found, c))
            .unwrap_or_default(),
        gap,
        no_gap_probability: decision.nothing_missing,
        next_capture: next.text,
        next_capture_id: next.capture,
        causes,
        pairs: pairs(&found),
        equivalents: decision.equivalents.clone(),
        places: places::places(&tiles, &before, found.channels, found.statistics.misfit),
        shape: shape::shape(&given, &nothing, &[]),
        explainable: explainable::explainable(&given, &nothing),
        shares: shares(&gap, found.model.own_gap),
        detection_limit: limit,
        model: found.model.clone(),
        residual,
        places_left,
        remarks: [remarks(&found), worsened(&found, &tile_gaps)].concat(),
        corrected,
        examples: examples(&given, &placed, &before, (&nothing, &[]), shown),
        tiles: tile_gaps,
    })
}

/// Fits the selected effects to all tiles, then without each fold.
fn finish(found: &Findings, tiles: &[&TileData], before: &[f64]) -> Final {
    let Some(added) = &found.decision.added else {
        return Final {
            hypothesis: found.search.nothing(),
            theta: Vec::new(),
            sigma: Vec::new(),
            after: before.to_vec(),
        };
    };
    let hypothesis = added.hypothesis.clone();
    let whole = GapProblem::new(&hypothesis, tiles, Detail::FIT);
    let theta = whole.descend(&added.theta, 3, 1e-3).theta;
    let linear = whole.linear(&theta);
    let mut left_out: Vec<Vec<f64>> = Vec::new();
    let mut after = before.to_vec();
    for fold in 0..FOLDS {
        let others: Vec<&TileData> = tiles.iter().filter(|t| t.fold != fold).copied().collect();
        let own: Vec<&TileData> = tiles.iter().filter(|t| t.fold == fold).copied().collect();
        if others.is_empty() || own.is_empty() {
            continue;
        }
        let of_others = GapProblem::new(&hypothesis, &others, Detail::FIT);
        let sums = linear.total(Some(fold));
        let cost = sums.cost;
        let stepped = damped_update(sums, &theta, &hypothesis.slots, LEFT_OUT_DAMPING);
        let there = if of_others.gap_sum(&stepped) <= cost {
            stepped
        } else {
            of_others.descend(&theta, 1, 1e-2).theta
        };
        let mut gaps = GapProblem::new(&hypothesis, &own, Detail::FULL)
            .gaps(&there)
            .into_iter();
        for (tile, after) in tiles.iter().zip(&mut after) {
            if tile.fold == fold {
                *after = gaps.next().expect("one gap a tile of the fold");
            }
        }
        left_out.push(there);
    }
    let sigma = standard_errors(&linear).into_iter().enumerate();
    Final {
        sigma: sigma
            .map(|(k, sandwich)| sandwich.max(jackknife_error(&left_out, k)))
            .collect(),
        hypothesis,
        theta,
        after,
    }
}

/// Returns the standard error of parameter `k` by the jackknife over zones: from the estimates without each of them. It contains errors that
/// the tiles of a zone have in common.
fn jackknife_error(left_out: &[Vec<f64>], k: usize) -> f64 {
    let count = left_out.len().max(1) as f64;
    let mean = left_out.iter().map(|theta| theta[k]).sum::<f64>() / count;
    let squares: f64 = left_out.iter().map(|theta| (theta[k] - mean).powi(2)).sum();
    ((count - 1.0) / count * squares).sqrt()
}

/// Splits `gap` of a lens that leaves `own_gap` of the set that it was fitted to.
fn shares(gap: &Gap, own_gap: f64) -> Shares {
    let before = gap.before.max(0.0);
    let model = own_gap.min(before);
    Shares {
        noise: gap.noise_floor,
        model,
        change: before - model,
    }
}

fn summary(tiles: &[&TileData], before: &[f64], after: &[f64]) -> Gap {
    let noise: Vec<f64> = tiles.iter().map(|t| t.noise).collect();
    let (closed, ci) = closed(tiles, before, after);
    let mean = |values: &[f64]| {
        let sum: f64 = values.iter().zip(&noise).map(|(g, n)| g - n).sum();
        sum / values.len() as f64
    };
    Gap {
        before: mean(before),
        after: mean(after),
        closed,
        closed_ci95: ci,
        noise_floor: noise.iter().sum::<f64>() / noise.len() as f64,
    }
}

/// Returns the closed share of the gap with its 95 % interval, clustered by observation.
fn closed(tiles: &[&TileData], before: &[f64], after: &[f64]) -> (f64, [f64; 2]) {
    let mut points: Vec<(usize, f64, f64)> = Vec::new();
    for (tile, (b, a)) in tiles.iter().zip(before.iter().zip(after)) {
        let (b, a) = (b - tile.noise, a - tile.noise);
        match points.last_mut() {
            Some(last) if last.0 == tile.observation => {
                last.1 += b;
                last.2 += a;
            }
            _ => points.push((tile.observation, b, a)),
        }
    }
    let total: f64 = points.iter().map(|p| p.1).sum();
    if total <= 0.0 {
        return (0.0, [0.0; 2]);
    }
    let left = points.iter().map(|p| p.2).sum::<f64>() / total;
    let n = points.len() as f64;
    let spread: f64 = points.iter().map(|p| (p.2 - left * p.1).powi(2)).sum();
    let sigma = (spread * n / (n - 1.0).max(1.0)).sqrt() / total;
    let closed = 1.0 - left;
    (
        closed,
        [closed - 1.96 * sigma, (closed + 1.96 * sigma).min(1.0)],
    )
}

fn causes(found: &Findings, last: &Final) -> Vec<Cause> {
    let statistics = found.statistics;
    let share = |after: f64| {
        if statistics.before > 0.0 {
            (1.0 - after / statistics.before).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    };
    let lens = &found.lens.scale();
    let mut causes: Vec<Cause> = found
        .singles
        .iter()
        .zip(&found.decision.singles)
        .map(|(single, probability)| {
            let effect = single.hypothesis.parts[0].0;
            let id = effect.id();
            // An effect that was added is shown as it was added.
            let chosen = last.hypothesis.ids().contains(&id);
            let parameters = if chosen {
                values(
                    &last.hypothesis,
                    &last.theta,
                    &last.sigma,
                    id,
                    found.channels,
                )
            } else if single.acts_as.is_some() {
                // They stand where the search began.
                Vec::new()
            } else {
                let sigma = single.sigma();
                values(
                    &single.hypothesis,
                    &single.theta,
                    &sigma,
                    id,
                    found.channels,
                )
            };
            let values = &parameters;
            let amount = effect.fitted_amount(Fitted { values, lens });
            let gap_closed = share(single.after);
            let part = found.search.part(single.scored_on);
            let (_, [low, high]) = closed(&part.tiles, &part.gaps, &single.linear.gaps);
            let half = (high - low) / 2.0;
            Cause {
                effect: id,
                probability: *probability,
                gap_closed,
                gap_closed_ci95: [gap_closed - half, (gap_closed + half).min(1.0)],
                amount: amount.unwrap_or_default(),
                parameters,
            }
        })
        .collect();
    let not_fitted = |effect, probability| Cause {
        effect,
        probability,
        gap_closed: 0.0,
        gap_closed_ci95: [0.0; 2],
        amount: String::new(),
        parameters: Vec::new(),
    };
    causes.push(not_fitted("unknown", found.decision.unknown));
    causes.extend(found.left.iter().map(|effect| not_fitted(effect.id(), 0.0)));
    causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    causes
}

/// The values of effect `id` in `hypothesis`; those that are not free are given as they stand.
fn values(
    hypothesis: &Hypothesis,
    theta: &[f64],
    sigma: &[f64],
    id: &str,
    channels: &[PupilChannel],
) -> Vec<FittedValue> {
    let Some(part) = hypothesis.parts.iter().position(|(e, _)| e.id() == id) else {
        return Vec::new();
    };
    let (effect, start) = &hypothesis.parts[part];
    let mut all = Vec::new();
    for (index, parameter) in effect.parameters().iter().enumerate() {
        let mut push = |channel: Option<usize>, value: f64, sigma: f64| {
            all.push(FittedValue {
                name: parameter.name,
                channel: channel.map(|c| channels[c].name.clone()),
                unit: parameter.unit,
                value,
                sigma,
            });
        };
        let own = hypothesis.slots.iter().enumerate();
        let mut free = own
            .filter(|(_, s)| s.part == part && s.parameter == index)
            .peekable();
        if free.peek().is_none() && start.values[index] != parameter.neutral {
            push(None, start.values[index], 0.0);
        }
        for (k, slot) in free {
            push(slot.channel, theta[k], sigma[k]);
        }
    }
    all
}

fn pairs(found: &Findings) -> Vec<Pair> {
    let before = found.statistics.before;
    let pairs = found.joint.iter().zip(&found.decision.joint);
    pairs
        .map(|(joint, probability)| Pair {
            effects: joint.hypothesis.ids(),
            probability: *probability,
            gap_closed: 1.0 - joint.after / before,
        })
        .collect()
}

/// The effects of `added`, the one that closes more of the gap alone first.
fn strongest_first(found: &Findings, added: &Candidate) -> Vec<&'static str> {
    let mut ids = added.hypothesis.ids();
    let rank = |id: &str| {
        found
            .singles
            .iter()
            .position(|s| s.hypothesis.ids() == [id])
    };
    ids.sort_by_key(|id| rank(id));
    ids
}

/// Names the channels and distances of which the added effects raise the gap.
fn worsened(found: &Findings, tiles: &[TileGap]) -> Vec<String> {
    let mut groups: Vec<Vec<&TileGap>> = Vec::new();
    for tile in tiles {
        let same = |group: &&mut Vec<&TileGap>| {
            group[0].channel == tile.channel && group[0].distance == tile.distance
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(tile),
            None => groups.push(vec![tile]),
        }
    }
    let mean = |group: &[&TileGap], gap: fn(&TileGap) -> f64| {
        group.iter().map(|t| gap(t)).sum::<f64>() / group.len() as f64
    };
    let risen = groups.iter().filter_map(|group| {
        let (before, after) = (mean(group, |t| t.before), mean(group, |t| t.after));
        let limit = found.statistics.detection_limit();
        let risen = after > (WORSE_RATIO * before).max(before + limit);
        risen.then(|| {
            format!(
                "the added effects raise the gap of channel {} at {} from {:.1} % to {:.1} %: they may be wrong there",
                group[0].channel,
                group[0].distance,
                100.0 * before,
                100.0 * after
            )
        })
    });
    risen.collect()
}

/// Ratio of the gaps after and before from which on an addition is reported as harmful.
const WORSE_RATIO: f64 = 1.2;

fn remarks(found: &Findings) -> Vec<String> {
    let mut remarks = found.tiles.remarks.clone();
    let mut distances: Vec<f64> = found
        .tiles
        .tiles
        .iter()
        .map(|t| t.point.vergence_per_m)
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    if distances.len() == 1 {
        remarks.extend(one_distance::alike().map(|pair| {
            let [one, other] = pair.map(|id| cause_words(id).title);
            format!(
                "all PSFs are at one distance, where {one} and {other} look alike unless the size of the image changes"
            )
        }));
    }
    if found.set.channels.len() < found.channels.len() {
        remarks.push("the set lacks some of the lens's channels".to_owned());
    }
    remarks
}

/// The worst gaps and some of the middle, no two of one observation. `tiles` are placed for the lens `base`, `placed` for
/// `corrected`.
fn examples(
    tiles: &[&TileData],
    placed: &[&TileData],
    before: &[f64],
    base: (&Hypothesis, &[f64]),
    corrected: (&Hypothesis, &[f64]),
) -> Vec<Example> {
    const WORST: usize = 3;
    const ALL: usize = 6;
    let mut order: Vec<usize> = (0..tiles.len()).collect();
    order.sort_by(|a, b| before[*b].total_cmp(&before[*a]));
    let mut chosen: Vec<usize> = Vec::new();
    let middle = order.len() / 2;
    for &k in order.iter().take(middle).chain(&order[middle..]) {
        let fresh = chosen
            .iter()
            .all(|c| tiles[*c].observation != tiles[k].observation);
        let late = chosen.len() >= WORST && before[k] > before[order[middle]];
        if fresh && !late && chosen.len() < ALL {
            chosen.push(k);
        }
    }
    let mut predictor = TilePredictor::default();
    let mut draw = |(hypothesis, theta): (&Hypothesis, &[f64]), data: &TileData| {
        let values = hypothesis.values(theta, data.of_lens);
        let mut picture = Vec::new();
        predictor.predict(hypothesis, &values, data, Detail::FIT, &mut picture);
        picture
    };
    chosen
        .into_iter()
        .filter_map(|k| {
            let data = tiles[k];
            let corrected = draw(corrected, placed[k]);
            Some(Example {
                tile: k,
                observed: tile(data, &completed(data, &corrected))?,
                predicted: tile(data, &draw(base, data))?,
                corrected: tile(data, &corrected)?,
            })
        })
        .collect()
}

/// Distance along an axis to the valid pixels that fill others, px: a pixel of its colour lies within two of every pixel.
const FILL_REACH_PX: usize = 2;

/// Returns the light of `data` to be looked at: pixels that are not valid, such as other colours of a mosaic, get the
/// `predicted` light and the mean residual of valid ones around.
fn completed(data: &TileData, predicted: &[f64]) -> Vec<f64> {
    let mut light = data.light.clone();
    let residual = data.residual(predicted);
    let (width, height) = data.size;
    for (k, _) in data.counts.iter().enumerate().filter(|(_, c)| !**c) {
        let (x, y) = (k % width, k / width);
        let (mut sum, mut count) = (0.0, 0.0);
        for row in y.saturating_sub(FILL_REACH_PX)..(y + FILL_REACH_PX + 1).min(height) {
            for column in x.saturating_sub(FILL_REACH_PX)..(x + FILL_REACH_PX + 1).min(width) {
                if data.counts[row * width + column] {
                    sum += residual[row * width + column];
                    count += 1.0;
                }
            }
        }
        light[k] = predicted[k] + sum / f64::max(count, 1.0);
    }
    light
}

fn tile(data: &TileData, samples: &[f64]) -> Option<Tile> {
    let samples = samples.iter().map(|v| *v as f32).collect();
    Tile::new(data.size.0, data.size.1, samples).ok()
}
