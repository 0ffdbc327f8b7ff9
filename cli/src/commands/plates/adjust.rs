//! Options that scale the blur of a lens, or move its axis.

use clap::Args;
use seidel_core::ChannelScale;
use seidel_core::ImagePoint;

use super::{SettingsRecord, setting};
use crate::commands::parse_point;

/// Options about the strength of the lens and its axis.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct AdjustArgs {
    /// Strength of the lens's blur and displacement, 0 to 16: 0 leaves the plate unchanged, 1 is as measured
    #[arg(long, value_name = "A", default_value_t = 1.0)]
    pub(crate) amount: f64,
    /// Factors on the blur of single channels of the lens, such as R=1.1,B=0.9; 1 if omitted
    #[arg(long, value_name = "CHANNEL=SCALE", value_delimiter = ',', value_parser = parse_scale)]
    channel_scale: Vec<(String, f64)>,
    /// Offset of the optical axis in plate pixels, right and down: for plates cropped off centre
    #[arg(long, value_name = "X,Y", value_parser = parse_point, allow_hyphen_values = true)]
    axis_offset: Option<ImagePoint>,
}

fn parse_scale(text: &str) -> Result<(String, f64), String> {
    let scale = text
        .split_once('=')
        .and_then(|(name, scale)| Some((name.trim().to_owned(), scale.trim().parse().ok()?)));
    scale.ok_or_else(|| "give a channel and its scale, such as R=1.1".to_owned())
}

impl AdjustArgs {
    /// Returns the options with the amount multiplied by `factor`.
    pub(super) fn with_amount_scaled(&self, factor: f64) -> Self {
        Self {
            amount: scaled_amount(self.amount, factor),
            ..self.clone()
        }
    }

    /// Returns the settings by name.
    pub(super) fn record(&self) -> SettingsRecord {
        let scales: Vec<String> = (self.channel_scale.iter())
            .map(|(name, scale)| format!("{name}={scale}"))
            .collect();
        let (x, y) = self.axis_offset_px();
        vec![
            setting("amount", self.amount),
            setting("channel-scale", scales.join(",")),
            setting("axis-offset", format!("{x},{y}")),
        ]
    }

    /// Returns the offset of the optical axis, plate pixels (x, y).
    pub(super) fn axis_offset_px(&self) -> (f64, f64) {
        self.axis_offset.map_or((0.0, 0.0), |at| (at.x_px, at.y_px))
    }

    /// Sets the offset of the optical axis along x, y or both, plate pixels.
    pub(super) fn set_axis_offset(&mut self, x: Option<f64>, y: Option<f64>) {
        let (old_x, old_y) = self.axis_offset_px();
        self.axis_offset = Some(ImagePoint::new(x.unwrap_or(old_x), y.unwrap_or(old_y)));
    }

    /// Sets the scale of the blur of one channel.
    pub(super) fn set_channel_scale(&mut self, channel: &str, scale: f64) {
        self.channel_scale.retain(|(name, _)| name != channel);
        self.channel_scale.push((channel.to_owned(), scale));
    }

    /// Returns the scales of the blur of single channels.
    pub(super) fn channel_scales(&self) -> Vec<ChannelScale> {
        let scales = self.channel_scale.iter();
        let scales = scales.map(|(channel, scale)| ChannelScale {
            channel: channel.clone(),
            scale: *scale,
        });
        scales.collect()
    }
}

/// Returns `amount * factor` rounded to twelve digits, so that the printed amount parses back to the same bits.
pub(crate) fn scaled_amount(amount: f64, factor: f64) -> f64 {
    let product = amount * factor;
    format!("{product:.11e}").parse().unwrap_or(product)
}

#[cfg(test)]
mod tests {
    use super::scaled_amount;

    #[test]
    fn printed_amounts_parse_back_to_the_same_bits() {
        let cases = [
            (0.1, 0.57, "0.057"),
            (0.7, 0.76, "0.532"),
            (1.0, 0.76, "0.76"),
        ];
        for (amount, factor, printed) in cases {
            assert_eq!(scaled_amount(amount, factor).to_string(), printed);
        }
        // A plain product does not.
        assert_ne!((0.7_f64 * 0.76).to_string(), "0.532");
    }
}
