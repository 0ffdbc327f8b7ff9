//! Options by which a lens is used otherwise than it was measured.

use clap::Args;
use seidel_core::field::ImagePoint;
use seidel_core::predict::Predictor;
use seidel_core::render::AdjustedLens;
use seidel_core::{Error, Result};

use crate::commands::parse_point;

/// Options about how strong the lens is.
#[derive(Debug, Clone, Args)]
pub(crate) struct AdjustArgs {
    /// How strong the lens's blur and displacement are: 0 leaves the plate as it is, 1 is as measured
    #[arg(
        long,
        value_name = "A",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub(crate) amount: f64,
    /// Scale the blur of single channels of the lens, such as R=1.1,B=0.9
    #[arg(long, value_name = "CHANNEL=SCALE", value_delimiter = ',', value_parser = parse_scale)]
    channel_scale: Vec<(String, f64)>,
    /// Where the optical axis lies, in plate pixels right of and below where it would: for plates cropped
    /// off the middle
    #[arg(long, value_name = "X,Y", value_parser = parse_point, allow_hyphen_values = true)]
    axis_offset: Option<ImagePoint>,
}

fn parse_scale(text: &str) -> std::result::Result<(String, f64), String> {
    let wrong = || "give a channel and its scale, such as R=1.1".to_owned();
    let (name, scale) = text.split_once('=').ok_or_else(wrong)?;
    let scale = scale.trim().parse().map_err(|_| wrong())?;
    Ok((name.trim().to_owned(), scale))
}

impl AdjustArgs {
    /// Whether the plate stays as it is.
    pub(crate) fn is_nothing(&self) -> bool {
        self.amount == 0.0
    }

    /// The same with `share` of the amount.
    pub(super) fn weakened(&self, share: f64) -> Self {
        Self {
            amount: share_of(self.amount, share),
            ..self.clone()
        }
    }

    /// The settings, by name.
    pub(super) fn told(&self) -> Vec<(String, String)> {
        let scales: Vec<String> = (self.channel_scale.iter())
            .map(|(name, scale)| format!("{name}={scale}"))
            .collect();
        let (x, y) = self.axis_offset_px();
        let named = |name: &str, value: String| (name.to_owned(), value);
        vec![
            named("amount", self.amount.to_string()),
            named("channel-scale", scales.join(",")),
            named("axis-offset", format!("{x},{y}")),
        ]
    }

    /// By how much the axis is moved, plate pixels (x, y).
    pub(crate) fn axis_offset_px(&self) -> (f64, f64) {
        self.axis_offset.map_or((0.0, 0.0), |at| (at.x_px, at.y_px))
    }

    /// Puts the axis elsewhere along x, y or both, plate pixels.
    pub(crate) fn move_axis(&mut self, x: Option<f64>, y: Option<f64>) {
        let at = self.axis_offset.map_or((0.0, 0.0), |at| (at.x_px, at.y_px));
        self.axis_offset = Some(ImagePoint::new(x.unwrap_or(at.0), y.unwrap_or(at.1)));
    }

    /// Scales the blur of one channel by `scale`, and no longer by what it was scaled by.
    pub(crate) fn scale_channel(&mut self, channel: &str, scale: f64) {
        self.channel_scale.retain(|(name, _)| name != channel);
        self.channel_scale.push((channel.to_owned(), scale));
    }

    /// By how much the blur of each channel of `lens` is scaled.
    ///
    /// # Errors
    /// Channels that the lens has not.
    pub(crate) fn channel_scales(&self, lens: &Predictor) -> Result<Vec<f64>> {
        let names = lens.channel_names();
        let mut scales = vec![1.0; names.len()];
        for (name, by) in &self.channel_scale {
            let index = names.iter().position(|n| n == name).ok_or_else(|| {
                Error::new(
                    format!("--channel-scale {name}"),
                    "names no channel of the lens",
                    format!("the lens has {}", names.join(", ")),
                )
            })?;
            scales[index] = *by;
        }
        Ok(scales)
    }

    /// Whether `lens` can be used so.
    ///
    /// # Errors
    /// Values that cannot be, and channels that the lens has not.
    pub(crate) fn check(&self, lens: &Predictor) -> Result<()> {
        let scales = self.channel_scales(lens)?;
        AdjustedLens::new(lens, self.amount, scales, self.axis_offset_px()).map(|_| ())
    }
}

/// `share` of an amount as one would write it: the number that its first twelve digits are read as, so that the amount
/// told is to the bit the one that was used.
pub(crate) fn share_of(amount: f64, share: f64) -> f64 {
    let product = amount * share;
    format!("{product:.11e}").parse().unwrap_or(product)
}

#[cfg(test)]
mod tests {
    use super::share_of;

    #[test]
    fn shares_of_amounts_read_back_as_they_are_told() {
        let made = [
            (0.1, 0.57, "0.057"),
            (0.7, 0.76, "0.532"),
            (1.0, 0.76, "0.76"),
        ];
        for (amount, share, told) in made {
            assert_eq!(share_of(amount, share).to_string(), told);
        }
        // Plain products do not all.
        assert_ne!((0.7_f64 * 0.76).to_string(), "0.532");
    }
}
