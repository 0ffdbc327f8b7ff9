//! `seidel view`: pages that need nothing but themselves, looked at in a browser where there is one.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use crate::support::{
    must_refuse, seidel_in, succeeds, write_generated_set, write_moments_lens, write_pupil_lens,
};

/// Returns the text of the page `name` after checks that hold for every page: one whole document, no address of anything
/// outside, data that parse.
fn checked_page(folder: &Path, name: &str) -> String {
    let page = std::fs::read_to_string(folder.join(name)).expect("written");
    let parsed = data(&page);
    let png = parsed["atlas"]["png"].as_str().unwrap_or_default();
    // Letters of a picture may spell anything.
    let words = if png.is_empty() {
        page.clone()
    } else {
        page.replace(png, "")
    };
    for part in [
        "http:", "https:", "src=\"", "@import", "<link", "url(", "import(", "fetch(", "NaN",
    ] {
        assert!(!words.contains(part), "{name}: {part}");
    }
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    for (open, close) in [
        ("<html", "</html>"),
        ("<head>", "</head>"),
        ("<body>", "</body>"),
        ("<main>", "</main>"),
        ("<script", "</script>"),
        ("<style>", "</style>"),
        ("<table>", "</table>"),
        ("<title>", "</title>"),
        ("<figure", "</figure>"),
        ("<section>", "</section>"),
        ("<form", "</form>"),
        ("<canvas", "</canvas>"),
        ("<td", "</td>"),
        ("<tr>", "</tr>"),
    ] {
        assert_eq!(
            page.matches(open).count(),
            page.matches(close).count(),
            "{name}: {open}"
        );
    }
    for placeholder in ["{title}", "{facts}", "{data}", "{made}"] {
        assert!(!page.contains(placeholder), "{name}: {placeholder}");
    }
    assert!(parsed["kind"].is_string());
    assert!(
        png.is_empty() || png.starts_with("data:image/png;base64,"),
        "{name}"
    );
    assert!(page.len() < 12_000_000, "{name}: {} bytes", page.len());
    page
}

/// Returns the data that the page's script reads.
fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").expect("data");
    let (text, _) = rest.split_once("</script>").expect("an end");
    serde_json::from_str(text).expect("JSON")
}

/// A report with the keys that `seidel diagnose` writes; a test of the diagnosis views a real one.
fn write_report(folder: &Path) {
    let place = |channel: &str, radius: [f64; 2], excess: f64| {
        json!({ "channel": channel, "depth_m": 2.0, "zone": { "radius": radius, "angle_deg": [0.0, 90.0] },
            "excess": excess, "z": 9.0, "tiles": 12 })
    };
    let mut at_infinity = place("R", [0.4, 1.0], 0.02);
    at_infinity["depth_m"] = Value::Null;
    let mut left_at_infinity = place("G", [0.4, 1.0], 0.006);
    left_at_infinity["depth_m"] = Value::Null;
    let report = json!({
        "format": "gap-report", "version": 2, "verdict": "explained", "added": ["vignetting"],
        "gap": { "before": 0.08, "after": 0.002, "closed": 0.97, "closed_ci95": [0.9, 0.99], "noise_floor": 0.001 },
        "causes": [{ "effect": "vignetting", "title": "vignetting", "meaning": "the <barrel> clips", "action": "stop down",
            "amount": "circles", "probability": 0.99, "gap_closed": 0.97 }],
        "where": [place("R", [0.0, 0.4], 0.01), place("G", [0.4, 1.0], 0.09), at_infinity],
        "where_left": [place("G", [0.4, 1.0], 0.004), left_at_infinity],
        "next_capture": "none", "remarks": ["a remark"],
        "subject": { "lens": "lens.json", "observations": "set", "count": 24 },
    });
    std::fs::write(folder.join("report.json"), report.to_string()).expect("writable");
}

#[test]
fn pages_are_self_contained_and_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_generated_set(folder, "set", &["R", "G", "B"]);
    write_report(folder);
    let stdout = succeeds(folder, "view @lens.json -o @lens.html").stdout;
    assert!(
        stdout.contains("lens.html") && stdout.contains("MB"),
        "{stdout}"
    );
    let lens = checked_page(folder, "lens.html");
    let lens = data(&lens);
    // No effect: round, one azimuth. Tiles of every state.
    assert_eq!(lens["polar"]["symmetry"], "round");
    let states = lens["distances"].as_array().expect("a list").len()
        * lens["stops"].as_array().expect("a list").len();
    assert_eq!(lens["states"].as_array().map(Vec::len), Some(states));
    assert!(states >= 8, "{states}");

    succeeds(folder, "view @set --lens @lens.json -o @set.html");
    let set = data(&checked_page(folder, "set.html"));
    assert_eq!(set["sources"], json!(["measured", "lens"]));
    let points = set["states"].as_array().expect("a list").iter();
    let points: usize = points
        .map(|s| s["points"].as_array().map_or(0, Vec::len))
        .sum();
    assert_eq!(points, 72);
    assert_eq!(set["distances"], json!(["infinity", "2.5 m", "1.2 m"]));

    succeeds(folder, "view @report.json -o @report.html");
    let report = checked_page(folder, "report.html");
    assert!(report.contains("the &lt;barrel&gt; clips") && report.contains("a remark"));
    let report = data(&report);
    assert_eq!(report["zones"].as_array().map(Vec::len), Some(5));
    assert_eq!(report["distances"], json!(["infinity", "2 m"]));
}

