//! Look-up tables, `.cube` and `.spi1d`, through a config that uses them.

use std::fs;
use std::path::Path;

use seidel_colour::{Config, Source};

use super::ocio::use_config;
use super::reader::Reader;
use super::{Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::texts;

pub(crate) static CUBE: Target = Target {
    name: "cube",
    about: "tables .cube",
    weight: 0.7,
    method: Method::Reader(Reader {
        file: "table.cube",
        seeds: |_| texts::cubes(),
        mutations: |_| TEXT,
        read,
    }),
};

pub(crate) static SPI1D: Target = Target {
    name: "spi1d",
    about: "tables .spi1d",
    weight: 0.7,
    method: Method::Reader(Reader {
        file: "table.spi1d",
        seeds: |_| texts::spi1d(),
        mutations: |_| TEXT,
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    // A name of its own for each case: engines may keep tables by name.
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let name = format!("{}-{file}", case.number);
    let table = path.with_file_name(&name);
    if let Err(error) = fs::copy(path, &table) {
        panic!("the attack cannot write {}: {error}", table.display());
    }
    let yaml = format!(
        "ocio_profile_version: 2.1\nsearch_path: \"{}\"\nroles:\n  default: ACEScg\n  scene_linear: ACEScg\n\
         file_rules:\n  - !<Rule> {{name: Default, colorspace: default}}\n\
         displays:\n  sRGB:\n    - !<View> {{name: Raw, colorspace: ACEScg}}\n\
         colorspaces:\n  - !<ColorSpace>\n    name: Camera\n    \
         to_scene_reference: !<FileTransform> {{src: {name}}}\n  - !<ColorSpace>\n    name: ACEScg\n",
        case.folder.display()
    );
    let source = Source::Text {
        name: "tables.ocio".to_owned(),
        yaml,
    };
    match Config::load(&source) {
        Ok(config) => {
            case.is_accepted = match config.processor("Camera", "ACEScg") {
                Ok(_) => true,
                Err(error) => {
                    case.check_file_error(&error, &table);
                    false
                }
            };
            use_config(case, &config, "tables.ocio");
        }
        Err(error) if case.inputs == Inputs::Sound => {
            case.report(Kind::Refused, error.to_string());
        }
        Err(_) => {}
    }
    // Best effort: a table that remains does no harm.
    let _ = fs::remove_file(table);
}
