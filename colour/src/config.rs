//! OpenColorIO configs.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use crate::engine::{
    ColourEngine, Display, EngineConfig, EngineProcessor, EngineResult, FileSpace, Space,
    default_engine,
};
use crate::limits;
use crate::processor::Processor;
use crate::suggestions::suggestions;
use crate::{ColourError, Result, Source};

/// The role of the working space.
const SCENE_LINEAR: &str = "scene_linear";

/// An OpenColorIO config in memory, which any number of threads may use.
pub struct Config {
    engine: Box<dyn EngineConfig>,
    engine_name: String,
    name: String,
    spaces: Vec<Space>,
    /// Processors made so far, by the names of their source and target spaces.
    processors: Mutex<HashMap<(String, String), Arc<Processor>>>,
}

impl Config {
    /// Reads a config with the default engine.
    ///
    /// # Errors
    /// If the config cannot be read or has no colour spaces.
    pub fn load(source: &Source) -> Result<Self> {
        Self::load_with(&*default_engine()?, source)
    }

    /// Reads a config with another engine.
    ///
    /// # Errors
    /// If the config cannot be read or has no colour spaces.
    pub fn load_with(engine: &dyn ColourEngine, source: &Source) -> Result<Self> {
        let name = source.to_string();
        let config = read(engine, source)?;
        let spaces = config.spaces();
        if spaces.is_empty() {
            return Err(ColourError::new(
                name,
                "colorspaces",
                "the config has no colour spaces",
                "give another config, or none to use Seidel's own",
            ));
        }
        Ok(Self {
            engine: config,
            engine_name: engine.name(),
            name,
            spaces,
            processors: Mutex::default(),
        })
    }

    /// Returns the config's name in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the name and version of the engine that read it.
    pub fn engine_name(&self) -> &str {
        &self.engine_name
    }

    /// Returns its active spaces, in the order of the config.
    pub fn spaces(&self) -> &[Space] {
        &self.spaces
    }

    /// Returns its roles, each with the name of a space.
    pub fn roles(&self) -> Vec<(String, String)> {
        self.engine.roles()
    }

    /// Returns its displays.
    pub fn displays(&self) -> Vec<Display> {
        self.engine.displays()
    }

    /// Returns the space with this name, alias or role, if any.
    pub fn find(&self, name: &str) -> Option<Space> {
        match name.trim() {
            "" => None,
            name => self.engine.space(name),
        }
    }

    /// Returns the space with this name, alias or role.
    ///
    /// # Errors
    /// A name that the config does not have; the message suggests similar ones.
    pub fn space(&self, name: &str) -> Result<Space> {
        self.find(name).ok_or_else(|| self.unknown_space(name))
    }

    /// Returns the working space: that of the role `scene_linear`.
    ///
    /// # Errors
    /// If the config lacks that role.
    pub fn scene_linear(&self) -> Result<Space> {
        self.find(SCENE_LINEAR).ok_or_else(|| {
            ColourError::new(
                &self.name,
                format!("role {SCENE_LINEAR}"),
                "the config lacks this role",
                "name a scene-linear space of the config as the working space",
            )
        })
    }

    /// Applies the config's file rules to the name of the file at `path`.
    pub fn file_space(&self, path: &Path) -> Option<FileSpace> {
        self.engine.file_space(path)
    }

    /// Returns the processor from one space to another, each given by name, alias or role. Processors are cached.
    ///
    /// # Errors
    /// If there is no such space, or a transform cannot be created, for example because a table is missing.
    pub fn processor(&self, from: &str, to: &str) -> Result<Arc<Processor>> {
        let key = (self.space(from)?.name, self.space(to)?.name);
        let mut processors = self
            .processors
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(processor) = processors.get(&key) {
            return Ok(Arc::clone(processor));
        }
        let (from, to) = &key;
        let processor = Arc::new(self.checked(from, to, self.engine.processor(from, to))?);
        processors.insert(key, Arc::clone(&processor));
        Ok(processor)
    }

    /// Returns the processor from a space to `display`, through `view`.
    ///
    /// # Errors
    /// If there is no such space, display or view, or a transform cannot be created.
    pub fn display_processor(&self, from: &str, display: &str, view: &str) -> Result<Processor> {
        let from = self.space(from)?.name;
        let to = format!("{display}/{view}");
        let known: Vec<String> = self
            .displays()
            .iter()
            .flat_map(|d| d.views.iter().map(|view| format!("{}/{view}", d.name)))
            .collect();
        if !known.contains(&to) {
            return Err(ColourError::new(
                &self.name,
                format!("view `{to}`"),
                "the config has no such display or view",
                format!("give one of {}", known.join(", ")),
            ));
        }
        self.checked(
            &from,
            &to,
            self.engine.display_processor(&from, display, view),
        )
    }

    fn unknown_space(&self, name: &str) -> ColourError {
        let roles = self.roles();
        let spaces = self.spaces.iter();
        let names = spaces
            .flat_map(|space| space.aliases.iter().chain([&space.name]))
            .chain(roles.iter().map(|(role, _)| role));
        let similar: Vec<String> = suggestions(name, names.map(String::as_str))
            .iter()
            .map(|name| format!("`{name}`"))
            .collect();
        let remedy = if similar.is_empty() {
            "`seidel lut --list` shows all names".to_owned()
        } else {
            format!(
                "did you mean {}? `seidel lut --list` shows all names",
                similar.join(" or ")
            )
        };
        let field = format!("colour space `{name}`");
        ColourError::new(
            &self.name,
            field,
            "the config has no space, alias or role of this name",
            remedy,
        )
    }

    /// Wraps the engine's transform, or its message as an error.
    fn checked(
        &self,
        from: &str,
        to: &str,
        engine: EngineResult<Box<dyn EngineProcessor>>,
    ) -> Result<Processor> {
        let engine = engine.map_err(|message| {
            ColourError::new(
                &self.name,
                format!("`{from}` to `{to}`"),
                format!("the transform cannot be created ({})", message.trim_end()),
                "check the transforms of these spaces, and that the files they name exist",
            )
        })?;
        Ok(Processor::new(engine, &self.name, from, to))
    }
}

fn read(engine: &dyn ColourEngine, source: &Source) -> Result<Box<dyn EngineConfig>> {
    let remedy = match source {
        Source::Embedded => "reinstall Seidel",
        Source::Text { .. } => "correct the config",
        Source::BuiltIn(_) => {
            "give a built-in config such as ocio://studio-config-latest or ocio://cg-config-latest"
        }
        // Engines take paths as strings.
        Source::File(path) if path.to_str().is_none() => {
            return Err(ColourError::new(
                source.to_string(),
                "",
                "the path is not valid Unicode",
                "rename the file or the folder",
            ));
        }
        Source::File(path) if path.exists() => "correct the config, or give another",
        Source::File(_) => "check the path of the config and the environment variable OCIO",
    };
    limits::check(source)?;
    engine.load(source).map_err(|message| {
        let problem = format!("the config cannot be read ({})", message.trim_end());
        ColourError::new(source.to_string(), "", problem, remedy)
    })
}
