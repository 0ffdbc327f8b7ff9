//! A part that ended in a local minimum is fitted again from its starts.

use super::super::context::FittedLens;
use super::super::part_log::PartLog;
use super::super::part_trial::Split;
use super::super::parts::Part;
use super::*;
use crate::stage::Stage;
use seidel_optics::profile::ProfileEffect;

/// Two circles of the barrel: the lens has one, and the fit ended at the end of the other's range.
const PLANTED: [f64; 4] = [1.05, 0.45, 4.0, 0.0];
const TRAPPED: [f64; 4] = [4.0, 0.0, 1.5, -2.0];

#[test]
fn stops_at_the_end_of_their_range_are_found_again() {
    let mut lens = planted(&mut SplitMix64::new(11));
    let values = PLANTED.map(VergenceSeries::constant).to_vec();
    lens.effects.push(ProfileEffect {
        effect: &effects::Vignetting,
        values,
    });
    let set = observed(&lens, 16, 0.0, &mut SplitMix64::new(12));
    with_context(&set, |context| {
        let stage = Stage::whole(&no_progress, "fit");
        let (round, _) = context.fit_reduced(stage).expect("a sound set");

        let structure = Part::of(&effects::Vignetting).added_to(&round.layout.structure);
        let structure = Part::of(&effects::HigherOrder).added_to(&structure);
        let layout = context.layout(structure);
        let mut theta = layout.transfer(&round.layout, &round.theta);
        for (k, value) in TRAPPED.into_iter().enumerate() {
            layout.set_constant_in_all(&mut theta, Quantity::Effect(0, k), value);
        }
        let trapped = FittedLens {
            layout,
            theta,
            ..round
        };
        assert!(trapped.is_at_end_of_range(0) && !trapped.is_at_end_of_range(1));

        let rest = trapped.without(context, 0);
        let ids: Vec<&str> = (rest.layout.structure.effects.iter())
            .map(|e| e.id())
            .collect();
        assert_eq!(ids, ["higher_order"]);
        assert_eq!(rest.theta.len() + TRAPPED.len(), trapped.theta.len());

        let (begun, log) = (&mut Vec::new(), &mut PartLog::new(None));
        let again = Split::new(context).begun_again(context, &trapped, begun, log);
        let again = again.expect("a better lens");
        let which = again.layout.structure.effects.len() - 1;
        let value = |k| {
            let found = again
                .layout
                .value(&again.theta, Quantity::Effect(which, k), 0, 0.0);
            found.expect("a circle")
        };
        let is_planted = |[radius, shift]: [f64; 2]| {
            (radius - PLANTED[0]).abs() < 0.05 && (shift - PLANTED[1]).abs() < 0.05
        };
        let circles = [[value(0), value(1)], [value(2), value(3)]];
        assert!(circles.into_iter().any(is_planted), "{circles:?}");
    });
}
