//! A lens with adjusted strength, colour fringing and optical axis.

use crate::{BlurField, DisplacedBlur};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::sensor::Tone;

/// Largest amount and channel scale.
pub const MAX_AMOUNT: f64 = 16.0;

/// A lens with its effect scaled and moved. Neutral values leave it unchanged to the bit.
pub struct AdjustedLens<'a> {
    lens: &'a dyn BlurField,
    amount: f64,
    channel_scales: Vec<f64>,
    /// Offset of the axis, half frame widths.
    offset: (f64, f64),
}

impl<'a> AdjustedLens<'a> {
    /// Wraps `lens`.
    ///
    /// `amount` scales blur and displacement: 0 removes both, 1 leaves the lens unchanged. `channel_scales` additionally
    /// scale the blur of each channel. `axis_offset_px` (x, y) moves the axis, pixels of the lens's frame. The sensor's
    /// tone stays.
    ///
    /// # Errors
    /// A scale that is not above 0 and up to [`MAX_AMOUNT`], the wrong number of scales, and an offset that is not finite.
    pub fn new(
        lens: &'a dyn BlurField,
        amount: f64,
        channel_scales: Vec<f64>,
        axis_offset_px: (f64, f64),
    ) -> Result<Self> {
        if channel_scales.len() != lens.channel_count() {
            return Err(Error::new(
                "channel scales",
                format!("are {}", channel_scales.len()),
                format!(
                    "give one for each of the lens's {} channels",
                    lens.channel_count()
                ),
            ));
        }
        if let Some(bad) = (channel_scales.iter()).find(|s| !(**s > 0.0 && **s <= MAX_AMOUNT)) {
            return Err(Error::new(
                "channel scale",
                format!("is {bad}"),
                format!("give a number above 0 and up to {MAX_AMOUNT}; 1 is the blur of the lens"),
            ));
        }
        if !(axis_offset_px.0.is_finite() && axis_offset_px.1.is_finite()) {
            return Err(Error::new(
                "axis offset",
                format!("is ({}, {})", axis_offset_px.0, axis_offset_px.1),
                "give finite numbers of pixels",
            ));
        }
        let half_width = f64::from(lens.frame().width_px()) / 2.0;
        Ok(Self {
            lens,
            amount,
            channel_scales,
            offset: (axis_offset_px.0 / half_width, axis_offset_px.1 / half_width),
        })
    }
}

impl BlurField for AdjustedLens<'_> {
    fn frame(&self) -> Frame {
        self.lens.frame()
    }

    fn channel_count(&self) -> usize {
        self.lens.channel_count()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let moved = FieldPoint::new(at.x - self.offset.0, at.y - self.offset.1);
        let placed = self.lens.blur_at(channel, moved, vergence_per_m);
        let (x, y) = placed.displacement_px;
        DisplacedBlur {
            blur: (placed.blur).rescaled(self.amount * self.channel_scales[channel]),
            displacement_px: (x * self.amount, y * self.amount),
        }
    }

    fn tone(&self, channel: usize) -> Tone {
        self.lens.tone(channel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::moments::CentralMoments;
    use seidel_optics::psf::LocalBlur;

    /// A lens whose blur and displacement vary with field, channel and depth.
    struct VaryingLens;

    impl BlurField for VaryingLens {
        fn frame(&self) -> Frame {
            Frame::new(300, 200, None).expect("a valid frame")
        }

        fn channel_count(&self) -> usize {
            2
        }

        fn blur_at(&self, channel: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
            let size = 1.3 + at.x + 0.7 * at.y * at.y + 0.1 * channel as f64 + vergence;
            let moments = CentralMoments::from_array([size, 0.1, 2.0, 0.3, 0.2, at.y, 0.5]);
            DisplacedBlur {
                blur: LocalBlur::from_moments(moments, FieldPoint::new(1.0, 0.0).meridian()),
                displacement_px: (at.x, 2.0 * at.y),
            }
        }
    }

    const AT: FieldPoint = FieldPoint { x: 0.37, y: -0.21 };

    #[test]
    fn neutral_values_change_no_bit() {
        let same = AdjustedLens::new(&VaryingLens, 1.0, vec![1.0; 2], (0.0, 0.0)).expect("neutral");
        for channel in 0..2 {
            assert_eq!(
                same.blur_at(channel, AT, 0.4),
                VaryingLens.blur_at(channel, AT, 0.4)
            );
        }
    }

    #[test]
    fn amount_scales_blur_and_displacement_and_channel_scales_blur_alone() {
        let want = VaryingLens.blur_at(1, AT, 0.0);
        let root = |placed: &DisplacedBlur| placed.blur.moments.mu20.sqrt();
        let lens = AdjustedLens::new(&VaryingLens, 2.0, vec![1.0; 2], (0.0, 0.0)).expect("valid");
        let twice = lens.blur_at(1, AT, 0.0);
        assert!((root(&twice) / root(&want) - 2.0).abs() < 1e-12);
        assert_eq!(twice.displacement_px.0, 2.0 * want.displacement_px.0);
        let lens = AdjustedLens::new(&VaryingLens, 1.0, vec![1.0, 2.0], (0.0, 0.0)).expect("valid");
        let wide = lens.blur_at(1, AT, 0.0);
        assert!((root(&wide) / root(&want) - 2.0).abs() < 1e-12);
        assert_eq!(wide.displacement_px, want.displacement_px);
        assert_eq!(lens.blur_at(0, AT, 0.0), VaryingLens.blur_at(0, AT, 0.0));
        let lens = AdjustedLens::new(&VaryingLens, 0.0, vec![1.0; 2], (0.0, 0.0)).expect("valid");
        let none = lens.blur_at(1, AT, 0.0);
        assert_eq!(none.displacement_px, (0.0, 0.0));
        assert_eq!(none.blur.moments.to_array(), [0.0; 7]);
    }

    #[test]
    fn an_axis_offset_shifts_the_frame() {
        let lens =
            AdjustedLens::new(&VaryingLens, 1.0, vec![1.0; 2], (30.0, -12.0)).expect("valid");
        let frame = VaryingLens.frame();
        let point = frame.image_point(AT);
        let moved = frame.field_point(seidel_optics::field::ImagePoint::new(
            point.x_px - 30.0,
            point.y_px + 12.0,
        ));
        let (got, want) = (lens.blur_at(0, AT, 0.0), VaryingLens.blur_at(0, moved, 0.0));
        assert!((got.blur.moments.mu20 - want.blur.moments.mu20).abs() < 1e-12);
        assert!((got.displacement_px.1 - want.displacement_px.1).abs() < 1e-12);
        assert!(
            (got.displacement_px.1 - VaryingLens.blur_at(0, AT, 0.0).displacement_px.1).abs() > 0.1
        );
    }

    #[test]
    fn invalid_values_are_refused() {
        let error =
            |scale, x| AdjustedLens::new(&VaryingLens, 1.0, vec![1.0, scale], (x, 0.0)).err();
        assert!(error(1.5, 3.0).is_none());
        for (scale, x) in [(0.0, 0.0), (f64::INFINITY, 0.0), (1.0, f64::NAN)] {
            assert!(error(scale, x).is_some(), "{scale} {x}");
        }
        assert!(AdjustedLens::new(&VaryingLens, 1.0, vec![1.0], (0.0, 0.0)).is_err());
    }
}
