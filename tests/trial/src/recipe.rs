//! Recipes of cases, and balanced lists of them.

use super::conditions::{Conditions, Size};
use super::rng::Rng;

/// Identifiers of the effects that a case can have, as in the effect library.
pub const EFFECTS: [&str; 18] = [
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
    "pupil_scale",
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
const SIMILAR: [[&str; 2]; 14] = [
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
    ["pupil_scale", "aperture_polygon"],
    ["pupil_scale", "apodisation"],
    ["pupil_scale", "anamorphic"],
    ["pupil_scale", "vignetting"],
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
    /// Three different ones of [`EFFECTS`].
    Triple([&'static str; 3]),
    /// One of [`UNKNOWN`].
    Unknown(&'static str),
    /// Noise only, but the fitted model cannot describe the design.
    TooSimple,
}

impl Kind {
    /// Returns the identifiers of the causes.
    pub fn causes(&self) -> Vec<&'static str> {
        match *self {
            Self::None | Self::TooSimple => Vec::new(),
            Self::Single(id) | Self::Unknown(id) => vec![id],
            Self::Pair(a, b) => vec![a, b],
            Self::Triple(ids) => ids.to_vec(),
        }
    }

    /// Returns whether the cause `id` is present.
    pub(super) fn holds(&self, id: &str) -> bool {
        self.causes().contains(&id)
    }

    /// Returns the class of the kind.
    pub fn class(&self) -> KindClass {
        match self {
            Self::None => KindClass::None,
            Self::Single(_) => KindClass::Single,
            Self::Pair(..) => KindClass::Pair,
            Self::Triple(_) => KindClass::Triple,
            Self::Unknown(_) => KindClass::Unknown,
            Self::TooSimple => KindClass::TooSimple,
        }
    }
}

/// A kind without its causes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KindClass {
    /// Noise only.
    None,
    /// One effect.
    Single,
    /// Two effects.
    Pair,
    /// Three effects.
    Triple,
    /// A cause outside the library.
    Unknown,
    /// A design that the fitted model cannot describe.
    TooSimple,
}

impl KindClass {
    /// All classes.
    pub const ALL: [Self; 6] = [
        Self::None,
        Self::Single,
        Self::Pair,
        Self::Triple,
        Self::Unknown,
        Self::TooSimple,
    ];

    /// Returns the identifier, as in [`super::Answer::kind`].
    pub fn id(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Triple => "triple",
            Self::Unknown => "unknown",
            Self::TooSimple => "too_simple",
        }
    }

    /// Returns the share of the cases of a mixed list, per cent.
    fn share_percent(self) -> usize {
        match self {
            Self::None => 8,
            Self::Single => 55,
            Self::Pair => 12,
            Self::Triple => 6,
            Self::Unknown => 12,
            Self::TooSimple => 7,
        }
    }
}

/// The simulator that draws a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simulator {
    /// A third-order lens with perturbed pencils.
    ThirdOrder,
}

impl Simulator {
    /// All simulators, used in turn by [`recipes`].
    pub const ALL: [Self; 1] = [Self::ThirdOrder];

    /// Returns the identifier used in reports.
    pub fn id(self) -> &'static str {
        match self {
            Self::ThirdOrder => "third_order",
        }
    }
}

/// The model that is fitted to the design of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitModel {
    /// The symmetric third-order model, the default of fits.
    Reduced,
    /// The third-order model with all further parts that the design asks for.
    Extended,
}

impl FitModel {
    /// Returns the identifier used in reports and by `seidel fit --model`.
    pub fn id(self) -> &'static str {
        match self {
            Self::Reduced => "reduced",
            Self::Extended => "extended",
        }
    }

    /// Returns the model that describes the designs of `simulator`, or is too simple for them as `kind` asks.
    pub fn of(simulator: Simulator, kind: Kind) -> Self {
        match (simulator, kind) {
            (_, Kind::TooSimple) | (Simulator::ThirdOrder, _) => Self::Reduced,
        }
    }
}

