//! Two lens profiles in files, for the plugin and the library.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Writes a lens profile and returns its path.
fn write_profile(name: &str, coma: f64) -> PathBuf {
    let series = |values: &[f64]| {
        let sigma = vec![0.0; values.len()];
        format!(r#"{{"coefficients": {values:?}, "sigma": {sigma:?}}}"#)
    };
    let channel = |name: &str, k: f64| {
        let numbers = [
            ("alpha", vec![0.3 * k - 20.0, 40.0]),
            ("beta", vec![1.5]),
            ("gamma", vec![-6.0]),
            ("delta", vec![1.0]),
            ("phi", vec![coma * (1.0 + 0.1 * k)]),
            ("blur_variance_px2", vec![0.3]),
            ("magnification", vec![0.002 * k]),
            ("distortion", vec![-0.004]),
        ];
        let numbers = numbers.map(|(name, values)| format!(r#""{name}": {}"#, series(&values)));
        let rest = r#""measured_vergence_per_m": [0.0, 1.0], "effects": []"#;
        format!(r#"{{"name": "{name}", {}, {rest}}}"#, numbers.join(", "))
    };
    let channels = [channel("R", 1.0), channel("G", 0.0), channel("B", -1.0)].join(", ");
    let json = format!(
        r#"{{"format": "seidel-lens", "version": 1, "kind": "pupil", "image_size": [640, 400],
 "optical_axis": [320.0, 200.0], "pixel_pitch_um": 50.0,
 "camera": {{"focal_length_mm": 50.0, "f_number": 1.4, "focus_distance_m": 2.0}}, "channels": [{channels}],
 "provenance": {{"program": "tests", "sources": [], "settings": ""}}}}"#
    );
    // In cargo's folder, because statics are never dropped and would leave temporary files behind.
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.json"));
    std::fs::write(&path, json).expect("writable");
    path
}

pub(crate) static LENS: LazyLock<PathBuf> = LazyLock::new(|| write_profile("lens", -3.0));
pub(crate) static OTHER_LENS: LazyLock<PathBuf> = LazyLock::new(|| write_profile("other", 2.0));
