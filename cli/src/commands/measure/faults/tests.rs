//! Departures of edges from what a lens draws, named by their cause.

use seidel_calibrate::fit::edges::Term;

use super::*;

fn departures(elongation: f64, direction_deg: f64, skewness: f64) -> Departures {
    let term = |value: f64| Term {
        value,
        sigma: 0.005,
    };
    Departures {
        elongation_px2: term(elongation),
        direction_deg,
        variance_px2: 2.0,
        skewness: term(skewness),
    }
}

fn text(faults: &[Fault]) -> Result<Vec<String>, String> {
    let settled = settle(faults, Insistence::Refuse, Path::new("photo.dng"));
    settled.map_err(|error| error.to_string())
}

#[test]
fn misfit_is_remarked_on_and_then_refused() {
    assert_eq!(of_misfit(1.3, 0.001), None);
    let doubtful: Vec<Fault> = of_misfit(3.0, 0.01).into_iter().collect();
    let remarks = text(&doubtful).expect("a remark");
    assert!(
        remarks.len() == 1 && remarks[0].contains("chi squared 3.0"),
        "{remarks:?}"
    );
    let wrong: Vec<Fault> = of_misfit(330.0, 0.05).into_iter().collect();
    let refused = text(&wrong).expect_err("refused");
    for part in [
        "photo.dng",
        "18.2 times",
        "5.0 % of the step",
        "--encoding",
        "--force",
    ] {
        assert!(refused.contains(part), "{refused}");
    }
    let forced = settle(&wrong, Insistence::Force, Path::new("photo.dng")).expect("insists");
    assert_eq!(forced.len(), 1);
}

#[test]
fn departures_are_named_by_their_cause() {
    assert!(of_departures(&departures(0.02, 33.0, 0.02), None).is_empty());
    let shaken = of_departures(&departures(0.375, 20.0, 0.0), None);
    let refused = text(&shaken).expect_err("refused");
    assert!(
        refused.contains("along 20 degrees") && refused.contains("moved by 3.0 px"),
        "{refused}"
    );
    let slight = of_departures(&departures(0.08, 20.0, 0.0), None);
    assert_eq!(text(&slight).expect("a remark").len(), 1);
    let squeezed = departures(1.2, 91.0, 0.0);
    let refused = text(&of_departures(&squeezed, None)).expect_err("refused");
    assert!(
        refused.contains("a squeezed picture") && refused.contains("--pixel-aspect"),
        "{refused}"
    );
    assert!(of_departures(&squeezed, Some(2.0)).is_empty());
    let log = of_departures(&departures(0.0, 0.0, -0.3), None);
    let refused = text(&log).expect_err("refused");
    assert!(
        refused.contains("towards their dark side") && refused.contains("--encoding"),
        "{refused}"
    );
}
