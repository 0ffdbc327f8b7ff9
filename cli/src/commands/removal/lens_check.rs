//! Whether the lens blurs as the plate shows it: asked of the first frame of a run, and held to in all.

use std::sync::{Arc, OnceLock};

use clap::ValueEnum;

use super::RemovalArgs;
use crate::commands::CommandError;
use crate::commands::plates::{ReadPlate, Shared, share_of};

/// What becomes of a plate that does not show the blur of its lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum OnDoubt {
    /// Where it shows less, as much as it shows is removed, as by a smaller --amount; where it shows more, that is said
    Adjust,
    /// It is said
    Warn,
    /// It is not looked at
    Off,
}

/// The check of a run's lens.
pub(in crate::commands) struct LensCheck {
    outcome: OnceLock<Outcome>,
    /// Whether frames have others beside them.
    is_sequence: bool,
    /// Whether the blur may be put back by `seidel apply`.
    is_put_back: bool,
}

/// What the first frame showed.
#[derive(Debug, Clone, Copy)]
struct Outcome {
    /// Its blur as a share of the lens's.
    share: f64,
    /// Its number.
    frame: Option<i64>,
}

impl LensCheck {
    /// Of a run over `frames` frames, whose blur may be put back.
    pub(in crate::commands) fn new(frames: usize, is_put_back: bool) -> Self {
        Self {
            outcome: OnceLock::new(),
            is_sequence: frames > 1,
            is_put_back,
        }
    }

    /// Sets the lens of frame `number`, which was `read`, as the first frame asks for; tells whether that is this one.
    /// `progress` is told the share done.
    pub(super) fn settle(
        &self,
        args: &RemovalArgs,
        shared: &Shared,
        (number, read): (Option<i64>, &mut ReadPlate),
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<bool, CommandError> {
        if args.lens_check == OnDoubt::Off {
            return Ok(false);
        }
        // Frames are worked on one after the other, in their order.
        let before = self.outcome.get();
        let outcome = match before {
            Some(outcome) => *outcome,
            None => Outcome {
                share: blur_share(args, shared, read, progress)?,
                frame: number,
            },
        };
        let outcome = *self.outcome.get_or_init(|| outcome);
        let is_first = before.is_none();
        let is_less = args.lens_check == OnDoubt::Adjust && outcome.share < 1.0;
        if is_first && outcome.share != 1.0 {
            let told = self.told(outcome.share, is_less, shared, read);
            read.said.push(told);
        } else if is_less && let Some(frame) = outcome.frame {
            let percent = percent(outcome.share);
            read.said.push(format!(
                "removed {percent} of the lens's blur, as frame {frame} shows it"
            ));
        }
        if is_less {
            read.setup = Arc::new(read.setup.weakened(outcome.share));
        }
        Ok(is_first)
    }

    /// What there is to say of a plate that shows a `share` of the lens's blur, and whether less `is_removed`.
    fn told(&self, share: f64, is_removed: bool, shared: &Shared, read: &ReadPlate) -> String {
        let shown = percent(share);
        let asked = read.setup.adjust.amount;
        let of = match asked == 1.0 {
            true => String::new(),
            false => format!(" at --amount {asked}"),
        };
        let amount = match shared.is_animated("amount") {
            true => format!("the amounts of --animate times {share}"),
            false => format!("--amount {}", share_of(asked, share)),
        };
        let all = match self.is_sequence {
            true => " from all frames",
            false => "",
        };
        // With another lens put on, --amount would go for that as well.
        let remedy = match self.is_put_back {
            true => format!("{amount} removes what is there, if the profile is not right"),
            false => "check its profile".to_owned(),
        };
        let keep = "use --lens-check off if the profile is right";
        let done = if is_removed && self.is_put_back {
            format!("removed that much{all}; put it back with {amount}, or {keep}")
        } else if is_removed {
            format!("removed that much{all}; {keep}")
        } else if share < 1.0 {
            format!("removed all of the lens's{all}, which may ring; {remedy}")
        } else {
            format!("removed no more than the lens's{all}; {remedy}")
        };
        format!("the plate shows about {shown} of the lens's blur{of}: {done}")
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// The blur that the plate shows, as a share of its lens's.
fn blur_share(
    args: &RemovalArgs,
    shared: &Shared,
    read: &ReadPlate,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<f64, CommandError> {
    RemovalArgs::with_light(shared, read, |sight, light| {
        let tell = |share| {
            progress(share);
            true
        };
        let check = args.unblur();
        let found = check.lens_check(&sight.scene, (light, sight.weights), &tell)?;
        Ok(found.blur_share)
    })
}
