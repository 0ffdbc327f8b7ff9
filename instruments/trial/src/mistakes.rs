//! Mistakes in keeping books, planted in the real set of a case.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;

use super::recipe::Recipe;
use super::rng::Rng;

/// Label of the random sequence of a planted mistake.
const LABEL: u64 = 900;
/// Metres in a foot and in an inch.
const FOOT_M: f64 = 0.3048;
const INCH_M: f64 = 0.0254;
/// Largest code of eight bits.
const LARGEST_CODE: f32 = 255.0;

/// A mistake in the books of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// The positions of another frame: mirrored, or turned by 180 degrees.
    Positions,
    /// Tiles mirrored or turned.
    Tiles,
    /// The order of the channels.
    Channels,
    /// Distances in feet, inches, centimetres or as reciprocals.
    DistanceUnit,
    /// Distances exchanged.
    DistanceLabels,
    /// Positions half a pixel too small or too large.
    HalfPixel,
    /// Tiles some whole pixels off.
    Offset,
    /// Positions from the centre of the frame.
    Origin,
    /// Positions of a picture of half or twice the size.
    PositionUnit,
    /// Positions in a crop.
    Crop,
    /// A transfer curve.
    Encoding,
    /// A constant.
    BlackLevel,
    /// An unsharp mask.
    Sharpening,
    /// A small blur after the noise.
    Denoising,
    /// Noise stated in codes of eight bits, of tiles up to 1.
    NoiseScale,
    /// A wrong f-number, focal length, focus distance or pixel pitch in the manifest.
    Camera,
    /// The set of another lens.
    AnotherLens,
}

/// A set with a planted mistake.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantedMistake {
    /// The set with the mistake.
    pub set: ObservationSet,
    /// The mistake with its amount.
    pub words: String,
}

impl Mistake {
    /// All mistakes.
    pub const ALL: [Self; 17] = [
        Self::Positions,
        Self::Tiles,
        Self::Channels,
        Self::DistanceUnit,
        Self::DistanceLabels,
        Self::HalfPixel,
        Self::Offset,
        Self::Origin,
        Self::PositionUnit,
        Self::Crop,
        Self::Encoding,
        Self::BlackLevel,
        Self::Sharpening,
        Self::Denoising,
        Self::NoiseScale,
        Self::Camera,
        Self::AnotherLens,
    ];

