//! `--verbose`: the methods that rendered a frame, and the error against the exact renderer.

use std::fmt::Write as _;

use seidel_core::{PreparedPlate, Quality, Rendering, Result, no_progress};
use seidel_render::{
    LevelStatistics, RenderStatistics, Rendered, SpotRenderer, VergencePass,
    low_discrepancy_pixels, psnr_at,
};

use super::of_edges;
use crate::commands::knobs::knob_text;

/// Number of pixels at which the exact render is computed.
const PIXELS: usize = 64;

/// Number of pixels above which the exact render shares kernels modelled ray by ray within cells of [`CELL_PX`].
const LARGE: usize = 512 * 512;
/// Side of cells of source pixels that share a kernel, px.
const CELL_PX: usize = 4;

/// Returns a report of the methods that rendered `plate`, and of the error against the exact renderer.
///
/// # Errors
/// Those of the exact renderer.
pub(super) fn report(
    rendering: &Rendering,
    rendered: &Rendered,
    plate: &PreparedPlate,
) -> Result<String> {
    let Rendered { planes, statistics } = rendered;
    let mut report = heading(rendering, plate);
    let mut line = |text: String| {
        // Writing to a string does not fail.
        let _ = write!(report, "\n    {text}");
    };
    line(depth_line(rendering, statistics));
    for (index, level) in statistics.levels.iter().enumerate() {
        line(level_line(index, level));
    }
    if statistics.exact == statistics.renders {
        line("every source pixel has its own kernel; nothing to estimate".into());
        return Ok(report);
    }
    line(format!(
        "small lights rendered apart: {} px",
        statistics.highlights
    ));
    let colours = &planes[..plate.colour_count()];
    line(error_line(rendering, colours, plate.peak())?);
    Ok(report)
}

fn heading(rendering: &Rendering, plate: &PreparedPlate) -> String {
    let settings = &of_edges(plate.session().settings(), plate.edges());
    let method = match settings.quality {
        Quality::Draft | Quality::Final => "gather",
        Quality::Exact => "scatter",
    };
    format!(
        "rendered by {method}, quality {}, psf {}, edges {}, geometry {}",
        knob_text("quality", settings),
        rendering.scene.model.id(),
        knob_text("edges", settings),
        knob_text("geometry", settings),
    )
}

fn depth_line(rendering: &Rendering, statistics: &RenderStatistics) -> String {
    match (rendering.scene.vergence, rendering.occlusion) {
        (VergencePass::Constant(_), _) => "one distance".to_owned(),
        (VergencePass::PerPixel(_), None) => "every pixel at its distance, no occlusion".to_owned(),
        (VergencePass::PerPixel(_), Some(occlusion)) => {
            let switch = |is_on| if is_on { "on" } else { "off" };
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

fn level_line(index: usize, level: &LevelStatistics) -> String {
    let (min, max) = (level.min_tile_px, level.max_tile_px);
    let sides = if min == max {
        format!("{min}")
    } else {
        format!("{min} to {max}")
    };
    format!(
        "level {index} (1/{} resolution): {} tiles gathered, {} scattered, {} from the level above, side {sides} px",
        1_u64 << index.min(63),
        level.gathered,
        level.scattered,
        level.upsampled
    )
}

/// Measures the error at [`PIXELS`] pixels against the exact render.
fn error_line(rendering: &Rendering, planes: &[Vec<f32>], peak: f64) -> Result<String> {
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
