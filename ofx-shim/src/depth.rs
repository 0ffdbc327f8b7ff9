//! Depth and matte inputs: their encoding as the parameters give it, and their samples as the core takes them.

use std::rc::Rc;

use seidel_core::{DepthConvention, Rectangle};

use crate::geometry::PixelMap;
use crate::host::{Failure, Image, Result, Samples};
use crate::knobs::{Knobs, depth, focus};
use crate::plate_image::{PlateImage, collect_rows};

/// Meaning of depth samples, apart from their sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DepthMath {
    /// Vergence relative to the focus plane, 1/m.
    Direct,
    /// Distance.
    Depth,
    /// One over the distance.
    FarZero,
    /// 0 at the near plane and 1 at infinity.
    FarOne,
    /// Distance, from 0 at the near plane to 1 at the far one.
    LinearFarOne,
    /// Distance, from 1 at the near plane to 0 at the far one.
    LinearFarZero,
}

/// Encoding of depth samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DepthEncoding {
    math: DepthMath,
    /// -1 where depth counts backwards, else 1.
    sign: f64,
    metres_per_unit: f64,
    near_m: f64,
    far_m: f64,
    /// Depth of the focus plane, as encoded.
    focus_plane: f64,
}

impl DepthEncoding {
    /// Reads the encoding from the parameters.
    pub(crate) fn new(knobs: &Knobs) -> Self {
        let menu = [
            (DepthMath::Direct, 1.0),
            (DepthMath::Depth, 1.0),
            (DepthMath::FarZero, 1.0),
            (DepthMath::FarOne, 1.0),
            (DepthMath::Direct, -1.0),
            (DepthMath::Depth, -1.0),
            (DepthMath::FarZero, -1.0),
            (DepthMath::FarOne, -1.0),
            (DepthMath::LinearFarOne, 1.0),
            (DepthMath::LinearFarZero, 1.0),
        ];
        let (math, sign) = menu[knobs.choice(&depth::MATH) as usize];
        let unit = depth::UNIT_METRES[knobs.choice(&depth::UNIT) as usize];
        let metres_per_unit = unit * knobs.number(&depth::UNIT_MULTIPLIER);
        Self {
            math,
            sign,
            metres_per_unit,
            near_m: metres_per_unit * knobs.number(&depth::NEAR),
            far_m: metres_per_unit * knobs.number(&depth::FAR),
            focus_plane: knobs.number(&focus::PLANE),
        }
    }

    /// Returns the metres in a unit of the depth pass.
    pub(crate) fn metres_per_unit(&self) -> f64 {
        self.metres_per_unit
    }

    /// Returns the convention of samples after [`DepthConversion::apply`].
    pub(crate) fn convention(&self) -> DepthConvention {
        let (near_m, far_m) = (self.near_m, self.far_m);
        let metres_per_unit = self.sign * self.metres_per_unit;
        match self.math {
            DepthMath::Depth => DepthConvention::Distance { metres_per_unit },
            DepthMath::FarZero => DepthConvention::Inverse { metres_per_unit },
            // Converted to near plane over distance.
            DepthMath::FarOne => DepthConvention::Inverse {
                metres_per_unit: near_m,
            },
            // Converted to vergence.
            DepthMath::Direct => DepthConvention::Inverse {
                metres_per_unit: 1.0,
            },
            DepthMath::LinearFarOne => DepthConvention::FarOne { near_m, far_m },
            DepthMath::LinearFarZero => DepthConvention::FarZero { near_m, far_m },
        }
    }

    /// Returns the distance of the focus plane, metres, or `None` if depth is relative to it.
    ///
    /// # Errors
    /// A plane that is not in front of the camera.
    pub(crate) fn focus_plane_m(&self) -> Result<Option<f64>> {
        let value = self.sign * self.focus_plane;
        let range_m = self.far_m - self.near_m;
        let metres = match self.math {
            DepthMath::Direct => return Ok(None),
            DepthMath::Depth => value * self.metres_per_unit,
            DepthMath::FarZero => self.metres_per_unit / value,
            DepthMath::FarOne => self.near_m / (1.0 - value),
            DepthMath::LinearFarOne => self.near_m + range_m * value,
            DepthMath::LinearFarZero => self.near_m + range_m * (1.0 - value),
        };
        if metres > 0.0 {
            return Ok(Some(metres));
        }
        Err(Failure::failed(format!(
            "Focus Plane (C): {} is {metres} m by this Depth Math; set it to a depth in front of the camera, or set Focus to Focus Distance.",
            self.focus_plane
        )))
    }

