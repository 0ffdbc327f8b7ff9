//! How lens channels act on the planes of a plate.

use seidel_optics::error::{Error, Result};
use seidel_optics::predict::Predictor;

/// How much each lens channel acts on each plane of a plate with colours called `names`, in the order of
/// [`Light`](super::Light), with an alpha and an alpha for each colour or not: a colour plane takes
/// the lens channel of its name, or the only one there is; a monochrome plate takes all alike; alpha is
/// blurred by the mean of what blurs the colours, so that it covers the light of every channel; the alpha of one
/// colour is blurred as that colour.
///
/// # Errors
/// A colour plane for which the lens has no channel.
pub fn plate_weights(
    names: &[String],
    (has_alpha, has_own_alphas): (bool, bool),
    lens: &Predictor,
) -> Result<Vec<Vec<f64>>> {
    let channels = lens.channel_names();
    let mut weights: Vec<Vec<f64>> = Vec::new();
    for name in names {
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
                ));
            }
        };
        weights.push(chosen);
    }
    if has_alpha {
        let count = weights.len() as f64;
        let mean = (0..channels.len())
            .map(|k| weights.iter().map(|w| w[k]).sum::<f64>() / count)
            .collect();
        let of_colours = if has_own_alphas {
            weights.clone()
        } else {
            Vec::new()
        };
        weights.push(mean);
        weights.extend(of_colours);
    }
    Ok(weights)
}
