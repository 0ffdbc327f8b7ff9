//! The engine on the crate `ocio`, a Rust port of OpenColorIO.

use std::path::Path;

use ocio::config::logging::set_logging_level;
use ocio::{Config, CpuProcessor, LoggingLevel, OptimizationFlags};

use super::{
    ColourEngine, Display, EngineConfig, EngineProcessor, EngineResult, FileSpace, Pixel, Space,
};
use crate::{EMBEDDED_CONFIG, Source};

/// Disables OpenColorIO's fast logarithms and powers. They are accurate to about 1e-5 only, so 16-bit codes would not
/// all survive a round trip through linear values.
const EXACT: OptimizationFlags = OptimizationFlags::LOSSLESS;

/// The Rust port of OpenColorIO.
pub(super) struct Port;

impl Port {
    pub(super) fn new() -> Self {
        // Errors are returned, and callers report them.
        set_logging_level(LoggingLevel::None);
        Self
    }
}

impl ColourEngine for Port {
    fn name(&self) -> String {
        format!(
            "ocio {} (OpenColorIO {})",
            ocio::VERSION,
            ocio::OCIO_VERSION
        )
    }

    fn load(&self, source: &Source) -> EngineResult<Box<dyn EngineConfig>> {
        let config = match source {
            Source::Embedded => Config::create_from_str(EMBEDDED_CONFIG),
            Source::Text { yaml, .. } => Config::create_from_str(yaml),
            Source::BuiltIn(name) => Config::create_from_builtin_config(name),
            Source::File(path) => Config::create_from_file(&path.to_string_lossy()),
        };
        let config = config.map_err(|e| e.message().to_owned())?;
        Ok(Box::new(PortConfig(config)))
    }
}

struct PortConfig(Config);

fn convert_space(space: &ocio::config::ColorSpace) -> Space {
    Space {
        name: space.name().to_owned(),
        aliases: space.aliases().to_vec(),
        family: space.family().to_owned(),
        encoding: space.encoding().to_owned(),
        description: space.description().to_owned(),
        is_data: space.is_data(),
    }
}

fn cpu_processor(processor: &ocio::Processor) -> Box<dyn EngineProcessor> {
    Box::new(processor.optimized_cpu_processor(EXACT))
}

impl EngineConfig for PortConfig {
    fn spaces(&self) -> Vec<Space> {
        let config = &self.0;
        (0..config.num_color_spaces())
            .filter_map(|i| config.get_color_space(config.color_space_name_by_index(i)))
            .map(convert_space)
            .collect()
    }

    fn roles(&self) -> Vec<(String, String)> {
        let roles = 0..self.0.num_roles();
        roles
            .map(|i| {
                let name = self.0.role_name(i);
                (name.to_owned(), self.0.role_color_space(name).to_owned())
            })
            .collect()
    }

    fn displays(&self) -> Vec<Display> {
        let displays = 0..self.0.num_displays();
        displays
            .map(|i| {
                let name = self.0.display(i);
                let views = (0..self.0.num_views(&name)).map(|v| self.0.view(&name, v));
                Display {
                    views: views.collect(),
                    name,
                }
            })
            .collect()
    }

    fn space(&self, name: &str) -> Option<Space> {
        self.0.get_color_space(name).map(convert_space)
    }

    fn file_space(&self, path: &Path) -> Option<FileSpace> {
        let path = path.to_string_lossy();
        let (space, rule) = self.0.color_space_from_filepath_with_index(&path);
        let last = self.0.file_rules().num_entries().checked_sub(1)?;
        (!space.is_empty()).then_some(FileSpace {
            space,
            is_default: rule == last,
        })
    }

    fn processor(&self, from: &str, to: &str) -> EngineResult<Box<dyn EngineProcessor>> {
        let processor = self.0.get_processor(from, to);
        Ok(cpu_processor(
            &processor.map_err(|e| e.message().to_owned())?,
        ))
    }

    fn display_processor(
        &self,
        from: &str,
        display: &str,
        view: &str,
    ) -> EngineResult<Box<dyn EngineProcessor>> {
        let processor = self.0.get_display_view_processor(from, display, view);
        Ok(cpu_processor(
            &processor.map_err(|e| e.message().to_owned())?,
        ))
    }
}

impl EngineProcessor for CpuProcessor {
    fn is_no_op(&self) -> bool {
        CpuProcessor::is_no_op(self)
    }

    fn apply(&self, pixels: &mut [Pixel]) {
        self.apply_pixels(pixels);
    }
}
