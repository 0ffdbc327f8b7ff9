//! A check of the lens on the first frame of a run: whether the plate shows as much blur as the lens has.

use std::sync::OnceLock;

use clap::ValueEnum;
use seidel_core::Progress;

use crate::commands::CommandError;
use crate::commands::plates::{LoadedPlate, PlateReader, scaled_amount};

/// The action if a plate does not show the blur of its lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum OnMismatch {
    /// Remove no more blur than the plate shows, as with a smaller --amount; warn if it shows more than the lens has
    Adjust,
    /// Warn only
    Warn,
    /// Skip the check
    Off,
}

/// The task of a run that removes blur; remedies in warnings depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::commands) enum Task {
    /// The blur is removed, and `seidel apply` may restore it with the same `--amount`.
    Remove,
    /// The blur is replaced by that of another lens, to which `--amount` applies as well.
    Relens,
}

/// The check of the lens of a run.
pub(super) struct LensCheck {
    action: OnMismatch,
    first: OnceLock<FirstFrame>,
    is_sequence: bool,
    task: Task,
}

/// The result on the first frame.
#[derive(Debug, Clone, Copy)]
struct FirstFrame {
    /// Blur of the plate as a share of the lens's blur.
    share: f64,
    /// Number of the frame.
    number: Option<i64>,
}

impl LensCheck {
    /// Creates the check of a run over `frame_count` frames.
    pub(super) fn new(action: OnMismatch, frame_count: usize, task: Task) -> Self {
        Self {
            action,
            first: OnceLock::new(),
            is_sequence: frame_count > 1,
            task,
        }
    }

    /// Returns whether the next frame is to be checked.
    pub(super) fn is_due(&self) -> bool {
        self.action != OnMismatch::Off && self.first.get().is_none()
    }

    /// Scales the lens of `loaded`, frame `number`, by the share of blur that the first frame shows. Checks this frame if
    /// it is the first. Adds warnings to the plate.
    ///
    /// # Errors
    /// Those of the check, cancellation by `progress` among them.
    pub(super) fn set_lens(
        &self,
        reader: &PlateReader,
        number: Option<i64>,
        loaded: &mut LoadedPlate,
        progress: &Progress,
    ) -> Result<(), CommandError> {
        if self.action == OnMismatch::Off {
            return Ok(());
        }
        // Frames are processed in sequence, so that no other thread checks at the same time.
        let earlier = self.first.get();
        let first = match earlier {
            Some(first) => *first,
            None => {
                let share = loaded.prepared.blur_share(progress);
                let share = share.map_err(|e| loaded.in_file(e))?;
                *self.first.get_or_init(|| FirstFrame { share, number })
            }
        };
        let share = first.share;
        let is_scaled = self.action == OnMismatch::Adjust && share < 1.0;
        if earlier.is_none() && share != 1.0 {
            let warning = self.warning(share, is_scaled, reader, loaded);
            loaded.warnings.push(warning);
        } else if is_scaled && let Some(frame) = first.number {
            let percent = percent(share);
            loaded.warnings.push(format!(
                "removed {percent} of the lens's blur, as frame {frame} shows it"
            ));
        }
        if is_scaled {
            loaded.set_lens(loaded.lens.with_amount_scaled(share)?);
        }
        Ok(())
    }

    /// Returns the warning about a plate that shows a `share` of the lens's blur, with the lens scaled to it or not.
    fn warning(
        &self,
        share: f64,
        is_scaled: bool,
        reader: &PlateReader,
        loaded: &LoadedPlate,
    ) -> String {
        let shown = percent(share);
        let requested = loaded.lens.session.settings().amount;
        let at_amount = if requested == 1.0 {
            String::new()
        } else {
            format!(" at --amount {requested}")
        };
        let amount = if reader.is_animated("amount") {
            format!("the amounts of --animate times {share}")
        } else {
            format!("--amount {}", scaled_amount(requested, share))
        };
        let all = if self.is_sequence {
            " from all frames"
        } else {
            ""
        };
        let remedy = match self.task {
            Task::Remove => format!("{amount} removes what is there, if the profile is not right"),
            Task::Relens => "check its profile".to_owned(),
        };
        let keep = "use --lens-check off if the profile is right";
        let action = match (is_scaled, self.task) {
            (true, Task::Remove) => {
                format!("removed that much{all}; put it back with {amount}, or {keep}")
            }
            (true, Task::Relens) => format!("removed that much{all}; {keep}"),
            (false, _) if share < 1.0 => {
                format!("removed all of the lens's{all}, which may ring; {remedy}")
            }
            (false, _) => format!("removed no more than the lens's{all}; {remedy}"),
        };
        format!("the plate shows about {shown} of the lens's blur{at_amount}: {action}")
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
