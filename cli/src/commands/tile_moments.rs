//! Options about the moments of tiles, for fits and evaluations.

use clap::Args;
use seidel_core::fitting::Weighting;
use seidel_optics::moments::support::Support;

/// Options about the moments of tiles.
#[derive(Debug, Args)]
pub(super) struct MomentArgs {
    /// Weight all moments equally and reject nothing, as in the paper (fit: with --model moments; eval: in Figure 13)
    #[arg(long)]
    pub(super) unweighted: bool,
    /// Use all pixels of a tile, even those that contain only noise
    #[arg(long)]
    all_pixels: bool,
}

impl MomentArgs {
    /// Returns the weighting of moments.
    pub(super) fn weighting(&self) -> Weighting {
        if self.unweighted {
            Weighting::Unweighted
        } else {
            Weighting::Weighted
        }
    }

    /// Returns the pixels that moments are taken of.
    pub(super) fn support(&self) -> Support {
        if self.all_pixels {
            Support::AllPixels
        } else {
            Support::Auto
        }
    }
}
