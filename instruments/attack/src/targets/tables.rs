//! Look-up tables, `.cube` and `.spi1d`, through a config that uses them.

use std::path::{Path, PathBuf};

use seidel_colour::{Config, Source};

use super::ocio::use_config;
use super::{Attack, Sort, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::texts;

pub(crate) static CUBE: Target = Target {
    name: "cube",
    about: "tables .cube",
    sort: Sort::InProcess,
    weight: 0.7,
    start: |_| {
        Box::new(Tables {
            seeds: texts::cubes(),
            name: "table.cube",
            last: None,
        })
    },
};

pub(crate) static SPI1D: Target = Target {
    name: "spi1d",
    about: "tables .spi1d",
    sort: Sort::InProcess,
    weight: 0.7,
    start: |_| {
        Box::new(Tables {
            seeds: texts::spi1d(),
            name: "table.spi1d",
            last: None,
        })
    },
};

struct Tables {
    seeds: Vec<Vec<u8>>,
    name: &'static str,
    /// The table of the last case.
    last: Option<PathBuf>,
}

impl Attack for Tables {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let bytes = case.damaged(&self.seeds, TEXT);
        // A name of its own for each case: engines may keep tables by name.
        let name = format!("{}-{}", case.number, self.name);
        let path = case.write(&name, &bytes);
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
                        case.check_error(&error.to_string(), &name);
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
        self.last = Some(path);
    }

    fn clean_up(&mut self, _folder: &Path) {
        if let Some(path) = self.last.take() {
            // Best effort: a table that remains does no harm.
            let _ = std::fs::remove_file(path);
        }
    }
}
