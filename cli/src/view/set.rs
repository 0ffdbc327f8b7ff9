//! The page of an observation set: measured PSFs at their places in the frame, and those of a lens beside them.

use seidel_core::{ObjectDistance, Observation, ObservationSet};
use serde::Serialize;

use super::atlas::{Atlas, Light, ShownChannels, most_tiles, tile_side};
use super::{PageText, page};
use crate::pictures::sheet_labels::distance_name;

/// Share of the peak from which a pixel counts as lit when the part to show is chosen: above the noise of most tiles.
const LIT_SHARE: f32 = 0.05;
/// Share of tiles that show whole; the widest may be noise.
const WHOLE_SHARE: f64 = 0.95;
/// Margin around the lit pixels, px, besides a fifth of their reach.
const MARGIN_PX: f64 = 2.0;
/// Largest number of samples along each axis for the mean over a pixel of a reduced tile.
const MOST_SAMPLES: usize = 8;

/// A set to show, and the PSFs that a lens predicts for it.
pub struct SetSubject<'a> {
    /// Name of the set.
    pub name: &'a str,
    /// The set.
    pub set: &'a ObservationSet,
    /// Name of the lens and its predictions, observation by observation.
    pub predicted: Option<(&'a str, &'a ObservationSet)>,
}

#[derive(Serialize)]
struct SetData {
    kind: &'static str,
    frame: [u32; 2],
    axis: [f64; 2],
    distances: Vec<String>,
    start_distance: usize,
    stops: [&'static str; 1],
    sources: Vec<String>,
    states: Vec<State>,
    atlas: Atlas,
}

/// The PSFs at one distance.
#[derive(Serialize)]
struct State {
    /// Width of a tile in px of the frame.
    extent_px: f64,
    points: Vec<Point>,
}

/// A PSF, with one tile a source.
#[derive(Serialize)]
struct Point {
    name: String,
    at: [f64; 2],
    tiles: Vec<usize>,
}

/// Returns the page of a set.
pub fn set_page(subject: &SetSubject) -> String {
    let set = subject.set;
    let sources: Vec<&ObservationSet> = std::iter::once(set)
        .chain(subject.predicted.map(|(_, set)| set))
        .collect();
    let chosen = chosen(set, most_tiles() / sources.len());
    let shown = ShownChannels::of(&set.channels);
    let side = tile_side(chosen.len() * sources.len());
    let distances = far_to_near(set);
    let mut tiles: Vec<Light> = Vec::new();
    let mut states = Vec::new();
    for distance in &distances {
        let here: Vec<usize> = (chosen.iter().copied())
            .filter(|&index| set.observations[index].distance == *distance)
            .collect();
        let extent_px = extent_px(here.iter().map(|&index| &set.observations[index]), &shown);
        let points = here.iter().map(|&index| {
            let observation = &set.observations[index];
            let first = tiles.len();
            for source in &sources {
                tiles.push(light(source, index, &shown, Sampling { extent_px, side }));
            }
            Point {
                name: observation.file.clone(),
                at: [observation.centre.x_px, observation.centre.y_px],
                tiles: (first..tiles.len()).collect(),
            }
        });
        let points = points.collect();
        states.push(State { extent_px, points });
    }
    let count = set.observations.len();
    let number = if chosen.len() == count {
        format!("{count} PSFs")
    } else {
        format!("{} of {count} PSFs, evenly chosen", chosen.len())
    };
    let mut facts = vec![
        format!("{number} at {} distances", distances.len()),
        format!(
            "frame {} × {} px",
            set.frame.width_px(),
            set.frame.height_px()
        ),
        shown.words.clone(),
    ];
    let mut names = vec!["measured".to_owned()];
    if let Some((lens, _)) = subject.predicted {
        facts.push(format!("beside each PSF, on the right: that of {lens}"));
        names.push("lens".to_owned());
    }
    let text = PageText {
        title: format!("Measured PSFs: {}", subject.name),
        facts,
        caption: "The frame, with enlarged PSFs at their measured places; the cross is the optical axis. Click a PSF, or \
                  focus the picture and press the arrow keys, to choose one. The bar is in pixels of the frame."
            .to_owned(),
        sections: String::new(),
        made: format!(
            "{} tiles of {side} × {side} px, resampled from those of the set, each channel of unit sum; 8 bits a colour, square \
             root of light.",
            tiles.len()
        ),
    };
    let data = SetData {
        kind: "set",
        frame: [set.frame.width_px(), set.frame.height_px()],
        axis: [set.frame.axis().x_px, set.frame.axis().y_px],
        distances: distances.iter().map(|d| distance_name(*d)).collect(),
        start_distance: 0,
        stops: ["as measured"],
        sources: names,
        states,
        atlas: Atlas::new(side, &tiles),
    };
    page(&text, &data)
}

/// Returns the distances of the set from far to near, an unknown one first.
fn far_to_near(set: &ObservationSet) -> Vec<ObjectDistance> {
    let mut all = set.distances();
    let key = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(-1.0);
    all.sort_by(|a, b| key(a).total_cmp(&key(b)));
    all
}

/// Returns the indices of at most `most` observations, evenly over the set.
fn chosen(set: &ObservationSet, most: usize) -> Vec<usize> {
    let count = set.observations.len();
    let step = count.div_ceil(most).max(1);
    (0..count).step_by(step).collect()
}

/// Returns the width of the part of the tiles to show, px: the lit pixels of almost all of them.
fn extent_px<'a>(
    observations: impl Iterator<Item = &'a Observation>,
    shown: &ShownChannels,
) -> f64 {
    let mut reaches: Vec<f64> = Vec::new();
    let mut widest: f64 = 1.0;
    for observation in observations {
        for channel in shown.indices() {
            let tile = observation.light(channel);
            let (width, height) = (tile.width(), tile.height());
            widest = widest.max(width.max(height) as f64);
            let peak = tile.samples().iter().copied().fold(0.0, f32::max);
            let lit = tile
                .samples()
                .iter()
                .enumerate()
                .filter(|(_, v)| **v > LIT_SHARE * peak);
            let off = |k: usize, size: usize| (k as f64 + 0.5 - size as f64 / 2.0).abs();
            let far = lit.map(|(k, _)| off(k % width, width).max(off(k / width, height)));
            reaches.push(far.fold(0.5, f64::max));
        }
    }
    reaches.sort_by(f64::total_cmp);
    let at = (WHOLE_SHARE * reaches.len().saturating_sub(1) as f64).round() as usize;
    let reach = reaches.get(at).copied().unwrap_or(0.5);
    (2.0 * (1.2 * reach + MARGIN_PX)).min(widest)
}