    /// Returns the identifier, as in reports of a diagnosis.
    pub fn id(self) -> &'static str {
        match self {
            Self::Positions => "positions",
            Self::Tiles => "tiles",
            Self::Channels => "channels",
            Self::DistanceUnit => "distance_unit",
            Self::DistanceLabels => "distance_labels",
            Self::HalfPixel => "half_pixel",
            Self::Offset => "offset",
            Self::Origin => "origin",
            Self::PositionUnit => "position_unit",
            Self::Crop => "crop",
            Self::Encoding => "encoding",
            Self::BlackLevel => "black_level",
            Self::Sharpening => "sharpening",
            Self::Denoising => "denoising",
            Self::NoiseScale => "noise_scale",
            Self::Camera => "camera",
            Self::AnotherLens => "another_lens",
        }
    }

    /// Returns whether `named`, the identifier of a mistake that a diagnosis names, is this one. Mirrored positions and mirrored tiles
    /// are one mistake of a lens with rotational symmetry, and an origin in the centre is that of a crop.
    pub fn is_named(self, named: &str) -> bool {
        match self {
            Self::Positions | Self::Tiles => matches!(named, "positions" | "tiles"),
            Self::Origin => matches!(named, "origin" | "crop"),
            other => named == other.id(),
        }
    }

    /// Returns `recipe` with the conditions under which the mistake can be seen at all: stated positions, exposed values, two distances or
    /// stated noise.
    #[must_use]
    pub fn made_visible(self, recipe: Recipe) -> Recipe {
        let mut conditions = recipe.conditions;
        match self {
            Self::DistanceUnit | Self::DistanceLabels => {
                conditions.distances = conditions.distances.max(2);
            }
            Self::Encoding | Self::BlackLevel => conditions.raw = true,
            Self::Denoising | Self::NoiseScale => conditions.noise_stated = true,
            _ => conditions.ideal_positions = true,
        }
        Recipe {
            conditions,
            ..recipe
        }
    }

    /// Plants the mistake in `real`, the real set of the case of `recipe`. `other` is the real set of another case.
    pub fn plant(
        self,
        recipe: &Recipe,
        real: &ObservationSet,
        other: &ObservationSet,
    ) -> PlantedMistake {
        let mut rng = Rng::stream(recipe.seed, LABEL, self as u64);
        let (set, words) = match self {
            Self::Positions => positions(real, &mut rng),
            Self::Tiles => tiles(real, &mut rng),
            Self::Channels => channels(real, &mut rng),
            Self::DistanceUnit => distance_unit(real, &mut rng),
            Self::DistanceLabels => distance_labels(real),
            Self::HalfPixel => {
                let by = 0.5 * rng.sign();
                (with_centres(real, [by; 2]), format!("{by} px"))
            }
            Self::Offset => {
                let by = [rng.signed(2.0, 9.0).round(), rng.signed(1.0, 6.0).round()];
                (with_centres(real, by), format!("({}, {}) px", by[0], by[1]))
            }
            Self::Origin => {
                let by = size(real).map(|side| -side / 2.0);
                (with_positions(real, by), "from the centre".to_owned())
            }
            Self::PositionUnit => position_unit(real, &mut rng),
            Self::Crop => crop(real, &mut rng),
            Self::Encoding => encoding(real, &mut rng),
            Self::BlackLevel => {
                let level = rng.between(0.01, 0.06) as f32;
                (with_samples(real, |v| v + level), format!("{level:.3}"))
            }
            Self::Sharpening => {
                let (amount, sigma_px) = (rng.between(0.4, 1.2), rng.between(0.7, 1.5));
                let set = filtered(real, sigma_px, |v, soft| v + amount * (v - soft));
                (set, format!("{amount:.2} of {sigma_px:.2} px"))
            }
            Self::Denoising => {
                let sigma_px = rng.between(0.6, 1.1);
                let set = filtered(real, sigma_px, |_, soft| soft);
                (set, format!("{sigma_px:.2} px"))
            }
            Self::NoiseScale => {
                let factor = if rng.chance(0.5) { 255.0 } else { 65535.0 };
                let mut set = real.clone();
                let sigmas = set.observations.iter_mut().flat_map(|o| &mut o.noise_sigma);
                sigmas.flatten().for_each(|sigma| *sigma *= factor);
                (set, format!("a factor of {factor}"))
            }
            Self::Camera => camera(real, &mut rng),
            Self::AnotherLens => (of_another_lens(real, other), "another lens".to_owned()),
        };
        PlantedMistake { set, words }
    }
}

fn size(set: &ObservationSet) -> [f64; 2] {
    [set.frame.width_px(), set.frame.height_px()].map(f64::from)
}

/// Changes every observation of a copy of `set`.
fn changed(set: &ObservationSet, change: impl FnMut(&mut Observation)) -> ObservationSet {
    let mut set = set.clone();
    set.observations.iter_mut().for_each(change);
    set
}

/// Changes centres and ideal positions.
fn moved(set: &ObservationSet, to: impl Fn(ImagePoint) -> ImagePoint) -> ObservationSet {
    changed(set, |o| {
        o.centre = to(o.centre);
        o.ideal = o.ideal.map(&to);
    })
}

fn with_positions(set: &ObservationSet, [x, y]: [f64; 2]) -> ObservationSet {
    moved(set, |at| ImagePoint::new(at.x_px + x, at.y_px + y))
}

fn with_centres(set: &ObservationSet, [x, y]: [f64; 2]) -> ObservationSet {
    changed(set, |o| {
        o.centre = ImagePoint::new(o.centre.x_px + x, o.centre.y_px + y);
    })
}

/// Changes every sample.
fn with_samples(set: &ObservationSet, change: impl Fn(f32) -> f32) -> ObservationSet {
    with_tiles(set, |tile| {
        (0..tile.samples().len())
            .map(|k| change(tile.samples()[k]))
            .collect()
    })
}

/// Changes the samples of every tile.
fn with_tiles(set: &ObservationSet, samples: impl Fn(&Tile) -> Vec<f32>) -> ObservationSet {
    changed(set, |o| {
        for tile in &mut o.tiles {
            *tile = Tile::new(tile.width(), tile.height(), samples(tile)).expect("finite");
        }
    })
}

fn positions(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    let [width, height] = size(set);
    match rng.below(3) {
        0 => (
            moved(set, |at| ImagePoint::new(at.x_px, height - at.y_px)),
            "y upwards".to_owned(),
        ),
        1 => (
            moved(set, |at| ImagePoint::new(width - at.x_px, at.y_px)),
            "x from the right".to_owned(),
        ),
        _ => (
            moved(set, |at| ImagePoint::new(width - at.x_px, height - at.y_px)),
            "turned by 180 degrees".to_owned(),
        ),
    }
}

