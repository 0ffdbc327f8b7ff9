//! Traced lenses as lenses of a simulator.

use seidel_optics::observations::ObservationSet;

use super::change::{Action, GlassCause, GlassChange};
use super::errors::error;
use super::lens::GlassLens;
use super::prescription::ALL;
use super::tiles::{self, Built, CELLS, CELLS_COARSE, spot_tiles};
use super::unknown::unknown;
use crate::conditions::Conditions;
use crate::expose::{GapOptions, SetRequest, Spot, TileOptions, observation_set};
use crate::lens::{Lens, LensConstraints};
use crate::recipe::Kind;
use crate::rng::Rng;
use crate::simulated::SimulatedLens;

impl SimulatedLens for GlassLens {
    type Action = Action;

    const FIRST_LABEL: u64 = 1000;
    const ATTEMPTS: u64 = 60;

    fn draw(kind: Kind, conditions: &Conditions, rng: &mut Rng) -> Self {
        let constraints = LensConstraints::of(kind, conditions);
        let tile = conditions.size.tile;
        loop {
            let lens = Self::draw_for(rng, constraints, tile);
            if kind != Kind::TooSimple || lens.is_too_rich(tile) {
                return lens;
            }
        }
    }

    fn changes(&self, kind: Kind, rng: &mut Rng) -> Vec<GlassChange> {
        match kind {
            Kind::Unknown(id) => vec![unknown(id, self, rng)],
            _ => kind
                .causes()
                .iter()
                .map(|id| error(id, self, rng))
                .collect(),
        }
    }

    fn camera(&self) -> &Lens {
        &self.camera
    }

    fn bare_tiles(&self, spot: &Spot, tile: usize) -> Vec<Vec<f64>> {
        let options = TileOptions {
            tile,
            cells: CELLS_COARSE,
            raw: false,
        };
        spot_tiles(&Built::new(self, &[]), spot, options)
            .expect("light passes the bare lens")
            .tiles
    }

    fn gap(&self, causes: &[&GlassCause], spots: &[Spot], options: GapOptions) -> f64 {
        tiles::gap(self, causes, spots, options)
    }

    fn set(&self, causes: &[&GlassCause], request: &SetRequest) -> ObservationSet {
        let built = Built::new(self, causes);
        let options = TileOptions {
            tile: request.tile,
            cells: CELLS,
            raw: request.capture.raw,
        };
        observation_set(&self.camera, request, |spot| {
            spot_tiles(&built, spot, options).expect("light passes the lens")
        })
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        let prescription = ALL
            .iter()
            .position(|p| std::ptr::eq(*p, self.prescription))
            .expect("the prescription is on the list");
        vec![("prescription", prescription as f64)]
    }
}
