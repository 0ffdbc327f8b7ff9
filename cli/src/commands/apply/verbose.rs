//! `--verbose`: the methods that rendered a frame, and the error against the exact renderer.

use std::fmt::Write as _;

use clap::ValueEnum;
use seidel_core::render::{
    LevelStatistics, RenderStatistics, Rendered, SpotRenderer, VergencePass,
    low_discrepancy_pixels, psnr_at,
};
use seidel_core::{PreparedPlate, Rendering, Result, no_progress};

use super::{ApplyArgs, QualityChoice};

/// Number of pixels at which the exact render is computed.
const PIXELS: usize = 64;

/// Plates of more pixels than this share kernels drawn ray by ray between neighbours in the exact render, in cells of
/// this side.
const LARGE: usize = 512 * 512;
const CELL_PX: usize = 4;

/// Reports how `plate` was `rendered` by `rendering`, and measures the error against the exact renderer.
pub(super) fn report(
    rendering: &Rendering,
    rendered: &Rendered,
    plate: &PreparedPlate,
    args: &ApplyArgs,
) -> Result<String> {
    let Rendered { planes, statistics } = rendered;
    let mut report = heading(rendering, args);
    let mut line = |text: String| {
        // Writing to a string does not fail.
        let _ = write!(report, "\n    {text}");
    };
    line(depth(rendering, statistics));
    for (index, level) in statistics.levels.iter().enumerate() {
        line(of_level(index, level));
    }
    if statistics.exact == statistics.renders {
        line("every source pixel has its own kernel; nothing to estimate".into());
        return Ok(report);
    }
    line(format!(
        "small lights scattered exactly: {} px",
        statistics.highlights
    ));
    line(error(
        rendering,
        &planes[..plate.colour_count()],
        plate.peak(),
    )?);
    Ok(report)
}

fn heading(rendering: &Rendering, args: &ApplyArgs) -> String {
    let name = |value: Option<clap::builder::PossibleValue>| {
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    };
    let (method, id) = match args.quality {
        QualityChoice::Draft => ("gather", "draft"),
        QualityChoice::Final => ("gather", "final"),
        QualityChoice::Exact => ("scatter", "exact"),
    };
    format!(
        "rendered by {method}, quality {id}, psf {}, edges {}, geometry {}",
        rendering.scene.model.id(),
        name(args.edges.to_possible_value()),
        name(args.lens_options.geometry.to_possible_value()),
    )
}

fn depth(rendering: &Rendering, statistics: &RenderStatistics) -> String {
    match (rendering.scene.vergence, rendering.occlusion) {
        (VergencePass::Constant(_), _) => "one distance".to_owned(),
        (VergencePass::PerPixel(_), None) => "every pixel at its distance, no occlusion".to_owned(),
        (VergencePass::PerPixel(_), Some(occlusion)) => {
            let switch = |on: bool| if on { "on" } else { "off" };
            format!(
                "{} slices of depth with occlusion in {} renders, fill foreground {}, blur inside {}, holdout {}",
                statistics.layers,
                statistics.renders,
                switch(occlusion.fill_foreground),
                switch(occlusion.blur_inside),
                switch(occlusion.holdout.is_some()),
            )
        }
    }
}

fn of_level(index: usize, level: &LevelStatistics) -> String {
    let (min, max) = (level.min_tile_px, level.max_tile_px);
    let sides = if min == max {
        format!("{min}")
    } else {
        format!("{min} to {max}")
    };
    format!(
        "level {index} (1/{} resolution): {} tiles gathered, {} from the level above, side {sides} px",
        1_u64 << index.min(63),
        level.gathered,
        level.upsampled
    )
}

/// Measures the error at a few pixels against the exact render.
fn error(rendering: &Rendering, planes: &[Vec<f32>], peak: f64) -> Result<String> {
    let scene = rendering.scene;
    let pixels = low_discrepancy_pixels(scene.width, scene.height, PIXELS);
    let shared = scene.pixel_count() > LARGE;
    let spots = SpotRenderer {
        map: scene.map,
        pixels: &pixels,
        cell_px: if shared { CELL_PX } else { 1 },
    };
    let exact = Rendering {
        renderer: &spots,
        ..*rendering
    };
    let exact = exact.render(None, &no_progress)?.planes;
    let psnr = psnr_at(planes, &exact, scene.width, &pixels, peak);
    Ok(match psnr {
        Some(db) => format!(
            "estimated error: PSNR {db:.1} dB of peak {peak:.4}, from the exact light of {PIXELS} pixels"
        ),
        None => "estimated error: none, the plate has no light".to_owned(),
    })
}
