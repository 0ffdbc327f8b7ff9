//! `seidel measure print`, `plan`, `chart` and `pair`: from a printed page to a lens.

use std::path::Path;

use seidel_optics::numeric::SplitMix64;
use serde_json::Value;

use crate::support::{must_refuse, real_data, seidel_in, succeeds};

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("one document")
}

fn document(folder: &Path, name: &str) -> Value {
    json(&std::fs::read_to_string(folder.join(name)).expect("written"))
}

#[test]
fn charts_are_printed_the_same_for_the_same_seed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    // A7: a quarter of the work of A5, the smallest that has a name.
    for (kind, paper) in [
        ("noise", "105x74"),
        ("edges", "A5"),
        ("lights", "105x74"),
        ("board", "105x74"),
    ] {
        let line = format!(
            "measure print {kind} -o @{kind}.pdf -o @{kind}.svg -o @{kind}.png --paper {paper} --distance 1 --blur-px 5"
        );
        let printed = succeeds(folder, &line).stdout;
        assert!(printed.contains("px of the photograph"), "{printed}");
        let read = |name: String| std::fs::read(folder.join(name)).expect("written");
        let (pdf, svg) = (read(format!("{kind}.pdf")), read(format!("{kind}.svg")));
        assert!(pdf.starts_with(b"%PDF-"), "{kind}");
        assert!(svg.starts_with(b"<svg"), "{kind}");
        assert!(
            read(format!("{kind}.png")).starts_with(b"\x89PNG"),
            "{kind}"
        );
        let again = line.replace(&format!("@{kind}."), &format!("@again-{kind}."));
        succeeds(folder, &again);
        assert_eq!(pdf, read(format!("again-{kind}.pdf")), "{kind}");
    }
    let before = std::fs::read(folder.join("noise.png")).expect("written");
    succeeds(
        folder,
        "measure print noise -o @noise.png --paper 105x74 --distance 1 --blur-px 5 --seed 2",
    );
    assert_ne!(
        before,
        std::fs::read(folder.join("noise.png")).expect("written")
    );
    must_refuse(
        folder,
        "measure print edges -o @large.pdf --paper 60x40 --blur-px 40",
        &["60 x 40 mm", "--paper"],
    );
    for (options, part) in [
        ("noise -o @a.jpg", ".pdf, .svg or .png"),
        ("noise -o @a.pdf --paper B9", "A0 to A5"),
        ("noise -o @a.png --screen 1x1", "3840x2160"),
    ] {
        let refused = seidel_in(folder, &format!("measure print {options}"));
        assert_eq!(refused.status, 2, "{options}: {}", refused.stderr);
        assert!(refused.stderr.contains(part), "{}", refused.stderr);
    }
}

#[test]
fn a_plan_has_distances_even_in_vergence() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let line = "measure plan --focal-length-mm 50 --f-number 2 --focus-distance 3 --pitch-um 4";
    let text = succeeds(folder, line).stdout;
    assert!(
        text.contains("even in 1 / distance") && text.contains("inf"),
        "{text}"
    );
    let plan = json(&succeeds(folder, &format!("{line} --near 1 --far 5 --count 3 --json")).stdout);
    let metres: Vec<f64> = (plan["distances"].as_array().expect("a list").iter())
        .map(|d| d["distance_m"].as_f64().expect("metres"))
        .collect();
    // Vergences 0.2, 0.6 and 1.
    for (got, want) in metres.iter().zip([5.0, 1.0 / 0.6, 1.0]) {
        assert!((got - want).abs() < 1e-9, "{metres:?}");
    }
    must_refuse(folder, &format!("{line} --near 9 --far 5"), &["--near"]);
}

/// A 16-bit PGM of linear counts.
fn write_pgm(path: &Path, width: usize, samples: &[f64]) {
    let mut bytes = format!("P5 {width} {} 65535\n", samples.len() / width).into_bytes();
    for sample in samples {
        bytes.extend((sample.round().clamp(0.0, 65_535.0) as u16).to_be_bytes());
    }
    std::fs::write(path, bytes).expect("writes");
}

const WIDTH: usize = 264;
const HEIGHT: usize = 200;

