//! The headline figures of a self-test against what they are to reach.

use seidel_core::trial::{Measure, Rate, Scores};

use super::SelfTest;

/// Where a figure is to lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// At this or above.
    AtLeast(f64),
    /// At this or below.
    AtMost(f64),
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Figure {
    /// How often something held.
    Rate(Rate),
    /// A mean or a median.
    Measure(Measure),
}

/// A headline figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Aim {
    /// Its key in programs' reports.
    pub key: &'static str,
    /// What it is, in words.
    pub name: &'static str,
    /// What was found.
    pub figure: Figure,
    /// What it is to reach; none where it is only told.
    pub bound: Option<Bound>,
}

impl Aim {
    /// The number; none without cases.
    pub fn value(&self) -> Option<f64> {
        match self.figure {
            Figure::Rate(rate) => rate.share,
            Figure::Measure(measure) => measure.value,
        }
    }

    /// Cases that it is taken over.
    pub fn of(&self) -> usize {
        match self.figure {
            Figure::Rate(rate) => rate.of,
            Figure::Measure(measure) => measure.of,
        }
    }

    /// Whether it is reached; none without cases or without anything to reach.
    pub fn met(&self) -> Option<bool> {
        let value = self.value()?;
        Some(match self.bound? {
            Bound::AtLeast(least) => value >= least,
            Bound::AtMost(most) => value <= most,
        })
    }

    /// What was found, in words.
    pub fn found(&self) -> String {
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

    /// What is to be reached, in words; empty where nothing is.
    pub fn wanted(&self) -> String {
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

    /// The interval that holds the rate behind this many cases with 95 % (Wilson 1927).
    pub fn interval(&self) -> Option<(f64, f64)> {
        const Z2: f64 = 1.96 * 1.96;
        let Figure::Rate(Rate {
            of,
            share: Some(share),
            ..
        }) = self.figure
        else {
            return None;
        };
        let n = of as f64;
        let middle = (share + 0.5 * Z2 / n) / (1.0 + Z2 / n);
        let half = (Z2 * (share * (1.0 - share) / n + 0.25 * Z2 / (n * n))).sqrt() / (1.0 + Z2 / n);
        Some(((middle - half).max(0.0), (middle + half).min(1.0)))
    }
}

impl SelfTest {
    /// The headline figures in the order in which they are told.
    pub fn aims(&self) -> Vec<Aim> {
        let Scores {
            single_top1,
            single_top3,
            pair_both,
            false_alarms,
            unknown_unexplained,
            closed_median,
            closed_error,
            calibration_error,
            calibration_error_first,
            ..
        } = self.scores();
        let aim = |key, name, figure, bound| Aim {
            key,
            name,
            figure,
            bound: Some(bound),
        };
        let rate = |key, name, rate, bound| aim(key, name, Figure::Rate(rate), bound);
        let measure = |key, name, m, bound| aim(key, name, Figure::Measure(m), bound);
        let mut aims = vec![
            rate(
                "single_top1",
                "one effect: it comes first",
                single_top1,
                Bound::AtLeast(0.9),
            ),
            rate(
                "single_top3",
                "one effect: it is among the first three",
                single_top3,
                Bound::AtLeast(0.97),
            ),
            rate(
                "pair_both",
                "two effects: both are added",
                pair_both,
                Bound::AtLeast(0.7),
            ),
            rate(
                "false_alarms",
                "no gap: one is found all the same",
                false_alarms,
                Bound::AtMost(0.02),
            ),
            rate(
                "unknown_unexplained",
                "unknown cause: called unexplained",
                unknown_unexplained,
                Bound::AtLeast(0.8),
            ),
            measure(
                "closed_median",
                "share of the gap truly closed where the cause was right, median",
                closed_median,
                Bound::AtLeast(0.9),
            ),
            measure(
                "closed_error",
                "share claimed less share truly closed, mean size",
                closed_error,
                Bound::AtMost(0.05),
            ),
            measure(
                "calibration_error",
                "expected calibration error of the answer's odds",
                calibration_error,
                Bound::AtMost(0.05),
            ),
            Aim {
                key: "calibration_error_first",
                name: "the same of the first cause alone (half a pair has a half at most)",
                figure: Figure::Measure(calibration_error_first),
                bound: None,
            },
        ];
        if let Some(rate) = self.withheld_unexplained() {
            aims.push(Aim {
                key: "withheld_unexplained",
                name: "withheld effects called unexplained",
                figure: Figure::Rate(rate),
                bound: None,
            });
        }
        aims
    }
}

#[cfg(test)]
mod tests {
    use super::super::made::self_test;

    #[test]
    fn figures_meet_their_bounds_or_not() {
        let aims = self_test().aims();
        let of = |key: &str| aims.iter().find(|a| a.key == key).expect("an aim");
        let first = of("single_top1");
        assert_eq!(first.found(), "1 of 3 (33 %)");
        assert_eq!(
            (first.wanted().as_str(), first.met()),
            ("at least 90 %", Some(false))
        );
        let (low, high) = first.interval().expect("a rate");
        assert!((low - 0.0615).abs() < 1e-3 && (high - 0.7923).abs() < 1e-3);
        assert_eq!(of("closed_median").met(), Some(true));
        assert_eq!(of("closed_error").wanted(), "at most 0.05");
        let withheld = of("withheld_unexplained");
        assert_eq!((withheld.of(), withheld.met()), (3, None));
        let mut none = self_test();
        none.cases.clear();
        for aim in none.aims() {
            assert_eq!((aim.met(), aim.found().as_str()), (None, "no such case"));
            assert_eq!(aim.interval(), None);
        }
    }
}
