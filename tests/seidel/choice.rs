//! `--only` and `--except`: selection of observations.

use serde_json::Value;

use crate::support::{seidel_in, succeeds, write_moments_lens};

#[test]
fn named_observations_are_selected_or_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    // The first 24 have one distance; every third of them is held out.
    let names: Vec<String> = (0..24).map(|k| format!("psf/{k:04}.exr")).collect();
    let held_out: Vec<&String> = names.iter().step_by(3).collect();
    let list = |names: &[&String]| {
        let lines: Vec<&str> = names.iter().map(|n| n.as_str()).collect();
        // With the byte order mark that some editors write.
        format!("\u{feff}# held out\n\n{}\n", lines.join("\r\n"))
    };
    std::fs::write(folder.join("held-out.txt"), list(&held_out)).expect("writable");
    let tiles = |line: &str, key: &str| -> Vec<u64> {
        let json: Value = serde_json::from_str(&succeeds(folder, line).stdout).expect("JSON");
        let all = json[key].as_array().expect("a list");
        all.iter()
            .map(|p| p["tiles"].as_u64().expect("a count"))
            .collect()
    };
    let fitted = tiles(
        "fit @set -o @part.json --except @held-out.txt --json --model moments",
        "planes",
    );
    assert_eq!(fitted.iter().sum::<u64>(), 72 - 8);
    assert!(fitted.contains(&16), "{fitted:?}");
    let profile = std::fs::read_to_string(folder.join("part.json")).expect("written");
    assert!(profile.contains("except held-out.txt"), "{profile}");
    let only = tiles(
        "eval --lens @lens.json @set --only @held-out.txt --json",
        "groups",
    );
    assert_eq!(only, [8]);
    let rest = tiles(
        "eval --lens @lens.json @set --except @held-out.txt --json",
        "groups",
    );
    assert_eq!(rest.iter().sum::<u64>(), 72 - 8);
}

#[test]
fn unknown_names_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    std::fs::write(folder.join("odd.txt"), "psf/0003.exr\npsf/9999.exr\nx\n").expect("writable");
    std::fs::write(folder.join("none.txt"), "# nobody\n").expect("writable");
    for (line, report) in [
        (
            "fit @set -o @out.json --only @odd.txt",
            "odd.txt: line 2: names no observation of any set, and neither does 1 more line",
        ),
        ("eval --lens @lens.json @set --except @odd.txt", "line 2"),
        ("fit @set -o @out.json --only @none.txt", "none.txt"),
        ("fit @set -o @out.json --only @absent.txt", "absent.txt"),
    ] {
        let refused = seidel_in(folder, line);
        assert_eq!(refused.status, 1, "{line}");
        assert!(refused.stderr.contains(report), "{}", refused.stderr);
        // The file may be another one by mistake.
        assert!(!refused.stderr.contains("9999"), "{}", refused.stderr);
    }
    assert!(!folder.join("out.json").exists());
}