fn tiles(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    let change = rng.below(4);
    let words = [
        "upside down",
        "mirrored",
        "turned by 180 degrees",
        "transposed",
    ][change];
    let set = with_tiles(set, |tile| {
        let side = tile.width();
        let samples = (0..side * side).map(|k| {
            let (x, y, last) = (k % side, k / side, side - 1);
            let from = match change {
                0 => (last - y) * side + x,
                1 => y * side + last - x,
                2 => (last - y) * side + last - x,
                _ => x * side + y,
            };
            tile.samples()[from]
        });
        samples.collect()
    });
    (set, words.to_owned())
}

fn channels(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    let order = if rng.chance(0.6) {
        [2, 1, 0]
    } else {
        [1, 2, 0]
    };
    let set = changed(set, |o| {
        o.tiles = order.map(|k| o.tiles[k].clone()).to_vec();
        o.noise_sigma = order.map(|k| o.noise_sigma[k]).to_vec();
        o.background = order.map(|k| o.background[k]).to_vec();
    });
    (set, format!("order {order:?}"))
}

/// Changes distances in metres.
fn with_distances(set: &ObservationSet, change: impl Fn(f64) -> f64) -> ObservationSet {
    changed(set, |o| {
        if let ObjectDistance::Metres(metres) = &mut o.distance {
            *metres = change(*metres);
        }
    })
}

fn distance_unit(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    match rng.below(4) {
        0 => (with_distances(set, |m| m / FOOT_M), "feet".to_owned()),
        1 => (with_distances(set, |m| m / INCH_M), "inches".to_owned()),
        2 => (with_distances(set, |m| 100.0 * m), "centimetres".to_owned()),
        _ => (with_distances(set, |m| 1.0 / m), "reciprocals".to_owned()),
    }
}

fn distance_labels(set: &ObservationSet) -> (ObservationSet, String) {
    let stated = set.distances();
    let set = changed(set, |o| {
        let own = stated.iter().position(|d| *d == o.distance);
        if let Some(own) = own {
            o.distance = stated[stated.len() - 1 - own];
        }
    });
    (set, "reversed".to_owned())
}

fn position_unit(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    let factor = if rng.chance(0.5) { 0.5 } else { 2.0 };
    let set = changed(set, |o| {
        let centre = ImagePoint::new(factor * o.centre.x_px, factor * o.centre.y_px);
        o.ideal = o.ideal.map(|ideal| {
            ImagePoint::new(
                centre.x_px + ideal.x_px - o.centre.x_px,
                centre.y_px + ideal.y_px - o.centre.y_px,
            )
        });
        o.centre = centre;
    });
    (set, format!("times {factor}"))
}

/// Keeps the observations within a crop, or the eight nearest to it, and counts positions from its corner.
fn crop(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    const KEPT: usize = 8;
    let [width, height] = size(set);
    let corner = [
        (width * rng.between(0.15, 0.3)).round(),
        (height * rng.between(0.15, 0.3)).round(),
    ];
    let beyond = |o: &Observation| {
        let at = o.ideal.unwrap_or(o.centre);
        (corner[0] - at.x_px).max(corner[1] - at.y_px).max(0.0)
    };
    let mut cropped = set.clone();
    cropped
        .observations
        .sort_by(|a, b| beyond(a).total_cmp(&beyond(b)));
    let within = cropped
        .observations
        .partition_point(|o| beyond(o) <= 0.0)
        .max(KEPT);
    cropped.observations.truncate(within);
    (
        with_positions(&cropped, corner.map(|c| -c)),
        format!("corner ({}, {})", corner[0], corner[1]),
    )
}

fn encoding(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    let srgb = |v: f32| match v.max(0.0) {
        v if v <= 0.003_130_8 => 12.92 * v,
        v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    };
    let log_c = |v: f32| match v > 0.010_591 {
        true => 0.247_19 * (5.555_556 * v + 0.052_272).log10() + 0.385_537,
        false => 5.367_655 * v + 0.092_809,
    };
    let light = |set: &ObservationSet| {
        changed(set, |o| {
            o.tiles = (0..o.tiles.len()).map(|channel| o.light(channel)).collect();
            o.background.fill(0.0);
            // Noise is known of light, not of codes.
            o.noise_sigma.fill(None);
        })
    };
    let set = light(set);
    match rng.below(4) {
        0 => (with_samples(&set, srgb), "sRGB".to_owned()),
        1 => (
            with_samples(&set, |v| LARGEST_CODE * srgb(v)),
            "sRGB of eight bits".to_owned(),
        ),
        2 => (with_samples(&set, log_c), "LogC3".to_owned()),
        _ => (
            with_samples(&set, |v| v.max(0.0).powf(1.0 / 2.2)),
            "gamma 2.2".to_owned(),
        ),
    }
}

