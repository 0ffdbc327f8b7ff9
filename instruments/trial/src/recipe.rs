//! Recipes of cases, and balanced lists of them.

use super::conditions::{Conditions, Size};
use super::glass;
use super::rng::Rng;
use super::third_order;

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
    /// One of [`Simulator::effects`].
    Single(&'static str),
    /// Two different ones of [`Simulator::effects`].
    Pair(&'static str, &'static str),
    /// Three different ones of [`Simulator::effects`].
    Triple([&'static str; 3]),
    /// One of [`Simulator::unknown_families`].
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
    /// Exact rays through a published lens with errors of manufacture.
    Glass,
}

impl Simulator {
    /// All simulators, used in turn by [`recipes`].
    pub const ALL: [Self; 2] = [Self::ThirdOrder, Self::Glass];

    /// Returns the identifier used in reports.
    pub fn id(self) -> &'static str {
        match self {
            Self::ThirdOrder => "third_order",
            Self::Glass => "glass",
        }
    }

    /// Returns the identifiers of the effects that its cases can have, as in the effect library.
    pub fn effects(self) -> &'static [&'static str] {
        match self {
            Self::ThirdOrder => &third_order::EFFECTS,
            Self::Glass => &glass::EFFECTS,
        }
    }

    /// Returns its families of causes that are not in the effect library.
    pub fn unknown_families(self) -> &'static [&'static str] {
        match self {
            Self::ThirdOrder => &third_order::UNKNOWN,
            Self::Glass => &glass::UNKNOWN,
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
            (Simulator::Glass, _) => Self::Extended,
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

/// Draws `N` of `effects` of which no two are too similar.
fn distinct<const N: usize>(effects: &[&'static str], rng: &mut Rng) -> [&'static str; N] {
    loop {
        let ids: [&str; N] = std::array::from_fn(|_| effects[rng.below(effects.len())]);
        let apart = |i: usize| ids[..i].iter().all(|a| may_pair(a, ids[i]));
        if (1..N).all(apart) {
            return ids;
        }
    }
}

/// The effects and families of unknown causes of a simulator in random order.
struct Deck {
    simulator: Simulator,
    effects: Vec<&'static str>,
    families: Vec<&'static str>,
}

impl Deck {
    fn shuffled(simulator: Simulator, rng: &mut Rng) -> Self {
        let mut deck = Self {
            simulator,
            effects: simulator.effects().to_vec(),
            families: simulator.unknown_families().to_vec(),
        };
        rng.shuffle(&mut deck.effects);
        rng.shuffle(&mut deck.families);
        deck
    }

    /// Returns the kind of case number `index` of its class. Single effects and families take turns.
    fn kind(&self, class: KindClass, index: usize, rng: &mut Rng) -> Kind {
        match class {
            KindClass::None => Kind::None,
            KindClass::Single => Kind::Single(self.effects[index % self.effects.len()]),
            KindClass::Pair => {
                let [a, b] = distinct(&self.effects, rng);
                Kind::Pair(a, b)
            }
            KindClass::Triple => Kind::Triple(distinct(&self.effects, rng)),
            KindClass::Unknown => Kind::Unknown(self.families[index % self.families.len()]),
            KindClass::TooSimple => Kind::TooSimple,
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

/// Returns a shuffled list of recipes. In each class the simulators take turns.
///
/// Without [`Selection::only`], 55 % have one effect (all of a simulator in turn), 12 % a pair, 6 % three effects, 12 % an
/// unknown cause (all families of a simulator in turn), 8 % none, and 7 % a design for which the fitted model is too simple.
pub fn recipes(selection: &Selection) -> Vec<Recipe> {
    let mut rng = Rng::stream(selection.seed, 0, 0);
    let decks = Simulator::ALL.map(|simulator| Deck::shuffled(simulator, &mut rng));
    let counts = counts(selection.count, selection.only);
    let mut drawn = Vec::with_capacity(selection.count);
    for (class, count) in KindClass::ALL.into_iter().zip(counts) {
        let first = rng.below(decks.len());
        for index in 0..count {
            let deck = &decks[(first + index) % decks.len()];
            let kind = deck.kind(class, index / decks.len(), &mut rng);
            drawn.push((deck.simulator, kind));
        }
    }
    rng.shuffle(&mut drawn);
    drawn
        .into_iter()
        .enumerate()
        .map(|(index, (simulator, kind))| {
            let seed = Rng::stream(selection.seed, 1, index as u64).word();
            Recipe::new(kind, simulator, seed, selection.size)
        })
        .collect()
}
