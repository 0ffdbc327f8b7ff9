//! The weights of lens channels on the planes of a plate.

use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::predict::Predictor;

use crate::planes::PlaneLayout;

/// Returns the weight of each lens channel on each plane of an image of this `layout`: colours, alpha, alphas of single colours.
///
/// A colour takes the lens channel of its name, or the only one there is; a monochrome plane takes all alike. Alpha
/// takes the mean weights of the colours, so that it covers the light of every channel; the alpha of one colour takes
/// that colour's weights.
///
/// # Errors
/// A colour for which the lens has no channel.
pub(crate) fn channel_weights(layout: &PlaneLayout, lens: &Predictor) -> Result<Vec<Vec<f64>>> {
    let channels = lens.channel_names();
    let mut weights: Vec<Vec<f64>> = Vec::new();
    for name in &layout.colour_names {
        let own = channels.iter().position(|n| n == name);
        let chosen = match own {
            Some(index) => (0..channels.len())
                .map(|k| f64::from(u8::from(k == index)))
                .collect(),
            None if channels.len() == 1 => vec![1.0],
            None if name == "Y" => vec![1.0 / channels.len() as f64; channels.len()],
            None => {
                return Err(Error::new(
                    format!("channel {name}"),
                    format!(
                        "has no counterpart in the lens, which has {}",
                        channels.join(", ")
                    ),
                    "use a lens with this channel, or one with a single channel",
                )
                .with_kind(ErrorKind::Unsupported));
            }
        };
        weights.push(chosen);
    }
    if layout.has_alpha {
        let count = weights.len() as f64;
        let mean = (0..channels.len())
            .map(|k| weights.iter().map(|w| w[k]).sum::<f64>() / count)
            .collect();
        let of_colours = if layout.has_channel_alphas {
            weights.clone()
        } else {
            Vec::new()
        };
        weights.push(mean);
        weights.extend(of_colours);
    }
    Ok(weights)
}
