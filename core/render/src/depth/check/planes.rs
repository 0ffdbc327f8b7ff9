//! Detection of a wrong reading of a depth pass: smooth patches vote for the reading that makes them planar.

use super::finding::{along_ray_remedy, inversion_remedy};
use super::patches::{Patch, READINGS, Reading, Sampled, patches};
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};
use rayon::prelude::*;

/// Largest ratio of the curvature under the winning reading to that under the losing one.
const FLATTER: f64 = 0.2;
/// Least curvature under the losing reading, as a multiple of its noise...
const ABOVE_NOISE: f64 = 8.0;
/// ...and absolutely: single-precision rounding bends planes by less.
const MIN_BEND: f64 = 1e-6;
/// Least number of votes for a wrong reading.
const MIN_VOTES: usize = 6;
/// Least ratio of votes for a wrong reading to votes for the stated one.
const MAJORITY: usize = 4;
/// Number of unopposed votes for an inversion from which a smaller share is enough: measured scenes are mostly curved,
/// and curved patches hardly ever vote for an inversion.
const UNOPPOSED_VOTES: usize = 24;
const UNOPPOSED_SHARE: f64 = 0.05;
/// Least relative error in the corner for which distances along the ray are reported.
const MIN_CORNER_ERROR: f64 = 0.003;

/// The votes that a reading needs.
struct Quorum {
    /// Number of votes.
    votes: usize,
    /// Share of the patches that could vote for it.
    share: f64,
}

impl Quorum {
    /// Curved surfaces can mimic planes at some perspective. Where the perspective is searched, readings that depend on
    /// it need more votes.
    fn new(reading: Reading, perspective: Perspective) -> Self {
        if perspective == Perspective::Known || reading == Reading::Inverted {
            Self {
                votes: MIN_VOTES,
                share: 0.2,
            }
        } else {
            Self {
                votes: 12,
                share: 0.5,
            }
        }
    }
}

/// Returns the finding of a wrong reading, if any.
pub(super) fn wrong_reading(check: &DepthCheck) -> Option<DepthFinding> {
    // Only patches that are curved in the stated reading speak against it.
    let (bent, flat): (Vec<_>, Vec<_>) = patches(check).into_iter().partition(|patch| {
        let (bend, noise) = patch.as_stated();
        is_bent(bend, noise)
    });
    if bent.len() < MIN_VOTES {
        return None;
    }
    let sampled = SampledPatches { bent, flat };
    let near = check.view.focal_px.and_then(|f| {
        let nearby = [1.0, 0.85, 1.18].map(|factor| factor * f);
        best(&sampled, &nearby, Perspective::Known)
    });
    near.or_else(|| best(&sampled, &perspectives(check), Perspective::Searched))?
        .finding(check)
}

fn is_bent(bend: f64, noise: f64) -> bool {
    bend > MIN_BEND && bend > ABOVE_NOISE * noise
}

/// Knowledge of the camera's perspective.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Perspective {
    Known,
    Searched,
}

/// The patches of a pass that are curved in the stated reading, and the others.
struct SampledPatches {
    bent: Vec<Sampled>,
    flat: Vec<Sampled>,
}

impl SampledPatches {
    /// Returns the verdict at a focal length of `focal_px`.
    fn verdict(&self, focal_px: f64, perspective: Perspective) -> Option<Verdict> {
        let at_focal_length = |patch: &Sampled| patch.at_focal_length(focal_px);
        let mut votes = Votes::default();
        votes.add(self.bent.par_iter().filter_map(at_focal_length).collect());
        // The others vote against other readings alone: mostly they need not be asked.
        votes.verdict(perspective, focal_px)?;
        votes.add(self.flat.par_iter().filter_map(at_focal_length).collect());
        votes.verdict(perspective, focal_px)
    }
}

/// Returns the verdict with the most votes over several focal lengths.
fn best(sampled: &SampledPatches, focal_px: &[f64], perspective: Perspective) -> Option<Verdict> {
    let verdicts = focal_px
        .par_iter()
        .map(|f| sampled.verdict(*f, perspective));
    let verdicts: Vec<Option<Verdict>> = verdicts.collect();
    // The first of equals: the focal length as given.
    verdicts.into_iter().flatten().reduce(|best, next| {
        if next.patches > best.patches {
            next
        } else {
            best
        }
    })
}

