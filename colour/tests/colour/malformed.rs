//! Configs and tables that are none: refused in words, whatever they hold.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use seidel_colour::curves::Table;
use seidel_colour::{Alphas, Config, OWN_CONFIG, Source};

/// Asks a config for all that it has, as far as it is one.
fn used(yaml: String) {
    let source = Source::Text {
        name: "made.ocio".to_owned(),
        yaml,
    };
    match Config::load(&source) {
        Err(why) => {
            let said = why.to_string();
            assert!(
                said.starts_with("made.ocio: ") && said.contains("; "),
                "{said}"
            );
        }
        Ok(config) => use_all(&config),
    }
}

fn use_all(config: &Config) {
    let names: Vec<&str> = config.spaces().iter().map(|s| s.name.as_str()).collect();
    config.roles();
    for display in config.displays() {
        for view in &display.views {
            let _ = config.display_processor(names[0], &display.name, view);
        }
    }
    let _ = config.file_space(Path::new("a_logc4.exr"));
    for from in &names {
        match config.processor(from, "ACEScg") {
            Ok(processor) => {
                let mut planes = vec![vec![0.1, -3.0, f32::NAN]; 3];
                let _ = processor.planes(&mut planes, Alphas::Straight).unwrap();
                assert!(processor.is_no_op() || planes.iter().flatten().all(|v| v.is_finite()));
            }
            Err(why) => assert!(why.to_string().contains("; "), "{why}"),
        }
    }
}

/// A config whose one camera is the table in `file`.
fn with_table(folder: &Path, file: &str) -> Source {
    let yaml = format!(
        "ocio_profile_version: 2.1\nsearch_path: \"{}\"\nroles:\n  default: ACEScg\n  scene_linear: ACEScg\n\
         file_rules:\n  - !<Rule> {{name: Default, colorspace: default}}\n\
         displays:\n  sRGB:\n    - !<View> {{name: Raw, colorspace: ACEScg}}\n\
         colorspaces:\n  - !<ColorSpace>\n    name: ACEScg\n  - !<ColorSpace>\n    name: Camera\n    \
         to_scene_reference: !<FileTransform> {{src: {file}}}\n",
        folder.display()
    );
    Source::Text {
        name: "tables.ocio".to_owned(),
        yaml,
    }
}

/// Colours through a table of this text, or why not.
fn through(file: &str, text: &[u8]) -> Result<Vec<Vec<f32>>, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(file), text).unwrap();
    let config = Config::load(&with_table(folder.path(), file)).unwrap();
    let processor = config
        .processor("Camera", "ACEScg")
        .map_err(|e| e.to_string())?;
    let mut planes = vec![vec![0.5, -3.0, 0.999, 7.0]; 3];
    let _ = processor.planes(&mut planes, Alphas::Straight).unwrap();
    assert!(processor.is_no_op() || planes.iter().flatten().all(|v| v.is_finite()));
    Ok(planes)
}

fn table(name: &str) -> Vec<u8> {
    let luts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../luts");
    fs::read(luts.join(name)).unwrap()
}

#[test]
fn our_own_tables_are_read() {
    let grey = seidel_colour::curves::own().unwrap().curves["logc4"]
        .form
        .linear(0.5);
    let planes = through("a.spi1d", &table("camera/arri-logc4.spi1d")).unwrap();
    assert!(
        (f64::from(planes[0][0]) / grey - 1.0).abs() < 1e-4,
        "{planes:?} {grey}"
    );
    let planes = through("a.cube", &table("cube/arri-logc4-to-srgb.cube")).unwrap();
    assert!((0.8..=1.0).contains(&planes[0][0]), "{planes:?}");
}

