//! The page of figures, as Markdown.

use std::fmt::Write;

use crate::Extent;

/// One job of the product with its figures.
pub(crate) struct Job {
    pub title: &'static str,
    /// The comparison in a few sentences.
    pub text: String,
    /// The simplest programs that could do the job.
    pub rivals: &'static [&'static str],
    pub cases: Vec<Case>,
}

/// The figures of one case, dB; larger is better.
pub(crate) struct Case {
    pub name: String,
    pub ours: f64,
    /// In the order of the rivals.
    pub rivals: Vec<f64>,
}

impl Case {
    /// Returns the lead over the best rival, dB.
    fn lead(&self) -> f64 {
        self.ours
            - self
                .rivals
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Job {
    /// Returns the lead over the best rival in the worst case, dB.
    pub(crate) fn worst_lead(&self) -> f64 {
        self.cases
            .iter()
            .map(Case::lead)
            .fold(f64::INFINITY, f64::min)
    }

    fn mean_lead(&self) -> f64 {
        self.cases.iter().map(Case::lead).sum::<f64>() / self.cases.len().max(1) as f64
    }
}

/// Returns the page of `jobs`.
pub(crate) fn page(jobs: &[Job], extent: Extent) -> String {
    let command = match extent {
        Extent::Full => "",
        Extent::Quick => " --quick",
    };
    let mut text = format!(
        "# Yardsticks\n\nEvery job of Seidel beside the simplest programs that could do it, over the range that users have. \
         `cargo xtask yardsticks{command}` makes this page.\nFigures are in decibels; larger is better. The lead is that over the best \
         rival of the case. A lead below zero is a fault.\n\n| job | cases | mean lead, dB | least lead, dB |\n| --- | --- | --- | --- |\n"
    );
    for job in jobs {
        let (mean, worst) = (job.mean_lead(), job.worst_lead());
        let _ = writeln!(
            text,
            "| {} | {} | {mean:.1} | {worst:.1} |",
            job.title,
            job.cases.len()
        );
    }
    for job in jobs {
        let rules = " --- |".repeat(job.rivals.len());
        let _ = write!(
            text,
            "\n## {}\n\n{}\n\n| case | Seidel | {} | lead |\n| --- | --- |{rules} --- |\n",
            job.title,
            job.text,
            job.rivals.join(" | ")
        );
        for case in &job.cases {
            let rivals: String = case.rivals.iter().map(|db| format!(" {db:.1} |")).collect();
            let (name, ours, lead) = (&case.name, case.ours, case.lead());
            let _ = writeln!(text, "| {name} | {ours:.1} |{rivals} {lead:+.1} |");
        }
    }
    text
}
