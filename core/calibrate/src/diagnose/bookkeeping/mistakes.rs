//! The mistakes that are tried, the commonest of equal ones first.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;

use super::denoising;
use super::encodings::{ENCODINGS, Encoding, white};
use super::sharpening::UnsharpMask;

/// Largest share of the gap that the right mistake leaves: an effect beside it may leave a part.
pub(super) const LEFT: f64 = 0.2;
/// The same of a mistake that an effect may imitate.
pub(super) const LEFT_OF_IMITATED: f64 = 0.03;
/// Largest number of distances of which every order is tried.
const ALL_ORDERS: usize = 4;

/// A mistake in a set.
pub(super) struct Mistake {
    pub(super) id: &'static str,
    pub(super) words: String,
    pub(super) remedy: String,
    /// Largest share of the gap that it may leave.
    pub(super) largest_share: f64,
    pub(super) change: Change,
}

/// The change of a set that corrects a mistake.
pub(super) enum Change {
    Positions(Symmetry),
    Tiles(Symmetry),
    /// Shift of the tiles alone, px.
    Shift([f64; 2]),
    /// Shift of tiles and ideal positions, px.
    Crop([f64; 2]),
    /// Factor of all positions.
    Scale(f64),
    /// Index of the tile that each channel gets.
    Channels(Vec<usize>),
    /// The stated and the true distance.
    Distances(Vec<(ObjectDistance, ObjectDistance)>),
    /// A curve, and the value of white.
    Encoding(Encoding, f64),
    /// Constant of each channel, added to the background.
    BlackLevel(Vec<f64>),
    Sharpening(UnsharpMask),
    /// Standard deviation of a blur, px.
    Denoising(f64),
    /// Factor of the stated noise.
    NoiseScale(f64),
}

/// A symmetry of a rectangle: first rows and columns are exchanged, then each axis is mirrored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Symmetry {
    transposes: bool,
    mirrors_x: bool,
    mirrors_y: bool,
}

const fn symmetry(transposes: bool, mirrors_x: bool, mirrors_y: bool) -> Symmetry {
    Symmetry {
        transposes,
        mirrors_x,
        mirrors_y,
    }
}

/// Symmetries with what is wrong of positions and of tiles.
const MIRRORS: [(Symmetry, &str, &str); 3] = [
    (
        symmetry(false, false, true),
        "positions count y upwards",
        "tiles are upside down",
    ),
    (
        symmetry(false, true, false),
        "positions count x from the right",
        "tiles are mirrored left to right",
    ),
    (
        symmetry(false, true, true),
        "positions are turned by 180 degrees",
        "tiles are turned by 180 degrees",
    ),
];

const TURNS: [(Symmetry, &str, &str); 4] = [
    (
        symmetry(true, false, false),
        "positions have x and y exchanged",
        "tiles have rows and columns exchanged",
    ),
    (
        symmetry(true, true, false),
        "positions are turned by 90 degrees anticlockwise",
        "tiles are turned by 90 degrees anticlockwise",
    ),
    (
        symmetry(true, false, true),
        "positions are turned by 90 degrees clockwise",
        "tiles are turned by 90 degrees clockwise",
    ),
    (
        symmetry(true, true, true),
        "positions are mirrored at the other diagonal",
        "tiles are mirrored at the other diagonal",
    ),
];

/// Wrong units of distance, each with the metres in one stated metre.
const UNITS: [(&str, f64); 7] = [
    ("distances are in feet, taken for metres", 0.3048),
    ("distances are in inches, taken for metres", 0.0254),
    ("distances are in centimetres, taken for metres", 0.01),
    ("distances are in millimetres, taken for metres", 0.001),
    (
        "distances in metres were converted as if they were in feet",
        1.0 / 0.3048,
    ),
    (
        "distances in metres were converted as if they were in centimetres",
        100.0,
    ),
    ("distances are in kilometres, taken for metres", 1000.0),
];

/// Returns every mistake that `set` may hold but those of distances.
pub(super) fn of_frame_and_samples(set: &ObservationSet) -> Vec<Mistake> {
    let mut all = Vec::new();
    if set.mosaic.is_none() {
        all.extend(of_symmetries(set));
    }
    all.extend(of_channels(set));
    all.extend(of_origin(set));
    all.extend(of_samples(set));
    all
}

