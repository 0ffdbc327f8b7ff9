//! Lens and plate settings: the options of the command as one struct that can grow.

mod look;

use std::ffi::c_char;
use std::sync::Arc;

use seidel_core::{
    AlphaKind, AperturePicture, ChannelScale, Controls, DepthConvention, DepthMeaning,
    Displacement, Edges, FocusControls, Grain, Lens, LensScale, LensSession, ObjectDistance,
    OcclusionSettings, Quality, RemovalSettings, Saturation,
};

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
pub const SEIDEL_EDGES_NEAREST: u32 = 2;
/// The edges are chosen by the alpha along the border: mirrored for full frames, black for elements over nothing,
/// nearest for elements that the border cuts. The default.
pub const SEIDEL_EDGES_AUTO: u32 = 3;

/// For previews: 45 dB peak signal-to-noise ratio against SEIDEL_QUALITY_EXACT.
pub const SEIDEL_QUALITY_DRAFT: u32 = 0;
/// For delivery: 60 dB, or 50 dB for a lens drawn ray by ray. The default.
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
/// meaning of NaN may be NaN. Switches are 0 or 1. The options of the `seidel` command have the same names.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelSettings {
    /// sizeof(SeidelSettings).
    pub size: u64,
    /// Strength of blur and displacement, 0 (none) to 16; 1 is as measured, and the default.
    pub amount: f64,
    /// Strength of the blur of each lens channel, in the order of the lens, on top of `amount`: above 0, up to 16.
    /// NULL: 1 for all.
    pub channel_scales: *const f64,
    /// Length of `channel_scales`: the number of lens channels, or 0.
    pub channel_scale_count: u32,
    /// SEIDEL_GEOMETRY_...
    pub geometry: u32,
    /// Offset of the optical axis to the right, plate pixels.
    pub axis_offset_x: f64,
    /// Offset of the optical axis downwards, plate pixels.
    pub axis_offset_y: f64,
    /// Name of the PSF model, UTF-8. NULL or "": the default of the lens. See seidel_lens_model.
    pub psf_model: *const c_char,
    /// Focus distance, metres; may be INFINITY. NaN: as measured.
    pub focus_distance: f64,
    /// F-number. NaN: as measured. Below the measured one the blur is extrapolated.
    pub f_number: f64,
    /// Shift of the sensor away from the lens, micrometres. NaN: as measured.
    pub sensor_shift_um: f64,
    /// Range around the focus plane that is as sharp as the plane, half of it on each side, metres. Default 0.
    pub depth_of_field: f64,
    /// Factor of the vergence difference to the focus plane for objects in front of it, 0 to 16. Default 1.
    pub front_multiplier: f64,
    /// Factor of the vergence difference to the focus plane for objects behind it, 0 to 16. Default 1.
    pub back_multiplier: f64,
    /// Largest kernel, as the radius of a uniform disc, plate pixels. NaN: no limit.
    pub maximum_size: f64,
    /// SEIDEL_QUALITY_... (seidel_apply)
    pub quality: u32,
    /// SEIDEL_EDGES_... (seidel_apply)
    pub edges: u32,
    /// Switch: near surfaces occlude far ones where depth varies. Default 1. (seidel_apply)
    pub occlusion: u32,
    /// Switch: background that a blurred foreground uncovers is filled from the background beside it. Default 1.
    /// (seidel_apply)
    pub fill_foreground: u32,
    /// Switch: a blurred foreground becomes transparent inside its own outline. Default 1. (seidel_apply)
    pub blur_inside: u32,
    /// SEIDEL_ALPHA_...
    pub alpha: u32,
    /// Switch: each colour has an alpha of its own, blurred like the colour and written to `alphas`. Default 0.
    pub alpha_per_channel: u32,
    /// Switch: samples that are not finite count as zero; otherwise the call fails. Default 0.
    pub scrub: u32,
    /// Plate pixels per pixel of the lens's frame, counted along y. NaN: the format is as wide as the frame.
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
    /// SEIDEL_CLIP_... (blur removal)
    pub clip: u32,
    /// Level at which samples are clipped, for SEIDEL_CLIP_LEVEL. Default 1. (blur removal)
    pub clip_level: f64,
    /// Standard deviation of the noise of each colour, scene-linear. NaN in the first entry: estimated from the
    /// plate; in another entry: that of the first. The fourth entry is not used. (blur removal)
    pub noise: [f64; 4],
    /// Weight of the sharp image against the plate, 0 to 1. Default 1. (seidel_remove)
    pub strength: f64,
    /// SEIDEL_GRAIN_... (seidel_remove)
    pub grain: u32,
    /// Most threads of a call, up to 1024; 0: one for each core. Results do not depend on it.
    pub threads: u32,
    /// Most memory that a call may need by seidel_memory_needed, bytes; 0: no limit.
    pub memory: u64,
    /// Iris blades: 3 to 13, 0 for a round iris, SEIDEL_BLADES_OF_LENS. The default is that of the lens. This and the
    /// following members are the look of the lens as f-number and focus distance set it, in seidel_apply, seidel_kernel,
    /// seidel_region_of_interest and for the new lens of seidel_relens. All but bloom need a lens of the kind
    /// SEIDEL_LENS_RAYS.
    pub blades: u32,
    /// Width of the picture of the aperture, pixels.
    pub aperture_width: u32,
    /// Picture of the aperture, 0 to 1, white where light passes: rows of `aperture_width` values from the top. Background
    /// discs show it; its shorter side is the width of the pupil. NULL: none.
    pub aperture: *const f32,
    /// Length of `aperture`: whole rows, at most 8192 of at most 8192 values.
    pub aperture_count: u64,
    /// Curvature of the blades, 0 (straight, the default) to 1 (one circle).
    pub roundness: f64,
    /// Direction of one corner of discs before the focus, -180 to 180 degrees from right towards down. Discs behind the
    /// focus are turned by 180 degrees.
    pub rotation: f64,
    /// Height of discs over their width, 0.4 to 2.5, times that of the lens. Default 1.
    pub squeeze: f64,
    /// Radius of the dark middle of discs, 0 (the default) to 0.9 of theirs.
    pub obstruction: f64,
    /// Cat's eyes towards the corners: -1 round discs, 0 (the default) as the lens, 1 strong ones.
    pub cats_eye: f64,
    /// Spherical aberration added: -1 soft discs behind the focus, 1 bubbles with bright rims. Default 0.
    pub spherical: f64,
    /// Factor on the difference of focus between channels, -4 to 4. Default 1.
    pub axial_colour: f64,
    /// Factor on the difference of magnification between channels, -4 to 4. Default 1.
    pub lateral_colour: f64,
    /// Share of the light above `bloom_level` that spreads around highlights, 0 (the default) to 1; any lens.
    pub bloom: f64,
    /// Scene-linear value above which light spreads, at least 0. Default 1.
    pub bloom_level: f64,
    /// Radius that holds half of the spread light, 0.05 to 20 per cent of the width of the lens's frame. Default 1.
    pub bloom_radius: f64,
    /// Focal length to scale the lens and its frame to, millimetres; f-number and focus distance stay. NaN: as measured.
    pub focal_length_mm: f64,
    /// Width of the sensor that the format shows (film back), millimetres, for lenses of known pixel pitch; `lens_scale`
    /// must be NaN. NaN: as `lens_scale` says.
    pub film_back_mm: f64,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Versioned for SeidelSettings {
    const MIN_SIZE: usize = std::mem::offset_of!(Self, blades);

    const DEFAULT: Self = Self {
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
        edges: SEIDEL_EDGES_AUTO,
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
        clip: SEIDEL_CLIP_AUTO,
        clip_level: 1.0,
        noise: [f64::NAN; 4],
        strength: 1.0,
        grain: SEIDEL_GRAIN_KEEP,
        threads: 0,
        memory: 0,
        blades: SEIDEL_BLADES_OF_LENS,
        aperture_width: 0,
        aperture: std::ptr::null(),
        aperture_count: 0,
        roundness: 0.0,
        rotation: 0.0,
        squeeze: 1.0,
        obstruction: 0.0,
        cats_eye: 0.0,
        spherical: 0.0,
        axial_colour: 1.0,
        lateral_colour: 1.0,
        bloom: 0.0,
        bloom_level: 1.0,
        bloom_radius: 1.0,
        focal_length_mm: f64::NAN,
        film_back_mm: f64::NAN,
    };
}