/// Photographs a scene of random squares, 1.9 px wide, through a Gaussian blur of standard deviation `sigma`, in
/// monochrome with even light.
fn photograph(sigma: f64, seed: u64) -> Vec<f64> {
    let (cell, fine) = (1.9, 4);
    let is_white = |x: f64, y: f64| {
        let (column, row) = ((x / cell).floor() as i64, (y / cell).floor() as i64);
        SplitMix64::new((column * 7919 + row * 104_729 + 1_000_000_007) as u64).unit() < 0.5
    };
    let (wide, high) = (WIDTH * fine, HEIGHT * fine);
    let at = |k: usize| (k as f64 + 0.5) / fine as f64;
    let scene: Vec<f64> = (0..wide * high)
        .map(|k| {
            if is_white(at(k % wide), at(k / wide)) {
                1.0
            } else {
                0.05
            }
        })
        .collect();
    let radius = (4.0 * sigma * fine as f64).ceil() as i64;
    let weights: Vec<f64> = (-radius..=radius)
        .map(|k| (-0.5 * (k as f64 / (sigma * fine as f64)).powi(2)).exp())
        .collect();
    let total: f64 = weights.iter().sum();
    let blur = |from: &[f64], stride: usize, length: usize| -> Vec<f64> {
        (0..from.len())
            .map(|k| {
                let along = (k / stride % length) as i64;
                let sum: f64 = (weights.iter().zip(-radius..=radius))
                    .map(|(w, d)| {
                        let near = (along + d).clamp(0, length as i64 - 1) - along;
                        w * from[(k as i64 + near * stride as i64) as usize]
                    })
                    .sum();
                sum / total
            })
            .collect()
    };
    let light = blur(&blur(&scene, 1, wide), wide, high);
    let mut random = SplitMix64::new(seed);
    (0..WIDTH * HEIGHT)
        .map(|k| {
            let (x, y) = (k % WIDTH * fine, k / WIDTH * fine);
            let sum: f64 = (0..fine * fine)
                .map(|f| light[(y + f / fine) * wide + x + f % fine])
                .sum();
            let counts = 40_000.0 * sum / (fine * fine) as f64;
            counts + 60.0 * (random.unit() + random.unit() + random.unit() - 1.5) * 2.0
        })
        .collect()
}

#[test]
fn a_pair_shows_the_blur_of_the_second_photograph() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pgm(&folder.join("sharp.pgm"), WIDTH, &photograph(0.4, 1));
    write_pgm(&folder.join("blurred.pgm"), WIDTH, &photograph(1.3, 2));
    let options = "--cfa none --black 0 --white 65535 --out @set --distance 2";
    let report = json(&succeeds(folder, &format!("measure pair @sharp.pgm @blurred.pgm {options} --tile 11 --sharp-sigma-px 0.4 --json")).stdout);
    assert!(report["kept"].as_u64().expect("a count") >= 4, "{report}");
    let set = document(folder, "set/manifest.json");
    let observation = &set["observations"][0];
    assert_eq!(
        (&observation["source"], &observation["depth_m"]),
        (&Value::from("blurred.pgm"), &Value::from(2.0))
    );
    let set = seidel_image_io::observation_set::read(&folder.join("set"), Default::default())
        .expect("a set")
        .set;
    let want = 1.3_f64.powi(2) + 1.0 / 12.0;
    let mut traces: Vec<f64> = (set.observations.iter())
        .map(|o| {
            let tile = &o.tiles[0];
            let (side, mut sums) = (tile.width(), [0.0; 6]);
            for (k, v) in tile.samples().iter().enumerate() {
                let (x, y, v) = ((k % side) as f64, (k / side) as f64, f64::from(*v));
                for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, y * y, 0.0]) {
                    *sum += v * term;
                }
            }
            let [n, x, y, xx, yy, _] = sums;
            (xx / n - (x / n).powi(2) + yy / n - (y / n).powi(2)) / 2.0
        })
        .collect();
    traces.sort_by(f64::total_cmp);
    let median = traces[traces.len() / 2];
    assert!((median / want - 1.0).abs() < 0.06, "{median}, not {want}");
    for name in ["set/report.html", "set/sheet.png", "set/left_out.json"] {
        assert!(folder.join(name).exists(), "{name}");
    }
    must_refuse(
        folder,
        &format!(
            "measure chart @blurred.pgm --chart @missing.png {}",
            options.replace("@set", "@other")
        ),
        &["missing.png"],
    );
    let even = vec![30_000.0; WIDTH * HEIGHT];
    write_pgm(&folder.join("even.pgm"), WIDTH, &even);
    succeeds(
        folder,
        "measure print noise -o @chart.png --paper 105x74 --distance 1 --blur-px 4",
    );
    must_refuse(
        folder,
        &format!(
            "measure chart @even.pgm --chart @chart.png {}",
            options.replace("@set", "@other")
        ),
        &["even.pgm", "--at"],
    );
    let refused = seidel_in(folder, &format!("measure pair @sharp.pgm {options}"));
    assert_eq!(refused.status, 2);
    assert!(
        refused.stderr.contains("two photographs"),
        "{}",
        refused.stderr
    );
}

/// A photograph of an independent simulator: the chart is found without help, and its blocks have the true second moments.
#[test]
fn a_simulated_photograph_of_an_independent_program_is_measured() {
    let Some(case) = real_data("measure/noise_0") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let line = format!(
        "measure chart {} --chart {} --distance 2 --channels G --out @set --report @page.html --json",
        case.join("photo0.dng").display(),
        case.join("chart.png").display()
    );
    let report = json(&succeeds(folder, &line).stdout);
    assert!(report["kept"].as_u64().expect("a count") >= 35, "{report}");
    let truth = document(&case, "truth.json");
    let corners = report["photographs"][0]["corners"]
        .as_array()
        .expect("four");
    for (got, want) in corners
        .iter()
        .zip(truth["corners"].as_array().expect("four"))
    {
        for k in 0..2 {
            let error = got[k].as_f64().expect("px") - want[k].as_f64().expect("px");
            assert!(error.abs() < 0.5, "{got} {want}");
        }
    }
    let page = std::fs::read_to_string(folder.join("page.html")).expect("written");
    assert!(page.contains("blocks measured") && page.contains("data:image/png;base64,"));
}
