//! The third-order simulator: lenses of third order whose pencils causes change.

use seidel_optics::observations::ObservationSet;

use super::change;
use super::conditions::Conditions;
use super::expose::{
    self, Cause, GapOptions, SetRequest, Spot, TileOptions, observation_set, spot_tiles,
};
use super::lens::{Lens, LensConstraints};
use super::perturb::{Perturbation, effect};
use super::rays::{CELLS, CELLS_COARSE};
use super::recipe::Kind;
use super::rng::Rng;
use super::simulated::SimulatedLens;
use super::unknown::unknown;

/// Identifiers of the effects that a case can have, as in the effect library.
pub(crate) const EFFECTS: [&str; 18] = [
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
pub(crate) const UNKNOWN: [&str; 8] = [
    "central_obstruction",
    "trefoil",
    "ripple",
    "ghost",
    "sharpening",
    "bleeding",
    "zone_warp",
    "radial_smear",
];

/// Effects of designs that the third-order model cannot describe.
const DESIGN_EFFECTS: [&str; 4] = ["decentre", "anamorphic", "higher_order", "vignetting"];

impl SimulatedLens for Lens {
    type Action = Perturbation;

    const FIRST_LABEL: u64 = 0;
    const ATTEMPTS: u64 = 200;

    fn draw(kind: Kind, conditions: &Conditions, rng: &mut Rng) -> Self {
        let constraints = LensConstraints::of(kind, conditions);
        Self::draw_for(rng, constraints, conditions.size.tile)
    }

    fn changes(&self, kind: Kind, rng: &mut Rng) -> Vec<change::Change<Perturbation>> {
        match kind {
            Kind::Unknown(id) => vec![unknown(id, rng)],
            Kind::TooSimple => {
                // Two or three at once, so that adding one effect to the fitted lens does not mend it.
                let mut ids = DESIGN_EFFECTS;
                rng.shuffle(&mut ids);
                let count = 2 + rng.below(2);
                ids[..count]
                    .iter()
                    .map(|id| effect(id, self, rng))
                    .collect()
            }
            _ => {
                // Diffraction has a fixed strength, so the other effects are scaled to it.
                let mut ids = kind.causes();
                ids.sort_by_key(|id| *id != "diffraction");
                ids.iter().map(|id| effect(id, self, rng)).collect()
            }
        }
    }

    fn camera(&self) -> &Lens {
        self
    }

    fn bare_tiles(&self, spot: &Spot, tile: usize) -> Vec<Vec<f64>> {
        let options = TileOptions {
            tile,
            cells: CELLS_COARSE,
            raw: false,
        };
        spot_tiles(self, &[], spot, options, None).tiles
    }

    fn gap(&self, causes: &[&Cause], spots: &[Spot], options: GapOptions) -> f64 {
        expose::gap(self, causes, spots, options)
    }

    fn set(&self, causes: &[&Cause], request: &SetRequest) -> ObservationSet {
        let options = TileOptions {
            tile: request.tile,
            cells: CELLS,
            raw: request.capture.raw,
        };
        observation_set(self, request, |spot| {
            spot_tiles(self, causes, spot, options, None)
        })
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}
