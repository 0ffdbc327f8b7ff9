//! Structs of the C ABI with sound or hostile members.

use std::ptr::null;

use seidel_c::*;

use super::GuardedImage;
use super::images::Layout;
use crate::case::{Case, Inputs};
use crate::rng::Rng;
use crate::seeds::{HEIGHT, WIDTH, sample};

/// Settings, plate and images of a call.
pub(super) struct Scene {
    pub(super) settings: SeidelSettings,
    pub(super) window: SeidelRect,
    pub(super) output: GuardedImage,
    source: GuardedImage,
    depth: Option<GuardedImage>,
    descriptions: Box<[SeidelImage; 2]>,
    format: SeidelRect,
    extent: SeidelRect,
    has_source: bool,
}

const ALL: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: WIDTH as i32,
    height: HEIGHT as i32,
};

impl Scene {
    pub(super) fn new(case: &mut Case) -> Self {
        let is_damaged = case.inputs == Inputs::Damaged;
        let rng = &mut case.rng;
        let rect = |rng: &mut Rng| {
            if is_damaged && rng.once_in(3) {
                nearby(rng)
            } else {
                ALL
            }
        };
        let (format, extent) = (rect(rng), rect(rng));
        let (source_rect, window) = (rect(rng), rect(rng));
        let channels = if is_damaged { 1 + rng.below(4) } else { 3 };
        let output_channels = if is_damaged && rng.once_in(8) {
            1 + rng.below(4)
        } else {
            channels
        };
        let bright = if is_damaged {
            *rng.pick(&[1.0, 1.0, 1e15, 6e4, f32::MAX, -1.0, 1e-38])
        } else {
            1.0
        };
        let bad = if is_damaged && rng.once_in(10) {
            *rng.pick(&[f32::NAN, f32::INFINITY])
        } else {
            0.5
        };
        let layout = |rect, channels, rng: &mut Rng| Layout::random(rect, channels, rng);
        let source = GuardedImage::new(layout(source_rect, channels, rng), |k| match k {
            17 => bad,
            40 => bright,
            k => sample(k % WIDTH, k / WIDTH % HEIGHT, k % 3),
        });
        let has_depth = is_damaged && rng.once_in(3);
        let far = hostile_float(rng, 2.0) as f32;
        let depth_rect = rect(rng);
        let depth_layout = layout(depth_rect, 1, rng);
        let depth = has_depth.then(|| {
            GuardedImage::new(depth_layout, |k| {
                if k % 9 == 0 {
                    far
                } else {
                    1.0 + (k % 7) as f32
                }
            })
        });
        let output = GuardedImage::new(layout(window, output_channels, rng), |_| 0.0);
        let mut settings = default_settings();
        settings.distance = 2.0;
        settings.quality = SEIDEL_QUALITY_DRAFT;
        settings.threads = 1;
        if is_damaged {
            for _ in 0..rng.below(4) {
                change_setting(&mut settings, rng);
            }
        }
        let mut descriptions = Box::new([source.describe(), source.describe()]);
        if let Some(depth) = &depth {
            descriptions[1] = depth.describe();
        }
        if is_damaged && rng.once_in(10) {
            spoil(&mut descriptions[0], rng);
        }
        Self {
            settings,
            window,
            output,
            source,
            depth,
            descriptions,
            format: if is_damaged && rng.once_in(12) {
                hostile_rect(rng)
            } else {
                format
            },
            extent: if is_damaged && rng.once_in(12) {
                hostile_rect(rng)
            } else {
                extent
            },
            has_source: !(is_damaged && rng.once_in(30)),
        }
    }

    /// Returns the plate, which points to this scene.
    pub(super) fn plate(&self) -> SeidelPlate {
        let depth = self.depth.as_ref().map(|_| &raw const self.descriptions[1]);
        SeidelPlate {
            size: size_of::<SeidelPlate>() as u64,
            format: self.format,
            extent: self.extent,
            source: if self.has_source {
                &self.descriptions[0]
            } else {
                null()
            },
            depth: depth.unwrap_or(null()),
            matte: null(),
            matte_depth: null(),
            alphas: null(),
            mask: null(),
        }
    }