/// Returns the mistakes in the origin and the unit of positions.
fn of_origin(set: &ObservationSet) -> Vec<Mistake> {
    let [width, height] = [set.frame.width_px(), set.frame.height_px()].map(f64::from);
    let remedy = "Count x and y of each observation in pixels of the whole picture, from its top left corner.";
    let mistake = |id, words: &str, change| Mistake {
        id,
        words: words.to_owned(),
        remedy: remedy.to_owned(),
        largest_share: LEFT,
        change,
    };
    vec![
        mistake(
            "origin",
            "positions are counted from the centre of the picture",
            Change::Crop([width / 2.0, height / 2.0]),
        ),
        mistake(
            "position_unit",
            "positions are those of a picture of half the size",
            Change::Scale(2.0),
        ),
        mistake(
            "position_unit",
            "positions are those of a picture of twice the size",
            Change::Scale(0.5),
        ),
    ]
}

/// Returns the mistake of positions in a crop whose corner lies at `corner` of the picture, px.
pub(super) fn of_crop(corner: [f64; 2]) -> Mistake {
    let [x, y] = corner;
    Mistake {
        id: "crop",
        words: format!(
            "positions are those in a crop, whose corner lies at ({x}, {y}) of the picture"
        ),
        remedy: format!("Add ({x}, {y}) to centre and ideal position of each observation."),
        largest_share: LEFT_OF_IMITATED,
        change: Change::Crop(corner),
    }
}

fn of_symmetries(set: &ObservationSet) -> Vec<Mistake> {
    let is_square = set.frame.width_px() == set.frame.height_px();
    let mistake = |id, words: &str, remedy: &str, change| Mistake {
        id,
        words: words.to_owned(),
        remedy: remedy.to_owned(),
        largest_share: LEFT,
        change,
    };
    let mut all = Vec::new();
    for (symmetry, positions, _) in MIRRORS.iter().chain(TURNS.iter().filter(|_| is_square)) {
        let remedy =
            "Count x and y of each observation from the top left corner of the frame, y downwards.";
        all.push(mistake(
            "positions",
            positions,
            remedy,
            Change::Positions(*symmetry),
        ));
    }
    for (symmetry, _, tiles) in MIRRORS.iter().chain(&TURNS) {
        let remedy = "Write the tiles as the frame shows them, the top row first.";
        all.push(mistake("tiles", tiles, remedy, Change::Tiles(*symmetry)));
    }
    all
}

fn of_channels(set: &ObservationSet) -> Vec<Mistake> {
    let orders = orders(set.channels.len()).into_iter();
    let mistake = |order: Vec<usize>| {
        let stated = set.channels.join(", ");
        let names: Vec<&str> = order.iter().map(|k| set.channels[*k].as_str()).collect();
        Mistake {
            id: "channels",
            words: format!(
                "channels are in another order: the tiles of {stated} are called {}",
                names.join(", ")
            ),
            remedy: "Name the channels in the order in which the tiles hold them.".to_owned(),
            largest_share: LEFT,
            change: Change::Channels(order),
        }
    };
    orders.map(mistake).collect()
}

/// Returns every order of `count` things but the given one; of more than [`ALL_ORDERS`] the reverse, and those moved by one.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let own: Vec<usize> = (0..count).collect();
    if count > ALL_ORDERS {
        let moved = |by: usize| own.iter().map(|k| (k + by) % count).collect();
        return vec![
            own.iter().rev().copied().collect(),
            moved(1),
            moved(count - 1),
        ];
    }
    let mut all = vec![Vec::new()];
    for _ in 0..count {
        let longer = all.iter().flat_map(|start: &Vec<usize>| {
            let rest = own.iter().filter(|k| !start.contains(k));
            rest.map(|k| [&start[..], &[*k]].concat())
                .collect::<Vec<_>>()
        });
        all = longer.collect();
    }
    all.retain(|order| *order != own);
    all
}

