//! Depth as the user names it, as the library reads it.

use seidel_c::{
    SEIDEL_DEPTH_DISTANCE, SEIDEL_DEPTH_FAR_ONE, SEIDEL_DEPTH_FAR_ZERO, SEIDEL_DEPTH_INVERSE,
    SEIDEL_FLOAT, SeidelImage, SeidelSettings,
};

use crate::geometry::Plane;
use crate::host::{Failure, Image, Result};
use crate::knobs::{Knobs, depth, focus};
use crate::pixels::Pixels;

/// What the numbers of depth are; places in the menu.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Math {
    Direct,
    Depth,
    FarZero,
    FarOne,
    LinearFarOne,
    LinearFarZero,
}

/// How depth is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    math: Math,
    /// -1 where depth counts backwards.
    sign: f64,
    /// Metres of a unit.
    unit: f64,
    near: f64,
    far: f64,
    /// Depth of the focus plane.
    plane: f64,
}

impl Reading {
    /// As the knobs say.
    pub(crate) fn new(knobs: &Knobs) -> Self {
        let menu = [
            (Math::Direct, 1.0),
            (Math::Depth, 1.0),
            (Math::FarZero, 1.0),
            (Math::FarOne, 1.0),
            (Math::Direct, -1.0),
            (Math::Depth, -1.0),
            (Math::FarZero, -1.0),
            (Math::FarOne, -1.0),
            (Math::LinearFarOne, 1.0),
            (Math::LinearFarZero, 1.0),
        ];
        let (math, sign) = menu[knobs.choice(&depth::MATH) as usize];
        let unit = depth::UNIT_METRES[knobs.choice(&depth::UNIT) as usize];
        let unit = unit * knobs.number(&depth::UNIT_MULTIPLIER);
        Self {
            math,
            sign,
            unit,
            near: unit * knobs.number(&depth::NEAR),
            far: unit * knobs.number(&depth::FAR),
            plane: knobs.number(&focus::PLANE),
        }
    }

    /// Puts it into settings.
    pub(crate) fn put(&self, settings: &mut SeidelSettings) {
        let (kind, unit) = match self.math {
            Math::Depth => (SEIDEL_DEPTH_DISTANCE, self.sign * self.unit),
            Math::FarZero => (SEIDEL_DEPTH_INVERSE, self.sign * self.unit),
            // What is handed over is near over distance, or one over metres.
            Math::FarOne => (SEIDEL_DEPTH_INVERSE, self.near),
            Math::Direct => (SEIDEL_DEPTH_INVERSE, 1.0),
            Math::LinearFarOne => (SEIDEL_DEPTH_FAR_ONE, 1.0),
            Math::LinearFarZero => (SEIDEL_DEPTH_FAR_ZERO, 1.0),
        };
        settings.depth_kind = kind;
        settings.depth_unit = unit;
        settings.depth_near = self.near;
        settings.depth_far = self.far;
    }

    /// Metres of the focus plane; nothing where depth is counted from it.
    ///
    /// # Errors
    /// A plane that is not before the camera.
    pub(crate) fn focus_metres(&self) -> Result<Option<f64>> {
        let value = self.sign * self.plane;
        let metres = match self.math {
            Math::Direct => return Ok(None),
            Math::Depth => value * self.unit,
            Math::FarZero => self.unit / value,
            Math::FarOne => self.near / (1.0 - value),
            Math::LinearFarOne => self.near + (self.far - self.near) * value,
            Math::LinearFarZero => self.near + (self.far - self.near) * (1.0 - value),
        };
        if metres > 0.0 {
            return Ok(Some(metres));
        }
        Err(Failure::failed(format!(
            "Focus Plane (C): {} is {metres} m by this Depth Math; set it to a depth before the camera, or set Focus to Focus Distance.",
            self.plane
        )))
    }

    /// What is handed over in place of a sample; nothing where samples are as they are. `focus` is the vergence of the
    /// focus plane, 1/m.
    fn converted(&self, focus: f64) -> Option<impl Fn(f32) -> f32 + use<>> {
        let Self {
            math, sign, plane, ..
        } = *self;
        matches!(math, Math::FarOne | Math::Direct).then_some(move |sample: f32| {
            let sample = f64::from(sample);
            let value = match math {
                Math::FarOne => 1.0 - sign * sample,
                _ => focus + sign * (sample - plane),
            };
            // Beyond infinity is infinity; what is no number stays none, to be refused.
            if value < 0.0 { 0.0 } else { value as f32 }
        })
    }

    /// Vergence, 1/m, of a sample as it is handed over.
    pub(crate) fn vergence(&self, sample: f32) -> f64 {
        let sample = f64::from(sample);
        let vergence = match self.math {
            Math::Depth => 1.0 / (self.sign * self.unit * sample),
            Math::FarZero => sample / (self.sign * self.unit),
            Math::FarOne => sample / self.near,
            Math::Direct => sample,
            Math::LinearFarOne => 1.0 / (self.near + (self.far - self.near) * sample),
            Math::LinearFarZero => 1.0 / (self.near + (self.far - self.near) * (1.0 - sample)),
        };
        // Nothing before the camera is infinity.
        vergence.max(0.0)
    }

    /// Whether it needs to be known where focus is.
    pub(crate) fn needs_focus(&self) -> bool {
        self.math == Math::Direct
    }
}

/// Shares of red, green and blue in luminance (ITU-R BT.709).
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Depth samples of a picture as they are.
pub(crate) struct Samples<'a> {
    image: &'a Image<'a>,
    channel: i32,
}

