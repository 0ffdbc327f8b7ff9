//! The lens of a frame: set, adjusted and focused as the options say, or as a table says for that frame.

use std::path::Path;

use seidel_core::distance::ObjectDistance;
use seidel_core::profile::LensProfile;

use super::adjust::AdjustArgs;
use super::focus::FocusArgs;
use crate::commands::drawing::{Drawing, DrawingArgs};
use crate::commands::{CommandError, short_name};

use crate::files::animation::{Animation, Between};
use seidel_image_io::error::FileError;

/// How a frame's lens is to be.
#[derive(Debug, Clone)]
pub(crate) struct Settings {
    pub(crate) drawing: DrawingArgs,
    pub(crate) adjust: AdjustArgs,
    pub(crate) focus: FocusArgs,
}

/// A frame's lens.
#[derive(Clone)]
pub(crate) struct Setup {
    pub(crate) drawing: Drawing,
    pub(crate) adjust: AdjustArgs,
    pub(crate) focus: FocusArgs,
    /// What the lens was focused at, where that was said.
    pub(crate) focused_at: Option<ObjectDistance>,
    /// How the lens is used, each setting by its name.
    pub(crate) told: Vec<(String, String)>,
}

/// What changes a setting to a value.
type Change = fn(&mut Settings, f64) -> seidel_core::Result<()>;

/// Columns that a table may have; besides, `channel-scale.NAME`.
const COLUMNS: [(&str, Between, Change); 10] = [
    ("amount", Between::Values, |s, v| {
        s.adjust.amount = v;
        Ok(())
    }),
    ("axis-offset.x", Between::Values, |s, v| {
        s.adjust.move_axis(Some(v), None);
        Ok(())
    }),
    ("axis-offset.y", Between::Values, |s, v| {
        s.adjust.move_axis(None, Some(v));
        Ok(())
    }),
    ("focus-distance", Between::Reciprocals, |s, v| {
        s.drawing.focus_distance = Some(ObjectDistance::metres(v)?);
        Ok(())
    }),
    ("f-number", Between::Values, |s, v| {
        s.drawing.f_number = Some(v);
        Ok(())
    }),
    ("sensor-shift-um", Between::Values, |s, v| {
        s.drawing.sensor_shift_um = Some(v);
        Ok(())
    }),
    ("depth-of-field", Between::Values, |s, v| {
        s.focus.depth_of_field = v;
        Ok(())
    }),
    ("front-multiplier", Between::Values, |s, v| {
        s.focus.front_multiplier = v;
        Ok(())
    }),
    ("back-multiplier", Between::Values, |s, v| {
        s.focus.back_multiplier = v;
        Ok(())
    }),
    ("maximum-size", Between::Values, |s, v| {
        s.focus.maximum_size = Some(v);
        Ok(())
    }),
];

/// Columns that scale a channel begin with this.
const CHANNEL: &str = "channel-scale.";

/// Refuses a table with columns that are no options.
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

impl Settings {
    /// The same with what `table` says about `frame`.
    pub(crate) fn at(mut self, table: &Animation, frame: i64) -> Result<Self, CommandError> {
        let in_table = |name: &str, e| {
            let e: seidel_core::Error = e;
            FileError::from_core(table.path(), e.within(&format!("frame {frame}, {name}")))
        };
        for (name, between, change) in COLUMNS {
            if let Some(value) = table.at(name, frame, between) {
                change(&mut self, value).map_err(|e| in_table(name, e))?;
            }
        }
        for name in table.names() {
            if let Some(channel) = name.strip_prefix(CHANNEL)
                && let Some(scale) = table.at(name, frame, Between::Values)
            {
                self.adjust.scale_channel(channel, scale);
            }
        }
        Ok(self)
    }

    /// The settings of the lens of the file `path`, drawn by `model`.
    fn told(&self, path: &Path, model: &str) -> Vec<(String, String)> {
        let named = |name: &str, value: String| (name.to_owned(), value);
        let mut told = vec![
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
        told.extend(self.adjust.told());
        let focus = &self.focus;
        told.extend([
            named("depth-of-field", focus.depth_of_field.to_string()),
            named("front-multiplier", focus.front_multiplier.to_string()),
            named("back-multiplier", focus.back_multiplier.to_string()),
            named("maximum-size", or_none(focus.maximum_size)),
        ]);
        told
    }

    /// Sets the lens that was `measured`, of the file `path`; remarks go to `said`.
    pub(crate) fn open(
        self,
        measured: &LensProfile,
        path: &Path,
        said: &mut Vec<String>,
    ) -> Result<Setup, CommandError> {
        let drawing = self.drawing.set(measured, path, said)?;
        let told = self.told(path, drawing.model.id());
        self.adjust.check(&drawing.predictor)?;
        self.focus.check()?;
        Ok(Setup {
            drawing,
            focused_at: self.drawing.focus_distance,
            told,
            adjust: self.adjust,
            focus: self.focus,
        })
    }
}

impl Setup {
    /// The same as if --amount were `share` of what it is.
    pub(crate) fn weakened(&self, share: f64) -> Self {
        let adjust = self.adjust.weakened(share);
        let changed = adjust.told();
        let told = self.told.iter().map(|(name, value)| {
            let new = changed.iter().find(|(changed, _)| changed == name);
            (name.clone(), new.map_or(value, |(_, new)| new).clone())
        });
        Self {
            told: told.collect(),
            adjust,
            ..self.clone()
        }
    }
}
