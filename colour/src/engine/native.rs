//! OpenColorIO's own C++ library: the crate `ocio-rs`, built with the library's source.
//!
//! Its configs may not leave the thread that made them: each has one, which is asked. Its processors may, but serve one
//! thread at a time: they are lent.

use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use ocio_rs::{
    CPUProcessor, ColorSpace, Config, LoggingLevel, OptimizationFlags, TransformDirection,
};

use super::{
    ColourEngine, Display, EngineConfig, EngineProcessor, EngineResult, FileSpace, Pixel, Space,
};
use crate::{ColourError, OWN_CONFIG, Result, Source};

/// The library that we know how to use; the crate alone, without it, would change no colour and say nothing.
const VERSION: &str = "2.";

/// No quick logarithms and powers: see the other engine.
const EXACT: u64 = OptimizationFlags::LOSSLESS.0 as u64;

/// The engine.
pub(super) struct Native {
    version: String,
}

impl Native {
    /// # Errors
    /// A build in which there is no library behind the crate.
    pub(super) fn new() -> Result<Self> {
        let version = ocio_rs::version().unwrap_or_default();
        if !version.starts_with(VERSION) {
            return Err(ColourError::new(
                "OpenColorIO",
                "version",
                format!("is `{version}`, so there is no library that changes colour"),
                "build with the feature `bundled` of ocio-rs",
            ));
        }
        let _ = ocio_rs::try_set_logging_level(LoggingLevel::None);
        Ok(Self { version })
    }
}

impl ColourEngine for Native {
    fn name(&self) -> String {
        format!("OpenColorIO {}", self.version)
    }

    fn load(&self, source: &Source) -> EngineResult<Box<dyn EngineConfig>> {
        Ok(Box::new(NativeConfig::open(source.clone())?))
    }
}

/// What a config's thread is asked to do with it.
type Question = Box<dyn FnOnce(&Config) + Send>;

/// A config, by the thread that has it. Both end with this: no code may run in a library that hosts unload.
struct NativeConfig {
    /// Nothing once it ends.
    questions: Mutex<Option<Sender<Question>>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for NativeConfig {
    fn drop(&mut self) {
        let questions = self.questions.get_mut();
        questions.unwrap_or_else(PoisonError::into_inner).take();
        if let Some(thread) = self.thread.take() {
            // How it ended tells nothing that answers have not told.
            let _ = thread.join();
        }
    }
}

fn space_of(space: &ColorSpace) -> Space {
    Space {
        name: space.name().unwrap_or_default(),
        aliases: (0..space.num_aliases())
            .filter_map(|i| space.alias(i))
            .collect(),
        family: space.family().unwrap_or_default(),
        encoding: space.encoding().unwrap_or_default(),
        description: space.description().unwrap_or_default(),
        is_data: space.is_data(),
    }
}

fn opened(source: &Source) -> EngineResult<Config> {
    let config = match source {
        Source::Own => Config::from_stream(OWN_CONFIG),
        Source::Text { yaml, .. } => Config::from_stream(yaml),
        Source::BuiltIn(name) => Config::create_from_builtin_config(name),
        Source::File(path) => Config::from_file(path.to_string_lossy()),
    };
    config.map_err(|e| e.to_string())
}

impl NativeConfig {
    fn open(source: Source) -> EngineResult<Self> {
        let (questions, asked) = channel::<Question>();
        let (outcome, opening) = channel();
        let has_it = move || match opened(&source) {
            Ok(config) => {
                let _ = outcome.send(Ok(()));
                for question in asked {
                    question(&config);
                }
            }
            Err(why) => {
                let _ = outcome.send(Err(why));
            }
        };
        let thread = thread::Builder::new().spawn(has_it);
        let config = Self {
            questions: Mutex::new(Some(questions)),
            thread: Some(thread.map_err(|e| e.to_string())?),
        };
        let opened = opening.recv().map_err(|e| e.to_string())?;
        opened.map(|()| config)
    }

    /// The answer to `question`; none if the config's thread has died.
    fn ask<T: Send + 'static>(
        &self,
        question: impl FnOnce(&Config) -> T + Send + 'static,
    ) -> Option<T> {
        let (answer, answered) = channel();
        let question: Question = Box::new(move |config| {
            let _ = answer.send(question(config));
        });
        let questions = self.questions.lock();
        let questions = questions.unwrap_or_else(PoisonError::into_inner);
        questions.as_ref()?.send(question).ok()?;
        drop(questions);
        answered.recv().ok()
    }

