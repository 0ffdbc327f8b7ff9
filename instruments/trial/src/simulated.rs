//! The interface between simulators and the drawing of cases.

use seidel_optics::observations::ObservationSet;

use super::change::{Cause, Change};
use super::conditions::Conditions;
use super::expose::{GapOptions, SetRequest, Spot};
use super::lens::Lens;
use super::recipe::Kind;
use super::rng::Rng;

/// A lens of a simulator, with changes of its own.
pub(super) trait SimulatedLens: Sized {
    /// The action of a change.
    type Action;

    /// First label of the random sequences of the simulator.
    const FIRST_LABEL: u64;

    /// Number of lenses tried before the best is used.
    const ATTEMPTS: u64;

    /// Draws a random lens that suits a case of `kind`.
    fn draw(kind: Kind, conditions: &Conditions, rng: &mut Rng) -> Self;

    /// Draws the changes of a case of `kind`. Those of [`Kind::TooSimple`] belong to the design.
    fn changes(&self, kind: Kind, rng: &mut Rng) -> Vec<Change<Self::Action>>;

    /// Returns the camera with its object distances.
    fn camera(&self) -> &Lens;

    /// Returns the tiles of the bare lens, coarsely sampled, with unit light.
    fn bare_tiles(&self, spot: &Spot, tile: usize) -> Vec<Vec<f64>>;

    /// Returns the mean over `spots` and channels of |o - p|² / |o|², for unit-sum tiles with and without the causes.
    ///
    /// It is infinite if no light reaches a tile.
    fn gap(&self, causes: &[&Cause<Self::Action>], spots: &[Spot], options: GapOptions) -> f64;

    /// Returns the observation set of the lens with the causes.
    fn set(&self, causes: &[&Cause<Self::Action>], request: &SetRequest) -> ObservationSet;

    /// Returns parameters of the lens for the answer.
    fn parameters(&self) -> Vec<(&'static str, f64)>;
}
