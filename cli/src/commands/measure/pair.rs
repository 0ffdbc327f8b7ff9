//! `seidel measure pair`: a sharp and a blurred photograph of one scene from one place.

use clap::Args;
use seidel_measure::Photograph;
use seidel_measure::chart::{ChartPicture, ChartSettings, Content, sharp_plane};

use super::chart::{Tile, finish, measure_all, parse_tile, prepare};
use super::common::CommonArgs;
use super::faults::{ForceArgs, Insistence};
use super::{output, photographs};
use crate::Console;
use crate::commands::CommandError;

/// Options of `seidel measure pair`.
#[derive(Debug, Args)]
pub struct PairArgs {
    /// First the sharp photograph, stopped down and in focus; then the blurred one, from the same place
    #[command(flatten)]
    pub(super) common: CommonArgs,
    /// Standard deviation of the blur that the sharp photograph has itself, in pixels, to add to the result
    #[arg(long, value_name = "PX", default_value_t = 0.0)]
    sharp_sigma_px: f64,
    /// Width and height of the tiles in pixels, odd, or `auto` for as wide as the blur needs
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = parse_tile)]
    tile: Tile,
    #[command(flatten)]
    force: ForceArgs,
}

pub(super) fn run(args: &PairArgs, console: &mut Console) -> Result<(), CommandError> {
    let common = &args.common;
    if common.photographs.len() != 2 {
        return Err(CommandError::Usage(
            "give two photographs: the sharp one, then the blurred one".to_owned(),
        ));
    }
    if !(0.0..=5.0).contains(&args.sharp_sigma_px) {
        return Err(CommandError::Usage(
            "--sharp-sigma-px: give 0 to 5 pixels".to_owned(),
        ));
    }
    common.check()?;
    output::check_targets(common)?;
    let (mut photographs, calibration) =
        photographs::read_all(&common.photographs, &common.input, console)?;
    prepare(&mut photographs, &calibration)?;
    let blurred = photographs.pop().into_iter().collect();
    let charts = charts(&photographs[0])?;
    let settings = ChartSettings {
        tile: args.tile.side(),
        same_view: true,
        added_sigma_px: args.sharp_sigma_px,
        ..ChartSettings::default()
    };
    let measured = measure_all(blurred, &[charts], &settings, console)?;
    let remarks = args.remarks(&photographs[0]);
    finish(
        common,
        &measured,
        &remarks,
        Insistence::of(&args.force),
        console,
    )
}

/// Returns the sharp photograph as the chart of every channel.
fn charts(sharp: &Photograph) -> Result<Vec<ChartPicture>, CommandError> {
    let mut charts = Vec::new();
    for channel in 0..sharp.channels.len() {
        let samples = sharp_plane(sharp, channel);
        charts.push(ChartPicture::new(
            sharp.width,
            sharp.height,
            samples,
            Content::Photograph,
        )?);
    }
    Ok(charts)
}

impl PairArgs {
    fn remarks(&self, sharp: &Photograph) -> Vec<String> {
        let mut remarks = vec![if self.sharp_sigma_px > 0.0 {
            format!(
                "a blur of {} px of the sharp photograph was added to all PSFs",
                self.sharp_sigma_px
            )
        } else {
            format!(
                "PSFs are relative to {}: its own blur is missing from them; state it with --sharp-sigma-px",
                sharp.name
            )
        }];
        if sharp.mosaic.is_some() {
            remarks.push(format!(
                "the colours of {} were interpolated, which sharpens the result a little; photograph a printed chart where accuracy counts",
                sharp.name
            ));
        }
        remarks
    }
}
