//! The PSF sheet: the PSFs of a lens over its frame, by object distance and channel.

use image::imageops::replace;
use image::{Rgb, RgbImage};
use seidel_core::profile::PupilChannel;
use seidel_core::{BlurField, LensProfile, ObjectDistance, Predictor, Result};
use seidel_optics::profile::TileCoverage;
use seidel_optics::psf::PsfModel;

use super::canvas::{Area, Canvas};
use super::psf_panel::PanelGrid;
use super::sheet_labels::{
    CAPTION_PX, GAP_PX, HEADER_PX, SCALE_PX, distance_name, draw_caption, draw_frame, draw_header,
    draw_scale,
};
use super::short_number;

const BACKGROUND: [u8; 3] = [18, 20, 25];
/// Relative difference of vergences that labels show as one distance.
const SAME_DISTANCE: f64 = 0.01;

/// The layout of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct SheetOptions {
    /// Title; the lens's first source if `None`.
    pub title: Option<String>,
    /// Number of PSFs across the frame; the number down follows from its aspect.
    pub columns: u32,
    /// Width of the sheet, px; at least 640.
    pub width_px: u32,
}

impl Default for SheetOptions {
    fn default() -> Self {
        Self {
            title: None,
            columns: 7,
            width_px: 2048,
        }
    }
}

/// Draws the PSFs of `lens` by `model` in a row of panels per object distance, from infinity inwards.
///
/// Each panel shows the frame with a cross at the optical axis and enlarged PSFs at a grid of field
/// positions; the scale bar below is in frame pixels. Channels named R, G and B get a panel of their
/// own in which they are drawn together, offset by the lens's lateral colour at the same enlargement.
/// Tone is the square root of light over the peak of each PSF.
///
/// # Errors
/// Planes that give no depth law, and a model that cannot draw the lens.
pub fn lens_sheet(
    lens: &LensProfile,
    model: &dyn PsfModel,
    options: &SheetOptions,
) -> Result<RgbImage> {
    Ok(draw(lens, model, options)?.image)
}

/// Returns `sheets` of one width below each other.
pub fn below_each_other(sheets: &[RgbImage]) -> RgbImage {
    let width = sheets.iter().map(RgbImage::width).max().unwrap_or(0);
    let height = sheets.iter().map(RgbImage::height).sum();
    let mut page = RgbImage::from_pixel(width, height, Rgb(BACKGROUND));
    let mut top = 0;
    for sheet in sheets {
        replace(&mut page, sheet, 0, top);
        top += i64::from(sheet.height());
    }
    page
}

/// The contents of a panel.
struct Panel {
    caption: String,
    /// Channels drawn together, with the colour of each.
    channels: Vec<(usize, [f32; 3])>,
}

fn draw(lens: &LensProfile, model: &dyn PsfModel, options: &SheetOptions) -> Result<Canvas> {
    let predictor = Predictor::new(lens)?;
    predictor.check_model(model)?;
    let panels = panels(lens);
    let distances = distances(lens);
    let across = across(panels.len(), distances.len());
    let width = options.width_px.max(640);
    let frame_width = (width - GAP_PX * (across + 1)) / across;
    let grid = grid(lens, frame_width, options.columns);
    let step = (
        grid.width + GAP_PX,
        grid.height + CAPTION_PX + SCALE_PX + GAP_PX,
    );
    let jobs: Vec<(ObjectDistance, &Panel)> = distances
        .iter()
        .flat_map(|d| panels.iter().map(move |p| (*d, p)))
        .collect();
    let down = (jobs.len() as u32).div_ceil(across);
    let mut canvas = Canvas::new(width, HEADER_PX + down * step.1 + 8, BACKGROUND);
    draw_header(&mut canvas, lens, model.id(), options.title.as_deref());
    for (index, (distance, panel)) in jobs.iter().enumerate() {
        let (column, row) = (index as u32 % across, index as u32 / across);
        let (left, top) = (GAP_PX + column * step.0, HEADER_PX + row * step.1);
        // One enlargement per distance, so that channels can be compared.
        let all: Vec<usize> = (0..predictor.channel_count()).collect();
        let vergence = distance.vergence_per_m().unwrap_or(0.0);
        let magnification = grid.magnification(&predictor, &all, vergence);
        let enlargement = magnification * grid.frame_scale(&lens.frame);
        let tiles = tiles_at(lens, vergence);
        let note = match tiles {
            None if holds_tiles(lens) => "  no tile",
            Some(at) if !at.bare_sides(&lens.frame).is_empty() => "  red: no tile",
            _ => "",
        };
        let caption = format!("{}  {}{note}", distance_name(*distance), panel.caption);
        let magnified = format!("PSF x{}", short_number(magnification));
        draw_caption(&mut canvas, left, top, grid.width, &caption, &magnified);
        let channels: Vec<usize> = panel.channels.iter().map(|c| c.0).collect();
        let light = grid.light(&predictor, model, &channels, vergence, enlargement);
        let area = Area {
            left,
            top: top + CAPTION_PX,
            width: grid.width,
            height: grid.height,
        };
        draw_frame(&mut canvas, area, lens, tiles);
        add_light(&mut canvas, area, panel, &light);
        draw_scale(&mut canvas, area, enlargement);
    }
    Ok(canvas)
}