#[test]
fn lenses_of_every_kind_have_a_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    succeeds(folder, "view @lens.json -o @moments.html");
    let moments = data(&checked_page(folder, "moments.html"));
    assert_eq!(moments["stops"], json!(["as measured"]));
    assert_eq!(moments["distances"], json!(["infinity", "2.5 m", "1.2 m"]));
    for (name, symmetry) in [
        ("anamorphic-75", "two_planes"),
        ("mirror-500", "round"),
        ("swirl-58", "none"),
    ] {
        succeeds(folder, &format!("view library:{name} -o @{name}.html"));
        let page = data(&checked_page(folder, &format!("{name}.html")));
        assert_eq!(page["polar"]["symmetry"], symmetry);
    }
    // The sheet of the mirror has one f-number.
    let mirror = std::fs::read_to_string(folder.join("mirror-500.html")).expect("written");
    assert_eq!(data(&mirror)["stops"], json!(["f/8"]));
}

#[test]
fn bad_input_is_refused_and_leaves_no_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    write_report(folder);
    must_refuse(
        folder,
        "view @lens.json -o @lens.png",
        &["lens.png", ".html"],
    );
    must_refuse(folder, "view @none.json -o @page.html", &["none.json"]);
    must_refuse(
        folder,
        "view library:swirl -o @page.html",
        &["library:swirl-58"],
    );
    std::fs::write(
        folder.join("half.json"),
        r#"{"format": "gap-report", "verdict": "explained"}"#,
    )
    .expect("writable");
    must_refuse(
        folder,
        "view @half.json -o @page.html",
        &["half.json", "report", "seidel diagnose"],
    );
    std::fs::copy(folder.join("lens.json"), folder.join("lens.html")).expect("copied");
    must_refuse(
        folder,
        "view @lens.html -o @lens.html",
        &["lens.html", "overwritten"],
    );
    let beside = seidel_in(folder, "view @lens.json --lens @lens.json -o @page.html");
    assert_eq!(beside.status, 2, "{}", beside.stderr);
}

/// A script that waits for the drawing, moves each slider by a step and the chosen PSF by a key, and writes into the page
/// which of these changed the canvas.
const MOVES: &str = r##"<script>
const changes = [];
const canvas = document.getElementById("field");
const light = () => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.reduce((a, b) => a + b, 0);
const look = () => canvas.toDataURL();
function act(name, change) {
  const before = look();
  change();
  changes.push(name + (look() === before ? ":same" : ":changed"));
}
const wait = setInterval(() => {
  if (document.documentElement.dataset.ready !== "yes") return;
  clearInterval(wait);
  changes.push("light:" + (light() > 255 * canvas.width * canvas.height ? "yes" : "no"));
  for (const input of document.querySelectorAll("input")) {
    act(input.id, () => {
      if (input.type === "checkbox") { input.checked = !input.checked; input.dispatchEvent(new Event("change")); }
      else { input.value = Number(input.value) + (input.value === input.max ? -1 : 1); input.dispatchEvent(new Event("input")); }
    });
  }
  act("key", () => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", cancelable: true })));
  const result = document.createElement("pre");
  result.id = "result";
  result.textContent = changes.join(" ");
  document.body.append(result);
}, 20);
</script>
</body>"##;

/// Returns the browser on the path of programs, or prints that the look is skipped.
fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let names = [
        "chromium",
        "chromium-browser",
        "google-chrome",
        "google-chrome-stable",
    ];
    let found = std::env::split_paths(&path)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|program| program.is_file());
    if found.is_none() {
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: no Chromium to look at pages of `seidel view`"
        );
    }
    found
}

/// Opens the page `name` with [`MOVES`] in the browser, and returns its words.
fn moves(browser: &Path, folder: &Path, name: &str) -> String {
    let page = std::fs::read_to_string(folder.join(name)).expect("written");
    let moved = folder.join(format!("moved-{name}"));
    // The last one: a script of the page may hold the same text.
    let (start, _) = page.rsplit_once("</body>").expect("a body");
    std::fs::write(&moved, format!("{start}{MOVES}</html>")).expect("writable");
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(format!("file://{}", moved.display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&output.stdout).into_owned();
    let result = dom
        .split_once("<pre id=\"result\">")
        .and_then(|(_, rest)| rest.split_once("</pre>"));
    let (result, _) = result.unwrap_or_else(|| {
        panic!(
            "{name}: no result; {}",
            String::from_utf8_lossy(&output.stderr)
        )
    });
    result.to_owned()
}

#[test]
fn sliders_change_the_picture_in_a_browser() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_generated_set(folder, "set", &["R", "G", "B"]);
    write_report(folder);
    succeeds(folder, "view @lens.json -o @lens.html");
    succeeds(folder, "view @set --lens @lens.json -o @set.html");
    succeeds(folder, "view @report.json -o @report.html");
    // The scales of a stop differ, so that one scale for all changes the picture.
    let expected = [
        (
            "lens.html",
            "light:yes distance:changed stop:changed turn:changed same:changed key:changed",
        ),
        (
            "set.html",
            "light:yes distance:changed same:changed key:changed",
        ),
        (
            "report.html",
            "light:yes state:changed channel:changed distance:changed key:same",
        ),
    ];
    for (name, words) in expected {
        assert_eq!(moves(&browser, folder, name), words, "{name}");
    }
}
