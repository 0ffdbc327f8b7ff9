//! Configs: which there are, what they are asked, and what is said of what they lack.

use std::fs;
use std::path::Path;

use seidel_colour::{Config, Source};

fn own() -> Config {
    Config::load(&Source::Own).unwrap()
}

#[test]
fn every_space_of_our_own_config_goes_to_every_other() {
    let config = own();
    let names: Vec<&str> = config.spaces().iter().map(|s| s.name.as_str()).collect();
    assert!(names.len() >= 24, "{names:?}");
    for from in &names {
        for to in &names {
            let processor = config.processor(from, to).unwrap();
            let data = [from, to].iter().any(|name| **name == "Raw");
            assert_eq!(processor.is_no_op(), data || from == to, "{from} to {to}");
        }
    }
}

#[test]
fn spaces_go_by_name_alias_and_role() {
    let config = own();
    for (asked, name) in [
        ("ACEScg", "ACEScg"),
        ("acescg", "ACEScg"),
        (" scene_linear ", "ACEScg"),
        ("lin_ap1_scene", "ACEScg"),
        ("logc4", "ARRI LogC4"),
        ("data", "Raw"),
    ] {
        assert_eq!(config.space(asked).unwrap().name, name, "{asked}");
    }
    assert_eq!(config.scene_linear().unwrap().name, "ACEScg");
    assert!(config.space("Raw").unwrap().is_data);
    assert!(config.space("ACEScg").unwrap().is_scene_linear());
    assert!(!config.space("ARRI LogC4").unwrap().is_scene_linear());
    assert!(config.find("").is_none());
}

#[test]
fn a_name_that_is_none_gets_the_nearest_ones() {
    let said = own()
        .processor("ARRI LogC5", "ACEScg")
        .err()
        .unwrap()
        .to_string();
    for part in [
        "Seidel's own config",
        "ARRI LogC5",
        "`ARRI LogC4`",
        "seidel lut --list",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let said = own()
        .processor("ACEScg", "qqqqqqq")
        .err()
        .unwrap()
        .to_string();
    assert!(
        said.contains("qqqqqqq") && said.contains("--list"),
        "{said}"
    );
    let said = own()
        .display_processor("ACEScg", "sRGB", "Filmic")
        .err()
        .unwrap();
    assert!(said.to_string().contains("sRGB/Plain"), "{said}");
}

#[test]
fn displays_have_views() {
    let config = own();
    let displays = config.displays();
    let names: Vec<&str> = displays.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(names, ["sRGB", "Rec.709"]);
    let shown = config.display_processor("ACEScg", "sRGB", "Plain").unwrap();
    let mut grey = [0.18, 0.18, 0.18];
    assert_eq!(shown.rows(&mut grey, 3, false).unwrap(), Default::default());
    assert!((grey[0] - 0.4614).abs() < 1e-3, "{grey:?}");
}

#[test]
fn files_have_spaces_by_their_names() {
    let config = own();
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
fn configs_come_from_files_and_from_opencolorio() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.ocio");
    fs::write(&file, seidel_colour::OWN_CONFIG).unwrap();
    let config = Config::load(&Source::File(file.clone())).unwrap();
    assert_eq!(config.spaces(), own().spaces());
    assert_eq!(config.name(), file.display().to_string());
    let studio = Config::load(&Source::named("ocio://studio-config-latest")).unwrap();
    assert!(studio.spaces().len() > 40);
    assert!(studio.scene_linear().unwrap().name == "ACEScg");
}

#[test]
fn configs_that_are_not_there_are_said_with_a_remedy() {
    let missing = Config::load(&Source::named("nowhere/config.ocio"))
        .err()
        .unwrap();
    let said = missing.to_string();
    assert!(
        said.contains("nowhere/config.ocio") && said.contains("--ocio"),
        "{said}"
    );
    let unknown = Config::load(&Source::named("ocio://no-such-config"))
        .err()
        .unwrap();
    assert!(
        unknown.to_string().contains("studio-config-latest"),
        "{unknown}"
    );
    let empty = Source::Text {
        name: "empty.ocio".to_owned(),
        yaml: String::new(),
    };
    let said = Config::load(&empty).err().unwrap().to_string();
    assert!(said.starts_with("empty.ocio: "), "{said}");
}
