//! A lens with the settings of a run, checked before any plate is read.

use seidel_optics::BlurField;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::ImagePoint;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{LensProfile, Provenance};
use seidel_optics::psf::{self, PsfModel};
use seidel_render::{
    AdjustedLens, FocusControls, FocusRange, FocusRemap, LocalKernel, LocalKernels,
    NonSquarePixelLens, Scene, VergencePass,
};

use crate::knobs;
use crate::lens::Lens;
use crate::placement::PlatePlacement;
use crate::plate::PlateGeometry;
use crate::settings::Settings;

/// A lens with [`Settings`] applied: its controls, PSF model and adjustments. All frames with the same settings share it.
#[derive(Clone)]
pub struct LensSession {
    lens: Lens,
    model: &'static dyn PsfModel,
    channel_scales: Vec<f64>,
    focus: FocusControls,
    settings: Settings,
}

/// The optics of a plate, and the focus settings that made its vergences.
pub(crate) struct PlateOptics<'a> {
    pub(crate) scene: Scene<'a>,
    /// Focus range by which the vergences of holdout and background are to be changed; `None` where they stay.
    pub(crate) focus_remap: Option<&'a FocusRemap>,
}

impl LensSession {
    /// Applies `settings` to `lens`, and checks them.
    ///
    /// # Errors
    /// Controls that the lens does not have, an unknown PSF model or one that cannot draw the lens, channels that the
    /// lens lacks, and values out of range.
    pub fn new(lens: &Lens, settings: &Settings) -> Result<Self> {
        knobs::check(settings)?;
        let named = settings.psf_model.as_deref().map(psf::by_id).transpose()?;
        let lens = lens.with_controls(&settings.controls)?;
        let lens = lens.with_look(&settings.look)?;
        let predictor = lens.predictor();
        let model = named.unwrap_or_else(|| predictor.default_model());
        predictor.check_model(model).map_err(unsupported)?;
        if settings.only_chroma && predictor.channel_names().len() == 1 {
            let remedy = "use a lens with R, G and B, or turn only chroma off";
            return Err(unsupported(Error::new(
                "only chroma",
                "needs the differences between channels; the lens has one channel",
                remedy,
            )));
        }
        let focused_at = settings.controls.focus_distance;
        let session = Self {
            model,
            channel_scales: channel_scales(predictor, settings)?,
            focus: FocusControls {
                focus_per_m: focused_at
                    .map_or(settings.focus.focus_per_m, ObjectDistance::vergence_per_m),
                ..settings.focus
            },
            settings: settings.clone(),
            lens,
        };
        session
            .adjusted(session.settings.axis_offset_px)
            .map(|_| ())?;
        Ok(session)
    }

    /// The lens, its controls set.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// The PSF model that draws it.
    pub fn psf_model(&self) -> &'static dyn PsfModel {
        self.model
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns whether `other` blurs every plate alike: it has the same settings and the same lens, wherever that comes from.
    pub fn is_same_as(&self, other: &Self) -> bool {
        let optics = |session: &Self| LensProfile {
            held_out: None,
            provenance: Provenance::default(),
            ..session.lens.profile().clone()
        };
        self.settings == other.settings && optics(self) == optics(other)
    }

    /// Whether the plate stays as it is: the amount is zero.
    pub fn is_neutral(&self) -> bool {
        self.settings.amount == 0.0
    }

    /// Returns the same lens at another `amount`.
    ///
    /// # Errors
    /// An amount outside 0 to 16.
    pub fn with_amount(&self, amount: f64) -> Result<Self> {
        let mut session = self.clone();
        session.settings.amount = amount;
        knobs::check(&session.settings)?;
        Ok(session)
    }

    /// Places a plate of `geometry` in the frame of the lens.
    ///
    /// # Errors
    /// Those of [`PlatePlacement::new`].
    pub fn place(&self, geometry: &PlateGeometry) -> Result<PlatePlacement> {
        PlatePlacement::new(self.lens.frame(), geometry)
    }

    /// Returns where the optical axis meets a plate placed at `placement`, in plate pixels from its first corner.
    pub fn axis(&self, placement: &PlatePlacement) -> ImagePoint {
        placement.axis(self.predictor().frame(), self.settings.axis_offset_px)
    }

    /// Returns the kernel of lens channel `channel` at `at`, plate pixels from the corner of the data window, for an
    /// object at `distance`: where the light of one source pixel lands.
    ///
    /// # Errors
    /// A channel index that the lens lacks, an unknown distance where the blur depends on it, and a kernel too large to
    /// draw.
    pub fn kernel_at(
        &self,
        geometry: &PlateGeometry,
        channel: usize,
        at: (f64, f64),
        distance: ObjectDistance,
    ) -> Result<LocalKernel> {
        let placement = self.place(geometry)?;
        let vergence = VergencePass::Constant(self.predictor().vergence(distance)?);
        self.with_optics(&placement, vergence, |optics| {
            // The kernel needs the point alone, not the plate around it.
            let scene = Scene {
                width: 1,
                height: 1,
                ..optics.scene
            };
            let mut weights = vec![0.0; scene.lens.channel_count()];
            let count = weights.len();
            *weights.get_mut(channel).ok_or_else(|| {
                Error::new(
                    "channel",
                    format!("is {channel}"),
                    format!("give one of the lens's {count}, counted from 0"),
                )
            })? = 1.0;
            LocalKernels::new(&scene, &weights)?.at(at)
        })
    }