    /// Returns the vergence, 1/m, of a sample after [`DepthConversion::apply`].
    pub(crate) fn vergence_per_m(&self, sample: f32) -> f64 {
        let sample = f64::from(sample);
        let range_m = self.far_m - self.near_m;
        let vergence = match self.math {
            DepthMath::Depth => 1.0 / (self.sign * self.metres_per_unit * sample),
            DepthMath::FarZero => sample / (self.sign * self.metres_per_unit),
            DepthMath::FarOne => sample / self.near_m,
            DepthMath::Direct => sample,
            DepthMath::LinearFarOne => 1.0 / (self.near_m + range_m * sample),
            DepthMath::LinearFarZero => 1.0 / (self.near_m + range_m * (1.0 - sample)),
        };
        // Behind the camera counts as infinity.
        vergence.max(0.0)
    }

    /// Returns whether samples are relative to the focus plane.
    pub(crate) fn is_relative_to_focus(&self) -> bool {
        self.math == DepthMath::Direct
    }
}

/// Conversion of depth samples to a convention of the core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DepthConversion {
    pub(crate) encoding: DepthEncoding,
    /// Vergence of the focus plane, 1/m; used if depth is relative to it.
    pub(crate) focus_per_m: f64,
}

impl DepthConversion {
    /// Returns the converted sample. Depth beyond infinity becomes infinity; NaN stays, to be rejected.
    fn apply(&self, sample: f32) -> f32 {
        let DepthEncoding {
            math,
            sign,
            focus_plane,
            ..
        } = self.encoding;
        let value = match math {
            DepthMath::FarOne => 1.0 - sign * f64::from(sample),
            DepthMath::Direct => self.focus_per_m + sign * (f64::from(sample) - focus_plane),
            _ => return sample,
        };
        if value < 0.0 { 0.0 } else { value as f32 }
    }
}

/// Weights of red, green and blue in luminance (ITU-R BT.709).
const LUMINANCE_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Returns the depth sample of a pixel whose `channels` are given by `sample`. The `choice` is that of Depth Channel.
fn depth_sample(
    channels: usize,
    choice: i32,
    sample: impl Fn(usize) -> Option<f32>,
) -> Option<f32> {
    if channels == 1 {
        return sample(0);
    }
    if choice == depth::LUMINANCE {
        return Some(luminance([sample(0)?, sample(1)?, sample(2)?]));
    }
    sample(choice as usize)
}

fn luminance(colour: [f32; 3]) -> f32 {
    let terms = LUMINANCE_WEIGHTS.iter().zip(colour);
    terms.map(|(weight, sample)| weight * sample).sum()
}

/// Returns the depth sample of pixel (`x`, `y`) of the host, y up, as encoded; `None` outside the image.
pub(crate) fn encoded_depth_at(samples: &Samples, knobs: &Knobs, x: i32, y: i32) -> Option<f32> {
    let choice = knobs.choice(&depth::CHANNEL);
    depth_sample(samples.channels(), choice, |channel| {
        samples.get(x, y, channel)
    })
}

/// One channel of a depth or holdout input, in plate coordinates. Outside its image it continues with the nearest pixel.
pub(crate) struct InputChannel<'h> {
    image: Rc<Image<'h>>,
    map: PixelMap,
    channel: i32,
    conversion: Option<DepthConversion>,
}

impl<'h> InputChannel<'h> {
    /// Creates the `channel` of `image`, a choice of the parameter `label`, read as depth where there is a `conversion`.
    /// `None` if the field has no row in the image.
    ///
    /// # Errors
    /// A channel that the image lacks.
    pub(crate) fn new(
        image: &Rc<Image<'h>>,
        map: PixelMap,
        channel: i32,
        label: &str,
        conversion: Option<DepthConversion>,
    ) -> Result<Option<Self>> {
        let channels = image.channels;
        if channels != 1 && channel != depth::LUMINANCE && channel >= channels as i32 {
            return Err(Failure::failed(format!(
                "{label}: the image has {channels} channels and no {}; choose another channel.",
                ["R", "G", "B", "A"][channel as usize % 4],
            )));
        }
        let has_rows = PlateImage::new(image, map).is_some();
        Ok(has_rows.then(|| Self {
            image: Rc::clone(image),
            map,
            channel,
            conversion,
        }))
    }

    /// Returns a function that returns the converted sample of a plate pixel.
    pub(crate) fn reader(&self) -> impl Fn((i32, i32)) -> f32 {
        let view = PlateImage::new(&self.image, self.map);
        move |pixel| {
            let sample = view.and_then(|view| {
                let pixel = view.nearest(pixel);
                depth_sample(view.channels(), self.channel, |channel| {
                    view.get(pixel, channel)
                })
            });
            let sample = sample.unwrap_or(f32::NAN);
            self.conversion
                .map_or(sample, |conversion| conversion.apply(sample))
        }
    }

