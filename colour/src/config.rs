//! A config: its spaces, and processors between them.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use crate::engine::{ColourEngine, Display, EngineConfig, FileSpace, Space, built_in};
use crate::processor::Processor;
use crate::spelling::nearest;
use crate::{ColourError, Result, Source};

/// The role of the space that light is worked on in.
const SCENE_LINEAR: &str = "scene_linear";

/// An OpenColorIO config in memory. May be used from any number of threads.
pub struct Config {
    engine: Box<dyn EngineConfig>,
    engine_name: String,
    name: String,
    spaces: Vec<Space>,
    /// Processors that were asked for, by the spaces that they are between.
    made: Mutex<HashMap<(String, String), Arc<Processor>>>,
}

fn read(engine: &dyn ColourEngine, source: &Source) -> Result<Box<dyn EngineConfig>> {
    let remedy = match source {
        Source::Own => "build Seidel anew",
        Source::Text { .. } => "mend the config",
        Source::BuiltIn(_) => {
            "give one such as ocio://studio-config-latest or ocio://cg-config-latest"
        }
        Source::File(path) if path.to_str().is_none() => {
            return Err(ColourError::new(
                source.to_string(),
                "",
                "is not named in Unicode",
                "rename it or a folder above it",
            ));
        }
        Source::File(path) if path.exists() => "mend the config, or give another",
        Source::File(_) => "check --ocio, or the environment variable OCIO",
    };
    engine.load(source).map_err(|why| {
        let problem = format!("cannot be read ({})", why.trim_end());
        ColourError::new(source.to_string(), "", problem, remedy)
    })
}

impl Config {
    /// Reads a config with the engine that this was built with.
    ///
    /// # Errors
    /// A config that cannot be read or has no colour spaces.
    pub fn load(source: &Source) -> Result<Self> {
        Self::load_with(&*built_in()?, source)
    }

    /// Reads a config with another engine.
    ///
    /// # Errors
    /// Those of [`Config::load`].
    pub fn load_with(engine: &dyn ColourEngine, source: &Source) -> Result<Self> {
        let name = source.to_string();
        let config = read(engine, source)?;
        let spaces = config.spaces();
        if spaces.is_empty() {
            return Err(ColourError::new(
                name,
                "colorspaces",
                "there are none",
                "give a config that has some, or none to use Seidel's own",
            ));
        }
        Ok(Self {
            engine: config,
            engine_name: engine.name(),
            name,
            spaces,
            made: Mutex::default(),
        })
    }

    /// What it is called in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Which engine reads it.
    pub fn engine_name(&self) -> &str {
        &self.engine_name
    }

    /// Its active spaces, in the order of the config.
    pub fn spaces(&self) -> &[Space] {
        &self.spaces
    }

    /// Its roles, each with the name of a space.
    pub fn roles(&self) -> Vec<(String, String)> {
        self.engine.roles()
    }

    /// Its displays.
    pub fn displays(&self) -> Vec<Display> {
        self.engine.displays()
    }

    /// The space that is called `name`, by whatever name it has: its own, an alias or a role.
    pub fn find(&self, name: &str) -> Option<Space> {
        match name.trim() {
            "" => None,
            name => self.engine.space(name),
        }
    }

    /// The space that is called `name`.
    ///
    /// # Errors
    /// No such space, with the names nearest to it.
    pub fn space(&self, name: &str) -> Result<Space> {
        self.find(name).ok_or_else(|| {
            let roles = self.roles();
            let spaces = self.spaces.iter();
            let names = spaces
                .flat_map(|space| space.aliases.iter().chain([&space.name]))
                .chain(roles.iter().map(|(role, _)| role));
            let near = nearest(name, names.map(String::as_str));
            let remedy = match near.as_slice() {
                [] => "give one that `seidel lut --list` shows".to_owned(),
                near => format!(
                    "is it {}? `seidel lut --list` shows all",
                    near.iter()
                        .map(|name| format!("`{name}`"))
                        .collect::<Vec<_>>()
                        .join(" or ")
                ),
            };
            let field = format!("colour space `{name}`");
            ColourError::new(&self.name, field, "there is none of this name", remedy)
        })
    }

    /// The space that light is worked on in: that of the role scene_linear.
    ///
    /// # Errors
    /// A config without that role.
    pub fn scene_linear(&self) -> Result<Space> {
        self.find(SCENE_LINEAR).ok_or_else(|| {
            ColourError::new(
                &self.name,
                format!("role {SCENE_LINEAR}"),
                "is not there",
                "say which space of it is linear as the working space (--working-space)",
            )
        })
    }

    /// What the config's file rules say of the file at `path`, by its name alone.
    pub fn file_space(&self, path: &Path) -> Option<FileSpace> {
        self.engine.file_space(path)
    }

    /// What turns colours of the space called `from` into those of `to`; made once.
    ///
    /// # Errors
    /// No such space, and transforms that cannot be made, such as those of tables that are not there.
    pub fn processor(&self, from: &str, to: &str) -> Result<Arc<Processor>> {
        let (from, to) = (self.space(from)?.name, self.space(to)?.name);
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (from, to);
        if let Some(processor) = made.get(&key) {
            return Ok(Arc::clone(processor));
        }
        let (from, to) = &key;
        let engine = self.engine.processor(from, to);
        let engine = engine.map_err(|why| self.unmade(from, to, &why))?;
        let processor = Arc::new(Processor::new(engine, &self.name, (from, to)));
        made.insert(key, Arc::clone(&processor));
        Ok(processor)
    }

    /// What turns colours of the space called `from` into what `display` is to be sent for `view`.
    ///
    /// # Errors
    /// Those of [`Config::processor`], and no such display or view.
    pub fn display_processor(&self, from: &str, display: &str, view: &str) -> Result<Processor> {
        let from = self.space(from)?.name;
        let displays = self.displays();
        let known = displays
            .iter()
            .any(|d| d.name == display && d.views.iter().any(|v| v == view));
        let to = format!("{display}/{view}");
        if !known {
            let all = displays.iter().flat_map(|d| {
                let views = d.views.iter();
                views.map(|view| format!("{}/{view}", d.name))
            });
            return Err(ColourError::new(
                &self.name,
                format!("view `{to}`"),
                "there is none of this name",
                format!("there are {}", all.collect::<Vec<_>>().join(", ")),
            ));
        }
        let engine = self.engine.display_processor(&from, display, view);
        let engine = engine.map_err(|why| self.unmade(&from, &to, &why))?;
        Ok(Processor::new(engine, &self.name, (&from, &to)))
    }

    fn unmade(&self, from: &str, to: &str, why: &str) -> ColourError {
        ColourError::new(
            &self.name,
            format!("`{from}` to `{to}`"),
            format!("cannot be made ({})", why.trim_end()),
            "check the transforms of these spaces, and that the files they name are there",
        )
    }
}