/// Returns the mistakes in distances, which count for a lens that depends on them.
pub(super) fn of_distances(set: &ObservationSet) -> Vec<Mistake> {
    let stated = set.distances();
    let mut all = Vec::new();
    let mut push = |id, words: String, remedy: &str, truth: Vec<Option<ObjectDistance>>| {
        let truth: Option<Vec<ObjectDistance>> = truth.into_iter().collect();
        if let Some(truth) = truth {
            all.push(Mistake {
                id,
                words,
                remedy: remedy.to_owned(),
                largest_share: LEFT,
                change: Change::Distances(stated.iter().copied().zip(truth).collect()),
            });
        }
    };
    let scaled = |distance: &ObjectDistance, scale: f64| match distance {
        ObjectDistance::Metres(metres) => ObjectDistance::metres(metres * scale).ok(),
        other => Some(*other),
    };
    for (words, scale) in UNITS {
        let truth = stated.iter().map(|distance| scaled(distance, scale));
        push(
            "distance_unit",
            words.to_owned(),
            "State depth_m in metres.",
            truth.collect(),
        );
    }
    let reciprocal = |distance: &ObjectDistance| match distance {
        ObjectDistance::Metres(metres) => ObjectDistance::metres(1.0 / metres).ok(),
        ObjectDistance::Infinity | ObjectDistance::Unknown => None,
    };
    push(
        "distance_unit",
        "distances are reciprocals, in 1/m, taken for metres".to_owned(),
        "State depth_m in metres.",
        stated.iter().map(reciprocal).collect(),
    );
    if stated.len() > 1 {
        for order in orders(stated.len()) {
            let truth: Vec<Option<ObjectDistance>> =
                order.iter().map(|k| Some(stated[*k])).collect();
            let pairs = stated
                .iter()
                .zip(&order)
                .filter(|(own, k)| **own != stated[**k]);
            let pairs = pairs.map(|(own, k)| format!("{} is {}", metres(*own), metres(stated[*k])));
            push(
                "distance_labels",
                format!(
                    "distances are exchanged: {}",
                    pairs.collect::<Vec<_>>().join(", ")
                ),
                "Give each observation the distance at which it was taken.",
                truth,
            );
        }
    }
    all
}

fn metres(distance: ObjectDistance) -> String {
    match distance {
        ObjectDistance::Metres(metres) => format!("{metres} m"),
        ObjectDistance::Infinity => "infinity".to_owned(),
        ObjectDistance::Unknown => "unknown".to_owned(),
    }
}

fn of_samples(set: &ObservationSet) -> Vec<Mistake> {
    let mistake = |id, words: &str, remedy: &str, change| Mistake {
        id,
        words: words.to_owned(),
        remedy: remedy.to_owned(),
        largest_share: LEFT_OF_IMITATED,
        change,
    };
    let centre = "Positions are measured from the corner of the frame: the centre of its first pixel is (0.5, 0.5).";
    let mut all = vec![
        mistake(
            "half_pixel",
            "positions are half a pixel too small in x and y",
            centre,
            Change::Shift([0.5; 2]),
        ),
        mistake(
            "half_pixel",
            "positions are half a pixel too large in x and y",
            centre,
            Change::Shift([-0.5; 2]),
        ),
    ];
    let light = "Write tiles whose samples are proportional to light.";
    let white = white(set);
    all.extend(ENCODINGS.map(|(encoding, words)| {
        let words = match white {
            1.0 => words.to_owned(),
            white => format!("{words}, in codes up to {white}"),
        };
        mistake("encoding", &words, light, Change::Encoding(encoding, white))
    }));
    all
}

impl Mistake {
    /// Returns `set` without the mistake; `None` if it cannot be made of it.
    pub(super) fn correct(&self, set: &ObservationSet) -> Option<ObservationSet> {
        let size = [set.frame.width_px(), set.frame.height_px()].map(f64::from);
        let observations = set.observations.iter();
        let corrected = observations.map(|observation| self.change.correct(observation, size));
        Some(ObservationSet {
            observations: corrected.collect::<Option<_>>()?,
            ..set.clone()
        })
    }
}