/// Combines every sample with that of the tile blurred by a Gaussian.
fn filtered(
    set: &ObservationSet,
    sigma_px: f64,
    combine: impl Fn(f64, f64) -> f64,
) -> ObservationSet {
    let reach = (4.0 * sigma_px).ceil() as i64;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| libm::exp(-0.5 * libm::pow(k as f64 / sigma_px, 2.0)))
        .collect();
    let sum: f64 = kernel.iter().sum();
    with_tiles(set, |tile| {
        let (width, height) = (tile.width() as i64, tile.height() as i64);
        // Pixels beyond the rim repeat it.
        let along = |pixels: &[f64], step: (i64, i64)| -> Vec<f64> {
            let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let mean = |(x, y): (i64, i64)| {
                let terms = kernel.iter().zip(-reach..).map(|(weight, k)| {
                    let x = (x + k * step.0).clamp(0, width - 1);
                    let y = (y + k * step.1).clamp(0, height - 1);
                    weight * pixels[(y * width + x) as usize]
                });
                terms.sum::<f64>() / sum
            };
            cells.map(mean).collect()
        };
        let own: Vec<f64> = tile.samples().iter().map(|v| f64::from(*v)).collect();
        let soft = along(&along(&own, (1, 0)), (0, 1));
        let combined = own.iter().zip(soft).map(|(v, soft)| combine(*v, soft));
        combined.map(|v| v as f32).collect()
    })
}

fn camera(set: &ObservationSet, rng: &mut Rng) -> (ObservationSet, String) {
    let mut set = set.clone();
    let words = match rng.below(4) {
        0 => {
            set.camera.f_number = set.camera.f_number.map(|n| 2.0 * n);
            "twice the f-number"
        }
        1 => {
            set.camera.focal_length_mm = set.camera.focal_length_mm.map(|f| f / 10.0);
            "the focal length in centimetres"
        }
        2 => {
            if let ObjectDistance::Metres(metres) = &mut set.camera.focus_distance {
                *metres /= FOOT_M;
            }
            "the focus in feet"
        }
        _ => {
            set.pixel_pitch_um = set.pixel_pitch_um.map(|pitch| 2.0 * pitch);
            "twice the pixel pitch"
        }
    };
    (set, words.to_owned())
}

/// Returns `other` in the frame, at the distances and with the camera of `own`.
fn of_another_lens(own: &ObservationSet, other: &ObservationSet) -> ObservationSet {
    let (from, to) = (size(other), size(own));
    let (theirs, ours) = (other.distances(), own.distances());
    let mut set = changed(other, |o| {
        let centre = ImagePoint::new(
            (o.centre.x_px * to[0] / from[0]).floor() + 0.5,
            (o.centre.y_px * to[1] / from[1]).floor() + 0.5,
        );
        o.ideal = o.ideal.map(|ideal| {
            ImagePoint::new(
                centre.x_px + ideal.x_px - o.centre.x_px,
                centre.y_px + ideal.y_px - o.centre.y_px,
            )
        });
        o.centre = centre;
        let rank = theirs.iter().position(|d| *d == o.distance).unwrap_or(0);
        o.distance = ours[rank % ours.len()];
    });
    set.frame = own.frame;
    set.camera = own.camera.clone();
    set.pixel_pitch_um = own.pixel_pitch_um;
    set
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Simulator, Size, draw};
    use super::*;

    #[test]
    fn every_mistake_changes_the_set_and_keeps_it_sound() {
        let size = Size {
            design: 1,
            real: 10,
            holdout: 1,
            tile: 25,
        };
        let real = |seed: u64, mistake: Mistake| {
            let recipe = Recipe::new(Kind::None, Simulator::ThirdOrder, seed, Some(size));
            let recipe = mistake.made_visible(recipe);
            (recipe, draw(&recipe).real)
        };
        let (_, other) = real(8, Mistake::AnotherLens);
        for mistake in Mistake::ALL {
            let (recipe, own) = real(7, mistake);
            let planted = mistake.plant(&recipe, &own, &other);
            assert_ne!(planted.set, own, "{}", planted.words);
            assert!(mistake.is_named(mistake.id()));
            let counts = [&planted.set, &own].map(|set| set.observations.len());
            assert!(counts[0] >= 8.min(counts[1]), "{counts:?}");
            assert_eq!(planted.set.frame, own.frame);
        }
    }
}
