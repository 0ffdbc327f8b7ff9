//! Malformed configs and tables: rejected with an error, never a panic.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use seidel_colour::curves::CurveTable;
use seidel_colour::{Alphas, Config, EMBEDDED_CONFIG, Source};

/// Loads a config and uses all that it contains.
fn load_and_use(yaml: String) {
    let source = Source::Text {
        name: "malformed.ocio".to_owned(),
        yaml,
    };
    match Config::load(&source) {
        Err(error) => {
            let text = error.to_string();
            assert!(
                text.starts_with("malformed.ocio: ") && text.contains("; "),
                "{text}"
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
                let _ = processor
                    .convert_planes(&mut planes, Alphas::Straight)
                    .unwrap();
                assert!(processor.is_no_op() || planes.iter().flatten().all(|v| v.is_finite()));
            }
            Err(error) => assert!(error.to_string().contains("; "), "{error}"),
        }
    }
}

/// Returns the error of a config file of this text.
fn refusal(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.ocio");
    fs::write(&path, text).unwrap();
    let refused = Config::load(&Source::File(path));
    refused.map(|_| ()).expect_err("refused").to_string()
}

#[test]
fn aliases_of_aliases_are_counted_and_refused() {
    let mut text = "a0: &a0 [x, x]\n".to_owned();
    for level in 1..40 {
        let nine = vec![format!("*a{}", level - 1); 9].join(", ");
        text += &format!("a{level}: &a{level} [{nine}]\n");
    }
    let error = refusal(&text);
    assert!(
        error.contains("bomb.ocio: line 7: its aliases make"),
        "{error}"
    );
    // By mappings, and by a value that is no list.
    let mapped = text.replace('[', "{p: [").replace(']', "]}");
    let error = refusal(&mapped);
    assert!(
        error.contains("bomb.ocio: line 7: its aliases make"),
        "{error}"
    );
}

#[test]
fn an_archive_with_aliases_of_aliases_is_refused() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.ocioz");
    let mut archive = zip::ZipWriter::new(fs::File::create(&path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file("config.ocio", options).unwrap();
    let mut text = "a0: &a0 [x, x]\n".to_owned();
    for level in 1..12 {
        let nine = vec![format!("*a{}", level - 1); 9].join(", ");
        text += &format!("a{level}: &a{level} [{nine}]\n");
    }
    archive.write_all(text.as_bytes()).unwrap();
    archive.finish().unwrap();
    let error = Config::load(&Source::File(path)).map(|_| ());
    let error = error.expect_err("refused").to_string();
    assert!(error.contains("bomb.ocioz: line 7: its aliases"), "{error}");
}

#[test]
fn values_nested_without_end_are_refused() {
    let error = refusal(&"- ".repeat(100_000));
    assert!(error.contains("more than 100 lists"), "{error}");
}

#[test]
fn a_config_may_use_aliases() {
    let plain = "  - !<ColorSpace>\n    name: Extra\n    aliases: &names [one, two]\n  - !<ColorSpace>\n    \
                 name: Other\n    categories: *names\n";
    load_and_use(format!("{EMBEDDED_CONFIG}\n{plain}"));
    let source = Source::Text {
        name: "aliases.ocio".to_owned(),
        yaml: format!("{}\n{plain}", EMBEDDED_CONFIG.trim_end()),
    };
    let _ =
        Config::load(&source).map_err(|e| assert!(!e.to_string().contains("aliases make"), "{e}"));
}

/// Returns a config with a space `Camera` that is defined by the table in `file`.
fn config_with_table(folder: &Path, file: &str) -> Source {
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

/// Converts colours with a table of this text, or returns the error message.
fn convert_with_table(file: &str, text: &[u8]) -> Result<Vec<Vec<f32>>, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(file), text).unwrap();
    let config = Config::load(&config_with_table(folder.path(), file)).unwrap();
    let processor = config
        .processor("Camera", "ACEScg")
        .map_err(|e| e.to_string())?;
    let mut planes = vec![vec![0.5, -3.0, 0.999, 7.0]; 3];
    let _ = processor
        .convert_planes(&mut planes, Alphas::Straight)
        .unwrap();
    assert!(processor.is_no_op() || planes.iter().flatten().all(|v| v.is_finite()));
    Ok(planes)
}

