//! An evaluation as tables, JSON, and the plot of Figure 13.

use seidel_core::evaluation::{GroupEvaluation, SplitMean};
use seidel_core::{CentralMoments, Evaluation};
use serde::Serialize;

use super::{CommandError, Form};
use crate::pictures::plot::{PlotPoint, Series, XAxis, line_plot_svg};

/// Returns Tables 1 and 2, the light in the wrong pixels, and the numbers of Figure 13 if they were computed.
pub(super) fn tables(evaluation: &Evaluation, form: Form) -> String {
    let mut parts = vec![
        table(
            "Variance explained over the field, %: all / middle 90 % of tiles (Table 1)",
            &header(&["tiles", "mu20 px²"], &CentralMoments::NAMES),
            &evaluation
                .groups
                .iter()
                .map(explained_row)
                .collect::<Vec<_>>(),
            form,
        ),
        table(
            "Forward-blur SNR, dB: mean (standard deviation) over tiles (Table 2)",
            &header(&[], &headings(evaluation)),
            &evaluation.groups.iter().map(method_row).collect::<Vec<_>>(),
            form,
        ),
        table(
            "Light in the wrong pixels, %: mean over tiles",
            &header(&[], &headings(evaluation)),
            &evaluation
                .groups
                .iter()
                .map(misplaced_row)
                .collect::<Vec<_>>(),
            form,
        ),
        HEADINGS_KEY.to_owned(),
    ];
    let sparse: Vec<Vec<String>> = evaluation.groups.iter().flat_map(sparse_rows).collect();
    if !sparse.is_empty() {
        parts.push(table(
            "Forward-blur SNR, dB, against training PSFs: mean ± 95 % over splits (Figure 13)",
            &header(&["PSFs"], &["Gaussian", "skew-normal", "undetermined"]),
            &sparse,
            form,
        ));
    }
    parts.join("\n\n")
}

fn header(first: &[&str], rest: &[&str]) -> Vec<String> {
    ["channel", "distance"]
        .iter()
        .chain(first)
        .chain(rest)
        .map(ToString::to_string)
        .collect()
}

/// Returns the methods' short headings, explained by [`HEADINGS_KEY`] below the table.
fn headings(evaluation: &Evaluation) -> Vec<&'static str> {
    let first = evaluation.groups.first();
    first.map_or_else(Vec::new, |g| {
        g.methods
            .iter()
            .map(|m| match m.id {
                "average-aligned" => "avg aligned",
                "average-unaligned" => "avg as is",
                "gaussian-raw" => "Gauss tile",
                "gaussian-model" => "Gauss lens",
                "skew-normal-general-raw" => "skew tile",
                "skew-normal-eq43-raw" => "skew43 tile",
                "skew-normal-model" => "skew lens",
                "skew-normal-eq43-model" => "skew43 lens",
                "mirrored-pair-raw" => "pair tile",
                "mirrored-pair-model" => "pair lens",
                "pupil-model" => "rays lens",
                _ => m.title,
            })
            .collect()
    })
}

const HEADINGS_KEY: &str = "avg: mean PSF, with centroids aligned or as the tiles are. tile: from the moments of each tile. lens: from \
the moments of the fitted lens. skew: skew-normal (tile: third moments weighted 1, 3, 3, 1; lens: meridional); \
skew43: by Eq 43 of the paper. pair: mirrored pair. rays: ray by ray through the pupil of the lens.";

fn place(group: &GroupEvaluation) -> Vec<String> {
    vec![group.channel.clone(), group.distance.to_string()]
}

fn explained_row(group: &GroupEvaluation) -> Vec<String> {
    let mut row = place(group);
    row.push(group.tiles.to_string());
    row.push(format!("{:.2}..{:.2}", group.mu20_px2.0, group.mu20_px2.1));
    let per_cent = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.1}"));
    row.extend(
        group
            .explained
            .iter()
            .map(|e| format!("{} / {}", per_cent(e.full), per_cent(e.middle))),
    );
    row
}

fn method_row(group: &GroupEvaluation) -> Vec<String> {
    let mut row = place(group);
    row.extend(
        group
            .methods
            .iter()
            .map(|m| format!("{:.2} ({:.2})", m.mean_db, m.std_db)),
    );
    row
}

fn misplaced_row(group: &GroupEvaluation) -> Vec<String> {
    let mut row = place(group);
    let shares = group.methods.iter().map(|m| 100.0 * m.misplaced_light);
    row.extend(shares.map(|share| format!("{share:.2}")));
    row
}

