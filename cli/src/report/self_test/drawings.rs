//! Drawings of a self-test: whether odds can be believed, and claims.

use std::fmt::Write as _;

use seidel_core::trial::{Bin, Scores};

use super::super::markup::escape;
use super::{SelfTest, Tested};

/// Side of the square that is drawn in, and the room about it.
const SIDE: f64 = 320.0;
const LEFT: f64 = 48.0;
const BELOW: f64 = 44.0;
const ABOVE: f64 = 10.0;
/// Largest dot of the reliability diagram.
const LARGEST: f64 = 13.0;
/// Least share closed that is drawn; what lies below is drawn there.
const LEAST: f64 = -0.2;

/// Both, side by side.
pub(super) fn drawings(test: &SelfTest, scores: &Scores) -> String {
    format!(
        "<section><div class=\"columns\"><div>{}</div><div>{}</div></div></section>\n",
        reliability(&scores.calibration),
        closed(&test.cases)
    )
}

/// A square with scales from `from` to 1 on both sides and the line on which both are alike.
struct Square {
    from: f64,
    svg: String,
}

impl Square {
    fn new(from: f64, (across, up): (&str, &str), label: &str) -> Self {
        let (width, height) = (LEFT + SIDE + 10.0, ABOVE + SIDE + BELOW);
        let mut square = Self {
            from,
            svg: format!(
                "<svg class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\">\
                 <rect x=\"{LEFT}\" y=\"{ABOVE}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"#fbfcfd\" \
                 stroke=\"#c9d0d7\"/>"
            ),
        };
        let bottom = ABOVE + SIDE;
        for step in 0..=5 {
            let value = f64::from(step) / 5.0;
            let (x, y) = (square.x(value), square.y(value));
            let _ = write!(
                square.svg,
                "<path d=\"M{x:.1} {ABOVE}V{bottom}M{LEFT} {y:.1}H{}\" stroke=\"#eceff2\"/>\
                 <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{value:.1}</text>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{value:.1}</text>",
                LEFT + SIDE,
                bottom + 16.0,
                LEFT - 6.0,
                y + 4.0
            );
        }
        let (low, high) = (
            (square.x(from), square.y(from)),
            (square.x(1.0), square.y(1.0)),
        );
        let middle = ABOVE + SIDE / 2.0;
        let _ = write!(
            square.svg,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"#9aa5b0\" stroke-dasharray=\"4 4\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{across}</text>\
             <text x=\"14\" y=\"{middle:.1}\" text-anchor=\"middle\" \
             transform=\"rotate(-90 14 {middle:.1})\">{up}</text>",
            low.0,
            low.1,
            high.0,
            high.1,
            LEFT + SIDE / 2.0,
            bottom + 36.0
        );
        square
    }

    fn share(&self, value: f64) -> f64 {
        (value.clamp(self.from, 1.0) - self.from) / (1.0 - self.from)
    }

    fn x(&self, value: f64) -> f64 {
        LEFT + SIDE * self.share(value)
    }

    fn y(&self, value: f64) -> f64 {
        ABOVE + SIDE * (1.0 - self.share(value))
    }

    fn dot(&mut self, (x, y): (f64, f64), radius: f64, class: &str, title: &str) {
        let (x, y) = (self.x(x), self.y(y));
        // Writing to a string cannot fail.
        let _ = write!(
            self.svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" class=\"{class}\"><title>{}</title></circle>",
            escape(title)
        );
    }

    fn done(self) -> String {
        self.svg + "</svg>\n"
    }
}

fn reliability(bins: &[Bin]) -> String {
    let mut square = Square::new(
        0.0,
        ("odds of the answer", "share that was right"),
        "odds against shares that were right",
    );
    let most = bins.iter().map(|b| b.count).max().unwrap_or(0).max(1) as f64;
    for bin in bins.iter().filter(|b| b.count > 0) {
        let radius = LARGEST * (bin.count as f64 / most).sqrt();
        let title = format!(
            "{} with mean odds {:.2}: {:.2} were right",
            bin.count, bin.confidence, bin.right
        );
        square.dot((bin.confidence, bin.right), radius.max(3.0), "good", &title);
    }
    format!(
        "<h2>Whether the odds can be believed</h2>\n<p class=\"quiet\">Cases by the odds of their answer (of all \
         effects added together, or of an unknown cause); a dot's area is how many. On the line odds are what they say.</p>\n{}",
        square.done()
    )
}

fn closed(cases: &[Tested]) -> String {
    let mut square = Square::new(
        LEAST,
        ("share truly closed, on places held out", "share claimed"),
        "share of the gap closed, claimed against true",
    );
    for (index, tested) in cases.iter().enumerate() {
        let o = &tested.outcome;
        if o.added.is_empty() {
            continue;
        }
        let class = if tested.is_right() { "good" } else { "bad" };
        let title = format!(
            "case {index}, {}: claimed {:.2}, true {:.2}",
            tested.truth(),
            o.claimed_closed,
            o.true_closed
        );
        square.dot((o.true_closed, o.claimed_closed), 4.0, class, &title);
    }
    format!(
        "<h2>Share of the gap closed</h2>\n<p class=\"quiet\">Cases to which an effect was added, blue where \
         rightly, red where not. What lies below {LEAST} is drawn there.</p>\n{}",
        square.done()
    )
}

#[cfg(test)]
mod tests {
    use super::super::made::self_test;
    use super::*;

    #[test]
    fn dots_are_bins_and_cases_with_something_added() {
        let test = self_test();
        let scores = test.scores();
        let odds = reliability(&scores.calibration);
        let bins = scores.calibration.iter().filter(|b| b.count > 0).count();
        assert_eq!(odds.matches("<circle").count(), bins);
        let text = closed(&test.cases);
        assert_eq!(text.matches("<circle").count(), 6);
        assert_eq!(text.matches("class=\"bad\"").count(), 4);
        assert!(text.contains("case 0, vignetting: claimed 0.95, true 0.91"));
    }

    #[test]
    fn what_is_far_off_stays_inside() {
        let mut test = self_test();
        test.cases[0].outcome.true_closed = -40.0;
        let text = closed(&test.cases);
        assert!(text.contains(&format!("cx=\"{LEFT:.1}\"")), "{text}");
    }
}