fn table(name: &str) -> Vec<u8> {
    let luts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../luts");
    fs::read(luts.join(name)).unwrap()
}

#[test]
fn generated_tables_are_read() {
    let linear = CurveTable::embedded().unwrap().curves["logc4"]
        .transfer
        .decode(0.5);
    let planes = convert_with_table("a.spi1d", &table("camera/arri-logc4.spi1d")).unwrap();
    assert!(
        (f64::from(planes[0][0]) / linear - 1.0).abs() < 1e-4,
        "{planes:?} {linear}"
    );
    let planes = convert_with_table("a.cube", &table("cube/arri-logc4-to-srgb.cube")).unwrap();
    assert!((0.8..=1.0).contains(&planes[0][0]), "{planes:?}");
}

#[test]
fn malformed_tables_are_rejected() {
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
        let message = convert_with_table(file, text.as_bytes()).unwrap_err();
        assert!(
            message.starts_with("tables.ocio: `Camera` to `ACEScg`"),
            "{message}"
        );
    }
    let empty = tempfile::tempdir().unwrap();
    let config = Config::load(&config_with_table(empty.path(), "lost.cube")).unwrap();
    let error = config.processor("Camera", "ACEScg").err().unwrap();
    assert!(error.to_string().contains("lost.cube"), "{error}");
}

#[test]
fn malformed_curve_tables_are_rejected() {
    for text in [
        "[curve.a]\nform = 3\n",
        "[[space]]\nname = 1",
        "]",
        "curve = 1",
    ] {
        let error = CurveTable::parse(text).unwrap_err().to_string();
        assert!(error.starts_with("luts/curves.toml: "), "{error}");
    }
    let valid = include_str!("../../../luts/curves.toml");
    let unknown_curve = valid.replace("curve = \"logc4\"", "curve = \"logc9\"");
    let error = CurveTable::parse(&unknown_curve).unwrap_err().to_string();
    assert!(
        error.contains("ARRI LogC4") && error.contains("logc9"),
        "{error}"
    );
}

/// Mutates a text: changes, deletes, doubles or replaces some of its bytes.
fn mutated(text: &[u8]) -> impl Strategy<Value = Vec<u8>> + use<> {
    let text = text.to_vec();
    let change = (
        any::<prop::sample::Index>(),
        0..4_u8,
        any::<u8>(),
        1..40_usize,
    );
    prop::collection::vec(change, 1..6).prop_map(move |changes| {
        let mut text = text.clone();
        for (position, kind, byte, length) in changes {
            let start = position
                .index(text.len().max(1))
                .min(text.len().saturating_sub(1));
            let end = (start + length).min(text.len());
            match kind {
                0 => text[start] = byte,
                1 => drop(text.drain(start..end)),
                2 => {
                    let again = text[start..end].to_vec();
                    text.splice(start..start, again);
                }
                _ => drop(text.splice(start..end, *b"-1e99")),
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
    fn mutated_configs_do_not_panic(text in mutated(EMBEDDED_CONFIG.as_bytes())) {
        load_and_use(String::from_utf8_lossy(&text).into_owned());
    }

    #[test]
    fn arbitrary_configs_do_not_panic(text in "(?s).{0,200}") {
        load_and_use(text.clone());
        load_and_use(format!("ocio_profile_version: 2.1\n{text}"));
    }

    #[test]
    fn mutated_spi1d_tables_do_not_panic(
        text in mutated(b"Version 1\nFrom -0.125 1.125\nLength 4\nComponents 3\n{\n0 0 0\n.1 .1 .2\n.3 .3 .4\n1 1 9\n}\n")
    ) {
        let _ = convert_with_table("a.spi1d", &text);
    }

    #[test]
    fn mutated_cube_tables_do_not_panic(
        text in mutated(b"TITLE \"x\"\nLUT_3D_SIZE 2\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n")
    ) {
        let _ = convert_with_table("a.cube", &text);
    }

    #[test]
    fn mutated_curve_tables_do_not_panic(
        text in mutated(include_bytes!("../../../luts/curves.toml"))
    ) {
        if let Err(error) = CurveTable::parse(&String::from_utf8_lossy(&text)) {
            prop_assert!(error.to_string().starts_with("luts/curves.toml: "));
        }
    }
}
