//! Loading configs, looking up spaces, displays and file rules, and the errors of each.

use std::fs;
use std::path::Path;

use seidel_colour::{Config, ConversionReport, PixelLayout, Source};

fn embedded() -> Config {
    Config::load(&Source::Embedded).unwrap()
}

#[test]
fn every_embedded_space_converts_to_every_other() {
    let config = embedded();
    let names: Vec<&str> = config.spaces().iter().map(|s| s.name.as_str()).collect();
    assert!(names.len() >= 24, "{names:?}");
    for from in &names {
        for to in &names {
            let processor = config.processor(from, to).unwrap();
            let has_data = [from, to].iter().any(|name| **name == "Raw");
            assert_eq!(
                processor.is_no_op(),
                has_data || from == to,
                "{from} to {to}"
            );
        }
    }
}

#[test]
fn spaces_are_found_by_name_alias_and_role() {
    let config = embedded();
    for (query, name) in [
        ("ACEScg", "ACEScg"),
        ("acescg", "ACEScg"),
        (" scene_linear ", "ACEScg"),
        ("lin_ap1_scene", "ACEScg"),
        ("logc4", "ARRI LogC4"),
        ("data", "Raw"),
    ] {
        assert_eq!(config.space(query).unwrap().name, name, "{query}");
    }
    assert_eq!(config.scene_linear().unwrap().name, "ACEScg");
    assert!(config.space("Raw").unwrap().is_data);
    assert!(config.space("ACEScg").unwrap().is_scene_linear());
    assert!(!config.space("ARRI LogC4").unwrap().is_scene_linear());
    assert!(config.find("").is_none());
}

/// Returns the message of a failed call.
fn message<T>(result: seidel_colour::Result<T>) -> String {
    result.err().unwrap().to_string()
}

#[test]
fn unknown_names_get_suggestions() {
    let config = embedded();
    let text = message(config.processor("ARRI LogC5", "ACEScg"));
    for part in [
        "Seidel's own config",
        "ARRI LogC5",
        "did you mean `ARRI LogC4`",
        "seidel lut --list",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let text = message(config.processor("ACEScg", "qqqqqqq"));
    assert!(
        text.contains("qqqqqqq") && text.contains("--list"),
        "{text}"
    );
    assert!(!text.contains("did you mean"), "{text}");
    let text = message(config.display_processor("ACEScg", "sRGB", "Filmic"));
    assert!(text.contains("sRGB/Plain"), "{text}");
}

#[test]
fn embedded_config_has_two_displays() {
    let config = embedded();
    let displays = config.displays();
    let names: Vec<&str> = displays.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(names, ["sRGB", "Rec.709"]);
    let to_display = config.display_processor("ACEScg", "sRGB", "Plain").unwrap();
    let mut grey = [0.18, 0.18, 0.18];
    let report = to_display.convert_pixels(&mut grey, PixelLayout::Rgb);
    assert_eq!(report.unwrap(), ConversionReport::default());
    assert!((grey[0] - 0.4614).abs() < 1e-3, "{grey:?}");
}

#[test]
fn file_rules_assign_spaces_by_file_name() {
    let config = embedded();
    for (file, space, is_default) in [
        ("shots/a_logc4_v2.exr", "ARRI LogC4", false),
        ("shots/A_LogC_0001.exr", "ARRI LogC3 (EI800)", false),
        ("slog3_sgamut3cine.0001.exr", "S-Log3 S-Gamut3.Cine", false),
        ("a_vlog_1.exr", "V-Log V-Gamut", false),
        ("still.png", "sRGB - Texture", false),
        ("plate.exr", "ACEScg", true),
    ] {
        let found = config.file_space(Path::new(file)).unwrap();
        assert_eq!(config.space(&found.space).unwrap().name, space, "{file}");
        assert_eq!(found.is_default, is_default, "{file}");
    }
}

#[test]
fn configs_load_from_files_and_from_opencolorio() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("copy.ocio");
    fs::write(&file, seidel_colour::EMBEDDED_CONFIG).unwrap();
    let config = Config::load(&Source::File(file.clone())).unwrap();
    assert_eq!(config.spaces(), embedded().spaces());
    assert_eq!(config.name(), file.display().to_string());
    let studio = Config::load(&Source::named("ocio://studio-config-latest")).unwrap();
    assert!(studio.spaces().len() > 40);
    assert_eq!(studio.scene_linear().unwrap().name, "ACEScg");
}

#[test]
fn unreadable_configs_are_reported_with_a_remedy() {
    let text = message(Config::load(&Source::named("nowhere/config.ocio")));
    assert!(
        text.contains("nowhere/config.ocio") && text.contains("check the path of the config"),
        "{text}"
    );
    let text = message(Config::load(&Source::named("ocio://no-such-config")));
    assert!(text.contains("studio-config-latest"), "{text}");
    let empty = Source::Text {
        name: "empty.ocio".to_owned(),
        yaml: String::new(),
    };
    let text = message(Config::load(&empty));
    assert!(text.starts_with("empty.ocio: "), "{text}");
}
