//! Lens and plate settings: the options of the command as one struct that can grow.

mod aperture;

use std::ffi::c_char;
use std::sync::Arc;

use seidel_core::{
    AlphaKind, Blades, ChannelScale, Choice, DepthConvention, DepthMeaning, Knob, KnobKind, Lens,
    LensScale, LensSession, ObjectDistance, RelensSide,
};

use aperture::aperture;

use crate::guard::guard;
use crate::pointers::{Versioned, read_array, read_optional, read_string, write_versioned};
use crate::status::{Failure, Result, SeidelStatus};

/// Blur only: each kernel has its centroid on its source pixel.
pub const SEIDEL_GEOMETRY_NONE: u32 = 0;
/// Blur and lateral colour: channels are displaced against each other, without distortion. The default.
pub const SEIDEL_GEOMETRY_LATERAL: u32 = 1;
/// Blur, lateral colour and distortion.
pub const SEIDEL_GEOMETRY_FULL: u32 = 2;

/// The mirrored plate lies beyond the plate, so that no light is lost.
pub const SEIDEL_EDGES_MIRROR: u32 = 0;
/// Black lies beyond the plate: light that leaves it is lost.
pub const SEIDEL_EDGES_BLACK: u32 = 1;
/// The nearest pixel of the plate lies beyond it, with its depth and blur.
pub const SEIDEL_EDGES_EXTEND: u32 = 2;
/// An earlier name of SEIDEL_EDGES_EXTEND.
pub const SEIDEL_EDGES_NEAREST: u32 = SEIDEL_EDGES_EXTEND;
/// The edges are chosen by the alpha along the border: mirrored for full frames, black for elements over nothing,
/// extended for elements that the border cuts. The default.
pub const SEIDEL_EDGES_AUTO: u32 = 3;

/// For previews: 45 dB peak signal-to-noise ratio against SEIDEL_QUALITY_EXACT.
pub const SEIDEL_QUALITY_DRAFT: u32 = 0;
/// For delivery: 60 dB, 75 dB where no blur is above 6 px, 50 dB for a lens drawn ray by ray. The default.
pub const SEIDEL_QUALITY_FINAL: u32 = 1;
/// Exact: every source pixel is scattered with its own kernel. Slow.
pub const SEIDEL_QUALITY_EXACT: u32 = 2;

/// Colour is multiplied by alpha (associated alpha). The default.
pub const SEIDEL_ALPHA_PREMULTIPLIED: u32 = 0;
/// Colour is not multiplied by alpha (straight alpha).
pub const SEIDEL_ALPHA_UNPREMULTIPLIED: u32 = 1;

/// Depth is the distance along the optical axis, in units of `depth_unit` metres. The default.
pub const SEIDEL_DEPTH_DISTANCE: u32 = 0;
/// Depth is 1 / distance, with the distance in units of `depth_unit` metres; 0 is infinity.
pub const SEIDEL_DEPTH_INVERSE: u32 = 1;
/// Depth is 0 at `depth_near` and 1 at `depth_far`, linear in distance.
pub const SEIDEL_DEPTH_FAR_ONE: u32 = 2;
/// Depth is 1 at `depth_near` and 0 at `depth_far`, linear in distance.
pub const SEIDEL_DEPTH_FAR_ZERO: u32 = 3;

/// The clip level of each colour is estimated from the plate. The default.
pub const SEIDEL_CLIP_AUTO: u32 = 0;
/// No sample counts as clipped.
pub const SEIDEL_CLIP_NONE: u32 = 1;
/// Samples at or above `clip_level` count as clipped.
pub const SEIDEL_CLIP_LEVEL: u32 = 2;

/// The sharp image gets the plate's own grain. The default.
pub const SEIDEL_GRAIN_KEEP: u32 = 0;
/// The sharp image is the solution as it is, nearly without grain.
pub const SEIDEL_GRAIN_SOLVED: u32 = 1;

/// The iris blades of the lens.
pub const SEIDEL_BLADES_OF_LENS: u32 = u32::MAX;

