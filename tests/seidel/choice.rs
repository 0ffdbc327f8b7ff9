//! `--only` and `--except`: which observations of a set take part.

use serde_json::Value;

use crate::support::{seidel_in, succeeds, write_moments_lens};

#[test]
fn named_observations_alone_or_all_but_those_take_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    // The first 24 are those of one distance; every third of them is kept aside.
    let names: Vec<String> = (0..24).map(|k| format!("psf/{k:04}.exr")).collect();
    let aside: Vec<&String> = names.iter().step_by(3).collect();
    let list = |names: &[&String]| {
        let lines: Vec<&str> = names.iter().map(|n| n.as_str()).collect();
        format!("# kept aside\n\n{}\n", lines.join("\r\n"))
    };
    std::fs::write(folder.join("aside.txt"), list(&aside)).expect("writable");
    let tiles = |line: &str, key: &str| -> Vec<u64> {
        let json: Value = serde_json::from_str(&succeeds(folder, line).stdout).expect("JSON");
        let all = json[key].as_array().expect("a list");
        all.iter()
            .map(|p| p["tiles"].as_u64().expect("a count"))
            .collect()
    };
    let fitted = tiles(
        "fit @set -o @part.json --except @aside.txt --json --model moments",
        "planes",
    );
    assert_eq!(fitted.iter().sum::<u64>(), 72 - 8);
    assert!(fitted.contains(&16), "{fitted:?}");
    let profile = std::fs::read_to_string(folder.join("part.json")).expect("written");
    assert!(profile.contains("except aside.txt"), "{profile}");
    let only = tiles(
        "eval --lens @lens.json @set --only @aside.txt --json",
        "groups",
    );
    assert_eq!(only, [8]);
    let rest = tiles(
        "eval --lens @lens.json @set --except @aside.txt --json",
        "groups",
    );
    assert_eq!(rest.iter().sum::<u64>(), 72 - 8);
}

#[test]
fn names_that_no_observation_has_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    std::fs::write(folder.join("odd.txt"), "psf/0003.exr\npsf/9999.exr\nx\n").expect("writable");
    std::fs::write(folder.join("none.txt"), "# nobody\n").expect("writable");
    for (line, told) in [
        (
            "fit @set -o @out.json --only @odd.txt",
            "psf/9999.exr` and 1 more",
        ),
        (
            "eval --lens @lens.json @set --except @odd.txt",
            "psf/9999.exr",
        ),
        ("fit @set -o @out.json --only @none.txt", "none.txt"),
        ("fit @set -o @out.json --only @absent.txt", "absent.txt"),
    ] {
        let refused = seidel_in(folder, line);
        assert_eq!(refused.status, 1, "{line}");
        assert!(refused.stderr.contains(told), "{}", refused.stderr);
    }
    assert!(!folder.join("out.json").exists());
}
