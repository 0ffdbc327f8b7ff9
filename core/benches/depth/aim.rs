//! Aims and what was found, as rows of a table.

/// The values that meet an aim.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Wanted {
    AtMost(f64),
    AtLeast(f64),
}

/// An aim with what was found.
pub(crate) struct Aim {
    what: String,
    wanted: Wanted,
    /// `None` where it could not be measured.
    found: Option<f64>,
    unit: &'static str,
}

impl Aim {
    /// An aim for a figure in `unit`.
    pub(crate) fn new(
        what: impl Into<String>,
        wanted: Wanted,
        unit: &'static str,
        found: impl Into<Option<f64>>,
    ) -> Self {
        Self {
            what: what.into(),
            wanted,
            found: found.into(),
            unit,
        }
    }

    fn row(&self) -> String {
        let Self {
            what, wanted, unit, ..
        } = self;
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" {unit}")
        };
        let (limit, bound) = match wanted {
            Wanted::AtMost(limit) => ("at most", *limit),
            Wanted::AtLeast(limit) => ("at least", *limit),
        };
        let (found, verdict) = match self.found {
            None => ("-".to_owned(), "not measured"),
            Some(found) => {
                let is_met = match wanted {
                    Wanted::AtMost(most) => found <= *most,
                    Wanted::AtLeast(least) => found >= *least,
                };
                let verdict = if is_met { "met" } else { "not met" };
                (format!("{}{unit}", digits(found)), verdict)
            }
        };
        format!(
            "| {what} | {limit} {}{unit} | {found} | {verdict} |",
            digits(bound)
        )
    }
}

/// Returns a value with about three digits.
fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size < 0.01 => format!("{value:.1e}"),
        size if size < 10.0 => format!("{:.2}", value)
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
        size if size < 100.0 => format!("{:.1}", value)
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
        _ => format!("{value:.0}"),
    }
}

/// Returns the table of all aims as Markdown.
pub(crate) fn table(aims: &[Aim]) -> String {
    let head = [
        "| aim | wanted | found | |".to_owned(),
        "| --- | --- | --- | --- |".to_owned(),
    ];
    let rows = aims.iter().map(Aim::row);
    head.into_iter().chain(rows).collect::<Vec<_>>().join("\n")
}
