//! The lens of a frame: set, adjusted and focused by the options, or by the animation table for that frame.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use seidel_core::{
    ErrorKind, ImagePoint, Knob, KnobScope, LensProfile, LensScale, LensSession, ObjectDistance,
    RelensSide, Settings,
};

use super::adjust::{AdjustArgs, adjust_record, scaled_amount};
use super::animated;
use super::look::look_record;
use super::shot_metadata::LensMetadataArgs;
use super::{SettingsRecord, setting};
use crate::commands::drawing::DrawingArgs;
use crate::commands::knobs::PlateKnobs;
use crate::commands::{CommandError, short_name};
use seidel_image_io::animation::Animation;
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
    #[command(flatten)]
    pub(super) metadata: LensMetadataArgs,
}

/// The options about the lens that an animation table can change.
#[derive(Debug, Args)]
pub(super) struct LensOptions {
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    knobs: PlateKnobs,
    #[command(flatten)]
    adjust: AdjustArgs,
}

/// The lens of a frame.
#[derive(Clone)]
pub(crate) struct FrameLens {
    /// The lens with the settings of the render.
    pub(crate) session: Arc<LensSession>,
    /// The settings of the lens by name.
    pub(super) record: SettingsRecord,
}

impl LensArgs {
    /// Returns the `lenses` of a run, each with its role, and the table of lens settings.
    pub(crate) fn files_with<'a>(
        &'a self,
        mut lenses: Vec<(&'static str, &'a Path)>,
    ) -> Vec<(&'static str, &'a Path)> {
        lenses.extend(self.metadata.table().map(|path| ("LensMetadata", path)));
        lenses
    }
}

impl LensOptions {
    /// Returns the first of the options called `names` that is given.
    pub(super) fn given<'n>(&self, names: &[&'n str]) -> Option<&'n str> {
        let is_given = |name: &&str| self.drawing.knobs.is_given(name) || self.knobs.is_given(name);
        names.iter().copied().find(is_given)
    }

    /// Writes the options to `settings`.
    pub(super) fn put(&self, settings: &mut Settings) -> Result<(), CommandError> {
        self.drawing.knobs.put(settings)?;
        self.knobs.put(settings)?;
        self.adjust.put(settings);
        Ok(())
    }

    /// Returns the pixel to focus on, from a `table` for a frame or the options.
    pub(super) fn focus_point(&self, table: Option<(&Animation, i64)>) -> Option<ImagePoint> {
        let animated = table.and_then(|(table, frame)| animated::focus_point(table, frame));
        animated.or(self.adjust.focus_at)
    }

    /// Writes the options with the values of `table` for `frame` to `settings`.
    pub(super) fn put_at_frame(
        &self,
        table: &Animation,
        frame: i64,
        settings: &mut Settings,
    ) -> Result<(), CommandError> {
        animated::at_frame(&self.drawing.knobs, table, frame)?.put(settings)?;
        animated::at_frame(&self.knobs, table, frame)?.put(settings)?;
        self.adjust.put(settings);
        animated::put_adjustments(table, frame, settings);
        Ok(())
    }

    /// Sets the lens `measured`, read from the file `path`, to `settings`, of `side` if it is one of two lenses. Adds to
    /// `warnings`.
    pub(super) fn set(
        &self,
        measured: &LensProfile,
        path: &Path,
        settings: &Settings,
        side: Option<RelensSide>,
        warnings: &mut Vec<String>,
    ) -> Result<FrameLens, CommandError> {
        let given = settings;
        let settings = &side.map_or_else(|| given.clone(), |side| given.of_side(side));
        let drawing = self.drawing.set(measured, path, settings, warnings)?;
        let mut record = vec![
            setting("lens", short_name(path)),
            setting("psf", drawing.model.id()),
        ];
        record.extend(knob_record(given));
        record.extend(adjust_record(settings));
        record.extend(look_record(settings));
        let mut settings = settings.clone();
        settings.psf_model = Some(drawing.model.id().to_owned());
        // The lens is set already.
        let controls = std::mem::take(&mut settings.controls);
        settings.focus.focus_per_m =
            (controls.focus_distance).and_then(ObjectDistance::vergence_per_m);
        let session = LensSession::new(&drawing.lens, &settings);
        let session = session.map_err(|e| match e.kind() {
            // The lens is at fault, not an option.
            ErrorKind::Unsupported => FileError::from_core(path, e).into(),
            _ => CommandError::from(e),
        })?;
        Ok(FrameLens {
            session: Arc::new(session),
            record,
        })
    }
}

/// Returns the knobs of the lens in `settings` by name.
fn knob_record(settings: &Settings) -> impl Iterator<Item = (String, String)> {
    let is_recorded = |knob: &&Knob| match knob.scope {
        KnobScope::Lens | KnobScope::Plates => true,
        KnobScope::Relens => (knob.number()).is_some_and(|number| (number.get)(settings).is_some()),
        _ => false,
    };
    let knobs = Knob::all().filter(is_recorded);
    // Both stand for one setting.
    let knobs = knobs.filter(|knob| knob.name != "film-back-mm");
    knobs.map(|knob| match settings.lens_scale {
        LensScale::FilmBack(width_mm) if knob.name == "lens-scale" => {
            setting(knob.name, format!("film back of {width_mm} mm"))
        }
        _ => setting(knob.name, knob.text(settings)),
    })
}

impl FrameLens {
    /// Returns the lens with its amount multiplied by `factor`.
    pub(crate) fn with_amount_scaled(&self, factor: f64) -> Result<Self, CommandError> {
        let amount = scaled_amount(self.session.settings().amount, factor);
        let mut record = self.record.clone();
        let mut entries = record.iter_mut();
        if let Some((_, text)) = entries.find(|(name, _)| name == "amount") {
            *text = amount.to_string();
        }
        Ok(Self {
            session: Arc::new(self.session.with_amount(amount)?),
            record,
        })
    }
}