/// Fills `*settings` with the defaults. The caller has set its `size` to sizeof(SeidelSettings).
///
/// # Safety
/// `settings`: as many writable bytes as its `size` states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_settings_init(settings: *mut SeidelSettings) -> SeidelStatus {
    // SAFETY: as the caller guarantees.
    guard(|| unsafe { write_versioned(settings, &SeidelSettings::DEFAULT, "settings") })
}

/// Most values of `channel_scales`: more than any lens has channels, so that a wild count is refused before it is
/// read.
const MAX_CHANNEL_SCALES: usize = 4096;

/// Settings of a call, checked as far as possible without a lens. They own copies of the data that they point to.
pub(crate) struct Settings {
    /// The caller's settings, all pointers set to NULL.
    pub(crate) raw: SeidelSettings,
    channel_scales: Vec<f64>,
    aperture: Option<AperturePicture>,
    psf_model: String,
}

/// Returns `None` for NaN.
fn unless_nan(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// Returns a distance in metres, or `None` for NaN.
fn object_distance(value: f64) -> Result<Option<ObjectDistance>> {
    Ok(unless_nan(value).map(ObjectDistance::metres).transpose()?)
}

impl Settings {
    /// Copies and checks the settings at `settings`; the defaults if it is NULL.
    ///
    /// # Safety
    /// `settings` must be NULL or settings whose pointers can be read until the call ends.
    pub(crate) unsafe fn new(settings: *const SeidelSettings) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let raw = unsafe { read_optional(settings, "settings")? };
        let raw = raw.unwrap_or(SeidelSettings::DEFAULT);
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
        // SAFETY: as the caller guarantees.
        let aperture = unsafe { look::aperture(&raw)? };
        let settings = Self {
            raw: SeidelSettings {
                channel_scales: std::ptr::null(),
                psf_model: std::ptr::null(),
                aperture: std::ptr::null(),
                ..raw
            },
            channel_scales,
            aperture,
            psf_model,
        };
        settings.check_choices()?;
        settings.check_numbers()?;
        Ok(settings)
    }

    fn check_choices(&self) -> Result<()> {
        let raw = &self.raw;
        for (name, value, last) in [
            ("geometry", raw.geometry, SEIDEL_GEOMETRY_FULL),
            ("quality", raw.quality, SEIDEL_QUALITY_EXACT),
            ("edges", raw.edges, SEIDEL_EDGES_AUTO),
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

    fn check_numbers(&self) -> Result<()> {
        let raw = &self.raw;
        if !(0.0..=1.0).contains(&raw.strength) {
            return Err(Failure::argument(
                "settings.strength",
                format!("is {}", raw.strength),
                "give a number from 0 to 1",
            ));
        }
        if !raw.lens_scale.is_nan() && !raw.film_back_mm.is_nan() {
            return Err(Failure::argument(
                "settings.film_back_mm",
                "is given beside lens_scale",
                "set one of them to NaN",
            ));
        }
        for (name, value) in [
            ("settings.lens_scale", raw.lens_scale),
            ("settings.film_back_mm", raw.film_back_mm),
        ] {
            let is_valid = value.is_nan() || (value.is_finite() && value > 0.0);
            if !is_valid {
                return Err(Failure::argument(
                    name,
                    format!("is {value}"),
                    "give a number greater than zero, or NaN",
                ));
            }
        }
        object_distance(raw.focus_distance)?;
        Ok(self.focus().check()?)
    }

    /// Sets `lens` to these settings, with their look.
    ///
    /// # Errors
    /// Values out of range, and settings that the lens does not support.
    pub(crate) fn session(&self, lens: &Lens) -> Result<Arc<LensSession>> {
        let mut settings = self.to_core(lens)?;
        self.put_look(&mut settings);
        Ok(Arc::new(LensSession::new(lens, &settings)?))
    }

    /// Sets `lens`, which a plate of so many `colours` was taken with, to these settings without their look.
    ///
    /// # Errors
    /// Those of [`Self::session`].
    pub(crate) fn session_of_plate(&self, lens: &Lens, colours: usize) -> Result<Arc<LensSession>> {
        let mut settings = self.to_core(lens)?;
        settings.removal.noise.truncate(colours);
        Ok(Arc::new(LensSession::new(lens, &settings)?))
    }

    /// Returns the settings of the core, for `lens`.
    fn to_core(&self, lens: &Lens) -> Result<seidel_core::Settings> {
        let raw = &self.raw;
        let mut settings = seidel_core::Settings::default();
        settings.controls = Controls {
            focal_length_mm: unless_nan(raw.focal_length_mm),
            focus_distance: object_distance(raw.focus_distance)?,
            f_number: unless_nan(raw.f_number),
            sensor_shift_um: unless_nan(raw.sensor_shift_um),
        };
        settings.psf_model = (!self.psf_model.is_empty()).then(|| self.psf_model.clone());
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
            SEIDEL_EDGES_MIRROR => Some(Edges::Mirror),
            SEIDEL_EDGES_BLACK => Some(Edges::Black),
            SEIDEL_EDGES_NEAREST => Some(Edges::Extend),
            _ => None,
        };
        settings.occlusion = (raw.occlusion == 1).then_some(OcclusionSettings {
            fill_foreground: raw.fill_foreground == 1,
            blur_inside: raw.blur_inside == 1,
        });
        settings.removal = self.removal();
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

    /// Returns the focus range; its focus plane is that of the controls.
    fn focus(&self) -> FocusControls {
        FocusControls {
            focus_per_m: None,
            depth_of_field_m: self.raw.depth_of_field,
            front: self.raw.front_multiplier,
            back: self.raw.back_multiplier,
            maximum_px: unless_nan(self.raw.maximum_size),
        }
    }

    fn removal(&self) -> RemovalSettings {
        let raw = &self.raw;
        let noise = match unless_nan(raw.noise[0]) {
            None => Vec::new(),
            Some(first) => (raw.noise.iter())
                .map(|noise| unless_nan(*noise).unwrap_or(first))
                .collect(),
        };
        RemovalSettings {
            noise,
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
        let film_back = unless_nan(self.raw.film_back_mm).map(LensScale::FilmBack);
        let ratio = unless_nan(self.raw.lens_scale).map(LensScale::PixelRatio);
        film_back.or(ratio).unwrap_or_default()
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
        }
    }
}
