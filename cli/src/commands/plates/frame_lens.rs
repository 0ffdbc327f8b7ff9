//! The lens of a frame: set, adjusted and focused by the options, or by the animation table for that frame.

use std::path::Path;
use std::sync::Arc;

use seidel_core::profile::LensProfile;
use seidel_core::{LensSession, ObjectDistance, Settings};

use super::adjust::AdjustArgs;
use super::focus::FocusArgs;
use crate::commands::drawing::DrawingArgs;
use crate::commands::{CommandError, short_name};
use seidel_image_io::animation::{Animation, Interpolation};
use seidel_image_io::error::FileError;

/// The options about the lens, with the values of one frame.
#[derive(Debug, Clone)]
pub(crate) struct LensOptions {
    pub(crate) drawing: DrawingArgs,
    pub(crate) adjust: AdjustArgs,
    pub(crate) focus: FocusArgs,
}

/// The lens of a frame.
#[derive(Clone)]
pub(crate) struct FrameLens {
    /// The lens and the settings that render with it.
    pub(crate) session: Arc<LensSession>,
    adjust: AdjustArgs,
    /// The settings of the lens by name, for provenance and residuals.
    pub(crate) record: Vec<(String, String)>,
}

/// A change of one option to a value.
type Change = fn(&mut LensOptions, f64) -> seidel_core::Result<()>;

/// Columns of an animation table, their interpolation and the option they change; `channel-scale.NAME` is one more.
const COLUMNS: [(&str, Interpolation, Change); 10] = [
    ("amount", Interpolation::Linear, |s, v| {
        s.adjust.amount = v;
        Ok(())
    }),
    ("axis-offset.x", Interpolation::Linear, |s, v| {
        s.adjust.move_axis(Some(v), None);
        Ok(())
    }),
    ("axis-offset.y", Interpolation::Linear, |s, v| {
        s.adjust.move_axis(None, Some(v));
        Ok(())
    }),
    ("focus-distance", Interpolation::Reciprocal, |s, v| {
        s.drawing.focus_distance = Some(ObjectDistance::metres(v)?);
        Ok(())
    }),
    ("f-number", Interpolation::Linear, |s, v| {
        s.drawing.f_number = Some(v);
        Ok(())
    }),
    ("sensor-shift-um", Interpolation::Linear, |s, v| {
        s.drawing.sensor_shift_um = Some(v);
        Ok(())
    }),
    ("depth-of-field", Interpolation::Linear, |s, v| {
        s.focus.depth_of_field = v;
        Ok(())
    }),
    ("front-multiplier", Interpolation::Linear, |s, v| {
        s.focus.front_multiplier = v;
        Ok(())
    }),
    ("back-multiplier", Interpolation::Linear, |s, v| {
        s.focus.back_multiplier = v;
        Ok(())
    }),
    ("maximum-size", Interpolation::Linear, |s, v| {
        s.focus.maximum_size = Some(v);
        Ok(())
    }),
];

/// Prefix of the columns that scale a channel.
const CHANNEL: &str = "channel-scale.";

/// Rejects a table with a column that is not an option.
pub(crate) fn check_names(table: &Animation) -> Result<(), CommandError> {
    let known = |name: &str| {
        name.starts_with(CHANNEL) || COLUMNS.iter().any(|(column, _, _)| *column == name)
    };
    let Some(bad) = table.names().find(|name| !known(name)) else {
        return Ok(());
    };
    let names: Vec<&str> = COLUMNS.iter().map(|(name, _, _)| *name).collect();
    Err(FileError::new(
        table.path(),
        bad,
        "is no option that can change by frame",
        format!("there are {} and {CHANNEL}NAME", names.join(", ")),
    )
    .into())
}

fn or_as_measured(value: Option<impl ToString>) -> String {
    value.map_or_else(|| "as measured".to_owned(), |value| value.to_string())
}

fn or_none(value: Option<f64>) -> String {
    value.map_or_else(|| "none".to_owned(), |value| value.to_string())
}

impl LensOptions {
    /// Returns the options with the values of `table` for `frame`.
    pub(crate) fn at(mut self, table: &Animation, frame: i64) -> Result<Self, CommandError> {
        let in_table = |name: &str, e: seidel_core::Error| {
            FileError::from_core(table.path(), e.within(&format!("frame {frame}, {name}")))
        };
        for (name, interpolation, change) in COLUMNS {
            if let Some(value) = table.value(name, frame, interpolation) {
                change(&mut self, value).map_err(|e| in_table(name, e))?;
            }
        }
        for name in table.names() {
            if let Some(channel) = name.strip_prefix(CHANNEL)
                && let Some(scale) = table.value(name, frame, Interpolation::Linear)
            {
                self.adjust.scale_channel(channel, scale);
            }
        }
        Ok(self)
    }

    /// The settings of the lens by name; its profile is the file `path`, its PSF model `model`.
    fn record(&self, path: &Path, model: &str) -> Vec<(String, String)> {
        let named = |name: &str, value: String| (name.to_owned(), value);
        let mut record = vec![
            named("lens", short_name(path)),
            named("psf", model.to_owned()),
            named(
                "focus-distance",
                or_as_measured(self.drawing.focus_distance),
            ),
            named("f-number", or_as_measured(self.drawing.f_number)),
            named(
                "sensor-shift-um",
                or_as_measured(self.drawing.sensor_shift_um),
            ),
        ];
        record.extend(self.adjust.record());
        let focus = &self.focus;
        record.extend([
            named("depth-of-field", focus.depth_of_field.to_string()),
            named("front-multiplier", focus.front_multiplier.to_string()),
            named("back-multiplier", focus.back_multiplier.to_string()),
            named("maximum-size", or_none(focus.maximum_size)),
        ]);
        record
    }

    /// Sets the lens `measured`, read from the file `path`; `base` has the settings that are not about the lens. Adds to
    /// `warnings`.
    pub(crate) fn set(
        self,
        measured: &LensProfile,
        path: &Path,
        base: &Settings,
        warnings: &mut Vec<String>,
    ) -> Result<FrameLens, CommandError> {
        let drawing = self.drawing.set(measured, path, warnings)?;
        let mut settings = base.clone();
        settings.psf_model = Some(drawing.model.id().to_owned());
        settings.amount = self.adjust.amount;
        settings.channel_scales = self.adjust.channel_scales();
        settings.axis_offset_px = self.adjust.axis_offset_px();
        settings.focus = self.focus.controls(self.drawing.focus_distance);
        Ok(FrameLens {
            session: Arc::new(LensSession::new(&drawing.lens, &settings)?),
            record: self.record(path, drawing.model.id()),
            adjust: self.adjust,
        })
    }
}

impl FrameLens {
    /// Returns the lens at `share` of its amount.
    pub(crate) fn weakened(&self, share: f64) -> Result<Self, CommandError> {
        let adjust = self.adjust.weakened(share);
        let changed = adjust.record();
        let record = self.record.iter().map(|(name, value)| {
            let new = changed.iter().find(|(changed, _)| changed == name);
            (name.clone(), new.map_or(value, |(_, new)| new).clone())
        });
        Ok(Self {
            session: Arc::new(self.session.with_amount(adjust.amount)?),
            record: record.collect(),
            adjust,
        })
    }
}