    fn made(
        &self,
        make: impl FnOnce(&Config) -> ocio_rs::Result<ocio_rs::Processor> + Send + 'static,
    ) -> EngineResult<Box<dyn EngineProcessor>> {
        let made = self.ask(|config| make(config).map_err(|e| e.to_string()));
        let made = made.unwrap_or_else(|| Err("the library has died".to_owned()));
        Lent::boxed(made?)
    }
}

impl EngineConfig for NativeConfig {
    fn spaces(&self) -> Vec<Space> {
        let spaces = self.ask(|config| {
            (0..config.num_color_spaces())
                .filter_map(|i| config.color_space(config.color_space_name_by_index(i)?))
                .map(|space| space_of(&space))
                .collect()
        });
        spaces.unwrap_or_default()
    }

    fn roles(&self) -> Vec<(String, String)> {
        let roles = self.ask(|config| {
            let roles = (0..config.num_roles()).filter_map(|i| {
                let name = config.role_name(i)?;
                let space = config.role_color_space(&name)?;
                Some((name, space))
            });
            roles.collect()
        });
        roles.unwrap_or_default()
    }

    fn displays(&self) -> Vec<Display> {
        let displays = self.ask(|config| {
            let displays = (0..config.num_displays()).filter_map(|i| {
                let name = config.display(i)?;
                let views = (0..config.num_views(&name)).filter_map(|v| config.view(&name, v));
                Some(Display {
                    views: views.collect(),
                    name,
                })
            });
            displays.collect()
        });
        displays.unwrap_or_default()
    }

    fn space(&self, name: &str) -> Option<Space> {
        let name = name.to_owned();
        let space = self.ask(|config| config.color_space(name).map(|space| space_of(&space)));
        space.flatten()
    }

    fn file_space(&self, path: &Path) -> Option<FileSpace> {
        let path = path.to_string_lossy().into_owned();
        let found = self.ask(|config| {
            let (space, rule) = config.color_space_from_filepath_with_rule_index(path)?;
            let rules = config.file_rules().ok()?.num_entries();
            let is_default = u64::try_from(rule).is_ok_and(|rule| rule + 1 == rules);
            Some(FileSpace { space, is_default })
        });
        found.flatten().filter(|found| !found.space.is_empty())
    }

    fn processor(&self, from: &str, to: &str) -> EngineResult<Box<dyn EngineProcessor>> {
        let (from, to) = (from.to_owned(), to.to_owned());
        self.made(|config| config.processor(from, to))
    }

    fn display_processor(
        &self,
        from: &str,
        display: &str,
        view: &str,
    ) -> EngineResult<Box<dyn EngineProcessor>> {
        let [from, display, view] = [from, display, view].map(str::to_owned);
        let direction = TransformDirection::Forward;
        self.made(move |config| config.processor_display(from, display, view, direction))
    }
}

/// A processor for each thread that needs one at the same time.
struct Lent {
    made_of: Mutex<ocio_rs::Processor>,
    idle: Mutex<Vec<CPUProcessor>>,
    is_no_op: bool,
}

impl Lent {
    fn boxed(processor: ocio_rs::Processor) -> EngineResult<Box<dyn EngineProcessor>> {
        let first = processor.optimized_cpu_processor(EXACT);
        let first = first.map_err(|e| e.to_string())?;
        Ok(Box::new(Self {
            is_no_op: first.is_no_op(),
            made_of: Mutex::new(processor),
            idle: Mutex::new(vec![first]),
        }))
    }

    fn one(&self) -> Option<CPUProcessor> {
        let idle = self
            .idle
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        idle.or_else(|| {
            let made_of = self.made_of.lock().unwrap_or_else(PoisonError::into_inner);
            made_of.optimized_cpu_processor(EXACT).ok()
        })
    }
}

impl EngineProcessor for Lent {
    fn is_no_op(&self) -> bool {
        self.is_no_op
    }

    fn apply(&self, pixels: &mut [Pixel]) {
        let count = pixels.len() as i64;
        let samples = pixels.as_flattened_mut();
        let done = self.one().is_some_and(|processor| {
            let done = processor.try_apply_rgba_pixels(samples, count, 4).is_ok();
            self.idle
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(processor);
            done
        });
        if !done {
            // Counted by who called as samples without a value.
            samples.fill(f32::NAN);
        }
    }
}