/// The part of a tile to show, and its size in the atlas.
#[derive(Debug, Clone, Copy)]
struct Sampling {
    extent_px: f64,
    side: usize,
}

/// Returns observation `index` of `set` in the colours of the page, resampled about the centre of its tile. Pixels that do
/// not count, such as those of other colours of a mosaic, are dark.
fn light(set: &ObservationSet, index: usize, shown: &ShownChannels, sampling: Sampling) -> Light {
    let observation = &set.observations[index];
    let Sampling { extent_px, side } = sampling;
    let step = extent_px / side as f64;
    let samples = (step.ceil() as usize).clamp(1, MOST_SAMPLES);
    let planes = shown.indices().into_iter().map(|channel| {
        let tile = observation.light(channel);
        let counted = set.counted(observation, channel);
        let (width, height) = (tile.width(), tile.height());
        let value = |x: f64, y: f64| {
            if x < 0.0 || y < 0.0 || x >= width as f64 || y >= height as f64 {
                return 0.0;
            }
            let k = y as usize * width + x as usize;
            let counts = counted.as_ref().is_none_or(|counted| counted[k]);
            if counts {
                f64::from(tile.samples()[k]).max(0.0)
            } else {
                0.0
            }
        };
        let place = |k: usize, part: usize, size: usize| {
            let within = (part as f64 + 0.5) / samples as f64;
            size as f64 / 2.0 + (k as f64 + within - side as f64 / 2.0) * step
        };
        let mean = |k: usize| {
            let mut sum = 0.0;
            for part in 0..samples * samples {
                let (i, j) = (part % samples, part / samples);
                sum += value(place(k % side, i, width), place(k / side, j, height));
            }
            sum
        };
        let plane: Vec<f64> = (0..side * side).map(mean).collect();
        let sum = plane.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        plane.into_iter().map(|v| v / sum).collect::<Vec<f64>>()
    });
    let planes: Vec<Vec<f64>> = planes.collect();
    let of_colour = |colour: usize| &planes[colour.min(planes.len() - 1)];
    (0..side * side)
        .map(|k| [of_colour(0)[k], of_colour(1)[k], of_colour(2)[k]])
        .collect()
}
