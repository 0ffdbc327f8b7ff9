//! Draws cases with the simulator that their recipe asks for.

use super::case::{Case, FurtherSets};
use super::further_capture::FurtherCapture;
use super::glass::GlassLens;
use super::lens::Lens;
use super::recipe::{Kind, Recipe, Simulator};
use super::sets;

/// Draws the case of `recipe`. The result does not depend on the number of threads.
///
/// # Panics
/// If the simulator has no effect or family of an identifier of the recipe, an effect occurs twice, a set has no positions,
/// there is no distance, or tiles are even or smaller than 25 pixels.
pub fn draw(recipe: &Recipe) -> Case {
    check(recipe);
    match recipe.simulator {
        Simulator::ThirdOrder => sets::draw::<Lens>(recipe),
        Simulator::Glass => sets::draw::<GlassLens>(recipe),
    }
}

/// Draws the sets of the case of `recipe` after a further `capture`; `None` if that capture shows nothing new.
///
/// # Panics
/// Those of [`draw`].
pub fn draw_further(recipe: &Recipe, capture: FurtherCapture) -> Option<FurtherSets> {
    check(recipe);
    match recipe.simulator {
        Simulator::ThirdOrder => sets::draw_further::<Lens>(recipe, capture),
        Simulator::Glass => sets::draw_further::<GlassLens>(recipe, capture),
    }
}

/// Panics if `recipe` cannot be drawn.
fn check(recipe: &Recipe) {
    let size = &recipe.conditions.size;
    assert!(
        size.tile >= 25 && size.tile % 2 == 1,
        "tiles are odd and at least 25 pixels wide"
    );
    assert!(
        size.design.min(size.real).min(size.holdout) > 0 && recipe.conditions.distances > 0,
        "every set has positions and distances"
    );
    if let Kind::Pair(..) | Kind::Triple(_) = recipe.kind {
        let causes = recipe.kind.causes();
        for (index, id) in causes.iter().enumerate() {
            assert!(!causes[..index].contains(id), "`{id}` occurs twice");
        }
    }
}