/// Returns whether the profile holds the distances of the tiles of its fit.
fn holds_tiles(lens: &LensProfile) -> bool {
    let mut tiles = lens.provenance.tiles.iter();
    tiles.any(|at| at.vergence_per_m.is_some())
}

/// Returns the tiles that the fit had at a vergence, which a label rounds.
fn tiles_at(lens: &LensProfile, vergence: f64) -> Option<&TileCoverage> {
    let is_there = |own: f64| (own - vergence).abs() <= SAME_DISTANCE * own.max(SAME_DISTANCE);
    let mut tiles = lens.provenance.tiles.iter();
    tiles.find(|at| at.vergence_per_m.is_some_and(is_there))
}

/// Returns the panels of a distance: R, G and B together if those are the channels, then each alone.
fn panels(lens: &LensProfile) -> Vec<Panel> {
    let names = lens.channel_names();
    let find = |name: &str| names.iter().position(|n| n.eq_ignore_ascii_case(name));
    let mut panels = Vec::new();
    if let (3, Some(r), Some(g), Some(b)) = (names.len(), find("R"), find("G"), find("B")) {
        panels.push(Panel {
            caption: "RGB".to_owned(),
            channels: vec![
                (r, [1.0, 0.0, 0.0]),
                (g, [0.0, 1.0, 0.0]),
                (b, [0.0, 0.0, 1.0]),
            ],
        });
    }
    panels.extend(names.iter().enumerate().map(|(index, name)| {
        let tint = match name.to_ascii_uppercase().as_str() {
            "R" => [1.0, 0.32, 0.26],
            "G" => [0.36, 1.0, 0.42],
            "B" => [0.36, 0.56, 1.0],
            _ => [1.0, 0.93, 0.80],
        };
        Panel {
            caption: (*name).to_owned(),
            channels: vec![(index, tint)],
        }
    }));
    panels
}

/// Returns the number of panels side by side: those of one distance, or several distances if each has only
/// one panel.
fn across(panels: usize, distances: usize) -> u32 {
    match (panels, distances) {
        (1, 1) => 1,
        (1, 2..=4) => 2,
        (1, _) => 3,
        (panels, _) => panels.min(4) as u32,
    }
}

/// Returns the object distances to draw, from infinity inwards: the measured ones of a lens described by
/// moments; the ends of the measured range and the focus of a lens modelled ray by ray.
fn distances(lens: &LensProfile) -> Vec<ObjectDistance> {
    let planes = lens.moments_channels().iter().flat_map(|c| &c.planes);
    let mut all: Vec<ObjectDistance> = Vec::new();
    let of_pupil = lens
        .pupil_channels()
        .first()
        .map(|c| range_and_focus(lens, c));
    for distance in planes
        .map(|plane| plane.distance)
        .chain(of_pupil.into_iter().flatten())
    {
        if !all.contains(&distance) {
            all.push(distance);
        }
    }
    all.sort_by(|a, b| {
        let key = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(-1.0);
        key(a).total_cmp(&key(b))
    });
    all
}

