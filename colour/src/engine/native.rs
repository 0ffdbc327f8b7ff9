//! The engine on OpenColorIO's own C++ library: the crate `ocio-rs`, built with the library's source.
//!
//! The crate's configs are not `Send`, so each lives on a thread of its own that runs the calls on it. Its processors
//! are `Send` but not `Sync`, so a pool lends one to each thread.

use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use ocio_rs::{
    CPUProcessor, ColorSpace, Config, LoggingLevel, OptimizationFlags, TransformDirection,
};

use super::{
    ColourEngine, Display, EngineConfig, EngineProcessor, EngineResult, FileSpace, Pixel, Space,
};
use crate::{ColourError, EMBEDDED_CONFIG, Result, Source};

/// Prefix of supported library versions. Without the library the crate is a stub that silently converts nothing.
const VERSION_PREFIX: &str = "2.";

/// Disables fast logarithms and powers, which are accurate to about 1e-5 only.
const EXACT: u64 = OptimizationFlags::LOSSLESS.0 as u64;

/// The C++ library.
pub(super) struct Native {
    version: String,
}

impl Native {
    /// Creates the engine.
    ///
    /// # Errors
    /// If the crate was built without a supported library.
    pub(super) fn new() -> Result<Self> {
        let version = ocio_rs::version().unwrap_or_default();
        if !version.starts_with(VERSION_PREFIX) {
            return Err(ColourError::new(
                "OpenColorIO",
                "version",
                format!("`{version}` is not supported"),
                "build Seidel with the feature `bundled` of ocio-rs",
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

/// A call that the thread of a config runs on it.
type Job = Box<dyn FnOnce(&Config) + Send>;

/// A handle to a config on its own thread. Dropping it joins the thread, because hosts unload the library that contains
/// this code.
struct NativeConfig {
    /// Jobs for the thread, which ends when this becomes `None`.
    jobs: Mutex<Option<Sender<Job>>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for NativeConfig {
    fn drop(&mut self) {
        let jobs = self.jobs.get_mut();
        jobs.unwrap_or_else(PoisonError::into_inner).take();
        if let Some(thread) = self.thread.take() {
            // A panic there has already failed the call that caused it.
            let _ = thread.join();
        }
    }
}

fn convert_space(space: &ColorSpace) -> Space {
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

fn load(source: &Source) -> EngineResult<Config> {
    let config = match source {
        Source::Embedded => Config::from_stream(EMBEDDED_CONFIG),
        Source::Text { yaml, .. } => Config::from_stream(yaml),
        Source::BuiltIn(name) => Config::create_from_builtin_config(name),
        Source::File(path) => Config::from_file(path.to_string_lossy()),
    };
    config.map_err(|e| e.to_string())
}

impl NativeConfig {
    fn open(source: Source) -> EngineResult<Self> {
        let (jobs, received) = channel::<Job>();
        let (outcome, loaded) = channel();
        let run = move || match load(&source) {
            Ok(config) => {
                let _ = outcome.send(Ok(()));
                for job in received {
                    job(&config);
                }
            }
            Err(why) => {
                let _ = outcome.send(Err(why));
            }
        };
        let thread = thread::Builder::new().spawn(run);
        let config = Self {
            jobs: Mutex::new(Some(jobs)),
            thread: Some(thread.map_err(|e| e.to_string())?),
        };
        let loaded = loaded.recv().map_err(|e| e.to_string())?;
        loaded.map(|()| config)
    }

    /// Runs `job` on the config's thread and returns its result, or nothing if that thread has died.
    fn call<T: Send + 'static>(
        &self,
        job: impl FnOnce(&Config) -> T + Send + 'static,
    ) -> Option<T> {
        let (sender, receiver) = channel();
        let job: Job = Box::new(move |config| {
            let _ = sender.send(job(config));
        });
        let jobs = lock(&self.jobs);
        jobs.as_ref()?.send(job).ok()?;
        drop(jobs);
        receiver.recv().ok()
    }

    fn create_processor(
        &self,
        create: impl FnOnce(&Config) -> ocio_rs::Result<ocio_rs::Processor> + Send + 'static,
    ) -> EngineResult<Box<dyn EngineProcessor>> {
        let processor = self.call(|config| create(config).map_err(|e| e.to_string()));
        let processor = processor.unwrap_or_else(|| Err("OpenColorIO crashed".to_owned()));
        Ok(Box::new(ProcessorPool::new(processor?)?))
    }
}

impl EngineConfig for NativeConfig {
    fn spaces(&self) -> Vec<Space> {
        let spaces = self.call(|config| {
            (0..config.num_color_spaces())
                .filter_map(|i| config.color_space(config.color_space_name_by_index(i)?))
                .map(|space| convert_space(&space))
                .collect()
        });
        spaces.unwrap_or_default()
    }

    fn roles(&self) -> Vec<(String, String)> {
        let roles = self.call(|config| {
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
        let displays = self.call(|config| {
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
        let space = self.call(|config| config.color_space(name).map(|space| convert_space(&space)));
        space.flatten()
    }

    fn file_space(&self, path: &Path) -> Option<FileSpace> {
        let path = path.to_string_lossy().into_owned();
        let found = self.call(|config| {
            let (space, rule) = config.color_space_from_filepath_with_rule_index(path)?;
            let rules = config.file_rules().ok()?.num_entries();
            let is_default = u64::try_from(rule).is_ok_and(|rule| rule + 1 == rules);
            Some(FileSpace { space, is_default })
        });
        found.flatten().filter(|found| !found.space.is_empty())
    }

    fn processor(&self, from: &str, to: &str) -> EngineResult<Box<dyn EngineProcessor>> {
        let (from, to) = (from.to_owned(), to.to_owned());
        self.create_processor(|config| config.processor(from, to))
    }

    fn display_processor(
        &self,
        from: &str,
        display: &str,
        view: &str,
    ) -> EngineResult<Box<dyn EngineProcessor>> {
        let [from, display, view] = [from, display, view].map(str::to_owned);
        let direction = TransformDirection::Forward;
        self.create_processor(move |config| {
            config.processor_display(from, display, view, direction)
        })
    }
}

/// A transform with one CPU processor for each thread that uses it at the same time.
struct ProcessorPool {
    processor: Mutex<ocio_rs::Processor>,
    idle: Mutex<Vec<CPUProcessor>>,
    is_no_op: bool,
}

impl ProcessorPool {
    fn new(processor: ocio_rs::Processor) -> EngineResult<Self> {
        let first = processor.optimized_cpu_processor(EXACT);
        let first = first.map_err(|e| e.to_string())?;
        Ok(Self {
            is_no_op: first.is_no_op(),
            processor: Mutex::new(processor),
            idle: Mutex::new(vec![first]),
        })
    }

    fn take(&self) -> Option<CPUProcessor> {
        let idle = lock(&self.idle).pop();
        idle.or_else(|| lock(&self.processor).optimized_cpu_processor(EXACT).ok())
    }
}

impl EngineProcessor for ProcessorPool {
    fn is_no_op(&self) -> bool {
        self.is_no_op
    }

    fn apply(&self, pixels: &mut [Pixel]) {
        let count = pixels.len() as i64;
        let samples = pixels.as_flattened_mut();
        let done = self.take().is_some_and(|processor| {
            let done = processor.try_apply_rgba_pixels(samples, count, 4).is_ok();
            lock(&self.idle).push(processor);
            done
        });
        if !done {
            // The caller counts these as samples that could not be converted.
            samples.fill(f32::NAN);
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
