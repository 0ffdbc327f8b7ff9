//! Options that are more than one number: scales of single channels, the offset of the optical axis, the pixel to focus on.

use clap::Args;
use seidel_core::{ChannelScale, ImagePoint, Settings};

use super::{SettingsRecord, setting};
use crate::commands::parse_point;

/// Options about single channels, the axis of the lens and its focus.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct AdjustArgs {
    /// Factors on the blur of single channels of the lens, such as R=1.1,B=0.9; 1 if omitted
    #[arg(long, value_name = "CHANNEL=SCALE", value_delimiter = ',', value_parser = parse_scale)]
    channel_scale: Vec<ChannelScale>,
    /// Offset of the optical axis in plate pixels, right and down: for plates cropped off centre
    #[arg(long, value_name = "X,Y", value_parser = parse_point, allow_hyphen_values = true)]
    axis_offset: Option<ImagePoint>,
    /// Pixel to focus on, right and down from the corner of the display window: at the depth under it, by the depth pass
    ///
    /// It is the median over a disc of 3 px radius. In a table of --animate the columns focus-at.x and focus-at.y follow an object.
    #[arg(long, help_heading = "Focus", value_name = "X,Y", value_parser = parse_point, conflicts_with = "focus-distance")]
    pub(super) focus_at: Option<ImagePoint>,
}

fn parse_scale(text: &str) -> Result<ChannelScale, String> {
    let scale = text.split_once('=').and_then(|(name, scale)| {
        Some(ChannelScale {
            channel: name.trim().to_owned(),
            scale: scale.trim().parse().ok()?,
        })
    });
    scale.ok_or_else(|| "give a channel and its scale, such as R=1.1".to_owned())
}

impl AdjustArgs {
    /// Writes the options to `settings`.
    pub(super) fn put(&self, settings: &mut Settings) {
        settings.channel_scales.clone_from(&self.channel_scale);
        let offset = self.axis_offset.map(|at| (at.x_px, at.y_px));
        settings.axis_offset_px = offset.unwrap_or_default();
    }
}

/// Returns scales and offset of `settings` by name.
pub(super) fn adjust_record(settings: &Settings) -> SettingsRecord {
    let scales = (settings.channel_scales.iter())
        .map(|scale| format!("{}={}", scale.channel, scale.scale))
        .collect::<Vec<_>>();
    let (x, y) = settings.axis_offset_px;
    vec![
        setting("channel-scale", scales.join(",")),
        setting("axis-offset", format!("{x},{y}")),
    ]
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
