//! The results as files for other programs: JSON, and JUnit's XML for build servers.

use serde_json::{Value, json};

use crate::causes::root_causes;
use crate::checks::find;
use crate::runner::Outcome;
use crate::subject::Subject;

/// Returns the results as JSON: the plugin, root causes, checks.
#[must_use]
pub fn json(subject: &Subject, outcomes: &[Outcome]) -> String {
    let causes: Vec<Value> = (root_causes(outcomes).iter())
        .map(|cause| json!({"cause": cause.text, "faults": cause.faults, "checks": cause.checks}))
        .collect();
    let checks: Vec<Value> = (outcomes.iter())
        .map(|outcome| {
            json!({
                "check": outcome.check,
                "about": find(outcome.check).map(|check| check.about),
                "result": outcome.result(),
                "seconds": outcome.duration.as_secs_f64(),
                "faults": outcome.report.faults,
                "skipped": outcome.report.skipped,
            })
        })
        .collect();
    let document = json!({
        "plugin": subject.file.to_string_lossy(),
        "id": subject.id,
        "kind": subject.kind.name,
        "failed": failed(outcomes),
        "causes": causes,
        "checks": checks,
    });
    format!("{document:#}\n")
}

/// Returns the results as a test suite of JUnit: a test case for each check, its faults as one failure, and the parts that were
/// not tested as its output.
#[must_use]
pub fn junit(subject: &Subject, outcomes: &[Outcome]) -> String {
    let seconds: f64 = outcomes.iter().map(|o| o.duration.as_secs_f64()).sum();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" time=\"{seconds:.3}\">\n",
        escaped(&subject.file.to_string_lossy()),
        outcomes.len(),
        failed(outcomes),
    );
    for outcome in outcomes {
        let name = escaped(outcome.check);
        let seconds = outcome.duration.as_secs_f64();
        text.push_str(&format!(
            "  <testcase classname=\"seidel-ofx-host\" name=\"{name}\" time=\"{seconds:.3}\">\n"
        ));
        let lines = |lines: &[String]| escaped(&lines.join("\n"));
        if let [first, ..] = &outcome.report.faults[..] {
            text.push_str(&format!(
                "    <failure message=\"{}\">{}</failure>\n",
                escaped(first),
                lines(&outcome.report.faults)
            ));
        }
        if !outcome.report.skipped.is_empty() {
            let skipped = lines(&outcome.report.skipped);
            text.push_str(&format!(
                "    <system-out>not tested: {skipped}</system-out>\n"
            ));
        }
        text.push_str("  </testcase>\n");
    }
    text.push_str("</testsuite>\n");
    text
}

fn failed(outcomes: &[Outcome]) -> usize {
    outcomes.iter().filter(|outcome| !outcome.passed()).count()
}

/// Returns `text` for XML 1.0, which has no place for control characters.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::checks::Report;

    fn outcomes() -> Vec<Outcome> {
        let outcome = |check, faults: &[&str], skipped: &[&str]| Outcome {
            check,
            report: Report {
                faults: faults.iter().map(|text| (*text).to_owned()).collect(),
                skipped: skipped.iter().map(|text| (*text).to_owned()).collect(),
            },
            duration: Duration::from_millis(1500),
        };
        vec![
            outcome("blur", &["a < b & \"c\" \u{7}", "second"], &[]),
            outcome("tiles", &["second"], &["no Depth"]),
            outcome("exports", &[], &[]),
        ]
    }

    fn subject() -> Subject {
        Subject::new("Some & Plugin.ofx".into(), "any", None).expect("a kind")
    }

    #[test]
    fn json_has_causes_before_checks() {
        let text = json(&subject(), &outcomes());
        let read: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(read["failed"], 2);
        assert_eq!(read["causes"][0]["cause"], "second");
        assert_eq!(read["causes"][0]["checks"], json!(["blur", "tiles"]));
        assert_eq!(read["checks"][1]["result"], "failed");
        assert_eq!(read["checks"][1]["skipped"], json!(["no Depth"]));
        assert_eq!(read["checks"][2]["result"], "passed");
        let about = read["checks"][2]["about"].as_str().expect("a text");
        assert!(about.contains("entry points"));
    }

    #[test]
    fn junit_is_escaped_and_counts() {
        let text = junit(&subject(), &outcomes());
        assert!(
            text.contains("<testsuite name=\"Some &amp; Plugin.ofx\" tests=\"3\" failures=\"2\"")
        );
        assert!(text.contains("time=\"4.500\""), "{text}");
        let failure = "<failure message=\"a &lt; b &amp; &quot;c&quot; \u{fffd}\">";
        assert!(text.contains(failure), "{text}");
        assert_eq!(text.matches("<testcase").count(), 3);
        assert_eq!(text.matches("</testcase>").count(), 3);
        assert!(text.contains("<system-out>not tested: no Depth</system-out>"));
        assert!(!text.contains('\u{7}'));
    }
}