impl Change {
    fn correct(&self, observation: &Observation, frame: [f64; 2]) -> Option<Observation> {
        let mut corrected = observation.clone();
        match self {
            Self::Positions(symmetry) => {
                corrected.centre = symmetry.point(corrected.centre, frame);
                corrected.ideal = corrected.ideal.map(|ideal| symmetry.point(ideal, frame));
            }
            Self::Tiles(symmetry) => {
                let tiles = corrected.tiles.iter().map(|tile| symmetry.tile(tile));
                corrected.tiles = tiles.collect::<Option<_>>()?;
                let first = observation.tiles.first()?;
                let mask = corrected.weight_mask.take();
                corrected.weight_mask =
                    mask.map(|mask| symmetry.cells(&mask, first.width(), first.height()));
            }
            Self::Shift(by) => corrected.centre = moved(corrected.centre, *by),
            Self::Crop(by) => {
                corrected.centre = moved(corrected.centre, *by);
                corrected.ideal = corrected.ideal.map(|ideal| moved(ideal, *by));
            }
            Self::Scale(factor) => {
                let scaled = |at: ImagePoint| ImagePoint::new(factor * at.x_px, factor * at.y_px);
                let centre = scaled(corrected.centre);
                // A tile keeps its pixels, and with them the offset of its centre from the ideal position.
                corrected.ideal = corrected.ideal.map(|ideal| {
                    let off = [
                        ideal.x_px - observation.centre.x_px,
                        ideal.y_px - observation.centre.y_px,
                    ];
                    moved(centre, off)
                });
                corrected.centre = centre;
            }
            Self::Channels(order) => {
                corrected.tiles = order
                    .iter()
                    .map(|k| observation.tiles[*k].clone())
                    .collect();
                corrected.noise_sigma = order.iter().map(|k| observation.noise_sigma[*k]).collect();
                corrected.background = order.iter().map(|k| observation.background[*k]).collect();
            }
            Self::Distances(pairs) => {
                let pair = pairs
                    .iter()
                    .find(|(stated, _)| *stated == observation.distance);
                corrected.distance = pair?.1;
            }
            Self::BlackLevel(levels) => {
                for (background, level) in corrected.background.iter_mut().zip(levels) {
                    *background += *level;
                }
            }
            Self::Sharpening(mask) => {
                let tiles = corrected.tiles.iter().map(|tile| mask.taken_off(tile));
                corrected.tiles = tiles.collect::<Option<_>>()?;
                // The mask changed the noise of pixels.
                corrected.noise_sigma = vec![None; corrected.tiles.len()];
            }
            Self::Denoising(sigma_px) => {
                let tiles = corrected.tiles.iter();
                let tiles = tiles.map(|tile| denoising::undone(tile, *sigma_px));
                corrected.tiles = tiles.collect::<Option<_>>()?;
                corrected.noise_sigma = vec![None; corrected.tiles.len()];
            }
            Self::NoiseScale(factor) => {
                let sigmas = corrected.noise_sigma.iter_mut().flatten();
                sigmas.for_each(|sigma| *sigma *= factor);
            }
            Self::Encoding(encoding, white) => {
                let tiles = corrected.tiles.iter();
                let decoded = tiles.map(|tile| encoding.decoded(tile, *white));
                corrected.tiles = decoded.collect::<Option<_>>()?;
                // Noise of codes is another in each pixel of light.
                corrected.noise_sigma = vec![None; corrected.tiles.len()];
                corrected.gain = None;
            }
        }
        Some(corrected)
    }
}

fn moved(at: ImagePoint, [x, y]: [f64; 2]) -> ImagePoint {
    ImagePoint::new(at.x_px + x, at.y_px + y)
}

impl Symmetry {
    fn point(self, at: ImagePoint, [width, height]: [f64; 2]) -> ImagePoint {
        let (mut x, mut y) = (at.x_px, at.y_px);
        if self.transposes {
            (x, y) = (y, x);
        }
        if self.mirrors_x {
            x = width - x;
        }
        if self.mirrors_y {
            y = height - y;
        }
        ImagePoint::new(x, y)
    }

    /// Returns the samples of a picture of `width` x `height` pixels.
    fn cells<T: Copy>(self, samples: &[T], width: usize, height: usize) -> Vec<T> {
        let (columns, rows) = match self.transposes {
            true => (height, width),
            false => (width, height),
        };
        let at = |column: usize, row: usize| {
            let x = if self.mirrors_x {
                columns - 1 - column
            } else {
                column
            };
            let y = if self.mirrors_y { rows - 1 - row } else { row };
            let (x, y) = if self.transposes { (y, x) } else { (x, y) };
            samples[y * width + x]
        };
        (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| at(column, row))
            .collect()
    }

    fn tile(self, tile: &Tile) -> Option<Tile> {
        let (width, height) = (tile.width(), tile.height());
        let samples = self.cells(tile.samples(), width, height);
        let (columns, rows) = match self.transposes {
            true => (height, width),
            false => (width, height),
        };
        Tile::new(columns, rows, samples).ok()
    }
}