/// Lens and plate settings. Fill it by seidel_settings_init, then change members. Members whose comment states a
/// meaning of NaN may be NaN. Switches are 0 or 1. The options of the `seidel` command have the same names. The members from
/// `blades` to `bloom_radius` are the look of the lens as f-number and focus distance set it, in seidel_apply, seidel_kernel,
/// seidel_region_of_interest and for the new lens of seidel_relens.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
// The header documents members without a comment from the table of knobs.
#[allow(missing_docs)]
pub struct SeidelSettings {
    /// sizeof(SeidelSettings).
    pub size: u64,
    pub amount: f64,
    /// Strength of the blur of each lens channel, in the order of the lens, on top of `amount`: above 0, up to 16.
    /// NULL: 1 for all.
    pub channel_scales: *const f64,
    /// Length of `channel_scales`: the number of lens channels, or 0.
    pub channel_scale_count: u32,
    pub geometry: u32,
    /// Offset of the optical axis to the right, plate pixels.
    pub axis_offset_x: f64,
    /// Offset of the optical axis downwards, plate pixels.
    pub axis_offset_y: f64,
    /// Name of the PSF model, UTF-8. NULL or "": the default of the lens. See seidel_lens_model.
    pub psf_model: *const c_char,
    pub focus_distance: f64,
    pub f_number: f64,
    pub sensor_shift_um: f64,
    pub depth_of_field: f64,
    pub front_multiplier: f64,
    pub back_multiplier: f64,
    pub maximum_size: f64,
    pub quality: u32,
    pub edges: u32,
    pub occlusion: u32,
    pub fill_foreground: u32,
    pub blur_inside: u32,
    /// SEIDEL_ALPHA_...
    pub alpha: u32,
    /// Switch: each colour has an alpha of its own, blurred like the colour and written to `alphas`. Default 0.
    pub alpha_per_channel: u32,
    /// Switch: samples that are not finite count as zero; otherwise the call fails. Default 0.
    pub scrub: u32,
    pub lens_scale: f64,
    /// Width of a plate pixel over its height in the scene, 1/16 to 16: 2 for a plate of a 2x anamorphic lens before it is
    /// desqueezed. Default 1.
    pub pixel_aspect: f64,
    /// Object distance of a plate without a depth image, metres; may be INFINITY. NaN: unknown.
    pub distance: f64,
    /// Metres per unit of depth; negative if depth is negative. Default 1.
    pub depth_unit: f64,
    /// Nearest distance of a normalised depth, metres.
    pub depth_near: f64,
    /// Farthest distance of a normalised depth, metres.
    pub depth_far: f64,
    /// Focal length in widths of a plate pixel, if depth is measured along the ray from the camera. NaN: along the
    /// axis.
    pub along_ray: f64,
    /// SEIDEL_DEPTH_...
    pub depth_kind: u32,
    pub clip: u32,
    pub clip_level: f64,
    /// Standard deviation of the noise of each colour, scene-linear. NaN in the first entry: estimated from the
    /// plate; in another entry: that of the first. The fourth entry is not used. (blur removal)
    pub noise: [f64; 4],
    pub strength: f64,
    pub grain: u32,
    /// Most threads of a call, up to 1024; 0: one for each core. Results do not depend on it.
    pub threads: u32,
    /// Most memory that a call may need by seidel_memory_needed, bytes; 0: no limit.
    pub memory: u64,
    /// Iris blades: 3 to 13, 0 for a round iris, SEIDEL_BLADES_OF_LENS. The default is that of the lens. All looks but bloom
    /// need a lens of the kind SEIDEL_LENS_RAYS.
    pub blades: u32,
    /// Width of the picture of the aperture, pixels.
    pub aperture_width: u32,
    /// Picture of the aperture, 0 to 1, white where light passes: rows of `aperture_width` values from the top. Background
    /// discs show it; its shorter side is the width of the pupil. NULL: none.
    pub aperture: *const f32,
    /// Length of `aperture`: whole rows, at most 8192 of at most 8192 values.
    pub aperture_count: u64,
    pub roundness: f64,
    pub rotation: f64,
    pub squeeze: f64,
    pub obstruction: f64,
    pub cats_eye: f64,
    pub spherical: f64,
    pub axial_colour: f64,
    pub lateral_colour: f64,
    pub bloom: f64,
    pub bloom_level: f64,
    pub bloom_radius: f64,
    pub focal_length_mm: f64,
    pub film_back_mm: f64,
    pub from_focal_length_mm: f64,
    pub from_f_number: f64,
    pub from_sensor_shift_um: f64,
    pub from_focus_distance: f64,
    pub to_focal_length_mm: f64,
    pub to_f_number: f64,
    pub to_sensor_shift_um: f64,
    pub to_focus_distance: f64,
    pub mix: f64,
    pub only_chroma: u32,
    pub mask_scales: u32,
    pub tilt: f64,
    pub tilt_direction: f64,
    /// Width over which depth is averaged at edges, by a filter or by motion over the shutter, plate pixels, up to 256: edges
    /// up to that wide are divided between their two sides. Default 0: none.
    pub depth_filter: f64,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Versioned for SeidelSettings {
    const MIN_SIZE: usize = std::mem::offset_of!(Self, blades);

    fn defaults() -> Self {
        // SAFETY: zero is valid for numbers and pointers.
        let mut settings: Self = unsafe { std::mem::zeroed() };
        settings.size = size_of::<Self>() as u64;
        for knob in Knob::all() {
            match &knob.kind {
                KnobKind::Number(number) => {
                    if let Some(member) = knob_member(NUMBERS, knob) {
                        *member(&mut settings) = number.default.unwrap_or(f64::NAN);
                    }
                }
                KnobKind::Choice(Choice { default, .. }) => settings.put_index(knob, *default),
                KnobKind::Switch(switch) => settings.put_index(knob, usize::from(switch.default)),
            }
        }
        settings.pixel_aspect = 1.0;
        settings.depth_unit = 1.0;
        settings.noise = [f64::NAN; 4];
        settings.blades = SEIDEL_BLADES_OF_LENS;
        for unknown in [
            &mut settings.distance,
            &mut settings.depth_near,
            &mut settings.depth_far,
            &mut settings.along_ray,
        ] {
            *unknown = f64::NAN;
        }
        settings
    }
}

/// A member of the settings, by the identifier of its knob.
pub type Member<T> = (&'static str, fn(&mut SeidelSettings) -> &mut T);

macro_rules! members {
    ($($name:ident),* $(,)?) => {
        &[$((stringify!($name), |settings| &mut settings.$name)),*]
    };
}

/// The members that are numbers of knobs.
pub const NUMBERS: &[Member<f64>] = members![
    amount,
    focus_distance,
    f_number,
    sensor_shift_um,
    depth_of_field,
    front_multiplier,
    back_multiplier,
    maximum_size,
    lens_scale,
    clip_level,
    strength,
    roundness,
    rotation,
    squeeze,
    obstruction,
    cats_eye,
    spherical,
    axial_colour,
    lateral_colour,
    bloom,
    bloom_level,
    bloom_radius,
    focal_length_mm,
    film_back_mm,
    from_focal_length_mm,
    from_f_number,
    from_sensor_shift_um,
    from_focus_distance,
    to_focal_length_mm,
    to_f_number,
    to_sensor_shift_um,
    to_focus_distance,
    mix,
    tilt,
    tilt_direction,
];

/// The members that are choices and switches of knobs.
pub const INDICES: &[Member<u32>] = members![
    geometry,
    quality,
    edges,
    occlusion,
    fill_foreground,
    blur_inside,
    clip,
    grain,
    only_chroma,
    mask_scales,
];

/// Returns the member of `knob`; `None` where the settings have it in another form, or not at all.
fn knob_member<T>(members: &[Member<T>], knob: &Knob) -> Option<fn(&mut SeidelSettings) -> &mut T> {
    let identifier = knob.identifier();
    let found = members.iter().find(|(name, _)| *name == identifier);
    found.map(|(_, member)| *member)
}

impl SeidelSettings {
    fn put_index(&mut self, knob: &Knob, index: usize) {
        if let Some(member) = knob_member(INDICES, knob) {
            *member(self) = index as u32;
        }
    }

    /// Returns the number of `knob`; `None` for NaN where that leaves the setting out.
    fn number(mut self, knob: &Knob) -> Option<f64> {
        let value = *knob_member(NUMBERS, knob)?(&mut self);
        let may_be_absent = knob.number().is_some_and(|number| number.default.is_none());
        if may_be_absent {
            unless_nan(value)
        } else {
            Some(value)
        }
    }

    /// Writes the knobs to `settings`.
    ///
    /// # Errors
    /// Values out of range, and two of which only one may be given, by the name of the member.
    fn put_knobs(mut self, settings: &mut seidel_core::Settings) -> Result<()> {
        for knob in Knob::all() {
            if let Some(value) = self.number(knob) {
                let is_given = |other: &Knob| self.number(other).is_some();
                knob.check_alone(is_given)?;
                knob.put_number(value, settings)?;
            } else if let Some(member) = knob_member(INDICES, knob) {
                let index = *member(&mut self) as usize;
                knob.put_index(index, settings)?;
            }
        }
        Ok(())
    }
}

/// Fills `*settings` with the defaults. The caller has set its `size` to sizeof(SeidelSettings).
///
/// # Safety
/// `settings`: as many writable bytes as its `size` states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_settings_init(settings: *mut SeidelSettings) -> SeidelStatus {
    // SAFETY: as the caller guarantees.
    guard(|| unsafe { write_versioned(settings, &SeidelSettings::defaults(), "settings") })
}

/// Most values of `channel_scales`: more than any lens has channels, so that a wild count is refused before it is
/// read.
const MAX_CHANNEL_SCALES: usize = 4096;

/// Settings of a call, checked as far as possible without a lens. They own copies of the data that they point to.
pub(crate) struct Settings {
    /// The caller's settings, all pointers set to NULL.
    pub(crate) raw: SeidelSettings,
    channel_scales: Vec<f64>,
    /// Settings of the core, without `channel_scales`.
    core: seidel_core::Settings,
}

/// Returns `None` for NaN.
fn unless_nan(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// Returns a distance in metres, or `None` for NaN.
fn object_distance(value: f64) -> Result<Option<ObjectDistance>> {
    Ok(unless_nan(value).map(ObjectDistance::metres).transpose()?)
}

/// Returns the noise of each colour; none if it is to be estimated.
fn noise(given: [f64; 4]) -> Vec<f64> {
    let first = unless_nan(given[0]);
    let of_all = |first| {
        given
            .map(|noise| unless_nan(noise).unwrap_or(first))
            .to_vec()
    };
    first.map(of_all).unwrap_or_default()
}

impl Settings {
    /// Copies and checks the settings at `settings`; the defaults if it is NULL.
    ///
    /// # Safety
    /// `settings` must be NULL or settings whose pointers can be read until the call ends.
    pub(crate) unsafe fn new(settings: *const SeidelSettings) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let raw = unsafe { read_optional(settings, "settings")? };
        let raw = raw.unwrap_or_else(SeidelSettings::defaults);
        let count = raw.channel_scale_count as usize;
        if count > MAX_CHANNEL_SCALES {
            return Err(Failure::argument(
                "settings.channel_scale_count",
                format!("is {count}"),
                "give the number of lens channels, or 0",
            ));
        }
        // SAFETY: the caller guarantees as many values.
        let channel_scales =
            unsafe { read_array(raw.channel_scales, count, "settings.channel_scales")? };
        let psf_model = if raw.psf_model.is_null() {
            String::new()
        } else {
            // SAFETY: the caller guarantees a string.
            unsafe { read_string(raw.psf_model, "settings.psf_model")? }.to_owned()
        };
        let mut core = seidel_core::Settings::default();
        core.psf_model = (!psf_model.is_empty()).then_some(psf_model);
        core.axis_offset_px = (raw.axis_offset_x, raw.axis_offset_y);
        // SAFETY: as the caller guarantees.
        core.look.picture = unsafe { aperture(&raw)? };
        core.look.blades =
            (raw.blades != SEIDEL_BLADES_OF_LENS).then(|| Blades::straight(raw.blades));
        raw.put_knobs(&mut core)?;
        core.removal.noise = noise(raw.noise);
        let settings = Self {
            raw: SeidelSettings {
                channel_scales: std::ptr::null(),
                psf_model: std::ptr::null(),
                aperture: std::ptr::null(),
                ..raw
            },
            channel_scales,
            core,
        };
        settings.check_choices()?;
        Ok(settings)
    }

    /// Checks the choices and switches that are no knobs.
    fn check_choices(&self) -> Result<()> {
        let raw = &self.raw;
        for (name, value, last) in [
            ("alpha", raw.alpha, SEIDEL_ALPHA_UNPREMULTIPLIED),
            ("alpha_per_channel", raw.alpha_per_channel, 1),
            ("scrub", raw.scrub, 1),
            ("depth_kind", raw.depth_kind, SEIDEL_DEPTH_FAR_ZERO),
        ] {
            if value > last {
                return Err(Failure::argument(
                    &format!("settings.{name}"),
                    format!("is {value}"),
                    &format!("give 0 to {last}"),
                ));
            }
        }
        Ok(())
    }

    /// Sets `lens` to these settings, with their look.
    ///
    /// # Errors
    /// Values out of range, and settings that the lens does not support.
    pub(crate) fn session(&self, lens: &Lens) -> Result<Arc<LensSession>> {
        Ok(Arc::new(LensSession::new(lens, &self.to_core(lens)?)?))
    }

    /// Sets `lens`, which a plate of so many `colours` was taken with, to these settings without their look.
    ///
    /// # Errors
    /// Those of [`Self::session`].
    pub(crate) fn session_of_plate(&self, lens: &Lens, colours: usize) -> Result<Arc<LensSession>> {
        let mut settings = self.to_core(lens)?.of_measured_lens();
        settings.removal.noise.truncate(colours);
        Ok(Arc::new(LensSession::new(lens, &settings)?))
    }

    /// Sets a lens of seidel_relens, for a plate of so many `colours`, to these settings.
    ///
    /// # Errors
    /// Those of [`Self::session`].
    pub(crate) fn session_of_side(
        &self,
        lens: &Lens,
        side: RelensSide,
        colours: usize,
    ) -> Result<Arc<LensSession>> {
        let mut settings = self.to_core(lens)?.of_side(side);
        settings.removal.noise.truncate(colours);
        Ok(Arc::new(LensSession::new(lens, &settings)?))
    }

    /// Returns the settings of the core, for `lens`.
    fn to_core(&self, lens: &Lens) -> Result<seidel_core::Settings> {
        let mut settings = self.core.clone();
        settings.channel_scales = self.channel_scales(lens)?;
        Ok(settings)
    }

    /// Returns one scale for each channel of `lens`, or none.
    fn channel_scales(&self, lens: &Lens) -> Result<Vec<ChannelScale>> {
        let names = lens.predictor().channel_names();
        let count = self.channel_scales.len();
        if count != 0 && count != names.len() {
            return Err(Failure::argument(
                "settings.channel_scales",
                format!("has {count} values"),
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

    /// Returns whether every source pixel is scattered with its own kernel.
    pub(crate) fn is_exact(&self) -> bool {
        self.raw.quality == SEIDEL_QUALITY_EXACT
    }

    /// Returns whether the edges depend on the border of the whole plate.
    pub(crate) fn has_automatic_edges(&self) -> bool {
        self.raw.edges == SEIDEL_EDGES_AUTO
    }

    /// The relation of colour and alpha.
    pub(crate) fn alpha_kind(&self) -> AlphaKind {
        if self.raw.alpha == SEIDEL_ALPHA_UNPREMULTIPLIED {
            AlphaKind::Unpremultiplied
        } else {
            AlphaKind::Premultiplied
        }
    }

    /// Scale of the lens's frame on the plate.
    pub(crate) fn lens_scale(&self) -> LensScale {
        self.core.lens_scale
    }

    /// Object distance of a plate without a depth image.
    pub(crate) fn distance(&self) -> Result<ObjectDistance> {
        Ok(object_distance(self.raw.distance)?.unwrap_or(ObjectDistance::Unknown))
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
            along_ray: unless_nan(raw.along_ray),
            averaged_px: raw.depth_filter,
        }
    }
}