#[test]
fn tables_that_are_none_are_refused_in_words() {
    let spi1d = "Version 1\nFrom 0.0 1.0\nLength 4\nComponents 1\n{\n0\n0.2\n}\n";
    let cube = "LUT_3D_SIZE 2\n0 0 0\n1 1 1\n";
    for (file, text) in [
        ("a.spi1d", ""),
        ("a.spi1d", spi1d),
        ("a.spi1d", "Version 1\nLength 99999999999999999999\n"),
        ("a.cube", ""),
        ("a.cube", cube),
        ("a.cube", "LUT_3D_SIZE 100000\n0 0 0\n"),
        ("a.cube", "LUT_3D_SIZE -2\n"),
        ("a.cube", "LUT_3D_SIZE 2\n0 0 zero\n"),
    ] {
        let said = through(file, text.as_bytes()).unwrap_err();
        assert!(
            said.starts_with("tables.ocio: `Camera` to `ACEScg`"),
            "{said}"
        );
    }
    let nowhere = tempfile::tempdir().unwrap();
    let config = Config::load(&with_table(nowhere.path(), "lost.cube")).unwrap();
    let said = config
        .processor("Camera", "ACEScg")
        .err()
        .unwrap()
        .to_string();
    assert!(said.contains("lost.cube"), "{said}");
}

#[test]
fn a_table_of_curves_that_is_none_is_refused_with_the_line() {
    for text in [
        "[curve.a]\nform = 3\n",
        "[[space]]\nname = 1",
        "]",
        "curve = 1",
    ] {
        let said = Table::parse(text).unwrap_err().to_string();
        assert!(said.starts_with("luts/curves.toml: "), "{said}");
    }
    let own = include_str!("../../../luts/curves.toml");
    let said = Table::parse(&own.replace("curve = \"logc4\"", "curve = \"logc9\""));
    let said = said.unwrap_err().to_string();
    assert!(
        said.contains("ARRI LogC4") && said.contains("logc9"),
        "{said}"
    );
}

/// A text with some of its bytes changed, left out or doubled.
fn spoiled(text: &[u8]) -> impl Strategy<Value = Vec<u8>> + use<> {
    let text = text.to_vec();
    let change = (
        any::<prop::sample::Index>(),
        0..4_u8,
        any::<u8>(),
        1..40_usize,
    );
    prop::collection::vec(change, 1..6).prop_map(move |changes| {
        let mut text = text.clone();
        for (at, kind, byte, length) in changes {
            let at = at
                .index(text.len().max(1))
                .min(text.len().saturating_sub(1));
            let end = (at + length).min(text.len());
            match kind {
                0 => text[at] = byte,
                1 => drop(text.drain(at..end)),
                2 => {
                    let again = text[at..end].to_vec();
                    text.splice(at..at, again);
                }
                _ => drop(text.splice(at..end, *b"-1e99")),
            }
            if text.is_empty() {
                text.push(byte);
            }
        }
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn a_spoiled_config_does_not_break_anything(text in spoiled(OWN_CONFIG.as_bytes())) {
        used(String::from_utf8_lossy(&text).into_owned());
    }

    #[test]
    fn any_text_as_a_config_does_not_break_anything(text in "(?s).{0,200}") {
        used(text.clone());
        used(format!("ocio_profile_version: 2.1\n{text}"));
    }

    #[test]
    fn a_spoiled_spi1d_does_not_break_anything(
        text in spoiled(b"Version 1\nFrom -0.125 1.125\nLength 4\nComponents 3\n{\n0 0 0\n.1 .1 .2\n.3 .3 .4\n1 1 9\n}\n")
    ) {
        let _ = through("a.spi1d", &text);
    }

    #[test]
    fn a_spoiled_cube_does_not_break_anything(
        text in spoiled(b"TITLE \"x\"\nLUT_3D_SIZE 2\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n")
    ) {
        let _ = through("a.cube", &text);
    }

    #[test]
    fn spoiled_curves_do_not_break_anything(
        text in spoiled(include_bytes!("../../../luts/curves.toml"))
    ) {
        if let Err(why) = Table::parse(&String::from_utf8_lossy(&text)) {
            prop_assert!(why.to_string().starts_with("luts/curves.toml: "));
        }
    }
}
