//! Recipes of cases, and balanced lists of them.

use super::rng::Rng;

/// Identifiers of the effects that a case can have, as in the effect library.
pub const EFFECTS: [&str; 17] = [
    "defocus_offset",
    "depth_scale",
    "sensor_tilt",
    "decentre",
    "diffraction",
    "vignetting",
    "aperture_polygon",
    "apodisation",
    "higher_order",
    "axial_colour",
    "lateral_colour",
    "distortion",
    "anamorphic",
    "pixel_footprint",
    "motion",
    "veiling_glare",
    "tone_curve",
];

/// Families of causes that are not in the effect library.
pub const UNKNOWN: [&str; 8] = [
    "central_obstruction",
    "trefoil",
    "ripple",
    "ghost",
    "sharpening",
    "bleeding",
    "zone_warp",
    "radial_smear",
];

/// Pairs of effects too similar to be identified together.
const SIMILAR: [[&str; 2]; 10] = [
    ["defocus_offset", "depth_scale"],
    ["decentre", "sensor_tilt"],
    ["motion", "pixel_footprint"],
    ["defocus_offset", "sensor_tilt"],
    ["depth_scale", "sensor_tilt"],
    ["apodisation", "tone_curve"],
    ["diffraction", "pixel_footprint"],
    ["defocus_offset", "anamorphic"],
    ["defocus_offset", "higher_order"],
    ["veiling_glare", "tone_curve"],
];

/// The difference between the real lens and its design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Noise only.
    None,
    /// One of [`EFFECTS`].
    Single(&'static str),
    /// Two different ones of [`EFFECTS`].
    Pair(&'static str, &'static str),
    /// One of [`UNKNOWN`].
    Unknown(&'static str),
}

/// The number of positions in each set and the size of the tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Size {
    /// Positions in the design set, each at two depths.
    pub design: usize,
    /// Positions in the real set, each at two depths.
    pub real: usize,
    /// Positions in the held-out set, each at two depths.
    pub holdout: usize,
    /// Width and height of every tile, pixels; odd, at least 25.
    pub tile: usize,
}

impl Default for Size {
    fn default() -> Self {
        Self {
            design: 25,
            real: 30,
            holdout: 12,
            tile: 33,
        }
    }
}

/// A recipe for one case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recipe {
    /// The causes of the gap.
    pub kind: Kind,
    /// The seed of all random choices.
    pub seed: u64,
    /// The size of the sets.
    pub size: Size,
}

/// Returns whether two effects are distinct enough to form a pair.
fn may_pair(a: &str, b: &str) -> bool {
    a != b && !SIMILAR.contains(&[a, b]) && !SIMILAR.contains(&[b, a])
}

/// Returns a shuffled list of `count` recipes.
///
/// 60 % have one effect (all in turn), 15 % a pair, 15 % an unknown cause (all families in turn) and 10 % none.
pub fn recipes(count: usize, seed: u64, size: Size) -> Vec<Recipe> {
    let mut rng = Rng::stream(seed, 0, 0);
    let share = |twentieths: usize| (count * twentieths + 10) / 20;
    let (pairs, unknown, none) = (share(3), share(3), share(2));
    let mut effects = EFFECTS;
    let mut families = UNKNOWN;
    rng.shuffle(&mut effects);
    rng.shuffle(&mut families);
    let mut kinds = Vec::with_capacity(count);
    kinds.extend((0..pairs).map(|_| {
        loop {
            let (a, b) = (
                EFFECTS[rng.below(EFFECTS.len())],
                EFFECTS[rng.below(EFFECTS.len())],
            );
            if may_pair(a, b) {
                return Kind::Pair(a, b);
            }
        }
    }));
    kinds.extend((0..unknown).map(|i| Kind::Unknown(families[i % families.len()])));
    kinds.extend((0..none).map(|_| Kind::None));
    kinds.truncate(count);
    kinds.extend((0..count - kinds.len()).map(|i| Kind::Single(effects[i % effects.len()])));
    rng.shuffle(&mut kinds);
    kinds
        .into_iter()
        .enumerate()
        .map(|(index, kind)| Recipe {
            kind,
            seed: Rng::stream(seed, 1, index as u64).word(),
            size,
        })
        .collect()
}
