//! The list of all cases, wrong ones first.

use super::super::markup::escape;
use super::super::words::{effect_name, gap, odds, percent};
use super::{SelfTest, TOLD, Tested, Withheld};

/// The section with the list.
pub(super) fn cases(test: &SelfTest) -> String {
    let mut order: Vec<(usize, &Tested)> = test.cases.iter().enumerate().collect();
    order.sort_by_key(|(index, tested)| (tested.is_right(), *index));
    let rows: String = order
        .into_iter()
        .map(|(index, tested)| row(index, tested, test.withhold))
        .collect();
    let withheld = if test.withhold {
        "<th>Said without the true effect in the library</th>"
    } else {
        ""
    };
    format!(
        "<section><h2>Every case, wrong ones first</h2>\n<table class=\"cases\"><thead><tr>\
         <th class=\"n\">Case</th><th>True</th><th class=\"n\">Gap</th><th>Said</th><th>Likeliest causes</th>\
         <th class=\"n\">Claimed closed</th><th class=\"n\">Truly closed</th>{withheld}<th class=\"n\">Time</th>\
         </tr></thead><tbody>\n{rows}</tbody></table></section>\n"
    )
}

fn row(index: usize, tested: &Tested, withhold: bool) -> String {
    let o = &tested.outcome;
    let class = if tested.is_right() { "right" } else { "wrong" };
    let causes: Vec<String> = o
        .ranked
        .iter()
        .take(TOLD)
        .map(|(id, p)| format!("{} {}", escape(&effect_name(id)), odds(*p)))
        .collect();
    let said = match &tested.failure {
        Some(problem) => format!("failed: {}", escape(problem)),
        None => said(&o.verdict, &o.added),
    };
    let closed = |share: f64| {
        if tested.failure.is_some() || o.added.is_empty() {
            "–".to_owned()
        } else {
            percent(share)
        }
    };
    let withheld = match (withhold, &tested.withheld) {
        (false, _) => String::new(),
        (true, None) => "<td></td>".to_owned(),
        (true, Some(w)) => format!("<td>{}</td>", without(w)),
    };
    format!(
        "<tr class=\"{class}\"><td class=\"n\">{index}</td><td><span class=\"name\">{}</span></td>\
         <td class=\"n\">{}</td><td>{said}</td><td class=\"small\">{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{}</td>{withheld}<td class=\"n\">{:.0}\u{a0}s</td></tr>\n",
        escape(&tested.truth().replace('_', " ")),
        gap(o.answer.gap),
        causes.join("<br>"),
        closed(o.claimed_closed),
        closed(o.true_closed),
        o.seconds
    )
}

fn said(verdict: &str, added: &[String]) -> String {
    let names: Vec<String> = added.iter().map(|id| effect_name(id)).collect();
    let verdict = escape(&verdict.replace('_', " "));
    if names.is_empty() {
        return verdict;
    }
    format!("{verdict}: {}", escape(&names.join(", ")))
}

fn without(w: &Withheld) -> String {
    match &w.failure {
        Some(problem) => format!("failed: {}", escape(problem)),
        None => said(&w.verdict, &w.added),
    }
}

#[cfg(test)]
mod tests {
    use super::super::made::self_test;
    use super::*;

    #[test]
    fn wrong_ones_stand_first_with_what_was_said() {
        let mut test = self_test();
        let text = cases(&test);
        let first_right = text.find("class=\"right\"").expect("some are right");
        let last_wrong = text.rfind("class=\"wrong\"").expect("some are wrong");
        assert!(last_wrong < first_right);
        assert_eq!(text.matches("<tr class").count(), test.cases.len());
        assert!(text.contains("failed: tile: &lt;no light&gt;"));
        assert!(text.contains("explained: vignetting</td>"));
        assert!(text.contains("unexplained: higher order</td>"));
        test.withhold = false;
        assert!(!cases(&test).contains("without the true effect"));
    }
}