    /// Returns whether source and depth are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.source.is_finite() && self.depth.as_ref().is_none_or(GuardedImage::is_finite)
    }

    /// Returns the name of an image whose padding was changed.
    pub(super) fn changed_padding(&self) -> Option<&'static str> {
        if !self.output.has_padding() {
            return Some("output");
        }
        (!self.source.has_padding()).then_some("source")
    }
}

fn default_settings() -> SeidelSettings {
    // SAFETY: every field is a number or a pointer, and zero is valid for both.
    let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
    settings.size = size_of::<SeidelSettings>() as u64;
    // SAFETY: the struct has the size that it states.
    unsafe { seidel_settings_init(&mut settings) };
    settings
}

/// Returns a rectangle near the plate: beside it, within it or around it.
fn nearby(rng: &mut Rng) -> SeidelRect {
    SeidelRect {
        left: rng.below(60) as i32 - 30,
        top: rng.below(40) as i32 - 20,
        width: 1 + rng.below(40) as i32,
        height: 1 + rng.below(30) as i32,
    }
}

/// Returns a rectangle that no image can have, or one of extreme place.
fn hostile_rect(rng: &mut Rng) -> SeidelRect {
    let mut side = || *rng.pick(&[0, -1, 1, 16_777_216, 16_777_217, i32::MAX, i32::MIN, 24]);
    let place = SeidelRect {
        left: side(),
        top: side(),
        width: side(),
        height: side(),
    };
    // A large valid rectangle is a large picture, which takes its time by right.
    if i64::from(place.width) * i64::from(place.height) > 1_000_000 && place.width <= 16_777_216 {
        return SeidelRect { width: -1, ..place };
    }
    place
}

/// Returns a hostile number, or often the usual one.
pub(super) fn hostile_float(rng: &mut Rng, usual: f64) -> f64 {
    let hostile = [
        0.0,
        -0.0,
        -1.0,
        1e-320,
        1e-9,
        1e9,
        1e30,
        1e300,
        f64::MAX,
        f64::MIN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];
    if rng.once_in(2) {
        usual
    } else {
        *rng.pick(&hostile)
    }
}

/// Changes a member of the settings.
fn change_setting(s: &mut SeidelSettings, rng: &mut Rng) {
    let usual = 1.0 + rng.share();
    let float = hostile_float(rng, usual);
    let choice = *rng.pick(&[0, 1, 2, 3, 4, 7, u32::MAX]);
    let floats = [
        &mut s.axis_offset_x,
        &mut s.axis_offset_y,
        &mut s.pixel_aspect,
        &mut s.distance,
        &mut s.depth_unit,
        &mut s.depth_near,
        &mut s.depth_far,
        &mut s.along_ray,
        &mut s.depth_filter,
        &mut s.noise[0],
    ];
    let choices = [
        &mut s.alpha,
        &mut s.scrub,
        &mut s.depth_kind,
        &mut s.blades,
        &mut s.aperture_width,
    ];
    let own = floats.len() + choices.len();
    match rng.below(own + NUMBERS.len() + INDICES.len() + 1) {
        at if at < floats.len() => *floats[at] = float,
        at if at < own => *choices[at - floats.len()] = choice,
        at if at < own + NUMBERS.len() => *(NUMBERS[at - own].1)(s) = float,
        at if at < own + NUMBERS.len() + INDICES.len() => {
            *(INDICES[at - own - NUMBERS.len()].1)(s) = choice;
        }
        _ => s.size = *rng.pick(&[0, 8, 100, 1 << 40, u64::MAX]),
    }
}

/// Makes the description of an image invalid, but never wrong about memory: that is the caller's own promise.
fn spoil(image: &mut SeidelImage, rng: &mut Rng) {
    match rng.below(6) {
        0 => image.size = *rng.pick(&[0, 8, u64::MAX]),
        1 => image.data = std::ptr::null_mut(),
        2 => image.channels = *rng.pick(&[0, 5, u32::MAX]),
        3 => image.sample = *rng.pick(&[0, 3, u32::MAX]),
        4 => image.rect.width = *rng.pick(&[0, -1, i32::MIN]),
        _ => image.rect.top = *rng.pick(&[i32::MAX, i32::MIN]),
    }
}
