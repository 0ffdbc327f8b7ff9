//! What the calls share: the bound on memory, and the results written to the caller's pictures.

use seidel_core::Image;

use crate::image::{SeidelRect, View};
use crate::settings::Settings;
use crate::status::{Failure, Result, SeidelStatus};

/// Refuses work that needs more memory than the settings allow.
pub(crate) fn check_memory(needed: u64, settings: &Settings) -> Result<()> {
    let most = settings.raw.memory;
    if most == 0 || needed <= most {
        return Ok(());
    }
    Err(Failure::new(
        SeidelStatus::Memory,
        format!(
            "settings.memory: is {most} bytes, {needed} are needed; allow more, or give a smaller extent"
        ),
    ))
}

/// Writes planes over `rect` to the caller's pictures.
pub(crate) fn write_back(image: &Image, rect: SeidelRect, output: &View, alphas: Option<&View>) {
    let planes = image.colours.iter().chain(&image.alpha);
    for (channel, plane) in planes.enumerate().take(output.channels) {
        output.write(channel, rect, plane);
    }
    if let Some(alphas) = alphas {
        for (channel, plane) in image
            .channel_alphas
            .iter()
            .enumerate()
            .take(alphas.channels)
        {
            alphas.write(channel, rect, plane);
        }
    }
}
