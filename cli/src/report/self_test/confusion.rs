//! Truth against answers: a table with shaded cells, and a list of pairs.

use std::collections::{BTreeMap, BTreeSet};

use seidel_core::trial::EFFECTS;

use super::super::markup::escape;

type Counts = BTreeMap<String, BTreeMap<String, usize>>;

/// Stands for any two effects that were named together.
const TWO: &str = "two effects";

/// Both parts.
pub(super) fn confusion(counts: &Counts) -> String {
    let pair = |id: &str| id.contains('+');
    let (pairs, singles): (Vec<_>, Vec<_>) = counts.iter().partition(|(truth, _)| pair(truth));
    let mut rows: Vec<(&str, BTreeMap<&str, usize>)> = singles
        .into_iter()
        .map(|(truth, named)| {
            let mut cells = BTreeMap::new();
            for (id, count) in named {
                let column = if pair(id) { TWO } else { id.as_str() };
                *cells.entry(column).or_default() += count;
            }
            (truth.as_str(), cells)
        })
        .collect();
    rows.sort_by_key(|(truth, _)| (rank(truth), *truth));
    let named: BTreeSet<(usize, &str)> = rows
        .iter()
        .flat_map(|(truth, cells)| std::iter::once(truth).chain(cells.keys()))
        .map(|id| (rank(id), *id))
        .collect();
    let columns: Vec<&str> = named.into_iter().map(|(_, id)| id).collect();
    format!(
        "<section><h2>What was true and what was named</h2>\n<p class=\"quiet\">A row is the truth of cases \
         with one cause or none, a column what was named in them. Blue is right, red is not; the fuller, the \
         larger the part of its row.</p>\n{}{}</section>\n",
        matrix(&rows, &columns),
        list(&pairs)
    )
}

/// Effects as the library of cases has them, then what is none of them.
fn rank(id: &str) -> usize {
    let others = [TWO, "none", "unknown"];
    EFFECTS
        .iter()
        .chain(&others)
        .position(|known| *known == id)
        .unwrap_or(EFFECTS.len() + others.len())
}

fn words(id: &str) -> String {
    escape(&id.replace('_', " "))
}

fn matrix(rows: &[(&str, BTreeMap<&str, usize>)], columns: &[&str]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let head: String = columns
        .iter()
        .map(|id| format!("<th><span>{}</span></th>", words(id)))
        .collect();
    let body: String = rows
        .iter()
        .map(|(truth, cells)| {
            let all: usize = cells.values().sum();
            let cells: String = columns
                .iter()
                .map(|id| cell(truth, id, cells.get(id).copied().unwrap_or(0), all))
                .collect();
            format!("<tr><th>{}</th>{cells}</tr>\n", words(truth))
        })
        .collect();
    format!(
        "<div class=\"wide\"><table class=\"confusion\"><thead><tr><th></th>{head}</tr></thead>\n<tbody>\n\
         {body}</tbody></table></div>\n"
    )
}

fn cell(truth: &str, named: &str, count: usize, all: usize) -> String {
    let class = if truth == named { " class=\"own\"" } else { "" };
    if count == 0 {
        return format!("<td{class}></td>");
    }
    let colour = if truth == named {
        "11 83 148"
    } else {
        "178 44 44"
    };
    let share = count as f64 / all.max(1) as f64;
    let strength = 0.15 + 0.85 * share;
    let ink = if strength > 0.55 { "#fff" } else { "inherit" };
    format!(
        "<td{class} style=\"background:rgb({colour} / {:.0}%);color:{ink}\" title=\"{} named {}: {count} of \
         {all}\">{count}</td>",
        100.0 * strength,
        words(truth),
        words(named)
    )
}

/// Cases with two effects: too many kinds for a table.
fn list(pairs: &[(&String, &BTreeMap<String, usize>)]) -> String {
    if pairs.is_empty() {
        return String::new();
    }
    let both = |id: &str| id.split('+').map(words).collect::<Vec<_>>().join(" and ");
    let rows: String = pairs
        .iter()
        .flat_map(|(truth, named)| named.iter().map(move |(id, count)| (*truth, id, count)))
        .map(|(truth, id, count)| {
            format!(
                "<tr><td><span class=\"name\">{}</span></td><td>{}</td><td class=\"n\">{count}</td></tr>\n",
                both(truth),
                both(id)
            )
        })
        .collect();
    format!(
        "<h2 class=\"later\">Two effects</h2>\n<table><thead><tr><th>True</th><th>Named</th>\
         <th class=\"n\">Cases</th></tr></thead><tbody>\n{rows}</tbody></table>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::super::made::self_test;
    use super::*;

    #[test]
    fn cells_are_shaded_by_their_part_of_the_row() {
        let text = confusion(&self_test().scores().confusion);
        let right = "class=\"own\" style=\"background:rgb(11 83 148 / 100%);color:#fff\" \
                     title=\"vignetting named vignetting: 1 of 1\">1<";
        assert!(text.contains(right), "{text}");
        assert!(
            text.contains("title=\"unknown named decentre: 1 of 2\""),
            "{text}"
        );
        assert!(text.contains("title=\"sensor tilt named failed: 1 of 1\""));
        let pair = "<tr><td><span class=\"name\">decentre and motion</span></td><td>decentre and motion</td>";
        assert!(text.contains(pair), "{text}");
        assert_eq!(text.matches("<td").count(), text.matches("</td>").count());
        assert!(!confusion(&Counts::new()).contains("<table"));
    }
}