/// Returns focal lengths for half fields from 60 to 7 degrees, px.
fn perspectives(check: &DepthCheck) -> Vec<f64> {
    let half = check.width as f64 / 2.0;
    std::iter::successors(Some(0.58 * half), |f| Some(1.15 * f))
        .take_while(|f| *f < 8.2 * half)
        .collect()
}

/// The votes of patches between each pair of readings.
#[derive(Debug, Default)]
struct Votes {
    /// Patches clearly flatter under one than under the other: `[winner][loser]`.
    flatter: [[usize; 4]; 4],
    /// Patches clearly curved under the reading or the stated one: those that could vote.
    voters: [usize; 4],
}

/// A reading that won over the stated one.
struct Verdict {
    reading: Reading,
    patches: usize,
    against: usize,
    focal_px: f64,
}

impl Votes {
    /// Counts the votes of `patches`.
    fn add(&mut self, patches: Vec<Patch>) {
        for patch in patches {
            let bent = |k: usize| is_bent(patch.bend[k], patch.noise[k]);
            for winner in 0..READINGS.len() {
                self.voters[winner] += usize::from(bent(winner) || bent(0));
                for loser in 0..READINGS.len() {
                    let wins = bent(loser) && patch.bend[winner] < FLATTER * patch.bend[loser];
                    self.flatter[winner][loser] += usize::from(wins);
                }
            }
        }
    }

    fn verdict(&self, perspective: Perspective, focal_px: f64) -> Option<Verdict> {
        let wins = |k: &usize| {
            let quorum = Quorum::new(READINGS[*k], perspective);
            let (patches, against) = (self.flatter[*k][0], self.flatter[0][*k]);
            let unopposed =
                READINGS[*k] == Reading::Inverted && against == 0 && patches >= UNOPPOSED_VOTES;
            let share = if unopposed {
                UNOPPOSED_SHARE
            } else {
                quorum.share
            };
            patches >= quorum.votes
                && patches > MAJORITY * against
                && patches as f64 >= share * self.voters[*k] as f64
        };
        let best = (1..READINGS.len()).filter(wins).reduce(|a, b| {
            // Steep planes look flat with the length of the ray or without; without is preferred.
            if self.flatter[b][a] > self.flatter[a][b] {
                b
            } else {
                a
            }
        })?;
        Some(Verdict {
            reading: READINGS[best],
            patches: self.flatter[best][0],
            against: self.flatter[0][best],
            focal_px,
        })
    }
}

impl Verdict {
    fn finding(&self, check: &DepthCheck) -> Option<DepthFinding> {
        let (patches, against) = (self.patches, self.against);
        let along_ray = self.reading == Reading::InvertedAlongRay;
        let (problem, remedy) = match self.reading {
            Reading::Stated => return None,
            Reading::AlongRay => {
                let corner_error = corner_error(check, self.focal_px);
                if corner_error < MIN_CORNER_ERROR {
                    return None;
                }
                let tangent = check.width as f64 / 2.0 / self.focal_px;
                let problem = DepthProblem::AlongRay {
                    patches,
                    against,
                    half_field_deg: libm::atan(tangent).to_degrees(),
                    corner_error,
                };
                (problem, along_ray_remedy(self.focal_px))
            }
            Reading::Inverted | Reading::InvertedAlongRay => (
                DepthProblem::Inverted {
                    patches,
                    against,
                    along_ray,
                },
                if along_ray {
                    let turn = along_ray_remedy(self.focal_px);
                    format!("{}; then {turn}", inversion_remedy(check.convention))
                } else {
                    inversion_remedy(check.convention).to_owned()
                },
            ),
        };
        Some(DepthFinding {
            problem,
            severity: Severity::Warning,
            remedy,
        })
    }
}

/// Returns the relative excess of distance along the ray over that along the axis in the farthest corner.
fn corner_error(check: &DepthCheck, focal_px: f64) -> f64 {
    let farthest = |size: usize, axis: f64| axis.abs().max((size as f64 - axis).abs()) / focal_px;
    let x = farthest(check.width, check.view.axis.x_px);
    let y = farthest(check.height, check.view.axis.y_px) / check.view.pixel_aspect;
    (1.0 + x * x + y * y).sqrt() - 1.0
}
