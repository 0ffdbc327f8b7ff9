//! What a depth pass holds, told by which guess makes its planes flat: patches vote.

use super::finding::{along_ray_remedy, inversion_remedy};
use super::patches::{GUESSES, Guess, Patch, Sampled, patches};
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};

/// A patch votes for a guess that leaves it this much flatter than another.
const FLATTER: f64 = 0.2;
/// The bend under the worse guess must pass its noise this many times...
const ABOVE_NOISE: f64 = 8.0;
/// ...and this, below which rounding of single precision bends planes.
const LEAST_BEND: f64 = 1e-6;
/// Patches a wrong reading must win, at least.
const LEAST_VOTES: usize = 6;
/// Votes for a wrong reading over votes for the right one, at least.
const MAJORITY: usize = 4;
/// Votes without one against them, from which on so small a share of those that could tell will do:
/// measured scenes are mostly curved, and what is curved hardly ever votes for an inversion.
const UNOPPOSED_VOTES: usize = 24;
const UNOPPOSED_SHARE: f64 = 0.05;
/// Distances along the ray that differ less than this in the corner are not worth a word.
const LEAST_CORNER_ERROR: f64 = 0.003;

/// How many patches a guess must win, as a number and as a share of those that could tell.
struct Quorum {
    votes: usize,
    share: f64,
}

impl Quorum {
    /// Curved things can mimic planes at some perspective: where it is chosen to suit the votes, a
    /// guess that hangs on it needs more of them.
    fn of(guess: Guess, perspective_is_known: bool) -> Self {
        if perspective_is_known || guess == Guess::Inverted {
            Self {
                votes: LEAST_VOTES,
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

/// The wrong meaning that the pass turns out to have.
pub(super) fn meaning(check: &DepthCheck) -> Option<DepthFinding> {
    let sampled = patches(check);
    // Only patches that are bent as read can speak against the reading.
    let bent = sampled.iter().filter(|p| is_bent(p.as_read())).count();
    if bent < LEAST_VOTES {
        return None;
    }
    let near = check
        .view
        .focal_px
        .and_then(|f| best(&sampled, [1.0, 0.85, 1.18].map(|factor| factor * f), true));
    near.or_else(|| best(&sampled, perspectives(check), false))?
        .finding(check)
}

fn is_bent((bend, noise): (f64, f64)) -> bool {
    bend > LEAST_BEND && bend > ABOVE_NOISE * noise
}

/// The verdict of most patches over several perspectives.
fn best(
    sampled: &[Sampled],
    focal_px: impl IntoIterator<Item = f64>,
    known: bool,
) -> Option<Verdict> {
    let verdicts = focal_px.into_iter().filter_map(|f| {
        let seen = sampled.iter().filter_map(|p| p.seen(f));
        Votes::of(seen).verdict(known, f)
    });
    // The first of equals, which is the perspective as given.
    verdicts.reduce(|best, next| {
        if next.patches > best.patches {
            next
        } else {
            best
        }
    })
}

/// Perspectives from half a field of 60 degrees to one of 7.
fn perspectives(check: &DepthCheck) -> impl Iterator<Item = f64> + use<> {
    let half = check.width as f64 / 2.0;
    std::iter::successors(Some(0.58 * half), |f| Some(1.15 * f))
        .take_while(move |f| *f < 8.2 * half)
}

/// What patches say of each pair of guesses.
#[derive(Debug, Default)]
struct Votes {
    /// Patches flatter under the one than under the other: `[winner][loser]`.
    flatter: [[usize; 4]; 4],
    /// Patches clearly bent under the guess or as read: those that could tell.
    telling: [usize; 4],
}

/// A guess that won over the reading.
struct Verdict {
    guess: Guess,
    patches: usize,
    against: usize,
    focal_px: f64,
}

impl Votes {
    fn of(patches: impl Iterator<Item = Patch>) -> Self {
        let mut votes = Self::default();
        for patch in patches {
            let bent = |k: usize| is_bent((patch.bend[k], patch.noise[k]));
            for winner in 0..GUESSES.len() {
                votes.telling[winner] += usize::from(bent(winner) || bent(0));
                for loser in 0..GUESSES.len() {
                    let wins = bent(loser) && patch.bend[winner] < FLATTER * patch.bend[loser];
                    votes.flatter[winner][loser] += usize::from(wins);
                }
            }
        }
        votes
    }

    fn verdict(&self, known: bool, focal_px: f64) -> Option<Verdict> {
        let wins = |k: &usize| {
            let quorum = Quorum::of(GUESSES[*k], known);
            let (patches, against) = (self.flatter[*k][0], self.flatter[0][*k]);
            let unopposed =
                GUESSES[*k] == Guess::Inverted && against == 0 && patches >= UNOPPOSED_VOTES;
            let share = if unopposed {
                UNOPPOSED_SHARE
            } else {
                quorum.share
            };
            patches >= quorum.votes
                && patches > MAJORITY * against
                && patches as f64 >= share * self.telling[*k] as f64
        };
        let best = (1..GUESSES.len()).filter(wins).reduce(|a, b| {
            // Steep planes look flat with the ray's length or without: where both will do, without.
            if self.flatter[b][a] > self.flatter[a][b] {
                b
            } else {
                a
            }
        })?;
        Some(Verdict {
            guess: GUESSES[best],
            patches: self.flatter[best][0],
            against: self.flatter[0][best],
            focal_px,
        })
    }
}

impl Verdict {
    fn finding(&self, check: &DepthCheck) -> Option<DepthFinding> {
        let (patches, against) = (self.patches, self.against);
        let along_ray = self.guess == Guess::InvertedAlongRay;
        let (problem, remedy) = match self.guess {
            Guess::AsRead => return None,
            Guess::AlongRay => {
                let corner_error = corner_error(check, self.focal_px);
                if corner_error < LEAST_CORNER_ERROR {
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
            Guess::Inverted | Guess::InvertedAlongRay => (
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

/// By how much distance along the ray passes that along the axis in the farthest corner, as a share.
fn corner_error(check: &DepthCheck, focal_px: f64) -> f64 {
    let farthest = |size: usize, axis: f64| axis.abs().max((size as f64 - axis).abs()) / focal_px;
    let x = farthest(check.width, check.view.axis.x_px);
    let y = farthest(check.height, check.view.axis.y_px) / check.view.pixel_aspect;
    (1.0 + x * x + y * y).sqrt() - 1.0
}
