//! The headline figures of a self-test and the values they should reach.

use seidel_trial::{Measure, Rate};

use crate::results::SelfTest;

/// The bound that a figure should satisfy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Bound {
    AtLeast(f64),
    AtMost(f64),
}

/// A measured figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Figure {
    /// Share of the cases in which something held.
    Rate(Rate),
    /// A mean or a median.
    Measure(Measure),
}

/// A headline figure with its bound.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Aim {
    /// Key in `self-test.json`.
    pub(crate) key: &'static str,
    /// Name in the printed summary.
    pub(crate) name: &'static str,
    pub(crate) figure: Figure,
    /// The bound; `None` for a figure that is only reported.
    pub(crate) bound: Option<Bound>,
}

impl Aim {
    /// Returns the measured value; `None` without cases.
    pub(crate) fn value(&self) -> Option<f64> {
        match self.figure {
            Figure::Rate(rate) => rate.share,
            Figure::Measure(measure) => measure.value,
        }
    }

    /// Returns the number of cases behind the value.
    pub(crate) fn of(&self) -> usize {
        match self.figure {
            Figure::Rate(rate) => rate.of,
            Figure::Measure(measure) => measure.of,
        }
    }

    /// Returns whether the bound is met; `None` without cases or without a bound.
    pub(crate) fn met(&self) -> Option<bool> {
        let value = self.value()?;
        Some(match self.bound? {
            Bound::AtLeast(least) => value >= least,
            Bound::AtMost(most) => value <= most,
        })
    }

    /// Returns the value as text.
    pub(crate) fn found(&self) -> String {
        match (self.figure, self.value()) {
            (_, None) => "no such case".to_owned(),
            (Figure::Rate(rate), Some(share)) => {
                format!("{} of {} ({:.0} %)", rate.held, rate.of, 100.0 * share)
            }
            (Figure::Measure(measure), Some(value)) => {
                let cases = if measure.of == 1 { "case" } else { "cases" };
                format!("{value:.3} over {} {cases}", measure.of)
            }
        }
    }

    /// Returns the bound as text; empty without a bound.
    pub(crate) fn wanted(&self) -> String {
        let number = |v: f64| match self.figure {
            Figure::Rate(_) => format!("{:.0} %", 100.0 * v),
            Figure::Measure(_) => format!("{v:.2}"),
        };
        match self.bound {
            Some(Bound::AtLeast(v)) => format!("at least {}", number(v)),
            Some(Bound::AtMost(v)) => format!("at most {}", number(v)),
            None => String::new(),
        }
    }
}

impl SelfTest {
    /// Returns the headline figures in the order in which they are reported.
    pub(crate) fn aims(&self) -> Vec<Aim> {
        use Bound::{AtLeast, AtMost};
        let s = self.scores();
        let aim = |key, name, figure, bound| Aim {
            key,
            name,
            figure,
            bound,
        };
        let rate = |key, name, rate, bound| aim(key, name, Figure::Rate(rate), bound);
        let measure = |key, name, m, bound| aim(key, name, Figure::Measure(m), bound);
        let r = &s.rates;
        let mut aims = vec![
            rate(
                "single_top1",
                "one effect: ranked first",
                r.single_top1,
                Some(AtLeast(0.95)),
            ),
            rate(
                "single_exact",
                "one effect: added, and nothing else",
                r.single_exact,
                Some(AtLeast(0.9)),
            ),
            rate(
                "pair_both",
                "two effects: both are added",
                r.pair_both,
                Some(AtLeast(0.8)),
            ),
            rate(
                "triple_two",
                "three effects: two are named",
                r.triple_two,
                Some(AtLeast(0.7)),
            ),
            rate(
                "false_alarms",
                "no gap: false alarm",
                r.false_alarms,
                Some(AtMost(0.02)),
            ),
            rate(
                "unknown_unexplained",
                "unknown cause: called unexplained",
                r.unknown_unexplained,
                Some(AtLeast(0.85)),
            ),
            rate(
                "too_simple_found",
                "model too simple: called so",
                r.too_simple_found,
                Some(AtLeast(0.95)),
            ),
            measure(
                "closed_error",
                "share claimed minus share truly closed, mean magnitude",
                s.closed_error,
                Some(AtMost(0.05)),
            ),
            measure(
                "calibration_error",
                "expected calibration error of the probabilities",
                s.calibration_error,
                Some(AtMost(0.05)),
            ),
            measure(
                "cpu_seconds_median",
                "processor seconds of a case, median",
                s.cpu_seconds_median,
                Some(AtMost(15.0)),
            ),
            measure(
                "cpu_seconds_p90",
                "processor seconds of a case, 90th percentile",
                s.cpu_seconds_p90,
                Some(AtMost(45.0)),
            ),
            rate(
                "single_top3",
                "one effect: ranked among the first three",
                r.single_top3,
                None,
            ),
            rate(
                "single_in_class",
                "one effect: ranked first, or in an ambiguous class of at most three",
                r.single_in_class,
                None,
            ),
            measure(
                "closed_median",
                "share of the gap truly closed where the cause was right, median",
                s.closed_median,
                None,
            ),
            measure(
                "calibration_error_first",
                "expected calibration error of the first cause alone (of a pair: at most one half)",
                s.calibration_error_first,
                None,
            ),
        ];
        aims.push(rate(
            "advised_settled",
            "ambiguous: settled by the advised capture, of those simulated",
            self.advised_settled(),
            None,
        ));
        aims.extend(self.withheld_unexplained().map(|rate| {
            let name = "withheld effects called unexplained";
            aim("withheld_unexplained", name, Figure::Rate(rate), None)
        }));
        aims
    }
}

#[cfg(test)]
mod tests {
    use crate::samples::self_test;

    #[test]
    fn figures_are_compared_with_their_bounds() {
        let aims = self_test().aims();
        let of = |key: &str| aims.iter().find(|a| a.key == key).expect("an aim");
        let first = of("single_top1");
        assert_eq!(first.found(), "1 of 3 (33 %)");
        assert_eq!(
            (first.wanted().as_str(), first.met()),
            ("at least 95 %", Some(false))
        );
        assert_eq!(of("closed_error").met(), Some(true));
        assert_eq!(of("closed_median").met(), None);
        assert_eq!(of("too_simple_found").found(), "1 of 2 (50 %)");
        assert_eq!(of("cpu_seconds_p90").met(), Some(true));
        assert_eq!(of("closed_error").wanted(), "at most 0.05");
        let withheld = of("withheld_unexplained");
        assert_eq!((withheld.of(), withheld.met()), (3, None));
        let mut empty = self_test();
        empty.cases.clear();
        for aim in empty.aims() {
            assert_eq!((aim.met(), aim.found().as_str()), (None, "no such case"));
        }
    }
}