/// Returns the distances of the least and the largest measured vergence, with the focus between them (the mean
/// vergence if the focus is unknown or outside).
fn range_and_focus(lens: &LensProfile, channel: &PupilChannel) -> Vec<ObjectDistance> {
    let (low, high) = channel.measured_vergence;
    if channel.alpha.degree() == 0 {
        return vec![ObjectDistance::Unknown];
    }
    let stated = lens.camera.focus_distance.vergence_per_m();
    let focus = stated.or_else(|| channel.focus_vergence_per_m());
    let within = focus.filter(|v| (low..=high).contains(v));
    [low, within.unwrap_or((low + high) / 2.0), high]
        .into_iter()
        .map(distance_of)
        .collect()
}

/// Returns the distance of vergence `v`, rounded to the three digits that a label shows.
fn distance_of(v: f64) -> ObjectDistance {
    if v < 1e-6 {
        return ObjectDistance::Infinity;
    }
    let step = 10.0_f64.powf((1.0 / v).log10().floor() - 2.0);
    ObjectDistance::Metres((1.0 / v / step).round() * step)
}

fn grid(lens: &LensProfile, width: u32, columns: u32) -> PanelGrid {
    let aspect = f64::from(lens.frame.height_px()) / f64::from(lens.frame.width_px());
    // Extreme aspects are limited, so that the panel stays readable.
    let height = (f64::from(width) * aspect.clamp(0.2, 3.0)).round() as u32;
    let columns = columns.clamp(1, 31);
    // With an odd number of rows, one runs through the axis.
    let rows = (f64::from(columns) * f64::from(height) / f64::from(width) * 1.15).round() as u32;
    PanelGrid {
        columns,
        rows: (rows / 2 * 2 + 1).max(1),
        width,
        height,
    }
}

