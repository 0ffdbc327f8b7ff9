//! `--verbose`: how a frame was rendered, and how far that is from an exact render.

use std::fmt::Write as _;

use clap::ValueEnum;
use seidel_core::Result;
use seidel_core::render::{
    LevelStatistics, RenderStatistics, Rendered, Renderer, SpotRenderer, VergencePass,
    low_discrepancy_pixels, psnr_at,
};

use super::ApplyArgs;
use crate::commands::plates::Rendering;

/// Pixels at which the exact light is made.
const PIXELS: usize = 64;

/// From this many pixels on neighbours share kernels drawn ray by ray where the exact light is made, in cells
/// of this side.
const LARGE: usize = 512 * 512;
const CELL_PX: usize = 4;

/// Renders by `inner`; returns the planes and what there is to say of it. The first `colours` planes are colour,
/// `peak` the largest value before.
pub(super) fn rendered(
    rendering: &Rendering,
    inner: &dyn Renderer,
    (args, colours, peak): (&ApplyArgs, usize, f64),
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<(Vec<Vec<f32>>, String)> {
    let Rendered { planes, statistics } = rendering.by(inner, progress)?;
    let mut told = heading(rendering, args, inner.id());
    let mut line = |text: String| {
        // A string takes all that is written to it.
        let _ = write!(told, "\n    {text}");
    };
    line(depth(rendering, &statistics));
    for (index, level) in statistics.levels.iter().enumerate() {
        line(of_level(index, level));
    }
    if statistics.exact == statistics.renders {
        line("every source pixel has its own kernel; nothing to estimate".into());
        return Ok((planes, told));
    }
    line(format!(
        "small lights scattered exactly: {} px",
        statistics.highlights
    ));
    line(error(rendering, &planes[..colours], peak)?);
    Ok((planes, told))
}

fn heading(rendering: &Rendering, args: &ApplyArgs, id: &str) -> String {
    let name = |value: Option<clap::builder::PossibleValue>| {
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    };
    let way = if id == "exact" { "scatter" } else { "gather" };
    format!(
        "rendered by {way}, quality {id}, psf {}, edges {}, geometry {}",
        rendering.scene.model.id(),
        name(args.edges.to_possible_value()),
        name(args.sight.geometry.to_possible_value()),
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

/// The exact light at a few pixels against what was rendered there.
fn error(rendering: &Rendering, planes: &[Vec<f32>], peak: f64) -> Result<String> {
    let scene = rendering.scene;
    let pixels = low_discrepancy_pixels(scene.width, scene.height, PIXELS);
    let shared = scene.pixel_count() > LARGE;
    let spots = SpotRenderer {
        map: scene.map,
        pixels: &pixels,
        cell_px: if shared { CELL_PX } else { 1 },
    };
    let exact = rendering.by(&spots, &|_| true)?.planes;
    let psnr = psnr_at(planes, &exact, scene.width, &pixels, peak);
    Ok(match psnr {
        Some(db) => format!(
            "estimated error: PSNR {db:.1} dB of peak {peak:.4}, from the exact light of {PIXELS} pixels"
        ),
        None => "estimated error: none, the plate has no light".to_owned(),
    })
}