impl<'a> Samples<'a> {
    /// Those of the channel that knobs say.
    pub(crate) fn new(image: &'a Image<'a>, knobs: &Knobs) -> Self {
        Self {
            image,
            channel: knobs.choice(&depth::CHANNEL),
        }
    }

    /// The sample of a pixel of the host's, nothing beyond the picture.
    pub(crate) fn at(&self, (x, y): (i32, i32)) -> Option<f32> {
        // With y down from row 0 of the host.
        let plane = Plane::new(Default::default(), crate::geometry::Field::Whole);
        let view = plane.image(self.image, 0, self.image.channels)?;
        // SAFETY: the picture is held.
        let pixels = unsafe { Pixels::new(view) };
        sample(&pixels, self.channel, (x, -1 - y))
    }
}

/// A depth sample of a picture of any channels.
fn sample(pixels: &Pixels, channel: i32, place: (i32, i32)) -> Option<f32> {
    if pixels.channels() == 1 {
        return pixels.get(place, 0);
    }
    if channel == depth::LUMINANCE {
        let parts = (0..3).map(|c| Some(LUMA[c as usize] * pixels.get(place, c)?));
        return parts.sum();
    }
    pixels.get(place, channel as u32)
}

/// A picture of one channel: the host's own, or one that was made of it.
pub(crate) struct Made {
    pub(crate) image: SeidelImage,
    _samples: Vec<f32>,
}

/// One channel of a picture for the library, read as depth where there is a `reading`. Nothing where the picture has no
/// row that counts.
///
/// # Errors
/// A channel that it has not; memory that ran out.
pub(crate) fn channel_of(
    (image, plane): (&Image, &Plane),
    (channel, what): (i32, &str),
    reading: Option<(&Reading, f64)>,
) -> Result<Option<Made>> {
    let channel = if image.channels == 1 { 0 } else { channel };
    if channel != depth::LUMINANCE && channel >= image.channels as i32 {
        return Err(Failure::failed(format!(
            "{what}: the picture has {} channels, which is not enough for {}; choose another channel.",
            image.channels,
            ["R", "G", "B", "A"][channel as usize % 4],
        )));
    }
    let converted = reading.and_then(|(reading, focus)| reading.converted(focus));
    if channel != depth::LUMINANCE && converted.is_none() {
        let view = plane.image(image, channel as u32, 1);
        return Ok(view.map(|image| Made {
            image,
            _samples: Vec::new(),
        }));
    }
    let Some(view) = plane.image(image, 0, image.channels) else {
        return Ok(None);
    };
    let rect = view.rect;
    // SAFETY: the picture is held.
    let pixels = unsafe { Pixels::new(view) };
    let mut samples = Vec::new();
    let count = rect.width as usize * rect.height as usize;
    samples
        .try_reserve_exact(count)
        .map_err(|_| Failure::memory(format!("{what}: no memory for {count} samples.")))?;
    pixels.each(rect, |pixels, place| {
        let value = sample(pixels, channel, place).unwrap_or(f32::NAN);
        samples.push(converted.as_ref().map_or(value, |convert| convert(value)));
    });
    Ok(Some(Made {
        image: SeidelImage {
            data: samples.as_mut_ptr().cast(),
            row_bytes: i64::from(rect.width) * 4,
            pixel_bytes: 4,
            channels: 1,
            sample: SEIDEL_FLOAT,
            ..view
        },
        _samples: samples,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(math: Math, sign: f64) -> Reading {
        Reading {
            math,
            sign,
            unit: 0.5,
            near: 2.0,
            far: 10.0,
            plane: sign * 0.25,
        }
    }

    #[test]
    fn the_focus_plane_is_read_as_depth_is() {
        let metres = |math, sign| {
            reading(math, sign)
                .focus_metres()
                .expect("before the camera")
        };
        for sign in [1.0, -1.0] {
            assert_eq!(metres(Math::Depth, sign), Some(0.125));
            assert_eq!(metres(Math::FarZero, sign), Some(2.0));
            assert_eq!(metres(Math::FarOne, sign), Some(2.0 / 0.75));
            assert_eq!(metres(Math::Direct, sign), None);
        }
        assert_eq!(metres(Math::LinearFarOne, 1.0), Some(4.0));
        assert_eq!(metres(Math::LinearFarZero, 1.0), Some(8.0));
        let zero = |math| Reading {
            plane: 0.0,
            ..reading(math, 1.0)
        };
        let endless = zero(Math::FarZero).focus_metres().expect("infinity");
        assert_eq!(endless, Some(f64::INFINITY));
        let failure = zero(Math::Depth).focus_metres().expect_err("in the camera");
        assert!(failure.text.contains("Focus Plane (C)"));
    }

    #[test]
    fn depth_counted_from_focus_or_far_is_turned_into_vergence() {
        let far_one = reading(Math::FarOne, 1.0).converted(0.0).expect("turned");
        assert_eq!((far_one(0.0), far_one(1.0), far_one(1.5)), (1.0, 0.0, 0.0));
        assert!(far_one(f32::NAN).is_nan());
        let backwards = reading(Math::FarOne, -1.0).converted(0.0).expect("turned");
        assert_eq!(backwards(-0.75), 0.25);
        let direct = reading(Math::Direct, 1.0).converted(0.5).expect("turned");
        assert_eq!((direct(0.25), direct(0.75), direct(-9.0)), (0.5, 1.0, 0.0));
        assert!(reading(Math::FarZero, 1.0).converted(0.5).is_none());
    }
}
