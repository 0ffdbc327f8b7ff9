//! How a lens is used and a plate is read: the options of the command, as one struct that can grow.

use std::ffi::c_char;
use std::sync::Arc;

use seidel_core::{
    AlphaKind, ChannelScale, Controls, DepthConvention, DepthMeaning, Displacement, Edges,
    FocusControls, Grain, LensSession, ObjectDistance, OcclusionSettings, Quality, RemovalSettings,
    Saturation,
};

use crate::guard::guard;
use crate::lens::Lens;
use crate::pointers::{Sized64, maybe_sized, put_sized, text, values};
use crate::status::{Failure, Result, SeidelStatus};

/// Blur alone.
pub const SEIDEL_GEOMETRY_NONE: u32 = 0;
/// Channels displaced against each other, the plate undistorted. The default.
pub const SEIDEL_GEOMETRY_LATERAL: u32 = 1;
/// Distortion and lateral colour.
pub const SEIDEL_GEOMETRY_FULL: u32 = 2;

/// Beyond the plate lies the mirrored plate: no light is lost. The default.
pub const SEIDEL_EDGES_MIRROR: u32 = 0;
/// Beyond the plate lies nothing.
pub const SEIDEL_EDGES_BLACK: u32 = 1;
/// Beyond the plate lies its nearest pixel, with its depth and blur.
pub const SEIDEL_EDGES_NEAREST: u32 = 2;

/// For looking: 45 dB from exact.
pub const SEIDEL_QUALITY_DRAFT: u32 = 0;
/// For delivery: 60 dB from exact; 50 dB for lenses drawn ray by ray. The default.
pub const SEIDEL_QUALITY_FINAL: u32 = 1;
/// Every source pixel with its own kernel: slow.
pub const SEIDEL_QUALITY_EXACT: u32 = 2;

/// Colour is multiplied by alpha. The default.
pub const SEIDEL_ALPHA_PREMULTIPLIED: u32 = 0;
/// Colour is not multiplied by alpha.
pub const SEIDEL_ALPHA_UNPREMULTIPLIED: u32 = 1;

/// Depth is distance along the optical axis, in `depth_unit` metres. The default.
pub const SEIDEL_DEPTH_DISTANCE: u32 = 0;
/// Depth is one over the distance in such units; 0 is infinity.
pub const SEIDEL_DEPTH_INVERSE: u32 = 1;
/// Depth is 0 at `depth_near` and 1 at `depth_far`, distance linear between.
pub const SEIDEL_DEPTH_FAR_ONE: u32 = 2;
/// Depth is 1 at `depth_near` and 0 at `depth_far`, distance linear between.
pub const SEIDEL_DEPTH_FAR_ZERO: u32 = 3;

/// Where the plate is clipped is told from it. The default.
pub const SEIDEL_CLIP_TOLD: u32 = 0;
/// No sample is clipped.
pub const SEIDEL_CLIP_NONE: u32 = 1;
/// Samples of `clip_level` and more are clipped.
pub const SEIDEL_CLIP_LEVEL: u32 = 2;

/// The sharp picture gets the plate's own grain. The default.
pub const SEIDEL_GRAIN_KEEP: u32 = 0;
/// The sharp picture as it was solved for, nearly without grain.
pub const SEIDEL_GRAIN_SOLVED: u32 = 1;