/// Adds the light of the PSFs to the panel in the colours of its channels.
fn add_light(canvas: &mut Canvas, area: Area, panel: &Panel, light: &[Vec<f32>]) {
    for row in 0..area.height {
        for column in 0..area.width {
            let index = (row * area.width + column) as usize;
            let mut sum = [0.0_f32; 3];
            for (plane, (_, tint)) in light.iter().zip(&panel.channels) {
                let tone = plane[index].clamp(0.0, 1.0).sqrt();
                for (s, t) in sum.iter_mut().zip(tint) {
                    *s += tone * t;
                }
            }
            if sum == [0.0; 3] {
                continue;
            }
            let pixel = canvas
                .image
                .get_pixel_mut(area.left + column, area.top + row);
            for (value, s) in pixel.0.iter_mut().zip(sum) {
                let under = f32::from(*value) / 255.0;
                let over = under + (1.0 - under) * s.min(1.0);
                *value = (over * 255.0).round() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sheet_labels::BARE;
    use super::*;
    use crate::demo::lens::lens;
    use seidel_core::profile::{LensDescription, MomentsChannel, MomentsPlane};
    use seidel_optics::psf;

    /// Returns the demo's lens described by moments, with other channels and planes.
    fn shaped(names: &[&str], planes: &[ObjectDistance]) -> LensProfile {
        let base = lens(640, 360).expect("a frame");
        let pupils = base.pupil_channels();
        let channels = names
            .iter()
            .enumerate()
            .map(|(index, name)| MomentsChannel {
                name: (*name).to_owned(),
                planes: planes
                    .iter()
                    .enumerate()
                    .map(|(k, &distance)| {
                        let v = distance.vergence_per_m().unwrap_or(0.2 * k as f64);
                        MomentsPlane {
                            distance,
                            s: pupils[index % 3].numbers(v).coefficients(),
                            s_sigma: [0.0; 10],
                            displacement: None,
                            tiles_used: 0,
                            tiles_rejected: 0,
                        }
                    })
                    .collect(),
            })
            .collect();
        LensProfile {
            description: LensDescription::Moments(channels),
            ..base
        }
    }

    #[test]
    fn every_model_draws_a_sheet_of_a_pupil_lens() {
        let options = SheetOptions {
            columns: 5,
            width_px: 1280,
            ..SheetOptions::default()
        };
        let rays = lens(640, 360).expect("a frame");
        assert_eq!(
            distances(&rays),
            [
                ObjectDistance::Infinity,
                ObjectDistance::Metres(2.0),
                ObjectDistance::Metres(1.2),
            ]
        );
        for model in psf::ALL {
            let canvas = draw(&rays, *model, &options).expect("drawable");
            let lit = canvas
                .image
                .pixels()
                .filter(|p| p.0.iter().any(|&v| v > 160));
            assert!(lit.count() > 1000, "{}", model.id());
        }
        let moments = shaped(&["Y"], &[ObjectDistance::Unknown]);
        assert!(draw(&moments, &psf::Pupil, &options).is_err());
    }

    #[test]
    fn labels_fit_for_all_numbers_of_channels_and_planes() {
        use ObjectDistance::{Infinity, Metres, Unknown};
        let six = [
            Infinity,
            Metres(12.5),
            Metres(5.0),
            Metres(3.0),
            Metres(2.0),
            Metres(0.85),
        ];
        let planes: [&[ObjectDistance]; 5] = [&[Unknown], &[Infinity], &six[..2], &six[..5], &six];
        let channels: [&[&str]; 4] = [
            &["Y"],
            &["R", "G", "B"],
            &["C0", "C1"],
            &["a", "b", "c", "d", "e"],
        ];
        let options = SheetOptions {
            columns: 5,
            width_px: 1280,
            ..SheetOptions::default()
        };
        let shortest = shaped(channels[0], planes[0]);
        for planes in planes {
            for names in channels {
                let lens = shaped(names, planes);
                for model in psf::ALL {
                    // Names of models do not depend on the numbers of channels and planes.
                    let shown = model.id() == "skew-normal" || lens == shortest;
                    if !shown || model.needs_rays() {
                        continue;
                    }
                    let canvas = draw(&lens, *model, &options).expect("drawable");
                    assert_eq!(canvas.shortened, 0, "{names:?} {planes:?}");
                    let lit = canvas
                        .image
                        .pixels()
                        .filter(|p| p.0.iter().any(|&v| v > 160));
                    assert!(lit.count() > 1000, "{names:?} {planes:?}");
                }
            }
        }
    }

    #[test]
    fn the_part_without_tiles_is_red() {
        use ObjectDistance::{Infinity, Metres};
        let mut lens = shaped(&["R", "G", "B"], &[Infinity, Metres(2.0)]);
        let options = SheetOptions {
            columns: 5,
            width_px: 1280,
            ..SheetOptions::default()
        };
        let red = |lens: &LensProfile| {
            let canvas = draw(lens, &psf::SkewNormal, &options).expect("drawable");
            assert_eq!(canvas.shortened, 0);
            canvas.image.pixels().filter(|p| p.0 == BARE).count()
        };
        assert_eq!(red(&lens), 0);
        let whole = TileCoverage {
            vergence_per_m: Some(0.5),
            tiles: 9,
            x_px: [20.0, 620.0],
            y_px: [20.0, 340.0],
        };
        lens.provenance.tiles = vec![whole.clone()];
        assert_eq!(red(&lens), 0);
        lens.provenance.tiles[0].x_px[1] = 320.0;
        assert!(red(&lens) > 1000, "{}", red(&lens));
    }

    #[test]
    fn long_titles_are_shortened() {
        let lens = shaped(&["Y"], &[ObjectDistance::Unknown]);
        let options = SheetOptions {
            title: Some("x".repeat(500)),
            ..SheetOptions::default()
        };
        let canvas = draw(&lens, &psf::SkewNormal, &options).expect("drawable");
        assert_eq!(canvas.shortened, 1);
        let last = canvas.image.width() - 1;
        assert!(
            (0..canvas.image.height()).all(|y| canvas.image.get_pixel(last, y).0 == BACKGROUND)
        );
    }
}
