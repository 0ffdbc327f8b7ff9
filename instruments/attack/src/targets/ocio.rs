//! OpenColorIO configs: loaded, and every space and view of them used.

use std::path::Path;

use seidel_colour::{Alphas, Config, Source};

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::texts;

pub(crate) static TARGET: Target = Target {
    name: "ocio",
    about: "OpenColorIO configs",
    weight: 1.5,
    method: Method::Reader(Reader {
        file: "config.ocio",
        seeds: |_| texts::configs(),
        mutations: |_| TEXT,
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    match Config::load(&Source::File(path.to_owned())) {
        Ok(config) => {
            case.is_accepted = true;
            use_config(case, &config, "config.ocio");
        }
        Err(error) => case.check_file_error(&error, path),
    }
}

/// Converts colours from a few spaces of the config and to its displays.
pub(crate) fn use_config(case: &mut Case, config: &Config, name: &str) {
    let _ = config.file_space(Path::new("a_log.exr"));
    let target = config
        .scene_linear()
        .map_or_else(|_| String::new(), |s| s.name);
    let spaces = config.spaces();
    for _ in 0..spaces.len().min(4) {
        let from = &case.rng.pick(spaces).name.clone();
        match config.processor(from, &target) {
            Ok(processor) => {
                let mut planes = vec![vec![0.1, -3.0, 0.999, 7.0, 0.0]; 3];
                let converted = processor.convert_planes(&mut planes, Alphas::Straight);
                let is_finite = planes.iter().flatten().all(|v| v.is_finite());
                let is_reported = converted.is_ok_and(|report| report.unrepresentable > 0);
                if !is_finite && !is_reported {
                    let text = format!("{from}: finite colours became {planes:?}");
                    case.report(Kind::SilentChange, text);
                }
            }
            Err(error) => case.check_error(&error.to_string(), name),
        }
    }
    for display in config.displays().iter().take(2) {
        for view in display.views.iter().take(2) {
            let made = config.display_processor(&target, &display.name, view);
            if let Err(error) = made {
                case.check_error(&error.to_string(), name);
            }
        }
    }
}