/// How a lens is used and a plate is read. Begin with `seidel_settings_init`. Numbers that say "NaN: ..." may be left
/// NaN. Switches are 0 or 1. The same names are options of the `seidel` command.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelSettings {
    /// sizeof(SeidelSettings).
    pub size: u64,
    /// How strong blur and displacement are: 0 leaves the plate as it is, 1 is as measured, 16 is the most.
    pub amount: f64,
    /// How strong the blur of each channel of the lens is besides, in their order; NULL: all 1.
    pub channel_scales: *const f64,
    /// How many there are: as many as channels, or 0.
    pub channel_scale_count: u32,
    /// SEIDEL_GEOMETRY_...
    pub geometry: u32,
    /// Where the optical axis lies, in plate pixels right of where it would.
    pub axis_offset_x: f64,
    /// The same, below.
    pub axis_offset_y: f64,
    /// PSF model by its name; NULL or "": what suits the lens best.
    pub psf_model: *const c_char,
    /// Focus the lens at this distance, metres, or INFINITY. NaN: as measured.
    pub focus_distance: f64,
    /// Stop the lens down to this f-number. NaN: as measured.
    pub f_number: f64,
    /// Move the sensor away from the lens, micrometres. NaN: as measured.
    pub sensor_shift_um: f64,
    /// Metres about the focus plane in which all is as sharp as on it.
    pub depth_of_field: f64,
    /// How many times as far from focus, in vergence, things before the focus plane are.
    pub front_multiplier: f64,
    /// The same behind it.
    pub back_multiplier: f64,
    /// Largest kernel: the radius of an even disc, plate pixels. NaN: none.
    pub maximum_size: f64,
    /// SEIDEL_QUALITY_...
    pub quality: u32,
    /// SEIDEL_EDGES_...
    pub edges: u32,
    /// Switch: near things hide far ones where depth varies.
    pub occlusion: u32,
    /// Switch: what a blurred foreground uncovers is filled with what is seen beside it.
    pub fill_foreground: u32,
    /// Switch: a blurred foreground becomes transparent within its own outline.
    pub blur_inside: u32,
    /// SEIDEL_ALPHA_...
    pub alpha: u32,
    /// Switch: the alpha of each colour is blurred as its colour, and written to `alphas`.
    pub alpha_per_channel: u32,
    /// Switch: samples that are not finite count as zero, instead of being refused.
    pub scrub: u32,
    /// Plate pixels per pixel of the lens's frame, counted along y. NaN: the format is as wide as the frame.
    pub lens_scale: f64,
    /// Width of a plate pixel over its height.
    pub pixel_aspect: f64,
    /// The one distance of plates without a depth image, metres, or INFINITY. NaN: not known.
    pub distance: f64,
    /// Metres that make up one unit of depth; negative if it counts backwards.
    pub depth_unit: f64,
    /// Nearest distance of a normalised depth, metres.
    pub depth_near: f64,
    /// Farthest distance of a normalised depth, metres.
    pub depth_far: f64,
    /// Focal length in widths of a plate pixel, where distances are along the ray from the camera. NaN: along the axis.
    pub along_ray: f64,
    /// SEIDEL_DEPTH_...
    pub depth_kind: u32,
    /// SEIDEL_CLIP_... (taking blur off)
    pub clip: u32,
    /// Where samples are clipped. (taking blur off)
    pub clip_level: f64,
    /// Standard deviation of the noise of each colour; NaN in the first: estimated from the plate, in others: as the first.
    /// (taking blur off)
    pub noise: [f64; 4],
    /// How much of the way from the plate to the sharp picture to go, 0 to 1. (seidel_remove)
    pub strength: f64,
    /// SEIDEL_GRAIN_... (seidel_remove)
    pub grain: u32,
    /// Most threads to work with; 0: as many as the machine has. No result depends on it.
    pub threads: u32,
    /// Most memory that a call may need, bytes, by `seidel_memory_needed`; 0: any.
    pub memory: u64,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Sized64 for SeidelSettings {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            amount: 1.0,
            channel_scales: std::ptr::null(),
            channel_scale_count: 0,
            geometry: SEIDEL_GEOMETRY_LATERAL,
            axis_offset_x: 0.0,
            axis_offset_y: 0.0,
            psf_model: std::ptr::null(),
            focus_distance: f64::NAN,
            f_number: f64::NAN,
            sensor_shift_um: f64::NAN,
            depth_of_field: 0.0,
            front_multiplier: 1.0,
            back_multiplier: 1.0,
            maximum_size: f64::NAN,
            quality: SEIDEL_QUALITY_FINAL,
            edges: SEIDEL_EDGES_MIRROR,
            occlusion: 1,
            fill_foreground: 1,
            blur_inside: 1,
            alpha: SEIDEL_ALPHA_PREMULTIPLIED,
            alpha_per_channel: 0,
            scrub: 0,
            lens_scale: f64::NAN,
            pixel_aspect: 1.0,
            distance: f64::NAN,
            depth_unit: 1.0,
            depth_near: f64::NAN,
            depth_far: f64::NAN,
            along_ray: f64::NAN,
            depth_kind: SEIDEL_DEPTH_DISTANCE,
            clip: SEIDEL_CLIP_TOLD,
            clip_level: 1.0,
            noise: [f64::NAN; 4],
            strength: 1.0,
            grain: SEIDEL_GRAIN_KEEP,
            threads: 0,
            memory: 0,
        }
    }
}

/// Puts the defaults into `settings`, whose `size` must have been set to sizeof(SeidelSettings).
///
/// # Safety
/// `settings` must point to as many bytes as its `size` says, which can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_settings_init(settings: *mut SeidelSettings) -> SeidelStatus {
    // SAFETY: as the caller vouches.
    guard(|| unsafe { put_sized(settings, &SeidelSettings::neutral(), "settings") })
}