fn sparse_rows(group: &GroupEvaluation) -> Vec<Vec<String>> {
    let Some(curve) = &group.sparse else {
        return Vec::new();
    };
    let score = |mean: Option<SplitMean>| match mean {
        None => "-".to_owned(),
        Some(m) => match m.half_width_db {
            Some(half) => format!("{:.2} ± {half:.2}", m.mean_db),
            None => format!("{:.2}", m.mean_db),
        },
    };
    curve
        .points
        .iter()
        .map(|point| {
            let mut row = place(group);
            row.push(point.training.to_string());
            row.push(score(point.gaussian));
            row.push(score(point.skew_normal));
            row.push(point.undetermined.to_string());
            row
        })
        .collect()
}

fn table(title: &str, header: &[String], rows: &[Vec<String>], form: Form) -> String {
    if form == Form::Markdown {
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| markdown(cell)).collect();
            format!("| {} |", cells.join(" | "))
        };
        let rule: Vec<String> = header.iter().map(|_| "---".to_owned()).collect();
        let mut lines = vec![
            format!("**{title}**"),
            String::new(),
            line(header),
            line(&rule),
        ];
        lines.extend(rows.iter().map(|row| line(row)));
        return lines.join("\n");
    }
    let width = |column: usize| {
        std::iter::once(header)
            .chain(rows.iter().map(Vec::as_slice))
            .map(|row| row[column].chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &[String]| {
        let padded: Vec<String> = cells
            .iter()
            .zip(&widths)
            .map(|(cell, &w)| format!("{cell:>w$}"))
            .collect();
        padded.join("  ")
    };
    let mut lines = vec![title.to_owned(), line(header)];
    lines.extend(rows.iter().map(|row| line(row)));
    lines.join("\n")
}

/// Returns `text` as a cell of a Markdown table: names of channels come from files, and must not become markup.
fn markdown(text: &str) -> String {
    let mut cell = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => cell.push_str("&amp;"),
            '<' => cell.push_str("&lt;"),
            '>' => cell.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '!' => cell.extend(['\\', c]),
            c if c.is_whitespace() => cell.push(' '),
            c => cell.push(c),
        }
    }
    cell
}

/// An evaluation as a JSON document.
#[derive(Serialize)]
struct Document<'a> {
    format: &'static str,
    version: u32,
    #[serde(flatten)]
    evaluation: &'a Evaluation,
}

/// Returns the evaluation as a JSON document with keys in alphabetical order.
pub(super) fn json(evaluation: &Evaluation) -> String {
    let document = serde_json::to_value(Document {
        format: "lens-evaluation",
        version: 1,
        evaluation,
    });
    let text = document.and_then(|document| serde_json::to_string_pretty(&document));
    text.expect("an evaluation is plain JSON")
}

/// Returns Figure 13: the SNR of the skew-normal from lenses fitted to few PSFs, a line per channel and
/// distance.
pub(super) fn plot(evaluation: &Evaluation) -> Result<String, CommandError> {
    let series: Vec<Series> = evaluation
        .groups
        .iter()
        .filter_map(|group| {
            let curve = group.sparse.as_ref()?;
            let points = curve
                .points
                .iter()
                .filter_map(|point| {
                    let m = point.skew_normal?;
                    let half = m.half_width_db.unwrap_or(0.0);
                    Some(PlotPoint {
                        x: point.training as f64,
                        y: m.mean_db,
                        lower: m.mean_db - half,
                        upper: m.mean_db + half,
                    })
                })
                .collect();
            Some(Series {
                name: format!("{} {}", group.channel, group.distance),
                points,
            })
        })
        .collect();
    let x = XAxis {
        label: "PSFs in the fit".to_owned(),
        logarithmic: true,
    };
    Ok(line_plot_svg(
        "Skew-normal PSFs from a lens fitted to few of them",
        &x,
        "forward-blur SNR on PSFs not fitted, dB",
        &series,
    )?)
}

#[cfg(test)]
mod tests {
    use super::markdown;

    #[test]
    fn names_of_channels_do_not_become_markup() {
        assert_eq!(
            markdown("<img src=x onerror=a&b>|[x](y)\n`c`"),
            r"&lt;img src=x onerror=a&amp;b&gt;\|\[x\](y) \`c\`"
        );
        assert_eq!(markdown("mu20 px², 1.2 / -3"), "mu20 px², 1.2 / -3");
    }
}