    /// Returns how far the light of a pixel reaches along x and along y, by bloom and blur, plate pixels, for a plate at one
    /// `distance`.
    ///
    /// # Errors
    /// An unknown distance where the blur depends on it.
    pub fn reach_px(
        &self,
        geometry: &PlateGeometry,
        distance: ObjectDistance,
    ) -> Result<(f64, f64)> {
        let placement = self.place(geometry)?;
        let vergence = VergencePass::Constant(self.predictor().vergence(distance)?);
        self.with_optics(&placement, vergence, |optics| {
            Ok(self.reach_of(&placement, &optics.scene))
        })
    }

    /// Returns how far the light of a pixel reaches along x and along y by bloom and by the blur of `scene`, plate pixels.
    pub(crate) fn reach_of(&self, placement: &PlatePlacement, scene: &Scene) -> (f64, f64) {
        let (x, y) = scene.reach_px();
        let bloom = self.settings.bloom.filter(|_| !self.is_neutral());
        let spread = bloom.map(|bloom| bloom.reach_px(self.frame_px(placement)));
        spread.map_or((x, y), |(across, down)| (x + across, y + down))
    }

    /// Returns the width of the lens's frame along x and along y, plate pixels.
    pub(crate) fn frame_px(&self, placement: &PlatePlacement) -> [f64; 2] {
        let width = f64::from(self.predictor().frame().width_px()) * placement.map.scale;
        [width / placement.sensor_aspect, width]
    }

    /// Returns the range of distances in focus.
    ///
    /// # Errors
    /// Those of [`FocusRange::new`].
    pub(crate) fn focus_range(&self) -> Result<FocusRange> {
        FocusRange::new(&self.adjusted((0.0, 0.0))?, &self.focus)
    }

    pub(crate) fn predictor(&self) -> &Predictor {
        self.lens.predictor()
    }

    /// Calls `then` with the optics of a plate at `placement` whose object vergences are `vergence`, changed by the
    /// focus settings. The edges of the scene are mirrored.
    ///
    /// # Errors
    /// Focus settings that cannot be followed, and those of `then`.
    pub(crate) fn with_optics<T>(
        &self,
        placement: &PlatePlacement,
        vergence: VergencePass,
        then: impl FnOnce(&PlateOptics) -> Result<T>,
    ) -> Result<T> {
        let (map, aspect) = (placement.map, placement.sensor_aspect);
        let (x, y) = self.settings.axis_offset_px;
        let adjusted = self.adjusted((x / (map.scale / aspect), y / map.scale))?;
        let non_square = if aspect == 1.0 {
            None
        } else {
            Some(NonSquarePixelLens::new(&adjusted, aspect)?)
        };
        let lens: &dyn BlurField = match &non_square {
            Some(lens) => lens,
            None => &adjusted,
        };
        let focus_remap = if self.focus.is_neutral() {
            None
        } else {
            Some(FocusRemap::new(lens, placement.extent, &self.focus)?)
        };
        let refocused = refocus(focus_remap.as_ref(), vergence);
        then(&PlateOptics {
            scene: Scene {
                lens,
                model: self.model,
                width: placement.width,
                height: placement.height,
                map,
                vergence: refocused.pass(),
                edges: seidel_render::Edges::Mirror,
                displacement: self.settings.displacement,
            },
            focus_remap: focus_remap.as_ref(),
        })
    }

    fn adjusted(&self, axis_offset_px: (f64, f64)) -> Result<AdjustedLens<'_>> {
        AdjustedLens::new(
            self.predictor(),
            self.settings.amount,
            self.channel_scales.clone(),
            axis_offset_px,
        )
    }
}

/// Vergences, changed by focus settings if there are any.
pub(crate) enum FocusedVergence<'v> {
    Unchanged(VergencePass<'v>),
    Constant(f64),
    PerPixel(Vec<f32>),
}

impl FocusedVergence<'_> {
    pub(crate) fn pass(&self) -> VergencePass<'_> {
        match self {
            Self::Unchanged(vergence) => *vergence,
            Self::Constant(vergence) => VergencePass::Constant(*vergence),
            Self::PerPixel(pass) => VergencePass::PerPixel(pass),
        }
    }
}

/// Changes vergences by the focus settings of `range`, if any.
pub(crate) fn refocus<'v>(
    range: Option<&FocusRemap>,
    vergence: VergencePass<'v>,
) -> FocusedVergence<'v> {
    let Some(range) = range else {
        return FocusedVergence::Unchanged(vergence);
    };
    match vergence {
        VergencePass::Constant(vergence) => FocusedVergence::Constant(range.vergence(vergence)),
        VergencePass::PerPixel(pass) => {
            let refocused = pass.iter().map(|v| range.vergence(f64::from(*v)) as f32);
            FocusedVergence::PerPixel(refocused.collect())
        }
    }
}

fn unsupported(error: Error) -> Error {
    error.with_kind(ErrorKind::Unsupported)
}

/// The scale of each channel of `lens`.
fn channel_scales(lens: &Predictor, settings: &Settings) -> Result<Vec<f64>> {
    let names = lens.channel_names();
    let mut scales = vec![1.0; names.len()];
    for entry in &settings.channel_scales {
        let index = names.iter().position(|name| *name == entry.channel);
        let index = index.ok_or_else(|| {
            Error::new(
                format!("channel scale {}", entry.channel),
                "names no channel of the lens",
                format!("the lens has {}", names.join(", ")),
            )
        })?;
        scales[index] = entry.scale;
    }
    Ok(scales)
}