    /// Returns the converted samples of the pixels of `rectangle`.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn samples(&self, rectangle: Rectangle) -> Result<Vec<f32>> {
        let mut reader = self.row_reader();
        collect_rows(rectangle, 1, |pixel, row| reader(pixel, row))
    }

    /// Returns a function that reads the converted samples of a plate pixel and of those to its right.
    pub(crate) fn row_reader(&self) -> impl FnMut((i32, i32), &mut [f32]) {
        let view = PlateImage::new(&self.image, self.map);
        let nearest = self.reader();
        let mut other = [Vec::new(), Vec::new()];
        move |pixel, row| {
            let columns = view.map_or(0..0, |view| view.rectangle().columns());
            let count = row.len() as i32;
            let start = (columns.start - pixel.0).clamp(0, count) as usize;
            let end = (columns.end - pixel.0).clamp(0, count) as usize;
            let Some(view) = view.filter(|_| start < end) else {
                // Beside the image, where all pixels have the same nearest one.
                row.fill(nearest(pixel));
                return;
            };
            let first = view.nearest((pixel.0 + start as i32, pixel.1));
            let own = &mut row[start..end];
            if view.channels() > 1 && self.channel == depth::LUMINANCE {
                view.read_channel(first, 0, own);
                for (channel, values) in other.iter_mut().enumerate() {
                    values.resize(own.len(), 0.0);
                    view.read_channel(first, channel + 1, values);
                }
                let [green, blue] = &other;
                for ((red, green), blue) in own.iter_mut().zip(green).zip(blue) {
                    *red = luminance([*red, *green, *blue]);
                }
            } else {
                let is_single = view.channels() == 1;
                view.read_channel(
                    first,
                    if is_single { 0 } else { self.channel as usize },
                    own,
                );
            }
            if let Some(conversion) = self.conversion {
                (own.iter_mut()).for_each(|sample| *sample = conversion.apply(*sample));
            }
            let (left, right) = (row[start], row[end - 1]);
            row[..start].fill(left);
            row[end..].fill(right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoding(math: DepthMath, sign: f64) -> DepthEncoding {
        DepthEncoding {
            math,
            sign,
            metres_per_unit: 0.5,
            near_m: 2.0,
            far_m: 10.0,
            focus_plane: sign * 0.25,
        }
    }

    fn conversion(math: DepthMath, sign: f64) -> DepthConversion {
        DepthConversion {
            encoding: encoding(math, sign),
            focus_per_m: 0.5,
        }
    }

    #[test]
    fn the_focus_plane_is_encoded_as_depth_is() {
        let metres = |math, sign| {
            encoding(math, sign)
                .focus_plane_m()
                .expect("in front of the camera")
        };
        for sign in [1.0, -1.0] {
            assert_eq!(metres(DepthMath::Depth, sign), Some(0.125));
            assert_eq!(metres(DepthMath::FarZero, sign), Some(2.0));
            assert_eq!(metres(DepthMath::FarOne, sign), Some(2.0 / 0.75));
            assert_eq!(metres(DepthMath::Direct, sign), None);
        }
        assert_eq!(metres(DepthMath::LinearFarOne, 1.0), Some(4.0));
        assert_eq!(metres(DepthMath::LinearFarZero, 1.0), Some(8.0));
        let zero = |math| DepthEncoding {
            focus_plane: 0.0,
            ..encoding(math, 1.0)
        };
        let infinite = zero(DepthMath::FarZero).focus_plane_m().expect("infinity");
        assert_eq!(infinite, Some(f64::INFINITY));
        let failure = zero(DepthMath::Depth)
            .focus_plane_m()
            .expect_err("in the camera");
        assert!(failure.text.contains("Focus Plane (C)"));
    }

    #[test]
    fn depth_relative_to_focus_or_far_is_converted_to_vergence() {
        let far_one = |sample| conversion(DepthMath::FarOne, 1.0).apply(sample);
        assert_eq!((far_one(0.0), far_one(1.0), far_one(1.5)), (1.0, 0.0, 0.0));
        assert!(far_one(f32::NAN).is_nan());
        assert_eq!(conversion(DepthMath::FarOne, -1.0).apply(-0.75), 0.25);
        let direct = |sample| conversion(DepthMath::Direct, 1.0).apply(sample);
        assert_eq!((direct(0.25), direct(0.75), direct(-9.0)), (0.5, 1.0, 0.0));
        assert_eq!(conversion(DepthMath::FarZero, 1.0).apply(-3.0), -3.0);
    }

    #[test]
    fn luminance_needs_three_channels_and_single_channels_any_choice() {
        let pixel = [1.0, 0.5, 0.25, 9.0];
        let sample = |choice| depth_sample(4, choice, |channel| pixel.get(channel).copied());
        assert_eq!(sample(3), Some(9.0));
        assert_eq!(
            sample(depth::LUMINANCE),
            Some(0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25)
        );
        assert_eq!(depth_sample(1, 2, |_| Some(7.0)), Some(7.0));
        assert_eq!(depth_sample(1, 2, |_| None), None);
    }
}
