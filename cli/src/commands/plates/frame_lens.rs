//! The lens of a frame: set, adjusted and focused by the options, or by the animation table for that frame.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use seidel_core::profile::LensProfile;
use seidel_core::{ErrorKind, LensSession, ObjectDistance, Settings};

use super::adjust::AdjustArgs;
use super::focus::FocusArgs;
use super::look::{self, LookArgs, look_record};
use super::{SettingsRecord, setting};
use crate::commands::drawing::DrawingArgs;
use crate::commands::{CommandError, short_name};
use seidel_image_io::animation::{Animation, Interpolation};
use seidel_image_io::error::FileError;

/// Options about the lens of a plate.
#[derive(Debug, Args)]
pub(crate) struct LensArgs {
    #[command(flatten)]
    pub(super) options: LensOptions,
    /// Table of values by frame of --amount, --focus-distance, --f-number and others; interpolated between its frames
    ///
    /// CSV with a column `frame` and one column per option, or JSON. The numbers of the look are among them, but not --blades.
    #[arg(long, help_heading = "Look", value_name = "FILE")]
    pub(super) animate: Option<PathBuf>,
}

/// The options about the lens that an animation table can change.
#[derive(Debug, Clone, Args)]
pub(super) struct LensOptions {
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    focus: FocusArgs,
    #[command(flatten)]
    adjust: AdjustArgs,
}

/// The lens of a frame.
#[derive(Clone)]
pub(crate) struct FrameLens {
    /// The lens with the settings of the render.
    pub(crate) session: Arc<LensSession>,
    adjust: AdjustArgs,
    /// The settings of the lens by name.
    pub(super) record: SettingsRecord,
}

/// A column of an animation table.
struct Column {
    name: &'static str,
    interpolation: Interpolation,
    /// Sets the option to a value.
    set: fn(&mut LensOptions, f64) -> seidel_core::Result<()>,
}

impl Column {
    const fn linear(
        name: &'static str,
        set: fn(&mut LensOptions, f64) -> seidel_core::Result<()>,
    ) -> Self {
        Self {
            name,
            interpolation: Interpolation::Linear,
            set,
        }
    }
}

/// The columns of animation tables; `channel-scale.NAME` is one more.
const COLUMNS: [Column; 11] = [
    Column::linear("amount", |options, value| {
        options.adjust.amount = value;
        Ok(())
    }),
    Column::linear("axis-offset.x", |options, value| {
        options.adjust.set_axis_offset(Some(value), None);
        Ok(())
    }),
    Column::linear("axis-offset.y", |options, value| {
        options.adjust.set_axis_offset(None, Some(value));
        Ok(())
    }),
    Column {
        name: "focus-distance",
        interpolation: Interpolation::Reciprocal,
        set: |options, value| {
            options.drawing.focus_distance = Some(ObjectDistance::metres(value)?);
            Ok(())
        },
    },
    Column::linear("f-number", |options, value| {
        options.drawing.f_number = Some(value);
        Ok(())
    }),
    Column::linear("focal-length-mm", |options, value| {
        options.drawing.focal_length_mm = Some(value);
        Ok(())
    }),
    Column::linear("sensor-shift-um", |options, value| {
        options.drawing.sensor_shift_um = Some(value);
        Ok(())
    }),
    Column::linear("depth-of-field", |options, value| {
        options.focus.depth_of_field = value;
        Ok(())
    }),
    Column::linear("front-multiplier", |options, value| {
        options.focus.front_multiplier = value;
        Ok(())
    }),
    Column::linear("back-multiplier", |options, value| {
        options.focus.back_multiplier = value;
        Ok(())
    }),
    Column::linear("maximum-size", |options, value| {
        options.focus.maximum_size = Some(value);
        Ok(())
    }),
];

/// Prefix of the columns that scale the blur of a channel.
const CHANNEL_PREFIX: &str = "channel-scale.";

/// Rejects a table with a column that is not an option; `look` are those of the look, `None` where a command has none.
pub(super) fn check_columns(
    table: &Animation,
    look: Option<&LookArgs>,
) -> Result<(), CommandError> {
    let of_look = look.map_or(&[][..], |_| &look::COLUMNS);
    let names: Vec<&str> = (COLUMNS.iter().map(|column| column.name))
        .chain(of_look.iter().map(|column| column.name))
        .collect();
    if look.is_some_and(|look| look.lacks_blades(table)) {
        return Err(FileError::new(
            table.path(),
            "roundness, rotation",
            "change no blades",
            "give --blades as well",
        )
        .into());
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

fn or_as_measured(value: Option<impl ToString>) -> String {
    value.map_or_else(|| "as measured".to_owned(), |value| value.to_string())
}

impl LensOptions {
    /// Returns the options with the values of `table` for `frame`.
    pub(super) fn at_frame(&self, table: &Animation, frame: i64) -> Result<Self, CommandError> {
        let mut options = self.clone();
        for column in &COLUMNS {
            if let Some(value) = table.value(column.name, frame, column.interpolation) {
                (column.set)(&mut options, value).map_err(|e| {
                    let place = format!("frame {frame}, {}", column.name);
                    FileError::from_core(table.path(), e.within(&place))
                })?;
            }
        }
        for name in table.names() {
            if let Some(channel) = name.strip_prefix(CHANNEL_PREFIX)
                && let Some(scale) = table.value(name, frame, Interpolation::Linear)
            {
                options.adjust.set_channel_scale(channel, scale);
            }
        }
        Ok(options)
    }

    /// Returns the settings by name of the lens in the file `path`, drawn by the PSF model `model`.
    fn record(&self, path: &Path, model: &str) -> SettingsRecord {
        let (drawing, focus) = (&self.drawing, &self.focus);
        let mut record = vec![
            setting("lens", short_name(path)),
            setting("psf", model),
            setting("focus-distance", or_as_measured(drawing.focus_distance)),
            setting("f-number", or_as_measured(drawing.f_number)),
            setting("focal-length-mm", or_as_measured(drawing.focal_length_mm)),
            setting("sensor-shift-um", or_as_measured(drawing.sensor_shift_um)),
        ];
        record.extend(self.adjust.record());
        let maximum_size = focus.maximum_size;
        let maximum_size = maximum_size.map_or_else(|| "none".to_owned(), |px| px.to_string());
        record.extend([
            setting("depth-of-field", focus.depth_of_field),
            setting("front-multiplier", focus.front_multiplier),
            setting("back-multiplier", focus.back_multiplier),
            setting("maximum-size", maximum_size),
        ]);
        record
    }

    /// Sets the lens `measured`, read from the file `path`; `base` has the settings that are not about the lens. Adds to
    /// `warnings`.
    pub(super) fn set(
        &self,
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
        let session = LensSession::new(&drawing.lens, &settings);
        let session = session.map_err(|e| match e.kind() {
            // The lens is at fault, not an option.
            ErrorKind::Unsupported => FileError::from_core(path, e).into(),
            _ => CommandError::from(e),
        })?;
        let mut record = self.record(path, drawing.model.id());
        record.extend(look_record(&settings));
        Ok(FrameLens {
            session: Arc::new(session),
            record,
            adjust: self.adjust.clone(),
        })
    }
}

impl FrameLens {
    /// Returns the lens with its amount multiplied by `factor`.
    pub(crate) fn with_amount_scaled(&self, factor: f64) -> Result<Self, CommandError> {
        let adjust = self.adjust.with_amount_scaled(factor);
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
