//! A check of the lens on the first frame of a run: whether the plate shows as much blur as the lens has.

use std::sync::OnceLock;

use clap::ValueEnum;

use crate::commands::CommandError;
use crate::commands::plates::{LoadedPlate, PlateReader, share_of};

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

/// Whether a frame was the one that is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Checked {
    /// It was.
    Here,
    /// An earlier frame was, or none is.
    Before,
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

    /// Sets the lens of the plate of frame `number` by what the first frame showed, which is this one if none was checked
    /// before. `progress` gets the share done.
    pub(super) fn settle(
        &self,
        on_doubt: OnDoubt,
        reader: &PlateReader,
        number: Option<i64>,
        loaded: &mut LoadedPlate,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Checked, CommandError> {
        if on_doubt == OnDoubt::Off {
            return Ok(Checked::Before);
        }
        // Frames are worked on one after the other, in their order.
        let before = self.outcome.get();
        let outcome = match before {
            Some(outcome) => *outcome,
            None => Outcome {
                share: blur_share(loaded, progress)?,
                frame: number,
            },
        };
        let outcome = *self.outcome.get_or_init(|| outcome);
        let is_less = on_doubt == OnDoubt::Adjust && outcome.share < 1.0;
        if before.is_none() && outcome.share != 1.0 {
            let warning = self.warning(outcome.share, is_less, reader, loaded);
            loaded.warnings.push(warning);
        } else if is_less && let Some(frame) = outcome.frame {
            let percent = percent(outcome.share);
            loaded.warnings.push(format!(
                "removed {percent} of the lens's blur, as frame {frame} shows it"
            ));
        }
        if is_less {
            loaded.set_lens(loaded.lens.weakened(outcome.share)?);
        }
        Ok(match before {
            None => Checked::Here,
            Some(_) => Checked::Before,
        })
    }

    /// The warning about a plate that shows a `share` of the lens's blur, and whether less `is_removed`.
    fn warning(
        &self,
        share: f64,
        is_removed: bool,
        reader: &PlateReader,
        loaded: &LoadedPlate,
    ) -> String {
        let shown = percent(share);
        let asked = loaded.lens.session.settings().amount;
        let of = if asked == 1.0 {
            String::new()
        } else {
            format!(" at --amount {asked}")
        };
        let amount = if reader.is_animated("amount") {
            format!("the amounts of --animate times {share}")
        } else {
            format!("--amount {}", share_of(asked, share))
        };
        let all = if self.is_sequence {
            " from all frames"
        } else {
            ""
        };
        // With another lens put on, --amount would go for that as well.
        let remedy = if self.is_put_back {
            format!("{amount} removes what is there, if the profile is not right")
        } else {
            "check its profile".to_owned()
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
fn blur_share(loaded: &LoadedPlate, progress: &(dyn Fn(f64) + Sync)) -> Result<f64, CommandError> {
    let share = loaded.prepared.blur_share(&|share| {
        progress(share);
        true
    });
    share.map_err(|e| loaded.in_file(e))
}
