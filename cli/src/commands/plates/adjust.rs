//! Options that make a lens stronger or weaker than it was measured, or move its axis.

use clap::Args;
use seidel_core::ChannelScale;
use seidel_core::ImagePoint;

use crate::commands::parse_point;

/// Options about the strength of the lens and its axis.
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
    /// Returns the options with `share` of the amount.
    pub(super) fn weakened(&self, share: f64) -> Self {
        Self {
            amount: share_of(self.amount, share),
            ..self.clone()
        }
    }

    /// The settings by name.
    pub(super) fn record(&self) -> Vec<(String, String)> {
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

    /// Offset of the optical axis, plate pixels (x, y).
    pub(crate) fn axis_offset_px(&self) -> (f64, f64) {
        self.axis_offset.map_or((0.0, 0.0), |at| (at.x_px, at.y_px))
    }

    /// Moves the optical axis along x, y or both, to plate pixels.
    pub(crate) fn move_axis(&mut self, x: Option<f64>, y: Option<f64>) {
        let at = self.axis_offset.map_or((0.0, 0.0), |at| (at.x_px, at.y_px));
        self.axis_offset = Some(ImagePoint::new(x.unwrap_or(at.0), y.unwrap_or(at.1)));
    }

    /// Sets the scale of one channel's blur.
    pub(crate) fn scale_channel(&mut self, channel: &str, scale: f64) {
        self.channel_scale.retain(|(name, _)| name != channel);
        self.channel_scale.push((channel.to_owned(), scale));
    }

    /// The scales of single channels' blur.
    pub(super) fn channel_scales(&self) -> Vec<ChannelScale> {
        let scales = self.channel_scale.iter();
        let scales = scales.map(|(channel, scale)| ChannelScale {
            channel: channel.clone(),
            scale: *scale,
        });
        scales.collect()
    }
}

/// Returns `share` of `amount`, rounded to twelve digits: the amount that is printed is the one that was used, to the bit.
pub(crate) fn share_of(amount: f64, share: f64) -> f64 {
    let product = amount * share;
    format!("{product:.11e}").parse().unwrap_or(product)
}

#[cfg(test)]
mod tests {
    use super::share_of;

    #[test]
    fn printed_shares_read_back_to_the_bit() {
        let made = [
            (0.1, 0.57, "0.057"),
            (0.7, 0.76, "0.532"),
            (1.0, 0.76, "0.76"),
        ];
        for (amount, share, printed) in made {
            assert_eq!(share_of(amount, share).to_string(), printed);
        }
        // A plain product does not.
        assert_ne!((0.7_f64 * 0.76).to_string(), "0.532");
    }
}