/// Settings found to be sound, as far as they can be without a lens.
#[derive(Debug, Clone)]
pub(crate) struct Settings {
    /// Its pointers are NULL.
    pub(crate) raw: SeidelSettings,
    channel_scales: Vec<f64>,
    model: String,
}

// SAFETY: the two pointers within are NULL: what they point to was copied.
unsafe impl Send for Settings {}

/// Nothing where a number is NaN.
fn given(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

fn metres(value: f64) -> Result<Option<ObjectDistance>> {
    Ok(given(value).map(ObjectDistance::metres).transpose()?)
}

impl Settings {
    /// Those at `settings`, the defaults where it is NULL.
    ///
    /// # Safety
    /// `settings` must be NULL or settings whose pointers are good until the call ends.
    pub(crate) unsafe fn new(settings: *const SeidelSettings) -> Result<Self> {
        // SAFETY: as the caller vouches.
        let raw = unsafe { maybe_sized(settings, "settings")? };
        let raw = raw.unwrap_or_else(SeidelSettings::neutral);
        let count = raw.channel_scale_count as usize;
        if count > 4096 {
            return Err(Failure::argument(
                "settings.channel_scale_count",
                format!("is {count}"),
                "give one a channel of the lens",
            ));
        }
        // SAFETY: the caller vouches for as many values.
        let channel_scales =
            unsafe { values(raw.channel_scales, count, "settings.channel_scales")? };
        let model = if raw.psf_model.is_null() {
            String::new()
        } else {
            // SAFETY: the caller vouches for a text.
            unsafe { text(raw.psf_model, "settings.psf_model")? }.to_owned()
        };
        let settings = Self {
            raw: SeidelSettings {
                channel_scales: std::ptr::null(),
                psf_model: std::ptr::null(),
                ..raw
            },
            channel_scales,
            model,
        };
        settings.check_choices()?;
        metres(settings.raw.focus_distance)?;
        settings.focus().check()?;
        Ok(settings)
    }

    fn check_choices(&self) -> Result<()> {
        let raw = &self.raw;
        for (name, value, most) in [
            ("geometry", raw.geometry, SEIDEL_GEOMETRY_FULL),
            ("quality", raw.quality, SEIDEL_QUALITY_EXACT),
            ("edges", raw.edges, SEIDEL_EDGES_NEAREST),
            ("occlusion", raw.occlusion, 1),
            ("fill_foreground", raw.fill_foreground, 1),
            ("blur_inside", raw.blur_inside, 1),
            ("alpha", raw.alpha, SEIDEL_ALPHA_UNPREMULTIPLIED),
            ("alpha_per_channel", raw.alpha_per_channel, 1),
            ("scrub", raw.scrub, 1),
            ("depth_kind", raw.depth_kind, SEIDEL_DEPTH_FAR_ZERO),
            ("clip", raw.clip, SEIDEL_CLIP_LEVEL),
            ("grain", raw.grain, SEIDEL_GRAIN_SOLVED),
        ] {
            if value > most {
                return Err(Failure::argument(
                    &format!("settings.{name}"),
                    format!("is {value}"),
                    &format!("give 0 to {most}"),
                ));
            }
        }
        if !(0.0..=1.0).contains(&raw.strength) {
            return Err(Failure::argument(
                "settings.strength",
                format!("is {}", raw.strength),
                "give a number from 0 to 1",
            ));
        }
        if given(raw.lens_scale).is_some_and(|scale| !(scale.is_finite() && scale > 0.0)) {
            return Err(Failure::argument(
                "settings.lens_scale",
                format!("is {}", raw.lens_scale),
                "give a number greater than zero, or NaN",
            ));
        }
        Ok(())
    }

    /// Sets `lens` as these settings say.
    ///
    /// # Errors
    /// Values that the lens cannot follow.
    pub(crate) fn session(&self, lens: &Lens) -> Result<Arc<LensSession>> {
        let lens = lens.measured();
        let settings = self.of_core(lens)?;
        Ok(Arc::new(LensSession::new(lens, &settings)?))
    }

    /// The settings as the core takes them.
    fn of_core(&self, lens: &seidel_core::Lens) -> Result<seidel_core::Settings> {
        let raw = &self.raw;
        let mut settings = seidel_core::Settings::default();
        settings.controls = Controls {
            focus_distance: metres(raw.focus_distance)?,
            f_number: given(raw.f_number),
            sensor_shift_um: given(raw.sensor_shift_um),
        };
        settings.psf_model = (!self.model.is_empty()).then(|| self.model.clone());
        settings.amount = raw.amount;
        settings.channel_scales = self.channel_scales(lens)?;
        settings.axis_offset_px = (raw.axis_offset_x, raw.axis_offset_y);
        settings.displacement = match raw.geometry {
            SEIDEL_GEOMETRY_NONE => Displacement::None,
            SEIDEL_GEOMETRY_FULL => Displacement::Full,
            _ => Displacement::Lateral,
        };
        settings.focus = self.focus();
        settings.quality = match raw.quality {
            SEIDEL_QUALITY_DRAFT => Quality::Draft,
            SEIDEL_QUALITY_EXACT => Quality::Exact,
            _ => Quality::Final,
        };
        settings.edges = match raw.edges {
            SEIDEL_EDGES_MIRROR => Edges::Mirror,
            SEIDEL_EDGES_BLACK => Edges::Black,
            _ => Edges::Extend,
        };
        settings.occlusion = (raw.occlusion == 1).then_some(OcclusionSettings {
            fill_foreground: raw.fill_foreground == 1,
            blur_inside: raw.blur_inside == 1,
        });
        settings.removal = self.removal();
        Ok(settings)
    }

    /// The scales by channel: one for each channel of `lens`, or none.
    fn channel_scales(&self, lens: &seidel_core::Lens) -> Result<Vec<ChannelScale>> {
        let names = lens.predictor().channel_names();
        let count = self.channel_scales.len();
        if count != 0 && count != names.len() {
            return Err(Failure::argument(
                "settings.channel_scales",
                format!("are {count}"),
                &format!("give one for each of the lens's {} channels", names.len()),
            ));
        }
        let scales = names.iter().zip(&self.channel_scales);
        let scales = scales.map(|(channel, scale)| ChannelScale {
            channel: channel.clone(),
            scale: *scale,
        });
        Ok(scales.collect())
    }

    /// The range in focus; the focus plane is that of the controls.
    fn focus(&self) -> FocusControls {
        FocusControls {
            focus_per_m: None,
            depth_of_field_m: self.raw.depth_of_field,
            front: self.raw.front_multiplier,
            back: self.raw.back_multiplier,
            maximum_px: given(self.raw.maximum_size),
        }
    }

    fn removal(&self) -> RemovalSettings {
        let raw = &self.raw;
        let noise = raw.noise;
        RemovalSettings {
            noise: match given(noise[0]) {
                None => Vec::new(),
                Some(first) => noise.map(|noise| given(noise).unwrap_or(first)).to_vec(),
            },
            saturation: match raw.clip {
                SEIDEL_CLIP_NONE => Saturation::Never,
                SEIDEL_CLIP_LEVEL => Saturation::Level(raw.clip_level),
                _ => Saturation::Auto,
            },
            strength: raw.strength,
            grain: if raw.grain == SEIDEL_GRAIN_KEEP {
                Grain::Keep
            } else {
                Grain::Solved
            },
        }
    }

    /// Whether every source pixel is scattered with its own kernel.
    pub(crate) fn is_exact(&self) -> bool {
        self.raw.quality == SEIDEL_QUALITY_EXACT
    }

    /// The relation of colour and alpha.
    pub(crate) fn alpha_kind(&self) -> AlphaKind {
        if self.raw.alpha == SEIDEL_ALPHA_UNPREMULTIPLIED {
            AlphaKind::Unpremultiplied
        } else {
            AlphaKind::Premultiplied
        }
    }

    /// Plate pixels per pixel of the lens's frame, where given.
    pub(crate) fn lens_scale(&self) -> Option<f64> {
        given(self.raw.lens_scale)
    }

    /// The one distance of a plate without a depth image.
    pub(crate) fn distance(&self) -> Result<ObjectDistance> {
        Ok(metres(self.raw.distance)?.unwrap_or(ObjectDistance::Unknown))
    }

    /// The meaning of depth samples.
    pub(crate) fn depth_meaning(&self) -> DepthMeaning {
        let raw = &self.raw;
        let metres_per_unit = raw.depth_unit;
        let (near_m, far_m) = (raw.depth_near, raw.depth_far);
        let convention = match raw.depth_kind {
            SEIDEL_DEPTH_INVERSE => DepthConvention::Inverse { metres_per_unit },
            SEIDEL_DEPTH_FAR_ONE => DepthConvention::FarOne { near_m, far_m },
            SEIDEL_DEPTH_FAR_ZERO => DepthConvention::FarZero { near_m, far_m },
            _ => DepthConvention::Distance { metres_per_unit },
        };
        DepthMeaning {
            convention,
            along_ray: given(raw.along_ray),
        }
    }
}
