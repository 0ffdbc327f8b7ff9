//! Settings that an animation table changes by frame: every knob that is a number, scales of channels and the axis offset.

use seidel_core::{ChannelScale, ImagePoint, Knob, Settings, Unit};

use super::look::LookArgs;
use crate::commands::CommandError;
use crate::commands::knobs::{KnobArgs, LensKnobs, NewBlurKnobs, PlateKnobs};
use seidel_image_io::animation::{Animation, Interpolation};
use seidel_image_io::error::FileError;

/// The columns of the axis offset.
const AXIS_OFFSET: [&str; 2] = ["axis-offset.x", "axis-offset.y"];

/// The columns of the pixel to focus on.
const FOCUS_AT: [&str; 2] = ["focus-at.x", "focus-at.y"];

/// Prefix of the columns that scale the blur of a channel.
const CHANNEL_PREFIX: &str = "channel-scale.";

/// Rejects a table with a column that is not an option; `look` are those of the look, where the command has them, and
/// `own` those of the command alone.
pub(super) fn check_columns(
    table: &Animation,
    look: Option<&LookArgs>,
    own: impl Iterator<Item = &'static Knob>,
) -> Result<(), CommandError> {
    look.map_or(Ok(()), |look| look.check_blades(table))?;
    let look = NewBlurKnobs::numbers().filter(|_| look.is_some());
    let knobs = (LensKnobs::numbers()
        .chain(PlateKnobs::numbers())
        .chain(look)
        .chain(own))
    .map(|knob| knob.name);
    let names: Vec<&str> = knobs.chain(AXIS_OFFSET).chain(FOCUS_AT).collect();
    let [x, y] = FOCUS_AT.map(|column| table.names().any(|name| name == column));
    if x != y || (x && table.names().any(|name| name == "focus-distance")) {
        let remedy = "give both, and no column focus-distance";
        let problem = "state one focus together";
        return Err(FileError::new(table.path(), FOCUS_AT.join(", "), problem, remedy).into());
    }
    let is_known = |name: &&str| name.starts_with(CHANNEL_PREFIX) || names.contains(name);
    let Some(unknown) = table.names().find(|name| !is_known(name)) else {
        return Ok(());
    };
    Err(FileError::new(
        table.path(),
        unknown,
        "is not an option that can change by frame",
        format!("use {} or {CHANNEL_PREFIX}NAME", names.join(", ")),
    )
    .into())
}

/// Returns `knobs` with the numbers that `table` has for `frame`.
///
/// # Errors
/// Values out of range.
pub(super) fn at_frame<const SCOPE: usize>(
    knobs: &KnobArgs<SCOPE>,
    table: &Animation,
    frame: i64,
) -> Result<KnobArgs<SCOPE>, FileError> {
    let mut knobs = knobs.clone();
    for knob in KnobArgs::<SCOPE>::numbers() {
        if let Some(value) = table.value(knob.name, frame, interpolation(knob)) {
            knobs.set_number(knob, value).map_err(|e| {
                let place = format!("frame {frame}, {}", knob.name);
                FileError::new(table.path(), place, e.problem, e.remedy)
            })?;
        }
    }
    Ok(knobs)
}

fn interpolation(knob: &Knob) -> Interpolation {
    match knob.number() {
        Some(number) if number.unit == Unit::Distance => Interpolation::Reciprocal,
        _ => Interpolation::Linear,
    }
}

/// Returns the pixel to focus on that `table` has for `frame`.
pub(super) fn focus_point(table: &Animation, frame: i64) -> Option<ImagePoint> {
    let value = |name: &str| table.value(name, frame, Interpolation::Linear);
    let [x, y] = FOCUS_AT.map(value);
    Some(ImagePoint::new(x?, y?))
}

/// Writes the scales of channels and the axis offset that `table` has for `frame` to `settings`.
pub(super) fn put_adjustments(table: &Animation, frame: i64, settings: &mut Settings) {
    let value = |name: &str| table.value(name, frame, Interpolation::Linear);
    let [x, y] = AXIS_OFFSET.map(value);
    let (old_x, old_y) = settings.axis_offset_px;
    settings.axis_offset_px = (x.unwrap_or(old_x), y.unwrap_or(old_y));
    for name in table.names() {
        if let Some(channel) = name.strip_prefix(CHANNEL_PREFIX)
            && let Some(scale) = value(name)
        {
            settings
                .channel_scales
                .retain(|other| other.channel != channel);
            settings.channel_scales.push(ChannelScale {
                channel: channel.to_owned(),
                scale,
            });
        }
    }
}
