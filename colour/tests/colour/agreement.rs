//! Agreement with OpenColorIO on random colours. Skipped unless Python has it (`pip install opencolorio numpy`).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use seidel_colour::{Alphas, Config, ConversionReport, Source};

/// Largest allowed difference between two engines, relative to the largest channel of a pixel or 1e-3. Measured
/// differences are below 3e-7 (docs/colour.md).
const TOLERANCE: f64 = 2e-6;

/// Converts files of RGB floats. Arguments: the config, then `from|to|input|output` for each conversion.
const SCRIPT: &str = "
import sys, numpy, PyOpenColorIO as ocio
config = ocio.Config.CreateFromFile(sys.argv[1])
for conversion in sys.argv[2:]:
    source, target, before, after = conversion.split('|')
    pixels = numpy.fromfile(before, dtype='<f4').reshape(-1, 3).copy()
    exact = config.getProcessor(source, target).getOptimizedCPUProcessor(ocio.OPTIMIZATION_LOSSLESS)
    exact.applyRGB(pixels)
    pixels.astype('<f4').tofile(after)
";

fn python() -> PathBuf {
    std::env::var_os("SEIDEL_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from)
}

fn has_opencolorio(python: &Path) -> bool {
    let output = Command::new(python)
        .args(["-c", "import numpy, PyOpenColorIO"])
        .output();
    output.is_ok_and(|output| output.status.success())
}

/// A linear congruential generator of numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        // Constants of Knuth's MMIX; only the upper bits are used.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Values of random colours.
#[derive(Clone, Copy, PartialEq)]
enum Values {
    /// Codes from -0.3 to 1.2, half of them within 0 to 1.
    Codes,
    /// Scene-linear values over 36 stops, 15 % of them negative.
    Linear,
}

/// Returns 1e5 random colours.
fn colours(values: Values) -> Vec<[f32; 3]> {
    let mut random = Random(8);
    let mut sample = || {
        let (kind, value) = (random.next(), random.next());
        let value = match values {
            Values::Linear if kind < 0.15 => -(value * 26.0 - 20.0).exp2(),
            Values::Linear => (value * 36.0 - 20.0).exp2(),
            Values::Codes if kind < 0.5 => value,
            Values::Codes => value * 1.5 - 0.3,
        };
        value as f32
    };
    (0..100_000)
        .map(|_| [sample(), sample(), sample()])
        .collect()
}

fn bytes(colours: &[[f32; 3]]) -> Vec<u8> {
    colours
        .as_flattened()
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect()
}

#[test]
fn camera_spaces_agree_with_opencolorio_on_random_colours() {
    let python = python();
    if !has_opencolorio(&python) {
        println!(
            "skipped: Python lacks PyOpenColorIO or numpy (set SEIDEL_PYTHON to another interpreter)"
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let config_file = folder.path().join("config.ocio");
    fs::write(&config_file, seidel_colour::EMBEDDED_CONFIG).unwrap();
    let config = Config::load(&Source::Embedded).unwrap();
    let cameras = config
        .spaces()
        .iter()
        .filter(|space| space.encoding == "log");
    let mut conversions = Vec::new();
    for camera in cameras {
        let name = camera.name.as_str();
        conversions.extend([
            (name, "ACEScg", Values::Codes),
            ("ACEScg", name, Values::Linear),
        ]);
    }
    let (codes, linear) = (colours(Values::Codes), colours(Values::Linear));
    let file = |name: &str| folder.path().join(name);
    fs::write(file("codes"), bytes(&codes)).unwrap();
    fs::write(file("linear"), bytes(&linear)).unwrap();
    let mut command = Command::new(&python);
    command.args(["-c", SCRIPT]).arg(&config_file);
    for (index, (from, to, values)) in conversions.iter().enumerate() {
        let before = file(match values {
            Values::Codes => "codes",
            Values::Linear => "linear",
        });
        let after = file(&index.to_string());
        command.arg(format!(
            "{from}|{to}|{}|{}",
            before.display(),
            after.display()
        ));
    }
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut failed = Vec::new();
    for (index, (from, to, values)) in conversions.iter().enumerate() {
        let before = match values {
            Values::Codes => &codes,
            Values::Linear => &linear,
        };
        let plane = |k: usize| before.iter().map(|p| p[k]).collect();
        let mut planes: Vec<Vec<f32>> = (0..3).map(plane).collect();
        let processor = config.processor(from, to).unwrap();
        let report = processor
            .convert_planes(&mut planes, Alphas::Straight)
            .unwrap();
        assert_eq!(report, ConversionReport::default());
        let want = fs::read(file(&index.to_string())).unwrap();
        let want: Vec<f64> = (want.chunks_exact(4))
            .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
            .collect();
        let want: Vec<Vec<f64>> = want.chunks_exact(3).map(<[f64]>::to_vec).collect();
        assert_eq!(want.len(), before.len());
        let worst = super::golden::difference(&planes, &want);
        println!("{from} to {to}: {worst:.1e}");
        if worst > TOLERANCE {
            failed.push(format!("{from} to {to}: {worst:e}"));
        }
    }
    assert!(failed.is_empty() && conversions.len() >= 20, "{failed:?}");
}
