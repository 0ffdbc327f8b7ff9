//! Agreement with OpenColorIO itself on many random colours, where Python has it (`pip install opencolorio numpy`).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use seidel_colour::{Alphas, Config, Source};

/// What two engines may differ by, of the largest channel of a pixel, and at least of 1e-3.
const TOLERANCE: f64 = 2e-6;

/// Reads pixels of floats, turns them and writes them: config, from, to, in, out.
const SCRIPT: &str = "
import sys, numpy, PyOpenColorIO as ocio
config = ocio.Config.CreateFromFile(sys.argv[1])
for way in sys.argv[2:]:
    source, target, before, after = way.split('|')
    pixels = numpy.fromfile(before, dtype='<f4').reshape(-1, 3).copy()
    exact = config.getProcessor(source, target).getOptimizedCPUProcessor(ocio.OPTIMIZATION_LOSSLESS)
    exact.applyRGB(pixels)
    pixels.astype('<f4').tofile(after)
";

fn python() -> PathBuf {
    std::env::var_os("SEIDEL_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from)
}

fn has_opencolorio(python: &Path) -> bool {
    let asked = Command::new(python)
        .args(["-c", "import numpy, PyOpenColorIO"])
        .output();
    asked.is_ok_and(|asked| asked.status.success())
}

/// Numbers from 0 to 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        // A step of the generator of Knuth's MMIX; its upper bits are good.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// 1e5 colours: codes with what lies beyond black and white, and light over 26 stops of both signs.
fn colours(light: bool) -> Vec<[f32; 3]> {
    let mut random = Random(8);
    let mut sample = || {
        let (kind, value) = (random.next(), random.next());
        let value = match light {
            true if kind < 0.15 => -(value * 26.0 - 20.0).exp2(),
            true => (value * 36.0 - 20.0).exp2(),
            false if kind < 0.5 => value,
            false => value * 1.5 - 0.3,
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
fn cameras_agree_with_opencolorio_on_many_colours() {
    let python = python();
    if !has_opencolorio(&python) {
        println!("skipped: no PyOpenColorIO and numpy in Python (SEIDEL_PYTHON names another)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let config_file = folder.path().join("config.ocio");
    fs::write(&config_file, seidel_colour::OWN_CONFIG).unwrap();
    let config = Config::load(&Source::Own).unwrap();
    let cameras = config
        .spaces()
        .iter()
        .filter(|space| space.encoding == "log");
    let mut ways = Vec::new();
    for camera in cameras {
        let name = camera.name.as_str();
        ways.extend([(name, "ACEScg", false), ("ACEScg", name, true)]);
    }
    let (codes, light) = (colours(false), colours(true));
    let file = |name: &str| folder.path().join(name);
    fs::write(file("codes"), bytes(&codes)).unwrap();
    fs::write(file("light"), bytes(&light)).unwrap();
    let mut command = Command::new(&python);
    command.args(["-c", SCRIPT]).arg(&config_file);
    for (index, (from, to, is_light)) in ways.iter().enumerate() {
        let before = file(if *is_light { "light" } else { "codes" });
        let after = file(&index.to_string());
        command.arg(format!(
            "{from}|{to}|{}|{}",
            before.display(),
            after.display()
        ));
    }
    let done = command.output().unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let mut failed = Vec::new();
    for (index, (from, to, is_light)) in ways.iter().enumerate() {
        let before = if *is_light { &light } else { &codes };
        let plane = |k: usize| before.iter().map(|p| p[k]).collect();
        let mut planes: Vec<Vec<f32>> = (0..3).map(plane).collect();
        let processor = config.processor(from, to).unwrap();
        let report = processor.planes(&mut planes, Alphas::Straight).unwrap();
        assert_eq!((report.scrubbed, report.unheld), (0, 0));
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
    assert!(failed.is_empty() && ways.len() >= 20, "{failed:?}");
}