/// A recipe for one case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    /// The causes of the gap.
    pub kind: Kind,
    /// The seed of all random choices.
    pub seed: u64,
    /// The simulator that draws the case.
    pub simulator: Simulator,
    /// The model that is fitted to the design.
    pub model: FitModel,
    /// The conditions of the capture.
    pub conditions: Conditions,
}

impl Recipe {
    /// Creates the recipe of a case with random conditions, and with `size` if it is given.
    pub fn new(kind: Kind, simulator: Simulator, seed: u64, size: Option<Size>) -> Self {
        let mut rng = Rng::stream(seed, 2, 0);
        Self {
            kind,
            seed,
            simulator,
            model: FitModel::of(simulator, kind),
            conditions: Conditions::draw(kind, size, &mut rng),
        }
    }
}

/// The choice of cases of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Selection {
    /// Number of cases.
    pub count: usize,
    /// The seed of all random choices.
    pub seed: u64,
    /// The only kind of the cases; all kinds if `None`.
    pub only: Option<KindClass>,
    /// The size of all cases; drawn for each case if `None`.
    pub size: Option<Size>,
}

/// Returns whether two effects are distinct enough to be in one case.
pub(super) fn may_pair(a: &str, b: &str) -> bool {
    a != b && !SIMILAR.contains(&[a, b]) && !SIMILAR.contains(&[b, a])
}

/// Draws `N` effects of which no two are too similar.
fn distinct<const N: usize>(rng: &mut Rng) -> [&'static str; N] {
    loop {
        let ids: [&str; N] = std::array::from_fn(|_| EFFECTS[rng.below(EFFECTS.len())]);
        let apart = |i: usize| ids[..i].iter().all(|a| may_pair(a, ids[i]));
        if (1..N).all(apart) {
            return ids;
        }
    }
}

/// Returns the number of cases of each class in a list of `count`, in the order of [`KindClass::ALL`].
fn counts(count: usize, only: Option<KindClass>) -> [usize; KindClass::ALL.len()] {
    if let Some(only) = only {
        return KindClass::ALL.map(|class| if class == only { count } else { 0 });
    }
    let mut left = count;
    let mut counts = KindClass::ALL.map(|class| {
        let share = if class == KindClass::Single {
            0
        } else {
            ((count * class.share_percent() + 50) / 100).min(left)
        };
        left -= share;
        share
    });
    counts[1] = left;
    counts
}

/// Returns a shuffled list of recipes.
///
/// Without [`Selection::only`], 55 % have one effect (all in turn), 12 % a pair, 6 % three effects, 12 % an unknown cause
/// (all families in turn), 8 % none, and 7 % a design for which the fitted model is too simple.
pub fn recipes(selection: &Selection) -> Vec<Recipe> {
    let mut rng = Rng::stream(selection.seed, 0, 0);
    let mut effects = EFFECTS;
    let mut families = UNKNOWN;
    rng.shuffle(&mut effects);
    rng.shuffle(&mut families);
    let counts = counts(selection.count, selection.only);
    let mut kinds = Vec::with_capacity(selection.count);
    for (class, count) in KindClass::ALL.into_iter().zip(counts) {
        for index in 0..count {
            kinds.push(match class {
                KindClass::None => Kind::None,
                KindClass::Single => Kind::Single(effects[index % effects.len()]),
                KindClass::Pair => {
                    let [a, b] = distinct(&mut rng);
                    Kind::Pair(a, b)
                }
                KindClass::Triple => Kind::Triple(distinct(&mut rng)),
                KindClass::Unknown => Kind::Unknown(families[index % families.len()]),
                KindClass::TooSimple => Kind::TooSimple,
            });
        }
    }
    rng.shuffle(&mut kinds);
    kinds
        .into_iter()
        .enumerate()
        .map(|(index, kind)| {
            let simulator = Simulator::ALL[index % Simulator::ALL.len()];
            let seed = Rng::stream(selection.seed, 1, index as u64).word();
            Recipe::new(kind, simulator, seed, selection.size)
        })
        .collect()
}
